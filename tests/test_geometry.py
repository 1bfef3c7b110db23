"""Angles and quaternions."""

from __future__ import annotations

import doctest
import importlib
from math import pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from robocon_course import geometry

angles = st.floats(-1e6, 1e6)
vectors = arrays(float, 3, elements=st.floats(-10.0, 10.0))
quaternions = (
    arrays(float, 4, elements=st.floats(-1.0, 1.0))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: q / np.linalg.norm(q))
)


def scipy_rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(np.roll(q, -1, axis=-1))  # scipy puts w last


def test_wrap_angle_takes_190_degrees_to_minus_170():
    assert np.degrees(geometry.wrap_angle(np.radians(190.0))) == pytest.approx(-170.0)


@given(angles)
def test_wrap_angle_stays_in_its_half_open_interval_and_keeps_the_direction(angle):
    wrapped = geometry.wrap_angle(angle)
    assert -pi <= wrapped < pi
    # cos and sin of 1e6 rad are good to 1e6 * 2^-53; the turn 2 pi itself is rounded that much too.
    assert np.cos(wrapped) == pytest.approx(np.cos(angle), abs=1e-9)
    assert np.sin(wrapped) == pytest.approx(np.sin(angle), abs=1e-9)


@given(st.floats(-pi, pi, exclude_max=True))
def test_wrap_angle_leaves_what_is_wrapped_as_it_is(angle):
    assert geometry.wrap_angle(angle) == angle


@pytest.mark.parametrize("turns", [-7, -3, -1, 1, 3, 7])
def test_wrap_angle_takes_odd_half_turns_to_minus_pi(turns):
    assert geometry.wrap_angle(turns * pi) == pytest.approx(-pi, abs=1e-14)


def test_a_quarter_turn_left_takes_forward_to_left():
    left = geometry.quaternion_from_euler(0.0, 0.0, pi / 2)
    np.testing.assert_allclose(geometry.rotate(left, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0], atol=1e-15)


def test_positive_pitch_lowers_the_nose_and_positive_roll_the_right_side():
    down = geometry.rotate(geometry.quaternion_from_euler(0.0, 0.1, 0.0), [1.0, 0.0, 0.0])
    side = geometry.rotate(geometry.quaternion_from_euler(0.1, 0.0, 0.0), [0.0, -1.0, 0.0])
    assert down[2] == pytest.approx(-np.sin(0.1))
    assert side[2] == pytest.approx(-np.sin(0.1))


def test_i_times_j_is_k():
    _, i, j, k = np.eye(4)
    assert geometry.quaternion_multiply(i, j).tolist() == k.tolist()


@given(quaternions, quaternions, vectors)
def test_a_product_turns_like_its_factors_one_after_the_other(a, b, v):
    together = geometry.rotate(geometry.quaternion_multiply(a, b), v)
    np.testing.assert_allclose(together, geometry.rotate(a, geometry.rotate(b, v)), atol=1e-12)


@given(quaternions, vectors)
def test_conjugate_turns_back(q, v):
    there_and_back = geometry.rotate(geometry.quaternion_conjugate(q), geometry.rotate(q, v))
    np.testing.assert_allclose(there_and_back, v, atol=1e-12)


@given(quaternions, vectors)
def test_rotate_agrees_with_scipy(q, v):
    np.testing.assert_allclose(geometry.rotate(q, v), scipy_rotation(q).apply(v), atol=1e-12)


@given(st.floats(-pi, pi), st.floats(-pi, pi), st.floats(-pi, pi))
def test_quaternion_from_euler_agrees_with_scipy(roll, pitch, yaw):
    q = geometry.quaternion_from_euler(roll, pitch, yaw)
    turned = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    np.testing.assert_allclose(scipy_rotation(q).as_matrix(), turned, atol=1e-12)


@given(vectors.filter(lambda v: np.linalg.norm(v) < pi - 1e-6))
def test_rotation_vector_undoes_quaternion_from_rotation_vector(v):
    q = geometry.quaternion_from_rotation_vector(v)
    np.testing.assert_allclose(geometry.rotation_vector(q), v, atol=1e-12)
    np.testing.assert_allclose(geometry.rotation_vector(-q), v, atol=1e-12)


@pytest.mark.parametrize("size", [0.0, 1e-300, 1e-12, 1e-3])
def test_tiny_rotations_keep_their_digits(size):
    v = np.array([size, -size, 2.0 * size])
    back = geometry.rotation_vector(geometry.quaternion_from_rotation_vector(v))
    np.testing.assert_allclose(back, v, rtol=1e-12, atol=0.0)


def test_everything_works_on_whole_logs_as_on_single_rows():
    rng = np.random.default_rng(3)
    a, b, v = rng.normal(size=(5, 2, 4)), rng.normal(size=4), rng.normal(size=(5, 2, 3))
    a /= np.linalg.norm(a, axis=-1, keepdims=True)
    for whole, single in (
        (geometry.quaternion_multiply(a, b), geometry.quaternion_multiply(a[3, 1], b)),
        (geometry.rotate(a, v), geometry.rotate(a[3, 1], v[3, 1])),
        (geometry.rotation_vector(a), geometry.rotation_vector(a[3, 1])),
        (geometry.quaternion_from_euler(*v.T).T[:, 3, 1], geometry.quaternion_from_euler(*v[3, 1])),
    ):
        np.testing.assert_allclose(whole[3, 1] if whole.ndim == 3 else whole, single, atol=1e-15)


def test_a_hole_in_a_log_stays_a_hole_and_spreads_no_further():
    q = np.tile([1.0, 0.0, 0.0, 0.0], (3, 1))
    q[1] = np.nan
    turned = geometry.rotate(q, [1.0, 2.0, 3.0])
    assert np.isnan(turned[1]).all() and np.isfinite(turned[[0, 2]]).all()


def test_a_wrong_last_axis_is_refused_by_name():
    with pytest.raises(ValueError, match=r"v: expected shape .*3.*, got \(4,\)"):
        geometry.rotate([1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="q: expected shape"):
        geometry.rotation_vector(1.0)


@pytest.mark.parametrize(
    "room",
    ["geometry", "imu.calibration", "imu.attitude", "imu.mahony", "imu.estimate", "imu.phone"],
)
def test_the_examples_in_docstrings_hold(room):
    outcome = doctest.testmod(importlib.import_module(f"robocon_course.{room}"))
    assert outcome.failed == 0
