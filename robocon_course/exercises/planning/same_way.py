"""Is an answer a shortest way? Which of several it is does not matter."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import NOTHING, difference, kind_of
from robocon_course.exercises.model import Case
from robocon_course.exercises.planning.maps import as_points, way_of
from robocon_course.gridmap import GridMap
from robocon_course.planning import Plan, neighbours, octile_distance
from robocon_course.planning.steps import ROOT_2

CLOSE = 1e-6


def way_case(
    what: str,
    grid: GridMap,
    start: np.ndarray,
    goal: np.ndarray,
    *,
    most: int | None = None,
    timed: str = "",
) -> Case:
    """A case whose answer is right if it is a shortest way, or says that there is none.

    Parameters
    ----------
    what : str
        The situation in words.
    grid : GridMap
    start, goal : ndarray, shape (2,)  [m, map]
    most : int, optional
        From more cells than this no search goes on that looks to the goal.
    timed : str
        As in `Case`.
    """

    def judge(reply: Reply) -> str | None:
        best = way_of(grid, start, goal)
        if best is None:
            return _refusal(reply)
        if reply.error:
            return f"{reply.error}: {reply.message}"
        wrong = _form(reply.value) or _ends(reply.value, best) or _steps(reply.value, grid)
        return wrong or _length(reply.value, best, grid) or _effort(reply.value.expanded, most)

    return Case(what, (grid, start, goal), "m", judge=judge, traits=_traits, timed=timed)


def looked_at(shape: tuple[int, int], start: tuple[int, int], goal: tuple[int, int]) -> int:
    """Cells that A* may go on from on an empty map: those on a way not a step too long."""
    best = octile_distance(start, goal) + 1.0
    every = np.argwhere(np.ones(shape, dtype=bool)).tolist()
    return sum(octile_distance(start, c) + octile_distance(c, goal) <= best for c in every)


def _refusal(reply: Reply) -> str | None:
    """There is no way: that must be said, not returned."""
    if reply.error == "NoPathError":
        return None
    if reply.error:
        return f"expected a NoPathError, got {reply.error}: {reply.message}"
    return "there is no way, so raise planning.NoPathError; the function returned something"


def _form(plan: Any) -> str | None:
    if plan is None:
        return NOTHING
    if type(plan) is not Plan:
        makes = "planning.plan_through(grid, cells, expanded) makes the plan"
        return f"expected a planning.Plan, got {kind_of(plan)}; {makes}"
    cells, xy = as_points(plan.cells), as_points(plan.xy)
    if cells is None or xy is None:
        return "cells and xy: expected two arrays of shape (n, 2)"
    if len(xy) != len(cells) or (cells != np.rint(cells)).any():
        return "cells and xy: expected whole numbers, and a point for each cell"
    return None


def _ends(plan: Plan, best: Plan) -> str | None:
    for place, at in (("begin", 0), ("end", -1)):
        came, wanted = (tuple(np.asarray(p.cells)[at].astype(int).tolist()) for p in (plan, best))
        if came != wanted:
            return f"the way has to {place} in cell {wanted}, and it does in {came}"
    return None


def _steps(plan: Plan, grid: GridMap) -> str | None:
    cells = [tuple(cell) for cell in np.asarray(plan.cells).astype(int).tolist()]
    for here, to in pairwise(cells):
        if to in (step for step, _ in neighbours(grid, here)):
            continue
        if max(abs(to[0] - here[0]), abs(to[1] - here[1])) != 1:
            return f"from {here} to {to} is no step to a neighbour"
        if to in (step for step, _ in neighbours(grid, here, cut_corners=True)):
            return f"the step from {here} to {to} cuts the corner of an obstacle"
        return f"the step from {here} leads to {to}, which is not free"
    return None


def _length(plan: Plan, best: Plan, grid: GridMap) -> str | None:
    real = grid.resolution * _cells_long(plan)
    if real > best.length + CLOSE:
        return f"the way is {real:.3f} m long, and there is one of {best.length:.3f} m"
    if difference(plan.xy, grid.centres(plan.cells), CLOSE):
        return "xy: expected the middles of the cells; planning.plan_through makes them"
    if difference(plan.length, real, CLOSE):
        return f"length: expected {real:.3f} m; planning.plan_through counts it"
    return None


def _effort(expanded: Any, most: int | None) -> str | None:
    if isinstance(expanded, bool) or not isinstance(expanded, int) or expanded < 0:
        return "expanded: expected the number of cells from which the search went on"
    if most is not None and expanded > most:
        return (
            f"the way is right, but the search went on from {expanded} cells; "
            f"with h it takes {most} at most"
        )
    return None


def _cells_long(plan: Plan) -> float:
    diagonal = np.diff(np.asarray(plan.cells), axis=0).all(axis=1)
    return float(np.where(diagonal, ROOT_2, 1.0).sum())


def _traits(plan: Plan) -> tuple:
    """Where a way begins and ends, and how long it is."""
    cells: NDArray[np.int64] = np.asarray(plan.cells).astype(int)
    ends = (*cells[0].tolist(), *cells[-1].tolist())
    return (*ends, len(cells), round(_cells_long(plan), 6), round(float(plan.length), 6))
