"""The robot drives to a place by itself: what it sees goes in, what its modules do comes out."""

from __future__ import annotations

from math import hypot, inf, isfinite, nan

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course.autopilot.following import Following, FollowSettings, follow_step
from robocon_course.autopilot.modules import hold, module_command
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.route import Route
from robocon_course.autopilot.sensing import Reckoning, lidar_y, reckon
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import Command, Observation

NEAR_GOAL = 0.2
"""So near to the goal the robot has arrived [m]."""
END = 0.03
"""The path is driven to its end: so much may be left of it [m]."""
STANDS = 0.02
"""Slower than this by its own wheels the robot stands [m/s]: two counts in 20 ms make 6 mm/s."""


class Pilot:
    """Drives the robot along a route, by its own dead wheels and gyroscope.

    Parameters
    ----------
    parts : Parts
    route : Route
    start : array_like, shape (3,)  [m, m, rad; map]
        Where it stands; the heading is kept all the way.
    wheels : TrackingWheels
        What it believes of its dead wheels.
    rest : float  [s]
        It stands so long before it goes: the gyroscope's bias is learnt then.
    settings : FollowSettings

    Attributes
    ----------
    reckoning : Reckoning
        Where it believes to be.
    following : Following
        How far it is on its path.
    seen : Observation or None
        The last observation.

    Raises
    ------
    ValueError
        A start that is no pose.
    """

    def __init__(
        self,
        parts: Parts,
        route: Route,
        start: ArrayLike,
        wheels: TrackingWheels,
        *,
        rest: float = 3.0,
        settings: FollowSettings = FollowSettings(),  # noqa: B008 - a NamedTuple cannot change
    ) -> None:
        self.parts, self.route, self.wheels = parts, route, wheels
        self.reckoning, self.following = Reckoning.at(start), Following.begin(route)
        self.seen: Observation | None = None
        self._heading = float(self.reckoning.pose[2])
        self._rest, self._settings = rest, settings
        self._waited, self._dt, self._speed = 0.0, nan, inf

    def tick(self, observation: Observation) -> Command:
        """What to do after one more observation.

        Parameters
        ----------
        observation : Observation
            One that cannot be used is counted. The last velocity holds for a while; then the robot
            stops.

        Returns
        -------
        Command

        Raises
        ------
        ValueError
            Readings of another shape. Never for a value: this runs in a control loop.
        """
        self.seen, last = observation, self.reckoning
        self.reckoning = now = reckon(self.parts, last, observation, self.wheels)
        if now.fresh and isfinite(now.dt):
            self._dt = now.dt
            self._waited += now.dt
            self._speed = float(hypot(*(now.pose - last.pose)[:2])) / now.dt
        if not (isfinite(self._dt) and self._waited >= self._rest):
            return hold(observation.module_angles)
        pose = now.pose if now.fresh else np.full(3, nan)
        self.following = follow_step(
            self.parts, self.following, self.route, pose, self._dt,
            heading=self._heading, settings=self._settings,
        )  # fmt: skip
        twist, angles = self.following.twist, observation.module_angles
        return module_command(self.parts, twist, now.pose[2], angles, dt=self._dt)

    @property
    def rejected(self) -> int:
        """How many readings could not be used."""
        return self.reckoning.rejected

    @property
    def away(self) -> float:
        """How far it believes to be from the goal [m]."""
        return float(hypot(*(self.reckoning.pose[:2] - self.route.xy[-1])))

    @property
    def arrived(self) -> bool:
        """Whether it stands at the goal, and the LiDAR agrees where that lies in Area 3."""
        resting = self.following.left <= END and self._speed < STANDS
        if self.seen is None or not resting or self.away > NEAR_GOAL:
            return False
        if self.route.xy[-1, 1] <= field.AREA_3_LINE:
            return True
        return lidar_y(self.seen, self.reckoning.pose[2]) > field.AREA_3_LINE
