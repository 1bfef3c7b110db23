"""A way with fewer points, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.geometry import distance_along
from robocon_course.planning import resample_path, thin_path
from robocon_course.worlds import Student


def _thin_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    line = np.column_stack([0.1 * np.arange(13), np.full(13, 2.0)])
    fine = np.column_stack([0.05 * np.arange(41), np.full(41, 2.0)])
    corner = np.array([(0, 0), (0, 1), (0, 2), (1, 2), (2, 2), (2, 1), (2, 0), (1, 0.2)], float)
    cases = [
        ("a line of points 0.1 m apart", line.round(3), 0.35),
        ("around three corners", corner, 1.5),
        ("a spacing longer than the way", corner, 99.0),
        ("two points", corner[:2], 0.3),
        ("every fourth of points 0.05 m apart", fine.round(3), 0.2),
    ]
    for _ in range(4):
        steps = rng.choice([(0.05, 0.0), (0.05, 0.05), (0.0, 0.05), (-0.05, 0.05)], 60)
        cases.append(("a way of your own", steps.cumsum(axis=0).round(3), rng.uniform(0.2, 0.5)))
    return [Case(what, (xy, round(spacing, 3)), "m") for what, xy, spacing in cases]


def _kept(rule: Callable[[np.ndarray, float], np.ndarray]) -> Callable[..., np.ndarray]:
    """The points that a rule keeps."""

    def function(xy: np.ndarray, spacing: float) -> np.ndarray:
        keep = rule(xy, spacing)
        return xy[keep]

    return function


def _by_place(along: np.ndarray, spacing: float) -> np.ndarray:
    return np.diff(np.floor(along / spacing + 1e-9), prepend=-1.0) > 0.0


def _without_last(xy: np.ndarray, spacing: float) -> np.ndarray:
    return _by_place(distance_along(xy), spacing)


def _without_first(xy: np.ndarray, spacing: float) -> np.ndarray:
    keep = _by_place(distance_along(xy), spacing)
    keep[0], keep[-1] = False, True
    return keep


def _rounding(xy: np.ndarray, spacing: float) -> np.ndarray:
    keep = np.diff(np.floor(distance_along(xy) / spacing), prepend=-1.0) > 0.0
    keep[-1] = True
    return keep


def _straight(xy: np.ndarray, spacing: float) -> np.ndarray:
    keep = _by_place(np.hypot(*(xy - xy[0]).T), spacing)
    keep[-1] = True
    return keep


def _every(xy: np.ndarray, spacing: float) -> np.ndarray:
    step = max(1, round(spacing / np.hypot(*(xy[1] - xy[0]))))
    keep = np.arange(len(xy)) % step == 0
    keep[-1] = True
    return keep


def _last_of_each(xy: np.ndarray, spacing: float) -> np.ndarray:
    place = np.floor(distance_along(xy) / spacing + 1e-9)
    return np.append(np.diff(place) > 0.0, True)


def _since_the_last(xy: np.ndarray, spacing: float) -> np.ndarray:
    along, keep = distance_along(xy), [0]
    for i in range(1, len(xy)):
        if along[i] - along[keep[-1]] >= spacing - 1e-9:
            keep.append(i)
    return np.array(sorted({*keep, len(xy) - 1}))


THIN_PATH = Exercise(
    id="planning.thin_path",
    title="One point every so often",
    points=1,
    reference=thin_path,
    cases=_thin_cases,
    time_limit=2.0,
    hints=(
        "How far along the way lies each point? np.hypot of the steps, and np.cumsum; the first "
        "lies at 0.",
        "np.floor(along / spacing + 1e-9) says in which piece each point lies. Keep those with "
        "another number than the point before.",
        "keep = np.diff(piece, prepend=-1) > 0; keep[-1] = True; return xy[keep]",
    ),
    mistakes=(
        Mistake(
            "a point later by rounding",
            "Steps of 0.05 m add up to a little less than a multiple of 0.2 m, and a point comes "
            "one too late. Add 1e-9 before you round down.",
            _kept(_rounding),
        ),
        Mistake(
            "last point lost",
            "The last point is missing, and the robot stops short of its goal.",
            _kept(_without_last),
        ),
        Mistake(
            "first point lost",
            "The first point is missing: the way no longer begins where the robot stands.",
            _kept(_without_first),
        ),
        Mistake(
            "straight from the start",
            "This measures straight from the start. Behind a bend the way comes nearer again: "
            "measure along it.",
            _kept(_straight),
        ),
        Mistake(
            "every so many points",
            "This keeps every so many points. Diagonal steps are longer than straight ones: count "
            "metres, not points.",
            _kept(_every),
        ),
        Mistake(
            "last of each piece",
            "This keeps the last point of each piece. Keep the first.",
            _kept(_last_of_each),
        ),
        Mistake(
            "counted anew from each point",
            "This counts the spacing anew from each point it keeps, so rounding adds up. The "
            "pieces lie at multiples of the spacing, from the start.",
            _kept(_since_the_last),
        ),
        Mistake(
            "new points",
            "These are new points, between the old ones. Thinning only leaves points out.",
            resample_path,
        ),
        Mistake(
            "unchanged",
            "This returns all points.",
            _kept(lambda xy, spacing: np.arange(len(xy))),
        ),
    ),
)
