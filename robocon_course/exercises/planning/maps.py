"""Small maps for the cases, each with numbers of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError, Plan, astar

Cell = tuple[int, int]


def some_grid(rng: np.random.Generator, rows: int, cols: int, share: float) -> GridMap:
    """A map with a share of its cells blocked, in cells of some size, somewhere."""
    resolution = float(rng.choice([0.05, 0.1, 0.2, 0.5]))
    origin = tuple((resolution * rng.integers(-9, 10, 2)).round(2).tolist())
    return GridMap(rng.uniform(size=(rows, cols)) >= share, resolution, origin)


def drawn_grid(picture: str, resolution: float = 0.1, origin: tuple = (0.0, 0.0)) -> GridMap:
    """A map from a drawing: its top line is the largest y, '#' is an obstacle."""
    lines = picture.split()
    free = np.array([[c != "#" for c in line] for line in lines])[::-1]
    return GridMap(free.copy(), resolution, origin)


def point_in(rng: np.random.Generator, grid: GridMap, cell: Cell) -> np.ndarray:
    """A point in a cell, not in its middle, shape (2,) [m, map]."""
    aside = rng.uniform(-0.3, 0.3, 2).round(2) * grid.resolution
    return (grid.centres(cell) + aside).round(4)


def some_ends(rng: np.random.Generator, grid: GridMap) -> tuple[np.ndarray, np.ndarray]:
    """Two points in free cells, in opposite quarters of the map."""
    rows, cols = grid.shape
    ends = []
    for at in rng.permutation([0, 1]).tolist():
        quarter = grid.free[at * rows * 3 // 4 :][: rows // 4, at * cols * 3 // 4 :][:, : cols // 4]
        row, col = rng.choice(np.argwhere(quarter)).tolist() if quarter.any() else (0, 0)
        ends.append(point_in(rng, grid, (row + at * rows * 3 // 4, col + at * cols * 3 // 4)))
    return ends[0], ends[1]


def as_points(value: Any) -> np.ndarray | None:
    """What came as finite points, shape (n, 2), or None if it is none."""
    try:
        points = np.asarray(value) if isinstance(value, np.ndarray | list | tuple) else np.zeros(0)
    except ValueError:  # lists of unequal length
        return None
    right = points.ndim == 2 and points.shape[1] == 2 and len(points) and points.dtype.kind in "iuf"
    return points if right and np.isfinite(points).all() else None


def way_of(grid: GridMap, start: np.ndarray, goal: np.ndarray) -> Plan | None:
    """The course's plan, or None where there is no way."""
    try:
        return astar(grid, start, goal)
    except NoPathError:
        return None
