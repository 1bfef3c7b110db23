"""Two numbers from the student's own field."""

from __future__ import annotations

import functools

import numpy as np

from robocon_course import worlds
from robocon_course.exercises.model import Mistake, Number
from robocon_course.worlds import Student, ways


@functools.lru_cache(maxsize=16)
def _lengths(student: Student) -> dict[str, float]:
    return ways.wrong_lengths(worlds.ways_world(student).grid)


OWN_LENGTH = Number(
    id="planning.own_length",
    title="How long your robot's way is",
    points=1,
    truth=lambda student: _lengths(student)["right"],
    tolerance=0.004,
    unit="m",
    likeness=3e-4,
    hints=(
        "Make room for the body first: inflate_square(world.grid, worlds.HALF).",
        "astar(room, world.start, world.goal).length",
    ),
    mistakes=(
        Mistake(
            "corners cut",
            "That is the way with corners cut: it passes diagonally beside blocked cells.",
            lambda student: _lengths(student)["corners"],
        ),
        Mistake(
            "a disc",
            "That is the way of a disc of 0.325 m. Your robot is square, and its corners need "
            "more: inflate_square.",
            lambda student: _lengths(student)["disc"],
        ),
        Mistake(
            "a point",
            "That is the way of a point. The robot is 0.65 m wide: plan in the inflated map.",
            lambda student: _lengths(student)["size"],
        ),
        Mistake(
            "an empty field",
            "That is the way over the field without your boxes. They stand in world.grid.",
            lambda student: _lengths(student)["boxes"],
        ),
        Mistake(
            "in cells",
            "That is in cells. The question asks for metres: Plan.length.",
            lambda student: _lengths(student)["right"] / worlds.ways_world(student).grid.resolution,
        ),
        Mistake(
            "as the crow flies",
            "That is the straight line from start to goal, through walls and boxes.",
            lambda student: float(
                np.hypot(
                    *np.subtract(worlds.ways_world(student).goal, worlds.ways_world(student).start)
                )
            ),
        ),
    ),
)


@functools.lru_cache(maxsize=16)
def _half(student: Student) -> float:
    return ways.widest_half(worlds.ways_world(student).fine)


@functools.lru_cache(maxsize=16)
def _coarse_half(student: Student) -> float:
    return ways.widest_half(worlds.ways_world(student).grid)


OWN_GAP = Number(
    id="planning.own_gap",
    title="The largest robot that gets through",
    points=1,
    truth=_half,
    tolerance=0.004,
    unit="m",
    likeness=1e-6,
    hints=(
        "Try half sides of 0.33 m, 0.34 m and so on. As long as astar finds a way there is one; "
        "then it raises NoPathError.",
        "for cm in range(33, 60): planning.astar(gridmap.inflate_square(world.fine, cm / 100), "
        "worlds.RAMP_TOP, world.goal). The last cm that passes is the answer.",
    ),
    mistakes=(
        Mistake(
            "on the coarse map",
            "That comes of the map with cells of 5 cm, where every gap looks narrower than it is. "
            "Use world.fine.",
            _coarse_half,
        ),
        Mistake(
            "first that fails",
            "That is the first half side that does not get through. The question asks for the last "
            "that does.",
            lambda student: _half(student) + 0.01,
        ),
        Mistake(
            "the whole side",
            "That is the whole side. The question asks for half of it.",
            lambda student: 2.0 * _half(student),
        ),
        Mistake(
            "in centimetres",
            "That is in centimetres. The question asks for metres.",
            lambda student: 100.0 * _half(student),
        ),
    ),
)
