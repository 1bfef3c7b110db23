"""Maps with ways on them, and the cells that a search went through, in the order of time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray
from PIL import Image, ImageDraw

from robocon_course._arrays import FloatArray
from robocon_course.gridmap import GridMap
from robocon_course.planning import Plan
from robocon_course.view.animation import LARGEST_GIF, backdrop_of, labelled, looped_gif
from robocon_course.view.canvas import REFERENCE, Animation, figure, png, styled
from robocon_course.view.field_picture import (
    OUR_HALF,
    Window,
    draw_field,
    draw_rings,
    draw_tracks,
    track,
)
from robocon_course.view.raster import Scale, rgb

WAVE = ("#E3EEF9", "#C6DBEF", "#9ECAE1", "#6BAED6", "#4292C6", "#2171B5", "#08519C", "#08306B")
"""From the first cells of a search to its last."""
BLOCKED, LOST = (70, 70, 70, 205), (70, 70, 70, 75)
"""Cells that are not free, and free ones too near to them: red, green, blue, opacity of 255."""
PLAYS = 5.0  # s
STAYS = 8  # pictures at the end, with the way
LONGEST_SIDE = 5.6  # inch, of a map that is not the field


@styled()
def draw_ways(
    grid: GridMap,
    paths: Mapping[str, ArrayLike] | None = None,
    *,
    room: GridMap | None = None,
    plan: Plan | None = None,
    markers: Mapping[str, ArrayLike] | None = None,
    window: Window | None = OUR_HALF,
    ax: Axes | None = None,
) -> Figure:
    """A map's obstacles with ways between them, on the game field or on white.

    Parameters
    ----------
    grid : GridMap
        Cells that are not free are dark.
    paths : mapping of label to array_like, shape (n, 2)  [m, map]
        Colours as in `draw_field`.
    room : GridMap, optional
        What of the map is room for the robot's middle; the rest of the free cells is grey.
    plan : Plan, optional
        With its ``order``: the cells it went on from, from pale (first) to dark (last).
    markers : mapping of label to array_like, shape (2,) or (k, 2)  [m, map]
    window : (x0, x1, y0, y1), optional  [m, map]
        Part of the field that is shown; None draws the whole map, without the field below it.
    ax : Axes, optional
        A panel to draw into; without it a figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        A plan that does not know its order, or paths of another shape.
    """
    if plan is not None and plan.order is None:
        raise ValueError("plan: it does not know its order; plan with astar(..., watch=True)")
    if window is not None:
        fig = draw_field(paths, markers=markers, window=window, ax=ax)
        ax = ax or fig.axes[0]
    else:
        ax = _white(grid, paths or {}, markers or {}, ax)
    limits = {"xlim": ax.get_xlim(), "ylim": ax.get_ylim()}
    style = {"origin": "lower", "interpolation": "nearest", "zorder": 1.5}
    ax.imshow(_layer(grid, room, plan), extent=grid.extent, **style)
    ax.set(**limits)
    return ax.figure


def _white(
    grid: GridMap,
    paths: Mapping[str, ArrayLike],
    markers: Mapping[str, ArrayLike],
    ax: Axes | None,
) -> Axes:
    """Axes that show a whole map on white, with what lies on it."""
    x0, x1, y0, y1 = grid.extent
    if ax is None:
        scale = LONGEST_SIDE / max(x1 - x0, y1 - y0)
        ax = figure(scale * (x1 - x0) + 0.8, scale * (y1 - y0) + 0.9)[1]
    ax.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    draw_tracks(ax, {label: track(path, label) for label, path in paths.items()})
    for label, at in markers.items():
        draw_rings(ax, label, track(np.atleast_2d(at), label))
    return ax


def _layer(grid: GridMap, room: GridMap | None, plan: Plan | None) -> NDArray[np.uint8]:
    """Obstacles, cells without room, and a search's cells, shape (rows, cols, 4), RGBA."""
    layer = np.zeros((*grid.shape, 4), np.uint8)
    if room is not None:
        layer[~room.free] = LOST
    if plan is not None:
        seen = plan.order > 0
        layer[seen] = _wave(plan.order[seen], int(plan.order.max()))
    layer[~grid.free] = BLOCKED
    return layer


def _wave(order: NDArray[np.int32], last: int) -> NDArray[np.uint8]:
    """Colour of cells by when a search went on from them, shape (n, 4), RGBA."""
    colours = np.array([(*rgb(colour), 215) for colour in WAVE], np.uint8)
    return colours[(order.astype(np.int64) - 1) * len(WAVE) // max(last, 1)]


def animate_search(
    grid: GridMap,
    plan: Plan,
    *,
    room: GridMap | None = None,
    markers: Mapping[str, ArrayLike] | None = None,
    window: Window | None = OUR_HALF,
    frames: int = 45,
) -> Animation:
    """The search spreading over the map, and the way it finds at last, for `show`.

    Parameters
    ----------
    grid, plan, room, markers, window
        As in `draw_ways`.
    frames : int
        Pictures at most; fewer where the file would become too large.

    Returns
    -------
    Animation

    Raises
    ------
    ValueError
        As `draw_ways`, or a file that stays too large.
    """
    place = {"room": room, "markers": markers, "window": window}
    still = png(draw_ways(grid, {"reference": plan.xy}, plan=plan, **place))
    backdrop, scale, inside = backdrop_of(draw_ways(grid, **place))
    order = _order_at(grid, plan, scale, inside)
    last = int(plan.order.max())
    for count in (frames, frames * 2 // 3, frames // 2, frames // 4):
        images = []
        for now in np.linspace(0, last, max(count, 2)).astype(int):
            picture, field = backdrop.copy(), backdrop[inside].copy()
            seen = (order > 0) & (order <= now)
            colour = _wave(order[seen], last).astype(np.float64)
            opacity = colour[:, 3:] / 255.0
            field[seen] = field[seen] * (1.0 - opacity) + colour[:, :3] * opacity
            picture[inside] = field
            images.append(labelled(picture, inside, f"{now} cells"))
        images += [_with_way(images[-1], scale.pixels(plan.xy))] * STAYS
        gif = looped_gif(images, np.array([0.0, PLAYS]))
        if len(gif) <= LARGEST_GIF:
            return Animation(gif, still)
    raise ValueError(f"animate_search: {len(gif)} bytes even with {count} frames")


def _order_at(
    grid: GridMap, plan: Plan, scale: Scale, inside: tuple[slice, slice]
) -> NDArray[np.int32]:
    """When the search came to each pixel's cell; 0 where it never did."""
    rows, cols = (np.arange(part.start, part.stop) + 0.5 for part in inside)
    x = (cols - scale.left) / scale.per_metre
    y = (scale.bottom - rows) / scale.per_metre
    row = grid.cells(np.column_stack([np.zeros_like(y), y]))[:, 0]
    col = grid.cells(np.column_stack([x, np.zeros_like(x)]))[:, 1]
    order = np.pad(plan.order, 1)
    (high, wide) = grid.shape
    return order[(row + 1).clip(0, high + 1)[:, None], (col + 1).clip(0, wide + 1)]


def _with_way(image: Image.Image, points: FloatArray) -> Image.Image:
    """A picture with the way on it, white around."""
    image = image.copy()
    line = [tuple(point) for point in points.tolist()]
    for colour, width in (("white", 7), (REFERENCE, 4)):
        ImageDraw.Draw(image).line(line, fill=colour, width=width, joint="curve")
    return image
