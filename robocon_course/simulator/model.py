"""One particular robot: what it really measures, weighs and grips, and the field it stands on."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats, frozen
from robocon_course.field import FLOOR_TABLE, OBSTACLES, SIZE
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import BATTERY, DEAD_WHEELS, MASS, MAX_SPEED, MODULES, SIDE
from robocon_course.simulator.numbers import require
from robocon_course.simulator.physics import Body, World

OUTWARDS = 1.0
"""How far the fences reach outwards for the physics [m]: nothing gets through."""


@dataclass(frozen=True, eq=False)
class RobotModel:
    """The true sizes of a robot; `robot` has the nominal ones, which autonomy believes in.

    ``dataclasses.replace`` makes another robot of it. Its dead wheels, for instance, are worn:
    ``replace(model, dead_wheels=replace(DEAD_WHEELS, radius=[0.0294, 0.0297, 0.0296]))``.

    Attributes
    ----------
    dead_wheels : TrackingWheels
        Where the dead wheels are, where they point, how large each is.
    modules : array_like, shape (4, 2)  [m, base]
        Where the drive wheels stand.
    side, mass : float  [m, kg]
        Of the body, a square plate; its moment of inertia is mass * side^2 / 6.
    friction : float
        Between drive wheel and floor. 0.6 holds a push of 5.9 m/s^2.
    wall_friction : float
        Between body and wall.
    steering_lag, steering_rate : float  [s, rad/s]
        A module nears its angle with this time constant, at most so fast.
    drive_lag, drive_acceleration : float  [s, m/s^2]
        A wheel nears its speed with this time constant, at most so hard.
    drive_force : float  [N]
        What a motor's torque pushes with at its wheel's rim, at most. A wheel grips with 36 N, so
        the motors of this robot spin their wheels; one that is weaker than the grip stalls.
    max_speed : float  [m/s]
        On a full battery.
    resistance : float  [ohm]
        Of the battery: under load its voltage falls, and the top speed with it. 0 turns that off.

    Raises
    ------
    ValueError
        Wrong shape, or a number that makes no robot.
    """

    dead_wheels: TrackingWheels = DEAD_WHEELS
    modules: ArrayLike = field(default_factory=lambda: MODULES)
    side: float = SIDE
    mass: float = MASS
    friction: float = 0.6
    wall_friction: float = 0.3
    steering_lag: float = 0.05
    steering_rate: float = 12.0
    drive_lag: float = 0.05
    drive_acceleration: float = 8.0
    drive_force: float = 60.0
    max_speed: float = MAX_SPEED
    resistance: float = 0.0

    def __post_init__(self) -> None:
        modules = frozen(as_floats(self.modules, "modules", 4, 2))
        object.__setattr__(self, "modules", modules)
        if not isinstance(self.dead_wheels, TrackingWheels):
            kind = type(self.dead_wheels).__name__
            raise ValueError(f"dead_wheels: expected TrackingWheels, got {kind}")
        above = ("side", "mass", "steering_rate", "drive_acceleration", "drive_force", "max_speed")
        require(self, *above)
        or_zero = ("friction", "wall_friction", "steering_lag", "drive_lag", "resistance")
        require(self, *or_zero, zero=True)
        if np.linalg.matrix_rank(modules - modules.mean(axis=0), tol=1e-6) < 2:
            raise ValueError("modules: they stand on one line; a robot needs a base to stand on")

    def body(self) -> Body:
        """The same in the form that the physics takes."""
        wheels = self.dead_wheels
        return Body(
            half=0.5 * self.side,
            mass=float(self.mass),
            inertia=self.mass * self.side**2 / 6.0,
            friction=float(self.friction),
            wall_friction=float(self.wall_friction),
            steering_lag=float(self.steering_lag),
            steering_rate=float(self.steering_rate),
            drive_lag=float(self.drive_lag),
            drive_acceleration=float(self.drive_acceleration),
            drive_force=float(self.drive_force),
            max_speed=float(self.max_speed),
            battery=BATTERY,
            resistance=float(self.resistance),
            modules=np.array(self.modules),
            plane=_plane_through(self.modules),
            dead_wheels=np.column_stack([wheels.positions, wheels.directions]),
        )


def _plane_through(modules: FloatArray) -> FloatArray:
    """The plane nearest to the heights at four places: (rise_x, rise_y, height at 0) of them.

    Around the mean of the places, slope and mean height are apart: the normal equations of the
    slope are two.
    """
    mean = modules.mean(axis=0)
    around = modules - mean
    slope = np.linalg.solve(around.T @ around, around.T)
    return np.vstack([slope, 0.25 - mean @ slope])


@cache
def game_field() -> World:
    """Floor and obstacles of the game field, as the physics takes them.

    The fences become four walls that reach outwards, and boxes that continue each other become
    one, so that the body slides along them without a joint to catch at.
    """
    low, high = -OUTWARDS, SIZE + OUTWARDS
    boxes = [(low, low, 0.0, high), (low, low, high, 0.0), (low, SIZE, high, high)]
    inside = [r[1:5] for r in OBSTACLES if r.x1 > 0.0 and r.y1 > 0.0 and r.y0 < SIZE]
    table = np.array(_joined(boxes + inside))
    return World(np.array(FLOOR_TABLE), table)


def _joined(boxes: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Boxes, those united that share two faces and touch."""
    boxes = list(boxes)
    for k, one in enumerate(boxes):
        for other in boxes[k + 1 :]:
            for a, b in ((0, 2), (1, 3)):  # along x, along y
                c = 1 - a
                meets = one[a] <= other[b] and other[a] <= one[b]
                if meets and (one[c], one[c + 2]) == (other[c], other[c + 2]):
                    union = list(one)
                    union[a], union[b] = min(one[a], other[a]), max(one[b], other[b])
                    rest = [box for box in boxes if box is not one and box is not other]
                    return _joined([*rest, tuple(union)])
    return boxes
