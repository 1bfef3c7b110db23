"""The practice robot with its own odometry, to be driven by hand or by a loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray
from robocon_course.tracking.differential import (
    DT,
    DifferentialModel,
    DifferentialState,
    differential_step,
    roll,
    wheel_speeds,
)


class Cart:
    """A differential robot and the pose that it believes in.

    Parameters
    ----------
    model : DifferentialModel
    pose : array_like, shape (3,)  [m, m, rad; map]
        Where it stands at first, and knows so.

    Attributes
    ----------
    model : DifferentialModel
    state : DifferentialState
        What it really does.
    pose : ndarray, shape (3,)  [m, m, rad; map]
        By its own odometry, from whole counts of its encoders. Give both back, and it goes on.

    Raises
    ------
    ValueError
        Not a pose.

    Examples
    --------
    >>> cart = Cart()
    >>> for _ in range(100):
    ...     cart.drive(0.25, 0.0)
    >>> cart.pose.round(3).tolist()
    [0.23, 0.0, 0.0]
    """

    def __init__(
        self,
        model: DifferentialModel = DifferentialModel(),  # noqa: B008 - frozen
        pose: ArrayLike = (0.0, 0.0, 0.0),
    ) -> None:
        self.model = model
        self.state = DifferentialState.at_rest(pose)
        self.pose: FloatArray = self.state.pose

    def drive(self, speed: float, turn: float) -> None:
        """Order a motion, and let 10 ms pass.

        Parameters
        ----------
        speed : float  [m/s]
            Forwards.
        turn : float  [rad/s]
            To the left.
        """
        before = self.model.ticks(self.state)
        command = wheel_speeds(speed, turn, self.model)
        self.state = differential_step(self.state, command, DT, self.model)
        rolled = self.model.metres_per_tick * (self.model.ticks(self.state) - before)
        self.pose = np.array(roll(*self.pose.tolist(), *rolled.tolist(), self.model.wheel_base))
