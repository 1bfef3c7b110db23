"""Attitudes in three dimensions as unit quaternions.

A unit quaternion q = (w, x, y, z) turns a vector from body axes into map axes:

    v_map = q ⊗ (0, v_body) ⊗ q*        a ⊗ b: first turn by b, then by a

so T_map_imu ⊗ T_imu_camera = T_map_camera, inner names cancelling. Frames follow REP-103:
x forward, y left, z up, counter-clockwise positive. All functions work on the last axis of arrays
of any depth and broadcast over the others; a hole in a log (NaN) stays a hole in the result.

Source: J. Kuipers, Quaternions and Rotation Sequences, Princeton 1999, chapters 5 to 7.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_vectors


def quaternion_multiply(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Product a ⊗ b: the turn ``b`` followed by the turn ``a``.

    Parameters
    ----------
    a, b : array_like, shape (..., 4)
        Quaternions (w, x, y, z).

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    ValueError
        The last axis is not 4 long.

    Notes
    -----
    Kuipers 1999, section 5.4 (Hamilton's rule i j = k).
    """
    aw, ax, ay, az = np.moveaxis(as_vectors(a, "a", 4), -1, 0)
    bw, bx, by, bz = np.moveaxis(as_vectors(b, "b", 4), -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def quaternion_conjugate(q: ArrayLike) -> FloatArray:
    """The turn back: T_map_body -> T_body_map.

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    ndarray, shape (..., 4)

    Raises
    ------
    ValueError
        The last axis is not 4 long.
    """
    return as_vectors(q, "q", 4) * np.array([1.0, -1.0, -1.0, -1.0])


def rotate(q: ArrayLike, v: ArrayLike) -> FloatArray:
    """Vector given in body axes, as seen in map axes.

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map.
    v : array_like, shape (..., 3)  [any unit, body]

    Returns
    -------
    ndarray, shape (..., 3)  [same unit, map]

    Raises
    ------
    ValueError
        A last axis is not 4 (``q``) or 3 (``v``) long.

    Examples
    --------
    >>> rotate(quaternion_from_euler(0.0, 0.0, np.pi / 2), [1.0, 0.0, 0.0]).round(3).tolist()
    [0.0, 1.0, 0.0]
    """
    q = as_vectors(q, "q", 4)
    v = as_vectors(v, "v", 3)
    w, axis = q[..., :1], q[..., 1:]
    twice = 2.0 * np.cross(axis, v)
    return v + w * twice + np.cross(axis, twice)


def quaternion_from_euler(roll: ArrayLike, pitch: ArrayLike, yaw: ArrayLike) -> FloatArray:
    """Quaternion of the turns yaw about z, then pitch about the new y, then roll about the new x.

    Parameters
    ----------
    roll, pitch, yaw : array_like, shape (...)  [rad]
        Roll lowers the right side, pitch lowers the nose, yaw turns to the left.

    Returns
    -------
    ndarray, shape (..., 4)
        Unit quaternions (w, x, y, z), body -> map.

    Notes
    -----
    Kuipers 1999, section 7.3 (aerospace sequence Z-Y-X).
    """
    halves = [np.asarray(angle, dtype=np.float64) / 2.0 for angle in (roll, pitch, yaw)]
    cr, cp, cy = (np.cos(half) for half in halves)
    sr, sp, sy = (np.sin(half) for half in halves)
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def quaternion_from_rotation_vector(v: ArrayLike) -> FloatArray:
    """Quaternion of a turn about the axis ``v`` by the angle ``|v|``.

    Parameters
    ----------
    v : array_like, shape (..., 3)  [rad]

    Returns
    -------
    ndarray, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Raises
    ------
    ValueError
        The last axis is not 3 long.
    """
    v = as_vectors(v, "v", 3)
    half = np.linalg.norm(v, axis=-1, keepdims=True) / 2.0
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * v], axis=-1)


def rotation_vector(q: ArrayLike) -> FloatArray:
    """Axis times angle of a turn, the shorter way round: the inverse of the function above.

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z); q and -q are the same turn.

    Returns
    -------
    ndarray, shape (..., 3)  [rad]
        At most pi long.

    Raises
    ------
    ValueError
        The last axis is not 4 long.
    """
    q = as_vectors(q, "q", 4)
    q = np.where(q[..., :1] < 0.0, -q, q)
    half = np.arctan2(np.linalg.norm(q[..., 1:], axis=-1, keepdims=True), q[..., :1])
    return 2.0 * q[..., 1:] / np.sinc(half / np.pi)
