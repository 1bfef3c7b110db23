"""The plots of a robot that moves: paths, pose errors, modules, following a target."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import wrap_angle
from robocon_course.view.canvas import (
    MINE,
    REFERENCE,
    TRUTH,
    WARN,
    XYZ,
    colours_of,
    figure,
    styled,
)
from robocon_course.view.field_picture import draw_rings, draw_tracks, track
from robocon_course.view.lines import draw_lines, gaps_at_jumps

MODULE_NAMES = ("front left", "rear left", "rear right", "front right")
MODULE_COLOURS = (MINE, WARN, REFERENCE, XYZ[0])
MOST_SIZE = (6.6, 5.6)


@styled()
def plot_paths(
    paths: Mapping[str, ArrayLike],
    *,
    markers: Mapping[str, ArrayLike] | None = None,
    headings: int = 0,
) -> Figure:
    """Paths in the plane, x to the right, both axes in the same scale.

    For paths on the game field there is `draw_field`.

    Parameters
    ----------
    paths : mapping of label to array_like, shape (n, 2) or (n, 3)  [m, map]
        Points or poses. A label that begins with mine, reference, truth, raw or wrong gets the
        colour that means this in all chapters.
    markers : mapping of label to array_like, shape (2,) or (k, 2)  [m, map]
        Rings with their label beside the first.
    headings : int
        How many arrows along each path of poses say where the robot faces.

    Returns
    -------
    Figure
    """
    tracks = {label: track(path, label) for label, path in paths.items()}
    rings = {label: track(np.atleast_2d(at), label) for label, at in (markers or {}).items()}
    known = np.vstack([*tracks.values(), *rings.values()])
    width, height = np.maximum(np.nanmax(known, axis=0) - np.nanmin(known, axis=0), 1e-3)
    height, width = max(height, width / 4), max(width, height / 1.6)
    scale = min(MOST_SIZE[0] / width, MOST_SIZE[1] / height)
    fig, ax = figure(scale * width + 0.9, scale * height + 0.95)
    ax.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", adjustable="datalim")
    draw_tracks(ax, tracks)
    for label, colour in colours_of(tracks).items():
        if np.shape(paths[label])[1] == 3:
            _draw_headings(ax, np.asarray(paths[label], float), headings, colour)
    for label, points in rings.items():
        draw_rings(ax, label, points)
    if rings or headings:
        ax.margins(0.12)  # labels and arrows stand out beyond the paths
    return fig


@styled()
def plot_pose_errors(time: ArrayLike, poses: Mapping[str, ArrayLike], truth: ArrayLike) -> Figure:
    """How far estimated poses are off, over time; each line says its last value.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    poses : mapping of label to array_like, shape (n, 3)  [m, m, rad; map]
        NaN where there is none.
    truth : array_like, shape (n, 3)  [m, m, rad; map]

    Returns
    -------
    Figure
        Distance above, in mm where all are below 1 m; heading error below, in degrees.
    """
    time = as_floats(time, "time", None)
    truth = as_floats(truth, "truth", time.size, 3, finite=False)
    errors = {
        label: as_floats(values, label, time.size, 3, finite=False) - truth
        for label, values in poses.items()
    }
    colours = colours_of(errors)
    far = {label: np.hypot(error[:, 0], error[:, 1]) for label, error in errors.items()}
    small = all(np.nanmax(distance) < 1.0 for distance in far.values())
    unit, scale, decimals = ("mm", 1000.0, 0) if small else ("m", 1.0, 2)
    turned = {label: np.degrees(wrap_angle(error[:, 2])) for label, error in errors.items()}
    fig, panels = figure(7.5, 4.6, rows=2, sharex=True)
    _draw_ends(panels[0], time, {k: v * scale for k, v in far.items()}, colours, decimals)
    _draw_ends(panels[1], time, turned, colours, 1, "°")
    panels[0].set_title(f"Position error, and its last value [{unit}]")
    panels[0].set_ylim(bottom=0.0)
    panels[1].set_title("Heading error [deg]")
    panels[1].set_xlabel("time [s]")
    return fig


@styled()
def plot_modules(
    time: ArrayLike,
    angles: ArrayLike,
    speeds: ArrayLike,
    *,
    target_angles: ArrayLike | None = None,
    target_speeds: ArrayLike | None = None,
) -> Figure:
    """What the four modules do: where they point above, how fast they roll below.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    angles : array_like, shape (n, 4)  [rad, base]
        Drawn in degrees, in the order of `robot.MODULES`.
    speeds : array_like, shape (n, 4)  [m/s]
    target_angles, target_speeds : array_like, shape (n, 4), optional  [rad, base; m/s]
        What was asked for: thin black lines.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    fig, panels = figure(7.5, 4.8, rows=2, sharex=True)
    for ax, values, wanted, name, unit in (
        (panels[0], angles, target_angles, "angle", "deg"),
        (panels[1], speeds, target_speeds, "speed", "m/s"),
    ):
        drawn = _in_degrees(as_floats(values, f"{name}s", time.size, 4, finite=False), unit)
        if wanted is not None:
            wanted = as_floats(wanted, f"target_{name}s", time.size, 4, finite=False)
            ax.plot(time, _in_degrees(wanted, unit), color=TRUTH, linewidth=0.8, zorder=3)
        names = zip(MODULE_NAMES, drawn.T, MODULE_COLOURS, strict=True)
        draw_lines(ax, time, {label: (line, paint) for label, line, paint in names})
        asked = "" if wanted is None else ", black: asked for"
        ax.set_title(f"Module {name} [{unit}]{asked}")
    panels[1].set_xlabel("time [s]")
    return fig


_TRACKING = [["x", "path"], ["y", "path"], ["heading", "path"]]


@styled()
def plot_tracking(
    time: ArrayLike, poses: ArrayLike, targets: ArrayLike, *, label: str = "mine"
) -> Figure:
    """How a robot follows a target: x, y and heading over time, and the path with headings.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    poses : array_like, shape (n, 3)  [m, m, rad; map]
    targets : array_like, shape (3,) or (n, 3)  [m, m, rad; map]
        A target that stands, or one that moves.
    label : str
        Name of the robot's line; its first word decides the colour.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    poses = as_floats(poses, "poses", time.size, 3, finite=False)
    if still := np.ndim(targets) == 1:
        targets = np.tile(as_floats(targets, "targets", 3), (time.size, 1))
    targets = as_floats(targets, "targets", time.size, 3, finite=False)
    colour = colours_of([label])[label]
    fig, panels = figure(8.2, 5.0, mosaic=_TRACKING, width_ratios=(1.25, 1))
    for k, (name, unit) in enumerate((("x", "m"), ("y", "m"), ("heading", "deg"))):
        pair = {"target": (targets[:, k], TRUTH), label: (poses[:, k], colour)}
        drawn = {who: (_in_degrees(line, unit), paint) for who, (line, paint) in pair.items()}
        draw_lines(panels[name], time, drawn)
        panels[name].set_title(f"{name.capitalize()} [{unit}]" if k == 2 else f"{name} [{unit}]")
    panels["heading"].set_xlabel("time [s]")
    ax = panels["path"]
    ax.set(aspect="equal", adjustable="datalim", xlabel="x [m]", ylabel="y [m]")
    ax.set_title("Path; arrows: heading")
    _draw_headings(ax, poses, 12, "#777777")
    if still:
        ax.plot(*targets[0, :2], "*", color=REFERENCE, markersize=15, zorder=6)
    else:
        ax.plot(targets[:, 0], targets[:, 1], color=TRUTH, linewidth=4.5, alpha=0.3, zorder=1)
    ax.plot(poses[:, 0], poses[:, 1], color=colour, zorder=4)
    ax.plot(*poses[0, :2], "o", color=WARN, markersize=7, zorder=6)
    ax.margins(0.12)
    return fig


def _draw_headings(ax: Axes, poses: FloatArray, count: int, colour: str) -> None:
    """Arrows at poses that lie evenly along the path."""
    poses = poses[np.isfinite(poses).all(axis=1)]
    if not count or len(poses) < 2:
        return
    way = np.r_[0.0, np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))]
    x, y, theta = poses[
        np.searchsorted(way, np.linspace(0.0, way[-1], count)).clip(0, len(way) - 1)
    ].T
    style = {"color": colour, "width": 0.006, "scale": 14.0, "pivot": "tail", "zorder": 5}
    ax.quiver(x, y, np.cos(theta), np.sin(theta), **style)


def _draw_ends(
    ax: Axes,
    time: FloatArray,
    lines: Mapping[str, FloatArray],
    colours: Mapping[str, str],
    decimals: int,
    unit: str = "",
) -> None:
    """Lines whose labels say their last value."""
    named = {}
    for label, values in lines.items():
        known = values[np.isfinite(values)]
        last = f"{known[-1]:.{decimals}f}".replace("-", "−") if known.size else "–"
        named[f"{label}\n{last}{unit}"] = (values, colours[label])
    draw_lines(ax, time, named, linewidth=1.4)


def _in_degrees(values: FloatArray, unit: str) -> FloatArray:
    """Angles within half a turn, with gaps where they jump; other units as they are."""
    if unit != "deg":
        return values
    return np.apply_along_axis(gaps_at_jumps, 0, np.degrees(wrap_angle(values)))
