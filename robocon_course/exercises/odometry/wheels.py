"""Travel and the wheel matrix, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import drivetrain, odometry, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS
from robocon_course.worlds import Student

AHEAD, LEFTWARD = 0.0, np.pi / 2


def some_wheels(rng: np.random.Generator) -> TrackingWheels:
    """Another robot's wheels, near the drawing."""
    return worlds.own_wheels(int(rng.integers(1 << 30)), "case")


def _wheel_travel_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    own, other = worlds.own_wheels(student), some_wheels(rng)
    small = TrackingWheels(rng.uniform(-0.3, 0.3, (4, 2)), rng.uniform(-3, 3, 4), 0.019, 2048)
    named = [
        ("one turn of every wheel, as drawn", DEAD_WHEELS, [3200, 3200, 3200]),
        ("your wheels, none as large as the other", own, [3200, -3200, 1600]),
        ("one sample", own, rng.integers(-90, 90, 3)),
        ("many samples", other, rng.integers(-90, 90, (50, 3))),
        ("four wheels, 2048 counts a turn", small, rng.integers(-90, 90, (20, 4))),
    ]
    return [Case(what, (wheels, np.array(ticks)), "m", 1e-9) for what, wheels, ticks in named]


def _scaled_travel(factor: Callable[[TrackingWheels], float]) -> Callable[..., np.ndarray]:
    return lambda wheels, ticks: odometry.wheel_travel(wheels, ticks) * factor(wheels)


WHEEL_TRAVEL = Exercise(
    id="odometry.wheel_travel",
    title="From counts to metres",
    points=1,
    reference=odometry.wheel_travel,
    shortcuts=("robocon_course.odometry.wheels.TrackingWheels.metres_per_tick",),
    cases=_wheel_travel_cases,
    hints=(
        "In one turn a wheel rolls its circumference and counts wheels.ticks_per_turn.",
        "2 π · wheels.radius · ticks / wheels.ticks_per_turn; wheels.radius holds one radius per "
        "wheel, and NumPy matches it to the last axis of ticks.",
    ),
    mistakes=(
        Mistake(
            "radius for diameter",
            "This is half the way: the circumference is 2 π r, or π times the diameter.",
            _scaled_travel(lambda wheels: 0.5),
        ),
        Mistake(
            "diameter for radius",
            "This is twice the way: wheels.radius is the radius already.",
            _scaled_travel(lambda wheels: 2.0),
        ),
        Mistake(
            "pulses for counts",
            "This is four times the way. The encoder's 800 pulses count 3200 steps: both edges of "
            "both channels. wheels.ticks_per_turn has the 4 in it.",
            _scaled_travel(lambda wheels: 4.0),
        ),
        Mistake(
            "800 instead of 3200",
            "800 pulses a turn are 3200 counts: both edges of both channels count. And other "
            "encoders have another number: wheels.ticks_per_turn.",
            _scaled_travel(lambda wheels: wheels.ticks_per_turn / 800),
        ),
        Mistake(
            "always 3200 counts",
            "It is right for encoders of 3200 counts a turn only. The number is in "
            "wheels.ticks_per_turn.",
            _scaled_travel(lambda wheels: wheels.ticks_per_turn / 3200),
        ),
        Mistake(
            "counts times four",
            "This is a quarter of the way: wheels.ticks_per_turn has the factor 4 of the edges in "
            "it already.",
            _scaled_travel(lambda wheels: 0.25),
        ),
        Mistake(
            "2 π forgotten",
            "The factor 2 π is missing: this is turns times radius.",
            _scaled_travel(lambda wheels: 0.5 / np.pi),
        ),
        Mistake(
            "angle of the wheel",
            "This is the angle by which the wheel turned. Times its radius it is the way.",
            lambda wheels, ticks: 2 * np.pi * np.asarray(ticks) / wheels.ticks_per_turn,
        ),
        Mistake(
            "one radius for all",
            "Every wheel gets the first one's radius. Each has its own in wheels.radius.",
            lambda wheels, ticks: (
                2 * np.pi * wheels.radius[0] * np.asarray(ticks) / wheels.ticks_per_turn
            ),
        ),
        Mistake(
            "mean radius for all",
            "Every wheel gets the mean radius. Each has its own in wheels.radius.",
            lambda wheels, ticks: (
                2 * np.pi * wheels.radius.mean() * np.asarray(ticks) / wheels.ticks_per_turn
            ),
        ),
        Mistake(
            "whole metres",
            "The metres are cut to whole numbers, as an array made like ticks does: its entries "
            "are integers. Make one of floats, or none at all.",
            lambda wheels, ticks: odometry.wheel_travel(wheels, ticks).astype(int),
        ),
        Mistake(
            "whole turns",
            "Only whole turns count: // cuts off the rest. Divide with /.",
            lambda wheels, ticks: 2 * np.pi * wheels.radius * (ticks // wheels.ticks_per_turn),
        ),
        Mistake(
            "millimetres",
            "This is in millimetres. Everything in the robot is in metres.",
            _scaled_travel(lambda wheels: 1000.0),
        ),
        Mistake(
            "absolute values",
            "The sign is lost: negative counts are a way back.",
            lambda wheels, ticks: np.abs(odometry.wheel_travel(wheels, ticks)),
        ),
        Mistake(
            "the drawn radius for all",
            "Every wheel gets the radius of the drawing. No real wheel is as drawn: wheels.radius.",
            lambda wheels, ticks: (
                2 * np.pi * DEAD_WHEELS.radius[0] * np.asarray(ticks) / wheels.ticks_per_turn
            ),
        ),
    ),
)


def _wheel_matrix_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    own, count = worlds.own_wheels(student), 5
    around = np.radians([60.0, 180.0, 300.0])
    circle = 0.2 * np.column_stack([np.cos(around), np.sin(around)])
    named = [
        ("a wheel ahead, on the left", [[0.0, 0.25]], [AHEAD]),
        ("a wheel across, behind the centre", [[-0.3, 0.0]], [LEFTWARD]),
        ("a wheel across, in front of the centre", [[0.3, 0.0]], [LEFTWARD]),
        ("a wheel that counts up when it rolls back", [[0.1, -0.2]], [np.pi]),
        ("your own dead wheels", own.positions, own.directions),
        ("three omni wheels around a circle", circle, around + np.pi / 2),
        ("a differential drive", [[0.0, 0.16], [0.0, -0.16]], [AHEAD, AHEAD]),
        ("wheels anywhere", rng.uniform(-0.4, 0.4, (count, 2)), rng.uniform(-3, 3, count)),
    ]
    return [
        Case(what, (np.array(places), np.array(ways)), "", 1e-9) for what, places, ways in named
    ]


def _matrix(
    lever: Callable[..., np.ndarray],
    order: tuple[int, int, int] = (0, 1, 2),
    angle: Callable[[np.ndarray], np.ndarray] = lambda directions: directions,
) -> Callable[..., np.ndarray]:
    """The matrix with another lever arm, other columns, or other angles."""

    def function(positions: np.ndarray, directions: np.ndarray) -> np.ndarray:
        x, y = np.transpose(positions)
        c, s = np.cos(angle(directions)), np.sin(angle(directions))
        return np.column_stack([c, s, lever(x, y, c, s)])[:, order]

    return function


def _lever(x: np.ndarray, y: np.ndarray, c: np.ndarray, s: np.ndarray) -> np.ndarray:
    return x * s - y * c


WHEEL_MATRIX = Exercise(
    id="odometry.wheel_matrix",
    title="The wheel matrix",
    points=2,
    reference=drivetrain.wheel_matrix,
    shortcuts=("robocon_course.odometry.wheels.TrackingWheels.matrix",),
    cases=_wheel_matrix_cases,
    hints=(
        "One row per wheel: cos a, sin a, lever arm. np.column_stack puts three columns together.",
        "The body turns with ω: the wheel's place moves with ω (−y, x). How much of that is along "
        "(cos a, sin a)?",
        "np.column_stack([np.cos(a), np.sin(a), x * np.sin(a) − y * np.cos(a)])",
    ),
    mistakes=(
        Mistake(
            "sign of the lever arm",
            "The third column has the wrong sign: turning left, the left wheel rolls back, so "
            "its lever arm is −y. It is x sin a − y cos a.",
            _matrix(lambda x, y, c, s: y * c - x * s),
        ),
        Mistake(
            "as if in front",
            "A wheel behind the centre is treated as if it stood in front, as in one of the "
            "sources: on a left turn a wheel behind goes to the right. Its x is negative; keep "
            "the sign.",
            _matrix(lambda x, y, c, s: np.abs(x) * s - y * c),
        ),
        Mistake(
            "plus for minus",
            "There is a plus where a minus belongs: a left turn moves a place to (−y, x), so the "
            "lever arm is x sin a − y cos a.",
            _matrix(lambda x, y, c, s: x * s + y * c),
        ),
        Mistake(
            "every wheel ahead",
            "The third column is −y for every wheel. That is right for wheels that roll ahead; the "
            "others need x sin a − y cos a.",
            _matrix(lambda x, y, c, s: -y),
        ),
        Mistake(
            "distance as lever arm",
            "The third column is the distance from the centre. Only the part of it square to the "
            "wheel's direction counts, and it has a sign: x sin a − y cos a.",
            _matrix(lambda x, y, c, s: np.hypot(x, y)),
        ),
        Mistake(
            "dot for cross product",
            "The third column is x cos a + y sin a: how far out the wheel stands along its own "
            "direction. Turning moves it square to that: x sin a − y cos a.",
            _matrix(lambda x, y, c, s: x * c + y * s),
        ),
        Mistake(
            "x and y swapped",
            "In the third column x and y are swapped: it is x sin a − y cos a.",
            _matrix(lambda x, y, c, s: y * s - x * c),
        ),
        Mistake(
            "sine and cosine swapped",
            "The first two columns are swapped: direction 0 is ahead, so cos a belongs to vx.",
            _matrix(_lever, (1, 0, 2)),
        ),
        Mistake(
            "turn forgotten",
            "The third column is 0: a wheel away from the centre rolls when the robot turns, too.",
            _matrix(lambda x, y, c, s: 0 * x),
        ),
        Mistake(
            "degrees",
            "The directions are taken for degrees. They are in radians already.",
            _matrix(_lever, angle=np.radians),
        ),
        Mistake(
            "transposed",
            "Rows and columns are swapped: one row per wheel, three columns.",
            lambda positions, directions: drivetrain.wheel_matrix(positions, directions).T,
        ),
        Mistake(
            "absolute values",
            "The lever arms have lost their signs: in a left turn the left wheel rolls back. It is "
            "x sin a − y cos a.",
            _matrix(lambda x, y, c, s: np.abs(_lever(x, y, c, s))),
        ),
    ),
)
