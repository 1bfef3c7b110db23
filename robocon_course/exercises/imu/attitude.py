"""Gravity, the Mahony filter and its angles, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import geometry, imu
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.geometry import GRAVITY
from robocon_course.worlds import DT, Student


def _attitudes(rng: np.random.Generator, count: int) -> list[np.ndarray]:
    vectors = rng.normal(size=(count, 4))
    return list(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def _gravity_direction_cases(student: Student, rng: np.random.Generator) -> list[Case]:
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
            "(w² − 0.5 + z²). A tilt of 20° would read as 10.3°. Double z.",
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


def _mahony_step_cases(student: Student, rng: np.random.Generator) -> list[Case]:
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
        ("one gyroscope axis is missing", leaning, [0.1, np.nan, 0.0], up, pi),
        ("the accelerometer reads infinity", leaning, calm, [np.inf, 0.0, 1.0], pi),
        ("a sample 0.4 m/s² too long, gate 0.5", leaning, calm, [0.0, 0.0, GRAVITY + 0.4], gated),
        ("a push of 3 m/s², gate 0.5 m/s²", leaning, calm, [3.0, 0.0, GRAVITY + 1], gated),
        ("a push to the side, gate 0.5 m/s²", leaning, calm, [3.5, 0.0, GRAVITY], gated),
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
    old_integral: bool = False,
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
        before = integral
        integral = integral + gains.k_i * push * (dt if integral_dt else 1.0)
        omega = rate(gyro) + gains.k_p * push + (before if old_integral else integral)
        q = q + half * dt * turn(q, np.array([0.0, *omega]))
        return imu.MahonyState(q / np.linalg.norm(q) if normalise else q, integral)

    return function


MAHONY_STEP = Exercise(
    id="imu.mahony_step",
    title="One step of the Mahony filter",
    points=4,
    reference=imu.mahony_step,
    shortcuts=("robocon_course.imu.mahony.mahony_update",),
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
            "integral of the sample before",
            "The corrected rate uses the integral from before this sample. Update the integral "
            "first, then add it.",
            _mahony(old_integral=True),
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
            "A missing sample (NaN) or free fall gets into the attitude, and stays there for the "
            "rest of the match. Skip what is not finite or has no direction.",
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


def _euler_angles_cases(student: Student, rng: np.random.Generator) -> list[Case]:
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
    # Clipping gives 90°, normalising first gives 89.99°: the tolerance lets both be right.
    steep = geometry.quaternion_from_euler(0.0, np.radians(89.99), 0.0) * (1 + 1e-7)
    rounded = Case("nose almost straight down, rounded", (steep,), "rad", 1e-3)
    return [*(Case(what, (quaternion,), "rad", 1e-6) for what, quaternion in cases), rounded]


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
