"""Wheels that grip and slide, slopes, walls: against hand calculations and a naive twin."""

from __future__ import annotations

from dataclasses import replace
from math import atan, cos, exp, pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course.geometry import GRAVITY
from robocon_course.robot import DEAD_WHEELS, MODULES, SIDE
from robocon_course.simulator import RobotModel, physics
from robocon_course.simulator.model import game_field
from robocon_course.simulator.physics import TICK

FLAT = np.array([[-100.0, -100.0, 100.0, 100.0, 0.0, 0.0, 0.0]])
NOTHING = np.empty((0, 4))
SPIN = np.arctan2(MODULES[:, 1], MODULES[:, 0]) + pi / 2  # every wheel along its circle
RADIUS = float(np.hypot(*MODULES[0]))
MODEL = RobotModel()


def robot(pose=(0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), speeds=0.0, angles=0.0):
    state = physics.State.at_rest(np.array(pose, float), MODEL.body())
    state.velocity[:3] = velocity
    state.angles[:] = angles
    state.speeds[:] = speeds
    return state


def run(state, seconds, speeds=0.0, angles=0.0, *, model=MODEL, floor=FLAT, boxes=NOTHING):
    """Every row of the track, after setting the robot on the floor."""
    ticks = round(seconds / TICK)
    track = np.zeros((ticks, physics.TRACK))
    command = np.array([np.zeros(4) + speeds, np.zeros(4) + angles])
    world = physics.World(np.array(floor, float), np.array(boxes, float))
    physics.advance(state, command, model.body(), world, TICK, 0, 0, track)
    physics.advance(state, command, model.body(), world, TICK, 0, ticks, track)
    return track


# --- rolling -------------------------------------------------------------------------------------


def test_one_metre_a_second_for_one_second_is_one_metre():
    state = robot(velocity=(1.0, 0.0, 0.0), speeds=1.0)
    run(state, 1.0, 1.0)
    np.testing.assert_allclose(state.pose, [1.0, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(state.travel, [1.0, 1.0, 0.0], atol=1e-12)


def test_wheels_along_their_circle_turn_the_robot_on_the_spot():
    omega = 2.0
    state = robot(velocity=(0.0, 0.0, omega), speeds=omega * RADIUS, angles=SPIN)
    run(state, 1.0, omega * RADIUS, SPIN)
    np.testing.assert_allclose(state.pose, [0.0, 0.0, omega], atol=1e-5)
    half_track, rear = 0.5377 / 2, 0.2745
    np.testing.assert_allclose(
        state.travel, omega * np.array([-half_track, half_track, -rear]), atol=1e-5
    )


def test_on_a_circle_it_drives_ahead_and_comes_back():
    velocity, omega = np.array([1.0, 0.0]), 2.0
    over = velocity + omega * MODULES[:, ::-1] * (-1.0, 1.0)
    speeds, angles = np.hypot(*over.T), np.arctan2(over[:, 1], over[:, 0])
    state = robot(velocity=(1.0, 0.0, omega), speeds=speeds, angles=angles)
    track = run(state, pi, speeds, angles)
    along = np.cos(track[:, 2]) * track[:, 3] + np.sin(track[:, 2]) * track[:, 4]
    across = np.cos(track[:, 2]) * track[:, 4] - np.sin(track[:, 2]) * track[:, 3]
    np.testing.assert_allclose(along, 1.0, atol=1e-4)
    # Half a step late would be 2 mm/s sideways. The grip that turns it takes some creep, outwards.
    creep = physics.CREEP * 1.0 * omega / (0.6 * GRAVITY)
    np.testing.assert_allclose(across[9:], -creep, rtol=0.02)
    np.testing.assert_allclose(state.pose[:2], 0.0, atol=1e-3)  # the last step ends 0.4 ms early
    np.testing.assert_allclose(track[785, :2], [0.0, 1.0], atol=4e-3)


def test_a_wheel_nears_its_speed_with_its_lag():
    state = robot()
    track = run(state, 0.2, 0.1)  # 0.1 m/s in 0.05 s is 2 m/s^2: within the grip
    wanted = 0.1 * (1.0 - (1.0 - TICK / 0.05) ** np.arange(1, 101))
    np.testing.assert_allclose(track[:, 3], wanted, atol=physics.CREEP)
    assert track[-1, 3] == pytest.approx(0.1 * (1.0 - exp(-4.0)), rel=0.01)


def test_a_module_turns_the_shorter_way_and_no_faster_than_it_can():
    state = robot(angles=3.0)
    ticks = [run(state, TICK, angles=-3.0) is not None and state.angles[0] for _ in range(30)]
    assert ticks[0] == pytest.approx(3.0 + TICK * (2 * pi - 6.0) / 0.05)
    assert ticks[-1] < -3.0  # past pi
    state = robot()
    run(state, 0.1, angles=2.5)
    assert state.angles[0] == pytest.approx(12.0 * 0.1)


def test_steady_driving_creeps_by_less_than_half_a_per_cent():
    for speeds, angles in ((0.3, 0.0), (3.0, 1.0), (0.5, SPIN)):
        state = robot()
        run(state, 1.5, speeds, angles)
        before = state.travel.copy()
        track = run(state, 1.0, speeds, angles)
        way = np.hypot(*np.diff(track[[0, -1], :2], axis=0)[0]) + RADIUS * np.ptp(track[:, 2])
        assert way / (499 * TICK) == pytest.approx(speeds, rel=1e-3)
        assert np.abs(state.travel - before).max() > 0.1


@given(st.floats(-pi, pi), st.lists(st.floats(-2.0, 2.0), min_size=8, max_size=8))
@settings(max_examples=30, deadline=None)
def test_the_map_has_no_favourite_direction(turn, numbers):
    speeds, angles = np.array(numbers[:4]), np.array(numbers[4:])
    one, other = robot(), robot(pose=(1.0, -2.0, turn))
    run(one, 0.4, speeds, angles)
    run(other, 0.4, speeds, angles)
    c, s = np.cos(turn), np.sin(turn)
    x, y, theta = one.pose
    np.testing.assert_allclose(
        other.pose, [1.0 + c * x - s * y, -2.0 + s * x + c * y, turn + theta], atol=1e-7
    )


@given(st.lists(st.floats(-2.0, 2.0), min_size=8, max_size=8))
@settings(max_examples=30, deadline=None)
def test_left_and_right_are_mirror_images(numbers):
    speeds, angles = np.array(numbers[:4]), np.array(numbers[4:])
    swap = [3, 2, 1, 0]  # front left <-> front right, rear left <-> rear right
    one, other = robot(), robot()
    run(one, 0.4, speeds, angles)
    run(other, 0.4, speeds[swap], -angles[swap])
    np.testing.assert_allclose(other.pose, one.pose * (1.0, -1.0, -1.0), atol=1e-7)
    np.testing.assert_allclose(other.travel[[1, 0, 2]], one.travel * (1, 1, -1), atol=1e-7)


# --- grip ----------------------------------------------------------------------------------------


@given(st.lists(st.floats(-3.2, 3.2), min_size=8, max_size=8), st.floats(0.1, 1.2))
@settings(max_examples=40, deadline=None)
def test_no_command_pushes_harder_than_friction(numbers, friction):
    state = robot()
    model = replace(MODEL, friction=friction, drive_acceleration=1e3, drive_lag=0.0)
    track = run(state, 0.3, numbers[:4], numbers[4:], model=model)
    push = np.hypot(*np.diff(track[:, 3:5], axis=0).T) / TICK
    assert push.max() <= friction * GRAVITY * (1.0 + 1e-9)


def test_below_the_limit_wheels_hold_and_beyond_it_they_slide():
    gentle = replace(MODEL, drive_acceleration=5.0, drive_lag=0.0)
    state = robot()
    run(state, 0.4, 3.0, model=gentle)
    assert state.speeds[0] - state.velocity[0] < physics.CREEP
    harsh = replace(MODEL, drive_acceleration=20.0, drive_lag=0.0)
    state = robot()
    run(state, 0.1, 3.0, model=harsh)
    assert state.speeds[0] == pytest.approx(2.0)
    assert state.velocity[0] == pytest.approx(0.6 * GRAVITY * 0.1, rel=1e-6)


def test_locked_wheels_slide_as_far_as_the_textbook_says():
    state = robot(velocity=(2.0, 1.0, 0.0))
    track = run(state, 1.0)
    way = np.hypot(*track[-1, :2])
    assert way == pytest.approx(5.0 / (2.0 * 0.6 * GRAVITY), rel=0.01)  # v^2 / 2 mu g; one tick off
    np.testing.assert_array_equal(track[-1, 3:5], 0.0)


def test_a_weak_motor_pushes_with_what_it_has_and_does_not_spin_its_wheel():
    weak = replace(MODEL, drive_force=10.0)  # four of them: 1.616 m/s^2; the floor would hold 5.9
    state = robot()
    track = run(state, 0.5, 3.0, model=weak)
    pushes = np.diff(track[:, 3]) / TICK
    np.testing.assert_allclose(pushes[50:], 40.0 / MODEL.mass, rtol=1e-6)
    np.testing.assert_allclose(state.speeds, state.velocity[0], atol=2 * physics.CREEP)


def test_a_weak_motor_brakes_no_harder_than_it_drives():
    state = robot(velocity=(2.0, 0.0, 0.0), speeds=2.0)
    run(state, 0.5, 0.0, model=replace(MODEL, drive_force=10.0))
    assert state.velocity[0] == pytest.approx(2.0 - 0.5 * 40.0 / MODEL.mass, abs=0.05)


@pytest.mark.parametrize("force, rolls", [(20.0, 0.0), (60.0, 1.0)])
def test_against_a_wall_a_weak_motor_stalls_and_a_strong_one_spins(force, rolls):
    wall = [[MODEL.side / 2, -5.0, 6.0, 5.0]]
    state = robot()
    run(state, 1.0, 1.0, model=replace(MODEL, drive_force=force), boxes=wall)
    # What a push gives in one step, 6.5 mm/s, the wall takes only after the wheels have felt it.
    np.testing.assert_allclose(state.speeds, rolls, atol=0.01)


@pytest.mark.parametrize("force, climbs", [(5.5, False), (6.5, True)])  # 24.16 N / 4 = 6.04 N
def test_a_motor_weaker_than_the_slope_does_not_climb_it(force, climbs):
    slope = [[-100.0, -100.0, 100.0, 100.0, 0.0, 0.1, 0.0]]
    state = robot()
    run(state, 2.0, 1.0, model=replace(MODEL, drive_force=force), floor=slope)
    assert state.pose[0] > 0.05 if climbs else state.pose[0] < -0.05


def test_on_a_slope_a_wheel_whose_motor_gives_all_keeps_the_speed_along_the_slope():
    slope = [[-100.0, -100.0, 100.0, 100.0, 0.0, 0.1, 0.0]]
    state = robot()
    run(state, 6.0, 3.2, model=replace(MODEL, drive_force=12.0), floor=slope)
    assert state.speeds[0] == pytest.approx(3.2, abs=1e-3)
    # the map sees 1 / sqrt(1.01) of it
    assert state.velocity[0] == pytest.approx(3.2 / sqrt(1.01), abs=physics.CREEP)


def test_slip_is_what_the_drive_wheels_roll_more_than_the_dead_wheels():
    state = robot()
    model = replace(MODEL, friction=0.1)
    run(state, 0.5, 2.0, model=model)
    # the wheels are at 2 m/s after 0.25 s, the body gains 0.1 g all the time
    assert state.travel[0] == pytest.approx(0.5 * 0.1 * GRAVITY * 0.5**2, rel=0.01)


def naive(seconds, speeds, angles, friction, h=2e-5):
    """Explicit steps, a hundred times as fine, of the law as it is written."""
    x, y, theta, vx, vy, omega = np.zeros(6)
    wheel, most = np.zeros(4), friction * MODEL.mass * GRAVITY / 4
    for _ in range(round(seconds / h)):
        wheel += h * np.clip((speeds - wheel) / 0.05, -8.0, 8.0)
        c, s = np.cos(theta), np.sin(theta)
        rx, ry = c * MODULES[:, 0] - s * MODULES[:, 1], s * MODULES[:, 0] + c * MODULES[:, 1]
        slip_x = wheel * np.cos(theta + angles) - (vx - omega * ry)
        slip_y = wheel * np.sin(theta + angles) - (vy + omega * rx)
        share = most / np.maximum(np.hypot(slip_x, slip_y), physics.CREEP)
        fx, fy = share * slip_x, share * slip_y
        vx, vy = vx + h * fx.sum() / MODEL.mass, vy + h * fy.sum() / MODEL.mass
        omega += h * (rx * fy - ry * fx).sum() / (MODEL.mass * SIDE**2 / 6)
        x, y, theta = x + h * vx, y + h * vy, theta + h * omega
    return np.array([x, y, theta])


@pytest.mark.parametrize("friction", [0.15, 0.6])
def test_the_steps_agree_with_a_naive_twin_that_takes_a_hundred_times_as_many(friction):
    speeds, angles = np.array([1.0, 0.4, -0.3, 0.8]), np.array([0.2, 1.0, -0.5, 2.0])
    state = robot(angles=angles)
    run(state, 0.3, speeds, angles, model=replace(MODEL, friction=friction))
    # First order in the step, where wheels begin and end to slide; taking the slip anew only once
    # a step comes out at 0.9 mrad.
    np.testing.assert_allclose(state.pose, naive(0.3, speeds, angles, friction), atol=7e-4)


def test_a_battery_with_resistance_gives_less_speed_under_load():
    fresh, weak = robot(), robot()
    run(fresh, 0.4, 3.2)
    model = replace(MODEL, resistance=0.5)
    run(weak, 0.4, 3.2, model=model)
    assert weak.battery[0] < 20.0 < fresh.battery[0] == 24.0
    assert weak.velocity[0] < fresh.velocity[0]
    run(weak, 2.0, 3.2, model=model)
    assert weak.velocity[0] == pytest.approx(3.2, abs=0.01)  # no load at a steady speed


def test_braking_does_not_charge_the_battery():
    state = robot(velocity=(3.0, 0.0, 0.0), speeds=3.0)
    volts = []
    for _ in range(150):
        run(state, TICK, 0.0, model=replace(MODEL, resistance=0.5))
        volts.append(state.battery[0])
    assert state.velocity[0] < 1.5 and max(volts) <= 24.0 and min(volts) < 22.0


# --- slopes --------------------------------------------------------------------------------------

SHIFTED = MODULES + np.array([0.05, -0.02])
TRAPEZOID = np.array([(0.25, 0.15), (-0.2, 0.25), (-0.2, -0.25), (0.25, -0.1)])


@pytest.mark.parametrize("modules", [MODULES, SHIFTED, TRAPEZOID])
def test_wherever_the_modules_are_a_flat_floor_is_flat_and_a_slope_has_its_rise(modules):
    model = replace(MODEL, modules=modules)
    raised = [[-100.0, -100.0, 100.0, 100.0, 0.2, 0.0, 0.0]]
    track = run(robot(pose=(1.0, 2.0, 0.7)), 1.0, model=model, floor=raised)
    np.testing.assert_allclose(track[-1], [1.0, 2.0, 0.7, 0, 0, 0, 0, 0, 0.2], atol=1e-12)
    track = run(robot(pose=(1.0, 2.0, 0.0)), TICK, model=model, floor=SLOPE)
    x, _, theta = track[-1, :3]
    wanted = [0.1 * cos(theta), -0.1 * np.sin(theta), 20.0 + 0.1 * x]
    np.testing.assert_allclose(track[-1, 6:], wanted, atol=1e-12)


SLOPE = np.array([[-100.0, -100.0, 100.0, 100.0, 10.0, 0.1, 0.0]])


def test_on_a_slope_the_robot_stands_and_tilts():
    state = robot(pose=(0.0, 0.0, 0.3))
    track = run(state, 5.0, floor=SLOPE)
    # It creeps by the share of the grip that it needs: 0.1 / 0.6 of 1 mm/s.
    assert abs(track[-1, 0]) < 5.0 * physics.CREEP * 0.1 / 0.6 * 1.05
    np.testing.assert_allclose(track[-1, 6:8], [0.1 * cos(0.3), -0.1 * np.sin(0.3)], atol=1e-12)
    assert np.degrees(atan(0.1)) == pytest.approx(5.7, abs=0.02)


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.0])
def test_without_enough_grip_it_slides_down_as_the_inclined_plane_says(heading):
    state = robot(pose=(0.0, 0.0, heading))
    run(state, 1.0, floor=SLOPE, model=replace(MODEL, friction=0.05))
    angle = atan(0.1)
    along = GRAVITY * (np.sin(angle) - 0.05 * cos(angle))
    assert state.velocity[0] == pytest.approx(-along * cos(angle), rel=0.01)
    assert abs(state.velocity[1]) < 1e-3


def test_wheels_roll_along_the_slope_and_the_map_sees_the_horizontal_part():
    state = robot(speeds=1.0, velocity=(sqrt(1 / 1.01), 0.0, 0.0))
    track = run(state, 1.0, 1.0, floor=SLOPE)
    assert track[-1, 0] == pytest.approx(1.0 / sqrt(1.01), abs=2e-4)
    assert state.travel[0] == pytest.approx(track[-1, 0] * sqrt(1.01), abs=1e-12)
    assert track[-1, 8] == pytest.approx(20.0 + 0.1 * track[-1, 0])
    assert track[-1, 5] == pytest.approx(0.1 * track[-1, 3])


def test_both_ramps_of_the_field_are_climbed_without_a_jump():
    world = game_field()
    for start, end in (((0.5, 2.0), 5.5), ((4.3, 6.0), 9.0)):
        state = robot(pose=(*start, 0.0), angles=pi / 2)
        track = run(state, 3.6, 1.0, pi / 2, floor=world.floor, boxes=world.boxes)
        assert track[-1, 1] > end and state.contact[1] == 0
        assert np.ptp(track[:, 8]) == pytest.approx(0.1, abs=1e-12)
        # 1 m/s on a rise of 0.1 climbs 0.2 mm a tick, and the wheels enter two by two
        assert np.abs(np.diff(track[:, 8])).max() < 2.1e-4
        assert track[:, 7].max() == pytest.approx(0.1, abs=1e-12)


# --- walls ---------------------------------------------------------------------------------------

WALL = [(1.0, -50.0, 2.0, 50.0)]


def corners(pose):
    c, s = np.cos(pose[2]), np.sin(pose[2])
    square = SIDE / 2 * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    return pose[:2] + square @ np.array([(c, s), (-s, c)])


def gap(pose, box):
    """Separating axes, from the corners."""
    body = corners(pose)
    x0, y0, x1, y1 = box
    other = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    best = -np.inf
    for angle in (0.0, pi / 2, pose[2], pose[2] + pi / 2):
        axis = np.array([np.cos(angle), np.sin(angle)])
        a, b = body @ axis, other @ axis
        best = max(best, a.min() - b.max(), b.min() - a.max())
    return best


@given(
    st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-4.0, 4.0),
    st.floats(0.03, 1.5), st.floats(0.03, 1.5),
)  # fmt: skip
@settings(max_examples=200, deadline=None)
def test_the_gap_to_a_box_is_that_of_the_naive_twin(x, y, theta, width, depth):
    pose, box = np.array([x, y, theta]), np.array([0.0, 0.0, width, depth])
    found, nx, ny = physics._gap_to(pose, SIDE / 2, box)
    assert found == pytest.approx(gap(pose, box), abs=1e-8)
    assert nx * nx + ny * ny == pytest.approx(1.0)
    if found < 0.0:  # the way out is a way out
        assert gap(pose - found * np.array([nx, ny, 0.0]), box) == pytest.approx(0.0, abs=1e-8)


def test_a_hit_square_on_stops_the_robot_and_does_not_turn_it():
    state = robot(velocity=(3.0, 0.0, 0.0), speeds=3.0)
    track = run(state, 1.0, 3.0, boxes=WALL)
    np.testing.assert_allclose(state.pose, [1.0 - SIDE / 2, 0.0, 0.0], atol=1e-4)
    assert np.abs(track[-1, 3:5]).max() < 0.02 and track[:, 0].max() < 1.0 - SIDE / 2 + 1e-9
    assert state.contact.tolist() == [1, 1]
    assert state.travel[0] == pytest.approx(1.0 - SIDE / 2, abs=1e-4)


def hit(velocity, arm, normal, wall_friction):
    """Velocity after a hit without bounce: Baraff 8-18 with restitution 0, Coulomb across it."""
    mass, inertia = MODEL.mass, MODEL.mass * SIDE**2 / 6
    jacobian = [np.array([*d, arm[0] * d[1] - arm[1] * d[0]]) for d in (normal, np.roll(normal, 1))]
    inverse = np.array([1.0, 1.0, mass / inertia]) / mass
    push, drag = (-(row @ velocity) / (row @ (inverse * row)) for row in jacobian)
    drag = np.clip(drag, -wall_friction * push, wall_friction * push)
    return velocity + inverse * (push * jacobian[0] + drag * jacobian[1])


@pytest.mark.parametrize("wall_friction", [0.0, 0.3, 5.0])
@pytest.mark.parametrize("slide", [1.5, -1.5])
def test_a_corner_s_hit_is_the_one_of_the_textbook(wall_friction, slide):
    c, s = cos(0.3), np.sin(0.3)
    corner = SIDE / 2 * np.array([c + s, s - c])  # the front right one, foremost at 0.3 rad
    velocity = np.array([2.0, slide, 0.0])
    state = robot(pose=(1.0 - corner[0] - 1e-3, 0.0, 0.3), velocity=velocity)
    run(state, TICK, model=replace(MODEL, friction=0.0, wall_friction=wall_friction), boxes=WALL)
    wanted = hit(velocity, corner, np.array([-1.0, 0.0]), wall_friction)
    np.testing.assert_allclose(state.velocity[:3], wanted, atol=1e-12)
    assert state.contact.tolist() == [1, 1]
    if wall_friction == 0.0:  # the corner no longer goes into the wall
        assert state.velocity[0] - state.velocity[2] * corner[1] == pytest.approx(0.0, abs=1e-12)


def test_of_two_corners_in_a_wall_the_deeper_one_counts_more():
    c, s = cos(0.02), np.sin(0.02)
    right, left = SIDE / 2 * np.array([(c + s, s - c), (c - s, s + c)])  # of the front
    pose = np.array([1.0 - left[0] + 0.002, 0.0, 0.02])  # the left one 2 mm deep
    deep = 0.002, 0.002 + right[0] - left[0]
    point = physics._meeting_point(pose, SIDE / 2, np.array(WALL[0]), -1.0, 0.0)
    np.testing.assert_allclose(point, (deep[0] * left + deep[1] * right) / sum(deep), atol=1e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_along_a_wall_friction_takes_its_share_of_the_push(way):
    # No grip, and a floor that falls towards the wall: the push is m g 0.1 / 1.01.
    ice = replace(MODEL, friction=0.0, wall_friction=0.3)
    downhill = [[-100.0, -100.0, 100.0, 100.0, 0.0, -0.1, 0.0]]
    state = robot(pose=(1.0 - SIDE / 2, 0.0, 0.0), velocity=(0.0, 2.0 * way, 0.0))
    track = run(state, 1.0, model=ice, floor=downhill, boxes=WALL)
    slowed = (2.0 - way * track[-1, 4]) / 1.0
    assert slowed == pytest.approx(0.3 * GRAVITY * 0.1 / 1.01, rel=0.02)
    assert np.abs(track[:, 2]).max() < 0.01 and state.contact.tolist() == [1, 1]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_hit_off_centre_turns_it_towards_the_wall(side):
    edge = [(1.0, min(0.1 * side, side), 2.0, max(0.1 * side, side))]
    state = robot(velocity=(2.0, 0.0, 0.0), speeds=2.0)
    track = run(state, 0.5, 2.0, boxes=edge)
    assert (side * track[:, 2]).min() >= 0.0  # and never the other way
    assert side * state.pose[2] > 0.2


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_end_of_a_ledge_turns_it_too(side):
    ledge = [(1.0, min(0.1 * side, 0.15 * side), 2.0, max(0.1 * side, 0.15 * side))]
    state = robot(velocity=(2.0, 0.0, 0.0), speeds=2.0)
    run(state, 0.4, 2.0, boxes=ledge)
    assert side * state.pose[2] > 0.1


def test_a_robot_without_grip_keeps_its_energy_until_a_wall_takes_some():
    ice = replace(MODEL, friction=0.0, wall_friction=0.0)
    rng = np.random.default_rng(4)
    box = [(-9, -9, -1, 9), (1, -9, 9, 9), (-9, -9, 9, -1), (-9, 1, 9, 9)]
    for _ in range(20):
        velocity = np.array([rng.uniform(1.5, 3.0), *rng.uniform(-3.0, 3.0, 2)])
        state = robot(pose=(0.0, 0.0, rng.uniform(-pi, pi)), velocity=velocity)
        energies = []
        for _ in range(300):
            run(state, TICK, model=ice, boxes=box)
            vx, vy, omega = state.velocity[:3]
            energies.append(vx * vx + vy * vy + SIDE**2 / 6 * omega * omega)
        assert np.diff(energies).max() < 1e-9 and energies[-1] < energies[0]


def test_along_the_fence_and_up_the_ramp_it_slides_without_catching():
    world = game_field()
    state = robot(pose=(SIDE / 2 + 0.01, 1.5, 0.0), angles=pi / 2 + 0.3)
    track = run(state, 5.0, 1.0, pi / 2 + 0.3, floor=world.floor, boxes=world.boxes)
    steady = track[500:]
    assert steady[:, 4].min() > 0.75 and state.contact[1] == 1
    assert np.abs(steady[:, 2]).max() < 1e-3 and state.pose[1] > 5.0


OPEN = [
    (3.0, 1.8),
    (0.5, 3.5),
    (2.0, 5.5),
    (4.3, 7.5),
    (4.5, 10.0),
    (1.1, 10.0),
    (5.3, 3.4),
    (5.4, 7.4),
]


@given(
    st.sampled_from(OPEN),
    st.floats(-pi, pi),
    st.lists(st.floats(-3.2, 3.2), min_size=4, max_size=4),
    st.lists(st.floats(-pi, pi), min_size=4, max_size=4) | st.floats(-pi, pi),
    st.sampled_from([TICK, 0.0005]),
)
@settings(max_examples=60, deadline=None)
def test_nothing_gets_into_a_wall_at_full_speed_from_any_side(place, theta, speeds, angles, h):
    world = game_field()
    model = replace(MODEL, friction=3.0, drive_acceleration=30.0)
    speeds = 3.2 if isinstance(angles, float) else speeds
    state = robot(pose=(*place, theta))
    track = np.zeros((10, physics.TRACK))
    command = np.array([np.zeros(4) + speeds, np.zeros(4) + angles])
    physics.advance(state, command, model.body(), world, h, 0, 0, track)
    area = state.floor[2]
    for _ in range(100):
        physics.advance(state, command, model.body(), world, h, 0, 10, track)
        assert min(gap(state.pose, box) for box in world.boxes) > -1e-3
        # a ledge of 0.1 m would show as a jump of the floor within 10 steps of at most 10 mm
        assert abs(state.floor[2] - area) < 0.02
        area = state.floor[2]


def test_the_fence_has_no_joints_and_reaches_outwards():
    boxes = game_field().boxes
    assert boxes[:, :2].min() <= -1.0 and boxes[:, 2:].max() >= 13.0
    for k, one in enumerate(boxes):
        for other in boxes[k + 1 :]:
            for a, b in ((0, 2), (1, 3)):
                flush = one[1 - a] == other[1 - a] and one[3 - a] == other[3 - a]
                assert not (flush and one[a] <= other[b] and other[a] <= one[b])


# --- the model -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mass": 0.0}, "mass: must be positive"),
        ({"side": float("nan")}, "side: must be positive"),
        ({"friction": -0.1}, "friction: must not be negative"),
        ({"drive_lag": float("inf")}, "drive_lag: must not be negative"),
        ({"modules": [[0.1, 0.1]] * 3}, r"modules: expected shape \(4, 2\)"),
        ({"modules": [[0.1, 0.1], [0.2, 0.2], [-0.1, -0.1], [0, 0]]}, "modules: they stand on"),
        ({"mass": "25"}, "mass: must be positive, got '25'"),
        ({"steering_lag": None}, "steering_lag: must not be negative, got None"),
        ({"dead_wheels": None}, "dead_wheels: expected TrackingWheels, got NoneType"),
        ({"modules": [[0.1, 0.0], [0.2, 0.0], [-0.1, 0.0], [0.3, 0.0]]}, "modules: they stand on"),
    ],
)
def test_numbers_that_make_no_robot_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        RobotModel(**change)


def test_a_model_keeps_its_own_modules():
    places = MODULES.copy()
    model = RobotModel(modules=places)
    places += 1.0
    np.testing.assert_array_equal(model.modules, MODULES)
    with pytest.raises(ValueError, match="read-only"):
        model.modules[0, 0] = 0.0


def test_a_worn_wheel_is_another_robot():
    worn = replace(MODEL, dead_wheels=replace(DEAD_WHEELS, radius=[0.029, 0.0296, 0.0300]))
    assert worn.dead_wheels.radius[0] == 0.029 and MODEL.dead_wheels.radius[0] == 0.0296028
