"""Shorter turns and speeds within the limit, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import swerve
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.swerve.same_modules import CLOSE, modules_case
from robocon_course.geometry import wrap_angle
from robocon_course.swerve import ModuleTargets
from robocon_course.worlds import Student

QUARTER = np.pi / 2


def _shortest_turn_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    situations = [
        ("all are there already", [20, -50, 130, 5], [20, -50, 130, 5]),
        ("80° to turn: that is the shorter way", [80, 10, -80, -30], [0, 90, 0, 50]),
        ("100° to turn: backwards is nearer", [100, -10, -100, -50], [0, 90, 0, 50]),
        ("89° and 91° to turn", [89, -89, 91, -91], [0, 0, 0, 0]),
        ("from ahead to back", [180, 0, 175, -5], [0, 180, 3, 170]),
        ("across ±180°: 20° to turn", [-170, 170, -175, 100], [170, -170, 165, 90]),
        ("only one module has far to go", [0, 0, 150, 0], [5, 5, 5, 5]),
        ("a steering that counts its turns", [30, -100, 10, -170], [725, 400, -350, 1090]),
    ]
    cases = [(what, np.full(4, 1.2), *np.radians([to, now])) for what, to, now in situations]
    to, now = np.radians([[170.0, 40, -150, 60], [10.0, 30, 20, -60]])
    cases.append(("commands that roll backwards", np.array([-0.5, -1.0, -0.7, 0.4]), to, now))
    cases.append(("standing still, told to turn", np.zeros(4), to, now))
    for _ in range(5):
        now = rng.uniform(-np.pi, np.pi, 4).round(3)
        turn = rng.uniform(0.1, 1.4, 4) * rng.choice([-1.0, 1.0], 4) + rng.choice([0.0, np.pi], 4)
        targets = rng.uniform(0.2, 2.0, 4).round(3), wrap_angle(now + turn).round(3), now
        cases.append(("any command", *targets))
    return [
        modules_case(what, swerve.shortest_turn, ModuleTargets(speeds, to), now)
        for what, speeds, to, now in cases
    ]


def _turned(
    *,
    difference: Callable[[np.ndarray, np.ndarray], np.ndarray] = lambda to, now: wrap_angle(
        to - now
    ),
    flips: Callable[[np.ndarray], np.ndarray] = lambda turn: np.abs(turn) > QUARTER,
    half: float = -np.pi,
    flipped: Callable[[np.ndarray], np.ndarray] = lambda speeds: -speeds,
    from_now: bool = True,
) -> Callable[..., ModuleTargets]:
    """The shorter way with one of its steps done wrongly."""

    def function(targets: ModuleTargets, angles: np.ndarray) -> ModuleTargets:
        speeds, to = np.array(targets.speeds), np.array(targets.angles)
        turn = difference(to, np.asarray(angles))
        flip = flips(turn)
        turn = np.where(flip, turn + half, turn)
        return ModuleTargets(
            np.where(flip, flipped(speeds), speeds), np.asarray(angles) + turn if from_now else turn
        )

    return function


def _flipped_target(half: float) -> Callable[..., ModuleTargets]:
    """Half a turn added to the wanted angle where it is far away, and the speed left alone."""

    def function(targets: ModuleTargets, angles: np.ndarray) -> ModuleTargets:
        to = np.array(targets.angles)
        far = np.abs(wrap_angle(to - angles)) > QUARTER
        return ModuleTargets(np.array(targets.speeds), np.where(far, to + half, to))

    return function


SHORTEST_TURN = Exercise(
    id="swerve.shortest_turn",
    title="Never steer more than a quarter turn",
    points=3,
    reference=swerve.shortest_turn,
    cases=_shortest_turn_cases,
    hints=(
        "How far has each module to turn? Wrap that difference first.",
        "Where it is more than a quarter turn, half a turn off and the wheel rolls backwards: same "
        "motion.",
        "turn = wrap_angle(targets.angles − angles), flip = np.abs(turn) > np.pi / 2, then "
        "np.where(flip, −targets.speeds, targets.speeds) and angles + np.where(flip, turn − np.pi, "
        "turn).",
    ),
    mistakes=(
        Mistake(
            "speed not reversed",
            "The angle is flipped by half a turn, the speed is not: the wheel drives the wrong "
            "way.",
            _turned(flipped=lambda speeds: speeds),
        ),
        *(
            Mistake(
                f"speed not reversed, {words}",
                "The angle is flipped by half a turn, the speed is not: the wheel drives the wrong "
                "way.",
                _flipped_target(half),
            )
            for words, half in (("half a turn added", np.pi), ("half a turn taken off", -np.pi))
        ),
        Mistake(
            "unchanged",
            "This returns the targets as they came: a module still turns by up to 180°.",
            lambda targets, angles: targets,
        ),
        Mistake(
            "angle not flipped",
            "The speed is reversed, the angle is not: the wheel drives the wrong way.",
            _turned(half=0.0),
        ),
        Mistake(
            "not wrapped",
            "The difference of the angles is not wrapped: from 170° to −170° are 20°, not 340°.",
            _turned(difference=lambda to, now: to - now),
        ),
        Mistake(
            "degrees",
            "No module ever rolls backwards: the turn is compared with 90, or with half a turn. "
            "The angles are in radians, and a quarter turn is π/2.",
            _turned(flips=lambda turn: np.abs(turn) > 90.0),
        ),
        Mistake(
            "the command's sign lost",
            "A module that flips always rolls backwards, even where the command rolls backwards "
            "already. Reverse the speed: −targets.speeds.",
            _turned(flipped=lambda speeds: -np.abs(speeds)),
        ),
        Mistake(
            "sign of the turn forgotten",
            "Only left turns are shortened: compare the absolute value with π/2.",
            _turned(flips=lambda turn: turn > QUARTER),
        ),
        Mistake(
            "the longer way",
            "The comparison is the wrong way round: this flips the modules that were nearly there.",
            _turned(flips=lambda turn: np.abs(turn) < QUARTER),
        ),
        Mistake(
            "all or none",
            "All modules flip as soon as one has far to go. Decide for each module by itself.",
            _turned(flips=lambda turn: np.full(turn.shape, bool((np.abs(turn) > QUARTER).any()))),
        ),
        Mistake(
            "always flipped",
            "This flips every module every time; then each of them turns by more than 90°.",
            _turned(flips=lambda turn: np.full(turn.shape, True)),
        ),
        Mistake(
            "turn instead of angle",
            "This returns how far to turn. The module wants the angle itself: add the angle it "
            "has.",
            _turned(from_now=False),
        ),
        Mistake(
            "an eighth of a turn",
            "It flips beyond 45°. The break-even is 90°: beyond that backwards is nearer.",
            _turned(flips=lambda turn: np.abs(turn) > QUARTER / 2),
        ),
    ),
)


def _limit_speeds_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    angles = rng.uniform(-3.0, 3.0, 4).round(3)
    situations = [
        ("all slower than the limit: nothing changes", [1.0, 0.5, 0.8, 0.2], 2.0),
        ("one wheel too fast", [3.0, 1.0, 2.0, 0.5], 2.0),
        ("all too fast", [4.0, 3.5, 5.0, 4.5], 3.0),
        ("the fastest wheel rolls backwards", [1.0, -4.0, 2.0, 0.5], 2.0),
        ("at rest", [0.0, 0.0, 0.0, 0.0], 2.0),
        ("a slow robot, barely too fast", [0.61, 0.3, -0.2, 0.0], 0.6),
    ]
    cases = [(what, np.array(speeds), limit) for what, speeds, limit in situations]
    for _ in range(4):
        speeds = (rng.uniform(0.5, 4.0, 4) * rng.choice([-1.0, 1.0], 4)).round(3)
        cases.append(("any command", speeds, round(rng.uniform(1.0, 2.5), 2)))
    return [
        Case(what, (ModuleTargets(speeds, angles), limit), "", CLOSE)
        for what, speeds, limit in cases
    ]


def _limited(
    factor: Callable[[np.ndarray, float], np.ndarray | float],
) -> Callable[..., ModuleTargets]:
    """All speeds times a factor, wrongly found."""

    def function(targets: ModuleTargets, max_speed: float) -> ModuleTargets:
        speeds = np.array(targets.speeds)
        with np.errstate(all="ignore"):
            return ModuleTargets(speeds * factor(speeds, max_speed), np.array(targets.angles))

    return function


def _fastest(speeds: np.ndarray) -> float:
    return np.abs(speeds).max()


LIMIT_SPEEDS = Exercise(
    id="swerve.limit_speeds",
    title="Slower, but on the same path",
    points=2,
    reference=swerve.limit_speeds,
    cases=_limit_speeds_cases,
    hints=(
        "One factor for all wheels keeps their ratio, and with it the path.",
        "The fastest wheel counts, forwards or backwards. If it is slow enough, the factor is 1.",
        "speeds · max_speed / max(np.abs(speeds).max(), max_speed)",
    ),
    mistakes=(
        Mistake(
            "single wheels cut off",
            "Each wheel is cut off by itself. Their ratio is lost, and with it the direction: the "
            "robot leaves its path. Slow all of them by one factor.",
            lambda targets, max_speed: ModuleTargets(
                np.clip(targets.speeds, -max_speed, max_speed), np.array(targets.angles)
            ),
        ),
        Mistake(
            "single wheels cut off forwards",
            "Each wheel that rolls forwards is cut off by itself, and one that rolls backwards not "
            "at all. Slow all of them by one factor.",
            lambda targets, max_speed: ModuleTargets(
                np.minimum(targets.speeds, max_speed), np.array(targets.angles)
            ),
        ),
        Mistake(
            "backwards forgotten",
            "A wheel that rolls backwards can be the fastest: take the absolute value.",
            _limited(lambda speeds, limit: limit / max(speeds.max(), limit)),
        ),
        Mistake(
            "divides by zero at rest",
            "A command that is slow enough must stay as it is: the factor is at most 1. And at "
            "rest this divides 0 by 0, which is NaN.",
            _limited(lambda speeds, limit: limit / _fastest(speeds)),
        ),
        Mistake(
            "always to the limit",
            "A slow command is made faster, up to the limit. Only ever slow down.",
            _limited(lambda speeds, limit: limit / (_fastest(speeds) or 1.0)),
        ),
        Mistake(
            "to one",
            "The speeds are scaled to 1, as in the listing of one source, whose speeds are shares "
            "of the limit. Here they are metres per second.",
            _limited(lambda speeds, limit: 1.0 / max(_fastest(speeds), 1.0)),
        ),
        Mistake(
            "mean instead of the fastest",
            "The mean speed is brought to the limit: the fastest wheel is still too fast.",
            _limited(lambda speeds, limit: min(1.0, limit / max(np.abs(speeds).mean(), 1e-9))),
        ),
        Mistake(
            "upside down",
            "The factor is upside down: too fast a command becomes faster still.",
            _limited(lambda speeds, limit: max(_fastest(speeds), limit) / limit),
        ),
        Mistake(
            "excess subtracted",
            "The same is taken off every speed. Their ratio is lost, and with it the path: "
            "multiply all of them by one factor.",
            lambda targets, max_speed: ModuleTargets(
                targets.speeds
                - np.sign(targets.speeds) * max(0.0, _fastest(targets.speeds) - max_speed),
                np.array(targets.angles),
            ),
        ),
        Mistake(
            "signs lost",
            "The signs are lost: a wheel that rolls backwards must go on doing so.",
            lambda targets, max_speed: ModuleTargets(
                np.abs(swerve.limit_speeds(targets, max_speed).speeds), np.array(targets.angles)
            ),
        ),
        Mistake(
            "length of all speeds together",
            "The root of all squares together is brought to the limit. Only the fastest wheel "
            "counts.",
            _limited(lambda speeds, limit: min(1.0, limit / max(np.linalg.norm(speeds), 1e-9))),
        ),
        Mistake(
            "unchanged",
            "This returns the targets as they came: too fast a wheel stays too fast.",
            lambda targets, max_speed: targets,
        ),
    ),
)
