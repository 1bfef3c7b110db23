"""Sizes, readings, commands, and the two methods of everything that can be driven.

Autonomy sees an `Observation` and answers with a `Command`; whoever offers `read` and `apply` is a
`Robot`: the simulator, a replayed log, the machine itself. The sizes below are the drawing's. The
true ones of one particular robot differ by a little, and only calibration finds them.

Base frame: origin in the middle of the robot, x forward, y left, angles counter-clockwise.

Source: 650 x 650 mm, 24.75 kg, dead wheels of 29.6028 mm radius, 537.7 mm apart and 274.5 mm
behind the centre, 800 pulses a turn: swerve robot of Yogyakarta State University, 2024.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, pi
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.odometry import TrackingWheels

if TYPE_CHECKING:
    from robocon_course.vision import Detections

SIDE = 0.65
"""Side of the square body [m]."""
MASS = 24.75
"""With battery and gripper [kg]."""
MAX_SPEED = 3.2
"""What a drive wheel reaches on a full battery [m/s]."""
BATTERY = 24.0
"""Full battery at rest [V]."""

WATCHES = ("", "ball", "silo")
"""What pictures may be asked for: of nothing, or for one of the networks."""

_H = 0.235
MODULES: FloatArray = np.array([(_H, _H), (-_H, _H), (-_H, -_H), (_H, -_H)])
"""Swerve modules [m, base]: front left, rear left, rear right, front right."""
MODULES.setflags(write=False)

DEAD_WHEELS = TrackingWheels(
    positions=np.array([(0.0, 0.26885), (0.0, -0.26885), (-0.2745, 0.0)]),
    directions=np.array([0.0, 0.0, pi / 2]),
    radius=0.0296028,
    ticks_per_turn=3200,
)
"""Left, right and rear; 800 pulses a turn, and both edges of both channels count."""


class LidarMount(NamedTuple):
    """Where a LiDAR sits and which way it looks.

    Attributes
    ----------
    name : str
    x, y : float  [m, base]
        Where its distance counts from.
    angle : float  [rad, base]
    """

    name: str
    x: float
    y: float
    angle: float


LIDARS = (
    LidarMount("front", 0.31, 0.14, 0.0),
    LidarMount("left", 0.12, 0.31, pi / 2),
    LidarMount("rear", -0.31, -0.14, pi),
    LidarMount("right", -0.12, -0.31, -pi / 2),
)
"""One to each side: facing along a map axis, the robot measures both coordinates against walls."""
LIDAR_HEIGHT = 0.05
"""Of every beam above the floor [m]: half the height of the boards."""
LIDAR_RANGE = (0.1, 12.0)
"""Nearest and farthest distance that a LiDAR reports [m]."""
WEAKEST, SATURATED = 100, 65535
"""A strength below the first, or equal to the second, makes the distance worthless."""


class LidarReading(NamedTuple):
    """One answer of one LiDAR.

    Attributes
    ----------
    time : float  [s]
        When it was measured. On a clock that has just begun at 0 the latest measurement may lie a
        little before it.
    distance : float  [m]
        Along the beam; 0 where the sensor does not trust itself.
    strength : int
        Of the returned light, 0 to 65535; below 100, or 65535, it is not to be trusted.
    temperature : float  [deg C]
    """

    time: float
    distance: float
    strength: int
    temperature: float


class Frame(NamedTuple):
    """One picture of the camera. It arrives some time after it was taken.

    Attributes
    ----------
    time : float  [s]
        When it was taken, by the robot's clock.
    pan, tilt : float  [rad, base]
        Where the camera looked then: to the left of ahead, and down.
    image_bgr : ndarray of uint8, shape (h, w, 3), or None
        None where nobody draws pictures: then what a detector would say of it stands in `found`.
    found : dict
        Detections by the kind of network, ``"ball"`` or ``"silo"``; empty beside a picture.
    """

    time: float
    pan: float
    tilt: float
    image_bgr: NDArray[np.uint8] | None = None
    found: Mapping[str, Detections] = MappingProxyType({})


class Observation(NamedTuple):
    """All that the robot knows about the world at one moment.

    Attributes
    ----------
    time : float  [s]
        The robot's clock.
    ticks : ndarray of int64, shape (3,)
        Counters of the dead wheels: left, right, rear; counted from the start, four to a pulse.
    imu_time : ndarray, shape (k,)  [s]
        The IMU samples since the last read, oldest first; k may be 0.
    gyro : ndarray, shape (k, 3)  [rad/s, base]
    accel : ndarray, shape (k, 3)  [m/s^2, base]
        Specific force: at rest the upward axis reads +9.8.
    lidar : tuple of LidarReading
        The latest of each sensor, in the order of `LIDARS`.
    module_speeds : ndarray, shape (4,)  [m/s]
        How fast the drive wheels turn, times their radius; a slipping wheel turns too.
    module_angles : ndarray, shape (4,)  [rad, base]
        Where the modules point, from -pi to pi.
    battery : float  [V]
    holding : bool
        Whether the light barrier in the gripper is interrupted: a ball is held.
    frame : Frame or None
        A picture that arrived since the last read.
    """

    time: float
    ticks: NDArray[np.int64]
    imu_time: FloatArray
    gyro: FloatArray
    accel: FloatArray
    lidar: tuple[LidarReading, ...]
    module_speeds: FloatArray
    module_angles: FloatArray
    battery: float
    holding: bool = False
    frame: Frame | None = None


@dataclass(frozen=True, eq=False)
class Command:
    """What the four modules are asked to do, in the order of `MODULES`.

    Attributes
    ----------
    speeds : array_like, shape (4,)  [m/s]
        Of the drive wheels; negative is backwards.
    angles : array_like, shape (4,)  [rad, base]
        Where the modules shall point. Full turns do not matter: a module has no end stop, and
        takes the shorter way to the direction.
    intake : float
        Rollers of the gripper: above 0 they pull a ball in, below 0 they let it go, 0 holds.
    release : bool
        Put the held ball down over the front edge, into a silo.
    pan, tilt : float  [rad, base]
        Of the camera servo: to the left of ahead, and down.
    watch : str
        What the next pictures are for, ``"ball"`` or ``"silo"``; empty: none are needed.
    """

    speeds: ArrayLike
    angles: ArrayLike
    intake: float = 0.0
    release: bool = False
    pan: float = 0.0
    tilt: float = 0.0
    watch: str = ""

    @classmethod
    def stop(cls, angles: ArrayLike = (0.0, 0.0, 0.0, 0.0)) -> Command:
        """Every wheel stands still.

        Parameters
        ----------
        angles : array_like, shape (4,)  [rad, base]
            Where the modules point meanwhile; pass ``observation.module_angles`` to leave them.
        """
        return cls(np.zeros(4), angles)

    def checked(self) -> tuple[FloatArray, FloatArray]:
        """Speeds and angles as float arrays of four: for whoever carries the command out.

        Returns
        -------
        speeds, angles : ndarray, shape (4,)  [m/s; rad, base]

        Raises
        ------
        ValueError
            Not four numbers each, a number that is not finite, pictures for what is no network.
        """
        for name in ("intake", "pan", "tilt"):
            number = getattr(self, name)
            if not isinstance(number, int | float | np.number) or not isfinite(number):
                raise ValueError(f"command.{name}: expected a finite number, got {number!r:.40}")
        if self.watch not in WATCHES:
            known = ", ".join(map(repr, WATCHES))
            raise ValueError(f"command.watch: expected one of {known}, got {self.watch!r:.40}")
        speeds = as_floats(self.speeds, "command.speeds", 4)
        return speeds, as_floats(self.angles, "command.angles", 4)


@runtime_checkable
class Robot(Protocol):
    """Whatever can be driven: the simulator, a replayed log, hardware."""

    def read(self) -> Observation:
        """What the sensors say now; hands over the IMU samples since the last call."""
        ...

    def apply(self, command: Command) -> None:
        """Drive like this from now on, until the next command."""
        ...
