"""The plots of path tracking: step responses, the circle of pure pursuit, speed along a path, and
how far from a path robots drove.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import distance_along, transform_points
from robocon_course.view.canvas import (
    MINE,
    REFERENCE,
    TRUTH,
    WARN,
    colours_of,
    figure,
    styled,
)
from robocon_course.view.field_picture import draw_tracks, track
from robocon_course.view.lines import draw_lines

BODY = np.array([[0.08, 0.0], [-0.06, 0.055], [-0.06, -0.055]])
"""A small robot seen from above: an arrow head [m]."""


class Run(Protocol):
    """What `plot_path_errors` reads of a run."""

    time: FloatArray
    poses: FloatArray
    cross_track: FloatArray


@styled()
def plot_responses(
    time: ArrayLike,
    panels: Mapping[str, Mapping[str, ArrayLike]],
    *,
    targets: Mapping[str, float | ArrayLike] | None = None,
    limits: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Lines over time, one panel above the other, as of a controller's answers to a step.

    Parameters
    ----------
    time : array_like, shape (n,)  [s]
    panels : mapping of title to (mapping of label to array_like, shape (n,))
        A label that begins with mine, reference, raw or wrong gets the colour that means this.
    targets : mapping of title to number or array_like, shape (n,), optional
        A broad pale line where it should be.
    limits : mapping of title to (low, high), optional
        Dotted lines at both.

    Returns
    -------
    Figure
    """
    time = as_floats(time, "time", None)
    colours = colours_of(dict.fromkeys(label for lines in panels.values() for label in lines))
    fig, axes = figure(7.5, 0.7 + 1.9 * len(panels), rows=len(panels), sharex=True, squeeze=False)
    for ax, (title, lines) in zip(axes[:, 0], panels.items(), strict=True):
        for bound in (limits or {}).get(title, ()):
            ax.axhline(bound, color=TRUTH, linestyle=":", linewidth=1.2)
        drawn = {
            k: (as_floats(v, k, time.size, finite=False), colours[k]) for k, v in lines.items()
        }
        wanted = (targets or {}).get(title)
        if wanted is not None:
            drawn["target"] = (np.broadcast_to(np.asarray(wanted, float), time.shape), TRUTH)
        draw_lines(ax, time, drawn, linewidth=1.6)
        ax.set_title(title)
    axes[-1, 0].set_xlabel("time [s]")
    return fig


@styled()
def plot_pursuit(
    path: ArrayLike, pose: ArrayLike, target: ArrayLike, curvature: float, foot: ArrayLike
) -> Figure:
    """Why pure pursuit turns as it does: path, robot, look-ahead point, and the circle to it.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    pose : array_like, shape (3,)  [m, m, rad; map]
    target : array_like, shape (2,)  [m, map]
    curvature : float  [1/m]
        Positive to the left.
    foot : array_like, shape (2,)  [m, map]
        Nearest point of the path.

    Returns
    -------
    Figure
    """
    path, pose = track(path, "path"), as_floats(pose, "pose", 3)
    target, foot = as_floats(target, "target", 2), as_floats(foot, "foot", 2)
    fig, ax = figure(7.0, 4.3)
    far = float(np.hypot(*(target - pose[:2])))
    ax.plot(*path.T, color=TRUTH, linewidth=5.0, alpha=0.3, solid_joinstyle="round")
    ax.add_patch(Circle(pose[:2], far, fill=False, color=TRUTH, linestyle=":", linewidth=1.2))
    _draw_arc(ax, pose, target, curvature)
    for end, colour in ((target, MINE), (foot, "#777777")):
        ax.plot(*np.stack([pose[:2], end]).T, color=colour, linewidth=1.2, linestyle="--")
    ax.add_patch(Polygon(transform_points(pose, BODY), color=MINE, zorder=5))
    words = {"textcoords": "offset points", "fontweight": "bold"}
    for name, place, colour, off in (
        ("look-ahead point", target, WARN, (10, -4)),
        ("nearest point", foot, "#555555", (-6, 9)),
    ):
        ax.plot(*place, "o", color=colour, markersize=8, zorder=6)
        side = "right" if off[0] < 0 else "left"
        ax.annotate(name, place, off, color=colour, ha=side, **words)
    tilt = np.degrees(np.arctan2(*(target - pose[:2])[::-1]))
    tilted = words | {"rotation": (tilt + 90.0) % 180.0 - 90.0, "ha": "center", "va": "center"}
    ax.annotate(f"L = {far:.2f} m", (pose[:2] + target) / 2, (6, -9), color=MINE, **tilted)
    shown = np.vstack([path, pose[:2] - 0.3, pose[:2] + 0.3])
    (x0, y0), (x1, y1) = shown.min(axis=0) - 0.1, shown.max(axis=0) + 0.1
    ax.set(aspect="equal", xlim=(x0, x1), ylim=(y0, y1), xlabel="x [m]", ylabel="y [m]")
    return fig


def _draw_arc(ax: Axes, pose: FloatArray, target: FloatArray, curvature: float) -> None:
    """The way to the target, the rest of its circle paler, and the radius."""
    if abs(curvature) < 1e-3:
        ax.plot(*np.stack([pose[:2], target]).T, color=REFERENCE, linewidth=3.0)
        return
    centre = transform_points(pose, [0.0, 1.0 / curvature])
    radius = abs(1.0 / curvature)
    if radius < 2.0:
        style = {"color": REFERENCE, "linewidth": 1.0, "alpha": 0.6}
        ax.add_patch(Circle(centre, radius, fill=False, **style))
        ax.plot(*centre, "+", color=REFERENCE, markersize=9)
        words = {"textcoords": "offset points", "color": REFERENCE, "fontweight": "bold"}
        ax.annotate(f"r = {radius:.2f} m", centre, (8, -4), **words)
    first, last = (np.arctan2(*(place - centre)[::-1]) for place in (pose[:2], target))
    turn = (last - first) * np.sign(curvature) % (2.0 * np.pi) * np.sign(curvature)
    angles = first + turn * np.linspace(0.0, 1.0, 60)
    arc = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    ax.plot(*arc.T, color=REFERENCE, linewidth=3.0)


@styled()
def plot_path_errors(
    path: ArrayLike, runs: Mapping[str, Run], *, limit: float | None = None
) -> Figure:
    """Paths that robots drove beside the one they should, and how far off it they were.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    runs : mapping of label to run
        Anything with ``time``, ``poses`` and ``cross_track`` [s, m and rad, m], as a
        `tracking.Trial`.
    limit : float, optional  [m]
        Where a demand or a published number lies, on both sides.

    Returns
    -------
    Figure
        Distance in cm, positive to the left of the path.
    """
    path = track(path, "path")
    colours = colours_of(runs)
    fig, (plane, errors) = figure(8.2, 3.9, columns=2, width_ratios=(1, 1.15))
    plane.plot(*path.T, color=TRUTH, linewidth=5.0, alpha=0.3, solid_joinstyle="round")
    for label, run in runs.items():
        plane.plot(run.poses[:, 0], run.poses[:, 1], color=colours[label], linewidth=1.6)
    plane.plot(*path[0], "o", color=TRUTH, markersize=6)
    plane.set(aspect="equal", adjustable="datalim", xlabel="x [m]", ylabel="y [m]", title="Path")
    plane.xaxis.set_major_locator(MaxNLocator(4))
    for bound in () if limit is None else (-limit, limit):
        errors.axhline(100.0 * bound, color=TRUTH, linestyle=":", linewidth=1.2)
    for label, run in runs.items():
        errors.plot(run.time, 100.0 * run.cross_track, color=colours[label], label=label)
    errors.set(title="Off the path [cm]", xlabel="time [s]")
    errors.margins(x=0.0)
    if len(runs) > 1:
        fig.legend(loc="outside lower center", ncols=len(runs), fontsize=10)
    return fig


@styled()
def plot_speeds(
    path: ArrayLike, speeds: ArrayLike, bounds: Mapping[str, ArrayLike] | None = None
) -> Figure:
    """How fast, where: the path coloured by its speed, and the speed over the way.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    speeds : array_like, shape (n,)  [m/s]
    bounds : mapping of label to array_like, shape (n,), optional  [m/s]
        Other lines over the way, as the limits of the bends.

    Returns
    -------
    Figure
    """
    path = track(path, "path")
    speeds, way = as_floats(speeds, "speeds", len(path)), distance_along(path)
    fig, (plane, over) = figure(8.2, 3.4, columns=2, width_ratios=(1, 1.25))
    pieces = LineCollection(np.stack([path[:-1], path[1:]], axis=1), cmap="viridis", linewidth=4.0)
    pieces.set_array(0.5 * (speeds[:-1] + speeds[1:]))
    plane.add_collection(pieces)
    plane.plot(*path[0], "o", color=TRUTH, markersize=7, zorder=5)
    plane.set(aspect="equal", adjustable="datalim", xlabel="x [m]", ylabel="y [m]")
    plane.set_title("Path, coloured by speed")
    plane.margins(0.08)
    fig.colorbar(pieces, ax=plane, label="m/s", shrink=0.85)
    colours = colours_of(bounds or {})
    for label, bound in (bounds or {}).items():
        line = as_floats(bound, label, len(path), finite=False)
        over.plot(way, line, color=colours[label], linewidth=1.1, linestyle="--", label=label)
    over.plot(way, speeds, color=REFERENCE, linewidth=2.4, label="speed profile")
    over.set(title="Speed [m/s]", xlabel="way [m]", ylim=(0.0, 1.5 * speeds.max()))
    over.margins(x=0.0)
    over.legend(loc="upper center", ncols=2, frameon=True, framealpha=1.0, edgecolor="white")
    return fig


@styled()
def plot_source_paths(
    paths: Mapping[str, ArrayLike], runs: Mapping[str, Mapping[str, ArrayLike]]
) -> Figure:
    """Several test paths side by side, and what was driven on each.

    Parameters
    ----------
    paths : mapping of name to array_like, shape (n, 2)  [m, map]
    runs : mapping of name to (mapping of label to array_like, shape (n, 3))  [m, m, rad; map]

    Returns
    -------
    Figure
    """
    fig, panels = figure(8.2, 3.5, columns=len(paths))
    for ax, (name, path) in zip(panels, paths.items(), strict=True):
        draw_tracks(ax, {label: track(poses, label) for label, poses in runs[name].items()})
        handles, labels = ax.get_legend_handles_labels()
        ax.get_legend().remove()
        ax.plot(*track(path, name).T, color=TRUTH, linewidth=6.0, alpha=0.25, zorder=1)
        ax.plot(*track(path, name)[0], "o", color=TRUTH, markersize=6, zorder=6)
        ax.set(aspect="equal", adjustable="datalim", xlabel="x [m]")
    panels[0].set_ylabel("y [m]")
    fig.legend(handles, labels, loc="outside upper left", ncols=len(labels), fontsize=10)
    return fig
