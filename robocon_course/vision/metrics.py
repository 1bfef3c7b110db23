"""How good a detector is: overlap, precision and recall, average precision, confusion.

Source: average precision as in the COCO evaluation and Ultralytics 8.4: precision made falling,
read at 101 recalls from 0 to 1, integrated by the trapezoidal rule.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats

TINY = 1e-16
"""Keeps shares of nothing from dividing by zero."""


def xyxy_from_yolo(rows: ArrayLike, width: int, height: int) -> FloatArray:
    """Boxes of an annotation file, in pixels.

    Parameters
    ----------
    rows : array_like, shape (n, 5)
        As in the file: class, middle x and y, width and height, of the picture's width and height.
    width, height : int  [pixels]
        Of the picture.

    Returns
    -------
    ndarray, shape (n, 4)  [pixels]
        Left, top, right, bottom.

    Raises
    ------
    ValueError
        Not five finite numbers a row.
    """
    rows = as_floats(np.reshape(rows, (-1, 5)) if np.size(rows) == 0 else rows, "rows", None, 5)
    middle, half = rows[:, 1:3], rows[:, 3:5] / 2
    return np.hstack([middle - half, middle + half]) * (width, height, width, height)


def box_iou(a: ArrayLike, b: ArrayLike) -> FloatArray:
    """Intersection over union of each box of one list with each of another.

    Parameters
    ----------
    a : array_like, shape (n, 4)
    b : array_like, shape (m, 4)
        Left, top, right, bottom.

    Returns
    -------
    ndarray, shape (n, m)
        0 for boxes that do not touch, 1 for equal ones; 0 where both have no area.
    """
    a = np.asarray(a, float).reshape(-1, 1, 4)
    b = np.asarray(b, float).reshape(1, -1, 4)
    sides = np.minimum(a[..., 2:], b[..., 2:]) - np.maximum(a[..., :2], b[..., :2])
    common = np.prod(np.clip(sides, 0.0, None), axis=-1)
    both = np.prod(a[..., 2:] - a[..., :2], axis=-1) + np.prod(b[..., 2:] - b[..., :2], axis=-1)
    return common / np.maximum(both - common, TINY)


class Scored(NamedTuple):
    """Detections of many pictures with the verdict on each.

    Attributes
    ----------
    scores : ndarray, shape (n,)
    hits : ndarray of bool, shape (n,)
        Whether it found a true box of its class that no surer detection had found.
    class_ids : ndarray of int, shape (n,)
    truths : ndarray of int, shape (classes,)
        How many true boxes each class has.
    """

    scores: FloatArray
    hits: NDArray[np.bool_]
    class_ids: NDArray[np.int64]
    truths: NDArray[np.int64]


def match_detections(
    boxes: ArrayLike,
    class_ids: ArrayLike,
    true_boxes: ArrayLike,
    true_ids: ArrayLike,
    min_iou: float = 0.5,
) -> NDArray[np.bool_]:
    """Which detections of one picture are right: each true box is found once, by the surest.

    Parameters
    ----------
    boxes : array_like, shape (n, 4)
        The surest first, as `Detector.detect` gives them: it takes what it overlaps best of the
        true boxes of its class that none before it has taken.
    class_ids : array_like, shape (n,)
    true_boxes : array_like, shape (m, 4)
    true_ids : array_like, shape (m,)
    min_iou : float
        Overlap that counts as found.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    ids, true_ids = np.asarray(class_ids), np.asarray(true_ids)
    overlap = box_iou(boxes, true_boxes) * (ids[:, None] == true_ids[None, :])
    hits = np.zeros(len(ids), bool)
    for mine in np.flatnonzero((overlap >= min_iou).any(axis=1)):
        true = int(overlap[mine].argmax())
        if overlap[mine, true] >= min_iou:
            hits[mine] = True
            overlap[:, true] = 0.0  # taken
    return hits


def precision_recall(
    scores: ArrayLike, hits: ArrayLike, truths: int
) -> tuple[FloatArray, FloatArray]:
    """Precision and recall as the threshold falls past one detection after the other.

    Parameters
    ----------
    scores : array_like, shape (n,)
    hits : array_like of bool, shape (n,)
    truths : int
        How many true boxes there are.

    Returns
    -------
    recall : ndarray, shape (n,)
        Found of what is there; rises.
    precision : ndarray, shape (n,)
        Right of what was reported.
    """
    hits = np.asarray(hits, bool)[np.argsort(-np.asarray(scores), kind="stable")]
    right = np.cumsum(hits)
    return right / (truths + TINY), right / np.arange(1, len(hits) + 1)


def average_precision(recall: ArrayLike, precision: ArrayLike) -> float:
    """Area under the precision-recall curve.

    Parameters
    ----------
    recall, precision : array_like, shape (n,)
        As `precision_recall` returns them.

    Returns
    -------
    float
        0 to 1. The curve starts at precision 1 and drops to 0 behind its last recall; between, each
        recall has the best precision of any recall that is not smaller.
    """
    if len(recall) == 0:
        return 0.0
    recall = np.concatenate([[0.0], recall, [recall[-1], 1.0]])
    precision = np.concatenate([[1.0], precision, [0.0, 0.0]])
    falling = np.maximum.accumulate(precision[::-1])[::-1]
    at = np.linspace(0.0, 1.0, 101)
    return float(np.trapezoid(np.interp(at, recall, falling), at))


def score_pictures(pictures: Sequence[tuple], classes: int, min_iou: float = 0.5) -> Scored:
    """The verdict on the detections of many pictures.

    Parameters
    ----------
    pictures : sequence of (detections, true boxes (m, 4), true class numbers (m,))
        With or without a fourth: doubtful boxes (k, 4), see `pictures.Picture`. A detection that
        found no true box, and overlaps a doubtful one enough and better than any true one, is then
        not judged at all: the "difficult" objects of PASCAL VOC, but that no class is asked for.
    classes : int
    min_iou : float

    Returns
    -------
    Scored
    """
    scores, hits, ids = [np.empty(0)], [np.empty(0, bool)], [np.empty(0, np.int64)]
    truths = np.zeros(classes, np.int64)
    for found, true_boxes, true_ids, *doubtful in pictures:
        order = np.argsort(-found.scores, kind="stable")
        boxes, said = found.boxes[order], found.class_ids[order]
        right = match_detections(boxes, said, true_boxes, true_ids, min_iou)
        judged = np.ones(len(right), bool)
        if doubtful:
            unsure = box_iou(boxes, doubtful[0]).max(axis=1, initial=0.0)
            true = box_iou(boxes, true_boxes).max(axis=1, initial=0.0)
            judged = right | (unsure < min_iou) | (unsure <= true)
        scores.append(found.scores[order][judged])
        ids.append(said[judged])
        hits.append(right[judged])
        truths += np.bincount(true_ids, minlength=classes)
    return Scored(np.concatenate(scores), np.concatenate(hits), np.concatenate(ids), truths)


def average_precisions(scored: Scored) -> FloatArray:
    """Average precision of each class; NaN for one that the pictures do not hold.

    Parameters
    ----------
    scored : Scored

    Returns
    -------
    ndarray, shape (classes,)
        Their mean, NaN left out, is the mAP at the overlap that the verdicts were made with.
    """
    found = np.full(len(scored.truths), np.nan)
    for k, truths in enumerate(scored.truths):
        if truths > 0:
            mine = scored.class_ids == k
            curve = precision_recall(scored.scores[mine], scored.hits[mine], int(truths))
            found[k] = average_precision(*curve) if mine.any() else 0.0
    return found


def confusion_matrix(
    pictures: Sequence[tuple], classes: int, *, min_score: float = 0.25, min_iou: float = 0.45
) -> NDArray[np.int64]:
    """What was taken for what.

    Parameters
    ----------
    pictures : sequence of (detections, true boxes (m, 4), true class numbers (m,))
    classes : int
    min_score, min_iou : float
        Which detections count, and what overlap makes a pair.

    Returns
    -------
    ndarray of int, shape (classes + 1, classes + 1)
        Row: what was reported, column: what was there. The last row counts what was missed, the
        last column what was reported where there was nothing.
    """
    table = np.zeros((classes + 1, classes + 1), np.int64)
    for found, true_boxes, true_ids in pictures:
        sure = found.scores > min_score
        boxes, ids = found.boxes[sure], found.class_ids[sure]
        true_ids = np.asarray(true_ids)
        overlap = box_iou(boxes, true_boxes)
        pairs = np.argwhere(overlap > min_iou)
        order = np.argsort(-overlap[pairs[:, 0], pairs[:, 1]], kind="stable")
        mine, true = np.zeros(len(ids), bool), np.zeros(len(true_ids), bool)
        for i, j in pairs[order]:
            if not mine[i] and not true[j]:
                mine[i] = true[j] = True
                table[ids[i], true_ids[j]] += 1
        np.add.at(table, (ids[~mine], classes), 1)
        np.add.at(table, (classes, true_ids[~true]), 1)
    return table
