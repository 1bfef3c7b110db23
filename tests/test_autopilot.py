"""The way from a velocity on the field to a command: on time, held back, and never broken off."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course import swerve
from robocon_course.autopilot import Parts, module_command
from robocon_course.geometry import se2_exp
from robocon_course.robot import MODULES

NOW = np.array([0.3, -2.0, 3.0, 1.0])
ORDER = (1.0, -0.5, 0.8)
anything = st.floats(allow_nan=True, allow_infinity=True)


def settled(twist, theta, dt):
    """The command once the modules point where it wants them: the loop's second step."""
    first = module_command(Parts(), twist, theta, NOW, dt=dt)
    return module_command(Parts(), twist, theta, first.angles, dt=dt)


# --- on time and held back -------------------------------------------------------------------


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.3])
def test_after_a_step_the_robot_is_where_the_order_meant(dt):
    twist, theta = np.array([0.9, 0.4, 2.0]), 0.7
    command = settled(twist, theta, dt)
    body = swerve.body_twist(MODULES, command.speeds, command.angles)
    # Where it gets, in its own axes at the start of the step: the order's straight line.
    meant = swerve.field_to_robot(twist, theta) * dt
    np.testing.assert_allclose(se2_exp(body * dt), meant, atol=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 30.0, 60.0, 90.0, 120.0, 180.0])
def test_a_wheel_that_still_has_to_turn_is_held_back_by_the_cosine(degrees):
    command = module_command(
        Parts(), [1.0, 0.0, 0.0], 0.0, np.full(4, np.radians(degrees)), dt=0.02
    )
    # Beyond a quarter turn it drives backwards, which leaves 180 degrees less to turn.
    np.testing.assert_allclose(command.speeds, np.cos(np.radians(degrees)), atol=1e-12)


# --- bad values ------------------------------------------------------------------------------


def angles_with(bad: float) -> np.ndarray:
    angles = NOW.copy()
    angles[2] = bad
    return angles


@pytest.mark.parametrize(
    ("twist", "theta"),
    [
        (ORDER, nan),
        (ORDER, inf),
        ((nan, 0.0, 0.0), 0.2),
        ((0.0, -inf, 0.0), 0.2),
        ((1e200, 0.0, 0.0), 0.2),
        ((1.0, 0.0, 2 * pi / 0.02), 0.2),
        ((1.0, 0.0, -1e9), 0.2),
    ],
)
def test_a_bad_order_or_heading_stops_the_wheels_where_they_are(twist, theta):
    command = module_command(Parts(), twist, theta, NOW, dt=0.02)
    assert command.speeds.tolist() == [0.0] * 4 and command.angles.tolist() == NOW.tolist()


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_module_whose_angle_is_not_known_is_sent_to_zero_and_the_others_stay(bad):
    command = module_command(Parts(), ORDER, 0.2, angles_with(bad), dt=0.02)
    assert command.speeds.tolist() == [0.0] * 4
    assert command.angles.tolist() == [0.3, -2.0, 0.0, 1.0]


def test_the_fastest_turn_that_can_be_driven_is_driven():
    omega = 0.99 * 2 * pi / 0.02
    assert module_command(Parts(), [0.0, 0.0, omega], 0.2, NOW, dt=0.02).speeds.any()


@given(
    twist=st.tuples(anything, anything, anything),
    theta=anything,
    angles=st.lists(anything, min_size=4, max_size=4),
)
def test_whatever_the_sensors_say_there_is_a_command_that_can_be_carried_out(twist, theta, angles):
    speeds, _ = module_command(Parts(), twist, theta, angles, dt=0.02).checked()
    assert np.abs(speeds).max() <= 3.2


def test_the_step_after_a_bad_one_is_driven_as_if_nothing_had_happened():
    held = module_command(Parts(), ORDER, nan, NOW, dt=0.02)
    after = module_command(Parts(), ORDER, 0.2, held.angles, dt=0.02)
    plain = module_command(Parts(), ORDER, 0.2, NOW, dt=0.02)
    np.testing.assert_array_equal(after.speeds, plain.speeds)
    np.testing.assert_array_equal(after.angles, plain.angles)


def test_a_part_that_answers_nan_and_a_wrong_shape_are_no_sensors_and_are_refused():
    broken = replace(Parts(), field_to_robot=lambda twist, theta: np.full(3, nan))
    with pytest.raises(ValueError, match=r"twist: .*not a finite number"):
        module_command(broken, ORDER, 0.2, NOW, dt=0.02)
    with pytest.raises(ValueError, match="angles: expected shape"):
        module_command(Parts(), ORDER, 0.2, NOW[:3], dt=0.02)
    with pytest.raises(ValueError, match="twist: expected shape"):
        module_command(Parts(), ORDER[:2], 0.2, NOW, dt=0.02)
    for dt in (0.0, nan, inf):
        with pytest.raises(ValueError, match="dt: expected seconds above 0"):
            module_command(Parts(), ORDER, nan, NOW, dt=dt)
