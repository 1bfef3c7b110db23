"""Odometry on a running robot: one pose from the last one and a handful of counts.

The counts c of one sample move the base by

    (forward, left, turn) = A^-1 (2πr / counts_per_turn) c        by wheels alone
    (forward, left)       = the same with the turn known          by wheels and gyroscope

and both are linear: what one count of each wheel does is worked out once.
"""

from __future__ import annotations

from functools import cached_property
from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import wrap_angle
from robocon_course.odometry.motion import START, odometry_update
from robocon_course.odometry.wheels import TrackingWheels


class OdometryState(NamedTuple):
    """All that odometry remembers between samples.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    yaw : float or None  [rad]
        The gyroscope's heading at the last sample, if it had one.
    """

    pose: FloatArray
    yaw: float | None


class Odometry:
    """Dead reckoning for a control loop: remembers the pose, nothing else.

    Parameters
    ----------
    wheels : TrackingWheels
    start : array_like, shape (3,)  [m, m, rad; map]
    yaw : float, optional  [rad]
        The gyroscope's heading at the start, in its own zero.

    Attributes
    ----------
    rejected : int
        Samples whose counts were not finite and were left out.
    """

    def __init__(
        self, wheels: TrackingWheels, start: ArrayLike = START, yaw: float | None = None
    ) -> None:
        self._wheels = wheels
        self.rejected = 0
        self.reset(start, yaw)

    def reset(self, pose: ArrayLike, yaw: float | None = None) -> None:
        """Stand at another pose, as after a look at the walls.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]
        yaw : float, optional  [rad]
            The gyroscope's heading there.
        """
        self.state = OdometryState(pose, yaw)

    def update(self, ticks: ArrayLike, yaw: float | None = None) -> FloatArray:
        """The pose after one more sample.

        Parameters
        ----------
        ticks : array_like, shape (number of wheels,)
            Counts since the sample before. Where one is not finite, the sample is counted in
            ``rejected``, and only the gyroscope moves the pose.
        yaw : float, optional  [rad]
            A gyroscope's heading. Where the sample before had one too, their difference is the
            turn, in place of the wheels' own. NaN is as good as None.

        Returns
        -------
        ndarray, shape (3,)  [m, m, rad; map]

        Raises
        ------
        ValueError
            Another number of ticks; or no gyroscope and wheels that cannot feel a turn.
        """
        ticks = as_floats(ticks, "ticks", len(self._wheels.radius), finite=False)
        last, self._yaw = self._yaw, _heading(yaw)
        if last is None or self._yaw is None:
            gains, turn = self._by_wheels, 0.0
        else:
            gains, turn = self._by_gyroscope, float(wrap_angle(self._yaw - last))
        if not odometry_update(self._pose, ticks, *gains, turn):
            self.rejected += 1
            self._pose[2] += turn
        return self._pose.copy()

    @cached_property
    def _by_wheels(self) -> tuple[FloatArray, FloatArray]:
        return self._wheels.solver * self._wheels.metres_per_tick, np.zeros(3)

    @cached_property
    def _by_gyroscope(self) -> tuple[FloatArray, FloatArray]:
        return self._wheels.per_tick, self._wheels.per_turn

    @property
    def pose(self) -> FloatArray:
        """Where the base is, shape (3,) [m, m, rad; map]; theta is not wrapped."""
        return self._pose.copy()

    @property
    def state(self) -> OdometryState:
        """What to keep and give back later."""
        return OdometryState(self.pose, self._yaw)

    @state.setter
    def state(self, state: OdometryState) -> None:
        self._pose = as_floats(state[0], "pose", 3).copy()
        self._yaw = _heading(state[1])


def _heading(yaw: float | None) -> float | None:
    return float(yaw) if yaw is not None and isfinite(yaw) else None
