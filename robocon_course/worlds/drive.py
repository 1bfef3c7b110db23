"""Drives of one student's robot in the simulator, with mass, grip and lag, and what it saw.

Somebody who sees the robot from outside drives it about Area 1, to one random pose after the
other, and lets it stand between some of them. The log is what the robot itself knows; the truth
lies beside it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robocon_course._arrays import FloatArray, freeze_arrays
from robocon_course.autopilot import Parts, module_command
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS, Observation
from robocon_course.simulator.inertial import ImuErrors
from robocon_course.swerve import pose_feedback
from robocon_course.worlds.imu import own_imu
from robocon_course.worlds.robot import LEFT, RIGHT, own_wheels
from robocon_course.worlds.student import Student, generator

START = (1.0, 1.0, 0.0)
"""Where the drives begin [m, m, rad; map]."""
AREA = ((0.7, 0.9), (5.1, 2.5))
"""Corners of where the middle of the robot goes, in Area 1 [m, map]: clear of rack and ramp."""
CYCLE = 0.02  # s, from one observation to the next
REST = 3.0  # s, before the first leg
GAIN = 2.5  # 1/s
FASTEST = (1.4, 2.0)  # m/s, rad/s
HARDEST = (2.0, 5.0)  # m/s^2, rad/s^2
NEAR = (0.08, 0.08)  # m, rad
SEAMS = 3.0  # s, from one hop of a wheel to the next
REFERENCE = Parts()
DRIVES = ("ideal", "noisy", "degraded")
Gaps = tuple[tuple[int, float, float], ...]
"""Wheel, and the times [s] between which its counter stands still."""


@dataclass(frozen=True)
class DriveLog:
    """A drive in the simulator.

    Attributes
    ----------
    observations : tuple of Observation
        One every `CYCLE`, the first before anything moves.
    poses : ndarray, shape (n, 3)  [m, m, rad; map]
        The truth at each of them; theta is not wrapped.
    wheels : TrackingWheels
        True sizes of this robot's dead wheels.
    rest : int
        So many observations were made at rest before the first leg.
    """

    observations: tuple[Observation, ...]
    poses: FloatArray
    wheels: TrackingWheels
    rest: int

    __post_init__ = freeze_arrays

    @property
    def time(self) -> FloatArray:
        """Of each observation, shape (n,) [s]."""
        return np.array([one.time for one in self.observations])

    @property
    def still(self) -> FloatArray:
        """Gyroscope at rest before the first leg, shape (m, 3) [rad/s]."""
        return np.concatenate([one.gyro for one in self.observations[: self.rest]])


def simulated_drive(student: Student, kind: str = "noisy", duration: float = 40.0) -> DriveLog:
    """A drive of one student's robot in the simulator.

    Parameters
    ----------
    student : int or str
        Student number.
    kind : {"ideal", "noisy", "degraded"}
        ``"ideal"``: a robot as drawn, with a perfect IMU. ``"noisy"``: the student's robot and
        IMU, and `bumps`. ``"degraded"``: the same with `failures` in their place.
    duration : float  [s]

    Returns
    -------
    DriveLog
    """
    if kind not in DRIVES:
        raise ValueError(f"kind: expected one of {', '.join(DRIVES)}, got {kind!r}")
    wheels = DEAD_WHEELS if kind == "ideal" else own_wheels(student)
    errors = None if kind == "ideal" else own_imu(student)
    rng = generator(student, "simulated drive", kind, f"{duration:g}")
    gaps = {"ideal": lambda *_: (), "noisy": bumps, "degraded": failures}[kind](rng, duration)
    return drive_log(wheels, errors, rng, duration, gaps=gaps)


def drive_log(
    wheels: TrackingWheels,
    errors: ImuErrors | None,
    rng: np.random.Generator,
    duration: float = 180.0,
    *,
    gaps: Gaps = (),
) -> DriveLog:
    """A random drive of a robot with these dead wheels and this IMU.

    Parameters
    ----------
    wheels : TrackingWheels
        The true sizes.
    errors : ImuErrors or None
        None is a perfect IMU.
    rng : numpy.random.Generator
        Draws the sensors' seed, and where the robot goes.
    duration : float  [s]
    gaps : tuple of (wheel, start, end)
        Times [s] in which a dead wheel's counter stands still.

    Returns
    -------
    DriveLog
    """
    from robocon_course.simulator import IDEAL, RobotModel, SensorModel, Simulator

    sensors = SensorModel(imu=errors) if errors else IDEAL
    robot = Simulator(
        RobotModel(dead_wheels=wheels), sensors=replace(sensors, encoder_gaps=gaps), start=START
    )
    robot.reset(int(rng.integers(1 << 31)))
    observations, poses = [robot.read()], [robot.truth.pose]
    goal, pause, twist = np.array(START), REST, np.zeros(3)
    while len(poses) <= round(duration / CYCLE):
        pose = poses[-1]
        if pause > 0.0:
            pause -= CYCLE
        elif _arrived(pose, goal):
            goal = _next_goal(rng, pose)
            pause = rng.choice([0.0, 0.0, 1.0])
        twist = _towards(goal if pause <= 0.0 else pose, pose, twist)
        angles = observations[-1].module_angles
        robot.apply(module_command(REFERENCE, twist, pose[2], angles, dt=CYCLE))
        robot.step(CYCLE)
        observations.append(robot.read())
        poses.append(robot.truth.pose)
    return DriveLog(tuple(observations), np.array(poses), wheels, round(REST / CYCLE))


def _next_goal(rng: np.random.Generator, pose: FloatArray) -> FloatArray:
    """A place in the area, and a heading not further than a turn and a half in all."""
    place = rng.uniform(*AREA)
    return np.array([*place, np.clip(pose[2] + rng.uniform(-2.5, 2.5), -9.0, 9.0)])


def _arrived(pose: FloatArray, goal: FloatArray) -> bool:
    return bool(np.hypot(*(goal - pose)[:2]) < NEAR[0] and abs(goal[2] - pose[2]) < NEAR[1])


def _towards(goal: FloatArray, pose: FloatArray, twist: FloatArray) -> FloatArray:
    """The next twist [map]: towards the goal, not too fast and not too hard."""
    want = pose_feedback(pose, goal, GAIN)
    want[:2] *= min(1.0, FASTEST[0] / max(np.hypot(*want[:2]), 1e-9))
    want[2] = np.clip(want[2], -FASTEST[1], FASTEST[1])
    change = want - twist
    change[:2] *= min(1.0, HARDEST[0] * CYCLE / max(np.hypot(*change[:2]), 1e-9))
    change[2] = np.clip(change[2], -HARDEST[1] * CYCLE, HARDEST[1] * CYCLE)
    return twist + change


def bumps(rng: np.random.Generator, duration: float) -> Gaps:
    """Seams in the floor: every few seconds one wheel hops, and misses up to 15 ms of its way.

    Parameters
    ----------
    rng : numpy.random.Generator
    duration : float  [s]

    Returns
    -------
    tuple of (wheel, start, end)
    """
    starts = np.arange(REST + 1.0, duration - 1.0, SEAMS) + rng.uniform(0.0, 1.0)
    return tuple(
        (int(rng.integers(3)), float(start), float(start + rng.uniform(0.005, 0.015)))
        for start in starts
    )


def failures(rng: np.random.Generator, duration: float) -> Gaps:
    """Left or right wheel not heard for 2 s once, and in the air for a moment a few times.

    Parameters
    ----------
    rng : numpy.random.Generator
    duration : float  [s]

    Returns
    -------
    tuple of (wheel, start, end)
    """
    starts = np.linspace(REST + 3.0, duration - 3.0, max(3, int(duration / 8.0)))
    lengths = rng.uniform(0.2, 0.5, len(starts))
    lengths[1] = 2.0
    return tuple(
        (int(rng.choice([LEFT, RIGHT])), float(start), float(start + length))
        for start, length in zip(starts, lengths, strict=True)
    )
