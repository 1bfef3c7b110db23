"""From a velocity on the field to what the four modules are told."""

from __future__ import annotations

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import swerve
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.autopilot.parts import Parts
from robocon_course.geometry import TURN
from robocon_course.robot import MAX_SPEED, MODULES, Command
from robocon_course.swerve.chain import field_targets

CHAIN = ("field_to_robot", "discretize", "module_targets", "limit_speeds", "shortest_turn")
"""The parts that `field_targets` does in one compiled step."""


def module_command(
    parts: Parts,
    twist: ArrayLike,
    theta: float,
    angles: ArrayLike,
    *,
    dt: float,
    max_speed: float = MAX_SPEED,
) -> Command:
    """The robot's way from a velocity on the field to what its modules are told.

    Turned into the robot's axes, aimed before the turn, shared out to the modules, slowed to what
    the wheels reach, steered the shorter way, and held back where a wheel still turns.

    A sensor's bad value never stops the loop: where the order, the heading or an angle is not
    finite, or the order would turn the robot by a whole turn within ``dt``, the wheels stand still
    and the modules keep their angles. Whoever counts such steps looks for speeds that are all 0
    though the order is not.

    Parameters
    ----------
    parts : Parts
    twist : array_like, shape (3,)  [m/s, m/s, rad/s; map]
    theta : float  [rad, map]
        Heading of the robot.
    angles : array_like, shape (4,)  [rad, base]
        Angles the modules have now.
    dt : float  [s]
        How long the command will hold.
    max_speed : float  [m/s]

    Returns
    -------
    Command
        Held, a module whose angle is not finite is sent to 0.

    Raises
    ------
    ValueError
        Wrong shapes, a dt that is not positive, or what a part refuses or gets wrong.
    """
    twist = as_floats(twist, "twist", 3, finite=False)
    theta = float(as_floats(theta, "theta", finite=False))
    angles = as_floats(angles, "angles", len(MODULES), finite=False)
    if not 0.0 < dt < np.inf:
        raise ValueError(f"dt: expected seconds above 0, got {dt}")
    if not _can_be_driven(twist, theta, angles, dt):
        return hold(angles)
    if parts.are_the_courses(*CHAIN):
        return Command(*field_targets(MODULES, twist, theta, angles, dt, max_speed))
    body = np.asarray(parts.field_to_robot(twist, theta), float)
    body = np.asarray(parts.discretize(body, dt), float)
    targets = _as_arrays(parts.module_targets(MODULES, body, angles))
    targets = _as_arrays(parts.limit_speeds(targets, max_speed))
    return Command(*swerve.cosine_compensation(parts.shortest_turn(targets, angles), angles))


def hold(angles: ArrayLike) -> Command:
    """Wheels that stand, and modules that stay where they are.

    Parameters
    ----------
    angles : array_like, shape (4,)  [rad, base]
        Angles the modules have now; one that is not finite is sent to 0.

    Returns
    -------
    Command

    Raises
    ------
    ValueError
        Another shape.
    """
    angles = as_floats(angles, "angles", len(MODULES), finite=False)
    return Command.stop(np.where(np.isfinite(angles), angles, 0.0))


def _can_be_driven(twist: FloatArray, theta: float, angles: FloatArray, dt: float) -> bool:
    """Whether an order and the readings beside it make sense."""
    vx, vy, omega = twist.tolist()
    square = vx * vx + vy * vy + omega * omega  # the modules' speeds are roots of such sums
    finite = isfinite(square) and isfinite(theta) and all(map(isfinite, angles.tolist()))
    return finite and abs(omega * dt) < TURN


def _as_arrays(targets: swerve.ModuleTargets) -> swerve.ModuleTargets:
    """One part may answer with lists, the next one count on arrays."""
    return swerve.ModuleTargets(*(np.asarray(values, float) for values in targets))
