"""Lines with their names at their right ends, and what keeps such names readable."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from robocon_course._arrays import FloatArray
from robocon_course.view.canvas import TRUTH

Lines = Mapping[str, tuple[FloatArray, str]]


def draw_lines(ax: Axes, x: FloatArray | None, lines: Lines, **style: Any) -> None:
    """Draw lines, with their names at their right ends instead of a key to look up.

    The truth becomes a broad pale band under all others: good estimates lie on it, not hide it.

    Parameters
    ----------
    ax : Axes
    x : ndarray, shape (n,), or None
        None counts the samples.
    lines : mapping of label to (values, colour)
    **style
        Passed on to ``Axes.plot``.
    """
    for values, colour in lines.values():
        own = style | {"linewidth": 4.5, "alpha": 0.3, "zorder": 1} if colour == TRUTH else style
        ax.plot(np.arange(values.size) if x is None else x, values, color=colour, **own)
    ax.margins(x=0.0)
    low, high = ax.get_ylim()
    ends = {}
    for label, (values, _) in lines.items():
        tail = values[-max(1, values.size // 50) :]
        known = tail[np.isfinite(tail)]
        ends[label] = (known.mean() - low) / (high - low) if known.size else 0.0
    inches = ax.get_position().height * ax.figure.get_figheight()
    places = _spread(ends, {label: (1 + label.count("\n")) * 0.17 / inches for label in ends})
    for label, place in places.items():
        ax.annotate(
            label,
            (1, place),
            (5, 0),
            "axes fraction",
            "offset points",
            color=lines[label][1],
            va="center",
            fontweight="bold",
        )


def gaps_at_jumps(degrees: FloatArray) -> FloatArray:
    """A copy with NaN where an angle jumps from 180 to -180: no line is drawn across."""
    broken = degrees.copy()
    broken[1:][np.abs(np.diff(degrees)) > 180.0] = np.nan
    return broken


def _spread(wanted: Mapping[str, float], heights: Mapping[str, float]) -> dict[str, float]:
    """Places near the wanted ones at which labels of these heights do not overlap."""
    places: dict[str, float] = {}
    floor = 0.0
    for label in sorted(wanted, key=lambda name: wanted[name]):
        places[label] = max(wanted[label], floor + heights[label] / 2)
        floor = places[label] + heights[label] / 2
    ceiling = 1.0
    for label in reversed(places):
        places[label] = min(places[label], ceiling - heights[label] / 2)
        ceiling = places[label] - heights[label] / 2
    return places
