"""The way a tick takes through the robot's program, from Observation to Command."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from robocon_course.view.canvas import MINE, REFERENCE, TRUTH, figure, styled

WIDTH, HEIGHT, PITCH, LANE = 1.16, 0.56, 1.42, 1.3
QUIET = "#6B7280"
Place = tuple[float, float]


class Box(NamedTuple):
    """A step of the tick; ``chapter`` is empty where something is only handed on."""

    words: str
    chapter: str
    column: int
    lane: int


BOXES = (
    Box("Observation", "", 0, 0),
    Box("calibrate", "01", 1, 0),
    Box("attitude", "01", 2, 0),
    Box("odometry\n+ LiDAR", "02", 3, 0),
    Box("pose", "", 4, 0),
    Box("mission\nstate", "07", 0, 1),
    Box("target\n(vision)", "06", 1, 1),
    Box("path\n(A*)", "04", 2, 1),
    Box("pursuit\n+ PID", "05", 0, 2),
    Box("body twist", "", 1, 2),
    Box("swerve\nmodules", "03", 2, 2),
    Box("Command", "", 3, 2),
)
HELPERS = (Box("particle\nfilter", "08", 5, 0), Box("occupancy\ngrid", "09", 3, 1))
LANES = ("Where am I?", "Where to, and which way?", "How do I move?")
KEY = (
    ("01", "chapter that builds it", QUIET),
    ("✔", "done", REFERENCE),
    ("■", "you are here", MINE),
    ("●", "handed on to the next step", "#9AA1A9"),
    ("⇠", "helps where it points", QUIET),
)
CHAPTERS = ("00", *sorted({box.chapter for box in BOXES + HELPERS} - {""}))


@styled()
def draw_system(done: Iterable[int | str] = (), here: int | str | None = None) -> Figure:
    """The robot's program as boxes, each with the number of the chapter that builds it.

    Parameters
    ----------
    done : chapters, as 1 or "01"
        Marked with a tick. Chapter 00 comes before all boxes and marks none.
    here : chapter, optional
        Highlighted.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        A chapter that is not in the picture.
    """
    finished = {_chapter(chapter) for chapter in done}
    current = "" if here is None else _chapter(here)
    fig, ax = figure(8.2, 3.95)
    ax.set(xlim=(-0.95, 5 * PITCH + 0.65), ylim=(-3.5, 0.62), aspect="equal")
    ax.set_axis_off()
    for box in (*BOXES, *HELPERS):
        _draw_box(ax, box, box.chapter in finished, box.chapter == current != "")
    for lane, words in enumerate(LANES):
        ax.text(-WIDTH / 2, -LANE * lane + 0.4, words, style="italic", color=QUIET)
    small = {"ha": "center", "va": "center", "fontsize": 9, "color": QUIET}
    ax.text(0, -0.43, "from the sensors", **small)
    ax.text(3 * PITCH, -2 * LANE - 0.43, "to the motors", **small)
    _draw_key(ax)
    _draw_arrows(ax)
    return fig


def _chapter(chapter: int | str) -> str:
    name = f"{chapter:02d}" if isinstance(chapter, int) else str(chapter)[:2]
    if name not in CHAPTERS:
        raise ValueError(f"chapter: expected one of {', '.join(CHAPTERS)}, got {chapter!r}")
    return name


def _draw_box(ax: Axes, box: Box, done: bool, here: bool) -> None:
    """Handed-on values are round and grey, steps are angular; state shows in fill and in a sign."""
    x, y = box.column * PITCH, -LANE * box.lane
    edge, fill, ink = (QUIET, "white", TRUTH) if box.chapter else ("#C4C9CE", "#EEF1F4", TRUTH)
    if done:
        edge, fill = REFERENCE, "#E2F3EC"
    if here:
        edge, fill, ink = MINE, MINE, "white"
    shape = f"round,pad=0,rounding_size={0.08 if box.chapter else 0.3}"
    style = {"facecolor": fill, "edgecolor": edge, "linewidth": 1.5, "zorder": 3}
    ax.add_patch(FancyBboxPatch((x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, shape, **style))
    centre = {"ha": "center", "va": "center", "zorder": 4}
    shift = 0.13 if box.chapter else 0.0
    ax.text(x + shift, y, box.words, color=ink, fontsize=9.5, linespacing=1.1, **centre)
    if box.chapter:
        sign = f"{box.chapter}\n✔" if done else box.chapter
        badge = {"color": ink if here else edge, "fontweight": "bold", "fontsize": 10}
        ax.text(x - WIDTH / 2 + 0.16, y, sign, **badge, **centre)


def _draw_key(ax: Axes) -> None:
    x = 3.85 * PITCH
    for row, (sign, words, colour) in enumerate(KEY):
        y = -1.1 * LANE - 0.36 * row
        ax.text(x, y, sign, ha="center", va="center", fontweight="bold", color=colour)
        ax.text(x + 0.3, y, words, va="center", fontsize=9.5, color=QUIET)


def _draw_arrows(ax: Axes) -> None:
    """From box to box, from the end of a lane to the start of the next, and from the helpers."""
    gap = WIDTH / 2
    for one, other in pairwise(BOXES):
        x, y = one.column * PITCH, -LANE * one.lane
        if one.lane == other.lane:
            _draw_arrow(ax, (x + gap, y), (other.column * PITCH - gap, y))
            continue
        turn, left = y - 0.62, -gap - 0.27
        ax.plot(
            [x, x, left, left], [y - HEIGHT / 2, turn, turn, y - LANE], color=QUIET, linewidth=1.4
        )
        _draw_arrow(ax, (left - 0.01, y - LANE), (-gap, y - LANE))
    for box in HELPERS:
        x, y = box.column * PITCH, -LANE * box.lane
        _draw_arrow(ax, (x - gap, y), (x - PITCH + gap, y), linestyle=(0, (2, 1.5)))


def _draw_arrow(
    ax: Axes, start: tuple[float, float], end: tuple[float, float], **style: Any
) -> None:
    line = {"arrowstyle": "-|>", "color": QUIET, "linewidth": 1.4, "shrinkA": 0, "shrinkB": 1}
    ax.annotate("", end, start, arrowprops=line | style)
