"""The wheels of chapter 02: one student's dead wheels and the logs they recorded.

These logs are exact kinematics: the motion is known, the wheels roll without slip unless the log
says otherwise, and only the encoders round. Drives with mass, grip and lag are in `drive`.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray, freeze_arrays
from robocon_course.geometry import distance_along, quaternion_from_euler
from robocon_course.odometry import TrackingWheels, integrate, tick_changes
from robocon_course.simulator.sensors import ImuErrors, imu_measurements
from robocon_course.worlds.robot import LEFT, RIGHT, own_wheels
from robocon_course.worlds.student import Student, generator

SAMPLE = 0.01  # s
BITS = 16
"""Width of the encoder counters in the robot's microcontroller."""
RUN = (2.4, 2.0)
"""Straight run of the calibration [m, base]: slanting, so that all wheels roll."""
CROOKED = (0.001, 0.002)  # rad, by which the run turned all the same; no eye sees 0.1 degrees
SPIN = 20.0 * np.pi
"""Spin of the calibration: ten turns to the left [rad]."""
SQUARE = 2.0
"""Side of the test square [m]; it is driven twice, to the left."""

Leg = tuple[float, float, float, float]
"""Forward [m], left [m], turn [rad], all in the base's own axes, and how long it takes [s]."""


@dataclass(frozen=True)
class WheelLog:
    """What the dead wheels counted on a drive that is known exactly.

    Attributes
    ----------
    counters : ndarray of int64, shape (n + 1, 3)
        Left, right, rear, 0 to 65535: they wrap around.
    poses : ndarray, shape (n + 1, 3)  [m, m, rad; map]
        The truth.
    dt : float  [s]
    """

    counters: NDArray[np.int64]
    poses: FloatArray
    dt: float = SAMPLE

    __post_init__ = freeze_arrays

    @property
    def distance(self) -> FloatArray:
        """How far the robot has driven, shape (n + 1,) [m]."""
        return distance_along(self.poses[:, :2])


@dataclass(frozen=True)
class OdometryWorld:
    """One student's robot on three drives before the match.

    Attributes
    ----------
    wheels : TrackingWheels
        The true sizes, which calibration looks for.
    run : WheelLog
        A slanting run of `RUN`, as straight as somebody can push a robot.
    spin : WheelLog
        A spin on the spot by `SPIN`.
    square : WheelLog
        Twice around a square of `SQUARE`, back to where it began.
    """

    wheels: TrackingWheels
    run: WheelLog
    spin: WheelLog
    square: WheelLog


@functools.lru_cache(maxsize=4)
def odometry_world(student: Student) -> OdometryWorld:
    """Drives of one student's robot: the same to the bit on every machine."""
    wheels, rng = own_wheels(student), generator(student, "wheel logs")
    crooked = rng.uniform(*CROOKED) * rng.choice([-1.0, 1.0])
    run = wheel_log([(*RUN, crooked, 6.0)], wheels, rng)
    spin = wheel_log([(0.0, 0.0, SPIN, 40.0)], wheels, rng)
    side = [(SQUARE, 0.0, 0.0, 3.0), (0.0, 0.0, np.pi / 2, 2.0)]
    return OdometryWorld(wheels, run, spin, wheel_log(8 * side, wheels, rng))


def twists_of(legs: Iterable[Leg], dt: float = SAMPLE) -> FloatArray:
    """Legs as one twist per sample, each leg from rest to rest.

    Parameters
    ----------
    legs : iterable of (forward, left, turn, duration)  [m, m, rad, s; base]
    dt : float  [s]

    Returns
    -------
    ndarray, shape (n, 3)  [m/s, m/s, rad/s; base]
    """
    parts = []
    for *motion, duration in legs:
        count = max(1, round(duration / dt))
        share = np.sin(np.pi * (np.arange(count) + 0.5) / count) ** 2
        parts.append(share[:, None] / share.sum() * motion / dt)
    return np.concatenate(parts)


def wheel_log(
    legs: Iterable[Leg],
    wheels: TrackingWheels,
    rng: np.random.Generator,
    *,
    grip: FloatArray | None = None,
    dt: float = SAMPLE,
) -> WheelLog:
    """What the counters of some wheels say on a drive.

    Parameters
    ----------
    legs : iterable of (forward, left, turn, duration)  [m, m, rad, s; base]
    wheels : TrackingWheels
        The true sizes.
    rng : numpy.random.Generator
        Draws where the counters stand at the beginning.
    grip : ndarray, shape (n, 3), optional
        Which part of its way each wheel rolls: 1 without slip, 0 lifted or not heard.
    dt : float  [s]

    Returns
    -------
    WheelLog
    """
    deltas = twists_of(legs, dt) * dt
    turned = deltas @ wheels.matrix.T / wheels.metres_per_tick
    turned = turned if grip is None else turned * grip
    begin = rng.uniform(0, 1 << BITS, turned.shape[1])
    whole = np.floor(begin + np.vstack([np.zeros(turned.shape[1]), turned.cumsum(axis=0)]))
    return WheelLog(whole.astype(np.int64) % (1 << BITS), integrate(deltas), dt)


def random_legs(rng: np.random.Generator, duration: float) -> list[Leg]:
    """Legs that go forward or back, aside, and turn on the way, after a second at rest.

    Parameters
    ----------
    rng : numpy.random.Generator
    duration : float  [s]
        Legs are added until they last this long; the last is cut to fit.

    Returns
    -------
    list of Leg
    """
    legs, time = [(0.0, 0.0, 0.0, 1.0)], 1.0
    while duration - time > 0.5:
        forward = rng.uniform(0.6, 2.4) * rng.choice([-1.0, 1.0], p=[0.3, 0.7])
        left = rng.uniform(-0.8, 0.8)
        turn = rng.uniform(0.4, 2.2) * rng.choice([-1.0, 1.0])
        needed = max(2.0 * np.hypot(forward, left) / 1.6, 2.0 * abs(turn) / 1.8)
        length = min(round(needed, 2), round(duration - time, 2))
        share = length / needed
        legs.append((share * forward, share * left, share * turn, length))
        time += length
    return legs


@dataclass(frozen=True)
class RoughDrive:
    """A drive on which sensors fail one after the other.

    Attributes
    ----------
    wheels : TrackingWheels
        Calibrated: sizes are not the problem here.
    ticks : ndarray of int64, shape (n, 3)
        Counts of each sample: left, right, rear.
    gyro : ndarray, shape (n,)  [rad/s, body]
        Rate about z of each sample, with a bias; NaN where nothing came.
    poses : ndarray, shape (n + 1, 3)  [m, m, rad; map]
        The truth, from (0, 0, 0).
    """

    wheels: TrackingWheels
    ticks: NDArray[np.int64]
    gyro: FloatArray
    poses: FloatArray
    dt: float = SAMPLE

    __post_init__ = freeze_arrays


def rough_drive_log(rng: np.random.Generator, duration: float = 40.0) -> RoughDrive:
    """A drive with a lost encoder, a slipping wheel, and gaps in a biased gyroscope.

    The first second is at rest. Then come, at different times: one of the two parallel wheels is
    not heard for 3 to 5 s; one of them rolls too little, three times for up to a second; the
    gyroscope is not heard, three times for up to a second.

    Parameters
    ----------
    rng : numpy.random.Generator
    duration : float  [s]

    Returns
    -------
    RoughDrive
    """
    wheels = own_wheels(int(rng.integers(1 << 30)), "rough")
    legs = random_legs(rng, duration)
    twists = twists_of(legs)
    count = len(twists)
    grip, heard = np.ones((count, 3)), np.ones(count, bool)
    slots = rng.permutation(np.linspace(150, count - 600, 7).astype(int))
    for number, start in enumerate(slots):
        length = int(rng.integers(40, 100)) if number else int(rng.integers(300, 450))
        when = slice(start, start + length)
        if number < 4:
            rolled = rng.uniform(0.0, 0.5) if number else 0.0
            grip[when, rng.choice([LEFT, RIGHT])] = rolled
        else:
            heard[when] = False
    log = wheel_log(legs, wheels, rng, grip=grip)
    ticks = tick_changes(log.counters, BITS)
    bias = np.radians(rng.uniform(0.2, 0.5) * rng.choice([-1.0, 1.0]))
    gyro = gyro_of(log.poses[:, 2], ImuErrors(gyro_bias=(0.0, 0.0, bias)), rng, log.dt)
    return RoughDrive(wheels, ticks, np.where(heard, gyro, np.nan), log.poses)


def gyro_of(
    headings: FloatArray, errors: ImuErrors, rng: np.random.Generator, dt: float = SAMPLE
) -> FloatArray:
    """What a gyroscope says about z between headings of a level robot.

    Parameters
    ----------
    headings : ndarray, shape (n + 1,)  [rad, map]
    errors : ImuErrors
    rng : numpy.random.Generator
    dt : float  [s]

    Returns
    -------
    ndarray, shape (n,)  [rad/s, body]
    """
    attitudes = quaternion_from_euler(np.zeros_like(headings), np.zeros_like(headings), headings)
    level = np.zeros((len(headings), 3))
    return imu_measurements(attitudes, level, dt, errors, rng)[0][1:, 2]
