"""A mission drawn: its states as boxes, what it did over time, the silos, the way on the field."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import ArrayLike

from robocon_course.field import BALL_DIAMETER, SILO_CAPACITY
from robocon_course.mission import Approach, SeenBall
from robocon_course.robot import SIDE
from robocon_course.view.canvas import MINE, RAW, REFERENCE, TRUTH, WARN, XYZ, figure, styled
from robocon_course.view.field_picture import draw_field
from robocon_course.view.lanes import STEP, arrows, box_at, middle

BALL = {"R": "#C62828", "B": "#1565C0"}
"""Of the balls of both teams."""
COLOURS = {"red": BALL["R"], "blue": BALL["B"], "purple": "#7B1FA2"}
KINDS = {
    "drive": (REFERENCE, ("reset", "go_to_area_3", "back_to_storage")),
    "ball": (MINE, ("detect_ball", "search_ball", "push_ball_pile", "reverse", "take_ball")),
    "silo": (XYZ[0], ("search_silo", "approach_silo", "silo_full")),
    "measure": (RAW, ("lidar_reset", "reset_odometry_from_lidar")),
    "trouble": (WARN, ("stuck", "no_sensors")),
    "end": (TRUTH, ("finished",)),
}
"""Colour of each kind of state, and which states are of it."""


def kind_of_state(state: str) -> str:
    """What kind of state this is; a state of another mission is a drive."""
    return next((kind for kind, (_, states) in KINDS.items() if state in states), "drive")


@styled()
def draw_states(
    edges: Iterable[tuple[str, str]] | Mapping[tuple[str, str], int],
    *,
    start: str,
    dead: Iterable[str] = (),
    unreached: Iterable[str] = (),
    live: str = "",
    columns: int = 4,
) -> Figure:
    """States as boxes in rows, with an arrow for each jump.

    Parameters
    ----------
    edges : iterable of (source, target), or a mapping of these to how often
        The more often, the thicker.
    start : str
        Its box has a thick rim.
    dead, unreached : iterable of str
        Boxes that are drawn orange, and grey with a broken rim.
    live : str
        A box that is filled.
    columns : int
        Boxes in a row; every second row runs from right to left.

    Returns
    -------
    Figure
    """
    counted = edges if isinstance(edges, Mapping) else dict.fromkeys(edges, 1)
    often = {(str(s), str(t)): count for (s, t), count in counted.items()}
    names = list(dict.fromkeys([str(start), *(state for edge in often for state in edge)]))
    places = {name: _place(k, columns) for k, name in enumerate(names)}
    rows = -(-len(names) // columns)
    fig, ax = figure(8.2, 0.2 + 0.88 * rows)
    dead, unreached = set(map(str, dead)), set(map(str, unreached))
    for name, place in places.items():
        colour = WARN if name in dead else RAW if name in unreached else TRUTH
        _box(ax, name, place, colour, filled=name == str(live), broken=name in unreached)
        ax.patches[-1].set_linewidth(2.8 if name == str(start) else 1.4)
    widths = [0.9 + 0.25 * min(count, 9) for count in often.values()]
    arrows(ax, [(places[s], places[t]) for s, t in often], widths)
    wide, tall = STEP
    ax.set(xlim=(-1.25, wide * (columns - 1) + 1.25), ylim=(-tall * (rows - 0.5), 0.6 * tall))
    ax.set_aspect("equal")
    ax.axis("off")
    return fig


def _place(k: int, columns: int) -> tuple[int, int]:
    row, column = divmod(k, columns)
    return (column if row % 2 == 0 else columns - 1 - column), row


def _box(
    ax: Axes, name: str, place: tuple[int, int], colour: str, *, filled: bool, broken: bool
) -> None:
    box = box_at(
        place, facecolor="#FFB000" if filled else "white", edgecolor=colour, zorder=3,
        linestyle="--" if broken else "-",
    )  # fmt: skip
    ax.add_patch(box)
    words = name.replace("_", " ")
    if len(words) > 20:  # two lines
        cut = words.rindex(" ", 0, 16)
        words = f"{words[:cut]}\n{words[cut + 1 :]}"
    style = {"ha": "center", "va": "center", "fontsize": 9, "zorder": 5, "linespacing": 0.95}
    ax.text(*middle(place), words, color=TRUTH if filled or not broken else "#666666", **style)


@styled()
def plot_histories(
    histories: Mapping[str, Sequence[tuple[float, str, str]]],
    ends: Mapping[str, float],
    *,
    marks: Mapping[str, float] | None = None,
) -> Figure:
    """What missions did over time: a bar for each state, one panel for each match.

    Parameters
    ----------
    histories : mapping of label to sequence of (time, state, reason)  [s]
    ends : mapping of label to float  [s]
        When each match ended.
    marks : mapping of word to float, optional  [s]
        Moments to mark.

    Returns
    -------
    Figure
    """
    shown = {label: _rows_of(history) for label, history in histories.items()}
    heights = [0.17 * len(rows) + 0.25 for rows in shown.values()]
    fig, axes = figure(7.4, 0.9 + sum(heights), rows=len(shown))
    for ax, (label, rows) in zip(np.atleast_1d(axes), shown.items(), strict=True):
        history = histories[label]
        until = [row[0] for row in history[1:]] + [ends[label]]
        for (time, state, _), end in zip(history, until, strict=True):
            colour = KINDS[kind_of_state(state)][0]
            ax.barh(rows.index(state), max(end - time, 0.3), 0.72, left=time, color=colour)
        for word, moment in (marks or {}).items():
            ax.axvline(moment, color=WARN, linewidth=1.2)
            ax.text(moment, -0.75, f" {word}", color=WARN, fontsize=8)
        ax.set_yticks(range(len(rows)), [row.replace("_", " ") for row in rows], fontsize=8)
        ax.set(ylim=(len(rows) - 0.4, -1.3), xlim=(0, max(ends.values())), title=label)
    ax.set_xlabel("time [s]")
    return fig


def _rows_of(history: Sequence[tuple[float, str, str]]) -> list[str]:
    """The states that occur, kind by kind."""
    met = {state for _, state, _ in history}
    known = [state for _, states in KINDS.values() for state in states]
    return [state for state in known if state in met] + sorted(met - set(known))


@styled()
def draw_silos(boards: Mapping[str, Sequence[str]]) -> Figure:
    """Rows of five silos with their balls.

    Parameters
    ----------
    boards : mapping of label to sequence of str
        What silos 1 to 5 hold, from bottom to top.

    Returns
    -------
    Figure
    """
    fig, axes = figure(1.0 + 2.15 * len(boards), 2.0, columns=len(boards))
    for ax, (label, fillings) in zip(np.atleast_1d(axes), boards.items(), strict=True):
        for k, filling in enumerate(fillings):
            ax.plot([k - 0.36, k - 0.36, k + 0.36, k + 0.36], [3.2, 0, 0, 3.2], color=RAW, lw=1.2)
            for level, letter in enumerate(filling[:SILO_CAPACITY]):
                ax.add_patch(Circle((k, level + 0.5), 0.33, color=BALL[letter]))
                ax.text(
                    k, level + 0.47, letter, color="white", ha="center", va="center", fontsize=8
                )
        ax.set(xlim=(-0.6, len(fillings) - 0.4), ylim=(-0.1, 3.4), yticks=[], title=label)
        ax.set_xticks(range(len(fillings)), [str(k + 1) for k in range(len(fillings))])
        ax.set_aspect("equal")
        ax.grid(visible=False)
        ax.spines[:].set_visible(False)
    return fig


@styled()
def draw_match(
    poses: ArrayLike, states: Sequence[str], *, until: int | None = None, robot: bool = True
) -> Figure:
    """The way of a match on the field, by the kind of state.

    Parameters
    ----------
    poses : array_like, shape (n, 3)  [m, m, rad; map]
    states : sequence of n str
    until : int, optional
        Rows up to this one.
    robot : bool
        Draw the robot at the last of them.

    Returns
    -------
    Figure
    """
    poses = np.asarray(poses, float)[:until]
    kinds = np.array([kind_of_state(str(state)) for state in states[: len(poses)]])
    window = (0.0, 6.2, 7.7, 12.2) if np.nanmin(poses[:, 1]) > 7.7 else (0.0, 6.2, 0.0, 12.2)
    fig = draw_field(robot=poses[-1] if robot else None, window=window)
    ax = fig.axes[0]
    for kind in dict.fromkeys(kinds.tolist()):
        here = kinds == kind
        here[1:] |= here[:-1]  # a line goes on to the first point of the next kind
        xy = np.where(here[:, None], poses[:, :2], np.nan)
        ax.plot(xy[:, 0], xy[:, 1], color=KINDS[kind][0], linewidth=2.0, label=kind, zorder=3)
    ax.legend(ncols=6, loc="lower left", bbox_to_anchor=(0.0, 1.0), handlelength=1.2)
    return fig


@styled()
def draw_choice(balls: Sequence[SeenBall], pose: ArrayLike, way: Approach | None) -> Figure:
    """Balls in their colours in the Storage Zone and Area 3, the robot, and the way it takes.

    Parameters
    ----------
    balls : sequence of SeenBall
    pose : array_like, shape (3,)  [m, m, rad; map]
    way : Approach or None

    Returns
    -------
    Figure
    """
    pose = np.asarray(pose, float)
    fig = draw_field(robot=pose, window=(0.0, 5.0, 8.0, 12.0))
    fig.set_size_inches(5.6, 4.5)  # four sliders stand below it on a small laptop's screen
    ax = fig.axes[0]
    for ball in balls:
        colour = COLOURS[ball.colour]
        ax.add_patch(Circle((ball.x, ball.y), BALL_DIAMETER / 2, facecolor=colour,
                            edgecolor="white", linewidth=1.2, zorder=6))  # fmt: skip
    if way is not None:
        line = np.array([pose[:2], way.ready, way.take])
        ax.plot(*line.T, color=MINE, linewidth=2.4, zorder=7)
        ax.plot(*way.ready, "o", color="white", markeredgecolor=MINE, markersize=8, zorder=8)
        ax.plot(*way.take, "o", color=MINE, markersize=8, zorder=8)
        robot_at(ax, (*way.take, way.heading))
        pad = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
        for word, at in (("ready", way.ready), ("take", way.take)):
            place = {"xytext": (0, -16), "textcoords": "offset points", "ha": "center"}
            ax.annotate(word, at, **place, color=MINE, zorder=9, bbox=pad)
    return fig


def robot_at(ax: Axes, pose: Sequence[float]) -> None:
    """The outline of the robot's body where it is going to be [m, m, rad; map]."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    square = SIDE / 2 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]])
    corners = square @ np.array([[c, s], [-s, c]]) + np.asarray(pose[:2])
    ax.plot(*corners.T, color=MINE, linewidth=1.4, linestyle="--", zorder=7)
