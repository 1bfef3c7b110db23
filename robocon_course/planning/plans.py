"""What a search is given and what it gives: two points in metres, a way, or the reason for none."""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import CourseError, FloatArray, as_distance, as_floats
from robocon_course.gridmap import GridMap, inflate


class NoPathError(CourseError, ValueError):
    """There is no way; the message says why.

    Attributes
    ----------
    reason : {"outside", "blocked", "enclosed", "bent"}
        An end lies outside the map, or in an obstacle or too near to one; or no way leads from
        one end to the other, or none without sharp bends.
    """

    def __init__(self, message: str, reason: str = "enclosed") -> None:
        super().__init__(message)
        self.reason = reason


class Plan(NamedTuple):
    """A way through a map, and what it took to find it.

    Attributes
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
        Middles of the cells, those of start and goal included.
    cells : ndarray of int64, shape (n, 2)
        (row, col).
    length : float  [m]
    expanded : int
        From how many cells the search went on; it may come back to one.
    order : ndarray of int32, shape (rows, cols), or None
        When it did: 1 for the first cell, 0 where it never was. None unless asked for.
    """

    xy: FloatArray
    cells: NDArray[np.int64]
    length: float
    expanded: int
    order: NDArray[np.int32] | None = None


class Task(NamedTuple):
    """A search with everything checked.

    Attributes
    ----------
    room : GridMap
        Free where the robot's middle may be.
    start, goal : (int, int)
        Free cells (row, col).
    """

    room: GridMap
    start: tuple[int, int]
    goal: tuple[int, int]


def checked_task(grid: GridMap, start: ArrayLike, goal: ArrayLike, clearance: float) -> Task:
    """The cells of start and goal in the inflated map.

    Parameters
    ----------
    grid : GridMap
    start, goal : array_like, shape (2,)  [m, map]
    clearance : float  [m]

    Returns
    -------
    Task

    Raises
    ------
    NoPathError
        One of them is outside, in an obstacle, or too near to one.
    ValueError
        Not finite, or a negative clearance.
    """
    points = {"start": as_floats(start, "start", 2), "goal": as_floats(goal, "goal", 2)}
    room, ends = inflated(grid, clearance), []
    for name, point in points.items():
        at = "{}: ({:g}, {:g}) m".format(name, *point)
        if not grid.contains(point):
            x0, x1, y0, y1 = grid.extent
            raise NoPathError(
                f"{at} lies outside the map, which spans x {x0:g} to {x1:g} m and y {y0:g} to "
                f"{y1:g} m without its upper edges; are these metres, and in this order?",
                "outside",
            )
        row, col = grid.cells(point).tolist()
        if not grid.free[row, col]:
            raise NoPathError(f"{at} lies in an obstacle; choose a free point", "blocked")
        if not room.free[row, col]:
            raise NoPathError(
                f"{at} is free, but nearer than the clearance of {clearance:g} m to an obstacle "
                "or to the edge of the map; take a smaller clearance or ask `nearest_free`",
                "blocked",
            )
        ends.append((row, col))
    return Task(room, *ends)


def inflated(grid: GridMap, clearance: float) -> GridMap:
    """Where the middle of a robot may be that keeps a clearance.

    Parameters
    ----------
    grid : GridMap
    clearance : float  [m]

    Returns
    -------
    GridMap

    Raises
    ------
    ValueError
        Negative or not finite.
    """
    clearance = as_distance(clearance, "clearance")
    return inflate(grid, clearance) if clearance > 0.0 else grid


def plan_through(
    grid: GridMap,
    cells: ArrayLike,
    expanded: int,
    order: NDArray[np.int32] | None = None,
) -> Plan:
    """The plan that leads through cells, one step from each to the next.

    Parameters
    ----------
    grid : GridMap
        Says where the cells lie and how large they are.
    cells : array_like of int, shape (n, 2)
        (row, col), from start to goal; a list of pairs will do.
    expanded : int
        From how many cells the search went on.
    order : ndarray of int32, shape (rows, cols), optional
        When it did, as in `Plan`.

    Returns
    -------
    Plan

    Raises
    ------
    ValueError
        No cells, another shape, no whole numbers, or two cells that are no neighbours.

    Examples
    --------
    >>> plan = plan_through(GridMap(np.ones((2, 3), dtype=bool), 0.5), [(0, 0), (1, 1), (1, 2)], 3)
    >>> plan.xy.tolist(), round(plan.length, 3)
    ([[0.25, 0.25], [0.75, 0.75], [1.25, 0.75]], 1.207)
    """
    cells = _as_cells(cells)
    away = np.abs(np.diff(cells, axis=0))
    jumps = np.flatnonzero(away.max(axis=1, initial=0) != 1)
    if len(jumps):
        one, other = cells[jumps[0] : jumps[0] + 2].tolist()
        raise ValueError(f"cells: from {one} to {other} is no step to one of the eight neighbours")
    diagonal = int(away.all(axis=1).sum())
    straight = len(cells) - 1 - diagonal
    length = (straight + diagonal * sqrt(2.0)) * grid.resolution
    return Plan(grid.centres(cells), cells, length, expanded, order)


def _as_cells(cells: ArrayLike) -> NDArray[np.int64]:
    """Cells as whole numbers, checked."""
    numbers = as_floats(cells, "cells", None, 2)
    if not len(numbers):
        raise ValueError("cells: a way has at least one cell, got none")
    if (numbers != np.rint(numbers)).any():
        raise ValueError(
            "cells: expected whole numbers (row, col), got fractions; are these metres?"
        )
    return numbers.astype(np.int64)


def no_way(task: Task, reached: int) -> NoPathError:
    """The error for a goal that a search did not reach.

    Parameters
    ----------
    task : Task
    reached : int
        Cells that it came to.

    Returns
    -------
    NoPathError
    """
    return NoPathError(
        f"no way leads from start to goal: only {reached} of the {int(task.room.free.sum())} free "
        "cells can be reached; is the clearance too large, or does the map close a passage?",
        "enclosed",
    )


def nearest_free(grid: GridMap, xy: ArrayLike, *, clearance: float = 0.0) -> FloatArray:
    """The middle of a point's cell, or of the nearest one that is free: where to plan from.

    Parameters
    ----------
    grid : GridMap
    xy : array_like, shape (2,)  [m, map]
        Any point, outside the map too.
    clearance : float  [m]
        As in `astar`.

    Returns
    -------
    ndarray, shape (2,)  [m, map]

    Raises
    ------
    NoPathError
        No cell is free.
    ValueError
        Not finite, or a negative clearance.

    Examples
    --------
    >>> nearest_free(GridMap(np.array([[False, True, True]]), 1.0), [0.2, 0.5]).tolist()
    [1.5, 0.5]
    """
    point, room = as_floats(xy, "xy", 2), inflated(grid, clearance)
    if room.is_free(point):
        return room.centres(room.cells(point))
    centres = grid.centres(np.argwhere(room.free))
    if not len(centres):
        raise NoPathError(
            f"no cell of the map is free with a clearance of {clearance:g} m; take a smaller one",
            "blocked",
        )
    return centres[np.hypot(*(centres - point).T).argmin()]
