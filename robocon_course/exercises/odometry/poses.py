"""From motion to poses, and back to velocity, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import geometry, odometry, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student

Answer = Callable[..., np.ndarray]
MICROMETRE = 1e-6


def _integrate_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    world = worlds.odometry_world(student)
    ticks = odometry.tick_changes(world.square.counters[::10], worlds.BITS)
    square = odometry.body_deltas(world.wheels, odometry.wheel_travel(world.wheels, ticks))
    quarter, start = np.pi / 2, (1.0, -2.0, 2.5)
    many = np.column_stack([rng.normal(0.02, 0.05, (200, 2)), rng.normal(0.0, 0.3, 200)])
    many[::20, 2] = 0.0
    named = [
        ("straight ahead", ([[0.3, 0.0, 0.0], [0.2, 0.0, 0.0]],)),
        ("a quarter of a circle in one step", ([[quarter, 0.0, quarter]],)),
        ("to the left in a quarter of a circle", ([[0.0, quarter, quarter]],)),
        ("on the spot", ([[0.0, 0.0, 1.0], [0.0, 0.0, -2.5]],)),
        ("a whole circle in 12 steps", (np.tile([0.2, 0.0, np.pi / 6], (12, 1)),)),
        ("from a start that looks elsewhere", ([[0.5, 0.1, 0.4], [0.5, -0.1, -0.9]], start)),
        ("almost straight", (np.tile([0.3, -0.2, 1e-12], (20, 1)),)),
        ("a wild drive", (many, start)),
        ("your own square, every tenth sample", (square,)),
    ]
    cases = [(what, tuple(np.array(a, float) for a in args)) for what, args in named]
    return [Case(what, args, "m, m, rad", MICROMETRE) for what, args in cases]


def _integrated(
    at: float,
    chord: Callable[[np.ndarray], np.ndarray] = np.ones_like,
    *,
    turned: float = 1.0,
    first: Callable[[np.ndarray], np.ndarray] = lambda start: start,
    last: Callable[[np.ndarray, np.ndarray], np.ndarray] = lambda poses, start: poses,
) -> Answer:
    """Dead reckoning with the heading taken ``at`` a share of each turn, and another chord."""

    def function(deltas: np.ndarray, start: np.ndarray = (0.0, 0.0, 0.0)) -> np.ndarray:
        begin = first(np.asarray(start, float))
        theta = begin[2] + np.r_[0.0, np.cumsum(deltas[:, 2])]
        way = turned * (theta[:-1] + at * deltas[:, 2])
        with np.errstate(all="ignore"):
            forward, left = (deltas[:, :2] * chord(deltas[:, 2] / 2)[:, None]).T
        x = begin[0] + np.r_[0.0, np.cumsum(np.cos(way) * forward - np.sin(way) * left)]
        y = begin[1] + np.r_[0.0, np.cumsum(np.sin(way) * forward + np.cos(way) * left)]
        return last(np.column_stack([x, y, theta]), np.asarray(start, float))

    return function


def _chord(half: np.ndarray) -> np.ndarray:
    return np.sinc(half / np.pi)


INTEGRATE = Exercise(
    id="odometry.integrate",
    title="Poses along exact arcs",
    points=3,
    reference=odometry.integrate,
    shortcuts=(
        "robocon_course.odometry.motion.integrate_arcs",
        "robocon_course.geometry.poses.se2_exp",
    ),
    cases=_integrate_cases,
    hints=(
        "Keep x, y, θ in a loop, and append a pose after each step; the first pose is the start.",
        "The chord points along θ + turn/2 and is shorter than the arc by sin(h)/h with "
        "h = turn/2. np.sinc(h / np.pi) is sin(h)/h, and 1 at h = 0.",
        "k = np.sinc(turn / 2 / np.pi); c, s = k cos(θ + turn/2), k sin(θ + turn/2); "
        "x += c · forward − s · left; y += s · forward + c · left; θ += turn.",
    ),
    mistakes=(
        Mistake(
            "Euler",
            "Each step goes along the heading at its beginning. In a left turn the path is then "
            "too far to the right. The chord of an arc points along the heading halfway.",
            _integrated(0.0),
        ),
        Mistake(
            "end heading",
            "Each step goes along the heading at its end. The chord of an arc points along the "
            "heading halfway, θ + turn/2.",
            _integrated(1.0),
        ),
        Mistake(
            "midpoint without chord",
            "The direction is right, the length is not: the chord is shorter than the arc, by "
            "sin(h)/h with h = turn/2. A quarter circle is 11 % too long without it.",
            _integrated(0.5),
        ),
        Mistake(
            "chord of the whole turn",
            "The chord is shortened by sin(turn)/turn. It is half the turn: sin(h)/h, h = turn/2.",
            _integrated(0.5, lambda half: np.sinc(2 * half / np.pi)),
        ),
        Mistake(
            "start heading, right chord",
            "The chord has the right length but starts along the heading at the beginning of the "
            "step. It points along the heading halfway, θ + turn/2.",
            _integrated(0.0, _chord),
        ),
        Mistake(
            "division by zero",
            "A step without a turn divides 0 by 0, and every pose after it is NaN. np.sinc knows "
            "the limit, or treat small turns apart.",
            _integrated(0.5, lambda half: np.sin(half) / half),
        ),
        Mistake(
            "not turned into the map",
            "Forward and left are added as if the robot always looked along x. Turn each step by "
            "the heading.",
            _integrated(0.5, _chord, turned=0.0),
        ),
        Mistake(
            "sign of the rotation",
            "The steps are turned the wrong way. Counter-clockwise is positive: "
            "x += cos · forward − sin · left, y += sin · forward + cos · left.",
            _integrated(0.5, _chord, turned=-1.0),
        ),
        Mistake(
            "degrees",
            "The angles are converted to radians once more. They are in radians already.",
            _integrated(0.5, _chord, turned=np.pi / 180),
        ),
        Mistake(
            "start ignored",
            "The start is not used: the path begins at (0, 0, 0).",
            _integrated(0.5, _chord, first=np.zeros_like),
        ),
        Mistake(
            "start added at the end",
            "The start is added to the poses at the end. Its heading turns the whole path; begin "
            "from it.",
            _integrated(0.5, _chord, first=np.zeros_like, last=lambda poses, start: poses + start),
        ),
        Mistake(
            "wrapped heading",
            "The heading is wrapped. Here it must not be: a robot that turned twice has turned "
            "by 4 π, and the next function needs to know.",
            _integrated(
                0.5,
                _chord,
                last=lambda poses, start: np.column_stack(
                    [poses[:, :2], geometry.wrap_angle(poses[:, 2])]
                ),
            ),
        ),
        Mistake(
            "start left out",
            "The first row is missing: the result begins with the start and is one row longer "
            "than the steps.",
            _integrated(0.5, _chord, last=lambda poses, start: poses[1:]),
        ),
    ),
)


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
        ("the heading passes ±180°", passing, 0.05),
        ("a tight curve, seldom sampled", drive([[1.0, 0.2, 3.0]] * 4, 0.5), 0.5),
        ("a wild drive", drive(wild, 0.1, (0.5, -1.0, 2.0)), 0.1),
    ]
    return [Case(what, (poses, dt), "m/s, m/s, rad/s", MICROMETRE) for what, poses, dt in named]


def _turns(yaw: np.ndarray) -> np.ndarray:
    return geometry.wrap_angle(np.diff(yaw))


def _velocity(
    at: float,
    *,
    arc: bool = True,
    turn: Callable[[np.ndarray], np.ndarray] = _turns,
    change: Callable[[np.ndarray, float], np.ndarray] = lambda steps, dt: steps / dt,
) -> Answer:
    """Velocity seen from the heading ``at`` a share of the turn, along the arc or its chord."""

    def function(poses: np.ndarray, dt: float) -> np.ndarray:
        step, turned = np.diff(poses[:, :2], axis=0), turn(poses[:, 2])
        look = poses[:-1, 2] + at * turned if np.isfinite(at) else 0.0 * turned
        c, s = np.cos(look), np.sin(look)
        longer = 1.0 / _chord(turned / 2) if arc else 1.0
        forward = longer * (c * step[:, 0] + s * step[:, 1])
        left = longer * (c * step[:, 1] - s * step[:, 0])
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
            _velocity(np.nan, arc=False),
        ),
        Mistake(
            "start heading",
            "The step is seen from the heading at its beginning. Its chord points along the "
            "heading halfway.",
            _velocity(0.0, arc=False),
        ),
        Mistake(
            "end heading",
            "The step is seen from the heading at its end. Its chord points along the heading "
            "halfway.",
            _velocity(1.0, arc=False),
        ),
        Mistake(
            "chord for arc",
            "This is the length of the chord. The robot drove the arc: divide by sin(h)/h with "
            "h = turn/2.",
            _velocity(0.5, arc=False),
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
    ),
)
