"""From what the sensors say to where the robot is: whole logs, and one reading after the other."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, fsum, inf, isfinite, nan, pi, radians, remainder, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field, imu, odometry
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.autopilot.parts import Parts
from robocon_course.geometry import TURN
from robocon_course.odometry.motion import odometry_update
from robocon_course.robot import DEAD_WHEELS, LIDARS, SATURATED, WEAKEST, Observation

COUNTER_BITS = 32
"""Counters are compared in so many bits: no wheel turns by half of that between two readings."""
HEADINGS = ("wheels", "gyro", "fused")
LONGEST_GAP = 0.5
"""A clock that goes on by more from one observation to the next has leapt [s]."""
PATIENCE = 10
"""After so many useless observations in a row a leap of the clock is believed."""
LEAP = 3.0
"""So much a rate may differ from the wheels' and from the last one [rad/s]: more is no motion."""
MOST_TICKS = 2.0**53
"""Up to here a float is a whole number."""
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
        Of the last observation that was used; NaN: none yet.
    ticks : tuple of 3 ints, or None
        Its counters.
    dt : float  [s]
        Between the last two that were used; NaN: there were none, or the clock leapt.
    rate : float  [rad/s]
        What the gyroscope said last; NaN: nothing.
    missed : int
        Observations in a row that were not used.
    rejected : int
        Observations that could not be used, and gyroscope readings that nothing explains.
    """

    pose: FloatArray
    heading: odometry.HeadingState
    time: float = nan
    ticks: tuple[int, ...] | None = None
    dt: float = nan
    rate: float = nan
    missed: int = 0
    rejected: int = 0

    @property
    def fresh(self) -> bool:
        """Whether the last observation was used. If not, the pose is as old as the one before."""
        return self.ticks is not None and self.missed == 0

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
        pose = as_floats(pose, "pose", 3).copy()
        return cls(pose, odometry.HeadingState(yaw=float(pose[2])))


def reckon(
    parts: Parts,
    state: Reckoning,
    observation: Observation,
    wheels: odometry.TrackingWheels = DEAD_WHEELS,
) -> Reckoning:
    """One step of `dead_reckoning` by wheels and gyroscope together, for a control loop.

    A clock that stands, runs back or leaps, and counters that are no numbers, make an observation
    useless: it is counted and the pose stays. Where the clock goes on from another time, the
    counters tell after a few of them how far the robot came meanwhile.

    Parameters
    ----------
    parts : Parts
    state : Reckoning
        Before; it is left as it is.
    observation : Observation
    wheels : TrackingWheels
        What the robot believes of its dead wheels.

    Returns
    -------
    Reckoning

    Raises
    ------
    ValueError
        Counters or gyroscope of another shape. Never for a value: this runs in a control loop.
    """
    now, count = float(observation.time), len(wheels.radius)
    ticks = as_floats(observation.ticks, "observation.ticks", count, finite=False).tolist()
    gyro = as_floats(observation.gyro, "observation.gyro", None, 3, finite=False)[:, 2]
    usable = isfinite(now) and all([abs(one) < MOST_TICKS for one in ticks])
    if usable and state.ticks is None:
        return state._replace(time=now, ticks=tuple(map(int, ticks)), missed=0)
    dt = now - state.time
    leapt = usable and not 0.0 < dt <= LONGEST_GAP
    if not usable or (leapt and (dt == 0.0 or state.missed < PATIENCE)):
        return state._replace(missed=state.missed + 1, rejected=state.rejected + 1)
    counted = tuple(map(int, ticks))
    rolled = _Rolled.of(parts, wheels, state.ticks, counted)
    rate, strange = (nan, False) if leapt else _rate(gyro, rolled.turned / dt, state.rate)
    step = dt if not leapt else LONGEST_GAP
    believed = nan if strange else rate
    heading = odometry.fuse_heading(state.heading, believed, rolled.turned / step, step)
    pose = rolled.pose(parts, wheels, state, heading.yaw)
    rejected = state.rejected + strange
    return Reckoning(pose, heading, now, counted, nan if leapt else dt, rate, rejected=rejected)


CHAIN = ("tick_changes", "wheel_travel", "body_deltas", "integrate")
"""Parts whose compiled kernel does the same in one step, if all of them are the course's."""


class _Rolled(NamedTuple):
    """What the dead wheels rolled between two observations.

    Attributes
    ----------
    turned : float  [rad]
        How far the base turned, by the wheels.
    changes : ndarray of float, shape (3,)
        Counts.
    travel : ndarray, shape (1, 3), or None  [m]
        By the parts; None: their kernel is used.
    """

    turned: float
    changes: FloatArray
    travel: FloatArray | None

    @classmethod
    def of(
        cls,
        parts: Parts,
        wheels: odometry.TrackingWheels,
        before: tuple[int, ...],
        now: tuple[int, ...],
    ) -> _Rolled:
        if parts.are_the_courses(*CHAIN):
            half = 1 << (COUNTER_BITS - 1)
            pairs = zip(before, now, strict=True)
            changes = np.array([float((b - a + half) % (2 * half) - half) for a, b in pairs])
            return cls(float(wheels.turn_per_tick.dot(changes)), changes, None)
        changes = parts.tick_changes(np.array([before, now]), COUNTER_BITS)
        travel = parts.wheel_travel(wheels, changes)
        return cls(float(np.asarray(parts.body_deltas(wheels, travel))[0, 2]), changes, travel)

    def pose(
        self, parts: Parts, wheels: odometry.TrackingWheels, state: Reckoning, yaw: float
    ) -> FloatArray:
        """The pose after it, heading to `yaw` now."""
        if self.travel is None:
            pose, turn = state.pose.copy(), remainder(yaw - state.heading.yaw, TURN)
            odometry_update(pose, self.changes, wheels.per_tick, wheels.per_turn, turn)
            return pose
        deltas = parts.body_deltas(wheels, self.travel, np.array([state.heading.yaw, yaw]))
        return np.array(parts.integrate(deltas, state.pose), float)[-1]


def _rate(gyro: FloatArray, by_wheels: float, last: float) -> tuple[float, bool]:
    """The gyroscope's mean rate [rad/s], and whether neither wheels nor the last one explain it.

    One such reading is a disturbance on the line. A second one is a robot that really turns.
    """
    known = [one for one in gyro.tolist() if isfinite(one)]
    rate = fsum(known) / len(known) if known else nan
    before = last if isfinite(last) else by_wheels
    return rate, abs(rate - by_wheels) > LEAP and abs(rate - before) > LEAP


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
    if not isfinite(heading):
        return nan
    for mount, reading in zip(LIDARS, observation.lidar, strict=False):
        off = remainder(mount.angle + heading - pi / 2, TURN)
        sure = WEAKEST <= reading.strength < SATURATED and 0.0 < reading.distance < inf
        if abs(off) <= LIDAR_CONE and sure:
            seat = mount.x * sin(heading) + mount.y * cos(heading)
            return field.SIZE - reading.distance * cos(off) - seat
    return nan
