"""Balls on the floor: what pushes them, what stops them, and which one the rollers take."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course import field
from robocon_course.robot import SIDE
from robocon_course.simulator import balls as rolling
from robocon_course.simulator.balls import FREE, HELD, OUT, RADIUS, Balls

DT = 0.01
FAR = np.array([5.2, 11.4, 0.0])
"""Where the robot is out of every ball's way."""
STILL = np.zeros(3)


def roll(balls: Balls, robot=FAR, motion=STILL, pull=0.0, seconds=DT) -> int:
    """Let time pass; the robot moves on as it is told. Number of the ball at the rollers."""
    robot, at_rollers = np.array(robot, float), -1
    for _ in range(round(seconds / DT)):
        robot += np.asarray(motion) * DT
        at_rollers = rolling.roll(
            balls.xy, balls.velocity, balls.place, robot, np.array(motion, float), pull, DT
        )
    return at_rollers


def one(x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> Balls:
    balls = Balls(np.array([(x, y)]), ["red"])
    balls.velocity[0] = vx, vy
    return balls


# --- by hand -----------------------------------------------------------------------------------


def test_a_rolling_ball_runs_out_after_the_way_that_its_speed_is_good_for():
    balls = one(0.5, 10.0, 0.5)
    roll(balls, seconds=3.0)
    assert balls.velocity[0].tolist() == [0.0, 0.0]
    assert balls.xy[0, 0] - 0.5 == pytest.approx(0.5**2 / (2 * rolling.HALT), abs=0.005)
    assert balls.xy[0, 1] == 10.0


def test_a_ball_comes_back_from_a_wall_with_a_share_of_its_speed():
    balls = one(0.2, 10.0, -1.0)
    while balls.velocity[0, 0] < 0.0:
        before = -balls.velocity[0, 0]
        roll(balls)
    assert balls.velocity[0, 0] == pytest.approx(rolling.BOUNCE * before, rel=0.02)
    assert balls.xy[0, 0] >= RADIUS


def test_on_the_slope_a_ball_gathers_speed_towards_the_storage_zone():
    balls = one(3.1, 10.0)
    roll(balls, seconds=0.5)
    down = 9.81 * 0.1 * 5 / 7 - rolling.HALT  # a solid ball: 5/7 of the slope's share of gravity
    assert balls.velocity[0, 0] == pytest.approx(-down * 0.5, rel=0.02)
    roll(balls, seconds=10.0)
    assert balls.xy[0, 0] < field.SIDE_SLOPE.x0 and balls.velocity[0].tolist() == [0.0, 0.0]


def test_on_the_flat_a_ball_that_lies_lies_still():
    balls = Balls(np.array(field.PILE_BALLS), ["red"] * 16)
    before = balls.xy.copy()
    roll(balls, seconds=5.0)
    np.testing.assert_allclose(balls.xy, before, atol=1e-9)


def test_a_push_shares_momentum_and_loses_energy():
    balls = Balls(np.array([(1.0, 10.0), (1.0 + 2 * RADIUS + 0.001, 10.03)]), ["red"] * 2)
    balls.velocity[0] = 1.0, 0.0
    before = balls.velocity.copy()
    rolling._part(balls.xy, balls.velocity, 1, 0)
    assert (balls.velocity == before).all()  # they do not touch yet
    balls.xy[0, 0] += 0.03
    rolling._part(balls.xy, balls.velocity, 1, 0)
    np.testing.assert_allclose(balls.velocity.sum(axis=0), before.sum(axis=0), atol=1e-12)
    assert (balls.velocity**2).sum() < (before**2).sum()
    apart = balls.xy[1] - balls.xy[0]
    assert np.hypot(*apart) == pytest.approx(2 * RADIUS)
    # Along the line between them the speed comes back, by the bounce; across it nothing changes.
    apart /= np.hypot(*apart)
    closing = (before[0] - before[1]) @ apart
    assert (balls.velocity[1] - balls.velocity[0]) @ apart == pytest.approx(
        rolling.BOUNCE * closing
    )


@given(
    angle=st.floats(-pi, pi),
    overlap=st.floats(1e-6, 0.18),
    speeds=st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4),
)
def test_momentum_is_shared_at_every_push(angle, overlap, speeds):
    gap = 2 * RADIUS - overlap
    xy = np.array([(1.0, 10.0), (1.0 + gap * cos(angle), 10.0 + gap * sin(angle))])
    velocity = np.array(speeds).reshape(2, 2)
    before, middle = velocity.copy(), xy.mean(axis=0)
    rolling._part(xy, velocity, 0, 1)
    np.testing.assert_allclose(velocity.sum(axis=0), before.sum(axis=0), atol=1e-12)
    np.testing.assert_allclose(xy.mean(axis=0), middle, atol=1e-12)
    assert (velocity**2).sum() <= (before**2).sum() + 1e-12


def test_two_balls_in_one_place_are_left_alone_and_nothing_becomes_nan():
    balls = Balls(np.array([(1.0, 10.0), (1.0, 10.0)]), ["red"] * 2)
    roll(balls, seconds=0.1)
    assert np.isfinite(balls.xy).all() and np.isfinite(balls.velocity).all()


# --- the robot ---------------------------------------------------------------------------------


def test_the_robot_pushes_a_ball_before_it_and_faster_than_itself():
    balls = one(2.0 - SIDE / 2 - RADIUS - 0.01, 10.2)
    roll(balls, (2.0, 10.0, pi), (-0.5, 0.0, 0.0), seconds=0.1)
    assert balls.velocity[0, 0] < -0.5 and balls.xy[0, 0] + RADIUS <= 2.0 - 0.05 - SIDE / 2 + 0.001


def test_a_robot_that_turns_hits_with_the_speed_of_its_corner():
    balls = one(2.0 + SIDE / 2 + RADIUS - 0.01, 10.2)
    roll(balls, (2.0, 10.0, 0.0), (0.0, 0.0, -2.0))
    assert balls.velocity[0, 0] == pytest.approx(1.3 * 2.0 * 0.2, rel=0.1)  # omega times the arm


def test_a_ball_whose_middle_is_inside_comes_out_by_the_nearest_side():
    for x, y, axis, sign in (
        (0.3, 0.0, 0, 1),
        (-0.3, 0.1, 0, -1),
        (0.0, 0.3, 1, 1),
        (0, -0.3, 1, -1),
    ):
        balls = one(2.0 + x, 10.0 + y)
        roll(balls, (2.0, 10.0, 0.0))
        out = (balls.xy[0] - (2.0, 10.0))[axis]
        assert sign * out >= SIDE / 2 - 0.005, (x, y)


def distance_to_square(points, robot) -> np.ndarray:
    """Naive twin: from points to the robot's square; 0 inside."""
    c, s = cos(robot[2]), sin(robot[2])
    local = (np.asarray(points) - robot[:2]) @ np.array([[c, -s], [s, c]])
    return np.hypot(*np.maximum(np.abs(local) - SIDE / 2, 0.0).T)


pushes = st.lists(
    st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-3.0, 3.0)),
    min_size=1,
    max_size=6,
)


@settings(max_examples=40, deadline=None)
@given(
    legs=pushes, speeds=st.lists(st.floats(-2.0, 2.0), min_size=32, max_size=32), pull=st.booleans()
)
def test_however_the_robot_pushes_balls_stay_inside_whole_and_apart(legs, speeds, pull):
    balls = Balls(np.array(field.PILE_BALLS), ["red"] * 16)
    balls.velocity[:] = np.array(speeds).reshape(16, 2)
    robot = np.array([3.0, 10.0, pi])
    for leg in legs:
        for _ in range(40):
            target = robot + np.array(leg) * DT
            clear = (0.47 < target[0] < 5.3) and (8.47 < target[1] < 11.53)
            motion = np.array(leg) if clear else np.zeros(3)
            robot = target if clear else robot
            rolling.roll(balls.xy, balls.velocity, balls.place, robot, motion, float(pull), DT)
            assert np.isfinite(balls.xy).all() and np.isfinite(balls.velocity).all()
            for axis in range(2):
                assert balls.xy[:, axis].min() >= rolling.LOW[axis]
                assert balls.xy[:, axis].max() <= rolling.HIGH[axis]
    # Whoever is jammed between robot, wall and others is pressed, but comes free when it leaves.
    roll(balls, seconds=1.0)
    gaps = np.hypot(*(balls.xy[:, None] - balls.xy).transpose(2, 0, 1))[np.triu_indices(16, 1)]
    assert gaps.min() > 2 * RADIUS - 0.02


def test_the_robot_never_drives_over_a_ball_in_the_open():
    balls = Balls(np.array([(1.6, 9.8), (1.5, 10.1), (1.7, 10.25)]), ["red"] * 3)
    robot = np.array([3.0, 10.0, pi])
    for _ in range(120):
        robot[0] -= 0.01
        rolling.roll(balls.xy, balls.velocity, balls.place, robot, np.array([-1.0, 0, 0]), 0.0, DT)
        assert distance_to_square(balls.xy, robot).min() > RADIUS - 0.012


# --- the rollers -------------------------------------------------------------------------------


@pytest.mark.parametrize("aside", [-0.3, -0.12, -0.08, 0.0, 0.08, 0.12, 0.3])
def test_the_rollers_feel_only_what_is_in_their_width(aside):
    x = 2.0 + SIDE / 2 + RADIUS + 0.005
    balls = one(x, 10.0 + aside)
    expected = 0 if abs(aside) < rolling.ROLLERS else -1
    assert roll(balls, (2.0, 10.0, 0.0), pull=1.0) == expected


def test_they_do_not_reach_ahead_nor_behind():
    front = SIDE / 2 + RADIUS
    assert roll(one(2.0 + front + 0.05, 10.0), (2.0, 10.0, 0.0), pull=1.0) == -1
    assert roll(one(2.0 - front, 10.0), (2.0, 10.0, 0.0), pull=1.0) == -1


def test_rollers_that_turn_keep_the_ball_with_them_and_draw_it_to_their_middle():
    robot, motion = np.array([3.0, 10.0, pi]), np.array([-0.3, 0.0, 0.0])
    balls = one(3.0 - SIDE / 2 - RADIUS - 0.005, 10.07)
    free = one(*balls.xy[0])
    for _ in range(40):
        robot += motion * DT
        kept = rolling.roll(balls.xy, balls.velocity, balls.place, robot, motion, 1.0, DT)
        rolling.roll(free.xy, free.velocity, free.place, robot, motion, 0.0, DT)
        assert kept == 0
    assert abs(balls.xy[0, 1] - 10.0) < 0.02 < abs(free.xy[0, 1] - 10.0)


def test_rollers_of_a_robot_that_turns_take_the_ball_round_with_them():
    reach = SIDE / 2 + RADIUS + 0.005
    balls = one(2.0 + reach, 10.0)
    assert roll(balls, (2.0, 10.0, 0.0), (0.1, -0.2, 0.5), pull=1.0) == 0
    np.testing.assert_allclose(balls.velocity[0], (0.1, -0.2 + 0.5 * reach), atol=0.01)


@pytest.mark.parametrize("place", [OUT, HELD])
def test_a_ball_in_a_silo_or_in_the_gripper_is_nowhere_on_the_floor(place):
    balls = Balls(np.array([(2.0 + SIDE / 2 + RADIUS, 10.0), (2.5, 10.0)]), ["red"] * 2)
    balls.place[:] = place
    balls.velocity[:] = 1.0
    before = balls.xy.copy()
    assert roll(balls, (2.0, 10.0, 0.0), pull=1.0, seconds=0.2) == -1
    np.testing.assert_array_equal(balls.xy, before)
    assert list(balls.free) == [] and balls.held == (0 if place == HELD else -1)


# --- the same again ----------------------------------------------------------------------------


def pile_pushed() -> tuple[bytes, bytes]:
    balls = Balls(np.array(field.PILE_BALLS), ["red"] * 16)
    roll(balls, (2.9, 10.05, pi), (-0.8, 0.02, 0.1), seconds=1.7)
    return balls.xy.tobytes(), balls.velocity.tobytes()


def test_the_same_push_gives_the_same_pile_to_the_bit():
    assert pile_pushed() == pile_pushed()


def test_a_ball_more_lies_beside_the_others_and_these_stay():
    balls = Balls(np.array(field.PILE_BALLS), ["purple"] * 16)
    balls.add((1.0, 8.2), (0.1, 0.6), "red")
    assert balls.xy.shape == balls.velocity.shape == (17, 2)
    assert balls.colours[-1] == "red" and list(balls.free) == list(range(17))
    assert balls.place[-1] == FREE
    ways = []
    for _ in range(3):
        ways.append(balls.xy[-1, 1])
        roll(balls, seconds=0.1)
    assert all(b > a for a, b in pairwise(ways))


def test_the_floor_under_balls_is_the_fields():
    x = np.array([0.1, 1.0, 2.24, 2.26, 2.75, 3.24, 3.26, 4.0, 5.7])
    heights = rolling.floor_under(np.column_stack([x, np.full(len(x), 10.0)]))
    np.testing.assert_allclose(heights, [field.floor_height(at, 10.0) for at in x], atol=1e-12)
    assert heights[0] == pytest.approx(0.15) and heights[-1] == pytest.approx(0.25)
