"""The look-ahead point of a path, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, sqrt

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.tracking.places import L_SHAPE, Path, beside, point_case, some_path
from robocon_course.tracking import PathPoint
from robocon_course.worlds import Student


def _lookahead_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    doubled = np.repeat(L_SHAPE, 2, axis=0)
    bow = np.array([[0.0, 0.0], [0.6, 0.0], [0.6, 0.6], [0.0, 0.6], [0.0, 1.5]])
    rows = [
        ("on a straight line", L_SHAPE, [0.2, 0.0], 0.5, 0, 0.2),
        ("beside a straight line", L_SHAPE, [0.2, 0.3], 0.5, 0, 0.2),
        ("round the corner", L_SHAPE, [0.4, 0.0], 1.0, 0, 0.4),
        ("half along the second segment", L_SHAPE, [1.0, 1.0], 0.4, 1, 0.5),
        ("the end is nearer than that", L_SHAPE, [1.0, 1.8], 0.5, 1, 0.9),
        ("farther off the path than that", L_SHAPE, [0.5, 0.9], 0.6, 0, 0.5),
        ("the path leaves the circle, comes back and leaves again", bow, [0.1, 0.1], 0.65, 0, 0.1),
        ("points that are drawn twice", doubled, [0.4, 0.0], 1.0, 1, 0.4),
    ]
    for _ in range(5):
        path = some_path(rng)
        place, k = beside(path, rng, 0.1)
        foot = tracking.nearest_point(path, place, k, 0.3)
        far = round(float(rng.uniform(0.25, 0.7)), 3)
        rows.append(("any path", path, place, far, foot.index, round(foot.share, 6)))
    return [
        point_case(what, tracking.lookahead_point, path, np.array(place), far, k, share)
        for what, path, place, far, k, share in rows
    ]


def _crossing(a: np.ndarray, way: np.ndarray, point: np.ndarray, far: float, sign: float) -> float:
    """Share of a segment at which a circle is crossed: the larger root, or the other."""
    square, b, c = way @ way, (a - point) @ way, (a - point) @ (a - point) - far**2
    return float((-b + sign * sqrt(max(b * b - square * c, 0.0))) / square)


def _unguarded(a: np.ndarray, way: np.ndarray, point: np.ndarray, far: float) -> float:
    """The larger root, nan where there is none."""
    inside = ((a - point) @ way) ** 2 - way @ way * ((a - point) @ (a - point) - far**2)
    return _crossing(a, way, point, far, 1.0) if inside >= 0.0 else float("nan")


def _ahead(
    *,
    begin: Callable[[int, float], tuple[int, float]] = lambda index, share: (index, share),
    share_of: Callable[..., float] = lambda a, way, p, far: _crossing(a, way, p, far, 1.0),
    end: Callable[..., PathPoint] | None = None,
    off_path: bool = True,
) -> Callable[..., PathPoint]:
    """The search for the look-ahead point with one of its parts wrong."""

    def function(
        path: Path, point: np.ndarray, lookahead: float, index: int, share: float
    ) -> PathPoint:
        def at(k: int, s: float) -> PathPoint:
            xy = path[k] + s * (path[k + 1] - path[k])
            return PathPoint(k, float(s), (float(xy[0]), float(xy[1])), hypot(*(xy - point)))

        first, s = begin(index, share)
        for k in range(first, len(path) - 1):
            s = s if k == first else 0.0
            if off_path and at(k, s).distance >= lookahead:
                return at(k, s)
            if at(k, 1.0).distance >= lookahead:
                way = path[k + 1] - path[k]
                return at(k, share_of(path[k], way, point, lookahead))
        return end(path, point, lookahead) if end else at(len(path) - 2, 1.0)

    return function


def _along(path: Path, point: np.ndarray, lookahead: float, index: int, share: float) -> PathPoint:
    """So far along the path, instead of straight from the point."""
    left = lookahead
    for k in range(index, len(path) - 1):
        way, s = path[k + 1] - path[k], share if k == index else 0.0
        length = hypot(*way)
        if (1.0 - s) * length >= left:
            s += left / length
            break
        left -= (1.0 - s) * length
    else:
        s = 1.0
    xy = path[k] + s * way
    return PathPoint(k, float(s), (float(xy[0]), float(xy[1])), hypot(*(xy - point)))


def _past(path: Path, point: np.ndarray, lookahead: float) -> PathPoint:
    way = path[-1] - path[-2]
    s = _crossing(path[-2], way, point, lookahead, 1.0)
    xy = path[-2] + s * way
    return PathPoint(len(path) - 2, s, (float(xy[0]), float(xy[1])), hypot(*(xy - point)))


def _nothing(path: Path, point: np.ndarray, lookahead: float) -> PathPoint:
    raise IndexError("list index out of range")


LOOKAHEAD_POINT = Exercise(
    id="tracking.lookahead_point",
    title="The point to look at",
    points=2,
    reference=tracking.lookahead_point,
    cases=_lookahead_cases,
    shortcuts=(
        "robocon_course.tracking.polyline.ahead",
        "robocon_course.tracking.polyline.look",
        "robocon_course.tracking.pursuit.pure_pursuit",
        "robocon_course.tracking.pursuit.pursue",
    ),
    hints=(
        "Where the search begins is a point of the path: path[index] + share · d. If that is as "
        "far away already, it is the answer.",
        "Go on from segment to segment until one ends outside the circle around the robot. Inside "
        "it, the crossing is at |a + s d − point| = lookahead.",
        "With A = d · d, B = (a − point) · d, C = |a − point|² − lookahead² the larger root is "
        "s = (−B + √(B² − A C)) / A. Where no segment ends outside: the last point, share 1.",
    ),
    mistakes=(
        Mistake(
            "waypoint beyond",
            "This takes the first waypoint outside the circle, as one source does. The point "
            "then jumps from waypoint to waypoint; interpolate on the segment.",
            _ahead(share_of=lambda *_: 1.0),
        ),
        Mistake(
            "waypoint before",
            "This takes the last waypoint inside the circle. Interpolate on the segment.",
            _ahead(share_of=lambda *_: 0.0),
        ),
        Mistake(
            "along the path",
            "This is as far along the path. The look-ahead is straight from the robot to the "
            "point.",
            _along,
        ),
        Mistake(
            "the other root",
            "The circle is crossed twice by the segment's line. The larger root lies ahead, the "
            "smaller one behind the robot.",
            _ahead(share_of=lambda a, way, p, far: _crossing(a, way, p, far, -1.0)),
        ),
        Mistake(
            "straight between the ends",
            "The distance does not change evenly along a segment, so it cannot be interpolated "
            "between its ends: solve |a + s d − point| = lookahead.",
            _ahead(
                share_of=lambda a, way, p, far: min(
                    max((far - hypot(*(a - p))) / (hypot(*(a + way - p)) - hypot(*(a - p))), 0.0),
                    1.0,
                )
            ),
        ),
        Mistake(
            "from the beginning of the path",
            "The search begins at the path's beginning: it finds a point behind the robot. Begin "
            "at index and share.",
            _ahead(begin=lambda index, share: (0, 0.0)),
        ),
        Mistake(
            "share ignored",
            "The search begins at the segment's beginning, which may lie behind the robot. Begin "
            "at share.",
            _ahead(begin=lambda index, share: (index, 0.0)),
        ),
        Mistake(
            "past the end",
            "The last segment is prolonged beyond the path's end. There is nothing: the end itself "
            "is the point.",
            _ahead(end=_past),
        ),
        Mistake(
            "error at the end",
            "Near the path's end no point is so far away. Then the end is the point to look at; "
            "the loop must not stop with an error.",
            _ahead(end=_nothing),
        ),
        Mistake(
            "far off the path",
            "Farther off the path than the look-ahead nothing is in the circle, and the root is "
            "one of a negative number. Then the point where the search begins is the answer.",
            _ahead(off_path=False, share_of=_unguarded),
        ),
    ),
)
