"""One box a thing, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student, some_boxes


def _nms_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    row = np.array([[10.0 * k, 0.0, 10.0 * k + 40.0, 40.0] for k in range(4)])
    scores = np.array([0.8, 0.9, 0.7, 0.6])
    same, other = np.zeros(4, int), np.array([0, 1, 1, 0])
    cases = [
        Case("a chain of boxes, each over the next", (row, scores, same, 0.5)),
        Case("the same boxes in two classes", (row, scores, other, 0.5)),
        Case("an overlap that is just allowed", (row[[0, 2]], scores[[0, 1]], same[:2], 1 / 3)),
        Case("no boxes", (np.empty((0, 4)), np.empty(0), np.empty(0, int), 0.5)),
        Case("one box", (row[:1], scores[:1], same[:1], 0.5)),
    ]
    for limit in (0.3, 0.5, 0.7):
        things = some_boxes(rng, 6)
        boxes = np.repeat(things, 4, axis=0) + np.round(rng.normal(0.0, 3.0, (24, 4)), 1)
        score = np.round(rng.permutation(np.linspace(0.1, 0.95, 24)), 4)
        ids = np.repeat(rng.integers(0, 3, 6), 4)
        ids[rng.integers(0, 24, 5)] = rng.integers(0, 3, 5)
        what = f"six things, four boxes each, at most {limit:g} in common"
        cases.append(Case(what, (boxes, score, ids, limit)))
    return cases


def _of_the_smaller(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The common part over the smaller box."""
    areas = [np.prod(x[:, 2:] - x[:, :2], axis=1) for x in (a, b)]
    union = areas[0][:, None] + areas[1][None]
    iou = vision.box_iou(a, b)
    return iou / (1.0 + iou) * union / np.minimum(areas[0][:, None], areas[1][None])


def _nms(
    *,
    order: Callable[[np.ndarray], np.ndarray] = lambda scores: np.argsort(-scores, kind="stable"),
    alike: Callable[[np.ndarray], np.ndarray] = lambda ids: ids[:, None] == ids[None],
    shared: Callable[..., np.ndarray] = vision.box_iou,
    drop: Callable[..., np.ndarray] = lambda overlap, most: overlap > most,
    by: str = "kept",
    result: Callable[..., object] = lambda kept, boxes: np.array(kept, int),
) -> Callable[..., object]:
    """Suppression with one part wrong."""

    def function(
        boxes: np.ndarray, scores: np.ndarray, class_ids: np.ndarray, max_iou: float
    ) -> object:
        kept: list[int] = []
        rival = drop(shared(boxes, boxes), max_iou) & alike(class_ids)
        ranking = [int(k) for k in order(scores)]
        for at, k in enumerate(ranking):
            rivals = kept if by == "kept" else ranking[:at] if by == "all" else kept[-1:]
            if not any(rival[k, j] for j in rivals):
                kept.append(k)
        return result(kept, boxes)

    return function


NON_MAX_SUPPRESSION = Exercise(
    id="vision.non_max_suppression",
    title="One box a thing",
    points=4,
    reference=vision.non_max_suppression,
    cases=_nms_cases,
    hints=(
        "Take the surest box. Drop every other box of its class that overlaps it by more than "
        "max_iou. Then the surest of those left, and so on.",
        "order = np.argsort(-scores, kind='stable') gives the indices, the surest first.",
        "best, rest = left[0], left[1:]; overlap = box_iou(boxes[[best]], boxes[rest])[0].",
        "left = rest[(class_ids[rest] != class_ids[best]) | (overlap <= max_iou)], as long as "
        "anything is left; return np.array(kept, int).",
    ),
    mistakes=(
        Mistake(
            "across classes",
            "A red ball in front of a blue one is dropped: only boxes of one class are rivals.",
            _nms(alike=lambda ids: np.ones((len(ids), len(ids)), bool)),
        ),
        Mistake(
            "the least sure first",
            "This begins with the least sure box. Sort by falling score.",
            _nms(order=lambda scores: np.argsort(scores, kind="stable")),
        ),
        Mistake(
            "not sorted",
            "The boxes are taken in the order in which they came. Begin with the surest.",
            _nms(order=lambda scores: np.arange(len(scores))),
        ),
        Mistake(
            "dropped boxes drop others",
            "A box that was dropped itself still drops others here. Only kept boxes do: in a chain "
            "of three, the first and the last stay.",
            _nms(by="all"),
        ),
        Mistake(
            "only against the last kept",
            "A box is compared with the last kept one only. Compare it with all that are kept.",
            _nms(by="last"),
        ),
        Mistake(
            "overlapping kept",
            "The comparison is the wrong way round: boxes that overlap are kept, the others "
            "dropped.",
            _nms(drop=lambda overlap, most: overlap <= most),
        ),
        Mistake(
            "equal dropped",
            "An overlap that is just max_iou is allowed: drop only what is more.",
            _nms(drop=lambda overlap, most: overlap >= most - 1e-12),
        ),
        Mistake(
            "any overlap",
            "max_iou is not used: boxes that only touch are dropped, too.",
            _nms(drop=lambda overlap, most: overlap > 0.0),
        ),
        Mistake(
            "only across classes",
            "Boxes of other classes are dropped, and the doubles of one class kept. It has to be "
            "the other way round.",
            _nms(alike=lambda ids: ids[:, None] != ids[None]),
        ),
        Mistake(
            "only the surest",
            "Only the surest box of the whole picture is returned. There may be several things.",
            _nms(result=lambda kept, boxes: np.array(kept[:1], int)),
        ),
        Mistake(
            "shared part of the smaller box",
            "What two boxes share is divided by the smaller of them: a small ball in front of a "
            "large one is lost. IoU divides by the union.",
            _nms(shared=_of_the_smaller),
        ),
        Mistake(
            "nothing dropped",
            "Nothing is dropped: these are all boxes, sorted.",
            _nms(drop=lambda overlap, most: overlap > 2.0),
        ),
        Mistake(
            "boxes instead of indices",
            "These are the boxes themselves. Asked for are their indices: scores and classes are "
            "needed, too.",
            _nms(result=lambda kept, boxes: boxes[kept]),
        ),
        Mistake(
            "indices in the order given",
            "The right boxes are kept. Return them with the surest first.",
            _nms(result=lambda kept, boxes: np.array(sorted(kept), int)),
        ),
        Mistake(
            "a mask",
            "This says of each box whether it is kept. Asked for are indices, the surest first.",
            _nms(result=lambda kept, boxes: np.isin(np.arange(len(boxes)), kept)),
        ),
    ),
)
