"""A student's own cart, the carts and paths of the challenge, and answers in other styles."""

from __future__ import annotations

import hashlib
from math import inf

import numpy as np
import pytest

from robocon_course import tracking, worlds
from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.model import Outcome
from robocon_course.exercises.source import Answer
from robocon_course.geometry import distance_along
from robocon_course.tracking import TrackingSettings

STUDENTS = [*range(0, 60, 7), "H1D021001"]
TUNE = registry.exercise("tracking.tune")

# --- a student's own cart -------------------------------------------------------------------------


def test_a_students_cart_is_the_same_on_every_machine():
    model = worlds.practice_world(21306141022).model
    assert (model.wheel_base, model.lag) == (0.354, 0.074)
    rng = worlds.generator(21306141022, "path")
    text = worlds.winding_path(rng).astype("<f8").tobytes()
    assert hashlib.sha256(text).hexdigest()[:16] == "09be072a958ccfa1"


@pytest.mark.parametrize("student", STUDENTS)
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    world = worlds.practice_world(student)
    # As a student does it: halve an interval until it is narrow, by the growth alone.
    low, high = 2.0, 60.0
    while high - low > 0.05:
        middle = 0.5 * (low + high)
        grows = tracking.find_oscillation(world.swing(middle), 0.01).growth > 1.0
        low, high = (low, middle) if grows else (middle, high)
    period = tracking.find_oscillation(world.swing(high), 0.01).period
    for name, value in ("tracking.own_gain", high), ("tracking.own_period", period):
        verdict = judge_number(registry.exercise(name), value, student)
        assert verdict.accepted, verdict.message


@pytest.mark.parametrize("student", STUDENTS)
def test_the_experiment_stays_far_from_the_wheels_limits(student):
    world = worlds.practice_world(student)
    gain = registry.exercise("tracking.own_gain").truth(student)
    assert 10.0 < gain < 30.0
    ordered = 0.25 + 0.5 * gain * np.abs(world.swing(gain)).max()
    assert ordered < 0.5 * world.model.max_speed


# --- carts and paths that nobody has seen ---------------------------------------------------------


def test_a_path_of_the_challenge_winds_and_has_two_corners():
    for seed in range(20):
        path = worlds.winding_path(np.random.default_rng(seed))
        assert distance_along(path)[-1] == pytest.approx(5.0, abs=0.02)
        bends = np.abs(tracking.path_curvature(path))
        assert (bends > 20.0).sum() == 2  # a corner of 70° over 2 cm is 61 1/m
        assert np.median(bends) < 3.0


def test_a_path_drawn_finely_is_the_same_path():
    coarse = np.array(worlds.SOURCE_PATHS["roof"])
    path = worlds.finely(coarse, 0.03)
    assert distance_along(path)[-1] == pytest.approx(distance_along(coarse)[-1])
    assert np.diff(distance_along(path)).max() < 0.031
    assert all(np.abs(path - corner).sum(axis=1).min() == 0.0 for corner in coarse)


def test_the_courses_search_earns_all_points_with_something_to_spare():
    rng = np.random.default_rng(8)
    for _ in range(10):
        model, path = worlds.some_cart(rng), worlds.winding_path(rng)
        run = tracking.trial(path, model, tracking.tune(model, path))
        assert run.duration <= tracking.time_allowed(path, model)
        assert run.worst < 0.0105  # measured on 200 pairs: 0.6 cm in the median, 1.0 at most


def test_a_rule_of_thumb_earns_more_than_one_guess_for_all_carts():
    def thumb(model, path):
        for lateral in (0.1, 0.15, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0):
            speeds = tracking.speed_profile(path, 0.9 * model.max_speed, tracking.ACCEL, lateral)
            planned = tracking.profile_times(path, np.maximum(speeds, tracking.CREEP))[-1]
            if planned < 0.9 * tracking.time_allowed(path, model):
                break
        return TrackingSettings(model.lag, 0.02, 0.9 * model.max_speed, lateral)

    def guess(model, path):
        return TrackingSettings(0.1, 0.05, 0.8 * model.max_speed, 1.0)

    earned = {"thumb": [], "guess": []}
    for student in range(12):
        for name, function in (("thumb", thumb), ("guess", guess)):
            earned[name].append(judge(TUNE, ask_function(function), student).points)
    assert np.mean(earned["guess"]) == 0.0
    assert 0.25 * TUNE.points < np.mean(earned["thumb"]) < TUNE.points


def test_who_creeps_is_told_the_rule_and_who_never_arrives_is_told_so():
    slow = judge(TUNE, ask_function(lambda *_: TrackingSettings(0.1, 0.05, 0.1, 0.1)))
    assert slow.points == 0.0 and "half as fast as its wheels can" in slow.message
    lost = judge(TUNE, ask_function(lambda *_: TrackingSettings(0.0, 5.0, 0.5, 1.0)))
    assert lost.points == 0.0
    wild = judge(TUNE, ask_function(lambda *_: TrackingSettings(-1.0, 0.05, 0.5, 1.0)))
    assert wild.points == 0.0 and "settings: expected k from 0 s on" in wild.message


# --- other ways to say the same -------------------------------------------------------------------

OTHER_STYLES = {
    "tracking.pid_step": """
import math
from robocon_course.tracking import PidState
def pid_step(state, setpoint, measured, dt, gains, limits):
    kp, ki, kd, _ = gains
    if math.isnan(measured) or math.isinf(measured):
        return PidState(state.proportional, state.integral, state.derivative, state.measured,
                        state.gap + dt, state.output, state.rejected + 1)
    e = setpoint - measured
    rate = 0.0
    if state.measured == state.measured:
        rate = (measured - state.measured) / (state.gap + dt)
    grown = state.integral + ki * e * dt
    raw = kp * e + grown - kd * rate
    out = max(limits.low, min(raw, limits.high))
    if (raw - out) * e * ki > 0:
        grown = state.integral
    return PidState(kp * e, grown, -kd * rate, measured, output=out, rejected=state.rejected)
""",
    "tracking.ziegler_nichols": """
from robocon_course.tracking import PidGains
def ziegler_nichols(k_cr, p_cr, kind):
    if kind == "PID":
        return PidGains(0.6 * k_cr, 1.2 * k_cr / p_cr, 0.075 * k_cr * p_cr)
    return PidGains(0.5 * k_cr) if kind == "P" else PidGains(0.45 * k_cr, 0.54 * k_cr / p_cr)
""",
    "tracking.nearest_point": """
import math
from robocon_course.tracking import PathPoint
def nearest_point(path, point, start_index, reach):
    px, py = point
    best, walked, k = PathPoint(start_index, 0.0, (0.0, 0.0), math.inf), 0.0, start_index
    for (ax, ay), (bx, by) in zip(path[start_index:-1], path[start_index + 1:]):
        length = math.dist((ax, ay), (bx, by))
        s = 0.0
        if length > 0:
            s = ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / length / length
            s = 0.0 if s < 0 else 1.0 if s > 1 else s
        x, y = ax + s * (bx - ax), ay + s * (by - ay)
        away = math.dist((x, y), (px, py))
        if away < best.distance - 1e-9:
            best, walked = PathPoint(k, s, [x, y], away), length * (1 - s)
        else:
            walked += length
        if walked > reach:
            return best
        k += 1
    return best
""",
    "tracking.lookahead_point": """
import cmath
from robocon_course.tracking import PathPoint
def lookahead_point(path, point, lookahead, index, share):
    p = complex(*point)
    z = [complex(*xy) for xy in path]
    for k in range(index, len(z) - 1):
        d = z[k + 1] - z[k]
        s = share if k == index else 0.0
        here = z[k] + s * d
        if abs(here - p) >= lookahead:
            return PathPoint(k, s, (here.real, here.imag), abs(here - p))
        if abs(z[k + 1] - p) >= lookahead:
            unit = d / abs(d)
            foot = ((p - z[k]) / unit).real
            height = ((p - z[k]) / unit).imag
            s = (foot + (lookahead ** 2 - height ** 2) ** 0.5) / abs(d)
            here = z[k] + s * d
            return PathPoint(k, s, (here.real, here.imag), lookahead)
    return PathPoint(len(z) - 2, 1.0, (z[-1].real, z[-1].imag), abs(z[-1] - p))
""",
    "tracking.pure_pursuit": """
import numpy as np
from robocon_course import geometry, tracking
def pure_pursuit(path, pose, lookahead, start_index):
    foot = tracking.nearest_point(path, pose[:2], start_index, lookahead)
    t = tracking.lookahead_point(path, pose[:2], lookahead, foot.index, foot.share)
    a, b = geometry.transform_points(geometry.inverse(pose), t.xy)
    k = 0.0 if a == b == 0 else 2 * b / (a * a + b * b)
    s = geometry.distance_along(path)
    at = s[foot.index] + foot.share * (s[foot.index + 1] - s[foot.index])
    over = s[-1] - at <= tracking.TOLERANCE and foot.distance < lookahead
    return tracking.Pursuit(k, list(t.xy), foot.index, over and t.xy == tuple(path[-1]))
""",
    "tracking.speed_profile": """
import numpy as np
from robocon_course import geometry, tracking
def speed_profile(path, max_speed, max_accel, max_lateral_accel):
    s = geometry.distance_along(path)
    k = abs(tracking.path_curvature(path))
    square = [min(max_speed ** 2, max_lateral_accel / b if b > 0 else 1e9) for b in k]
    square[0] = square[-1] = 0.0
    out = []
    for i in range(len(s)):  # every point may be the one that limits
        out.append(min(q + 2 * max_accel * abs(s[i] - x) for q, x in zip(square, s)) ** 0.5)
    return out
""",
}


@pytest.mark.parametrize("exercise_id", OTHER_STYLES)
def test_a_right_answer_in_another_style_earns_all_points(exercise_id):
    exercise = registry.exercise(exercise_id)
    with AnswerProcess() as process:
        for student in (0, 7, 12):
            answer = Answer(exercise.function_name, OTHER_STYLES[exercise_id])
            verdict = judge_answer(process, exercise, answer, student)
            assert verdict.outcome is Outcome.PASSED, verdict.message


def test_the_end_of_a_segment_and_the_beginning_of_the_next_are_one_place():
    exercise = registry.exercise("tracking.nearest_point")

    def other_side(path, point, start_index, reach=inf):
        found = tracking.nearest_point(path, point, start_index, reach)
        if found.share == 1.0 and found.index < len(path) - 2:
            return found._replace(index=found.index + 1, share=0.0)
        return found

    assert judge(exercise, ask_function(other_side)).points == exercise.points
