"""The challenge: a network of the student's own training, and what goes wrong with such networks.

Wrong answers are made from what is really in the pictures, not by running a network: whose ever
network it was, an answer is told by what it shows. Nothing here needs the course's own weights.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from robocon_course import vision
from robocon_course._arrays import FloatArray
from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import NOTHING, kind_of
from robocon_course.exercises.model import Case, Exercise, Mistake, Score
from robocon_course.vision import Detections
from robocon_course.vision.metrics import average_precisions, score_pictures
from robocon_course.worlds import Student

COUNT = 16
SIZE = (160, 120)
SMALL = 14.0
"""Balls whose longer side is less than this are hard for a network of 96 pixels [pixels]."""
SURE = 0.97
CLEARLY = 0.25
"""By so much mAP a change must help before it counts as what went wrong."""

Truth = Sequence[tuple[np.ndarray, np.ndarray]]
Found = list[Detections]
_truths: dict[str, Truth] = {}


def _picture_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = []
    for part in ("first", "second", "third"):
        images, truth = _test_set(int(rng.integers(1 << 31)))
        what = f"the {part} {COUNT} of your own pictures"
        shows = functools.partial(_symptom, truth)
        cases.append(Case(what, (images,), judge=_wrong_form, truth=truth, traits=shows))
    return cases


@functools.lru_cache(maxsize=12)
def _test_set(seed: int) -> tuple[np.ndarray, Truth]:
    """Pictures that nobody has trained on, and what is in them."""
    from robocon_course.vision.pictures import picture

    taken = [picture("ball", seed, k, SIZE) for k in range(COUNT)]
    images, truth = np.stack([t.image_bgr for t in taken]), [(t.boxes, t.class_ids) for t in taken]
    _truths[_digest(images)] = truth
    return images, truth


def _digest(images: np.ndarray) -> str:
    return hashlib.sha256(np.ascontiguousarray(images).tobytes()).hexdigest()


# --- how good an answer is ------------------------------------------------------------------------


def _wrong_form(reply: Reply) -> str | None:
    """What keeps an answer from being measured, None if nothing does."""
    if reply.error:
        return f"{reply.error}: {reply.message}"
    if reply.value is None:
        return NOTHING
    if not isinstance(reply.value, list | tuple) or isinstance(reply.value, Detections):
        return f"expected a list of {COUNT} Detections, one a picture, got {kind_of(reply.value)}"
    if len(reply.value) != COUNT:
        return f"expected one result for each of {COUNT} pictures, got {len(reply.value)}"
    try:
        for item in reply.value:
            _as_found(item)
    except (TypeError, ValueError) as error:
        return str(error)
    return None


def _as_found(item: Any) -> Detections:
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
    if not all(np.isfinite(part).all() for part in (boxes, scores, ids)):
        raise ValueError("expected finite numbers, got NaN or infinity")
    return Detections(boxes, scores, ids.astype(int))


def _missing(case: Case, found: Found) -> float:
    """What is missing to a mAP of 1 [per cent]."""
    found = [_as_found(item) for item in found]
    ids = np.concatenate([item.class_ids for item in found])
    if ids.size and not (ids.min() >= 0 and ids.max() <= 2):
        raise ValueError(
            f"class numbers are 0 blue, 1 purple, 2 red; got {ids.min()} to {ids.max()}"
        )
    return 100.0 * (1.0 - _quality(case.truth, found))


def _quality(truth: Truth, found: Found) -> float:
    """Mean of the average precisions of the three colours."""
    rows = [(mine, *true) for mine, true in zip(found, truth, strict=True)]
    return float(np.nanmean(average_precisions(score_pictures(rows, 3))))


# --- what an answer shows -------------------------------------------------------------------------


def _recoloured(numbers: tuple[int, int, int]) -> Callable[[Detections], Detections]:
    table = np.array(numbers)
    return lambda found: found._replace(class_ids=table[found.class_ids])


def _boxed(change: Callable[[FloatArray], FloatArray]) -> Callable[[Detections], Detections]:
    return lambda found: found._replace(boxes=change(np.asarray(found.boxes, float)))


def _kept(keep: Callable[[Detections], np.ndarray]) -> Callable[[Detections], Detections]:
    return lambda found: Detections(*(part[keep(found)] for part in found))


def _corners(boxes: FloatArray) -> FloatArray:
    """Boxes of middle and size."""
    return np.hstack([boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2])


def _longest(boxes: FloatArray) -> FloatArray:
    return (boxes[:, 2:] - boxes[:, :2]).max(axis=1, initial=0.0)


class _Fault(NamedTuple):
    """A fault that can be undone: how it is made, and what makes it good again."""

    name: str
    make: Callable[[Detections], Detections]
    mend: Callable[[Detections], Detections]


BARS = (0, (SIZE[0] - SIZE[1]) // 2, 0, (SIZE[0] - SIZE[1]) // 2)
FAULTS = (
    _Fault("red and blue swapped", _recoloured((2, 1, 0)), _recoloured((2, 1, 0))),
    _Fault("order of another data set", _recoloured((0, 2, 1)), _recoloured((0, 2, 1))),
    _Fault("blue and purple swapped", _recoloured((1, 0, 2)), _recoloured((1, 0, 2))),
    _Fault("classes from another beginning", _recoloured((1, 2, 0)), _recoloured((2, 0, 1))),
    _Fault(
        "shares instead of pixels",
        _boxed(lambda b: b / (*SIZE, *SIZE)),
        _boxed(lambda b: b * (*SIZE, *SIZE)),
    ),
    _Fault(
        "middle and size",
        _boxed(lambda b: np.hstack([(b[:, :2] + b[:, 2:]) / 2, b[:, 2:] - b[:, :2]])),
        _boxed(_corners),
    ),
    _Fault("bars not taken off", _boxed(lambda b: b + BARS), _boxed(lambda b: b - BARS)),
    _Fault(
        "pixels of the network",
        _boxed(lambda b: 2.0 * (b + BARS)),
        _boxed(lambda b: b / 2.0 - BARS),
    ),
    _Fault(
        "x and y swapped",
        _boxed(lambda b: b[:, [1, 0, 3, 2]]),
        _boxed(lambda b: b[:, [1, 0, 3, 2]]),
    ),
)


def _symptom(truth: Truth, value: Any) -> str:
    """What an answer shows, by the name of a mistake; empty where it is nothing in particular."""
    found = [_as_found(item) for item in value]
    ids = np.concatenate([item.class_ids for item in found])
    if not ids.size:
        return "nothing found"
    if ids.max() > 2:
        return "a network of 80 classes" if ids.max() > 14 else "the silos' network"
    if ids.min() < 0:
        return ""
    quality = _quality(truth, found)
    mended = {f.name: _quality(truth, [f.mend(item) for item in found]) for f in FAULTS}
    name = max(mended, key=mended.__getitem__)
    if mended[name] > quality + CLEARLY:
        return name
    return _weakness(truth, found, quality)


def _weakness(truth: Truth, found: Found, quality: float) -> str:
    """What a network is bad at that does nothing wrong."""
    colourless = [item._replace(class_ids=0 * item.class_ids) for item in found]
    balls = [(boxes, 0 * ids) for boxes, ids in truth]
    if _quality(balls, colourless) > quality + CLEARLY:
        alike = len(np.unique(np.concatenate([item.class_ids for item in found]))) == 1
        return "one colour for all" if alike else "colours guessed"
    if min(item.scores.min(initial=1.0) for item in found) > 0.9:
        return "only the very sure"
    large = [(boxes[_longest(boxes) >= SMALL], ids[_longest(boxes) >= SMALL])
             for boxes, ids in truth]  # fmt: skip
    near = [_kept(lambda item: _longest(item.boxes) >= SMALL)(item) for item in found]
    return "small ones missed" if _quality(large, near) > quality + CLEARLY else ""


# --- the answers that show it ---------------------------------------------------------------------


def _from_truth(change: Callable[[Detections], Detections]) -> Callable[[np.ndarray], Found]:
    """What would be found by a network that sees all, and is misread or misled in one way."""

    def function(images: np.ndarray) -> Found:
        rows = _truths[_digest(images)]
        return [
            change(Detections(boxes.astype(float), np.linspace(0.995, 0.6, len(ids)), ids))
            for boxes, ids in rows
        ]

    return function


def _by_place(found: Detections) -> Detections:
    """Colours by where a ball lies: no better than guessed."""
    return found._replace(class_ids=np.floor(7.0 * found.boxes[:, 0]).astype(int) % 3)


MADE = {fault.name: _from_truth(fault.make) for fault in FAULTS}

FIND_BALLS = Exercise(
    id="vision.find_balls",
    title="Challenge: your own network",
    points=4,
    reference=vision.find_balls,
    cases=_picture_cases,
    file="ball.onnx",
    time_limit=30.0,
    shortcuts=("robocon_course.vision.detection._shipped", "robocon_course.files.data_file"),
    score=Score(_missing, "% missing to a mAP of 1", ((25.0, 1.0), (50.0, 0.5))),
    hints=(
        'vision.load_detector("ball.onnx") opens the file that training.export wrote beside this '
        "notebook; its detect(image) gives Detections.",
        "Return a list with one result for each picture. A lower min_score than 0.4 finds more "
        "and costs little: mAP looks at all scores. Try 0.05.",
        "More pictures help more than more epochs, and 160 pixels more than 96. Start a longer "
        "training from the last one with start_from.",
    ),
    mistakes=(
        Mistake(
            "red and blue swapped",
            "Blue balls are called red and red ones blue. Was the picture given as RGB, or are "
            "the classes in another order? 0 is blue, 1 purple, 2 red.",
            MADE["red and blue swapped"],
        ),
        Mistake(
            "order of another data set",
            "The classes are in the order blue, red, purple, as in another team's list. Here it is "
            "blue, purple, red.",
            MADE["order of another data set"],
        ),
        Mistake(
            "blue and purple swapped",
            "The classes are in the order purple, blue, red. Here it is blue, purple, red.",
            MADE["blue and purple swapped"],
        ),
        Mistake(
            "classes from another beginning",
            "Every class number is one too large, and the last one has become 0. The data set's "
            "labels begin with 0: 0 blue, 1 purple, 2 red.",
            MADE["classes from another beginning"],
        ),
        Mistake(
            "one colour for all",
            "The balls are found, and all are called the same. Are there labels of three classes "
            "in your data set?",
            _from_truth(_recoloured((0, 0, 0))),
        ),
        Mistake(
            "colours guessed",
            "The balls are found, and their colours are guessed. An augmentation that turns the "
            "hue takes away what tells the classes apart: hsv_h must stay small.",
            _from_truth(_by_place),
        ),
        Mistake(
            "shares instead of pixels",
            "The boxes are shares of the picture. Asked for are pixels.",
            MADE["shares instead of pixels"],
        ),
        Mistake(
            "middle and size",
            "The boxes are middle and size. Asked for are left, top, right, bottom.",
            MADE["middle and size"],
        ),
        Mistake(
            "bars not taken off",
            "All boxes lie too low by the height of the grey bar that the letterbox puts above "
            "the picture: subtract the letterbox's shift.",
            MADE["bars not taken off"],
        ),
        Mistake(
            "pixels of the network",
            "The boxes are in pixels of the network's square, not of the picture: subtract the "
            "letterbox's shift and divide by its scale.",
            MADE["pixels of the network"],
        ),
        Mistake(
            "x and y swapped",
            "The boxes are top, left, bottom, right.",
            MADE["x and y swapped"],
        ),
        Mistake(
            "only the very sure",
            "Nothing with a score of less than 0.9 is reported: most balls are missed. Lower "
            "min_score; mAP looks at all scores.",
            _from_truth(_kept(lambda found: found.scores > SURE)),
        ),
        Mistake(
            "small ones missed",
            "Large balls are found, small ones are not. Train with larger pictures: at 96 pixels "
            "a ball at the other end of the field is two pixels wide.",
            _from_truth(_kept(lambda found: _longest(found.boxes) >= SMALL)),
        ),
        Mistake(
            "nothing found",
            "Nothing is found in any picture. Was the network trained at all?",
            _from_truth(_kept(lambda found: found.scores > 2.0)),
        ),
        Mistake(
            "the silos' network",
            "There are class numbers beyond 2: this network knows the fillings of silos. Hand in "
            "the one that you trained on balls.",
            _from_truth(
                lambda found: found._replace(class_ids=3 + np.arange(len(found.scores)) % 12)
            ),
        ),
        Mistake(
            "a network of 80 classes",
            "There are class numbers beyond 14: this network knows the 80 things of the COCO data "
            "set, as it is downloaded. Hand in one that you trained on balls.",
            _from_truth(lambda found: found._replace(class_ids=32 + 0 * found.class_ids)),
        ),
    ),
)
