"""The kernels of the search: A* through a bitmap, and D* Lite, which repairs what A* found.

A cell n that is reached at the cost g(n) leads to ways of about

    f(n) = g(n) + w h(n)

where h estimates what is left. A* always goes on from the smallest f. The cells that wait are
kept in *buckets*: stacks that each hold a small range of f. The lowest bucket is emptied before
the next is begun, and a cell that becomes cheaper in the meantime is put back into it. So nothing
has to be sorted, and the way found is still the shortest (`search` says why).

What a step costs, and which steps are worth a try, stands in `moves`.

Source: P. E. Hart, N. J. Nilsson, B. Raphael, A Formal Basis for the Heuristic Determination of
Minimum Cost Paths, IEEE Transactions on Systems Science and Cybernetics 4(2), 1968; R. B. Dial,
Algorithm 360, Communications of the ACM 12(11), 1969, for the buckets.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from robocon_course.planning.moves import (
    D_COL,
    D_ROW,
    DIAGONAL,
    NEVER,
    NOWHERE,
    STRAIGHT,
    estimate,
    walls_around,
)

# What the marks say of a cell that is no wall: 0 not seen yet; STEP + k reached by a step in
# direction k, and done; WAITING + STEP + k reached likewise, and in a bucket.
STEP, WAITING = 2, 16
ONE = 1024
"""Weights are counted in this part: even they are whole numbers."""


@njit(cache=True, inline="always")
def left(rows, cols, weight, heuristic):
    """The weighted estimate w h of what is left to a goal (rows, cols) away, rounded down.

    Parameters
    ----------
    rows, cols : int
    weight : int
        In parts of ``ONE``.
    heuristic : {OCTILE, MANHATTAN, EUCLIDEAN}

    Returns
    -------
    int
    """
    h = estimate(rows, cols, heuristic)
    return h // ONE * weight + h % ONE * weight // ONE  # weight h alone may not fit into 64 bits


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

    The buckets lie in a ring, because few of them hold anything at a time. A bucket is a pile of
    entries; an entry is a cell and the number of the entry below it, 0 if there is none.

    It trusts its input.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
        As `prepared` makes it; then holds the steps that lead to each cell, for `trace`.
    width : int
        Columns of the map, the wall included.
    ends : (int, int)
        Start and goal, free cells.
    rules : (int, int, bool, int, ndarray of int64)
        Weight w of the estimate in parts of ``ONE``, the heuristic, whether a cell is gone on
        from only once, the binary logarithm of what a bucket spans, and the steps that are
        `worthwhile`.
    cost : ndarray of int64, shape (n,)
        Takes g of the cells reached.
    order : ndarray of int32, shape (n,) or (0,)
        Takes 1, 2, 3 ... where the search went on from a cell, if there is room.
    top : ndarray of int32, shape (m,)
        All 0, m a power of two. The buckets: the number of the entry on top of each.
    pool : ndarray of int32, shape (2, k)
        Room for entries: their cells, and the numbers of those below, 1 to k for a start.

    Returns
    -------
    (int, int)
        The number of cells is -1 if ``top`` was too short and -2 if ``pool`` was.
    """
    (start, goal), (weight, heuristic, once, shift, worth) = ends, rules
    (row, col), (goal_row, goal_col) = divmod(start, width), divmod(goal, width)
    level = left(row - goal_row, col - goal_col, weight, heuristic) >> shift
    ring, highest = len(top) - 1, level  # & ring is modulo the number of buckets
    which, below, steps = pool[0], pool[1], D_ROW * width + D_COL
    cost[start], mark[start], top[level & ring] = 0, WAITING + STEP + NOWHERE, 1
    which[1], below[1], spare = start, 0, 2  # the spare entries are a pile, too
    best, expanded = (0 if start == goal else NEVER), 0
    while level <= highest and level << shift < best:
        entry = top[level & ring]
        if entry == 0:
            level += 1
            continue
        cell = int(which[entry])  # wider than it is kept: costs are no 32-bit numbers
        top[level & ring], below[entry], spare = below[entry], spare, entry
        came = int(mark[cell]) - WAITING - STEP
        if came < 0:
            continue  # another entry of this cell was better
        mark[cell] = STEP + came
        expanded += 1
        if len(order):
            order[cell] = expanded
        row, col = divmod(cell, width)
        todo = worth[came, walls_around(mark, width, cell)]
        while todo:
            k, todo = todo & 7, todo >> 4
            to = cell + steps[k]
            new = cost[cell] + (DIAGONAL if k & 1 else STRAIGHT)
            if mark[to] and (new >= cost[to] or (once and mark[to] < WAITING)):
                continue
            rows, cols = row + D_ROW[k] - goal_row, col + D_COL[k] - goal_col
            f = new + left(rows, cols, weight, heuristic)
            if f >= best:
                continue
            cost[to], mark[to] = new, WAITING + STEP + k
            if to == goal:
                best = new
            level, highest = min(level, f >> shift), max(highest, f >> shift)
            if highest - level > ring or spare == len(which):
                return NEVER, -1 if spare < len(which) else -2
            entry, spare = spare, below[spare]
            which[entry], below[entry], top[f >> shift & ring] = to, top[f >> shift & ring], entry
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
