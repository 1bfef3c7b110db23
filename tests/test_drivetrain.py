"""The wheel matrix: one linear map for dead wheels, omni wheels, modules and two wheels."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robocon_course.drivetrain import wheel_matrix
from robocon_course.geometry import se2_exp, transform_points
from robocon_course.odometry import TrackingWheels, body_deltas, integrate

angles = st.floats(-10.0, 10.0)
places = arrays(float, 2, elements=st.floats(-1.0, 1.0))
twists = arrays(float, 3, elements=st.floats(-3.0, 3.0))


def wheel_speed(place, direction, twist) -> float:
    return float(wheel_matrix([place], [direction])[0] @ twist)


@pytest.mark.parametrize(
    "place, direction, speed",
    [
        ((0.0, 0.25), 0.0, -0.25),  # left wheel, rolling ahead: a left turn drags it back
        ((0.0, -0.25), 0.0, 0.25),
        ((-0.3, 0.0), pi / 2, -0.3),  # behind, rolling to the left: pushed to the right
        ((0.3, 0.0), pi / 2, 0.3),  # in front: the sign of the offset is all
        ((0.3, 0.0), 0.0, 0.0),  # a wheel that points at the centre does not roll
    ],
)
def test_what_a_left_turn_does_to_a_wheel(place, direction, speed):
    assert wheel_speed(place, direction, [0.0, 0.0, 1.0]) == pytest.approx(speed, abs=1e-16)


@given(places, angles, twists)
def test_a_wheel_sees_the_motion_of_its_own_place_along_its_own_direction(place, direction, twist):
    # Naive twin: where is the place a moment later and earlier? The third derivative of the motion
    # is below 100, so the error of the central difference is below 100 (1e-4)²/6 = 2e-7.
    h = 1e-4
    after, before = (transform_points(se2_exp(twist * dt), place) for dt in (h, -h))
    velocity = (after - before) / (2.0 * h)
    along = np.array([np.cos(direction), np.sin(direction)])
    assert wheel_speed(place, direction, twist) == pytest.approx(velocity @ along, abs=1e-6)


@given(places, angles, twists, st.floats(-1.0, 1.0))
def test_where_along_its_own_direction_a_wheel_stands_does_not_matter(place, way, twist, shift):
    further = place + shift * np.array([np.cos(way), np.sin(way)])
    here, there = wheel_speed(place, way, twist), wheel_speed(further, way, twist)
    assert here == pytest.approx(there, abs=1e-13)


@given(places, angles, twists)
def test_a_wheel_turned_about_counts_backwards(place, direction, twist):
    turned = wheel_speed(place, direction + pi, twist)
    assert turned == pytest.approx(-wheel_speed(place, direction, twist), abs=1e-13)


@given(places, angles, twists)
def test_a_module_is_a_wheel_ahead_and_a_wheel_to_the_left(place, direction, twist):
    vx, vy = wheel_matrix([place, place], [0.0, pi / 2]) @ twist
    along = np.cos(direction) * vx + np.sin(direction) * vy
    assert wheel_speed(place, direction, twist) == pytest.approx(along, abs=1e-13)


# --- check the source: the three-omni-wheel model of the swerve robot's thesis, equations 1 to 6 --


def three_omni_wheels(rng):
    """Angles δ, distances R and radii r of three omni wheels, not in a row."""
    while True:
        delta, distance = rng.uniform(-pi, pi, 3), rng.uniform(0.1, 0.4, 3)
        wheels = TrackingWheels(
            (distance * [np.cos(delta), np.sin(delta)]).T,
            delta + pi / 2,
            rng.uniform(0.02, 0.06, 3),
            ticks_per_turn=1000,
        )
        if np.linalg.cond(wheels.matrix) < 100.0:
            return delta, distance, wheels


def test_equation_3_holds_as_printed():
    # M = (-sin δ, cos δ, R) / r, for wheels at R (cos δ, sin δ) that roll to the left seen from
    # the centre
    delta, distance, wheels = three_omni_wheels(np.random.default_rng(1))
    printed = np.column_stack([-np.sin(delta), np.cos(delta), distance])
    np.testing.assert_allclose(wheels.matrix, printed, atol=1e-15)


@pytest.mark.parametrize("seed", range(10))
def test_equation_6_the_closed_form_of_the_inverse_holds_as_printed(seed):
    (da, db, dc), (Ra, Rb, Rc), wheels = three_omni_wheels(np.random.default_rng(seed))
    divisor = Ra * np.sin(db - dc) - Rb * np.sin(da - dc) + Rc * np.sin(da - db)
    ahead, left = (
        [Rb * f(dc) - Rc * f(db), Ra * f(dc) - Rc * f(da), Ra * f(db) - Rb * f(da)]
        for f in (np.cos, np.sin)
    )
    turn = [np.sin(db - dc), np.sin(da - dc), np.sin(da - db)]
    printed = np.array([ahead, left, turn]) * [1.0, -1.0, 1.0] * wheels.radius / divisor
    omega = np.random.default_rng(seed).uniform(-20.0, 20.0, 3)  # rad/s
    ours = body_deltas(wheels, [omega * wheels.radius])[0]
    np.testing.assert_allclose(printed @ omega, ours, atol=1e-11)  # condition below 100


def test_equation_4_goes_straight_where_the_robot_goes_along_an_arc():
    # x += T R(θ)^-1 M^-1 ω, with the heading before the step: a circle of radius 1 m at 1 m/s
    period, twist = 0.01, np.array([1.0, 0.0, 1.0])
    steps = round(2.0 * pi / period)
    poses = np.zeros((steps + 1, 3))
    for k in range(steps):
        c, s = np.cos(poses[k, 2]), np.sin(poses[k, 2])
        world = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        poses[k + 1] = poses[k] + period * world @ twist
    ours = integrate(np.tile(twist * period, (steps, 1)))
    error = np.hypot(*(poses - ours)[:, :2].T)
    # Every chord is turned by T ω / 2 = 0.005 rad: halfway round, 2 m away, that makes 1 cm.
    assert error.max() == pytest.approx(0.01, rel=0.01)
    radius = np.hypot(ours[:, 0], ours[:, 1] - 1.0)
    np.testing.assert_allclose(radius, 1.0, atol=1e-12)


# --- refusals ---------------------------------------------------------------------------------


def test_no_wheels_make_an_empty_matrix():
    assert wheel_matrix(np.zeros((0, 2)), []).shape == (0, 3)


@pytest.mark.parametrize(
    "positions, directions, sentence",
    [
        ([0.0, 0.25], [0.0], r"positions: expected shape \(n, 2\), got \(2,\)"),
        ([[0.0, 0.25]], [0.0, 1.0], r"directions: expected shape \(1,\), got \(2,\)"),
        ([[0.0, np.nan]], [0.0], r"positions: entry \(0, 1\) is not a finite number"),
        ([[0.0, 0.25]], ["ahead"], "directions: expected numbers"),
    ],
)
def test_wrong_wheels_are_refused_by_name(positions, directions, sentence):
    with pytest.raises(ValueError, match=sentence):
        wheel_matrix(positions, directions)
