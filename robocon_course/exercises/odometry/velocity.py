"""From poses back to velocity, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import geometry, odometry
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.odometry.body import one_way
from robocon_course.exercises.odometry.poses import MICROMETRE, Answer, chord_share
from robocon_course.worlds import Student


def _body_velocity_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def drive(twists: list, dt: float, start: tuple = (0.0, 0.0, 0.0)) -> np.ndarray:
        return odometry.integrate(np.array(twists, float) * dt, start)

    wild = np.column_stack([rng.uniform(-1.5, 1.5, (30, 2)), rng.uniform(-3, 3, 30)])
    passing = drive([[0.4, 0.0, 2.0]] * 6, 0.05, (0.0, 0.0, np.radians(165)))
    passing[:, 2] = geometry.wrap_angle(passing[:, 2])
    named = [
        (
            "straight ahead, looking along y",
            drive([[1.0, 0.0, 0.0]] * 3, 0.05, (0, 0, np.pi / 2)),
            0.05,
        ),
        ("backwards", drive([[-0.8, 0.0, 0.0]] * 3, 0.05, (1, 2, 0.7)), 0.05),
        ("to the right", drive([[0.0, -0.5, 0.0]] * 3, 0.05, (0, 0, -2.0)), 0.05),
        ("on the spot, clockwise", drive([[0.0, 0.0, -2.0]] * 3, 0.05), 0.05),
        ("a left turn, half a radian in each step", drive([[1.0, 0.0, 1.0]] * 4, 0.5), 0.5),
        ("the heading passes ±180° to the left", passing, 0.05),
        ("the heading passes ±180° to the right", passing * [1.0, -1.0, -1.0], 0.05),
        ("a tight curve, seldom sampled", drive([[1.0, 0.2, 3.0]] * 4, 0.5), 0.5),
        ("a fast turn", drive([[0.5, 0.1, -5.0]] * 4, 0.1), 0.1),
        ("a wild drive", drive(wild, 0.1, (0.5, -1.0, 2.0)), 0.1),
    ]
    return [Case(what, (poses, dt), "m/s, m/s, rad/s", MICROMETRE) for what, poses, dt in named]


def _turns(yaw: np.ndarray) -> np.ndarray:
    return geometry.wrap_angle(np.diff(yaw))


def _stretch(half: np.ndarray) -> np.ndarray:
    return 1.0 / chord_share(half)


def _late_wrap(steps: np.ndarray, dt: float) -> np.ndarray:
    return np.column_stack([steps[:, :2] / dt, geometry.wrap_angle(steps[:, 2] / dt)])


def _velocity(
    at: float,
    *,
    longer: Callable[[np.ndarray], np.ndarray] = _stretch,
    turn: Callable[[np.ndarray], np.ndarray] = _turns,
    look: Callable[[np.ndarray], np.ndarray] | None = None,
    change: Callable[[np.ndarray, float], np.ndarray] = lambda steps, dt: steps / dt,
) -> Answer:
    """Velocity seen from the heading ``at`` a share of the turn, or from where one looks."""

    def function(poses: np.ndarray, dt: float) -> np.ndarray:
        step, yaw = np.diff(poses[:, :2], axis=0), poses[:, 2]
        turned = turn(yaw)
        heading = look(yaw) if look else yaw[:-1] + at * turned
        c, s = np.cos(heading), np.sin(heading)
        stretch = longer(turned / 2)
        forward = stretch * (c * step[:, 0] + s * step[:, 1])
        left = stretch * (c * step[:, 1] - s * step[:, 0])
        return change(np.column_stack([forward, left, turned]), dt)

    return function


BODY_VELOCITY = Exercise(
    id="odometry.body_velocity",
    title="Speed with its sign",
    points=2,
    reference=odometry.body_velocity,
    shortcuts=("robocon_course.geometry.poses.se2_log",),
    cases=_body_velocity_cases,
    hints=(
        "Go the way of integrate backwards: difference of places, turn it into the base, stretch "
        "the chord to its arc, divide by dt.",
        "turn = wrapped difference of headings; look = θ + turn/2; forward = cos · dx + sin · dy, "
        "left = cos · dy − sin · dx.",
        "Divide forward and left by np.sinc(turn / 2 / np.pi), then all three by dt.",
    ),
    mistakes=(
        Mistake(
            "absolute values",
            "The sign is lost, as in one of the sources: nobody can tell forwards from backwards, "
            "or left from right.",
            _velocity(0.5, change=lambda steps, dt: np.abs(steps) / dt),
        ),
        Mistake(
            "missing wrap",
            "Where the heading passes ±180° the robot seems to spin at a hundred radians a second. "
            "Wrap the difference of headings.",
            _velocity(0.5, turn=np.diff),
        ),
        Mistake(
            "world for body",
            "This is the velocity in map axes. Asked for is what the robot feels: turn it back by "
            "the heading.",
            _velocity(0.0, longer=np.ones_like, look=lambda yaw: 0.0 * yaw[1:]),
        ),
        Mistake(
            "start heading",
            "The step is seen from the heading at its beginning. Its chord points along the "
            "heading halfway.",
            _velocity(0.0, longer=np.ones_like),
        ),
        Mistake(
            "end heading",
            "The step is seen from the heading at its end. Its chord points along the heading "
            "halfway.",
            _velocity(1.0, longer=np.ones_like),
        ),
        *(
            Mistake(
                f"{words} heading, right arc",
                f"The arc has the right length, but the step is seen from the heading at its "
                f"{words}. Its chord points along the heading halfway: θ + turn/2.",
                _velocity(at),
            )
            for words, at in (("start", 0.0), ("end", 1.0))
        ),
        Mistake(
            "mean of the headings",
            "Halfway between 179° and −179° is 180°, not 0°: the mean of two wrapped headings "
            "looks backwards. Take the first heading and half of the wrapped turn.",
            _velocity(0.5, look=lambda yaw: (yaw[:-1] + yaw[1:]) / 2),
        ),
        Mistake(
            "sinc without π",
            "np.sinc(h) is sin(π h) / (π h): it brings a π of its own. sin(h)/h is "
            "np.sinc(h / np.pi).",
            _velocity(0.5, longer=lambda half: 1.0 / np.sinc(half)),
        ),
        Mistake(
            "arc shorter",
            "The factor is upside down: the arc is longer than its chord, so divide by sin(h)/h.",
            _velocity(0.5, longer=chord_share),
        ),
        Mistake(
            "turned the wrong way",
            "The step is turned into the map once more. Turn it back by the heading: "
            "cos · dx + sin · dy forward, cos · dy − sin · dx left.",
            _velocity(0.5, look=lambda yaw: -yaw[:-1] - _turns(yaw) / 2),
        ),
        Mistake(
            "turn not divided by dt",
            "Forward and left are speeds, the turn is not yet: divide all three by dt.",
            _velocity(0.5, change=lambda steps, dt: steps / [dt, dt, 1.0]),
        ),
        Mistake(
            "chord for arc",
            "This is the length of the chord. The robot drove the arc: divide by sin(h)/h with "
            "h = turn/2.",
            _velocity(0.5, longer=np.ones_like),
        ),
        Mistake(
            "not divided by dt",
            "These are steps, not speeds: divide by dt.",
            _velocity(0.5, change=lambda steps, dt: steps),
        ),
        Mistake(
            "times dt",
            "Speed is way divided by time, not times.",
            _velocity(0.5, change=lambda steps, dt: steps * dt),
        ),
        Mistake(
            "degrees per second",
            "The turn is in degrees per second. It is in rad/s everywhere in the robot.",
            _velocity(0.5, change=lambda steps, dt: steps * [1.0, 1.0, 180.0 / np.pi] / dt),
        ),
        Mistake(
            "millimetres per second",
            "Forward and left are in mm/s. The robot counts in m/s.",
            _velocity(0.5, change=lambda steps, dt: steps * [1000.0, 1000.0, 1.0] / dt),
        ),
        Mistake(
            "forward and left swapped",
            "The first two columns are swapped: forward (x) comes first, then left (y).",
            _velocity(0.5, change=lambda steps, dt: steps[:, [1, 0, 2]] / dt),
        ),
        Mistake(
            "wrapped after the division",
            "The turn rate is wrapped, not the turn: a robot that turns by 5 rad/s seems to turn "
            "the other way. Wrap first, then divide by dt.",
            _velocity(0.5, change=_late_wrap),
        ),
        Mistake(
            "start heading, nothing wrapped",
            "The step is seen from the heading at its beginning; its chord points along the "
            "heading halfway. And where the heading passes ±180° the turn has to be wrapped.",
            _velocity(0.0, longer=np.ones_like, turn=np.diff),
        ),
        *(
            Mistake(
                f"wraps {words} turns only",
                "The difference of headings is mended where ±180° is passed one way, but not the "
                "other way. Mend both: above π and below −π.",
                _velocity(0.5, turn=lambda yaw, sign=sign: one_way(yaw, sign)),
            )
            for words, sign in (("left", 1.0), ("right", -1.0))
        ),
    ),
)
