"""Boxes of an annotation file, and how far two boxes overlap; how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student, some_boxes

Boxes = np.ndarray


def _yolo_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def rows(count: int) -> Boxes:
        middle, size = rng.uniform(0.3, 0.7, (count, 2)), rng.uniform(0.05, 0.5, (count, 2))
        return np.round(np.hstack([rng.integers(0, 3, (count, 1)), middle, size]), 6)

    return [
        Case("one box in the middle", (np.array([[1, 0.5, 0.5, 0.2, 0.4]]), 320, 240), "px", 1e-6),
        Case("three boxes", (rows(3), 320, 240), "px", 1e-6),
        Case("a wide photograph", (rows(4), 1920, 1080), "px", 1e-6),
        Case("an upright picture", (rows(2), 90, 160), "px", 1e-6),
        Case("a picture without boxes", (np.empty((0, 5)), 320, 240), "px", 1e-6),
    ]


def _from_yolo(
    *,
    columns: tuple[int, int, int, int] = (1, 2, 3, 4),
    half: float = 0.5,
    corner: bool = False,
    far: bool = True,
    scale: Callable[[int, int], tuple[float, ...]] = lambda w, h: (w, h, w, h),
    whole: bool = False,
) -> Callable[..., Boxes]:
    """The conversion with one part wrong."""

    def function(rows: Boxes, width: int, height: int) -> Boxes:
        x, y, w, h = (rows[:, k] for k in columns)
        left, top = (x, y) if corner else (x - half * w, y - half * h)
        right, bottom = (left + w, top + h) if corner else (x + half * w, y + half * h)
        ends = (right, bottom) if far else (w, h)
        boxes = np.column_stack([left, top, *ends]) * scale(width, height)
        return boxes.astype(int) if whole else boxes

    return function


XYXY_FROM_YOLO = Exercise(
    id="vision.xyxy_from_yolo",
    title="Boxes of an annotation file, in pixels",
    points=1,
    reference=vision.xyxy_from_yolo,
    cases=_yolo_cases,
    hints=(
        "A row is class, middle x, middle y, width, height. The last four are shares of the "
        "picture: x and width of its width, y and height of its height.",
        "left = middle x − half the width, right = middle x + half the width.",
        "np.column_stack([x - w / 2, y - h / 2, x + w / 2, y + h / 2]) times (width, height, "
        "width, height).",
    ),
    mistakes=(
        Mistake(
            "middle taken for the corner",
            "x and y are the middle of the box, not its upper left corner: half of its size lies "
            "before them.",
            _from_yolo(corner=True),
        ),
        Mistake(
            "whole width to each side",
            "The box reaches half its width to either side of its middle, not its whole width.",
            _from_yolo(half=1.0),
        ),
        Mistake(
            "width and height instead of right and bottom",
            "The last two numbers are width and height. Asked for are the right and bottom edge.",
            _from_yolo(far=False),
        ),
        Mistake(
            "still shares",
            "These are shares of the picture. Multiply by its width and height for pixels.",
            _from_yolo(scale=lambda w, h: (1, 1, 1, 1)),
        ),
        Mistake(
            "width and height of the picture swapped",
            "x belongs to the picture's width, y to its height.",
            _from_yolo(scale=lambda w, h: (h, w, h, w)),
        ),
        Mistake(
            "width for both",
            "y is a share of the picture's height, not of its width.",
            _from_yolo(scale=lambda w, h: (w, w, w, w)),
        ),
        Mistake(
            "rows before columns",
            "This is (top, left, bottom, right). Boxes here have x first: left, top, right, "
            "bottom.",
            lambda rows, w, h: vision.xyxy_from_yolo(rows, w, h)[:, [1, 0, 3, 2]],
        ),
        Mistake(
            "class taken for x",
            "The first number of a row is the class. The box begins with the second.",
            _from_yolo(columns=(0, 1, 2, 3)),
        ),
        Mistake(
            "y upwards",
            "Top and bottom are counted from the picture's lower edge. Pixels count from the upper "
            "left corner, y downwards.",
            lambda rows, w, h: (
                vision.xyxy_from_yolo(rows, w, h)[:, [0, 3, 2, 1]] * (1, -1, 1, -1) + (0, h, 0, h)
            ),
        ),
        Mistake(
            "boxes as columns",
            "Each column is a box. Asked for is one row a box: shape (n, 4).",
            lambda rows, w, h: vision.xyxy_from_yolo(rows, w, h).T,
        ),
        Mistake(
            "rounded to whole pixels",
            "The edges are cut to whole pixels. A box may begin inside a pixel: keep the decimals.",
            _from_yolo(whole=True),
        ),
    ),
)


def _iou_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    one = np.array([[10.0, 20.0, 50.0, 60.0]])
    apart = np.array([[60.0, 70.0, 90.0, 80.0], [60.0, 20.0, 80.0, 60.0], [50.0, 20.0, 90.0, 60.0]])
    cross = np.array([[0.0, 4.0, 12.0, 6.0]]), np.array([[4.0, 0.0, 6.0, 12.0]])
    inside = np.array([[20.0, 30.0, 40.0, 50.0], [10.0, 20.0, 50.0, 60.0]])
    return [
        Case("a box and itself", (one, one.copy()), "", 1e-9),
        Case("boxes that do not touch, or only at an edge", (one, apart), "", 1e-9),
        Case("a box inside another", (one, inside), "", 1e-9),
        Case("a box around another", (inside[:1], one), "", 1e-9),
        Case("half of it", (one, one + np.array([20.0, 0.0, 20.0, 0.0])), "", 1e-9),
        Case("many with many", (some_boxes(rng, 6), some_boxes(rng, 9)), "", 1e-9),
        Case("one with none", (one, np.empty((0, 4))), "", 1e-9),
        Case("crossing boxes", cross, "", 1e-9),
    ]


def _iou(
    *,
    inner: Callable[[Boxes], Boxes] = lambda sides: np.clip(sides, 0.0, None),
    extra: float = 0.0,
    under: Callable[..., Boxes] = lambda common, a, b: a + b - common,
    low: Callable[..., Boxes] = np.maximum,
    turned: bool = False,
) -> Callable[..., Boxes]:
    """Intersection over union with one part wrong."""

    def area(boxes: Boxes) -> Boxes:
        return (boxes[..., 2] - boxes[..., 0] + extra) * (boxes[..., 3] - boxes[..., 1] + extra)

    def function(a: Boxes, b: Boxes) -> Boxes:
        a, b = a[:, None], b[None]
        sides = np.minimum(a[..., 2:], b[..., 2:]) - low(a[..., :2], b[..., :2]) + extra
        common = inner(sides).prod(axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            found = common / under(common, area(a), area(b))
        return found.T if turned else found

    return function


def _over_the_whole(a: Boxes, b: Boxes) -> Boxes:
    """The common part over the box around both."""
    low = np.minimum(a[:, None, :2], b[None, :, :2])
    around = (np.maximum(a[:, None, 2:], b[None, :, 2:]) - low).prod(axis=-1)
    return _iou(under=lambda common, one, other: 1.0 + 0.0 * (one + other))(a, b) / around


BOX_IOU = Exercise(
    id="vision.box_iou",
    title="Overlap of boxes: intersection over union",
    points=3,
    reference=vision.box_iou,
    cases=_iou_cases,
    hints=(
        "The common part reaches from the larger of the two left edges to the smaller of the two "
        "right ones. If that is negative, nothing is common.",
        "union = area of one + area of the other − the common part.",
        "All pairs at once: a[:, None, :2] has shape (n, 1, 2), b[None, :, :2] has (1, m, 2); "
        "np.maximum of both has (n, m, 2).",
        "sides = np.clip(np.minimum(…) - np.maximum(…), 0, None); common = sides[..., 0] * "
        "sides[..., 1].",
    ),
    mistakes=(
        Mistake(
            "negative sides multiplied",
            "Two boxes that lie apart in x and in y have two negative sides, and their product is "
            "positive. Cut each side at 0 before you multiply.",
            _iou(inner=lambda sides: sides),
        ),
        Mistake(
            "absolute value of the sides",
            "The gap between two boxes is taken for a common part. Cut each side at 0.",
            _iou(inner=np.abs),
        ),
        Mistake(
            "union with the common part twice",
            "The union is the sum of both areas minus the common part: that would count twice.",
            _iou(under=lambda common, a, b: a + b),
        ),
        Mistake(
            "divided by the smaller box",
            "This is divided by the smaller of the two boxes: a small one inside a large one would "
            "be a perfect match. Divide by the union.",
            _iou(under=lambda common, a, b: np.minimum(a, b)),
        ),
        Mistake(
            "divided by the larger box",
            "This is divided by the larger of the two boxes. Divide by what both cover together.",
            _iou(under=lambda common, a, b: np.maximum(a, b)),
        ),
        Mistake(
            "divided by the box around both",
            "This is divided by the smallest box around both. The union is less: area + area − the "
            "common part.",
            _over_the_whole,
        ),
        Mistake(
            "twice over the sum",
            "This is twice the common part over the sum of both areas, Dice's coefficient. Divide "
            "the common part by the union.",
            _iou(under=lambda common, a, b: 0.5 * (a + b)),
        ),
        Mistake(
            "right and bottom taken for sizes",
            "The last two numbers of a box are taken for its width and height. They are its right "
            "and bottom edge.",
            lambda a, b: vision.box_iou(
                *(np.hstack([x[:, :2], x[:, :2] + x[:, 2:]]) for x in (a, b))
            ),
        ),
        Mistake(
            "divided by the first box",
            "This is divided by the area of the first box only. Divide by the union of both.",
            _iou(under=lambda common, a, b: a + 0.0 * b),
        ),
        Mistake(
            "intersection only",
            "This is the common area. Divide it by the union.",
            _iou(under=lambda common, a, b: 1.0 + 0.0 * (a + b)),
        ),
        Mistake(
            "one pixel too many",
            "Each side is one pixel too long. Edges here are places, not numbers of pixels: width "
            "= right − left.",
            _iou(extra=1.0),
        ),
        Mistake(
            "smaller left edge",
            "The common part begins at the larger of the two left edges, not at the smaller.",
            _iou(low=np.minimum),
        ),
        Mistake(
            "table turned",
            "Rows and columns are swapped: row i belongs to box i of a, column j to box j of b.",
            _iou(turned=True),
        ),
        Mistake(
            "pair by pair",
            "Only box i of a with box i of b is compared. Asked for are all pairs: shape (n, m).",
            lambda a, b: np.diag(vision.box_iou(a, b)),
        ),
    ),
)
