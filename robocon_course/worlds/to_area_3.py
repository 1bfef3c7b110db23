"""From the start zone to Area 3: one student's robot drives there by itself, in the simulator.

Before it starts it was calibrated, like every robot before a match: a run and a spin, measured by
hand, tell the sizes of its dead wheels, and it stands for three seconds to learn its gyroscope's
bias. On the way it has its own sensors and nothing else. The truth lies beside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import hypot, radians
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats, freeze_arrays
from robocon_course.autopilot import DriveLimits, Parts, Pilot, Route, lidar_y, plan_route
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS
from robocon_course.tracking import nearest_points, profile_times
from robocon_course.worlds.drive import CYCLE, DRIVES, REFERENCE, REST, bumps
from robocon_course.worlds.imu import own_imu
from robocon_course.worlds.robot import own_robot
from robocon_course.worlds.student import Student, generator
from robocon_course.worlds.wheels import BITS, RUN, SPIN, odometry_world

if TYPE_CHECKING:
    from robocon_course.simulator import Simulator

HEADING = 0.0
"""Kept all the way [rad, map]: the left LiDAR looks at the far fence."""
TAPE, TURNS = 0.001, radians(0.2)
"""What the run and the spin of the calibration are measured to [m, rad]."""
LATE, PATIENCE = 1.5, 2.0
"""A robot that needs so many times the time of its profile, and so many seconds, is stopped."""
SLOWED = {"friction": 0.3, "steering_lag": 0.1, "drive_lag": 0.1}
"""A dusty floor and tired motors."""
WORN = 4
"""So many times as often a wheel hops, on a worn floor."""
FINE, COARSE = 0.01, 0.05
"""Cells of the map [m]; a search in plain Python takes the coarse one."""


@dataclass(frozen=True)
class FieldDrive:
    """A drive over the field, and the truth about it.

    Attributes
    ----------
    parts : str
        Whose parts drove.
    arrived : bool
        At rest within 0.2 m of the goal and, in Area 3, behind its line by LiDAR; all as the robot
        itself believes.
    reason : str
        How it ended, in words.
    time : ndarray, shape (n,)  [s]
        From the moment at which it was allowed to go.
    poses, estimates : ndarray, shape (n, 3)  [m, m, rad; map]
        The truth, and what the robot believed.
    module_angles, module_speeds : ndarray, shape (n, 4)  [rad, base; m/s]
    cross_track : ndarray, shape (n,)  [m]
        Of the truth: distance from the path.
    route : Route
    limit : float  [s]
        What the speed profile needs for the path.
    contacts : int
        How often the body began to touch something.
    rejected : int
        Readings that the robot could not use.
    lidar_y : float  [m, map]
        What the LiDAR that looks at the far fence says at the end; NaN: nothing. Before Area 3 it
        meets the water's frame, and says too much.
    """

    parts: str
    arrived: bool
    reason: str
    time: FloatArray
    poses: FloatArray
    estimates: FloatArray
    module_angles: FloatArray
    module_speeds: FloatArray
    cross_track: FloatArray
    route: Route
    limit: float
    contacts: int
    rejected: int
    lidar_y: float

    __post_init__ = freeze_arrays

    @property
    def path(self) -> FloatArray:
        """Of the drive, shape (m, 2) [m, map]."""
        return self.route.xy

    @property
    def speeds(self) -> FloatArray:
        """Of the profile at each point of the path, shape (m,) [m/s]."""
        return self.route.speeds

    @property
    def duration(self) -> float:
        """From going to the end [s]."""
        return float(self.time[-1])

    @property
    def away(self) -> float:
        """True distance from the goal at the end [m]."""
        return float(hypot(*(self.poses[-1, :2] - self.route.xy[-1])))

    @property
    def off(self) -> float:
        """Root mean square of the cross-track error [m]."""
        return float(np.sqrt(np.mean(self.cross_track**2)))

    @property
    def lines(self) -> tuple[str, ...]:
        """The drive in words and numbers, for a terminal or a notebook."""
        plan, more = self.route.plan, self.duration - self.limit
        height = "no reading" if np.isnan(self.lidar_y) else f"y = {self.lidar_y:.2f} m"
        in_area_3 = self.route.xy[-1, 1] > field.AREA_3_LINE
        return (
            f"plan: {len(plan.cells)} cells, {plan.length:.2f} m; rounded "
            f"{self.route.along[-1]:.2f} m, {100 * self.route.margin:.0f} cm of room on each side; "
            f"{self.limit:.1f} s by its speed profile",
            f"{'✔' if self.arrived else '✘'} {self.reason}, after {self.duration:.1f} s, "
            f"{more:.1f} s more than its profile",
            f"truth: {1000 * self.away:.0f} mm from the goal"
            + (f"; LiDAR: {height}" if in_area_3 else ""),
            f"cross-track error: {1000 * self.off:.0f} mm RMS, "
            f"{1000 * self.cross_track.max():.0f} mm at most; touched something "
            f"{self.contacts} times; {self.rejected} readings rejected",
        )


def field_drive(
    student: Student,
    parts: Parts = REFERENCE,
    goal: ArrayLike = field.AREA_3_GOAL,
    *,
    kind: str = "noisy",
    limits: DriveLimits = DriveLimits(),  # noqa: B008 - a NamedTuple cannot change
    resolution: float | None = None,
    on_time: Callable[[float], object] = lambda share: None,
) -> FieldDrive:
    """Let one student's robot drive from the start to a goal.

    Parameters
    ----------
    student : int or str
        Student number: another one is another robot with other noise.
    parts : Parts
    goal : array_like, shape (2,)  [m, map]
    kind : {"ideal", "noisy", "degraded"}
        ``"ideal"``: a robot as drawn, with perfect sensors. ``"noisy"``: the student's robot and
        its sensors, on a floor with seams. ``"degraded"``: the same on a dusty, worn floor with
        tired motors.
    limits : DriveLimits
    resolution : float, optional  [m]
        Of the map it plans on: 1 cm; 5 cm where the search is the student's own, in plain Python.
    on_time : callable
        Told now and then which share of the drive has passed.

    Returns
    -------
    FieldDrive

    Raises
    ------
    NoPathError
        No way leads there.
    ValueError
        A goal that is no point, or another kind.
    """
    if kind not in DRIVES:
        raise ValueError(f"kind: expected one of {', '.join(DRIVES)}, got {kind!r}")
    goal = as_floats(goal, "goal", 2)
    cell = resolution or (COARSE if "astar" in parts.mine else FINE)
    route = plan_route(parts, field.obstacle_map(cell), field.START, goal, limits=limits)
    limit = float(profile_times(route.xy, route.speeds)[-1])
    robot, wheels = _robot(student, kind, _longest(limit), parts)
    pilot = Pilot(parts, route, (*field.START, HEADING), wheels, rest=REST)
    return _driven(robot, pilot, limit, on_time)


def calibrated_wheels(student: Student, parts: Parts = REFERENCE) -> TrackingWheels:
    """The sizes of a student's dead wheels as a run and a spin tell them.

    Parameters
    ----------
    student : int or str
    parts : Parts

    Returns
    -------
    TrackingWheels
        The run was measured to 1 mm, the spin to 0.2 degrees.
    """
    world, rng = odometry_world(student), generator(student, "calibration")
    run, spin = (
        parts.tick_changes(log.counters, BITS).sum(axis=0) for log in (world.run, world.spin)
    )
    way, angle = RUN + rng.normal(0.0, TAPE, 2), SPIN + rng.normal(0.0, TURNS)
    return parts.calibrate_wheels(DEAD_WHEELS, run, way, spin, float(angle))


def _robot(
    student: Student, kind: str, duration: float, parts: Parts
) -> tuple[Simulator, TrackingWheels]:
    """The simulated robot, and what it believes of its dead wheels."""
    from robocon_course.simulator import IDEAL, SensorModel, Simulator

    start = (*field.START, HEADING)
    if kind == "ideal":
        return Simulator(sensors=IDEAL, start=start), DEAD_WHEELS
    rng, model = generator(student, "field drive", kind), own_robot(student)
    gaps = bumps(rng, duration)
    if kind == "degraded":
        model = replace(model, **SLOWED)
        gaps = sum((bumps(rng, duration) for _ in range(WORN - 1)), gaps)
    sensors = SensorModel(imu=own_imu(student), encoder_gaps=gaps)
    robot = Simulator(model, sensors=sensors, start=start)
    robot.reset(int(rng.integers(1 << 31)))
    return robot, calibrated_wheels(student, parts)


def _longest(limit: float) -> float:
    """How long a drive may take, the rest before it included [s]."""
    return REST + LATE * limit + PATIENCE


def _driven(
    robot: Simulator, pilot: Pilot, limit: float, on_time: Callable[[float], object]
) -> FieldDrive:
    """The whole drive, until the robot has arrived and stands, or is late."""
    rows, steps = [], round(_longest(limit) / CYCLE)
    for step in range(steps):
        seen, truth = robot.read(), robot.truth
        command = pilot.tick(seen)
        rows.append((seen.time, truth.pose, pilot.reckoning.pose, seen.module_angles,
                     seen.module_speeds))  # fmt: skip
        if seen.time >= REST and pilot.arrived:
            break
        robot.apply(command)
        robot.step(CYCLE)
        if step % 25 == 0:
            on_time(step / steps)
    time, poses, estimates, angles, speeds = (
        np.array(column) for column in zip(*rows, strict=True)
    )
    gone = time >= REST
    truth = robot.truth
    return FieldDrive(
        parts=pilot.parts.label,
        arrived=pilot.arrived,
        reason=_reason(pilot, truth.contacts),
        time=time[gone] - REST,
        poses=poses[gone],
        estimates=estimates[gone],
        module_angles=angles[gone],
        module_speeds=speeds[gone],
        cross_track=np.abs(nearest_points(pilot.route.xy, poses[gone]).cross_track),
        route=pilot.route,
        limit=limit,
        contacts=truth.contacts,
        rejected=pilot.rejected,
        lidar_y=lidar_y(pilot.seen, pilot.reckoning.pose[2]),
    )


def _reason(pilot: Pilot, contacts: int) -> str:
    touched = f", but touched something {contacts} times" if contacts else ""
    if pilot.arrived:
        return f"arrived{touched}"
    return f"stopped for being late, {pilot.away:.2f} m from the goal by its own odometry{touched}"
