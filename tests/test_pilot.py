"""From the start zone to Area 3: route, following, dead reckoning step by step, and all together.

The suite drives three robots; the campaign a hundred.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import hypot, inf, nan, pi

import numpy as np
import pytest

from conftest import solved_parts
from robocon_course import autopilot, field, worlds
from robocon_course.autopilot import (
    DriveLimits,
    Following,
    FollowSettings,
    Parts,
    Pilot,
    Reckoning,
    dead_reckoning,
    follow_step,
    lidar_y,
    plan_route,
    reckon,
    room_for_body,
)
from robocon_course.geometry import distance_along
from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError, line_of_sight
from robocon_course.robot import DEAD_WHEELS, LIDARS, SIDE, LidarReading, Observation
from robocon_course.tracking import speed_profile

PARTS = Parts()
FIELD = field.obstacle_map(0.05)
GOAL = field.AREA_3_GOAL


@cache
def to_area_3() -> autopilot.Route:
    return plan_route(PARTS, field.obstacle_map(), field.START, GOAL)


def along_x(length=3.0, speed=1.0) -> autopilot.Route:
    """A straight path along x in steps of 5 cm."""
    xy = np.column_stack([np.arange(0.0, length + 1e-9, 0.05), np.zeros(round(length / 0.05) + 1)])
    return autopilot.Route(xy, distance_along(xy), speed_profile(xy, speed, 2.0, 1.5))


def body_cells(grid: GridMap, x: float, y: float) -> np.ndarray:
    """Middles of all cells that a square body in the middle of cell (x, y) reaches into."""
    half = SIDE / 2 - 1e-6
    rows = np.arange(*(grid.cells([(x, y - half), (x, y + half)])[:, 0] + (0, 1)))
    cols = np.arange(*(grid.cells([(x - half, y), (x + half, y)])[:, 1] + (0, 1)))
    return grid.centres(np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1))


# --- the route -------------------------------------------------------------------------------


def test_the_route_leads_over_both_ramps_and_the_whole_body_has_room_everywhere():
    route, grid = to_area_3(), field.obstacle_map()
    assert route.xy[[0, -1]] == pytest.approx(np.array([field.START, GOAL]))
    for ramp in (field.RAMP_1, field.RAMP_2):
        assert any(ramp.contains(*point) for point in route.xy)
    assert all(grid.is_free(body_cells(grid, *point)).all() for point in route.xy[::3])
    assert route.margin == autopilot.route.MARGINS[0]


def test_away_from_its_ends_the_route_keeps_its_margin():
    route, grid = to_area_3(), field.obstacle_map()
    room = PARTS.inflate_square(grid, SIDE / 2 + route.margin)
    away = np.hypot(*(route.xy[:, None] - [field.START, GOAL]).transpose(2, 0, 1)).min(axis=1)
    assert room.is_free(route.xy[away > autopilot.route.NEAR_END]).all()
    assert not room.is_free(field.START)  # where somebody put the robot no margin is asked for


def test_a_disc_as_wide_as_the_body_would_let_its_corner_touch():
    free = np.ones((150, 150), dtype=bool)
    free[100:, 100:] = False  # a box, its corner at (2, 2) m
    grid, place = GridMap(free, 0.02), np.array([1.755, 1.755])  # 0.346 m from the corner
    assert line_of_sight(grid, place, place, clearance=SIDE / 2)
    assert not grid.is_free(body_cells(grid, *place)).all()
    assert not room_for_body(PARTS, grid, np.array([[0.0, 0.0]]), 0.0).is_free(place)


def passage(width: float) -> GridMap:
    """Two rooms of 1.8 m with a passage between them, 1 m long."""
    free, half = np.ones((150, 250), dtype=bool), round(width / 0.04)
    free[: 75 - half, 100:150] = free[75 + half :, 100:150] = False
    return GridMap(free, 0.02)


@pytest.mark.parametrize(("width", "margin"), [(0.96, 0.12), (0.84, 0.06), (0.72, 0.0)])
def test_in_a_passage_too_narrow_for_the_margin_there_is_less_of_it(width, margin):
    assert plan_route(PARTS, passage(width), [1.0, 1.5], [4.0, 1.5]).margin == margin


def test_through_a_passage_narrower_than_the_body_there_is_no_way():
    with pytest.raises(NoPathError, match="no way leads"):
        plan_route(PARTS, passage(0.64), [1.0, 1.5], [4.0, 1.5])


@pytest.mark.parametrize("goal", [field.START, (0.56, 0.36), (0.6, 0.4)])
def test_a_goal_where_the_robot_stands_already_is_a_route_too(goal):
    run = worlds.field_drive(1, goal=goal)
    assert run.arrived and run.away < 0.05 and run.contacts == 0


def test_no_point_of_the_route_is_driven_faster_than_its_bend_allows():
    limits = DriveLimits(speed=1.5, accel=1.0, lateral=0.8)
    route = plan_route(PARTS, FIELD, field.START, GOAL, limits=limits)
    assert route.speeds.max() < 1.5 + 1e-9 and route.speeds[[0, -1]].tolist() == [0.0, 0.0]
    gained = np.diff(route.speeds**2) / (2.0 * np.diff(route.along))
    assert np.abs(gained).max() < 1.0 + 1e-9


@pytest.mark.parametrize(
    ("goal", "sentence"),
    [
        ((3.0, 7.5), r"goal: \(3, 7.5\) m lies in an obstacle"),
        ((5.8, 10.0), r"goal: at \(5.8, 10\) m the body of 0.65 m stands in an obstacle"),
        ((0.3, 10.0), r"goal: at \(0.3, 10\) m the body"),
        ((99.0, 0.0), "outside the map"),
        ((nan, 1.0), "goal: entry .* is not a finite number"),
        ((1.0, 2.0, 3.0), "goal: expected shape"),
    ],
)
def test_a_goal_where_the_body_cannot_be_is_refused(goal, sentence):
    with pytest.raises(ValueError, match=sentence):
        plan_route(PARTS, FIELD, field.START, goal)


def test_a_search_of_ones_own_that_says_little_is_not_asked_about_a_goal_outside():
    def astar(room, start, goal):
        raise NoPathError("not free")

    with pytest.raises(NoPathError, match="outside the map, which spans"):
        plan_route(replace(PARTS, astar=astar), FIELD, field.START, (99.0, 0.0))


def test_a_path_of_ones_own_that_is_none_is_refused_before_anybody_drives_it():
    def smooth_path(room, xy, curvature):
        return [*xy, (nan, 1.0)]

    with pytest.raises(ValueError, match=r"path: entry .* is not a finite number"):
        plan_route(
            replace(PARTS, smooth_path=smooth_path, speed_profile=lambda xy, *_: np.ones(len(xy))),
            FIELD, field.START, GOAL,
        )  # fmt: skip


# --- following -------------------------------------------------------------------------------


def test_on_a_straight_path_the_robot_goes_along_it_at_the_profiles_speed():
    route = along_x()
    state = Following.begin(route)._replace(speed=1.0)
    state = follow_step(PARTS, state, route, [1.5, 0.0, 0.0], 0.02)
    assert state.twist == pytest.approx((1.0, 0.0, 0.0)) and state.index in (29, 30)
    assert state.left == pytest.approx(1.5)


def test_beside_the_path_it_comes_back_and_steers_towards_it():
    route = along_x()
    start = Following.begin(route)._replace(speed=1.0)
    for side in (0.05, -0.05):  # to the left, to the right
        state = follow_step(PARTS, start, route, [1.5, side, 0.0], 0.02)
        assert state.twist[1] * side < 0.0 and state.course * side < 0.0


def test_far_off_the_path_the_way_back_is_not_faster_than_its_limit():
    route = along_x()
    state = follow_step(PARTS, Following.begin(route), route, [1.5, 1.5, 0.0], 0.02)
    assert hypot(*state.twist[:2]) < 1.0 + 0.5 and state.twist[1] <= -0.5 + 1e-9


def test_the_heading_comes_back_the_shorter_way_and_whole_turns_do_not_matter():
    route = along_x()
    turned = {}
    for theta in (0.3, 0.3 + 4 * pi, -0.3, pi + 0.2):
        state = follow_step(PARTS, Following.begin(route), route, [1.5, 0.0, theta], 0.02)
        turned[theta] = state.twist[2]
    assert turned[0.3] == pytest.approx(-0.9) == pytest.approx(turned[0.3 + 4 * pi])
    assert turned[-0.3] == pytest.approx(0.9)
    assert turned[pi + 0.2] == 2.0  # 161 degrees to the left, not 199 to the right


def test_a_course_that_points_away_from_the_path_is_given_up_at_once():
    route = along_x()
    wrong = Following.begin(route)._replace(course=2.5, speed=1.0)
    assert follow_step(PARTS, wrong, route, [1.5, 0.0, 0.0], 0.02).twist[0] == pytest.approx(1.0)


def test_without_a_pose_it_goes_on_for_a_while_then_stops_and_counts():
    route = along_x()
    state = follow_step(PARTS, Following.begin(route), route, [1.5, 0.0, 0.0], 0.02)
    last = state.twist
    seen = []
    for bad in [nan, inf, -inf] * 4:
        state = follow_step(PARTS, state, route, [1.5, bad, 0.0], 0.02)
        seen.append(state.twist)
    assert seen[:10] == [last] * 10 and seen[10:] == [(0.0, 0.0, 0.0)] * 2
    assert state.missed == state.rejected == 12
    state = follow_step(PARTS, state, route, [1.5, 0.0, 0.0], 0.02)
    assert state.missed == 0 and state.rejected == 12 and state.twist[0] == pytest.approx(1.0)


def test_it_leaves_its_start_and_comes_to_rest_at_its_end():
    route, dt = along_x(), 0.01
    pose, state = np.zeros(3), Following.begin(route)
    for _ in range(1000):
        state = follow_step(PARTS, state, route, pose, dt)
        pose = pose + dt * np.array(state.twist)
    assert pose == pytest.approx([3.0, 0.0, 0.0], abs=1e-3)
    assert state.twist == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_a_step_leaves_the_state_it_was_given_as_it_is_and_is_a_pure_function():
    route = along_x()
    state = Following.begin(route)
    first = follow_step(PARTS, state, route, [0.5, 0.1, 0.1], 0.02)
    assert state == Following.begin(route)
    assert follow_step(PARTS, state, route, [0.5, 0.1, 0.1], 0.02) == first


@pytest.mark.parametrize("dt", [0.0, -0.1, nan, inf])
def test_a_step_without_time_is_refused(dt):
    with pytest.raises(ValueError, match="dt: expected seconds above 0"):
        follow_step(PARTS, Following.begin(along_x()), along_x(), [0.0, 0.0, 0.0], dt)


# --- dead reckoning, step by step ------------------------------------------------------------


def test_step_by_step_it_is_the_dead_reckoning_of_the_whole_log():
    log = worlds.simulated_drive(7, "degraded", 12.0)
    whole = dead_reckoning(PARTS, log.observations, start=log.poses[0])
    state, poses = Reckoning.at(log.poses[0]), []
    for one in log.observations:
        state = reckon(PARTS, state, one)
        poses.append(state.pose)
    np.testing.assert_allclose(poses, whole, atol=1e-9)


def test_an_observation_that_is_not_later_changes_nothing_but_counters():
    log = worlds.simulated_drive(7, "ideal", 4.0)
    state = reckon(PARTS, Reckoning.at(log.poses[0]), log.observations[189])
    state = reckon(PARTS, state, log.observations[190])
    for late in (log.observations[190], log.observations[3]):
        again = reckon(PARTS, state, late)
        assert again == state._replace(missed=1, rejected=1) and not again.fresh


def observations(count=40, dt=0.02, speed=1.0):
    """Readings of a robot that drives ahead."""
    zero = np.zeros((2, 3))
    per_tick = speed * dt / DEAD_WHEELS.metres_per_tick.mean()
    lidar = tuple(LidarReading(0.0, 1.0, 500, 25.0) for _ in LIDARS)
    for k in range(count):
        ticks = np.array([round(per_tick * k), round(per_tick * k), 0])
        yield Observation(
            k * dt, ticks, np.zeros(2), zero, zero, lidar, np.full(4, speed), np.zeros(4), 24.0
        )


def reckoned(readings) -> Reckoning:
    state = Reckoning.at([0.0, 0.0, 0.0])
    for one in readings:
        state = reckon(PARTS, state, one)
    return state


def test_counters_may_pass_their_largest_number_and_share_one_buffer():
    buffer, state = np.zeros(3, np.int64), Reckoning.at([0.0, 0.0, 0.0])
    for one in observations():
        count = one.ticks + 2**31 - 9000
        buffer[:] = np.where(count >= 2**31, count - 2**32, count)  # a 32-bit register
        state = reckon(PARTS, state, one._replace(ticks=buffer))
    assert state.pose == pytest.approx(reckoned(observations()).pose) != pytest.approx([0, 0, 0])
    assert buffer[0] < 0  # it did pass


@pytest.mark.parametrize("leap", [1000.0, -0.5, nan, inf])
def test_one_bad_time_costs_one_reading(leap):
    whole = list(observations())
    whole[20] = whole[20]._replace(time=whole[20].time + leap)
    state = reckoned(whole)
    assert state.rejected == 1 and state.fresh
    assert state.pose == pytest.approx(reckoned(observations()).pose)


@pytest.mark.parametrize("leap", [1000.0, -0.4])
def test_a_clock_that_goes_on_elsewhere_is_believed_after_a_while_and_no_way_is_lost(leap):
    whole = [o._replace(time=o.time + leap * (k >= 20)) for k, o in enumerate(observations())]
    state = reckoned(whole)
    assert state.fresh and state.rejected == autopilot.sensing.PATIENCE
    assert state.pose == pytest.approx(reckoned(observations()).pose)


@pytest.mark.parametrize("ticks", [[nan, 0, 0], [inf, 0, 0], [1e300, 0, 0]])
def test_counters_that_are_no_numbers_cost_one_reading(ticks):
    whole = list(observations())
    whole[20] = whole[20]._replace(ticks=np.array(ticks))
    state = reckoned(whole)
    assert state.rejected == 1 and state.pose == pytest.approx(reckoned(observations()).pose)


@pytest.mark.parametrize("rate", [34.9, -20.0, 1e300])
def test_one_rate_that_nothing_explains_is_bridged_by_the_wheels(rate):
    whole = list(observations())
    whole[20] = whole[20]._replace(gyro=np.array([[0.0, 0.0, rate]]))
    state = reckoned(whole)
    assert state.rejected == 1 and state.pose == pytest.approx(reckoned(observations()).pose)


def test_a_fast_turn_that_goes_on_is_believed_though_the_wheels_are_silent():
    turning = [o._replace(gyro=np.array([[0.0, 0.0, 5.0]])) for o in observations(60)]
    state = reckoned([*observations(1), *turning[1:]])
    assert state.pose[2] == pytest.approx(5.0 * 0.02 * 58, rel=0.05) and state.rejected == 1


def test_readings_of_another_shape_are_refused_by_name():
    one = next(observations())
    with pytest.raises(ValueError, match=r"observation\.ticks: expected shape \(3,\)"):
        reckon(PARTS, Reckoning.at([0, 0, 0]), one._replace(ticks=np.zeros(2)))
    with pytest.raises(ValueError, match=r"observation\.gyro: expected shape \(n, 3\)"):
        reckon(PARTS, Reckoning.at([0, 0, 0]), one._replace(gyro=np.zeros(3)))


def test_without_a_gyroscope_the_wheels_turn_the_heading():
    log = worlds.simulated_drive(7, "ideal", 8.0)
    state = Reckoning.at(log.poses[0])
    for one in log.observations:
        state = reckon(PARTS, state, one._replace(gyro=np.empty((0, 3))))
    assert state.pose == pytest.approx(log.poses[-1], abs=0.03)


def seen_by(readings: dict[str, float]) -> Observation:
    """An observation in which only some LiDARs say something."""
    zero = np.zeros((0, 3))
    lidar = tuple(LidarReading(0.0, readings.get(m.name, 0.0), 500, 25.0) for m in LIDARS)
    return Observation(
        0.0, np.zeros(3, int), np.empty(0), zero, zero, lidar, np.zeros(4), np.zeros(4), 24.0
    )


@pytest.mark.parametrize(
    ("heading", "name", "y"),
    [(0.0, "left", 9.99), (pi / 2, "front", 9.99), (-pi / 2, "rear", 9.99), (pi, "right", 9.99)],
)
def test_the_lidar_that_looks_at_the_far_fence_tells_how_far_up_the_robot_is(heading, name, y):
    assert lidar_y(seen_by({name: 1.70}), heading) == pytest.approx(y)


def test_a_lidar_that_looks_aslant_is_corrected_and_one_too_far_aslant_is_not_asked():
    turn = np.radians(10.0)
    # the left LiDAR at (0.12, 0.31), turned by 10 degrees; 1.7 m along the slanting beam
    expected = 12.0 - 1.7 * np.cos(turn) - (0.12 * np.sin(turn) + 0.31 * np.cos(turn))
    assert lidar_y(seen_by({"left": 1.7}), turn) == pytest.approx(expected)
    assert np.isnan(lidar_y(seen_by({"left": 1.7}), np.radians(45.0)))
    assert np.isnan(lidar_y(seen_by({"front": 1.7}), 0.0))  # the left one says nothing


@pytest.mark.parametrize(
    "reading", [(1.7, 99), (1.7, 65535), (0.0, 500), (inf, 500), (nan, 500), (-1.0, 500)]
)
def test_a_lidar_that_does_not_trust_itself_is_not_asked(reading):
    seen = seen_by({})
    lidar = [LidarReading(0.0, *reading, 25.0) for _ in LIDARS]
    assert np.isnan(lidar_y(seen._replace(lidar=tuple(lidar)), 0.0))
    assert np.isnan(lidar_y(seen._replace(lidar=()), 0.0)) and np.isnan(lidar_y(seen, inf))


# --- all together ----------------------------------------------------------------------------


def check_drive(run: worlds.FieldDrive) -> None:
    """What a drive to Area 3 has to reach; all errors are those of the truth."""
    assert run.arrived and run.reason == "arrived"
    assert run.contacts == 0
    assert run.away < 0.2 and run.lidar_y > field.AREA_3_LINE
    assert run.off <= 0.03
    assert run.duration <= 1.15 * run.limit


@pytest.mark.parametrize("student", [1, 2, "H1D021001"])
def test_the_robot_arrives_in_area_3_by_its_own_sensors(student):
    check_drive(worlds.field_drive(student))


@pytest.mark.campaign
def test_a_hundred_robots_arrive_in_area_3(whole):
    runs = [worlds.field_drive(seed) for seed in range(1, 101 if whole else 6)]
    for run in runs:
        check_drive(run)
    # Noise is really there: no two robots end at one place, and odometry is off by millimetres.
    ends = np.array([run.poses[-1, :2] for run in runs])
    assert len(np.unique(ends.round(4), axis=0)) == len(runs)
    assert np.median([run.away for run in runs]) > 0.002


def test_on_a_worn_floor_with_tired_motors_it_arrives_and_is_farther_off():
    good, worn = (worlds.field_drive(3, kind=kind) for kind in ("noisy", "degraded"))
    assert worn.arrived and worn.contacts == 0 and worn.off > good.off


def test_the_same_student_gets_the_same_drive_to_the_bit():
    first, second = (worlds.field_drive(5, goal=(0.6, 2.0)) for _ in range(2))
    assert first.poses.tobytes() == second.poses.tobytes()
    other = worlds.field_drive(6, goal=(0.6, 2.0))
    assert other.poses.shape != first.poses.shape or (other.poses != first.poses).any()


def test_a_drive_that_is_not_calibrated_misses_for_its_truth_is_nobodys_to_ask():
    parts = replace(PARTS, calibrate_wheels=lambda wheels, *_: wheels)
    runs = [worlds.field_drive(4, own) for own in (PARTS, parts)]
    assert runs[1].away > 3 * runs[0].away


def driving(route=None, rest=0.1) -> Pilot:
    """A pilot on the way along x, from the origin."""
    return Pilot(PARTS, route or along_x(), (0.0, 0.0, 0.0), DEAD_WHEELS, rest=rest)


BAD = {
    "time": [nan, inf, -inf, 1e300, -1e300, 0.0],
    "ticks": [np.full(3, value) for value in (nan, inf, -inf, 1e300, 0.0)],
    "gyro": [np.full((2, 3), value) for value in (nan, inf, 1e300, 35.0)] + [np.empty((0, 3))],
    "accel": [np.full((2, 3), nan), np.empty((0, 3))],
    "module_angles": [np.full(4, value) for value in (nan, inf, 1e300)],
    "module_speeds": [np.full(4, nan)],
    "battery": [nan],
    "lidar": [(), tuple(LidarReading(nan, nan, 0, nan) for _ in LIDARS)],
}


@pytest.mark.parametrize("at", [0, 3, 30])
@pytest.mark.parametrize(
    ("field_name", "number"),
    [(name, k) for name, values in BAD.items() for k in range(len(values))],
)
def test_whatever_a_sensor_says_once_there_is_a_command_and_the_drive_goes_on(
    field_name, number, at
):
    """At first, while it rests, while it drives."""
    pilot = driving()
    for k, one in enumerate(observations(60)):
        if k == at:
            one = one._replace(**{field_name: BAD[field_name][number]})
        speeds, _ = pilot.tick(one).checked()
        assert np.abs(speeds).max() <= 3.2
    assert speeds.any() and pilot.reckoning.fresh
    assert pilot.reckoning.pose == pytest.approx([1.18, 0.0, 0.0], abs=0.05)


@pytest.mark.parametrize("bad", [{"time": nan}, {"ticks": np.full(3, nan)}, {"time": 0.5}])
def test_a_robot_that_sees_nothing_any_more_stops_and_counts(bad):
    pilot = driving()
    for k, one in enumerate(observations(80)):
        command = pilot.tick(one._replace(**bad) if k >= 40 else one)
    assert not np.any(command.speeds) and pilot.rejected >= 40 - autopilot.sensing.PATIENCE


def test_it_has_arrived_only_where_it_stands_and_the_lidar_agrees():
    path = np.array([[4.3, 9.0], [4.3, 9.5], [4.3, 10.0]])
    route = autopilot.Route(path, distance_along(path), np.zeros(3))
    pilot = Pilot(PARTS, route, (4.3, 10.0, 0.0), DEAD_WHEELS, rest=0.05)
    for one in observations(20, speed=0.0):
        pilot.tick(one._replace(lidar=seen_by({"left": 1.7}).lidar))
    assert pilot.arrived
    for left in (0.0, 3.4):  # no reading; y = 8.29 m, before the line
        pilot.seen = one._replace(lidar=seen_by({"left": left}).lidar)
        assert not pilot.arrived
    pilot.seen = one._replace(lidar=seen_by({"left": 1.7}).lidar)
    pilot.reckoning = pilot.reckoning._replace(pose=np.array([4.3, 9.7, 0.0]))
    assert not pilot.arrived  # 0.3 m away


def test_the_speed_is_looked_up_a_little_ahead():
    route = along_x()  # 1 m/s, braking with 2 m/s² over the last 25 cm
    state = Following.begin(route)._replace(speed=1.0)
    at, later = (follow_step(PARTS, state, route, [x, 0.0, 0.0], 0.02).speed for x in (2.7, 2.75))
    assert at == pytest.approx(1.0) and later == pytest.approx(np.sqrt(2 * 2.0 * 0.2), abs=0.01)


def test_a_steady_drift_is_taken_back_by_the_integral():
    route, ends = along_x(20.0), []
    for k_i in (0.0, FollowSettings().across.k_i):
        settings = autopilot.FollowSettings(
            across=autopilot.FollowSettings().across._replace(k_i=k_i)
        )
        pose, state = np.zeros(3), Following.begin(route)
        for _ in range(1500):
            state = follow_step(PARTS, state, route, pose, 0.01, settings=settings)
            pose = pose + 0.01 * np.add(state.twist, (0.0, 0.1, 0.0))  # a slanting floor
        ends.append(abs(pose[1]))
    assert ends[1] < 0.5 * ends[0]


def test_a_heading_that_is_none_is_refused():
    with pytest.raises(ValueError, match="heading: expected an angle"):
        follow_step(PARTS, Following.begin(along_x()), along_x(), [0, 0, 0], 0.02, heading=nan)


def test_a_robot_whose_parts_lead_nowhere_is_stopped_and_told_so():
    lame = replace(PARTS, speed_profile=lambda xy, *_: np.full(len(xy), 0.06))
    run = worlds.field_drive(1, lame, goal=(0.6, 0.9))
    assert run.arrived  # creeping, but there
    stuck = replace(PARTS, field_to_robot=lambda twist, theta: np.zeros(3))
    run = worlds.field_drive(1, stuck, goal=(0.6, 0.9))
    assert not run.arrived and run.reason.startswith("stopped for being late, 0.5")


def test_it_rests_before_it_goes_and_learns_its_gyroscopes_bias():
    route = plan_route(PARTS, FIELD, field.START, (0.6, 2.0))
    pilot = Pilot(PARTS, route, (*field.START, 0.0), worlds.calibrated_wheels(3), rest=1.0)
    robot = worlds.to_area_3._robot(3, "noisy", 10.0, PARTS)[0]
    for _ in range(50):
        command = pilot.tick(robot.read())
        robot.apply(command)
        robot.step(0.02)
        assert np.asarray(command.speeds).tolist() == [0.0] * 4
    bias = robot.sensors.imu.gyro_bias[2]
    assert pilot.reckoning.heading.bias == pytest.approx(bias, abs=np.radians(0.02))
    assert np.asarray(pilot.tick(robot.read()).speeds).any()


def test_a_goal_before_area_3_needs_no_lidar():
    run = worlds.field_drive(2, goal=(0.6, 6.0))
    assert run.arrived and "LiDAR" not in " ".join(run.lines)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [({"kind": "perfect"}, "kind: expected one of ideal, noisy, degraded"),
     ({"goal": (1.0,)}, "goal: expected shape")],
)  # fmt: skip
def test_a_drive_that_makes_no_sense_is_refused(options, sentence):
    with pytest.raises(ValueError, match=sentence):
        worlds.field_drive(1, **options)


# --- on a student's own parts ----------------------------------------------------------------


def test_on_parts_that_are_all_a_students_own_the_robot_arrives_in_area_3():
    parts = solved_parts()
    assert parts.label == "mine" and parts.astar.__module__ != PARTS.astar.__module__
    check_drive(worlds.field_drive(1, parts))


@pytest.mark.campaign
def test_a_hundred_robots_arrive_on_a_students_own_parts(whole):
    for seed in range(1, 101 if whole else 3):
        check_drive(worlds.field_drive(seed, solved_parts()))
