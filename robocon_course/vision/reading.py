"""What goes into a network and what comes out of it, in numpy: pictures, numbers, boxes.

Boxes are (left, top, right, bottom) in pixels of the picture, from its upper left corner.

Source: YOLOv8's head without anchors; letterbox and rounding as in Ultralytics 8.4, so that both
give the same boxes.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.metrics import box_iou

MAX_IOU = 0.7
"""Two boxes of one class that share more than this are one thing seen twice."""
GREY = 114
"""What the letterbox is filled with."""


class Detections(NamedTuple):
    """What was found in a picture, the surest first.

    Attributes
    ----------
    boxes : ndarray of float32, shape (n, 4)  [pixels]
        Left, top, right, bottom.
    scores : ndarray of float32, shape (n,)
        How sure, 0 to 1.
    class_ids : ndarray of int64, shape (n,)
        By the order of `Detector.names`.
    """

    boxes: NDArray[np.float32]
    scores: NDArray[np.float32]
    class_ids: NDArray[np.int64]


def letterbox(
    image_bgr: NDArray[np.uint8], size: int = 320, step: int | None = None
) -> tuple[NDArray[np.float32], float, tuple[int, int]]:
    """A picture of any shape as a network takes it, with grey bars beside it.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    size : int  [pixels]
        Of the longer side.
    step : int, optional  [pixels]
        Both sides become multiples of it, with no more grey than that takes: less for the network
        to look at. Left out, the result is a square.

    Returns
    -------
    tensor : ndarray of float32, shape (1, 3, h', w')
        Red, green, blue planes, 0 to 1.
    scale : float
        Pixels of the result per pixel of the picture.
    shift : (int, int)  [pixels of the result]
        Where the picture's left and upper edge lie.
    """
    import cv2

    height, width = image_bgr.shape[:2]
    scale = min(size / height, size / width)
    inner = max(1, round(width * scale)), max(1, round(height * scale))
    if inner != (width, height):
        image_bgr = cv2.resize(image_bgr, inner, interpolation=cv2.INTER_LINEAR)
    outer = [side + -side % (step or size) for side in inner]
    left, top = (round((whole - side) / 2 - 0.1) for whole, side in zip(outer, inner, strict=True))
    boxed = np.full((outer[1], outer[0], 3), GREY, np.uint8)
    boxed[top : top + inner[1], left : left + inner[0]] = image_bgr
    return cv2.dnn.blobFromImage(boxed, 1 / 255.0, swapRB=True), scale, (left, top)


def decode(
    output: FloatArray, min_score: float
) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """The network's numbers as boxes, scores and classes; still several boxes a thing.

    Parameters
    ----------
    output : ndarray, shape (4 + classes, n)
        A column for each of n places in the picture: middle x and y, width, height [pixels], and
        the score of each class.
    min_score : float
        A column counts if its best class scores more.

    Returns
    -------
    boxes : ndarray, shape (k, 4)
        Left, top, right, bottom [pixels].
    scores : ndarray, shape (k,)
    class_ids : ndarray of int64, shape (k,)
    """
    columns = output[:, output[4:].max(axis=0) > min_score].T
    middle, half = columns[:, :2], columns[:, 2:4] / 2
    boxes = np.hstack([middle - half, middle + half])
    return boxes, columns[:, 4:].max(axis=1), columns[:, 4:].argmax(axis=1)


def non_max_suppression(
    boxes: FloatArray,
    scores: FloatArray,
    class_ids: NDArray[np.int64],
    max_iou: float = MAX_IOU,
) -> NDArray[np.int64]:
    """Which boxes to keep: of those that overlap in one class, only the surest.

    Parameters
    ----------
    boxes : ndarray, shape (n, 4)
    scores : ndarray, shape (n,)
    class_ids : ndarray, shape (n,)
    max_iou : float
        A box that shares more than this with a surer one of its class is dropped.

    Returns
    -------
    ndarray of int64, shape (k,)
        Indices of the kept boxes, the surest first; of equal scores the earlier one.
    """
    left = np.argsort(-np.asarray(scores), kind="stable")
    boxes, class_ids = np.asarray(boxes), np.asarray(class_ids)
    kept = []
    while len(left):
        best, left = left[0], left[1:]
        kept.append(best)
        overlap = box_iou(boxes[[best]], boxes[left])[0]
        left = left[(class_ids[left] != class_ids[best]) | (overlap <= max_iou)]
    return np.array(kept, np.int64)


def as_picture(image: Any) -> NDArray[np.uint8]:
    """A picture as (h, w, 3) bytes; see `Detector.detect` for what passes.

    Raises
    ------
    ValueError
        Not a picture of bytes, or one without pixels.
    """
    if not isinstance(image, np.ndarray):
        raise ValueError(
            f"image_bgr: expected an array as cv2.imread returns it, got {type(image).__name__}"
            + ("; does the file exist?" if image is None else "")
        )
    if image.dtype != np.uint8:
        more = " (divide by 257 and make it uint8)" if image.dtype == np.uint16 else ""
        raise ValueError(f"image_bgr: expected bytes (uint8), got {image.dtype}{more}")
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    if image.ndim != 3 or image.shape[2] not in (3, 4) or image.size == 0:
        raise ValueError(
            f"image_bgr: expected shape (height, width, 3), no side of 0, got {image.shape}"
        )
    return np.ascontiguousarray(image[..., :3])
