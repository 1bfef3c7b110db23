"""The robot drives to a place by itself: what it sees goes in, what its modules do comes out."""

from __future__ import annotations

from math import hypot

from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course.autopilot.following import Following, FollowSettings, follow_step
from robocon_course.autopilot.modules import module_command
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.route import Route
from robocon_course.autopilot.sensing import Reckoning, lidar_y, reckon
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import Command, Observation

NEAR_GOAL = 0.2
"""So near to the goal the robot has arrived [m]."""
STANDING = 0.03
"""The path is driven to its end: so much may be left of it [m]."""


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
        self._begin: float | None = None

    def tick(self, observation: Observation) -> Command:
        """What to do after one more observation.

        Parameters
        ----------
        observation : Observation

        Returns
        -------
        Command
        """
        last, self.seen = self.seen, observation
        self.reckoning = reckon(self.parts, self.reckoning, observation, self.wheels)
        if self._begin is None:
            self._begin = observation.time
        dt = observation.time - last.time if last else 0.0
        if observation.time - self._begin < self._rest or not dt > 0.0:
            return Command.stop(observation.module_angles)
        pose = self.reckoning.pose
        self.following = follow_step(
            self.parts, self.following, self.route, pose, dt,
            heading=self._heading, settings=self._settings,
        )  # fmt: skip
        return module_command(
            self.parts, self.following.twist, pose[2], observation.module_angles, dt=dt
        )

    @property
    def away(self) -> float:
        """How far it believes to be from the goal [m]."""
        return float(hypot(*(self.reckoning.pose[:2] - self.route.xy[-1])))

    @property
    def arrived(self) -> bool:
        """Whether it is at the goal, and the LiDAR agrees where that lies in Area 3."""
        if self.seen is None or self.away > NEAR_GOAL or self.following.left > STANDING:
            return False
        if self.route.xy[-1, 1] <= field.AREA_3_LINE:
            return True
        return lidar_y(self.seen, self.reckoning.pose[2]) > field.AREA_3_LINE
