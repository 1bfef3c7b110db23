"""Which way is up, and by which angles is the body turned?

With the attitude q (body -> map) and R(q) its rotation matrix:

    up in body axes      v = third row of R(q)      what an accelerometer at rest reads, over g
    tilt from gravity    roll = atan2(a_y, a_z),    pitch = atan2(-a_x, sqrt(a_y^2 + a_z^2))

Yaw is a turn about gravity itself, so no accelerometer can see it.

Source: J. Kuipers, Quaternions and Rotation Sequences, Princeton 1999, chapter 7; the tilt:
M. Pedley, Tilt Sensing Using a Three-Axis Accelerometer, Freescale AN3461, 2013, equations 25, 26.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_vectors
from robocon_course.geometry import quaternion_from_euler


def attitude_from_accel(accel: ArrayLike) -> FloatArray:
    """Tilt that an accelerometer at rest shows; yaw is 0, since gravity does not show it.

    Parameters
    ----------
    accel : array_like, shape (..., 3)  [any unit, body]
        What the sensor reads: the axis that points up reads positive.

    Returns
    -------
    ndarray, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map; NaN where the sample has no direction.

    Raises
    ------
    ValueError
        The last axis is not 3 long.
    """
    accel = as_vectors(accel, "accel", 3)
    x, y, z = np.moveaxis(np.where(has_direction(accel)[..., None], accel, np.nan), -1, 0)
    return quaternion_from_euler(np.arctan2(y, z), np.arctan2(-x, np.hypot(y, z)), 0.0)


def gravity_direction(quaternion: ArrayLike) -> FloatArray:
    """Up, seen from the body: what an accelerometer at rest reads, divided by g.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map.

    Returns
    -------
    ndarray, shape (..., 3)  [body]
        Unit vectors: the third row of R(q).

    Raises
    ------
    ValueError
        The last axis is not 4 long.

    Notes
    -----
    All three are full components. Printed recipes that mix w^2 - 1/2 + z^2 (half of the third)
    with two full ones settle at tan(estimate) = tan(true)/2.
    """
    w, x, y, z = np.moveaxis(as_vectors(quaternion, "quaternion", 4), -1, 0)
    up = [2.0 * (x * z - w * y), 2.0 * (w * x + y * z), w * w - x * x - y * y + z * z]
    return np.stack(up, axis=-1)


def euler_angles(quaternion: ArrayLike) -> FloatArray:
    """Roll, pitch and yaw (Z-Y-X: first yaw, then pitch about the new y, then roll).

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map.

    Returns
    -------
    ndarray, shape (..., 3)  [rad]
        Roll and yaw in [-pi, pi], pitch in [-pi/2, pi/2]. With the nose straight up or down
        roll and yaw turn about one axis, and only their sum or difference means anything.

    Raises
    ------
    ValueError
        The last axis is not 4 long.
    """
    w, x, y, z = np.moveaxis(as_vectors(quaternion, "quaternion", 4), -1, 0)
    roll = np.arctan2(2.0 * (w * x + y * z), w * w - x * x - y * y + z * z)
    pitch = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
    yaw = np.arctan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
    return np.stack([roll, pitch, yaw], axis=-1)


def inclination_error(estimated: ArrayLike, truth: ArrayLike) -> FloatArray:
    """Angle between the two up-directions: the error that gravity can mend, yaw left aside.

    Parameters
    ----------
    estimated, truth : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map.

    Returns
    -------
    ndarray, shape (...)  [rad]
        In [0, pi]; NaN where either is NaN.

    Raises
    ------
    ValueError
        The last axis is not 4 long.
    """
    a, b = gravity_direction(estimated), gravity_direction(truth)
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))


def has_direction(accel: FloatArray) -> FloatArray:
    """Which samples point somewhere: finite and not zero.

    Parameters
    ----------
    accel : ndarray, shape (..., 3)  [any unit, body]

    Returns
    -------
    ndarray of bool, shape (...)
    """
    largest = np.abs(accel).max(axis=-1)
    return (largest > 0.0) & (largest < inf)
