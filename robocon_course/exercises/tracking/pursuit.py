"""Pure pursuit, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, inf, sin

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.tracking.places import HAIRPIN, L_SHAPE, beside, some_path
from robocon_course.geometry import TURN
from robocon_course.tracking import PathPoint, Pursuit
from robocon_course.worlds import Student

JUDGED = {"curvature": 1e-6, "target": 1e-6, "index": 0.0, "done": 0.0}
ROUND = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
HOOK = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.03], [0.99, 0.006]])
Path = np.ndarray


def _pure_pursuit_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    rows = [
        ("on the path, facing along it", L_SHAPE, [0.2, 0.0, 0.0], 0.5, 0),
        ("to the left of the path", L_SHAPE, [0.2, 0.3, 0.0], 0.5, 0),
        ("to the right of the path", L_SHAPE, [0.2, -0.3, 0.0], 0.5, 0),
        ("facing 40° to the left", L_SHAPE, [0.2, 0.1, 0.7], 0.5, 0),
        ("before the corner", L_SHAPE, [0.4, 0.1, 0.0], 1.0, 0),
        ("along the field's y axis", L_SHAPE, [0.9, 1.0, 1.4], 0.4, 1),
        ("facing back", L_SHAPE, [0.3, 0.05, 3.0], 0.4, 0),
        ("farther off the path than the look-ahead", L_SHAPE, [0.3, 0.9, -0.5], 0.5, 0),
        ("near the end, which is now the target", L_SHAPE, [1.02, 1.8, 1.5], 0.5, 1),
        ("5 mm before the end", L_SHAPE, [1.01, 1.995, 1.5], 0.5, 1),
        ("past the end", L_SHAPE, [1.03, 2.1, 1.5], 0.5, 1),
        ("beside the end, farther than the look-ahead", L_SHAPE, [1.6, 1.995, 2.0], 0.4, 1),
        ("on the way out of a way out and back", HAIRPIN, [0.5, 0.15, 0.0], 0.3, 0),
        ("on the way back of it", HAIRPIN, [0.6, 0.05, 3.1], 0.3, 2),
        ("at the start of a way that ends there", ROUND, [0.004, 0.0, 0.0], 0.3, 0),
    ]
    rows.append(("before a last bend that comes back", HOOK, [0.99, -0.02, 0.0], 0.3, 0))
    for _ in range(5):
        path = some_path(rng)
        (x, y), k = beside(path, rng, 0.1)
        heading = atan2(*(path[k + 1] - path[k])[::-1]) + rng.uniform(-0.8, 0.8)
        pose = [float(x), float(y), round(float(heading), 3)]
        rows.append(("any path", path, pose, round(float(rng.uniform(0.25, 0.5)), 3), k))
    return [
        Case(what, (path, np.array(pose), far, k), "", dict(JUDGED))
        for what, path, pose, far, k in rows
    ]


def _left_along(path: Path, foot: PathPoint) -> float:
    """Path from a point of it to its end [m]."""
    rest = np.vstack([foot.xy, path[foot.index + 1 :]])
    return float(np.hypot(*np.diff(rest, axis=0).T).sum())


def _arrived(path: Path, place: np.ndarray, foot: PathPoint, target: PathPoint, far: float) -> bool:
    at_end = hypot(*(path[-1] - target.xy)) < 1e-9
    return at_end and _left_along(path, foot) <= tracking.TOLERANCE and foot.distance < far


def _pursue(
    *,
    bend: Callable[..., float] = lambda ahead, left, far: 2.0 * left / (ahead**2 + left**2),
    heading: Callable[[float], float] = lambda theta: theta,
    start: Callable[[int], int] = lambda start: start,
    wide: bool = False,
    aim: Callable[..., PathPoint] = lambda foot, target: target,
    index: Callable[..., int] = lambda foot, target: foot.index,
    done: Callable[..., bool] = _arrived,
) -> Callable[..., Pursuit]:
    """Pure pursuit with one of its parts wrong."""

    def function(path: Path, pose: np.ndarray, lookahead: float, start_index: int) -> Pursuit:
        place, theta = np.array(pose[:2]), heading(float(pose[2]))
        foot = tracking.nearest_point(path, place, start(start_index), inf if wide else lookahead)
        target = tracking.lookahead_point(path, place, lookahead, foot.index, foot.share)
        aimed = aim(foot, target)
        dx, dy = np.array(aimed.xy) - place
        ahead = cos(theta) * dx + sin(theta) * dy
        left = cos(theta) * dy - sin(theta) * dx
        curvature = float(bend(ahead, left, lookahead))
        ended = bool(done(path, place, foot, target, lookahead))
        return Pursuit(curvature, tuple(aimed.xy), index(foot, target), ended)

    return function


def _square(ahead: float, left: float) -> float:
    return ahead**2 + left**2


PURE_PURSUIT = Exercise(
    id="tracking.pure_pursuit",
    title="The circle that leads to the path",
    points=3,
    reference=tracking.pure_pursuit,
    cases=_pure_pursuit_cases,
    shortcuts=(
        "robocon_course.tracking.pursuit.pursue",
        "robocon_course.tracking.pursuit.bend",
        "robocon_course.tracking.polyline.look",
    ),
    hints=(
        "Two parts that you have: nearest_point with reach = lookahead, then lookahead_point from "
        "its index and share on.",
        "Turn the vector to the target by −θ. Its y, the distance to the left, is "
        "cos θ · dy − sin θ · dx.",
        "curvature = 2 · left / (dx² + dy²): the distance to the target itself, which near the "
        "end is not the look-ahead. 0 where the target is the robot's own place.",
        "done: the target is the path's end, the path left from the nearest point on is no longer "
        "than tracking.TOLERANCE, and the nearest point is nearer than the look-ahead.",
    ),
    mistakes=(
        Mistake(
            "sign of the curvature",
            "The sign is reversed: positive is to the left. The robot would flee from its path.",
            _pursue(bend=lambda a, b, far: -2.0 * b / _square(a, b)),
        ),
        Mistake(
            "look-ahead instead of distance",
            "The square of the look-ahead stands below the line. Near the end, and far off the "
            "path, the target is not so far away: take its distance.",
            _pursue(bend=lambda a, b, far: 2.0 * b / far**2),
        ),
        Mistake(
            "factor 2 forgotten",
            "The 2 is missing: the circle is too wide by half.",
            _pursue(bend=lambda a, b, far: b / _square(a, b)),
        ),
        Mistake(
            "distance not squared",
            "The distance is not squared. A curvature is in 1/m.",
            _pursue(bend=lambda a, b, far: 2.0 * b / _square(a, b) ** 0.5),
        ),
        Mistake(
            "radius instead of curvature",
            "This is the circle's radius. Straight ahead it is infinite; the curvature is 1 / r.",
            _pursue(bend=lambda a, b, far: _square(a, b) / (2.0 * b) if b else inf),
        ),
        Mistake(
            "bearing instead of curvature",
            "This is the angle to the target. The circle to it has the curvature 2 · left / "
            "distance².",
            _pursue(bend=lambda a, b, far: atan2(b, a)),
        ),
        Mistake(
            "ahead instead of left",
            "The distance ahead stands in the place of the distance to the left.",
            _pursue(bend=lambda a, b, far: 2.0 * a / _square(a, b)),
        ),
        Mistake(
            "map axes",
            "The vector to the target is not turned into the robot's axes. That is right at "
            "heading 0 only.",
            _pursue(heading=lambda theta: 0.0),
        ),
        Mistake(
            "turned the wrong way",
            "The vector to the target is turned by +θ. Seen from a robot that turned to the left, "
            "the world turned to the right: −θ.",
            _pursue(heading=lambda theta: -theta),
        ),
        Mistake(
            "degrees",
            "θ is taken for degrees. It is in radians already.",
            _pursue(heading=lambda theta: theta * TURN / 360.0),
        ),
        Mistake(
            "nearest point as target",
            "This aims at the nearest point. On the path that is where the robot is already; look "
            "ahead.",
            _pursue(
                aim=lambda foot, target: foot,
                bend=lambda a, b, far: 2.0 * b / _square(a, b) if _square(a, b) > 1e-18 else 0.0,
            ),
        ),
        Mistake(
            "start_index ignored",
            "The search begins at the path's beginning. Where the path comes back on itself the "
            "robot jumps to another leg.",
            _pursue(start=lambda start: 0),
        ),
        Mistake(
            "the whole path searched",
            "The nearest point is searched without reach. Where the path comes back on itself the "
            "robot jumps to another leg: reach = lookahead.",
            _pursue(wide=True),
        ),
        Mistake(
            "index of the target",
            "index is the segment of the look-ahead point. Next time the search would begin there, "
            "ahead of the robot; give back that of the nearest point.",
            _pursue(index=lambda foot, target: target.index),
        ),
        Mistake(
            "done as soon as the end is the target",
            "It says done a whole look-ahead before the end. Done means that no more than "
            "tracking.TOLERANCE of the path is left.",
            _pursue(
                done=lambda path, place, foot, target, far: (
                    hypot(*(path[-1] - target.xy)) < 1e-9 and foot.distance < far
                )
            ),
        ),
        Mistake(
            "done near the end",
            "It is done wherever the path's end is near. A path that ends where it began would be "
            "done at its start: count the path that is left.",
            _pursue(
                done=lambda path, place, foot, target, far: (
                    hypot(*(path[-1] - foot.xy)) <= tracking.TOLERANCE and foot.distance < far
                )
            ),
        ),
        Mistake(
            "straight to the end",
            "What is left is measured straight to the end. A path that bends there comes near its "
            "end before it is there: add up the pieces.",
            _pursue(
                done=lambda path, place, foot, target, far: (
                    hypot(*(path[-1] - target.xy)) < 1e-9
                    and hypot(*(path[-1] - foot.xy)) <= tracking.TOLERANCE
                    and foot.distance < far
                )
            ),
        ),
        Mistake(
            "never done",
            "It never says done.",
            _pursue(done=lambda *_: False),
        ),
        Mistake(
            "done though far beside the end",
            "It says done beside the end, farther off than the look-ahead. There the robot still "
            "has to come back.",
            _pursue(
                done=lambda path, place, foot, target, far: (
                    _left_along(path, foot) <= tracking.TOLERANCE
                )
            ),
        ),
    ),
)
