"""The pose by the distances to the walls: expected readings, correction, and being lost."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import cos, hypot, inf, nan, pi, radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course.autopilot import Walls, expected_readings, measured_offsets
from robocon_course.autopilot.walls import LOST_AFTER, _misfit, correct, found_again
from robocon_course.robot import LIDARS, SATURATED, LidarReading, Observation
from robocon_course.simulator import IDEAL, SensorModel, Simulator
from robocon_course.simulator.match import Match

SPOT = radians(3.6)
EXACT = replace(IDEAL, lidar=replace(IDEAL.lidar, spot=SPOT, step_mm=1))
NOISY = replace(IDEAL, lidar=replace(IDEAL.lidar, spot=SPOT, noise=0.01, step_mm=10))
HERE = np.array([4.3, 10.0, 0.0])
STANDING, DT = (0.0, 0.0), 0.01
NO_OFFSETS = np.zeros(4)


@cache
def robot(sensors: SensorModel) -> Simulator:
    return Simulator(sensors=sensors)


def read_at(pose, sensors=EXACT, count=1) -> list[Observation]:
    """Readings of a robot that stands at a pose; ValueError where it cannot."""
    bot = robot(sensors)
    bot.place(pose)
    bot.step(0.05)
    seen = []
    for _ in range(count):
        bot.step(DT)
        seen.append(bot.read())
    return seen


def unsure(sigma=0.05, offsets=NO_OFFSETS) -> Walls:
    return Walls((sigma, sigma), np.asarray(offsets, float))


def corrected(pose, readings, walls=None):
    """The pose after some readings in place."""
    walls, pose = walls or unsure(), np.array(pose, float)
    for seen in readings:
        walls, pose = correct(walls, pose, seen, STANDING, DT)
    return walls, pose


def with_reading(seen: Observation, j: int, **values) -> Observation:
    """One LiDAR says something else."""
    lidar = list(seen.lidar)
    lidar[j] = lidar[j]._replace(**values)
    return seen._replace(lidar=tuple(lidar))


# --- what each should read ---------------------------------------------------------------------


def test_at_the_goal_the_walls_lie_where_the_map_says():
    front, left, _, _ = expected_readings(HERE)
    assert front[0] == pytest.approx(5.875 - 4.3 - 0.31, abs=0.01) and front[1] > 0.9
    assert left[0] == pytest.approx(12.0 - 10.0 - 0.31, abs=0.02)


def test_anywhere_the_simulator_s_lidars_read_what_is_expected():
    rng, compared = np.random.default_rng(7), 0
    for pose in rng.uniform((0.47, 0.47, -pi), (5.4, 11.5, pi), (150, 3)):
        try:
            [seen] = read_at(pose)
        except ValueError:  # the robot cannot stand there
            continue
        truth, _ = robot(EXACT).motion
        for reading, (distance, square) in zip(seen.lidar, expected_readings(truth), strict=True):
            if reading.distance > 0.0:  # it trusts itself
                compared += 1
                assert abs(reading.distance - distance) <= 0.0006, pose
                assert 0.0 < square <= 1.001
    assert compared > 300


# --- the set-up --------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_turned_beside_the_fence_each_lidar_s_own_error_is_found_to_5_mm(seed):
    match = Match(seed)
    found = measured_offsets(match.set_up())
    true = match.robot._lidars.offsets
    assert np.abs(true).max() > 0.01
    np.testing.assert_allclose(found, true, atol=0.005)


def test_a_lidar_that_never_looked_at_a_near_wall_is_taken_as_it_is():
    readings = [tuple(LidarReading(0.0, 0.5, 60, 25.0) for _ in LIDARS)] * 3  # too weak
    assert measured_offsets([(HERE, readings)]).tolist() == [0.0] * 4
    assert measured_offsets([]).tolist() == [0.0] * 4


# --- correction --------------------------------------------------------------------------------


@pytest.mark.parametrize("theta", [0.0, pi / 2, pi, -pi / 2, 0.15])
def test_a_pose_5_cm_off_comes_home_within_half_a_second(theta):
    truth = np.array([4.6, 10.4, theta])
    off = np.add(truth, (0.04, -0.03, 0.0))
    walls, pose = corrected(off, read_at(truth, NOISY, 50))
    assert hypot(*(pose - truth)[:2]) < 0.006
    assert walls.sure and not walls.lost and walls.used > 60
    assert pose[2] == theta  # LiDARs say nothing of the heading here


@given(dx=st.floats(-0.05, 0.05), dy=st.floats(-0.05, 0.05))
def test_from_wherever_nearby_the_end_is_the_same(dx, dy):
    _, pose = corrected(np.add(HERE, (dx, dy, 0.0)), _still())
    assert hypot(*(pose - HERE)[:2]) < 0.004


@cache
def _still() -> tuple[Observation, ...]:
    return tuple(read_at(HERE, EXACT, 40))


def test_each_lidar_s_own_error_is_taken_off():
    offsets = np.array([0.03, -0.02, 0.0, 0.01])
    readings = [
        seen._replace(lidar=tuple(
            r._replace(distance=r.distance + e) for r, e in zip(seen.lidar, offsets, strict=True)
        ))
        for seen in _still()
    ]  # fmt: skip
    _, known = corrected(HERE, readings, unsure(offsets=offsets))
    _, unknown = corrected(HERE, readings)
    assert hypot(*(known - HERE)[:2]) < 0.002 < 0.015 < hypot(*(unknown - HERE)[:2])


def test_a_reading_is_used_once():
    first = _still()[0]
    walls, pose = corrected(np.add(HERE, (0.03, 0.0, 0.0)), [first])
    again, same = correct(walls, pose, first, STANDING, DT)
    assert again.used == walls.used > 0 and same.tolist() == pose.tolist()


def test_what_was_measured_on_the_way_is_taken_for_where_it_was_measured():
    # 5 ms ago, at 2 m/s, it was 1 cm farther from the wall ahead, and nearer to what lies behind.
    old = _still()[0]
    was = tuple(
        r._replace(time=1.0, distance=r.distance + 0.01 * cos(mount.angle))
        for r, mount in zip(old.lidar, LIDARS, strict=True)
    )
    late = old._replace(time=1.005, lidar=was)
    walls = unsure(0.02)
    _, moving = correct(walls, HERE, late, (2.0, 0.0), DT)
    _, standing = correct(walls, HERE, late, STANDING, DT)
    assert abs(moving[0] - HERE[0]) < 0.001 < 0.004 < abs(standing[0] - HERE[0])


def test_the_way_makes_it_unsure_and_a_reset_much_more():
    blind = Observation(
        1.0, np.zeros(3), *[np.zeros((0, 3))] * 3, (), np.zeros(4), np.zeros(4), 24.0
    )
    walls = unsure(0.002)
    driven, _ = correct(walls, HERE, blind, (1.0, 0.0), 1.0)
    stood, _ = correct(walls, HERE, blind, STANDING, 1.0)
    assert walls.sigma[0] < stood.sigma[0] < driven.sigma[0] < walls.doubted().sigma[0]


# --- what is not believed ----------------------------------------------------------------------


def test_a_leg_in_a_beam_is_refused_and_counted():
    plain, pose = corrected(HERE, _still())
    legs = [with_reading(seen, 0, distance=0.4) for seen in _still()]
    walls, same = corrected(HERE, legs)
    # Along y nothing has changed; along x the rear LiDAR may be left, or nothing.
    assert walls.refused >= len(legs) > plain.refused == 0
    assert hypot(*(same - pose)[:2]) < 0.005


@pytest.mark.parametrize(
    "values",
    [
        {"distance": nan}, {"distance": inf}, {"distance": -inf}, {"distance": 0.0, "strength": 0},
        {"strength": SATURATED}, {"strength": 50}, {"time": nan}, {"time": -inf}, {"strength": nan},
    ],
)  # fmt: skip
def test_a_reading_that_is_none_changes_nothing(values):
    seen = _still()[0]
    for j in range(len(LIDARS)):
        seen = with_reading(seen, j, **values)
    walls, pose = correct(unsure(), HERE, seen, STANDING, DT)
    assert pose.tolist() == HERE.tolist() and walls.used == 0
    assert np.isfinite(walls.sigma).all()


anything = st.floats(allow_nan=True, allow_infinity=True)
readings = st.builds(
    LidarReading, anything, anything, st.one_of(st.integers(-1, 70000), anything), st.just(25.0)
)


@given(
    time=anything,
    lidar=st.lists(readings, min_size=0, max_size=5),
    pose=st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-100, 100)),
    motion=st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
)
def test_whatever_the_lidars_say_the_pose_stays_a_pose_and_moves_but_a_little(
    time, lidar, pose, motion
):
    seen = _still()[0]._replace(time=time, lidar=tuple(lidar))
    walls, moved = correct(unsure(), np.array(pose), seen, motion, DT)
    assert np.isfinite(moved).all() and np.isfinite(walls.sigma).all()
    assert hypot(*(moved - pose)[:2]) < 1.5  # four gates


# --- lost --------------------------------------------------------------------------------------


def test_who_is_carried_elsewhere_notices_and_who_stands_right_does_not():
    readings = read_at(HERE, NOISY, 120)
    walls, _ = corrected(HERE, readings)
    assert not walls.lost and walls.lost_for == (0.0, 0.0)
    walls, pose = corrected(np.add(HERE, (0.0, 0.6, 0.0)), readings[:50])
    assert not walls.lost  # half a second: it may be people
    walls, pose = corrected(pose, readings[50:], walls)
    assert walls.lost and walls.lost_for[1] > LOST_AFTER
    assert not walls.doubted().lost


@pytest.mark.parametrize("quarter", range(4))
def test_in_area_3_the_lost_robot_finds_itself_within_5_cm(quarter):
    rng = np.random.default_rng(quarter)
    for _ in range(8):
        theta = quarter * pi / 2 + rng.uniform(-0.1, 0.1)
        truth = np.array([rng.uniform(3.4, 5.35), rng.uniform(8.6, 11.4), theta])
        [seen] = read_at(truth, NOISY)
        found = found_again(unsure(), np.array([1.0, 9.0, theta]), seen)
        assert found is not None and hypot(*(found - truth)[:2]) < 0.05, truth
        assert found[2] == theta


def test_in_the_storage_zone_it_rather_says_that_it_does_not_know():
    rng, known, wrong = np.random.default_rng(5), 0, 0
    for _ in range(24):
        theta = rng.integers(4) * pi / 2
        truth = np.array([rng.uniform(0.5, 3.3), rng.uniform(8.6, 11.4), theta])
        [seen] = read_at(truth, NOISY)
        found = found_again(unsure(), np.array([4.0, 9.0, theta]), seen)
        if found is not None:
            off = hypot(*(found - truth)[:2])
            known, wrong = known + (off < 0.05), wrong + (off >= 0.2)
    assert known >= 17 and wrong <= 1


def test_how_badly_a_place_fits_by_hand():
    should = np.array([(1.0, 0.98), (2.0, 0.97), (3.0, 0.1), (0.0, 0.0)])
    heard = np.array([1.02, 1.0, 2.9, nan])
    # 2 cm off; at most half a metre; a floor counts too; nothing expected, and nothing heard.
    assert _misfit(should, heard) == pytest.approx((0.02 + 0.5 + 0.1 + 0.0) / 4)
    # A wall that is not heard counts; a floor far away may not be heard; what nobody expects.
    assert _misfit(should, np.array([nan, 2.0, nan, 4.0])) == pytest.approx((0.5 + 0 + 0 + 0.5) / 4)


def test_without_two_readings_or_aslant_it_is_found_nowhere():
    [seen] = read_at(HERE)
    dumb = seen
    for j in range(3):
        dumb = with_reading(dumb, j, distance=0.0, strength=0)
    assert found_again(unsure(), HERE, dumb) is None
    assert found_again(unsure(), np.array([4.3, 10.0, 0.7]), seen) is None


def test_distances_that_fit_nowhere_are_no_place():
    [seen] = read_at(HERE)
    for j, distance in enumerate((0.3, 0.3, 0.3, 0.3)):
        seen = with_reading(seen, j, distance=distance, strength=500)
    assert found_again(unsure(), HERE, seen) is None


@given(lidar=st.lists(readings, min_size=4, max_size=4), theta=st.one_of(anything, st.just(0.0)))
def test_no_reading_and_no_heading_stops_the_search(lidar, theta):
    seen = _still()[0]._replace(lidar=tuple(lidar))
    found = found_again(unsure(), np.array([1.0, 9.0, theta]), seen, step=0.8)
    assert found is None or np.isfinite(found).all()
