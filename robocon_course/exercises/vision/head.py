"""The network's numbers as boxes, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student, some_boxes


def _decode_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def output(columns: int, classes: int) -> np.ndarray:
        boxes = some_boxes(rng, columns)
        middle, size = (boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2]
        scores = np.round(rng.uniform(0.02, 0.98, (columns, classes)) ** 2, 4)
        return np.hstack([middle, size, scores]).T

    quiet = output(8, 3)
    quiet[4:] *= 0.2
    return [
        Case("three columns, two classes", (output(3, 2), 0.2)),
        Case("as many columns as a small picture has", (output(84, 3), 0.4)),
        Case("fifteen classes", (output(30, 15), 0.6)),
        Case("a low threshold", (output(12, 3), 0.05)),
        Case("nothing is sure enough", (quiet, 0.9)),
        Case("a score that is just the threshold", (_on_the_line(output(5, 3)), 0.5)),
    ]


def _on_the_line(output: np.ndarray) -> np.ndarray:
    output[4:] = np.minimum(output[4:], 0.49)
    output[5, 1], output[4, 3] = 0.5, 0.75
    return output


def _decode(
    *,
    best: Callable[[np.ndarray], np.ndarray] = lambda scores: scores.max(axis=0),
    first: int = 4,
    corners: Callable[[np.ndarray, np.ndarray], np.ndarray] = lambda m, s: np.hstack(
        [m - s / 2, m + s / 2]
    ),
    keep: Callable[..., np.ndarray] = lambda best, least: best > least,
    number: int = 0,
) -> Callable[..., tuple]:
    """The decoder with one part wrong."""

    def function(output: np.ndarray, min_score: float) -> tuple:
        scores = output[first:]
        columns = np.flatnonzero(keep(best(scores), min_score))
        boxes = corners(output[:2, columns].T, output[2:4, columns].T)
        kept = scores[:, columns]
        return boxes, best(kept), kept.argmax(axis=0) + number

    return function


def _all_kept(output: np.ndarray, min_score: float) -> tuple:
    return vision.decode(output, -1.0)


def _every_class(output: np.ndarray, min_score: float) -> tuple:
    boxes, _, _ = vision.decode(output, -1.0)
    columns, ids = np.nonzero(output[4:].T > min_score)
    return boxes[columns], output[4:].T[columns, ids], ids


DECODE = Exercise(
    id="vision.decode",
    title="From the network's numbers to boxes",
    points=3,
    reference=vision.decode,
    cases=_decode_cases,
    hints=(
        "A column is one guess. Its first four numbers are the middle of a box and its size, the "
        "rest are the scores of the classes.",
        "scores = output[4:]. The score of a column is scores.max(axis=0), its class "
        "scores.argmax(axis=0).",
        "Keep the columns whose score is larger than min_score: output[:, score > min_score].",
        "Boxes in rows: middle − size / 2 and middle + size / 2, side by side with np.hstack after "
        "turning the columns into rows with .T.",
    ),
    mistakes=(
        Mistake(
            "middle and size",
            "These boxes are middle and size, as the network gives them. Asked for are left, top, "
            "right, bottom.",
            _decode(corners=lambda m, s: np.hstack([m, s])),
        ),
        Mistake(
            "middle taken for the corner",
            "The first two numbers are the middle of the box, not its upper left corner.",
            _decode(corners=lambda m, s: np.hstack([m, m + s])),
        ),
        Mistake(
            "whole size to each side",
            "The box reaches half its size to each side of its middle.",
            _decode(corners=lambda m, s: np.hstack([m - s, m + s])),
        ),
        Mistake(
            "an objectness that is not there",
            "Row 4 is skipped as if it were a score for “any object”. YOLOv5 had one; YOLOv8's "
            "classes begin with row 4.",
            _decode(first=5),
        ),
        Mistake(
            "counted from 1",
            "Class numbers begin with 0.",
            _decode(number=1),
        ),
        Mistake(
            "sum of the scores",
            "The scores of the classes are added. They are judged one by one: take the largest.",
            _decode(best=lambda scores: scores.sum(axis=0)),
        ),
        Mistake(
            "mean of the scores",
            "This takes the mean of the classes' scores. Take the largest.",
            _decode(best=lambda scores: scores.mean(axis=0)),
        ),
        Mistake(
            "scores squeezed again",
            "The scores pass through a sigmoid here. The network has done that already: they are "
            "between 0 and 1.",
            _decode(best=lambda scores: 1.0 / (1.0 + np.exp(-scores.max(axis=0)))),
        ),
        Mistake(
            "threshold ignored",
            "Every column is kept. Only those whose best score is larger than min_score count.",
            _all_kept,
        ),
        Mistake(
            "the unsure kept",
            "The comparison is the wrong way round: these are the columns that are not sure.",
            _decode(keep=lambda best, least: best <= least),
        ),
        Mistake(
            "equal counts",
            "A score that is just min_score does not count: larger than, not at least.",
            _decode(keep=lambda best, least: best >= least),
        ),
        Mistake(
            "one box a class",
            "A column with two classes above min_score gives two boxes here. It is one thing: keep "
            "its best class.",
            _every_class,
        ),
        Mistake(
            "x and y swapped",
            "Row 0 is x, row 1 is y: boxes are left, top, right, bottom.",
            _decode(corners=lambda m, s: np.hstack([m - s / 2, m + s / 2])[:, [1, 0, 3, 2]]),
        ),
    ),
)
