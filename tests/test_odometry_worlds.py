"""Chapter 02's robots, logs, rough drives and exercises: what they promise to a student."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
import pytest

from robocon_course import odometry, worlds
from robocon_course.answers.process import AnswerProcess
from robocon_course.autopilot import HEADINGS, Parts, dead_reckoning
from robocon_course.exercises import registry
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.source import Answer
from robocon_course.robot import DEAD_WHEELS

STUDENTS = [*range(0, 60, 7), 21306141022, "H1D021001"]
LEFT, RIGHT, REAR = range(3)


def counts(log) -> np.ndarray:
    """Counts of each sample of a log."""
    return odometry.tick_changes(log.counters, worlds.BITS)


def calibrated(student) -> odometry.TrackingWheels:
    """A student's wheels from the run and the spin."""
    world = worlds.odometry_world(student)
    run, spin = counts(world.run).sum(axis=0), counts(world.spin).sum(axis=0)
    return odometry.calibrate_wheels(DEAD_WHEELS, run, worlds.RUN, spin, worlds.SPIN)


def reckoned(wheels, log) -> np.ndarray:
    """Poses of a log by the package."""
    travel = odometry.wheel_travel(wheels, counts(log))
    return odometry.integrate(odometry.body_deltas(wheels, travel))


# --- a robot of one's own ------------------------------------------------------------------------


@pytest.mark.parametrize("student", STUDENTS)
def test_a_students_wheels_are_a_little_off_the_drawing(student):
    wheels = worlds.own_wheels(student)
    scale = np.abs(wheels.radius / DEAD_WHEELS.radius - 1.0)
    moved = np.abs(wheels.positions - DEAD_WHEELS.positions)
    assert ((0.0039 < scale) & (scale < 0.0101)).all()
    assert (moved[[LEFT, RIGHT], 1] < 0.0041).all() and 0.0019 < moved[REAR, 0] < 0.0061
    bends = (wheels.radius - DEAD_WHEELS.radius)[[LEFT, RIGHT]]
    assert bends[0] * bends[1] < 0.0, "a straight line must bend, or nothing shows"
    assert worlds.own_robot(student).dead_wheels.radius.tolist() == wheels.radius.tolist()


def test_a_students_logs_are_the_same_to_the_bit_on_every_machine():
    world = worlds.odometry_world(21306141022)
    logs = (world.run.counters, world.spin.counters, world.square.counters)
    digest = hashlib.sha256(b"".join(log.astype("<i8").tobytes() for log in logs)).hexdigest()
    assert digest[:16] == "f4b2de8dbd23b1ef"


@pytest.mark.parametrize("student", STUDENTS)
def test_the_counters_of_a_log_fit_its_truth(student):
    world = worlds.odometry_world(student)
    for log in (world.run, world.spin, world.square):
        assert log.counters.min() >= 0 and log.counters.max() < 1 << worlds.BITS
        off = reckoned(world.wheels, log) - log.poses
        # A count is 0.06 mm; wrong by one all the way, a heading is off by 0.0002 rad.
        assert np.abs(off[:, :2]).max() < 1e-3 and np.abs(off[:, 2]).max() < 5e-4
    assert world.spin.poses[-1] == pytest.approx([0, 0, worlds.SPIN], abs=1e-9)
    assert world.square.poses[-1, :2] == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize("student", STUDENTS)
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    world = worlds.odometry_world(student)
    end = reckoned(DEAD_WHEELS, world.square)[-1] - world.square.poses[-1]
    back = 1000.0 * (DEAD_WHEELS.positions[REAR, 0] - calibrated(student).positions[REAR, 0])
    for number, value in (
        ("odometry.own_square", 1000.0 * np.hypot(*end[:2])),
        ("odometry.own_offset", back),
    ):
        assert judge_number(registry.exercise(number), value, student).accepted
    assert np.hypot(*end[:2]) > 0.1
    good = reckoned(calibrated(student), world.square)[-1] - world.square.poses[-1]
    assert np.hypot(*good[:2]) < 0.03, "a run that turned by 0.1 degrees leaves a little"


# --- rough drives --------------------------------------------------------------------------------


def test_on_a_drive_without_faults_rough_reckoning_is_plain_reckoning():
    rng = np.random.default_rng(3)
    log = worlds.wheel_log(worlds.random_legs(rng, 20.0), DEAD_WHEELS, rng)
    rate = np.diff(log.poses[:, 2]) / log.dt
    poses = odometry.rough_drive_poses(DEAD_WHEELS, counts(log), rate + 0.01, log.dt)
    assert np.hypot(*(poses - log.poses)[:, :2].T).max() < 2e-3


def test_of_two_wheels_that_disagree_the_one_that_rolls_more_is_believed():
    ticks = np.tile([172, 172, 0], (300, 1))  # 1 m/s, straight ahead
    ticks[:100] = 0
    ticks[150:200, LEFT] = 0
    ticks[220:240, RIGHT] = -50
    poses = odometry.rough_drive_poses(DEAD_WHEELS, ticks, np.zeros(300), 0.01)
    way = 200 * 172 * DEAD_WHEELS.metres_per_tick[0]
    assert poses[-1] == pytest.approx([way, 0.0, 0.0], abs=1e-9)


def test_the_wheels_bridge_a_silent_gyroscope():
    turn = np.tile([0.0, 0.0, 0.01], (300, 1))
    turn[:100] = 0.0
    ticks = np.round(turn @ DEAD_WHEELS.matrix.T / DEAD_WHEELS.metres_per_tick)
    gyro = turn[:, 2] / 0.01 + 0.02
    gyro[150:250] = np.nan
    heading = odometry.rough_drive_poses(DEAD_WHEELS, ticks, gyro, 0.01)[-1, 2]
    assert heading == pytest.approx(2.0, abs=0.02)  # half a count in 46, for 100 samples


def test_rough_reckoning_refuses_a_start_without_gyroscope():
    gyro = np.full(300, np.nan)
    with pytest.raises(ValueError, match="start at rest"):
        odometry.rough_drive_poses(DEAD_WHEELS, np.zeros((300, 3)), gyro, 0.01)


@pytest.mark.parametrize("seed", range(20))
def test_a_rough_drive_can_be_followed_and_not_by_its_wheels_alone(seed):
    drive = worlds.rough_drive_log(np.random.default_rng(seed))
    poses = odometry.rough_drive_poses(drive.wheels, drive.ticks, drive.gyro, drive.dt)
    assert np.hypot(*(poses - drive.poses)[:, :2].T).max() < 0.05
    travel = odometry.wheel_travel(drive.wheels, drive.ticks)
    plain = odometry.integrate(odometry.body_deltas(drive.wheels, travel))
    assert np.hypot(*(plain - drive.poses)[:, :2].T).max() > 1.0
    assert np.isnan(drive.gyro).any() and (drive.ticks[:100] == 0).all()


# --- drives in the simulator, and the parts in a row ---------------------------------------------


def test_an_ideal_drive_is_followed_to_millimetres_whoever_says_the_heading():
    drive = worlds.simulated_drive(7, "ideal", 20.0)
    for heading in HEADINGS:
        poses = dead_reckoning(Parts(), drive.observations, start=drive.poses[0], heading=heading)
        assert poses.shape == drive.poses.shape
        assert np.hypot(*(poses - drive.poses)[:, :2].T).max() < 5e-3


@pytest.mark.parametrize("student", [0, 7, 1234])
def test_a_noisy_drive_goes_about_its_area_and_begins_at_rest(student):
    drive = worlds.simulated_drive(student, "noisy", 40.0)
    assert len(drive.observations) == len(drive.poses) == len(drive.time) == 2001
    assert np.hypot(*np.diff(drive.poses[:, :2], axis=0).T).sum() > 15.0
    assert (drive.poses[:, :2] > (0.5, 0.7)).all() and (drive.poses[:, :2] < (5.3, 2.7)).all()
    assert np.ptp(drive.poses[: drive.rest], axis=0).max() < 1e-9
    bias = odometry_bias(drive)
    assert bias == pytest.approx(worlds.own_imu(student).gyro_bias[2], abs=np.radians(0.02))


def odometry_bias(drive) -> float:
    """What the gyroscope says about z before the first leg."""
    return float(drive.still[:, 2].mean())


def test_the_same_student_drives_the_same_way_twice():
    one, two = (worlds.simulated_drive(5, "degraded", 10.0) for _ in range(2))
    assert np.array_equal(one.poses, two.poses)
    assert [o.ticks.tolist() for o in one.observations] == [
        o.ticks.tolist() for o in two.observations
    ]


def test_a_lost_encoder_turns_the_wheels_heading_but_not_the_fused_one():
    drive = worlds.simulated_drive(7, "degraded", 40.0)
    errors = {}
    for heading in HEADINGS:
        poses = dead_reckoning(
            Parts(), drive.observations, drive.wheels, start=drive.poses[0], heading=heading,
            bias=odometry_bias(drive),
        )  # fmt: skip
        errors[heading] = np.degrees(np.abs(poses - drive.poses)[:, 2].max())
    assert errors["wheels"] > 10.0 and errors["fused"] < 1.0 and errors["gyro"] < 1.0


def test_reckoning_runs_on_the_parts_that_it_is_given():
    asked = []

    def integrate(deltas, start):
        asked.append(len(deltas))
        return odometry.integrate(deltas, start)

    drive = worlds.simulated_drive(7, "ideal", 5.0)
    dead_reckoning(replace(Parts(), integrate=integrate), drive.observations)
    assert asked == [250]


def test_an_unknown_heading_or_drive_is_refused():
    with pytest.raises(ValueError, match="heading: expected one of wheels, gyro, fused"):
        dead_reckoning(Parts(), (), heading="compass")
    with pytest.raises(ValueError, match="kind: expected one of ideal, noisy, degraded"):
        worlds.simulated_drive(0, "wild")


# --- answers in another style --------------------------------------------------------------------

OTHER_STYLES = {
    "odometry.tick_changes": """
def tick_changes(counters, bits):
    out = []
    for before, after in zip(counters[:-1], counters[1:]):
        row = []
        for a, b in zip(before, after):
            d = int(b) - int(a)
            while d >= 2 ** bits // 2:
                d -= 2 ** bits
            while d < -(2 ** bits // 2):
                d += 2 ** bits
            row.append(d)
        out.append(row)
    return out
""",
    "odometry.wheel_travel": """
import math
def wheel_travel(wheels, ticks):
    turns = ticks / wheels.ticks_per_turn
    angle = turns * 2 * math.pi
    return angle * wheels.radius
""",
    "odometry.wheel_matrix": """
import math
def wheel_matrix(positions, directions):
    rows = []
    for (x, y), a in zip(positions, directions):
        direction = (math.cos(a), math.sin(a))
        rows.append([*direction, x * direction[1] - y * direction[0]])
    return rows
""",
    "odometry.body_deltas": """
import numpy as np
from robocon_course.drivetrain import wheel_matrix
from robocon_course.geometry import wrap_angle
def body_deltas(wheels, travel, yaw=None):
    A = wheel_matrix(wheels.positions, wheels.directions)
    result = []
    for k, d in enumerate(travel):
        if yaw is None:
            result.append(np.linalg.lstsq(A, d, rcond=None)[0])
            continue
        turn = wrap_angle(yaw[k + 1] - yaw[k])
        forward, left = np.linalg.solve(A[:, :2].T @ A[:, :2], A[:, :2].T @ (d - A[:, 2] * turn))
        result.append([forward, left, turn])
    return np.array(result)
""",
    "odometry.integrate": """
import math
def integrate(deltas, start=(0.0, 0.0, 0.0)):
    x, y, th = start
    out = [[x, y, th]]
    for f, l, w in deltas:
        if abs(w) < 1e-6:
            dx, dy = f, l
        else:
            s, c = math.sin(w) / w, (1 - math.cos(w)) / w
            dx, dy = s * f - c * l, c * f + s * l
        x += math.cos(th) * dx - math.sin(th) * dy
        y += math.sin(th) * dx + math.cos(th) * dy
        th += w
        out.append([x, y, th])
    return out
""",
    "odometry.body_velocity": """
import numpy as np
def body_velocity(poses, dt):
    out = []
    for (x0, y0, t0), (x1, y1, t1) in zip(poses[:-1], poses[1:]):
        turn = np.arctan2(np.sin(t1 - t0), np.cos(t1 - t0))
        half = turn / 2
        k = half / np.tan(half) if abs(half) > 1e-9 else 1.0
        c, s = np.cos(t0), np.sin(t0)
        u, v = c * (x1 - x0) + s * (y1 - y0), -s * (x1 - x0) + c * (y1 - y0)
        out.append([(k * u + half * v) / dt, (-half * u + k * v) / dt, turn / dt])
    return np.array(out)
""",
    "odometry.calibrate_wheels": """
import math
import numpy as np
from robocon_course.odometry import TrackingWheels
def calibrate_wheels(wheels, run_ticks, run, spin_ticks, angle):
    places, radii = [], []
    for (x, y), a, n, m in zip(wheels.positions, wheels.directions, run_ticks, spin_ticks):
        known = math.cos(a) * run[0] + math.sin(a) * run[1]
        radius = known / (2 * math.pi * n / wheels.ticks_per_turn)
        lever = 2 * math.pi * radius * m / wheels.ticks_per_turn / angle
        inward = x * math.cos(a) + y * math.sin(a)
        places.append([lever * math.sin(a) + inward * math.cos(a),
                       -lever * math.cos(a) + inward * math.sin(a)])
        radii.append(radius)
    return TrackingWheels(places, wheels.directions, radii, wheels.ticks_per_turn)
""",
}


@pytest.mark.parametrize("exercise_id", OTHER_STYLES)
def test_a_right_answer_in_another_style_passes(exercise_id):
    exercise = registry.exercise(exercise_id)
    answer = Answer(exercise.function_name, OTHER_STYLES[exercise_id])
    with AnswerProcess() as process:
        verdict = judge_answer(process, exercise, answer, 4711)
    assert verdict.points == exercise.points, verdict.message


def test_on_a_robot_exactly_as_drawn_the_drawing_is_right_and_nowhere_else():
    """The case must not refuse for a rounded count what its name calls right."""
    exercise = registry.exercise("odometry.calibrate_wheels")
    verdict = judge(exercise, ask_function(lambda wheels, *counts: wheels), 7)
    assert verdict.finding.case.what == "your own robot" and verdict.mistake == "unchanged"


def test_a_step_seen_from_its_beginning_is_told_before_any_wrap():
    exercise = registry.exercise("odometry.body_velocity")
    mistake = next(m for m in exercise.mistakes if m.name == "start heading, right arc")
    verdict = judge(exercise, ask_function(mistake.function), 7)
    assert verdict.finding.case.what == "a left turn, half a radian in each step"


SHORTCUTS = {
    "odometry.body_deltas": "return travel @ wheels.solver.T",
    "odometry.wheel_travel": "return ticks * wheels.metres_per_tick",
    "odometry.wheel_matrix": (
        "return odometry.TrackingWheels(positions, directions, 1.0, 1).matrix"
    ),
    "odometry.integrate": (
        "poses = np.zeros((len(deltas) + 1, 3))\n    poses[0] = start\n"
        "    odometry.integrate_arcs(deltas, poses)\n    return poses"
    ),
}
SIGNATURES = {
    "odometry.body_deltas": "wheels, travel, yaw=None",
    "odometry.wheel_travel": "wheels, ticks",
    "odometry.wheel_matrix": "positions, directions",
    "odometry.integrate": "deltas, start=(0.0, 0.0, 0.0)",
}


@pytest.mark.parametrize("exercise_id", SHORTCUTS)
def test_what_the_package_knows_already_is_no_answer(exercise_id):
    exercise = registry.exercise(exercise_id)
    text = (
        "import numpy as np\nfrom robocon_course import odometry\n"
        f"def {exercise.function_name}({SIGNATURES[exercise_id]}):\n    {SHORTCUTS[exercise_id]}\n"
    )
    with AnswerProcess() as process:
        verdict = judge_answer(process, exercise, Answer(exercise.function_name, text), 0)
    assert verdict.points == 0.0 and "the course's own" in verdict.message
