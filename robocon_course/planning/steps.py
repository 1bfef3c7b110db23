"""One cell and its eight neighbours: which steps are open, what each costs, what is left at least.

A straight step costs 1 cell, a diagonal one √2. A diagonal step passes between two cells; unless
corners may be cut, both must be free, or the robot would touch what stands there.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import as_floats
from robocon_course.gridmap import GridMap
from robocon_course.planning import moves

ROOT_2 = sqrt(2.0)
DIRECTIONS = tuple(zip(moves.D_ROW.tolist(), moves.D_COL.tolist(), strict=True))
Step = tuple[tuple[int, int], float]
"""A neighbour (row, col), and what the step to it costs [cells]."""
MIDDLE = 4  # of a window of 3 by 3 cells, counted row by row


def octile_distance(cell: ArrayLike, goal: ArrayLike) -> float:
    """Length of the shortest way between two cells on an empty map.

    Parameters
    ----------
    cell, goal : array_like of int, shape (2,)
        (row, col).

    Returns
    -------
    float  [cells]
        max(a, b) + (√2 - 1) min(a, b) for a rows and b columns between them.

    Raises
    ------
    ValueError
        Another shape, or no whole numbers.

    Examples
    --------
    >>> round(octile_distance((0, 0), (3, 4)), 3)
    5.243
    """
    rows, cols = (_as_cell(goal, "goal") - _as_cell(cell, "cell")).tolist()
    return moves.estimate(rows, cols, moves.OCTILE) / moves.STRAIGHT


def neighbours(grid: GridMap, cell: ArrayLike, *, cut_corners: bool = False) -> list[Step]:
    """The cells to which one step leads, and what it costs.

    Parameters
    ----------
    grid : GridMap
    cell : array_like of int, shape (2,)
        (row, col), in the map.
    cut_corners : bool
        Allow diagonal steps beside an obstacle, even between two.

    Returns
    -------
    list of ((int, int), float)
        Free neighbours (row, col) and the cost of the step [cells]: 1, or √2 for a diagonal one.
        Counter-clockwise from +x.

    Raises
    ------
    ValueError
        Another shape, no whole numbers, or a cell outside the map.

    Examples
    --------
    >>> grid = GridMap(np.array([[True, True], [True, False]]), 1.0)
    >>> neighbours(grid, (0, 0))
    [((0, 1), 1.0), ((1, 0), 1.0)]
    """
    row, col = _as_cell(cell, "cell").tolist()
    rows, cols = grid.shape
    if not (0 <= row < rows and 0 <= col < cols):
        raise ValueError(f"cell: ({row}, {col}) lies outside the map of {rows} by {cols} cells")
    mark = np.full((3, 3), moves.WALL, np.uint8)
    up, left = max(row - 1, 0), max(col - 1, 0)
    seen = grid.free[up : row + 2, left : col + 2]
    down, right = up - row + 1, left - col + 1
    mark[down : down + seen.shape[0], right : right + seen.shape[1]] = ~seen
    mark = mark.ravel()
    return [
        ((row + d_row, col + d_col), ROOT_2 if k & 1 else 1.0)
        for k, (d_row, d_col) in enumerate(DIRECTIONS)
        if moves.may_step(mark, 3, MIDDLE, k, cut_corners)
    ]


def _as_cell(cell: ArrayLike, name: str) -> NDArray[np.int64]:
    """A cell, checked."""
    numbers = as_floats(cell, name, 2)
    if (numbers != np.rint(numbers)).any():
        raise ValueError(f"{name}: expected two whole numbers (row, col), got {cell!r}")
    return numbers.astype(np.int64)
