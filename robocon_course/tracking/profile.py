"""How fast, where? As fast as the bends, the wheels' grip and the brakes allow.

    v² |κ| <= a_lat              in a bend of curvature κ
    v₁² <= v₀² + 2 a Δs          from one point to the next, and backwards from the end

Both passes are running minima: v² - 2 a s may only fall along the path, v² + 2 a s only rise.

Source: T. Lipp, S. Boyd, Minimum-time speed optimisation over a fixed path, International Journal
of Control 87(6), 2014, section 2 (speed squared as the unknown).
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import distance_along, wrap_angle
from robocon_course.tracking.polyline import as_path


def path_curvature(path: ArrayLike) -> FloatArray:
    """How sharply a path turns at each of its points, from the angle between its segments.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
        The angle at a point is spread over half of each segment beside it: points as far apart as a
        corner may be rounded, so some centimetres. Points that repeat count as one.

    Returns
    -------
    ndarray, shape (n,)  [1/m]
        Positive to the left; 0 at both ends. A way straight back has π by its spread.

    Raises
    ------
    ValueError
        No path.

    Examples
    --------
    A square of 1 m, counter-clockwise: a quarter turn in each metre.

    >>> path_curvature([[0, 0], [1, 0], [1, 1], [0, 1]]).round(3).tolist()
    [0.0, 1.571, 1.571, 0.0]
    """
    path = as_path(path)
    steps = np.diff(path, axis=0)
    lengths = np.hypot(*steps.T)
    moves = np.flatnonzero(lengths)  # segments that lead somewhere
    headings = np.arctan2(steps[moves, 1], steps[moves, 0])
    turns = wrap_angle(np.diff(headings))
    bends = 2.0 * turns / (lengths[moves[:-1]] + lengths[moves[1:]])
    curvature = np.zeros(len(path))
    if len(bends):  # a corner drawn twice or more often bends at each of its copies
        curvature[moves[0] + 1 : moves[-1] + 1] = np.repeat(bends, np.diff(moves))
    return curvature


def speed_profile(
    path: ArrayLike,
    max_speed: float,
    max_accel: float,
    max_lateral_accel: float,
    *,
    start_speed: float = 0.0,
    end_speed: float = 0.0,
) -> FloatArray:
    """The greatest speed at each point of a path that keeps within all limits.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
        Finely drawn: see `path_curvature`.
    max_speed : float  [m/s]
    max_accel : float  [m/s^2]
        Along the path, forwards and when braking.
    max_lateral_accel : float  [m/s^2]
        Across it, in bends.
    start_speed, end_speed : float  [m/s]
        Greatest speed at the two ends; infinity leaves it to the other limits.

    Returns
    -------
    ndarray, shape (n,)  [m/s]
        Between two points v² is a straight line over the way.

    Raises
    ------
    ValueError
        No path, or a limit that is not positive.

    Notes
    -----
    A robot that stands at the start reads a speed of 0 there: the loop has to give it a little more
    (`tracking.CREEP`), or look at a point ahead.

    Examples
    --------
    Two metres from rest to rest with 1 m/s^2: sqrt(2) m/s in the middle.

    >>> speed_profile([[0, 0], [1, 0], [2, 0]], 3.0, 1.0, 1.0).round(3).tolist()
    [0.0, 1.414, 0.0]
    """
    limits = (max_speed, max_accel, max_lateral_accel)
    if not all(limit > 0.0 for limit in limits) or not max_speed + max_accel < inf:
        raise ValueError(
            "max_speed, max_accel, max_lateral_accel: expected numbers above 0, got "
            + ", ".join(map(str, limits))
        )
    if not (start_speed >= 0.0 and end_speed >= 0.0):
        raise ValueError(
            f"start_speed, end_speed: expected m/s from 0 on, got {start_speed} and {end_speed}"
        )
    bend = np.abs(path_curvature(path))
    with np.errstate(divide="ignore"):
        square = np.minimum(max_speed**2, max_lateral_accel / bend)
    square[0] = min(square[0], start_speed**2)
    square[-1] = min(square[-1], end_speed**2)
    gained = 2.0 * max_accel * distance_along(path)  # v₁² <= v₀² + 2 a Δs
    square = np.minimum.accumulate(square - gained) + gained
    square = np.minimum.accumulate((square + gained)[::-1])[::-1] - gained
    return np.sqrt(np.maximum(square, 0.0))


def profile_times(path: ArrayLike, speeds: ArrayLike) -> FloatArray:
    """When a robot that keeps to a profile passes each point.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    speeds : array_like, shape (n,)  [m/s]
        As `speed_profile` gives them: no two neighbours both 0 unless they are one point.

    Returns
    -------
    ndarray, shape (n,)  [s]

    Raises
    ------
    ValueError
        Wrong shapes, a negative speed, or a segment on which nothing moves.

    Examples
    --------
    >>> profile_times([[0, 0], [1, 0], [2, 0]], [0.0, 2.0, 2.0]).tolist()
    [0.0, 1.0, 1.5]
    """
    lengths = np.diff(distance_along(as_path(path)))
    speeds = as_floats(speeds, "speeds", len(lengths) + 1)
    means = 0.5 * (speeds[:-1] + speeds[1:])  # exact: the acceleration is constant between
    if (speeds < 0.0).any() or (means[lengths > 0.0] == 0.0).any():
        raise ValueError("speeds: must not be negative, nor 0 at both ends of a segment")
    steps = np.divide(lengths, means, out=np.zeros_like(lengths), where=lengths > 0.0)
    return np.concatenate([[0.0], np.cumsum(steps)])
