"""Sizes from a run and a spin, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import odometry, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.exercises.odometry.wheels import some_wheels
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS
from robocon_course.worlds import Student

Drive = tuple[TrackingWheels, np.ndarray, np.ndarray, np.ndarray, float]


def _drives(
    wheels: TrackingWheels,
    drawn: TrackingWheels,
    run: tuple[float, float],
    angle: float,
    *,
    whole: bool = True,
) -> Drive:
    """The arguments of a calibration: what true wheels count on a run and a spin."""
    rolled = wheels.matrix @ np.array([(*run, 0.0), (0.0, 0.0, angle)]).T
    counts = rolled.T / wheels.metres_per_tick
    if whole:
        counts = np.round(counts).astype(np.int64)
    return drawn, counts[0], np.array(run), counts[1], angle


def _calibrate_wheels_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    own, other = worlds.own_wheels(student), some_wheels(rng)
    around = np.radians([60.0, 180.0, 300.0]) + rng.uniform(-0.2, 0.2)
    circle = np.column_stack([np.cos(around), np.sin(around)])
    # Not quite tangential, so that a place has a part along the wheel's direction, too.
    ways = around + np.pi / 2 + 0.15
    omni = TrackingWheels(0.2 * circle, ways, 0.05, 2048)
    radius = 0.05 * (1 + rng.uniform(-0.01, 0.01, 3))
    built = TrackingWheels(rng.uniform(0.196, 0.204) * circle, ways, radius, 2048)
    # So that every wheel rolls: none of the three stands square to the run.
    slanting = 3.0 * np.array([np.cos(around[0] - 0.25), np.sin(around[0] - 0.25)])
    # Whole counts would move every size by micrometres; this robot is as drawn to the last digit.
    exact = _drives(DEAD_WHEELS, DEAD_WHEELS, (2.0, 2.0), 12.0, whole=False)
    named = [
        ("a robot that is exactly as drawn", exact),
        ("your own robot", _drives(own, DEAD_WHEELS, worlds.RUN, worlds.SPIN)),
        ("another robot, spun to the right", _drives(other, DEAD_WHEELS, (3.0, -1.5), -40.0)),
        ("a run backwards", _drives(some_wheels(rng), DEAD_WHEELS, (-2.0, 1.5), worlds.SPIN)),
        ("three omni wheels on a circle", _drives(built, omni, tuple(slanting), 25.0)),
    ]
    close = {"positions": 1e-6, "directions": 1e-9, "radius": 1e-8, "ticks_per_turn": 1e-6}
    return [Case(what, args, "m", close) for what, args in named]


def _calibration(
    *,
    radius: Callable[..., np.ndarray] = lambda found, drawn, run: found,
    angle: Callable[[float], float] = lambda angle: angle,
    lever: Callable[[np.ndarray, np.ndarray], np.ndarray] = lambda found, drawn: found,
    spin_radius: Callable[..., np.ndarray] = lambda found, drawn: found,
    place: Callable[..., np.ndarray] = lambda drawn, steps, across: (
        drawn.positions + steps[:, None] * across
    ),
) -> Callable[..., TrackingWheels]:
    """Run and spin with one of the steps done wrongly."""

    def function(
        wheels: TrackingWheels,
        run_ticks: np.ndarray,
        run: np.ndarray,
        spin_ticks: np.ndarray,
        spun: float,
    ) -> TrackingWheels:
        per_turn = wheels.ticks_per_turn / (2 * np.pi)
        good = wheels.matrix[:, :2] @ run * per_turn / run_ticks
        found = radius(good, wheels, (run_ticks, run))
        travel = spin_radius(found, wheels) * spin_ticks / per_turn
        arms = lever(travel / angle(spun), wheels.matrix[:, 2])
        across = np.column_stack([np.sin(wheels.directions), -np.cos(wheels.directions)])
        moved = place(wheels, arms - wheels.matrix[:, 2], across)
        return TrackingWheels(moved, wheels.directions, np.abs(found), wheels.ticks_per_turn)

    return function


def _by_length(found: np.ndarray, drawn: TrackingWheels, drive: tuple) -> np.ndarray:
    ticks, run = drive
    return np.hypot(*run) * drawn.ticks_per_turn / (2 * np.pi * np.abs(ticks))


CALIBRATE_WHEELS = Exercise(
    id="odometry.calibrate_wheels",
    title="Sizes from a run and a spin",
    points=3,
    reference=odometry.calibrate_wheels,
    shortcuts=("robocon_course.odometry.calibration.self_calibrate",),
    cases=_calibrate_wheels_cases,
    hints=(
        "The run first. Wheel i rolls the part of the run along its direction, "
        "cos a · dx + sin a · dy. That is 2 π r times its turns: solve for r.",
        "Then the spin: with the new radii, travel = lever arm · angle.",
        "The lever arm is x sin a − y cos a, so moving a wheel by (sin a, −cos a) · step changes "
        "it by step. step = new lever arm − old one, the third column of wheel_matrix.",
    ),
    mistakes=(
        Mistake(
            "radius for diameter",
            "The radii are twice too large: these are diameters. The circumference is 2 π r.",
            _calibration(
                radius=lambda found, drawn, run: 2 * found,
                spin_radius=lambda found, drawn: found / 2,
            ),
        ),
        Mistake(
            "length of the run",
            "Every wheel is taken to roll the whole length of the run. A wheel only rolls the part "
            "along its own direction: cos a · dx + sin a · dy.",
            _calibration(radius=_by_length),
        ),
        Mistake(
            "drawn radius in the spin",
            "The lever arms come from the radii of the drawing. Use the radii that the run has "
            "just found.",
            _calibration(spin_radius=lambda found, drawn: drawn.radius),
        ),
        Mistake(
            "radii left as drawn",
            "The radii are still those of the drawing. The run says how large each wheel is.",
            _calibration(radius=lambda found, drawn, run: drawn.radius),
        ),
        Mistake(
            "one radius for all",
            "All wheels get the mean radius. Each has its own, and a difference between left and "
            "right bends every straight line.",
            _calibration(radius=lambda found, drawn, run: np.full_like(found, found.mean())),
        ),
        Mistake(
            "radius upside down",
            "The correction is upside down: a wheel that counts more than it should is smaller "
            "than drawn.",
            _calibration(radius=lambda found, drawn, run: drawn.radius**2 / found),
        ),
        Mistake(
            "degrees",
            "The angle of the spin is taken for degrees. It is in radians.",
            _calibration(angle=np.radians),
        ),
        Mistake(
            "sign of the spin",
            "The sign of the angle is lost: in a spin to the right every wheel seems to stand on "
            "the other side.",
            _calibration(angle=abs),
        ),
        Mistake(
            "lever arm moved the wrong way",
            "The wheels are moved the wrong way: away from their measured lever arm.",
            _calibration(lever=lambda found, drawn: 2 * drawn - found),
        ),
        Mistake(
            "moved along its direction",
            "The wheels are moved along the way they roll. That does not change a lever arm; move "
            "them square to it, by (sin a, −cos a).",
            _calibration(
                place=lambda drawn, steps, across: (
                    drawn.positions + steps[:, None] * drawn.matrix[:, :2]
                )
            ),
        ),
        Mistake(
            "only the lever arm kept",
            "The wheels stand at lever arm · (sin a, −cos a), so their place along their own "
            "direction is lost. Keep the drawn place and add only what its lever arm lacks.",
            _calibration(
                place=lambda drawn, steps, across: (steps + drawn.matrix[:, 2])[:, None] * across
            ),
        ),
        Mistake(
            "lever arm added",
            "The whole new lever arm is added to the place. Move the wheel by the difference: new "
            "lever arm minus old.",
            _calibration(lever=lambda found, drawn: found + drawn),
        ),
        Mistake(
            "unchanged",
            "These are the sizes of the drawing. Run and spin say what they are really.",
            lambda wheels, run_ticks, run, spin_ticks, angle: wheels,
        ),
        Mistake(
            "positions left as drawn",
            "The wheels stand where the drawing has them. The spin says how far out they are.",
            _calibration(lever=lambda found, drawn: drawn),
        ),
        Mistake(
            "track and offset halved",
            "The lever arms are half of what they should be. A wheel's lever arm is its distance "
            "from the centre: half the track, but the whole rear offset.",
            _calibration(lever=lambda found, drawn: found / 2),
        ),
        Mistake(
            "first radius for all",
            "All wheels get the first one's radius. Each has its own.",
            _calibration(radius=lambda found, drawn, run: np.full_like(found, found[0])),
        ),
        Mistake(
            "places scaled",
            "The whole place is scaled by new lever arm over old. Nothing is known of a wheel's "
            "place along its own direction: move it square to that only.",
            _calibration(
                place=lambda drawn, steps, across: (
                    drawn.positions * (1.0 + steps / drawn.matrix[:, 2])[:, None]
                )
            ),
        ),
    ),
)
