"""A robot that sees once more what it saw in a match."""

from __future__ import annotations

from os import PathLike
from typing import Any

from robocon_course.logs.reader import read_log
from robocon_course.logs.writer import LogError
from robocon_course.robot import Command, Observation
from robocon_course.robot.codec import encode_command
from robocon_course.robot.text import to_text


class Replay:
    """The robot of a log: ``read`` gives its observations one after the other.

    Nothing moves by what it is told; it compares that with what was told then. An autopilot that
    has not changed gives the same commands to the bit.

    Parameters
    ----------
    path : path
        A match log, whole or cut off.

    Attributes
    ----------
    ended : bool
        Whether the last observation was read.
    expected : Command or None
        What was told in the log after the observation that was read last.
    heard : list of (str, message)
        Topics and messages of everything else that was told between the observation that was read
        last and the one before it: the operator's buttons among them.
    applied, different : int
        Commands since the beginning, and those among them that are not the log's.
    first_different : float or None  [s]
        When the first of them was told.
    trouble : str
        As `LogFile.trouble`: of a log that was cut off.

    Raises
    ------
    LogError
        As `read_log`, or a log without observations.
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self._log = read_log(path)
        self._told = iter(self._log)
        self._next: Observation | None = None
        self._latest: Observation | None = None
        self.expected: Command | None = None
        self.heard: list[tuple[str, Any]] = []
        self._coming: list[tuple[str, Any]] = []
        self.applied = self.different = 0
        self.first_different: float | None = None
        self._advance()
        if self._next is None:
            raise LogError(f"{path} holds no observations to replay")

    @property
    def trouble(self) -> str:
        """Empty; at the end a sentence if the log is cut off or damaged."""
        return self._log.trouble

    @property
    def ended(self) -> bool:
        """Whether there is no further observation."""
        return self._next is None

    def _advance(self) -> None:
        """To the next observation, past what was told meanwhile."""
        self._next, self.expected, self._coming = None, None, []
        for topic, message in self._told:
            if topic == "/observation":
                self._next = message
                return
            if topic == "/command":
                self.expected = message
            else:
                self._coming.append((topic, message))

    def read(self) -> Observation:
        """The next observation; at the end the last one again, without samples and picture.

        Returns
        -------
        Observation
        """
        self.heard = self._coming
        if self._next is not None:
            self._latest = self._next
            self._advance()
            return self._latest
        last = self._latest
        assert last is not None, "there is one in the log"
        self.expected, self._coming = None, []
        return last._replace(
            imu_time=last.imu_time[:0], gyro=last.gyro[:0], accel=last.accel[:0], frame=None
        )

    def apply(self, command: Command) -> None:
        """Compare a command with the log's.

        Parameters
        ----------
        command : Command

        Raises
        ------
        ValueError
            Not four speeds and four angles.
        """
        given = to_text(encode_command(command))
        self.applied += 1
        if self.expected is None or given != to_text(encode_command(self.expected)):
            self.different += 1
            if self.first_different is None and self._latest is not None:
                self.first_different = self._latest.time
