"""Chapter 01: calibration, tilt and the Mahony filter."""

from __future__ import annotations

from math import exp, inf, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robocon_course import geometry, imu
from robocon_course._arrays import CourseError
from robocon_course.imu.mahony import as_memory
from robocon_course.simulator import sensors

G = 9.80665
DT = 0.01
UP = [0.0, 0.0, G]
anything = st.floats(allow_nan=True, allow_infinity=True)
compiled = settings(deadline=None)  # the first call compiles


def tilt_of(state: imu.MahonyState) -> float:
    return float(imu.inclination_error(state.quaternion, [1.0, 0.0, 0.0, 0.0]))


def rolled(angle: float) -> imu.MahonyState:
    return imu.MahonyState(geometry.quaternion_from_euler(angle, 0.0, 0.0), np.zeros(3))


def naive_mahony(gyro, accel, dt, k_p, k_i):
    """The filter once more, from its equations, with rotation matrices and arrays."""
    q, integral = imu.attitude_from_accel(accel[0]), np.zeros(3)
    rows = [q]
    for w, a in zip(gyro[1:], accel[1:], strict=True):
        rotation = np.column_stack([geometry.rotate(q, axis) for axis in np.eye(3)])
        error = np.cross(a / np.linalg.norm(a), rotation[2])
        integral = integral + k_i * error * dt
        rate = w + k_p * error + integral
        q = q + 0.5 * dt * geometry.quaternion_multiply(q, np.append(0.0, rate))
        q = q / np.linalg.norm(q)
        rows.append(q)
    return np.array(rows)


@pytest.fixture(scope="module")
def drive():
    motion = sensors.drive(30.0, DT, np.random.default_rng(8))
    gyro, accel = sensors.imu_measurements(
        *motion, DT, sensors.UNCALIBRATED, np.random.default_rng(9)
    )
    return gyro, accel, motion[0]


# --- gyroscope --------------------------------------------------------------------------------


def still_log(n=2000, bias=(0.02, -0.01, 0.005), noise=0.002, seed=1):
    return np.random.default_rng(seed).normal(bias, noise, (n, 3))


def test_calibrate_gyro_takes_the_mean_of_a_still_log():
    log = np.tile([[0.01, 0.02, 0.03], [0.03, 0.02, 0.01]], (50, 1))
    assert imu.calibrate_gyro(log).bias == pytest.approx([0.02, 0.02, 0.02])


def test_calibrate_gyro_finds_the_noise_of_one_sample_even_when_the_bias_wanders():
    log = still_log() + np.linspace(0.0, 0.005, 2000)[:, None]
    # 2000 differences: the noise is good to 1/sqrt(2 n) = 1.6 %
    assert imu.calibrate_gyro(log).noise == pytest.approx([0.002] * 3, rel=0.06)


def test_apply_subtracts_the_bias_and_keeps_holes():
    calibration = imu.GyroCalibration(np.array([1.0, 2.0, 3.0]), np.zeros(3))
    rates = calibration.apply([[1.0, 2.0, 4.0], [nan, 2.0, 3.0]])
    assert rates[0].tolist() == [0.0, 0.0, 1.0] and np.isnan(rates[1, 0])


@given(st.integers(100, 4000), st.floats(1e-6, 50.0), st.integers(0, 2**32 - 1))
def test_white_noise_of_any_size_is_no_movement(n, noise, seed):
    imu.calibrate_gyro(still_log(n, noise=noise, seed=seed))


def test_raw_counts_and_coarse_converters_are_no_movement():
    imu.calibrate_gyro(np.round(still_log(bias=(2.0, -4.0, 0.5), noise=3.0)))
    imu.calibrate_gyro(np.round(still_log(bias=(0.0, 0.4, 0.9), noise=0.3)))
    imu.calibrate_gyro(np.zeros((500, 3)))
    flicker = np.zeros((2000, 3))
    flicker[[700, 1500], 1] = 1.0  # two single counts in twenty seconds
    imu.calibrate_gyro(flicker)


@pytest.mark.parametrize("size, rows", [(0.05, 100), (0.3, 30), (-1.0, 15)])
@pytest.mark.parametrize("at", [0, 777, 1900])
def test_a_log_that_moved_is_refused_and_told_when(size, rows, at):
    log = still_log()
    log[at : at + rows, 1] += size
    with pytest.raises(imu.MovedError, match=r"axis y.*record again") as refusal:
        imu.calibrate_gyro(log)
    first, last = refusal.value.rows
    assert first <= at + rows - 1 and at <= last  # they overlap
    assert at - 60 <= first and last <= at + rows + 60  # and by little more than a block


def test_the_refusal_counts_seconds_when_told_the_sample_time():
    log = still_log()
    log[1000:1100] += 0.2
    with pytest.raises(imu.MovedError, match=r"rows 1000 to 1099 \(10\.00 s to 10\.99 s\)"):
        imu.calibrate_gyro(log, dt=0.01)


def test_movement_in_raw_counts_is_found_too():
    log = np.round(still_log(bias=(2.0, -4.0, 0.5), noise=3.0))
    log[500:600, 2] += 100.0  # 6 deg/s of a sensor with 16 counts per deg/s
    with pytest.raises(imu.MovedError):
        imu.calibrate_gyro(log)


def test_a_log_without_noise_that_moved_is_refused():
    log = np.zeros((1000, 3))
    log[400:500, 0] = 1.0
    with pytest.raises(imu.MovedError, match="rows 400 to 499"):
        imu.calibrate_gyro(log)


def test_swaying_all_the_time_is_movement():
    sway = 0.2 * np.sin(2 * pi * 0.7 * 0.01 * np.arange(2000))
    with pytest.raises(imu.MovedError):
        imu.calibrate_gyro(still_log() + sway[:, None])


@pytest.mark.parametrize("size, rows", [(0.1, 50), (5.0, 100)])
def test_shaking_that_turns_nowhere_is_movement_however_violent(size, rows):
    log = still_log()
    log[1000 : 1000 + rows, 0] += size * np.where(np.arange(rows) % 2, 1.0, -1.0)
    with pytest.raises(imu.MovedError, match="axis x"):
        imu.calibrate_gyro(log)


def test_rows_with_holes_are_left_out_and_do_not_shift_the_rows_named():
    log = still_log()
    log[100:700:2, 1] = nan
    assert imu.calibrate_gyro(log).bias == pytest.approx([0.02, -0.01, 0.005], abs=3e-4)
    log[1500:1600] += 0.5
    with pytest.raises(imu.MovedError) as refusal:
        imu.calibrate_gyro(log)
    assert abs(refusal.value.rows[0] - 1500) < 60


def test_too_few_rows_and_wrong_shapes_are_refused():
    assert issubclass(imu.MovedError, CourseError) and issubclass(imu.MovedError, ValueError)
    with pytest.raises(ValueError, match="still: 99 usable rows are too few"):
        imu.calibrate_gyro(still_log(99))
    with pytest.raises(ValueError, match=r"still: expected shape \(n, 3\), got \(3, 2000\)"):
        imu.calibrate_gyro(still_log().T)


# --- accelerometer ----------------------------------------------------------------------------

BIAS, SCALE = np.array([0.2, -0.15, 0.1]), np.array([1.01, 0.985, 1.005])
SIX = np.vstack([np.eye(3), -np.eye(3)])


def raw(directions, bias=BIAS, scale=SCALE):
    """What a sensor with these errors reads when up lies along ``directions``."""
    return G * np.asarray(directions) / scale + bias


def random_directions(n, seed=0):
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def test_six_positions_by_hand():
    rests = [[10.0, 0, 1], [-9.0, 0, 1], [0.5, 9, 1], [0.5, -9, 1], [0.5, 0, 11], [0.5, 0, -9]]
    found = imu.calibrate_accelerometer(rests)
    assert found.bias.tolist() == [0.5, 0.0, 1.0]
    assert found.scale == pytest.approx([2 * G / 19, 2 * G / 18, 2 * G / 20])


@given(st.permutations(range(6)))
def test_six_positions_in_any_order_give_bias_and_scale(order):
    found = imu.calibrate_accelerometer(raw(SIX)[order])
    np.testing.assert_allclose(found.bias, BIAS, atol=1e-12)
    np.testing.assert_allclose(found.scale, SCALE, rtol=1e-12)


def test_a_still_mean_as_bias_would_swallow_gravity_and_the_formula_does_not():
    rest = raw([[0.0, 0.0, 1.0]])
    assert np.linalg.norm(rest - rest.mean(axis=0)) == 0.0
    corrected = imu.calibrate_accelerometer(raw(SIX)).apply(rest)
    np.testing.assert_allclose(corrected, [UP], atol=1e-12)


@given(
    arrays(float, 3, elements=st.floats(-2.0, 2.0)),
    arrays(float, 3, elements=st.floats(0.7, 1.4)),
    st.sampled_from([1.0, 208.0, 1e-3]),
)
def test_fit_ellipsoid_finds_any_bias_and_scale_in_any_unit(bias, scale, unit):
    samples = raw(random_directions(40), bias, scale) * unit
    found = imu.fit_ellipsoid(samples)
    np.testing.assert_allclose(found.bias, bias * unit, atol=1e-9 * unit)
    np.testing.assert_allclose(found.scale, scale / unit, rtol=1e-9)


def test_fit_ellipsoid_needs_no_axis_ever_vertical():
    directions = imu.gravity_direction(sensors.slow_turns(DT, lean=0.3)[0])
    assert np.abs(directions).max() < 0.98
    noisy = raw(directions) + np.random.default_rng(2).normal(0, 0.02, directions.shape)
    noisy[50:60] = nan
    found = imu.fit_ellipsoid(noisy)
    # 3500 rows of 0.02 m/s^2, worsened at most 20 times: 0.007 m/s^2
    np.testing.assert_allclose(found.bias, BIAS, atol=0.005)
    np.testing.assert_allclose(found.scale, SCALE, atol=5e-4)


def test_more_than_six_rests_are_fitted():
    found = imu.calibrate_accelerometer(raw(random_directions(12)), gravity=G)
    np.testing.assert_allclose(found.bias, BIAS, atol=1e-9)


def test_scale_follows_the_gravity_given():
    found = imu.calibrate_accelerometer(raw(SIX), gravity=2 * G)
    np.testing.assert_allclose(found.scale, 2 * SCALE)
    np.testing.assert_allclose(imu.fit_ellipsoid(raw(SIX), 2 * G).scale, 2 * SCALE)


def test_six_that_are_not_two_per_axis_are_refused_with_the_way_out():
    twice_up = np.vstack([np.eye(3), np.eye(3)])
    leaning = geometry.rotate(geometry.quaternion_from_rotation_vector([0.5, 0.3, 0.2]), SIX)
    for directions in (twice_up, leaning, random_directions(6)):
        with pytest.raises(ValueError, match=r"six sides.*fit_ellipsoid"):
            imu.calibrate_accelerometer(raw(directions))


def test_directions_that_do_not_span_are_refused():
    circle = np.linspace(0, 2 * pi, 200)
    one_turn = np.column_stack([np.cos(circle), np.sin(circle), np.zeros(200)])
    tilts = geometry.quaternion_from_euler(*np.random.default_rng(1).uniform(-0.3, 0.3, (3, 500)))
    for directions in (one_turn, imu.gravity_direction(tilts), np.tile([0.0, 0.0, 1.0], (50, 1))):
        noisy = raw(directions) + np.random.default_rng(2).normal(0, 0.005, directions.shape)
        for samples in (noisy, raw(directions)):
            with pytest.raises(ValueError, match="do not span"):
                imu.fit_ellipsoid(samples)


def test_fewer_than_six_holes_and_a_foolish_gravity_are_refused():
    with pytest.raises(ValueError, match="rests: six or more are needed, got 5"):
        imu.calibrate_accelerometer(raw(SIX)[:5])
    with pytest.raises(ValueError, match=r"rests: entry \(2, 1\) is not a finite number"):
        imu.calibrate_accelerometer(np.where(np.arange(18).reshape(6, 3) == 7, nan, raw(SIX)))
    with pytest.raises(ValueError, match="samples: six or more usable rows"):
        imu.fit_ellipsoid(np.full((50, 3), nan))
    for gravity in (0.0, -G, nan, inf):
        with pytest.raises(ValueError, match="gravity: must be a positive"):
            imu.calibrate_accelerometer(raw(SIX), gravity)


# --- tilt and angles --------------------------------------------------------------------------


def test_a_level_sensor_sees_up_along_z_and_one_on_its_left_side_along_minus_y():
    assert imu.gravity_direction([1.0, 0.0, 0.0, 0.0]).tolist() == [0.0, 0.0, 1.0]
    on_left = geometry.quaternion_from_euler(-pi / 2, 0.0, 0.0)
    np.testing.assert_allclose(imu.gravity_direction(on_left), [0.0, -1.0, 0.0], atol=1e-15)


@given(arrays(float, 3, elements=st.floats(-20, 20)).filter(lambda a: np.linalg.norm(a) > 1e-3))
def test_the_tilt_from_a_sample_explains_that_sample(accel):
    tilt = imu.attitude_from_accel(accel)
    up = accel / np.linalg.norm(accel)
    np.testing.assert_allclose(imu.gravity_direction(tilt), up, atol=1e-12)
    np.testing.assert_allclose(geometry.rotate(tilt, up), [0.0, 0.0, 1.0], atol=1e-12)


@given(st.floats(-pi, pi), st.floats(-1.57, 1.57), st.floats(-pi, pi))
def test_euler_angles_undo_quaternion_from_euler(roll, pitch, yaw):
    angles = imu.euler_angles(geometry.quaternion_from_euler(roll, pitch, yaw))
    # near the pole asin loses half its digits
    assert angles[1] == pytest.approx(pitch, abs=1e-7)
    off = geometry.wrap_angle(angles[[0, 2]] - [roll, yaw])
    assert np.abs(off).max() < 1e-9 / np.cos(pitch)


def test_straight_up_the_angles_are_finite_and_their_difference_right():
    q = geometry.quaternion_from_euler(0.3, pi / 2, 0.8)
    roll, pitch, yaw = imu.euler_angles(q * (1 + 1e-15))
    assert pitch == pytest.approx(pi / 2, abs=1e-7) and np.isfinite([roll, yaw]).all()


def test_inclination_error_sees_tilt_and_is_blind_to_yaw():
    truth, turned, tilted = geometry.quaternion_from_euler([0.1, 0.1, 0.12], 0.0, [0.3, 2.0, -3.0])
    assert imu.inclination_error(turned, truth) == pytest.approx(0.0, abs=1e-12)
    assert imu.inclination_error(tilted, truth) == pytest.approx(0.02)
    assert imu.inclination_error([0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]) == pytest.approx(pi)


def test_a_sample_without_direction_has_no_tilt():
    tilt = imu.attitude_from_accel([[0.0, 0.0, 0.0], [nan, 0.0, 1.0], [inf, 0.0, 1.0], UP])
    assert np.isnan(tilt[:3]).all() and tilt[3].tolist() == [1.0, 0.0, 0.0, 0.0]


# --- one Mahony step --------------------------------------------------------------------------


def test_one_step_by_hand():
    # Upright and at rest, rolled by 0.1: e = (sin 0.1, 0, 0) pulls the roll by k_p sin(0.1) dt.
    after = imu.mahony_step(rolled(0.1), [0, 0, 0], UP, DT, imu.MahonyGains(2.0))
    assert imu.euler_angles(after.quaternion)[0] == pytest.approx(
        0.1 - 2.0 * np.sin(0.1) * DT, abs=1e-9
    )


def test_without_correction_the_gyroscope_alone_turns():
    state = imu.MahonyState.level()
    for _ in range(100):
        state = imu.mahony_step(state, [0.0, 0.0, 0.5], UP, DT, imu.MahonyGains(0.0))
    np.testing.assert_allclose(imu.euler_angles(state.quaternion), [0.0, 0.0, 0.5], atol=1e-5)


@pytest.mark.parametrize("k_p", [0.5, 1.0, 3.0])
def test_a_small_tilt_error_fades_with_time_constant_one_over_k_p(k_p):
    state, gains = rolled(0.05), imu.MahonyGains(k_p)
    for _ in range(100):
        state = imu.mahony_step(state, [0, 0, 0], UP, DT, gains)
    # Euler's (1 - k_p dt)^n differs from exp by k_p^2 t dt/2: 4.5 % at 3
    assert tilt_of(state) == pytest.approx(0.05 * exp(-k_p), rel=0.05)


def test_a_bias_leaves_a_tilt_of_bias_over_k_p_and_the_integral_learns_it():
    bias = 0.01
    proportional, integral = rolled(0.0), rolled(0.0)
    for _ in range(6000):
        proportional = imu.mahony_step(proportional, [bias, 0, 0], UP, DT, imu.MahonyGains(1.0))
        integral = imu.mahony_step(integral, [bias, 0, 0], UP, DT, imu.MahonyGains(1.0, 0.3))
    assert np.sin(tilt_of(proportional)) == pytest.approx(bias / 1.0, rel=1e-3)
    assert tilt_of(integral) < 1e-5
    np.testing.assert_allclose(integral.integral, [-bias, 0.0, 0.0], atol=1e-5)


def test_a_step_leaves_the_state_it_was_given_as_it_was():
    before = rolled(0.1)
    kept = as_memory(before)
    imu.mahony_step(before, [1.0, 2.0, 3.0], UP, DT, imu.MahonyGains(1.0, 1.0))
    assert np.array_equal(as_memory(before), kept)


@pytest.mark.parametrize("accel", [[nan, 0, G], [inf, 0, 0], [0, 0, 0], [1e200, 1e200, 0]])
def test_an_accelerometer_sample_without_direction_leaves_it_to_the_gyroscope(accel):
    state = imu.MahonyState(rolled(0.2).quaternion, np.array([0.0, 0.01, 0.0]))
    found = imu.mahony_step(state, [0.1, 0.2, 0.3], accel, DT, imu.MahonyGains(2.0, 1.0))
    alone = imu.mahony_step(state, [0.1, 0.2, 0.3], UP, DT, imu.MahonyGains(0.0, 0.0))
    assert np.array_equal(as_memory(found), as_memory(alone))


@pytest.mark.parametrize("gyro", [[nan, 0, 0], [0, inf, 0], [0, 0, -inf], [1e300, 1e300, 0]])
def test_a_gyroscope_sample_that_is_not_finite_leaves_the_state_alone(gyro):
    state = rolled(0.2)
    after = imu.mahony_step(state, gyro, UP, DT, imu.MahonyGains(1.0, 1.0))
    assert np.array_equal(as_memory(after), as_memory(state))


def test_the_gate_keeps_pushes_out():
    pushed = [3.0, 0.0, G]  # 0.45 m/s^2 longer than gravity
    gated = imu.mahony_step(rolled(0.0), [0, 0, 0], pushed, DT, imu.MahonyGains(1.0, 0.0, 0.4))
    open_ = imu.mahony_step(rolled(0.0), [0, 0, 0], pushed, DT, imu.MahonyGains(1.0, 0.0, 0.5))
    assert tilt_of(gated) == 0.0 and tilt_of(open_) > 0.0


@compiled
@given(arrays(float, 3, elements=anything), arrays(float, 3, elements=anything), st.floats(1e-6, 1))
def test_no_reading_whatever_raises_or_spoils_the_state(gyro, accel, dt):
    after = imu.mahony_step(rolled(0.3), gyro, accel, dt, imu.MahonyGains(1.0, 0.1))
    assert np.linalg.norm(after.quaternion) == pytest.approx(1.0)
    assert np.isfinite(after.integral).all()


def test_the_kernel_as_plain_python_gives_the_same_numbers(drive):
    plain = getattr(imu.mahony_update, "py_func", imu.mahony_update)  # NUMBA_DISABLE_JIT=1
    compiled_state, plain_state = as_memory(rolled(0.1)), as_memory(rolled(0.1))
    for gyro, accel in zip(drive[0][:200], drive[1][:200], strict=True):
        imu.mahony_update(compiled_state, gyro, accel, DT, 1.0, 0.3, inf)
        plain(plain_state, gyro, accel, DT, 1.0, 0.3, inf)
    np.testing.assert_allclose(compiled_state, plain_state, atol=1e-13)


def test_wrong_shapes_times_and_gains_are_refused_by_name():
    level = imu.MahonyState.level()
    with pytest.raises(ValueError, match=r"gyro: expected shape \(3,\), got \(4,\)"):
        imu.mahony_step(level, np.zeros(4), UP, DT)
    with pytest.raises(ValueError, match=r"accel: expected shape \(3,\), got \(1, 3\)"):
        imu.mahony_step(level, np.zeros(3), [UP], DT)
    with pytest.raises(ValueError, match=r"state.quaternion: expected shape \(4,\)"):
        imu.mahony_step(imu.MahonyState(np.zeros(3), np.zeros(4)), np.zeros(3), UP, DT)
    with pytest.raises(ValueError, match="accel: expected numbers"):
        imu.mahony_step(level, np.zeros(3), "up", DT)
    for dt in (0.0, -DT, nan, inf):
        with pytest.raises(ValueError, match="dt: must be a positive number of seconds"):
            imu.mahony_step(level, np.zeros(3), UP, dt)
    for gains in (imu.MahonyGains(-1.0), imu.MahonyGains(1.0, nan), imu.MahonyGains(gate=-1.0)):
        with pytest.raises(ValueError, match="gains: k_p, k_i and gate"):
            imu.mahony_step(level, np.zeros(3), UP, DT, gains)


# --- a whole log ------------------------------------------------------------------------------


@pytest.mark.parametrize("k_i", [0.0, 0.2])
def test_the_filter_agrees_with_its_naive_twin(drive, k_i):
    gyro, accel = drive[0][:1500], drive[1][:1500]
    log = imu.estimate_attitude(gyro, accel, DT, gains=imu.MahonyGains(0.8, k_i))
    twin = naive_mahony(gyro, accel, DT, 0.8, k_i)
    np.testing.assert_allclose(log.quaternions, twin, atol=1e-9)


def test_the_filter_agrees_with_the_ahrs_package(drive):
    ahrs = pytest.importorskip("ahrs", reason="the peer comes with the extra 'bench'")
    gyro, accel, _ = drive
    peer = ahrs.filters.Mahony(gyro, accel, frequency=1.0 / DT, k_P=1.2, k_I=0.3)
    log = imu.estimate_attitude(gyro, accel, DT, gains=imu.MahonyGains(1.2, 0.3))
    np.testing.assert_allclose(log.quaternions, peer.Q, atol=1e-9)


def spoilt(drive):
    gyro, accel = drive[0].copy(), drive[1].copy()
    gyro[100:110, 1], accel[200:230], accel[300] = nan, nan, 0.0
    return gyro, accel


def test_log_stream_and_steps_give_the_same_rows(drive):
    gyro, accel = spoilt(drive)
    gains = imu.MahonyGains(0.7, 0.1, 0.4)
    log = imu.estimate_attitude(gyro, accel, DT, gains=gains)
    stream = imu.AttitudeFilter(gains)
    rows = np.array([stream.update(g, a, DT) for g, a in zip(gyro, accel, strict=True)])
    state, steps = imu.MahonyState(log.quaternions[0], np.zeros(3)), [log.quaternions[0]]
    for g, a in zip(gyro[1:], accel[1:], strict=True):
        state = imu.mahony_step(state, g, a, DT, gains)
        steps.append(state.quaternion)
    assert np.array_equal(log.quaternions, rows) and np.array_equal(log.quaternions, steps)
    assert log.rejected == stream.rejected > 41


def test_rejected_counts_the_samples_not_fully_used(drive):
    assert imu.estimate_attitude(*drive[:2], DT).rejected == 0
    assert imu.estimate_attitude(*spoilt(drive), DT).rejected == 10 + 30 + 1


def test_a_gap_is_bridged_by_the_gyroscope(drive):
    gyro, accel, truth = drive
    gap = accel.copy()
    gap[1000:1100] = nan
    error = imu.inclination_error(imu.estimate_attitude(gyro, gap, DT).quaternions, truth)
    # one second of the bias, 0.5 deg/s, on top of what the pushes do anyway
    whole = imu.inclination_error(imu.estimate_attitude(gyro, accel, DT).quaternions, truth)
    assert np.degrees(error[1000:1100].max()) < np.degrees(whole.max()) + 0.7


def test_the_first_row_is_the_tilt_of_the_first_sample_and_its_rate_is_not_used():
    log = imu.estimate_attitude([[9.0, 9.0, 9.0]], [[0.0, 1.0, 1.0]], DT)
    assert (log.roll[0], log.pitch[0], log.yaw[0]) == pytest.approx((pi / 4, 0.0, 0.0))


def test_with_an_initial_attitude_the_first_sample_is_a_step():
    start = geometry.quaternion_from_euler(0.1, 0.2, 0.3)
    log = imu.estimate_attitude([[0.1, 0.2, 0.3]], [UP], DT, initial=start)
    state = imu.MahonyState(start, np.zeros(3))
    step = imu.mahony_step(state, [0.1, 0.2, 0.3], UP, DT)
    np.testing.assert_allclose(log.quaternions[0], step.quaternion, atol=1e-15)


def test_a_late_accelerometer_starts_level_and_gives_the_tilt_when_it_comes():
    accel = np.tile([0.0, G, G], (10, 1))
    accel[:4] = nan
    log = imu.estimate_attitude(np.zeros((10, 3)), accel, DT)
    assert log.roll[3] == 0.0 and log.roll[4] == pytest.approx(pi / 4)
    assert log.rejected == 4


def test_a_log_without_any_accelerometer_follows_the_gyroscope():
    log = imu.estimate_attitude(np.tile([0, 0, 1.0], (100, 1)), np.full((100, 3), nan), DT)
    assert log.yaw[-1] == pytest.approx(1.0, abs=1e-4) and log.rejected == 100


def test_uneven_time_steps_are_used_one_by_one():
    dt = np.random.default_rng(4).uniform(0.002, 0.03, 500)
    dt[40] = 0.0  # two rows with one time stamp
    log = imu.estimate_attitude(np.tile([0, 0, 0.4], (500, 1)), np.tile(UP, (500, 1)), dt)
    assert np.unwrap(log.yaw)[-1] == pytest.approx(0.4 * dt[1:].sum(), abs=1e-4)


def test_an_accelerometer_in_any_unit_gives_the_same_attitude(drive):
    gyro, accel, _ = drive
    in_g = imu.estimate_attitude(gyro, accel / G, DT).quaternions
    np.testing.assert_allclose(imu.estimate_attitude(gyro, accel, DT).quaternions, in_g, atol=1e-12)


def test_an_empty_log_gives_an_empty_attitude():
    assert imu.estimate_attitude(np.empty((0, 3)), np.empty((0, 3)), DT).yaw.shape == (0,)


def test_logs_that_do_not_fit_together_are_refused():
    two = np.zeros((2, 3))
    with pytest.raises(ValueError, match=r"accel: expected shape \(2, 3\), got \(3, 3\)"):
        imu.estimate_attitude(two, np.zeros((3, 3)), DT)
    with pytest.raises(ValueError, match=r"dt: expected shape \(2,\), got \(3,\)"):
        imu.estimate_attitude(two, two, [DT] * 3)
    with pytest.raises(ValueError, match=r"dt: is -0.01 s in row 1; sort"):
        imu.estimate_attitude(two, two, [DT, -DT])
    for dt in (0.0, nan, inf):
        with pytest.raises(ValueError, match="dt: must be a positive number"):
            imu.estimate_attitude(two, two, dt)
    with pytest.raises(ValueError, match="initial: must be a unit quaternion"):
        imu.estimate_attitude(two, two, DT, initial=[2.0, 0.0, 0.0, 0.0])


# --- a stream ---------------------------------------------------------------------------------


def test_half_a_log_saved_and_restored_continues_to_the_bit(drive):
    gyro, accel, gains = *spoilt(drive), imu.MahonyGains(1.0, 0.2)
    whole = imu.estimate_attitude(gyro, accel, DT, gains=gains).quaternions
    first = imu.AttitudeFilter(gains)
    for g, a in zip(gyro[:1500], accel[:1500], strict=True):
        first.update(g, a, DT)
    saved = first.state
    first.update([1.0, 1.0, 1.0], UP, DT)  # what happens after saving must not matter
    second = imu.AttitudeFilter(gains)
    second.state = saved
    rows = [second.update(g, a, DT) for g, a in zip(gyro[1500:], accel[1500:], strict=True)]
    assert np.array_equal(rows, whole[1500:])


def test_a_filter_that_has_seen_nothing_has_no_state_and_can_be_put_back_there():
    stream = imu.AttitudeFilter()
    assert stream.state is None
    stream.update([0, 0, 0], [0.0, G, 0.0], DT)
    stream.state = None
    again = stream.update([0, 0, 0], [0.0, -G, 0.0], DT)
    assert imu.euler_angles(again)[0] == pytest.approx(-pi / 2)


def test_a_filter_with_an_initial_attitude_steps_from_it():
    start = geometry.quaternion_from_euler(0.0, 0.0, 1.0)
    assert imu.euler_angles(imu.AttitudeFilter(initial=start).update([0, 0, 0], UP, DT))[2] == 1.0


def test_a_time_step_that_is_no_time_is_counted_and_bridged():
    stream = imu.AttitudeFilter()
    kept = stream.update([0, 0, 0], UP, DT)
    for dt in (0.0, -1.0, nan, inf):
        assert np.array_equal(stream.update([1.0, 1.0, 1.0], UP, dt), kept)
    assert stream.rejected == 4


def test_the_attitude_handed_out_is_a_copy():
    stream = imu.AttitudeFilter()
    stream.update([0, 0, 0], UP, DT)[:] = 7.0
    stream.state.quaternion[:] = 7.0
    assert stream.state.quaternion.tolist() == [1.0, 0.0, 0.0, 0.0]


# --- what the printed source says -------------------------------------------------------------


@pytest.mark.parametrize("true_deg, reads_deg", [(20.0, 10.3), (45.0, 26.6)])
def test_half_of_one_component_of_gravity_settles_at_half_the_tangent(true_deg, reads_deg):
    """Printed: v_x and v_y in full beside v_z = w^2 - 1/2 + z^2, which is half."""

    def settled(third):
        q, accel = np.array([1.0, 0, 0, 0]), imu.gravity_direction(rolled(np.radians(true_deg))[0])
        for _ in range(3000):
            up = imu.gravity_direction(q)
            up[2] = third(q)
            rate = np.cross(accel, up)
            q = q + 0.5 * DT * geometry.quaternion_multiply(q, np.append(0.0, rate))
            q = q / np.linalg.norm(q)
        return np.degrees(imu.euler_angles(q)[0])

    printed = settled(lambda q: q[0] ** 2 - 0.5 + q[3] ** 2)
    assert printed == pytest.approx(reads_deg, abs=0.05)
    assert np.tan(np.radians(printed)) == pytest.approx(np.tan(np.radians(true_deg)) / 2, rel=1e-6)
    assert settled(lambda q: 2 * (q[0] ** 2 - 0.5 + q[3] ** 2)) == pytest.approx(true_deg, abs=1e-6)


@pytest.mark.parametrize("gap", [3.0, 10.0, 60.0])
def test_after_a_gap_one_sample_does_not_throw_the_tilt_past_gravity(gap):
    leaning = [0.0, np.sin(np.radians(20)), np.cos(np.radians(20))]
    state = imu.mahony_step(imu.MahonyState.level(), np.zeros(3), leaning, gap)
    assert 0.0 < np.degrees(imu.euler_angles(state.quaternion)[0]) <= 20.0


def test_a_slow_turn_is_refused_however_noisy_the_sensor():
    log = np.random.default_rng(3).normal(0.0, 0.02, (2000, 3))
    log[600:1100, 2] += np.radians(3.0)
    with pytest.raises(imu.MovedError):
        imu.calibrate_gyro(log)


def test_fit_ellipsoid_refuses_a_sensor_that_lay_still():
    rng = np.random.default_rng(4)
    with pytest.raises(ValueError, match=r"do not lie on an ellipsoid|span"):
        imu.fit_ellipsoid(rng.normal([0.0, 0.0, G], 0.005, (2000, 3)))
