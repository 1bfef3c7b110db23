"""The nearest point of a path, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.tracking.places import (
    HAIRPIN,
    L_SHAPE,
    Path,
    beside,
    point_case,
    some_path,
)
from robocon_course.tracking import PathPoint
from robocon_course.worlds import Student, winding_path


def _nearest_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    doubled = np.repeat(L_SHAPE, 2, axis=0)
    stairs = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.1], [0.6, 0.1], [0.6, 0.5], [1.6, 0.5]])
    rows = [
        ("beside the first segment", L_SHAPE, [0.25, 0.5], 0, inf),
        ("beside the second segment", L_SHAPE, [1.5, 0.5], 0, inf),
        ("before the beginning", L_SHAPE, [-3.0, -4.0], 0, inf),
        ("past the end", L_SHAPE, [1.0, 5.0], 0, inf),
        ("outside the corner", L_SHAPE, [1.3, -0.4], 0, inf),
        ("both legs of a way out and back are as near", HAIRPIN, [0.5, 0.1], 0, inf),
        ("nearer to the way back, but that is far along", HAIRPIN, [0.5, 0.15], 0, 0.3),
        ("nearer to the way back, and all may be searched", HAIRPIN, [0.5, 0.15], 0, inf),
        ("nearer to the way out, but on the way back by now", HAIRPIN, [0.5, 0.05], 2, 0.3),
        ("0.5 m of path lie between, and the search goes on for 0.6 m", stairs, [1.5, 0.4], 3, 0.6),
        ("points that are drawn twice", doubled, [1.5, 0.5], 0, inf),
        ("far along a path: what was walked up to the nearest point does not count", None, 0, 0, 0),
    ]
    long = np.column_stack([np.arange(0.0, 3.05, 0.1), np.zeros(31)])
    rows[-1] = (rows[-1][0], long, [2.52, 0.1], 0, 0.45)
    for _ in range(4):
        path = some_path(rng)
        place, k = beside(path, rng, 0.12)
        rows.append(("any path", path, place, max(0, k - 1), 1.0))
    curve = winding_path(rng, 2.0)
    rows.append(("a bend", curve, np.round(curve[60] + rng.normal(0.0, 0.04, 2), 3), 50, 0.3))
    return [
        point_case(what, tracking.nearest_point, path, np.array(place), start, reach)
        for what, path, place, start, reach in rows
    ]


def _nearest(
    *,
    share_of: Callable[..., float] = lambda s, length: min(max(s, 0.0), 1.0),
    start: Callable[[int], int] = lambda start: start,
    later: int = 0,
    counted: str = "since the nearest",
    strict: bool = True,
    shown: Callable[[PathPoint], PathPoint] = lambda found: found,
) -> Callable[..., PathPoint]:
    """The search with one of its parts wrong."""

    def function(path: Path, point: np.ndarray, start_index: int, reach: float) -> PathPoint:
        best, walked = None, 0.0
        for k in range(min(start(start_index) + later, len(path) - 2), len(path) - 1):
            way = path[k + 1] - path[k]
            length = hypot(*way)
            s = share_of((point - path[k]) @ way / length**2, length) if length else 0.0
            xy = path[k] + s * way
            far = hypot(*(point - xy))
            nearer = best is None or (
                far < best.distance - 1e-9 if strict else far <= best.distance
            )
            if nearer:
                best = PathPoint(k, float(s), (float(xy[0]), float(xy[1])), far)
            if counted == "since the nearest" and nearer:
                walked = (1.0 - s) * length
            elif counted != "never":
                walked += length
            if walked > reach or (counted == "until it rises" and not nearer):
                break
        return shown(best)

    return function


def _nearest_waypoint(path: Path, point: np.ndarray, start_index: int, reach: float) -> PathPoint:
    k = start_index + int(np.hypot(*(path[start_index:] - point).T).argmin())
    index = min(k, len(path) - 2)
    xy = (float(path[k, 0]), float(path[k, 1]))
    return PathPoint(index, float(k - index), xy, hypot(*(point - path[k])))


NEAREST_POINT = Exercise(
    id="tracking.nearest_point",
    title="The nearest point of the path, from here on",
    points=3,
    reference=tracking.nearest_point,
    cases=_nearest_cases,
    shortcuts=(
        "robocon_course.tracking.polyline.nearest",
        "robocon_course.tracking.polyline.look",
        "robocon_course.tracking.along.walk",
        "robocon_course.tracking.pursuit.pure_pursuit",
        "robocon_course.tracking.pursuit.pursue",
    ),
    hints=(
        "One segment first: from a = path[k] along d = path[k + 1] − a. The foot of the "
        "perpendicular is at share (point − a) · d / (d · d), cut to between 0 and 1.",
        "Go through the segments from start_index on and keep the nearest so far. A segment of "
        "length 0 has share 0.",
        "Count how much path was walked since the nearest point so far: (1 − share) · length when "
        "a nearer one is found, plus the whole length of each segment that is not nearer. Stop "
        "when that exceeds reach.",
        "Of two that are as near the first counts: take a new one only if it is nearer by 1e-9.",
    ),
    mistakes=(
        Mistake(
            "nearest waypoint",
            "This finds the nearest waypoint. Between two waypoints the path is a line: the "
            "nearest point lies on a segment.",
            _nearest_waypoint,
        ),
        Mistake(
            "share not limited",
            "The foot of the perpendicular lies beyond the segment's end. Cut share to between 0 "
            "and 1.",
            _nearest(share_of=lambda s, length: s),
        ),
        Mistake(
            "share limited at the end only",
            "The foot of the perpendicular lies before the segment's beginning: share must not be "
            "negative either.",
            _nearest(share_of=lambda s, length: min(s, 1.0)),
        ),
        Mistake(
            "length not squared",
            "share is (point − a) · d divided by d · d, the length squared. Divided by the length "
            "it is in metres.",
            _nearest(share_of=lambda s, length: min(max(s * length, 0.0), 1.0)),
        ),
        Mistake(
            "start_index ignored",
            "The search begins at the path's beginning. It has to begin at start_index: where the "
            "path comes back on itself the robot would jump to another leg.",
            _nearest(start=lambda start: 0),
        ),
        Mistake(
            "one segment too far",
            "The search begins one segment after start_index.",
            _nearest(later=1),
        ),
        Mistake(
            "reach ignored",
            "The search does not stop at reach: where the path comes back on itself the robot "
            "jumps to another leg.",
            _nearest(counted="never"),
        ),
        Mistake(
            "reach counted from the start",
            "reach is counted from where the search began. It counts from the nearest point so "
            "far: begin anew whenever one is found.",
            _nearest(counted="from the start"),
        ),
        Mistake(
            "stops when it rises",
            "The search stops at the first segment that is not nearer. A path may go away and come "
            "nearer again within reach.",
            _nearest(counted="until it rises"),
        ),
        Mistake(
            "the last of equals",
            "Two legs are as near, and this takes the later one: the robot skips the way between. "
            "Take a new point only if it is nearer.",
            _nearest(strict=False),
        ),
        Mistake(
            "distance squared",
            "The distance is squared: the root is missing.",
            _nearest(shown=lambda found: found._replace(distance=found.distance**2)),
        ),
        Mistake(
            "index of the end",
            "index is the waypoint at the segment's end. It is the one at its beginning: the "
            "segment goes from point index to index + 1.",
            _nearest(shown=lambda found: found._replace(index=found.index + 1)),
        ),
    ),
)
