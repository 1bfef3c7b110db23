"""The course's own parts run as one compiled step; with one part of a student's, part by part."""

from dataclasses import replace

import numpy as np

from robocon_course.autopilot import Parts, Reckoning, module_command, reckon
from robocon_course.robot import Command
from robocon_course.simulator import Simulator


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
