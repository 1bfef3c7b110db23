"""Poses in the plane: the group SE(2), against matrices and a peer."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.linalg import expm

from conftest import missing
from robocon_course.geometry import compose, inverse, se2_exp, se2_log, transform_points

# Within 10 m and 10 rad an entry of a product is good to some 10 * 10 * 2^-53 = 1e-14.
poses = arrays(float, 3, elements=st.floats(-10.0, 10.0))
twists = poses.map(lambda twist: twist * [1.0, 1.0, 0.62])  # within one turn: log has one answer
points = arrays(float, 2, elements=st.floats(-10.0, 10.0))


def matrix(pose: np.ndarray) -> np.ndarray:
    """The pose as a homogeneous matrix: what composition means."""
    x, y, theta = pose
    c, s = np.cos(theta), np.sin(theta)
    return np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="module")
def peer():
    try:
        from wpimath import geometry
    except ImportError:
        missing("no robotpy-wpimath")
    return geometry


def test_a_step_ahead_after_a_quarter_turn_goes_to_the_left():
    assert compose([1.0, 2.0, pi / 2], [3.0, 0.0, 0.1]) == pytest.approx([1.0, 5.0, pi / 2 + 0.1])


def test_the_way_back_from_a_pose_that_looks_left():
    assert inverse([1.0, 2.0, pi / 2]) == pytest.approx([-2.0, 1.0, -pi / 2])


def test_a_half_circle_ends_one_diameter_to_the_left():
    assert se2_exp([pi, 0.0, pi]) == pytest.approx([0.0, 2.0, pi], abs=1e-15)


def test_the_chord_of_a_quarter_circle_points_halfway():
    x, y, _ = se2_exp([1.0, 0.0, pi / 2])
    assert np.hypot(x, y) == pytest.approx(2.0 * sqrt(2.0) / pi)
    assert np.arctan2(y, x) == pytest.approx(pi / 4)


@given(poses, poses)
def test_compose_multiplies_matrices(a, b):
    np.testing.assert_allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-12)


@given(poses, poses, poses)
def test_compose_is_associative_and_counts_full_turns(a, b, c):
    left, right = compose(compose(a, b), c), compose(a, compose(b, c))
    np.testing.assert_allclose(left, right, atol=1e-12)
    assert left[2] == pytest.approx(a[2] + b[2] + c[2], abs=1e-13)


@given(poses)
def test_inverse_undoes_a_pose_from_either_side(pose):
    np.testing.assert_allclose(compose(pose, inverse(pose)), np.zeros(3), atol=1e-13)
    np.testing.assert_allclose(compose(inverse(pose), pose), np.zeros(3), atol=1e-13)


@given(twists)
def test_exp_is_the_matrix_exponential(twist):
    forward, left, turn = twist
    rates = np.array([[0.0, -turn, forward], [turn, 0.0, left], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(matrix(se2_exp(twist)), expm(rates), atol=1e-11)


@given(twists)
def test_a_twist_in_two_halves_leads_to_the_same_place(twist):
    half = se2_exp(twist / 2.0)
    np.testing.assert_allclose(compose(half, half), se2_exp(twist), atol=1e-12)


# Close to a full turn the chord shrinks to nothing and its direction with it.
@given(twists.filter(lambda twist: abs(twist[2]) < 6.0))
def test_log_undoes_exp(twist):
    np.testing.assert_allclose(se2_log(se2_exp(twist)), twist, atol=1e-11)


@pytest.mark.parametrize("turn", [0.0, 1e-300, 1e-12, 1e-8, 1e-4])
def test_tiny_turns_keep_their_digits(turn):
    # x = 1 - turn²/6, y = turn/2 - turn³/24: the next terms are below 1e-17 of them
    x, y, theta = se2_exp([1.0, 0.0, turn])
    assert x == pytest.approx(1.0 - turn**2 / 6.0, rel=1e-15)
    assert y == pytest.approx(turn / 2.0 - turn**3 / 24.0, rel=1e-15)
    assert theta == turn
    np.testing.assert_allclose(se2_log([x, y, theta]), [1.0, 0.0, turn], atol=1e-15)


def test_exp_and_log_agree_with_a_peer_on_random_twists(peer):
    rng = np.random.default_rng(5)
    for start, twist in zip(*rng.uniform(-3.0, 3.0, (2, 500, 3)), strict=True):
        origin = peer.Pose2d(start[0], start[1], peer.Rotation2d(start[2]))
        end = origin.exp(peer.Twist2d(*twist))
        ours = compose(start, se2_exp(twist))
        np.testing.assert_allclose(ours[:2], [end.x, end.y], atol=1e-12)
        assert np.cos(ours[2] - end.rotation().radians()) == pytest.approx(1.0, abs=1e-15)
        back = origin.log(end)
        ours = se2_log(compose(inverse(start), ours))
        np.testing.assert_allclose(ours, [back.dx, back.dy, back.dtheta], atol=1e-9)


def test_compose_and_inverse_agree_with_a_peer(peer):
    rng = np.random.default_rng(6)
    for a, b in zip(*rng.uniform(-3.0, 3.0, (2, 100, 3)), strict=True):
        first, second = (peer.Pose2d(p[0], p[1], peer.Rotation2d(p[2])) for p in (a, b))
        step = second.relativeTo(first)
        np.testing.assert_allclose(compose(inverse(a), b)[:2], [step.x, step.y], atol=1e-12)


@given(poses, points)
def test_points_move_like_the_origin_of_a_pose_would(pose, point):
    moved = transform_points(pose, point)
    np.testing.assert_allclose(moved, compose(pose, [*point, 0.0])[:2], atol=1e-13)
    np.testing.assert_allclose(transform_points(inverse(pose), moved), point, atol=1e-12)


def test_one_pose_serves_many_points_and_many_poses_one_point():
    rng = np.random.default_rng(7)
    pose, cloud = rng.normal(size=(4, 3)), rng.normal(size=(5, 2))
    every = transform_points(pose[:, None], cloud)
    assert every.shape == (4, 5, 2)
    assert every[2, 3].tolist() == transform_points(pose[2], cloud[3]).tolist()
    assert transform_points(pose, cloud[0])[1].tolist() == every[1, 0].tolist()


@pytest.mark.parametrize("function", [inverse, se2_exp, se2_log])
def test_whole_logs_go_row_by_row(function):
    log = np.random.default_rng(8).normal(size=(4, 2, 3))
    assert function(log)[3, 1] == pytest.approx(function(log[3, 1]), rel=1e-15)
    assert compose(log, log[0, 0])[3, 1] == pytest.approx(compose(log[3, 1], log[0, 0]))


def test_a_hole_in_a_log_stays_a_hole_and_spreads_no_further():
    log = np.ones((3, 3))
    log[1] = np.nan
    for result in (compose(log, log[0]), inverse(log), se2_exp(log), se2_log(log)):
        assert np.isnan(result[1]).all() and np.isfinite(result[[0, 2]]).all()


def test_a_whole_turn_that_ends_elsewhere_has_no_twist():
    # sin(pi) is 1e-16 and not 0 in floating point, so the answer is huge and not infinite
    assert np.abs(se2_log([1.0, 0.0, 2.0 * pi])).max() == pytest.approx(2.6e16, rel=0.02)
    assert se2_log([0.0, 0.0, 2.0 * pi]) == pytest.approx([0.0, 0.0, 2.0 * pi])


def test_a_wrong_last_axis_is_refused_by_name():
    with pytest.raises(ValueError, match=r"delta: expected shape .*3.*, got \(2,\)"):
        compose([0.0, 0.0, 0.0], [1.0, 2.0])
    with pytest.raises(ValueError, match=r"pose: expected shape .*3"):
        inverse([1.0, 2.0])
    with pytest.raises(ValueError, match=r"twist: expected shape .*3"):
        se2_exp(1.0)
    with pytest.raises(ValueError, match=r"points: expected shape .*2"):
        transform_points([0.0, 0.0, 0.0], [1.0, 2.0, 3.0])
