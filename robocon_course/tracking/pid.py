"""From an error to an actuator: the PID controller, with what a real robot adds to the formula.

    u = k_p e + k_i ∫ e dt - k_d dy/dt        e = setpoint - measured value y

Four things make it fit for a robot:

- The output has limits, and the integral does not grow while the output stands at one of them and
  the error pushes further (anti-windup): else it must first shrink again while the error is over.
- The derivative is the measurement's, subtracted. That of the error would kick at each step of the
  setpoint, and between steps is the same.
- An angle's error goes the shorter way round.
- A measurement that is no number changes nothing but a counter.

Source: K. J. Åström, R. M. Murray, Feedback Systems, 2nd edition, Princeton 2021, sections 11.1
(terms), 11.4 (windup) and 11.5 (derivative of the measurement; velocity form).
"""

from __future__ import annotations

from math import inf, isfinite, nan, remainder
from typing import NamedTuple

from robocon_course.geometry import TURN


class PidGains(NamedTuple):
    """How strongly each term answers; units are those of the output per those of the error.

    Attributes
    ----------
    k_p : float  [output / error]
    k_i : float  [output / (error s)]
    k_d : float  [output s / error]
    smoothing : float  [s]
        Time constant of a low-pass on the derivative, which sees each count of an encoder as a
        jump. 0: none.
    """

    k_p: float
    k_i: float = 0.0
    k_d: float = 0.0
    smoothing: float = 0.0


class PidLimits(NamedTuple):
    """What the controller may ask for, in units of the output.

    Attributes
    ----------
    low, high : float
        Least and greatest output.
    integral : float
        The integral term stays within ± this.
    """

    low: float = -inf
    high: float = inf
    integral: float = inf


class PidTerms(NamedTuple):
    """What the last output was made of, in units of the output."""

    proportional: float
    integral: float
    derivative: float


class PidState(NamedTuple):
    """All that a controller remembers from sample to sample.

    Attributes
    ----------
    proportional, integral, derivative : float  [output]
        The terms of the last output, before the limits.
    measured : float  [as the measurement]
        The last good one; NaN: none yet.
    gap : float  [s]
        Time passed since, in samples without a good one.
    output : float
        The last output.
    rejected : int
        Samples without a finite setpoint and measurement.
    """

    proportional: float = 0.0
    integral: float = 0.0
    derivative: float = 0.0
    measured: float = nan
    gap: float = 0.0
    output: float = 0.0
    rejected: int = 0


class Pid:
    """A PID controller in position form: the output follows from the terms alone.

    Parameters
    ----------
    gains : PidGains
    limits : PidLimits
    wrap : bool
        Setpoint and measurement are angles [rad]; error and change go the shorter way round.
    state : PidState
        Where it goes on; a new one starts from nothing.

    Raises
    ------
    ValueError
        Gains that are no finite numbers, or limits that leave nothing.

    Examples
    --------
    A wheel is to run at 2 m/s and runs at 1 m/s; each second of that adds 0.5 to the answer.

    >>> pid = Pid(PidGains(3.0, 0.5), PidLimits(high=3.9))
    >>> pid.update(2.0, 1.0, 1.0), pid.update(2.0, 1.0, 1.0), pid.update(2.0, 1.0, 1.0)
    (3.5, 3.9, 3.9)
    >>> pid.terms
    PidTerms(proportional=3.0, integral=0.5, derivative=-0.0)
    """

    __slots__ = (
        *("_k_p", "_k_i", "_k_d", "_smoothing", "_low", "_high", "_cap", "_wrap"),
        *("_proportional", "_integral", "_derivative", "_measured", "_gap", "_output", "_rejected"),
    )

    def __init__(
        self,
        gains: PidGains,
        limits: PidLimits = PidLimits(),  # noqa: B008 - a NamedTuple cannot change
        *,
        wrap: bool = False,
        state: PidState = PidState(),  # noqa: B008
    ) -> None:
        self._k_p, self._k_i, self._k_d, self._smoothing = _checked_gains(gains)
        self._low, self._high, self._cap = _checked_limits(limits)
        self._wrap = bool(wrap)
        self.state = state

    def update(self, setpoint: float, measured: float, dt: float) -> float:
        """The output after one more sample.

        Parameters
        ----------
        setpoint, measured : float
            In the same unit. Where one is not finite, the last output holds and the sample counts
            in ``rejected``.
        dt : float  [s]
            Time since the sample before.

        Returns
        -------
        float

        Raises
        ------
        ValueError
            dt is not positive. Never for a measurement: this runs in a control loop.
        """
        if not 0.0 < dt < inf:
            raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
        error = setpoint - measured
        if error - error != 0.0:  # infinity or NaN
            return self._miss(dt)
        change = measured - self._measured
        if self._wrap:
            error, change = remainder(error, TURN), remainder(change, TURN)
        # u = k_p e + k_i ∫ e dt - k_d dy/dt; no change is known at the first sample
        proportional = self._k_p * error
        growth = self._k_i * error * dt
        derivative = -self._k_d * change / (dt + self._gap) if change == change else 0.0
        if self._smoothing:
            share = dt / (dt + self._smoothing)
            derivative = self._derivative + share * (derivative - self._derivative)
        integral = self._integral + growth
        if not -self._cap <= integral <= self._cap:
            integral = self._cap if integral > 0.0 else -self._cap
        output = proportional + integral + derivative
        if output - output != 0.0:  # two huge numbers beside each other are no measurement
            return self._miss(dt)
        # At a limit, the integral may shrink but not push further.
        if output > self._high:
            output = self._high
            if growth > 0.0:
                integral = self._integral
        elif output < self._low:
            output = self._low
            if growth < 0.0:
                integral = self._integral
        self._proportional, self._integral, self._derivative = proportional, integral, derivative
        self._measured, self._gap, self._output = measured, 0.0, output
        return output

    def _miss(self, dt: float) -> float:
        self._gap += dt
        self._rejected += 1
        return self._output

    def reset(self) -> None:
        """Forget everything, as when the robot is put elsewhere."""
        self.state = PidState()

    @property
    def terms(self) -> PidTerms:
        """What the last output was made of, before the limits."""
        return PidTerms(self._proportional, self._integral, self._derivative)

    @property
    def output(self) -> float:
        """The last output."""
        return self._output

    @property
    def rejected(self) -> int:
        """How many samples had no finite setpoint and measurement."""
        return self._rejected

    @property
    def state(self) -> PidState:
        """What to keep and give back later."""
        return PidState(
            self._proportional, self._integral, self._derivative,
            self._measured, self._gap, self._output, self._rejected,
        )  # fmt: skip

    @state.setter
    def state(self, state: PidState) -> None:
        *numbers, rejected = state
        self._proportional, self._integral, self._derivative, *rest = map(float, numbers)
        self._measured, self._gap, self._output = rest
        self._rejected = int(rejected)


def pid_step(
    state: PidState,
    setpoint: float,
    measured: float,
    dt: float,
    gains: PidGains,
    limits: PidLimits = PidLimits(),  # noqa: B008 - a NamedTuple cannot change
    *,
    wrap: bool = False,
) -> PidState:
    """One step of `Pid` as a pure function; the new output stands in the new state.

    Parameters
    ----------
    state : PidState
        Before; it is left as it is.
    setpoint, measured : float
        In the same unit.
    dt : float  [s]
        Time since the sample before.
    gains : PidGains
    limits : PidLimits
    wrap : bool
        As in `Pid`.

    Returns
    -------
    PidState

    Raises
    ------
    ValueError
        Wrong gains, limits or dt. Never for a measurement.

    Examples
    --------
    >>> pid_step(PidState(), 1.0, 0.0, 0.1, PidGains(2.0, 5.0)).output
    2.5
    """
    pid = Pid(gains, limits, wrap=wrap, state=state)
    pid.update(setpoint, measured, dt)
    return pid.state


def _checked_gains(gains: PidGains) -> tuple[float, ...]:
    k_p, k_i, k_d, smoothing = checked = tuple(map(float, gains))
    if not (isfinite(k_p) and isfinite(k_i) and isfinite(k_d) and 0.0 <= smoothing < inf):
        raise ValueError(
            f"gains: expected finite numbers, smoothing in seconds from 0 on, got {gains}"
        )
    return checked


def _checked_limits(limits: PidLimits) -> tuple[float, ...]:
    low, high, integral = checked = tuple(map(float, limits))
    if not (low < high and integral >= 0.0):
        raise ValueError(f"limits: expected low < high and integral from 0 on, got {limits}")
    return checked
