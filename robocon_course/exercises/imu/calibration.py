"""Bias and scale, and how people get them wrong."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from robocon_course import imu, worlds
from robocon_course.answers.process import Reply
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.geometry import GRAVITY
from robocon_course.simulator import sensors
from robocon_course.worlds import DT, Student

BLOCK = 50


def _still_log(rng: np.random.Generator) -> np.ndarray:
    errors = _some_imu(rng)
    return sensors.imu_measurements(*sensors.still(15.0, DT), DT, errors, rng)[0]


def _some_imu(rng: np.random.Generator) -> sensors.ImuErrors:
    return worlds.own_imu(int(rng.integers(1 << 30)), "case")


def _moved_log(rng: np.random.Generator) -> tuple[np.ndarray, int]:
    """A still log in which somebody turns the robot for half a second, and the row where."""
    log = _still_log(rng)
    row = int(rng.integers(200, len(log) - 200))
    log[row : row + BLOCK, rng.integers(3)] += rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.6)
    return log, row


def _names_row(row: int) -> Callable[[Reply], str | None]:
    """A judge: the log must be refused, and the message must say where it moved."""

    def judge(reply: Reply) -> str | None:
        if not reply.error:
            return "the log moved, but the function returned a bias instead of refusing it"
        if reply.error not in ("ValueError", "MovedError"):
            return f"expected a ValueError, got {reply.error}: {reply.message}"
        rows = [float(number) for number in re.findall(r"\d+\.?\d*", reply.message)]
        if len(rows) <= 6 and any(abs(found - row) <= 2 * BLOCK for found in rows):
            return None
        return f"the message does not say where it moved (about row {row}): {reply.message!r}"

    return judge


def _calibrate_gyro_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    bias = {"bias": 3e-5}  # a mean of 1500 samples is good to 1e-5
    cases = [Case("a robot at rest", (_still_log(rng),), "rad/s", bias) for _ in range(3)]
    hum, noisy = _still_log(rng), _still_log(rng)
    hum[300:350, 1] += 0.006
    cases.append(Case("at rest, one block 0.006 rad/s off", (hum,), "rad/s", bias))
    noisy += rng.normal(0.0, 0.03, noisy.shape)
    cases.append(Case("at rest with a noisy sensor", (noisy,), "rad/s", {"bias": 1e-3}))
    for what in ("somebody turns the robot", "somebody bumps into the robot"):
        log, row = _moved_log(rng)
        cases.append(Case(what, (log,), "rad/s", judge=_names_row(row)))
    slow = _still_log(rng)
    slow[:50, 2] += 0.05
    slow[800:900, 0] -= 0.4
    cases.append(
        Case("a slow turn at once, a fast one later", (slow,), "rad/s", judge=_names_row(0))
    )
    return cases


def _refusing(bias: Callable[[np.ndarray], np.ndarray]) -> Callable[..., imu.GyroCalibration]:
    """A wrong way to average, with a right way to refuse."""

    def function(still: np.ndarray) -> imu.GyroCalibration:
        try:
            right = imu.calibrate_gyro(still)
        except imu.MovedError as error:
            raise ValueError(str(error)) from None
        return imu.GyroCalibration(bias=bias(still), noise=right.noise)

    return function


def _without_row(still: np.ndarray) -> imu.GyroCalibration:
    try:
        return imu.calibrate_gyro(still)
    except imu.MovedError:
        raise ValueError("the robot moved") from None


CALIBRATE_GYRO = Exercise(
    id="imu.calibrate_gyro",
    title="Gyroscope bias from a log at rest",
    points=3,
    reference=imu.calibrate_gyro,
    cases=_calibrate_gyro_cases,
    hints=(
        "A robot at rest turns at 0 rad/s. Whatever the gyroscope says on average is its bias.",
        "Cut the log into blocks of 50 rows. At rest every block has the same mean, but for noise. "
        "Compare each block's mean with the median of all blocks.",
        "blocks = still[:len(still) // 50 * 50].reshape(-1, 50, 3).mean(axis=1); a block further "
        "than 0.02 rad/s from np.median(blocks, axis=0) moved. Its first row is 50 × its number.",
    ),
    mistakes=(
        Mistake(
            "never refuses",
            "It averages a log that moved. The turn then hides in the bias, and the robot believes "
            "that it turns for the rest of the match. Look at blocks of the log first.",
            lambda still: imu.GyroCalibration(bias=np.mean(still, axis=0), noise=np.zeros(3)),
        ),
        Mistake(
            "does not say when",
            "It refuses, but does not say when the log moved. Put the row into the message, so "
            "that whoever reads it can look there.",
            _without_row,
        ),
        Mistake(
            "degrees per second",
            "The bias is in degrees per second. Everything in the robot is in radians.",
            _refusing(lambda still: np.degrees(still.mean(axis=0))),
        ),
        Mistake(
            "mean of absolute values",
            "It averages absolute values: noise never cancels, and the sign is lost.",
            _refusing(lambda still: np.abs(still).mean(axis=0)),
        ),
        Mistake(
            "sign reversed",
            "The sign is reversed. A bias is what the sensor says too much; later it is taken off.",
            _refusing(lambda still: -still.mean(axis=0)),
        ),
        Mistake(
            "sum instead of mean",
            "This is the sum of all samples. Divide by their number.",
            _refusing(lambda still: still.sum(axis=0)),
        ),
    ),
)


def _calibrate_accelerometer_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    close = {"bias": 5e-3, "scale": 5e-4}
    cases = [Case("a perfect sensor", (GRAVITY * np.vstack([np.eye(3), -np.eye(3)]),), "", close)]
    for what in ("your own sensor", "another sensor", "a third sensor"):
        rests = worlds.rest_means(_some_imu(rng), rng)
        cases.append(Case(what, (rng.permutation(rests),), "", close))
    cases.append(Case("gravity as in Quito, 9.77 m/s²", (rests, 9.77), "", close))
    counts = np.round(16384 * rests / GRAVITY) + np.array([900.0, -400.0, 150.0])
    close = {"bias": 10.0, "scale": 3e-7}
    cases.append(Case("raw counts, where 1 g is about 16384", (counts,), "", close))
    return cases


def _six_positions(
    bias: Callable[[np.ndarray], np.ndarray], scale: Callable[[np.ndarray], np.ndarray]
) -> Callable[..., imu.AccelerometerCalibration]:
    def function(rests: np.ndarray, gravity: float = GRAVITY) -> imu.AccelerometerCalibration:
        return imu.AccelerometerCalibration(bias(rests), scale(rests) * gravity / GRAVITY)

    return function


def _middle(rests: np.ndarray) -> np.ndarray:
    return (rests.max(axis=0) + rests.min(axis=0)) / 2


def _gain(rests: np.ndarray) -> np.ndarray:
    return 2 * GRAVITY / (rests.max(axis=0) - rests.min(axis=0))


CALIBRATE_ACCELEROMETER = Exercise(
    id="imu.calibrate_accelerometer",
    title="Accelerometer bias and scale from six positions",
    points=2,
    reference=imu.calibrate_accelerometer,
    cases=_calibrate_accelerometer_cases,
    hints=(
        "With an axis up the sensor reads +g/scale + bias, with the axis down −g/scale + bias.",
        "Add the two readings and the gravity goes away; subtract them and the bias goes away.",
        "bias = (max + min)/2 and scale = 2g/(max − min), for each axis: rests.max(axis=0).",
    ),
    mistakes=(
        Mistake(
            "gravity taken for bias",
            "The bias holds gravity: it is the mean of a log at rest, as printed in one of the "
            "sources. At rest an accelerometer does not read 0, it reads g upwards.",
            _six_positions(lambda rests: rests[np.argmax(rests[:, 2])], _gain),
        ),
        Mistake(
            "gravity ignored",
            "The argument gravity is not used: g is not 9.80665 everywhere.",
            lambda rests, gravity=GRAVITY: imu.calibrate_accelerometer(rests),
        ),
        Mistake(
            "scale upside down",
            "The scale is upside down: it multiplies the raw value, so it is 2g/(max − min).",
            _six_positions(_middle, lambda rests: 1 / _gain(rests)),
        ),
        Mistake(
            "half the scale",
            "The scale is half of what it should be: from down to up are 2g, not g.",
            _six_positions(_middle, lambda rests: _gain(rests) / 2),
        ),
        Mistake(
            "half difference as bias",
            "The bias is half the difference of up and down; that is gravity. Take half the sum.",
            _six_positions(lambda rests: (rests.max(axis=0) - rests.min(axis=0)) / 2, _gain),
        ),
        Mistake(
            "scale in g",
            "The scale turns raw values into multiples of g. The course needs m/s²: times 9.80665.",
            _six_positions(_middle, lambda rests: _gain(rests) / GRAVITY),
        ),
        Mistake(
            "bias of the corrected value",
            "The bias is multiplied by the scale already. It is subtracted first, then scaled.",
            _six_positions(lambda rests: _middle(rests) * _gain(rests), _gain),
        ),
    ),
)


def _fit_ellipsoid_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = []
    for what in ("slow turns of your own sensor", "slow turns of another sensor"):
        turns = sensors.imu_measurements(
            *sensors.slow_turns(DT, lean=worlds.LEAN), DT, _some_imu(rng), rng
        )[1]
        cases.append(Case(what, (turns[::10],), "", {"bias": 0.02, "scale": 1e-3}))
    direction = rng.normal(size=(40, 3))
    up = GRAVITY * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    tilted = np.round(up / [1.05, 0.97, 1.01] + [0.3, -0.2, 0.1], 4)
    close = {"bias": 5e-3, "scale": 5e-4}
    cases.append(Case("forty positions, no axis ever vertical", (tilted,), "", close))
    far = np.round(up / [1.1, 0.93, 1.0] + [2.5, -2.0, 1.5], 4)
    cases.append(Case("a very large bias", (far,), "", close))
    cases.append(Case("gravity as in Quito, 9.77 m/s²", (tilted, 9.77), "", close))
    return cases


def _sphere(samples: np.ndarray, gravity: float = GRAVITY) -> imu.AccelerometerCalibration:
    """One radius for all axes."""
    unknowns = np.c_[2 * samples, np.ones(len(samples))]
    found = np.linalg.lstsq(unknowns, (samples**2).sum(axis=1), rcond=None)[0]
    radius = np.sqrt(found[3] + found[:3] @ found[:3])
    return imu.AccelerometerCalibration(bias=found[:3], scale=np.full(3, gravity / radius))


def _no_square(samples: np.ndarray, gravity: float = GRAVITY) -> imu.AccelerometerCalibration:
    """The half axes as if the centre were the origin."""
    unit = np.abs(samples).max()
    x = samples / unit
    found = np.linalg.lstsq(np.hstack([x**2, x]), np.ones(len(x)), rcond=None)[0]
    bias = -found[3:] / (2 * found[:3])
    return imu.AccelerometerCalibration(bias * unit, gravity * np.sqrt(found[:3]) / unit)


def _with_right_fit(
    change: Callable[[imu.AccelerometerCalibration, np.ndarray], tuple[np.ndarray, np.ndarray]],
) -> Callable[..., imu.AccelerometerCalibration]:
    def function(samples: np.ndarray, gravity: float = GRAVITY) -> imu.AccelerometerCalibration:
        bias, scale = change(imu.fit_ellipsoid(samples, gravity), samples)
        return imu.AccelerometerCalibration(bias=bias, scale=scale)

    return function


FIT_ELLIPSOID = Exercise(
    id="imu.fit_ellipsoid",
    title="Bias and scale when no axis was ever vertical",
    points=3,
    reference=imu.fit_ellipsoid,
    cases=_fit_ellipsoid_cases,
    hints=(
        "Corrected samples lie on a sphere of radius g, so raw ones lie on an ellipsoid. "
        "Six unknowns, three biases and three scales, and many more samples.",
        "A x² + B y² + C z² + D x + E y + F z = 1 is linear in its six unknowns: np.linalg.lstsq.",
        "Complete the square: bias_x = −D/(2A); with r = 1 + A bias_x² + B bias_y² + C bias_z² the "
        "half axes are sqrt(r/A), …, and scale_x = g / sqrt(r/A).",
    ),
    mistakes=(
        Mistake(
            "largest and smallest value",
            "This uses the largest and smallest reading. No axis was ever exactly vertical, so "
            "neither is a full g; and each is one sample with its noise. Use all samples.",
            _six_positions(_middle, _gain),
        ),
        Mistake(
            "square not completed",
            "The half axes are too short: the centre's own squares are missing. "
            "r = 1 + A b_x² + B b_y² + C b_z².",
            _no_square,
        ),
        Mistake(
            "one scale for all axes",
            "This fits a sphere: one scale for all axes. Each axis has a scale of its own.",
            _sphere,
        ),
        Mistake(
            "mean of the samples",
            "The bias is the mean of the samples. That is the centre only if the samples are "
            "spread evenly over the ellipsoid, and they never are.",
            _with_right_fit(lambda fit, samples: (samples.mean(axis=0), fit.scale)),
        ),
        Mistake(
            "scale in g",
            "The scale turns raw values into multiples of g. Multiply by 9.80665 m/s².",
            _with_right_fit(lambda fit, samples: (fit.bias, fit.scale / GRAVITY)),
        ),
        Mistake(
            "sign of the centre",
            "The centre has the wrong sign: A x² + D x has its minimum at x = −D/(2A).",
            _with_right_fit(lambda fit, samples: (-fit.bias, fit.scale)),
        ),
        Mistake(
            "square of the scale",
            "This is the square of the scale: a half axis is a square root.",
            _with_right_fit(lambda fit, samples: (fit.bias, fit.scale**2)),
        ),
    ),
)
