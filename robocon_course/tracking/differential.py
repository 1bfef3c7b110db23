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
from math import cos, exp, inf, pi, sin
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats

DT = 0.01
"""Period of the practice robot's loop [s]."""


@njit(cache=True)
def roll(x, y, theta, left, right, wheel_base):
    """The pose after both wheels have rolled so far, along an exact arc. It trusts its input.

    Parameters
    ----------
    x, y, theta : float  [m, m, rad; map]
    left, right : float  [m]
    wheel_base : float  [m]

    Returns
    -------
    tuple of 3 floats  [m, m, rad; map]
    """
    turn = (right - left) / wheel_base
    half = 0.5 * turn
    # An arc's chord points along the heading halfway and is shorter by sin(half) / half.
    chord = 0.5 * (left + right) * (sin(half) / half if half != 0.0 else 1.0)
    return x + chord * cos(theta + half), y + chord * sin(theta + half), theta + turn


@njit(cache=True)
def near(speed, command, dt, lag):
    """Speed of a wheel and what it rolled, one step nearer to its command. It trusts its input.

    Parameters
    ----------
    speed, command : float  [m/s]
    dt, lag : float  [s]

    Returns
    -------
    tuple of 2 floats  [m/s, m]
    """
    # v = c + (v0 - c) exp(-t / lag), and its integral over the step
    left_over = exp(-dt / lag)
    behind = speed - command
    return command + behind * left_over, command * dt + behind * lag * (1.0 - left_over)


@njit(cache=True)
def share_out(speed, turn, wheel_base, max_speed):
    """Speeds of both wheels for a motion; the turn has precedence. It trusts its input.

    Parameters
    ----------
    speed, turn : float  [m/s, rad/s]
    wheel_base, max_speed : float  [m, m/s]

    Returns
    -------
    tuple of 2 floats  [m/s]
    """
    turning = min(max(0.5 * wheel_base * turn, -max_speed), max_speed)
    room = max_speed - abs(turning)
    forward = min(max(speed, -room), room)
    return forward - turning, forward + turning


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
    moved = [
        near(float(v), float(c), dt, model.lag)
        for v, c in zip(state.speeds, state.waiting, strict=True)
    ]
    speeds, rolled = zip(*moved, strict=True)
    pose = roll(*map(float, state.pose), *rolled, model.wheel_base)
    return DifferentialState(
        pose=np.array(pose),
        speeds=np.array(speeds),
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
    return np.array(share_out(float(speed), float(turn), model.wheel_base, model.max_speed))
