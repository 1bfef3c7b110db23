"""What the silos hold, from left to right, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.vision import SILOS, Detections
from robocon_course.worlds import Student


def _row(
    rng: np.random.Generator, count: int, doubles: int = 0, *, same: bool = False, empty: int = 0
) -> Detections:
    """Some silos side by side, with a second opinion on a few, in the order of their scores.

    `same`: the second opinion is the first one. `empty`: so many silos are.
    """
    lefts = 10.0 + 62.0 * np.arange(count) + np.round(rng.uniform(0.0, 6.0, count), 1)
    boxes = np.column_stack([lefts, np.full(count, 60.0), lefts + 40.0, np.full(count, 150.0)])
    ids = rng.permutation(len(SILOS))[:count]
    ids[rng.permutation(count)[:empty]] = 0
    again = rng.permutation(count)[:doubles]
    boxes = np.vstack([boxes, boxes[again] + [3.0, 1.0, 3.0, 2.0]])
    change = rng.integers(1, 15, doubles) * (not same)
    ids = np.concatenate([ids, (ids[again] + change) % 15])
    scores = np.round(rng.permutation(np.linspace(0.62, 0.97, count + doubles)), 2)
    order = np.argsort(-scores)
    return Detections(boxes[order].astype(np.float32), scores[order].astype(np.float32), ids[order])


def _contents_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    none = Detections(np.empty((0, 4), np.float32), np.empty(0, np.float32), np.empty(0, int))
    return [
        Case("three silos", (_row(rng, 3),)),
        Case("five silos", (_row(rng, 5),)),
        Case("four silos, two of them empty", (_row(rng, 4, empty=2),)),
        Case("no silo in view", (none,)),
        Case("one silo", (_row(rng, 1),)),
        Case("one of four seen twice, and read alike", (_row(rng, 4, 1, same=True),)),
        Case("two opinions on one of three", (_row(rng, 3, 1),)),
        Case("two opinions on three of four", (_row(rng, 4, 3),)),
    ]


def _read(
    *,
    rivals: Callable[..., list[int]] = lambda ids, k, kept: kept,
    order: Callable[[Detections, list[int]], list[int]] = lambda found, kept: sorted(
        kept, key=lambda k: found.boxes[k, 0]
    ),
    name: Callable[[int], object] = lambda k: SILOS[k],
    best: bool = True,
) -> Callable[[Detections], tuple]:
    """The reading with one part wrong."""

    def function(detections: Detections) -> tuple:
        kept: list[int] = []
        ranking = range(len(detections.scores))
        for k in ranking if best else reversed(ranking):
            others = rivals(detections.class_ids, k, kept)
            shared = vision.box_iou(detections.boxes[[k]], detections.boxes[others])
            if not others or shared.max() <= 0.5:
                kept.append(k)
        return tuple(name(int(detections.class_ids[k])) for k in order(detections, kept))

    return function


SILO_CONTENTS = Exercise(
    id="vision.silo_contents",
    title="What the silos hold",
    points=1,
    reference=vision.silo_contents,
    cases=_contents_cases,
    hints=(
        "Two detections of one silo overlap by more than 0.5, whatever their fillings: keep the "
        "surer. non_max_suppression with the same class number for all does that.",
        "Sort those you keep by their left edge.",
        "Return tuple(vision.SILOS[k] for k in the class numbers in that order).",
    ),
    mistakes=(
        Mistake(
            "surest first",
            "They are in the order of their scores. Sort them from left to right.",
            _read(order=lambda found, kept: kept),
        ),
        Mistake(
            "right to left",
            "They are in order, but from right to left.",
            _read(order=lambda found, kept: sorted(kept, key=lambda k: -found.boxes[k, 0])),
        ),
        Mistake(
            "two opinions kept",
            "Doubles are dropped only where both say the same. One silo read in two ways is still "
            "one silo: leave the class out when you look for doubles.",
            _read(rivals=lambda ids, k, kept: [j for j in kept if ids[j] == ids[k]]),
        ),
        Mistake(
            "classes from one",
            "Each silo has the filling of the class before its own: class numbers begin with 0, "
            "and SILOS[0] is “empty”.",
            _read(name=lambda k: SILOS[k - 1]),
        ),
        Mistake(
            "empty ones left out",
            "Empty silos are left out. The robot counts silos: an empty one is a place for a ball.",
            lambda found: tuple(name for name in vision.silo_contents(found) if name != "empty"),
        ),
        Mistake(
            "sorted as words",
            "The fillings are sorted as words. Sort by where the silos stand.",
            lambda found: tuple(sorted(vision.silo_contents(found))),
        ),
        Mistake(
            "one silo twice",
            "One silo is read twice. Of two boxes that overlap by more than 0.5 only the surer "
            "counts, even if their fillings differ.",
            _read(rivals=lambda ids, k, kept: []),
        ),
        Mistake(
            "the less sure opinion",
            "Of two opinions on one silo the less sure is believed.",
            _read(best=False),
        ),
        Mistake(
            "class numbers",
            "These are class numbers. vision.SILOS has their names.",
            _read(name=lambda k: k),
        ),
        Mistake(
            "top to bottom",
            "The fillings are written from top to bottom. Names go from bottom to top, as the "
            "balls were dropped.",
            _read(name=lambda k: SILOS[k] if k == 0 else SILOS[k][::-1]),
        ),
    ),
)
