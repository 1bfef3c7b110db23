"""What a network's answer to some pictures shows: how good it is, and what went wrong with it.

Told by comparing it with what is really in the pictures: by which change would it become clearly
better? That holds for anybody's network, whatever it was trained on.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from robocon_course._arrays import FloatArray
from robocon_course.exercises.compare import kind_of
from robocon_course.vision import Detections
from robocon_course.vision.detection import MOST
from robocon_course.vision.metrics import average_precisions, score_pictures

COUNT = 16
"""Pictures of one case."""
SIZE = (160, 120)
"""Their width and height [pixels]."""
SMALL = 14.0
"""A ball whose longer side is less than this is small [pixels]."""
CLEARLY = 0.25
"""By so much mAP a change must help before it counts as what went wrong."""

Truth = Sequence[tuple[np.ndarray, np.ndarray]]
Found = list[Detections]


def as_found(item: Any) -> Detections:
    """Detections as arrays, whatever lists somebody made of them.

    Raises
    ------
    ValueError
        No boxes with scores and class numbers; the message says what came.
    """
    if not isinstance(item, list | tuple) or len(item) != 3:
        raise ValueError(f"expected Detections for each picture, got {kind_of(item)}")
    boxes, scores, ids = (np.asarray(part, float) for part in item)
    boxes = boxes.reshape(-1, 4) if boxes.size == 0 else boxes
    if not (boxes.shape == (len(boxes), 4) and scores.shape == ids.shape == (len(boxes),)):
        raise ValueError(
            f"expected as many scores and class numbers as boxes of four numbers, got shapes "
            f"{boxes.shape}, {scores.shape} and {ids.shape}"
        )
    if len(boxes) > MOST:
        raise ValueError(f"expected at most {MOST} boxes a picture, got {len(boxes)}")
    if not all(np.isfinite(part).all() for part in (boxes, scores, ids)):
        raise ValueError("expected finite numbers, got NaN or infinity")
    return Detections(boxes, scores, ids.clip(-1, 1000).astype(int))


def quality(truth: Truth, found: Found) -> float:
    """Mean of the average precisions of the three colours."""
    rows = [(mine, *true) for mine, true in zip(found, truth, strict=True)]
    return float(np.nanmean(average_precisions(score_pictures(rows, 3))))


def recoloured(numbers: tuple[int, int, int]) -> Callable[[Detections], Detections]:
    """Class numbers looked up in a list: what was 0 becomes the first of it."""
    table = np.array(numbers)
    return lambda found: found._replace(class_ids=table[found.class_ids])


def _boxed(change: Callable[[FloatArray], FloatArray]) -> Callable[[Detections], Detections]:
    return lambda found: found._replace(boxes=change(np.asarray(found.boxes, float)))


def kept_where(keep: Callable[[Detections], np.ndarray]) -> Callable[[Detections], Detections]:
    """Only those detections of which `keep` says yes."""
    return lambda found: Detections(*(part[keep(found)] for part in found))


def _corners(boxes: FloatArray) -> FloatArray:
    """Boxes of middle and size."""
    return np.hstack([boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2])


def longest(boxes: FloatArray) -> FloatArray:
    """The longer side of each box [pixels]."""
    return (boxes[:, 2:] - boxes[:, :2]).max(axis=1, initial=0.0)


class Fault(NamedTuple):
    """A fault that can be undone: how it is made, and what makes it good again."""

    name: str
    make: Callable[[Detections], Detections]
    mend: Callable[[Detections], Detections]


BARS = (0, (SIZE[0] - SIZE[1]) // 2, 0, (SIZE[0] - SIZE[1]) // 2)
FAULTS = (
    Fault("red and blue swapped", recoloured((2, 1, 0)), recoloured((2, 1, 0))),
    Fault("order of another data set", recoloured((0, 2, 1)), recoloured((0, 2, 1))),
    Fault("blue and purple swapped", recoloured((1, 0, 2)), recoloured((1, 0, 2))),
    Fault("classes from another beginning", recoloured((1, 2, 0)), recoloured((2, 0, 1))),
    Fault(
        "shares instead of pixels",
        _boxed(lambda b: b / (*SIZE, *SIZE)),
        _boxed(lambda b: b * (*SIZE, *SIZE)),
    ),
    Fault(
        "middle and size",
        _boxed(lambda b: np.hstack([(b[:, :2] + b[:, 2:]) / 2, b[:, 2:] - b[:, :2]])),
        _boxed(_corners),
    ),
    Fault("bars not taken off", _boxed(lambda b: b + BARS), _boxed(lambda b: b - BARS)),
    Fault(
        "pixels of the network",
        _boxed(lambda b: 2.0 * (b + BARS)),
        _boxed(lambda b: b / 2.0 - BARS),
    ),
    Fault(
        "x and y swapped",
        _boxed(lambda b: b[:, [1, 0, 3, 2]]),
        _boxed(lambda b: b[:, [1, 0, 3, 2]]),
    ),
)


def symptom(truth: Truth, value: Any) -> str:
    """What an answer shows, by the name of a mistake; empty where it is nothing in particular."""
    found = [as_found(item) for item in value]
    ids = np.concatenate([item.class_ids for item in found])
    if not ids.size:
        return "nothing found"
    if ids.max() > 2:
        return "a network of 80 classes" if ids.max() > 14 else "the silos' network"
    if ids.min() < 0:
        return ""
    now = quality(truth, found)
    mended = {f.name: quality(truth, [f.mend(item) for item in found]) for f in FAULTS}
    name = max(mended, key=mended.__getitem__)
    if mended[name] > now + CLEARLY:
        return name
    return _weakness(truth, found, now)


def _weakness(truth: Truth, found: Found, now: float) -> str:
    """What a network is bad at that does nothing wrong."""
    colourless = [item._replace(class_ids=0 * item.class_ids) for item in found]
    balls = [(boxes, 0 * ids) for boxes, ids in truth]
    if quality(balls, colourless) > now + CLEARLY:
        alike = len(np.unique(np.concatenate([item.class_ids for item in found]))) == 1
        return "one colour for all" if alike else "colours guessed"
    if min(item.scores.min(initial=1.0) for item in found) > 0.9:
        return "only the very sure"
    large = [(boxes[longest(boxes) >= SMALL], ids[longest(boxes) >= SMALL])
             for boxes, ids in truth]  # fmt: skip
    near = [kept_where(lambda item: longest(item.boxes) >= SMALL)(item) for item in found]
    return "small ones missed" if quality(large, near) > now + CLEARLY else ""
