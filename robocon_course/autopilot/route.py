"""From two points on the field to a path with a speed for each of its points.

    bitmap → room for the body → A* → pulled tight → rounded → speeds

The body is a square that keeps its heading, so its room is a square too: a disc as wide as the body
lets a corner of it touch the corner of an obstacle. Between body and obstacles a margin stays free,
for what tracking and odometry are off; near start and goal, where somebody put the robot, none is
asked for. Where a passage is too narrow for the margin, it gets smaller.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.autopilot.parts import Parts
from robocon_course.geometry import distance_along
from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError, Plan, line_of_sight
from robocon_course.planning.plans import checked_task
from robocon_course.robot import SIDE
from robocon_course.tracking.polyline import as_path

MARGINS = (0.12, 0.06, 0.0)
"""Room between body and obstacles, as much as there is [m]."""
NEAR_END = 0.4
"""So near to start and goal, in x and y, no margin is asked for [m]."""


class DriveLimits(NamedTuple):
    """How a path is driven.

    Attributes
    ----------
    speed : float  [m/s]
    accel : float  [m/s^2]
        Along the path; the floor holds 5.9.
    lateral : float  [m/s^2]
        Across it, in bends.
    curvature : float  [1/m]
        The path bends no more.
    arrive : float  [m/s]
        So fast it may still be at the end of a straight way; a planned one ends at rest.
    """

    speed: float = 2.0
    accel: float = 2.0
    lateral: float = 1.5
    curvature: float = 2.5
    arrive: float = 0.0


class Route(NamedTuple):
    """A path to drive.

    Attributes
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
        From start to goal.
    along : ndarray, shape (n,)  [m]
        Way from the start to each point.
    speeds : ndarray, shape (n,)  [m/s]
    plan : Plan or None
        The cells that it was made of, if a search made it.
    margin : float  [m]
        Room that the body keeps, as far as known.
    """

    xy: FloatArray
    along: FloatArray
    speeds: FloatArray
    plan: Plan | None = None
    margin: float = 0.0


def plan_route(
    parts: Parts,
    grid: GridMap,
    start: ArrayLike,
    goal: ArrayLike,
    *,
    limits: DriveLimits = DriveLimits(),  # noqa: B008 - a NamedTuple cannot change
) -> Route:
    """The robot's way from two points to a path and its speeds.

    Parameters
    ----------
    parts : Parts
    grid : GridMap
        Free where no obstacle stands.
    start, goal : array_like, shape (2,)  [m, map]
        Of the robot's middle; it looks along an axis of the map all the way.
    limits : DriveLimits

    Returns
    -------
    Route

    Raises
    ------
    NoPathError
        The body does not fit where start or goal are, or no way leads from one to the other.
    ValueError
        Points that are not finite.
    """
    ends = np.stack([as_floats(start, "start", 2), as_floats(goal, "goal", 2)])
    checked_task(grid, *ends, 0.0)  # says in metres what the search would say in cells
    tight = _checked_room(parts, grid, ends)
    for margin in MARGINS:
        room = room_for_body(parts, grid, ends, margin, tight=tight)
        try:
            plan = parts.astar(room, *ends)
            break
        except NoPathError:
            if margin == MARGINS[-1]:
                raise
    xy = np.array(plan.xy, float)
    if len(xy) > 1:
        short = parts.shorten_path(room, _with_ends(room, xy, ends))
        xy = np.asarray(parts.smooth_path(room, short, limits.curvature), float)
    if len(xy) < 3:  # the goal lies in the start's own cell or beside it: a profile needs a middle
        xy = np.linspace(*ends, 3)
    xy = as_path(xy)  # checked once, looked at in every tick
    speeds = parts.speed_profile(xy, limits.speed, limits.accel, limits.lateral)
    return Route(xy, distance_along(xy), np.asarray(speeds, float), plan, margin)


def _with_ends(room: GridMap, xy: FloatArray, ends: FloatArray) -> FloatArray:
    """A way with the very start and goal in place of the middles of their cells, where it can be.

    A start on the edge of its cell, with an obstacle's room beside it, stays in the middle: the
    robot stands so much beside its path at first.
    """
    for place, beside, end in ((0, 1, ends[0]), (-1, -2, ends[1])):
        if line_of_sight(room, end, xy[beside]):
            xy[place] = end
    return xy


def _checked_room(parts: Parts, grid: GridMap, ends: FloatArray) -> GridMap:
    """Room for the bare body; refuses an end that is free, but not for the whole of it."""
    room = parts.inflate_square(grid, 0.5 * SIDE)
    for name, (x, y), fit in zip(("start", "goal"), ends, room.is_free(ends), strict=True):
        if not fit:
            raise NoPathError(
                f"{name}: at ({x:g}, {y:g}) m the body of {SIDE:g} m stands in an obstacle or in "
                f"the fence; its middle needs {0.5 * SIDE:g} m on each side",
                "blocked",
            )
    return room


def room_for_body(
    parts: Parts, grid: GridMap, ends: FloatArray, margin: float, *, tight: GridMap | None = None
) -> GridMap:
    """Where the middle of the body may be: with a margin, but near the ends without.

    Parameters
    ----------
    parts : Parts
    grid : GridMap
    ends : ndarray, shape (k, 2)  [m, map]
    margin : float  [m]
    tight : GridMap, optional
        Room for the bare body, where it is known already.

    Returns
    -------
    GridMap
    """
    tight = tight or parts.inflate_square(grid, 0.5 * SIDE)
    if margin == 0.0:
        return tight
    free = parts.inflate_square(grid, 0.5 * SIDE + margin).free.copy()
    for end in ends:
        first, last = grid.cells([end - NEAR_END, end + NEAR_END]).clip(0)
        around = slice(first[0], last[0] + 1), slice(first[1], last[1] + 1)
        free[around] |= tight.free[around]
    return GridMap(free, grid.resolution, grid.origin)
