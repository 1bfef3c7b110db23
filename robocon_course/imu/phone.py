r"""A phone as IMU: samples that arrive as UDP datagrams.

Any app or script that sends text will do. A datagram holds one or more lines, each one sample, in
either of two forms that may be mixed; time in s, rates in rad/s, accelerations in m/s²:

    CSV     t,gx,gy,gz,ax,ay,az
            0.01,0.001,-0.002,0.0,0.03,0.1,9.79
    JSON    {"t": 0.01, "gyro": [0.001, -0.002, 0.0], "accel": [0.03, 0.1, 9.79]}

``nan`` (in JSON also ``null``) says that a sensor gave nothing. Lines that are neither are counted
and skipped. UDP loses, doubles and swaps datagrams: take the step from ``t``, not from the clock.

To try it without a phone (Python, in a second window):

    socket.socket(type=socket.SOCK_DGRAM).sendto(b"0.01,0,0,0,0,0,9.81\n", ("127.0.0.1", 5555))
"""

from __future__ import annotations

import json
import selectors
import socket
import threading
from collections import deque
from contextlib import suppress
from math import isfinite, nan
from types import TracebackType
from typing import NamedTuple

import numpy as np

from robocon_course._arrays import FloatArray

_LARGEST_DATAGRAM = 65535


class Sample(NamedTuple):
    """One reading of the phone.

    Attributes
    ----------
    time : float  [s]
        The phone's own clock.
    gyro : ndarray, shape (3,)  [rad/s, body]
    accel : ndarray, shape (3,)  [m/s^2, body]
    """

    time: float
    gyro: FloatArray
    accel: FloatArray


def listen(port: int, host: str = "0.0.0.0", *, timeout: float | None = None) -> Listener:
    """Samples as they arrive at a UDP port.

    Parameters
    ----------
    port : int
        0 takes any free one; `Listener.port` tells which.
    host : str
        Address to listen on; "0.0.0.0" is every network of this computer, "127.0.0.1" only itself.
    timeout : float, optional  [s]
        Stop when nothing has come for so long; None waits for ever.

    Returns
    -------
    Listener
        To iterate over, best in a ``with`` block.

    Raises
    ------
    ValueError
        No such port number, or a timeout that is not positive.
    OSError
        The port is taken by another program, or the host is not this computer.

    Examples
    --------
    >>> with listen(0, "127.0.0.1", timeout=0.01) as phone:
    ...     samples = list(phone)
    >>> samples, phone.received, phone.malformed
    ([], 0, 0)
    """
    if not 0 <= port <= 65535:
        raise ValueError(f"port: must lie between 0 and 65535, got {port!r}")
    if timeout is not None and not timeout > 0.0:
        raise ValueError(f"timeout: must be a positive number of seconds, got {timeout!r}")
    return Listener(port, host, timeout)


class Listener:
    """Iterator over the samples that arrive at a port; made by `listen`.

    Attributes
    ----------
    port : int
        Where it listens.
    received : int
        Samples taken in.
    malformed : int
        Lines skipped because they were no sample.
    """

    def __init__(self, port: int, host: str, timeout: float | None) -> None:
        self.received = 0
        self.malformed = 0
        self._timeout = timeout
        self._waiting: deque[Sample] = deque()
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((host, port))
        except OSError:
            self._socket.close()
            raise
        self.port: int = self._socket.getsockname()[1]
        self._socket.setblocking(False)
        # Closing a socket does not wake who waits for it; a byte through this pair does.
        self._bell, self._rope = socket.socketpair()
        self._closed = False
        self._reading = threading.Lock()
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ)
        self._selector.register(self._bell, selectors.EVENT_READ)

    def __enter__(self) -> Listener:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __iter__(self) -> Listener:
        return self

    def __next__(self) -> Sample:
        while not self._waiting and not self._closed:
            self._receive()
        if self._closed:
            raise StopIteration
        return self._waiting.popleft()

    def close(self) -> None:
        """Stop listening; a loop that waits in another thread ends at once. May be called twice."""
        self._closed = True
        with suppress(OSError):  # the rope is gone when it was closed before
            self._rope.send(b"!")
        with self._reading:
            self._selector.close()
            for end in (self._socket, self._bell, self._rope):
                end.close()

    def _receive(self) -> None:
        """Wait for one datagram and take its samples in; silence or the bell close the listener."""
        with self._reading:
            if self._closed:
                return
            heard = [key.fileobj for key, _ in self._selector.select(self._timeout)]
            datagram = b""
            if self._socket in heard:
                with suppress(OSError):  # a datagram that was announced may still be found damaged
                    datagram = self._socket.recv(_LARGEST_DATAGRAM)
        if not heard:
            self.close()
        self._take(datagram.decode("utf-8", errors="replace"))

    def _take(self, text: str) -> None:
        for line in text.split("\n"):
            if not (line := line.strip(" \t\r\0")):
                continue
            try:
                self._waiting.append(_parse(line))
                self.received += 1
            except (ValueError, TypeError, KeyError, OverflowError, RecursionError):
                self.malformed += 1


def _parse(line: str) -> Sample:
    """One line as a sample; raises one of the errors that `Listener._take` counts."""
    if line.startswith("{"):
        fields = json.loads(line)
        time, gyro, accel = fields["t"], fields["gyro"], fields["accel"]
        if not (isinstance(gyro, list) and isinstance(accel, list)):
            raise ValueError("gyro and accel must be lists")
        gyro, accel = ([nan if v is None else float(v) for v in three] for three in (gyro, accel))
    else:
        time, *six = (float(cell) for cell in line.split(","))
        gyro, accel = six[:3], six[3:]
    if not (isfinite(time := float(time)) and len(gyro) == len(accel) == 3):
        raise ValueError("no sample")
    return Sample(time, np.array(gyro), np.array(accel))
