"""One step of a PID controller, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, isnan, nan

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.tracking import PidGains, PidLimits, PidState
from robocon_course.worlds import Student

JUDGED = {"output": 1e-9, "integral": 1e-9, "measured": 1e-9, "gap": 1e-9, "rejected": 0.0}
FREE, NARROW, TIGHT = PidLimits(), PidLimits(-1.0, 1.0), PidLimits(-0.3, 0.3)


def _pid_step_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    def some(low: float, high: float) -> float:
        return float(round(rng.uniform(low, high), 3))

    k_p, k_i, k_d = some(1.2, 3.0), some(1.5, 4.0), some(0.2, 0.6)
    gains, dt = PidGains(k_p, k_i, k_d), 0.02
    before = some(0.2, 0.3)  # setpoint minus measurement of the sample before
    going = PidState(k_p * before, some(0.05, 0.2), 0.0, 0.5, output=0.7, rejected=2)
    pushed = going._replace(integral=some(0.5, 0.8), output=1.0)
    blind = going._replace(gap=0.06)
    rows = [
        ("the first sample: nothing measured before", PidState(), 1.0, 0.4, FREE),
        ("the measurement rises towards the setpoint", going, 0.5 + before, some(0.51, 0.55), FREE),
        ("the measurement falls", going, 0.5 + before, some(0.42, 0.48), FREE),
        ("the setpoint jumps, the robot has not moved", going, 3.0, 0.5, FREE),
        ("beyond the setpoint", going, 0.45, some(0.5, 0.53), FREE),
        ("the output is at its upper limit, the error pushes on", pushed, 1.6, 0.5, NARROW),
        ("the output is at its upper limit, the error pulls back", pushed, 0.47, 0.5, TIGHT),
        (
            "the output is at its lower limit, the error pushes on",
            pushed._replace(integral=-pushed.integral, output=-1.0),
            -0.6,
            0.5,
            NARROW,
        ),
        (
            "within limits, the integral beyond them",
            pushed._replace(integral=1.3),
            0.1,
            0.5,
            NARROW,
        ),
        ("limits that are not alike", going, 0.9, 0.5, PidLimits(0.2, 0.6)),
        ("the sensor says nan", going, 0.8, nan, FREE),
        ("the sensor says nan again", blind, 0.8, nan, FREE),
        ("the first measurement after three that were lost", blind, 0.8, some(0.53, 0.58), FREE),
    ]
    cases = [(what, state, a, b, dt, gains, limits) for what, state, a, b, limits in rows]
    for _ in range(4):
        other = PidGains(some(0.5, 4.0), some(0.5, 4.0), some(0.05, 0.5))
        state = PidState(some(-1.0, 1.0), some(-1.0, 1.0), 0.0, some(-1.0, 1.0))
        numbers = some(-1.0, 1.0), some(-1.0, 1.0), some(0.01, 0.1)
        cases.append(("any state", state, *numbers, other, FREE))
    return [Case(what, tuple(args), "", dict(JUDGED)) for what, *args in cases]


def _change(state: PidState, measured: float, dt: float) -> float:
    """How fast the measurement changed, over the whole gap; 0 where none is known."""
    return 0.0 if isnan(state.measured) else (measured - state.measured) / (dt + state.gap)


def _held(state: PidState, dt: float) -> PidState:
    return state._replace(gap=state.gap + dt, rejected=state.rejected + 1)


def _winds(growth: float, output: float, limits: PidLimits) -> bool:
    """Whether the integral must wait."""
    return (output > limits.high and growth > 0.0) or (output < limits.low and growth < 0.0)


def _pid(
    *,
    error: Callable[[float, float], float] = lambda setpoint, measured: setpoint - measured,
    growth: Callable[..., float] = lambda e, dt, gains: gains.k_i * e * dt,
    brake: Callable[..., float] = lambda s, e, y, dt, g: -g.k_d * _change(s, y, dt),
    waits: Callable[..., bool] = _winds,
    total: Callable[..., float] = lambda p, i, grown, d, gains: p + i + grown + d,
    cut: Callable[..., float] = lambda output, limits: min(max(output, limits.low), limits.high),
    keep: Callable[..., float] = lambda integral, limits: integral,
    bad: Callable[..., PidState] | None = _held,
    gap: Callable[[PidState], float] = lambda state: 0.0,
) -> Callable[..., PidState]:
    """The step with one of its parts wrong."""

    def function(
        state: PidState,
        setpoint: float,
        measured: float,
        dt: float,
        gains: PidGains,
        limits: PidLimits,
    ) -> PidState:
        e = error(setpoint, measured)
        if bad and not isfinite(e):
            return bad(state, dt)
        p, grown, d = gains.k_p * e, growth(e, dt, gains), brake(state, e, measured, dt, gains)
        output = total(p, state.integral, grown, d, gains)
        integral = state.integral if waits(grown, output, limits) else state.integral + grown
        return PidState(
            p,
            keep(integral, limits),
            d,
            measured,
            gap(state),
            cut(output, limits),
            state.rejected,
        )

    return function


def _of_the_error(s: PidState, e: float, y: float, dt: float, g: PidGains) -> float:
    return 0.0 if isnan(s.measured) else g.k_d * (e - s.proportional / g.k_p) / (dt + s.gap)


def _nan_as_zero(s: PidState, e: float, y: float, dt: float, g: PidGains) -> float:
    return -g.k_d * (y - (0.0 if isnan(s.measured) else s.measured)) / (dt + s.gap)


PID_STEP = Exercise(
    id="tracking.pid_step",
    title="One step of a PID controller that is fit for a robot",
    points=4,
    reference=tracking.pid_step,
    cases=_pid_step_cases,
    shortcuts=(
        "robocon_course.tracking.pid.Pid.update",
        "robocon_course.tracking.incremental.IncrementalPid.update",
    ),
    hints=(
        "Begin with the bad sample: where the error is not finite, return "
        "state._replace(gap=state.gap + dt, rejected=state.rejected + 1) and nothing else changes.",
        "Three terms: k_p · error; the integral grows by k_i · error · dt; the derivative is −k_d "
        "times the change of the measurement, divided by dt + state.gap, and 0 while "
        "state.measured is nan.",
        "output = proportional + state.integral + growth + derivative, then cut to the limits.",
        "Anti-windup: where the uncut output is above limits.high and growth > 0, or below "
        "limits.low and growth < 0, keep state.integral instead of state.integral + growth.",
    ),
    mistakes=(
        Mistake(
            "derivative added",
            "The derivative of the measurement is added, as one source prints it. It has to brake: "
            "subtract it.",
            _pid(brake=lambda s, e, y, dt, g: g.k_d * _change(s, y, dt)),
        ),
        Mistake(
            "derivative of the error",
            "This is the derivative of the error. When the setpoint jumps the error jumps, and the "
            "actuator gets a kick. Take minus the change of the measurement.",
            _pid(brake=_of_the_error),
        ),
        Mistake(
            "first sample kicks",
            "At the first sample nothing was measured before. That is not the same as 0: the "
            "derivative is 0 there.",
            _pid(brake=_nan_as_zero),
        ),
        Mistake(
            "first sample is nan",
            "At the first sample state.measured is nan, and so is the derivative made with it. "
            "It has to be 0 there.",
            _pid(
                brake=lambda s, e, y, dt, g: -g.k_d * (y - s.measured) / (dt + s.gap),
                cut=lambda output, limits: float(np.clip(output, limits.low, limits.high)),
            ),
        ),
        Mistake(
            "no anti-windup",
            "The integral grows on while the output stands at its limit. It has to be emptied "
            "later, and until then the robot goes too far.",
            _pid(waits=lambda grown, output, limits: False),
        ),
        Mistake(
            "integral frozen at a limit",
            "At a limit the integral is not allowed to shrink either. It has to wait only where "
            "the error pushes further beyond the limit.",
            _pid(waits=lambda grown, output, limits: not limits.low <= output <= limits.high),
        ),
        Mistake(
            "anti-windup the wrong way round",
            "The integral waits when the error leads back from the limit, and grows when it pushes "
            "on. Exchange the two.",
            _pid(waits=lambda grown, output, limits: _winds(-grown, output, limits)),
        ),
        Mistake(
            "integral cut to the output's limits",
            "The integral is cut to the output's limits. That is a bound, but no anti-windup: the "
            "output reaches its limit long before the integral does.",
            _pid(
                waits=lambda grown, output, limits: False,
                keep=lambda integral, limits: min(max(integral, limits.low), limits.high),
            ),
        ),
        Mistake(
            "dt forgotten in the integral",
            "The integral grows by k_i · error · dt. Without dt it depends on how often the loop "
            "runs.",
            _pid(growth=lambda e, dt, gains: gains.k_i * e),
        ),
        Mistake(
            "dt forgotten in the derivative",
            "The change is not divided by the time it took. Then it depends on how often the loop "
            "runs.",
            _pid(
                brake=lambda s, e, y, dt, g: 0.0 if isnan(s.measured) else -g.k_d * (y - s.measured)
            ),
        ),
        Mistake(
            "integral without its gain",
            "state.integral is in units of the output: k_i belongs into what is added, not in "
            "front of the whole.",
            _pid(
                growth=lambda e, dt, gains: e * dt,
                total=lambda p, i, grown, d, gains: p + gains.k_i * (i + grown) + d,
            ),
        ),
        Mistake(
            "integral one sample late",
            "The output is made with the old integral. What this sample adds belongs in it.",
            _pid(total=lambda p, i, grown, d, gains: p + i + d),
        ),
        Mistake(
            "error reversed",
            "The error is setpoint minus measurement. Reversed, the robot runs away.",
            _pid(error=lambda setpoint, measured: measured - setpoint),
        ),
        Mistake(
            "limits not applied",
            "The output goes beyond its limits.",
            _pid(cut=lambda output, limits: output),
        ),
        Mistake(
            "lower limit forgotten",
            "Only the upper limit is applied. A robot drives backwards too.",
            _pid(cut=lambda output, limits: min(output, limits.high)),
        ),
        Mistake(
            "nan goes through",
            "One bad measurement makes the state nan, and it never recovers. Where the error is "
            "not finite, keep the state, and count.",
            _pid(bad=None, cut=lambda output, limits: float(np.clip(output, *limits[:2]))),
        ),
        Mistake(
            "nan resets",
            "After a bad measurement the controller has forgotten everything. Keep the state, "
            "count the sample, add dt to the gap.",
            _pid(bad=lambda state, dt: PidState(gap=dt, rejected=state.rejected + 1)),
        ),
        Mistake(
            "nan stops the robot",
            "A bad measurement sets the output to 0. One lost sample must not jolt the robot: the "
            "last output holds.",
            _pid(bad=lambda state, dt: _held(state, dt)._replace(output=0.0)),
        ),
        Mistake(
            "nan not counted",
            "A bad sample has to be counted: rejected + 1. Somebody will want to know.",
            _pid(bad=lambda state, dt: state._replace(gap=state.gap + dt)),
        ),
        Mistake(
            "gap not counted",
            "A bad sample takes time as well: its dt belongs to state.gap.",
            _pid(bad=lambda state, dt: state._replace(rejected=state.rejected + 1)),
        ),
        Mistake(
            "gap ignored",
            "After lost samples the change took longer than dt: divide by dt + state.gap.",
            _pid(brake=lambda s, e, y, dt, g: -g.k_d * _change(s._replace(gap=0.0), y, dt)),
        ),
        Mistake(
            "gap never closed",
            "A good measurement ends the gap: set it to 0.",
            _pid(gap=lambda state: state.gap),
        ),
        Mistake(
            "P only",
            "This is the proportional term alone.",
            _pid(
                growth=lambda e, dt, gains: 0.0,
                total=lambda p, i, grown, d, gains: p,
                brake=lambda s, e, y, dt, g: 0.0,
            ),
        ),
    ),
)
