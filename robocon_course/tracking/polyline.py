"""A path is a row of points with straight lines between them. Where on it is the nearest point, and
where is the first one so far away?

The path may cross itself or come back on itself: the search begins at a given segment and gives up
a given length of path after the nearest point so far, so it stays on its branch.

All kernels stand in this file: numba compiles one again only when its own file changes.
"""

from __future__ import annotations

from math import hypot, inf, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats

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
        away = sqrt((x - px) * (x - px) + (y - py) * (y - py))
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
def look(path, x, y, start, lookahead):
    """Nearest point, look-ahead point, and the way between them. It trusts its input.

    Parameters
    ----------
    path : ndarray of float64, shape (n, 2)  [m, map]
    x, y : float  [m, map]
    start : int
        Segment from which the search begins.
    lookahead : float  [m]

    Returns
    -------
    tuple of two tuples and a float
        (segment, share, x, y, distance) of the nearest, (segment, share, x, y) of the look-ahead
        point, metres of path from one to the other.
    """
    foot = nearest(path, x, y, start, lookahead)
    target = ahead(path, x, y, foot[0], foot[1], lookahead)
    return foot, target, length_between(path, foot[0], foot[1], target[0], target[1])


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


def lookahead_point(
    path: ArrayLike, point: ArrayLike, lookahead: float, index: int = 0, share: float = 0.0
) -> PathPoint:
    """The first point of a path that is so far away from a place, searched from a point of it on.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    point : array_like, shape (2,)  [m, map]
    lookahead : float  [m]
        Straight from the place.
    index : int
        Segment from which the search begins.
    share : float
        Of that segment, 0 to 1: as `nearest_point` gives both.

    Returns
    -------
    PathPoint
        Where the search begins if that is as far away already; the end of the path if nothing is.

    Raises
    ------
    ValueError
        No path, a point that is not finite, a look-ahead that is not positive, or a start that is
        not on the path.

    Examples
    --------
    >>> lookahead_point([[0.0, 0.0], [2.0, 0.0]], [0.5, 0.0], 0.75)
    PathPoint(index=0, share=0.625, xy=(1.25, 0.0), distance=0.75)
    """
    path, (x, y) = as_path(path), as_floats(point, "point", 2).tolist()
    check_start(path, int(index))
    if not (0.0 < lookahead < inf and 0.0 <= share <= 1.0):
        raise ValueError(
            f"lookahead, share: expected metres above 0 and a share from 0 to 1, got {lookahead} "
            f"and {share}"
        )
    segment, s, tx, ty = ahead(path, x, y, int(index), float(share), float(lookahead))
    return PathPoint(segment, s, (tx, ty), hypot(tx - x, ty - y))


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
