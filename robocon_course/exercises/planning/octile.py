"""What is left to the goal at least, and how people get it wrong."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.planning.maps import Cell
from robocon_course.planning import octile_distance
from robocon_course.planning.steps import ROOT_2
from robocon_course.worlds import Student


def _octile_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    named = [
        ("one row up, three columns over", (2, 1), (3, 4)),
        ("along a row", (5, 2), (5, 12)),
        ("along a diagonal, backwards", (9, 9), (3, 3)),
        ("the goal itself", (4, 7), (4, 7)),
        ("down and to the left", (20, 31), (3, 24)),
    ]
    for _ in range(6):
        cell, goal = rng.integers(0, 200, (2, 2)).tolist()
        named.append(("two cells of your own", tuple(cell), tuple(goal)))
    return [Case(what, (cell, goal), "cells") for what, cell, goal in named]


def _left(formula: Callable[[int, int], float]) -> Callable[[Cell, Cell], float]:
    """A wrong formula of the rows and columns that are left."""
    return lambda cell, goal: float(formula(abs(goal[0] - cell[0]), abs(goal[1] - cell[1])))


OCTILE_DISTANCE = Exercise(
    id="planning.octile_distance",
    title="What is left at least",
    points=1,
    reference=octile_distance,
    shortcuts=(
        "robocon_course.planning.moves.estimate",
        "robocon_course.planning.shortest.astar",
        "robocon_course.planning.shortest.anytime_astar",
        "robocon_course.planning.replanning.Replanner.plan",
    ),
    cases=_octile_cases,
    time_limit=2.0,
    hints=(
        "Go diagonally until you are level with the goal, then straight on. How many of each?",
        "With a and b rows and columns: min(a, b) diagonal steps, and max(a, b) − min(a, b) "
        "straight ones.",
        "max(a, b) + (math.sqrt(2) - 1) * min(a, b), with a = abs(goal[0] - cell[0]) and b for "
        "the columns.",
    ),
    mistakes=(
        Mistake(
            "Manhattan",
            "This counts rows and columns, as if the robot could not drive diagonally. It is more "
            "than what is left, by up to √2.",
            _left(lambda a, b: a + b),
        ),
        Mistake(
            "straight line",
            "This is the length of the straight line. The way goes along eight directions, and is "
            "longer: the estimate would be safe, but weak.",
            _left(math.hypot),
        ),
        Mistake(
            "diagonal for one",
            "This counts a diagonal step as 1. It is √2 long.",
            _left(max),
        ),
        Mistake(
            "smaller and larger exchanged",
            "min and max are exchanged: the diagonal steps are as many as the smaller of the two.",
            _left(lambda a, b: min(a, b) + (ROOT_2 - 1.0) * max(a, b)),
        ),
        Mistake(
            "14 for 10 times the root",
            "A diagonal step counts 14 here where a straight one counts 10. √2 is a little more, "
            "and over a hundred steps that is more than a cell.",
            _left(lambda a, b: max(a, b) + 0.4 * min(a, b)),
        ),
        Mistake(
            "rounded root",
            "0.414 or 1.414 is rounded, and over a hundred steps that is felt: math.sqrt(2) - 1.",
            _left(lambda a, b: max(a, b) + 0.414 * min(a, b)),
        ),
        Mistake(
            "ten for one",
            "This counts 10 and 14 for a step. Here a straight step is 1, a diagonal one √2.",
            _left(lambda a, b: 10 * max(a, b) + 4 * min(a, b)),
        ),
        Mistake(
            "diagonal steps counted twice",
            "Diagonal steps are counted twice: max(a, b) contains them already, so only √2 − 1 is "
            "added for each.",
            _left(lambda a, b: max(a, b) + ROOT_2 * min(a, b)),
        ),
        Mistake(
            "sign kept",
            "Without abs() a goal below or to the left has negative rows or columns.",
            lambda cell, goal: float(
                max(goal[0] - cell[0], goal[1] - cell[1])
                + (ROOT_2 - 1.0) * min(goal[0] - cell[0], goal[1] - cell[1])
            ),
        ),
        Mistake(
            "square of the distance",
            "This is the square of a distance: far too much.",
            _left(lambda a, b: a * a + b * b),
        ),
    ),
)
