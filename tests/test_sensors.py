"""The simulated IMU, the motions it records, and the recordings of data/imu."""

from __future__ import annotations

import runpy
from dataclasses import replace
from math import pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from robocon_course import geometry, imu
from robocon_course.simulator import sensors

DATA = Path(__file__).resolve().parents[1] / "data" / "imu"
DT = 0.01
PERFECT = sensors.ImuErrors(
    gyro_bias=(0.0, 0.0, 0.0),
    gyro_noise_density=0.0,
    gyro_walk=0.0,
    accel_noise_density=0.0,
    gyro_resolution=1e-12,
    accel_resolution=1e-12,
)


def measured(motion, errors=PERFECT, seed=0):
    return sensors.imu_measurements(*motion, DT, errors, np.random.default_rng(seed))


MOTIONS = {
    "still": sensors.still(5.0, DT, geometry.quaternion_from_euler(0.1, 0.2, 0.3)),
    "slow turns": sensors.slow_turns(DT),
    "leaning turns": sensors.slow_turns(DT, lean=0.2),
    "drive": sensors.drive(60.0, DT, np.random.default_rng(5)),
}


def test_a_perfect_sensor_at_rest_reads_no_rate_and_gravity_upwards():
    gyro, accel = measured(sensors.still(1.0, DT))
    np.testing.assert_allclose(gyro, 0.0, atol=1e-12)
    np.testing.assert_allclose(accel, np.tile([0.0, 0.0, sensors.GRAVITY], (100, 1)), atol=1e-11)


def test_speeding_up_forward_reads_on_the_x_axis_whichever_way_the_robot_faces():
    facing_left = geometry.quaternion_from_euler(0.0, 0.0, pi / 2)
    _, accel = measured((np.tile(facing_left, (3, 1)), np.tile([0.0, 2.0, 0.0], (3, 1))))
    np.testing.assert_allclose(accel[0], [2.0, 0.0, sensors.GRAVITY], atol=1e-9)


def test_a_turn_to_the_left_reads_positive_on_the_z_axis():
    yaw = 0.5 * DT * np.arange(4)
    gyro, _ = measured((geometry.quaternion_from_euler(0.0, 0.0, yaw), np.zeros((4, 3))))
    np.testing.assert_allclose(gyro, np.tile([0.0, 0.0, 0.5], (4, 1)), atol=1e-11)


@pytest.mark.parametrize("name", MOTIONS)
def test_the_rates_lead_from_each_true_attitude_to_the_next(name):
    quaternions, _ = motion = MOTIONS[name]
    gyro, _ = measured(motion)
    steps = geometry.quaternion_from_rotation_vector(gyro[1:] * DT)
    reached = geometry.quaternion_multiply(quaternions[:-1], steps)
    np.testing.assert_allclose(np.abs((reached * quaternions[1:]).sum(axis=1)), 1.0, atol=1e-12)


@pytest.mark.parametrize("name", MOTIONS)
def test_the_filter_on_a_perfect_gyroscope_follows_the_truth(name):
    quaternions, _ = motion = MOTIONS[name]
    log = imu.estimate_attitude(*measured(motion), DT, gains=imu.MahonyGains(0.0))
    error = imu.inclination_error(log.quaternions, quaternions)
    assert np.degrees(error.max()) < 0.01


def test_the_filter_with_accelerometer_lags_slow_turns_by_one_sample_at_most():
    # The accelerometer of sample k meets the attitude of sample k - 1: fastest rate * dt, 0.11 deg.
    quaternions, _ = motion = sensors.slow_turns(DT, turn=60.0)
    log = imu.estimate_attitude(*measured(motion), DT, gains=imu.MahonyGains(1.0))
    assert np.degrees(imu.inclination_error(log.quaternions, quaternions).max()) < 0.12


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_are_smooth_and_their_quaternions_unit(name):
    quaternions, accelerations = motion = MOTIONS[name]
    gyro, _ = measured(motion)
    np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-12)
    assert np.abs(np.diff(gyro, axis=0)).max() < 10.0 * DT  # rad/s^2
    assert np.abs(np.diff(accelerations, axis=0)).max() < 25.0 * DT  # m/s^3


def test_gravity_passes_over_every_axis_up_and_down_in_slow_turns():
    up = imu.gravity_direction(MOTIONS["slow turns"][0])
    assert up.max(axis=0).min() > 0.999 and up.min(axis=0).max() < -0.999


def test_no_axis_is_vertical_in_leaning_turns():
    assert np.abs(imu.gravity_direction(MOTIONS["leaning turns"][0])).max() < np.cos(0.1)


def test_a_drive_turns_pushes_and_climbs_two_ramps():
    quaternions, accelerations = MOTIONS["drive"]
    tilt = imu.inclination_error(quaternions, [1.0, 0.0, 0.0, 0.0])
    climbing = np.diff((tilt > 0.99 * sensors.RAMP).astype(int))
    assert tilt.max() == pytest.approx(sensors.RAMP, abs=1e-6)
    assert (climbing == 1).sum() == 2
    assert 2.0 < np.abs(accelerations[:, :2]).max() <= 3.01
    assert np.ptp(np.unwrap(imu.euler_angles(quaternions)[:, 2])) > 1.0


def test_a_drive_stays_on_its_half_of_the_field():
    _, accelerations = MOTIONS["drive"]
    place = 0.5 + (accelerations[:, :2].cumsum(axis=0) * DT).cumsum(axis=0) * DT
    assert place.min() > 0.4 and (place.max(axis=0) < [5.6, 11.7]).all()


def test_noise_per_sample_is_density_times_root_of_half_the_rate():
    gyro, accel = measured(sensors.still(100.0, DT), sensors.ImuErrors(gyro_walk=0.0))
    # 30 000 draws: the sample sigma is good to 0.4 %; rounding adds step^2/12.
    for reading, density, step in (
        (gyro, np.radians(0.0038), np.radians(1 / 65.5)),
        (accel, 70e-6 * 9.80665, 9.80665 / 8192),
    ):
        wanted = sqrt(density**2 * 50.0 + step**2 / 12.0)
        assert reading.std(axis=0).mean() == pytest.approx(wanted, rel=0.02)


def test_the_calibration_undoes_bias_and_scale():
    errors = replace(PERFECT, accel_bias=(0.2, -0.1, 0.3), accel_scale=(1.02, 0.97, 1.0))
    _, accel = measured(MOTIONS["drive"], errors)
    found = imu.AccelerometerCalibration(np.array(errors.accel_bias), np.array(errors.accel_scale))
    np.testing.assert_allclose(found.apply(accel), measured(MOTIONS["drive"])[1], atol=1e-9)


def test_a_turn_faster_than_the_range_reads_the_range():
    yaw = 20.0 * DT * np.arange(10)  # 1146 deg/s
    motion = geometry.quaternion_from_euler(0.0, 0.0, yaw), np.full((10, 3), 100.0)
    gyro, accel = measured(motion, sensors.ImuErrors())
    assert gyro[:, 2] == pytest.approx(np.radians(500.0), abs=sensors.ImuErrors().gyro_resolution)
    assert accel[:, 2] == pytest.approx(4 * sensors.GRAVITY)


def test_readings_are_whole_steps_and_carry_no_negative_zero():
    errors = sensors.ImuErrors()
    gyro, accel = measured(sensors.still(5.0, DT), errors)
    for reading, step in ((gyro, errors.gyro_resolution), (accel, errors.accel_resolution)):
        np.testing.assert_allclose(reading / step, np.round(reading / step), atol=1e-9)
        assert not np.signbit(reading[reading == 0.0]).any()


def test_a_quaternion_and_its_negative_are_one_attitude():
    quaternions, accelerations = MOTIONS["drive"]
    signs = np.where(np.arange(len(quaternions)) % 3 == 0, -1.0, 1.0)[:, None]
    for one, other in zip(
        measured((quaternions, accelerations)), measured((signs * quaternions, accelerations)),
        strict=True,
    ):  # fmt: skip
        np.testing.assert_allclose(one, other, atol=1e-9)


def test_the_same_seed_gives_the_same_log_and_another_seed_another():
    first, again, other = (
        measured(MOTIONS["still"], sensors.ImuErrors(), seed)[0] for seed in (1, 1, 2)
    )
    assert np.array_equal(first, again) and not np.array_equal(first, other)


def test_a_last_bit_of_difference_in_the_motion_leaves_the_log_to_the_bit():
    quaternions, accelerations = MOTIONS["drive"]
    log = measured((quaternions, accelerations), sensors.UNCALIBRATED)
    other = measured((np.nextafter(quaternions, 2.0), accelerations), sensors.UNCALIBRATED)
    assert np.array_equal(log[0], other[0]) and np.array_equal(log[1], other[1])


def test_wrong_lengths_times_and_holes_are_refused():
    quaternions, accelerations = sensors.still(1.0, DT)
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"accelerations: expected shape \(100, 3\)"):
        sensors.imu_measurements(quaternions, accelerations[1:], DT, PERFECT, rng)
    with pytest.raises(ValueError, match="dt: must be a positive"):
        sensors.imu_measurements(quaternions, accelerations, 0.0, PERFECT, rng)
    with pytest.raises(ValueError, match=r"errors.gyro_bias: expected shape \(3,\)"):
        errors = replace(PERFECT, gyro_bias=(0.1, 0.2))
        sensors.imu_measurements(quaternions, accelerations, DT, errors, rng)
    with pytest.raises(ValueError, match="duration: must be a positive"):
        sensors.still(-1.0, DT)
    with pytest.raises(ValueError, match="hold no sample"):
        sensors.drive(0.001, DT, rng)
    with pytest.raises(ValueError, match="turn: must be a positive"):
        sensors.slow_turns(DT, turn=float("nan"))


def test_a_single_sample_is_a_log_too():
    for motion in (sensors.still(DT, DT), sensors.drive(DT, DT, np.random.default_rng(0))):
        gyro, accel = measured(motion)
        assert gyro.shape == accel.shape == (1, 3)


# --- the recordings ---------------------------------------------------------------------------


def column(name: str, *columns: str) -> np.ndarray:
    table = np.genfromtxt(DATA / name, delimiter=",", names=True)
    return np.column_stack([table[column] for column in columns])


def test_the_script_makes_the_recordings_again_to_the_byte(tmp_path):
    runpy.run_path(str(DATA / "make.py"))["main"](tmp_path)
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(path.name for path in DATA.glob("*.csv"))
    for name in made:
        assert (tmp_path / name).read_bytes() == (DATA / name).read_bytes(), name


def test_the_recordings_show_the_truth_that_their_readme_tells():
    still, turns = imu.read_log(DATA / "still.csv"), imu.read_log(DATA / "turns.csv")
    gyro = imu.calibrate_gyro(still.gyro, dt=DT)
    accel = imu.fit_ellipsoid(turns.accel)
    # 2000 rows of 0.027 deg/s: the mean is good to 0.0006 deg/s, and the bias wanders by as much.
    np.testing.assert_allclose(np.degrees(gyro.bias), [0.5, -0.4, 0.3], atol=0.003)
    np.testing.assert_allclose(accel.bias / 9.80665 * 1e3, [20.0, -15.0, 10.0], atol=0.2)
    np.testing.assert_allclose(accel.scale, [1.010, 0.985, 1.005], atol=2e-4)


def test_the_moved_recording_is_refused_with_its_second():
    with pytest.raises(imu.MovedError, match=r"12\.\d+ s to 12\.\d+ s"):
        imu.calibrate_gyro(imu.read_log(DATA / "moved.csv").gyro, dt=DT)


def test_the_six_rests_laid_by_hand_give_the_scale_to_a_tenth_of_a_per_cent():
    log, side = imu.read_log(DATA / "rests.csv"), column("rests.csv", "side")[:, 0]
    rests = [log.accel[side == k].mean(axis=0) for k in range(1, 7)]
    found = imu.calibrate_accelerometer(rests)
    np.testing.assert_allclose(found.scale, [1.010, 0.985, 1.005], rtol=0.0012)  # 1 - cos(2.8 deg)
    np.testing.assert_allclose(found.bias / 9.80665 * 1e3, [20.0, -15.0, 10.0], atol=0.6)


def test_calibration_turns_a_drift_of_18_degrees_into_a_tenth():
    log, truth = imu.read_log(DATA / "drive.csv"), column("drive.csv", "q_w", "q_x", "q_y", "q_z")
    gyro = imu.calibrate_gyro(imu.read_log(DATA / "still.csv").gyro)
    drift = []
    for rates in (log.gyro, gyro.apply(log.gyro)):
        yaw = imu.estimate_attitude(rates, log.accel, log.dt).yaw
        drift.append(np.degrees(geometry.wrap_angle(yaw - imu.euler_angles(truth)[:, 2])[-1]))
    # 0.3 deg/s for 60 s, plus what the accelerometer's own error lets through
    assert drift[0] == pytest.approx(18.0, abs=2.0)
    assert abs(drift[1]) < 0.3
