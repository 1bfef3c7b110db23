"""The robot's replaceable parts, and the order in which they run.

Each part is one function of one chapter. The references stand here by default; an accepted answer
takes the place of the reference of the same name. Chapters to come add their parts and their
step of the way from a sensor reading to a command.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import geometry, gridmap, imu, odometry, planning, swerve
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.drivetrain import wheel_matrix
from robocon_course.geometry import TURN
from robocon_course.robot import DEAD_WHEELS, MAX_SPEED, MODULES, Command, Observation

Part = Callable[..., Any]

COUNTER_BITS = 32
"""Counters are compared in so many bits: no wheel turns by half of that between two readings."""
HEADINGS = ("wheels", "gyro", "fused")


@dataclass(frozen=True)
class Parts:
    """The robot's parts; ``mine`` names those that a student wrote."""

    wrap_angle: Part = geometry.wrap_angle
    calibrate_gyro: Part = imu.calibrate_gyro
    calibrate_accelerometer: Part = imu.calibrate_accelerometer
    fit_ellipsoid: Part = imu.fit_ellipsoid
    gravity_direction: Part = imu.gravity_direction
    mahony_step: Part = imu.mahony_step
    euler_angles: Part = imu.euler_angles
    tick_changes: Part = odometry.tick_changes
    wheel_travel: Part = odometry.wheel_travel
    wheel_matrix: Part = wheel_matrix
    body_deltas: Part = odometry.body_deltas
    integrate: Part = odometry.integrate
    body_velocity: Part = odometry.body_velocity
    calibrate_wheels: Part = odometry.calibrate_wheels
    inflate_square: Part = gridmap.inflate_square
    astar: Part = planning.astar
    shorten_path: Part = planning.shorten_path
    smooth_path: Part = planning.smooth_path
    pose_feedback: Part = swerve.pose_feedback
    field_to_robot: Part = swerve.field_to_robot
    discretize: Part = swerve.discretize
    module_targets: Part = swerve.module_targets
    limit_speeds: Part = swerve.limit_speeds
    shortest_turn: Part = swerve.shortest_turn
    body_twist: Part = swerve.body_twist
    mine: tuple[str, ...] = ()

    @staticmethod
    def names() -> tuple[str, ...]:
        """Names of all parts, in the order in which data meets them."""
        return tuple(f.name for f in fields(Parts) if f.name != "mine")

    @property
    def label(self) -> str:
        """Which parts are the student's, in a few words for a figure."""
        if not self.mine:
            return "reference"
        count, whole = len(self.mine), len(self.names())
        return "mine" if count == whole else f"mixed, {count} of {whole} parts mine"


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


def module_command(
    parts: Parts,
    twist: ArrayLike,
    theta: float,
    angles: ArrayLike,
    *,
    dt: float,
    max_speed: float = MAX_SPEED,
) -> Command:
    """The robot's way from a velocity on the field to what its modules are told.

    Turned into the robot's axes, aimed before the turn, shared out to the modules, slowed to what
    the wheels reach, steered the shorter way, and held back where a wheel still turns.

    A sensor's bad value never stops the loop: where the order, the heading or an angle is not
    finite, or the order would turn the robot by a whole turn within ``dt``, the wheels stand still
    and the modules keep their angles. Whoever counts such steps looks for speeds that are all 0
    though the order is not.

    Parameters
    ----------
    parts : Parts
    twist : array_like, shape (3,)  [m/s, m/s, rad/s; map]
    theta : float  [rad, map]
        Heading of the robot.
    angles : array_like, shape (4,)  [rad, base]
        Angles the modules have now.
    dt : float  [s]
        How long the command will hold.
    max_speed : float  [m/s]

    Returns
    -------
    Command
        Held, a module whose angle is not finite is sent to 0.

    Raises
    ------
    ValueError
        Wrong shapes, a dt that is not positive, or what a part refuses or gets wrong.
    """
    twist = as_floats(twist, "twist", 3, finite=False)
    theta = float(as_floats(theta, "theta", finite=False))
    angles = as_floats(angles, "angles", len(MODULES), finite=False)
    if not 0.0 < dt < np.inf:
        raise ValueError(f"dt: expected seconds above 0, got {dt}")
    if not _can_be_driven(twist, theta, angles, dt):
        return Command.stop(np.where(np.isfinite(angles), angles, 0.0))
    body = np.asarray(parts.field_to_robot(twist, theta), float)
    body = np.asarray(parts.discretize(body, dt), float)
    targets = _as_arrays(parts.module_targets(MODULES, body, angles))
    targets = _as_arrays(parts.limit_speeds(targets, max_speed))
    return Command(*swerve.cosine_compensation(parts.shortest_turn(targets, angles), angles))


def _can_be_driven(twist: FloatArray, theta: float, angles: FloatArray, dt: float) -> bool:
    """Whether an order and the readings beside it make sense."""
    with np.errstate(over="ignore"):
        squares = np.square(twist)  # the modules' speeds are roots of sums of them
    finite = np.isfinite(squares.sum()) and np.isfinite(theta) and np.isfinite(angles).all()
    return bool(finite and abs(twist[2] * dt) < TURN)


def _as_arrays(targets: swerve.ModuleTargets) -> swerve.ModuleTargets:
    """One part may answer with lists, the next one count on arrays."""
    return swerve.ModuleTargets(*(np.asarray(values, float) for values in targets))
