"""Numbers from the student's own world, and the challenge."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import geometry, imu, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake, Number, Score
from robocon_course.worlds import DT, Student


def _true_bias(student: Student) -> float:
    return float(np.degrees(worlds.own_imu(student).gyro_bias[2]))


def _yaw_drift(student: Student, *, calibrated: bool = False) -> float:
    """Yaw at the end of the match beside the truth [deg]."""
    world = worlds.imu_world(student)
    bias = imu.calibrate_gyro(world.still).bias if calibrated else np.zeros(3)
    accel = imu.calibrate_accelerometer(world.rests).apply(world.accel)
    log = imu.estimate_attitude(world.gyro - bias, accel, world.dt)
    true_yaw = imu.euler_angles(world.truth[-1])[2]
    return float(np.degrees(geometry.wrap_angle(log.yaw[-1] - true_yaw)))


OWN_BIAS = Number(
    id="imu.own_bias",
    title="Your gyroscope's bias about the vertical axis",
    points=1,
    truth=_true_bias,
    tolerance=0.01,
    unit="deg/s",
    hints=(
        "Your calibration of the still log has a .bias; the vertical axis is z, the third.",
        "np.degrees(calibration.bias[2])",
    ),
    mistakes=(
        Mistake(
            "radians per second",
            "That is the bias in rad/s. The question asks for deg/s.",
            lambda student: np.radians(_true_bias(student)),
        ),
        Mistake(
            "another axis",
            "That is the bias about x. The vertical axis of a level robot is z.",
            lambda student: float(np.degrees(worlds.own_imu(student).gyro_bias[0])),
        ),
        Mistake(
            "sign reversed",
            "The sign is reversed: the bias is what the sensor says too much.",
            lambda student: -_true_bias(student),
        ),
    ),
)

OWN_DRIFT = Number(
    id="imu.own_drift",
    title="How far your heading drifts in a match without calibration",
    points=1,
    truth=_yaw_drift,
    tolerance=1.5,
    unit="deg",
    hints=(
        "Run the filter on the raw match log. Compare its last yaw with the last true yaw.",
        "wrap_angle(raw.yaw[-1] − true_yaw[-1]), in degrees. Bias times 180 s is nearly the same.",
    ),
    mistakes=(
        Mistake(
            "with calibration",
            "That is the drift with the bias removed. The question asks for the raw gyroscope.",
            lambda student: _yaw_drift(student, calibrated=True),
        ),
        Mistake(
            "sign reversed",
            "The sign is reversed: estimate minus truth, left positive.",
            lambda student: -_yaw_drift(student),
        ),
        Mistake(
            "radians",
            "That is in radians. The question asks for degrees.",
            lambda student: np.radians(_yaw_drift(student)),
        ),
    ),
)


def _attitude_in_motion_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    drives = [worlds.rough_drive(rng) for _ in range(3)]
    return [Case("a rough drive", (d.gyro, d.accel, DT), truth=d.truth) for d in drives]


def _tilt_rms(case: Case, quaternions: np.ndarray) -> float:
    with np.errstate(over="ignore"):
        length = np.linalg.norm(quaternions, axis=-1)
    row = int(np.argmax(np.abs(length - 1.0)))
    if not abs(length[row] - 1.0) < 1e-3:
        raise ValueError(f"a quaternion has length 1; the one in row {row} has {length[row]:.3g}")
    error = imu.inclination_error(quaternions, case.truth)
    return float(np.degrees(np.sqrt(np.mean(error**2))))


def _filter(**gains: float) -> Callable[..., np.ndarray]:
    def function(gyro: np.ndarray, accel: np.ndarray, dt: float) -> np.ndarray:
        return imu.estimate_attitude(gyro, accel, dt, gains=imu.MahonyGains(**gains)).quaternions

    return function


ATTITUDE_IN_MOTION = Exercise(
    id="imu.attitude_in_motion",
    title="Challenge: the attitude during a rough drive",
    points=4,
    reference=imu.attitude_in_motion,
    cases=_attitude_in_motion_cases,
    time_limit=20.0,
    score=Score(_tilt_rms, "deg RMS tilt error", ((0.5, 1.0), (1.2, 0.5))),
    hints=(
        "Start with imu.estimate_attitude. Pushes are larger than noise: most samples of a braking "
        "robot are not exactly g long.",
        "The gate of MahonyGains leaves such samples out. The noise is 0.005 m/s²: try a gate of a "
        "few times that, and a low k_p.",
        "The first second is at rest: its mean is the bias. np.interp bridges the gaps.",
    ),
    mistakes=(
        Mistake(
            "the plain filter",
            "This is the filter as it stands: it believes every push and every hit.",
            _filter(),
        ),
        Mistake(
            "accelerometer alone",
            "This takes the tilt from the accelerometer alone: every push is a tilt.",
            lambda gyro, accel, dt: imu.attitude_from_accel(_hold(accel)),
        ),
        Mistake(
            "gyroscope alone",
            "This integrates the gyroscope alone: bias and gaps add up.",
            _filter(k_p=0.0),
        ),
    ),
)


def _hold(samples: np.ndarray) -> np.ndarray:
    """The last sample that was there."""
    rows = np.where(np.isfinite(samples).all(axis=1), np.arange(len(samples)), 0)
    return samples[np.maximum.accumulate(rows)]
