"""Area under precision and recall, the best threshold, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import vision, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake, Number
from robocon_course.worlds import Student

Curve = np.ndarray


def _curve(rng: np.random.Generator, count: int, truths: int) -> tuple[Curve, Curve]:
    """A curve of a detector that is mostly right first and mostly wrong later."""
    hits = rng.uniform(size=count) < np.linspace(0.95, 0.3, count)
    return vision.precision_recall(np.linspace(1.0, 0.0, count), hits, max(truths, hits.sum()))


def _ap_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = [
        Case("half is found, all of it right", (np.array([0.25, 0.5]), np.array([1.0, 1.0]))),
        Case("a mistake first", (np.array([0.0, 0.5, 1.0]), np.array([0.0, 0.5, 2 / 3]))),
        Case("nothing was reported", (np.empty(0), np.empty(0))),
    ]
    for count, truths in ((12, 12), (40, 30), (90, 70)):
        what = f"{count} detections of {truths} balls"
        cases.append(Case(what, _curve(rng, count, truths)))
    return [Case(c.what, c.args, "", 1e-6) for c in cases]


def _ap(
    *,
    start: tuple[float, ...] = (1.0,),
    envelope: bool = True,
    end: bool = True,
    integral: Callable[[Curve, Curve], float] | None = None,
    points: int = 101,
) -> Callable[[Curve, Curve], float]:
    """Average precision with one part wrong."""

    def function(recall: Curve, precision: Curve) -> float:
        if len(recall) == 0:
            return 0.0
        tail = ([recall[-1], 1.0], [0.0, 0.0]) if end else ([1.0], [precision[-1]])
        r = np.concatenate([[0.0] * len(start), recall, tail[0]])
        p = np.concatenate([start, precision, tail[1]])
        if envelope:
            p = np.maximum.accumulate(p[::-1])[::-1]
        if integral:
            return float(integral(r, p))
        at = np.linspace(0.0, 1.0, points)
        return float(np.trapezoid(np.interp(at, r, p), at))

    return function


def _read(recall: Curve, precision: Curve, left: float | None = None) -> float:
    """The area under a curve with ends of its own, made falling and read at 101 recalls."""
    at, falling = np.linspace(0.0, 1.0, 101), np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.trapezoid(np.interp(at, recall, falling, left=left), at))


AVERAGE_PRECISION = Exercise(
    id="vision.average_precision",
    title="One number for a curve: average precision",
    points=2,
    reference=vision.average_precision,
    cases=_ap_cases,
    hints=(
        "Nothing reported: 0. Otherwise put recall 0 with precision 1 before the curve; behind it "
        "recall[-1] and 1, both with precision 0.",
        "Make the precision falling: each value becomes the largest that comes at or after it. "
        "From the right: np.maximum.accumulate(p[::-1])[::-1].",
        "Read it at np.linspace(0, 1, 101) with np.interp, and integrate with np.trapezoid.",
    ),
    mistakes=(
        Mistake(
            "not made falling",
            "The precision goes up and down as it comes. Make it falling first: each value becomes "
            "the largest at or after it.",
            _ap(envelope=False),
        ),
        Mistake(
            "made falling from the left",
            "Each precision became the largest so far, from the left. Go from the right: what "
            "counts is the best that is still to come.",
            lambda r, p: _ap(envelope=False)(r, np.maximum.accumulate(p) if len(p) else p),
        ),
        Mistake(
            "goes on after the last recall",
            "Behind the last recall nothing more is found: the precision is 0 there.",
            _ap(end=False),
        ),
        Mistake(
            "slope to the end",
            "Behind the last recall the precision slopes down to 0. It drops at once: put "
            "recall[-1] with precision 0 before recall 1.",
            lambda r, p: _read(np.r_[0.0, r, 1.0], np.r_[1.0, p, 0.0]) if len(p) else 0.0,
        ),
        Mistake(
            "start forgotten",
            "The curve has no point at recall 0: put recall 0 with precision 1 before it. The "
            "first readings lie there.",
            lambda r, p: (
                _read(np.r_[r, r[-1], 1.0], np.r_[p, 0.0, 0.0], left=0.0) if len(p) else 0.0
            ),
        ),
        Mistake(
            "mean of the readings",
            "This is the mean of the 101 readings, in which the first and the last count whole. "
            "The area counts both half: np.trapezoid.",
            _ap(integral=lambda r, p: np.interp(np.linspace(0.0, 1.0, 101), r, p).mean()),
        ),
        Mistake(
            "mean of the precisions",
            "This is the mean of the precisions. Recall does not grow evenly: integrate over it.",
            lambda r, p: float(p.mean()) if len(p) else 0.0,
        ),
        Mistake(
            "last precision",
            "This is the precision at the end of the curve. Asked for is the area under it.",
            lambda r, p: float(p[-1]) if len(p) else 0.0,
        ),
        Mistake(
            "last recall",
            "This is the recall at the end of the curve. Asked for is the area under it.",
            lambda r, p: float(r[-1]) if len(r) else 0.0,
        ),
        Mistake(
            "eleven points",
            "The curve is read at 11 recalls, as in the first such contest. Here it is 101.",
            _ap(points=11),
        ),
        Mistake(
            "as stairs",
            "This is the exact area of the stairs. The published numbers are read at 101 recalls: "
            "np.interp at np.linspace(0, 1, 101).",
            _ap(integral=lambda r, p: np.sum(np.diff(r) * p[1:])),
        ),
        Mistake(
            "sum instead of integral",
            "The 101 values are added. Integrate them over the recall, which ends at 1.",
            lambda r, p: 100.0 * _ap()(r, p),
        ),
        Mistake(
            "recall over precision",
            "Recall and precision are swapped: it is the precision that is integrated over recall.",
            lambda r, p: _ap()(np.sort(p), r[np.argsort(p, kind="stable")]) if len(p) else 0.0,
        ),
    ),
)


def _f1(right: int, said: int, there: int) -> float:
    """Harmonic mean of precision and recall."""
    return 2.0 * right / (said + there)


def _best(student: Student) -> float:
    """The threshold with the best F1."""
    return _of(student, _f1)


def _of(student: Student, measure: Callable[[int, int, int], float]) -> float:
    """The threshold that is best by a measure of (right, reported, there); of equals the least."""
    levels = worlds.eye_world(student).thresholds()
    return float(max(levels, key=lambda t: (round(measure(*_counts(student, t)), 12), -t)))


def _counts(student: Student, threshold: float) -> tuple[int, int, int]:
    """Right ones, reported ones, and those that are there."""
    world = worlds.eye_world(student)
    counted = world.scores >= threshold - 1e-9
    return int((world.hits & counted).sum()), int(counted.sum()), world.truths


OWN_THRESHOLD = Number(
    id="vision.own_threshold",
    title="The best threshold for your own detector",
    points=1,
    truth=_best,
    tolerance=0.0051,
    unit="",
    likeness=1e-6,
    hints=(
        "For each of world.thresholds(): which scores count, and how many of those are hits?",
        "precision = right / counted, recall = right / world.truths, and F1 is 2 P R / (P + R).",
        "max(world.thresholds(), key=your_f1) is the threshold with the largest F1.",
    ),
    mistakes=(
        Mistake(
            "best precision",
            "There the precision is best, and most balls are missed. Asked for is the best F1.",
            lambda s: _of(s, lambda right, said, there: right / max(1, said)),
        ),
        Mistake(
            "best recall",
            "There the recall is best, and half of what is reported is wrong. Asked for is the "
            "best F1.",
            lambda s: _of(s, lambda right, said, there: right / there),
        ),
        Mistake(
            "the F1 itself",
            "That is the best F1. Asked for is the threshold at which it is reached.",
            lambda s: round(_f1(*_counts(s, _best(s))), 4),
        ),
        Mistake(
            "in per cent",
            "That is in per cent. A score lies between 0 and 1.",
            lambda s: 100.0 * _best(s),
        ),
        Mistake(
            "precision equals recall",
            "There precision and recall are equal. F1 may be larger elsewhere: it can win more of "
            "one than it loses of the other.",
            lambda s: _of(s, lambda right, said, there: -abs(right / max(1, said) - right / there)),
        ),
        Mistake(
            "lowest score",
            "That is the lowest score in your log: everything counts from there.",
            lambda s: float(worlds.eye_world(s).scores.min()),
        ),
        Mistake(
            "the published 0.4",
            "That is the source's threshold, for its own network. Yours has another.",
            lambda s: 0.4,
        ),
        Mistake(
            "Ultralytics' 0.25",
            "That is what Ultralytics takes when it is told nothing. Your detector has a best one "
            "of its own.",
            lambda s: 0.25,
        ),
    ),
)
