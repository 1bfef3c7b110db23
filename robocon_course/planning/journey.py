"""Through a place that is not known: go, look, and plan anew where the plan meets an obstacle.

    look → know more → does an obstacle stand in the plan? → plan from here → one cell on

What has not been seen counts as free. So the robot always has somewhere to go, every obstacle that
stops it is one more that it knows, and at last it arrives, or knows that there is no way.

Source: "dynamic A*", a search again from here at every obstacle, as in A. Stentz, Optimal and
Efficient Path Planning for Partially-Known Environments, ICRA 1994, which repairs instead.
"""

from __future__ import annotations

from collections.abc import Callable
from math import ceil, cos, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.gridmap import GridMap
from robocon_course.planning.path import as_positive
from robocon_course.planning.plans import Plan, checked_task, inflated
from robocon_course.planning.replanning import Replanner
from robocon_course.planning.sight import in_cells
from robocon_course.raycast import walk


class Leg(NamedTuple):
    """One plan on a journey.

    Attributes
    ----------
    at : ndarray, shape (2,)  [m, map]
        Where the robot was when it made the plan.
    found : ndarray of int64, shape (n, 2)
        (row, col) of the obstacles it found since the plan before.
    plan : Plan
    """

    at: FloatArray
    found: NDArray[np.int64]
    plan: Plan


class Journey(NamedTuple):
    """The way that was driven, and how it came about.

    Attributes
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
        Middles of the cells, in order.
    legs : tuple of Leg
        One per plan; ``len(legs) - 1`` times the robot had to plan anew.
    known : GridMap
        What the robot knew in the end.
    """

    xy: FloatArray
    legs: tuple[Leg, ...]
    known: GridMap


@njit(cache=True)
def look(blocked, x, y, reach, beams, seen):
    """Mark every cell that a beam all around meets, the one that stops it included.

    Parameters
    ----------
    blocked : ndarray of uint8, shape (rows, cols)
        1 where a cell stops a beam, 0 where not.
    x, y : float  [cells]
    reach : float  [cells]
    beams : int
    seen : ndarray of bool, shape (rows, cols)
        Changed in place.
    """
    met = np.empty((2 * int(reach) + 4, 2), np.int64)
    for k in range(beams):
        angle = 2.0 * pi * k / beams
        _, count = walk(blocked, x, y, 0.5, cos(angle), sin(angle), 0.0, reach, met)
        for i in range(min(count, len(met))):
            seen[met[i, 0], met[i, 1]] = True


def visible_cells(grid: GridMap, xy: ArrayLike, reach: float) -> NDArray[np.bool_]:
    """The cells that a sensor sees that looks all around: up to the first obstacle.

    Parameters
    ----------
    grid : GridMap
        What there is.
    xy : array_like, shape (2,)  [m, map]
    reach : float  [m]

    Returns
    -------
    ndarray of bool, shape (rows, cols)
        Free cells and the first obstacle on each beam; beams lie at most half a cell apart. From
        outside the map nothing is seen.

    Raises
    ------
    ValueError
        Not finite, or a reach that is not positive.

    Examples
    --------
    >>> visible_cells(GridMap(np.array([[True, True, False, True]]), 1.0), [0.5, 0.5], 9.0).tolist()
    [[True, True, True, False]]
    """
    cells = min(as_positive(reach, "reach") / grid.resolution, float(sum(grid.shape)))
    seen = np.zeros(grid.shape, dtype=bool)
    blocked = np.logical_not(grid.free).view(np.uint8)
    x, y = in_cells(grid, as_floats(xy, "xy", 2))
    look(blocked, x, y, cells, max(64, ceil(4.0 * pi * cells)), seen)
    return seen


def travel(
    truth: GridMap,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    reach: float,
    clearance: float = 0.0,
    known: GridMap | None = None,
    planner: Callable[[GridMap, FloatArray], Plan] | None = None,
    room: Callable[[GridMap], GridMap] | None = None,
) -> Journey:
    """Drive to a goal through obstacles that the robot does not know until it sees them.

    Parameters
    ----------
    truth : GridMap
        What there is.
    start, goal : array_like, shape (2,)  [m, map]
    reach : float  [m]
        How far the robot sees.
    clearance : float  [m]
        As in `astar`.
    known : GridMap, optional
        What the robot knows at first; without it, that all is free.
    planner : callable, optional
        ``planner(known, xy)`` gives the plan from xy to the goal, with the same clearance. A
        `Replanner` without it; ``lambda grid, xy: astar(grid, xy, goal)`` starts from nothing each
        time.
    room : callable, optional
        ``room(known)`` is the map for the robot's middle, in the place of ``clearance``: for a
        body that is not round. A planner of one's own has to use it, too.

    Returns
    -------
    Journey

    Raises
    ------
    NoPathError
        As far as the robot knows at last, there is no way.
    ValueError
        Maps that do not lie on each other, or anything that `astar` refuses.
    """
    checked_task(truth, start, goal, 0.0)
    room = room or (lambda grid: inflated(grid, clearance))
    planner = planner or _through(room, Replanner(goal))
    known = known or GridMap(np.ones(truth.shape, dtype=bool), truth.resolution, truth.origin)
    if _frame(known) != _frame(truth):
        raise ValueError("known: must have the shape, resolution and origin of truth")
    driven, legs, found = [truth.centres(truth.cells(start))], [], []
    ahead = np.empty((0, 2), np.int64)
    while not legs or len(ahead) > 1:
        known, new = _learnt(truth, known, visible_cells(truth, driven[-1], reach))
        found.append(new)
        if not legs or (len(new) and not _is_open(room(known), ahead)):
            _back_out(room(known), driven)
            plan = planner(known, driven[-1])
            legs.append(Leg(driven[-1], np.concatenate(found), plan))
            ahead, found = plan.cells, []
        if len(ahead) > 1:
            ahead = ahead[1:]
            driven.append(truth.centres(ahead[0]))
    return Journey(np.array(driven), tuple(legs), known)


def _through(
    room: Callable[[GridMap], GridMap], replanner: Replanner
) -> Callable[[GridMap, FloatArray], Plan]:
    """The planner that mends its plan through the room there is."""
    return lambda known, xy: replanner.plan(room(known), xy)


def _frame(grid: GridMap) -> tuple[object, ...]:
    return grid.shape, grid.resolution, grid.origin


def _learnt(
    truth: GridMap, known: GridMap, seen: NDArray[np.bool_]
) -> tuple[GridMap, NDArray[np.int64]]:
    """What is known after a look, and the obstacles that were not known before."""
    new = np.argwhere(seen & known.free & ~truth.free)
    if not (seen & (known.free != truth.free)).any():
        return known, new
    free = np.where(seen, truth.free, known.free)
    return GridMap(free, known.resolution, known.origin), new


def _is_open(room: GridMap, cells: NDArray[np.int64]) -> bool:
    """Whether a way is still free, the cells beside its diagonal steps too."""
    (rows, cols), (after, beside) = cells[:-1].T, cells[1:].T
    free = room.free
    return bool((free[after, beside] & free[rows, beside] & free[after, cols]).all())


def _back_out(room: GridMap, driven: list[FloatArray]) -> None:
    """Go back the way that was driven, as far as what was seen last stands too near."""
    for point in driven[-2::-1]:
        if room.is_free(driven[-1]):
            return
        driven.append(point)
