"""One step on a map, as the kernels see it: what it costs, whether it is open and worth a try.

Costs are whole numbers, 1 311 738 121 for a straight step and 1 855 077 841 for a diagonal one.
That is √2 to 18 digits: of two ways with less than 10^9 steps the shorter one always has the
smaller cost, and nothing depends on the order in which numbers are added.

Kernels see the map as `prepared` makes it: flat, with a wall around it, so that a neighbour is one
addition away and nobody asks whether it lies on the map.

Of many ways that are equally long only one has to be looked at. A step is *needless* if the cell
before reaches its end as cheaply some other way. Where nothing stands around, that leaves one step
out of eight after a straight one, and three after a diagonal one.

Source: D. Harabor, A. Grastien, Online Graph Pruning for Pathfinding on Grid Maps, AAAI 2011, for
the needless steps.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course.gridmap import GridMap

# numba looks for changes only in the file of the kernel that is called: after one here, save
# search.py and replanning.py, too.

STRAIGHT, DIAGONAL = 1_311_738_121, 1_855_077_841
NEVER = 1 << 62
"""A cost that no way has."""
OCTILE, MANHATTAN, EUCLIDEAN = 0, 1, 2
OVERESTIMATE = (1.0, sqrt(2.0), 1.0)
"""How many times too large each of them may be."""
# Eight directions, counter-clockwise from +x; the odd ones are diagonal.
D_ROW = np.array([0, 1, 1, 1, 0, -1, -1, -1])
D_COL = np.array([1, 1, 0, -1, -1, -1, 0, 1])
WALL = 1
"""The mark of a cell that is not free; a free one is 0."""
NOWHERE = 8
"""In place of a direction: by no step, for it is the start."""


def prepared(grid: GridMap) -> NDArray[np.uint8]:
    """The map as the kernels see it: flat, with a wall around it.

    Parameters
    ----------
    grid : GridMap

    Returns
    -------
    ndarray of uint8, shape ((rows + 2) (cols + 2),)
        0 where free, ``WALL`` where not; cell (row, col) at (row + 1) (cols + 2) + col + 1.
    """
    rows, cols = grid.shape
    mark = np.full((rows + 2, cols + 2), WALL, np.uint8)
    mark[1:-1, 1:-1] = ~grid.free
    return mark.ravel()


@njit(cache=True)
def estimate(rows, cols, heuristic):
    """Cost of a way over (rows, cols), as if nothing stood in it.

    Octile is exact on an empty map. The straight line is less than that. Manhattan is more, up to
    √2 times: it counts a diagonal step as two. It trusts its input.

    Parameters
    ----------
    rows, cols : int
        Any sign.
    heuristic : {OCTILE, MANHATTAN, EUCLIDEAN}

    Returns
    -------
    int
    """
    rows, cols = abs(rows), abs(cols)
    if heuristic == OCTILE:
        return STRAIGHT * max(rows, cols) + (DIAGONAL - STRAIGHT) * min(rows, cols)
    if heuristic == MANHATTAN:
        return STRAIGHT * (rows + cols)
    # A little less than a step, or rounding would make it fall by more than the step costs.
    return int((STRAIGHT - 2) * sqrt(rows * rows + cols * cols))


@njit(cache=True, inline="always")
def may_step(mark, width, cell, k, cut_corners):
    """Whether a step from a cell in direction k meets no obstacle. It trusts its input.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
        As `prepared` makes it.
    width : int
        Columns of the map, the wall included.
    cell : int
    k : int
        0 to 7, as in D_ROW and D_COL.
    cut_corners : bool
        Otherwise both cells beside a diagonal step must be free.

    Returns
    -------
    bool
    """
    return mark[cell + D_ROW[k] * width + D_COL[k]] != WALL and (
        k & 1 == 0
        or cut_corners
        or (mark[cell + D_ROW[k] * width] != WALL and mark[cell + D_COL[k]] != WALL)
    )


@njit(cache=True, inline="always")
def is_needless(mark, width, cell, came, turn, cut_corners):
    """Whether the cell before this one reaches a step's end as cheaply without this one.

    Between two equally long ways, straight first or diagonally first, the second is kept. It
    trusts its input.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
    width, cell : int
    came : int
        Direction of the step to this cell.
    turn : int
        By how many eighths the step from it turns to the left, -2 to 2: back it never pays.
    cut_corners : bool

    Returns
    -------
    bool
    """
    if turn == 0 or (came & 1 and abs(turn) == 1):
        return False
    if came & 1:  # diagonal and again: two straight steps are less, if nothing stands there
        k = (came + turn // 2) & 7
        beside = cell - D_ROW[came] * width - D_COL[came] + D_ROW[k] * width + D_COL[k]
        return not cut_corners or mark[beside] != WALL
    k = (came + 2 if turn > 0 else came - 2) & 7
    if cut_corners:
        return abs(turn) == 2 or mark[cell + D_ROW[k] * width + D_COL[k]] != WALL
    return mark[cell - D_ROW[came] * width - D_COL[came] + D_ROW[k] * width + D_COL[k]] != WALL


@njit(cache=True, inline="always")
def walls_around(mark, width, cell):
    """Which of the eight cells around a cell are walls: bit k for the one in direction k.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
    width, cell : int

    Returns
    -------
    int
    """
    walls = 0
    for k in range(8):
        walls |= (mark[cell + D_ROW[k] * width + D_COL[k]] == WALL) << k
    return walls


@njit(cache=True)
def worthwhile(cut_corners, once):
    """The steps worth a try from a cell, for each way to have come there and all walls around it.

    Nothing else matters, so each case is judged here once, on a map of nine cells, and a search
    looks it up.

    Parameters
    ----------
    cut_corners : bool
    once : bool
        Whether the search goes on from a cell only once. Then no step is needless: the cell that
        reaches its end as cheaply may have been gone on from too soon.

    Returns
    -------
    ndarray of int64, shape (9, 256)
        By the direction of the step to the cell (``NOWHERE`` at the start) and by `walls_around`
        it: the directions in a row, four bits each, 8 + k, the first one to the right.
    """
    table = np.zeros((9, 256), np.int64)
    for walls in range(256):
        mark = np.zeros(9, np.uint8)
        for k in range(8):
            mark[4 + D_ROW[k] * 3 + D_COL[k]] = walls >> k & 1  # WALL is 1
        for came in range(9):
            # Straight on comes last in the row: what waits on top of a bucket is taken up first.
            for turn in (0, 1, -1, 2, -2, 3, -3, 4):
                k = (came + turn) & 7
                if came != NOWHERE and (
                    abs(turn) > 2  # back it never pays
                    or (not once and is_needless(mark, 3, 4, came, turn, cut_corners))
                ):
                    continue
                if may_step(mark, 3, 4, k, cut_corners):
                    table[came, walls] = table[came, walls] << 4 | 8 | k
    return table
