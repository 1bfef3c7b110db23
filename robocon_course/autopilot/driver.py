"""Brings the robot to a pose: a path if it is far, straight at it if it is near."""

from __future__ import annotations

from functools import cache
from math import hypot, isfinite, nan, remainder

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.autopilot.following import Following, FollowSettings, follow_step
from robocon_course.autopilot.modules import hold, module_command
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.route import DriveLimits, Route, plan_route
from robocon_course.autopilot.sensing import Reckoning
from robocon_course.geometry import TURN, distance_along
from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError
from robocon_course.robot import Command

Target = tuple[float, float, float]
NEAR = 0.03
"""So near to its target the robot holds it, without a path [m]."""
MOVED = 0.015
"""A target that moves farther than this gets a new path [m]."""
TURN_ROOM = 0.475
"""From the middle to a wall: nearer the robot does not turn [m]."""
SOUTH = field.STORAGE_ZONE.y0
"""Edge of Storage Zone and Area 3 towards Area 2 [m]."""
DRIVES = FollowSettings(spin=3.0)


class Driver:
    """Drives to one target after the other.

    Parameters
    ----------
    parts : Parts
    heading : float  [rad, map]
        Kept until there is room to turn.

    Attributes
    ----------
    plan : ndarray, shape (n, 2)  [m, map]
        The path it drives.
    ordered : tuple of 2 floats  [m/s, map]
        How fast the robot was told to go.
    trouble : str
        Why there is no way to the newest target, the tick in which that was found; else empty.
    """

    def __init__(self, parts: Parts, heading: float) -> None:
        self.parts, self.heading = parts, heading
        self.plan: FloatArray = np.empty((0, 2))
        self.ordered, self.trouble = (0.0, 0.0), ""
        self.forget()

    def forget(self) -> None:
        """The next target gets a path of its own, wherever it lies."""
        self._route: Route | None = None
        self._target: Target | None = None
        self._following: Following | None = None

    def drive(
        self, target: Target | None, limits: DriveLimits, now: Reckoning, angles: ArrayLike
    ) -> Command:
        """The command that leads to a target.

        Parameters
        ----------
        target : tuple of 3 floats or None  [m, m, rad; map]
            None: stand.
        limits : DriveLimits
        now : Reckoning
            Where the robot is.
        angles : array_like, shape (4,)  [rad, base]
            Where its modules point.

        Returns
        -------
        Command
        """
        self.trouble = ""
        if target is None or not isfinite(now.dt):
            self.ordered = (0.0, 0.0)
            return hold(angles)
        self._aim(target, limits, now.pose)
        if self._following is None or _gap(now.pose, target) < NEAR:
            twist = self._homing(target, now.pose) if now.fresh else (0.0, 0.0, 0.0)
        else:
            pose = now.pose if now.fresh else np.full(3, nan)
            self._following = follow_step(
                self.parts, self._following, self._route, pose, now.dt,
                heading=self._turned(target[2], now.pose), settings=DRIVES,
            )  # fmt: skip
            twist = self._following.twist
        self.ordered = twist[0], twist[1]
        return module_command(self.parts, twist, now.pose[2], angles, dt=now.dt)

    def _aim(self, target: Target, limits: DriveLimits, pose: FloatArray) -> None:
        """A path to the target, if it is another one."""
        if self._target is not None and _gap(self._target, target) < MOVED:
            return
        self._target = target
        self._route = self._route_to(target[:2], limits, pose[:2])
        self._following = None if self._route is None else Following.begin(self._route)
        self.plan = np.empty((0, 2)) if self._route is None else self._route.xy

    def _route_to(
        self, goal: tuple[float, float], limits: DriveLimits, start: FloatArray
    ) -> Route | None:
        """Straight through Area 3 and the Storage Zone; else by a search on the map."""
        if min(start[1], goal[1]) < field.AREA_3_LINE - 0.1:
            try:
                grid = _grid("astar" in self.parts.mine)
                return plan_route(self.parts, grid, start, goal, limits=limits)
            except NoPathError as error:
                self.trouble = str(error)
        far = _gap(start, goal)
        if far < 0.5 * NEAR:
            return None
        xy = np.linspace(start, goal, max(3, round(far / 0.1) + 1))
        return Route(xy, distance_along(xy), self._speeds(xy, limits))

    def _speeds(self, xy: FloatArray, limits: DriveLimits) -> FloatArray:
        """The profile of a straight way, on which the robot is moving already and may not stop.

        A profile begins and ends at rest. So the way is drawn longer: back to where the robot
        would have set off to be as fast as it is now, and on to where it could stop.
        """
        way = (xy[-1] - xy[0]) / _gap(xy[0], xy[-1])
        now = min(max(float(way @ self.ordered), 0.0), limits.speed)
        before, after = 0.5 * now**2 / limits.accel, 0.5 * limits.arrive**2 / limits.accel
        begin = [xy[0] - before * way] if before > 0.0 else []
        end = [xy[-1] + after * way] if after > 0.0 else []
        longer = np.array([*begin, *xy, *end])
        speeds = self.parts.speed_profile(longer, limits.speed, limits.accel, limits.lateral)
        return np.asarray(speeds, float)[len(begin) : len(begin) + len(xy)]

    def _homing(self, target: Target, pose: FloatArray) -> Target:
        """Straight to a target that is all but reached [m/s, m/s, rad/s; map]."""
        x, y, theta = pose.tolist()
        vx, vy = 3.0 * (target[0] - x), 3.0 * (target[1] - y)
        speed = hypot(vx, vy)
        if speed > 0.3:
            vx, vy = 0.3 * vx / speed, 0.3 * vy / speed
        off = remainder(self._turned(target[2], pose) - theta, TURN)
        return float(vx), float(vy), float(min(max(3.0 * off, -2.0), 2.0))

    def _turned(self, wanted: float, pose: FloatArray) -> float:
        """The heading to hold: the wanted one where there is room to turn, else the last."""
        x, y, theta = pose.tolist()
        room = min(x, field.EDGE - x, field.SIZE - y, y - SOUTH if y > SOUTH else y)
        if room > TURN_ROOM or abs(remainder(wanted - theta, TURN)) < 0.1:
            self.heading = wanted
        return self.heading


def _gap(one: ArrayLike, other: ArrayLike) -> float:
    """Distance of two places [m]."""
    return hypot(one[0] - other[0], one[1] - other[1])


@cache
def _grid(coarse: bool) -> GridMap:
    """The field to plan on: coarser where the search is a student's own, in plain Python."""
    return field.obstacle_map(0.05 if coarse else 0.01)
