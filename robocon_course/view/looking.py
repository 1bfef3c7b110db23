"""The figures of looking: what a network says of each place, films with boxes, balls from above."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from robocon_course._arrays import FloatArray
from robocon_course.view.canvas import MINE, RAW, TRUTH, WARN, Animation, figure, packed, styled
from robocon_course.view.raster import font
from robocon_course.view.seeing import FRAME, GLOW, PAINT, tag
from robocon_course.vision.classes import BALLS
from robocon_course.vision.detection import Detections
from robocon_course.vision.locate import Sighting

STRIDES = (8, 16, 32)
"""Pixels of the network's square that one of its places spans, in each of its three grids."""
CAPTION = 22
"""Height of the line of words under a film [pixels]."""


def film(
    images_bgr: Sequence[NDArray[np.uint8]],
    found: Sequence[Detections],
    captions: Sequence[str],
    names: Sequence[str] = BALLS,
    *,
    pause: float = 0.4,
) -> Animation:
    """Pictures one after the other, with what was found in each and a line of words below.

    Parameters
    ----------
    images_bgr : sequence of ndarray of uint8, shape (h, w, 3)
        All of one size.
    found : sequence of Detections
        One for each picture.
    captions : sequence of str
    names : sequence of str
        The detector's classes.
    pause : float  [s]
        Between two pictures.

    Returns
    -------
    Animation
        The picture in the middle of the row stands for it where nothing can move.
    """
    frames = [_frame(*parts, names) for parts in zip(images_bgr, found, captions, strict=True)]
    rows = np.vstack([np.asarray(frame)[::2, ::2] for frame in frames])
    colours = Image.fromarray(rows).quantize(256, Image.Quantize.MAXCOVERAGE, kmeans=1)
    flat = [frame.quantize(palette=colours, dither=Image.Dither.NONE) for frame in frames]
    pauses = [round(1000 * pause)] * (len(flat) - 1) + [round(1000 * pause) + 1500]
    stream = io.BytesIO()
    flat[0].save(stream, "gif", save_all=True, append_images=flat[1:], duration=pauses, loop=0)
    return Animation(stream.getvalue(), packed(frames[len(frames) // 2]))


def _frame(
    image: NDArray[np.uint8], found: Detections, caption: str, names: Sequence[str]
) -> Image.Image:
    """One picture of a film."""
    height, width = image.shape[:2]
    frame = Image.new("RGB", (width, height + CAPTION), "white")
    frame.paste(Image.fromarray(np.ascontiguousarray(image[..., ::-1])))
    pen = ImageDraw.Draw(frame)
    for box, score, k in zip(*found, strict=True):
        colour = GLOW.get(names[int(k)], FRAME)
        left, top, right, bottom = (round(float(side)) for side in box)
        pen.rectangle((left, top, max(left, right - 1), max(top, bottom - 1)), outline=colour)
        words = tag(names[int(k)], score)
        if right - left > 0.05 * width:
            at = (left, max(10, top))
            pen.rectangle(pen.textbbox(at, words, font(9), anchor="lb"), fill=colour)
            pen.text(at, words, "black", font(9), anchor="lb")
    pen.text((4, height + 4), caption, TRUTH, font(11))
    return frame


@styled()
def plot_places(tensor: NDArray[np.float32], scores: FloatArray) -> Figure:
    """How sure a network is at each of its places: three grids over the picture it looked at.

    Parameters
    ----------
    tensor : ndarray, shape (1, 3, h, w)
        What went in, as `detection.letterbox` makes it.
    scores : ndarray, shape (n,)
        The best score of each place, grid by grid, row by row.
    """
    height, width = tensor.shape[2:]
    fig, axes = figure(7.4, 2.15, len(STRIDES))
    start = 0
    for stride, ax in zip(STRIDES, axes, strict=True):
        rows, columns = height // stride, width // stride
        grid = np.asarray(scores)[start : start + rows * columns].reshape(rows, columns)
        start += rows * columns
        ax.imshow(tensor[0].transpose(1, 2, 0).mean(axis=2), cmap="gray", vmin=-0.2, vmax=1.6)
        heat = np.ma.masked_less(grid, 0.05)
        around = (0, width, height, 0)
        shown = {"cmap": "plasma", "vmin": 0, "vmax": 1, "interpolation": "nearest"}
        painted = ax.imshow(heat, extent=around, **shown)
        ax.set_title(f"{columns} × {rows} places", fontsize=9)
        ax.set_axis_off()
    fig.colorbar(painted, ax=axes, label="best score", shrink=0.8, aspect=12, ticks=[0, 0.5, 1])
    return fig


@styled()
def plot_pinhole(distance: float, focal: float, radius: float) -> Figure:
    """How a ball is projected, from the side: the lens, the plane of the picture, the ball.

    Parameters
    ----------
    distance : float  [m]
        From the lens to the ball's middle.
    focal : float  [pixels]
    radius : float  [m]
    """
    fig, ax = figure(6.0, 2.6)
    plane = 0.3  # where the picture is drawn; true to shape, not to scale
    ax.add_patch(Circle((distance, 0), radius, facecolor=PAINT["red"], alpha=0.85))
    for sign in (-1, 1):
        ax.plot([0, distance], [0, sign * radius], color=RAW, linewidth=1)
    half = plane * radius / distance
    ax.plot([plane, plane], [-0.16, 0.16], color=TRUTH, linewidth=1.5)
    ax.plot([plane, plane], [-half, half], color=MINE, linewidth=5, solid_capstyle="butt")
    ax.plot(0, 0, "o", color=TRUTH)
    pixels = 2 * radius / distance * focal
    notes = {
        "lens": (0.0, -0.07),
        f"picture: {pixels:.0f} pixels": (plane, -0.18),
        f"ball: {2 * radius:.2f} m": (distance, -radius - 0.04),
    }
    for words, at in notes.items():
        ax.text(*at, words, ha="center", va="top")
    for end, high, words in (
        (plane, 0.2, f"f = {focal:.0f} pixels"),
        (distance, 0.32, f"z = {distance:.2f} m"),
    ):
        arrow = {"arrowstyle": "<->", "color": TRUTH, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", (end, high), (0, high), arrowprops=arrow)
        ax.text(end / 2, high + 0.015, words, ha="center", va="bottom")
        ax.plot([0, 0, np.nan, end, end], [0, high, np.nan, 0, high], ":", color=RAW, lw=0.8)
    ax.set(xlim=(-0.12, distance + 0.2), ylim=(-0.26, 0.4), aspect="equal")
    ax.set_axis_off()
    return fig


@styled()
def plot_touching_looks(bearing: float, distance: float, radius: float) -> Figure:
    """From above: the looks at both edges of a ball touch it, and it lies halfway between them.

    Parameters
    ----------
    bearing : float  [rad]
        Of the ball's middle, to the right of the camera's axis.
    distance : float  [m]
    radius : float  [m]
    """
    half = float(np.arcsin(radius / distance))
    fig, ax = figure(5.2, 3.4)
    middle, deep = _ahead(distance, bearing), distance * np.cos(bearing)
    ax.add_patch(Circle(tuple(middle), radius, facecolor=PAINT["red"], alpha=0.35, linewidth=0))
    for angle in (bearing - half, bearing + half):
        ax.plot(*zip((0.0, 0.0), _ahead(1.12 * distance, angle), strict=True), color=MINE, lw=1.6)
    touch = _ahead(distance * np.cos(half), bearing + half)
    ax.plot(*zip((0.0, 0.0), middle, strict=True), "--", color=TRUTH, linewidth=1.2)
    ax.plot(*zip(middle, touch, strict=True), color=WARN, linewidth=2.0)
    ax.plot([0, 0], [0, 1.12 * distance], color=RAW, linewidth=1.0)
    ax.plot([0, middle[0]], [deep, deep], ":", color=RAW, linewidth=1.2)
    for at, turn in ((0.66, bearing - half), (0.5, bearing), (0.34, bearing + half)):
        ax.plot(*_ahead(at * distance, np.linspace(0.0, turn, 40)), color=RAW, linewidth=0.9)
    words = {
        "$a_\\mathrm{left}$": (_ahead(0.71 * distance, (bearing - half) / 2), "center"),
        "$a$": (_ahead(0.54 * distance, bearing / 3), "center"),
        "$a_\\mathrm{right}$": (_ahead(0.34 * distance, bearing + half + 0.05), "left"),
        "$\\rho$": (_ahead(0.8 * distance, bearing - 0.02), "right"),
        "$R$": ((middle + touch) / 2 + (0.0, 0.03 * distance), "left"),
        "$z$": (np.array((-0.02 * distance, 0.8 * deep)), "right"),
        "lens": (np.array((-0.03 * distance, 0.0)), "right"),
    }
    for word, (at, side) in words.items():
        ax.text(*at, f" {word} ", ha=side, va="center")
    ax.plot(0, 0, "^", color=TRUTH, markersize=9)
    ax.set_aspect("equal")
    ax.set_axis_off()
    return fig


def _ahead(far: ArrayLike, turned: ArrayLike) -> FloatArray:
    """A place seen from the lens, drawn with the camera's axis upwards and right to the right."""
    return np.array(far * np.array([np.sin(turned), np.cos(turned)]))


@styled()
def plot_sightings(
    seen: Mapping[str, Sequence[Sighting]],
    colours: Sequence[str],
    truth: ArrayLike,
) -> Figure:
    """Balls from above, and how far each way of measuring is off, with one standard deviation.

    Parameters
    ----------
    seen : mapping of name to a sighting for each ball
    colours : sequence of str
        Of the balls.
    truth : array_like, shape (n, 2)  [rad, m]
        True bearings and ranges.
    """
    truth = np.asarray(truth, float).reshape(-1, 2)
    fig, (above, error) = figure(8.4, 3.7, 2, width_ratios=(1, 1.3))
    _from_above(above, seen, colours, truth)
    styles = dict(zip(seen, "osD^", strict=False))
    for k, (name, sightings) in enumerate(seen.items()):
        for j, (one, colour) in enumerate(zip(sightings, colours, strict=True)):
            at = j + 0.22 * ((len(seen) - 1) / 2 - k)
            off = 100 * (one.range - truth[j, 1])
            error.errorbar(off, at, xerr=100 * one.range_sigma, color=PAINT[colour],
                           fmt=styles[name], markersize=5, capsize=3)  # fmt: skip
        error.plot([], [], styles[name], color=TRUTH, markersize=5, label=name)
    error.axvline(0, color=TRUTH, linewidth=1)
    labels = [f"{c}, {r:.1f} m" for c, r in zip(colours, truth[:, 1], strict=True)]
    error.set_yticks(range(len(truth)), labels)
    error.set(xlabel="error of the range [cm]", ylim=(-0.6, len(truth) - 0.1))
    error.legend(loc="upper center", ncols=len(seen), fontsize=9)
    return fig


def _from_above(
    ax: Axes, seen: Mapping[str, Sequence[Sighting]], colours: Sequence[str], truth: FloatArray
) -> None:
    """The robot looks up; true balls as circles, the last way of measuring as crosses."""
    for (bearing, far), colour in zip(truth, colours, strict=True):
        centre = (-far * np.sin(bearing), far * np.cos(bearing))
        ax.add_patch(Circle(centre, 0.095, facecolor=PAINT[colour], alpha=0.5, linewidth=0))
    *_, (name, last) = seen.items()
    for one in last:
        at = np.array([-np.sin(one.bearing), np.cos(one.bearing)])
        ends = np.outer(one.range + np.array([-2, 2]) * one.range_sigma, at)
        ax.plot(*(one.range * at), "+", color=TRUTH, markersize=7)
        ax.plot(*ends.T, color=WARN, linewidth=2)
    ax.plot([], [], "+", color=TRUTH, label=name)
    ax.plot([], [], color=WARN, linewidth=2, label="± 2 deviations")
    ax.plot(0, 0, "^", color=TRUTH, markersize=10, linestyle="", label="lens")
    half = 0.35 * truth[:, 1].max()
    ax.set(xlabel="to the right [m]", ylabel="ahead [m]", xlim=(-half, half), aspect="equal")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=9)
