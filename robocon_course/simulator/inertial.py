"""What does an IMU read, given how it really moves?

With q_k the true attitude (body -> map) and a_k the true acceleration in map axes at sample k:

    gyro_k  = rotation_vector(q*_(k-1) ⊗ q_k) / dt + bias + noise      mean rate since sample k-1
    accel_k = R(q_k)^T (a_k + g z) / scale + bias + noise              specific force: up reads +g

then cut off at the sensor's range and rounded to its resolution. A noise density N in unit/sqrt(Hz)
gives sigma = N sqrt(fs/2) per sample: the sensor passes everything up to half the sample rate.
(Some tools use N sqrt(fs), 1.41 times more.)

Source: TDK InvenSense, ICM-42605 data sheet DS-000292 rev. 1.4, tables 1 and 2 (densities, ranges).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, atan2, cos, inf, radians, sin, sqrt

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import GRAVITY


@dataclass(frozen=True)
class ImuErrors:
    """Everything that parts an IMU's reading from the truth; three numbers are one per axis.

    Attributes
    ----------
    gyro_bias : sequence of 3  [rad/s]
        0.02 deg/s stays after a phone has calibrated itself.
    gyro_noise_density : float  [rad/s/sqrt(Hz)]
    gyro_walk : float  [rad/s/sqrt(s)]
        How the bias wanders: 5 deg/h within a match.
    accel_bias : sequence of 3  [m/s^2]
    accel_scale : sequence of 3
        The calibration (raw - bias) * scale undoes scale and bias.
    accel_noise_density : float  [m/s^2/sqrt(Hz)]
    gyro_range, accel_range : float  [rad/s, m/s^2]
        The sensor says at most this much, either way.
    gyro_resolution, accel_resolution : float  [rad/s, m/s^2]
        One step of the converter.
    """

    gyro_bias: Sequence[float] = (radians(0.02), radians(-0.02), radians(0.02))
    gyro_noise_density: float = radians(0.0038)
    gyro_walk: float = radians(1e-4)
    accel_bias: Sequence[float] = (0.0, 0.0, 0.0)
    accel_scale: Sequence[float] = (1.0, 1.0, 1.0)
    accel_noise_density: float = 70e-6 * GRAVITY
    gyro_range: float = radians(500.0)
    accel_range: float = 4.0 * GRAVITY
    gyro_resolution: float = radians(1.0 / 65.5)
    accel_resolution: float = GRAVITY / 8192.0


UNCALIBRATED = ImuErrors(
    gyro_bias=(radians(0.5), radians(-0.4), radians(0.3)),
    accel_bias=(0.020 * GRAVITY, -0.015 * GRAVITY, 0.010 * GRAVITY),
    accel_scale=(1.010, 0.985, 1.005),
)
"""A sensor as it leaves the factory: 0.5 deg/s, 20 mg and a per cent or so off."""


NOISES = 9
"""Standard normal numbers that a sample takes: the gyroscope's walk, then its and the
accelerometer's white noise, three axes each."""


def error_table(errors: ImuErrors, dt: float) -> FloatArray:
    """The errors as the kernels take them.

    Parameters
    ----------
    errors : ImuErrors
    dt : float  [s]
        Time between samples.

    Returns
    -------
    ndarray, shape (6, 6)
        Columns: gyroscope x, y, z, accelerometer x, y, z. Rows: scale, bias, walk and white noise
        per sample, range, resolution.

    Raises
    ------
    ValueError
        Not three numbers where there should be.
    """
    one, rate = np.ones(3), sqrt(0.5 / dt)
    bias = as_floats(errors.gyro_bias, "errors.gyro_bias", 3)
    scale = as_floats(errors.accel_scale, "errors.accel_scale", 3)
    rows = (
        (one, scale),
        (bias, as_floats(errors.accel_bias, "errors.accel_bias", 3)),
        (errors.gyro_walk * sqrt(dt) * one, 0.0 * one),
        (errors.gyro_noise_density * rate * one, errors.accel_noise_density * rate * one),
        (errors.gyro_range * one, errors.accel_range * one),
        (errors.gyro_resolution * one, errors.accel_resolution * one),
    )
    return np.array([np.concatenate(row) for row in rows])


@njit
def _turn_rate(before, now, dt, out):
    """Mean rate of the turn between two attitudes (w, x, y, z), into out[:3]."""
    aw, ax, ay, az = before[0], before[1], before[2], before[3]
    w, x, y, z = now[0], now[1], now[2], now[3]
    # (s, v) = before* ⊗ now, by the shorter way round
    s = aw * w + ax * x + ay * y + az * z
    side = -1.0 if s < 0.0 else 1.0
    vx = side * (aw * x - ax * w - ay * z + az * y)
    vy = side * (aw * y + ax * z - ay * w - az * x)
    vz = side * (aw * z - ax * y + ay * x - az * w)
    half = atan2(sqrt(vx * vx + vy * vy + vz * vz), side * s)
    rate = 2.0 / dt * (half / sin(half) if half > 0.0 else 1.0)
    out[0], out[1], out[2] = rate * vx, rate * vy, rate * vz


@njit
def _specific_force(now, ax, ay, az, out):
    """R(now)^T (a + g z), into out[3:]."""
    w, x, y, z = now[0], now[1], now[2], now[3]
    az += GRAVITY
    cx, cy, cz = 2.0 * (ay * z - az * y), 2.0 * (az * x - ax * z), 2.0 * (ax * y - ay * x)
    out[3] = ax + w * cx + cy * z - cz * y
    out[4] = ay + w * cy + cz * x - cx * z
    out[5] = az + w * cz + cx * y - cy * x


@njit
def _convert(out, table, walk, noise):
    """From the true rates and forces in ``out`` to what the sensor says, in place."""
    for j in range(6):
        if j < 3:
            walk[j] += table[2, j] * noise[j]
        value = out[j] / table[0, j] + table[1, j] + (walk[j] if j < 3 else 0.0)
        value += table[3, j] * noise[3 + j]
        value = min(max(value, -table[4, j]), table[4, j])
        # Whole steps of the converter; adding 0.0 turns -0.0 into 0.0.
        out[j] = (np.rint(value / table[5, j]) + 0.0) * table[5, j]


@njit(cache=True)
def read_motion(quaternions, accelerations, dt, table, noise, out):
    """A whole motion, row by row; the first row repeats the second's rate.

    Parameters
    ----------
    quaternions : ndarray, shape (n, 4)
    accelerations : ndarray, shape (n, 3)  [m/s^2, map]
    dt : float  [s]
    table : ndarray, shape (6, 6)
        From `error_table`.
    noise : ndarray, shape (n, NOISES)
    out : ndarray, shape (n, 6)
        Gyroscope and accelerometer.
    """
    walk = np.zeros(3)
    for k in range(len(out)):
        after = min(max(k, 1), len(out) - 1)
        _turn_rate(quaternions[max(after - 1, 0)], quaternions[after], dt, out[k])
        a = accelerations[k]
        _specific_force(quaternions[k], a[0], a[1], a[2], out[k])
        _convert(out[k], table, walk, noise[k])


@njit(cache=True)
def read_track(track, tick, every, table, noise, memory, walk, out):
    """The samples of an IMU on a robot whose physics left a track.

    Its acceleration is the mean since the sample before: a short hit is felt, as it is by a sensor
    that passes everything up to half its rate.

    Parameters
    ----------
    track : ndarray, shape (rows, TRACK)
        As `physics.advance` leaves it.
    tick : int
        Of the first sample; row ``tick % len(track)``.
    every : int
        Ticks between samples.
    table : ndarray, shape (6, 6)
    noise : ndarray, shape (n, NOISES)
    memory : ndarray, shape (8,)
        What the sample before leaves: attitude (4), velocity (3), and the time between samples
        [s]; changed in place.
    walk : ndarray, shape (3,)  [rad/s]
        How far the gyroscope's bias has wandered; changed in place.
    out : ndarray, shape (n, 6)
    """
    dt = memory[7]
    now = np.empty(4)
    for k in range(len(out)):
        row = track[(tick + k * every) % len(track)]
        attitude(row[2], row[6], row[7], now)
        _turn_rate(memory, now, dt, out[k])
        vx, vy, vz = row[3], row[4], row[5]
        ax, ay, az = (vx - memory[4]) / dt, (vy - memory[5]) / dt, (vz - memory[6]) / dt
        _specific_force(now, ax, ay, az, out[k])
        _convert(out[k], table, walk, noise[k])
        memory[0], memory[1], memory[2], memory[3] = now[0], now[1], now[2], now[3]
        memory[4], memory[5], memory[6] = vx, vy, vz


@njit(cache=True)
def attitude(theta, rise_x, rise_y, out):
    """Quaternion (w, x, y, z) of a robot that stands on a slope, into ``out``.

    Parameters
    ----------
    theta : float  [rad]
        Heading in the map.
    rise_x, rise_y : float  [m per m]
        Of the floor, along the robot's x and y axis.
    out : ndarray, shape (4,)
    """
    pitch = -atan(rise_x)  # REP-103: positive lowers the nose
    roll = atan(rise_y * cos(pitch))
    cr, sr, cp, sp = cos(roll / 2), sin(roll / 2), cos(pitch / 2), sin(pitch / 2)
    cy, sy = cos(theta / 2), sin(theta / 2)
    out[0], out[1] = cr * cp * cy + sr * sp * sy, sr * cp * cy - cr * sp * sy
    out[2], out[3] = cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy


def imu_measurements(
    quaternions: ArrayLike,
    accelerations: ArrayLike,
    dt: float,
    errors: ImuErrors,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """What the IMU reads during a known motion.

    Parameters
    ----------
    quaternions : array_like, shape (n, 4)
        True attitudes, unit quaternions (w, x, y, z), body -> map.
    accelerations : array_like, shape (n, 3)  [m/s^2, map]
        True accelerations, without gravity.
    dt : float  [s]
        Time between samples.
    errors : ImuErrors
    rng : numpy.random.Generator

    Returns
    -------
    gyro : ndarray, shape (n, 3)  [rad/s, body]
        Mean rate since the sample before; the first row repeats the second's rate.
    accel : ndarray, shape (n, 3)  [m/s^2, body]

    Raises
    ------
    ValueError
        Wrong shapes or lengths, entries that are not finite, or dt that is not positive.

    Notes
    -----
    The same ``rng`` state and motion give the same numbers to the bit on every machine: the last
    bits, in which library functions differ, vanish in the rounding to the sensor's resolution.
    """
    quaternions = as_floats(quaternions, "quaternions", None, 4)
    n = len(quaternions)
    accelerations = as_floats(accelerations, "accelerations", n, 3)
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    table = error_table(errors, dt)
    noise, out = np.empty((n, NOISES)), np.empty((n, 6))
    noise[:, :3] = rng.standard_normal((n, 3))
    noise[:, 3:6], noise[:, 6:] = rng.standard_normal((2, n, 3))
    read_motion(quaternions, accelerations, float(dt), table, noise, out)
    return out[:, :3].copy(), out[:, 3:].copy()
