"""Numbers from the student's own drive, and the challenge."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import swerve, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake, Number, Score
from robocon_course.robot import MODULES
from robocon_course.worlds import Student

AHEAD = 1.0  # m/s
REAR_RIGHT, FRONT_RIGHT = 2, 3


def _turn_rate(student: Student) -> float:
    """Largest omega at which no module exceeds its limit, driving ahead at 1 m/s [rad/s].

    The right modules are fastest: (1 + ω h)² + (ω h)² = limit².
    """
    limit, h = worlds.swerve_world(student).max_speed, MODULES[0, 0]
    return float((np.sqrt(2.0 * limit**2 - AHEAD**2) - AHEAD) / (2.0 * h))


def _limit(student: Student) -> float:
    return worlds.swerve_world(student).max_speed


RADIUS = float(np.hypot(*MODULES[0]))

OWN_TURN_RATE = Number(
    id="swerve.own_turn_rate",
    title="How fast your robot may turn while it drives",
    points=1,
    truth=_turn_rate,
    tolerance=0.02,
    unit="rad/s",
    hints=(
        "Ask module_targets for (1, 0, omega) and look at the fastest wheel; raise omega until it "
        "reaches world.max_speed.",
        "Or by hand: the right modules are fastest, (1 + omega · h)² + (omega · h)² = limit² with "
        "h = 0.235 m.",
    ),
    mistakes=(
        Mistake(
            "speeds added",
            "This adds the 1 m/s and the speed of the turn as if they had the same direction. At "
            "the right modules they are 45° apart.",
            lambda student: (_limit(student) - AHEAD) / RADIUS,
        ),
        Mistake(
            "on the spot",
            "That is the limit for a turn on the spot. While the robot drives, less is left.",
            lambda student: _limit(student) / RADIUS,
        ),
        Mistake(
            "at right angles",
            "This adds the two speeds as if they were at right angles. At the right modules they "
            "are 45° apart.",
            lambda student: np.sqrt(_limit(student) ** 2 - AHEAD**2) / RADIUS,
        ),
        Mistake(
            "degrees per second",
            "That is in degrees per second. The question asks for rad/s.",
            lambda student: np.degrees(_turn_rate(student)),
        ),
    ),
)


def _offset(student: Student, module: int = REAR_RIGHT) -> float:
    return float(np.degrees(worlds.swerve_world(student).offsets[module]))


OWN_OFFSET = Number(
    id="swerve.own_offset",
    title="The zero offset of your rear right steering encoder",
    points=1,
    truth=_offset,
    tolerance=0.3,
    unit="deg",
    hints=(
        "module_targets says which angle each module must have had for the twist that the camera "
        "saw. The encoder says something else.",
        "Wrap the differences, then average them over the log: column 2 is the rear right module.",
    ),
    mistakes=(
        Mistake(
            "sign reversed",
            "The sign is reversed: the offset is what the encoder says too much.",
            lambda student: -_offset(student),
        ),
        Mistake(
            "radians",
            "That is in radians. The question asks for degrees.",
            lambda student: np.radians(_offset(student)),
        ),
        Mistake(
            "front right",
            "That is the front right module. Rear right is the third: column 2.",
            lambda student: _offset(student, FRONT_RIGHT),
        ),
        Mistake(
            "rear left",
            "That is the rear left module. Rear right is the third: column 2.",
            lambda student: _offset(student, 1),
        ),
    ),
)


def _find_slip_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    logs = [worlds.slip_log(rng) for _ in range(3)]
    return [
        Case("a wet floor", (np.array(MODULES), log.speeds, log.angles), truth=log.slipping)
        for log in logs
    ]


def _wrong_rows(case: Case, found: np.ndarray) -> float:
    """Share of the rows that blame the wrong wheel, or none, or one too many [%]."""
    return 100.0 * float(np.mean(np.asarray(found) != case.truth))


def _blame(
    doubt: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray], limit: float
) -> Callable[..., np.ndarray]:
    """The wheel with the largest doubt, where that is above a limit."""

    def function(drive: np.ndarray, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
        doubts = doubt(np.asarray(drive, float), np.asarray(speeds), np.asarray(angles))
        return np.where(doubts.max(axis=1) > limit, doubts.argmax(axis=1), -1)

    return function


def _left_over(drive: np.ndarray, speeds: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """What each wheel differs from the motion that fits all, shape (n, 4) [m/s]."""
    matrix = swerve.SwerveDrive(drive).matrix
    fitted = swerve.body_twist(drive, speeds, angles) @ matrix.T
    seen = np.hstack([speeds * np.cos(angles), speeds * np.sin(angles)])
    off = np.abs(seen - fitted)
    return np.hypot(off[:, : len(drive)], off[:, len(drive) :])


FIND_SLIP = Exercise(
    id="swerve.find_slip",
    title="Challenge: which wheel slips, and when",
    points=4,
    reference=swerve.find_slip,
    cases=_find_slip_cases,
    time_limit=20.0,
    score=Score(_wrong_rows, "% wrong rows", ((4.0, 1.0), (16.0, 0.5))),
    hints=(
        "Fit one twist to all four wheels, row by row. What is left over of each wheel's velocity "
        "is its doubt.",
        "All rows at once: components (n, 8) times np.linalg.pinv(matrix).T gives the twists "
        "(n, 3). Blame the wheel with the largest doubt, if it is above a limit of 0.06 m/s or so.",
        "Noise changes from row to row, slip does not: take the median of each wheel's doubt over "
        "seven rows before you compare.",
    ),
    mistakes=(
        Mistake(
            "the fastest wheel",
            "This blames the wheel that differs most from the mean speed. In a turn the outer "
            "wheels are faster, and rightly so. Compare with what the fitted motion gives each "
            "place.",
            _blame(lambda drive, v, angles: np.abs(v - v.mean(axis=1, keepdims=True)), 0.15),
        ),
        Mistake(
            "always somebody",
            "This blames a wheel in every row. Where the wheels agree but for noise, nobody slips.",
            _blame(_left_over, -1.0),
        ),
        Mistake(
            "nobody ever",
            "This never finds a wheel that slips.",
            _blame(_left_over, np.inf),
        ),
        Mistake(
            "the wheel that fits best",
            "This blames the wheel with the smallest doubt. The slipping one has the largest.",
            lambda drive, v, angles: np.where(
                (doubts := _left_over(np.asarray(drive), v, angles)).max(axis=1) > 0.06,
                doubts.argmin(axis=1),
                -1,
            ),
        ),
    ),
)
