"""How large are the wheels really, and where do they stand?

A drawing is good to a per cent, and odometry multiplies that per cent by the way. Two short drives
find it. A straight run of known displacement (dx, dy) tells how far each wheel rolled, so how far
one count is; a spin on the spot by a known angle tells at which lever arm the wheel goes round:

    radius_i = (cos a_i dx + sin a_i dy) counts_per_turn / (2 π counts_i)
    lever_i  = travel_i / angle                 third column of the wheel matrix

Only the lever arm shows, not where along its own direction a wheel stands; odometry needs no more.

Where the true poses of a whole drive are known, least squares finds the sizes that follow them
best. Sizes that a drive hardly shows then run away to fit slip and noise, and other drives pay. So
the drawing stays in as a weak prior: every size is held near its nominal value as loosely as
workshops work.

    minimise  Σ (e_position / σ_p)² + (e_heading / σ_h)²  averaged over the poses
              + Σ (log(radius_i / nominal) / σ_r)² + ((lever_i - nominal) / (σ_l largest lever))²

Source: J. Borenstein, L. Feng, Measurement and correction of systematic odometry errors in mobile
robots, IEEE Transactions on Robotics and Automation 12(6), 1996 (drives that show the sizes);
A. Björck, Numerical Methods for Least Squares Problems, SIAM 1996, section 9.2 (Gauss-Newton).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import radians
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import wrap_angle
from robocon_course.odometry.motion import body_deltas, integrate
from robocon_course.odometry.wheels import TrackingWheels, wheel_travel

LEAST_ROLL = 0.1
"""A wheel must roll this share of the run: one that rolls less turns a slip into a wrong radius."""
LEAST_ANGLE = 1.0
"""Smallest spin [rad]; a few full turns are better."""
PLAUSIBLE = 0.2
"""Radii and lever arms farther than this from nominal come of swapped wheels or units."""
STEPS = 20
SMALL_STEP = 1e-9  # of the prior's tolerance: far below what a count can show


class SizePrior(NamedTuple):
    """How far from the drawing sizes may be, and how well they can explain a drive.

    Attributes
    ----------
    radius : float
        Standard deviation of a wheel's radius, as a share of it. A 60 mm wheel turned to 0.3 mm,
        worn and pressed flat by as much, is good to 1 %.
    lever : float
        Standard deviation of a lever arm, as a share of the largest one: 2 %, or 5 mm of 250 mm.
        A wheel touches the floor somewhere on its width.
    position : float  [m]
        How far a robot of known sizes would end up all the same, from slip and uneven floor: half
        a per cent to one of the way, or 5 cm after 7 m. All poses of a drive share most of it, so
        together they count as one.
    heading : float  [rad]
        The same for its heading: 1 degree.
    """

    radius: float = 0.01
    lever: float = 0.02
    position: float = 0.05
    heading: float = radians(1.0)


def calibrate_wheels(
    wheels: TrackingWheels,
    run_ticks: ArrayLike,
    run: ArrayLike,
    spin_ticks: ArrayLike,
    angle: float,
) -> TrackingWheels:
    """Radii and lever arms from one straight run and one spin on the spot.

    Parameters
    ----------
    wheels : TrackingWheels
        n wheels of nominal size; their directions are kept.
    run_ticks : array_like, shape (n,)
        Counts from the start to the end of the run.
    run : array_like, shape (2,)  [m, base]
        How far the base went, forward and left, without turning. Diagonal, so that every wheel
        rolls.
    spin_ticks : array_like, shape (n,)
        Counts from the start to the end of the spin.
    angle : float  [rad]
        How far the base turned on the spot, full turns included; counter-clockwise is positive.

    Returns
    -------
    TrackingWheels
        Each wheel with its own radius, and moved square to its direction to its lever arm.

    Raises
    ------
    ValueError
        Wrong shapes, an entry that is not finite, a wheel that hardly rolls in the run, too small
        an angle, or a size more than 20 % off.

    Examples
    --------
    Two wheels drawn 0.5 m apart. They count 1 % more than they should in a run of one metre: they
    are smaller. And in a spin as many as wheels of that size 0.52 m apart.

    >>> wheels = TrackingWheels([[0, 0.25], [0, -0.25]], [0, 0], 0.03, 3200)
    >>> counts = 3200 / (2 * np.pi * 0.0297)
    >>> found = calibrate_wheels(
    ...     wheels, [counts, counts], [1, 0], [-2.6 * counts, 2.6 * counts], 10.0
    ... )
    >>> found.radius.round(4).tolist(), found.positions.round(3).tolist()
    ([0.0297, 0.0297], [[0.0, 0.26], [0.0, -0.26]])
    """
    n = len(wheels.radius)
    counted = as_floats(run_ticks, "run_ticks", n)
    run = as_floats(run, "run", 2)
    known = wheels.matrix[:, :2] @ run
    if not (np.abs(known) >= LEAST_ROLL * np.hypot(*run)).all() or not run.any():
        raise ValueError(
            f"run: in a run of {run.tolist()} m the wheels roll {known.round(3).tolist()} m, one "
            "of them too little to tell its size; drive diagonally"
        )
    factors = known / np.where(counted, counted * wheels.metres_per_tick, np.inf)
    _plausible("run_ticks", "radii, in nominal ones,", factors, 1.0, PLAUSIBLE)
    if not LEAST_ANGLE <= abs(angle) < np.inf:
        raise ValueError(f"angle: a spin of {angle} rad says little; make some full turns, in rad")
    sized = replace(wheels, radius=wheels.radius * factors)
    levers = wheel_travel(sized, as_floats(spin_ticks, "spin_ticks", n)) / angle
    nominal = wheels.matrix[:, 2]
    reach = PLAUSIBLE * np.abs(nominal).max()
    _plausible("spin_ticks", "lever arms, in m,", levers, nominal, reach)
    return _with_levers(sized, levers)


def self_calibrate(
    wheels: TrackingWheels,
    ticks: ArrayLike,
    truth: ArrayLike,
    *,
    prior: SizePrior = SizePrior(),  # noqa: B008 - a NamedTuple cannot change
) -> TrackingWheels:
    """The radii and lever arms near the nominal ones that follow a known drive best.

    Parameters
    ----------
    wheels : TrackingWheels
        n wheels of nominal size; their directions are kept.
    ticks : array_like, shape (k, n)
        Counts of each sample of the drive.
    truth : array_like, shape (k + 1, 3)  [m, m, rad; map]
        True poses, before the first sample and after each. A row with NaN is not known; only the
        first must be. Headings may be wrapped.
    prior : SizePrior
        Much wider tolerances make it plain least squares.

    Returns
    -------
    TrackingWheels

    Raises
    ------
    ValueError
        Wrong shapes, ticks or a first pose that are not finite, no other pose known, or a
        tolerance that is not positive.

    Notes
    -----
    Gauss-Newton from the nominal sizes, Jacobian from central differences.
    """
    n = len(wheels.radius)
    ticks = as_floats(ticks, "ticks", None, n)
    truth = as_floats(truth, "truth", len(ticks) + 1, 3, finite=False)
    known = np.flatnonzero(np.isfinite(truth).all(axis=1))
    if len(known) < 2 or known[0] != 0:
        raise ValueError("truth: the first pose and one more must be known, the rest may be NaN")
    if not all(0.0 < tolerance < np.inf for tolerance in prior):
        raise ValueError(f"prior: expected tolerances above 0, got {prior}")
    shares = np.sqrt(len(known)) * np.array([prior.position, prior.position, prior.heading])

    def residuals(z: FloatArray) -> FloatArray:
        poses = integrate(body_deltas(sized(z), wheel_travel(sized(z), ticks)), truth[0])
        error = (poses - truth)[known]
        error[:, 2] = wrap_angle(error[:, 2])
        return np.concatenate([(error / shares).ravel(), z])

    def sized(z: FloatArray) -> TrackingWheels:
        return _resized(wheels, prior.radius * z[:n], prior.lever * z[n:])

    return sized(_least_squares(residuals, np.zeros(2 * n)))


def _least_squares(residuals: Callable[[FloatArray], FloatArray], z: FloatArray) -> FloatArray:
    """The z that makes the squares of its residuals least, Gauss-Newton."""
    for _ in range(STEPS):
        nudges = 1e-4 * np.eye(len(z))
        slopes = [(residuals(z + nudge) - residuals(z - nudge)) / 2e-4 for nudge in nudges]
        step = np.linalg.lstsq(np.transpose(slopes), -residuals(z), rcond=None)[0]
        z = z + step
        if np.abs(step).max() < SMALL_STEP:
            break
    return z


def _resized(wheels: TrackingWheels, growth: FloatArray, shifts: FloatArray) -> TrackingWheels:
    """Radii grown by exp(growth), lever arms by shares of the largest."""
    levers = wheels.matrix[:, 2]
    sized = replace(wheels, radius=wheels.radius * np.exp(growth))
    return _with_levers(sized, levers + np.abs(levers).max() * shifts)


def _with_levers(wheels: TrackingWheels, levers: FloatArray) -> TrackingWheels:
    """The wheels moved square to their directions until they have these lever arms."""
    # lever = (x, y) · (sin a, -cos a): a step along that unit vector changes it by its own length
    across = np.column_stack([np.sin(wheels.directions), -np.cos(wheels.directions)])
    steps = (levers - wheels.matrix[:, 2])[:, None] * across
    return replace(wheels, positions=wheels.positions + steps)


def _plausible(
    name: str, sizes: str, found: FloatArray, nominal: FloatArray | float, reach: float
) -> None:
    if (np.abs(found - nominal) > reach).any():
        raise ValueError(
            f"{name}: they make the {sizes} {found.round(4).tolist()}, more than "
            f"{100 * PLAUSIBLE:g} % off; look for swapped wheels, a counter that runs backwards, "
            "and units (m, rad)"
        )
