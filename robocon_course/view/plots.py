"""The plots of the chapters: arrays in SI units come in, a figure in readable units comes out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.view.canvas import (
    MINE,
    RAW,
    REFERENCE,
    TRUTH,
    WARN,
    XYZ,
    colours_of,
    figure,
    png,
    show,
    styled,
)
from robocon_course.view.comparison import plot_counter_example
from robocon_course.view.field_picture import OUR_HALF, WHOLE_FIELD, draw_field
from robocon_course.view.lines import draw_lines, gaps_at_jumps
from robocon_course.view.motion import plot_modules, plot_paths, plot_pose_errors, plot_tracking
from robocon_course.view.runs import plot_distribution
from robocon_course.view.tracking import (
    plot_path_errors,
    plot_pursuit,
    plot_responses,
    plot_source_paths,
    plot_speeds,
)

__all__ = [
    "MINE",
    "OUR_HALF",
    "RAW",
    "REFERENCE",
    "TRUTH",
    "WARN",
    "WHOLE_FIELD",
    "XYZ",
    "draw_field",
    "figure",
    "plot_angles",
    "plot_counter_example",
    "plot_distribution",
    "plot_imu",
    "plot_modules",
    "plot_path_errors",
    "plot_paths",
    "plot_pose_errors",
    "plot_pursuit",
    "plot_responses",
    "plot_source_paths",
    "plot_speeds",
    "plot_sphere",
    "plot_still",
    "plot_tilt_error",
    "plot_tracking",
    "png",
    "show",
]

FEW = 60
WIDTH_OF_DATA = ("data", "axes fraction")


@styled()
def plot_imu(time: ArrayLike, gyro: ArrayLike, accel: ArrayLike) -> Figure:
    """What an IMU said: angular rates above, specific force below.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    gyro : array_like, shape (n, 3)  [rad/s, body]
        Drawn in deg/s.
    accel : array_like, shape (n, 3)  [m/s², body]

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    gyro = as_floats(gyro, "gyro", time.size, 3, finite=False)
    accel = as_floats(accel, "accel", time.size, 3, finite=False)
    fig, panels = figure(7.5, 4.4, rows=2, sharex=True)
    for ax, samples, title in (
        (panels[0], np.degrees(gyro), "Gyroscope [deg/s]"),
        (panels[1], accel, "Accelerometer [m/s²]"),
    ):
        lines = {name: (samples[:, i], XYZ[i]) for i, name in enumerate("xyz")}
        draw_lines(ax, time, lines, linewidth=0.9)
        ax.set_title(title)
    panels[1].set_xlabel("time [s]")
    return fig


@styled()
def plot_angles(
    time: ArrayLike,
    angles: Mapping[str, ArrayLike],
    truth: ArrayLike | None = None,
    *,
    names: tuple[str, ...] | None = None,
) -> Figure:
    """Angles over time, one panel per angle, one line per source.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    angles : mapping of label to array_like, shape (n,) or (n, k)  [rad]
        Drawn in degrees. A label that begins with mine, reference, raw or wrong gets the colour
        that means this in all chapters.
    truth : array_like, shape as the angles, optional  [rad]
    names : tuple of str, optional
        Titles of the panels; without them "angle", or roll, pitch and yaw.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    series = dict(angles) if truth is None else dict(angles) | {"truth": truth}
    columns = {label: _columns(values, label, time.size) for label, values in series.items()}
    count = max(values.shape[1] for values in columns.values())
    names = names or (("roll", "pitch", "yaw") if count > 1 else ("angle",))
    count = min(count, len(names))
    colours = colours_of(columns)
    fig, panels = figure(7.5, 1.0 + 1.75 * count, rows=count, sharex=True, squeeze=False)
    for k, ax in enumerate(panels[:, 0]):
        lines = {
            label: (gaps_at_jumps(np.degrees(values[:, k])), colours[label])
            for label, values in columns.items()
            if k < values.shape[1]
        }
        draw_lines(ax, time, lines)
        ax.set_title(f"{names[k].capitalize()} [deg]")
    panels[-1, 0].set_xlabel("time [s]")
    return fig


@styled()
def plot_tilt_error(time: ArrayLike, errors: Mapping[str, ArrayLike]) -> Figure:
    """How far the estimated vertical is off, over time; each line says its RMS.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    errors : mapping of label to array_like, shape (n,)  [rad]
        Drawn in degrees; NaN where the truth is not known.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    colours = colours_of(errors)
    lines = {}
    for label, values in errors.items():
        degrees = np.degrees(as_floats(values, label, time.size, finite=False))
        rms = np.sqrt(np.nanmean(degrees**2))
        lines[f"{label}\nRMS {rms:.2f}°"] = (degrees, colours[label])
    fig, ax = figure(7.5, 3.2)
    draw_lines(ax, time, lines, linewidth=1.1)
    ax.set_title("Tilt error [deg]")
    ax.set_xlabel("time [s]")
    return fig


_PLANES = ((0, 1), (0, 2), (1, 2))
_SPHERE = [["xy", "xz", "yz"], ["length", "length", "length"]]


@styled()
def plot_sphere(raw: ArrayLike, corrected: ArrayLike, gravity: float = 9.80665) -> Figure:
    """Accelerometer samples before and after calibration, against the sphere of radius gravity.

    Parameters
    ----------
    raw, corrected : array_like, shape (n, 3)  [m/s², body]
    gravity : float  [m/s²]

    Returns
    -------
    Figure
        Three projections above; below them the length of every sample's vector.
    """
    pairs = (
        ("raw", as_floats(raw, "raw", None, 3, finite=False), RAW, "x"),
        ("corrected", as_floats(corrected, "corrected", None, 3, finite=False), MINE, "."),
    )
    reach = 1.05 * max(gravity, *(np.nanmax(np.abs(samples)) for _, samples, *_ in pairs))
    fig, panels = figure(7.5, 5.0, mosaic=_SPHERE, height_ratios=(1.45, 1))
    for ax, (i, j) in zip(panels.values(), _PLANES, strict=False):
        ax.add_patch(Circle((0, 0), gravity, fill=False, color=TRUTH, linewidth=1.0))
        for _, samples, colour, marker in pairs:
            ax.plot(samples[:, i], samples[:, j], marker, color=colour, markersize=4)
        ax.set(aspect="equal", xlim=(-reach, reach), ylim=(-reach, reach))
        ax.set_title(f"{'xyz'[i]}{'xyz'[j]} plane [m/s²]")
    ax = panels["length"]
    lengths = {name: (np.linalg.norm(s, axis=1), colour) for name, s, colour, _ in pairs}
    few = len(pairs[0][1]) <= FEW
    style = {"linestyle": "none", "marker": "o"} if few else {"linewidth": 1.0}
    draw_lines(ax, None, lengths, **style)
    ax.margins(x=0.02)
    ax.axhline(gravity, color=TRUTH, linewidth=1.0)
    ax.set_title("Length of the measured vector; the line is gravity [m/s²]")
    ax.set_xlabel("sample")
    return fig


@styled()
def plot_still(
    time: ArrayLike,
    gyro: ArrayLike,
    bias: ArrayLike,
    moved: Iterable[tuple[float, float]] = (),
) -> Figure:
    """A gyroscope at rest: noise around a bias that is not zero.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    gyro : array_like, shape (n, 3)  [rad/s, body]
        Drawn in deg/s.
    bias : array_like, shape (3,)  [rad/s, body]
    moved : pairs (start, end)  [s]
        When the sensor was not at rest.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    rates = np.degrees(as_floats(gyro, "gyro", time.size, 3, finite=False))
    level = np.degrees(as_floats(bias, "bias", 3))
    moved = list(moved)
    fig, panels = figure(7.5, 4.8, rows=3, sharex=True)
    for i, ax in enumerate(panels):
        ax.plot(time, rates[:, i], color=RAW, linewidth=0.8)
        ax.axhline(0.0, color=TRUTH, linewidth=0.8, linestyle=":")
        for start, end in moved:
            ax.axvspan(start, end, color=WARN, alpha=0.18, linewidth=0)
        label = f"bias\n{level[i]:+.3f}".replace("-", "−")
        draw_lines(ax, time, {label: (np.full_like(time, level[i]), MINE)}, linewidth=2.0)
        ax.set_title(f"Rate about {'xyz'[i]} [deg/s]")
    for start, _ in moved:
        panels[0].annotate("moved", (start, 1.03), xycoords=WIDTH_OF_DATA, color=WARN)
    panels[2].set_xlabel("time [s]")
    return fig


def _columns(values: ArrayLike, name: str, rows: int) -> FloatArray:
    if np.ndim(values) == 1:
        return as_floats(values, name, rows, finite=False)[:, None]
    return as_floats(values, name, rows, None, finite=False)
