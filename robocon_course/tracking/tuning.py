"""Which gains? Raise one until the loop oscillates, and read the others off the oscillation.

With a P controller alone the gain is raised until the oscillation neither dies nor grows. That gain
k_cr and the period p_cr give the gains (second method of Ziegler and Nichols):

    P    0.5 k_cr
    PI   0.45 k_cr    T_i = p_cr / 1.2
    PID  0.6 k_cr     T_i = p_cr / 2      T_d = p_cr / 8        k_i = k_p / T_i,  k_d = k_p T_d

They are a place to start from: the answer to a step overshoots, often by a quarter or more.

Source: J. G. Ziegler, N. B. Nichols, Optimum settings for automatic controllers, Transactions of
the ASME 64, 1942; the table as in K. Ogata, Modern Control Engineering, section "Tuning rules for
PID controllers".
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import CourseError, as_floats
from robocon_course.tracking.pid import PidGains

# Share of k_cr, p_cr / T_i, T_d / p_cr.
_RULES = {"P": (0.5, 0.0, 0.0), "PI": (0.45, 1.2, 0.0), "PID": (0.6, 2.0, 0.125)}


class Oscillation(NamedTuple):
    """How a signal swings about zero.

    Attributes
    ----------
    period : float  [s]
        NaN where it does not swing.
    growth : float
        By what the amplitude changes in a period: below 1 it dies out, above 1 it grows.
    """

    period: float
    growth: float


class Critical(NamedTuple):
    """The gain at which a P controller oscillates without end.

    Attributes
    ----------
    gain : float
    period : float  [s]
    """

    gain: float
    period: float


class NoOscillationError(CourseError, ValueError):
    """A loop that does not begin to oscillate, or never stops to."""


def ziegler_nichols(k_cr: float, p_cr: float, kind: str = "PID") -> PidGains:
    """Gains from the critical gain and period.

    Parameters
    ----------
    k_cr : float  [output / error]
        Gain of the P controller that oscillates without end.
    p_cr : float  [s]
        Period of that oscillation. In another unit of time the gains come out in that unit.
    kind : {"P", "PI", "PID"}

    Returns
    -------
    PidGains

    Raises
    ------
    ValueError
        A gain or period that is not positive, or another kind.

    Examples
    --------
    >>> ziegler_nichols(1.0, 2.0)
    PidGains(k_p=0.6, k_i=0.6, k_d=0.15, smoothing=0.0)
    """
    if kind not in _RULES:
        raise ValueError(f"kind: expected one of {', '.join(_RULES)}, got {kind!r}")
    if not (0.0 < k_cr < inf and 0.0 < p_cr < inf):
        raise ValueError(f"k_cr, p_cr: expected numbers above 0, got {k_cr} and {p_cr}")
    share, resets, rate = _RULES[kind]
    k_p = share * k_cr
    return PidGains(k_p, k_p * resets / p_cr, k_p * rate * p_cr)


def find_oscillation(error: ArrayLike, dt: float) -> Oscillation:
    """Period and growth of a signal that swings about zero.

    Parameters
    ----------
    error : array_like, shape (n,)
        Control error after a disturbance.
    dt : float  [s]

    Returns
    -------
    Oscillation
        Growth 0 where it crosses zero less than four times before it has shrunk to a fiftieth.

    Raises
    ------
    ValueError
        Not a row of finite numbers, or dt not positive.

    Examples
    --------
    >>> t = 0.01 * np.arange(300)
    >>> swing = find_oscillation(0.5**t * np.cos(2 * np.pi * t / 0.5), 0.01)
    >>> round(swing.period, 3), round(swing.growth, 2)
    (0.5, 0.71)
    """
    error = as_floats(error, "error", None)
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    places, below = np.flatnonzero(error), error < 0.0
    turns = np.flatnonzero(np.diff(below[places]))
    before, after = places[turns], places[turns + 1]
    # Zeros by straight lines between the samples on both sides.
    share = np.abs(error[before]) / (np.abs(error[before]) + np.abs(error[after]))
    zeros = before + share * (after - before)
    swings = [np.abs(part).max() for part in np.split(error, after)[1:-1]]  # whole ones only
    small = np.flatnonzero(np.array(swings) < 0.02 * np.abs(error).max(initial=0.0))
    swings = swings[: small[0]] if len(small) else swings
    if len(swings) < 3:
        return Oscillation(np.nan, 0.0)
    half_periods = np.arange(len(swings))
    slope = np.polyfit(half_periods, np.log(swings), 1)[0]
    period = 2.0 * dt * (zeros[len(swings)] - zeros[0]) / len(swings)
    return Oscillation(float(period), float(np.exp(2.0 * slope)))


def critical_gain(
    respond: Callable[[float], ArrayLike],
    start: float,
    dt: float,
    *,
    factor: float = 1.2,
    tolerance: float = 0.005,
    limit: float = 1e6,
) -> Critical:
    """Raise the gain until the loop oscillates without end, then narrow it down.

    Parameters
    ----------
    respond : function of a gain
        Runs the loop with that P gain from a small disturbance and returns its error, shape (n,).
        Small, so that the actuator stays within its limits: there the loop looks tamer than it is.
    start : float  [output / error]
        A gain at which the error dies out.
    dt : float  [s]
        Between two samples of the error.
    factor : float
        By what the gain is raised each time.
    tolerance : float
        Relative width to which it is narrowed down.
    limit : float
        A gain never to go beyond.

    Returns
    -------
    Critical

    Raises
    ------
    NoOscillationError
        The start oscillates already, or nothing oscillates up to the limit.
    ValueError
        A start, factor, tolerance or dt that leads nowhere.
    """
    if not (0.0 < start < limit and factor > 1.0 and 0.0 < tolerance < 1.0):
        raise ValueError(
            f"start, factor, tolerance: expected 0 < start < {limit:g}, factor above 1 and "
            f"tolerance in (0, 1), got {start}, {factor} and {tolerance}"
        )
    low, high = start, start
    while (swing := find_oscillation(respond(high), dt)).growth < 1.0:
        low, high = high, high * factor
        if high > limit:
            raise NoOscillationError(
                f"respond: the error dies out at every gain up to {low:g}; a loop without any "
                "delay never oscillates: look for the sensor's or actuator's"
            )
    if high == start:
        raise NoOscillationError(
            f"start: the loop oscillates at {start:g} already; start with a smaller gain"
        )
    while high - low > tolerance * low:
        middle = 0.5 * (low + high)
        found = find_oscillation(respond(middle), dt)
        if found.growth < 1.0:
            low = middle
        else:
            high, swing = middle, found
    return Critical(high, swing.period)
