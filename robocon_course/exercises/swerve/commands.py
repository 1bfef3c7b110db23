"""From a velocity on the field to a command for the body, and how people get it wrong."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from robocon_course import swerve
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student


def rotated(vector: np.ndarray, angle: float) -> np.ndarray:
    """Velocity turned by an angle, its own turn as it is."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]])


def _field_to_robot_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    named = [
        ("a robot that looks along the map's x axis", [1.0, 0.5, 0.3], 0.0),
        ("towards the far end, looking to the left", [0.0, 1.0, 0.0], np.pi),
        ("towards the far end, looking there", [0.0, 1.0, 0.0], np.pi / 2),
        ("ahead of the field while turning", [1.0, 0.0, 2.0], 0.5),
        ("a robot that has turned twice", [0.3, -0.8, 0.0], 4 * np.pi + 0.7),
    ]
    cases = [(what, np.array(twist), float(theta)) for what, twist, theta in named]
    for _ in range(5):
        twist, theta = rng.uniform(-2.0, 2.0, 3).round(3), round(rng.uniform(-3.0, 3.0), 3)
        cases.append(("any velocity, any heading", twist, theta))
    return [Case(what, (twist, theta), "m/s, m/s, rad/s") for what, twist, theta in cases]


FIELD_TO_ROBOT = Exercise(
    id="swerve.field_to_robot",
    title="A velocity on the field, seen from the robot",
    points=1,
    reference=swerve.field_to_robot,
    cases=_field_to_robot_cases,
    hints=(
        "The robot is turned by theta, so its command has to be turned back by theta.",
        "Forward is cos · vx + sin · vy, left is −sin · vx + cos · vy; omega is the same in both.",
        "np.array([c * vx + s * vy, c * vy - s * vx, omega]) with c = cos(theta), s = sin(theta)",
    ),
    mistakes=(
        Mistake(
            "robot to field",
            "This turns the other way: it takes a velocity of the robot into the map, as two "
            "equations of one source print it. The command has to be turned by −theta.",
            lambda twist, theta: rotated(twist, theta),
        ),
        Mistake(
            "degrees",
            "theta is taken for degrees. It is in radians already.",
            lambda twist, theta: rotated(twist, -np.radians(theta)),
        ),
        Mistake(
            "sign of omega",
            "omega must stay as it is: robot and field agree about which way is left round.",
            lambda twist, theta: rotated(twist, -theta) * [1.0, 1.0, -1.0],
        ),
        Mistake(
            "omega forgotten",
            "omega got lost on the way: the robot no longer turns.",
            lambda twist, theta: rotated(twist, -theta) * [1.0, 1.0, 0.0],
        ),
        Mistake(
            "sine and cosine swapped",
            "Sine and cosine are exchanged. A robot at heading 0 must drive what it is told.",
            lambda twist, theta: rotated(twist, theta - np.pi / 2),
        ),
        Mistake(
            "one sign",
            "One of the two signs is wrong, so this is no rotation: it changes the speed.",
            lambda twist, theta: np.array(
                [
                    np.cos(theta) * twist[0] + np.sin(theta) * twist[1],
                    np.cos(theta) * twist[1] + np.sin(theta) * twist[0],
                    twist[2],
                ]
            ),
        ),
        Mistake(
            "minus twice",
            "Both sines have a minus, so this is no rotation: it changes the speed. Forward is "
            "cos · vx + sin · vy.",
            lambda twist, theta: np.array(
                [
                    np.cos(theta) * twist[0] - np.sin(theta) * twist[1],
                    np.cos(theta) * twist[1] - np.sin(theta) * twist[0],
                    twist[2],
                ]
            ),
        ),
        Mistake(
            "unchanged",
            "This returns the velocity as it came. That is right at heading 0 only.",
            lambda twist, theta: np.array(twist),
        ),
    ),
)


def _discretize_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    named = [
        ("straight ahead: nothing to change", [1.0, 0.0, 0.0], 0.1),
        ("nothing at all", [0.0, 0.0, 0.0], 0.1),
        ("a turn on the spot: nothing to change", [0.0, 0.0, 2.0], 0.1),
        ("ahead, and turning left", [1.0, 0.0, 2.0], 0.1),
        ("ahead, and turning right", [1.0, 0.0, -2.0], 0.1),
        ("almost straight", [1.5, -0.3, 1e-8], 0.02),
        ("a slow turn", [1.5, -0.3, 0.05], 0.1),
        ("a turn of 0.5 rad/s", [-1.2, 0.8, 0.5], 0.1),
        ("a slow loop: a quarter turn within one step", [1.0, 0.5, np.pi], 0.5),
    ]
    cases = [(what, (np.array(twist), dt)) for what, twist, dt in named]
    for _ in range(5):
        twist = np.append(
            rng.uniform(-2.0, 2.0, 2), rng.uniform(1.0, 6.0) * rng.choice([-1.0, 1.0])
        )
        cases.append(("any command", (twist.round(3), float(rng.choice([0.01, 0.02, 0.05, 0.1])))))
    # Students divide by tan or sin of a small angle; what that costs is no mistake.
    return [Case(what, args, "m/s, m/s, rad/s", 1e-7) for what, args in cases]


def _aimed(
    turn: Callable[[float], float], longer: Callable[[float], float]
) -> Callable[..., np.ndarray]:
    """The command turned and stretched, by functions of half the angle."""

    def function(twist: np.ndarray, dt: float) -> np.ndarray:
        half = twist[2] * dt / 2.0
        with np.errstate(all="ignore"):
            factor = longer(half)
            return rotated(twist, turn(half)) * np.array([factor, factor, 1.0])

    return function


def _stretch(half: float) -> float:
    """How much longer an arc is than its chord."""
    return 1.0 / np.sinc(half / np.pi)


def _left_out(limit: float) -> Callable[..., np.ndarray]:
    """Turns slower than a limit are taken for none."""

    def function(twist: np.ndarray, dt: float) -> np.ndarray:
        return np.array(twist) if abs(twist[2]) < limit else swerve.discretize(twist, dt)

    return function


DISCRETIZE = Exercise(
    id="swerve.discretize",
    title="Aim before the turn, so that the step ends right",
    points=2,
    reference=swerve.discretize,
    shortcuts=("robocon_course.geometry.poses.se2_log",),
    cases=_discretize_cases,
    hints=(
        "During dt the robot turns by omega · dt. On average it looks half of that to the left of "
        "where it looked at first, so aim as much to the right.",
        "half = omega · dt / 2; turn (vx, vy) by −half, and multiply it by half / sin(half), since "
        "an arc is longer than its chord.",
        "half / sin(half) is 1 at half = 0: 1 / np.sinc(half / np.pi) knows that. Forward is f · "
        "(cos(half) · vx + sin(half) · vy), left is f · (cos(half) · vy − sin(half) · vx).",
    ),
    mistakes=(
        Mistake(
            "aimed the wrong way",
            "This aims to the side to which the robot drifts anyway: the skew doubles. Turn the "
            "command by −half.",
            _aimed(lambda half: half, _stretch),
        ),
        Mistake(
            "whole angle",
            "This aims off by the whole angle. On average over the step it is half of it.",
            _aimed(lambda half: -2.0 * half, _stretch),
        ),
        Mistake(
            "arc not longer",
            "The direction is right. The robot drives an arc, though, and an arc is longer than "
            "its chord: times half / sin(half).",
            _aimed(lambda half: -half, lambda half: 1.0),
        ),
        Mistake(
            "direction unchanged",
            "The length is right, the direction is not: turn the command by −half.",
            _aimed(lambda half: 0.0, _stretch),
        ),
        Mistake(
            "arc shorter",
            "The factor is upside down: an arc is longer than its chord, so half / sin(half).",
            _aimed(lambda half: -half, lambda half: np.sinc(half / np.pi)),
        ),
        Mistake(
            "divides by zero when straight",
            "Without a turn half / sin(half) is 0/0, and the command becomes NaN. The limit is 1; "
            "np.sinc knows it.",
            _aimed(lambda half: -half, lambda half: np.float64(half) / np.sin(half)),
        ),
        Mistake(
            "stops when straight",
            "Without a turn this divides by zero and raises. half / sin(half) is 1 there; np.sinc "
            "knows it.",
            _aimed(lambda half: -half, lambda half: float(half) / math.sin(half)),
        ),
        Mistake(
            "unchanged",
            "This returns the command as it came.",
            lambda twist, dt: np.array(twist),
        ),
        Mistake(
            "way instead of speed",
            "This is the way of one step in metres. The modules want a speed: divide by dt.",
            lambda twist, dt: swerve.discretize(twist, dt) * dt,
        ),
        Mistake(
            "dt ignored",
            "The angle is omega / 2, as if a step lasted a second: it is omega · dt / 2.",
            lambda twist, dt: swerve.discretize(twist, 1.0),
        ),
        Mistake(
            "sinc without π",
            "np.sinc(h) is sin(π h) / (π h): it brings a π of its own. sin(h)/h is "
            "np.sinc(h / np.pi).",
            _aimed(lambda half: -half, lambda half: 1.0 / np.sinc(half)),
        ),
        Mistake(
            "whole angle, no arc",
            "This aims off by the whole angle, and the arc is no longer than its chord. It is half "
            "the angle, and times half / sin(half).",
            _aimed(lambda half: -2.0 * half, lambda half: 1.0),
        ),
        Mistake(
            "whole angle throughout",
            "The whole angle stands where half of it belongs, in the direction and in the length.",
            _aimed(lambda half: -2.0 * half, lambda half: _stretch(2.0 * half)),
        ),
        Mistake(
            "turn rate stretched",
            "omega is multiplied by half / sin(half), too. The turn rate is right as it came; only "
            "forward and left change.",
            lambda twist, dt: (
                swerve.discretize(twist, dt) * [1.0, 1.0, _stretch(twist[2] * dt / 2.0)]
            ),
        ),
        *(
            Mistake(
                f"turns below {limit} rad/s left out",
                "A slow turn is treated as none. It skews the command, too. np.sinc needs no "
                "exception at all.",
                _left_out(limit),
            )
            for limit in (0.1, 1)
        ),
    ),
)
