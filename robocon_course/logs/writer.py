"""A match written down while it is played: one MCAP file, which Foxglove and Lichtblick open."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from threading import Lock
from typing import Any, Self

import robocon_course
from robocon_course._arrays import CourseError
from robocon_course.logs.drawn import Piece, nanoseconds
from robocon_course.logs.kinds import KINDS
from robocon_course.robot import Bus
from robocon_course.robot.text import to_text

PROFILE = "robocon-1"
"""The mark of a match log in the file's head, with the number of its form."""
CHUNK = 256 * 1024
"""So much is collected, then compressed and written [bytes]: two to three seconds of a match."""
NEW_CLOCK = 1_000_000_000
"""A time that lies farther back is on a clock that began anew [ns]."""


class LogError(CourseError):
    """A log that cannot be written or read."""


class MatchLog:
    """Writes what is told on a bus to a file.

    The file grows as ``<path>.part`` and gets its name when the log is closed: a file under the
    final name is whole. What was written before a kill can be read from the part.

    Parameters
    ----------
    path : path
        Name of the file, by custom with the ending ``.mcap``. A file of that name is replaced.

    Attributes
    ----------
    kept, thinned : Counter
        Messages by topic: written, and passed over because they came too often.
    left_out : Counter
        Messages by topic that cannot be written: of an unknown kind, or with a NaN where
        Foxglove's schema wants a number. The log goes on without them.

    Raises
    ------
    LogError
        The library ``mcap`` is missing, or the file cannot be made.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> from robocon_course.robot import messages
    >>> with TemporaryDirectory() as folder:
    ...     bus = Bus()
    ...     with MatchLog(Path(folder) / "match.mcap") as log:
    ...         log.listen(bus)
    ...         bus.publish("/rosout", messages.Log(0.0, "info", "ready"))
    ...     os.listdir(folder), dict(log.kept)
    (['match.mcap'], {'/rosout': 1})
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)
        self.part = self.path.with_name(self.path.name + ".part")
        self.kept: Counter[str] = Counter()
        self.thinned: Counter[str] = Counter()
        self.left_out: Counter[str] = Counter()
        self._subscriptions: list[Callable[[], None]] = []
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}
        self._last: dict[str, int] = {}
        self._clock = 0
        self._broken: OSError | None = None
        self._lock = Lock()  # the operator's screen tells from a thread of its own
        self._open()

    def _open(self) -> None:
        try:
            from mcap.writer import CompressionType, Writer
        except ImportError:
            raise LogError(
                'a match log needs the library mcap: pip install "robocon-course[logs]"'
            ) from None
        try:
            self.part.parent.mkdir(parents=True, exist_ok=True)
            self._file = self.part.open("wb")
            self._writer = Writer(self._file, CHUNK, compression=CompressionType.ZSTD)
            self._writer.start(PROFILE, f"robocon-course {robocon_course.__version__}")
            self._file.flush()
        except OSError as error:
            raise LogError(f"{self.part} cannot be written: {error.strerror}") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def listen(self, bus: Bus) -> None:
        """Write down everything that is told on a bus from now on.

        Parameters
        ----------
        bus : Bus
            Once the disk is full it drops the log, and says so in ``bus.failed``.
        """
        self._subscriptions.append(bus.subscribe("*", self._hear))

    def _hear(self, topic: str, message: Any) -> None:
        try:
            self.write(topic, message)
        except (ValueError, TypeError, AttributeError, OverflowError):
            self.left_out[topic] += 1  # one bad message does not end the log

    def write(self, topic: str, message: Any) -> None:
        """Write one message down.

        Parameters
        ----------
        topic : str
        message : one of `messages`, Observation or Command

        Raises
        ------
        ValueError
            A message of an unknown kind, or one that its form cannot hold.
        LogError
            The log is closed.
        """
        if self._file.closed:
            raise LogError(f"{self.path} is closed; open a new log")
        kind = KINDS.get(type(message))
        if kind is None:
            raise ValueError(f"{topic}: a log does not know {type(message).__name__}")
        with self._lock:
            now = self._now(message)
            if kind.rate and 0 <= now - self._last.get(topic, -(10**10)) < round(1e9 / kind.rate):
                self.thinned[topic] += 1
                return
            data = [(piece, to_text(piece.tree)) for piece in kind.write(topic, message)]
            try:
                for piece, text in data:
                    channel = self._channel(piece, topic, type(message).__name__)
                    self._writer.add_message(channel, now, text, now, self.kept[topic])
                self._file.flush()
            except OSError as error:  # a piece may be missing from now on
                self._broken = error
                raise
            self._last[topic] = now
            self.kept[topic] += 1

    def _now(self, message: Any) -> int:
        """A message's own time [ns]; of one without, the latest on the clock that runs now."""
        try:
            now = nanoseconds(message.time)
        except (AttributeError, ValueError):
            return self._clock
        # A picture is a little older than what was told before it; a new match begins at 0.
        self._clock = now if now < self._clock - NEW_CLOCK else max(self._clock, now)
        return now

    def _channel(self, piece: Piece, topic: str, name: str) -> int:
        """Number of the channel of a piece, made when it is first needed."""
        title = piece.schema["title"]
        key = piece.topic, title
        if key not in self._channels:
            if title not in self._schemas:
                text = json.dumps(piece.schema, indent=1).encode()
                self._schemas[title] = self._writer.register_schema(title, "jsonschema", text)
            about = {} if piece.derived else {"topic": topic, "message": name}
            self._channels[key] = self._writer.register_channel(
                piece.topic, "json", self._schemas[title], about
            )
        return self._channels[key]

    def close(self) -> None:
        """Finish the file and give it its name. Again: nothing more happens.

        Raises
        ------
        LogError
            The disk is or was full, or the name cannot be given; the part stays.
        """
        for stop in self._subscriptions:
            stop()
        self._subscriptions.clear()
        with self._lock:
            if self._file.closed:
                return
            try:
                with self._file:
                    if self._broken is not None:
                        raise self._broken
                    self._writer.finish()
                    self._file.flush()
                    os.fsync(self._file.fileno())
                os.replace(self.part, self.path)
            except OSError as error:
                raise LogError(
                    f"{self.path} was not finished: {error.strerror}; what there is stays in "
                    f"{self.part.name}"
                ) from None
