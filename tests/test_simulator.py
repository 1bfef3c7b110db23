"""The simulated robot as its user meets it: readings, commands, time, seeds."""

from __future__ import annotations

import gc
import time
import tracemalloc
from dataclasses import replace
from math import pi, radians, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course import beams, field, geometry, odometry, raycast, swerve
from robocon_course.robot import (
    DEAD_WHEELS,
    LIDARS,
    MODULES,
    Command,
    LidarReading,
    decode_lidar,
    encode_lidar,
)
from robocon_course.simulator import (
    IDEAL,
    RobotModel,
    SensorModel,
    Simulator,
    lidar,
    machine,
    noise,
    sensors,
    warm,
)

OPEN = (3.0, 1.6, 0.0)
AHEAD = np.zeros(4)
GOAL = (*field.AREA_3_GOAL, 0.0)


def drive(robot, seconds, speeds=0.0, angles=0.0, dt=0.01):
    """Every observation and truth on the way."""
    robot.apply(Command(np.zeros(4) + speeds, np.zeros(4) + angles))
    seen, truths = [], []
    for _ in range(round(seconds / dt)):
        robot.step(dt)
        seen.append(robot.read())
        truths.append(robot.truth)
    return seen, truths


def wander(robot, seed, seconds=5.0, dt=0.01, speed=1.0):
    """A drive with a new twist every quarter of a second, which the modules carry together."""
    rng = np.random.default_rng(seed)
    seen, truths, angles = [], [], AHEAD
    for _ in range(round(seconds / 0.25)):
        twist = rng.uniform(-speed, speed, 3) * (1.0, 1.0, 2.0)
        speeds, angles = swerve.module_targets(MODULES, twist, angles)
        part = drive(robot, 0.25, speeds, angles, dt)
        seen, truths = seen + part[0], truths + part[1]
    return seen, truths


def same(one, other):
    """Whether two observations agree to the bit."""
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


# --- ready to use --------------------------------------------------------------------------------


def test_it_is_ready_as_built_at_the_start_of_robot_2():
    robot = Simulator()
    seen, truth = robot.read(), robot.truth
    assert seen.time == truth.time == 0.0
    assert truth.pose.tolist() == [*field.START, 0.0] and not truth.contact
    assert seen.ticks.tolist() == [0, 0, 0] and seen.ticks.dtype == np.int64
    assert seen.gyro.shape == seen.accel.shape == (0, 3) and seen.imu_time.shape == (0,)
    assert len(seen.lidar) == len(LIDARS) and seen.battery == 24.0


def test_half_a_metre_a_second_ahead():
    robot = Simulator(sensors=IDEAL, start=OPEN)
    drive(robot, 0.5, 0.5)
    ticks, pose = robot.read().ticks, robot.truth.pose
    seen, _ = drive(robot, 1.0, 0.5)
    np.testing.assert_allclose(robot.truth.pose - pose, [0.5, 0.0, 0.0], atol=1e-4)
    counts = 0.5 / (2 * pi * 0.0296028) * 3200
    np.testing.assert_allclose(seen[-1].ticks - ticks, [counts, counts, 0.0], atol=1.5)
    np.testing.assert_allclose(seen[-1].module_speeds, 0.5, atol=1e-4)


def test_time_passes_as_asked_and_a_remainder_is_kept():
    robot = Simulator()
    for dt in (0.01, 0.003, 0.0005, 0.0005, 1.0):
        robot.step(dt)
    assert robot.time == pytest.approx(1.014, abs=1e-12)
    assert robot.read().time == robot.truth.time == robot.time


def test_steps_too_short_to_move_by_add_up():
    robot = Simulator()
    for _ in range(1000):
        robot.step(1e-9)  # half a millionth of a tick
    assert robot.time == pytest.approx(1e-6, abs=2e-9)
    robot.reset()
    robot.step(1e-9)
    robot.reset()
    assert robot.time == 0.0


def test_ten_short_steps_are_one_long_step():
    runs = []
    for dts in ([0.1], [0.01] * 10, [0.004, 0.006, 0.09]):
        robot = Simulator()
        robot.reset(5)
        for angle in (0.0, 0.5, 2.0):
            robot.apply(Command([1.0, 0.5, 0.8, 1.0], [angle, 0.2, 0.3, 1.0]))
            for dt in dts:
                robot.step(dt)
        runs.append((robot.read(), robot.truth))
    for seen, truth in runs[1:]:
        assert same(seen, runs[0][0]) and same(truth, runs[0][1])
    assert len(runs[0][0].gyro) == 30


def test_steps_off_the_grid_come_to_nearly_the_same():
    poses = []
    for dt, count in ((0.01, 100), (1 / 60, 60), (0.0007, 1429)):
        robot = Simulator(sensors=IDEAL, start=OPEN)
        robot.apply(Command([0.5, 0.6, 0.7, 0.6], [0.3] * 4))
        for _ in range(count):
            robot.step(dt)
        poses.append(robot.truth.pose)
    np.testing.assert_allclose(poses, poses[:1] * 3, atol=2e-3)  # the last one ends 0.3 ms later


# --- the same again ------------------------------------------------------------------------------


def test_the_same_seed_gives_the_same_run_to_the_bit_and_another_seed_another():
    robot = Simulator()
    runs = []
    for seed in (3, 3, 4):
        robot.reset(seed)
        runs.append(wander(robot, 0, 2.0))
    assert all(same(a, b) for a, b in zip(runs[0][0], runs[1][0], strict=True))
    assert all(same(a, b) for a, b in zip(runs[0][1], runs[1][1], strict=True))
    assert all(same(a, c) for a, c in zip(runs[0][1], runs[2][1], strict=True))
    assert not any(same(a, c) for a, c in zip(runs[0][0], runs[2][0], strict=True))


def test_reset_forgets_everything():
    used, fresh = Simulator(), Simulator()
    wander(used, 1, 1.0)
    used.apply(Command([9.0] * 4, [1.0] * 4))
    used.reset(0)
    assert same(used.read(), fresh.read()) and same(used.truth, fresh.truth) and used.clamped == 0
    seen = drive(used, 0.1)[0], drive(fresh, 0.1)[0]
    assert all(same(a, b) for a, b in zip(*seen, strict=True))


def test_reading_more_often_or_never_changes_nothing():
    quiet, busy = Simulator(), Simulator()
    for robot in (quiet, busy):
        robot.reset(9, OPEN)
        robot.apply(Command([0.4] * 4, [1.0] * 4))
    gyro = []
    for _ in range(200):
        quiet.step(0.01)
        busy.step(0.01)
        gyro += [busy.read().gyro, busy.read().gyro]
        assert busy.truth.time == quiet.time
    last, late = busy.read(), quiet.read()
    assert last.lidar == late.lidar and same(busy.truth, quiet.truth)
    assert np.array_equal(np.concatenate(gyro), late.gyro) and len(late.gyro) == 200


def test_what_is_handed_out_is_a_copy():
    robot = Simulator()
    drive(robot, 0.1, 0.5)
    truth = robot.truth
    for array in (truth.pose, truth.travel, truth.module_angles, truth.module_speeds):
        array += 1.0
    before = robot.read()
    for array in (before.ticks, before.module_angles, before.module_speeds):
        array += 1
    after = robot.read()
    assert robot.truth.pose[0] < 0.7 and (after.ticks == before.ticks - 1).all()
    assert (after.module_angles == before.module_angles - 1).all()


def test_a_command_stays_as_it_was_given():
    speeds = np.full(4, 0.5)
    robot = Simulator()
    robot.apply(Command(speeds, AHEAD))
    speeds[:] = -0.5
    robot.step(0.5)
    assert robot.truth.twist[0] > 0.4


# --- dead wheels ---------------------------------------------------------------------------------


def test_counters_are_the_floor_of_the_continuous_travel():
    robot = Simulator(start=OPEN)
    seen, truths = wander(robot, 2)
    for one, truth in zip(seen, truths, strict=True):
        exact = truth.travel / DEAD_WHEELS.metres_per_tick
        assert ((one.ticks <= exact) & (exact < one.ticks + 1)).all()
    assert min(one.ticks.min() for one in seen) < 0


@pytest.mark.parametrize("seed", range(3))
def test_the_robot_s_odometry_follows_the_truth_on_the_flat(seed):
    robot = Simulator(sensors=IDEAL, start=OPEN)
    start = robot.truth.pose
    seen, truths = wander(robot, seed)
    ticks = np.diff([(0, 0, 0), *(one.ticks for one in seen)], axis=0)
    deltas = odometry.body_deltas(DEAD_WHEELS, odometry.wheel_travel(DEAD_WHEELS, ticks))
    poses = odometry.integrate(deltas, start)[1:]
    assert not any(truth.contacts for truth in truths)
    way = np.abs(np.diff([truth.pose for truth in truths], axis=0)).sum(axis=0)
    assert (way > 1.0).all(), "it has to drive both ways and turn"
    # a count is 0.058 mm; over the track width it is 0.1 mrad
    np.testing.assert_allclose(poses, [truth.pose for truth in truths], atol=5e-4)


def test_a_worn_wheel_counts_more_and_only_it():
    worn = replace(RobotModel(), dead_wheels=replace(DEAD_WHEELS, radius=[0.029, 0.0296028, 0.03]))
    for model, share in ((RobotModel(), 1.0), (worn, 0.0296028 / 0.029)):
        ticks = drive(Simulator(model, sensors=IDEAL, start=OPEN), 1.0, 1.0)[0][-1].ticks
        assert ticks[0] / ticks[1] == pytest.approx(share, abs=2e-4)


def test_on_the_ramp_the_dead_wheels_roll_along_the_slope():
    robot = Simulator(sensors=IDEAL, start=(0.5, 2.0, pi / 2))
    _, truths = drive(robot, 3.0, 1.0)
    travel = truths[-1].travel[0]
    way = truths[-1].pose[1] - 2.0
    # 1 m of ramp is in it; each of its edges falls into a step of 2 mm, all of one slope
    assert travel - way == pytest.approx(sqrt(1.01) - 1.0, abs=2 * 2e-3 * 0.005)


def test_a_command_of_many_turns_is_a_direction():
    near, far, huge = (Simulator(start=OPEN) for _ in range(3))
    for robot, angle in ((near, 1.0), (far, 1.0 + 2000 * pi), (huge, 1e300)):
        drive(robot, 1.0, 0.3, angle)
    np.testing.assert_allclose(far.truth.pose, near.truth.pose, atol=1e-9)
    wanted = np.fmod(1e300, 2.0 * pi)
    turned = huge.truth.module_angles - wanted
    np.testing.assert_allclose(turned, 2.0 * pi * np.rint(turned / (2.0 * pi)), atol=1e-6)
    assert huge.truth.twist[:2] == pytest.approx(
        [0.3 * np.cos(wanted), 0.3 * np.sin(wanted)], abs=1e-3
    )


def test_slip_shows_between_drive_wheels_and_dead_wheels_and_in_the_truth():
    robot = Simulator(RobotModel(friction=0.1), sensors=IDEAL, start=OPEN)
    seen, truths = drive(robot, 0.5, 2.0)
    rolled = sum(one.module_speeds[0] for one in seen) * 0.01
    assert rolled - truths[-1].travel[0] > 0.4
    assert truths[-1].slip == pytest.approx([2.0 - 0.5 * 0.1 * 9.80665] * 4, abs=0.02)
    assert drive(robot, 3.0, 0.0)[1][-1].slip == pytest.approx([0.0] * 4, abs=1e-3)


def test_a_loose_plug_counts_nothing_while_it_is_loose():
    loose = replace(IDEAL, encoder_gaps=((1, 0.5, 0.7), (2, 0.0, 9.0)))
    for dt in (0.01, 0.1):
        robot = Simulator(sensors=loose, start=OPEN)
        seen, _ = drive(robot, 1.0, 0.5, dt=dt)
        lost = (seen[-1].ticks[0] - seen[-1].ticks[1]) * DEAD_WHEELS.metres_per_tick[0]
        assert lost == pytest.approx(0.1, abs=1e-3)
    seen, truths = drive(robot, 0.5, 0.5, pi / 2)
    assert seen[-1].ticks[2] == 0 and truths[-1].travel[2] > 0.1


# --- modules -------------------------------------------------------------------------------------


def test_module_encoders_tell_whole_steps():
    seen, truths = drive(Simulator(start=OPEN), 0.5, 0.777, 1.234)
    step = 2 * pi / 4096
    for one, truth in zip(seen, truths, strict=True):
        np.testing.assert_allclose(one.module_angles, truth.module_angles, atol=step / 2 + 1e-12)
        np.testing.assert_allclose(one.module_angles / step, np.rint(one.module_angles / step))
        np.testing.assert_allclose(one.module_speeds, truth.module_speeds, atol=0.0005 + 1e-12)


# --- IMU -----------------------------------------------------------------------------------------


def test_the_imu_tells_what_imu_measurements_makes_of_the_truth():
    errors = replace(IDEAL.imu, gyro_bias=(0.01, 0.02, -0.03), accel_scale=(1.01, 0.98, 1.0))
    robot = Simulator(sensors=replace(IDEAL, imu=errors), start=(0.5, 2.0, 0.2))
    first = robot.truth
    parts = drive(robot, 2.5, 1.0, 1.4), wander(robot, 6, 3.0, speed=1.5)
    seen, truths = parts[0][0] + parts[1][0], [first, *parts[0][1], *parts[1][1]]
    attitudes = np.array([truth.attitude for truth in truths])
    gyro, accel = sensors.imu_measurements(
        attitudes[1:], np.diff(velocities(truths), axis=0) / 0.01, 0.01, errors,
        np.random.default_rng(0),
    )  # fmt: skip
    assert np.ptp([truth.height for truth in truths]) > 0.02, "it has to meet a slope"
    np.testing.assert_allclose(np.concatenate([o.gyro for o in seen])[1:], gyro[1:], atol=1e-8)
    ours = np.concatenate([o.accel for o in seen])
    np.testing.assert_allclose(ours, accel, atol=1e-6)


def velocities(truths):
    """Map velocities; upwards from the tick before, which only the slope and the twist know."""
    found = []
    for truth in truths:
        c, s = np.cos(truth.pose[2]), np.sin(truth.pose[2])
        vx, vy, _ = truth.twist
        found.append((c * vx - s * vy, s * vx + c * vy, truth.climb))
    return np.array(found)


def test_the_imu_s_noise_is_that_of_its_data_sheet():
    robot = Simulator()
    robot.step(9.99)
    gyro, accel = [], []
    for _ in range(10):
        robot.step(9.99)
        seen = robot.read()
        gyro.append(seen.gyro - seen.gyro.mean(axis=0))
        accel.append(seen.accel)
    errors = sensors.ImuErrors()
    for rows, density, step in (
        (gyro, errors.gyro_noise_density, errors.gyro_resolution),
        (accel, errors.accel_noise_density, errors.accel_resolution),
    ):
        # 30 000 draws: the sample sigma is good to 0.4 %; rounding adds step^2/12
        wanted = sqrt(density**2 * 50.0 + step**2 / 12.0)
        assert np.concatenate(rows).std(axis=0).mean() == pytest.approx(wanted, rel=0.02)
    bias = np.degrees(np.concatenate([g for g in gyro]).mean())
    assert abs(bias) < 1e-9


def test_the_gyroscope_s_bias_and_the_range_are_those_of_its_errors():
    robot = Simulator(sensors=SensorModel(imu=sensors.UNCALIBRATED))
    robot.step(9.99)
    np.testing.assert_allclose(
        np.degrees(robot.read().gyro.mean(axis=0)), [0.5, -0.4, 0.3], atol=3e-3
    )
    crash = Simulator(start=(5.0, 2.0, 0.0), sensors=IDEAL)
    seen, truths = drive(crash, 1.5, 3.0)
    assert truths[-1].contacts == 1
    assert min(one.accel[:, 0].min() for one in seen) == pytest.approx(-4 * 9.80665)


def test_standing_on_the_ramp_the_accelerometer_reads_the_slope_s_share_of_gravity():
    robot = Simulator(sensors=IDEAL, start=(0.5, 3.5, pi / 2))
    robot.step(1.0)
    angle = np.arctan(0.1)
    assert np.degrees(angle) == pytest.approx(5.71, abs=0.01)
    g = geometry.GRAVITY
    wanted = [g * np.sin(angle), 0.0, g * np.cos(angle)]  # nose up: the push from below is forward
    np.testing.assert_allclose(robot.read().accel[-1], wanted, atol=1e-6)
    sideways = Simulator(sensors=IDEAL, start=(0.5, 3.5, 0.0))
    sideways.step(1.0)
    wanted = [0.0, g * np.sin(angle), g * np.cos(angle)]  # left side up
    np.testing.assert_allclose(sideways.read().accel[-1], wanted, atol=1e-6)
    up = geometry.rotate(robot.truth.attitude, [1.0, 0.0, 0.0])
    assert up[2] == pytest.approx(np.sin(angle))


def test_speeding_up_is_felt_forward_and_turning_about_z():
    robot = Simulator(sensors=IDEAL, start=OPEN)
    seen, _ = drive(robot, 0.1, 0.2)
    assert seen[0].accel[0, 0] == pytest.approx(4.0, rel=0.2)  # 0.2 m/s in 0.05 s
    spin = np.arctan2(MODULES[:, 1], MODULES[:, 0]) + pi / 2
    drive(robot, 0.5, 0.0, spin)
    seen, truths = drive(robot, 0.5, 0.3, spin)
    rate = seen[-1].gyro[0, 2]
    assert rate == pytest.approx(truths[-1].twist[2], rel=1e-3) and rate > 0.8
    assert truths[-1].slip.max() < 2e-3


def test_sample_times_are_the_imu_s_own_and_none_is_told_twice():
    robot = Simulator(sensors=replace(IDEAL, imu_rate=50.0))
    times = []
    for dt in (0.013, 0.1, 0.004, 0.003, 0.05):
        robot.step(dt)
        times += robot.read().imu_time.tolist()
    assert times == [k / 50 for k in range(1, 9)]


def test_of_samples_nobody_reads_the_latest_thousand_are_kept():
    robot = Simulator()
    robot.reset(1)
    robot.step(12.0)
    robot.step(0.5)
    seen = robot.read()
    assert len(seen.gyro) == machine.UNREAD
    assert seen.imu_time[0] == 2.51 and seen.imu_time[-1] == 12.5
    other = Simulator()
    other.reset(1)
    other.step(6.0)
    other.read()
    other.step(6.5)
    assert np.array_equal(other.read().gyro, seen.gyro[-650:])


# --- LiDARs --------------------------------------------------------------------------------------


def test_ideal_beams_at_the_goal_tell_the_walls_to_a_centimetre():
    robot = Simulator(sensors=IDEAL, start=GOAL)
    front, left, _, _ = robot.read().lidar
    # The silo strip's face is 1.575 m ahead of the goal, the end fence 2 m to the left. The strip
    # begins inside a cell of the height map, which counts as filled.
    assert front.distance + LIDARS[0].x == pytest.approx(1.575, abs=0.0101)
    assert left.distance + LIDARS[1].y == pytest.approx(2.0, abs=0.0101)


@pytest.mark.parametrize("heading", [0.0, pi / 2, pi, -pi / 2])
def test_a_wall_tells_both_coordinates_whichever_way_the_robot_looks(heading):
    robot = Simulator(sensors=IDEAL, start=(*field.AREA_3_GOAL, heading))
    ranges = [
        reading.distance + np.hypot(mount.x, mount.y) * 0.0
        for reading, mount in zip(robot.read().lidar, LIDARS, strict=True)
    ]
    turn = round(heading / (pi / 2))
    towards_x, towards_y = ranges[-turn % 4], ranges[(1 - turn) % 4]
    assert towards_x + 0.31 == pytest.approx(1.575, abs=0.0101)
    assert towards_y + 0.31 == pytest.approx(2.0, abs=0.0101)


def readings(robot, count):
    """Distances (count, sensors) of a robot at rest."""
    rows = []
    for _ in range(count):
        robot.step(0.01)
        rows.append([reading.distance for reading in robot.read().lidar])
    return np.array(rows)


def test_noise_offset_and_steps_are_those_of_the_model():
    errors = sensors.LidarErrors(spot=0.0)
    robot = Simulator(sensors=SensorModel(lidar=errors), start=GOAL)
    truth = np.array([r.distance for r in Simulator(sensors=IDEAL, start=GOAL).read().lidar])[:2]
    offsets = []
    for seed in range(40):
        robot.reset(seed)
        rows = readings(robot, 100)[:, :2]
        np.testing.assert_allclose(rows * 100, np.rint(rows * 100), atol=1e-9)
        assert np.abs(rows - truth).max() <= 0.050 + 0.005 + 0.001
        offsets.append(rows.mean(axis=0) - truth)
        if np.abs(offsets[-1]).max() < 0.02:  # no clipping at the band there
            # sigma 10 mm and rounding to 10 mm; 100 draws are good to 7 %, four times that is safe
            assert rows.std(axis=0) == pytest.approx([sqrt(0.01**2 + 0.01**2 / 12)] * 2, rel=0.3)
    # 80 uniform offsets of +-30 mm: sigma 17.3 mm to 6 %, and both ends are met
    assert np.std(offsets) == pytest.approx(0.03 / sqrt(3), rel=0.2)
    assert 0.024 < np.max(offsets) < 0.034 and -0.034 < np.min(offsets) < -0.024


def test_readings_stay_in_the_band_that_the_maker_promises():
    wild = sensors.LidarErrors(offset=0.2, noise=0.1, spot=0.0, step_mm=1)
    robot = Simulator(sensors=SensorModel(lidar=wild), start=GOAL)
    rows = readings(robot, 300)[:, :2]
    truth = np.array([r.distance for r in Simulator(sensors=IDEAL, start=GOAL).read().lidar])[:2]
    assert np.abs(rows - truth).max() == pytest.approx(0.05, abs=0.0011)


def test_noise_goes_on_and_belongs_to_its_sample():
    once = noise.Noise(np.random.default_rng(3), 2)
    rows = np.random.default_rng(3).standard_normal((40 * noise.BLOCK, 2))
    for row in (5, 511, 512, 700, 5000):
        once.reach(row)
        assert once.first <= row < once.first + 2 * noise.BLOCK
        np.testing.assert_array_equal(once.window, rows[once.first :][: 2 * noise.BLOCK])
    robot, other = Simulator(start=GOAL), Simulator(start=GOAL)
    for _ in range(120):
        robot.step(0.1)
    other.step(12.0)
    assert robot.read().lidar == other.read().lidar
    assert readings(robot, 50).std(axis=0)[:2] == pytest.approx([0.0104] * 2, rel=0.5)


def test_every_reading_survives_the_serial_line():
    robot = Simulator(start=(1.2, 10.0, 0.3))
    for one in wander(robot, 3, 3.0)[0]:
        for reading in one.lidar:
            decoded = decode_lidar(encode_lidar(reading), time=reading.time)
            assert decoded.readings == [reading] and type(reading.strength) is int


def test_each_lidar_measures_at_its_own_moments():
    robot = Simulator()
    robot.reset(2)
    times = np.array([[r.time for r in one.lidar] for one in drive(robot, 1.0, 0.3)[0]])
    np.testing.assert_allclose(np.diff(times, axis=0), 0.01, atol=1e-12)
    age = np.arange(1, 101)[:, None] / 100 - times
    assert age.min() >= -1e-12 and age.max() < 0.01
    assert len(np.unique(np.round(age[0], 6))) > 1


def test_a_reading_is_of_its_own_moment():
    robot = Simulator(sensors=IDEAL, start=(1.5, 1.6, 0.0))
    drive(robot, 0.6, 2.0)
    seen, truths = drive(robot, 0.3, 2.0)
    for one, truth in zip(seen, truths, strict=True):
        front = one.lidar[0]
        x = truth.pose[0] - truth.twist[0] * (one.time - front.time)
        assert front.distance == pytest.approx(5.87 - x - 0.31, abs=0.002)


def test_too_near_is_blind_and_nothing_in_sight_is_weak():
    near = Simulator(start=(0.36, 1.5, 0.0)).read().lidar[2]
    assert near == LidarReading(near.time, 0.0, 65535, 25.0)
    far = Simulator(start=(2.0, 10.0, 0.0)).read().lidar
    assert all(r.strength >= 100 or r.distance == 0.0 for r in far)


def test_the_spot_passes_over_a_board_that_is_far_enough():
    """The cone is 0.063 of the distance wide: at 1.6 m as high as the boards."""
    strengths = []
    for distance in (0.5, 1.0, 2.0, 4.0):
        robot = Simulator(sensors=IDEAL, start=(5.875 - 0.31 - distance, 1.6, 0.0))
        line = robot.read().lidar[0]
        cone = replace(IDEAL, lidar=replace(IDEAL.lidar, spot=radians(3.6)))
        spot = Simulator(sensors=cone, start=(5.875 - 0.31 - distance, 1.6, 0.0)).read().lidar[0]
        strengths.append(spot.strength / line.strength)
        assert 0.85 * line.distance < spot.distance < 1.02 * line.distance
    assert strengths[:2] == pytest.approx([1.0, 1.0], abs=0.01)
    assert strengths[3] == pytest.approx(0.5, abs=0.05)  # four of seven rays miss: half the light


def test_a_spot_on_two_surfaces_reads_between_them():
    # The left edge of the cone meets ramp 1, 1.7 m off, the right one passes it: the ledge, 2.2 m.
    cone = replace(IDEAL, lidar=replace(IDEAL.lidar, spot=radians(3.6)))
    distances = []
    for x in np.linspace(1.06, 1.22, 33):
        distances.append(Simulator(sensors=cone, start=(x, 1.5, pi / 2)).read().lidar[0].distance)
    near, far = distances[0], distances[-1]
    assert far == pytest.approx(2.19, abs=0.02) and near < 1.9
    assert any(near + 0.05 < d < far - 0.05 for d in distances)


def test_long_steps_over_blocks_find_what_short_steps_find():
    world, no_cells = lidar.game_field(), np.empty((0, 2), np.int64)
    rng = np.random.default_rng(0)
    for _ in range(300):
        x, y = rng.uniform(0.3, 5.8), rng.uniform(0.3, 11.7)
        z = float(field.floor_height(x, y)) + 0.05
        angle, climb = rng.uniform(-pi, pi), rng.normal(0.0, 0.03)
        x, y = (x - world.x) / 0.01, (y - world.y) / 0.01
        found, _ = beams._meet(world, x, y, z, angle, climb, no_cells)
        way, _ = raycast.walk(
            world.height, x, y, z, np.cos(angle), np.sin(angle), climb * 0.01, 1200.0, no_cells
        )
        wanted = way * 0.01 * sqrt(1.0 + climb**2) if way < 1200.0 else 0.0
        assert found == pytest.approx(wanted, abs=1e-9)


def test_light_returns_with_the_square_of_the_distance():
    strength = {}
    for distance in (1.0, 2.0):
        robot = Simulator(sensors=IDEAL, start=(5.87 - 0.31 - distance, 1.6, 0.0))
        strength[distance] = robot.read().lidar[0].strength
    assert strength[1.0] / strength[2.0] == pytest.approx(4.0, rel=0.02)
    assert strength[1.0] == pytest.approx(16000 * 0.5, rel=0.03)


def test_beams_tilt_with_the_robot():
    # On the flat the front beam meets ramp 1 before it; on the ramp it looks along the slope.
    flat = Simulator(sensors=IDEAL, start=(0.5, 2.0, pi / 2)).read().lidar[0]
    assert flat.distance == pytest.approx(3.5 - 2.31, abs=0.02)  # 50 mm up is half the ramp
    on_it = Simulator(sensors=IDEAL, start=(0.5, 3.5, pi / 2)).read().lidar
    assert on_it[0].distance == 0.0  # 1 m up on 10 m, over every board
    # Backwards and down, 50 mm above the slope: it meets the floor half a metre before the foot.
    assert on_it[2].distance == pytest.approx((3.5 - 0.31 - 2.5) * sqrt(1.01), abs=0.02)


def test_a_beam_starts_as_high_as_its_side_of_a_robot_across_the_slope():
    # The ramp's foot is 0.5 m behind the middle, at y = 3. The right mount is 31 mm lower than the
    # middle, 50 mm above the slope under it: the floor again, half a metre before the foot.
    right = Simulator(sensors=IDEAL, start=(0.5, 3.5, 0.0)).read().lidar[3]
    assert right.distance == pytest.approx((3.5 - 0.31 - 2.5) * sqrt(1.01), abs=0.02)


def test_before_the_clock_s_first_tick_a_reading_is_at_most_a_period_old():
    robot = Simulator()
    for seed in range(5):
        robot.reset(seed)
        times = np.array([reading.time for reading in robot.read().lidar])
        assert ((times > -0.01) & (times <= 0.0)).all()


# --- commands and refusals -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (Command([1.0, np.nan, 1.0, 1.0], AHEAD), "command.speeds: entry"),
        (Command([1.0] * 5, AHEAD), r"command.speeds: expected shape \(4,\), got \(5,\)"),
        (([1.0] * 4, [0.0] * 4), "command: expected Command.*got tuple"),
        (None, "command: expected Command.*got NoneType"),
    ],
)
def test_a_wrong_command_is_refused_and_the_one_before_stays(command, message):
    robot = Simulator(start=OPEN)
    drive(robot, 0.5, 0.5)
    with pytest.raises(ValueError, match=message):
        robot.apply(command)
    robot.step(0.5)
    assert robot.truth.twist[0] == pytest.approx(0.5, abs=1e-3) and robot.clamped == 0


def test_too_fast_is_cut_and_counted():
    robot = Simulator(start=OPEN)
    robot.apply(Command([9.0, -9.0, 3.2, 0.0], AHEAD))
    robot.step(1.0)
    assert robot.clamped == 1
    np.testing.assert_allclose(robot.truth.module_speeds, [3.2, -3.2, 3.2, 0.0], atol=1e-3)
    robot.apply(Command([3.2] * 4, AHEAD))
    assert robot.clamped == 1


@pytest.mark.parametrize("dt", [None, "0.01", 0.0, -0.01, float("nan"), float("inf"), 61.0])
def test_a_step_that_is_no_time_is_refused(dt):
    robot = Simulator()
    with pytest.raises(ValueError, match="dt: must be seconds above 0, at most 60"):
        robot.step(dt)
    assert robot.time == 0.0


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ((0.1, 0.5, 0.0), "start: the robot would stand in an obstacle"),
        ((3.0, 4.0, 0.0), "start: the robot would stand in an obstacle"),
        ((0.4, 0.4, pi / 4), "start: the robot would stand in an obstacle"),
        ((6.0, 10.0, 0.0), "start: the robot would stand in an obstacle"),
        ((9.0, 6.0, 0.0), "start: the robot would stand in an obstacle"),
        ((-3.0, 6.0, 0.0), "start: .* outside the field"),
        ((3.0, np.nan, 0.0), "start: entry .* is not a finite number"),
        ((3.0, 1.0), r"start: expected shape \(3,\)"),
    ],
)
def test_a_start_where_no_robot_can_stand_is_refused(start, message):
    robot = Simulator()
    with pytest.raises(ValueError, match=message):
        robot.reset(0, start)
    with pytest.raises(ValueError, match=message):
        Simulator(start=start)
    assert robot.truth.pose.tolist() == [*field.START, 0.0]


def test_what_is_no_model_is_refused():
    with pytest.raises(ValueError, match="model: expected a RobotModel, got tuple"):
        Simulator((0.5, 0.5, 0.0))
    with pytest.raises(ValueError, match="sensors: expected a SensorModel, got RobotModel"):
        Simulator(sensors=RobotModel())


@pytest.mark.parametrize("seed", [-1, 1.5, None, "7", True])
def test_a_seed_that_is_none_is_refused(seed):
    with pytest.raises(ValueError, match="seed: expected a whole number"):
        Simulator().reset(seed)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SensorModel(imu_rate=300.0), "imu_rate: must be 500 Hz divided by a whole number"),
        (lambda: SensorModel(lidar_rate=0.0), "lidar_rate: must be 500 Hz divided"),
        (lambda: SensorModel(angle_step=0.0), "angle_step: must be positive"),
        (
            lambda: SensorModel(encoder_gaps=((3, 0.0, 1.0),)),
            "encoder_gaps: a tuple of .wheel 0, 1 or 2",
        ),
        (lambda: SensorModel(encoder_gaps=None), "encoder_gaps: a tuple of"),
        (lambda: SensorModel(encoder_gaps=(1, 0.0, 1.0)), "encoder_gaps: a tuple of"),
        (lambda: SensorModel(encoder_gaps=((1.0, 0.0, 1.0),)), "encoder_gaps: a tuple of"),
        (lambda: SensorModel(encoder_gaps=((1, 2.0, 1.0),)), "encoder_gaps: a tuple of"),
        (lambda: SensorModel(encoder_gaps=((1, "0", 1.0),)), "encoder_gaps: a tuple of"),
        (lambda: SensorModel(imu_rate="x"), "imu_rate: must be 500 Hz divided by .* got 'x'"),
        (lambda: SensorModel(speed_step="x"), "speed_step: must be positive, got 'x'"),
        (lambda: SensorModel(lidar=None), "lidar: expected LidarErrors, got NoneType"),
        (lambda: SensorModel(imu=None), "imu: expected ImuErrors, got NoneType"),
        (lambda: sensors.LidarErrors(step_mm=None), "step_mm: must be positive, got None"),
        (lambda: sensors.LidarErrors(noise=-0.1), "noise: must not be negative"),
        (lambda: sensors.LidarErrors(step_mm=2.5), "step_mm: must be whole millimetres"),
        (lambda: sensors.LidarErrors(reflectivity=0.0), "reflectivity: between 0 and 1"),
    ],
)
def test_sensors_that_cannot_be_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_gap_of_a_wheel_that_the_robot_lacks_is_refused():
    two = odometry.TrackingWheels(DEAD_WHEELS.positions[:2], DEAD_WHEELS.directions[:2], 0.03, 3200)
    loose = replace(IDEAL, encoder_gaps=((2, 0.0, 1.0),))
    with pytest.raises(ValueError, match="encoder_gaps: wheel 2 is not there, the model has 2"):
        Simulator(RobotModel(dead_wheels=two), sensors=loose)


@given(
    st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4),
    st.lists(st.floats(-1e6, 1e6), min_size=4, max_size=4),
    st.floats(1e-4, 0.3),
)
@settings(max_examples=30, deadline=None)
def test_whatever_the_command_all_readings_stay_finite(speeds, angles, dt):
    robot = Simulator(start=(4.3, 7.5, 0.4))
    robot.apply(Command(speeds, angles))
    for _ in range(5):
        robot.step(dt)
        seen = robot.read()
    for array in (seen.gyro, seen.accel, seen.module_speeds, seen.module_angles):
        assert np.isfinite(array).all()
    assert np.abs(seen.module_angles).max() <= pi + 1e-9
    assert np.isfinite(robot.truth.pose).all()


# --- a long run ----------------------------------------------------------------------------------


def test_a_slow_first_start_is_announced_and_a_fast_one_is_silent(monkeypatch):
    said = []
    monkeypatch.setattr(warm, "PATIENCE", 600.0)
    warm.warm_up(said.append)
    assert said == []
    monkeypatch.setattr(warm, "PATIENCE", 0.0)
    monkeypatch.setattr(warm, "Simulator", lambda: time.sleep(0.3) or Simulator())
    warm.warm_up(said.append)
    assert len(said) == 1 and "once" in said[0]


def memory_grown(minutes):
    """Bytes that a robot which drives and is read keeps; the least of four quarters.

    What leaks leaks in every quarter; what the interpreter or a library sets aside for itself
    does not.
    """
    robot = Simulator(start=OPEN)
    wander(robot, 0, 5.0)
    tracemalloc.start()
    held = []
    for quarter in range(5):
        for k in range(round(minutes * 6000 / 4) if quarter else 100):
            if k % 100 == 0:
                robot.apply(Command([0.3, 0.2, 0.3, 0.4], [0.01 * k, 0.0, 1.0, 2.0]))
            robot.step(0.01)
            robot.read()
        gc.collect()
        held.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    return np.diff(held).min()


KEPT = 24 * 750
"""The smallest thing that Python keeps has 24 bytes: of it, one for every observation in a quarter
of half a minute. What the interpreter sets aside now and then is some kilobytes; one forgotten
Observation a step would be over a megabyte."""


def test_memory_stays_flat_over_half_a_minute():
    assert memory_grown(0.5) < KEPT


@pytest.mark.campaign
def test_memory_stays_flat_over_an_hour():
    assert memory_grown(60.0) < KEPT  # here 0.2 bytes an observation


# --- put down elsewhere ------------------------------------------------------------------------


def test_put_down_elsewhere_it_stands_there_and_clock_and_counters_go_on():
    robot = Simulator(sensors=IDEAL, start=OPEN)
    drive(robot, 0.5, 0.5)
    before = robot.read()
    robot.place((4.3, 10.0, pi / 2))
    pose, motion = robot.motion
    assert pose.tolist() == [4.3, 10.0, pi / 2] and motion.tolist() == [0.0] * 3
    after = robot.read()
    assert after.time == before.time and after.ticks.tolist() == before.ticks.tolist()
    seen, _ = drive(robot, 0.5)
    assert seen[-1].ticks.tolist() == before.ticks.tolist()  # a wheel in the air counts nothing
    assert abs(np.concatenate([o.gyro for o in seen])[:, 2]).max() < 1e-9  # nor does its gyroscope
    walls = [o.lidar[0].distance for o in seen]  # the front one looks at the far fence
    assert walls[-1] == pytest.approx(12.0 - 10.0 - 0.31, abs=0.02)


def test_it_is_not_put_into_an_obstacle_and_stays_where_it_was():
    robot = Simulator(sensors=IDEAL, start=OPEN)
    for pose, sentence in (
        ((2.0, 7.5, 0.0), "obstacle"),
        ((0.1, 2.0, 0.0), "obstacle"),
        ((-1.0, 2.0, 0.0), "outside the field"),
        ((1.0, 2.0), "expected shape"),
    ):
        with pytest.raises(ValueError, match=sentence):
            robot.place(pose)
    assert robot.motion[0].tolist() == list(OPEN)


def test_motion_is_the_truth_in_brief_and_a_copy():
    robot = Simulator(sensors=IDEAL, start=OPEN)
    drive(robot, 1.0, 0.5)
    pose, motion = robot.motion
    np.testing.assert_array_equal(pose, robot.truth.pose)
    assert motion[0] == pytest.approx(0.5, abs=0.02)
    pose[:] = motion[:] = 0.0
    assert robot.motion[0][0] > OPEN[0]
