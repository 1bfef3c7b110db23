"""The robot driving on its field, as a GIF: it moves in every viewer, and no program runs."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from PIL import Image, ImageDraw

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.view.body import RobotPicture, robot_shapes
from robocon_course.view.canvas import TRUTH, Animation, colours_of, png
from robocon_course.view.field_picture import Window, draw_field
from robocon_course.view.raster import Pixels, Scale, font, paint

LARGEST_GIF = 1_000_000
"""A notebook carries the file inside; larger ones make it slow to open [byte]."""
LONGEST = 8.0
"""How long an animation plays [s]; what took longer is shown faster."""
REST = 1.2
"""How long the last picture stays before the animation begins anew [s]."""
COLOURS = 96
ALIKE = 10
"""Colours that differ by less in each of red, green and blue look the same."""
STILL_ROBOTS = 5


def animate(
    time: ArrayLike,
    poses: Mapping[str, ArrayLike],
    *,
    angles: ArrayLike | None = None,
    speeds: ArrayLike | None = None,
    beams: ArrayLike | None = None,
    markers: Mapping[str, ArrayLike] | None = None,
    window: Window | None = None,
    frames: int = 60,
) -> Animation:
    """Robots driving along their paths, for `show`.

    The paths are there from the first picture on. Where nothing can move, a still picture shows
    the first robot at several moments.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
        Increasing. Up to 8 s play as fast as they were, longer ones are shown faster.
    poses : mapping of label to array_like, shape (n, 3)  [m, m, rad; map]
        A robot per label, its colour as in `draw_field`.
    angles, speeds : array_like, shape (n, 4), optional  [rad, base; m/s]
        Modules of the first robot.
    beams : array_like, shape (n, k), optional  [m]
        What the first robot's LiDARs measured.
    markers : mapping of label to array_like, shape (2,) or (k, 2), optional  [m, map]
        As in `draw_field`.
    window : (x0, x1, y0, y1), optional  [m, map]
        As in `draw_field`.
    frames : int
        Pictures at most; fewer where the file would become too large.

    Returns
    -------
    Animation

    Raises
    ------
    ValueError
        Times that do not increase, series of another length, or a path that cannot be drawn.
    """
    time = as_floats(time, "time", None)
    if time.size < 2 or not (np.diff(time) > 0.0).all():
        raise ValueError("time: expected at least two increasing times")
    tracks = {label: as_floats(path, label, time.size, 3) for label, path in poses.items()}
    extras = [
        None if values is None else as_floats(values, name, time.size, None)
        for name, values in (("angles", angles), ("speeds", speeds), ("beams", beams))
    ]
    colours = colours_of(tracks)

    def robots_at(k: int) -> Iterator[RobotPicture]:
        """The robots at sample k, the first on top."""
        for place, (label, path) in reversed(list(enumerate(tracks.items()))):
            parts = [None if place or extra is None else extra[k] for extra in extras]
            yield RobotPicture(path[k], *parts, colour=colours[label])

    label, first = next(iter(tracks.items()))
    few = np.linspace(0, time.size - 1, STILL_ROBOTS).astype(int)
    some = [RobotPicture(first[k], colour=colours[label]) for k in few]
    place = {"markers": markers, "window": window}
    still = png(draw_field(tracks, some, **place))
    backdrop, scale, inside = backdrop_of(draw_field(tracks, **place))
    for count in (frames, frames * 2 // 3, frames // 2, frames // 4):
        chosen = np.searchsorted(time, np.linspace(time[0], time[-1], max(count, 2)))
        scenes = ((time[k], robots_at(k)) for k in chosen.clip(0, time.size - 1))
        gif = looped_gif([_frame(backdrop, scale, inside, *scene) for scene in scenes], time)
        if len(gif) <= LARGEST_GIF:
            return Animation(gif, still)
    raise ValueError(
        f"animate: {len(gif)} bytes even with {count} frames; choose a smaller window or fewer"
    )


def backdrop_of(fig: Figure) -> tuple[Pixels, Scale, tuple[slice, slice]]:
    """A figure as pixels, where the map lies in it, and the part that is field."""
    canvas = FigureCanvasAgg(fig)
    canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
    ax, height = fig.axes[0], picture.shape[0]
    (left, bottom), (right, _) = ax.transData.transform([(0.0, 0.0), (1.0, 0.0)])
    box = ax.get_window_extent()
    rows = slice(max(0, round(height - box.y1)), round(height - box.y0))
    inside = rows, slice(max(0, round(box.x0)), round(box.x1))
    return picture, Scale(right - left, left, height - bottom), inside


def _frame(
    backdrop: Pixels,
    scale: Scale,
    inside: tuple[slice, slice],
    now: float,
    robots: Iterator[RobotPicture],
) -> Image.Image:
    picture = backdrop.copy()
    field = picture[inside].copy()
    moved = scale.moved(inside[1].start, inside[0].start)
    for robot in robots:
        paint(field, robot_shapes(robot), moved)
    picture[inside] = field
    return labelled(picture, inside, f"{now:.1f} s")


def labelled(picture: Pixels, inside: tuple[slice, slice], words: str) -> Image.Image:
    """A picture of a film, with a few words above the right corner of the field."""
    image = Image.fromarray(picture)
    corner = (inside[1].stop - 2, inside[0].start - 6)
    ImageDraw.Draw(image).text(corner, words, anchor="rd", fill=TRUTH, font=font(14))
    return image


def looped_gif(images: list[Image.Image], time: FloatArray) -> bytes:
    """A GIF that repeats for ever, with one table of colours for all its pictures."""
    table = colour_table(images[:: max(1, len(images) // 8)])
    pace = 1000.0 * min(LONGEST, time[-1] - time[0]) / (len(images) - 1)
    each = max(2, round(pace / 10))
    return as_gif([flattened(image, table) for image in images], each)


def flattened(image: Image.Image, table: Image.Image) -> Image.Image:
    """A picture in the colours of a table: a third of the memory."""
    return image.quantize(palette=table, dither=Image.Dither.NONE)


def as_gif(flat: list[Image.Image], each: int, rest: float = REST) -> bytes:
    """Pictures of one table of colours as a GIF that repeats for ever.

    Parameters
    ----------
    flat : list of Image
    each : int  [0.01 s]
        How long each is shown: a GIF counts hundredths of a second.
    rest : float  [s]
        How much longer the last one stays.

    Returns
    -------
    bytes
    """
    pauses = [10 * each] * (len(flat) - 1) + [10 * each + int(1000 * rest)]
    stream = io.BytesIO()
    flat[0].save(
        stream, "gif", save_all=True, append_images=flat[1:], duration=pauses, loop=0, disposal=1
    )
    return stream.getvalue()


def colour_table(images: list[Image.Image]) -> Image.Image:
    """The most frequent colours as they are: surfaces stay exact, only smooth edges are rounded."""
    pixels = np.vstack([np.asarray(image).reshape(-1, 3) for image in images]).astype(np.int64)
    packed, counts = np.unique(pixels @ (1 << 16, 1 << 8, 1), return_counts=True)
    packed = packed[np.argsort(-counts, kind="stable")]
    left = np.column_stack([packed >> 16, packed >> 8 & 255, packed & 255])
    chosen = []
    while len(left) and len(chosen) < COLOURS:
        chosen.append(left[0])  # what looks the same is left out: Pillow could confuse the two
        left = left[np.abs(left - left[0]).max(axis=1) >= ALIKE]
    table = Image.new("P", (1, 1))
    table.putpalette(np.concatenate(chosen).tolist())
    return table
