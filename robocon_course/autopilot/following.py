"""From a path and a pose to the velocity of a robot that drives in any direction.

Pure pursuit steers a car. A swerve robot that keeps its heading has no front, but it has a
direction of travel, the *course* ψ, and that can be steered like a car:

    ψ' = v κ,        κ = pure_pursuit(path, (x, y, ψ), L),        L = k v + least

On a straight line and on a circle this leaves no error. What the lag of the modules, a bump or a
gust of noise leaves, two PID controllers take back: one across the path, one for the heading.

    velocity = v (cos ψ, sin ψ) + PID(cross-track error) · (left of the path)
    ω        = PID(heading error)

v comes from the path's speed profile, a little ahead: motors lag, and braking late costs more than
braking early.
"""

from __future__ import annotations

from math import atan2, cos, hypot, inf, isfinite, pi, remainder, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.route import Route
from robocon_course.geometry import TURN
from robocon_course.tracking import (
    PathPoint,
    PidGains,
    PidLimits,
    PidState,
    lookahead_distance,
    start_pose,
)
from robocon_course.tracking.polyline import look
from robocon_course.tracking.pursuit import bend


class FollowSettings(NamedTuple):
    """How the path is followed.

    Attributes
    ----------
    k, least : float  [s, m]
        Look-ahead L = k v + least.
    across, turning : PidGains
        Controllers of the cross-track error and of the heading.
    aside : float  [m/s]
        Fastest way back to the path.
    spin : float  [rad/s]
        Fastest turn back to the heading.
    creep : float  [m/s]
        Slowest speed on the way: at its ends a profile says 0.
    braking : float  [s]
        So far ahead the speed is looked up.
    near, homing : float  [m, 1/s]
        So near to the end the robot heads straight for it, as fast as homing times what is left.
    patience : int
        For so many steps without a pose the last velocity holds; then the robot stops.
    """

    k: float = 0.1
    least: float = 0.1
    across: PidGains = PidGains(3.0, 0.5)
    turning: PidGains = PidGains(3.0)
    aside: float = 0.5
    spin: float = 2.0
    creep: float = 0.05
    braking: float = 0.05
    near: float = 0.02
    homing: float = 3.0
    patience: int = 10


class Following(NamedTuple):
    """All that following a path remembers from step to step.

    Attributes
    ----------
    twist : tuple of 3 floats  [m/s, m/s, rad/s; map]
        What the robot is to do now.
    index : int
        Segment of the nearest point.
    course : float  [rad, map]
        Direction of travel.
    speed : float  [m/s]
        Along the path.
    across, turning : PidState
        The two controllers.
    left : float  [m]
        Way that is left.
    missed : int
        Steps in a row without a pose.
    rejected : int
        All steps without one.
    """

    twist: tuple[float, float, float]
    index: int
    course: float
    speed: float
    across: PidState
    turning: PidState
    left: float
    missed: int = 0
    rejected: int = 0

    @classmethod
    def begin(cls, route: Route) -> Following:
        """At the start of a path, at rest.

        Parameters
        ----------
        route : Route

        Returns
        -------
        Following
        """
        course = float(start_pose(route.xy)[2])
        return cls((0.0, 0.0, 0.0), 0, course, 0.0, PidState(), PidState(), float(route.along[-1]))


def follow_step(
    parts: Parts,
    state: Following,
    route: Route,
    pose: ArrayLike,
    dt: float,
    *,
    heading: float = 0.0,
    settings: FollowSettings = FollowSettings(),  # noqa: B008 - a NamedTuple cannot change
) -> Following:
    """One step along a path: the velocity stands in the new state.

    Parameters
    ----------
    parts : Parts
    state : Following
        Before; it is left as it is.
    route : Route
    pose : array_like, shape (3,)  [m, m, rad; map]
        Where it is not finite, the last twist holds for a while; the step is counted.
    dt : float  [s]
        Time since the step before.
    heading : float  [rad, map]
        Where to look.
    settings : FollowSettings

    Returns
    -------
    Following

    Raises
    ------
    ValueError
        Not three numbers, a dt that is not positive, or no heading. Never for a value of the pose.
    """
    pose = as_floats(pose, "pose", 3, finite=False)
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: expected seconds above 0, got {dt!r}")
    if not isfinite(heading):
        raise ValueError(f"heading: expected an angle in radians, got {heading!r}")
    x, y, theta = pose.tolist()
    if not (isfinite(x) and isfinite(y) and isfinite(theta)):
        return _missed(state, settings)
    lookahead = float(lookahead_distance(state.speed, settings.k, settings.least))
    foot, curvature, target = _looked(parts, route.xy, (x, y, state.course), state.index, lookahead)
    place = _place(route, foot.index, foot.share)
    left = float(route.along[-1]) - place
    speed = _speed_at(route, place + settings.braking * state.speed)
    speed = max(speed, min(settings.creep, settings.homing * left))
    course = _steered(state.course, speed * curvature * dt, target, x, y)
    off = _cross_track(route.xy, foot, x, y)
    bound = PidLimits(-settings.aside, settings.aside)
    across = parts.pid_step(state.across, 0.0, off, dt, settings.across, bound)
    wanted = theta + remainder(heading - theta, TURN)  # the shorter way round
    bound = PidLimits(-settings.spin, settings.spin)
    turning = parts.pid_step(state.turning, wanted, theta, dt, settings.turning, bound)
    vx, vy = _velocity(route, (x, y), left, (speed, course, across.output), settings)
    twist = (float(vx), float(vy), float(turning.output))
    if not all(map(isfinite, (*twist, course))):
        return _missed(state, settings)
    return Following(
        twist, foot.index, course, speed, across, turning, left, rejected=state.rejected
    )


LOOKS = ("nearest_point", "pure_pursuit")
"""Parts whose compiled kernel does the same in one step, if both are the course's."""


def _looked(
    parts: Parts, path: FloatArray, pose: tuple[float, float, float], index: int, lookahead: float
) -> tuple[PathPoint, float, tuple[float, float]]:
    """Nearest point of the path, and curvature and target of the pursuit."""
    x, y, course = pose
    if parts.are_the_courses(*LOOKS):
        (index, share, *foot, away), (_, _, *target), _ = look(path, x, y, index, lookahead)
        curvature = bend(target[0] - x, target[1] - y, course)
        return PathPoint(index, share, tuple(foot), away), curvature, tuple(target)
    foot = parts.nearest_point(path, (x, y), index, lookahead)
    pursuit = parts.pure_pursuit(path, pose, lookahead, foot.index)
    return foot, pursuit.curvature, pursuit.target


def _missed(state: Following, settings: FollowSettings) -> Following:
    """A step without a usable pose: the last twist for a while, then none."""
    missed = state.missed + 1
    twist = state.twist if missed <= settings.patience else (0.0, 0.0, 0.0)
    return state._replace(twist=twist, missed=missed, rejected=state.rejected + 1)


def _velocity(
    route: Route,
    place: tuple[float, float],
    left: float,
    motion: tuple[float, float, float],
    settings: FollowSettings,
) -> FloatArray | tuple[float, float]:
    """Along the course and back to the path; just before the end straight to it [m/s, map]."""
    if left <= settings.near:
        return settings.homing * (route.xy[-1] - place)
    speed, course, side = motion
    return (
        speed * cos(course) - side * sin(course),
        speed * sin(course) + side * cos(course),
    )


def _place(route: Route, index: int, share: float) -> float:
    """Way from the start to a point of the path [m]."""
    first, second = route.along[index], route.along[index + 1]
    return float(first + share * (second - first))


def _speed_at(route: Route, place: float) -> float:
    """Speed of the profile at a place; its square is a straight line between two points."""
    return sqrt(float(np.interp(place, route.along, route.speeds**2)))


def _steered(course: float, turn: float, target: tuple[float, float], x: float, y: float) -> float:
    """The course after a step. Where the target lies behind it, no car has to turn round."""
    bearing = atan2(target[1] - y, target[0] - x)
    if abs(remainder(bearing - course, TURN)) > pi / 2:
        return bearing
    return course + turn


def _cross_track(path: FloatArray, foot: PathPoint, x: float, y: float) -> float:
    """Distance from the path, positive to its left [m]."""
    (ax, ay), (bx, by) = path[foot.index : foot.index + 2].tolist()
    dx, dy = bx - ax, by - ay
    length = hypot(dx, dy)
    fx, fy = foot.xy
    return (dx * (y - fy) - dy * (x - fx)) / length if length > 0.0 else 0.0
