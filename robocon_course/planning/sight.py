"""What is in sight of what, and a way without the points that nobody needs.

Two points are in sight of each other if the line between them stays in free cells and touches no
other cell, not even its corner. On a map inflated by the robot's radius it then keeps its distance.
"""

from __future__ import annotations

from math import floor

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.gridmap import GridMap
from robocon_course.planning.path import as_path, path_length, subdivided
from robocon_course.planning.plans import inflated

TOUCH = 1e-9  # cells; a line that comes so near to a cell touches it


@njit(cache=True)
def in_sight(free, x0, y0, x1, y1):
    """Whether a line touches free cells only. It trusts its input.

    Parameters
    ----------
    free : ndarray of bool, shape (rows, cols)
    x0, y0, x1, y1 : float  [cells]
        Its ends, anywhere; cell (row, col) begins at x = col, y = row.

    Returns
    -------
    bool
        False where the line leaves the map.
    """
    rows, cols = free.shape
    steep = abs(y1 - y0) > abs(x1 - x0)
    if steep:  # walk along the longer side: the slope is never above 1
        x0, y0, x1, y1 = y0, x0, y1, x1
    if x1 < x0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    slope = (y1 - y0) / (x1 - x0) if x1 > x0 else 0.0
    for i in range(floor(x0 - TOUCH), floor(x1 + TOUCH) + 1):
        enter = y0 + slope * (min(max(x0, i), x1) - x0)
        leave = y0 + slope * (max(min(x1, i + 1), x0) - x0)
        first, last = floor(min(enter, leave) - TOUCH), floor(max(enter, leave) + TOUCH)
        for j in range(first, last + 1):
            row, col = (i, j) if steep else (j, i)
            if not (0 <= row < rows and 0 <= col < cols and free[row, col]):
                return False
    return True


@njit(cache=True)
def pull_tight(free, points, kept):
    """Keep of a way's points only those around which it has to bend; how many are kept.

    From each kept point it goes to the last one in sight, at least to the next.

    Parameters
    ----------
    free : ndarray of bool, shape (rows, cols)
    points : ndarray, shape (n, 2)  [cells]
        (x, y).
    kept : ndarray of int64, shape (n,)
        Takes their numbers.

    Returns
    -------
    int
    """
    count, at = 1, 0
    kept[0] = 0
    while at < len(points) - 1:
        to = len(points) - 1
        x, y = points[at]
        while to > at + 1 and not in_sight(free, x, y, points[to, 0], points[to, 1]):
            to -= 1
        at = to
        kept[count] = at
        count += 1
    return count


def line_of_sight(
    grid: GridMap, start: ArrayLike, end: ArrayLike, *, clearance: float = 0.0
) -> bool:
    """Whether a robot can drive straight from one point to another.

    Parameters
    ----------
    grid : GridMap
    start, end : array_like, shape (2,)  [m, map]
    clearance : float  [m]
        As in `astar`.

    Returns
    -------
    bool
        False also where the line only touches an obstacle, or leaves the map.

    Raises
    ------
    ValueError
        Not finite, or a negative clearance.

    Examples
    --------
    >>> grid = GridMap(np.array([[True, True], [True, False]]), 1.0)
    >>> line_of_sight(grid, [0.5, 0.5], [1.5, 0.5]), line_of_sight(grid, [0.5, 1.5], [1.5, 0.5])
    (True, False)
    """
    ends = np.stack([as_floats(start, "start", 2), as_floats(end, "end", 2)])
    return bool(in_sight(inflated(grid, clearance).free, *in_cells(grid, ends).ravel()))


def shorten_path(grid: GridMap, xy: ArrayLike, *, clearance: float = 0.0) -> FloatArray:
    """Pull a way tight: straight legs that bend only around obstacles.

    First it leaves out the points that are not needed, then it does the same from the other end
    with points a cell apart on the new legs, to and fro until nothing is gained.

    Parameters
    ----------
    grid : GridMap
    xy : array_like, shape (n, 2)  [m, map]
    clearance : float  [m]
        As in `astar`; the new legs keep it.

    Returns
    -------
    ndarray, shape (m, 2)  [m, map]
        With the same first and last point, and never longer. A leg that had no clearance may stay.

    Raises
    ------
    ValueError
        Another shape, not finite, or a negative clearance.

    Examples
    --------
    >>> grid = GridMap(np.ones((3, 3), dtype=bool), 1.0)
    >>> shorten_path(grid, [[0.5, 0.5], [1.5, 1.5], [2.5, 1.5]]).tolist()
    [[0.5, 0.5], [2.5, 1.5]]
    """
    free = inflated(grid, clearance).free
    tight = _tight(free, grid, as_path(xy))
    while True:
        back = _tight(free, grid, subdivided(tight, grid.resolution)[::-1])
        again = _tight(free, grid, subdivided(back, grid.resolution)[::-1])
        if path_length(again) >= path_length(tight) * (1.0 - 1e-6):
            return tight
        tight = again


def _tight(free: NDArray[np.bool_], grid: GridMap, points: FloatArray) -> FloatArray:
    """Those of the points that `pull_tight` keeps."""
    kept = np.empty(len(points), np.int64)
    return points[kept[: pull_tight(free, in_cells(grid, points), kept)]]


def in_cells(grid: GridMap, xy: FloatArray) -> FloatArray:
    """Points as the kernels of this chapter count: cells, from the corner of cell (0, 0).

    Parameters
    ----------
    grid : GridMap
    xy : ndarray, shape (..., 2)  [m, map]

    Returns
    -------
    ndarray, shape (..., 2)  [cells]
        x along the columns, y along the rows.
    """
    return (xy - grid.origin) / grid.resolution
