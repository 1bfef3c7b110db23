"""Chapter 01: the exercises of the IMU, and how people get them wrong."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from robocon_course import geometry, imu, worlds
from robocon_course.answers.process import Reply
from robocon_course.exercises.model import (
    Case,
    Chapter,
    Exercise,
    Mistake,
    Number,
    Score,
)
from robocon_course.simulator import sensors

GRAVITY = worlds.GRAVITY
DT = worlds.DT
BLOCK = 50


# --- calibrate_gyro ---------------------------------------------------------------------------


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
        if any(abs(found - row) <= 2 * BLOCK for found in rows):
            return None
        return f"the message does not say where it moved (about row {row}): {reply.message!r}"

    return judge


def _calibrate_gyro_cases(student: int, rng: np.random.Generator) -> list[Case]:
    cases = [Case("a robot at rest", (_still_log(rng),), "rad/s", 2e-4) for _ in range(3)]
    for what in ("somebody turns the robot", "somebody bumps into the robot"):
        log, row = _moved_log(rng)
        cases.append(Case(what, (log,), "rad/s", judge=_names_row(row)))
    return cases


def _refusing(bias: Callable[[np.ndarray], np.ndarray]) -> Callable[..., imu.GyroCalibration]:
    """A wrong way to average, with a right way to refuse."""

    def function(still: np.ndarray) -> imu.GyroCalibration:
        right = imu.calibrate_gyro(still)
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
    fields=("bias",),
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
            "The sign is reversed. A bias is what the sensor says too much; later it is subtracted.",
            _refusing(lambda still: -still.mean(axis=0)),
        ),
        Mistake(
            "sum instead of mean",
            "This is the sum of all samples. Divide by their number.",
            _refusing(lambda still: still.sum(axis=0)),
        ),
    ),
)


# --- calibrate_accelerometer ------------------------------------------------------------------


def _calibrate_accelerometer_cases(student: int, rng: np.random.Generator) -> list[Case]:
    cases = [
        Case("a perfect sensor", (GRAVITY * np.vstack([np.eye(3), -np.eye(3)]),), "m/s²", 1e-9)
    ]
    for what in ("your own sensor", "another sensor", "a third sensor"):
        rests = worlds.rest_means(_some_imu(rng), rng)
        cases.append(Case(what, (rng.permutation(rests),), "m/s²", 1e-6))
    counts = np.round(16384 * cases[1].args[0] / GRAVITY)
    cases.append(Case("raw counts, where 1 g is about 16384", (counts,), "counts", 1e-6))
    return cases


def _six_positions(
    bias: Callable[[np.ndarray], np.ndarray], scale: Callable[[np.ndarray], np.ndarray]
) -> Callable[..., imu.AccelerometerCalibration]:
    def function(rests: np.ndarray) -> imu.AccelerometerCalibration:
        return imu.AccelerometerCalibration(bias=bias(rests), scale=scale(rests))

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
    fields=("bias", "scale"),
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


# --- fit_ellipsoid ----------------------------------------------------------------------------


def _fit_ellipsoid_cases(student: int, rng: np.random.Generator) -> list[Case]:
    cases = []
    for what in ("slow turns of your own sensor", "slow turns of another sensor"):
        turns = sensors.imu_measurements(*sensors.slow_turns(DT, lean=worlds.LEAN), DT, _some_imu(rng), rng)[1]
        cases.append(Case(what, (turns[::10],), "m/s²", 0.02))
    direction = rng.normal(size=(40, 3))
    up = GRAVITY * direction / np.linalg.norm(direction, axis=1, keepdims=True)
    tilted = np.round(up / [1.05, 0.97, 1.01] + [0.3, -0.2, 0.1], 4)
    cases.append(Case("forty positions, no axis ever vertical", (tilted,), "m/s²", 0.005))
    return cases


def _sphere(samples: np.ndarray) -> imu.AccelerometerCalibration:
    """One radius for all axes."""
    unknowns = np.c_[2 * samples, np.ones(len(samples))]
    found = np.linalg.lstsq(unknowns, (samples**2).sum(axis=1), rcond=None)[0]
    radius = np.sqrt(found[3] + found[:3] @ found[:3])
    return imu.AccelerometerCalibration(bias=found[:3], scale=np.full(3, GRAVITY / radius))


def _with_right_fit(
    change: Callable[[imu.AccelerometerCalibration, np.ndarray], tuple[np.ndarray, np.ndarray]],
) -> Callable[..., imu.AccelerometerCalibration]:
    def function(samples: np.ndarray) -> imu.AccelerometerCalibration:
        bias, scale = change(imu.fit_ellipsoid(samples), samples)
        return imu.AccelerometerCalibration(bias=bias, scale=scale)

    return function


FIT_ELLIPSOID = Exercise(
    id="imu.fit_ellipsoid",
    title="Bias and scale when no axis was ever vertical",
    points=3,
    reference=imu.fit_ellipsoid,
    cases=_fit_ellipsoid_cases,
    fields=("bias", "scale"),
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


# --- gravity_direction ------------------------------------------------------------------------


def _attitudes(rng: np.random.Generator, count: int) -> list[np.ndarray]:
    vectors = rng.normal(size=(count, 4))
    return list(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _gravity_direction_cases(student: int, rng: np.random.Generator) -> list[Case]:
    named = [
        ("level", (0.0, 0.0, 0.0)),
        ("20° of roll", (np.radians(20), 0.0, 0.0)),
        ("45° of pitch, nose down", (0.0, np.radians(45), 0.0)),
        ("level, turned left by 90°", (0.0, 0.0, np.radians(90))),
        ("leaning and turned", (0.3, -0.4, 1.2)),
    ]
    cases = [(what, geometry.quaternion_from_euler(*angles)) for what, angles in named]
    cases += [("any attitude", quaternion) for quaternion in _attitudes(rng, 10)]
    return [Case(what, (quaternion,), "", 1e-9) for what, quaternion in cases]


def _half_gravity(quaternion: np.ndarray) -> np.ndarray:
    up = imu.gravity_direction(quaternion)
    return np.array([up[0], up[1], up[2] / 2])


GRAVITY_DIRECTION = Exercise(
    id="imu.gravity_direction",
    title="Where up is, seen from the robot",
    points=1,
    reference=imu.gravity_direction,
    cases=_gravity_direction_cases,
    hints=(
        "The map's z axis, turned into body axes: the third row of R(q).",
        "Level means (0, 0, 1). All three components have the factor 2, or z is w² − x² − y² + z².",
        "[2(xz − wy), 2(wx + yz), w² − x² − y² + z²]",
    ),
    mistakes=(
        Mistake(
            "half gravity",
            "x and y are full components and z is half of one, as one of the sources prints it "
            "(q0² − 0.5 + q3²). A tilt of 20° would read as 10.3°. Double z.",
            _half_gravity,
        ),
        Mistake(
            "world for body",
            "This turns the wrong way: it is the body's z axis seen from the map. The sensor needs "
            "the map's z axis seen from the body, the third row of R(q), not the third column.",
            lambda q: geometry.rotate(q, np.array([0.0, 0.0, 1.0])),
        ),
        Mistake(
            "down",
            "This points down, where things fall. An accelerometer at rest reads upwards: it "
            "feels the table that pushes it.",
            lambda q: -imu.gravity_direction(q),
        ),
        Mistake(
            "order of the quaternion",
            "The quaternion is read as (x, y, z, w). In this course it is (w, x, y, z).",
            lambda q: imu.gravity_direction(np.roll(q, 1)),
        ),
        Mistake(
            "in m/s²",
            "This is 9.81 long. A direction has length 1.",
            lambda q: GRAVITY * imu.gravity_direction(q),
        ),
    ),
)


# --- mahony_step ------------------------------------------------------------------------------


def _mahony_step_cases(student: int, rng: np.random.Generator) -> list[Case]:
    p, pi = imu.MahonyGains(1.0, 0.0), imu.MahonyGains(1.5, 0.3)
    gated = imu.MahonyGains(1.0, 0.1, gate=0.5)
    level, up = imu.MahonyState(np.array([1.0, 0, 0, 0]), np.zeros(3)), [0.0, 0.0, GRAVITY]
    leaning = imu.MahonyState(geometry.quaternion_from_euler(0.3, 0.0, 0.0), np.zeros(3))
    calm, nan = np.zeros(3), np.full(3, np.nan)
    named = [
        ("level and at rest: nothing changes", level, calm, up, p),
        ("turning left at 1 rad/s", level, [0.0, 0.0, 1.0], up, p),
        ("the attitude leans, the accelerometer does not", leaning, calm, up, p),
        ("the same with an integral part", leaning, calm, up, pi),
        ("the accelerometer sample is missing (NaN)", leaning, [0.1, 0.2, 0.3], nan, pi),
        ("free fall: the accelerometer reads 0", leaning, [0.1, 0.2, 0.3], calm, pi),
        ("the gyroscope sample is missing (NaN)", leaning, nan, up, pi),
        ("a push of 3 m/s², gate 0.5 m/s²", leaning, calm, [3.0, 0.0, GRAVITY + 1], gated),
        ("no push, gate 0.5 m/s²", leaning, calm, [0.2, 0.0, GRAVITY], gated),
    ]
    for quaternion in _attitudes(rng, 6):
        state = imu.MahonyState(quaternion, rng.uniform(-0.05, 0.05, 3))
        accel = GRAVITY * imu.gravity_direction(quaternion) + rng.normal(0, 2.0, 3)
        named.append(("turning, leaning, speeding up", state, rng.normal(0, 1, 3), accel, pi))
    return [
        Case(what, (state, np.array(gyro), np.array(accel), DT, gains), "", 1e-9)
        for what, state, gyro, accel, gains in named
    ]


def _mahony(
    *,
    up: Callable[[np.ndarray], np.ndarray] = imu.gravity_direction,
    error: Callable[[np.ndarray, np.ndarray], np.ndarray] = np.cross,
    unit: bool = True,
    integral_dt: bool = True,
    turn: Callable[[np.ndarray, np.ndarray], np.ndarray] = geometry.quaternion_multiply,
    half: float = 0.5,
    normalise: bool = True,
    careful: bool = True,
    gated: bool = True,
    rate: Callable[[np.ndarray], np.ndarray] = lambda gyro: gyro,
) -> Callable[..., imu.MahonyState]:
    """The filter with one of its steps done wrongly."""

    def function(
        state: imu.MahonyState,
        gyro: np.ndarray,
        accel: np.ndarray,
        dt: float,
        gains: imu.MahonyGains,
    ) -> imu.MahonyState:
        q, integral = np.array(state.quaternion), np.array(state.integral)
        if careful and not np.isfinite(gyro).all():
            return imu.MahonyState(q, integral)
        push = np.zeros(3)
        length = np.linalg.norm(accel)
        inside = not gated or abs(length - GRAVITY) <= gains.gate
        if not careful or (0 < length < np.inf and inside):
            with np.errstate(all="ignore"):
                push = error(accel / length if unit else accel, up(q))
        integral = integral + gains.k_i * push * (dt if integral_dt else 1.0)
        omega = rate(gyro) + gains.k_p * push + integral
        q = q + half * dt * turn(q, np.array([0.0, *omega]))
        return imu.MahonyState(q / np.linalg.norm(q) if normalise else q, integral)

    return function


MAHONY_STEP = Exercise(
    id="imu.mahony_step",
    title="One step of the Mahony filter",
    points=4,
    reference=imu.mahony_step,
    cases=_mahony_step_cases,
    hints=(
        "Five lines: error, integral, corrected rate, turn the quaternion, normalise. Before "
        "them: without a gyroscope sample return the state; the error is 0 unless "
        "0 < |a| < inf and the length is within the gate.",
        "error = cross(measured up, estimated up); integral += k_i · error · dt; "
        "rate = gyro + k_p · error + integral.",
        "q + 0.5 · dt · (q ⊗ (0, rate)), then divide by its length. "
        "geometry.quaternion_multiply(q, [0, *rate]) is the product.",
    ),
    mistakes=(
        Mistake(
            "half gravity",
            "Estimated up has half a z component. The filter then settles at "
            "tan(estimate) = tan(true)/2: 20° reads as 10.3°.",
            _mahony(up=_half_gravity),
        ),
        Mistake(
            "error reversed",
            "The cross product is the other way round: the filter runs away from gravity instead "
            "of towards it. Measured × estimated.",
            _mahony(error=lambda measured, up: np.cross(up, measured)),
        ),
        Mistake(
            "accelerometer not normalised",
            "The accelerometer is not divided by its length: the gain becomes 9.8 times larger, "
            "and a push counts more than gravity.",
            _mahony(unit=False),
        ),
        Mistake(
            "no dt in the integral",
            "The integral grows by k_i · error, without dt: it depends on the sample rate, and at "
            "100 Hz it is a hundred times too fast.",
            _mahony(integral_dt=False),
        ),
        Mistake(
            "world frame",
            "The rate is multiplied from the left, as if it were in map axes. The gyroscope turns "
            "with the body: q ⊗ (0, rate).",
            _mahony(turn=lambda q, rate: geometry.quaternion_multiply(rate, q)),
        ),
        Mistake(
            "half forgotten",
            "The factor ½ is missing in q' = ½ q ⊗ (0, rate): everything turns twice as fast.",
            _mahony(half=1.0),
        ),
        Mistake(
            "not normalised",
            "The quaternion is not divided by its length. It grows a little at every step.",
            _mahony(normalise=False),
        ),
        Mistake(
            "bad samples believed",
            "A missing sample (NaN) or free fall gets into the attitude, and stays there for the rest "
            "of the match. Skip what is not finite or has no direction.",
            _mahony(careful=False),
        ),
        Mistake(
            "gate forgotten",
            "The gate is not used: a sample whose length is further than gains.gate from 9.80665 "
            "is a push, not gravity, and must not correct the tilt.",
            _mahony(gated=False),
        ),
        Mistake(
            "degrees",
            "The gyroscope is turned into degrees (or taken for them). It is in rad/s already.",
            _mahony(rate=np.degrees),
        ),
        Mistake(
            "degrees taken for radians",
            "The gyroscope is converted once more. It is in rad/s already.",
            _mahony(rate=np.radians),
        ),
    ),
)


# --- euler_angles -----------------------------------------------------------------------------


def _euler_angles_cases(student: int, rng: np.random.Generator) -> list[Case]:
    named = [
        ("level", (0.0, 0.0, 0.0)),
        ("20° of roll", (np.radians(20), 0.0, 0.0)),
        ("10° of pitch, nose down", (0.0, np.radians(10), 0.0)),
        ("turned left by 135°", (0.0, 0.0, np.radians(135))),
        ("upside down", (np.radians(170), 0.0, 0.0)),
        ("on the ramp, turned right", (np.radians(-2), np.radians(-5.7), np.radians(-120))),
    ]
    cases = [(what, geometry.quaternion_from_euler(*angles)) for what, angles in named]
    cases += [("any attitude", quaternion) for quaternion in _attitudes(rng, 10)]
    # A quaternion a little longer than 1 pushes the argument of asin past 1, and asin is then NaN.
    steep = geometry.quaternion_from_euler(0.0, np.radians(89.99), 0.0) * (1 + 1e-7)
    cases.append(("nose almost straight down, rounded", steep))
    return [Case(what, (quaternion,), "rad", 1e-6) for what, quaternion in cases]


def _changed_angles(
    change: Callable[[float, float, float], tuple[float, float, float]],
) -> Callable[..., np.ndarray]:
    return lambda quaternion: np.array(change(*imu.euler_angles(quaternion)))


def _plain_atan(quaternion: np.ndarray) -> np.ndarray:
    w, x, y, z = quaternion
    with np.errstate(all="ignore"):
        roll = np.arctan(2 * (w * x + y * z) / (w * w - x * x - y * y + z * z))
        yaw = np.arctan(2 * (w * z + x * y) / (w * w + x * x - y * y - z * z))
    return np.array([roll, imu.euler_angles(quaternion)[1], yaw])


def _no_clip(quaternion: np.ndarray) -> np.ndarray:
    roll, _, yaw = imu.euler_angles(quaternion)
    w, x, y, z = quaternion
    with np.errstate(all="ignore"):
        return np.array([roll, np.arcsin(2 * (w * y - x * z)), yaw])


EULER_ANGLES = Exercise(
    id="imu.euler_angles",
    title="Roll, pitch and yaw",
    points=2,
    reference=imu.euler_angles,
    cases=_euler_angles_cases,
    hints=(
        "Roll and yaw are each an atan2, pitch is an asin.",
        "roll = atan2(2(wx + yz), 1 − 2(x² + y²)), pitch = asin(2(wy − xz)), "
        "yaw = atan2(2(wz + xy), 1 − 2(y² + z²)).",
        "Rounding can push the argument of asin past 1: np.clip(…, -1, 1).",
    ),
    mistakes=(
        Mistake(
            "degrees",
            "These are degrees. The course's angles are in radians until they are printed.",
            _changed_angles(lambda roll, pitch, yaw: tuple(np.degrees([roll, pitch, yaw]))),
        ),
        Mistake(
            "yaw first",
            "The order is yaw, pitch, roll. The course's order is roll, pitch, yaw: x, y, z.",
            _changed_angles(lambda roll, pitch, yaw: (yaw, pitch, roll)),
        ),
        Mistake(
            "sign of pitch",
            "Pitch has the wrong sign: nose down is positive, since y points left.",
            _changed_angles(lambda roll, pitch, yaw: (roll, -pitch, yaw)),
        ),
        Mistake(
            "sign of yaw",
            "Yaw has the wrong sign: a left turn is positive.",
            _changed_angles(lambda roll, pitch, yaw: (roll, pitch, -yaw)),
        ),
        Mistake(
            "atan instead of atan2",
            "atan of a quotient cannot tell front from back: beyond ±90° it is half a turn off. "
            "Use atan2 with both parts.",
            _plain_atan,
        ),
        Mistake(
            "asin past one",
            "Rounding pushed the argument of asin past 1, and the pitch became NaN just when the "
            "nose pointed straight down. Clip it to [−1, 1].",
            _no_clip,
        ),
    ),
)


# --- numbers from the student's own world -----------------------------------------------------


def _true_bias(student: int) -> float:
    return float(np.degrees(worlds.own_imu(student).gyro_bias[2]))


def _yaw_drift(student: int, *, calibrated: bool = False) -> float:
    """Yaw at the end of the match beside the truth [deg]."""
    world = worlds.imu_world(student)
    bias = imu.calibrate_gyro(world.still).bias if calibrated else np.zeros(3)
    log = imu.estimate_attitude(world.gyro - bias, world.accel, world.dt)
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


# --- challenge --------------------------------------------------------------------------------


def _attitude_in_motion_cases(student: int, rng: np.random.Generator) -> list[Case]:
    drives = [worlds.rough_drive(rng) for _ in range(3)]
    return [Case("a rough drive", (d.gyro, d.accel, DT), truth=d.truth) for d in drives]


def _tilt_rms(case: Case, quaternions: np.ndarray) -> float:
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


CHAPTER = Chapter(
    number="01",
    topic="imu",
    title="IMU: calibration and the Mahony filter",
    minutes=210,
    needs=("chapter 00", "vectors", "NumPy arrays"),
    exercises=(
        CALIBRATE_GYRO,
        OWN_BIAS,
        CALIBRATE_ACCELEROMETER,
        FIT_ELLIPSOID,
        GRAVITY_DIRECTION,
        MAHONY_STEP,
        EULER_ANGLES,
        OWN_DRIFT,
        ATTITUDE_IN_MOTION,
    ),
)
