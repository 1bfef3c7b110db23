"""The kernels of the search: A* through a bitmap, and D* Lite, which repairs what A* found.

A cell n that is reached at the cost g(n) leads to ways of about

    f(n) = g(n) + w h(n)

where h estimates what is left. A* always goes on from the smallest f. The cells that wait are
kept in *buckets*: stacks that each hold a small range of f. The lowest bucket is emptied before
the next is begun, and a cell that becomes cheaper in the meantime is put back into it. So nothing
has to be sorted, and the way found is still the shortest (`search` says why).

Costs are whole numbers, 1 311 738 121 for a straight step and 1 855 077 841 for a diagonal one.
That is √2 to 18 digits: of two ways with less than 10^9 steps the shorter one always has the
smaller cost, and nothing depends on the order in which numbers are added.

Kernels see the map as `prepared` makes it: flat, with a wall around it, so that a neighbour is one
addition away and nobody asks whether it lies on the map.

Source: P. E. Hart, N. J. Nilsson, B. Raphael, A Formal Basis for the Heuristic Determination of
Minimum Cost Paths, IEEE Transactions on Systems Science and Cybernetics 4(2), 1968; R. B. Dial,
Algorithm 360, Communications of the ACM 12(11), 1969, for the buckets.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course.gridmap import GridMap

STRAIGHT, DIAGONAL = 1_311_738_121, 1_855_077_841
NEVER = 1 << 62
"""A cost that no way has."""
OCTILE, MANHATTAN, EUCLIDEAN = 0, 1, 2
OVERESTIMATE = (1.0, sqrt(2.0), 1.0)
"""How many times too large each of them may be."""
# Eight directions, counter-clockwise from +x; the odd ones are diagonal.
D_ROW = np.array([0, 1, 1, 1, 0, -1, -1, -1])
D_COL = np.array([1, 1, 0, -1, -1, -1, 0, 1])
# What the map's marks say of a cell: 0 free and not seen yet; STEP + k reached by a step in
# direction k, and done; WAITING + STEP + k reached likewise, and in a bucket.
WALL, STEP, WAITING = 1, 2, 16
ONE = 1024
"""Weights are counted in this part: even they are whole numbers."""


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
    return np.pad(~grid.free, 1, constant_values=True).view(np.uint8).ravel()


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


@njit(cache=True)
def search(mark, width, ends, rules, cost, order, top, pool):
    """A*: the cost of the way found (``NEVER`` if there is none), and how many cells it took.

    With w ≤ 1, and h never more than what is left, it is the shortest way. For: each cell of that
    way has an f of at most its cost C. A bucket is left only when it is empty, so when C's bucket
    is, all these cells have been gone on from, with the smallest g they can have.

    With w > 1 no cell is gone on from twice, or it would happen to each of them dozens of times.
    g may then be too large, but not by much: the cost is at most w C + (w - 1) straight steps, as
    long as a bucket spans no more than w - 1 steps (Likhachev 2003, and one bucket for those in
    the same bucket that came in the wrong order). Manhattan counts as √2 times a good estimate.

    It trusts its input.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
        As `prepared` makes it; then holds the steps that lead to each cell, for `trace`.
    width : int
        Columns of the map, the wall included.
    ends : (int, int)
        Start and goal, free cells.
    rules : (float, int, bool, bool, int)
        Weight w of the estimate, the heuristic, whether corners may be cut, whether a cell is
        gone on from only once, and the binary logarithm of what a bucket spans.
    cost : ndarray of int64, shape (n,)
        Takes g of the cells reached.
    order : ndarray of int32, shape (n,) or (0,)
        Takes 1, 2, 3 ... where the search went on from a cell, if there is room.
    top : ndarray of int32, shape (m,)
        All -1. The buckets: the entry on top of each.
    pool : ndarray of int32, shape (k, 2)
        Room for entries: a cell, and the entry below it.

    Returns
    -------
    (int, int)
        The number of cells is -1 if ``top`` or ``pool`` were too short.
    """
    (start, goal), (weight, heuristic, cut_corners, once, shift) = ends, rules
    goal_row, goal_col = divmod(goal, width)
    row, col = divmod(start, width)
    level = weight * estimate(row - goal_row, col - goal_col, heuristic) // ONE >> shift
    if level >= len(top):
        return NEVER, -1
    cost[start], mark[start], top[level] = 0, WAITING + STEP, 0
    pool[0] = start, -1
    unused, spare, waiting = 1, -1, 1  # entries never used, and a stack of those given back
    best, expanded = (0 if start == goal else NEVER), 0
    while waiting and level << shift < best:
        entry = top[level]
        if entry < 0:
            level += 1
            continue
        cell = int(pool[entry, 0])  # wider than it is kept: costs are no 32-bit numbers
        top[level], pool[entry, 1], spare = pool[entry, 1], spare, entry
        waiting -= 1
        if mark[cell] < WAITING:
            continue  # another entry of this cell was better
        mark[cell] -= WAITING
        expanded += 1
        if len(order):
            order[cell] = expanded
        row, col = divmod(cell, width)
        came = int(mark[cell]) - STEP
        prune = not once and cell != start
        for i in range(-3 if cell == start else 0, 5):
            # ... -2, 2, -1, 1, 0: what comes last is taken up first, so it goes straight on
            turn = 2 - (i >> 1) if i & 1 else (i >> 1) - 2
            k = (came + turn) & 7
            if prune and is_needless(mark, width, cell, came, turn, cut_corners):
                continue
            if not may_step(mark, width, cell, k, cut_corners):
                continue
            to = cell + D_ROW[k] * width + D_COL[k]
            new = cost[cell] + (DIAGONAL if k & 1 else STRAIGHT)
            if mark[to] and (new >= cost[to] or (once and mark[to] < WAITING)):
                continue
            h = estimate(row + D_ROW[k] - goal_row, col + D_COL[k] - goal_col, heuristic)
            f = new + weight * h // ONE
            if f >= best:
                continue
            cost[to], mark[to] = new, WAITING + STEP + k
            if to == goal:
                best = new
            level = min(level, f >> shift)
            entry = spare if spare >= 0 else unused
            if f >> shift >= len(top) or entry == len(pool):
                return NEVER, -1
            if spare >= 0:
                spare = pool[entry, 1]
            else:
                unused += 1
            pool[entry, 0], pool[entry, 1], top[f >> shift] = to, top[f >> shift], entry
            waiting += 1
    return best, expanded


@njit(cache=True)
def trace(mark, width, start, goal):
    """The way that `search` found, from start to goal, back along the marks.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
    width : int
    start, goal : int

    Returns
    -------
    ndarray of int64, shape (m,)
    """
    count, cell = 1, goal
    while cell != start:
        k = mark[cell] % WAITING - STEP
        cell -= D_ROW[k] * width + D_COL[k]
        count += 1
    cells = np.empty(count, np.int64)
    cell = goal
    for i in range(count - 1, 0, -1):
        cells[i] = cell
        k = mark[cell] % WAITING - STEP
        cell -= D_ROW[k] * width + D_COL[k]
    cells[0] = start
    return cells
