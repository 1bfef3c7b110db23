"""How good a network is on one part of a data set. Loads no torch."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.detection import load_detector
from robocon_course.vision.inspection import (
    PICTURES,
    DatasetError,
    read_names,
    read_picture,
    read_rows,
)
from robocon_course.vision.metrics import average_precisions, score_pictures, xyxy_from_yolo

LOWEST = 0.001
"""Every score counts for an average precision; Ultralytics counts from here, too."""


class Labelled(NamedTuple):
    """A picture of a data set.

    Attributes
    ----------
    name : str
        Of its file, without the ending.
    image_bgr : ndarray of uint8, shape (h, w, 3)
    boxes : ndarray, shape (n, 4)
        Left, top, right, bottom [pixels].
    class_ids : ndarray of int64, shape (n,)
    """

    name: str
    image_bgr: NDArray[np.uint8]
    boxes: FloatArray
    class_ids: NDArray[np.int64]


def read_split(data: str | Path, split: str = "test") -> Iterator[Labelled]:
    """The pictures of one part of a data set, in the order of their names.

    Parameters
    ----------
    data : path
        Folder of a data set, as `dataset.write_dataset` makes it.
    split : {"train", "val", "test"}

    Yields
    ------
    Labelled

    Raises
    ------
    DatasetError
        That part has no pictures, or a picture or label of it cannot be read.
    """
    folder, classes = Path(data) / "images" / split, len(read_names(data))
    listed = sorted(folder.iterdir()) if folder.is_dir() else []
    paths = [path for path in listed if path.suffix.lower() in PICTURES]
    if not paths:
        raise DatasetError(f"{folder}: no pictures; expected a data set with a part {split!r}")
    for path in paths:
        image = read_picture(path)
        if image is None:
            raise DatasetError(f"{path}: not a picture that can be read")
        rows = _rows(Path(data), Path("labels") / split / f"{path.stem}.txt", classes)
        boxes = xyxy_from_yolo(rows, *image.shape[1::-1])
        yield Labelled(path.stem, image, boxes, rows[:, 0].astype(np.int64))


def _rows(data: Path, label: Path, classes: int) -> FloatArray:
    """The boxes of a label file, every line of it."""
    try:
        rows, wrong = read_rows((data / label).read_text(encoding="utf-8"), classes)
    except (OSError, UnicodeDecodeError):
        rows, wrong = np.empty((0, 5)), [(1, "cannot be read")]
    if wrong:
        number, what = wrong[0]
        raise DatasetError(
            f"{label}:{number} {what}; see all with: robocon dataset KIND --check {data}"
        )
    return rows


def evaluate(weights: str | Path, data: str | Path, split: str = "test") -> dict[str, float]:
    """Average precision of each class, at an overlap of 0.5.

    Parameters
    ----------
    weights : path or {"ball", "silo"}
        An .onnx file, or one of the course's own networks.
    data : path
        Folder of a data set.
    split : {"train", "val", "test"}

    Returns
    -------
    dict of str to float
        By class; NaN where none of it is in those pictures. `numpy.nanmean` of it is the mAP.

    Raises
    ------
    DatasetError
        That part has no pictures, or its classes are not those of the network.
    WeightsError
        No such network.
    """
    detector = load_detector(weights)
    names = read_names(data)
    if names != detector.names:
        raise DatasetError(
            f"{data}: its classes are {names[:3]}…, those of the network {detector.names[:3]}…"
        )
    rows = [
        (detector.detect(one.image_bgr, min_score=LOWEST), one.boxes, one.class_ids)
        for one in read_split(data, split)
    ]
    each = average_precisions(score_pictures(rows, len(names)))
    return dict(zip(names, each.tolist(), strict=True))
