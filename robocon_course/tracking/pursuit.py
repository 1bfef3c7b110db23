"""Where on the path should I look, and how sharply must I turn to get there?

Pure pursuit drives towards a point of the path a little ahead, on the circle that touches the
robot's heading and leads through that point:

    L = k v + Lfc          how far ahead: farther at speed
    κ = 2 y / d²           target at distance d, y to the left in the robot's frame

The longer the look-ahead L, the gentler the steering, and the more a bend is cut. The point lies on
a segment, not at a waypoint, so it moves smoothly; beyond the last point there is none. The search
begins at the segment found last time (``start_index``), so a path may cross itself.

Source: R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, Carnegie Mellon
University CMU-RI-TR-92-01, 1992 (circle); swerve robot of Yogyakarta State University, 2024
(L = k v + Lfc).
"""

from __future__ import annotations

from math import cos, inf, sin
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.tracking.polyline import as_path, check_start, look

TOLERANCE = 0.01
"""So much of the way may be left at the end [m]."""


class Pursuit(NamedTuple):
    """What pure pursuit says.

    Attributes
    ----------
    curvature : float  [1/m]
        Of the circle to drive on; positive to the left.
    target : tuple of 2 floats  [m, map]
        Look-ahead point.
    index : int
        Segment of the nearest point: the next call's ``start_index``.
    done : bool
        The end is reached: no more of the way is left than the tolerance.
    """

    curvature: float
    target: tuple[float, float]
    index: int
    done: bool


@njit(cache=True)
def bend(dx, dy, theta):
    """Curvature of the circle that touches a heading and leads to a point. It trusts its input.

    Parameters
    ----------
    dx, dy : float  [m, map]
        From the robot to the point.
    theta : float  [rad, map]

    Returns
    -------
    float  [1/m]
    """
    square = dx * dx + dy * dy
    # Coulter 1992: κ = 2 y / d², y to the left of the heading
    return 2.0 * (cos(theta) * dy - sin(theta) * dx) / square if square > 0.0 else 0.0


def pursue(
    path: FloatArray,
    pose: tuple[float, float, float],
    lookahead: float,
    start: int,
    tolerance: float = TOLERANCE,
) -> Pursuit:
    """`pure_pursuit` for loops that count microseconds. It trusts its input.

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    pose : tuple of 3 floats  [m, m, rad; map]
    lookahead : float  [m]
    start : int
    tolerance : float  [m]

    Returns
    -------
    Pursuit
    """
    x, y, theta = pose
    (index, _, _, _, away), (segment, share, tx, ty), way = look(path, x, y, start, lookahead)
    at_end = share == 1.0 and segment == len(path) - 2
    curvature = bend(tx - x, ty - y, theta)
    return Pursuit(curvature, (tx, ty), index, at_end and way <= tolerance and away < lookahead)


def pure_pursuit(
    path: ArrayLike,
    pose: ArrayLike,
    lookahead: float,
    start_index: int = 0,
    *,
    tolerance: float = TOLERANCE,
) -> Pursuit:
    """The circle that leads to the path a little ahead.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
        Two points or more.
    pose : array_like, shape (3,)  [m, m, rad; map]
        Where it is not finite, the answer is not either and the index stays.
    lookahead : float  [m]
        Straight from the robot to the target. Farther off the path than this, the nearest point is
        the target; nearer to the end than this, the end.
    start_index : int
        Segment from which the search begins: ``index`` of the call before.
    tolerance : float  [m]
        How much of the way may be left when it is done.

    Returns
    -------
    Pursuit

    Raises
    ------
    ValueError
        No path, a look-ahead or tolerance that is not positive, or a start beyond the path. Never
        for the pose: this runs in a control loop.

    Notes
    -----
    Coulter 1992. Where the target lies exactly behind the robot, the circle is a straight line away
    from it: whoever steers has to turn the robot first, as the autopilot does with its course.

    A robot that passed the end is done, though it may be up to a look-ahead away: it
    is for the speed to bring it to rest there.

    Examples
    --------
    The path turns left in front of a robot that stands 0.6 m before the corner.

    >>> found = pure_pursuit([[0, 0], [1, 0], [1, 2]], [0.4, 0.0, 0.0], 1.0)
    >>> found.target[0], round(found.target[1], 6), round(found.curvature, 6), found.index
    (1.0, 0.8, 1.6, 0)
    """
    path, pose, start = as_path(path), as_floats(pose, "pose", 3, finite=False), int(start_index)
    if not (0.0 < lookahead < inf and 0.0 <= tolerance < inf):
        raise ValueError(
            f"lookahead, tolerance: expected metres above 0, got {lookahead} and {tolerance}"
        )
    check_start(path, start)
    if not np.isfinite(pose).all():
        return Pursuit(np.nan, (np.nan, np.nan), start, False)
    return pursue(path, tuple(pose.tolist()), float(lookahead), start, float(tolerance))


def lookahead_distance(speed: ArrayLike, k: float, least: float) -> FloatArray:
    """How far ahead to look at a speed: Lf = k v + Lfc.

    Parameters
    ----------
    speed : array_like  [m/s]
        Backwards counts as forwards.
    k : float  [s]
    least : float  [m]
        Lfc: what is left at rest.

    Returns
    -------
    ndarray or float  [m]

    Raises
    ------
    ValueError
        k negative, or the least distance not positive.

    Notes
    -----
    As printed for the swerve robot of Yogyakarta State University, 2024. A longer look-ahead makes
    the steering gentler, not more aggressive as the text beside it says.

    Examples
    --------
    >>> float(lookahead_distance(1.0, k=0.25, least=0.125))
    0.375
    """
    if not (0.0 <= k < inf and 0.0 < least < inf):
        raise ValueError(
            f"k, least: expected seconds from 0 on and metres above 0, got {k} and {least}"
        )
    return k * np.abs(speed) + least
