"""The challenge: round the bends that cost time, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from robocon_course import field, worlds
from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import NOTHING, difference
from robocon_course.exercises.model import Case, Exercise, Mistake, Score
from robocon_course.exercises.planning.maps import as_points
from robocon_course.gridmap import GridMap, inflate_square
from robocon_course.planning import (
    NoPathError,
    astar,
    line_of_sight,
    resample_path,
    shorten_path,
    smooth_path,
    thin_path,
)
from robocon_course.worlds import Student

LIMIT = 5.0
"""One over the smallest radius [1/m]."""
WORTH = 1.12
"""So many times as long as the course's own way takes the way as it comes."""
LARGEST = 20_000  # points


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases: list[Case] = []
    while len(cases) < 3:
        room = inflate_square(worlds.passable_field(rng), worlds.HALF)
        xy = shorten_path(room, astar(room, field.START, field.AREA_3_GOAL).xy)
        try:
            best = worlds.driving_time(smooth_path(room, xy, LIMIT), LIMIT)
        except NoPathError:
            continue
        first = worlds.driving_time(xy, LIMIT)
        if first > WORTH * best:
            cases.append(_smooth_case(room, xy, (first, best)))
    return cases


def _smooth_case(room: GridMap, xy: np.ndarray, times: tuple[float, float]) -> Case:
    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        return _problem(reply.value, room, xy)

    return Case("a way past boxes", (room, xy, LIMIT), judge=judge, truth=times)


def _problem(value: Any, room: GridMap, xy: np.ndarray) -> str | None:
    came = as_points(value)
    if value is None:
        return NOTHING
    if came is None or len(came) > LARGEST:
        return f"expected an array of finite points, shape (m, 2), with m up to {LARGEST}"
    for place, at in (("first", 0), ("last", -1)):
        if difference(came[at], xy[at], 1e-6):
            return f"the {place} point has to stay ({xy[at, 0]:.3f}, {xy[at, 1]:.3f}) m"
    for one, other in pairwise(came):
        if not line_of_sight(room, one, other):
            return "the way leaves the free cells near ({:.2f}, {:.2f}) m".format(*one)
    return None


def _missed(case: Case, value: Any) -> float:
    """How much is missed of the time that the course's own way gains [%]."""
    first, best = case.truth
    missed = 100.0 * (worlds.driving_time(value, LIMIT) - best) / (first - best)
    return max(missed, 0.0)  # in this order: what is not a number stays so


def _averaged(look: bool, sweeps: int = 40) -> Callable[..., np.ndarray]:
    """Each point moved into the middle of its neighbours."""

    def function(grid: GridMap, xy: np.ndarray, max_curvature: float) -> np.ndarray:
        points = resample_path(xy, 0.05)
        for _ in range(sweeps):
            middles = (points[:-2] + points[2:]) / 2.0
            free = grid.is_free(middles) if look else np.ones(len(middles), dtype=bool)
            points[1:-1] = np.where(free[:, None], middles, points[1:-1])
        return points

    return function


def _corners_cut(grid: GridMap, xy: np.ndarray, max_curvature: float) -> np.ndarray:
    """Chaikin's rule: each corner replaced by two, a quarter of a leg beside it."""
    for _ in range(4):
        one, other = xy[:-1], xy[1:]
        inner = np.stack([0.75 * one + 0.25 * other, 0.25 * one + 0.75 * other], axis=1)
        xy = np.vstack([xy[:1], inner.reshape(-1, 2)[1:-1], xy[-1:]])
    return xy


SMOOTH_PATH = Exercise(
    id="planning.smooth_path",
    title="Challenge: bends that can be driven",
    points=4,
    reference=smooth_path,
    shortcuts=("robocon_course.planning.smoothing.relax",),
    cases=_cases,
    time_limit=60.0,
    score=Score(_missed, "% of the possible gain missed", ((40.0, 1.0), (85.0, 0.5))),
    hints=(
        "First put points on the legs, 5 cm apart, and keep the corners. Then look where "
        "planning.path_curvature is above the limit.",
        "There push the point inwards, along p[i-1] - 2 p[i] + p[i+1], and its neighbours half as "
        "much outwards. Move a point only if both neighbours still see it.",
        "push = (p[i-1] - 2 * p[i] + p[i+1]) * (1 - 0.95 * max_curvature / bend) / 4, with the "
        "bend that point i has now; move i by 2 * push and i ± 1 by -push; again and again, until "
        "nothing bends too much.",
    ),
    mistakes=(
        Mistake(
            "unchanged",
            "The way is as it came: at every corner the robot has to stop.",
            lambda grid, xy, max_curvature: np.array(xy),
        ),
        Mistake(
            "more points on the same legs",
            "There are more points, on the same legs: the corners are still there.",
            lambda grid, xy, max_curvature: _dense(xy),
        ),
        Mistake(
            "averaged through obstacles",
            "Points were averaged without a look at the map. A way around an obstacle shrinks into "
            "it: ask planning.line_of_sight before you move a point.",
            _averaged(look=False),
        ),
        Mistake(
            "averaged, points looked at",
            "Single points were asked whether they are free. The line between two of them can "
            "still touch an obstacle: ask planning.line_of_sight.",
            _averaged(look=True),
        ),
        Mistake(
            "corners cut off",
            "The corners were cut off. They stand where they are because an obstacle is beside "
            "them: swing out first.",
            _corners_cut,
        ),
        Mistake(
            "straight to the goal",
            "Only the ends are left, and the line between them goes through obstacles.",
            lambda grid, xy, max_curvature: np.array(xy)[[0, -1]],
        ),
        Mistake(
            "thinned",
            "Points were left out, and the way cuts the corner of an obstacle.",
            lambda grid, xy, max_curvature: thin_path(_dense(xy), 1.0),
        ),
        Mistake(
            "goal lost",
            "The way no longer ends at the goal.",
            lambda grid, xy, max_curvature: smooth_path(grid, xy, max_curvature)[:-1],
        ),
        Mistake(
            "start lost",
            "The way no longer begins where the robot stands.",
            lambda grid, xy, max_curvature: smooth_path(grid, xy, max_curvature)[1:],
        ),
    ),
)


def _dense(xy: np.ndarray) -> np.ndarray:
    """Points on the legs, the corners kept."""
    legs = [resample_path(leg, 0.05)[:-1] for leg in pairwise(xy)]
    return np.vstack([*legs, xy[-1:]])
