"""The kernels of a trial: the cart, its odometry, and what leads it along a path.

They compile in those of `differential`, `polyline` and `pursuit`: after an edit there, touch this
file.
"""

from __future__ import annotations

from math import floor, isnan, sqrt

import numpy as np
from numba import njit

from robocon_course.tracking.along import REACH
from robocon_course.tracking.differential import DT, near, roll, share_out
from robocon_course.tracking.polyline import look, nearest
from robocon_course.tracking.pursuit import bend

CREEP = 0.03
"""Slowest speed short of the end [m/s]: at its ends a profile says 0."""
ARRIVED = 0.003
"""So much of the path may be left at the end [m]."""
REST = 60  # samples in which it comes to rest after the end


@njit(cache=True)
def advance(now, speed, turn, sizes):
    """The robot and its odometry 10 ms later, in place. It trusts its input.

    Parameters
    ----------
    now : ndarray, shape (12,)
        Pose, pose by odometry [m, m, rad], and for both wheels speed [m/s], way [m] and the order
        that waits [m/s].
    speed, turn : float  [m/s, rad/s]
    sizes : tuple of 4 floats  [m, m, s, m/s]
        Wheel base, metres per tick, lag, top speed.
    """
    base, per_tick, lag, top = sizes
    now[6], left = near(now[6], now[10], DT, lag)
    now[7], right = near(now[7], now[11], DT, lag)
    now[10], now[11] = share_out(speed, turn, base, top)
    now[0], now[1], now[2] = roll(now[0], now[1], now[2], left, right, base)
    before_left, before_right = floor(now[8] / per_tick), floor(now[9] / per_tick)
    now[8] += left
    now[9] += right
    left = per_tick * (floor(now[8] / per_tick) - before_left)
    right = per_tick * (floor(now[9] / per_tick) - before_right)
    now[3], now[4], now[5] = roll(now[3], now[4], now[5], left, right, base)


@njit(cache=True)
def follow(path, squares, lookahead, sizes, late, noise, out):
    """Drive along a path; rows of ``out`` take pose, target and speed. It trusts its input.

    Parameters
    ----------
    path : ndarray, shape (n, 2)  [m, map]
    squares : ndarray, shape (n,)  [m²/s²]
        Speed of the profile, squared.
    lookahead : tuple of 2 floats  [s, m]
        k and least.
    sizes : tuple of 4 floats
        As in `advance`.
    late : int
        Age of the pose that the loop sees [samples].
    noise : ndarray, shape (m, 3)  [m, m, rad]
        On that pose; NaN: none came.
    out : ndarray, shape (m, 6)
        Row 0 holds the first pose.

    Returns
    -------
    tuple of 2 ints
        Rows filled; the row in which the end was reached, or -1.
    """
    now = np.zeros(12)
    now[0:3] = now[3:6] = out[0, 0:3]
    tx, ty, index, speed, turn, end = out[0, 0], out[0, 1], 0, 0.0, 0.0, -1
    believed = np.empty((len(noise), 3))
    for k in range(len(noise)):
        believed[k] = now[3:6]
        seen = believed[max(k - late, 0)] + noise[k]
        px, py = seen[0], seen[1]
        if end >= 0:
            speed = turn = 0.0
        elif not isnan(px):
            here = nearest(path, px, py, index, REACH)
            i, gained = here[0], squares[here[0] + 1] - squares[here[0]]
            speed = max(sqrt(squares[i] + here[1] * gained), CREEP)
            reach = lookahead[0] * speed + lookahead[1]
            foot, target, way = look(path, px, py, i, reach)
            index, tx, ty = foot[0], target[2], target[3]
            turn = speed * bend(tx - px, ty - py, seen[2])
            if target[0] == len(path) - 2 and target[1] == 1.0 and way <= ARRIVED:
                end, speed, turn = k, 0.0, 0.0
        out[k, 0:3] = now[0:3]
        out[k, 3], out[k, 4], out[k, 5] = tx, ty, speed
        if end >= 0 and k == end + REST:
            return k + 1, end
        advance(now, speed, turn, sizes)
    return len(noise), end
