"""One number from each of many runs, drawn so that the median and the worst are seen."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.view.canvas import TRUTH, WARN, colours_of, figure, styled

UNITS = {"m": 1.0, "cm": 100.0, "mm": 1000.0, "deg": 180.0 / np.pi, "rad": 1.0, "s": 1.0, "%": 1e2}
"""What a number in SI units is multiplied with to stand in this unit."""


@styled()
def plot_distribution(
    values: Mapping[str, ArrayLike],
    what: str = "Position error",
    unit: str = "mm",
    *,
    limit: float | None = None,
) -> Figure:
    """One number from each of many runs: every run a dot, with quartiles, median and worst.

    Parameters
    ----------
    values : mapping of label to array_like, shape (n,)  [SI]
        Not negative: the largest is the worst. NaN (a run without a result) is left out.
    what : str
        The title's beginning.
    unit : str
        One of `UNITS`; the values are converted to it.
    limit : float, optional  [SI]
        Where a demand or a published number lies.

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        An unknown unit, or a label without any value.
    """
    if unit not in UNITS:
        raise ValueError(f"unit: expected one of {', '.join(UNITS)}, got {unit!r}")
    colours = colours_of(values)
    fig, ax = figure(7.5, 1.0 + 0.75 * len(values))
    for row, (label, numbers) in enumerate(values.items()):
        numbers = UNITS[unit] * as_floats(numbers, label, None, finite=False)
        numbers = numbers[np.isfinite(numbers)]
        if not numbers.size:
            raise ValueError(f"{label}: expected at least one finite number, got none")
        _draw_strip(ax, -row, numbers, colours[label], unit)
    if limit is not None:
        ax.axvline(limit * UNITS[unit], color=TRUTH, linestyle=":", linewidth=1.6)
        ax.annotate(
            "limit", (limit * UNITS[unit], 0), (3, 3), ("data", "axes fraction"), "offset points"
        )
    ax.set_yticks(-np.arange(len(values)), values, fontweight="bold")
    for tick, label in zip(ax.get_yticklabels(), values, strict=True):
        tick.set_color(colours[label])
    ax.grid(axis="y", visible=False)
    ax.set_title(f"{what} [{unit}]")
    ax.set_xlim(left=0.0)
    ax.set_ylim(-len(values) + 0.45, 0.55)
    return fig


def _draw_strip(ax: Axes, row: float, numbers: FloatArray, colour: str, unit: str) -> None:
    """Dots, a box over the middle half, a stroke at the median, a ring at the worst."""
    low, median, high = np.percentile(numbers, (25, 50, 75))
    worst = numbers.max()
    golden = 0.618033988749895  # multiples of it spread evenly without randomness
    aside = 0.44 * (np.arange(numbers.size) * golden % 1.0 - 0.5)
    ax.barh(row, high - low, 0.56, low, color=colour, alpha=0.18, zorder=1)
    dot = {"markersize": 3.5, "alpha": 0.65, "markeredgewidth": 0.0}
    ax.plot(numbers, row + aside, "o", color=colour, zorder=2, **dot)
    ax.plot((median, median), (row - 0.28, row + 0.28), color=colour, linewidth=3.0, zorder=3)
    ring = {"markersize": 9, "markerfacecolor": "none", "markeredgewidth": 1.6, "zorder": 3}
    ax.plot(worst, row + aside[numbers.argmax()], "o", color=WARN, **ring)
    words = f"median {median:.3g} {unit}\nworst {worst:.3g} {unit}\n{numbers.size} runs"
    place = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    ax.annotate(words, (1.0, row), (6, 0), va="center", fontsize=9, **place)
