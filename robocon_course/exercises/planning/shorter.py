"""Straight legs for a way, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from robocon_course import field, worlds
from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import NOTHING, difference
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.planning.maps import (
    as_points,
    drawn_grid,
    some_ends,
    some_grid,
    way_of,
)
from robocon_course.gridmap import GridMap, inflate_square
from robocon_course.planning import (
    line_of_sight,
    path_length,
    shorten_path,
)
from robocon_course.worlds import Student

LONGER = 1.005
"""So many times as long as the worst greedy way an answer may be."""


SHELF = "......... ......... ..#####.. ......... ........."


def short_case(what: str, grid: GridMap, xy: np.ndarray) -> Case:
    """A case whose answer is right if it is tight, in sight, and has the same ends."""

    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        came = as_points(reply.value)
        if came is None:
            return NOTHING if reply.value is None else "expected finite points, shape (m, 2)"
        for place, at in (("first", 0), ("last", -1)):
            if difference(came[at], xy[at], 1e-9):
                return f"the {place} point has to stay ({xy[at, 0]:.3f}, {xy[at, 1]:.3f}) m"
        for one, other in pairwise(came):
            if not line_of_sight(grid, one, other):
                ends = "({:.2f}, {:.2f}) to ({:.2f}, {:.2f})".format(*one, *other)
                return f"the leg from {ends} m touches cells that are not free"
        most = LONGER * max(path_length(way) for way in _greedy_ways(grid, xy))
        if path_length(came) > most:
            return (
                f"your way is {path_length(came):.3f} m long; looking for the last point in sight "
                f"gives at most {most:.3f} m"
            )
        return None

    return Case(what, (grid, xy), "m", judge=judge)


def _greedy_ways(grid: GridMap, xy: np.ndarray) -> list[np.ndarray]:
    """Ways that honest answers find: to the last point in sight, or up to the first hidden one."""
    return [
        _greedy(grid, xy, far=True),
        _greedy(grid, xy[::-1], far=True),
        _greedy(grid, xy, far=False),
        _greedy(grid, xy[::-1], far=False),
    ]


def _greedy(grid: GridMap, xy: np.ndarray, *, far: bool) -> np.ndarray:
    kept = [0]
    while kept[-1] < len(xy) - 1:
        at = kept[-1]
        seen = [line_of_sight(grid, xy[at], xy[k]) for k in range(at + 1, len(xy))]
        ahead = len(seen) - seen[::-1].index(True) if far and any(seen) else None
        if ahead is None:
            ahead = seen.index(False) if False in seen else len(seen)
        kept.append(at + max(ahead, 1))
    return xy[kept]


def _short_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    shelf = drawn_grid(SHELF, 0.2)
    ends = shelf.centres([(0, 1), (4, 7)])
    cases = [("around a shelf", shelf, way_of(shelf, *ends).xy)]
    while len(cases) < 6:
        grid = some_grid(rng, 26, 30, 0.06)
        best = way_of(grid, *some_ends(rng, grid))
        if best and _is_worth(grid, best.xy):
            cases.append(("a map of your own", grid, best.xy))
    room = inflate_square(worlds.passable_field(rng), worlds.HALF)
    best = way_of(room, np.array(field.START), np.array(field.AREA_3_GOAL))
    cases.append(("the game field with boxes", room, best.xy))
    return [short_case(*case) for case in cases]


def _is_worth(grid: GridMap, xy: np.ndarray) -> bool:
    """Whether a way has a bend that is needed, and others that are not."""
    greedy = max(path_length(way) for way in _greedy_ways(grid, xy))
    return not line_of_sight(grid, xy[0], xy[-1]) and path_length(xy) > 1.02 * greedy


def _bends(grid: GridMap, xy: np.ndarray) -> np.ndarray:
    """Only the points at which the direction changes."""
    turns = np.abs(np.diff(np.diff(xy, axis=0), axis=0)).max(axis=1, initial=0.0) > 1e-9
    return xy[np.concatenate([[True], turns, [True]])]


def _by_middle(grid: GridMap, a: np.ndarray, b: np.ndarray) -> bool:
    return bool(grid.is_free((a + b) / 2.0))


def _seen(sight: Callable[..., bool]) -> Callable[..., np.ndarray]:
    """To the last point that a wrong rule calls visible."""

    def function(grid: GridMap, xy: np.ndarray) -> np.ndarray:
        kept = [0]
        while kept[-1] < len(xy) - 1:
            at, to = kept[-1], len(xy) - 1
            while to > at + 1 and not sight(grid, xy[at], xy[to]):
                to -= 1
            kept.append(to)
        return xy[kept]

    return function


SHORTEN_PATH = Exercise(
    id="planning.shorten_path",
    title="Straight legs, as long as can be seen",
    points=3,
    reference=shorten_path,
    shortcuts=(
        "robocon_course.planning.sight.pull_tight",
        "robocon_course.planning.smoothing.smooth_path",
    ),
    cases=_short_cases,
    time_limit=20.0,
    hints=(
        "Stand at the first point. Which is the last one that you see? Go there, and look again.",
        "Try the points from the end of the way backwards, until planning.line_of_sight(grid, "
        "xy[at], xy[to]) says yes; the next point is always in sight.",
        "to = len(xy) - 1; while to > at + 1 and not planning.line_of_sight(grid, xy[at], xy[to]): "
        "to -= 1; then keep xy[to], and at = to.",
    ),
    mistakes=(
        Mistake(
            "unchanged",
            "All points are still there. Leave out those that are not needed.",
            lambda grid, xy: xy.copy(),
        ),
        Mistake(
            "only points on a line",
            "Only points in the middle of straight pieces are left out. The way still goes along "
            "eight directions: look how far you can see.",
            _bends,
        ),
        Mistake(
            "straight to the goal",
            "Only the two ends are left. The line between them goes through obstacles.",
            lambda grid, xy: xy[[0, -1]],
        ),
        Mistake(
            "only the middle looked at",
            "A leg counts as free when its middle is. Look at all of it: planning.line_of_sight.",
            _seen(_by_middle),
        ),
        Mistake(
            "goal lost",
            "The last point is missing.",
            lambda grid, xy: _seen(line_of_sight)(grid, xy)[:-1],
        ),
        Mistake(
            "start lost",
            "The first point is missing.",
            lambda grid, xy: _seen(line_of_sight)(grid, xy)[1:],
        ),
        Mistake(
            "every tenth point",
            "This keeps every tenth point, whatever stands between.",
            lambda grid, xy: np.vstack([xy[:-1:10], xy[-1:]]),
        ),
        Mistake(
            "the wrong way round",
            "The way runs from goal to start.",
            lambda grid, xy: _seen(line_of_sight)(grid, xy)[::-1],
        ),
    ),
)
