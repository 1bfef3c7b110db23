"""Chapter 05: the PID controller, its tuning, and the two printed sources beside them."""

from __future__ import annotations

from math import exp, inf, isnan, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from conftest import missing
from robocon_course import tracking
from robocon_course.tracking import (
    DifferentialModel,
    DifferentialState,
    IncrementalPid,
    Pid,
    PidGains,
    PidLimits,
    PidState,
    pid_step,
)

TURN = 2.0 * pi
DT = 0.01
FREE = PidLimits()
signal = st.floats(-5.0, 5.0)
samples = st.lists(st.tuples(signal, signal, st.floats(0.005, 0.05)), min_size=1, max_size=40)
gains = st.builds(
    PidGains, st.floats(0.0, 5.0), st.floats(0.0, 5.0), st.floats(0.0, 0.5), st.just(0.0)
)
limits = st.builds(PidLimits, st.floats(-3.0, -0.1), st.floats(0.1, 3.0), st.floats(0.0, 2.0))


def run(pid, rows) -> list[float]:
    return [pid.update(*row) for row in rows]


def naive(rows, gains, limits=FREE) -> list[float]:
    """The formula, written down sample by sample."""
    outputs, integral, last = [], 0.0, None
    for setpoint, measured, dt in rows:
        error = setpoint - measured
        growth = gains.k_i * error * dt
        rate = 0.0 if last is None else (measured - last) / dt
        kept = min(max(integral + growth, -limits.integral), limits.integral)
        wanted = gains.k_p * error + kept - gains.k_d * rate
        output = min(max(wanted, limits.low), limits.high)
        if (wanted - output) * growth <= 0.0:  # within the limits, or on the way back
            integral = kept
        outputs.append(output)
        last = measured
    return outputs


# --- by hand ----------------------------------------------------------------------------------


def test_each_term_by_hand():
    pid = Pid(PidGains(2.0, 3.0, 0.5))
    assert pid.update(1.0, 0.0, 0.1) == pytest.approx(2.0 + 0.3)
    assert pid.terms == pytest.approx((2.0, 0.3, 0.0))
    assert pid.update(1.0, 0.2, 0.1) == pytest.approx(1.6 + 0.54 - 1.0)
    assert pid.terms == pytest.approx((1.6, 0.54, -1.0))


def test_the_derivative_brakes_a_measurement_that_rises():
    pid = Pid(PidGains(0.0, k_d=1.0))
    assert run(pid, [(0.0, 0.1 * k, 0.1) for k in range(4)]) == pytest.approx([0.0, -1, -1, -1])


def test_a_step_of_the_setpoint_kicks_nothing():
    pid = Pid(PidGains(0.0, k_d=1.0))
    assert run(pid, [(0.0, 0.3, DT), (1.0, 0.3, DT), (-9.0, 0.3, DT)]) == [0.0, 0.0, 0.0]


def test_the_first_sample_knows_no_change():
    assert Pid(PidGains(0.0, k_d=1.0)).update(0.0, 100.0, DT) == 0.0


def test_smoothing_spreads_a_jump_of_the_derivative_over_its_time_constant():
    pid = Pid(PidGains(0.0, k_d=1.0, smoothing=0.05))
    outputs = run(pid, [(0.0, 0.0, DT), (0.0, 0.01, DT)] + [(0.0, 0.01, DT)] * 5)
    # One jump of 0.01 in 0.01 s: 1/6 of it at once, the rest fades by 5/6 a sample.
    assert outputs[1:] == pytest.approx([-(1 / 6) * (5 / 6) ** k for k in range(6)])


# --- limits -----------------------------------------------------------------------------------


@given(samples, gains, limits)
def test_the_output_and_the_integral_never_leave_their_limits(rows, gains, limits):
    pid = Pid(gains, limits)
    for row in rows:
        assert limits.low <= pid.update(*row) <= limits.high
        assert abs(pid.terms.integral) <= limits.integral


def test_at_a_limit_the_integral_waits_and_the_way_back_begins_at_once():
    pid = Pid(PidGains(0.0, 1.0), PidLimits(-1.0, 1.0))
    assert max(run(pid, [(1.0, 0.0, 0.1)] * 1000)) == 1.0
    # After 100 s at the limit one sample of the other sign already shows.
    assert pid.update(0.0, 1.0, 0.1) == pytest.approx(0.9)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_anti_windup_spares_a_cart_most_of_its_overshoot(sign):
    gains, limit = PidGains(2.0, 1.5), 0.2

    def overshoot(pid) -> float:
        place, most = 0.0, 0.0
        for _ in range(3000):  # a cart that drives at the speed it is told, 0.2 m/s at most
            place += min(max(pid.update(sign, place, DT), -limit), limit) * DT
            most = max(most, sign * place - 1.0)
        return most

    wound = overshoot(Pid(gains))
    assert wound > 0.5
    for kind in (Pid, IncrementalPid):
        assert overshoot(kind(gains, PidLimits(-limit, limit))) < 0.1 * wound


def test_a_reversed_actuator_has_the_same_anti_windup():
    pid = Pid(PidGains(0.0, -1.0), PidLimits(-1.0, 1.0))
    run(pid, [(1.0, 0.0, 0.1)] * 100)
    assert pid.update(0.0, 1.0, 0.1) == pytest.approx(-0.9)


# --- angles -----------------------------------------------------------------------------------


def test_an_angle_goes_the_shorter_way_round():
    pid = Pid(PidGains(1.0, k_d=1.0), wrap=True)
    assert pid.update(3.0, -3.0, 1.0) == pytest.approx(6.0 - TURN)
    # The measurement went on by 0.2 over the cut, not back by 6.1.
    pid.update(0.0, 3.1, 1.0)
    pid.update(0.0, 3.3 - TURN, 1.0)
    assert pid.terms.derivative == pytest.approx(-0.2)


@given(samples, gains, st.integers(-3, 3), st.integers(-3, 3))
def test_whole_turns_change_nothing(rows, gains, setpoint_turns, measured_turns):
    here, there = Pid(gains, wrap=True), Pid(gains, wrap=True)
    for setpoint, measured, dt in rows:
        far = abs(abs(np.remainder(setpoint - measured, TURN)) - pi) < 1e-6
        one = here.update(setpoint, measured, dt)
        two = there.update(setpoint + setpoint_turns * TURN, measured + measured_turns * TURN, dt)
        if far or abs(abs(here.terms.proportional) - abs(there.terms.proportional)) > 1e-6:
            return  # just opposite, either way round is as short
        # The measurement's change near half a turn may round to either side, too.
        if abs(here.terms.derivative - there.terms.derivative) > 1e-6:
            return
        assert one == pytest.approx(two, abs=1e-7)


# --- in a control loop ------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [Pid, IncrementalPid])
@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_sample_that_is_no_number_holds_the_output_and_is_counted(kind, bad):
    pid = kind(PidGains(1.0, 0.5, 0.1))
    held = run(pid, [(1.0, 0.0, DT), (1.0, 0.1, DT)])[-1]
    before = pid.state
    assert pid.update(1.0, bad, DT) == held and pid.update(bad, 0.3, DT) == held
    assert pid.rejected == 2
    assert pid.state == before._replace(gap=2 * DT, rejected=2)


def test_after_a_gap_the_change_is_spread_over_the_whole_of_it():
    pid = Pid(PidGains(0.0, k_d=1.0))
    run(pid, [(0.0, 0.0, 0.1), (0.0, nan, 0.1), (0.0, nan, 0.1)])
    assert pid.update(0.0, 0.6, 0.1) == pytest.approx(-2.0)
    assert pid.update(0.0, 0.9, 0.1) == pytest.approx(-3.0)


@given(samples, gains, limits, st.booleans(), st.integers(0, 40), st.data())
def test_saved_and_restored_a_controller_goes_on_to_the_bit(rows, gains, limits, wrap, at, data):
    kind = data.draw(st.sampled_from([Pid, IncrementalPid]))
    limits = limits._replace(integral=inf) if kind is IncrementalPid else limits
    whole, first, second = (kind(gains, limits, wrap=wrap) for _ in range(3))
    run(second, rows[:3])  # whatever it remembers is overwritten
    outputs = run(whole, rows)
    begun = run(first, rows[:at])
    second.state = first.state
    assert begun + run(second, rows[at:]) == outputs
    first.reset()
    assert run(first, rows) == outputs


@given(samples, gains, limits)
def test_the_pure_step_is_the_same_controller(rows, gains, limits):
    pid, state = Pid(gains, limits), PidState()
    for row in rows:
        before = repr(state)
        after = pid_step(state, *row, gains, limits)
        assert repr(state) == before
        state = after
        assert state.output == pid.update(*row)
        assert state == pid.state


@given(samples, gains, limits)
def test_it_equals_the_formula_written_down(rows, gains, limits):
    assert run(Pid(gains, limits), rows) == pytest.approx(naive(rows, gains, limits), abs=1e-9)


def test_it_equals_wpimath_where_both_mean_the_same():
    try:
        from wpimath.controller import PIDController
    except ImportError:
        missing("robotpy-wpimath is not installed")
    theirs = PIDController(1.3, 0.7, 0.05, DT)
    ours = Pid(PidGains(1.3, 0.7, 0.05))
    theirs.setIntegratorRange(-1e9, 1e9)
    for k, measured in enumerate(np.sin(np.arange(300) * 0.05)):
        pair = ours.update(0.5, measured, DT), theirs.calculate(measured, 0.5)
        # Its first sample takes the error before for 0: the kick that ours leaves out.
        assert k == 0 or pair[0] == pytest.approx(pair[1], abs=1e-9)
        assert k > 0 or pair[1] - pair[0] == pytest.approx(0.05 * 0.5 / DT)


# --- the incremental form ---------------------------------------------------------------------


@given(samples, gains)
def test_between_its_limits_the_incremental_form_equals_the_other(rows, gains):
    # Sums of 40 terms in another order; each below 1e3.
    one, other = run(Pid(gains), rows), run(IncrementalPid(gains), rows)
    assert other == pytest.approx(one, abs=1e-9)


@given(samples, gains, limits)
def test_the_incremental_form_adds_changes_and_cuts(rows, gains, limits):
    pid = IncrementalPid(gains, limits._replace(integral=inf))
    output, last_error, last, last_rate = 0.0, 0.0, None, 0.0
    for setpoint, measured, dt in rows:
        error = setpoint - measured
        rate = 0.0 if last is None else (measured - last) / dt
        output += gains.k_p * (error - last_error) + gains.k_i * error * dt
        output -= gains.k_d * (rate - last_rate)
        output = min(max(output, limits.low), limits.high)
        last_error, last, last_rate = error, measured, rate
        assert pid.update(setpoint, measured, dt) == pytest.approx(output, abs=1e-9)


def test_the_incremental_form_takes_over_without_a_jump():
    pid = IncrementalPid(PidGains(4.0, 0.0, 0.2))
    pid.take_over(0.7, error=0.25)
    assert pid.update(1.0, 0.75, DT) == pytest.approx(0.7)
    assert pid.update(1.0, 0.75, DT) == pytest.approx(0.7)
    assert Pid(PidGains(4.0)).update(1.0, 0.75, DT) == pytest.approx(1.0)


# --- refusals ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "gains, limits, sentence",
    [
        (PidGains(nan), FREE, "gains: expected finite numbers"),
        (PidGains(1.0, inf), FREE, "gains: expected finite numbers"),
        (PidGains(1.0, smoothing=-0.1), FREE, "smoothing in seconds from 0 on"),
        (PidGains(1.0), PidLimits(1.0, 1.0), "limits: expected low < high"),
        (PidGains(1.0), PidLimits(nan, 1.0), "limits: expected low < high"),
        (PidGains(1.0), PidLimits(integral=-1.0), "limits: .* integral from 0 on"),
    ],
)
def test_settings_that_mean_nothing_are_refused_when_it_is_made(gains, limits, sentence):
    for kind in (Pid, IncrementalPid):
        with pytest.raises(ValueError, match=sentence):
            kind(gains, limits)


def test_the_incremental_form_refuses_a_limit_of_what_it_does_not_keep():
    with pytest.raises(ValueError, match=r"limits.integral: the incremental form keeps no"):
        IncrementalPid(PidGains(1.0), PidLimits(integral=2.0))


@pytest.mark.parametrize("dt", [0.0, -0.01, nan, inf])
def test_a_time_step_that_is_none_is_refused(dt):
    with pytest.raises(ValueError, match="dt: must be a positive number of seconds"):
        Pid(PidGains(1.0)).update(1.0, 0.0, dt)


# --- thesis 2024: the printed controller --------------------------------------------------------


class Printed:
    """The thesis's controller as its listing works, in mm/s and ms; its parts can be mended."""

    def __init__(self, k_p, k_i, k_d, bound, *, sign=1.0, period=10):
        self.k_p, self.k_i, self.k_d, self.bound, self.sign = k_p, k_i, k_d, bound, sign
        self.period, self.sum, self.last, self.time = period, 0.0, 0.0, 0

    def compute(self, now, setpoint, measured):
        passed = now - self.time
        if passed >= self.period:

            def cut(value, bound):
                return min(max(value, -bound), bound)

            error = cut(setpoint - measured, self.bound)
            self.sum = cut(self.sum + error * passed, self.bound / self.k_i)
            change = cut((measured - self.last) / passed, self.bound / self.k_d)
            self.last, self.time = measured, now
            total = self.k_p * error + self.k_i * self.sum + self.sign * self.k_d * change
            return cut(total, self.bound)


def test_the_print_divides_by_zero_for_a_p_a_pi_and_a_pd_controller():
    for numbers in ((1.0, 0.0, 0.0), (1.0, 0.1, 0.0), (1.0, 0.0, 0.1)):
        with pytest.raises(ZeroDivisionError):
            Printed(*numbers, 100.0).compute(10, 500.0, 0.0)
        assert Pid(PidGains(*numbers)).update(500.0, 0.0, 0.01) > 0.0


def test_the_print_returns_nothing_between_its_samples():
    printed = Printed(1.0, 0.1, 0.1, 100.0)
    assert printed.compute(10, 50.0, 0.0) is not None
    assert printed.compute(15, 50.0, 0.0) is None
    with pytest.raises(TypeError):
        300.0 + printed.compute(16, 50.0, 0.0)


def test_the_prints_derivative_pushes_where_it_should_brake():
    rising = Printed(1e-9, 1e-9, 5.0, 1000.0)
    rising.compute(10, 0.0, 0.0)
    assert rising.compute(20, 0.0, 100.0) == pytest.approx(50.0, abs=1e-3)
    ours = Pid(PidGains(0.0, k_d=0.005))
    assert run(ours, [(0.0, 0.0, 0.01), (0.0, 100.0, 0.01)])[-1] == pytest.approx(-50.0)


def swing_of_a_mass(push) -> float:
    """Largest speed of a mass in its last second; it is pulled to 0 from 0.1 for ten seconds."""
    place, speed, fastest = 0.1, 0.0, 0.0
    for k in range(1, 1001):
        speed += push(10 * k, place) * DT
        place += speed * DT
        fastest = max(fastest, abs(speed)) if k > 900 else 0.0
    return fastest


def test_with_the_derivative_added_a_mass_swings_up_and_subtracted_it_comes_to_rest():
    def by(sign):
        printed = Printed(25.0, 1e-9, 4000.0, 50.0, sign=sign)  # k_d in ms
        return swing_of_a_mass(lambda now, place: printed.compute(now, 0.0, place))

    assert by(+1.0) > 1.0 and by(-1.0) < 1e-3
    pid = Pid(PidGains(25.0, k_d=4.0), PidLimits(-50.0, 50.0))
    assert swing_of_a_mass(lambda _, place: pid.update(0.0, place, DT)) < 1e-3


def driven(pid, setpoint: float, seconds: float = 5.0) -> float:
    """Speed [m/s] of a wheel with a lag of 0.1 s after a while, from 0.5 m/s."""
    speed = 0.5
    for _ in range(round(seconds / DT)):
        speed += (pid.update(setpoint, speed, DT) - speed) * (1.0 - exp(-DT / 0.1))
    return speed


def test_the_printed_clamp_never_stops_and_its_sum_of_outputs_is_no_increment():
    clamped = IncrementalPid(PidGains(0.5, 5.0), PidLimits(0.1, 1.0))
    clamped.take_over(0.5)
    assert driven(clamped, 0.0) == pytest.approx(0.1)  # 100 mm/s, told to stand still
    ours = IncrementalPid(PidGains(0.5, 5.0), PidLimits(-1.0, 1.0))
    ours.take_over(0.5)
    assert abs(driven(ours, 0.0)) < 1e-6
    assert driven(ours, 0.7) == pytest.approx(0.7, abs=1e-6)
    # The print adds the whole output of the controller to the speed, not its change: P then acts as
    # an integral, and the integral as one of an integral, which overshoots in any tuning.
    summed, position, speed, most = 0.5, Pid(PidGains(0.02, 0.05)), 0.5, 0.0
    for _ in range(3000):
        summed += position.update(0.7, speed, DT)
        speed += (summed - speed) * (1.0 - exp(-DT / 0.1))
        most = max(most, speed)
    assert most > 0.75
    ours = IncrementalPid(PidGains(0.02, 2.0))  # P of the sum, at 100 samples a second
    ours.take_over(0.5)
    assert max(driven(ours, 0.7, 0.1 * k) for k in range(1, 4)) < 0.75


# --- tuning -----------------------------------------------------------------------------------


def test_the_published_gains_follow_from_the_published_oscillation():
    # K_cr = 0.7, P_cr = 21 x 10 ms; time in milliseconds as printed.
    found = tracking.ziegler_nichols(0.7, 21 * 10.0)
    assert found.k_p == pytest.approx(0.42)
    assert found.k_i == pytest.approx(0.42 / 105.0) and round(found.k_i, 3) == 0.004
    assert found.k_d == pytest.approx(0.42 * 26.25) == 11.025
    # In seconds: the same controller.
    ours = tracking.ziegler_nichols(0.7, 0.21)
    assert ours == pytest.approx((0.42, 4.0, 0.011025, 0.0))


def test_the_rules_for_p_and_pi():
    assert tracking.ziegler_nichols(2.0, 0.6, "P") == pytest.approx((1.0, 0.0, 0.0, 0.0))
    assert tracking.ziegler_nichols(2.0, 0.6, "PI") == pytest.approx((0.9, 1.8, 0.0, 0.0))


@given(st.floats(0.1, 1.2), st.floats(0.05, 0.6), st.floats(-pi, pi), st.floats(0.01, 100.0))
def test_period_and_growth_of_a_swing_are_found(growth, period, phase, size):
    t = np.arange(0.0, 4.5 * period, 0.001)
    swing = size * growth ** (t / period) * np.cos(TURN * t / period + phase)
    found = tracking.find_oscillation(swing, 0.001)
    if isnan(found.period):
        assert growth < 0.15  # less than three half swings before a fiftieth is left
        return
    # Half swings are measured at their samples: at 50 samples a period up to 0.8 % too low.
    assert found.period == pytest.approx(period, rel=0.01)
    assert found.growth == pytest.approx(growth, rel=0.05)


@pytest.mark.parametrize(
    "error", [np.zeros(100), np.ones(100), np.exp(-np.arange(100)), [1.0, -0.5, 0.01], []]
)
def test_what_does_not_swing_has_no_period(error):
    found = tracking.find_oscillation(error, DT)
    assert isnan(found.period) and found.growth == 0.0


def test_counts_of_an_encoder_around_zero_are_no_swing_after_the_true_one():
    t = 0.01 * np.arange(400)
    swing = 0.6 ** (t / 0.2) * np.cos(TURN * t / 0.2)
    noisy = swing + np.random.default_rng(1).choice([-0.002, 0.0, 0.002], 400)
    found = tracking.find_oscillation(noisy, 0.01)
    assert found.period == pytest.approx(0.2, rel=0.02)
    assert found.growth == pytest.approx(0.6, abs=0.03)


MODEL = DifferentialModel()


def heading_error(k_p: float, first: float = 0.002, seconds: float = 2.0) -> np.ndarray:
    """Heading error of the simulated robot under a P controller, from a small one [rad]."""
    state, errors = DifferentialState.at_rest([0.0, 0.0, first]), []
    for _ in range(round(seconds / DT)):
        errors.append(-state.pose[2])
        command = tracking.wheel_speeds(0.25, k_p * errors[-1], MODEL)
        state = tracking.differential_step(state, command, DT, MODEL)
    return np.array(errors)


def exact_critical() -> tuple[float, float]:
    """The same from the eigenvalues of the loop: heading, turn rate, waiting command."""
    kept = exp(-DT / MODEL.lag)
    late = MODEL.lag * (1.0 - kept)

    def largest(k_p):
        loop = np.array([[1.0, late, DT - late], [0.0, kept, 1.0 - kept], [-k_p, 0.0, 0.0]])
        values = np.linalg.eigvals(loop)
        return values[np.argmax(np.abs(values))]

    low, high = 1.0, 1000.0
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if abs(largest(middle)) < 1.0 else (low, middle)
    return high, TURN * DT / abs(np.angle(largest(high)))


def test_the_critical_gain_found_by_experiment_is_that_of_the_loops_eigenvalues():
    found = tracking.critical_gain(heading_error, 10.0, DT)
    gain, period = exact_critical()
    # The search stops 0.5 % wide; half swings are measured at samples, 21 a period.
    assert found.gain == pytest.approx(gain, rel=0.01)
    assert found.period == pytest.approx(period, rel=0.005)
    # The robot of the source swung with 21 x 10 ms.
    assert found.period == pytest.approx(0.21, abs=0.002)


def test_the_gains_found_bring_the_robot_to_its_heading_and_half_as_much_again_shakes_it():
    gains = tracking.ziegler_nichols(*tracking.critical_gain(heading_error, 10.0, DT))

    def step(gains) -> np.ndarray:
        state, pid = DifferentialState.at_rest(), Pid(gains, PidLimits(-5.0, 5.0), wrap=True)
        headings = []
        for _ in range(200):
            turn = pid.update(0.02, state.pose[2], DT)
            command = tracking.wheel_speeds(0.25, turn, MODEL)
            state = tracking.differential_step(state, command, DT, MODEL)
            headings.append(state.pose[2])
        return np.array(headings)

    calm = step(gains)
    # Ogata: a maximum overshoot of 10 to 60 % is what these rules aim at.
    assert 1.1 < calm.max() / 0.02 < 1.8
    assert np.abs(calm[100:] - 0.02).max() < 0.05 * 0.02
    doubled = step(PidGains(2.0 * gains.k_p, gains.k_i, gains.k_d))
    assert np.abs(doubled[100:] - 0.02).max() > 10.0 * np.abs(calm[100:] - 0.02).max()


def test_a_loop_without_delay_never_oscillates_and_one_that_does_already_is_told():
    t = DT * np.arange(100)
    with pytest.raises(tracking.NoOscillationError, match="dies out at every gain up to"):
        tracking.critical_gain(lambda gain: np.exp(-gain * t), 1.0, DT, limit=100.0)
    with pytest.raises(tracking.NoOscillationError, match="start with a smaller gain"):
        tracking.critical_gain(lambda gain: np.cos(TURN * t / 0.2), 1.0, DT)


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: tracking.ziegler_nichols(0.0, 1.0), "k_cr, p_cr: expected numbers above 0"),
        (lambda: tracking.ziegler_nichols(1.0, nan), "k_cr, p_cr: expected numbers above 0"),
        (lambda: tracking.ziegler_nichols(1.0, 1.0, "PD"), "kind: expected one of P, PI, PID"),
        (lambda: tracking.find_oscillation([0.0, nan], DT), "error: entry"),
        (lambda: tracking.find_oscillation([0.0], 0.0), "dt: must be a positive number"),
        (lambda: tracking.critical_gain(heading_error, 0.0, DT), "start, factor, tolerance"),
        (lambda: tracking.critical_gain(heading_error, 1.0, DT, factor=1.0), "factor above 1"),
    ],
)
def test_experiments_that_lead_nowhere_are_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


# --- the robot to practise on -------------------------------------------------------------------


def test_a_wheel_nears_its_speed_one_step_late():
    state = DifferentialState.at_rest()
    speeds = []
    for _ in range(50):
        state = tracking.differential_step(state, [0.2, 0.2], DT, MODEL)
        speeds.append(state.speeds[0])
    assert speeds[0] == 0.0
    assert speeds[1:] == pytest.approx([0.2 * (1 - exp(-k * DT / MODEL.lag)) for k in range(1, 50)])
    rolled = 0.2 * (0.49 - MODEL.lag * (1.0 - exp(-0.49 / MODEL.lag)))
    assert state.travel == pytest.approx([rolled, rolled])
    assert state.pose == pytest.approx([rolled, 0.0, 0.0])
    assert MODEL.ticks(state).tolist() == [int(rolled / (TURN * 0.03 / 2000))] * 2


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-8.0, 8.0))
def test_the_wheels_turn_the_robot_as_told_within_their_speed(speed, turn):
    left, right = tracking.wheel_speeds(speed, turn, MODEL)
    assert max(abs(left), abs(right)) <= MODEL.max_speed + 1e-12
    got = (right - left) / MODEL.wheel_base
    assert got == pytest.approx(min(max(turn, -16 / 3), 16 / 3), abs=1e-9)
    if abs(speed) + 0.15 * abs(turn) <= MODEL.max_speed:
        assert (left + right) / 2 == pytest.approx(speed, abs=1e-9)


def test_a_wheel_goes_no_faster_than_it_can():
    state = DifferentialState.at_rest()
    for _ in range(200):
        state = tracking.differential_step(state, [5.0, -5.0], DT, MODEL)
    assert state.speeds == pytest.approx([0.8, -0.8])


def test_a_robot_that_turns_one_way_drives_a_circle():
    state = DifferentialState.at_rest()
    model = DifferentialModel(lag=1e-6)
    for _ in range(101):
        state = tracking.differential_step(
            state, [0.2 - 0.3 * pi / 4, 0.2 + 0.3 * pi / 4], 0.01, model
        )
    # Half a turn at 0.2 m/s and pi/2 rad/s would take 2 s; after 1 s it is a quarter.
    radius = 0.2 / (pi / 2)
    assert state.pose == pytest.approx([radius, radius, pi / 2], abs=2e-6)


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: DifferentialModel(lag=0.0), "lag: must be positive, got 0.0"),
        (lambda: DifferentialModel(max_speed=nan), "max_speed: must be positive"),
        (lambda: DifferentialState.at_rest([0.0, 0.0]), r"pose: expected shape \(3,\)"),
        (
            lambda: tracking.differential_step(DifferentialState.at_rest(), [0.0, nan], DT),
            "command: entry",
        ),
        (
            lambda: tracking.differential_step(DifferentialState.at_rest(), [0.0, 0.0], 0.0),
            "dt: must be a positive",
        ),
    ],
)
def test_a_robot_that_cannot_be_is_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


def test_two_huge_readings_leave_no_nan_behind():
    pid = Pid(PidGains(1.0, 1.0, 1.0, 0.1), PidLimits(-1.0, 1.0))
    for measured in (0.0, 1e308, -1e308, 0.0, 0.0, 0.5):
        assert -1.0 <= pid.update(0.0, measured, 0.01) <= 1.0
    assert pid.rejected >= 1
