"""The robot from above, with everything that the chapters talk about."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrow, FancyBboxPatch, Rectangle, Wedge
from matplotlib.transforms import Affine2D, Transform

from robocon_course.field import BALL_DIAMETER
from robocon_course.robot import DEAD_WHEELS, LIDARS, MODULES, SIDE
from robocon_course.view.body import BODY, RUBBER, STEEL
from robocon_course.view.canvas import MINE, TRUTH, WARN, XYZ, figure, styled

(_, SIDE_WHEEL), _, (_REAR, _) = DEAD_WHEELS.positions.tolist()
REAR_WHEEL = -_REAR
TWIST = (0.8, 0.35, 1.1)
"""Forward, left, turning: the motion that the arrows of the wheels belong to."""
ORANGE = "#E69F00"
LABELS = (  # words, where they stand, what they point at; on the page: right, up
    ("gripper,\nholds one ball", (0.47, 0.57), (0.12, 0.47)),
    ("camera on a servo\n(06 vision)", (0.47, 0.40), (0.035, 0.225)),
    ("swerve module, one of four:\nturns and drives (03 swerve)", (0.47, 0.22), (0.30, 0.235)),
    ("right dead wheel\n(02 odometry)", (0.47, 0.05), (0.29, 0.0)),
    ("LiDAR, one of four:\none to each side (02, 08, 09)", (-0.47, 0.41), (-0.14, 0.31)),
    ("arrows: where the wheels roll\nin one motion of the body", (-0.47, 0.235), (-0.325, 0.27)),
    ("left dead wheel\n(02 odometry)", (-0.47, 0.025), (-0.29, 0.0)),
    ("phone with IMU\n(01 IMU)", (-0.47, -0.14), (-0.045, -0.05)),
    ("dead wheel across,\nbehind the centre", (-0.47, -0.41), (-0.03, -0.287)),
)


@styled()
def draw_robot() -> Figure:
    """The robot from above: x, forward, points up on the page and y to the left.

    Returns
    -------
    Figure
    """
    fig, ax = figure(8.2, 6.2)
    ax.set(xlim=(-0.98, 0.98), ylim=(-0.72, 0.72), aspect="equal")
    ax.set_axis_off()
    robot = Affine2D().rotate_deg(90.0) + ax.transData
    _draw_views(ax, robot)
    _draw_body(ax, robot)
    for x, y in MODULES.tolist():
        _draw_module(ax, robot, x, y)
    rolling = np.degrees(DEAD_WHEELS.directions).tolist()
    for place, angle in zip(DEAD_WHEELS.positions.tolist(), rolling, strict=True):
        _draw_box(ax, robot, place, (0.075, 0.028), angle, facecolor=ORANGE, edgecolor=TRUTH)
    _draw_axes(ax, robot)
    _draw_sizes(ax)
    for words, place, target in LABELS:
        side = "left" if place[0] > 0 else "right"
        line = {"arrowstyle": "-", "color": STEEL, "linewidth": 0.9, "shrinkA": 2, "shrinkB": 0}
        ax.annotate(words, target, place, ha=side, va="center", fontsize=9.5, arrowprops=line)
    return fig


def _draw_box(
    ax: Axes,
    transform: Transform,
    centre: tuple[float, float],
    size: tuple[float, float],
    angle: float = 0.0,
    **style: Any,
) -> None:
    corner = centre[0] - size[0] / 2, centre[1] - size[1] / 2
    turn = {"angle": angle, "rotation_point": "center", "transform": transform}
    ax.add_patch(Rectangle(corner, *size, **turn, **style))


def _draw_views(ax: Axes, robot: Transform) -> None:
    """What camera and LiDARs see; the beams are as narrow as the real ones, 3.6 degrees."""
    ax.add_patch(Wedge((0.225, 0.0), 0.46, -32, 32, color=MINE, alpha=0.10, transform=robot))
    for mount in LIDARS:
        beam = {"color": WARN, "alpha": 0.45, "linewidth": 0.0, "transform": robot}
        angle = np.degrees(mount.angle)
        ax.add_patch(Wedge((mount.x, mount.y), 0.22, angle - 1.8, angle + 1.8, **beam))


def _draw_body(ax: Axes, robot: Transform) -> None:
    half, shape = SIDE / 2, "round,pad=0,rounding_size=0.05"
    style = {"facecolor": BODY, "edgecolor": STEEL, "linewidth": 2.0, "transform": robot}
    ax.add_patch(FancyBboxPatch((-half, -half), SIDE, SIDE, shape, **style))
    for y in (-0.115, 0.115):
        _draw_box(ax, robot, (0.415, y), (0.18, 0.022), color=STEEL)
    ball = {"facecolor": "#F03241", "edgecolor": "white", "transform": robot}
    ax.add_patch(Circle((0.445, 0.0), BALL_DIAMETER / 2, **ball))
    _draw_box(ax, robot, (0.225, 0.0), (0.045, 0.09), color=RUBBER)
    ax.add_patch(Circle((0.25, 0.0), 0.018, color=MINE, transform=robot))
    for mount in LIDARS:
        _draw_box(ax, robot, (mount.x, mount.y), (0.03, 0.06), np.degrees(mount.angle), color=WARN)
    phone = {"facecolor": "#C9D1D9", "edgecolor": RUBBER, "linewidth": 1.4}
    _draw_box(ax, robot, (0.0, 0.0), (0.16, 0.085), **phone)


def _draw_module(ax: Axes, robot: Transform, x: float, y: float) -> None:
    """A swerve module; v = (vx - omega y, vy + omega x) says how its wheel stands."""
    forward, left, omega = TWIST
    velocity = np.array([forward - omega * y, left + omega * x])
    angle = np.degrees(np.arctan2(velocity[1], velocity[0]))
    rim = {"facecolor": "white", "edgecolor": STEEL, "linewidth": 1.4, "transform": robot}
    ax.add_patch(Circle((x, y), 0.072, **rim))
    _draw_box(ax, robot, (x, y), (0.09, 0.035), angle, color=RUBBER)
    arrow = {"width": 0.011, "head_width": 0.038, "length_includes_head": True, "zorder": 5}
    ax.add_patch(FancyArrow(x, y, *(0.16 * velocity), color=MINE, transform=robot, **arrow))


def _draw_axes(ax: Axes, robot: Transform) -> None:
    arrow = {"width": 0.008, "head_width": 0.03, "length_includes_head": True, "zorder": 6}
    words = {"ha": "center", "va": "center", "fontweight": "bold", "fontsize": 11, "zorder": 7}
    axes = (("x", (0.17, 0.0), (0.03, 0.15)), ("y", (0.0, 0.17), (-0.15, 0.035)))
    for (name, step, place), colour in zip(axes, XYZ, strict=False):
        ax.add_patch(FancyArrow(0, 0, *step, color=colour, transform=robot, **arrow))
        ax.text(*place, name, color=colour, **words)


def _draw_sizes(ax: Axes) -> None:
    """Dimension lines, in the millimetres of a drawing."""
    half = SIDE / 2
    sizes = (
        ((-half, -0.56), (half, -0.56), "650 mm", (0.0, -0.595)),
        (
            (-SIDE_WHEEL, -0.64),
            (SIDE_WHEEL, -0.64),
            "537.7 mm between the dead wheels",
            (0.0, -0.675),
        ),
        ((0.08, 0.0), (0.08, -REAR_WHEEL), "274.5\nmm", (0.14, -0.16)),
    )
    for start, end, words, place in sizes:
        line = {"arrowstyle": "<->", "color": TRUTH, "linewidth": 0.9, "shrinkA": 0, "shrinkB": 0}
        ax.annotate("", end, start, arrowprops=line)
        ax.text(*place, words, ha="center", va="center", fontsize=9)
