"""Numbers from the student's own robot, and the challenge."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import odometry, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake, Number, Score
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS
from robocon_course.worlds import Student

DRAWN_MM = 274.5  # mm, rear wheel behind the centre
REAR = 2


def _further_back(student: Student, *, drawn_radius: bool = False) -> float:
    """How much further behind the centre the rear wheel stands than drawn [mm]."""
    wheels = worlds.own_wheels(student)
    behind = -1000.0 * wheels.positions[REAR, 0]
    if drawn_radius:
        behind *= DEAD_WHEELS.radius[REAR] / wheels.radius[REAR]
    return float(behind - DRAWN_MM)


def _end_error(student: Student, *, mended: bool = True) -> float:
    """How far from the true end the square of one student ends by odometry [mm]."""
    world = worlds.odometry_world(student)
    counters = world.square.counters
    ticks = odometry.tick_changes(counters, worlds.BITS) if mended else np.diff(counters, axis=0)
    travel = odometry.wheel_travel(DEAD_WHEELS, ticks)
    end = odometry.integrate(odometry.body_deltas(DEAD_WHEELS, travel))[-1]
    return float(1000.0 * np.hypot(*(end - world.square.poses[-1])[:2]))


OWN_OFFSET = Number(
    id="odometry.own_offset",
    title="How much further back your rear wheel stands than drawn",
    points=1,
    truth=_further_back,
    tolerance=0.3,
    unit="mm",
    hints=(
        "Your calibration moved the rear wheel. Where is its x now, and where was it in the "
        "drawing?",
        "1000 * (drawing.positions[2, 0] − mine.positions[2, 0]): x is negative behind the centre.",
    ),
    mistakes=(
        Mistake(
            "sign reversed",
            "The sign is reversed: positive means further back than drawn.",
            lambda student: -_further_back(student),
        ),
        Mistake(
            "whole offset",
            "That is the whole offset. Asked for is how much more it is than the 274.5 mm drawn.",
            lambda student: _further_back(student) + DRAWN_MM,
        ),
        Mistake(
            "drawn radius",
            "That comes from the spin with the drawn radius. The rear wheel is not as large as "
            "drawn either; find its radius from the run first.",
            lambda student: _further_back(student, drawn_radius=True),
        ),
        Mistake(
            "metres",
            "That is in metres. The question asks for mm.",
            lambda student: _further_back(student) / 1000.0,
        ),
    ),
)

OWN_SQUARE = Number(
    id="odometry.own_square",
    title="How far off your square ends with the drawing's sizes",
    points=1,
    truth=_end_error,
    tolerance=1.0,
    unit="mm",
    hints=(
        "Take the wheels of the drawing. Counters → counts → travel → motion → poses, then compare "
        "the last pose with world.square.poses[-1].",
        "1000 * np.hypot(dx, dy) of the difference between the two last poses.",
    ),
    mistakes=(
        Mistake(
            "metres",
            "That is in metres. The question asks for mm.",
            lambda student: _end_error(student) / 1000.0,
        ),
        Mistake(
            "counters not mended",
            "The counters wrapped around on the way, and nobody mended them: use tick_changes.",
            lambda student: _end_error(student, mended=False),
        ),
        Mistake(
            "centimetres",
            "That is in centimetres. The question asks for mm.",
            lambda student: _end_error(student) / 10.0,
        ),
    ),
)


def _rough_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    drives = [worlds.rough_drive_log(rng) for _ in range(3)]
    return [
        Case("a rough drive", (d.wheels, d.ticks, d.gyro, d.dt), "m, m, rad", truth=d.poses)
        for d in drives
    ]


def _farthest(case: Case, poses: np.ndarray) -> float:
    """Largest distance from the truth [m]."""
    with np.errstate(over="ignore"):
        return float(np.hypot(*(poses - case.truth)[:, :2].T).max())


def _rough(turn: Callable[..., np.ndarray]) -> Callable[..., np.ndarray]:
    """All wheels believed, with another turn."""

    def function(
        wheels: TrackingWheels, ticks: np.ndarray, gyro: np.ndarray, dt: float
    ) -> np.ndarray:
        travel = odometry.wheel_travel(wheels, ticks)
        by_wheels = odometry.body_deltas(wheels, travel)[:, 2]
        yaw = np.cumsum(np.r_[0.0, turn(by_wheels, gyro, dt)])
        return odometry.integrate(odometry.body_deltas(wheels, travel, yaw))

    return function


def _bridged(by_wheels: np.ndarray, gyro: np.ndarray, dt: float) -> np.ndarray:
    return np.where(np.isfinite(gyro), (gyro - np.nanmean(gyro[:80])) * dt, by_wheels)


ROUGH_DRIVE_POSES = Exercise(
    id="odometry.rough_drive_poses",
    title="Challenge: where is the robot after a rough drive?",
    points=4,
    reference=odometry.rough_drive_poses,
    cases=_rough_cases,
    time_limit=20.0,
    score=Score(_farthest, "m at the farthest", ((0.1, 1.0), (0.5, 0.5))),
    hints=(
        "The first second is at rest: the mean of the gyroscope there is its bias. Where gyro is "
        "NaN, the turn of body_deltas without yaw bridges the gap.",
        "Take what the turn rolls off the travel: travel − turn[:, None] * A[:, 2]. Left and right "
        "must then be equal, within a few counts.",
        "Where they are not, one of the two is wrong. A dead wheel has no motor: it can roll too "
        "little, never too much. Take the larger.",
    ),
    mistakes=(
        Mistake(
            "wheels alone",
            "This believes the wheels: every slip of one wheel is a turn that never happened, and "
            "stays in the heading.",
            _rough(lambda by_wheels, gyro, dt: by_wheels),
        ),
        Mistake(
            "bias left in",
            "The gyroscope's bias is still in the heading. The robot is at rest for the first "
            "second: what the gyroscope says there is bias.",
            _rough(lambda by_wheels, gyro, dt: np.where(np.isfinite(gyro), gyro * dt, by_wheels)),
        ),
        Mistake(
            "gaps as standstill",
            "Where the gyroscope is silent the robot is taken not to turn. The wheels know how far "
            "it turned.",
            _rough(lambda by_wheels, gyro, dt: np.nan_to_num((gyro - np.nanmean(gyro[:80])) * dt)),
        ),
        Mistake(
            "slip averaged",
            "The heading is right, but a wheel that slips or is not heard still counts half of the "
            "way forward. With the turn known, left and right can be compared.",
            _rough(_bridged),
        ),
    ),
)
