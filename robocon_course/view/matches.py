"""A match as a short film, as one figure, and in one line."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from robocon_course import field
from robocon_course.view._film import animate_match
from robocon_course.view._record import (
    counts_for,
    own_letter,
    points_at,
)
from robocon_course.view.canvas import RAW, TRUTH, figure, styled
from robocon_course.view.field_picture import OUR_HALF, draw_ground
from robocon_course.view.lines import draw_lines
from robocon_course.view.missions import BALL, KINDS, kind_of_state
from robocon_course.worlds.match_result import stored_in

if TYPE_CHECKING:
    from robocon_course.worlds import MatchResult

__all__ = ["animate_match", "match_twin", "plot_match"]

WORDS = {
    "drive": "drives far",
    "ball": "gets a ball",
    "silo": "brings it to a silo",
    "measure": "measures its pose",
    "trouble": "is in trouble",
    "end": "has finished",
}
"""The kinds of states, as what the robot does."""
PANELS = [["field", "doing"], ["field", "silos"], ["field", "points"]]
MARKS = {"own": "o", "theirs": "s"}
NAMES = {"R": "red", "B": "blue"}


@styled()
def plot_match(result: MatchResult) -> Figure:
    """Where the robot was and what it did there, and over time: doing, silos, points.

    Parameters
    ----------
    result : MatchResult

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        A match without a row in its record.
    """
    kinds = _kinds(result)
    fig, panels = figure(8.2, 6.0, mosaic=PANELS, width_ratios=(1, 1.45), height_ratios=(1, 1.3, 1))
    _draw_way(panels["field"], result, kinds)
    _draw_doing(panels["doing"], result, kinds)
    _draw_silos(panels["silos"], result)
    _draw_points(panels["points"], result)
    for name in ("doing", "silos", "points"):
        panels[name].set_xlim(0.0, 1.04 * result.ended)  # a ball stored at the end is seen whole
    panels["points"].set_xlabel("time [s]")
    return fig


def _kinds(result: MatchResult) -> list[str]:
    """The kind of state in each row."""
    if not len(result.time):
        raise ValueError("result: expected a match with at least one row in its record, got none")
    return [kind_of_state(state) for state in result.states]


def _draw_way(ax: Axes, result: MatchResult, kinds: list[str]) -> None:
    """The way on our half, each piece in the colour of what the robot was doing."""
    draw_ground(ax, OUR_HALF, 0.6)
    names = np.array(kinds)
    for kind in _met(kinds):
        here = names == kind
        here[1:] |= here[:-1]  # a line goes on to the first point of the next kind
        xy = np.where(here[:, None], result.poses[:, :2], np.nan)
        ax.plot(*xy.T, color=KINDS[kind][0], linewidth=1.3, zorder=3)
    ax.set_title("Way")


def _draw_doing(ax: Axes, result: MatchResult, kinds: list[str]) -> None:
    met = _met(kinds)
    changes = [k for k in range(1, len(kinds)) if kinds[k] != kinds[k - 1]]
    for first, last in zip([0, *changes], [*changes, len(kinds) - 1], strict=True):
        start, kind = result.time[first], kinds[first]
        ax.barh(met.index(kind), result.time[last] - start, 0.8, start, color=KINDS[kind][0])
    ax.set_yticks(range(len(met)), [WORDS[kind] for kind in met])
    for tick, kind in zip(ax.get_yticklabels(), met, strict=True):
        tick.set_color(KINDS[kind][0])
    ax.set(ylim=(len(met) - 0.4, -0.6), title="What the robot does")
    ax.grid(axis="y", visible=False)


def _met(kinds: list[str]) -> list[str]:
    """The kinds that occur, in the order of `KINDS`."""
    return [kind for kind in KINDS if kind in kinds]


def _draw_silos(ax: Axes, result: MatchResult) -> None:
    """Each ball stored as a mark; a ring where the silo counts from then on."""
    letter = own_letter(result)
    for k in range(len(field.SILOS)):
        ax.axhline(k + 1, color=RAW, linewidth=0.8, zorder=1)
    for event in result.events:
        if event.what == "stored":
            silo, filling = stored_in(event.detail)
            mark = {"color": BALL[filling[-1]], "marker": MARKS[event.team], "zorder": 3}
            ax.plot(event.time, silo + 1, markersize=8, **mark)
            if counts_for(filling):
                ring = {"markersize": 15, "markerfacecolor": "none", "color": TRUTH, "zorder": 2}
                ax.plot(event.time, silo + 1, "o", **ring)
    rest = "RB".replace(letter, "")
    style = {"linestyle": "", "markersize": 7}
    handles = [
        Line2D([], [], color=BALL[letter], marker="o", label="own ball", **style),
        Line2D([], [], color=BALL[rest], marker="s", label="theirs", **style),
        Line2D([], [], color=TRUTH, marker="o", markerfacecolor="none", linestyle="",
               markersize=11, label="silo counts"),
    ]  # fmt: skip
    ax.legend(handles=handles, ncols=3, loc="lower right", bbox_to_anchor=(1.0, 0.98),
              borderaxespad=0.1, columnspacing=1.0, handletextpad=0.1, fontsize=9)  # fmt: skip
    ax.set_yticks(range(1, 6))
    ax.set(ylim=(0.4, 5.6), title="Silos")
    ax.grid(axis="y", visible=False)


def _draw_points(ax: Axes, result: MatchResult) -> None:
    letter = own_letter(result)
    moments = np.array(sorted({0.0, result.ended, *(event.time for event in result.events)}))
    points = np.array([points_at(result, now) for now in moments], float)
    letters = letter, "RB".replace(letter, "")
    draw_lines(
        ax, moments,
        {f"{NAMES[one]}\n{points[-1, k]:.0f}": (points[:, k], BALL[one])
         for k, one in enumerate(letters)},
        drawstyle="steps-post",
    )  # fmt: skip
    ax.set_ylim(bottom=0.0)
    ax.set_title("Points")


def match_twin(result: MatchResult) -> str:
    """A match in one line, for the text twin of its film or figure.

    Parameters
    ----------
    result : MatchResult

    Returns
    -------
    str
        Numbers of the simulated match alone: none depends on how fast the computer is.
    """
    how = {"own": "won", "theirs": "lost", "nobody": "a draw"}[result.winner]
    own = [event.time for event in result.events if (event.what, event.team) == ("stored", "own")]
    theirs = sum((event.what, event.team) == ("stored", "theirs") for event in result.events)
    there = result.time[result.poses[:, 1] > field.AREA_3_LINE]
    arrived = f"in Area 3 after {there[0]:.0f} s, " if len(there) else "never in Area 3, "
    first = f", the first after {own[0]:.0f} s" if own else ""
    silos = ", ".join(filling or "–" for filling in result.fillings_at(result.ended))
    return (
        f"Match with seed {result.seed}, {NAMES[own_letter(result)]}: {how} by {result.reason} "
        f"after {result.ended:.0f} s, {result.points} to {result.their_points} points; {arrived}"
        f"{len(own)} balls stored{first}, {theirs} by the other team; silos 1 to 5 from bottom to "
        f"top: {silos}; {result.fouls} fouls, {result.retries} retries."
    )
