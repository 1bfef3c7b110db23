"""A robot to practise on: two driven wheels, each late, each counted.

    dv/dt = (command - v) / lag        a wheel nears its speed; the command comes one step late
    forward = (left + right) / 2,  turn = (right - left) / wheel_base

With a lag of 70 ms and a loop of 10 ms the heading under a P controller swings with a period of
210 ms at the gain where it never stops: that of the robot of the source.

Source: path tracking with odometry feedback by PID (in Indonesian), Politeknik Elektronika Negeri
Surabaya: differential drive, a loop of 10 ms, P_cr = 21 x 10 ms.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import compose, se2_exp


@dataclass(frozen=True)
class DifferentialModel:
    """Sizes of the robot.

    Attributes
    ----------
    wheel_base : float  [m]
        Between the two wheels.
    radius : float  [m]
        Of each wheel.
    ticks_per_turn : int
        Counts per turn of a wheel.
    lag : float  [s]
        Time constant of the wheels' speed.
    max_speed : float  [m/s]
        Of a wheel.

    Raises
    ------
    ValueError
        A size that is not positive.
    """

    wheel_base: float = 0.3
    radius: float = 0.03
    ticks_per_turn: int = 2000
    lag: float = 0.07
    max_speed: float = 0.8

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 < value < inf:
                raise ValueError(f"{name}: must be positive, got {value!r}")

    @property
    def metres_per_tick(self) -> float:
        """What one count is worth  [m]."""
        return 2.0 * pi * self.radius / self.ticks_per_turn

    def ticks(self, state: DifferentialState) -> NDArray[np.int64]:
        """What the encoders of both wheels have counted since the start.

        Parameters
        ----------
        state : DifferentialState

        Returns
        -------
        ndarray of int64, shape (2,)
            Left, right.
        """
        return np.floor(state.travel / self.metres_per_tick).astype(np.int64)


class DifferentialState(NamedTuple):
    """What the robot is doing.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    speeds : ndarray, shape (2,)  [m/s]
        Of the left and right wheel.
    travel : ndarray, shape (2,)  [m]
        What each has rolled.
    waiting : ndarray, shape (2,)  [m/s]
        The command that the next step carries out.
    """

    pose: FloatArray
    speeds: FloatArray
    travel: FloatArray
    waiting: FloatArray

    @classmethod
    def at_rest(cls, pose: ArrayLike = (0.0, 0.0, 0.0)) -> DifferentialState:
        """The robot standing somewhere.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]

        Returns
        -------
        DifferentialState

        Raises
        ------
        ValueError
            Not a pose.
        """
        return cls(as_floats(pose, "pose", 3).copy(), *np.zeros((3, 2)))


def differential_step(
    state: DifferentialState,
    command: ArrayLike,
    dt: float,
    model: DifferentialModel = DifferentialModel(),
) -> DifferentialState:
    """The robot one step later.

    Parameters
    ----------
    state : DifferentialState
    command : array_like, shape (2,)  [m/s]
        Speed for the left and right wheel: carried out in the next step, as far as they can.
    dt : float  [s]
    model : DifferentialModel

    Returns
    -------
    DifferentialState

    Raises
    ------
    ValueError
        A command that is not two finite numbers, or dt not positive.

    Examples
    --------
    >>> state = DifferentialState.at_rest()
    >>> for _ in range(101):
    ...     state = differential_step(state, [0.25, 0.25], 0.01)
    >>> state.pose.round(3).tolist(), DifferentialModel().ticks(state).tolist()
    ([0.233, 0.0, 0.0], [2466, 2466])
    """
    command = as_floats(command, "command", 2)
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    # v = c + (v0 - c) exp(-t / lag), and its integral over the step
    left_over = exp(-dt / model.lag)
    behind = state.speeds - state.waiting
    rolled = state.waiting * dt + behind * model.lag * (1.0 - left_over)
    motion = np.array([rolled.mean(), 0.0, (rolled[1] - rolled[0]) / model.wheel_base])
    return DifferentialState(
        pose=compose(state.pose, se2_exp(motion)),
        speeds=state.waiting + behind * left_over,
        travel=state.travel + rolled,
        waiting=command.clip(-model.max_speed, model.max_speed),
    )


def wheel_speeds(
    speed: float,
    turn: float,
    model: DifferentialModel = DifferentialModel(),
) -> FloatArray:
    """Speeds of both wheels for a motion of the robot, slowed together to what they can.

    Parameters
    ----------
    speed : float  [m/s]
        Forwards.
    turn : float  [rad/s]
        To the left.
    model : DifferentialModel

    Returns
    -------
    ndarray, shape (2,)  [m/s]
        Left, right. The turn has precedence: too fast for both, it is the speed that gives way.

    Examples
    --------
    >>> wheel_speeds(0.7, 2.0).round(3).tolist()
    [0.2, 0.8]
    """
    turning = 0.5 * model.wheel_base * turn
    turning = min(max(turning, -model.max_speed), model.max_speed)
    room = model.max_speed - abs(turning)
    forward = min(max(speed, -room), room)
    return np.array([forward - turning, forward + turning])
