"""How a ball is come at, followed while it rolls, and told from those beside it.

`mission.choose_ball` chooses the ball and the direction to come from. From then on the balls are
seen anew ten times a second: the way moves with its ball, and where another one comes between, or
the ball is gone, a new way is chosen.
"""

from __future__ import annotations

from math import cos, hypot, sin
from typing import TYPE_CHECKING

import numpy as np

from robocon_course import field
from robocon_course.autopilot.driver import SOUTH
from robocon_course.field import BALL_DIAMETER
from robocon_course.mission import Approach, SeenBall, State
from robocon_course.mission.balls import LANE
from robocon_course.robot import SIDE

if TYPE_CHECKING:
    from robocon_course.autopilot.autopilot import Autopilot

WALL = 0.16
"""Between the body and any wall where a ball is taken [m]: it may turn there."""
CLOSE = 0.04
"""Between the body and any wall at the very end of that way [m]."""
OVERSHOOT = 0.10
"""The robot goes on so far past where the ball should be [m]."""
PATIENCE = 0.4
"""A ball that is driven to may be out of sight so long [s]."""
SWEEP = 0.12
"""With turning rollers it goes aside no faster [m/s]."""


def fits(x: float, y: float, heading: float, wall: float = WALL) -> bool:
    """Whether the robot's square stands free there, with room to turn.

    Parameters
    ----------
    x, y : float  [m, map]
    heading : float  [rad]
    wall : float  [m]
        So much room between its corners and any wall.

    Returns
    -------
    bool
        In the Storage Zone and Area 3 only.
    """
    reach = 0.5 * SIDE * (abs(cos(heading)) + abs(sin(heading))) + wall
    return reach <= x <= field.EDGE - reach and SOUTH + reach <= y <= field.SIZE - reach


def approach_to_ball(pilot: Autopilot) -> Approach | None:
    """The ball to take, and how; while it is being taken, the same one where it is now.

    Parameters
    ----------
    pilot : Autopilot

    Returns
    -------
    Approach or None
        None: no own ball can be come at.
    """
    way = pilot.notes.get("approach") if pilot.state is State.TAKE_BALL else None
    if way is not None:
        way = _still(way, pilot)
    if way is None:
        pilot.notes["straight"] = pilot.notes["close"] = False
        pilot.notes["seen"] = pilot.now
        way = pilot.parts.choose_ball(pilot.sight.balls, pilot.team, pilot.pose, fits)
    return way


def _still(way: Approach, pilot: Autopilot) -> Approach | None:
    """The way to a ball that is being taken, to where it is now; None: it can't be taken so."""
    balls = pilot.sight.balls
    straight = bool(pilot.notes.get("straight"))
    close = bool(pilot.notes.get("close"))
    if straight and (_barred(way, pilot) or (close and _other_at_rollers(way, pilot))):
        return None
    own = [ball for ball in balls if ball.colour == pilot.team]
    gaps = [hypot(ball.x - way.ball.x, ball.y - way.ball.y) for ball in own]
    if not gaps or min(gaps) > 0.2:
        return way if pilot.now - pilot.notes.setdefault("seen", pilot.now) < PATIENCE else None
    pilot.notes["seen"] = pilot.now
    moved = own[int(np.argmin(gaps))]
    if min(gaps) < 0.015:
        return way
    shift = moved.x - way.ball.x, moved.y - way.ball.y
    way = way._replace(
        ball=moved,
        ready=(way.ready[0] + shift[0], way.ready[1] + shift[1]),
        take=(way.take[0] + shift[0], way.take[1] + shift[1]),
    )
    return way if fits(*end_of(way), way.heading, CLOSE) else None  # it rolled to a wall


def _seen_from(pilot: Autopilot, heading: float, ball: SeenBall) -> tuple[float, float]:
    """How far a ball lies ahead of the robot's middle, and to its left, along a heading [m]."""
    dx, dy = ball.x - pilot.pose[0], ball.y - pilot.pose[1]
    return cos(heading) * dx + sin(heading) * dy, cos(heading) * dy - sin(heading) * dx


def may_pull(way: Approach, pilot: Autopilot) -> bool:
    """Whether what the rollers get would be the ball: seen just now, alone, and not swept up.

    Pictures come late. Who goes aside with turning rollers takes what lies there by now.

    Parameters
    ----------
    way : Approach
    pilot : Autopilot

    Returns
    -------
    bool
    """
    c, s = cos(way.heading), sin(way.heading)
    sideways = c * pilot.motion[1] - s * pilot.motion[0]
    return (
        abs(sideways) < SWEEP and pilot.sight.sees(way.ball) and not _other_at_rollers(way, pilot)
    )


def _other_at_rollers(way: Approach, pilot: Autopilot) -> bool:
    """Whether a ball of another colour may come to the rollers, or lies there already."""
    far, _ = _seen_from(pilot, way.heading, way.ball)
    for other in pilot.sight.other_colours(pilot.team):
        ahead, aside = _seen_from(pilot, way.heading, other)
        if 0.0 < ahead < far + 0.3 * BALL_DIAMETER and abs(aside) < LANE:
            return True
    return False


def _barred(way: Approach, pilot: Autopilot) -> bool:
    """Whether another ball has come between the rollers and the ball."""
    far, _ = _seen_from(pilot, way.heading, way.ball)
    for other in pilot.sight.balls:
        ahead, aside = _seen_from(pilot, way.heading, other)
        in_its_place = hypot(other.x - way.ball.x, other.y - way.ball.y) < 0.12
        in_front = 0.3 < ahead < far - 0.03 and abs(aside) < 0.12
        if other.colour != pilot.team and (in_front or in_its_place):
            return True
    return False


def end_of(way: Approach) -> tuple[float, float]:
    """Where the way to a ball ends: a little farther, but not where the ball has a wall behind.

    Parameters
    ----------
    way : Approach

    Returns
    -------
    x, y : float  [m, map]
    """
    c, s = cos(way.heading), sin(way.heading)
    for over in (OVERSHOOT, 0.5 * OVERSHOOT, 0.01):
        end = way.take[0] + over * c, way.take[1] + over * s
        if fits(*end, way.heading, BALL_DIAMETER - 0.015):
            break
    return end
