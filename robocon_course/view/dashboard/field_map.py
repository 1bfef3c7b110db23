"""The robot on its field: a picture of the floor that stays, and lines over it that move.

The floor is drawn once. Over it lies an SVG of some kilobytes, in centimetres with y downwards,
which is written anew every time.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from functools import cache
from math import degrees, dist
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from PIL import Image

from robocon_course import field, robot
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import wrap_angle
from robocon_course.view.body import RobotPicture, Shape, robot_shapes
from robocon_course.view.dashboard.inbox import JUMP, Inbox
from robocon_course.view.dashboard.markup import (
    MINE,
    PLANNED,
    QUIET,
    TRUTH,
    ball,
    data_uri,
    escaped,
    number,
)
from robocon_course.view.ground import painted_field

PER_METRE = 100
PALE = 0.45
RIM = field.FENCE_THICKNESS
RIGHT = 7.25
"""Right end of what is shown [m]: our half, the silos, and room for what they hold."""
BOX = f"{-100 * RIM:g} {-100 * (field.SIZE + RIM):g} {100 * (RIGHT + RIM):g} {1210:g}"
SHAPE = "display:block;width:100%;aspect-ratio:730/1210"
BESIDE, PITCH, BALL = 0.38, 0.26, 12
"""Of the balls beside a silo: the first [m], from one to the next [m], radius [cm]."""


@cache
def floor() -> str:
    """The floor with the silos' numbers, as HTML; drawn once."""
    pixels, scale = painted_field(PER_METRE, PALE)
    columns = round(scale.left + RIGHT * PER_METRE)
    picture = pixels[:, :columns].copy()
    beyond = round(scale.left + field.SILO_ZONE.x1 * PER_METRE)
    picture[:, beyond:] = (0.35 * picture[:, beyond:] + 0.65 * 255).astype(np.uint8)
    stream = io.BytesIO()
    image = Image.fromarray(picture).quantize(64, dither=Image.Dither.NONE)
    image.save(stream, "png", optimize=True)
    return f'<img alt="" style="{SHAPE}" src="{data_uri(stream.getvalue(), "png")}">'


def overlay(inbox: Inbox) -> str:
    """Everything on the map that moves, as one SVG.

    Parameters
    ----------
    inbox : Inbox

    Returns
    -------
    str
        HTML; its label says in words where the robot is.
    """
    latest = inbox.latest
    parts = [
        *_silos(latest.get("/silos")),
        *_way(latest.get("/plan"), inbox.reached),
        _trail(list(inbox.trail)),
        *_truth(latest.get("/ground_truth")),
        *_robot(latest),
    ]
    words = escaped(where(inbox))
    return (
        f'<svg viewBox="{BOX}" style="{SHAPE}" role="img" aria-label="Map: {words}">'
        f"{''.join(parts)}</svg>"
    )


def where(inbox: Inbox) -> str:
    """Where the robot believes to be, in words."""
    told = inbox.latest.get("/odom")
    if told is None:
        return "no pose yet"
    x, y, theta = as_floats(told.pose, "/odom: pose", 3)
    turned = number(degrees(float(wrap_angle(theta))), 0)
    target = "; target reached" if inbox.reached else ""
    return f"x {number(x)} m, y {number(y)} m, heading {turned}°{target}"


def key() -> str:
    """What the lines on the map mean."""
    lines = ((MINE, "", "driven"), (PLANNED, "4 3", "planned"), (TRUTH, "2 2", "true"))
    drawn = "".join(
        f'<span style="margin-right:10px;white-space:nowrap"><svg width="20" height="8">'
        f'<line x1="0" y1="4" x2="20" y2="4" stroke="{colour}" stroke-width="2" '
        f'stroke-dasharray="{dashes}"/></svg> {word}</span>'
        for colour, dashes, word in lines
    )
    return f'<div style="color:{QUIET}">{drawn}</div>'


def _points(xy: ArrayLike) -> list[tuple[int, int]]:
    """Whole centimetres, y downwards."""
    return [(round(100 * x), round(-100 * y)) for x, y in np.asarray(xy, float).tolist()]


def _line(points: Iterable[tuple[int, int]]) -> str:
    """A path's data; steps are written relative, which is shorter."""
    written, (x, y) = [], (0, 0)
    for a, b in points:
        far = not written or dist((a, b), (x, y)) > 100 * JUMP
        written.append(f"M{a} {b}" if far else f"l{a - x} {b - y}")
        x, y = a, b
    return "".join(written)


def _trail(trail: list[tuple[float, float]]) -> str:
    return (
        f'<path class="rc-trail" d="{_line(_points(trail))}" fill="none" stroke="{MINE}" '
        f'stroke-width="5" stroke-linejoin="round"/>'
        if trail
        else ""
    )


def _way(plan: Any, reached: bool) -> Iterable[str]:
    """The planned way, and a ring at its end; the ring is full once the robot was there."""
    if plan is None or not len(plan.xy):
        return
    points = _points(as_floats(plan.xy, "/plan: xy", None, 2))
    way = "M" + "L".join(f"{x} {y}" for x, y in points)
    style = f'fill="none" stroke="{PLANNED}" stroke-width="5" stroke-dasharray="14 10"'
    yield f'<path class="rc-plan" d="{way}" {style}/>'
    x, y = points[-1]
    fill = PLANNED if reached else "#fff"
    yield f'<circle cx="{x}" cy="{y}" r="15" fill="{fill}" stroke="{PLANNED}" stroke-width="6"/>'
    if reached:
        tick = f"M{x - 7} {y}l5 6 9 -12"
        yield f'<path class="rc-reached" d="{tick}" fill="none" stroke="#fff" stroke-width="4"/>'


def _silos(silos: Any) -> Iterable[str]:
    """Silos with their numbers, and beside each what it is believed to hold, the lowest first."""
    fillings = () if silos is None else tuple(map(str, silos.fillings))
    for k, (x, y) in enumerate(field.SILOS):
        column, row = 100 * x, -100 * y
        radius = 50 * field.SILO_DIAMETER
        yield f'<circle cx="{column:g}" cy="{row:g}" r="{radius:g}" fill="#fff" stroke="{TRUTH}"/>'
        yield (
            f'<text x="{column:g}" y="{row:g}" dy=".36em" text-anchor="middle" font-size="22" '
            f'fill="{TRUTH}">{k + 1}</text>'
        )
        filling = fillings[k] if k < len(fillings) else ""
        for place in range(field.SILO_CAPACITY):
            at = 100 * (x + BESIDE + PITCH * place)
            if place < len(filling):
                yield ball(at, row, BALL, filling[place])
            else:
                empty = f'fill="none" stroke="{QUIET}" stroke-dasharray="4 4"'
                yield f'<circle cx="{at:g}" cy="{row:g}" r="{BALL - 1}" {empty}/>'


def _placed(pose: FloatArray) -> str:
    x, y, theta = pose
    return f"translate({100 * x:.1f} {-100 * y:.1f}) rotate({0.0 - degrees(theta):.1f})"


def _truth(told: Any) -> Iterable[str]:
    """Where the robot is indeed, which only a simulator tells: a dashed outline."""
    if told is not None:
        half = 50 * robot.SIDE
        yield (
            f'<rect class="rc-truth" transform="{_placed(as_floats(told.pose, "pose", 3))}" '
            f'x="{-half:g}" y="{-half:g}" width="{2 * half:g}" height="{2 * half:g}" '
            f'fill="none" stroke="{TRUTH}" stroke-width="3" stroke-dasharray="8 6"/>'
        )


def _robot(latest: dict[str, Any]) -> Iterable[str]:
    told = latest.get("/odom")
    if told is None:
        return
    pose = as_floats(told.pose, "/odom: pose", 3)
    shapes = robot_shapes(_picture(latest))
    yield f'<g class="rc-robot" transform="{_placed(pose)}">{"".join(map(_polygon, shapes))}</g>'


def _picture(latest: dict[str, Any]) -> RobotPicture:
    """The robot at the origin, with beams and wheels as far as they are known."""
    seen, scan = latest.get("/observation"), latest.get("/scan")
    if seen is not None:
        return RobotPicture.seen((0.0, 0.0, 0.0), seen)
    return RobotPicture((0.0, 0.0, 0.0), beams=None if scan is None else scan.ranges)


def _polygon(shape: Shape) -> str:
    corners = " ".join(f"{100 * x:.1f},{-100 * y:.1f}" for x, y in shape.corners.tolist())
    opacity = "" if shape.opacity == 1.0 else f' opacity="{shape.opacity:g}"'
    return f'<polygon points="{corners}" fill="{shape.colour}"{opacity}/>'
