"""Balls on the floor: they roll, push each other, and are pushed by the robot's square.

Seen from above a ball is a disc. Where two of them, or one and a wall, or one and the robot,
overlap, they are moved apart, and what they had of speed towards each other is shared out. On a
slope they roll down; on the flat they run out. The robot does not feel them: 0.3 kg beside 25 kg.

Source: diameter and mass from the field of 2024; rolling resistance, bounce and the rollers' reach
are assumed.
"""

from __future__ import annotations

from math import cos, hypot, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.field import BALL_DIAMETER, SIDE_SLOPE, SIZE, STORAGE_ZONE
from robocon_course.robot import SIDE

RADIUS = BALL_DIAMETER / 2
OUT, FREE, HELD = 0, 1, 2
"""Where a ball is: in a silo or out of play, on the floor, in the gripper."""
HALT = 0.25
"""A rolling ball loses so much speed [m/s^2]."""
BOUNCE = 0.3
"""Share of the speed that comes back from a push."""
ROLL_DOWN = 9.81 * SIDE_SLOPE.slope[0] * 5 / 7
"""Down the side slope, a rolling solid ball [m/s^2]."""
LOW = (RADIUS, STORAGE_ZONE.y0 + RADIUS)
HIGH = (5.875 - RADIUS, SIZE - RADIUS)
"""Walls around Area 3 and the Storage Zone, as a ball's middle meets them [m, map]."""
ROLLERS = 0.09
"""Half of the width of the rollers in the middle of the front: beyond it a ball rolls off [m]."""
TOUCH = 0.02
"""A ball so near before the front is at the rollers [m]."""
PULL = 0.25
"""The rollers need so long to take a ball [s]."""
SUBSTEPS = 2


@njit(cache=True)
def roll(xy, velocity, place, robot, motion, pull, dt):
    """Move all free balls; tell which one is at the rollers.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
        Changed in place, as are the next ones.
    velocity : ndarray, shape (n, 2)  [m/s, map]
    place : ndarray of int64, shape (n,)
        `OUT`, `FREE` or `HELD`.
    robot : ndarray, shape (3,)  [m, m, rad; map]
    motion : ndarray, shape (3,)  [m/s, m/s, rad/s; map]
        How the robot moves.
    pull : float
        Above 0 the rollers turn inwards.
    dt : float  [s]

    Returns
    -------
    int
        Number of the ball at the rollers, or -1.
    """
    count, h, at_rollers = len(xy), dt / SUBSTEPS, -1
    c, s = cos(robot[2]), sin(robot[2])
    for _ in range(SUBSTEPS):
        at_rollers = -1
        for i in range(count):
            if place[i] != FREE:
                continue
            if SIDE_SLOPE.x0 < xy[i, 0] < SIDE_SLOPE.x1:
                velocity[i, 0] -= ROLL_DOWN * h
            speed = hypot(velocity[i, 0], velocity[i, 1])
            if speed > 0.0:
                left = max(speed - HALT * h, 0.0) / speed
                velocity[i] *= left
                xy[i] += velocity[i] * h
        for i in range(count):
            if place[i] != FREE:
                continue
            for j in range(i):
                if place[j] == FREE and _near(xy, i, j):
                    _part(xy, velocity, i, j)
        for i in range(count):
            if place[i] != FREE:
                continue
            if _push(xy, velocity, i, robot, motion, c, s, pull, h):
                at_rollers = i
            _keep_in(xy, velocity, i)
    return at_rollers


@njit
def _near(xy, i, j):
    """Whether two balls may overlap: few pairs do, and nothing more is worked out for the rest."""
    return abs(xy[i, 0] - xy[j, 0]) < BALL_DIAMETER and abs(xy[i, 1] - xy[j, 1]) < BALL_DIAMETER


@njit
def _part(xy, velocity, i, j):
    """Two balls that overlap are moved apart and share the speed between them."""
    dx, dy = xy[i, 0] - xy[j, 0], xy[i, 1] - xy[j, 1]
    apart = hypot(dx, dy)
    if apart >= BALL_DIAMETER or apart == 0.0:
        return
    dx, dy, half = dx / apart, dy / apart, 0.5 * (BALL_DIAMETER - apart)
    xy[i, 0] += half * dx
    xy[i, 1] += half * dy
    xy[j, 0] -= half * dx
    xy[j, 1] -= half * dy
    closing = (velocity[i, 0] - velocity[j, 0]) * dx + (velocity[i, 1] - velocity[j, 1]) * dy
    if closing < 0.0:
        share = 0.5 * (1.0 + BOUNCE) * closing
        velocity[i, 0] -= share * dx
        velocity[i, 1] -= share * dy
        velocity[j, 0] += share * dx
        velocity[j, 1] += share * dy


@njit
def _push(xy, velocity, i, robot, motion, c, s, pull, h):
    """A ball that the robot's square touches is pushed off; whether it is at the rollers."""
    rx, ry = xy[i, 0] - robot[0], xy[i, 1] - robot[1]
    ahead, aside, half = c * rx + s * ry, c * ry - s * rx, 0.5 * SIDE
    gap = ahead - half - RADIUS
    rollers = abs(aside) < ROLLERS and 0.0 < ahead and gap < TOUCH
    nx, ny = min(max(ahead, -half), half), min(max(aside, -half), half)
    dx, dy = ahead - nx, aside - ny
    far = hypot(dx, dy)
    if far == 0.0:  # its middle is inside: out by the nearest side
        if half - abs(ahead) < half - abs(aside):
            dx, far = (1.0 if ahead > 0.0 else -1.0), 0.0
        else:
            dy, far = (1.0 if aside > 0.0 else -1.0), 0.0
        length = 1.0
    else:
        length = far
    if far < RADIUS:
        dx, dy = dx / length, dy / length
        mx, my = c * dx - s * dy, s * dx + c * dy
        xy[i, 0] += (RADIUS - far) * mx
        xy[i, 1] += (RADIUS - far) * my
        wall_x = motion[0] - motion[2] * (xy[i, 1] - robot[1])
        wall_y = motion[1] + motion[2] * (xy[i, 0] - robot[0])
        closing = (velocity[i, 0] - wall_x) * mx + (velocity[i, 1] - wall_y) * my
        if closing < 0.0:
            velocity[i, 0] -= (1.0 + BOUNCE) * closing * mx
            velocity[i, 1] -= (1.0 + BOUNCE) * closing * my
    if rollers and pull > 0.0:  # the rollers keep it with them and draw it to their middle
        velocity[i, 0] = motion[0] - motion[2] * ry
        velocity[i, 1] = motion[1] + motion[2] * rx
        shift = min(1.0, 4.0 * h) * aside
        xy[i, 0] += s * shift
        xy[i, 1] -= c * shift
    return rollers


@njit
def _keep_in(xy, velocity, i):
    """Walls around Area 3 and the Storage Zone."""
    for axis in range(2):
        if xy[i, axis] < LOW[axis]:
            xy[i, axis] = LOW[axis]
            velocity[i, axis] = BOUNCE * abs(velocity[i, axis])
        elif xy[i, axis] > HIGH[axis]:
            xy[i, axis] = HIGH[axis]
            velocity[i, axis] = -BOUNCE * abs(velocity[i, axis])


def floor_under(xy: FloatArray) -> FloatArray:
    """Height of the floor under balls, all of them north of the water [m].

    Parameters
    ----------
    xy : ndarray, shape (n, 2)  [m, map]

    Returns
    -------
    ndarray, shape (n,)  [m above the ground under the stage]
    """
    uphill = np.clip(xy[:, 0] - SIDE_SLOPE.x0, 0.0, SIDE_SLOPE.x1 - SIDE_SLOPE.x0)
    return SIDE_SLOPE.height + SIDE_SLOPE.slope[0] * uphill


class Balls:
    """All balls of one team's Area 3 and Storage Zone.

    Parameters
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
    colours : sequence of str

    Attributes
    ----------
    xy, velocity : ndarray, shape (n, 2)  [m, m/s; map]
    place : ndarray of int64, shape (n,)
        `OUT`, `FREE` or `HELD`.
    colours : list of str
    """

    def __init__(self, xy: FloatArray, colours: list[str]) -> None:
        self.xy = np.array(xy, float).reshape(-1, 2)
        self.velocity = np.zeros_like(self.xy)
        self.place: NDArray[np.int64] = np.full(len(self.xy), FREE)
        self.colours = list(colours)

    def add(self, xy: tuple[float, float], velocity: tuple[float, float], colour: str) -> None:
        """One more ball [m, m/s; map]."""
        self.xy = np.vstack([self.xy, xy])
        self.velocity = np.vstack([self.velocity, velocity])
        self.place = np.append(self.place, FREE)
        self.colours.append(colour)

    @property
    def free(self) -> NDArray[np.int64]:
        """Numbers of the balls on the floor."""
        return np.flatnonzero(self.place == FREE)

    @property
    def held(self) -> int:
        """Number of the ball in the gripper, or -1."""
        places = self.place.tolist()
        return places.index(HELD) if HELD in places else -1
