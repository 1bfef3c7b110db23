"""Every exercise of every chapter, by discovery: its reference, its mistakes, its own lesson.

A new chapter is held by these tests as soon as the registry knows it.
"""

from __future__ import annotations

import hashlib
import importlib
import re
from functools import cache

import numpy as np
import pytest

from conftest import ROOT
from robocon_course import geometry, imu, lessons, worlds
from robocon_course.answers.process import AnswerProcess
from robocon_course.answers.wire import fields_of
from robocon_course.exercises import registry
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.model import Exercise, Number, Outcome
from robocon_course.exercises.source import Answer, assemble, from_cells
from robocon_course.worlds import generator, imu_world

STUDENTS = (0, 7, 21306141022)
ALL = list(registry.exercises().values())
FUNCTIONS = [e for e in ALL if isinstance(e, Exercise)]
NUMBERS = [e for e in ALL if isinstance(e, Number)]
NAMED = "field geometry imu mission odometry planning swerve tracking vision worlds".split()
ROOMS = {room: importlib.import_module(f"robocon_course.{room}") for room in NAMED}
ROOMS["games"] = importlib.import_module("robocon_course.worlds.missions")
"""Modules as the lessons call them."""
MISTAKES = [(e, m) for e in ALL for m in e.mistakes]


def name(value) -> str:
    """What a parametrized test is called."""
    return getattr(value, "id", None) or getattr(value, "name", None) or str(value)


def verdict_on(exercise: Exercise | Number, function, student: int, salt: str = "public"):
    """The verdict on a function of ours as if it were a student's answer."""
    if isinstance(exercise, Number):
        return judge_number(exercise, function(student), student)
    return judge(exercise, ask_function(function), student, salt)


@pytest.mark.parametrize("student", STUDENTS)
@pytest.mark.parametrize("exercise", ALL, ids=name)
def test_the_reference_earns_all_points(exercise, student):
    right = exercise.truth if isinstance(exercise, Number) else exercise.reference
    for salt in ("public", "graded"):
        verdict = verdict_on(exercise, right, student, salt)
        assert verdict.points == exercise.points, verdict.message


@pytest.mark.parametrize("student", STUDENTS)
@pytest.mark.parametrize("exercise, mistake", MISTAKES, ids=name)
def test_a_known_mistake_earns_less_and_is_told_by_name(exercise, mistake, student):
    verdict = verdict_on(exercise, mistake.function, student)
    assert verdict.points < exercise.points
    assert verdict.mistake == mistake.name
    assert mistake.message in verdict.message


@pytest.mark.campaign
@pytest.mark.parametrize("exercise", ALL, ids=name)
def test_no_student_number_lets_a_mistake_pass(exercise, whole):
    count = (300 if isinstance(exercise, Number) else 60) if whole else 3
    for student in range(1000, 1000 + count):
        for mistake in exercise.mistakes:
            verdict = verdict_on(exercise, mistake.function, student)
            assert verdict.points < exercise.points, (mistake.name, student)
            assert verdict.mistake == mistake.name, student


@pytest.mark.parametrize("exercise", ALL, ids=name)
def test_an_exercise_has_hints_and_mistakes_with_words(exercise):
    assert len(exercise.hints) >= 2 and len(set(exercise.hints)) == len(exercise.hints)
    assert len(exercise.mistakes) >= 3
    names = [m.name for m in exercise.mistakes]
    assert len(set(names)) == len(names), "a name belongs to one mistake"
    assert all(m.message.strip().endswith(".") for m in exercise.mistakes)
    assert exercise.points > 0 and exercise.title


@pytest.mark.parametrize("exercise", ALL, ids=name)
def test_what_a_hint_or_a_message_names_is_there(exercise):
    for words in (*exercise.hints, *(mistake.message for mistake in exercise.mistakes)):
        for room, thing in re.findall(rf"\b({'|'.join(ROOMS)})\.(\w+)", words):
            assert hasattr(ROOMS[room], thing), f"{room}.{thing} in {words!r}"


@pytest.mark.parametrize("exercise", FUNCTIONS, ids=name)
def test_every_student_gets_cases_and_not_all_the_same(exercise):
    first, second, again = (
        exercise.cases(student, generator(student, exercise.id, "public")) for student in (1, 2, 1)
    )
    assert len(first) >= 3 and all(case.what for case in first)
    assert flat(first) == flat(again)
    assert flat(first) != flat(second)


def flat(cases) -> list[bytes]:
    """All numbers of some cases, to the bit."""
    rows: list[bytes] = []

    def add(value) -> None:
        fields = fields_of(value)
        if fields is not None:
            add(tuple(fields.values()))
        elif isinstance(value, tuple | list):
            for item in value:
                add(item)
        elif isinstance(value, str):
            rows.append(value.encode())
        else:
            rows.append(np.asarray(value, float).tobytes())

    for case in cases:
        add(case.args)
    return rows


@pytest.mark.parametrize("exercise", FUNCTIONS, ids=name)
def test_the_reference_bears_the_exercises_name(exercise):
    assert exercise.reference.__name__ == exercise.function_name
    assert exercise.id.startswith(f"{exercise.chapter}.")


def test_ids_are_unique_and_belong_to_their_chapter():
    ids = [e.id for about in registry.chapters() for e in about.exercises]
    assert len(set(ids)) == len(ids)
    for about in registry.chapters():
        assert all(e.chapter == about.topic for e in about.exercises)
        assert registry.chapter(about.number) is registry.chapter(about.topic) is about


def test_chapters_stand_in_the_order_of_their_numbers():
    numbers = [about.number for about in registry.chapters()]
    assert numbers == sorted(numbers) and len(set(numbers)) == len(numbers)


@pytest.mark.parametrize("exercise", FUNCTIONS, ids=name)
def test_doing_nothing_earns_nothing(exercise):
    for result in (None, 0.0, np.zeros(3), np.zeros((1, 4)), ""):
        assert judge(exercise, ask_function(lambda *_, r=result: r)).points == 0.0
    lazy = judge(exercise, ask_function(lambda first, *_: first))
    assert lazy.points < exercise.points


def test_a_students_world_is_the_same_to_the_bit_on_every_machine():
    world = imu_world(21306141022)
    logs = (world.still, world.rests, world.turns, world.gyro, world.accel)
    digest = hashlib.sha256(b"".join(log.astype("<f8").tobytes() for log in logs)).hexdigest()
    assert digest[:16] == "8265d95a2c1be937"


# --- the lesson's own solution: the naive twin ------------------------------------------------


@cache
def cells(chapter: str) -> tuple[str, ...]:
    """Code cells of a lesson's source."""
    path = ROOT / "solutions" / f"{registry.chapter(chapter).name}.py"
    return tuple(c.source for c in lessons.read_source(path).cells if c.cell_type == "code")


def handed_in(exercise: Exercise):
    """The file that lies beside the solved lesson, where an exercise asks for one."""
    return ROOT / "solutions" / exercise.file if exercise.file else None


@pytest.mark.parametrize("student", STUDENTS[1:])
@pytest.mark.parametrize("exercise", FUNCTIONS, ids=name)
def test_the_lessons_solution_passes_in_a_process_of_its_own(exercise, student):
    answer = assemble(exercise.function_name, from_cells(cells(exercise.chapter)))
    with AnswerProcess() as process:
        verdict = judge_answer(process, exercise, answer, student, file=handed_in(exercise))
    assert verdict.points == exercise.points, verdict.message


@pytest.mark.parametrize("exercise", FUNCTIONS, ids=name)
def test_a_graded_run_uses_other_numbers_and_the_solution_passes_there_too(exercise):
    answer = assemble(exercise.function_name, from_cells(cells(exercise.chapter)))
    with AnswerProcess() as process:
        verdict = judge_answer(
            process, exercise, answer, 7, salt="a class key", file=handed_in(exercise)
        )
    assert verdict.outcome is Outcome.PASSED and verdict.points == exercise.points


IN_PLACE = {
    "imu.euler_angles": "def euler_angles(q):\n    q[0] += 0.5\n    return q[:3]\n",
    "imu.fit_ellipsoid": (
        "from robocon_course import imu\ndef fit_ellipsoid(samples, gravity=9.80665):\n"
        "    samples /= 2\n    return imu.AccelerometerCalibration([0, 0, 0], [1, 1, 1])\n"
    ),
}


@pytest.mark.parametrize("exercise_id", IN_PLACE)
def test_an_answer_that_changes_what_it_was_given_is_told_so(exercise_id):
    exercise = registry.exercise(exercise_id)
    with AnswerProcess() as process:
        verdict = judge_answer(
            process, exercise, Answer(exercise.function_name, IN_PLACE[exercise_id]), 0
        )
    assert verdict.points == 0.0
    assert "it changes what it was given" in verdict.message


WAYS_ROUND = {
    "imu.mahony_step": "import numpy as np\nfrom robocon_course import imu\n"
    "def mahony_step(state, gyro, accel, dt, gains):\n"
    "    memory = np.concatenate([state.quaternion, state.integral])\n"
    "    imu.mahony_update(memory, gyro, accel, dt, *gains)\n"
    "    return imu.MahonyState(memory[:4], memory[4:])\n",
    "swerve.body_twist": "from robocon_course import swerve\n"
    "def body_twist(drive, speeds, angles):\n"
    "    return swerve.body_motion(drive, speeds, angles).twist\n",
    "swerve.discretize": "from robocon_course import geometry\n"
    "def discretize(twist, dt):\n    return geometry.se2_log(twist * dt) / dt\n",
    "tracking.pid_step": "from robocon_course import tracking\n"
    "def pid_step(state, setpoint, measured, dt, gains, limits):\n"
    "    pid = tracking.Pid(gains, limits)\n    pid.state = state\n"
    "    pid.update(setpoint, measured, dt)\n    return pid.state\n",
    "tracking.nearest_point": "from robocon_course.tracking import PathPoint, polyline\n"
    "def nearest_point(path, point, start_index, reach):\n"
    "    k, s, x, y, d = polyline.nearest(path, *point, start_index, reach)\n"
    "    return PathPoint(k, s, (x, y), d)\n",
    "tracking.pure_pursuit": "from robocon_course.tracking import pursuit\n"
    "def pure_pursuit(path, pose, lookahead, start_index):\n"
    "    return pursuit.pursue(path, tuple(pose), lookahead, start_index)\n",
    "tracking.tune": "from robocon_course.tracking import search\n"
    "def tune(model, path):\n"
    "    return min(search._begin(model), key=lambda s: search._cost(path, model, s))\n",
}


@pytest.mark.parametrize("exercise_id", WAYS_ROUND)
def test_the_courses_own_way_round_is_no_answer(exercise_id):
    exercise = registry.exercise(exercise_id)
    with AnswerProcess() as process:
        answer = Answer(exercise.function_name, WAYS_ROUND[exercise_id])
        verdict = judge_answer(process, exercise, answer, 0)
    assert verdict.points == 0.0 and "the course's own" in verdict.message


@pytest.mark.parametrize("student", [*range(0, 60, 7), "H1D021001"])
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    world = worlds.imu_world(student)
    accel = imu.calibrate_accelerometer(world.rests).apply(world.accel)
    raw = imu.estimate_attitude(world.gyro, accel, world.dt)
    off = geometry.wrap_angle(raw.yaw[-1] - imu.euler_angles(world.truth[-1])[2])
    bias = np.degrees(imu.calibrate_gyro(world.still).bias[2])
    for number, value in ("imu.own_drift", np.degrees(off)), ("imu.own_bias", bias):
        assert judge_number(registry.exercise(number), value, student).accepted
    assert judge_number(registry.exercise("imu.own_drift"), bias * 180, student).accepted
