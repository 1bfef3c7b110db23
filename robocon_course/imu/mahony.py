"""The Mahony filter: turns from the gyroscope, pulled gently towards the accelerometer's gravity.

With q the attitude (body -> map), a the accelerometer, w the gyroscope, both in body axes:

    v  = third row of R(q)                  where up should be, seen from the body
    e  = a/|a| x v                          how far it is off: axis times sine of the angle
    b' = k_i e                              slow part: learns the gyroscope's bias (sign reversed)
    q' = 1/2 q ⊗ (0, w + k_p e + b)         fast part: the gyroscope, pulled towards gravity

A tilt error dies out as exp(-k_p t). Yaw is never corrected, gravity does not show it.

Source: R. Mahony, T. Hamel, J.-M. Pflimlin, Nonlinear Complementary Filters on the Special
Orthogonal Group, IEEE Transactions on Automatic Control 53(5), 2008, equations 48a to 48c.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import GRAVITY


class MahonyGains(NamedTuple):
    """How strongly the accelerometer pulls.

    Attributes
    ----------
    k_p : float  [1/s]
        A tilt error fades with the time constant 1/k_p, and a gyroscope's bias b leaves a tilt
        of b/k_p. Two seconds average over a push and the braking that follows it; a calibrated
        gyroscope, off by 0.02 deg/s, then costs 0.04 deg.
    k_i : float  [1/s^2]
        Learning rate of the bias; 0 leaves it to `calibrate_gyro`, which does not confuse a long
        push with a bias.
    gate : float  [m/s^2]
        Samples whose norm differs from 9.80665 by more are not used to correct: they are a push,
        not gravity. Infinity uses them all, and allows accelerometers in any unit.
    """

    k_p: float = 0.5
    k_i: float = 0.0
    gate: float = inf


class MahonyState(NamedTuple):
    """All the filter remembers between two samples.

    Attributes
    ----------
    quaternion : ndarray, shape (4,)
        Unit quaternion (w, x, y, z), body -> map.
    integral : ndarray, shape (3,)  [rad/s, body]
        What the filter adds to the gyroscope: its bias with the sign reversed.
    """

    quaternion: FloatArray
    integral: FloatArray

    @classmethod
    def level(cls) -> MahonyState:
        """Flat on the ground, x axis along the map's, nothing learnt yet."""
        return cls(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))


@njit(cache=True)
def mahony_update(
    state: FloatArray,
    gyro: FloatArray,
    accel: FloatArray,
    dt: float,
    k_p: float,
    k_i: float,
    gate: float,
) -> bool:
    """One Mahony step on ``state`` = (w, x, y, z, ix, iy, iz), in place; was the sample used?

    The kernel behind `mahony_step`, `AttitudeFilter` and `estimate_attitude`, for loops that
    count nanoseconds. It trusts its input.

    Parameters
    ----------
    state : ndarray of float64, shape (7,)  [-, rad/s]
        Quaternion and integral; left alone when the result would not be finite.
    gyro : ndarray of float64, shape (3,)  [rad/s, body]
    accel : ndarray of float64, shape (3,)  [m/s^2, body]
    dt : float  [s]
    k_p, k_i, gate : float  [1/s, 1/s^2, m/s^2]
        As in `MahonyGains`.

    Returns
    -------
    bool
    """
    w, x, y, z = state[0], state[1], state[2], state[3]
    ix, iy, iz = state[4], state[5], state[6]
    wx, wy, wz = gyro[0], gyro[1], gyro[2]
    ax, ay, az = accel[0], accel[1], accel[2]
    norm = sqrt(ax * ax + ay * ay + az * az)
    used = 0.0 < norm < inf and abs(norm - GRAVITY) <= gate
    if used:
        ax, ay, az = ax / norm, ay / norm, az / norm
        # v = third row of R(q): up, as the body should see it
        vx = 2.0 * (x * z - w * y)
        vy = 2.0 * (w * x + y * z)
        vz = w * w - x * x - y * y + z * z
        # e = a x v
        ex = ay * vz - az * vy
        ey = az * vx - ax * vz
        ez = ax * vy - ay * vx
        # After a gap one sample may at most settle the tilt, and teach the bias for a second.
        k_p = min(k_p, 1.0 / dt) if dt > 0.0 else k_p
        k_i *= min(dt, 1.0)
        ix += k_i * ex
        iy += k_i * ey
        iz += k_i * ez
        wx, wy, wz = wx + k_p * ex, wy + k_p * ey, wz + k_p * ez
    # q + 1/2 q ⊗ (0, rate) dt, then back to length 1
    hx, hy, hz = 0.5 * dt * (wx + ix), 0.5 * dt * (wy + iy), 0.5 * dt * (wz + iz)
    qw = w - x * hx - y * hy - z * hz
    qx = x + w * hx + y * hz - z * hy
    qy = y + w * hy - x * hz + z * hx
    qz = z + w * hz + x * hy - y * hx
    norm = sqrt(qw * qw + qx * qx + qy * qy + qz * qz)
    if not 0.0 < norm < inf:  # a gyroscope that says NaN or infinity ends here
        return False
    state[0], state[1], state[2], state[3] = qw / norm, qx / norm, qy / norm, qz / norm
    state[4], state[5], state[6] = ix, iy, iz
    return used


@njit(cache=True)
def mahony_run(memory, gyro, accel, dt, k_p, k_i, gate, out):
    """`mahony_update` over all rows into ``out``; how many samples were not fully used.

    It stands beside the kernel it compiles in: numba looks only here for changes.

    Parameters
    ----------
    memory : ndarray, shape (7,)
        As in `mahony_update`; changed in place.
    gyro : ndarray, shape (n, 3)  [rad/s, body]
    accel : ndarray, shape (n, 3)  [m/s^2, body]
    dt : ndarray, shape (n,)  [s]
    k_p : float  [1/s]
    k_i : float  [1/s^2]
    gate : float  [m/s^2]
    out : ndarray, shape (n, 4)
        Takes the attitude after each row.

    Returns
    -------
    int
    """
    state = memory.copy()  # numba aligns it; numpy's may straddle two cache lines, a fifth slower
    rejected = 0
    for k in range(len(gyro)):
        if not mahony_update(state, gyro[k], accel[k], dt[k], k_p, k_i, gate):
            rejected += 1
        for j in range(4):  # four stores; a slice assignment takes half as long again
            out[k, j] = state[j]
    memory[:] = state
    return rejected


def mahony_step(
    state: MahonyState,
    gyro: ArrayLike,
    accel: ArrayLike,
    dt: float,
    gains: MahonyGains = MahonyGains(),  # noqa: B008 - a NamedTuple cannot change
) -> MahonyState:
    """Attitude after one more sample of gyroscope and accelerometer.

    Parameters
    ----------
    state : MahonyState
        Attitude before; it is left as it is.
    gyro : array_like, shape (3,)  [rad/s, body]
        A value that is not finite leaves the attitude as it was.
    accel : array_like, shape (3,)  [m/s^2, body]
        What the sensor reads: +9.8 on the axis that points up. Zero, not finite or outside the
        gate: the gyroscope alone moves the attitude.
    dt : float  [s]
        Time since the sample before.
    gains : MahonyGains

    Returns
    -------
    MahonyState

    Raises
    ------
    ValueError
        Wrong shape, dt or gains. Never for a sensor value: this runs in a control loop.

    Notes
    -----
    Mahony 2008, equations 48a to 48c, one Euler step. ``k_p`` multiplies the full cross product.

    Examples
    --------
    >>> state = MahonyState.level()
    >>> for _ in range(100):
    ...     state = mahony_step(state, [0.0, 0.0, 0.5], [0.0, 0.0, 9.8], 0.01)
    >>> state.quaternion.round(3).tolist()
    [0.969, 0.0, 0.0, 0.247]
    """
    after = as_memory(state)
    gyro, accel = (
        as_floats(gyro, "gyro", 3, finite=False),
        as_floats(accel, "accel", 3, finite=False),
    )
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    mahony_update(after, gyro, accel, float(dt), *checked_gains(gains))
    return MahonyState(after[:4], after[4:])


def checked_gains(gains: MahonyGains) -> tuple[float, float, float]:
    """The gains as the floats the kernel takes.

    Parameters
    ----------
    gains : MahonyGains

    Returns
    -------
    tuple of 3 floats

    Raises
    ------
    ValueError
        Negative or NaN.
    """
    k_p, k_i, gate = gains
    if not (0.0 <= k_p < inf and 0.0 <= k_i < inf and gate >= 0.0):
        raise ValueError(f"gains: k_p, k_i and gate must not be negative or NaN, got {gains}")
    return float(k_p), float(k_i), float(gate)


def as_memory(state: MahonyState) -> FloatArray:
    """The state as the one array that the kernel updates; a copy.

    Parameters
    ----------
    state : MahonyState

    Returns
    -------
    ndarray, shape (7,)

    Raises
    ------
    ValueError
        Wrong shape.
    """
    memory = np.empty(7)
    memory[:4] = as_floats(state[0], "state.quaternion", 4, finite=False)
    memory[4:] = as_floats(state[1], "state.integral", 3, finite=False)
    return memory
