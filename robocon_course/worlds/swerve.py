"""The swerve world of chapter 03: one student's four modules, and logs of how they drove."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray, freeze_arrays
from robocon_course.geometry import wrap_angle
from robocon_course.robot import MODULES
from robocon_course.simulator.sensors import SensorModel
from robocon_course.swerve import module_targets
from robocon_course.worlds.student import Student, generator

STEP = 0.02  # s between two rows of a log
SPEED_NOISE = 0.04  # m/s
ANGLE_NOISE = np.radians(0.8)


@dataclass(frozen=True)
class SwerveWorld:
    """One student's drive, and a log of it beside what a camera over the field saw.

    Attributes
    ----------
    max_speed : float  [m/s]
        What the drive wheels of this very robot reach.
    offsets : ndarray, shape (4,)  [rad]
        What each steering encoder says too much: it was screwed on by hand.
    time : ndarray, shape (n,)  [s]
    twists : ndarray, shape (n, 3)  [m/s, m/s, rad/s; base]
        Motion of the body as the camera measured it.
    speeds : ndarray, shape (n, 4)  [m/s]
        Of the drive wheels, always forwards.
    angles : ndarray, shape (n, 4)  [rad, base]
        As the steering encoders say, in [-pi, pi).
    """

    max_speed: float
    offsets: FloatArray
    time: FloatArray
    twists: FloatArray
    speeds: FloatArray
    angles: FloatArray

    __post_init__ = freeze_arrays


@functools.lru_cache(maxsize=4)
def swerve_world(student: Student) -> SwerveWorld:
    """One student's drive: the same to the bit on every machine."""
    rng = generator(student, "swerve")
    offsets = own_offsets(rng)
    max_speed = float(round(rng.uniform(2.2, 3.1), 2))
    twists = body_twists(600, rng)
    speeds, angles = encoders(twists, rng, offsets)
    seen = np.round(twists + rng.normal(0.0, [0.005, 0.005, 0.01], twists.shape), 3)
    return SwerveWorld(max_speed, offsets, STEP * np.arange(600), seen, speeds, angles)


def own_offsets(rng: np.random.Generator) -> FloatArray:
    """Zero offsets of four steering encoders, none like another [rad]."""
    size = rng.uniform(4.0, 25.0, 4)
    while np.diff(np.sort(size)).min() < 2.0:
        size = rng.uniform(4.0, 25.0, 4)
    return np.radians(np.round(size, 1) * rng.choice([-1.0, 1.0], 4))


@dataclass(frozen=True)
class SlipLog:
    """A drive during which one wheel after the other slips.

    Attributes
    ----------
    time : ndarray, shape (n,)  [s]
    speeds : ndarray, shape (n, 4)  [m/s]
    angles : ndarray, shape (n, 4)  [rad, base]
    slipping : ndarray of int, shape (n,)
        Number of the wheel that slips, -1 where all roll.
    """

    time: FloatArray
    speeds: FloatArray
    angles: FloatArray
    slipping: NDArray[np.intp]

    __post_init__ = freeze_arrays


def slip_log(rng: np.random.Generator, rows: int = 600) -> SlipLog:
    """Twelve seconds on a floor with wet spots, one every second and a half or so."""
    speeds, angles = encoders(body_twists(rows, rng), rng)
    slipping = np.full(rows, -1)
    start = int(rng.integers(30, 60))
    while start < rows - 50:
        spot = slice(start, start + int(rng.integers(12, 40)))
        wheel = int(rng.integers(4))
        slipping[spot] = wheel
        # A driven wheel spins, a braked one is held back.
        speeds[spot, wheel] += rng.uniform(0.15, 0.45) * rng.choice([-1.0, 1.0])
        start = spot.stop + int(rng.integers(25, 60))
    return SlipLog(STEP * np.arange(rows), np.round(speeds, 3), angles, slipping)


def body_twists(rows: int, rng: np.random.Generator) -> FloatArray:
    """A swerving drive that never stands still, shape (rows, 3) [m/s, m/s, rad/s; base]."""
    t = STEP * np.arange(rows)

    def wave() -> FloatArray:
        return np.sin(2.0 * np.pi * (rng.uniform(0.1, 0.25) * t + rng.uniform(0.0, 1.0)))

    speed, way, omega = 1.1 + 0.25 * wave(), np.pi * wave() + np.pi * wave(), 1.2 * wave()
    return np.column_stack([speed * np.cos(way), speed * np.sin(way), omega])


def encoders(
    twists: FloatArray, rng: np.random.Generator, offsets: FloatArray | float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """What the encoders of rolling modules say, rounded to what they resolve."""
    targets = module_targets(MODULES, twists, np.zeros(4))
    speeds = targets.speeds + rng.normal(0.0, SPEED_NOISE, targets.speeds.shape)
    angles = targets.angles + offsets + rng.normal(0.0, ANGLE_NOISE, targets.angles.shape)
    counts = np.round(wrap_angle(angles) / SensorModel.angle_step)
    counts = np.where(counts == 2048, -2048, counts)
    return np.round(speeds, 3), counts * SensorModel.angle_step
