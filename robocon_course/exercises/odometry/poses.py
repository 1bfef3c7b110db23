"""From motion to poses, and how people get them wrong."""

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
    aside: float = -1.0,
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
        x = begin[0] + np.r_[0.0, np.cumsum(np.cos(way) * forward + aside * np.sin(way) * left)]
        y = begin[1] + np.r_[0.0, np.cumsum(np.sin(way) * forward + np.cos(way) * left)]
        return last(np.column_stack([x, y, theta]), np.asarray(start, float))

    return function


def chord_share(half: np.ndarray) -> np.ndarray:
    """How long a chord is, in lengths of its arc, by half the turn."""
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
            _integrated(0.0, chord_share),
        ),
        Mistake(
            "end heading, right chord",
            "The chord has the right length but points along the heading after the step. It points "
            "along the heading halfway, θ + turn/2.",
            _integrated(1.0, chord_share),
        ),
        Mistake(
            "half a turn too far",
            "θ is moved on before the step is made, so θ + turn/2 lies beyond its end. Move θ "
            "last.",
            _integrated(1.5, chord_share),
        ),
        Mistake(
            "sinc without π",
            "np.sinc(h) is sin(π h) / (π h): it brings a π of its own. sin(h)/h is "
            "np.sinc(h / np.pi).",
            _integrated(0.5, np.sinc),
        ),
        Mistake(
            "chord longer",
            "The factor is upside down: the chord is shorter than its arc, by sin(h)/h.",
            _integrated(0.5, lambda half: 1.0 / chord_share(half)),
        ),
        Mistake(
            "shortened twice",
            "The chord is shortened twice: sin(h)/h belongs to the step once.",
            _integrated(0.5, lambda half: chord_share(half) ** 2),
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
            _integrated(0.5, chord_share, turned=0.0),
        ),
        Mistake(
            "sign of the rotation",
            "The steps are turned the wrong way. Counter-clockwise is positive: "
            "x += cos · forward − sin · left, y += sin · forward + cos · left.",
            _integrated(0.5, chord_share, turned=-1.0),
        ),
        Mistake(
            "minus forgotten",
            "A minus is missing, so this is no rotation: x += cos · forward − sin · left.",
            _integrated(0.5, chord_share, aside=1.0),
        ),
        Mistake(
            "degrees",
            "The angles are converted to radians once more. They are in radians already.",
            _integrated(0.5, chord_share, turned=np.pi / 180),
        ),
        Mistake(
            "start ignored",
            "The start is not used: the path begins at (0, 0, 0).",
            _integrated(0.5, chord_share, first=np.zeros_like),
        ),
        Mistake(
            "start's heading ignored",
            "The start's place is used, its heading is not: a robot that looks elsewhere drives "
            "elsewhere. Begin with all three.",
            _integrated(0.5, chord_share, first=lambda start: start * [1.0, 1.0, 0.0]),
        ),
        Mistake(
            "start added at the end",
            "The start is added to the poses at the end. Its heading turns the whole path; begin "
            "from it.",
            _integrated(
                0.5, chord_share, first=np.zeros_like, last=lambda poses, start: poses + start
            ),
        ),
        Mistake(
            "wrapped heading",
            "The heading is wrapped. Here it must not be: a robot that turned twice has turned "
            "by 4 π, and the next function needs to know.",
            _integrated(
                0.5,
                chord_share,
                last=lambda poses, start: np.column_stack(
                    [poses[:, :2], geometry.wrap_angle(poses[:, 2])]
                ),
            ),
        ),
        Mistake(
            "start left out",
            "The first row is missing: the result begins with the start and is one row longer "
            "than the steps.",
            _integrated(0.5, chord_share, last=lambda poses, start: poses[1:]),
        ),
    ),
)
