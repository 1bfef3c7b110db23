"""The game field from above in its true colours, with paths, robots and markers on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.patheffects import Normal, Stroke
from matplotlib.ticker import MultipleLocator
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.robot import SIDE
from robocon_course.view.body import RobotPicture, Shape, robot_shapes
from robocon_course.view.canvas import TRUTH, colours_of, figure, styled

Window = tuple[float, float, float, float]
Robots = RobotPicture | ArrayLike | Iterable[RobotPicture]

RIM = field.FENCE_THICKNESS
WHOLE_FIELD: Window = (-RIM, field.SIZE + RIM, -RIM, field.SIZE + RIM)
"""Both halves with their fences; for `draw_field`'s window."""
OUR_HALF: Window = (-RIM, 6.2, -RIM, field.SIZE + RIM)
"""Our half up to the silos."""
LARGEST = (5.9, 6.6)
"""Width and height of the field's picture itself [inch], without axes and key."""
SMALLEST_WINDOW = 2.4
NARROWEST = 0.6
"""A fitted window's shorter side, by its longer one."""
PALE = 0.4


@styled()
def draw_field(
    paths: Mapping[str, ArrayLike] | None = None,
    robot: Robots | None = None,
    *,
    markers: Mapping[str, ArrayLike] | None = None,
    window: Window | None = None,
    pale: float = PALE,
    ax: Axes | None = None,
) -> Figure:
    """The game field from above with what is given drawn on it, axes in metres.

    Parameters
    ----------
    paths : mapping of label to array_like, shape (n, 2) or (n, 3)  [m, map]
        Points or poses; NaN leaves a gap. A label that begins with mine, reference, truth, raw
        or wrong gets the colour that means this in all chapters.
    robot : RobotPicture, pose, or several RobotPictures
    markers : mapping of label to array_like, shape (2,) or (n, 2)  [m, map]
        Rings with their label beside the first.
    window : (x0, x1, y0, y1), optional  [m, map]
        What is shown; without it what is drawn and a little around it, `WHOLE_FIELD` if nothing is.
    pale : float, 0 to 1
        How far the floor is mixed with white, so that what is drawn stands out.
    ax : Axes, optional
        A panel to draw into; without it a figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        A window without area, or what is drawn is not of the stated shape.
    """
    tracks = {label: track(path, label) for label, path in (paths or {}).items()}
    rings = {label: track(np.atleast_2d(at), label) for label, at in (markers or {}).items()}
    robots = _robots(robot)
    window = _window(window, [*tracks.values(), *rings.values()], robots)
    if ax is None:
        ax = figure(*_size(window, len(tracks)))[1]
    draw_ground(ax, window, pale)
    draw_tracks(ax, tracks)
    for one in robots:
        draw_shapes(ax, robot_shapes(one), zorder=5)
    for label, points in rings.items():
        draw_rings(ax, label, points)
    return ax.figure


def _robots(robot: Robots | None) -> list[RobotPicture]:
    if robot is None:
        return []
    if isinstance(robot, RobotPicture):
        return [robot]
    several = list(robot)
    if several and all(isinstance(one, RobotPicture) for one in several):
        return several
    return [RobotPicture(as_floats(robot, "robot", 3))]


def track(points: ArrayLike, label: str) -> FloatArray:
    """The x and y of points or poses; NaN may pass."""
    width = 3 if np.ndim(points) == 2 and np.shape(points)[1] == 3 else 2
    return as_floats(points, label, None, width, finite=False)[:, :2]


def _window(
    window: Window | None, drawn: Iterable[FloatArray], robots: list[RobotPicture]
) -> Window:
    """The wanted window, or a fitting one."""
    if window is not None:
        x0, x1, y0, y1 = as_floats(window, "window", 4)
        if not (x0 < x1 and y0 < y1):
            raise ValueError(f"window: expected (x0, x1, y0, y1) with x0 < x1, y0 < y1; {window}")
        return x0, x1, y0, y1
    places = [np.asarray(one.pose, float)[None, :2] for one in robots]
    known = np.vstack([*drawn, *places, np.empty((0, 2))])
    known = known[np.isfinite(known).all(axis=1)]
    if not known.size:
        return WHOLE_FIELD
    low, high = known.min(axis=0) - SIDE, known.max(axis=0) + SIDE
    size = high - low
    wanted = np.maximum(size, SMALLEST_WINDOW)
    more = (np.maximum(wanted, NARROWEST * wanted[::-1]) - size) / 2
    (x0, y0), (x1, y1) = low - more, high + more
    # A strip of empty page beside the field shows nothing.
    (x0, x1), (y0, y1) = _moved_inside(x0, x1), _moved_inside(y0, y1)
    return x0, x1, y0, y1


def _moved_inside(low: float, high: float) -> tuple[float, float]:
    first, last = WHOLE_FIELD[:2]
    shift = max(0.0, first - low) - max(0.0, high - last)
    return max(first, low + shift), min(last, high + shift)


def _size(window: Window, entries: int) -> tuple[float, float]:
    """Size of a figure whose field is as large as allowed."""
    width, height = window[1] - window[0], window[3] - window[2]
    scale = min(LARGEST[0] / width, LARGEST[1] / height)
    return scale * width + 0.75, scale * height + 0.6 + 0.25 * (entries > 0)


def draw_ground(ax: Axes, window: Window, pale: float) -> None:
    """The floor and the axes of a window, in metres."""
    picture, origin = field.picture(), WHOLE_FIELD[0]
    cells = len(picture) / (WHOLE_FIELD[1] - origin)
    low = [max(0, int((edge - origin) * cells)) for edge in window[::2]]
    high = [int((edge - origin) * cells) + 1 for edge in window[1::2]]
    part = picture[low[1] : high[1], low[0] : high[0]]  # the rest would only cost time
    if part.size:
        shown = (part * (1.0 - pale) + 255.0 * pale).astype(np.uint8)
        x, y = (origin + np.array(low) / cells).tolist()
        extent = (x, x + part.shape[1] / cells, y, y + part.shape[0] / cells)
        ax.imshow(shown, origin="lower", extent=extent, interpolation="antialiased")
    draw_shapes(ax, field_edges(), zorder=1)
    ax.set(xlim=window[:2], ylim=window[2:], aspect="equal", xlabel="x [m]", ylabel="y [m]")
    step = 0.5 if max(window[1] - window[0], window[3] - window[2]) <= 5.0 else 1.0
    for axis in (ax.xaxis, ax.yaxis):
        axis.set_major_locator(MultipleLocator(step))
    ax.grid(color="black", linewidth=0.6, alpha=0.1)  # paler than any line of the field
    ax.spines[:].set_visible(False)


@cache
def field_edges() -> tuple[Shape, ...]:
    """What has one colour on both sides: steps and the sides of ramps, and where slopes begin."""
    thin = 0.012
    boxes = [(step.x0, step.y0, step.x1, step.y1, 0.5) for step in field.LEDGES]
    for ramp in (field.RAMP_1, field.RAMP_2):
        boxes += [(ramp.x0, y - thin, ramp.x1, y + thin, 0.25) for y in (ramp.y0, ramp.y1)]
    side = field.SIDE_SLOPE
    boxes += [(x - thin, side.y0, x + thin, side.y1, 0.25) for x in (side.x0, side.x1)]
    shapes = []
    for x0, y0, x1, y1, opacity in boxes:
        corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
        mirrored = np.array([field.SIZE, 0.0]) + corners * [-1.0, 1.0]
        shapes += [Shape(corners, TRUTH, opacity), Shape(mirrored, TRUTH, opacity)]
    return tuple(shapes)


def draw_shapes(ax: Axes, shapes: Iterable[Shape], zorder: float) -> None:
    """Polygons in metres."""
    for shape in shapes:
        style = {"color": shape.colour, "alpha": shape.opacity, "linewidth": 0.0}
        ax.add_patch(Polygon(shape.corners, zorder=zorder, **style))


def draw_tracks(ax: Axes, tracks: Mapping[str, FloatArray]) -> None:
    """Paths with a pale rim, the truth broad below them, and a key above the picture."""
    colours = colours_of(tracks)
    for label, points in tracks.items():
        true = colours[label] == TRUTH
        line = {"linewidth": 5.0, "alpha": 0.45, "zorder": 2} if true else {"linewidth": 2.2}
        halo = [] if true else [Stroke(linewidth=4.4, foreground="white"), Normal()]
        style = {"color": colours[label], "path_effects": halo, "zorder": 3} | line
        ax.plot(points[:, 0], points[:, 1], label=label, solid_joinstyle="round", **style)
    if tracks:
        longest = max(len(label) for label in tracks)
        columns = max(1, int(ax.figure.get_figwidth() / (0.55 + 0.085 * longest)))
        place = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "borderaxespad": 0.2}
        ax.legend(ncols=columns, handlelength=1.4, columnspacing=1.2, **place)


def draw_rings(ax: Axes, label: str, points: FloatArray) -> None:
    """White rings, the label beside the first."""
    ring = {"markersize": 10, "markerfacecolor": "white", "markeredgewidth": 2.2, "zorder": 6}
    ax.plot(points[:, 0], points[:, 1], "o", color=TRUTH, **ring)
    halo = [Stroke(linewidth=3.0, foreground="white"), Normal()]
    words = {"va": "center", "fontweight": "bold", "path_effects": halo, "zorder": 7}
    x, y = points[0]
    ax.annotate(label, (x, y), (9, 0), "data", "offset points", **words)
