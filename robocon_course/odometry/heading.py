"""Which way does the robot look, by gyroscope and wheels together?

The gyroscope feels every turn, slip or not, but reads a little while nothing turns; that bias b,
integrated, makes its heading run away. The wheels do not run away at rest, but slip, and their
sizes are never quite right. So the gyroscope turns the heading, and the wheels teach its bias:

    b' = (gyro - b - wheels) / τ        unless they disagree by more than slip explains
    θ' = gyro - b                       and wheels, where they stand

A complementary filter: of the rate it keeps what the gyroscope says faster than τ and what the
wheels say slower. The best τ is what one second of the teacher scatters, beside what the bias
wanders in one second, both per root of a second, as independent errors add up:

- Standing, the wheels' rate 0 is exact and only the gyroscope's noise scatters: 0.0027 deg/sqrt(s)
  over a walk of 0.0001 deg/s/sqrt(s) gives 27 s. What was taught before τ has passed is a plain
  mean: the first second at rest tells nearly all (zero-velocity update).
- Rolling, one wheel 0.1 % larger than the other makes 0.1 deg/s at 1 m/s, for legs of two seconds:
  0.15 deg/sqrt(s), so 1500 s. It matters to a robot that never stops.

A bias known to s leaves the heading off by s T after the time T: three seconds at rest know it to
0.0016 deg/s, and after three minutes that is 0.3 deg.

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
        Time constant while the robot stands: the wheels have not turned it for ``rest``.
    rolling : float  [s]
        Time constant otherwise; infinity: they teach only while it stands.
    slip : float  [rad/s]
        A larger disagreement is slip, or an encoder that is lost, and teaches nothing. Two counts
        in 10 ms make 1.2 deg/s on the robot, a fresh gyroscope 0.5 deg/s.
    rest : float  [s]
        How long the wheels' rate must have been 0.
    """

    still: float = 30.0
    rolling: float = 1000.0
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
        Time since the wheels last turned the robot; infinity: it has not moved yet.
    taught : float  [s]
        For how long the bias was learnt at rest, up to the time constant. Whoever brings a bias
        from `calibrate_gyro` brings the length of its log.
    rejected : int
        Samples in which one of the two could not be used: slip, or not finite.
    """

    yaw: float = 0.0
    bias: float = 0.0
    rest: float = inf
    taught: float = 0.0
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
def heading_update(memory, gyro, wheel, dt, still, rolling, slip, least_rest):
    """One step of the filter, in place; was everything used? It trusts its input.

    Parameters
    ----------
    memory : ndarray, shape (4,)  [rad, rad/s, s, s]
        Yaw, bias, rest and taught, as in `HeadingState`.
    gyro, wheel : float  [rad/s]
        Rates; NaN or infinity where there is none.
    dt : float  [s]
    still, rolling, slip, least_rest : float  [s, s, rad/s, s]
        As in `HeadingGains`.

    Returns
    -------
    bool
    """
    yaw, bias, rest, taught = memory
    rest = rest + dt if abs(wheel) < NO_RATE else 0.0
    error = gyro - bias - wheel
    rate = gyro - bias
    used = abs(error) <= slip  # NaN is not
    if used and rest >= least_rest:
        taught = min(taught + dt, max(still, dt))
        bias += error * dt / taught
        rate = wheel
    elif used:
        bias += error * min(1.0, dt / rolling)  # after a gap one sample may at most settle it
        rate = gyro - bias
    elif not isfinite(gyro):
        rate = wheel if isfinite(wheel) else 0.0
    memory[0], memory[1], memory[2], memory[3] = yaw + rate * dt, bias, rest, taught
    return used


@njit(cache=True)
def heading_run(memory, gyro, wheel, dt, gains, yaw, bias):
    """`heading_update` over all rows into ``yaw`` and ``bias``; how many were not fully used.

    Parameters
    ----------
    memory : ndarray, shape (4,)
        As in `heading_update`; changed in place.
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
    still, rolling, slip, least_rest = gains
    yaw[0], bias[0] = memory[0], memory[1]
    rejected = 0
    for k in range(len(gyro)):
        used = heading_update(memory, gyro[k], wheel[k], dt[k], still, rolling, slip, least_rest)
        yaw[k + 1], bias[k + 1] = memory[0], memory[1]
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
    At rest the reading is all bias. Then a second of turning, by 0.5 rad/s.

    >>> state = HeadingState()
    >>> for gyro, wheel in [(0.01, 0.0)] * 100 + [(0.51, 0.5)] * 100:
    ...     state = fuse_heading(state, gyro, wheel, 0.01)
    >>> round(state.bias, 6), round(state.yaw, 6)
    (0.01, 0.5)
    """
    if not 0.0 < dt < inf:
        raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
    memory = _memory(state)
    used = heading_update(memory, *_floats((gyro_rate, wheel_rate, dt)), *_checked(gains))
    return HeadingState(*memory.tolist(), state.rejected + (not used))


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
    rejected = heading_run(_memory(start), gyro, wheel, steps, _checked(gains), yaw, bias)
    return HeadingLog(yaw, bias, start.rejected + rejected)


def _checked(gains: HeadingGains) -> tuple[float, float, float, float]:
    still, rolling, slip, rest = gains
    if not (still > 0.0 and rolling > 0.0 and slip >= 0.0 and rest >= 0.0):
        raise ValueError(
            f"gains: time constants must be positive, slip and rest not negative, got {gains}"
        )
    return tuple(map(float, gains))


def _memory(state: HeadingState) -> FloatArray:
    return np.array(state[:4], float)  # of None it makes NaN


def _floats(values) -> tuple[float, ...]:
    return tuple([nan if value is None else float(value) for value in values])
