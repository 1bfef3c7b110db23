"""The map has changed on the way: mend the plan, and do not start from nothing (D* Lite).

It searches from the goal, so that what it knows stays true while the robot moves. Of each cell it
keeps two numbers: g, the cost left from there as once settled, and one step ahead of it

    rhs(n) = min over neighbours m of  cost(n, m) + g(m)

A cell is *settled* if they agree. An obstacle that appears changes rhs around it. The cells that
are not settled wait in a heap, in the order of

    ( min(g, rhs) + h(robot, n) + drift,  min(g, rhs) )

and are settled one after the other, but only as long as they can matter to the robot. When the
robot moves, every h falls by at most the estimate of its way; raising ``drift`` by as much, for
those that are new, saves sorting the heap anew.

Source: S. Koenig, M. Likhachev, D* Lite, AAAI 2002, figure 3; drift is its k_m.
"""

from __future__ import annotations

from heapq import heappop, heappush

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import as_floats
from robocon_course.gridmap import GridMap
from robocon_course.planning.moves import (
    D_COL,
    D_ROW,
    DIAGONAL,
    NEVER,
    OCTILE,
    STRAIGHT,
    WALL,
    estimate,
    may_step,
    prepared,
)
from robocon_course.planning.plans import Plan, checked_task, no_way, plan_through

# numba looks for changes only in this file: after one in moves.py, save this one too.


@njit(cache=True)
def urgency(width, start, drift, g, rhs, cell):
    """What a cell is sorted by in the heap, smallest first, and the cell itself.

    Parameters
    ----------
    width : int
        Columns of the map, the wall included.
    start : int
        Where the robot is.
    drift : int
    g, rhs : ndarray of int64, shape (n,)
    cell : int

    Returns
    -------
    (int, int, int)
    """
    least = min(g[cell], rhs[cell])
    (row, col), (start_row, start_col) = divmod(cell, width), divmod(start, width)
    return least + estimate(row - start_row, col - start_col, OCTILE) + drift, least, cell


@njit(cache=True)
def look_ahead(mark, width, goal, cut_corners, g, cell):
    """The smallest cost left from a cell, by what its neighbours know: rhs.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
        As `prepared` makes it.
    width, goal : int
    cut_corners : bool
    g : ndarray of int64, shape (n,)
    cell : int

    Returns
    -------
    int
    """
    if cell == goal:
        return 0
    least = NEVER
    if mark[cell] != WALL:
        for k in range(8):
            if may_step(mark, width, cell, k, cut_corners):
                step = DIAGONAL if k & 1 else STRAIGHT
                least = min(least, step + g[cell + D_ROW[k] * width + D_COL[k]])
    return least


@njit(cache=True)
def repair(mark, width, ends, cut_corners, drift, g, rhs, queue, changed):
    """Settle all cells that matter to the robot; the heap that is left, and how many it took.

    It trusts its input.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
        As `prepared` makes it.
    width : int
        Columns of the map, the wall included.
    ends : (int, int)
        Where the robot is, and the goal.
    cut_corners : bool
    drift : int
        How much the estimates may have fallen since the first search.
    g, rhs : ndarray of int64, shape (n,)
        Changed in place.
    queue : ndarray of int64, shape (m, 3)
        The heap, as it was left.
    changed : ndarray of int64, shape (k,)
        Cells on which a step has become possible or impossible.

    Returns
    -------
    (ndarray of int64, shape (j, 3), int)
    """
    start, goal = ends
    heap = [(queue[i, 0], queue[i, 1], queue[i, 2]) for i in range(len(queue))]
    for cell in changed:
        rhs[cell] = look_ahead(mark, width, goal, cut_corners, g, cell)
        if g[cell] != rhs[cell]:
            heappush(heap, urgency(width, start, drift, g, rhs, cell))
    expanded = 0
    while heap and (
        g[start] != rhs[start] or heap[0] < urgency(width, start, drift, g, rhs, start)
    ):
        entry = heappop(heap)
        cell = entry[2]
        if g[cell] == rhs[cell]:
            continue  # another entry of this cell came first
        now = urgency(width, start, drift, g, rhs, cell)
        if entry < now:
            heappush(heap, now)
            continue
        expanded += 1
        before, g[cell] = g[cell], (rhs[cell] if g[cell] > rhs[cell] else NEVER)
        if g[cell] != rhs[cell]:  # its way is lost: it may have to be settled again, higher
            heappush(heap, urgency(width, start, drift, g, rhs, cell))
        for k in range(8):
            if not may_step(mark, width, cell, k, cut_corners):
                continue
            to = cell + D_ROW[k] * width + D_COL[k]
            step = DIAGONAL if k & 1 else STRAIGHT
            if g[cell] < NEVER:
                rhs[to] = min(rhs[to], step + g[cell])
            elif rhs[to] == step + before:  # it relied on this cell
                rhs[to] = look_ahead(mark, width, goal, cut_corners, g, to)
            else:
                continue
            if g[to] != rhs[to]:
                heappush(heap, urgency(width, start, drift, g, rhs, to))
    left = np.empty((len(heap), 3), np.int64)
    for i in range(len(heap)):
        left[i, 0], left[i, 1], left[i, 2] = heap[i]
    return left, expanded


@njit(cache=True)
def descend(mark, width, ends, cut_corners, g):
    """The way from start to goal on which the cost left falls.

    Parameters
    ----------
    mark : ndarray of uint8, shape (n,)
    width : int
    ends : (int, int)
    cut_corners : bool
    g : ndarray of int64, shape (n,)
        Finite at the start.

    Returns
    -------
    ndarray of int64, shape (m,)
    """
    cell, goal = ends
    way = [cell]
    while cell != goal:
        least, best = NEVER, 0
        for k in range(8):
            if may_step(mark, width, cell, k, cut_corners):
                left = g[cell + D_ROW[k] * width + D_COL[k]] + (DIAGONAL if k & 1 else STRAIGHT)
                if left < least:
                    least, best = left, k
        cell += D_ROW[best] * width + D_COL[best]
        way.append(cell)
    return np.array(way)


class Replanner:
    """Plans to one goal through a map that changes while the robot moves.

    Its plans are as long as those of `astar`; only they come sooner when little has changed.

    Parameters
    ----------
    goal : array_like, shape (2,)  [m, map]
    clearance : float  [m]
        As in `astar`.
    cut_corners : bool
        As in `astar`.

    Raises
    ------
    ValueError
        A goal that is not finite.

    Examples
    --------
    >>> free = np.ones((3, 5), dtype=bool)
    >>> replanner = Replanner([4.5, 1.5])
    >>> replanner.plan(GridMap(free, 1.0), [0.5, 1.5]).length
    4.0
    >>> free[0:2, 2] = False
    >>> round(replanner.plan(GridMap(free, 1.0), [1.5, 1.5]).length, 3)
    4.414
    """

    def __init__(
        self, goal: ArrayLike, *, clearance: float = 0.0, cut_corners: bool = False
    ) -> None:
        self.goal = as_floats(goal, "goal", 2)
        self.clearance = clearance
        self.cut_corners = bool(cut_corners)
        self._room: GridMap | None = None

    def plan(self, grid: GridMap, start: ArrayLike) -> Plan:
        """The shortest way from where the robot is now, through the map as it is known now.

        Parameters
        ----------
        grid : GridMap
            What differs from the map of the call before is found out here. A map of another
            size or place starts a new search.
        start : array_like, shape (2,)  [m, map]

        Returns
        -------
        Plan

        Raises
        ------
        NoPathError, ValueError
            As `astar`; the next call may well succeed.
        """
        task = checked_task(grid, start, self.goal, self.clearance)
        width = grid.shape[1] + 2
        here, goal = ((row + 1) * width + col + 1 for row, col in (task.start, task.goal))
        changed = self._update(task.room, here, goal)
        self._queue, expanded = repair(
            self._mark, width, (here, goal), self.cut_corners, self._drift,
            self._g, self._rhs, self._queue, changed,
        )  # fmt: skip
        if self._g[here] >= NEVER:
            raise no_way(task, int((self._g < NEVER).sum()))
        flat = descend(self._mark, width, (here, goal), self.cut_corners, self._g)
        way = np.column_stack([flat // width - 1, flat % width - 1])
        return plan_through(task.room, way, expanded)

    def _update(self, room: GridMap, here: int, goal: int) -> NDArray[np.int64]:
        """Take over the map and the place; the cells on which steps have changed."""
        width, mark = room.shape[1] + 2, prepared(room)
        old = self._room
        if old is None or (old.shape, old.origin, old.resolution) != (
            room.shape, room.origin, room.resolution,
        ):  # fmt: skip
            self._g, self._rhs = np.full(mark.size, NEVER), np.full(mark.size, NEVER)
            self._queue, self._drift = np.empty((0, 3), np.int64), 0
            changed = np.array([goal])
        else:
            turned = np.flatnonzero(mark != self._mark)
            # A cell also stands beside its neighbours' diagonal steps.
            around = (np.arange(-1, 2)[:, None] * width + np.arange(-1, 2)).ravel()
            changed = np.unique(turned[:, None] + around)
            moved = np.subtract(divmod(here, width), divmod(self._here, width))
            self._drift += estimate(*moved.tolist(), OCTILE)
        self._room, self._mark, self._here = room, mark, here
        return changed
