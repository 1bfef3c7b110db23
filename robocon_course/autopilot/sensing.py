"""From what the sensors say to where the robot is: whole logs, and one reading after the other."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, nan, pi, radians, remainder, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course import field, imu, odometry
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.autopilot.parts import Parts
from robocon_course.geometry import TURN
from robocon_course.robot import DEAD_WHEELS, LIDARS, Observation

COUNTER_BITS = 32
"""Counters are compared in so many bits: no wheel turns by half of that between two readings."""
HEADINGS = ("wheels", "gyro", "fused")
LIDAR_CONE = radians(20.0)
"""A beam that meets a wall more slantingly is no measure of the distance from it."""


def attitude_angles(
    parts: Parts,
    still: ArrayLike,
    rests: ArrayLike,
    gyro: ArrayLike,
    accel: ArrayLike,
    *,
    dt: float,
    gains: imu.MahonyGains = imu.MahonyGains(),  # noqa: B008 - a NamedTuple cannot change
) -> FloatArray:
    """The robot's way from raw samples to roll, pitch and yaw: calibrate, filter, convert.

    Parameters
    ----------
    parts : Parts
    still : array_like, shape (m, 3)  [rad/s]
        Gyroscope at rest, before the start.
    rests : array_like, shape (6, 3)  [m/s^2]
        Accelerometer in six positions.
    gyro : array_like, shape (n, 3)  [rad/s, body]
    accel : array_like, shape (n, 3)  [m/s^2, body]
    dt : float  [s]
    gains : MahonyGains

    Returns
    -------
    ndarray, shape (n, 3)  [rad]
        Roll, pitch and yaw after each sample; yaw starts at 0.
    """
    slow, ruler = parts.calibrate_gyro(still), parts.calibrate_accelerometer(rests)
    rates = np.asarray(gyro, float) - slow.bias
    forces = (np.asarray(accel, float) - ruler.bias) * ruler.scale
    state = imu.MahonyState(imu.attitude_from_accel(forces[0]), np.zeros(3))
    angles = np.empty((len(rates), 3))
    for row, (rate, force) in enumerate(zip(rates, forces, strict=True)):
        state = parts.mahony_step(state, rate, force, dt, gains)
        angles[row] = parts.euler_angles(state[0])
    return angles


def dead_reckoning(
    parts: Parts,
    observations: Sequence[Observation],
    wheels: odometry.TrackingWheels = DEAD_WHEELS,
    *,
    start: ArrayLike = odometry.motion.START,
    heading: str = "fused",
    bias: float = 0.0,
    taught: float = 0.0,
) -> FloatArray:
    """The robot's way from counters and gyroscope to poses.

    Parameters
    ----------
    parts : Parts
    observations : sequence of Observation
        One after the other, the first before the way begins.
    wheels : TrackingWheels
        What the robot believes of its dead wheels.
    start : array_like, shape (3,)  [m, m, rad; map]
        Where it stands at the first observation.
    heading : {"fused", "gyro", "wheels"}
        Who says how far it turned: the gyroscope, whose bias the wheels teach; the gyroscope
        alone; the wheels alone.
    bias : float  [rad/s]
        What the gyroscope reads about z at rest, as far as known.
    taught : float  [s]
        Length of the log at rest that it comes from: so much does it weigh beside what the wheels
        teach.

    Returns
    -------
    ndarray, shape (n, 3)  [m, m, rad; map]
        A pose for each observation.

    Raises
    ------
    ValueError
        An unknown ``heading``.
    """
    if heading not in HEADINGS:
        raise ValueError(f"heading: expected one of {', '.join(HEADINGS)}, got {heading!r}")
    ticks = parts.tick_changes(np.array([one.ticks for one in observations]), COUNTER_BITS)
    travel = parts.wheel_travel(wheels, ticks)
    deltas = parts.body_deltas(wheels, travel)
    if heading == "wheels":
        return parts.integrate(deltas, np.asarray(start, float))
    dt = np.diff([one.time for one in observations])
    rates = np.array([one.gyro[:, 2].mean() if len(one.gyro) else np.nan for one in observations])
    wheel_rates = deltas[:, 2] / dt if heading == "fused" else np.full(len(dt), np.nan)
    known = odometry.HeadingState(yaw=float(start[2]), bias=bias, taught=taught)
    yaw = odometry.estimate_heading(rates[1:], wheel_rates, dt, start=known).yaw
    return parts.integrate(parts.body_deltas(wheels, travel, yaw), np.asarray(start, float))


class Reckoning(NamedTuple):
    """All that dead reckoning remembers from one observation to the next.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    heading : odometry.HeadingState
        Heading and the gyroscope's bias.
    time : float  [s]
        Of the last observation; NaN: none yet.
    ticks : ndarray of int64, shape (3,)
        Its counters.
    """

    pose: FloatArray
    heading: odometry.HeadingState
    time: float = nan
    ticks: NDArray[np.int64] | None = None

    @classmethod
    def at(cls, pose: ArrayLike) -> Reckoning:
        """Standing at a known pose, before anything was seen.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]

        Returns
        -------
        Reckoning

        Raises
        ------
        ValueError
            Not a pose.
        """
        pose = as_floats(pose, "pose", 3)
        return cls(pose, odometry.HeadingState(yaw=float(pose[2])))


def reckon(
    parts: Parts,
    state: Reckoning,
    observation: Observation,
    wheels: odometry.TrackingWheels = DEAD_WHEELS,
) -> Reckoning:
    """One step of `dead_reckoning` by wheels and gyroscope together, for a control loop.

    Parameters
    ----------
    parts : Parts
    state : Reckoning
        Before; it is left as it is.
    observation : Observation
        One that is not later than the last changes nothing.
    wheels : TrackingWheels
        What the robot believes of its dead wheels.

    Returns
    -------
    Reckoning
    """
    now, ticks = observation.time, np.asarray(observation.ticks)
    if state.ticks is None:
        return state._replace(time=now, ticks=ticks)
    dt = now - state.time
    if not dt > 0.0:
        return state
    changes = parts.tick_changes(np.array([state.ticks, ticks]), COUNTER_BITS)
    travel = parts.wheel_travel(wheels, changes)
    by_wheels = float(np.asarray(parts.body_deltas(wheels, travel))[0, 2])
    rate = float(observation.gyro[:, 2].mean()) if len(observation.gyro) else nan
    heading = odometry.fuse_heading(state.heading, rate, by_wheels / dt, dt)
    deltas = parts.body_deltas(wheels, travel, np.array([state.heading.yaw, heading.yaw]))
    pose = np.asarray(parts.integrate(deltas, state.pose), float)[-1]
    return Reckoning(pose, heading, now, ticks)


def lidar_y(observation: Observation, heading: float) -> float:
    """Distance from the fence behind the start, by the LiDAR that looks at the far fence.

    Parameters
    ----------
    observation : Observation
    heading : float  [rad, map]

    Returns
    -------
    float  [m, map]
        y of the robot's middle; NaN where no LiDAR looks that way within `LIDAR_CONE`, or it does
        not trust itself.
    """
    for mount, reading in zip(LIDARS, observation.lidar, strict=True):
        off = remainder(mount.angle + heading - pi / 2, TURN)
        if abs(off) <= LIDAR_CONE and reading.distance > 0.0:
            seat = mount.x * sin(heading) + mount.y * cos(heading)
            return field.SIZE - reading.distance * cos(off) - seat
    return nan
