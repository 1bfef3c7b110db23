"""A log read back: the messages as they were told, and what is in a file.

A file that was cut off, because the program or the robot died, is read as far as it goes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from robocon_course.logs.kinds import KINDS, NAMES
from robocon_course.logs.writer import PROFILE, LogError
from robocon_course.robot.text import Tree, from_text

SEVERAL = {kind.__name__ for kind, how in KINDS.items() if how.several}
"""Types, by name, of which a message takes several pieces."""


class LogFile:
    """The messages of a log in the order in which they were told; made by `read_log`.

    Going through it again reads the file again.

    Attributes
    ----------
    path : Path
    count : int
        Messages read so far.
    skipped : int
        Messages among them that no one here can read, and that were passed over.
    trouble : str
        Empty; once the end is reached, a sentence if the file is cut off or damaged.
    """

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = Path(path)
        self.count = self.skipped = 0
        self.trouble = ""
        self._check_head()

    def _check_head(self) -> None:
        """Refuse what is no match log."""
        head = next(
            (record for record in self._records() if type(record).__name__ == "Header"), None
        )
        if head is None:
            raise LogError(f"{self.path} is no MCAP file, or ends within its first bytes")
        if head.profile == PROFILE:
            return
        if head.profile.startswith("robocon-"):
            raise LogError(f"{self.path} was written by a newer course; install that one")
        who = head.library or head.profile or "an unknown program"
        raise LogError(f"{self.path} is no match log of this course: it was written by {who}")

    def _records(self) -> Iterator[Any]:
        """The file's records, as far as they can be read."""
        try:
            from mcap.stream_reader import StreamReader
        except ImportError:
            raise LogError(
                'a match log needs the library mcap: pip install "robocon-course[logs]"'
            ) from None
        try:
            stream = self.path.open("rb")
        except OSError as error:
            raise LogError(f"{self.path} cannot be read: {error.strerror}") from None
        with stream:
            size = self.path.stat().st_size
            reader = StreamReader(stream, validate_crcs=True, record_size_limit=size)
            try:
                yield from reader.records
            except Exception:  # whatever damage makes the library raise
                self.trouble = f"{self.path.name} is cut off or damaged"

    def pieces(self) -> Iterator[tuple[dict[str, str], Any]]:
        """What the messages are made of: a channel's notes, and the file's own message."""
        from mcap.records import Channel, Message

        self.trouble = ""
        notes: dict[int, dict[str, str]] = {}
        for record in self._records():
            if isinstance(record, Channel):
                notes[record.id] = record.metadata
            elif isinstance(record, Message) and "message" in notes.get(record.channel_id, {}):
                yield notes[record.channel_id], record

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        self.count = self.skipped = 0
        before, group = None, []
        for about, record in self.pieces():
            told = about["topic"], about["message"], record.sequence
            if told != before and group:
                yield from self._message(before, group)
                group = []
            before = told
            group.append(record.data)
        if group and not (self.trouble and before[1] in SEVERAL):
            yield from self._message(before, group)
        if self.trouble:
            self.trouble += f"; {self.count} messages could be read"

    def _message(self, told: tuple, texts: list[bytes]) -> Iterator[tuple[str, Any]]:
        """Topic and message of some pieces; nothing if they make none."""
        topic, name, _ = told
        self.count += 1
        try:
            trees: list[Tree] = [from_text(text) for text in texts]
            message = KINDS[NAMES[name]].read(trees)
        except (ValueError, TypeError, KeyError, IndexError, OverflowError):
            self.skipped += 1
            return
        yield topic, message


def read_log(path: str | PathLike[str]) -> LogFile:
    """The messages of a match log.

    Parameters
    ----------
    path : path
        A log, or the ``.part`` of one that was not finished.

    Returns
    -------
    LogFile
        Gives (topic, message). Observations and commands equal to the bit those that were told;
        the other kinds as close as Foxglove's schemas allow, see `drawn`.

    Raises
    ------
    LogError
        No such file, no MCAP file, or one of another program.
    """
    return LogFile(path)


class Summary(NamedTuple):
    """What is in a log.

    Attributes
    ----------
    topics : dict
        Messages by topic, sorted by name.
    duration : float  [s]
        From the first to the last.
    size : int  [bytes]
    trouble : str
        Empty, or what is wrong with the file.
    """

    topics: dict[str, int]
    duration: float
    size: int
    trouble: str


def summary(path: str | PathLike[str]) -> Summary:
    """Topics, numbers of messages and duration of a log, without reading the messages.

    Parameters
    ----------
    path : path

    Returns
    -------
    Summary

    Raises
    ------
    LogError
        As `read_log`.
    """
    log = LogFile(path)
    topics: Counter[str] = Counter()
    first, last, before = None, 0, None
    for about, record in log.pieces():
        told = about["topic"], record.sequence
        topics[about["topic"]] += told != before
        before = told
        first = record.log_time if first is None else min(first, record.log_time)
        last = max(last, record.log_time)
    duration = 0.0 if first is None else (last - first) / 1e9
    return Summary(dict(sorted(topics.items())), duration, log.path.stat().st_size, log.trouble)
