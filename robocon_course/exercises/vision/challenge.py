"""The challenge: a network of the student's own training, and how such networks are misread."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from robocon_course import vision
from robocon_course.exercises.model import Case, Exercise, Mistake, Score
from robocon_course.vision import Detections
from robocon_course.vision.metrics import average_precisions, score_pictures
from robocon_course.worlds import Student

COUNT = 16
SIZE = (160, 120)


def _picture_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = []
    for part in ("first", "second", "third"):
        images, truth = _test_set(int(rng.integers(1 << 31)))
        cases.append(Case(f"the {part} {COUNT} of your own pictures", (images,), truth=truth))
    return cases


@functools.lru_cache(maxsize=12)
def _test_set(seed: int) -> tuple[np.ndarray, list]:
    """Pictures that nobody has trained on, and what is in them."""
    from robocon_course.vision.pictures import picture

    taken = [picture("ball", seed, k, SIZE) for k in range(COUNT)]
    return np.stack([t.image_bgr for t in taken]), [(t.boxes, t.class_ids) for t in taken]


def _missing(case: Case, found: list[Detections]) -> float:
    """What is missing to a mAP of 1 [per cent]."""
    if len(found) != COUNT:
        raise ValueError(f"expected one result for each of {COUNT} pictures, got {len(found)}")
    pictures = [(mine, *true) for mine, true in zip(found, case.truth, strict=True)]
    for mine, *_ in pictures:
        ids = np.asarray(mine.class_ids)
        if ids.size and not (ids.min() >= 0 and ids.max() <= 2):
            raise ValueError(f"class numbers are 0 blue, 1 purple, 2 red; got {ids.max()}")
    scored = score_pictures([(_as_found(m), b, i) for m, b, i in pictures], 3)
    return 100.0 * (1.0 - float(np.nanmean(average_precisions(scored))))


def _as_found(found: Detections) -> Detections:
    """Detections as arrays, whatever lists a student made of them."""
    boxes = np.asarray(found.boxes, float).reshape(-1, 4)
    return Detections(boxes, np.asarray(found.scores), np.asarray(found.class_ids, int))


def _changed(change: Callable[..., Detections], *, before: Callable = lambda image: image):
    """The course's network, misread in one way."""

    def function(images: np.ndarray) -> list[Detections]:
        detector = vision.load_detector("ball")
        return [change(detector.detect(before(image)), image.shape) for image in images]

    return function


def _recoloured(numbers: tuple[int, int, int]) -> Callable[..., Detections]:
    table = np.array(numbers)
    return lambda found, shape: found._replace(class_ids=table[found.class_ids])


def _boxed(change: Callable[..., np.ndarray]) -> Callable[..., Detections]:
    return lambda found, shape: found._replace(
        boxes=change(found.boxes.astype(float), shape).astype(np.float32)
    )


def _few(found: Detections, shape: tuple) -> Detections:
    sure = found.scores > 0.97
    return Detections(*(part[sure] for part in found))


FIND_BALLS = Exercise(
    id="vision.find_balls",
    title="Challenge: your own network",
    points=4,
    reference=vision.find_balls,
    cases=_picture_cases,
    file="ball.onnx",
    time_limit=30.0,
    shortcuts=("robocon_course.vision.detection._shipped",),
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
            _changed(_recoloured((2, 1, 0))),
        ),
        Mistake(
            "order of another data set",
            "The classes are in the order blue, red, purple. Here it is blue, purple, red.",
            _changed(_recoloured((0, 2, 1))),
        ),
        Mistake(
            "one colour for all",
            "Every ball has class 0.",
            _changed(_recoloured((0, 0, 0))),
        ),
        Mistake(
            "shares instead of pixels",
            "The boxes are shares of the picture. Asked for are pixels.",
            _changed(_boxed(lambda b, shape: b / (shape[1], shape[0], shape[1], shape[0]))),
        ),
        Mistake(
            "middle and size",
            "The boxes are middle and size. Asked for are left, top, right, bottom.",
            _changed(
                _boxed(lambda b, shape: np.hstack([(b[:, :2] + b[:, 2:]) / 2, b[:, 2:] - b[:, :2]]))
            ),
        ),
        Mistake(
            "pixels of the network",
            "The boxes are in pixels of the network's square, not of the picture: subtract the "
            "letterbox's shift and divide by its scale.",
            _changed(_boxed(lambda b, shape: b * 2.0 + (0, 40, 0, 40))),
        ),
        Mistake(
            "x and y swapped",
            "The boxes are top, left, bottom, right.",
            _changed(_boxed(lambda b, shape: b[:, [1, 0, 3, 2]])),
        ),
        Mistake(
            "only the very sure",
            "Only scores above 0.97 are reported: most balls are missed.",
            _changed(_few),
        ),
        Mistake(
            "nothing found",
            "Nothing is found in any picture. Was the network trained at all?",
            _changed(lambda found, shape: Detections(*(part[:0] for part in found))),
        ),
    ),
)
