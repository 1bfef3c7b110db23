"""From a velocity on the field to four modules, in one compiled step.

`field_to_robot`, `discretize`, `module_targets`, `limit_speeds`, `shortest_turn` and
`cosine_compensation` one after the other, for a loop in which their checks would take most of the
time. A test holds it to them.
"""

from __future__ import annotations

from math import copysign, cos, pi, sin, tan

import numpy as np
from numba import njit

from robocon_course._arrays import FloatArray
from robocon_course.swerve.modules import fill_targets


@njit(cache=True)
def field_command(positions, twist, theta, now, dt, max_speed, speeds, angles):
    """What the modules are told; it trusts its input.

    Parameters
    ----------
    positions : ndarray, shape (m, 2)  [m, base]
    twist : ndarray, shape (3,)  [m/s, m/s, rad/s; map]
    theta : float  [rad, map]
    now : ndarray, shape (m,)  [rad, base]
        Where the modules point.
    dt : float  [s]
    max_speed : float  [m/s]
    speeds, angles : ndarray, shape (m,)  [m/s, rad; base]
        Filled.
    """
    c, s = cos(theta), sin(theta)
    vx, vy, omega = c * twist[0] + s * twist[1], c * twist[1] - s * twist[0], twist[2]
    half = 0.5 * omega * dt
    # The twist that ends there: half a turn back, and along the chord (Solà 2018, equation 157).
    along = half / tan(half) if half != 0.0 else 1.0
    body = np.array([[along * vx + half * vy, along * vy - half * vx, omega]])
    fill_targets(positions, body, now.reshape(1, -1), speeds.reshape(1, -1), angles.reshape(1, -1))
    fastest = np.abs(speeds).max()
    for i in range(len(now)):
        if fastest > max_speed:
            speeds[i] = speeds[i] / fastest * max_speed
        turn = np.fmod(angles[i] - now[i], 2.0 * pi)
        turn = turn - 2.0 * pi * (turn >= pi) + 2.0 * pi * (turn < -pi)
        if abs(turn) > 0.5 * pi:
            turn, speeds[i] = turn - copysign(pi, turn), -speeds[i]
        angles[i] = now[i] + turn
        speeds[i] *= cos(turn)


def field_targets(
    positions: FloatArray, twist: FloatArray, theta: float, now: FloatArray, dt: float, most: float
) -> tuple[FloatArray, FloatArray]:
    """Speeds and angles of `field_command`, in arrays of their own; it trusts its input.

    Parameters
    ----------
    positions : ndarray of float64, shape (m, 2)  [m, base]
    twist : ndarray of float64, shape (3,)  [m/s, m/s, rad/s; map]
    theta : float  [rad, map]
    now : ndarray of float64, shape (m,)  [rad, base]
    dt : float  [s]
    most : float  [m/s]
        Top speed.

    Returns
    -------
    speeds, angles : ndarray, shape (m,)  [m/s, rad; base]
    """
    speeds, angles = np.empty(len(now)), np.empty(len(now))
    field_command(positions, twist, theta, now, dt, most, speeds, angles)
    return speeds, angles
