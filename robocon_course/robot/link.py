"""A datagram of the link between autonomy and hardware, and which of those that come are new.

``docs/link.md`` describes the link for whoever builds the other end of it.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

from robocon_course._arrays import CourseError
from robocon_course.robot.text import Tree, field, from_text, to_text

VERSION = 1
"""Of the datagrams; both ends must speak the same."""
LIMIT = 60_000
"""No datagram is larger [bytes]."""
WINDOW = 256
"""So far back a datagram that came late is told from one that came twice."""
KINDS = ("hello", "command", "observation", "frame")
"""The first two go to the robot, the others come from it."""


class LinkError(CourseError):
    """A link that cannot be opened."""


@dataclass
class LinkCounts:
    """What happened on a link so far, seen from one end.

    Attributes
    ----------
    received : int
        Datagrams that were new and good.
    lost : int
        Datagrams that never came, told by the gaps in the sequence.
    late : int
        Datagrams that came after a newer one had been used; they are not.
    doubled : int
        Datagrams that came twice.
    malformed : int
        Datagrams that are none of this link, or hold what cannot be.
    other_version : int
        Datagrams of another version of the link.
    foreign : int
        Datagrams of somebody else while the robot obeys one.
    unsent : int
        What could not be sent: the network refuses, or it does not fit a datagram.
    """

    received: int = 0
    lost: int = 0
    late: int = 0
    doubled: int = 0
    malformed: int = 0
    other_version: int = 0
    foreign: int = 0
    unsent: int = 0


class Datagram(NamedTuple):
    """One message on the link.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    session : int
        Drawn when a program starts: another one means that the other end began anew.
    sequence : int
        Counts the sender's datagrams of this kind.
    body : dict
    """

    kind: str
    session: int
    sequence: int
    body: Tree


class OtherVersion(ValueError):
    """A datagram of a version that this end does not speak."""


def pack(datagram: Datagram) -> bytes:
    """The bytes of a datagram.

    Parameters
    ----------
    datagram : Datagram

    Returns
    -------
    bytes

    Raises
    ------
    ValueError
        It would be larger than `LIMIT`.

    Examples
    --------
    >>> pack(Datagram("hello", 7, 0, {}))
    b'{"robocon":1,"kind":"hello","session":7,"sequence":0,"body":{}}'
    """
    data = to_text({"robocon": VERSION, **datagram._asdict()})
    if len(data) > LIMIT:
        raise ValueError(f"datagram: {len(data)} bytes do not fit into {LIMIT}")
    return data


def unpack(data: bytes) -> Datagram:
    """The datagram that some bytes hold.

    Parameters
    ----------
    data : bytes

    Returns
    -------
    Datagram

    Raises
    ------
    OtherVersion
        One of another version of the link.
    ValueError
        No datagram of this link.
    """
    if len(data) > LIMIT:
        raise ValueError(f"datagram: {len(data)} bytes are more than {LIMIT}")
    tree = from_text(data)
    version = field(tree, "robocon", int)
    if version != VERSION:
        raise OtherVersion(f"robocon: this end speaks version {VERSION}, got {version}")
    kind = field(tree, "kind", str)
    if kind not in KINDS:
        raise ValueError(f"kind: expected one of {', '.join(KINDS)}, got {kind!r:.40}")
    counts = field(tree, "session", int), field(tree, "sequence", int)
    if not all(0 <= count < 2**53 for count in counts):
        raise ValueError("session, sequence: expected whole numbers from 0 to 2^53")
    return Datagram(kind, *counts, field(tree, "body", dict))


class Arrivals:
    """Tells which datagrams of one kind are new, and counts the others.

    Parameters
    ----------
    counts : LinkCounts
        Is added to.

    Examples
    --------
    >>> counts = LinkCounts()
    >>> arrivals = Arrivals(counts)
    >>> [arrivals.take(session=7, sequence=k) for k in (0, 1, 4, 2, 4)]
    [True, True, True, False, False]
    >>> counts.received, counts.lost, counts.late, counts.doubled
    (3, 1, 1, 1)
    """

    def __init__(self, counts: LinkCounts) -> None:
        self._counts = counts
        self._session: int | None = None
        self._over: deque[int] = deque(maxlen=16)  # sessions that ended
        self._first = self._newest = 0
        self._seen: deque[int] = deque(maxlen=WINDOW)

    def take(self, session: int, sequence: int) -> bool:
        """Whether a datagram is newer than all before it.

        Parameters
        ----------
        session : int
        sequence : int
        """
        if session in self._over:
            self._counts.late += 1
            return False
        if session != self._session:
            self._begin(session, sequence)
        if sequence > self._newest:
            self._counts.lost += sequence - self._newest - 1
            self._counts.received += 1
            self._newest = sequence
            self._seen.append(sequence)
            return True
        if sequence in self._seen:
            self._counts.doubled += 1
            return False
        self._counts.late += 1
        if sequence > self._newest - WINDOW:
            self._seen.append(sequence)
            self._counts.lost -= sequence > self._first
        return False

    def _begin(self, session: int, sequence: int) -> None:
        """The other end began anew: whatever comes first is the first."""
        if self._session is not None:
            self._over.append(self._session)
        self._session = session
        self._first = self._newest = sequence - 1
        self._seen.clear()
