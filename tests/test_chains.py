"""The course's own parts run as one compiled step; with one part of a student's, part by part."""

from dataclasses import replace

import numpy as np

from robocon_course.autopilot import (
    Following,
    Parts,
    Reckoning,
    Route,
    follow_step,
    module_command,
    reckon,
)
from robocon_course.geometry import distance_along
from robocon_course.robot import Command
from robocon_course.simulator import Simulator
from robocon_course.tracking import speed_profile


def one_by_one(name):
    """Parts that are the course's in all but name: each is called on its own."""
    course = getattr(Parts, name)
    return replace(Parts(), **{name: lambda *args: course(*args)})


def test_four_modules_are_told_the_same_in_one_step_as_part_by_part():
    rng, parts = np.random.default_rng(0), one_by_one("shortest_turn")
    for _ in range(500):
        twist = rng.normal(0.0, 2.0, 3) * rng.integers(0, 2, 3)
        theta, angles = rng.uniform(-9.0, 9.0), rng.uniform(-7.0, 7.0, 4)
        quick = module_command(Parts(), twist, theta, angles, dt=0.01)
        plain = module_command(parts, twist, theta, angles, dt=0.01)
        np.testing.assert_allclose(quick.speeds, plain.speeds, rtol=0, atol=1e-13)
        np.testing.assert_allclose(quick.angles, plain.angles, rtol=0, atol=1e-13)


def test_the_pose_is_reckoned_the_same_in_one_step_as_part_by_part():
    robot, rng, parts = Simulator(), np.random.default_rng(1), one_by_one("integrate")
    quick = plain = Reckoning.at((0.55, 0.35, 0.0))
    for tick in range(1000):
        if tick % 50 == 0:
            robot.apply(Command(rng.uniform(-1.0, 1.0, 4), rng.uniform(-3.0, 3.0, 4)))
        robot.step(0.01)
        seen = robot.read()
        quick, plain = reckon(Parts(), quick, seen), reckon(parts, plain, seen)
        np.testing.assert_allclose(quick.pose, plain.pose, rtol=0, atol=1e-12)


def test_counters_that_wrap_are_taken_the_nearer_way_in_one_step_too():
    parts = one_by_one("tick_changes")
    seen = Simulator().read()
    before = seen._replace(ticks=np.array([2**31 - 5, 7, -(2**31) + 3]))
    after = seen._replace(time=0.01, ticks=np.array([-(2**31) + 5, 9, 2**31 - 7]))
    poses = [
        reckon(each, reckon(each, Reckoning.at((1.0, 1.0, 0.0)), before), after).pose
        for each in (Parts(), parts)
    ]
    np.testing.assert_allclose(*poses, rtol=0, atol=1e-12)
    # A count is 0.06 mm: ten forward and ten back turn the robot by a little.
    assert 0.0 < abs(poses[0][2]) < 0.01 and np.abs(poses[0][:2] - 1.0).max() < 0.001


def test_a_path_is_followed_the_same_with_one_look_as_part_by_part():
    way, rng = np.linspace(0.0, 4.0, 60), np.random.default_rng(2)
    xy = np.column_stack([2.0 + np.cos(2.0 * way), np.sin(3.0 * way)])  # it crosses itself
    route = Route(xy, distance_along(xy), speed_profile(xy, 1.5, 2.0, 1.5))
    start = Following.begin(route)
    for name in ("nearest_point", "pure_pursuit"):
        parts, quick = one_by_one(name), start
        for k in range(59):
            pose = (*(xy[k] + rng.normal(0.0, 0.1, 2)), rng.uniform(-4.0, 4.0))
            plain = follow_step(parts, quick, route, pose, 0.01)
            quick = follow_step(Parts(), quick, route, pose, 0.01)
            assert quick == plain
        assert quick.index > 50
