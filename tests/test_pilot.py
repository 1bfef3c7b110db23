"""From the start zone to Area 3: route, following, dead reckoning step by step, and all together.

The suite drives three robots; the campaign a hundred.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import hypot, inf, nan, pi
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from conftest import ROOT
from robocon_course import autopilot, field, lessons, worlds
from robocon_course.autopilot import (
    DriveLimits,
    Following,
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
from robocon_course.exercises import registry, robot_parts
from robocon_course.exercises.model import Exercise
from robocon_course.exercises.source import assemble, from_cells
from robocon_course.exercises.workspace import Workspace
from robocon_course.geometry import distance_along
from robocon_course.gridmap import GridMap
from robocon_course.planning import NoPathError, line_of_sight
from robocon_course.robot import LIDARS, SIDE, LidarReading, Observation
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
    return to_area_3()._replace(
        xy=xy, along=distance_along(xy), speeds=speed_profile(xy, speed, 2.0, 1.5)
    )


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


def test_an_observation_that_is_not_later_changes_nothing():
    log = worlds.simulated_drive(7, "ideal", 4.0)
    state = reckon(PARTS, Reckoning.at(log.poses[0]), log.observations[0])
    state = reckon(PARTS, state, log.observations[190])
    assert reckon(PARTS, state, log.observations[190]) is state
    assert reckon(PARTS, state, log.observations[3]) is state


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


def test_the_truth_never_reaches_the_pilot():
    """With the wrong sizes of its wheels it misses, though the simulator knows better."""

    def uncalibrated(wheels, *_):
        return wheels

    parts = replace(PARTS, calibrate_wheels=uncalibrated)
    runs = [worlds.field_drive(4, own) for own in (PARTS, parts)]
    assert runs[1].away > 3 * runs[0].away


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


@cache
def solved_parts() -> Parts:
    """The parts that a student has who solved every lesson as its solution does, plain Python."""
    with TemporaryDirectory() as folder:
        workspace = Workspace(folder)
        for about in registry.chapters():
            source = lessons.read_source(ROOT / "solutions" / f"{about.name}.py")
            cells = [cell.source for cell in source.cells if cell.cell_type == "code"]
            for exercise in about.exercises:
                if isinstance(exercise, Exercise):
                    answer = assemble(exercise.function_name, from_cells(cells))
                    workspace.accept(exercise.id, answer.text)
        return robot_parts("mine", workspace=workspace)


def test_on_parts_that_are_all_a_students_own_the_robot_arrives_in_area_3():
    parts = solved_parts()
    assert parts.label == "mine" and parts.astar.__module__ != PARTS.astar.__module__
    check_drive(worlds.field_drive(1, parts))


@pytest.mark.campaign
def test_a_hundred_robots_arrive_on_a_students_own_parts(whole):
    for seed in range(1, 101 if whole else 3):
        check_drive(worlds.field_drive(seed, solved_parts()))
