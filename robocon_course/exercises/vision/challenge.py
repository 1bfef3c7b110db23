"""The challenge: a network of the student's own training, and what goes wrong with such networks.

Wrong answers are made from what is really in the pictures, not by running a network: whose ever
network it was, an answer is told by what it shows. Nothing here needs the course's own weights.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import NOTHING, kind_of
from robocon_course.exercises.model import Case, Exercise, Mistake, Score
from robocon_course.exercises.vision.symptoms import (
    COUNT,
    FAULTS,
    SIZE,
    SMALL,
    Found,
    Truth,
    as_found,
    kept_where,
    longest,
    quality,
    recoloured,
    symptom,
)
from robocon_course.vision import Detections
from robocon_course.worlds import Student

SURE = 0.97
_truths: dict[str, Truth] = {}


def _picture_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = []
    for part in ("first", "second", "third"):
        images, truth = _test_set(int(rng.integers(1 << 31)))
        what = f"the {part} {COUNT} of your own pictures"
        shows = functools.partial(symptom, truth)
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
            as_found(item)
    except (TypeError, ValueError) as error:
        return str(error)
    return None


def _missing(case: Case, found: Found) -> float:
    """What is missing to a mAP of 1 [per cent]."""
    found = [as_found(item) for item in found]
    ids = np.concatenate([item.class_ids for item in found])
    if ids.size and not (ids.min() >= 0 and ids.max() <= 2):
        raise ValueError(
            f"class numbers are 0 blue, 1 purple, 2 red; got {ids.min()} to {ids.max()}"
        )
    return 100.0 * (1.0 - quality(case.truth, found))


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
            "The balls are found, and all are called the same. Look at the labels of your data "
            "set: the first number of a row is the class, 0, 1 or 2.",
            _from_truth(recoloured((0, 0, 0))),
        ),
        Mistake(
            "colours guessed",
            "The balls are found, and their colours are guessed. Was the picture given as RGB? Did "
            "an augmentation turn the hue? It tells the classes apart: hsv_h must stay small.",
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
            _from_truth(kept_where(lambda found: found.scores > SURE)),
        ),
        Mistake(
            "small ones missed",
            "Large balls are found, small ones are not. Train with larger pictures: at 96 pixels "
            "a ball at the other end of the field is two pixels wide.",
            _from_truth(kept_where(lambda found: longest(found.boxes) >= SMALL)),
        ),
        Mistake(
            "nothing found",
            "Nothing is found in any picture. A network that was hardly trained is sure of "
            "nothing.",
            _from_truth(kept_where(lambda found: found.scores > 2.0)),
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
