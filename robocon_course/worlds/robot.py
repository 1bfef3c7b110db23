"""One student's robot: built from the drawing, but no robot is built exactly.

Radii of dead wheels differ by up to a per cent, their places by some millimetres. Autonomy starts
from the nominal sizes in `robot.DEAD_WHEELS`; calibration finds these.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS
from robocon_course.worlds.student import Student, generator

if TYPE_CHECKING:
    from robocon_course.simulator.model import RobotModel

LEFT, RIGHT, REAR = range(3)
"""Rows of the three dead wheels."""


def own_wheels(student: Student, *purpose: str) -> TrackingWheels:
    """The true sizes of one student's dead wheels.

    Parameters
    ----------
    student : int or str
        Student number.
    *purpose : str
        Other words give another robot.

    Returns
    -------
    TrackingWheels
        Radii 0.4 to 1 % off the drawing's, left and right wheel 1 to 4 mm further out or in, the
        rear wheel 2 to 6 mm.
    """
    rng = generator(student, "dead wheels", *purpose)
    while True:
        scale = 1.0 + rng.uniform(0.004, 0.010, 3) * rng.choice([-1.0, 1.0], 3)
        # One of the parallel wheels is too large and one too small: straight lines always bend.
        scale[RIGHT] = 1.0 - np.sign(scale[LEFT] - 1.0) * abs(scale[RIGHT] - 1.0)
        aside = rng.uniform(0.001, 0.004, 2) * rng.choice([-1.0, 1.0], 2)
        further = rng.uniform(0.002, 0.006) * rng.choice([-1.0, 1.0])
        # With the drawing's radius another offset comes out; neither it nor the sign reversed
        # may pass for the true one.
        nominal = (0.2745 + further) / scale[REAR] - 0.2745
        apart = min(abs(nominal - further), abs(nominal + further), abs(nominal))
        if apart > 0.0007:
            break
    positions = np.array(DEAD_WHEELS.positions)
    positions[[LEFT, RIGHT], 1] += aside
    positions[REAR, 0] -= further
    return TrackingWheels(
        np.round(positions, 5),
        DEAD_WHEELS.directions,
        np.round(DEAD_WHEELS.radius * scale, 7),
        DEAD_WHEELS.ticks_per_turn,
    )


def own_robot(student: Student) -> RobotModel:
    """One student's robot for the simulator.

    Parameters
    ----------
    student : int or str
        Student number.

    Returns
    -------
    RobotModel
    """
    from robocon_course.simulator.model import RobotModel  # the exercises need no physics

    return RobotModel(dead_wheels=own_wheels(student))
