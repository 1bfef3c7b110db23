"""Chapter 00: one small exercise, to meet the checks."""

from __future__ import annotations

import math

import numpy as np

from robocon_course import geometry
from robocon_course.exercises.model import Case, Chapter, Exercise, Mistake
from robocon_course.worlds import Student

TURN = 2 * math.pi


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    situations = [
        ("a quarter turn left", math.pi / 2),
        ("three quarters of a turn left", 1.5 * math.pi),
        ("three quarters of a turn right", -1.5 * math.pi),
        ("half a turn left, which is where the range begins again", math.pi),
        ("three whole turns and a bit", 3 * TURN + 0.25),
        ("forty whole turns and a bit", 40 * TURN + 0.5),
    ]
    situations += [("an angle of your own", round(a, 3)) for a in rng.uniform(-40, 40, 6)]
    return [Case(what, (angle,), "rad") for what, angle in situations]


WRAP_ANGLE = Exercise(
    id="start.wrap_angle",
    title="Wrap an angle",
    points=1,
    reference=geometry.wrap_angle,
    cases=_cases,
    time_limit=2.0,
    hints=(
        "Shift the angle by half a turn, take the remainder by a whole turn, shift back.",
        "Python's % gives a remainder in [0, b) for b > 0, for negative numbers too.",
        "(angle + π) % (2π) − π",
    ),
    mistakes=(
        Mistake(
            "from zero to a whole turn",
            "This counts from 0 to 2π. A robot that should turn a little to the right (−0.1) "
            "would turn almost all the way to the left (6.18). Shift by half a turn first.",
            lambda angle: angle % TURN,
        ),
        Mistake(
            "takes off one turn at most",
            "This takes off one turn at most. An angle that has added up over several turns "
            "needs them all taken off: use the remainder, or repeat.",
            lambda angle: (
                angle - TURN if angle >= math.pi else angle + TURN if angle < -math.pi else angle
            ),
        ),
        Mistake(
            "only positive angles",
            "This leaves angles below −π as they are. Turning right counts, too.",
            lambda angle: (angle + math.pi) % TURN - math.pi if angle > 0 else angle,
        ),
        Mistake(
            "remainder with the sign of the angle",
            "math.fmod keeps the sign of the angle; its remainder runs from −2π to 2π.",
            lambda angle: math.fmod(angle, TURN),
        ),
        Mistake(
            "degrees",
            "This wraps degrees. The course's angles are in radians: a whole turn is 2π.",
            lambda angle: (angle + 180.0) % 360.0 - 180.0,
        ),
        Mistake(
            "open at the wrong end",
            "Half a turn must come out as −π: the range is [−π, π), closed on the left.",
            lambda angle: math.pi - (math.pi - angle) % TURN,
        ),
        Mistake(
            "unchanged",
            "This returns the angle as it came.",
            lambda angle: angle,
        ),
    ),
)

CHAPTER = Chapter(
    number="00",
    topic="start",
    title="Start here",
    minutes=30,
    needs=("Python functions",),
    exercises=(WRAP_ANGLE,),
)
