"""Where on the path am I, where should I look, and how sharply must I turn to get there?

Pure pursuit drives towards a point of the path a little ahead, on the circle that touches the
robot's heading and leads through that point:

    L = k v + Lfc          how far ahead: farther at speed
    κ = 2 y / d²           target at distance d, y to the left in the robot's frame

The longer the look-ahead L, the gentler the steering, and the more a bend is cut. The point lies on
a segment, not at a waypoint, so it moves smoothly; beyond the last point there is none.

The path may cross itself: the search begins at the segment found last time (``start_index``) and
gives up one look-ahead after the nearest point so far, so it stays on its branch.

Source: R. C. Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, Carnegie Mellon
University CMU-RI-TR-92-01, 1992 (circle); swerve robot of Yogyakarta State University, 2024
(L = k v + Lfc).
"""

from __future__ import annotations

from math import cos, hypot, inf, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats

TOLERANCE = 0.01
"""So much of the way may be left at the end [m]."""
_TIE = 1e-9  # metres by which a point must be nearer: on a way out and back both legs are as near


class PathPoint(NamedTuple):
    """A point on a path.

    Attributes
    ----------
    index : int
        Segment it lies on: from point ``index`` to point ``index + 1``.
    share : float
        Of that segment, 0 at its beginning to 1 at its end.
    xy : tuple of 2 floats  [m, map]
    distance : float  [m]
        From the point that was asked for.
    """

    index: int
    share: float
    xy: tuple[float, float]
    distance: float


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
def nearest(path, x, y, start, reach):
    """Nearest point of a path from segment ``start`` on: (segment, share, x, y, distance).

    The search gives up ``reach`` metres of path after the nearest point so far. It trusts its
    input.

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    x, y : float  [m, map]
    start : int
        From 0 to n - 2.
    reach : float  [m]

    Returns
    -------
    tuple of (int, float, float, float, float)
    """
    index, share, best_x, best_y, best = start, 0.0, path[start, 0], path[start, 1], np.inf
    walked = 0.0  # since the nearest point so far
    for k in range(start, len(path) - 1):
        ax, ay = path[k, 0], path[k, 1]
        dx, dy = path[k + 1, 0] - ax, path[k + 1, 1] - ay
        square = dx * dx + dy * dy
        s = ((x - ax) * dx + (y - ay) * dy) / square if square > 0.0 else 0.0
        s = min(max(s, 0.0), 1.0)
        px, py = ax + s * dx, ay + s * dy
        away = hypot(x - px, y - py)
        if away < best - _TIE:
            index, share, best_x, best_y, best = k, s, px, py, away
            walked = (1.0 - s) * sqrt(square)
        else:
            walked += sqrt(square)
        if walked > reach:
            break
    return index, share, best_x, best_y, best


@njit(cache=True)
def ahead(path, x, y, index, share, lookahead):
    """First point at distance ``lookahead`` from (x, y), from a point of the path on.

    That point itself if it is as far away, the end of the path if nothing is. It trusts its input.

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    x, y : float  [m, map]
    index, share : int, float
        Segment and share of the point of the path.
    lookahead : float  [m]

    Returns
    -------
    tuple of (int, float, float, float)
        Segment, share, x, y.
    """
    last = len(path) - 2
    for k in range(index, last + 1):
        ax, ay = path[k, 0], path[k, 1]
        dx, dy = path[k + 1, 0] - ax, path[k + 1, 1] - ay
        s = share if k == index else 0.0
        if hypot(ax + dx - x, ay + dy - y) < lookahead:
            continue
        # |a + s d - p| = L: from inside the circle a straight line leaves it once, at the larger s.
        ex, ey = ax + s * dx - x, ay + s * dy - y
        c = ex * ex + ey * ey - lookahead * lookahead
        if c < 0.0:
            a, b = dx * dx + dy * dy, ex * dx + ey * dy
            s = min(s - c / (b + sqrt(b * b - a * c)), 1.0)
        return k, s, ax + s * dx, ay + s * dy
    return last, 1.0, path[last + 1, 0], path[last + 1, 1]


@njit(cache=True)
def length_between(path, index, share, until, until_share):
    """Length of path from one of its points to a later one [m].

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    index, share : int, float
        Segment and share of the first point.
    until, until_share : int, float
        Of the second.

    Returns
    -------
    float
    """
    total = 0.0
    for k in range(index, until + 1):
        length = hypot(path[k + 1, 0] - path[k, 0], path[k + 1, 1] - path[k, 1])
        begin = share if k == index else 0.0
        end = until_share if k == until else 1.0
        total += (end - begin) * length
    return total


@njit(cache=True)
def pursue(path, x, y, theta, lookahead, start, tolerance):
    """The kernel behind `pure_pursuit`: (curvature, x, y, index, done). It trusts its input.

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    x, y, theta : float  [m, m, rad; map]
    lookahead : float  [m]
    start : int
    tolerance : float  [m]

    Returns
    -------
    tuple of (float, float, float, int, bool)
    """
    index, share, _, _, away = nearest(path, x, y, start, lookahead)
    segment, s, tx, ty = ahead(path, x, y, index, share, lookahead)
    at_end = segment == len(path) - 2 and s == 1.0
    done = (
        at_end and away < lookahead and length_between(path, index, share, segment, s) <= tolerance
    )
    dx, dy = tx - x, ty - y
    square = dx * dx + dy * dy
    left = cos(theta) * dy - sin(theta) * dx
    # Coulter 1992: κ = 2 y / d²
    curvature = 2.0 * left / square if square > 0.0 else 0.0
    return curvature, tx, ty, index, done


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
    Coulter 1992. A robot that passed the end is done, though it may be up to a look-ahead away: it
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
    x, y, theta = pose.tolist()
    if not np.isfinite(pose).all():
        return Pursuit(np.nan, (np.nan, np.nan), start, False)
    curvature, tx, ty, index, done = pursue(
        path, x, y, theta, float(lookahead), start, float(tolerance)
    )
    return Pursuit(curvature, (tx, ty), index, done)


def nearest_point(
    path: ArrayLike, point: ArrayLike, start_index: int = 0, reach: float = inf
) -> PathPoint:
    """The point of a path that is nearest to a place.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    point : array_like, shape (2,)  [m, map]
    start_index : int
        Segment from which the search begins.
    reach : float  [m]
        The search gives up so much of the path after the nearest point so far; infinity: it looks
        at the whole path.

    Returns
    -------
    PathPoint

    Raises
    ------
    ValueError
        No path, a point that is not finite, a reach that is not positive, or a start beyond the
        path.

    Examples
    --------
    >>> nearest_point([[0.0, 0.0], [2.0, 0.0]], [0.5, 0.25])
    PathPoint(index=0, share=0.25, xy=(0.5, 0.0), distance=0.25)
    """
    path, (x, y) = as_path(path), as_floats(point, "point", 2).tolist()
    check_start(path, int(start_index))
    if not reach > 0.0:
        raise ValueError(f"reach: expected metres above 0, got {reach}")
    index, share, px, py, away = nearest(path, x, y, int(start_index), float(reach))
    return PathPoint(index, share, (px, py), away)


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


def as_path(path: ArrayLike) -> FloatArray:
    """A path as an array of two points or more, or a refusal.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    ndarray, shape (n, 2)  [m, map]

    Raises
    ------
    ValueError
        Another shape, an entry that is not finite, or fewer than two points.
    """
    path = as_floats(path, "path", None, 2)
    if len(path) < 2:
        raise ValueError(f"path: expected two points or more, got {len(path)}")
    return path


def check_start(path: FloatArray, start: int) -> None:
    """Refuse a segment that the path does not have.

    Parameters
    ----------
    path : ndarray, shape (n, 2)
    start : int

    Raises
    ------
    ValueError
    """
    if not 0 <= start <= len(path) - 2:
        raise ValueError(
            f"start_index: a path of {len(path)} points has the segments 0 to {len(path) - 2}, "
            f"got {start}"
        )
