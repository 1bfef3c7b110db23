"""The figures of vision: pictures with boxes, how good a detector is, where balls are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray
from robocon_course.view.canvas import MINE, REFERENCE, TRUTH, WARN, figure, styled
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.detection import Detections
from robocon_course.vision.sheet import COLOURS, OTHER

PAINT = {"blue": "#2D6CDF", "purple": "#A64FB0", "red": "#E0334A"}
"""Colours of balls on white paper."""
GLOW = {name: "#{2:02X}{1:02X}{0:02X}".format(*bgr) for name, bgr in COLOURS.items()}
FRAME = "#{2:02X}{1:02X}{0:02X}".format(*OTHER)
"""The same on a picture, and the frame of silos: as the contact sheet has them."""
STROKES = ("-", "--", ":")
"""Of lines side by side: red and purple, orange and green are one colour to many eyes."""


@styled()
def draw_picture(
    image_bgr: NDArray[np.uint8],
    found: Detections | None = None,
    names: Sequence[str] = BALLS,
    *,
    title: str = "",
    width: float = 6.0,
) -> Figure:
    """One picture, large, with what was found in it.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    found : Detections, optional
    names : sequence of str
        The detector's classes.
    title : str
    width : float  [inch]
    """
    height, across = image_bgr.shape[:2]
    fig, ax = figure(width, width * height / across + (0.3 if title else 0.0))
    _picture(ax, image_bgr, found, names, title)
    _untangle(fig)
    return fig


@styled()
def gallery(
    images: Sequence[NDArray[np.uint8]],
    found: Sequence[Detections | None] | None = None,
    names: Sequence[str] = BALLS,
    *,
    titles: Sequence[str] = (),
    across: int = 3,
    side: float = 2.3,
) -> Figure:
    """Several pictures side by side, each with what was found in it.

    Parameters
    ----------
    images : sequence of ndarray of uint8, shape (h, w, 3)
    found : sequence of Detections or None, optional
        One for each picture.
    names : sequence of str
    titles : sequence of str
    across : int
    side : float  [inch]
        Width of a picture.
    """
    down = -(-len(images) // across)
    shape = max(image.shape[0] / image.shape[1] for image in images)
    each = (side - 0.1) * shape + (0.32 if titles else 0.1)
    fig, axes = figure(across * side, down * each, across, down, squeeze=False)
    for k, ax in enumerate(axes.ravel()):
        if k < len(images):
            seen = found[k] if found is not None else None
            _picture(ax, images[k], seen, names, titles[k] if k < len(titles) else "")
        else:
            ax.set_axis_off()
    _untangle(fig)
    return fig


def _picture(
    ax: Axes, image: NDArray[np.uint8], found: Detections | None, names: Sequence[str], title: str
) -> None:
    ax.imshow(image[..., ::-1], interpolation="antialiased")
    ax.set_axis_off()
    if title:
        ax.set_title(title, fontsize=9)
    for box, score, k in zip(*found, strict=True) if found is not None else ():
        name = names[int(k)]
        colour = GLOW.get(name, FRAME)
        corner, size = box[:2], box[2:] - box[:2]
        ax.add_patch(Rectangle(corner, *size, fill=False, edgecolor=colour, linewidth=1.2))
        if size[0] > 0.06 * image.shape[1] and np.isfinite(score):
            place = {"va": "bottom"} if box[1] > 14 else {"va": "top"}
            ax.text(*corner, tag(name, score), color="black", fontsize=6.5, clip_on=True, **place,
                    bbox={"facecolor": colour, "edgecolor": "none", "pad": 0.6})  # fmt: skip


def tag(name: str, score: float) -> str:
    """What stands at a box: a ball's first letter, as on a contact sheet, or a silo's filling."""
    return f"{name[0] if name in GLOW else name} {score:.2f}"


def _untangle(fig: Figure) -> None:
    """Leave out each tag that would cover one before it; detections come surest first."""
    fig.draw_without_rendering()
    for ax in fig.axes:
        kept: list[Any] = []
        for words in ax.texts:
            spot = words.get_window_extent()
            if any(spot.overlaps(other) for other in kept):
                words.set_visible(False)
            else:
                kept.append(spot)


def as_truth(boxes: ArrayLike, class_ids: ArrayLike) -> Detections:
    """True boxes in the form of detections, for drawing: without scores."""
    boxes = np.asarray(boxes, np.float32).reshape(-1, 4)
    return Detections(boxes, np.full(len(boxes), np.nan, np.float32), np.asarray(class_ids))


@styled()
def plot_iou(a: ArrayLike, b: ArrayLike, iou: float) -> Figure:
    """Two boxes, their common part and their union.

    Parameters
    ----------
    a, b : array_like, shape (4,)
    iou : float
    """
    a, b = np.asarray(a, float), np.asarray(b, float)
    fig, ax = figure(4.2, 2.9)
    for name, box, colour in (("A", a, MINE), ("B", b, REFERENCE)):
        size = box[2:] - box[:2]
        corner, side = (box[:2], "right") if name == "A" else (box[[2, 1]], "left")
        ax.text(*corner, f" {name} ", color=colour, fontweight="bold", ha=side, va="top")
        ax.add_patch(Rectangle(box[:2], *size, facecolor=colour, alpha=0.25, linewidth=0))
        ax.add_patch(Rectangle(box[:2], *size, fill=False, edgecolor=colour, linewidth=2))
    low, high = np.maximum(a[:2], b[:2]), np.minimum(a[2:], b[2:])
    if (high > low).all():
        ax.add_patch(Rectangle(low, *(high - low), fill=False, hatch="////", edgecolor=TRUTH))
        ax.text(*((low + high) / 2), "common", ha="center", va="center",
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.5})  # fmt: skip
    ax.set(xlim=(0, 100), ylim=(70, 0), aspect="equal", xlabel="x [pixels]", ylabel="y [pixels]")
    ax.set_title(f"IoU = {iou:.2f}")
    return fig


@styled()
def plot_precision_recall(curves: Mapping[str, tuple[FloatArray, FloatArray]]) -> Figure:
    """Precision over recall, one curve a class.

    Parameters
    ----------
    curves : mapping of name to (recall, precision)
    """
    fig, ax = figure(5.0, 3.4)
    for (name, (recall, precision)), stroke in zip(curves.items(), cycle(STROKES), strict=False):
        ax.plot(recall, precision, stroke, color=PAINT.get(name), label=name, linewidth=2.0)
    ax.set(xlabel="recall: found of what is there", ylabel="precision: right of what is said")
    ax.set(xlim=(0, 1.02), ylim=(0, 1.04))
    ax.legend(loc="lower left")
    return fig


@styled()
def plot_confusion(table: ArrayLike, names: Sequence[str]) -> Figure:
    """A confusion matrix: rows what was reported, columns what was there.

    Parameters
    ----------
    table : array_like of int, shape (n + 1, n + 1)
    names : sequence of str, length n
        The last row and column are the background.
    """
    table = np.asarray(table)
    labels = [*names, "nothing"]
    small = len(labels) > 8
    fig, ax = figure(6.4 if small else 4.4, 5.6 if small else 3.6)
    share = table / np.maximum(1, table.sum(axis=0))
    ax.imshow(share, cmap="Blues", vmin=0, vmax=1)
    for (i, j), count in np.ndenumerate(table):
        if count:
            dark = "white" if share[i, j] > 0.55 else TRUTH
            ax.text(j, i, str(count), ha="center", va="center", color=dark,
                    fontsize=7 if small else 10)  # fmt: skip
    ticks = range(len(labels))
    ax.set_xticks(ticks, labels, rotation=60 if small else 0, fontsize=8 if small else 10)
    ax.set_yticks(ticks, labels, fontsize=8 if small else 10)
    ax.set(xlabel="was there", ylabel="was reported")
    ax.grid(False)
    return fig


@styled()
def plot_training(runs: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Learning curves: loss on the training pictures, mAP on pictures not trained on.

    Parameters
    ----------
    runs : mapping of name to history
        As `training.history` gives it: ``epoch``, ``box``, ``class``, ``dfl``, ``map50``.
    """
    fig, (loss, score) = figure(8.0, 3.1, 2)
    for (name, run), stroke in zip(runs.items(), cycle(STROKES), strict=False):
        total = run["box"] + run["class"] + run["dfl"]
        loss.plot(run["epoch"], total, stroke, label=name, marker="o" if len(total) < 4 else "")
        known = np.isfinite(run["map50"])
        score.plot(run["epoch"][known], run["map50"][known], stroke, label=name, marker=".")
    loss.set(xlabel="epoch", title="loss on training pictures", ylim=(0, None))
    score.set(xlabel="epoch", title="mAP at 0.5 on validation pictures", ylim=(0, 1.02))
    for ax in (loss, score):
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    if len(runs) > 1:
        score.legend(loc="upper left")
    return fig


@styled()
def plot_losses(runs: Mapping[str, Mapping[str, FloatArray]]) -> Figure:
    """Loss on the training and on the validation pictures: they part where it learns by heart.

    Parameters
    ----------
    runs : mapping of name to history
        As `training.history` gives it; one panel each, to the same scale.
    """
    fig, axes = figure(8.0, 3.1, len(runs), sharey=True, squeeze=False)
    for ax, (name, run) in zip(axes[0], runs.items(), strict=True):
        seen, unseen = (sum(run[of + p] for p in ("box", "class", "dfl")) for of in ("", "val_"))
        known = np.isfinite(unseen)
        ax.plot(run["epoch"], seen, color=MINE, label="training")
        ax.plot(run["epoch"][known], unseen[known], "--", color=WARN, label="validation")
        words = f"at the end: {seen[-1]:.1f} and {unseen[known][-1]:.1f}"
        ax.text(0.98, 0.06, words, ha="right", transform=ax.transAxes)
        ax.set(xlabel="epoch", ylim=(0, None), title=name)
        ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0, 0].set_ylabel("loss")
    axes[0, -1].legend()
    return fig


@styled()
def plot_growth(
    shown: ArrayLike, missing: ArrayLike, wanted: float, slope: float, at_one: float
) -> Figure:
    """What a network lacks, over the pictures shown to it, and where a power of them would lead.

    Parameters
    ----------
    shown : array_like, shape (n,)
        Pictures shown in training until then.
    missing : array_like, shape (n,)
        What the mAP lacks to the most there can be.
    wanted : float
        The same of the figure that is aimed at.
    slope, at_one : float
        ``missing = exp(at_one) * shown ** slope``.
    """
    fig, ax = figure(6.0, 3.1)
    enough = np.exp((np.log(wanted) - at_one) / slope)
    along = np.geomspace(min(shown), max(enough, max(shown)), 50)
    ax.loglog(along, np.exp(at_one) * along**slope, ":", color=REFERENCE, label="as a power")
    ax.loglog(shown, missing, "o", color=MINE, label="measured")
    ax.axhline(wanted, color=WARN, linestyle="--", label="published")
    ax.set(xlabel="pictures shown in training", ylabel="what the mAP lacks")
    ax.legend()
    return fig


@styled()
def plot_thresholds(
    thresholds: FloatArray, curves: Mapping[str, FloatArray], best: float | None = None
) -> Figure:
    """Precision, recall and F1 over the threshold.

    Parameters
    ----------
    thresholds : ndarray, shape (n,)
    curves : mapping of name to ndarray, shape (n,)
    best : float, optional
        A threshold to mark.
    """
    fig, ax = figure(6.0, 3.1)
    for name, values in curves.items():
        ax.plot(thresholds, values, label=name, linewidth=1.8)
    if best is not None:
        ax.axvline(best, color=TRUTH, linewidth=1, linestyle="--")
    ax.set(xlabel="threshold on the score", ylim=(0, 1.04), xlim=(0, 1))
    ax.legend(loc="lower left")
    return fig


def silo_order(found: Detections) -> str:
    """Fillings from left to right, in words."""
    order = np.argsort(found.boxes[:, 0] + found.boxes[:, 2])
    return ", ".join(SILOS[int(found.class_ids[k])] for k in order) or "none"


def count_words(class_ids: Any, names: Sequence[str] = BALLS) -> str:
    """How many of each class, in words: "2 blue, 1 red"."""
    counts = np.bincount(np.asarray(class_ids, int), minlength=len(names))
    return ", ".join(f"{n} {names[k]}" for k, n in enumerate(counts) if n) or "nothing"
