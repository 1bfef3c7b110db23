"""How fast, where; and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.tracking.places import some_path
from robocon_course.worlds import Student, finely, winding_path

Path = np.ndarray


def _speed_profile_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    straight = np.column_stack([np.linspace(0.0, 2.0, 21), np.zeros(21)])
    turn = np.linspace(0.0, 3.0, 61)
    left = 0.5 * np.column_stack([np.sin(turn), 1.0 - np.cos(turn)])
    corner = finely([[0.0, 0.0], [1.0, 0.0], [1.0, 1.5]], 0.05)
    uneven = np.array([[0.0, 0.0], [0.02, 0.0], [0.5, 0.0], [0.52, 0.0], [1.4, 0.0], [1.5, 0.0]])
    rows = [
        ("a straight way, long enough for full speed", straight, 1.0, 1.0, 1.0),
        ("a straight way, too short for full speed", straight, 3.0, 1.0, 1.0),
        ("a left bend of 0.5 m radius", left, 2.0, 1.5, 0.5),
        ("a right bend of 0.5 m radius", left * [1.0, -1.0], 2.0, 1.5, 0.5),
        ("a corner", corner, 1.0, 0.8, 0.6),
        ("points at uneven distances", uneven, 1.0, 0.7, 1.0),
        ("a corner drawn twice", np.insert(corner, 20, corner[20], axis=0), 1.0, 0.8, 0.6),
    ]
    for _ in range(2):
        limits = [round(float(value), 2) for value in rng.uniform(0.4, 2.0, 3)]
        rows.append(("any path", some_path(rng), *limits))
        limits = [round(float(value), 2) for value in rng.uniform(0.4, 2.0, 3)]
        rows.append(("bends and corners", winding_path(rng, 3.0), *limits))
    return [Case(what, tuple(args), "m/s", 1e-6) for what, *args in rows]


def _profile(
    *,
    cap: Callable[[Path, float], Path] = lambda bend, lateral: np.sqrt(
        lateral / np.maximum(np.abs(bend), 1e-12)
    ),
    top: bool = True,
    ends: float | None = 0.0,
    forwards: bool = True,
    backwards: bool = True,
    gain: Callable[..., float] = lambda v, a, ds: np.sqrt(v**2 + 2.0 * a * ds),
    steps: Callable[[Path], Path] = lambda path: np.hypot(*np.diff(path, axis=0).T),
) -> Callable[..., Path]:
    """Both passes, with one part wrong."""

    def function(path: Path, max_speed: float, max_accel: float, max_lateral_accel: float) -> Path:
        with np.errstate(invalid="ignore", divide="ignore"):
            v = cap(tracking.path_curvature(path), max_lateral_accel)
        v = np.minimum(v, max_speed) if top else np.minimum(v, 1e3)
        if ends is not None:
            v[0], v[-1] = ends, ends
        ds = steps(path)
        for k in range(1, len(v)) if forwards else ():
            v[k] = min(v[k], gain(v[k - 1], max_accel, ds[k - 1]))
        for k in range(len(v) - 2, -1, -1) if backwards else ():
            v[k] = min(v[k], gain(v[k + 1], max_accel, ds[k]))
        return v

    return function


def _loose_end(path: Path, max_speed: float, max_accel: float, max_lateral_accel: float) -> Path:
    return tracking.speed_profile(
        path, max_speed, max_accel, max_lateral_accel, end_speed=float("inf")
    )


SPEED_PROFILE = Exercise(
    id="tracking.speed_profile",
    title="As fast as bends and brakes allow",
    points=3,
    reference=tracking.speed_profile,
    cases=_speed_profile_cases,
    hints=(
        "First the bends: v = √(max_lateral_accel / |κ|) with κ from tracking.path_curvature, and "
        "never more than max_speed. Where κ is 0 there is no limit but that: divide by "
        "np.maximum(np.abs(κ), 1e-9).",
        "Then the ends: speed 0 at the first and the last point.",
        "Forwards: v[k] is at most √(v[k − 1]² + 2 a Δs). Backwards from the end the same, so that "
        "the robot brakes in time.",
    ),
    mistakes=(
        Mistake(
            "no backward pass",
            "Nothing makes the robot brake before a bend or the end: pass over the points a second "
            "time, from the end.",
            _profile(backwards=False),
        ),
        Mistake(
            "no forward pass",
            "The robot would jump to full speed at the start and behind each bend: pass over the "
            "points from the start as well.",
            _profile(forwards=False),
        ),
        Mistake(
            "no passes at all",
            "These are the limits of the bends alone. A robot needs way to become faster and to "
            "brake.",
            _profile(forwards=False, backwards=False),
        ),
        Mistake(
            "starts and ends at speed",
            "The robot starts from rest and has to come to rest: speed 0 at both ends.",
            _profile(ends=None),
        ),
        Mistake(
            "ends at speed",
            "The last speed is not 0: the robot runs past its goal.",
            _loose_end,
        ),
        Mistake(
            "root forgotten in the bends",
            "In a bend v² |κ| = a: the speed is the root of a / |κ|.",
            _profile(cap=lambda bend, a: a / np.maximum(np.abs(bend), 1e-12)),
        ),
        Mistake(
            "radius for curvature",
            "κ is the curvature, not the radius: the tighter the bend the slower. v = √(a / |κ|).",
            _profile(cap=lambda bend, a: np.sqrt(a * np.abs(bend)) + 1e9 * (bend == 0.0)),
        ),
        Mistake(
            "right bends ignored",
            "In right bends the curvature is negative, and they are not limited: take its "
            "absolute value.",
            _profile(cap=lambda bend, a: np.where(bend > 0.0, np.sqrt(a / np.abs(bend)), 1e9)),
        ),
        Mistake(
            "nan in right bends",
            "The root of a negative curvature is nan. Take the absolute value.",
            lambda path, *limits: np.where(
                tracking.path_curvature(path) < 0.0, np.nan, tracking.speed_profile(path, *limits)
            ),
        ),
        Mistake(
            "bends ignored",
            "max_lateral_accel is not used: the robot leaves the path in its first bend.",
            _profile(cap=lambda bend, a: np.full(bend.shape, 1e9)),
        ),
        Mistake(
            "max_speed ignored",
            "On a straight way the robot becomes faster than max_speed.",
            _profile(top=False),
        ),
        Mistake(
            "factor 2 forgotten",
            "v² grows by 2 a Δs; the 2 is missing.",
            _profile(gain=lambda v, a, ds: np.sqrt(v**2 + a * ds)),
        ),
        Mistake(
            "a Δs added to the speed",
            "It is v² that grows with the way, by 2 a Δs. The speed itself grows with time.",
            _profile(gain=lambda v, a, ds: v + a * ds),
        ),
        Mistake(
            "way from point to point ignored",
            "Points are not always as far apart: use the length of each segment for Δs.",
            _profile(
                steps=lambda path: np.full(len(path) - 1, np.hypot(*np.diff(path, axis=0).T).mean())
            ),
        ),
    ),
)
