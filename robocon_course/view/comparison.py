"""The picture of a wrong answer: what came beside what was expected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robocon_course._arrays import FloatArray
from robocon_course.view.canvas import MINE, REFERENCE, figure, styled

MOST_BARS = 12
MOST_NOTES = 4
MOST_PANELS = 4


@styled()
def plot_counter_example(what: str, got: Any, expected: Any, unit: str = "") -> Figure:
    """What came beside what was expected: bars for a few numbers, lines for a series.

    Parameters
    ----------
    what : str
        The case, as a title.
    got, expected : numbers, arrays (n,) or (n, k), or dictionaries of them
        Shapes may differ; entries that are not finite leave a gap.
    unit : str

    Returns
    -------
    Figure

    Raises
    ------
    ValueError
        Nothing in it can be drawn as numbers.
    """
    pairs = list(_pairs(got, expected))[:MOST_PANELS]
    if not pairs:
        raise ValueError("got, expected: nothing in them can be drawn as numbers")
    fig, panels = figure(7.5, 1.0 + 1.6 * len(pairs), rows=len(pairs), squeeze=False)
    for ax, (name, one, other) in zip(panels[:, 0], pairs, strict=True):
        draw = _draw_bars if other.size <= MOST_BARS and one.size <= MOST_BARS else _draw_series
        draw(ax, one, other)
        ax.set_ylabel(name or (f"[{unit}]" if unit else ""))
    panels[0, 0].set_title(what, wrap=True)
    panels[0, 0].legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return fig


def _pairs(got: Any, expected: Any, name: str = "") -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """(name, came, expected) for everything that one panel can hold."""
    if isinstance(expected, Mapping):
        for key, value in expected.items():
            yield from _pairs(got.get(key) if isinstance(got, Mapping) else None, value, str(key))
        return
    one, other = _numbers(got), _numbers(expected)
    if one.ndim == other.ndim == 2 and other.size > MOST_BARS:
        for k in range(min(one.shape[1], other.shape[1])):
            yield f"{name} [:, {k}]".strip(), one[:, k], other[:, k]
    elif one.size and other.size:
        yield name, one.ravel(), other.ravel()


def _numbers(value: Any) -> FloatArray:
    """An answer as floats, empty where it is none; it may be anything at all."""
    try:
        numbers = np.asarray(value if value is not None else [], dtype=np.float64)
    except (TypeError, ValueError):
        return np.empty(0)
    return np.where(np.isfinite(numbers), numbers, np.nan)


def _draw_bars(ax: Axes, got: FloatArray, expected: FloatArray) -> None:
    """Expected as an empty box, what came as a full bar inside it: two shapes, not two colours."""
    ax.bar(np.arange(got.size), got, 0.42, color=MINE, label="came")
    ax.bar(
        np.arange(expected.size),
        expected,
        0.62,
        fill=False,
        edgecolor=REFERENCE,
        linewidth=2.0,
        label="expected",
    )
    count = max(got.size, expected.size)
    for k in range(count if count <= MOST_NOTES else 0):
        # Rounded: 6e-17 is a zero that went through a sine.
        words = [
            f"{values[k].round(12) + 0.0:.4g}" if k < values.size else "–"
            for values in (got, expected)
        ]
        ax.annotate(
            f"came {words[0]}\nexpected {words[1]}",
            (k, 0),
            (0, -6),
            ("data", "axes fraction"),
            "offset points",
            ha="center",
            va="top",
        )
    ax.axhline(0.0, color="#777777", linewidth=0.8)
    ax.set_xticks(range(count), [] if count <= MOST_NOTES else range(count))
    ax.set_xlim(-0.6, count - 0.4)
    ax.grid(axis="x", visible=False)
    ax.margins(y=0.12)


def _draw_series(ax: Axes, got: FloatArray, expected: FloatArray) -> None:
    """Expected as a broad line, what came as a thin one upon it."""
    ax.plot(expected, color=REFERENCE, linewidth=4.0, alpha=0.55, label="expected")
    ax.plot(got, color=MINE, linewidth=1.2, label="came")
    ax.margins(x=0.0)
    ax.set_xlabel("sample")
