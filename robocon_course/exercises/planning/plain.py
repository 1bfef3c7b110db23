"""A* in plain Python, with one of its steps done wrongly: for the catalogue of wrong answers."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from heapq import heappop, heappush
from math import inf

import numpy as np

from robocon_course.exercises.planning.maps import Cell
from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError, Plan, plan_through
from robocon_course.planning.steps import DIRECTIONS, ROOT_2

Estimate = Callable[[Cell, Cell, Cell], float]
"""``h(cell, goal, start)`` in cells."""


def to_goal(cell: Cell, goal: Cell, start: Cell) -> float:
    """Octile distance, as the kernel counts it, without a door."""
    a, b = abs(cell[0] - goal[0]), abs(cell[1] - goal[1])
    return max(a, b) + (ROOT_2 - 1.0) * min(a, b)


def manhattan(cell: Cell, goal: Cell, start: Cell) -> float:
    """Rows and columns that are left."""
    return float(abs(cell[0] - goal[0]) + abs(cell[1] - goal[1]))


def from_start(cell: Cell, goal: Cell, start: Cell) -> float:
    """The distance from the start, which two sources call h."""
    return to_goal(cell, start, goal)


def as_it_is(grid: GridMap, point: np.ndarray) -> Cell:
    """The cell of a point."""
    row, col = grid.cells(point).tolist()
    return row, col


def plain_astar(
    *,
    h: Estimate = to_goal,
    directions: tuple[Cell, ...] = DIRECTIONS,
    corners: bool = False,
    diagonal: float = ROOT_2,
    greedy: bool = False,
    seen: bool = False,
    adding: str = "g",
    cell_of: Callable[[GridMap, np.ndarray], Cell] = as_it_is,
    order: slice = slice(None),
    none: bool = False,
    ask: bool = True,
) -> Callable[..., Plan | None]:
    """A* in plain Python with one thing done wrongly.

    ``seen`` closes a cell when it is first seen; ``adding`` "f" takes what the heap is sorted by
    for the cost so far; ``none`` returns None where there is no way, and
    without ``ask`` the start may lie in an obstacle. To stop when the goal is first seen is none of
    them: beside the goal the octile distance is the step itself, so it makes no difference.
    """

    rule = partial(_steps, directions=directions, corners=corners, diagonal=diagonal)

    def function(grid: GridMap, start: np.ndarray, goal: np.ndarray) -> Plan | None:
        free = np.pad(grid.free, 1).tolist()  # a rim, so that no step leaves the lists
        first, last = cell_of(grid, start), cell_of(grid, goal)
        cost, came, done = {first: 0.0}, {first: first}, set()
        queue = [(0.0, first)] if grid.is_free(grid.centres(first)) or not ask else []
        while queue:
            f, cell = heappop(queue)
            if cell in done:
                continue
            done.add(cell)
            if cell == last:
                break
            for to, step in rule(free, cell):
                new = (f if adding == "f" else cost[cell]) + step
                if to in done or (seen and to in cost) or new >= cost.get(to, inf):
                    continue
                cost[to], came[to] = new, cell
                heappush(queue, (h(to, last, first) + (0.0 if greedy else new), to))
        if last in done:
            return plan_through(grid, _back(came, first, last)[order], len(done))
        if none:
            return None
        raise NoPathError("no way", "enclosed")

    return function


def _steps(
    free: list[list[bool]],
    cell: Cell,
    directions: tuple[Cell, ...],
    corners: bool,
    diagonal: float,
) -> list[tuple[Cell, float]]:
    """Open steps and what they cost; ``free`` has a rim of one cell that is not."""
    row, col = cell[0] + 1, cell[1] + 1
    return [
        ((cell[0] + dr, cell[1] + dc), diagonal if dr and dc else 1.0)
        for dr, dc in directions
        if free[row + dr][col + dc]
        and (corners or not (dr and dc) or (free[row + dr][col] and free[row][col + dc]))
    ]


def _back(came: dict[Cell, Cell], first: Cell, last: Cell) -> list[Cell]:
    """The cells of a way, from its start."""
    way = [last]
    while way[-1] != first:
        way.append(came[way[-1]])
    return way[::-1]


def upside_down(grid: GridMap, point: np.ndarray) -> Cell:
    """The cell, rows counted from above."""
    row, col = as_it_is(grid, point)
    return grid.shape[0] - 1 - row, col


def without_origin(grid: GridMap, point: np.ndarray) -> Cell:
    """The cell, as if the map began at (0, 0) m."""
    x, y = point
    return int(y / grid.resolution), int(x / grid.resolution)
