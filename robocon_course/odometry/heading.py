"""Which way does the robot look, by gyroscope and wheels together?

The gyroscope feels every turn, slip or not, but reads a little while nothing turns; that bias b,
integrated, makes its heading run away. The wheels do not run away at rest, but slip, and their
sizes are never quite right. So the gyroscope turns the heading, and the wheels teach its bias:

    b' = (gyro - b - wheels) / τ        unless they disagree by more than slip explains
    θ' = gyro - b

A complementary filter: of the rate it keeps what the gyroscope says faster than τ and what the
wheels say slower than that. τ is chosen by what the wheels are worth:

- They have not turned the robot for a while: it stands, or goes dead straight. Their rate 0 is
  true to one count over that while, and τ is short: 1 s, some 200 samples, leave a fifteenth of the
  gyroscope's noise in the bias (zero-velocity update).
- They roll: wheels of which one is 0.1 % too large at 1 m/s lie by 0.1 deg/s, five times as much as
  the bias of a good gyroscope. Over τ such errors of many legs average out, so τ is long.

After the time T since the bias was learnt to b ± s the heading is off by s T: 0.002 deg/s after
three minutes without a stop is 0.4 deg.

Source: R. Mahony, T. Hamel, J.-M. Pflimlin, Nonlinear Complementary Filters on the Special
Orthogonal Group, IEEE Transactions on Automatic Control 53(5), 2008, section II (with one axis:
the bias is learnt by integrating the error); I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko,
Zero-velocity detection, IEEE Transactions on Biomedical Engineering 57(11), 2010.
"""

from __future__ import annotations

from math import inf, isfinite, nan, radians
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats


class HeadingGains(NamedTuple):
    """How fast the wheels teach the gyroscope its bias.

    Attributes
    ----------
    still : float  [s]
        Time constant while the wheels have not turned the robot for ``rest``.
    rolling : float  [s]
        Time constant otherwise; infinity: they teach only while still.
    slip : float  [rad/s]
        A larger disagreement is slip, or an encoder that is lost, and teaches nothing. Two counts
        in 10 ms make 1.2 deg/s on the robot, a fresh gyroscope 0.5 deg/s.
    rest : float  [s]
        How long the wheels' rate must have been 0.
    """

    still: float = 1.0
    rolling: float = 300.0
    slip: float = radians(3.0)
    rest: float = 0.2


class HeadingState(NamedTuple):
    """All that is remembered from sample to sample.

    Attributes
    ----------
    yaw : float  [rad, map]
        Not wrapped.
    bias : float  [rad/s]
        What the gyroscope reads while nothing turns.
    rest : float  [s]
        Time since the wheels last turned the robot.
    rejected : int
        Samples in which one of the two could not be used: slip, or not finite.
    """

    yaw: float = 0.0
    bias: float = 0.0
    rest: float = 0.0
    rejected: int = 0


class HeadingLog(NamedTuple):
    """Heading over a log.

    Attributes
    ----------
    yaw : ndarray, shape (n + 1,)  [rad, map]
        Before the first sample and after each, as `body_deltas` takes it; not wrapped.
    bias : ndarray, shape (n + 1,)  [rad/s]
        What was known of the gyroscope's bias.
    rejected : int
        Samples in which one of the two could not be used.
    """

    yaw: FloatArray
    bias: FloatArray
    rejected: int


# Less than one count in any sample turns the robot by more: what is below is arithmetic.
NO_RATE = 1e-6  # rad/s


@njit(cache=True)
def heading_update(yaw, bias, rest, gyro, wheel, dt, still, rolling, slip, least_rest):
    """One step of the filter: (yaw, bias, rest, was everything used?). It trusts its input.

    Parameters
    ----------
    yaw, bias, rest : float  [rad, rad/s, s]
        As in `HeadingState`.
    gyro, wheel : float  [rad/s]
        Rates; NaN or infinity where there is none.
    dt : float  [s]
    still, rolling, slip, least_rest : float  [s, s, rad/s, s]
        As in `HeadingGains`.

    Returns
    -------
    tuple of (float, float, float, bool)
    """
    if not isfinite(wheel):
        return (yaw + (gyro - bias) * dt if isfinite(gyro) else yaw), bias, 0.0, False
    rest = rest + dt if abs(wheel) < NO_RATE else 0.0
    if not isfinite(gyro):
        return yaw + wheel * dt, bias, rest, False
    error = gyro - bias - wheel
    used = abs(error) <= slip
    if used:
        # A sample after a gap may at most settle the bias.
        bias += error * min(1.0, dt / (still if rest >= least_rest else rolling))
    return yaw + (gyro - bias) * dt, bias, rest, used


@njit(cache=True)
def heading_run(start, gyro, wheel, dt, gains, yaw, bias):
    """`heading_update` over all rows into ``yaw`` and ``bias``; how many were not fully used.

    Parameters
    ----------
    start : tuple of 3 floats  [rad, rad/s, s]
        Yaw, bias and rest before the first row.
    gyro, wheel : ndarray, shape (n,)  [rad/s]
    dt : ndarray, shape (n,)  [s]
    gains : tuple of 4 floats
        As in `HeadingGains`.
    yaw, bias : ndarray, shape (n + 1,)
        Take the result.

    Returns
    -------
    int
    """
    now, drift, rest = start
    still, rolling, slip, least_rest = gains
    yaw[0], bias[0] = now, drift
    rejected = 0
    for k in range(len(gyro)):
        now, drift, rest, used = heading_update(
            now, drift, rest, gyro[k], wheel[k], dt[k], still, rolling, slip, least_rest
        )
        yaw[k + 1], bias[k + 1] = now, drift
        rejected += not used
    return rejected


def fuse_heading(
    state: HeadingState,
    gyro_rate: float,
    wheel_rate: float,
    dt: float,
    gains: HeadingGains = HeadingGains(),  # noqa: B008 - a NamedTuple cannot change
) -> HeadingState:
    """Heading after one more sample of gyroscope and wheels.

    Parameters
    ----------
    state : HeadingState
        Heading and bias before; it is left as it is.
    gyro_rate : float  [rad/s]
        What the gyroscope reads about the vertical axis. Not finite: the wheels bridge.
    wheel_rate : float  [rad/s]
        Turn of the base by its wheels over ``dt``, as `body_deltas` gives it. Not finite, or too
        far off: the gyroscope goes alone.
    dt : float  [s]
        Time since the sample before.
    gains : HeadingGains

    Returns
    -------
    HeadingState

    Raises
    ------
    ValueError
        Wrong dt or gains. Never for a sensor value: this runs in a control loop.

    Examples
    --------
    At rest the reading is all bias. After five seconds that is known, and the heading stays.

    >>> state = HeadingState()
    >>> for _ in range(500):
    ...     state = fuse_heading(state, 0.01, 0.0, 0.01)
    >>> round(state.bias, 4), round(state.yaw, 4)
    (0.0099, 0.0117)
    """
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    yaw, bias, rest, used = heading_update(
        *_floats(state[:3]), *_floats((gyro_rate, wheel_rate, dt)), *_checked(gains)
    )
    return HeadingState(yaw, bias, rest, state.rejected + (not used))


def estimate_heading(
    gyro: ArrayLike,
    wheel: ArrayLike,
    dt: ArrayLike,
    *,
    gains: HeadingGains = HeadingGains(),  # noqa: B008 - a NamedTuple cannot change
    start: HeadingState = HeadingState(),  # noqa: B008
) -> HeadingLog:
    """Heading over a recorded log, row by row as `fuse_heading`.

    Parameters
    ----------
    gyro : array_like, shape (n,)  [rad/s]
        What the gyroscope reads about the vertical axis; NaN where it is missing.
    wheel : array_like, shape (n,)  [rad/s]
        Turn of the base by its wheels in each sample, divided by dt; NaN where it is missing.
    dt : float or array_like, shape (n,)  [s]
        Time since the sample before.
    gains : HeadingGains
    start : HeadingState

    Returns
    -------
    HeadingLog

    Raises
    ------
    ValueError
        Wrong shapes or lengths, a time step that is not positive, or wrong gains.
    """
    gyro = as_floats(gyro, "gyro", None, finite=False)
    n = len(gyro)
    wheel = as_floats(wheel, "wheel", n, finite=False)
    steps = as_floats(dt if np.ndim(dt) else np.full(n, dt), "dt", n)
    if not (steps > 0.0).all():
        raise ValueError(f"dt: must be positive numbers of seconds, got {steps.min():g}")
    yaw, bias = np.empty((2, n + 1))
    rejected = heading_run(_floats(start[:3]), gyro, wheel, steps, _checked(gains), yaw, bias)
    return HeadingLog(yaw, bias, start.rejected + rejected)


def _checked(gains: HeadingGains) -> tuple[float, float, float, float]:
    still, rolling, slip, rest = gains
    if not (still > 0.0 and rolling > 0.0 and slip >= 0.0 and rest >= 0.0):
        raise ValueError(
            f"gains: time constants must be positive, slip and rest not negative, got {gains}"
        )
    return _floats(gains)


def _floats(values) -> tuple[float, ...]:
    return tuple(nan if value is None else float(value) for value in values)
