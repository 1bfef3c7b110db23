"""The sensors in numbers, and the four modules as arrows."""

from __future__ import annotations

from collections.abc import Iterable
from math import cos, degrees, sin
from typing import Any

import numpy as np

from robocon_course.robot import LIDARS, MAX_SPEED, SATURATED, WEAKEST
from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.dashboard.markup import MINE, QUIET, TRUTH, escaped, head, number

MODULES = ("front left", "rear left", "rear right", "front right")
COUNTERS = ("left", "right", "rear", "gripper")
STILL = 0.02
"""Slower wheels show no arrow [m/s]."""


def readings(inbox: Inbox) -> str:
    """What the sensors say, as a table.

    Parameters
    ----------
    inbox : Inbox

    Returns
    -------
    str
        HTML.
    """
    seen = inbox.latest.get("/observation")
    if seen is None:
        return head("Sensors") + "no reading yet"
    rows = "".join(_rows(seen, rates(list(inbox.ticks))))
    return f'{head("Sensors")}<table class="rc">{rows}</table>'


def rates(ticks: list[tuple[float, Any]]) -> list[float]:
    """Ticks per second of each counter over what is kept of it; NaN where nothing tells."""
    if len(ticks) < 2 or ticks[-1][0] <= ticks[0][0]:
        return [float("nan")] * 3
    (begun, first), (ended, last) = ticks[0], ticks[-1]
    return ((np.asarray(last, float) - np.asarray(first, float)) / (ended - begun)).tolist()


def _rows(seen: Any, speeds: list[float]) -> Iterable[str]:
    yield _heads("encoder", COUNTERS)
    ball = "holds a ball" if seen.holding else "empty"
    yield _row("ticks", [*(number(count, 0) for count in seen.ticks), ball])
    yield _row("ticks/s", [number(speed, 0) for speed in speeds])
    yield _heads("LiDAR", [mount.name for mount in LIDARS])
    yield _row("distance [m]", [_distance(reading) for reading in seen.lidar])
    yield _row("strength", [_strength(reading.strength) for reading in seen.lidar])
    yield _heads("IMU", ("gyro z", "accel x", "accel y", "accel z"))
    yield _row("rad/s, m/s²", _inertial(seen))
    yield _heads("module", MODULES)
    pairs = list(zip(seen.module_angles, seen.module_speeds, strict=True))
    yield _row("", [arrow(float(angle), float(speed)) for angle, speed in pairs])
    yield _row("angle [°]", [number(degrees(angle), 0) for angle, _ in pairs])
    yield _row("speed [m/s]", [number(speed) for _, speed in pairs])


def _heads(label: str, names: Iterable[str]) -> str:
    cells = "".join(f"<th>{escaped(name)}</th>" for name in names)
    return f'<tr class="rc-top"><th><b>{label}</b></th>{cells}</tr>'


def _row(label: str, cells: Iterable[str]) -> str:
    return f"<tr><th>{label}</th>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _distance(reading: Any) -> str:
    return number(reading.distance) if reading.distance else "–"


def _strength(strength: int) -> str:
    """Too little or too much light makes the distance worthless, and is told in a word."""
    if strength >= SATURATED:
        return "too much"
    return f"{strength:d} weak" if strength < WEAKEST else f"{strength:d}"


def _inertial(seen: Any) -> list[str]:
    """The last sample since the read before; dashes where there was none."""
    if not len(seen.gyro) or not len(seen.accel):
        return ["–"] * 4
    return [number(seen.gyro[-1][2]), *(number(part, 1) for part in seen.accel[-1])]


def arrow(angle: float, speed: float) -> str:
    """A module from above, the robot's front at the top: its wheel, and where it rolls."""
    x, y = -sin(angle), -cos(angle)
    wheel = f'<line x1="{-7 * x:.1f}" y1="{-7 * y:.1f}" x2="{7 * x:.1f}" y2="{7 * y:.1f}" '
    parts = [
        f'<circle r="15" fill="#F4F6F8" stroke="{QUIET}" stroke-width=".7"/>',
        f'{wheel}stroke="{TRUTH}" stroke-width="5"/>',
    ]
    if abs(speed) > STILL:
        reach = np.copysign(7.0 + 8.0 * min(abs(speed) / MAX_SPEED, 1.0), speed)
        tip = f'transform="translate({reach * x:.1f} {reach * y:.1f}) '
        turn = degrees(np.arctan2(reach * y, reach * x))
        parts.append(
            f'<line x2="{reach * x:.1f}" y2="{reach * y:.1f}" stroke="{MINE}" stroke-width="2.4"/>'
            f'<path {tip}rotate({turn:.0f})" d="M4 0L-4 4L-4 -4z" fill="{MINE}"/>'
        )
    return (
        f'<svg class="rc-module" width="38" height="38" viewBox="-19 -19 38 38">'
        f"{''.join(parts)}</svg>"
    )
