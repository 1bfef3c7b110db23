"""The sensor world of chapter 01: one student's IMU and the logs it recorded."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from robocon_course._arrays import FloatArray, freeze_arrays, frozen
from robocon_course.field import MATCH_LENGTH
from robocon_course.imu import attitude_from_accel
from robocon_course.simulator import sensors
from robocon_course.simulator.sensors import ImuErrors, imu_measurements
from robocon_course.worlds.student import Student, generator

DT = 0.01  # s, the phone's sample period
MATCH = MATCH_LENGTH  # s
LEAN = 0.2  # rad: how far from upright a hand holds the phone during its slow turns


@dataclass(frozen=True)
class ImuWorld:
    """One student's IMU and the logs it recorded.

    Attributes
    ----------
    errors : ImuErrors
        Biases, scales and noise of this very sensor: the truth that calibration looks for.
    still : ndarray, shape (2000, 3)  [rad/s]
        Gyroscope, 20 s at rest.
    rests : ndarray, shape (6, 3)  [m/s^2]
        Accelerometer, means of six resting positions: each axis up and down.
    turns : ndarray, shape (n, 3)  [m/s^2]
        Accelerometer during slow turns about three axes, never exactly vertical.
    gyro, accel : ndarray, shape (18000, 3)  [rad/s, m/s^2]
        A whole match, 180 s.
    truth : ndarray, shape (18000, 4)
        True attitude during the match (w, x, y, z).
    """

    errors: ImuErrors
    still: FloatArray
    rests: FloatArray
    turns: FloatArray
    gyro: FloatArray
    accel: FloatArray
    truth: FloatArray
    dt: float = DT

    __post_init__ = freeze_arrays


def own_imu(student: Student, *purpose: str) -> ImuErrors:
    """The errors of one student's IMU: larger than a good sensor's, so that they can be found."""
    rng = generator(student, "imu errors", *purpose)
    size = rng.uniform(0.15, 0.5, 3)  # deg/s
    while np.diff(np.sort(size)).min() < 0.03:  # so that no axis can be mistaken for another
        size = rng.uniform(0.15, 0.5, 3)
    bias = np.radians(size * rng.choice([-1.0, 1.0], 3))
    return ImuErrors(
        gyro_bias=frozen(bias),
        accel_bias=frozen(rng.uniform(0.05, 0.25, 3) * rng.choice([-1.0, 1.0], 3)),
        accel_scale=frozen(1.0 + rng.uniform(-0.025, 0.025, 3)),
    )


@functools.lru_cache(maxsize=4)
def imu_world(student: Student) -> ImuWorld:
    """Logs of one student's IMU: the same to the bit on every machine."""
    rng, errors = generator(student, "imu logs"), own_imu(student)
    still, _ = imu_measurements(*sensors.still(20.0, DT), DT, errors, rng)
    _, turns = imu_measurements(*sensors.slow_turns(DT, lean=LEAN), DT, errors, rng)
    truth, push = sensors.drive(MATCH, DT, rng)
    gyro, accel = imu_measurements(truth, push, DT, errors, rng)
    return ImuWorld(errors, still, rest_means(errors, rng), turns, gyro, accel, truth)


def rest_means(errors: ImuErrors, rng: np.random.Generator) -> FloatArray:
    """Means of six resting positions of 2 s, each axis up and down, shape (6, 3) [m/s^2]."""
    means = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            up = np.zeros(3)
            up[axis] = sign
            tilt = attitude_from_accel(up)
            _, accel = imu_measurements(*sensors.still(2.0, DT, tilt=tilt), DT, errors, rng)
            means.append(accel.mean(axis=0))
    return np.round(means, 4)


@dataclass(frozen=True)
class Rung:
    """One log on the way from an ideal sensor to a real one.

    Attributes
    ----------
    still : ndarray, shape (m, 3)  [rad/s]
        Gyroscope at rest before the drive.
    rests : ndarray, shape (6, 3)  [m/s^2]
        Accelerometer in six positions.
    gyro, accel : ndarray, shape (n, 3)  [rad/s, m/s^2]
    truth : ndarray, shape (n, 4)
        True attitude (w, x, y, z).
    """

    still: FloatArray
    rests: FloatArray
    gyro: FloatArray
    accel: FloatArray
    truth: FloatArray

    __post_init__ = freeze_arrays


PERFECT = ImuErrors(
    gyro_bias=(0.0, 0.0, 0.0), gyro_noise_density=0.0, gyro_walk=0.0, accel_noise_density=0.0
)


def imu_rungs(student: Student, duration: float = 30.0) -> dict[str, Rung]:
    """The same kind of drive three times: an ideal IMU, the student's own, and a rough link."""
    own = own_imu(student)
    rungs = {}
    for name, errors in (("ideal", PERFECT), ("noisy", own), ("rough", own)):
        rng = generator(student, "rung", name)
        truth, push = sensors.drive(duration, DT, rng)
        gyro, accel = imu_measurements(truth, push, DT, errors, rng)
        if name == "rough":
            gyro, accel = roughen(gyro, accel, errors, rng)
        still, _ = imu_measurements(*sensors.still(15.0, DT), DT, errors, rng)
        rungs[name] = Rung(still, rest_means(errors, rng), gyro, accel, truth)
    return rungs


def rough_drive(rng: np.random.Generator, duration: float = 40.0) -> Rung:
    """A drive over a bad radio link, with a bias nobody measured; its first second is at rest."""
    errors = ImuErrors(gyro_bias=np.radians(rng.uniform(-0.4, 0.4, 3)))
    truth, push = sensors.drive(duration, DT, rng)
    gyro, accel = roughen(*imu_measurements(truth, push, DT, errors, rng), errors, rng)
    return Rung(gyro[:80], rest_means(errors, rng), gyro, accel, truth)


def roughen(
    gyro: FloatArray, accel: FloatArray, errors: ImuErrors, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Twelve gaps of up to 0.11 s as NaN, and 25 hits that saturate the accelerometer."""
    gyro, accel = gyro.copy(), accel.copy()
    for start in rng.integers(100, len(gyro) - 100, 12):
        gap = slice(start, start + int(rng.integers(2, 12)))
        gyro[gap] = accel[gap] = np.nan
    for row in rng.integers(100, len(gyro), 25):
        accel[row] = rng.choice([-1.0, 1.0], 3) * errors.accel_range
    return gyro, accel
