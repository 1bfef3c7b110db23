"""Chapter 02: ticks, wheels, motion of the base, poses; calibration and heading."""

from __future__ import annotations

from dataclasses import replace
from math import exp, inf, nan, pi, radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conftest import missing
from robocon_course import odometry
from robocon_course.geometry import compose, se2_exp, wrap_angle
from robocon_course.odometry import HeadingGains, HeadingState, SizePrior, TrackingWheels

TRACK, BEHIND, RADIUS = 0.5377, 0.2745, 0.0296028
POSITIONS = [[0.0, TRACK / 2], [0.0, -TRACK / 2], [-BEHIND, 0.0]]
WHEELS = TrackingWheels(POSITIONS, [0.0, 0.0, pi / 2], RADIUS, 3200)
TURN = 2.0 * pi
compiled = settings(deadline=None)  # the first call compiles

seeds = st.integers(0, 2**32 - 1)
places = arrays(float, 3, elements=st.floats(-3.0, 3.0))
motions = arrays(float, (5, 3), elements=st.floats(-0.5, 0.5))


def random_wheels(rng, n: int = 3) -> TrackingWheels:
    """Wheels anywhere on the robot that tell the three motions apart."""
    while True:
        wheels = TrackingWheels(
            rng.uniform(-0.3, 0.3, (n, 2)),
            rng.uniform(-pi, pi, n),
            rng.uniform(0.02, 0.05, n),
            ticks_per_turn=3200,
        )
        if np.linalg.cond(wheels.matrix) < 100.0:
            return wheels


def counts(wheels: TrackingWheels, deltas) -> np.ndarray:
    """What perfect encoders would count, fractions and all: the model turned round."""
    return np.asarray(deltas) @ wheels.matrix.T / wheels.metres_per_tick


def random_drive(rng, n: int = 400) -> np.ndarray:
    """Motions of 2 cm and 2 degrees, changing slowly: everywhere and in every direction."""
    return np.repeat(rng.normal(0.0, [0.02, 0.02, 0.04], (n // 20, 3)), 20, axis=0)


def slightly_off(wheels: TrackingWheels, rng) -> TrackingWheels:
    """A robot as built: radii by up to 1 %, positions by up to 5 mm."""
    return replace(
        wheels,
        positions=wheels.positions + rng.uniform(-0.005, 0.005, wheels.positions.shape),
        radius=wheels.radius * rng.uniform(0.99, 1.01, len(wheels.radius)),
    )


# --- counters and travel ----------------------------------------------------------------------


def test_one_turn_of_a_wheel_rolls_its_circumference():
    travel = odometry.wheel_travel(WHEELS, [3200, -1600, 0])
    assert travel == pytest.approx([TURN * RADIUS, -pi * RADIUS, 0.0])


def test_every_wheel_has_its_own_radius_and_any_number_of_samples():
    wheels = replace(WHEELS, radius=[0.03, 0.06, 0.03])
    travel = odometry.wheel_travel(wheels, np.full((2, 5, 3), 3200))
    assert travel.shape == (2, 5, 3)
    assert travel[1, 4] == pytest.approx([TURN * 0.03, TURN * 0.06, TURN * 0.03])


def test_a_counter_that_wraps_around_goes_on_counting():
    assert odometry.tick_changes([65530, 4, 65534], bits=16).tolist() == [10, -6]
    assert odometry.tick_changes([32767, -32768], bits=16).tolist() == [1]


@given(st.integers(2, 64), st.booleans(), st.integers(-(2**62), 2**62), st.data())
def test_changes_below_half_the_range_come_back_whatever_the_counter_shows(
    bits, signed, first, data
):
    half = 2 ** (bits - 1)
    steps = data.draw(st.lists(st.integers(-half, half - 1), max_size=20))
    readings, total = [], first
    for step in [0, *steps]:
        total += step
        shown = total % 2**bits
        readings.append(shown - 2**bits if signed and shown >= half else shown)
    kept = np.array(readings, dtype=np.int64 if signed else np.uint64)
    changes = odometry.tick_changes(kept, bits=bits)
    assert changes.dtype == np.int64 and changes.tolist() == steps


def test_counters_of_several_wheels_and_of_narrow_types():
    counters = np.array([[250, 3], [4, 253]], dtype=np.uint8)
    assert odometry.tick_changes(counters, bits=8).tolist() == [[10, -6]]
    assert odometry.tick_changes(np.array([120, -120], dtype=np.int8), bits=8).tolist() == [16]
    assert odometry.tick_changes([[7, 7, 7]]).shape == (0, 3)


@pytest.mark.parametrize(
    "counters, bits, sentence",
    [
        ([1.5, 2.0], 16, "counters: expected whole numbers.*float64.*astype"),
        (7, 16, r"counters: expected whole numbers.*shape \(\)"),
        (np.zeros((0, 3), dtype=int), 16, "counters: expected at least one reading"),
        ([1, 2], 0, "bits: expected a whole number from 1 to 64, got 0"),
        ([1, 2], 65, "bits: expected a whole number from 1 to 64, got 65"),
        ([1, 2], "16", "bits: expected a whole number from 1 to 64, got '16'"),
    ],
)
def test_readings_that_are_no_counter_are_refused(counters, bits, sentence):
    with pytest.raises(ValueError, match=sentence):
        odometry.tick_changes(counters, bits=bits)


@pytest.mark.parametrize(
    "change, sentence",
    [
        ({"positions": [0.0, 1.0]}, r"positions: expected shape \(n, 2\)"),
        ({"directions": [0.0]}, r"directions: expected shape \(3,\), got \(1,\)"),
        ({"radius": [0.03, 0.03]}, r"radius: expected shape \(3,\), got \(2,\)"),
        ({"radius": -0.03}, "radius: expected metres above 0, got -0.03"),
        ({"radius": [0.03, 0.0, 0.03]}, "radius: expected metres above 0, got 0"),
        ({"radius": nan}, "radius: entry .* is not a finite number"),
        ({"ticks_per_turn": 0}, "ticks_per_turn: expected counts above 0, got 0"),
        ({"ticks_per_turn": nan}, "ticks_per_turn: expected counts above 0"),
        ({"ticks_per_turn": inf}, "ticks_per_turn: expected counts above 0"),
    ],
)
def test_wheels_that_cannot_be_are_refused_when_they_are_made(change, sentence):
    with pytest.raises(ValueError, match=sentence):
        replace(WHEELS, **change)


def test_wheels_cannot_change_afterwards():
    places = np.array(POSITIONS)
    wheels = replace(WHEELS, positions=places)
    places += 1.0
    assert wheels.positions.tolist() == POSITIONS
    for array in (wheels.positions, wheels.radius, wheels.matrix, wheels.solver):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


# --- motion of the base -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "delta, travel",
    [
        ((0.1, 0.0, 0.0), (0.1, 0.1, 0.0)),
        ((0.0, 0.1, 0.0), (0.0, 0.0, 0.1)),
        # A turn to the left: the left wheel goes back, the rear one to the right.
        ((0.0, 0.0, 0.1), (-0.026885, 0.026885, -0.02745)),
    ],
)
def test_the_three_plain_motions(delta, travel):
    found = odometry.body_deltas(WHEELS, [travel])
    np.testing.assert_allclose(found, [delta], atol=1e-15)


@given(seeds, st.integers(3, 6), motions)
def test_what_the_wheels_roll_tells_how_the_base_moved(seed, n, deltas):
    wheels = random_wheels(np.random.default_rng(seed), n)
    travel = deltas @ wheels.matrix.T
    # The condition of the matrix is below 100, so 1e-16 becomes at most 1e-14.
    np.testing.assert_allclose(odometry.body_deltas(wheels, travel), deltas, atol=1e-12)
    yaw = wrap_angle(3.0 + np.concatenate([[0.0], np.cumsum(deltas[:, 2])]))
    np.testing.assert_allclose(odometry.body_deltas(wheels, travel, yaw), deltas, atol=1e-12)


def test_a_fourth_wheel_averages_what_three_already_know():
    wheels = TrackingWheels([*POSITIONS, [BEHIND, 0.0]], [0.0, 0.0, pi / 2, pi / 2], RADIUS, 3200)
    # The rear wheel reads 2 mm too much, the front one is right: half of it stays, and the rest
    # looks like a turn, which the four lever arms share out: Σ lever · error / Σ lever².
    found = odometry.body_deltas(wheels, [[0.1, 0.1, 0.002, 0.0]])
    turn = -BEHIND * 0.002 / (TRACK**2 / 2 + 2 * BEHIND**2)
    assert found[0] == pytest.approx([0.1, 0.001, turn])


def test_a_gyroscope_takes_the_place_of_the_wheels_turn_and_of_nothing_else():
    travel = np.array([[0.10, 0.12, 0.05]])
    yaw = [0.5, 0.54]
    found = odometry.body_deltas(WHEELS, travel, yaw)[0]
    assert found[2] == pytest.approx(0.04, abs=1e-15)
    assert found[0] == pytest.approx(0.11)
    assert found[1] == pytest.approx(0.05 + 0.04 * BEHIND)  # not the wheels' 0.02 / track


def test_a_turn_over_the_edge_of_a_wrapped_heading_is_small():
    found = odometry.body_deltas(WHEELS, np.zeros((2, 3)), [3.1, -3.1, 3.1])
    assert found[:, 2] == pytest.approx([TURN - 6.2, 6.2 - TURN])


@pytest.mark.parametrize("reach", [0.0, 0.1, -0.3])
@pytest.mark.parametrize("directions", [(0.0, 0.0), (0.0, pi), (pi, pi)])
def test_two_wheels_whose_axle_is_off_the_origin(reach, directions):
    # Turning about the axle's middle drags the origin along a circle around it.
    wheels = TrackingWheels([[-reach, 0.2], [-reach, -0.2]], directions, 0.03, 3200)
    delta = np.array([0.1, reach * 0.3, 0.3])
    travel = [wheels.matrix @ delta]
    np.testing.assert_allclose(odometry.body_deltas(wheels, travel), [delta], atol=1e-15)
    found = odometry.body_deltas(wheels, travel, [0.0, 0.3])
    np.testing.assert_allclose(found, [delta], atol=1e-15)


def test_two_wheels_across_need_a_gyroscope():
    wheels = TrackingWheels([[0.0, 0.2], [-0.3, 0.0]], [0.0, pi / 2], 0.03, 3200)
    delta = np.array([0.1, -0.2, 0.3])
    travel = [wheels.matrix @ delta]
    np.testing.assert_allclose(
        odometry.body_deltas(wheels, travel, [1.0, 1.3]), [delta], atol=1e-15
    )
    with pytest.raises(ValueError, match="these 2 wheels cannot tell forward, left and turn apart"):
        odometry.body_deltas(wheels, travel)


@pytest.mark.parametrize(
    "positions, directions",
    [
        ([[0.0, 0.2], [0.0, -0.2], [0.1, 0.0]], [0.3, 0.3, 0.3 + pi]),  # all parallel
        ([[0.1, 0.0], [0.2, 0.0], [0.0, 0.3]], [0.0, 0.0, pi / 2]),  # all point at the centre
        ([[0.1, 0.2], [-0.1, 0.2]], [0.0, 0.0]),  # two in one line
        ([[0.1, 0.2]], [0.0]),
    ],
)
def test_wheels_that_cannot_tell_all_motions_apart_are_refused(positions, directions):
    wheels = TrackingWheels(positions, directions, 0.03, 3200)
    with pytest.raises(ValueError, match="cannot tell forward, left and turn apart"):
        odometry.body_deltas(wheels, np.zeros((1, len(positions))))


def test_wrong_travel_and_headings_are_refused_by_name():
    with pytest.raises(ValueError, match=r"travel: expected shape \(n, 3\), got \(3,\)"):
        odometry.body_deltas(WHEELS, [0.1, 0.1, 0.0])
    with pytest.raises(ValueError, match=r"travel: entry \(0, 1\) is not a finite number"):
        odometry.body_deltas(WHEELS, [[0.1, nan, 0.0]])
    with pytest.raises(ValueError, match=r"yaw: expected shape \(2,\), got \(1,\)"):
        odometry.body_deltas(WHEELS, [[0.1, 0.1, 0.0]], [0.0])
    with pytest.raises(ValueError, match=r"ticks: expected shape .*3"):
        odometry.wheel_travel(WHEELS, [1, 2])


def test_check_the_source_the_printed_sign_reads_a_turn_as_sideways_travel():
    # Thesis, section "Odometry": Δy = ΔC - (ΔR - ΔL) offset / track. With the wheel behind the
    # centre the sign has to be plus: a turn of 90° on the spot becomes 2 · 274.5 mm · π/2 = 862 mm.
    left, right, rear = WHEELS.matrix @ [0.0, 0.0, pi / 2]
    printed = rear - (right - left) * BEHIND / TRACK
    assert printed == pytest.approx(-2.0 * BEHIND * pi / 2)
    np.testing.assert_allclose(
        odometry.body_deltas(WHEELS, [[left, right, rear]]), [[0.0, 0.0, pi / 2]], atol=1e-15
    )
    # It holds as printed for a wheel in front of the centre, or a counter that runs backwards.
    in_front = replace(WHEELS, positions=[*POSITIONS[:2], [BEHIND, 0.0]])
    left, right, front = in_front.matrix @ [0.02, 0.03, 0.1]
    assert front - (right - left) * BEHIND / TRACK == pytest.approx(0.03)


def test_check_the_source_the_total_distance_knows_only_straight_lines():
    # Path tracking paper, equations 3 to 7: x = d sin θ, y = d cos θ with the total distance d.
    side = np.tile([0.01, 0.0, 0.0], (150, 1))
    poses = odometry.integrate(np.concatenate([side, [[0.0, 0.0, -pi / 2]], side]))
    distance, theta = 3.0, -poses[-1, 2]  # clockwise from the y axis, there
    printed = distance * np.array([np.sin(theta), np.cos(theta)])
    assert printed == pytest.approx([3.0, 0.0], abs=1e-12)
    # 1.5 m up, turned right, 1.5 m on: forward is their y, and their x is our -y
    assert [-poses[-1, 1], poses[-1, 0]] == pytest.approx([1.5, 1.5])


# --- poses ------------------------------------------------------------------------------------


def naive_integrate(deltas, start):
    """Poses once more, step by step, from the group's own operations."""
    rows = [np.asarray(start, dtype=float)]
    for delta in deltas:
        rows.append(compose(rows[-1], se2_exp(delta)))
    return np.array(rows)


@compiled
@given(
    arrays(float, (7, 3), elements=st.floats(-4.0, 4.0)),
    arrays(float, 3, elements=st.floats(-9.0, 9.0)),
)
def test_integrate_chains_exponentials(deltas, start):
    found = odometry.integrate(deltas, start)
    np.testing.assert_allclose(found, naive_integrate(deltas, start), atol=1e-12)


def test_integrate_agrees_with_a_peer():
    try:
        from wpimath.geometry import Pose2d, Rotation2d, Twist2d
    except ImportError:
        missing("no robotpy-wpimath")
    deltas = np.random.default_rng(1).normal(0.0, [0.01, 0.01, 0.02], (5000, 3))
    pose, rows = Pose2d(1.0, 2.0, Rotation2d(0.5)), [(1.0, 2.0, 0.5)]
    for delta in deltas.tolist():
        pose = pose.exp(Twist2d(*delta))
        rows.append((pose.x, pose.y, pose.rotation().radians()))
    error = odometry.integrate(deltas, [1.0, 2.0, 0.5]) - rows
    error[:, 2] = wrap_angle(error[:, 2])
    assert np.abs(error).max() < 1e-9


@compiled
@given(st.integers(1, 500), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.sampled_from([-1, 1, 3]))
def test_integrate_returns_to_the_start_after_full_circles(steps, forward, left, turns):
    deltas = np.tile([forward, left, turns * TURN / steps], (steps, 1))
    poses = odometry.integrate(deltas, [0.3, -0.4, 0.5])
    # 500 additions to a heading of up to 19 rad, 2e-15 each, on a circle of up to 225 m: 2e-10 m
    assert poses[-1] == pytest.approx([0.3, -0.4, 0.5 + turns * TURN], abs=1e-9)


def test_arcs_are_exact_where_euler_and_midpoint_are_not():
    # A quarter circle of radius 1 in 9 steps of 10 degrees
    turn = pi / 18
    deltas = np.tile([turn, 0.0, turn], (9, 1))
    assert odometry.integrate(deltas)[-1, :2] == pytest.approx([1.0, 1.0], abs=1e-14)
    headings = turn * np.arange(9)
    euler, midpoint = (
        turn * np.array([np.cos(angles).sum(), np.sin(angles).sum()])
        for angles in (headings, headings + turn / 2)
    )
    # Euler looks half a step's turn too far back: 0.087 of the chord of 1.41 m. The midpoint looks
    # right and only takes the arc for the chord: turn²/24 of it.
    assert np.hypot(*(euler - 1.0)) == pytest.approx(turn / 2 * np.sqrt(2.0), rel=0.02)
    assert np.hypot(*(midpoint - 1.0)) == pytest.approx(turn**2 / 24 * np.sqrt(2.0), rel=0.02)


@compiled
@given(motions, places)
def test_another_start_moves_the_whole_way_along(deltas, start):
    moved = compose(start, odometry.integrate(deltas))
    np.testing.assert_allclose(odometry.integrate(deltas, start), moved, atol=1e-13)


def test_no_motion_no_way():
    assert odometry.integrate(np.zeros((0, 3)), [1.0, 2.0, 3.0]).tolist() == [[1.0, 2.0, 3.0]]
    assert odometry.integrate(np.zeros((2, 3)))[-1].tolist() == [0.0, 0.0, 0.0]


def test_integrate_refuses_holes_and_wrong_shapes():
    with pytest.raises(ValueError, match=r"deltas: entry \(1, 2\) is not a finite number"):
        odometry.integrate([[0.0, 0.0, 0.0], [0.0, 0.0, nan]])
    with pytest.raises(ValueError, match=r"deltas: expected shape \(n, 3\), got \(3,\)"):
        odometry.integrate([0.0, 0.0, 0.0])
    with pytest.raises(ValueError, match=r"start: expected shape \(3,\), got \(2,\)"):
        odometry.integrate([[0.0, 0.0, 0.0]], [0.0, 0.0])


# --- velocity ---------------------------------------------------------------------------------


@pytest.mark.parametrize("heading", [0.0, pi / 2, 3.0, -pi])
@pytest.mark.parametrize("twist", [(-1.0, 0.0, 0.0), (0.0, -0.5, 0.0), (0.0, 0.0, -2.0)])
def test_backwards_right_and_clockwise_are_negative_whatever_the_heading(heading, twist):
    poses = odometry.integrate(np.tile(twist, (4, 1)) * 0.05, [5.0, 5.0, heading])
    found = odometry.body_velocity(poses, 0.05)
    np.testing.assert_allclose(found, np.tile(twist, (4, 1)), atol=1e-12)


@compiled
@given(motions, places)
def test_body_velocity_undoes_integrate_with_headings_wrapped_too(deltas, start):
    poses = odometry.integrate(deltas, start)
    poses[:, 2] = wrap_angle(poses[:, 2])
    np.testing.assert_allclose(odometry.body_velocity(poses, 0.05) * 0.05, deltas, atol=1e-12)


def test_check_the_source_differences_without_wrap_and_sign():
    # A slow turn over the edge of the heading, backwards: absolute and unwrapped differences as
    # printed see 125 rad/s, and a robot that drives ahead.
    poses = odometry.integrate([[-0.01, 0.0, 0.02]], [0.0, 0.0, pi - 0.01])
    poses[:, 2] = wrap_angle(poses[:, 2])
    printed = np.abs(np.diff(poses, axis=0)[0]) / 0.05
    assert printed[2] == pytest.approx((TURN - 0.02) / 0.05) and printed[0] > 0.0
    ours = odometry.body_velocity(poses, 0.05)[0]
    assert ours == pytest.approx([-0.2, 0.0, 0.4], abs=1e-12)


def test_one_pose_has_no_velocity():
    assert odometry.body_velocity([[1.0, 2.0, 3.0]], 0.05).shape == (0, 3)


@pytest.mark.parametrize("dt", [0.0, -0.05, inf, nan])
def test_body_velocity_refuses_a_time_that_is_none(dt):
    with pytest.raises(ValueError, match="dt: expected seconds above 0"):
        odometry.body_velocity(np.zeros((2, 3)), dt)


# --- a control loop ---------------------------------------------------------------------------


@pytest.fixture(scope="module")
def drive():
    """Whole counts of a drive, and a gyroscope's headings before it and after each sample."""
    rng = np.random.default_rng(4)
    deltas = random_drive(rng)
    ticks = np.diff(np.floor(np.cumsum(counts(WHEELS, deltas), axis=0)), axis=0, prepend=0.0)
    yaw = np.cumsum(np.concatenate([[0.7], deltas[:, 2] + rng.normal(0.0, 1e-3, len(deltas))]))
    return ticks.astype(np.int64), wrap_angle(yaw)


def batch(ticks, yaw=None, start=(0.0, 0.0, 0.0)):
    travel = odometry.wheel_travel(WHEELS, ticks)
    return odometry.integrate(odometry.body_deltas(WHEELS, travel, yaw), start)


def test_a_stream_by_wheels_goes_where_the_batch_goes(drive):
    ticks, _ = drive
    stream = odometry.Odometry(WHEELS, [1.0, 2.0, 0.5])
    rows = [stream.pose] + [stream.update(row) for row in ticks]
    np.testing.assert_allclose(rows, batch(ticks, start=[1.0, 2.0, 0.5]), atol=1e-12)


def test_a_stream_by_gyroscope_goes_where_the_batch_goes(drive):
    ticks, yaw = drive
    stream = odometry.Odometry(WHEELS, yaw=yaw[0])
    rows = [stream.pose] + [stream.update(row, y) for row, y in zip(ticks, yaw[1:], strict=True)]
    np.testing.assert_allclose(rows, batch(ticks, yaw), atol=1e-12)


def test_saved_and_restored_it_goes_on_as_if_nothing_had_happened(drive):
    ticks, yaw = drive
    through, before, after = (odometry.Odometry(WHEELS) for _ in range(3))
    for k, (row, y) in enumerate(zip(ticks, yaw[1:], strict=True)):
        through.update(row, y)
        if k == 200:
            after.state = before.state
        (before if k < 200 else after).update(row, y)
    assert after.pose.tolist() == through.pose.tolist()


def test_reset_puts_it_elsewhere_and_forgets_the_gyroscope(drive):
    ticks, yaw = drive
    stream, fresh = odometry.Odometry(WHEELS), odometry.Odometry(WHEELS, [3.0, 4.0, 1.0])
    stream.update(ticks[0], yaw[0])
    stream.reset([3.0, 4.0, 1.0])
    for row, y in zip(ticks[1:5], yaw[1:5], strict=True):
        assert stream.update(row, y).tolist() == fresh.update(row, y).tolist()


def test_bad_counts_are_left_out_and_the_gyroscope_turns_the_pose(drive):
    stream = odometry.Odometry(WHEELS, [1.0, 2.0, 0.0], yaw=3.1)
    pose = stream.update([5.0, nan, 5.0], -3.1)
    assert pose == pytest.approx([1.0, 2.0, TURN - 6.2])
    assert stream.update([inf, 0.0, 0.0]) == pytest.approx([1.0, 2.0, TURN - 6.2])
    assert stream.rejected == 2
    assert np.isfinite(stream.update([5, 5, 5])).all() and stream.rejected == 2


def test_without_a_heading_the_wheels_turn_the_pose_until_there_are_two_in_a_row():
    quarter = WHEELS.matrix @ [0.0, 0.0, pi / 2] / WHEELS.metres_per_tick
    stream = odometry.Odometry(WHEELS)
    headings = [None, 0.0, 0.1, nan, 0.2, 0.3, None, 0.4, 0.5]
    turns = np.diff([0.0] + [stream.update(quarter, yaw)[2] for yaw in headings])
    assert turns == pytest.approx([pi / 2, *[pi / 2, 0.1, pi / 2] * 2, pi / 2, 0.1])


def test_what_is_handed_out_or_in_is_not_the_memory():
    start = np.array([1.0, 2.0, 3.0])
    stream = odometry.Odometry(WHEELS, start)
    start += 1.0
    stream.update([0, 0, 0])[:] = 7.0
    stream.pose[:] = 7.0
    stream.state.pose[:] = 7.0
    assert stream.pose.tolist() == [1.0, 2.0, 3.0]


def test_a_stream_refuses_what_is_wrong_with_the_program_and_not_with_a_sensor():
    stream = odometry.Odometry(WHEELS)
    with pytest.raises(ValueError, match=r"ticks: expected shape \(3,\), got \(2,\)"):
        stream.update([1, 2])
    with pytest.raises(ValueError, match=r"pose: expected shape \(3,\)"):
        stream.reset([1.0, 2.0])
    across = TrackingWheels([[0.0, 0.2], [-0.3, 0.0]], [0.0, pi / 2], 0.03, 3200)
    assert np.isfinite(odometry.Odometry(across, yaw=0.0).update([1, 2], 0.1)).all()
    with pytest.raises(ValueError, match="cannot tell"):
        odometry.Odometry(across).update([1, 2])


# --- calibration ------------------------------------------------------------------------------

DIAGONAL = np.array([3.0, 2.0])
FIVE_TURNS = 5.0 * TURN


def calibrated(true: TrackingWheels, nominal: TrackingWheels = WHEELS, run=DIAGONAL, whole=False):
    run_ticks = counts(true, [*run, 0.0])
    spin_ticks = counts(true, [0.0, 0.0, FIVE_TURNS])
    if whole:
        run_ticks, spin_ticks = np.floor(run_ticks), np.floor(spin_ticks)
    return odometry.calibrate_wheels(nominal, run_ticks, run, spin_ticks, FIVE_TURNS)


@given(seeds)
def test_a_run_and_a_spin_find_the_true_sizes(seed):
    true = slightly_off(WHEELS, np.random.default_rng(seed))
    found = calibrated(true)
    np.testing.assert_allclose(found.radius, true.radius, rtol=1e-13)
    np.testing.assert_allclose(found.matrix, true.matrix, atol=1e-13)


def test_track_width_and_offset_of_the_rear_wheel_by_hand():
    # Radii 1 % larger count 1 % less; a track of 540 mm and an offset of 270 mm
    true = replace(
        WHEELS, positions=[[0.0, 0.27], [0.0, -0.27], [-0.27, 0.0]], radius=1.01 * RADIUS
    )
    found = calibrated(true)
    assert found.radius == pytest.approx([1.01 * RADIUS] * 3)
    np.testing.assert_allclose(found.positions, true.positions, atol=1e-15)


@given(seeds)
def test_wheels_move_only_square_to_their_direction(seed):
    rng = np.random.default_rng(seed)
    places = rng.uniform(0.1, 0.3, (4, 2)) * [[1, 1], [-1, 1], [-1, -1], [1, -1]]
    # Within 40° of the run, either way about: every wheel rolls
    directions = 0.6 + rng.uniform(-0.7, 0.7, 4) + rng.choice([0.0, pi], 4)
    nominal = TrackingWheels(places, directions, 0.03, 3200)
    true = slightly_off(nominal, rng)
    found = calibrated(true, nominal)
    along = np.column_stack([np.cos(directions), np.sin(directions)])
    moved = ((found.positions - places) * along).sum(axis=1)
    np.testing.assert_allclose(moved, 0.0, atol=1e-15)
    np.testing.assert_allclose(found.matrix, true.matrix, atol=1e-12)


def test_whole_counts_are_good_enough():
    # One count of the 1.9 m that the left wheel rolls at least is 3e-5 of it; of the spin 7e-6.
    for seed in range(20):
        true = slightly_off(WHEELS, np.random.default_rng(seed))
        found = calibrated(true, whole=True)
        np.testing.assert_allclose(found.radius, true.radius, rtol=4e-5)
        np.testing.assert_allclose(found.matrix, true.matrix, atol=2e-5)


def test_two_wheels_side_by_side_need_only_a_straight_run():
    nominal = TrackingWheels([[0.0, -0.1], [0.0, 0.1]], [0.0, 0.0], 0.042, 2797)
    true = slightly_off(nominal, np.random.default_rng(3))
    found = calibrated(true, nominal, np.array([4.0, 0.0]))
    np.testing.assert_allclose(found.matrix, true.matrix, atol=1e-13)


RUN_TICKS, SPIN_TICKS = counts(WHEELS, [*DIAGONAL, 0.0]), counts(WHEELS, [0.0, 0.0, FIVE_TURNS])


@pytest.mark.filterwarnings("error")  # a wheel that never counted is no division by zero
@pytest.mark.parametrize(
    "run_ticks, run, spin_ticks, angle, sentence",
    [
        (RUN_TICKS, (3.0, 0.0), SPIN_TICKS, FIVE_TURNS, "too little to tell its size; drive diag"),
        (RUN_TICKS, (0.0, 0.0), SPIN_TICKS, FIVE_TURNS, "too little to tell its size"),
        (RUN_TICKS, (3000.0, 2000.0), SPIN_TICKS, FIVE_TURNS, r"run_ticks: .* units \(m, rad\)"),
        (-RUN_TICKS, DIAGONAL, SPIN_TICKS, FIVE_TURNS, "a counter that runs backwards"),
        (RUN_TICKS[[0, 2, 1]], DIAGONAL, SPIN_TICKS, FIVE_TURNS, "swapped wheels"),
        (RUN_TICKS * [1, 1, 0], DIAGONAL, SPIN_TICKS, FIVE_TURNS, "run_ticks: they make the radii"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS[[1, 0, 2]], FIVE_TURNS, "spin_ticks: .* swapped wheels"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS, -FIVE_TURNS, "spin_ticks: they make the lever arms"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS, 1800.0, "spin_ticks: .* units"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS, 0.0, "angle: a spin of 0.0 rad says little"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS, nan, "angle: a spin of nan rad"),
        (RUN_TICKS, DIAGONAL, SPIN_TICKS, inf, "angle: a spin of inf rad"),
        (RUN_TICKS[:2], DIAGONAL, SPIN_TICKS, FIVE_TURNS, r"run_ticks: expected shape \(3,\)"),
        (RUN_TICKS, (1.0, 2.0, 3.0), SPIN_TICKS, FIVE_TURNS, r"run: expected shape \(2,\)"),
        (RUN_TICKS, DIAGONAL, [nan, 1, 1], FIVE_TURNS, r"spin_ticks: entry \(0,\) is not a finite"),
    ],
)
def test_calibration_refuses_drives_that_show_nothing(run_ticks, run, spin_ticks, angle, sentence):
    with pytest.raises(ValueError, match=sentence):
        odometry.calibrate_wheels(WHEELS, run_ticks, run, spin_ticks, angle)


def known_drive(true: TrackingWheels, rng):
    """Counts of robot ``true`` and its poses."""
    deltas = random_drive(rng)
    return counts(true, deltas), odometry.integrate(deltas, [1.0, 2.0, 3.0])


def test_self_calibration_finds_the_true_sizes_where_a_drive_shows_them():
    rng = np.random.default_rng(2)
    true = slightly_off(WHEELS, rng)
    ticks, truth = known_drive(true, rng)
    trusting = SizePrior(position=1e-5, heading=1e-5)
    found = odometry.self_calibrate(WHEELS, ticks, truth, prior=trusting)
    # The prior still pulls, by (1e-5 / what a tolerance moves the poses)² of it: below 1e-4 of 1 %.
    np.testing.assert_allclose(found.radius, true.radius, rtol=1e-6)
    np.testing.assert_allclose(found.matrix, true.matrix, atol=1e-6)


def test_self_calibration_leaves_alone_what_a_drive_does_not_show():
    # Straight ahead: nothing is known of the rear wheel, nor of any lever arm.
    deltas = np.tile([0.02, 0.0, 0.0], (200, 1))
    true = replace(WHEELS, radius=1.005 * RADIUS)
    ticks, truth = counts(true, deltas), odometry.integrate(deltas)
    found = odometry.self_calibrate(WHEELS, ticks, truth, prior=SizePrior(position=1e-3))
    np.testing.assert_allclose(found.matrix, WHEELS.matrix, atol=1e-6)
    assert found.radius[2] == pytest.approx(RADIUS, rel=1e-9)
    # 1 % moves the poses by 2 cm in the mean: the prior pulls by (1 mm / 2 cm)² of half a per cent.
    assert found.radius[:2] == pytest.approx([1.005 * RADIUS] * 2, rel=3e-5)


def test_self_calibration_ends_at_the_least_sum_of_squares():
    rng = np.random.default_rng(9)
    ticks, truth = known_drive(slightly_off(WHEELS, rng), rng)
    truth[:, :2] += rng.normal(0.0, 0.01, (len(truth), 2))
    prior = SizePrior()

    def cost(wheels):
        poses = odometry.integrate(
            odometry.body_deltas(wheels, odometry.wheel_travel(wheels, ticks)), truth[0]
        )
        place, turn = (poses - truth)[:, :2] / prior.position, (poses - truth)[:, 2] / prior.heading
        growth = np.log(wheels.radius / RADIUS) / prior.radius
        lever = (wheels.matrix - WHEELS.matrix)[:, 2] / (prior.lever * BEHIND)
        mean = (place**2).sum(axis=1).mean() + (turn**2).mean()
        return mean + (growth**2).sum() + (lever**2).sum()

    found = odometry.self_calibrate(WHEELS, ticks, truth)
    least = cost(found)
    for wheel in range(3):
        for sign in (-1.0, 1.0):
            radius, places = np.array(found.radius), np.array(found.positions)
            radius[wheel] *= 1.0 + sign * 1e-4
            places[wheel] += sign * 1e-4 * np.array([1.0, -1.0])
            assert cost(replace(found, radius=radius)) > least
            assert cost(replace(found, positions=places)) > least


def test_self_calibration_needs_poses_and_tolerances():
    ticks, truth = known_drive(WHEELS, np.random.default_rng(1))
    unknown = np.full_like(truth, nan)
    with pytest.raises(ValueError, match="the first pose and one more must be known"):
        odometry.self_calibrate(WHEELS, ticks, unknown)
    unknown[1:] = truth[1:]
    with pytest.raises(ValueError, match="the first pose and one more must be known"):
        odometry.self_calibrate(WHEELS, ticks, unknown)
    with pytest.raises(ValueError, match=r"truth: expected shape \(401, 3\), got \(400, 3\)"):
        odometry.self_calibrate(WHEELS, ticks, truth[1:])
    with pytest.raises(ValueError, match="prior: expected tolerances above 0"):
        odometry.self_calibrate(WHEELS, ticks, truth, prior=SizePrior(radius=0.0))
    with pytest.raises(ValueError, match=r"ticks: entry \(0, 0\) is not a finite"):
        odometry.self_calibrate(WHEELS, ticks * nan, truth)


# --- heading ----------------------------------------------------------------------------------

DT = 0.01


def after(seconds: float, gyro: float, wheel: float, state=HeadingState(), **gains) -> HeadingState:  # noqa: B008
    for _ in range(round(seconds / DT)):
        state = odometry.fuse_heading(state, gyro, wheel, DT, HeadingGains()._replace(**gains))
    return state


def test_without_bias_and_slip_the_heading_is_the_turn():
    assert after(2.0, 0.5, 0.5) == pytest.approx((1.0, 0.0, 0.0, 0.0, 0), abs=1e-12)


def test_at_rest_the_bias_is_the_mean_so_far_and_the_heading_stays():
    state = HeadingState()
    readings = np.random.default_rng(5).normal(0.01, 0.002, 300)
    for reading in readings.tolist():
        state = odometry.fuse_heading(state, reading, 0.0, DT)
    assert state.bias == pytest.approx(readings.mean(), rel=1e-12)
    assert state.yaw == 0.0 and state.taught == pytest.approx(3.0) and state.rejected == 0


def test_what_was_taught_long_enough_fades_with_the_time_constant():
    state = after(2.0, 0.03, 0.0, HeadingState(bias=0.01, taught=2.0), still=2.0)
    # Steps of 1/200: (1 - 1/200)^200 = e^-1 to a quarter of a per cent
    assert state.bias == pytest.approx(0.03 - 0.02 * exp(-1.0), rel=1e-3)
    assert state.taught == 2.0


def test_a_bias_brought_along_counts_as_long_as_its_log():
    state = after(5.0, 0.03, 0.0, HeadingState(bias=0.01, taught=15.0))
    assert state.bias == pytest.approx((15.0 * 0.01 + 5.0 * 0.03) / 20.0)


def test_rolling_wheels_teach_slowly():
    state = after(30.0, 0.51, 0.5, rolling=30.0)
    assert state.bias == pytest.approx(0.01 * (1.0 - exp(-1.0)), rel=1e-3)
    assert after(30.0, 0.51, 0.5, rolling=inf).bias == 0.0


def test_a_short_stop_is_no_rest():
    state = HeadingState(bias=0.01)
    for _ in range(20):
        state = after(0.01, 0.52, 0.5, state, rolling=inf)
        state = after(0.1, 0.02, 0.0, state, rolling=inf)
    assert state.bias == 0.01 and state.taught == 0.0


def test_after_a_stop_long_enough_it_stands():
    state = after(0.01, 0.5, 0.5)
    assert after(0.1, 0.0, 0.0, state).taught == 0.0
    # Twenty samples make 0.2 s, give or take the last bit.
    assert after(1.2, 0.01, 0.0, state).taught == pytest.approx(1.0, abs=0.02)


def test_slip_turns_the_wheels_and_not_the_heading():
    state = after(1.0, 0.0, 0.4, HeadingState(yaw=1.0, bias=0.001))
    assert state.bias == 0.001 and state.rejected == 100
    assert state.yaw == pytest.approx(1.0 - 0.001)


def test_a_lost_encoder_that_says_zero_while_the_robot_turns_teaches_nothing():
    state = after(5.0, 0.5, 0.0)
    assert state.bias == 0.0 and state.yaw == pytest.approx(2.5) and state.rejected == 500


@pytest.mark.parametrize("hole", [nan, inf, -inf])
def test_each_of_the_two_bridges_the_other(hole):
    start = HeadingState(yaw=1.0, bias=0.01)
    by_wheels = after(1.0, hole, 0.2, start)
    assert by_wheels.yaw == pytest.approx(1.2) and by_wheels.bias == 0.01
    by_gyro = after(1.0, 0.21, hole, start)
    assert by_gyro.yaw == pytest.approx(1.2) and by_gyro.bias == 0.01
    by_none = after(1.0, hole, hole, start)
    assert by_none.yaw == 1.0 and by_none.bias == 0.01
    assert by_wheels.rejected == by_gyro.rejected == by_none.rejected == 100


def test_a_gap_settles_the_bias_and_does_not_shoot_beyond():
    standing = odometry.fuse_heading(HeadingState(), 0.01, 0.0, 60.0)
    assert standing.bias == 0.01 and standing.yaw == 0.0
    rolling = odometry.fuse_heading(HeadingState(), 0.51, 0.5, 60.0, HeadingGains(rolling=1.0))
    assert rolling.bias == pytest.approx(0.01) and rolling.yaw == pytest.approx(30.0)


def test_a_log_is_row_by_row_the_same_as_the_steps():
    rng = np.random.default_rng(3)
    gyro, wheel = rng.normal(0.0, 0.05, (2, 500))
    wheel[100:200] = 0.0
    gyro[50], wheel[60] = nan, nan
    dt = rng.uniform(0.005, 0.02, 500)
    start = HeadingState(0.3, 0.002, 0.1, 2.0, 7)
    log = odometry.estimate_heading(gyro, wheel, dt, start=start)
    states = [start]
    for row in zip(gyro.tolist(), wheel.tolist(), dt.tolist(), strict=True):
        states.append(odometry.fuse_heading(states[-1], *row))
    assert log.yaw.tolist() == [state.yaw for state in states]
    assert log.bias.tolist() == [state.bias for state in states]
    assert log.rejected == states[-1].rejected
    even = odometry.estimate_heading(gyro, wheel, 0.01)
    assert len(even.yaw) == 501 and np.isfinite(even.yaw).all()


def test_a_step_leaves_the_state_before_as_it_was():
    state = HeadingState(0.1, 0.2, 0.3, 0.4, 5)
    odometry.fuse_heading(state, 1.0, 1.0, 0.01)
    assert state == (0.1, 0.2, 0.3, 0.4, 5)


@pytest.mark.parametrize("dt", [0.0, -0.01, inf, nan])
def test_heading_refuses_a_time_that_is_none(dt):
    with pytest.raises(ValueError, match="dt: must be"):
        odometry.fuse_heading(HeadingState(), 0.0, 0.0, dt)
    with pytest.raises(ValueError, match="dt: "):
        odometry.estimate_heading([0.0], [0.0], dt)


@pytest.mark.parametrize(
    "gains", [{"still": 0.0}, {"rolling": -1.0}, {"slip": nan}, {"rest": -0.1}, {"still": nan}]
)
def test_heading_refuses_gains_without_meaning(gains):
    with pytest.raises(ValueError, match="gains: time constants must be positive"):
        after(0.01, 0.0, 0.0, **gains)


def test_heading_refuses_logs_that_do_not_fit():
    with pytest.raises(ValueError, match=r"wheel: expected shape \(2,\), got \(3,\)"):
        odometry.estimate_heading([0.0, 0.0], [0.0] * 3, 0.01)
    with pytest.raises(ValueError, match=r"dt: expected shape \(2,\)"):
        odometry.estimate_heading([0.0, 0.0], [0.0, 0.0], [0.01])


def test_the_slip_limit_lies_above_what_two_counts_and_a_fresh_gyroscope_make():
    two_counts = 2 * WHEELS.metres_per_tick[0] / TRACK / DT
    assert radians(1.0) < two_counts < radians(1.3)
    assert two_counts + radians(0.5) < HeadingGains().slip
