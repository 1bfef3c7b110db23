"""A robot on the other end of a network: `UdpRobot` drives it, `RobotServer` is what it runs.

    robot's computer                     autopilot's computer
    serve(hardware, 5005, host=...)      robot = UdpRobot("192.168.1.20", 5005)

Both are a `Robot`: whatever drives the simulator drives the machine. There is no password on the
link: whoever is in the network can drive the robot, though only one at a time.
"""

from __future__ import annotations

import socket
from collections import deque
from math import isfinite
from time import monotonic

import numpy as np

from robocon_course.robot.camera_frames import decode_frame
from robocon_course.robot.codec import decode_observation, encode_command
from robocon_course.robot.hardware import Command, Frame, Observation
from robocon_course.robot.link import Arrivals, Datagram, LinkError
from robocon_course.robot.udp_end import AT_ONCE, End
from robocon_course.robot.udp_server import RobotServer, serve

__all__ = ["RobotServer", "UdpRobot", "serve"]

SILENCE = 0.2
"""Without an observation for so long, a link counts as broken [s]."""
HELLO = 0.1
"""Whoever does not command says hello this often [s]."""


class UdpRobot(End):
    """A robot that is driven over the network.

    Parameters
    ----------
    host : str
        Name or address of the robot's computer.
    port : int
    wait : float  [s]
        So long it may take until the first observation comes.

    Attributes
    ----------
    counts : LinkCounts
        Of the observations and pictures that came, or did not.

    Raises
    ------
    LinkError
        No such host, no robot that answers, or a wait that is none.
    """

    def __init__(self, host: str, port: int, *, wait: float = 3.0) -> None:
        if not isinstance(wait, int | float) or not wait >= 0.0:
            raise LinkError(f"wait: expected seconds, 0 or more, got {wait!r}")
        super().__init__()
        self._arrivals = Arrivals(self.counts), Arrivals(self.counts)
        self._pending: deque[Observation] = deque(maxlen=AT_ONCE)
        self._frame: Frame | None = None
        self._latest: Observation | None = None
        self._heard = self._said = -1e9
        try:
            if not 0 < port < 65536:
                raise OverflowError("a port is a number from 1 to 65535")
            self._robot = socket.getaddrinfo(host, port, socket.AF_INET, socket.SOCK_DGRAM)[0][4]
        except (OSError, UnicodeError, OverflowError, TypeError) as error:
            self.close()
            raise LinkError(f"host, port: {host!r}, {port!r} is no address ({error})") from None
        if not self.wait_for(wait):
            self.close()
            raise LinkError(self._nobody(host, port, wait))

    def _nobody(self, host: str, port: int, wait: float) -> str:
        if self.counts.other_version:
            return f"the robot at {host}:{port} speaks another version of the link; update it"
        return (
            f"no robot answered at {host}:{port} within {wait:g} s; is its program running, are "
            "both in one network, and does its firewall let UDP pass?"
        )

    @property
    def connected(self) -> bool:
        """Whether an observation came within the last 0.2 s."""
        self._take_in()
        return monotonic() - self._heard < SILENCE

    def wait_for(self, seconds: float) -> bool:
        """Wait until there is a new observation.

        Parameters
        ----------
        seconds : float  [s]
            At most.

        Returns
        -------
        bool
            Whether there is one.
        """
        end = monotonic() + seconds
        while True:
            self._greet()
            self._take_in()
            now = monotonic()
            if self._pending or now >= end:
                return bool(self._pending)
            self._wait(min(end, now + HELLO))

    def read(self) -> Observation:
        """The newest observation, without waiting; with the IMU samples since the last call.

        Never raises for what came or did not come. Without a new observation it is the last one
        again, without samples and picture: its time stands still. A pause of a second or more
        loses observations; the first call afterwards then gives an old one, the next the newest.

        Returns
        -------
        Observation
        """
        self._greet()
        self._take_in()
        seen, frame = list(self._pending), self._frame
        self._pending.clear()
        self._frame = None
        if seen:
            self._latest = seen[-1]
        assert self._latest is not None, "there is one since the link was opened"
        return self._latest._replace(
            imu_time=np.concatenate([np.empty(0), *(one.imu_time for one in seen)]),
            gyro=np.concatenate([np.empty((0, 3)), *(one.gyro for one in seen)]),
            accel=np.concatenate([np.empty((0, 3)), *(one.accel for one in seen)]),
            frame=frame,
        )

    def apply(self, command: Command) -> None:
        """Send a command. The robot drives like this for 0.15 s, unless another one comes.

        Parameters
        ----------
        command : Command

        Raises
        ------
        ValueError
            Not a command, or one that `Command.checked` refuses. What the network does is counted,
            not raised.
        """
        if not isinstance(command, Command):
            raise ValueError(
                f"command: expected Command(speeds, angles), got {type(command).__name__}"
            )
        command.checked()
        if self._send("command", encode_command(command), self._robot):
            self._said = monotonic()

    def _greet(self) -> None:
        """Say hello where nothing else was said: the robot answers only who speaks."""
        now = monotonic()
        if now - self._said >= HELLO:
            self._said = now
            self._send("hello", {}, self._robot)

    def _take_in(self) -> None:
        """Sort in what came; observations that overtook each other are put in order first."""
        observed, frames = [], []
        for datagram, sender in self._incoming():
            if sender != self._robot:
                self.counts.foreign += 1
            elif datagram.kind == "observation":
                observed.append(datagram)
            elif datagram.kind == "frame":
                frames.append(datagram)
            else:
                self.counts.malformed += 1
        for datagram in _in_order(observed):
            self._take_observation(datagram)
        for datagram in _in_order(frames):
            try:
                frame = decode_frame(datagram.body)
            except ValueError:
                self.counts.malformed += 1
                continue
            if self._arrivals[1].take(datagram.session, datagram.sequence):
                self._frame = frame

    def _take_observation(self, datagram: Datagram) -> None:
        try:
            observation = decode_observation(datagram.body)
        except ValueError:
            self.counts.malformed += 1
            return
        if not isfinite(observation.time):
            self.counts.malformed += 1
        elif self._arrivals[0].take(datagram.session, datagram.sequence):
            self._heard = monotonic()
            self._pending.append(observation)


def _in_order(datagrams: list[Datagram]) -> list[Datagram]:
    """By sequence within a session; sessions in the order in which they came."""
    sessions = list(dict.fromkeys(datagram.session for datagram in datagrams))
    return sorted(datagrams, key=lambda one: (sessions.index(one.session), one.sequence))
