"""The swerve's worlds, the search for slip, and the way from the field to a command."""

from __future__ import annotations

import hashlib
from itertools import product

import numpy as np
import pytest

from robocon_course import swerve, worlds
from robocon_course.answers.process import AnswerProcess
from robocon_course.autopilot import Parts, module_command
from robocon_course.exercises import registry
from robocon_course.exercises.judge import judge_answer, judge_number
from robocon_course.exercises.model import Outcome
from robocon_course.exercises.source import Answer
from robocon_course.geometry import wrap_angle
from robocon_course.robot import MODULES
from robocon_course.swerve import NO_SLIP, find_slip, module_targets

STUDENTS = [*range(0, 60, 7), "H1D021001"]

# --- which wheel slips ------------------------------------------------------------------------


def rolling(rows: int, twist=(0.8, -0.3, 1.2)):
    """Speeds and angles of wheels that all roll."""
    return module_targets(MODULES, np.tile(twist, (rows, 1)), np.zeros(4))


@pytest.mark.parametrize("wheel, extra", [*product(range(4), (0.3, -0.3))])
def test_a_wheel_that_is_too_fast_or_too_slow_for_a_while_is_found(wheel, extra):
    speeds, angles = rolling(60)
    speeds[20:40, wheel] += extra
    expected = np.full(60, NO_SLIP)
    expected[20:40] = wheel
    np.testing.assert_array_equal(find_slip(MODULES, speeds, angles), expected)


def test_wheels_that_roll_and_a_single_wild_reading_are_no_slip():
    speeds, angles = rolling(60)
    speeds[30, 2] += 1.0
    assert (find_slip(MODULES, speeds, angles) == NO_SLIP).all()


def test_of_three_modules_the_slipping_one_is_found_too():
    three = MODULES[:3] * [[1.0, 0.8], [1.1, 1.0], [0.9, 1.2]]
    speeds, angles = module_targets(three, np.tile([0.5, 0.9, -1.0], (40, 1)), np.zeros(3))
    speeds[10:30, 1] += 0.4
    assert (find_slip(three, speeds, angles)[10:30] == 1).all()


def leave_one_out(speeds, angles, limit=0.1, window=7) -> np.ndarray:
    """The same question asked slowly: without which wheel's slip do the others agree best?"""
    found, half = [], window // 2
    rows = len(speeds)
    matrix = swerve.SwerveDrive(MODULES).matrix
    slips, gains = np.empty((rows, 4)), np.empty((rows, 4))
    for k, i in product(range(rows), range(4)):
        c, s = np.cos(angles[k]), np.sin(angles[k])
        seen = np.hstack([speeds[k] * c, speeds[k] * s])
        error = np.zeros(8)
        error[[i, 4 + i]] = c[i], s[i]
        without = np.linalg.lstsq(matrix, seen, rcond=None)[1][0]
        fit, rest = np.linalg.lstsq(np.c_[matrix, error], seen, rcond=None)[:2]
        slips[k, i], gains[k, i] = abs(fit[3]), without - rest[0]
    for k in range(rows):
        around = np.clip(np.arange(k - half, k + half + 1), 0, rows - 1)
        suspect = int(np.argmax(np.median(gains[around], axis=0)))
        found.append(suspect if np.median(slips[around, suspect]) > limit else NO_SLIP)
    return np.array(found)


def test_the_search_for_slip_equals_one_fit_more_for_each_wheel():
    log = worlds.slip_log(worlds.generator(3, "twin"), 200)
    np.testing.assert_array_equal(
        find_slip(MODULES, log.speeds, log.angles), leave_one_out(log.speeds, log.angles)
    )


def test_slip_is_found_in_nearly_all_rows_of_a_wet_floor():
    for seed in range(20):
        log = worlds.slip_log(worlds.generator(seed, "wet"))
        wrong = np.mean(find_slip(MODULES, log.speeds, log.angles) != log.slipping)
        assert wrong < 0.04  # measured on 60 logs: 0.8 % in the median, 1.8 % at worst
        assert 0.2 < np.mean(log.slipping >= 0) < 0.5


@pytest.mark.parametrize(
    "drive, speeds, angles, sentence",
    [
        (MODULES[:2], np.zeros((5, 2)), np.zeros((5, 2)), "takes three modules, got 2"),
        (MODULES, np.zeros((5, 3)), np.zeros((5, 3)), "speeds: expected shape"),
        (MODULES, np.zeros((5, 4)), np.zeros((4, 4)), "angles: expected shape"),
        (MODULES, np.full((5, 4), np.nan), np.zeros((5, 4)), "not a finite number"),
    ],
)
def test_a_log_that_nobody_can_search_is_refused(drive, speeds, angles, sentence):
    with pytest.raises(ValueError, match=sentence):
        find_slip(drive, speeds, angles)


# --- a student's own drive --------------------------------------------------------------------


def test_a_students_drive_is_the_same_to_the_bit_on_every_machine():
    world = worlds.swerve_world(21306141022)
    logs = (world.offsets, world.twists, world.speeds, world.angles)
    digest = hashlib.sha256(b"".join(log.astype("<f8").tobytes() for log in logs)).hexdigest()
    assert (world.max_speed, digest[:16]) == (2.56, "204c5ac8065adf52")


@pytest.mark.parametrize("student", STUDENTS)
def test_the_log_shows_a_rolling_drive_with_crooked_encoders(student):
    world = worlds.swerve_world(student)
    targets = module_targets(MODULES, world.twists, np.zeros(4))
    off = wrap_angle(world.angles - targets.angles - world.offsets)
    assert np.abs(world.speeds - targets.speeds).max() < 0.3 and world.speeds.min() > 0.0
    assert np.abs(off.mean(axis=0)).max() < np.radians(0.25)
    assert (np.abs(world.angles) <= np.pi).all()
    assert np.degrees(np.abs(world.offsets)).min() >= 4.0


@pytest.mark.parametrize("student", STUDENTS)
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    world = worlds.swerve_world(student)
    said = world.angles
    off = wrap_angle(said - module_targets(MODULES, world.twists, said).angles)
    offset = np.degrees(off.mean(axis=0)[2])
    rates = np.arange(0.0, 20.0, 0.005)
    twists = np.column_stack([np.ones_like(rates), np.zeros_like(rates), rates])
    fastest = module_targets(MODULES, twists, np.zeros(4)).speeds.max(axis=1)
    rate = rates[np.argmax(fastest >= world.max_speed)]
    for name, value in ("swerve.own_offset", offset), ("swerve.own_turn_rate", rate):
        verdict = judge_number(registry.exercise(name), value, student)
        assert verdict.accepted, verdict.message


# --- other ways to say the same ---------------------------------------------------------------

OTHER_STYLES = {
    "swerve.module_targets": """
import cmath, math
from robocon_course import swerve
def module_targets(drive, twist, hold_angles):
    speeds, angles = [], []
    for (x, y), held in zip(drive, hold_angles):
        v = complex(twist[0], twist[1]) + 1j * twist[2] * complex(x, y)
        speeds.append(abs(v) if abs(v) >= swerve.REST else 0.0)
        angles.append(cmath.phase(v) % (2 * math.pi) if speeds[-1] else held)
    return swerve.ModuleTargets(speeds, angles)
""",
    "swerve.shortest_turn": """
import math
def shortest_turn(targets, angles):
    speeds, out = [], []
    for speed, to, now in zip(targets.speeds, targets.angles, angles):
        if math.cos(to - now) < 0:
            speed, to = -speed, to + math.pi
        speeds.append(speed)
        out.append(math.atan2(math.sin(to), math.cos(to)))
    return targets._replace(speeds=speeds, angles=out)
""",
    "swerve.limit_speeds": """
def limit_speeds(targets, max_speed):
    fastest = max(abs(speed) for speed in targets.speeds)
    if fastest > max_speed:
        return targets._replace(speeds=[s * max_speed / fastest for s in targets.speeds])
    return targets
""",
    "swerve.body_twist": """
import numpy as np
def body_twist(drive, speeds, angles):
    rows, seen = [], []
    for (x, y), speed, angle in zip(drive, speeds, angles):
        rows += [[1, 0, -y], [0, 1, x]]
        seen += [speed * np.cos(angle), speed * np.sin(angle)]
    A = np.array(rows)
    return list(np.linalg.solve(A.T @ A, A.T @ np.array(seen)))
""",
    "swerve.field_to_robot": """
import cmath
def field_to_robot(twist, theta):
    v = complex(twist[0], twist[1]) * cmath.exp(-1j * theta)
    return [v.real, v.imag, twist[2]]
""",
    "swerve.discretize": """
import math
def discretize(twist, dt):
    h = twist[2] * dt / 2
    k = 1.0 if abs(h) < 1e-6 else h / math.tan(h)
    return [k * twist[0] + h * twist[1], k * twist[1] - h * twist[0], twist[2]]
""",
    "swerve.pose_feedback": """
import math
def pose_feedback(pose, target, gain, feedforward=(0.0, 0.0, 0.0)):
    turn = math.remainder(target[2] - pose[2], 2 * math.pi)
    far = [target[0] - pose[0], target[1] - pose[1], turn]
    return [gain * d + f for d, f in zip(far, feedforward)]
""",
}


@pytest.mark.parametrize("exercise_id", OTHER_STYLES)
def test_a_right_answer_in_another_style_earns_all_points(exercise_id):
    exercise = registry.exercise(exercise_id)
    with AnswerProcess() as process:
        answer = Answer(exercise.function_name, OTHER_STYLES[exercise_id])
        verdict = judge_answer(process, exercise, answer, 7)
    assert verdict.outcome is Outcome.PASSED, verdict.message


# --- the way to a command ---------------------------------------------------------------------


def test_a_command_moves_the_body_as_ordered_on_the_field():
    theta, twist = 0.7, np.array([0.4, -0.6, 0.0])
    there = module_command(Parts(), twist, theta, np.zeros(4), dt=0.02).angles
    command = module_command(Parts(), twist, theta, there, dt=0.02)
    moved = swerve.body_twist(MODULES, command.speeds, command.angles)
    np.testing.assert_allclose(moved, swerve.field_to_robot(twist, theta), atol=1e-12)


def test_a_command_never_exceeds_the_limit_and_never_steers_by_more_than_a_quarter_turn():
    rng = np.random.default_rng(3)
    for _ in range(50):
        twist, now = rng.uniform(-5.0, 5.0, 3), rng.uniform(-3.0, 3.0, 4)
        command = module_command(Parts(), twist, 0.3, now, dt=0.02, max_speed=1.5)
        assert np.abs(command.speeds).max() <= 1.5
        assert np.abs(command.angles - now).max() <= np.pi / 2 + 1e-12


def test_a_command_of_nothing_stops_the_wheels_and_leaves_them_where_they_are():
    now = np.array([0.3, -2.0, 3.0, 1.0])
    command = module_command(Parts(), np.zeros(3), 1.0, now, dt=0.02)
    np.testing.assert_array_equal(command.speeds, np.zeros(4))
    np.testing.assert_array_equal(command.angles, now)


def test_the_students_parts_are_the_ones_that_run():
    called = []

    def noted(name):
        original = getattr(swerve, name)
        return lambda *args: (called.append(name), original(*args))[1]

    names = ("field_to_robot", "discretize", "module_targets", "limit_speeds", "shortest_turn")
    parts = Parts(**{name: noted(name) for name in names})
    module_command(parts, [1.0, 0.0, 1.0], 0.2, np.zeros(4), dt=0.02)
    assert called == list(names)


def test_parts_that_answer_with_lists_and_parts_that_count_on_arrays_work_together():
    def listed(name):
        def function(first, *rest):
            for values in first if isinstance(first, tuple) else [first]:
                assert isinstance(values, np.ndarray), f"{name} was given a {type(values)}"
            value = getattr(swerve, name)(first, *rest)
            rows = [v.tolist() for v in value]
            return swerve.ModuleTargets(*rows) if isinstance(value, tuple) else rows

        return function

    names = ("field_to_robot", "discretize", "module_targets", "limit_speeds", "shortest_turn")
    order = [1.0, -0.5, 2.0], 0.4, [0.1, 0.2, -3.0, 2.0]
    plain = module_command(Parts(), *order, dt=0.02, max_speed=1.0)
    parts = Parts(**{name: listed(name) for name in names})
    mixed = module_command(parts, *order, dt=0.02, max_speed=1.0)
    # The course's own parts run as one compiled step, which may differ in the last bit.
    np.testing.assert_allclose(mixed.speeds, plain.speeds, rtol=0, atol=1e-14)
    np.testing.assert_allclose(mixed.angles, plain.angles, rtol=0, atol=1e-14)
