"""Which ball to take, and from where.

The rollers in the middle of the robot's front take whatever ball comes first. So on the way to an
own ball no other one may lie, and where the robot then stands, its square must fit.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import atan2, cos, hypot, pi, remainder, sin
from typing import NamedTuple

from robocon_course.field import BALL_DIAMETER

REACH = 0.42
"""From the robot's middle to a ball at its rollers [m]."""
RUN_UP = 0.30
"""So far it comes straight on before it takes a ball [m]."""
LANE = 0.15
"""No other ball may lie so near beside the way of the rollers [m]."""
DIRECTIONS = 32
"""Of so many directions to come from, the best is taken."""
TURN_WEIGHT = 0.25
"""A radian of turning is worth so many metres."""


class SeenBall(NamedTuple):
    """A ball, where it was seen last.

    Attributes
    ----------
    x, y : float  [m, map]
    colour : str
        ``"red"``, ``"blue"`` or ``"purple"``.
    """

    x: float
    y: float
    colour: str


class Approach(NamedTuple):
    """How to take a ball.

    Attributes
    ----------
    ball : SeenBall
    heading : float  [rad, map]
        Of the robot on its last way, straight towards the ball.
    ready, take : tuple of 2 floats  [m, map]
        Where the robot's middle is before its last way, and after it.
    """

    ball: SeenBall
    heading: float
    ready: tuple[float, float]
    take: tuple[float, float]


def choose_ball(
    balls: Sequence[SeenBall],
    team: str,
    pose: Sequence[float],
    fits: Callable[[float, float, float], bool],
) -> Approach | None:
    """The own ball that is taken soonest, and the direction to come from.

    Parameters
    ----------
    balls : sequence of SeenBall
        All that are known, whatever their colour.
    team : {"red", "blue"}
    pose : array_like, shape (3,)  [m, m, rad; map]
        Of the robot.
    fits : callable
        Takes x, y [m, map] and a heading [rad]: whether the robot's square fits there.

    Returns
    -------
    Approach or None
        None: there is no own ball, or none that can be come at.
    """
    best, least = None, float("inf")
    for ball in balls:
        if ball.colour != team:
            continue
        straight = atan2(ball.y - pose[1], ball.x - pose[0])
        for k in range(DIRECTIONS):
            # Straight ahead first, then more and more to both sides.
            turn = (k + 1) // 2 * (2 * pi / DIRECTIONS) * (1 if k % 2 else -1)
            way = approach_from(ball, straight + turn)
            price = hypot(way.ready[0] - pose[0], way.ready[1] - pose[1]) + TURN_WEIGHT * abs(
                remainder(way.heading - pose[2], 2 * pi)
            )
            if price < least and is_clear(way, balls) and _fits(way, fits):
                best, least = way, price
    return best


def approach_from(ball: SeenBall, heading: float) -> Approach:
    """The last way to a ball, coming with a heading.

    Parameters
    ----------
    ball : SeenBall
    heading : float  [rad, map]

    Returns
    -------
    Approach
    """
    c, s = cos(heading), sin(heading)
    far = REACH + RUN_UP
    return Approach(
        ball, heading,
        (ball.x - far * c, ball.y - far * s),
        (ball.x - REACH * c, ball.y - REACH * s),
    )  # fmt: skip


def is_clear(way: Approach, balls: Sequence[SeenBall]) -> bool:
    """Whether no other ball comes to the rollers before this one.

    Parameters
    ----------
    way : Approach
    balls : sequence of SeenBall
        All that are known; the one to take is among them.

    Returns
    -------
    bool
    """
    c, s = cos(way.heading), sin(way.heading)
    for other in balls:
        if other is way.ball:
            continue
        dx, dy = other.x - way.ball.x, other.y - way.ball.y
        ahead, aside = c * dx + s * dy, c * dy - s * dx
        if -(REACH + RUN_UP) < ahead < 0.3 * BALL_DIAMETER and abs(aside) < LANE:
            return False
    return True


def _fits(way: Approach, fits: Callable[[float, float, float], bool]) -> bool:
    return fits(*way.ready, way.heading) and fits(*way.take, way.heading)
