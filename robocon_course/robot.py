"""What the autonomy and the hardware agree on: sizes, readings, commands, and two methods.

Autonomy sees an `Observation` and answers with a `Command`; whoever offers `read` and `apply` is a
`Robot`: the simulator, a replayed log, the machine itself. The sizes below are the drawing's. The
true ones of one particular robot differ by a little, and only calibration finds them.

Base frame: origin in the middle of the robot, x forward, y left, angles counter-clockwise.

Source: 650 x 650 mm, 24.75 kg, dead wheels of 29.6028 mm radius, 537.7 mm apart and 274.5 mm
behind the centre, 800 pulses a turn: swerve robot of Yogyakarta State University, 2024.
LiDAR: Benewake, TFmini Plus data sheet SJ-GU-TFmini-Plus-01 A04, frame format and validity.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.odometry import TrackingWheels

SIDE = 0.65
"""Side of the square body [m]."""
MASS = 24.75
"""With battery and gripper [kg]."""
MAX_SPEED = 3.2
"""What a drive wheel reaches on a full battery [m/s]."""
BATTERY = 24.0
"""Full battery at rest [V]."""

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
    """

    speeds: ArrayLike
    angles: ArrayLike

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

        Raises
        ------
        ValueError
            Not four numbers each, or one that is not finite.
        """
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


# --- TFmini Plus: nine bytes a reading -----------------------------------------------------------

FRAME_HEAD = b"\x59\x59"
FRAME_SIZE = 9
WEAKEST, SATURATED = 100, 65535
"""A strength below the first, or equal to the second, makes the distance worthless."""


class LidarFrames(NamedTuple):
    """What was found in a piece of a LiDAR's byte stream.

    Attributes
    ----------
    readings : list of LidarReading
        Oldest first, their time as given.
    bad : int
        Heads without a matching checksum behind them.
    rest : bytes
        Beginning of a frame that is not complete; put it in front of the next piece.
    """

    readings: list[LidarReading]
    bad: int
    rest: bytes


def encode_lidar(reading: LidarReading, *, per_metre: int = 100) -> bytes:
    """The nine bytes that a TFmini Plus sends for a reading.

    Parameters
    ----------
    reading : LidarReading
        Its time is not sent.
    per_metre : int
        Steps of the distance in a metre: 100, or 1000 for a sensor set to millimetres.

    Returns
    -------
    bytes, 9 long
        0x59 0x59, distance, strength, temperature (two bytes each, low byte first), checksum.

    Raises
    ------
    ValueError
        A value that does not fit into its two bytes.

    Examples
    --------
    >>> encode_lidar(LidarReading(0.0, 1.23, 1000, 25.0)).hex(" ")
    '59 59 7b 00 e8 03 c8 08 e8'
    """
    frame = bytearray(FRAME_HEAD)
    counts = {
        "distance": reading.distance * per_metre,
        "strength": reading.strength,
        "temperature": (reading.temperature + 256.0) * 8.0,
    }
    for name, count in counts.items():
        if not 0.0 <= count < 65535.5:
            raise ValueError(f"reading.{name}: {getattr(reading, name)!r} does not fit the frame")
        frame += round(count).to_bytes(2, "little")
    frame.append(sum(frame) & 0xFF)
    return bytes(frame)


def decode_lidar(stream: bytes, *, time: float = 0.0, per_metre: int = 100) -> LidarFrames:
    """The readings in a piece of a TFmini Plus's byte stream, wherever in a frame it begins.

    Parameters
    ----------
    stream : bytes
        What the serial port gave, the last piece's rest in front.
    time : float  [s]
        Written into the readings: when the piece arrived.
    per_metre : int
        As in `encode_lidar`.

    Returns
    -------
    LidarFrames
        A distance that the strength makes worthless is 0.

    Notes
    -----
    Two bytes 0x59 may stand inside a frame as well. Only a matching checksum makes them a head;
    else the search goes on one byte further.

    Examples
    --------
    >>> found = decode_lidar(bytes.fromhex("00 59 59 7b 00 e8 03 c8 08 e8 59"))
    >>> found.readings[0].distance, found.bad, found.rest
    (1.23, 0, b'Y')
    """
    readings, bad, place, done = [], 0, 0, 0
    while (place := stream.find(FRAME_HEAD, place)) >= 0 and place + FRAME_SIZE <= len(stream):
        frame = stream[place : place + FRAME_SIZE]
        if sum(frame[:-1]) & 0xFF != frame[-1]:
            bad, place = bad + 1, place + 1
            continue
        distance, strength, warmth = (
            int.from_bytes(frame[k : k + 2], "little") for k in range(2, 8, 2)
        )
        if strength < WEAKEST or strength == SATURATED:
            distance = 0
        readings.append(LidarReading(time, distance / per_metre, strength, warmth / 8.0 - 256.0))
        done = place = place + FRAME_SIZE
    if place < 0:  # no head is left, but perhaps its first byte
        place = max(done, len(stream) - stream.endswith(FRAME_HEAD[:1]))
    return LidarFrames(readings, bad, stream[place:])
