"""What is really so: the one thing that autonomy never sees."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robocon_course._arrays import FloatArray
from robocon_course.simulator import inertial
from robocon_course.simulator.physics import Body, State


class Truth(NamedTuple):
    """What is really so; for graders and plots, never for autonomy.

    Attributes
    ----------
    time : float  [s]
    pose : ndarray, shape (3,)  [m, m, rad; map]
        Theta is not wrapped.
    twist : ndarray, shape (3,)  [m/s, m/s, rad/s; base]
    climb : float  [m/s]
        Velocity upwards.
    attitude : ndarray, shape (4,)
        Unit quaternion (w, x, y, z), base -> map.
    height : float  [m]
        Of the floor under the robot's middle, above the ground under the stage.
    travel : ndarray, shape (n,)  [m]
        What each dead wheel rolled since the start.
    module_speeds, module_angles : ndarray, shape (4,)  [m/s, rad]
    slip : ndarray, shape (4,)  [m/s]
        Speed of each drive wheel's tread over the floor.
    battery : float  [V]
    contact : bool
        Whether the body touches something.
    contacts : int
        How often it began to.
    """

    time: float
    pose: FloatArray
    twist: FloatArray
    climb: float
    attitude: FloatArray
    height: float
    travel: FloatArray
    module_speeds: FloatArray
    module_angles: FloatArray
    slip: FloatArray
    battery: float
    contact: bool
    contacts: int


def truth_of(state: State, body: Body, time: float) -> Truth:
    """A copy of all that matters of a state.

    Parameters
    ----------
    state : State
    body : Body
    time : float  [s]

    Returns
    -------
    Truth
    """
    theta, (vx, vy, omega, climb) = state.pose[2], state.velocity
    c, s = np.cos(theta), np.sin(theta)
    attitude = np.empty(4)
    inertial.attitude(theta, state.floor[0], state.floor[1], attitude)
    arms = body.modules @ np.array([(c, s), (-s, c)])
    over = state.velocity[:2] + omega * arms[:, ::-1] * (-1.0, 1.0)  # the floor, each wheel's
    return Truth(
        time=time,
        pose=state.pose.copy(),
        twist=np.array([c * vx + s * vy, c * vy - s * vx, omega]),
        climb=float(climb),
        attitude=attitude,
        height=float(state.floor[2]),
        travel=state.travel.copy(),
        module_speeds=state.speeds.copy(),
        module_angles=state.angles.copy(),
        slip=np.hypot(*(state.wheels[:, 2:4] - over).T),
        battery=float(state.battery[0]),
        contact=bool(state.contact[0]),
        contacts=int(state.contact[1]),
    )
