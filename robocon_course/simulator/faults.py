"""What goes wrong in a match: faults that last, and faults that happen once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import cos, sin
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.mission import is_full
from robocon_course.simulator.sensors import SensorModel

if TYPE_CHECKING:
    from robocon_course.simulator.match import Match

KINDS = ("dark", "lidar", "slip", "drop", "filled", "kidnap", "frozen")


class Fault(NamedTuple):
    """Something that goes wrong.

    Attributes
    ----------
    kind : str
        ``"dark"``: the camera sees black. ``"lidar"``: no LiDAR answers. ``"slip"``: a dead wheel
        slips. ``"drop"``: the ball is lost from the gripper. ``"filled"``: the other team fills the
        silo that the robot is about to reach. ``"kidnap"``: somebody puts the robot elsewhere.
        ``"frozen"``: every read gives the same observation.
    start : float  [s]
        Of the match.
    duration : float  [s]
        Where it lasts.
    """

    kind: str
    start: float
    duration: float = 5.0


def drop(match: Match, pose: FloatArray) -> bool:
    """The held ball falls out to the front left; False while none is held.

    Parameters
    ----------
    match : Match
    pose : ndarray, shape (3,)  [m, m, rad; map]
    """
    if match.balls.held < 0:
        return False
    c, s = cos(pose[2] + 0.6), sin(pose[2] + 0.6)
    match.put_down(match.balls.held, (pose[0] + 0.6 * c, pose[1] + 0.6 * s), (0.5 * c, 0.5 * s))
    return True


def fill(match: Match, pose: FloatArray) -> bool:
    """The other team fills the silo ahead; False until a robot with a ball is near it.

    Parameters
    ----------
    match : Match
    pose : ndarray, shape (3,)  [m, m, rad; map]
    """
    if match.balls.held < 0 or pose[0] < 5.0:
        return False
    silo = int(np.argmin([abs(pose[1] - y) for _, y in field.SILOS]))
    while not is_full(match.referee.fillings[silo]) and not match.over:
        match.referee.store(match.clock, "theirs", silo)
    return True


def kidnap(match: Match, pose: FloatArray) -> bool:
    """Somebody puts the robot elsewhere in Area 3; False until it drives there along an axis.

    Parameters
    ----------
    match : Match
    pose : ndarray, shape (3,)  [m, m, rad; map]
    """
    if pose[1] < 8.6 or not 3.3 < pose[0] < 5.4 or abs(sin(2.0 * pose[2])) > 0.1:
        return False
    aside = 1.1 if pose[1] < 10.0 else -1.1
    match.robot.place((max(pose[0] - 0.6, 3.4), pose[1] + aside, pose[2]))
    return True


HAPPENS: dict[str, Callable[[Match, FloatArray], bool]] = {
    "drop": drop,
    "filled": fill,
    "kidnap": kidnap,
}
"""Faults that happen once, as soon as they can."""


def slipping(sensors: SensorModel, faults: Sequence[Fault], begin: float) -> SensorModel:
    """Sensors of which a dead wheel does not turn with the floor for a while.

    Parameters
    ----------
    sensors : SensorModel
    faults : sequence of Fault
    begin : float  [s]
        Of the match, on the robot's clock.

    Returns
    -------
    SensorModel
    """
    gaps = tuple(
        (0, begin + f.start, begin + f.start + min(f.duration, 0.3))
        for f in faults
        if f.kind == "slip"
    )
    return replace(sensors, encoder_gaps=(*sensors.encoder_gaps, *gaps)) if gaps else sensors
