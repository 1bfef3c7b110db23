"""Numbers from the student's own cart, and the challenge."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from robocon_course import tracking, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake, Number, Score
from robocon_course.tracking import Critical, DifferentialModel, TrackingSettings
from robocon_course.worlds import Student


@functools.lru_cache(maxsize=400)
def _critical(student: Student) -> Critical:
    return tracking.critical_gain(worlds.practice_world(student).swing, 2.0, tracking.DT)


def _gain(student: Student) -> float:
    """Where the cart swings without end [(m/s) / rad]."""
    return _critical(student).gain


def _period(student: Student) -> float:
    return _critical(student).period


OWN_GAIN = Number(
    id="tracking.own_gain",
    title="The gain at which your own cart swings without end",
    points=1,
    truth=_gain,
    tolerance=0.5,
    unit="m/s per rad",
    hints=(
        "Look at world.swing(gain) for a gain of 5, and for one of 40: one dies out, one grows.",
        "tracking.find_oscillation(world.swing(gain), 0.01).growth says by what a swing changes "
        "from one period to the next. Where is it 1?",
        "Halve the interval: if the swing grows the gain is too large, else too small.",
    ),
    mistakes=(
        Mistake(
            "0.6 of it",
            "That is 0.6 of it: the k_p of a PID controller. Asked for is the critical gain.",
            lambda student: 0.6 * _gain(student),
        ),
        Mistake(
            "half of it",
            "That is half of it: the k_p of a P controller. Asked for is the critical gain.",
            lambda student: 0.5 * _gain(student),
        ),
        Mistake(
            "per metre of wheel base",
            "That is the gain of a turn rate. world.swing takes that of the difference of both "
            "wheels' speeds: it is smaller by the wheel base.",
            lambda student: _gain(student) / worlds.practice_world(student).model.wheel_base,
        ),
        Mistake(
            "per degree",
            "That is per degree. The question asks for m/s per rad.",
            lambda student: np.radians(_gain(student)),
        ),
        Mistake(
            "too far",
            "At twice the critical gain the swing grows until the wheels reach their limit, and "
            "looks as if it went on without end. Begin with a small gain.",
            lambda student: 2.0 * _gain(student),
        ),
        Mistake(
            "the period",
            "That is the period of the swing in seconds. Asked for is the gain.",
            _period,
        ),
    ),
)

OWN_PERIOD = Number(
    id="tracking.own_period",
    title="The period of that swing",
    points=1,
    truth=_period,
    tolerance=0.006,
    unit="s",
    hints=(
        "At the gain where the swing neither dies nor grows, look at world.swing(gain) over time.",
        "From one crest to the next, on average over several; a sample lasts 10 ms.",
        "tracking.find_oscillation(world.swing(gain), 0.01).period at the critical gain.",
    ),
    mistakes=(
        Mistake(
            "samples",
            "That is in samples. One lasts 10 ms.",
            lambda student: _period(student) / tracking.DT,
        ),
        Mistake(
            "milliseconds",
            "That is in milliseconds. The question asks for seconds.",
            lambda student: 1000.0 * _period(student),
        ),
        Mistake(
            "half a period",
            "That is half a period, from one zero to the next; it is also the T_i of a PID "
            "controller. A period goes from crest to crest.",
            lambda student: 0.5 * _period(student),
        ),
        Mistake(
            "two periods",
            "That is two periods.",
            lambda student: 2.0 * _period(student),
        ),
        Mistake(
            "T_d",
            "That is an eighth of the period: the T_d of a PID controller.",
            lambda student: _period(student) / 8.0,
        ),
        Mistake(
            "frequency",
            "That is how often it swings in a second. The period is one over that.",
            lambda student: 1.0 / _period(student),
        ),
        Mistake(
            "the lag",
            "That is the lag of the wheels. The swing is slower.",
            lambda student: worlds.practice_world(student).model.lag,
        ),
    ),
)


def _tune_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    return [
        Case(f"cart number {k}", (worlds.some_cart(rng), worlds.winding_path(rng)))
        for k in (1, 2, 3)
    ]


def _off_path(case: Case, settings: TrackingSettings) -> float:
    """How far the cart leaves the path at most with somebody's settings [cm]."""
    model, path = case.args
    run = tracking.trial(path, model, settings)
    allowed = tracking.time_allowed(path, model)
    if not run.done:
        raise ValueError("with these settings the cart never reaches the end of the path")
    if run.duration > allowed:
        raise ValueError(
            f"with these settings the cart takes {run.duration:.1f} s, and {allowed:.1f} s are "
            "allowed: on average at least half as fast as its wheels can"
        )
    return 100.0 * run.worst


def _guess(
    k: float, least: float, share: float, lateral: float
) -> Callable[[DifferentialModel, np.ndarray], TrackingSettings]:
    """The same settings for every cart, but for its top speed."""
    return lambda model, path: TrackingSettings(k, least, share * model.max_speed, lateral)


TUNE = Exercise(
    id="tracking.tune",
    title="Challenge: settings for any cart and any path",
    points=4,
    reference=tracking.tune,
    shortcuts=(
        "robocon_course.tracking.search._begin",
        "robocon_course.tracking.search._cost",
        "robocon_course.tracking.search._around",
    ),
    cases=_tune_cases,
    time_limit=30.0,
    score=Score(_off_path, "cm off the path", ((1.1, 1.0), (1.5, 0.5))),
    hints=(
        "A cart with a long lag must look farther ahead: begin with k = model.lag and least = "
        "0.03 m. speed can be 0.9 of model.max_speed.",
        "How slow may it be in bends? tracking.profile_times says how long a speed_profile takes; "
        "lower lateral until it takes 0.9 of tracking.time_allowed(path, model).",
        "A tracking.trial takes some milliseconds. Try some dozens of settings with "
        "itertools.product, and keep the best that is done in time.",
    ),
    mistakes=(
        Mistake(
            "the course's default",
            "These are the settings that TrackingSettings() has of itself. They are for one cart; "
            "this one has another lag and another speed.",
            lambda model, path: TrackingSettings(),
        ),
        Mistake(
            "creeping",
            "Slow is exact, but it is not in time.",
            _guess(0.1, 0.05, 0.25, 0.1),
        ),
        Mistake(
            "creeping in bends",
            "So small a lateral acceleration makes the cart creep in every bend.",
            _guess(0.1, 0.05, 0.9, 0.01),
        ),
        Mistake(
            "far look-ahead",
            "So long a look-ahead cuts every corner.",
            _guess(0.5, 0.2, 0.9, 1.0),
        ),
        Mistake(
            "one guess for all",
            "The look-ahead does not depend on the cart's lag, nor the speed in bends on the time "
            "that is allowed.",
            _guess(0.1, 0.05, 0.8, 1.0),
        ),
        Mistake(
            "bends at full speed",
            "Full speed in all bends: the wheels cannot follow. Leave the time that is allowed to "
            "the bends.",
            _guess(0.1, 0.05, 0.9, 100.0),
        ),
    ),
)
