"""From travel to motion, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import geometry, odometry, worlds
from robocon_course.drivetrain import wheel_matrix
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.odometry.wheels import some_wheels
from robocon_course.odometry import TrackingWheels
from robocon_course.worlds import Student

Answer = Callable[..., np.ndarray]
MICROMETRE = 1e-6


def _body_deltas_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    own, other = worlds.own_wheels(student), some_wheels(rng)
    places = np.array([(0.3, 0.2), (-0.2, 0.3), (-0.3, -0.2), (0.2, -0.3)])
    four = TrackingWheels(
        places + rng.uniform(-0.05, 0.05, (4, 2)),
        rng.uniform(-3, 3) + np.arange(4) * 1.7,
        0.03,
        3200,
    )
    motions = np.column_stack([*rng.uniform(-0.02, 0.02, (2, 30)), rng.uniform(-0.05, 0.05, 30)])
    slipped = motions @ own.matrix.T
    slipped[10:20, 0] *= 0.4
    across = np.radians(160) + 0.03 * np.arange(len(motions) + 1)
    gyro = np.cumsum(np.r_[0.3, motions[:, 2]])
    noisy = motions @ four.matrix.T + rng.normal(0.0, 2e-4, (30, 4))
    named = [
        ("straight ahead", (own, np.array([[0.01, 0.01, 0.0]]))),
        ("to the left", (own, np.array([[0.0, 0.0, 0.01]]))),
        ("on the spot", (own, np.array([[0.0, 0.0, 0.1]]) @ own.matrix.T)),
        ("any motion", (other, motions @ other.matrix.T)),
        ("four wheels that do not quite agree", (four, noisy)),
        ("the same with a gyroscope's heading", (four, noisy, gyro)),
        ("the left wheel slips, the gyroscope does not", (own, slipped, gyro)),
        ("a heading that passes ±180° to the left", (own, slipped, geometry.wrap_angle(across))),
        ("a heading that passes ±180° to the right", (own, slipped, geometry.wrap_angle(-across))),
    ]
    return [Case(what, args, "m, m, rad", MICROMETRE) for what, args in named]


def _moved(positions: Callable[[np.ndarray], np.ndarray]) -> Answer:
    """The right way with the wheels believed elsewhere."""

    def function(
        wheels: TrackingWheels, travel: np.ndarray, yaw: np.ndarray | None = None
    ) -> np.ndarray:
        place = positions(np.array(wheels.positions))
        return odometry.body_deltas(
            TrackingWheels(place, wheels.directions, wheels.radius, wheels.ticks_per_turn),
            travel,
            yaw,
        )

    return function


def _with_yaw(
    turn: Callable[[np.ndarray], np.ndarray], *, taken_off: bool = True, sign: float = 1.0
) -> Answer:
    """Wheels as they should be, but another turn from the heading."""

    def function(
        wheels: TrackingWheels, travel: np.ndarray, yaw: np.ndarray | None = None
    ) -> np.ndarray:
        if yaw is None:
            return odometry.body_deltas(wheels, travel)
        turned, matrix = turn(yaw), wheel_matrix(wheels.positions, wheels.directions)
        if not taken_off:
            return np.column_stack([odometry.body_deltas(wheels, travel)[:, :2], turned])
        rest = travel - sign * turned[:, None] * matrix[:, 2]
        return np.column_stack([rest @ np.linalg.pinv(matrix[:, :2]).T, turned])

    return function


def _turns(yaw: np.ndarray) -> np.ndarray:
    return geometry.wrap_angle(np.diff(yaw))


def one_way(yaw: np.ndarray, sign: float) -> np.ndarray:
    """Differences of headings, mended only where ±180° is passed to the left (1) or right (-1)."""
    turned = np.diff(yaw)
    return np.where(sign * turned < -np.pi, turned + sign * 2 * np.pi, turned)


def _changed(change: Callable[[np.ndarray], np.ndarray]) -> Answer:
    return lambda wheels, travel, yaw=None: change(odometry.body_deltas(wheels, travel, yaw))


def _in_map(
    wheels: TrackingWheels, travel: np.ndarray, yaw: np.ndarray | None = None
) -> np.ndarray:
    deltas = odometry.body_deltas(wheels, travel, yaw)
    heading = np.cumsum(deltas[:, 2]) - deltas[:, 2] if yaw is None else yaw[:-1]
    turned = geometry.transform_points(
        np.column_stack([0 * heading, 0 * heading, heading]), deltas[:, :2]
    )
    return np.column_stack([turned, deltas[:, 2]])


def _solved(solver: Callable[[np.ndarray], np.ndarray], known: Callable | None = None) -> Answer:
    """Another matrix in place of the pseudo-inverse, transposed; with yaw, too, if so asked."""

    def function(
        wheels: TrackingWheels, travel: np.ndarray, yaw: np.ndarray | None = None
    ) -> np.ndarray:
        matrix = wheel_matrix(wheels.positions, wheels.directions)
        if yaw is None:
            return travel @ solver(matrix)
        if known is None:
            return odometry.body_deltas(wheels, travel, yaw)
        turned = _turns(yaw)
        rest = travel - turned[:, None] * matrix[:, 2]
        return np.column_stack([rest @ known(matrix[:, :2]), turned])

    return function


def _left_right_rear(
    wheels: TrackingWheels, travel: np.ndarray, yaw: np.ndarray | None = None
) -> np.ndarray:
    (left, right, rear), (x, y) = travel[:, :3].T, wheels.positions.T
    turned = (right - left) / (y[0] - y[1]) if yaw is None else _turns(yaw)
    return np.column_stack([(left + right) / 2, rear - x[2] * turned, turned])


BODY_DELTAS = Exercise(
    id="odometry.body_deltas",
    title="The body's motion from its wheels, and from a gyroscope",
    points=3,
    reference=odometry.body_deltas,
    shortcuts=(
        "robocon_course.odometry.wheels.TrackingWheels.solver",
        "robocon_course.odometry.wheels.TrackingWheels.shift_solver",
    ),
    cases=_body_deltas_cases,
    hints=(
        "A Δ = d for every row of travel, with A = wheel_matrix(wheels.positions, "
        "wheels.directions). For all rows at once: travel @ np.linalg.pinv(A).T",
        "With yaw the turn is known: the wrapped difference of headings. Take what the turn rolls "
        "off the travel, travel − turn[:, None] * A[:, 2]; what is left is forward and left.",
        "rest @ np.linalg.pinv(A[:, :2]).T gives two columns; np.column_stack puts turn beside "
        "them.",
    ),
    mistakes=(
        Mistake(
            "rear wheel in front",
            "The wheel across is taken to stand on the other side of the centre, as in one of the "
            "sources: a turn on the spot then reads as sideways travel of twice the offset times "
            "the angle.",
            _moved(lambda place: place * [-1.0, 1.0]),
        ),
        Mistake(
            "turn of the wheel across forgotten",
            "What the turn alone rolls on the wheel across is not taken off: on the spot the robot "
            "seems to go sideways.",
            _moved(lambda place: place * [0.0, 1.0]),
        ),
        Mistake(
            "left and right swapped",
            "Left and right wheel are swapped, so the turn has the wrong sign: the right wheel "
            "rolls further in a left turn.",
            _moved(lambda place: place * [1.0, -1.0]),
        ),
        Mistake(
            "yaw ignored",
            "The heading is not used: with yaw the turn is its difference, not the wheels'.",
            lambda wheels, travel, yaw=None: odometry.body_deltas(wheels, travel),
        ),
        Mistake(
            "wheels' turn left in",
            "The turn is the gyroscope's, but forward and left still hold the wheels' own turn. "
            "Put the known turn in first, then solve for forward and left only.",
            _with_yaw(_turns, taken_off=False),
        ),
        Mistake(
            "turn added",
            "What the turn rolls on the wheels is added to the travel. It is in there already: "
            "take it off.",
            _with_yaw(_turns, sign=-1.0),
        ),
        Mistake(
            "missing wrap",
            "Where the heading passes ±180° the robot seems to turn all the way round. Wrap the "
            "difference.",
            _with_yaw(np.diff),
        ),
        Mistake(
            "heading for turn",
            "The heading itself is taken for the turn. The turn is the difference of two headings.",
            _with_yaw(lambda yaw: yaw[1:]),
        ),
        Mistake(
            "turn reversed",
            "The turn from the heading has the wrong sign: new heading minus old.",
            _with_yaw(lambda yaw: -_turns(yaw)),
        ),
        Mistake(
            "degrees",
            "The turn is in degrees. It is in radians everywhere in the robot.",
            _changed(lambda deltas: deltas * [1.0, 1.0, 180.0 / np.pi]),
        ),
        Mistake(
            "forward and left swapped",
            "The first two columns are swapped: forward (x) comes first, then left (y).",
            _changed(lambda deltas: deltas[:, [1, 0, 2]]),
        ),
        Mistake(
            "world for body",
            "The motion is turned into the map already. It belongs to the base here.",
            _in_map,
        ),
        Mistake(
            "transposed",
            "Rows and columns of the result are swapped: one row for each sample, three columns.",
            _changed(np.transpose),
        ),
        *(
            Mistake(
                f"solver not transposed{where}",
                "The matrix that solves for one sample stands to its left. For rows of travel it "
                "stands to the right and has to be transposed: travel @ np.linalg.pinv(A).T.",
                _solved(np.linalg.pinv, known),
            )
            for where, known in (("", np.linalg.pinv), (" without yaw", None))
        ),
        *(
            Mistake(
                f"inverse for pseudo-inverse{where}",
                "Only three wheels have an inverse. With four wheels, or with the turn known, the "
                "matrix is not square: np.linalg.pinv(A) is least squares.",
                _solved(lambda matrix: np.linalg.inv(matrix).T, known),
            )
            for where, known in (("", np.linalg.inv), (" without yaw", None))
        ),
        Mistake(
            "formulas of one robot",
            "Mean and difference of left and right are the answer for two wheels equally far from "
            "the centre. Solve with the wheel matrix, and any number of wheels anywhere will do.",
            _left_right_rear,
        ),
        *(
            Mistake(
                f"wraps {words} turns only",
                "The difference of headings is mended where ±180° is passed one way, but not the "
                "other way. Mend both: above π and below −π.",
                _with_yaw(lambda yaw, sign=sign: one_way(yaw, sign)),
            )
            for words, sign in (("left", 1.0), ("right", -1.0))
        ),
    ),
)
