"""A* in metres: the shortest way through a map, or a good one sooner.

The way goes from cell middle to cell middle, each time to one of the eight neighbours. A diagonal
step needs both cells beside it free, or else the robot would cut a corner.

The search is led by an estimate h of what is left to a goal a rows and b columns away:

=============  ==========================  =====================================================
``octile``     max(a, b) + (√2 - 1) min(a, b)  the true length on an empty map: the best there is
``euclidean``  √(a² + b²)                  never more than octile: the same way, more cells
``manhattan``  a + b                       up to √2 times the true length
=============  ==========================  =====================================================

An estimate is *admissible* if it is never more than what is left. Only then the way is the
shortest; with Manhattan it may not be. A weight w > 1 gives that up on purpose: the search runs
straighter to the goal, looks at fewer cells, and its way is at most about w times too long.

Source: P. E. Hart, N. J. Nilsson, B. Raphael, A Formal Basis for the Heuristic Determination of
Minimum Cost Paths, IEEE Transactions on Systems Science and Cybernetics 4(2), 1968; M. Likhachev,
G. Gordon, S. Thrun, ARA*: Anytime A* with Provable Bounds on Sub-Optimality, NIPS 2003.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from math import floor, log2
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import as_floats
from robocon_course.gridmap import GridMap
from robocon_course.planning import moves, search
from robocon_course.planning.plans import Plan, Task, checked_task, no_way, plan_through

HEURISTICS = {
    "octile": moves.OCTILE,
    "manhattan": moves.MANHATTAN,
    "euclidean": moves.EUCLIDEAN,
}
GREATEST_WEIGHT = 100.0
LEAST_EXCESS = 0.1  # an estimate that is too large by less would need too many buckets


class Attempt(NamedTuple):
    """One of several searches with falling weight.

    Attributes
    ----------
    weight : float
        Of this search.
    plan : Plan
        The shortest so far.
    bound : float
        The plan is at most this many times as long as the shortest there is.
    expanded : int
        Cells from which this search went on.
    """

    weight: float
    plan: Plan
    bound: float
    expanded: int


def astar(
    grid: GridMap,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    clearance: float = 0.0,
    weight: float = 1.0,
    heuristic: str = "octile",
    cut_corners: bool = False,
    watch: bool = False,
) -> Plan:
    """The shortest way from start to goal.

    Parameters
    ----------
    grid : GridMap
    start, goal : array_like, shape (2,)  [m, map]
        The way begins and ends in the middle of the cells that they lie in.
    clearance : float  [m]
        Room to keep from obstacles and from the edge of the map, as `inflate` counts it: the
        robot's radius.
    weight : float
        Of the estimate. Above 1 the way may be ``weight`` times as long as the shortest, and
        ``weight - 1`` steps, but is mostly found sooner; 1 to 1.1 count as 1. 0 is Dijkstra's
        search, which estimates nothing.
    heuristic : {"octile", "euclidean", "manhattan"}
        Estimate of what is left. Manhattan counts like a weight √2 times as large.
    cut_corners : bool
        Allow diagonal steps beside an obstacle, even between two.
    watch : bool
        Also tell in which order the search went through the map.

    Returns
    -------
    Plan

    Raises
    ------
    NoPathError
        Start or goal outside the map or in an obstacle, or no way between them.
    ValueError
        A point that is not finite, a negative clearance, or no such weight or heuristic.

    Notes
    -----
    Hart, Nilsson and Raphael 1968, section II. The same input gives the same way to the bit. The
    loop itself is `search.search`.

    Examples
    --------
    >>> grid = GridMap(np.ones((3, 4), dtype=bool), 0.5)
    >>> plan = astar(grid, [0.2, 0.2], [1.8, 1.3])
    >>> plan.cells.tolist(), round(plan.length, 3)
    ([[0, 0], [1, 1], [2, 2], [2, 3]], 1.914)
    """
    rules = _rules(weight, heuristic, cut_corners)
    return _find(checked_task(grid, start, goal, clearance), rules, watch)


def anytime_astar(
    grid: GridMap,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    weights: Sequence[float] = (2.5, 2.0, 1.5, 1.0),
    clearance: float = 0.0,
    heuristic: str = "octile",
    cut_corners: bool = False,
) -> Iterator[Attempt]:
    """A way soon, then better ones: search again with falling weight for as long as there is time.

    Parameters
    ----------
    grid : GridMap
    start, goal : array_like, shape (2,)  [m, map]
    weights : sequence of float
        One search each.
    clearance, heuristic, cut_corners
        As in `astar`.

    Yields
    ------
    Attempt
        After each search. It ends early when the plan is known to be the shortest.

    Raises
    ------
    NoPathError, ValueError
        As `astar`, when the first attempt is asked for.

    Notes
    -----
    Likhachev, Gordon and Thrun 2003. The shortest way is at least as long as the estimate from
    the start, and, after a search with weight w that found the length l, at least
    (l - (w - 1) steps) / w. The bound is the plan's length over the largest of these.

    Examples
    --------
    >>> grid = GridMap(np.ones((30, 30), dtype=bool), 0.1)
    >>> [(a.weight, round(a.bound, 3)) for a in anytime_astar(grid, [0.0, 0.0], [2.9, 1.0])]
    [(2.5, 1.0)]
    """
    task = checked_task(grid, start, goal, clearance)
    away = np.subtract(task.goal, task.start)
    least = moves.estimate(*away.tolist(), moves.OCTILE) / moves.STRAIGHT * grid.resolution
    best = None
    for weight in weights:
        rules = _rules(weight, heuristic, cut_corners)
        plan = _find(task, rules, False)
        w = max(1.0, rules.weight / search.ONE * moves.OVERESTIMATE[rules.heuristic])
        least = max(least, (plan.length - (w - 1.0) * grid.resolution) / w)
        if best is None or plan.length < best.length:
            best = plan
        bound = max(1.0, best.length / least) if least > 0.0 else 1.0
        yield Attempt(weight, best, bound, plan.expanded)
        if bound < 1.0 + 1e-12:
            return


class Rules(NamedTuple):
    """How to search, as the kernel takes it."""

    weight: int
    heuristic: int
    once: bool
    shift: int
    worth: NDArray[np.int64]


@cache
def _worthwhile(cut_corners: bool, once: bool) -> NDArray[np.int64]:
    """The table that every search by the same rules looks into."""
    return moves.worthwhile(cut_corners, once)


def _rules(weight: float, heuristic: str, cut_corners: bool) -> Rules:
    """Everything about the search that is not the map."""
    if not isinstance(heuristic, str) or heuristic not in HEURISTICS:
        raise ValueError(f"heuristic: must be one of {', '.join(HEURISTICS)}, got {heuristic!r}")
    weight = float(as_floats(weight, "weight", finite=False))
    if not 0.0 <= weight <= GREATEST_WEIGHT:
        raise ValueError(f"weight: must be from 0 to {GREATEST_WEIGHT:g}, got {weight!r}")
    code, parts = HEURISTICS[heuristic], floor(weight * search.ONE)
    most = moves.OVERESTIMATE[code] / search.ONE
    excess = parts * most - 1.0
    if 0.0 < excess < LEAST_EXCESS:
        parts, excess = floor(1.0 / most), 0.0
    once = excess > 0.0
    # A bucket spans 2^shift, and no more than ``excess`` steps.
    shift = floor(log2(excess * moves.STRAIGHT)) if once else 30
    return Rules(parts, code, once, shift, _worthwhile(bool(cut_corners), once))


def _find(task: Task, rules: Rules, watch: bool) -> Plan:
    """The plan of one search."""
    width = task.room.shape[1] + 2
    start, goal = ((row + 1) * width + col + 1 for row, col in (task.start, task.goal))
    mark, order, expanded = _searched(task, (start, goal), rules, watch)
    flat = search.trace(mark, width, start, goal)
    way = np.column_stack(np.divmod(flat - width - 1, width))
    seen = order.reshape(-1, width)[1:-1, 1:-1] if watch else None
    return plan_through(task.room, way, expanded, seen)


def _searched(
    task: Task, ends: tuple[int, int], rules: Rules, watch: bool
) -> tuple[NDArray[np.uint8], NDArray[np.int32], int]:
    """Marks that lead back from the goal, the order of the cells, and how many there were."""
    rows, cols = task.room.shape
    cells = (rows + 2) * (cols + 2)
    cost, order = np.empty(cells, np.int64), np.zeros(cells if watch else 0, np.int32)
    levels, entries, expanded = 4096, cells // 16 + 1024, -1
    while expanded < 0:  # hardly ever twice
        mark = moves.prepared(task.room)
        top, pool = np.zeros(levels, np.int32), np.empty((2, entries), np.int32)
        pool[1] = np.arange(1, entries + 1)
        found, expanded = search.search(mark, cols + 2, ends, tuple(rules), cost, order, top, pool)
        levels, entries = (2 * levels, entries) if expanded == -1 else (levels, 2 * entries)
    if found == moves.NEVER:
        raise no_way(task, int((mark > moves.WALL).sum()))
    return mark, order, expanded
