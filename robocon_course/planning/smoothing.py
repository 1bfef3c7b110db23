"""A way without kinks: nowhere does it bend more than a limit.

The bend at point i is the curvature of the circle through it and its neighbours,

    κ_i = 2 |a × b| / (|a| |b| |a + b|),    a = p_i - p_(i-1),  b = p_(i+1) - p_i

Where it is too large, p_i is pushed inwards and both neighbours half as much outwards, in
proportion to p_(i-1) - 2 p_i + p_(i+1). Nothing is pushed out of its neighbours' sight. So the way
swings out before a corner that it cannot cut.

Source: C. Thorpe, Path Relaxation: Path Planning for a Mobile Robot, AAAI 1984; M. Müller,
B. Heidelberger, M. Hennix, J. Ratcliff, Position Based Dynamics, Journal of Visual Communication
and Image Representation 18(2), 2007, section 3.3, for the size of a push.
"""

from __future__ import annotations

from math import hypot, inf

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray
from robocon_course.gridmap import GridMap
from robocon_course.planning.path import as_path, as_positive, subdivided
from robocon_course.planning.plans import NoPathError, inflated
from robocon_course.planning.sight import in_cells, in_sight

# numba looks for changes only in this file: after one of `in_sight`, save this one too.
SWEEPS = 20_000
HASTE = 1.5  # times the push that one bend alone would need; from 2 on nothing settles


@njit(cache=True)
def bend(points, i):
    """Curvature of the circle through point i and its neighbours [1/cell]; 0 where two coincide.

    Parameters
    ----------
    points : ndarray, shape (n, 2)  [cells]
    i : int
        Neither the first nor the last.

    Returns
    -------
    float
        Where the way turns by more than a right angle, 2 over the chord, which is more than the
        circle's: that would call a turn back on itself straight. Infinity for that.
    """
    ax, ay = points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1]
    bx, by = points[i + 1, 0] - points[i, 0], points[i + 1, 1] - points[i, 1]
    sides = hypot(ax, ay) * hypot(bx, by)
    if sides == 0.0:
        return 0.0
    chord = hypot(ax + bx, ay + by)
    if chord == 0.0:
        return inf
    if ax * bx + ay * by < 0.0:
        return 2.0 / chord
    return 2.0 * abs(ax * by - ay * bx) / (sides * chord)


@njit(cache=True)
def push(free, points, i, dx, dy):
    """Move a point that is no end, unless a neighbour would lose it from sight.

    Parameters
    ----------
    free : ndarray of bool, shape (rows, cols)
    points : ndarray, shape (n, 2)  [cells]
        Changed in place.
    i : int
    dx, dy : float  [cells]
    """
    if not 0 < i < len(points) - 1:
        return
    x, y = points[i, 0] + dx, points[i, 1] + dy
    if in_sight(free, points[i - 1, 0], points[i - 1, 1], x, y) and in_sight(
        free, x, y, points[i + 1, 0], points[i + 1, 1]
    ):
        points[i, 0], points[i, 1] = x, y


@njit(cache=True)
def relax(free, points, limit, sweeps):
    """Push points, again and again, until nothing bends more than the limit.

    Parameters
    ----------
    free : ndarray of bool, shape (rows, cols)
    points : ndarray, shape (n, 2)  [cells]
        Changed in place.
    limit : float  [1/cell]
    sweeps : int
        Passes over all points at most.

    Returns
    -------
    (float, int)
        Greatest bend that is left, and the number of its point.
    """
    for sweep in range(sweeps + 1):
        worst, where = 0.0, 0
        for i in range(1, len(points) - 1):
            kappa = bend(points, i)
            if kappa > worst:
                worst, where = kappa, i
        if worst <= limit or sweep == sweeps:
            break
        for i in range(1, len(points) - 1):
            kappa = bend(points, i)
            if kappa > 0.98 * limit:  # a little more than necessary, or it would never end
                share = HASTE * (1.0 - 0.95 * limit / kappa) / 6.0
                cx = share * (points[i - 1, 0] - 2.0 * points[i, 0] + points[i + 1, 0])
                cy = share * (points[i - 1, 1] - 2.0 * points[i, 1] + points[i + 1, 1])
                push(free, points, i, 2.0 * cx, 2.0 * cy)
                push(free, points, i - 1, -cx, -cy)
                push(free, points, i + 1, -cx, -cy)
    return worst, where


def smooth_path(
    grid: GridMap,
    xy: ArrayLike,
    max_curvature: float,
    *,
    clearance: float = 0.0,
    spacing: float = 0.05,
) -> FloatArray:
    """Round a way's corners so that it nowhere bends more than allowed, and keeps its clearance.

    Parameters
    ----------
    grid : GridMap
    xy : array_like, shape (n, 2)  [m, map]
        Best a shortened way: few points.
    max_curvature : float  [1/m]
        One over the smallest radius. At speed v it costs v² times this in sideways acceleration.
    clearance : float  [m]
        As in `astar`; the way must keep it already.
    spacing : float  [m]
        Between points, about.

    Returns
    -------
    ndarray, shape (m, 2)  [m, map]
        With the same first and last point.

    Raises
    ------
    NoPathError
        The way cannot be rounded so much where it is (reason ``"bent"``).
    ValueError
        Another shape, not finite, numbers that are not positive, or legs without clearance.

    Examples
    --------
    >>> grid = GridMap(np.ones((40, 40), dtype=bool), 0.1)
    >>> corner = [[0.5, 0.5], [2.5, 0.5], [2.5, 2.5]]
    >>> round_corner = smooth_path(grid, corner, max_curvature=2.0)
    >>> bool(path_curvature(round_corner).max() <= 2.0)
    True
    """
    limit = as_positive(max_curvature, "max_curvature") * grid.resolution
    free = inflated(grid, clearance).free
    points = in_cells(grid, subdivided(xy, spacing))
    for i in range(len(points) - 1):
        if not in_sight(free, *points[i], *points[i + 1]):
            x, y = points[i] * grid.resolution + grid.origin
            raise ValueError(
                f"xy: the way has no clearance of {clearance:g} m near ({x:.3f}, {y:.3f}) m; "
                "plan and shorten it with the same clearance"
            )
    worst, where = relax(free, points, limit, SWEEPS)
    xy = points * grid.resolution + grid.origin
    if worst > limit:
        raise NoPathError(
            f"near ({xy[where, 0]:.2f}, {xy[where, 1]:.2f}) m the way cannot bend less than "
            f"{worst / grid.resolution:.2f} per metre; allow more, or plan with more clearance",
            "bent",
        )
    return xy


def path_curvature(xy: ArrayLike) -> FloatArray:
    """How much a way bends at each of its points.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    ndarray, shape (n,)  [1/m]
        Of the circle through a point and its neighbours; 0 at both ends.

    Raises
    ------
    ValueError
        Another shape, or not finite.
    """
    points = as_path(xy)
    inner = [bend(points, i) for i in range(1, len(points) - 1)]
    return np.array([0.0, *inner, 0.0][: len(points)])
