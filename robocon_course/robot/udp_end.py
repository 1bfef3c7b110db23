"""What both ends of the link do: send, count, and take in whatever comes."""

from __future__ import annotations

import select
import socket
from collections.abc import Iterator
from secrets import randbits
from time import monotonic
from typing import Self

from robocon_course.robot.link import Datagram, LinkCounts, OtherVersion, pack, unpack
from robocon_course.robot.text import Tree

Address = tuple[str, int]
AT_ONCE = 1000
"""Datagrams that are taken in one go, so that a flood does not hold the robot up."""
_BUFFER = 1 << 20


class End:
    """One end of a link; the attributes are those of `UdpRobot` and `RobotServer`."""

    def __init__(self) -> None:
        self.counts = LinkCounts()
        self._session = randbits(48)
        self._sequences: dict[str, int] = {}
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER)
        self._socket.setblocking(False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Give the port back."""
        self._socket.close()

    def _send(self, kind: str, body: Tree, to: Address) -> bool:
        sequence = self._sequences.get(kind, 0)
        self._sequences[kind] = sequence + 1
        try:
            self._socket.sendto(pack(Datagram(kind, self._session, sequence, body)), to)
        except (OSError, ValueError):
            self.counts.unsent += 1
            return False
        return True

    def _incoming(self) -> Iterator[tuple[Datagram, Address]]:
        """What lies there, with its sender; what is none of this link is counted."""
        for _ in range(AT_ONCE):
            try:
                data, sender = self._socket.recvfrom(65535)
            except BlockingIOError:
                return
            except OSError:  # the other end's port is closed: an error of what was sent before
                continue
            try:
                yield unpack(data), sender
            except OtherVersion:
                self.counts.other_version += 1
            except ValueError:
                self.counts.malformed += 1

    def _wait(self, until: float) -> None:
        """Until something comes, at most to a time."""
        rest = until - monotonic()
        if rest > 0.0:
            select.select([self._socket], [], [], rest)
