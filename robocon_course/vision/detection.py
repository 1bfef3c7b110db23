"""From a picture to boxes: run a trained network, read its output, keep one box a thing.

``load_detector("ball").detect(image_bgr)`` does all of it. The network runs in onnxruntime; what
goes in and what comes out is read in `reading`, whose names can be had from here, too.

Source of the thresholds 0.4 and 0.6: swerve robot of Yogyakarta State University, 2024.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Callable
from copy import copy
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robocon_course import files
from robocon_course._arrays import CourseError, FloatArray
from robocon_course.vision.classes import CLASSES, MIN_SCORE
from robocon_course.vision.reading import (
    MAX_IOU,
    Detections,
    as_picture,
    decode,
    letterbox,
    non_max_suppression,
)

MOST = 300
"""How many boxes of one picture are kept at most."""
LARGEST = 1280
"""A network for larger pictures would need more memory than a robot has to spare [pixels]."""
LEAST_SCORE = 0.05
"""Below this a report is of no use even for a mean over all thresholds."""


class WeightsError(CourseError):
    """A file of weights that is missing, damaged, or not of a network the course can run."""


class Detector:
    """A trained network, ready to look at pictures. Made by `load_detector`.

    Attributes
    ----------
    names : tuple of str
        The classes, by their number.
    min_score : float
        Lowest score that counts when `detect` is given none.
    size : int  [pixels]
        Longer side of what the network looks at.
    step : int  [pixels]
        Both sides are multiples of it; as large as `size` for a network that takes squares only.
    """

    def __init__(
        self,
        session: Any,
        names: tuple[str, ...],
        min_score: float,
        size: int,
        step: int,
    ) -> None:
        self.names, self.min_score, self.size, self.step = names, min_score, size, step
        self._session, self._input = session, session.get_inputs()[0].name
        self._decode, self._suppress = decode, non_max_suppression

    def with_parts(self, decode: Callable, suppress: Callable) -> Detector:
        """The same network, read by other functions in place of `decode` and its suppression."""
        other = copy(self)
        other._decode, other._suppress = decode, suppress
        return other

    def with_size(self, size: int) -> Detector:
        """The same network, looking at pictures of another size.

        Small things are found better in a larger picture, in more time: 480 pixels take 2.25 times
        the work of 320. The course's ball network looks at 480 and is trained for 320 to 480
        pixels; the silos' looks at 320, and gains nothing by more.

        Parameters
        ----------
        size : int  [pixels]
            Longer side of what it looks at.

        Returns
        -------
        Detector

        Raises
        ------
        ValueError
            No multiple of 32, or another size than the only one that its file takes.
        """
        whole = isinstance(size, int | np.integer) and not isinstance(size, bool)
        if self.step == self.size != size:
            raise ValueError(f"size: this network takes {self.size} pixels only, got {size!r}")
        if not whole or size < self.step or size % self.step:
            raise ValueError(f"size: expected a multiple of {self.step} pixels, got {size!r}")
        other = copy(self)
        other.size = int(size)
        return other

    def letterbox(self, image_bgr: NDArray[np.uint8]) -> tuple:
        """A picture as this network takes it, its scale and shift; see `reading.letterbox`."""
        return letterbox(image_bgr, self.size, self.step)

    def guesses(self, image_bgr: NDArray[np.uint8]) -> FloatArray:
        """The network's own numbers on a picture, as `decode` reads them.

        Parameters
        ----------
        image_bgr : ndarray of uint8, shape (h, w, 3)

        Returns
        -------
        ndarray, shape (4 + classes, n)
            Boxes in pixels of the letterboxed picture.

        Raises
        ------
        ValueError
            Not a picture; see `detect`.
        """
        return self._run(self.letterbox(as_picture(image_bgr))[0])

    def _run(self, tensor: NDArray[np.float32]) -> FloatArray:
        return self._session.run(None, {self._input: tensor})[0][0]

    def detect(self, image_bgr: NDArray[np.uint8], *, min_score: float | None = None) -> Detections:
        """What is in a picture.

        Parameters
        ----------
        image_bgr : ndarray of uint8, shape (h, w, 3), (h, w, 4) or (h, w)
            Blue, green, red, as OpenCV reads it. A fourth channel is dropped, a grey picture is
            taken as one with three equal channels. Any size: it is fitted into the network's
            square, so a ball that is small in a large picture becomes smaller still.
        min_score : float, optional
            Lowest score that counts, 0 to 1; left out, it is `min_score` of the detector.

        Returns
        -------
        Detections
            Boxes inside the picture, the surest first; empty arrays where nothing is found.

        Raises
        ------
        ValueError
            Not a picture of bytes, one without pixels, or a score outside 0 to 1.
        """
        image_bgr = as_picture(image_bgr)
        if min_score is None:
            min_score = self.min_score
        elif not (isinstance(min_score, int | float | np.number) and 0.0 <= min_score <= 1.0):
            raise ValueError(f"min_score: expected a number from 0 to 1, got {min_score!r}")
        tensor, scale, shift = self.letterbox(image_bgr)
        boxes, scores, class_ids = self._decode(self._run(tensor), min_score)
        kept = np.asarray(self._suppress(boxes, scores, class_ids, MAX_IOU), int)[:MOST]
        boxes = (np.asarray(boxes)[kept].reshape(-1, 4) - (*shift, *shift)) / scale
        height, width = image_bgr.shape[:2]
        return Detections(
            np.clip(boxes, 0, (width, height, width, height)).astype(np.float32),
            np.asarray(scores, np.float32)[kept],
            np.asarray(class_ids, np.int64)[kept],
        )


# --- weights --------------------------------------------------------------------------------------


def load_detector(weights: str | Path) -> Detector:
    """A detector, ready to use.

    Parameters
    ----------
    weights : {"ball", "silo"} or path
        One of the course's own networks, or an .onnx file of your own training.

    Returns
    -------
    Detector

    Raises
    ------
    WeightsError
        A file that is missing, empty, cut short or altered (the course's own are compared with
        their SHA-256 before anything reads them), or no network with boxes and classes.
    """
    if not isinstance(weights, str | Path):
        raise WeightsError(f"weights: expected 'ball', 'silo' or a path, got {weights!r}")
    if str(weights) in CLASSES:
        return _shipped(str(weights))
    return _open(_read(Path(weights)), Path(weights))


def find_balls(images: NDArray[np.uint8]) -> list[Detections]:
    """The balls in some pictures, by the course's own network, the unsure ones among them.

    What a network is sure of is for its user to say; mAP looks at every score.

    Parameters
    ----------
    images : ndarray of uint8, shape (n, h, w, 3)
        Blue, green, red.

    Returns
    -------
    list of Detections
        One for each picture.
    """
    detector = load_detector("ball")
    return [detector.detect(image, min_score=LEAST_SCORE) for image in images]


@cache
def _shipped(kind: str) -> Detector:
    """One of the course's own networks, opened once."""
    try:
        path = files.data_file(f"weights/{kind}.onnx")
        sums = files.checksums("weights")
    except FileNotFoundError as error:
        raise WeightsError(str(error)) from None
    except ValueError:
        raise WeightsError("SHA256SUMS is not text; install the course again") from None
    data = _read(path)
    found = hashlib.sha256(data).hexdigest()
    if sums.get(path.name) != found:
        raise WeightsError(
            f"{path.name} is not the file the course came with (SHA-256 {found[:12]}…, expected "
            f"{sums.get(path.name, 'none')[:12]}…); install the course again"
        )
    detector = _open(data, path)
    if detector.names != CLASSES[kind]:
        raise WeightsError(f"{path.name}: its classes are not those of {kind!r}")
    return detector


def _read(path: Path) -> bytes:
    """The bytes of a file of weights."""
    try:
        size = path.stat().st_size
        if size > files.LARGEST_WEIGHTS:
            raise WeightsError(f"{path.name}: {size / 1e6:.0f} MB; at most 13 MB are read")
        data = path.read_bytes()
    except OSError as error:
        raise WeightsError(f"{path.name}: cannot be read ({error.strerror})") from None
    if not data:
        raise WeightsError(f"{path.name}: the file is empty; export it again")
    return data


def _open(data: bytes, path: Path) -> Detector:
    """A network from its bytes, its classes from the note in them."""
    import onnxruntime

    options = onnxruntime.SessionOptions()
    options.log_severity_level = 4
    # Threads wait for work by spinning, for long, and take a core from whatever else the robot does
    # and from this network's own other thread. So short a wait costs little when nothing else runs.
    options.add_session_config_entry("session.intra_op.spin_duration_us", "20")
    try:
        session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
        noted = session.get_modelmeta().custom_metadata_map
        names = ast.literal_eval(noted.get("names", "{}"))
        names = tuple(str(names[k]) for k in sorted(names))
        (taken, *more), given = session.get_inputs(), session.get_outputs()[0]
        size, step = _sides(taken.shape, noted)
    except Exception as error:  # onnxruntime raises a class of its own for each of its reasons
        reason = str(error).splitlines()[0][:120]
        raise WeightsError(f"{path.name}: not a network that can be opened ({reason})") from None
    if more or {taken.type, given.type} != {"tensor(float)"}:
        raise WeightsError(
            f"{path.name}: takes {1 + len(more)} inputs, the first a {taken.type}, and gives a "
            f"{given.type}; expected one input, both tensor(float): export it without half=True"
        )
    gives = given.shape
    if not (size and names and len(gives) == 3 and gives[1] == 4 + len(names)):
        raise WeightsError(
            f"{path.name}: takes {taken.shape} and gives {gives} for {len(names)} classes; "
            "expected [1, 3, s, s] and [1, 4 + classes, n], as `robocon train` exports it"
        )
    kind = next((k for k, known in CLASSES.items() if known == names), None)
    return Detector(session, names, MIN_SCORE.get(kind, 0.25), size, step)


def _sides(takes: list, noted: dict[str, str]) -> tuple[int, int]:
    """Longer side of what a network takes and the step of both [pixels]; 0 if it takes others.

    A side that is left open has a name in place of a number; what it is meant for is noted.
    """
    if takes[1] != 3 or isinstance(takes[2], int) != isinstance(takes[3], int):
        return 0, 0
    if isinstance(takes[2], int):
        return (takes[2], takes[2]) if takes[2] == takes[3] and takes[0] == 1 else (0, 0)
    size, step = max(ast.literal_eval(noted["imgsz"])), int(noted["stride"])
    return (size, step) if 0 < step <= size <= LARGEST and size % step == 0 else (0, 0)


__all__ = [
    "Detections",
    "Detector",
    "WeightsError",
    "as_picture",
    "decode",
    "find_balls",
    "letterbox",
    "load_detector",
    "non_max_suppression",
]
