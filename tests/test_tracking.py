"""Chapter 05: pursuit, speed profile, path following; and the printed sources beside them."""

from __future__ import annotations

from itertools import pairwise
from math import acos, atan, atan2, hypot, inf, isnan, nan, pi, remainder, sin, sqrt, tan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from robocon_course import field, tracking
from robocon_course.geometry import compose, distance_along, se2_exp
from robocon_course.odometry import Odometry, TrackingWheels
from robocon_course.tracking import (
    ARRIVED,
    DT,
    REACH,
    Cart,
    DifferentialModel,
    Faults,
    Pid,
    PidLimits,
    TrackingSettings,
    lookahead_point,
    nearest_point,
    nearest_points,
    pure_pursuit,
    speed_profile,
    trial,
    tune,
)
from robocon_course.worlds import PUBLISHED, SOURCE_PATHS, finely

TURN = 2.0 * pi
compiled = settings(deadline=None)  # the first call compiles
coordinate = st.floats(-3.0, 3.0).map(lambda value: round(value, 3))
points = st.tuples(coordinate, coordinate)
paths = st.lists(points, min_size=2, max_size=8).map(np.array)
poses = st.tuples(coordinate, coordinate, st.floats(-4.0, 4.0))
L_SHAPE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
STRAIGHT = np.array([[0.0, 0.0], [2.0, 0.0]])


fine = finely


def rounded(path, radius: float) -> np.ndarray:
    """The same path with arcs in its corners."""
    path = np.asarray(path, float)
    out = [path[0]]
    for a, b, c in zip(path, path[1:], path[2:], strict=False):
        u, w = (a - b) / hypot(*(a - b)), (c - b) / hypot(*(c - b))
        half = acos(u @ w) / 2.0
        middle = b + (u + w) / hypot(*(u + w)) * radius / sin(half)
        first, last = (b + side * radius / tan(half) - middle for side in (u, w))
        start = atan2(first[1], first[0])
        angles = start + remainder(atan2(last[1], last[0]) - start, TURN) * np.linspace(0, 1, 25)
        out.extend(middle + radius * np.column_stack([np.cos(angles), np.sin(angles)]))
    return np.array([*out, path[-1]])


def eight(n: int = 400) -> np.ndarray:
    """A figure eight in Area 1; it crosses itself in its middle."""
    t = np.linspace(0.0, TURN, n)
    return np.column_stack([3.2 + 1.4 * np.sin(t), 2.0 + 0.7 * np.sin(2.0 * t)])


# --- nearest point ----------------------------------------------------------------------------


def test_the_nearest_point_by_hand():
    found = nearest_point(L_SHAPE, (0.25, 0.5))
    assert found == (0, 0.25, (0.25, 0.0), 0.5)
    assert nearest_point(L_SHAPE, (1.5, 0.5)) == (1, 0.25, (1.0, 0.5), 0.5)
    assert nearest_point(L_SHAPE, (-3.0, -4.0)) == (0, 0.0, (0.0, 0.0), 5.0)
    assert nearest_point(L_SHAPE, (1.0, 5.0)) == (1, 1.0, (1.0, 2.0), 3.0)


@compiled
@given(paths, points)
def test_no_point_of_the_path_is_nearer(path, point):
    found = nearest_point(path, point)
    shares = np.linspace(0.0, 1.0, 201)[:, None]
    everywhere = np.concatenate([a + shares * (b - a) for a, b in pairwise(path)])
    least = np.hypot(*(everywhere - point).T).min()
    # 201 points on segments of 8.5 m at most: none is farther than 21 mm from one of them.
    assert found.distance <= least + 1e-8
    assert found.distance >= least - 0.022
    assert hypot(found.xy[0] - point[0], found.xy[1] - point[1]) == pytest.approx(found.distance)
    a, b = path[found.index], path[found.index + 1]
    assert found.xy == pytest.approx(tuple(a + found.share * (b - a)), abs=1e-12)


def test_the_nearest_points_of_a_drive_are_those_found_one_after_the_other():
    path, rng = finely(eight(), 0.05), np.random.default_rng(2)
    poses = np.column_stack([path + rng.normal(0.0, 0.02, path.shape), np.zeros(len(path))])
    found, index = nearest_points(path, poses, reach=0.3), 0
    for pose, xy, off in zip(poses, *found, strict=True):
        one = nearest_point(path, pose[:2], index, 0.3)
        index = one.index
        assert tuple(xy) == one.xy and abs(off) == one.distance
    assert (found.cross_track > 0.0).any() and (found.cross_track < 0.0).any()
    with pytest.raises(ValueError, match="reach: expected metres above 0"):
        nearest_points(path, poses, reach=0.0)
    with pytest.raises(ValueError, match="poses: expected shape"):
        nearest_points(path, poses[:, :2])


def test_the_search_stays_on_its_leg_of_a_way_out_and_back():
    path = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.1], [0.0, 0.1]]
    assert nearest_point(path, (0.5, 0.06)).index == 2
    assert nearest_point(path, (0.5, 0.06), 0, reach=0.3).index == 0
    assert nearest_point(path, (0.5, 0.04), 2, reach=0.3).index == 2
    # Both legs on one line are as near: rounding does not choose.
    same = [[0.0, 0.0], [1.7, 1.1], [0.0, 0.0]]
    for off in np.random.default_rng(2).normal(0.0, 0.01, (200, 2)):
        assert nearest_point(same, np.array([1.6, 1.0]) + off).index == 0


# --- look-ahead point ---------------------------------------------------------------------------


def test_the_look_ahead_point_by_hand():
    assert lookahead_point(L_SHAPE, (0.2, 0.3), 0.5, 0, 0.2).xy == pytest.approx((0.6, 0.0))
    corner = lookahead_point(L_SHAPE, (0.4, 0.0), 1.0, 0, 0.4)
    assert (corner.index, corner.share) == (1, pytest.approx(0.4))
    assert lookahead_point(L_SHAPE, (1.0, 1.8), 0.5, 1, 0.9) == (1, 1.0, (1.0, 2.0), 2.0 - 1.8)
    far_off = lookahead_point(L_SHAPE, (0.5, 0.9), 0.6, 0, 0.5)
    assert far_off == (0, 0.5, (0.5, 0.0), 0.9)
    # What lies behind the place where the search begins is out of the question.
    assert lookahead_point(L_SHAPE, (1.0, 1.0), 0.4, 1, 0.5).xy == pytest.approx((1.0, 1.4))


@compiled
@given(paths, poses, st.floats(0.05, 2.0))
def test_pure_pursuit_is_made_of_the_nearest_and_the_look_ahead_point(path, pose, lookahead):
    foot = nearest_point(path, pose[:2], 0, lookahead)
    ahead = lookahead_point(path, pose[:2], lookahead, foot.index, foot.share)
    found = pure_pursuit(path, pose, lookahead)
    assert (found.target, found.index) == (ahead.xy, foot.index)
    x, y = transform_back(pose, ahead.xy)
    if ahead.distance > 1e-6:
        assert found.curvature == pytest.approx(2.0 * y / (x * x + y * y), rel=1e-9, abs=1e-9)


def transform_back(pose, place) -> tuple[float, float]:
    """A place of the map as seen from a pose: ahead, to the left."""
    seen = complex(place[0] - pose[0], place[1] - pose[1]) * np.exp(-1j * pose[2])
    return seen.real, seen.imag


# --- pure pursuit -----------------------------------------------------------------------------


def test_the_target_by_hand_on_a_straight_line_and_round_a_corner():
    found = pure_pursuit(STRAIGHT, [0.5, 0.3, 0.0], 0.5)
    assert found.target == pytest.approx((0.9, 0.0))
    assert found.curvature == pytest.approx(-2 * 0.3 / 0.25)  # to the right, back to the path
    found = pure_pursuit(L_SHAPE, [0.4, 0.0, 0.0], 1.0)
    assert found.target == pytest.approx((1.0, 0.8)) and found.index == 0


@compiled
@given(paths, poses, st.floats(0.05, 2.0))
def test_the_target_lies_on_the_path_so_far_away_and_never_past_the_end(path, pose, lookahead):
    foot = nearest_point(path, pose[:2], 0, lookahead)
    found = pure_pursuit(path, pose, lookahead)
    assert found.index == foot.index
    away = hypot(found.target[0] - pose[0], found.target[1] - pose[1])
    on_path = nearest_point(path, found.target)
    assert on_path.distance < 1e-9
    if foot.distance >= lookahead:
        assert found.target == pytest.approx(foot.xy)
    elif away < lookahead - 1e-9:
        assert found.target == tuple(path[-1])
    else:
        assert away == pytest.approx(lookahead, abs=1e-9)


@compiled
@given(paths, poses, st.floats(0.05, 2.0))
def test_the_target_is_the_first_point_that_a_walk_along_the_path_finds(path, pose, lookahead):
    foot = nearest_point(path, pose[:2], 0, lookahead)
    assume(foot.distance < lookahead - 0.01)
    rest = np.array([foot.xy, *path[foot.index + 1 :]])
    for point in fine(rest, 0.001) if distance_along(rest)[-1] > 0.0 else rest:
        if hypot(point[0] - pose[0], point[1] - pose[1]) >= lookahead:
            break
    target = pure_pursuit(path, pose, lookahead).target
    # The walk steps over the circle by 1 mm at most; where it crosses at a flat angle that is more,
    # and a path that only touches the circle between two steps may be missed.
    flat = abs(hypot(point[0] - pose[0], point[1] - pose[1]) - lookahead) < 1e-6
    assert flat or hypot(target[0] - point[0], target[1] - point[1]) < 0.1


@compiled
@given(poses, st.floats(0.2, 1.5))
def test_the_circle_leads_through_the_target(pose, lookahead):
    found = pure_pursuit(L_SHAPE, pose, lookahead)
    away = hypot(found.target[0] - pose[0], found.target[1] - pose[1])
    bearing = remainder(atan2(found.target[1] - pose[1], found.target[0] - pose[0]) - pose[2], TURN)
    assume(away > 1e-3 and abs(abs(bearing) - pi) > 1e-3 and abs(bearing) > 1e-6)
    # On a circle touched by the heading, the turn up to a point is twice its bearing.
    length = 2.0 * bearing / found.curvature
    end = compose(pose, se2_exp([length, 0.0, 2.0 * bearing]))
    assert end[:2] == pytest.approx(found.target, abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_on_a_circle_the_curvature_is_the_circles_whatever_the_lookahead(side):
    t = np.linspace(0.0, 3.0, 3001)
    path = np.column_stack([0.8 * np.sin(t), side * 0.8 * (1.0 - np.cos(t))])
    for lookahead in (0.1, 0.3, 0.8):
        found = pure_pursuit(path, [0.0, 0.0, 0.0], lookahead)
        # A chord of 0.8 mm lies 1e-7 m inside; that over d² = 0.01 is 2e-5.
        assert found.curvature == pytest.approx(side / 0.8, abs=1e-4)


def test_a_longer_look_ahead_steers_more_gently_not_more_aggressively():
    found = [abs(pure_pursuit(STRAIGHT, [0.2, 0.1, 0.0], d).curvature) for d in (0.2, 0.4, 0.8)]
    assert found == pytest.approx([2 * 0.1 / 0.04, 2 * 0.1 / 0.16, 2 * 0.1 / 0.64])
    distances = tracking.lookahead_distance([0.0, 0.25, -1.0], k=0.4, least=0.1)
    assert distances == pytest.approx([0.1, 0.2, 0.5])


def drive_by_pursuit(path, pose, lookahead, step=0.01, most=5000):
    """Poses of a robot without lag that follows the circles, and the indices it saw."""
    poses, indices, index = [pose], [], 0
    for _ in range(most):
        found = pure_pursuit(path, poses[-1], lookahead, index)
        index = found.index
        indices.append(index)
        if found.done:
            break
        turn = min(max(found.curvature, -10.0), 10.0) * step
        poses.append(compose(poses[-1], se2_exp([step, 0.0, turn])))
    return np.array(poses), indices


def test_a_path_that_crosses_itself_is_driven_to_its_end():
    path = eight()
    way = np.diff(path[:2], axis=0)[0]
    poses, indices = drive_by_pursuit(path, [*path[0], atan2(way[1], way[0])], 0.2)
    assert indices[-1] == len(path) - 2 and indices == sorted(indices)
    assert len(poses) * 0.01 == pytest.approx(distance_along(path)[-1], rel=0.03)
    # A search of the whole path confuses the two branches in the middle.
    assert nearest_point(path, path[3]).index in (2, 3)
    assert nearest_point(path, path[3], 150, 0.2).index in range(190, 210)


def test_a_closed_path_is_not_done_at_its_start():
    square = fine([[0, 0], [2, 0], [2, 2], [0, 2], [0, 0]])
    assert not pure_pursuit(square, [0.0, 0.0, 0.0], 0.3).done
    poses, _ = drive_by_pursuit(square, [0.0, 0.0, 0.0], 0.2)
    assert 7.5 < 0.01 * len(poses) < 8.1


def test_it_is_done_at_the_end_past_the_end_and_nowhere_else():
    def done(pose, **more):
        return pure_pursuit(STRAIGHT, pose, 0.3, **more).done

    assert done([2.0, 0.0, 0.0]) and done([1.995, 0.02, 0.0])
    assert done([2.1, 0.05, 0.0])  # overshot: turning round would not help
    assert not done([1.97, 0.0, 0.0]) and done([1.97, 0.0, 0.0], tolerance=0.05)
    assert not done([2.0, 0.5, 0.0])  # beside the end, a look-ahead and more away
    assert not done([1.0, 0.2999, 0.0])  # the target is 8 mm farther, but not the end
    assert pure_pursuit(STRAIGHT, [2.1, 0.05, 0.0], 0.3).target == (2.0, 0.0)
    assert pure_pursuit(STRAIGHT, [2.0, 0.0, 0.0], 0.3).curvature == 0.0


def test_points_drawn_twice_do_no_harm():
    double = np.repeat(L_SHAPE, 3, axis=0)
    for pose in ([0.4, 0.1, 0.0], [1.0, 0.0, 1.0], [0.9, 1.9, 2.0]):
        one, other = pure_pursuit(L_SHAPE, pose, 0.5), pure_pursuit(double, pose, 0.5)
        assert other.target == pytest.approx(one.target) and other.done == one.done
    assert pure_pursuit([[1.0, 1.0]] * 4, [0.0, 1.0, 0.0], 0.5).target == (1.0, 1.0)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_pose_that_is_no_number_gives_no_number_and_keeps_the_place(bad):
    for k in range(3):
        pose = np.array([0.5, 0.0, 0.0])
        pose[k] = bad
        found = pure_pursuit(L_SHAPE, pose, 0.5, 1)
        assert isnan(found.curvature) and found.index == 1 and not found.done


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: pure_pursuit([[0.0, 0.0]], [0, 0, 0], 0.3), "path: expected two points or more"),
        (lambda: pure_pursuit([[0, 0], [nan, 0]], [0, 0, 0], 0.3), "path: entry"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0], 0.3), r"pose: expected shape \(3,\)"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0, 0], 0.0), "lookahead, tolerance: expected metres"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0, 0], nan), "lookahead, tolerance: expected metres"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0, 0], 0.3, 1), "start_index: .* segments 0 to 0"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0, 0], 0.3, -1), "start_index: .* segments 0 to 0"),
        (lambda: pure_pursuit(STRAIGHT, [0, 0, 0], 0.3, tolerance=-1.0), "tolerance: expected"),
        (lambda: nearest_point(STRAIGHT, [0, nan]), "point: entry"),
        (lambda: nearest_point(STRAIGHT, [0, 0], 0, 0.0), "reach: expected metres above 0"),
        (lambda: nearest_point(STRAIGHT, [0, 0], 3), "start_index: "),
        (lambda: lookahead_point(STRAIGHT, [0, nan], 0.3), "point: entry"),
        (lambda: lookahead_point(STRAIGHT, [0, 0], 0.0), "lookahead, share: expected metres"),
        (lambda: lookahead_point(STRAIGHT, [0, 0], 0.3, 0, 1.5), "share from 0 to 1, got"),
        (lambda: lookahead_point(STRAIGHT, [0, 0], 0.3, 1), "start_index: "),
        (lambda: tracking.lookahead_distance(1.0, -0.1, 0.1), "k, least: expected"),
        (lambda: tracking.lookahead_distance(1.0, 0.1, 0.0), "k, least: expected"),
    ],
)
def test_a_pursuit_of_nothing_is_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


# --- speed profile ----------------------------------------------------------------------------


def slow_profile(path, max_speed, max_accel, max_lateral, start, end) -> np.ndarray:
    """The two passes, point by point."""
    bend = np.abs(tracking.path_curvature(path))
    v = [min(max_speed, sqrt(max_lateral / k) if k > 0.0 else inf) for k in bend]
    v[0], v[-1] = min(v[0], start), min(v[-1], end)
    gaps = np.diff(distance_along(path))
    for k in range(1, len(v)):
        v[k] = min(v[k], sqrt(v[k - 1] ** 2 + 2.0 * max_accel * gaps[k - 1]))
    for k in range(len(v) - 2, -1, -1):
        v[k] = min(v[k], sqrt(v[k + 1] ** 2 + 2.0 * max_accel * gaps[k]))
    return np.array(v)


def test_from_rest_to_rest_by_hand():
    # 1 m/s² up to 1 m/s takes 1 s and 0.5 m, as does braking; 1 m is left at full speed.
    path = fine(STRAIGHT, 0.1)
    speeds = speed_profile(path, 1.0, 1.0, 1.0)
    x = path[:, 0]
    assert speeds == pytest.approx(np.sqrt(np.minimum(np.minimum(2 * x, 2 * (2 - x)), 1.0)))
    assert tracking.profile_times(path, speeds)[-1] == pytest.approx(3.0)


@given(paths, *[st.floats(0.1, 5.0)] * 3, st.floats(0.0, 3.0), st.floats(0.0, 3.0))
def test_the_profile_equals_two_passes_point_by_point(path, speed, accel, lateral, start, end):
    found = speed_profile(path, speed, accel, lateral, start_speed=start, end_speed=end)
    # Roots of differences of sums up to 5 * 2 * 50: 1e-13 of that under a root is 1e-6.
    expected = slow_profile(path, speed, accel, lateral, start, end)
    assert found**2 == pytest.approx(expected**2, abs=1e-10)


@given(paths, *[st.floats(0.1, 5.0)] * 3)
def test_the_profile_keeps_all_limits_and_nothing_below_them_is_faster(path, speed, accel, lateral):
    v = speed_profile(path, speed, accel, lateral)
    gaps = np.diff(distance_along(path))
    assert v.max() <= speed + 1e-9 and v[0] == v[-1] == 0.0
    assert (v**2 * np.abs(tracking.path_curvature(path)) <= lateral + 1e-9).all()
    assert (np.abs(np.diff(v**2)) <= 2.0 * accel * gaps + 1e-9).all()
    wider = speed_profile(path, speed * 1.5, accel * 1.5, lateral * 1.5)
    assert (wider >= v - 1e-6).all()


def test_on_a_circle_curvature_and_speed_are_the_circles():
    t = np.linspace(0.0, 5.0, 501)
    path = 0.5 * np.column_stack([np.cos(t), np.sin(t)])
    assert tracking.path_curvature(path)[1:-1] == pytest.approx(2.0, rel=1e-4)
    assert tracking.path_curvature(path[::-1])[1:-1] == pytest.approx(-2.0, rel=1e-4)
    v = speed_profile(path, 3.0, 2.0, 0.5, start_speed=inf, end_speed=inf)
    assert v[1:-1] == pytest.approx(0.5, rel=1e-3)


def test_a_way_straight_back_is_the_sharpest_bend():
    path = fine([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]], 0.02)
    assert np.abs(tracking.path_curvature(path)).max() == pytest.approx(pi / 0.02)
    v = speed_profile(path, 1.0, 1.0, 1.0)
    assert v[len(path) // 2] == pytest.approx(sqrt(0.02 / pi))


def test_corners_drawn_twice_bend_as_if_drawn_once():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [3.0, 1.0], [3.0, 2.0]])
    times = [1, 2, 1, 3, 2]
    assert tracking.path_curvature(np.repeat(corners, times, axis=0)).tolist() == pytest.approx(
        np.repeat(tracking.path_curvature(corners), times).tolist()
    )
    double = np.repeat(L_SHAPE, 2, axis=0)
    assert speed_profile(double, 1.0, 1.0, 0.1)[2:4] == pytest.approx(
        speed_profile(L_SHAPE, 1.0, 1.0, 0.1)[[1, 1]]
    )


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: speed_profile(STRAIGHT, 0.0, 1.0, 1.0), "max_speed, max_accel.*above 0"),
        (lambda: speed_profile(STRAIGHT, 1.0, nan, 1.0), "max_speed, max_accel.*above 0"),
        (lambda: speed_profile(STRAIGHT, inf, 1.0, 1.0), "max_speed, max_accel"),
        (lambda: speed_profile(STRAIGHT, 1.0, 1.0, 1.0, end_speed=-1.0), "start_speed, end_speed"),
        (lambda: speed_profile([[0, 0]], 1.0, 1.0, 1.0), "path: expected two points"),
        (lambda: tracking.profile_times(STRAIGHT, [0.0, 0.0]), "speeds: must not be negative"),
        (lambda: tracking.profile_times(STRAIGHT, [1.0]), r"speeds: expected shape \(2,\)"),
    ],
)
def test_limits_that_are_none_are_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


FIELD_WAY = [(0.55, 0.35), (0.5, 6.42), (4.3, 6.42), (4.3, 10.0)]

# --- the whole loop ------------------------------------------------------------------------------

GOOD = TrackingSettings(0.1, 0.05, 0.38, 0.6)
ZIGZAG = fine(SOURCE_PATHS["zigzag"])


def by_the_doors(path, model, settings) -> np.ndarray:
    """The loop of `trial` written with the public functions: true poses until it is done."""
    speeds = speed_profile(path, settings.speed, tracking.ACCEL, settings.lateral)
    cart, index, poses = Cart(model, tracking.start_pose(path)), 0, []
    for _ in range(20000):
        poses.append(cart.state.pose)
        here = nearest_point(path, cart.pose[:2], index, REACH)
        square = np.interp(here.index + here.share, np.arange(len(path)), speeds**2)
        speed = max(sqrt(square), tracking.CREEP)
        lookahead = tracking.lookahead_distance(speed, settings.k, settings.least)
        found = pure_pursuit(path, cart.pose, lookahead, here.index, tolerance=ARRIVED)
        if found.done:
            return np.array(poses)
        index = found.index
        cart.drive(speed, speed * found.curvature)
    raise AssertionError("the end was never reached")


@pytest.mark.parametrize("name", SOURCE_PATHS)
@pytest.mark.parametrize("model", [DifferentialModel(), DifferentialModel(0.22, lag=0.12)])
def test_the_compiled_loop_equals_the_doors_in_a_loop(name, model):
    path = fine(SOURCE_PATHS[name])
    run, slow = trial(path, model, GOOD), by_the_doors(path, model, GOOD)
    assert run.done and run.duration == pytest.approx(DT * (len(slow) - 1))
    # A count is worth 0.09 mm, and rounding may decide about one.
    np.testing.assert_allclose(run.poses[: len(slow)], slow, atol=3e-4)


def test_a_cart_knows_its_place_as_odometry_does():
    model = DifferentialModel()
    half = model.wheel_base / 2.0
    wheels = TrackingWheels(
        [[0.0, half], [0.0, -half]], [0.0, 0.0], model.radius, model.ticks_per_turn
    )
    cart, peer = Cart(model, (1.0, 2.0, 0.3)), Odometry(wheels, (1.0, 2.0, 0.3))
    counts, rng = model.ticks(cart.state), np.random.default_rng(4)
    for turn in rng.normal(0.0, 2.0, 300):
        cart.drive(0.3, turn)
        now = model.ticks(cart.state)
        peer.update(now - counts)
        counts = now
    np.testing.assert_allclose(cart.pose, peer.pose, atol=1e-9)
    assert hypot(*(cart.pose - cart.state.pose)[:2]) < 0.005


def test_saved_and_restored_a_cart_goes_on_to_the_bit():
    whole, other = Cart(), Cart()
    for k in range(60):
        whole.drive(0.3, sin(0.1 * k))
        if k == 30:
            other.state, other.pose = whole.state, whole.pose
        elif k > 30:
            other.drive(0.3, sin(0.1 * k))
    assert np.array_equal(whole.pose, other.pose)
    assert np.array_equal(whole.state.pose, other.state.pose)


def test_distances_from_the_path_are_positive_to_its_left():
    run = trial([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], settings=GOOD._replace(least=0.3))
    assert run.cross_track.max() > 0.03  # a left corner is cut on the inside
    other = trial([[0.0, 0.0], [1.0, 0.0], [1.0, -1.0]], settings=GOOD._replace(least=0.3))
    assert other.cross_track.min() < -0.03
    assert np.hypot(*(run.poses[:, :2] - run.feet).T) == pytest.approx(np.abs(run.cross_track))


def test_a_late_pose_makes_the_cart_swing_and_a_longer_look_ahead_calms_it():
    def rms(settings, **faults):
        run = trial(ZIGZAG, settings=settings, faults=Faults(**faults))
        return float(np.sqrt(np.mean(run.cross_track**2)))

    calm, late = rms(GOOD), rms(GOOD, delay=0.1)
    assert late > 3.0 * calm
    assert rms(GOOD._replace(k=0.3), delay=0.1) < 0.6 * late


def test_half_of_the_samples_and_a_noise_of_1_cm_are_enough():
    for faults in (Faults(dropped=0.5), Faults(noise=0.01)):
        run = trial(ZIGZAG, settings=GOOD, faults=faults)
        assert run.done and run.worst < 0.035
    one, other = (trial(ZIGZAG, faults=Faults(noise=0.01)) for _ in range(2))
    assert np.array_equal(one.poses, other.poses)
    rng = np.random.default_rng(1)
    assert not np.array_equal(one.poses, trial(ZIGZAG, faults=Faults(noise=0.01), rng=rng).poses)


def test_a_look_ahead_that_is_too_short_shakes_and_one_that_is_too_long_cuts_corners():
    short = trial(ZIGZAG, settings=GOOD._replace(k=0.0, least=0.01))
    good = trial(ZIGZAG, settings=GOOD)
    assert short.time[-1] > 3.0 * good.duration
    assert trial(ZIGZAG, settings=GOOD._replace(least=0.4)).worst > 3.0 * good.worst


def test_a_trial_that_never_arrives_says_so():
    hectic = GOOD._replace(k=0.0, least=0.01)
    run = trial(ZIGZAG, settings=hectic, faults=Faults(noise=0.001))
    assert not run.done and run.duration == inf


def test_settings_found_by_trials_beat_those_it_begins_with_and_are_in_time():
    model, path = DifferentialModel(lag=0.1, max_speed=0.6), fine(SOURCE_PATHS["roof"])
    found = trial(path, model, tune(model, path))
    assert found.duration <= tracking.time_allowed(path, model)
    for k, least in ((0.05, 0.03), (0.1, 0.05), (0.1, 0.03)):
        for lateral in (0.3, 0.8, 2.0):
            other = trial(path, model, TrackingSettings(k, least, 0.85 * 0.6, lateral))
            assert other.duration > tracking.time_allowed(path, model) or (
                found.worst <= other.worst + 1e-12
            )


def test_where_nothing_is_in_time_the_least_late_settings_are_taken():
    model = DifferentialModel(lag=0.1, max_speed=8.0)  # its tyres allow no more than 0.5 m/s²
    path = fine(STRAIGHT)
    run = trial(path, model, tune(model, path))
    # From rest to rest 2 m take 2 sqrt(2 / 0.5) = 4 s.
    assert run.done and 3.9 < run.duration < 4.5
    assert tracking.time_allowed(path, model) == 0.5


def test_a_robot_starts_facing_along_the_path():
    assert tracking.start_pose([[1.0, 2.0], [1.0, 2.0], [1.0, 3.0]]).tolist() == [1.0, 2.0, pi / 2]
    assert tracking.start_pose([[1.0, 2.0], [1.0, 2.0]]).tolist() == [1.0, 2.0, 0.0]


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: trial([[0.0, 0.0]]), "path: expected two points or more"),
        (lambda: trial(STRAIGHT, settings=GOOD._replace(least=0.0)), "settings: expected k from"),
        (lambda: trial(STRAIGHT, settings=GOOD._replace(k=-0.1)), "settings: expected k from"),
        (lambda: trial(STRAIGHT, settings=GOOD._replace(speed=nan)), "settings: expected k from"),
        (lambda: trial(STRAIGHT, faults=Faults(delay=-0.1)), "faults: expected a delay"),
        (lambda: trial(STRAIGHT, faults=Faults(dropped=1.0)), "faults: .* share below 1"),
        (lambda: trial(STRAIGHT, faults=Faults(noise=nan)), "faults: "),
        (lambda: tune(DifferentialModel(), [[0.0, 0.0]]), "path: expected two points or more"),
        (lambda: tracking.time_allowed([[0, 0]], DifferentialModel()), "path: expected two"),
        (lambda: Cart(pose=(0.0, nan, 0.0)), "pose: entry"),
    ],
)
def test_a_trial_of_nothing_is_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


# --- the paths of the differential robot, Surabaya -----------------------------------------------

PRINTED_PATHS = tuple(SOURCE_PATHS.values())
MILD = TrackingSettings(0.1, 0.05, lateral=0.3)


def by_bearing(waypoints, top, bearing_of=atan2) -> np.ndarray:
    """Poses: a PID controller turns the robot towards the next waypoint, at constant speed."""
    gains = tracking.ziegler_nichols(69.3, 0.2107)  # as the experiment on this robot finds them
    cart, pid, k = Cart(pose=(0.0, 0.0, pi / 2)), Pid(gains, PidLimits(-4.0, 4.0), wrap=True), 1
    poses = []
    for _ in range(5000):
        x, y, theta = cart.pose
        if hypot(waypoints[k][0] - x, waypoints[k][1] - y) < 0.05:
            k += 1
            if k == len(waypoints):
                for _ in range(60):
                    cart.drive(0.0, 0.0)
                return np.array([*poses, cart.state.pose])
        bearing = bearing_of(waypoints[k][1] - y, waypoints[k][0] - x)
        cart.drive(top, pid.update(bearing, theta, DT))
        poses.append(cart.state.pose)
    raise AssertionError("the end was never reached")


def deviations(waypoints, poses) -> np.ndarray:
    """Place minus nearest point of the path, in x and y, shape (n, 2) [m]."""
    index, out = 0, []
    for pose in poses:
        found = nearest_point(waypoints, pose[:2], index, 0.3)
        index = found.index
        out.append(pose[:2] - found.xy)
    return np.array(out)


@pytest.mark.parametrize("top", PUBLISHED)
@pytest.mark.parametrize("waypoints", PRINTED_PATHS, ids=["square", "roof", "zigzag"])
def test_the_published_paths_are_kept_within_3_cm_and_their_ends_within_1(waypoints, top):
    run = trial(fine(waypoints), settings=MILD._replace(speed=top))
    off = deviations(waypoints, run.poses)
    assert np.abs(off).max() < 0.03 < np.abs(PUBLISHED[top]).max()
    assert hypot(*(run.poses[-1, :2] - waypoints[-1])) < 0.01
    # Neither by creeping: with acceleration, corners and end it takes a quarter more than the way.
    assert run.duration < 1.6 * distance_along(waypoints)[-1] / top


@pytest.mark.parametrize("top", PUBLISHED)
def test_the_published_scheme_on_our_robot_lies_between_the_publication_and_ours(top):
    (low_x, high_x), (low_y, high_y) = PUBLISHED[top]
    worst = 0.0
    for waypoints in PRINTED_PATHS:
        poses = by_bearing(waypoints, top)
        off = deviations(waypoints, poses)
        assert low_x < off[:, 0].min() and off[:, 0].max() < high_x
        assert low_y < off[:, 1].min() and off[:, 1].max() < high_y
        assert hypot(*(poses[-1, :2] - waypoints[-1])) < 0.03
        worst = max(worst, np.abs(off).max())
    assert worst > 0.03


def test_the_printed_bearing_turns_the_robot_away_from_waypoints_to_its_left():
    # Equation 11 has arctan of a quotient: half of all directions come out as their opposites.
    def printed(dy, dx):
        return atan(dy / dx) if dx else pi / 2

    assert printed(0.0, -1.0) == 0.0 and atan2(0.0, -1.0) == pi
    with pytest.raises(AssertionError, match="never reached"):
        by_bearing(PRINTED_PATHS[2], 0.25, printed)


def test_the_printed_bearing_and_heading_count_from_different_axes():
    # Heading from the y axis, clockwise (equation 4); bearing from the x axis, the other way.
    ahead_of_it = (0.0, 1.0)
    heading, bearing = 0.0, atan2(ahead_of_it[1], ahead_of_it[0])
    assert bearing - heading == pytest.approx(pi / 2)  # printed error (12) of a robot on course
    assert atan2(ahead_of_it[0], ahead_of_it[1]) - heading == 0.0  # from the y axis, both


# --- the pursuit of the thesis, Yogyakarta -------------------------------------------------------


def printed_search(path, x, y, reach, old, most=1000):
    """Index that the listing ends with, starting from one found before; None: it never ends."""

    def distance(k):
        return hypot(path[k][0] - x, path[k][1] - y)

    index, here = old, distance(old)
    for _ in range(most):
        following = distance(index + 1)
        if here < following:
            break
        if index + 1 < len(path) - 1:
            index += 1
        if index >= len(path) - 1:
            break
        here = following
    else:
        return None
    while reach > distance(index) and index + 1 < len(path) - 1:
        index += 1
    return index


def test_the_printed_search_never_chooses_the_last_waypoint():
    path = [(0.1 * k, 0.0) for k in range(11)]
    chosen = {printed_search(path, x, 0.0, 0.3, 0) for x in np.arange(0.0, 0.9, 0.01)}
    assert max(chosen) == 9  # of 10: the robot stops 10 cm short of its goal
    targets = [pure_pursuit(path, [x, 0.0, 0.0], 0.3).target for x in (0.6, 0.75, 0.9, 1.0)]
    assert targets == [pytest.approx((x, 0.0)) for x in (0.9, 1.0, 1.0, 1.0)]


def test_the_printed_search_never_ends_past_the_last_but_one_waypoint():
    path = [(0.1 * k, 0.0) for k in range(11)]
    assert printed_search(path, 0.94, 0.0, 0.3, 5) == 9
    assert printed_search(path, 0.96, 0.0, 0.3, 5) is None
    assert pure_pursuit(path, [0.96, 0.0, 0.0], 0.3, 5).target == (1.0, 0.0)


def test_the_printed_target_jumps_from_waypoint_to_waypoint_and_ours_moves_smoothly():
    path = [(0.5 * k, 0.0) for k in range(9)]
    x = np.arange(0.0, 2.0, 0.01)
    printed = [path[printed_search(path, a, 0.0, 0.3, 0)][0] for a in x]
    ours = [pure_pursuit(path, [a, 0.0, 0.0], 0.3).target[0] for a in x]
    assert np.diff(printed).max() == pytest.approx(0.5)
    assert np.diff(ours) == pytest.approx(0.01)


def test_the_way_of_the_thesis_lies_on_the_field():
    # So that a lesson may drive it: no point of the tested way is in an obstacle.
    drivable = field.obstacle_map()
    assert drivable.is_free(np.array(rounded(FIELD_WAY, 0.6))).all()
