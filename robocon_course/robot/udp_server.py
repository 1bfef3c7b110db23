"""The robot's side of the link: it tells what it sees, does what it is told, and stops alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import monotonic

import numpy as np

from robocon_course.robot.camera_frames import encode_frame
from robocon_course.robot.codec import decode_command, encode_observation
from robocon_course.robot.hardware import Command, Frame, Observation, Robot
from robocon_course.robot.link import Arrivals, Datagram, LinkError, pack
from robocon_course.robot.udp_end import Address, End

PERIOD = 0.01
"""Between two observations [s]."""
PATIENCE = 0.15
"""Without a command for so long, a robot stops [s]. With all delays it stands by within 0.2 s."""
FORGET = 1.0
"""After so long without a word, a robot listens to somebody else [s]."""
KNOWN = 16
"""Of so many senders it is known which datagrams came already."""
MOST_SAMPLES = 200
"""IMU samples that an observation carries at most; of more, the oldest are left away."""
QUALITIES = (85, 60, 35, 15)
"""Of a picture's JPEG: the first with which it fits a datagram."""


class RobotServer(End):
    """Lets a robot be driven over the network.

    Whoever speaks first is obeyed, and nobody else until that one was silent for a second. Without
    a command for 0.15 s the robot stops, its modules held where they point; the next command
    drives it again.

    Parameters
    ----------
    robot : Robot
        Its ``read`` must not wait.
    port : int
        0 takes a free one, see `port`.
    host : str
        Address to listen at. The usual one is reached from this computer alone; ``"0.0.0.0"`` is
        reached from the whole network, which has no password here.
    step : callable, optional
        Called with the seconds that passed: what lets a simulator's time pass.

    Attributes
    ----------
    port : int
    counts : LinkCounts
        Of the commands that came, or did not.
    driving : bool
        Whether commands come.

    Raises
    ------
    LinkError
        The port is taken, the address is not of this computer, or the robot is none.
    """

    def __init__(
        self,
        robot: Robot,
        port: int = 0,
        *,
        host: str = "127.0.0.1",
        step: Callable[[float], object] | None = None,
    ) -> None:
        if not isinstance(robot, Robot):
            raise LinkError(f"robot: expected read() and apply(command), got {robot!r:.60}")
        super().__init__()
        try:
            self._socket.bind((host, port))
        except (OSError, OverflowError, TypeError) as error:
            self._socket.close()
            raise LinkError(f"host, port: cannot listen at {host!r}, {port!r} ({error})") from None
        self.port: int = self._socket.getsockname()[1]
        self.driving = False
        self._robot, self._step = robot, step
        self._peer: Address | None = None
        self._senders: dict[Address, Arrivals] = {}
        self._heard = self._told = -1e9
        self._stepped = monotonic()
        self._command = Command.stop()
        self._angles = np.zeros(4)
        self._running = True

    def run(self) -> None:
        """Serve until `stop` is called, from another thread or a step; then the robot stands."""
        due = monotonic()
        try:
            while self._running:
                self.turn()
                due = max(due + PERIOD, monotonic() - 0.1)  # after a hold-up, do not make it all up
                while monotonic() < due:
                    self._wait(due)
                    self._take_in()
        finally:
            self._halt()

    def stop(self) -> None:
        """End `run` after its round."""
        self._running = False

    def turn(self) -> None:
        """One round: let time pass, obey what came, stop if nothing did, tell what is seen."""
        now = monotonic()
        if self._step is not None and now > self._stepped:
            self._step(now - self._stepped)
        self._stepped = now
        self._take_in()
        observation = self._robot.read()
        if np.isfinite(observation.module_angles).all():
            self._angles = observation.module_angles
        if self.driving and monotonic() - self._told > PATIENCE:
            self._halt()
        if self._peer is not None and monotonic() - self._heard > FORGET:
            self._peer = None
        if self._peer is not None:
            try:
                self._tell(observation, self._peer)
            except ValueError:  # a driver that gives what is no observation; it is obeyed still
                self.counts.unsent += 1

    def _halt(self) -> None:
        """The wheels stand, the modules and the camera stay as they are."""
        self.driving = False
        pan, tilt = self._command.pan, self._command.tilt
        self._robot.apply(replace(Command.stop(self._angles), pan=pan, tilt=tilt))

    def _take_in(self) -> None:
        """Obey the commands that came."""
        for datagram, sender in self._incoming():
            if datagram.kind not in ("hello", "command"):
                self.counts.malformed += 1
            elif self._listens_to(sender) and datagram.kind == "command":
                self._obey(datagram)

    def _listens_to(self, sender: Address) -> bool:
        if sender != self._peer:
            if self._peer is not None:  # until a turn forgets it
                self.counts.foreign += 1
                return False
            self._peer = sender
            # What each has said stays known: its old words, sent again, shall not drive the robot.
            known = self._senders.pop(sender, None) or Arrivals(self.counts)
            self._senders[sender] = known
            for oldest in list(self._senders)[:-KNOWN]:
                del self._senders[oldest]
        self._heard = monotonic()
        return True

    def _obey(self, datagram: Datagram) -> None:
        try:
            command = decode_command(datagram.body)
            command.checked()
        except ValueError:
            self.counts.malformed += 1
            return
        if self._senders[self._peer].take(datagram.session, datagram.sequence):
            self._told, self._command, self.driving = monotonic(), command, True
            self._robot.apply(command)

    def _tell(self, observation: Observation, peer: Address) -> None:
        """Send an observation, and its picture by itself: a lost piece of it costs no samples."""
        if observation.frame is not None:
            self._show(observation.frame, peer)
        told = observation._replace(
            imu_time=observation.imu_time[-MOST_SAMPLES:],
            gyro=observation.gyro[-MOST_SAMPLES:],
            accel=observation.accel[-MOST_SAMPLES:],
            frame=None,
        )
        self._send("observation", encode_observation(told), peer)

    def _show(self, frame: Frame, peer: Address) -> None:
        for quality in QUALITIES:
            body = encode_frame(frame, quality=quality)
            if _fits(body) or quality == QUALITIES[-1]:
                self._send("frame", body, peer)
                return


def _fits(body: dict) -> bool:
    try:
        pack(Datagram("frame", 2**53 - 1, 2**53 - 1, body))
    except ValueError:
        return False
    return True


def serve(
    robot: Robot,
    port: int,
    *,
    host: str = "127.0.0.1",
    step: Callable[[float], object] | None = None,
) -> None:
    """Let a robot be driven over the network, until the program is interrupted.

    Parameters
    ----------
    robot : Robot
        Its ``read`` must not wait.
    port : int
    host : str
        As for `RobotServer`: ``"0.0.0.0"`` is reached from the whole network.
    step : callable, optional
        Called with the seconds that passed [s], for a simulator.

    Raises
    ------
    LinkError
        The port is taken, or the address is not of this computer.
    """
    with RobotServer(robot, port, host=host, step=step) as server:
        try:
            server.run()
        except KeyboardInterrupt:
            pass
