"""Chapter 03: four steered wheels make one motion, and say what motion they made."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan, pi

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from conftest import missing
from robocon_course import geometry, swerve
from robocon_course.autopilot import Parts, module_command
from robocon_course.robot import MODULES
from robocon_course.simulator import IDEAL, Simulator
from robocon_course.swerve.modules import fill_targets
from robocon_course.swerve.motion import fill_motion

SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
UNTURNED = np.zeros(4)
compiled = settings(deadline=None)  # the first call compiles
twists = arrays(float, 3, elements=st.floats(-5.0, 5.0))
turned = arrays(float, 4, elements=st.floats(-30.0, 30.0))  # steering counts its turns
speeds4 = arrays(float, 4, elements=st.floats(-5.0, 5.0))


@st.composite
def drives(draw):
    """Two to six modules anywhere within a metre, not all in one place."""
    places = arrays(float, (draw(st.integers(2, 6)), 2), elements=st.floats(-1.0, 1.0))
    positions = draw(places)
    assume(np.ptp(positions, axis=0).max() > 0.05)
    return positions


@pytest.fixture(scope="module")
def wpi():
    """The kinematics of another house, with our modules and their geometry module."""
    try:
        from wpimath import geometry as there
        from wpimath import kinematics
    except ImportError:
        missing("robotpy-wpimath is not installed")
    places = [there.Translation2d(*place) for place in MODULES]
    return kinematics, there, kinematics.SwerveDrive4Kinematics(*places)


def random_twists(n=1000, seed=1):
    return np.random.default_rng(seed).uniform(-4.0, 4.0, (n, 3))


def velocities(targets):
    """The modules' velocities as complex numbers: forward + 1j left."""
    return targets.speeds * np.exp(1j * targets.angles)


def naive_velocities(positions, twist):
    """The same from the twist: v + i ω r, with complex numbers for vectors."""
    vx, vy, omega = twist
    return complex(vx, vy) + 1j * omega * (positions @ [1.0, 1j])


def naive_motion(positions, speeds, angles):
    """Twist and residual, from one equation for each component."""
    rows, components = [], []
    for (x, y), speed, angle in zip(positions, speeds, angles, strict=True):
        rows += [[1.0, 0.0, -y], [0.0, 1.0, x]]
        components += [speed * np.cos(angle), speed * np.sin(angle)]
    twist = np.linalg.lstsq(np.array(rows), np.array(components))[0]
    return twist, np.sqrt(np.sum((rows @ twist - components) ** 2) / len(positions))


# --- twist to modules ----------------------------------------------------------------------------


def test_straight_ahead_all_modules_point_ahead():
    targets = swerve.module_targets(SQUARE, [2.0, 0.0, 0.0], UNTURNED)
    assert targets.speeds.tolist() == [2.0] * 4 and targets.angles.tolist() == [0.0] * 4


def test_to_the_left_all_modules_point_left():
    targets = swerve.module_targets(SQUARE, [0.0, 2.0, 0.0], UNTURNED)
    assert targets.angles.tolist() == [pi / 2] * 4


def test_turning_left_on_the_spot_each_module_stands_across_its_radius():
    targets = swerve.module_targets(SQUARE, [0.0, 0.0, 1.0], UNTURNED)
    assert targets.speeds == pytest.approx([np.sqrt(2.0)] * 4)
    assert np.degrees(targets.angles) == pytest.approx([135.0, -135.0, -45.0, 45.0])


def test_ahead_and_left_turn_by_hand():
    targets = swerve.module_targets(SQUARE, [2.0, 0.0, 1.0], UNTURNED)
    # front left (2 - 1, 1), rear left (2 - 1, -1), rear right (2 + 1, -1), front right (2 + 1, 1)
    assert targets.speeds**2 == pytest.approx([2.0, 2.0, 10.0, 10.0])
    assert np.tan(targets.angles) == pytest.approx([1.0, -1.0, -1 / 3, 1 / 3])


@compiled
@given(drives(), twists)
def test_each_module_moves_with_the_velocity_of_its_place(positions, twist):
    targets = swerve.module_targets(positions, twist, np.zeros(len(positions)))
    # A module below REST is told to stand: that is all that may differ.
    difference = np.abs(velocities(targets) - naive_velocities(positions, twist))
    assert (difference <= np.where(targets.speeds == 0.0, swerve.REST, 1e-12)).all()


@compiled
@given(st.integers(0, 3), st.floats(0.01, 5.0), turned)
def test_a_rotation_about_a_module_leaves_it_still_and_unturned(i, omega, angles):
    x, y = MODULES[i]
    targets = swerve.module_targets(MODULES, [omega * y, -omega * x, omega], angles)
    assert targets.speeds[i] == 0.0 and targets.angles[i] == angles[i]
    distance = np.hypot(*(MODULES - MODULES[i]).T)
    assert targets.speeds == pytest.approx(omega * distance, rel=1e-12)


@compiled
@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-5.0, 5.0))
def test_in_a_rotation_about_any_point_speed_goes_with_distance_and_wheels_stand_across(
    x, y, omega
):
    targets = swerve.module_targets(MODULES, [omega * y, -omega * x, omega], UNTURNED)
    radius = (MODULES - [x, y]) @ [1.0, 1j]
    assert targets.speeds == pytest.approx(np.abs(omega * radius), abs=swerve.REST)
    assert (velocities(targets) * radius.conj()).real == pytest.approx(0.0, abs=1e-3)


@compiled
@given(turned)
def test_at_rest_every_module_keeps_its_angle(angles):
    targets = swerve.module_targets(MODULES, np.zeros(3), angles)
    assert targets.speeds.tolist() == [0.0] * 4 and targets.angles.tolist() == angles.tolist()


def test_creeping_below_rest_counts_as_still_and_just_above_does_not():
    below = swerve.module_targets(SQUARE, [0.0, 0.99 * swerve.REST, 0.0], UNTURNED)
    above = swerve.module_targets(SQUARE, [0.0, 1.01 * swerve.REST, 0.0], UNTURNED)
    assert not below.speeds.any() and not below.angles.any()
    assert above.speeds.all() and above.angles.tolist() == [pi / 2] * 4


def test_a_batch_equals_its_loop_to_the_bit_whatever_its_depth():
    batch = random_twists(60).reshape(3, 4, 5, 3)
    batch[1, 2, 3] = 0.0
    held = np.random.default_rng(2).uniform(-9, 9, (3, 4, 5, 4))
    targets = swerve.module_targets(MODULES, batch, held)
    one_row = swerve.module_targets(MODULES, batch, held[0, 0, 0])
    assert targets.speeds.shape == targets.angles.shape == (3, 4, 5, 4)
    for at in np.ndindex(3, 4, 5):
        single = swerve.module_targets(MODULES, batch[at], held[at])
        assert np.array_equal(single, [targets.speeds[at], targets.angles[at]])
        single = swerve.module_targets(MODULES, batch[at], held[0, 0, 0])
        assert np.array_equal(single, [one_row.speeds[at], one_row.angles[at]])


def test_an_empty_batch_is_an_empty_answer():
    targets = swerve.module_targets(MODULES, np.empty((0, 3)), UNTURNED)
    assert targets.speeds.shape == targets.angles.shape == (0, 4)
    assert swerve.body_motion(MODULES, *targets).residual.shape == (0,)
    assert swerve.limit_speeds(targets, 1.0).speeds.shape == (0, 4)
    assert swerve.shortest_turn(targets, UNTURNED).angles.shape == (0, 4)


def test_lists_integers_and_other_layouts_are_as_good_as_arrays():
    strided = np.zeros((6, 5))[::2, :3] + [1, 2, 3]
    expected = swerve.module_targets(MODULES, [1.0, 2.0, 3.0], UNTURNED)
    for twist in (
        [1, 2, 3],
        np.array([1, 2, 3], dtype=np.int32),
        strided[0],
        np.float32([1, 2, 3]),
    ):
        found = swerve.module_targets(MODULES.tolist(), twist, [0, 0, 0, 0])
        assert np.array_equal(found, expected)


def test_nothing_that_was_passed_in_is_changed():
    def frozen(*values):
        array = np.array(values, dtype=float)
        array.flags.writeable = False
        return array

    twist, now = frozen(1.0, -2.0, 3.0), frozen(0.5, 1.0, -4.0, 8.0)
    targets = swerve.module_targets(MODULES, twist, now)
    for part in targets:
        part.flags.writeable = False
    before = np.array(targets)
    swerve.shortest_turn(targets, now)
    swerve.limit_speeds(targets, 0.5)
    swerve.cosine_compensation(targets, now)
    swerve.body_motion(MODULES, *targets)
    swerve.discretize(swerve.field_to_robot(twist, 1.0), 0.02)
    swerve.pose_feedback(twist, frozen(0.0, 0.0, 9.0), 1.0, twist)
    swerve.follow(MODULES, twist, frozen(0.0, 0.0, 9.0), 1.0, duration=0.1)
    assert np.array_equal(targets, before) and twist.tolist() == [1.0, -2.0, 3.0]


# --- modules to twist ----------------------------------------------------------------------------


@compiled
@given(drives(), twists)
def test_forward_undoes_inverse_and_rolling_wheels_leave_no_residual(positions, twist):
    targets = swerve.module_targets(positions, twist, np.zeros(len(positions)))
    found, residual = swerve.body_motion(positions, *targets)
    # Two modules 5 cm apart feel a turn by 5 cm only: what REST hides is worth 20 times more.
    still = 40 * swerve.REST if (targets.speeds == 0.0).any() else 0.0
    np.testing.assert_allclose(found, twist, rtol=0.0, atol=1e-9 + still)
    assert residual <= 1e-9 + still


@compiled
@given(drives(), st.data())
def test_body_motion_equals_the_plain_least_squares(positions, data):
    any_floats = arrays(float, len(positions), elements=st.floats(-5.0, 5.0))
    speeds, angles = data.draw(any_floats), data.draw(any_floats)
    twist, residual = swerve.body_motion(positions, speeds, angles)
    expected, left_over = naive_motion(positions, speeds, angles)
    np.testing.assert_allclose(twist, expected, rtol=0.0, atol=1e-9)
    assert residual == pytest.approx(left_over, abs=1e-9)
    assert np.array_equal(swerve.body_twist(positions, speeds, angles), twist)


def test_one_spinning_wheel_by_hand():
    # Front right 1 m/s too fast along x: vx takes 1/4 of it, ω = 1/8 (r x d = 1, sum of r² = 8),
    # so 1 - 1/4 - 1/8 = 5/8 of its square is left over, shared by four modules.
    twist, residual = swerve.body_motion(SQUARE, [1.0, 1.0, 1.0, 2.0], UNTURNED)
    assert twist == pytest.approx([1.25, 0.0, 0.125])
    assert residual == pytest.approx(np.sqrt(5 / 8 / 4))


@pytest.mark.parametrize("angle, share", [(45.0, 0.75), (135.0, 0.5)], ids=["radial", "tangential"])
@pytest.mark.parametrize("size", [0.01, 0.235, 7.0])
def test_one_wrong_wheel_leaves_the_stated_share_whatever_the_size_of_the_robot(angle, share, size):
    twist = swerve.body_motion(SQUARE * size, [1.0, 0, 0, 0], np.radians([angle, 0, 0, 0]))
    assert twist.residual == pytest.approx(np.sqrt(share / 4))  # 0.433 and 0.354


def test_the_residual_tells_a_slipping_wheel_from_noise():
    rng = np.random.default_rng(3)
    noise = 0.01  # m/s and rad, of each encoder
    rows = swerve.module_targets(MODULES, rng.uniform(-1.5, 1.5, (20_000, 3)), UNTURNED)
    speeds = rows.speeds + rng.normal(0.0, noise, rows.speeds.shape)
    angles = rows.angles + rng.normal(0.0, noise, rows.angles.shape)
    slipping = speeds.copy()
    slipping[:, 2] += 0.3
    calm = swerve.body_motion(MODULES, speeds, angles).residual
    slip = swerve.body_motion(MODULES, slipping, angles).residual
    # Wheels up to 2 m/s: errors of 0.01 m/s along and up to 0.02 m/s across, five of eight left
    # over, so about 0.01 m/s; the slip adds 0.11 to 0.13 m/s.
    assert calm.max() < 0.06 < slip.min()


def test_wheels_that_slip_all_alike_are_not_found_out():
    assert swerve.body_motion(SQUARE, np.full(4, 2.0), UNTURNED).residual == pytest.approx(0.0)


def test_a_batch_of_readings_equals_its_loop_and_keeps_its_holes():
    rng = np.random.default_rng(4)
    speeds, angles = rng.uniform(-3, 3, (2, 5, 6, 4))
    speeds[1, 2, 3], angles[4, 5, 0] = inf, nan
    twist, residual = swerve.body_motion(MODULES, speeds, angles)
    for at in np.ndindex(5, 6):
        single = swerve.body_motion(MODULES, speeds[at], angles[at])
        assert np.array_equal(single.twist, twist[at], equal_nan=True)
        assert np.array_equal(single.residual, residual[at], equal_nan=True)
    holes = np.isnan(residual)
    assert np.argwhere(holes).tolist() == [[1, 2], [4, 5]]
    assert np.array_equal(np.isfinite(twist).all(axis=-1), ~holes)


def test_two_modules_are_enough_and_one_is_not():
    pair = [[0.3, 0.0], [-0.3, 0.0]]
    targets = swerve.module_targets(pair, [1.0, -0.5, 2.0], np.zeros(2))
    assert swerve.body_twist(pair, *targets) == pytest.approx([1.0, -0.5, 2.0])
    for positions in ([[0.3, 0.0]], [[0.3, 0.1]] * 4, [[0.3, 0.1], [0.3, 0.1 + 1e-6]]):
        with pytest.raises(ValueError, match=r"positions: .* two modules in different places, got"):
            swerve.SwerveDrive(positions)


def test_a_drive_keeps_its_own_copy_of_the_positions():
    positions = MODULES.copy()
    drive = swerve.SwerveDrive(positions)
    positions[:] = 0.0
    assert np.array_equal(drive.positions, MODULES)
    for array in (drive.positions, drive.matrix, drive.solver):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
    assert drive.matrix[:4].tolist() == [[1.0, 0.0, -y] for y in MODULES[:, 1]]
    assert drive.matrix[4:].tolist() == [[0.0, 1.0, x] for x in MODULES[:, 0]]


# --- which wheel slips ---------------------------------------------------------------------------


def slip_log(module, rows, by, *, noise=0.0, n=300):
    """Speeds and angles of a smooth drive, one wheel too fast in some rows."""
    rng, t = np.random.default_rng(9), np.linspace(0.0, 6.0, n)
    drive = np.column_stack([np.sin(t), 0.5 * np.cos(2 * t), np.sin(0.7 * t)])
    speeds, angles = swerve.module_targets(MODULES, drive, UNTURNED)
    speeds[rows, module] += by
    return speeds + rng.normal(0, noise, speeds.shape), angles + rng.normal(0, noise, angles.shape)


def naive_suspect(positions, speeds, angles):
    """The wheel that, left to turn as it likes, lets the others agree best; and its slip."""
    lines = np.exp(1j * angles)
    matrix = np.vstack([[[1.0, 0.0, -y], [0.0, 1.0, x]] for x, y in positions])
    components = np.ravel([[v.real, v.imag] for v in speeds * lines])
    best = (inf, None, None)
    for i, line in enumerate(lines):
        free = np.zeros(len(components))
        free[2 * i : 2 * i + 2] = line.real, line.imag
        wider = np.column_stack([matrix, free])
        found = np.linalg.lstsq(wider, components)[0]
        best = min(best, (np.sum((wider @ found - components) ** 2), i, found[3]))
    return best[1:]


@pytest.mark.parametrize("module", range(4))
@pytest.mark.parametrize("by", [0.4, -0.4])
def test_find_slip_names_the_wheel_and_the_rows(module, by):
    slipping = slice(100, 180)
    expected = np.full(300, swerve.NO_SLIP)
    expected[slipping] = module
    assert swerve.find_slip(MODULES, *slip_log(module, slipping, by)).tolist() == expected.tolist()
    noisy = swerve.find_slip(MODULES, *slip_log(module, slipping, by, noise=0.02))
    assert (noisy != expected).mean() < 0.02  # a median over seven rows is late by one or two


def test_find_slip_blames_nobody_while_all_wheels_roll():
    found = swerve.find_slip(MODULES, *slip_log(0, slice(0, 0), 0.0, noise=0.02))
    assert (found == swerve.NO_SLIP).all()


def test_find_slip_agrees_with_freeing_one_wheel_after_the_other():
    speeds, angles = slip_log(2, slice(0, 300), 0.5, noise=0.05)
    for k in range(0, 300, 20):
        suspect, slip = naive_suspect(MODULES, speeds[k], angles[k])
        still = np.tile(speeds[k], (9, 1)), np.tile(angles[k], (9, 1))  # nothing to smooth
        found = swerve.find_slip(MODULES, *still)
        assert found.tolist() == [suspect if abs(slip) > 0.1 else swerve.NO_SLIP] * 9


def test_without_noise_find_slip_is_exact_on_any_drive_and_at_any_angles():
    rng = np.random.default_rng(11)
    for _ in range(200):
        m = rng.integers(3, 6)
        positions = rng.uniform(-1.0, 1.0, (m, 2))
        speeds, angles = swerve.module_targets(positions, rng.uniform(-2, 2, 3), np.zeros(m))
        module = rng.integers(m)
        for by, found in ((0.1001, module), (-0.1001, module), (0.0999, swerve.NO_SLIP)):
            slipping = speeds + by * (np.arange(m) == module)
            assert swerve.find_slip(positions, [slipping], [angles]).tolist() == [found]


def test_find_slip_takes_short_logs_and_an_empty_one():
    assert swerve.find_slip(MODULES, np.ones((1, 4)), np.zeros((1, 4))).tolist() == [-1]
    assert swerve.find_slip(MODULES, np.empty((0, 4)), np.empty((0, 4))).tolist() == []


# --- kinder commands -----------------------------------------------------------------------------


def targets_of(speeds, angles):
    return swerve.ModuleTargets(np.asarray(speeds, float), np.asarray(angles, float))


@given(speeds4, turned, turned)
def test_shortest_turn_makes_the_same_velocity_with_at_most_a_quarter_turn(speeds, wanted, now):
    targets = targets_of(speeds, wanted)
    short = swerve.shortest_turn(targets, now)
    assert np.abs(short.angles - now).max() <= pi / 2 + 1e-12
    np.testing.assert_allclose(velocities(short), velocities(targets), rtol=0.0, atol=1e-12)


@given(speeds4, turned)
def test_a_module_that_already_stands_right_is_left_alone(speeds, now):
    short = swerve.shortest_turn(targets_of(speeds, now), now)
    assert np.array_equal(short, [speeds, now])


@pytest.mark.parametrize(
    "wanted, now, speed, angle",
    [
        (180.0, 0.0, -1.0, 0.0),
        (-180.0, 0.0, -1.0, 0.0),
        (90.0, 0.0, 1.0, 90.0),
        (100.0, 0.0, -1.0, -80.0),
        (-100.0, 0.0, -1.0, 80.0),
        (170.0, -170.0, 1.0, -190.0),
        (0.0, 350.0, 1.0, 360.0),
        (10.0, 3600.0 + 170.0, -1.0, 3600.0 + 190.0),
    ],
)
def test_shortest_turn_by_hand(wanted, now, speed, angle):
    short = swerve.shortest_turn(targets_of([1.0], np.radians([wanted])), np.radians([now]))
    assert short.speeds.tolist() == [speed] and np.degrees(short.angles) == pytest.approx([angle])


def test_steering_counts_its_turns_and_never_drifts_over_a_long_drive():
    # 1500 s straight across the field while turning to the left: seen from the robot the
    # direction turns to the right, 238 times round.
    headings = np.arange(0.0, 1500.0, 0.1)
    rows = swerve.field_to_robot([1.0, 0.0, 0.0], headings)
    wanted = swerve.module_targets(MODULES, rows, UNTURNED)
    now = UNTURNED
    for speeds, angles in zip(*wanted, strict=True):
        short = swerve.shortest_turn(targets_of(speeds, angles), now)
        assert np.abs(short.angles - now).max() < 0.11 and (short.speeds > 0.0).all()
        now = short.angles
    np.testing.assert_allclose(now, -headings[-1], rtol=0.0, atol=1e-9)


def test_angles_stay_on_the_wanted_line_through_a_wild_drive():
    wanted = swerve.module_targets(MODULES, random_twists(5000), UNTURNED)
    now, before = UNTURNED, 0.0
    for speeds, angles in zip(*wanted, strict=True):
        short = swerve.shortest_turn(targets_of(speeds, angles), now)
        assert np.abs(short.angles - now).max() <= pi / 2 + 1e-12
        off = np.abs(np.sin(short.angles - angles)).max()
        assert off < 1e-12  # forwards or backwards on the very line, at the end as at the start
        now, before = short.angles, max(before, off)
    assert np.abs(now).max() > pi  # the steering did wind up


@given(speeds4, st.floats(1e-6, 10.0))
def test_limit_speeds_keeps_the_path_and_the_limit(speeds, limit):
    targets = targets_of(speeds, UNTURNED)
    slowed = swerve.limit_speeds(targets, limit)
    fastest = np.abs(speeds).max()
    assert np.abs(slowed.speeds).max() <= limit  # to the bit: hardware may clamp what is above
    if fastest <= limit:
        assert np.array_equal(slowed.speeds, speeds)
    else:
        assert np.abs(slowed.speeds).max() == limit
        np.testing.assert_allclose(slowed.speeds * fastest, speeds * limit, rtol=1e-14, atol=1e-300)
    assert np.array_equal(slowed.angles, targets.angles)


def test_limit_speeds_slows_each_command_of_a_batch_on_its_own():
    batch = targets_of([[1.0, 2.0, -4.0, 0.0], [1.0, 1.0, 1.0, 1.0], [0.0] * 4], np.zeros((3, 4)))
    expected = [[0.5, 1.0, -2.0, 0.0], [1.0] * 4, [0.0] * 4]
    assert swerve.limit_speeds(batch, 2.0).speeds.tolist() == expected


def test_limiting_keeps_the_curve_while_cutting_single_wheels_bends_it_and_makes_them_fight():
    twist = np.array([3.0, 0.0, 3.0])
    targets = swerve.module_targets(MODULES, twist, UNTURNED)
    limited = swerve.body_twist(MODULES, *swerve.limit_speeds(targets, 3.2))
    assert limited / limited[0] == pytest.approx(twist / twist[0])
    cut = swerve.body_motion(MODULES, np.minimum(targets.speeds, 3.2), targets.angles)
    assert cut.twist[2] / cut.twist[0] < 0.9 * twist[2] / twist[0] and cut.residual > 0.1


@given(speeds4, turned, turned)
def test_cosine_compensation_never_speeds_up_and_drives_only_along_the_way(speeds, wanted, now):
    targets = targets_of(speeds, wanted)
    found = swerve.cosine_compensation(targets, now)
    assert (np.abs(found.speeds) <= np.abs(speeds)).all()
    # What the wheel, pointing where it does, contributes along the wanted direction: cos² >= 0.
    along = found.speeds * np.cos(now - wanted)
    assert (along * speeds >= 0.0).all() and np.array_equal(found.angles, wanted)


def test_cosine_compensation_by_hand():
    found = swerve.cosine_compensation(
        targets_of([2.0, 2.0, 2.0, 2.0], np.radians([0.0, 60.0, 90.0, 180.0])), UNTURNED
    )
    assert found.speeds == pytest.approx([2.0, 1.0, 0.0, -2.0])


def test_one_row_of_angles_serves_a_whole_batch():
    batch = swerve.module_targets(MODULES, random_twists(7), UNTURNED)
    now = np.array([0.1, 0.2, 3.0, -40.0])
    for step in (swerve.shortest_turn, swerve.cosine_compensation):
        assert np.array_equal(step(batch, now), step(batch, np.tile(now, (7, 1))))


# --- field-centric, discretised, controlled ------------------------------------------------------


@given(twists, st.floats(-50.0, 50.0))
def test_field_to_robot_turns_the_velocity_back_by_the_heading(twist, theta):
    vx, vy, omega = swerve.field_to_robot(twist, theta)
    back = complex(vx, vy) * np.exp(1j * theta)
    assert back == pytest.approx(complex(twist[0], twist[1]), abs=1e-12) and omega == twist[2]


def test_field_to_robot_broadcasts_and_keeps_holes():
    headings = np.linspace(-3.0, 3.0, 7)
    rows = swerve.field_to_robot([1.0, 2.0, 3.0], headings)
    assert rows.shape == (7, 3)
    assert np.array_equal(rows[5], swerve.field_to_robot([1.0, 2.0, 3.0], headings[5]))
    assert swerve.field_to_robot(np.ones((5, 1, 3)), headings).shape == (5, 7, 3)
    assert np.isnan(swerve.field_to_robot([1.0, 2.0, 3.0], nan)[:2]).all()


def held(twist, dt, pieces=20_000):
    """Where a twist held for dt leads, in many small straight steps from the middle of each."""
    x = y = theta = 0.0
    vx, vy, omega = twist
    for _ in range(pieces):
        middle = theta + 0.5 * omega * dt / pieces
        x += (vx * np.cos(middle) - vy * np.sin(middle)) * dt / pieces
        y += (vx * np.sin(middle) + vy * np.cos(middle)) * dt / pieces
        theta += omega * dt / pieces
    return np.array([x, y, theta])


@pytest.mark.parametrize("twist", [(1.0, 0.0, 2.0), (-0.5, 1.5, -8.0), (1.0, 2.0, 0.0)])
def test_a_discretised_twist_ends_where_the_wanted_one_meant(twist):
    dt = 0.25
    ends = held(swerve.discretize(twist, dt), dt)
    np.testing.assert_allclose(
        ends, np.array(twist) * dt, rtol=0.0, atol=1e-8
    )  # h² of 20 000 steps
    if twist[2]:  # the plain one ends a half of the turn to the side
        skew = np.angle(held(twist, dt)[:2] @ [1.0, 1j] / complex(*twist[:2]))
        assert skew == pytest.approx(twist[2] * dt / 2.0)


@given(twists, st.floats(1e-3, 0.5))
def test_discretize_is_the_inverse_of_the_exact_arc(twist, dt):
    pose = geometry.se2_exp(swerve.discretize(twist, dt) * dt)
    np.testing.assert_allclose(pose, twist * dt, rtol=0.0, atol=1e-12)


def test_discretize_works_on_batches_and_leaves_straight_drives_alone():
    rows = random_twists(5)
    rows[2, 2] = 0.0
    found = swerve.discretize(rows, 0.02)
    assert found.shape == (5, 3) and found[2].tolist() == rows[2].tolist()
    assert np.array_equal(found[4], swerve.discretize(rows[4], 0.02))


def test_pose_feedback_leads_to_the_target_and_turns_the_shorter_way():
    found = swerve.pose_feedback([1.0, 2.0, 3.0], [2.0, 0.0, -3.0], 2.0, [0.5, 0.0, 0.0])
    assert found == pytest.approx([2.5, -4.0, 2.0 * (2 * pi - 6.0)])


def test_pose_feedback_broadcasts_one_target_to_many_poses():
    poses = random_twists(6)
    found = swerve.pose_feedback(poses, [1.0, 1.0, 1.0], 0.5)
    assert np.array_equal(found[3], swerve.pose_feedback(poses[3], [1.0, 1.0, 1.0], 0.5))


# --- following -----------------------------------------------------------------------------------


def naive_follow(start, target, gain, dt, steps, feedforward):
    """The source's loop: the pose moves by ξ dt, no modules in between."""
    pose, poses = np.array(start, float), []
    for k in range(steps + 1):
        goal, velocity = target(np.array(k * dt))
        poses.append(pose)
        error = pose - goal
        error[2] = (error[2] + pi) % (2 * pi) - pi
        pose = pose + dt * (velocity * feedforward - gain * error)
    return np.array(poses)


@pytest.mark.parametrize("target", [swerve.circle, swerve.figure_eight])
@pytest.mark.parametrize("feedforward", [True, False])
def test_follow_equals_the_loop_without_modules(target, feedforward):
    def slow(t):
        return target(t, period=7.0)

    run = swerve.follow(
        MODULES, [0.3, -0.2, 1.0], slow, 1.5, dt=0.02, duration=8.0, feedforward=feedforward
    )
    expected = naive_follow([0.3, -0.2, 1.0], slow, 1.5, 0.02, 400, feedforward)
    np.testing.assert_allclose(run.poses, expected, rtol=0.0, atol=1e-9)
    assert np.array_equal(run.targets, slow(run.time).pose)


def test_a_step_that_does_not_divide_the_duration_ends_at_the_nearest_instant():
    run = swerve.follow(MODULES, [0.0, 0.0, 0.0], [3.0, 6.0, 0.0], 0.5, dt=0.3, duration=1.0)
    assert run.time == pytest.approx([0.0, 0.3, 0.6, 0.9])


def test_the_error_to_a_still_target_fades_by_the_same_share_in_every_step():
    run = swerve.follow(MODULES, [0.0, 0.0, 0.0], [3.0, 6.0, pi / 2], 0.5)
    assert len(run.time) == 1201 and run.time[-1] == 12.0
    shares = (1.0 - 0.5 * 0.01) ** np.arange(1201)
    expected = -shares[:, None] * [3.0, 6.0, pi / 2]
    np.testing.assert_allclose(run.errors, expected, rtol=0.0, atol=1e-9)


def test_follow_turns_the_shorter_way_and_stands_still_at_the_target():
    run = swerve.follow(MODULES, [0.0, 0.0, 3.0], [0.1, 0.0, -3.0], 4.0)
    assert run.poses[-1] == pytest.approx([0.1, 0.0, 2 * pi - 3.0], abs=swerve.REST / 4.0 * 1.5)
    assert run.errors[0, 2] == pytest.approx(6.0 - 2 * pi)
    for speeds, angles in zip(run.speeds.T, run.angles.T, strict=True):
        last = np.flatnonzero(speeds)[-1]  # then it keeps its angle
        assert last < 1200 and angles[last] != 0.0 and (angles[last:] == angles[last]).all()


def test_without_feedforward_the_robot_is_late_by_speed_over_gain_and_with_it_hardly():
    period, gain, dt = 12.0, 4.0, 0.01
    rate = 2 * pi / period

    def target(t):
        return swerve.circle(t, period=period)

    late = swerve.follow(MODULES, [2.0, 0.0, pi / 2], target, gain, feedforward=False)
    led = swerve.follow(MODULES, [2.0, 0.0, pi / 2], target, gain)
    settled = late.time > 4.0  # exp(-16)
    # The loop e <- (1 - λ dt) e - (step of the target), for a target that goes round.
    turn = np.exp(1j * rate * dt)
    expected = 2.0 * abs(turn - 1.0) / abs(turn - 1.0 + gain * dt)
    distance = np.hypot(*late.errors[settled, :2].T)
    assert distance == pytest.approx(expected, rel=1e-5)
    assert distance == pytest.approx(2.0 * rate / gain, rel=0.02)  # about v / λ
    assert late.errors[settled, 2] == pytest.approx(-rate / gain, rel=1e-5)
    # A command holds for dt, in which the target's acceleration is not yet known: a dt / (2 λ).
    left = np.hypot(*led.errors[settled, :2].T)
    assert left.max() < 2.0 * rate**2 * dt / (2 * gain) < distance.min() / 300
    assert np.abs(led.errors[settled, 2]).max() < 1e-9


def test_feedforward_follows_twice_as_well_with_half_the_step():
    def target(t):
        return swerve.figure_eight(t, period=12.0)

    start = target(0.0).pose
    worst = []
    for dt in (0.02, 0.01):
        run = swerve.follow(MODULES, start, target, 2.0, dt=dt)
        worst.append(np.hypot(*run.errors[:, :2].T).max())
    assert worst[0] / worst[1] == pytest.approx(2.0, rel=0.02) and worst[1] < 0.003


@pytest.mark.parametrize("target", [swerve.circle, swerve.figure_eight])
@given(t=st.floats(-5.0, 5.0), period=st.floats(0.5, 60.0))
def test_a_targets_twist_is_the_derivative_of_its_pose(target, t, period):
    h = 1e-5 * period
    before, after = (target(t + s * h, period=period).pose for s in (-1, 1))
    twist = target(t, period=period).twist
    # Central difference: h²/6 of a third derivative, which is largest in the eight's tight bends.
    scale = 1.0 + np.abs(twist)
    np.testing.assert_allclose((after - before) / (2 * h) / scale, twist / scale, atol=1e-5)


@pytest.mark.parametrize("target", [swerve.circle, swerve.figure_eight])
def test_a_target_looks_where_it_goes_and_its_heading_never_jumps(target):
    t = np.linspace(-1.0, 3.0, 20_001)
    pose, twist = target(t)
    along = swerve.field_to_robot(twist, pose[:, 2])
    np.testing.assert_allclose(along[:, 1], 0.0, atol=1e-12)
    assert (along[:, 0] > 3.0).all()
    assert np.abs(np.diff(pose[:, 2])).max() < 1.01 * np.abs(twist[:, 2]).max() * (t[1] - t[0])
    turns = (target(1.0).pose - target(0.0).pose)[2] / (2 * pi)
    assert turns == pytest.approx(1.0 if target is swerve.circle else 0.0, abs=1e-12)


@pytest.mark.parametrize("target", [swerve.circle, swerve.figure_eight])
def test_wheels_of_the_robot_can_follow_a_target_with_a_period_of_five_seconds(target):
    t = np.linspace(0.0, 5.0, 5001)
    pose, twist = target(t, period=5.0)
    body = swerve.field_to_robot(twist, pose[:, 2])
    assert 2.5 < swerve.module_targets(MODULES, body, UNTURNED).speeds.max() < 3.2


# --- the whole way, in the simulator -------------------------------------------------------------

SIDES = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)]


def drive_sides(parts, spin, sides=SIDES, *, speed=0.5, dt=0.02):
    """A metre along each side, in the field's axes, turning all the while, then a stop.

    The heading is known, the position is not: what slips or skews adds up. Returns the truth at
    the end, and how far each command asked each module to steer.
    """
    robot = Simulator(sensors=IDEAL, start=(1.0, 1.0, 0.0))
    wanted = np.repeat([[speed * x, speed * y, spin] for x, y in sides], round(1 / speed / dt), 0)
    turns = []
    for twist in [*wanted, *np.zeros((50, 3))]:
        now = robot.read().module_angles
        command = module_command(parts, twist, robot.truth.pose[2], now, dt=dt)
        turns.append(geometry.wrap_angle(command.angles - now))
        robot.apply(command)
        robot.step(dt)
    return robot.truth, np.abs(turns)


@pytest.mark.parametrize("spin", [1.0, -1.0, 2.0, 0.0])
def test_the_robot_drives_a_square_on_the_field_while_it_turns(spin):
    truth, _ = drive_sides(Parts(), spin)
    # 1 % of the way: modules take 0.05 s to steer and to speed up, at each of four corners.
    assert np.hypot(*truth.pose[:2] - 1.0) < 0.04
    assert truth.pose[2] == pytest.approx(8.0 * spin, rel=0.01)
    assert truth.contacts == 0 and np.abs(truth.module_speeds).max() < 1e-6


def test_driven_in_its_own_axes_the_turning_robot_ends_elsewhere():
    own_axes = replace(Parts(), field_to_robot=lambda twist, theta: twist)
    truth, _ = drive_sides(own_axes, 1.0)
    assert np.hypot(*truth.pose[:2] - 1.0) > 0.4


def test_with_the_shortest_turn_no_module_is_asked_for_more_than_a_quarter_turn():
    there_and_back = [(1.0, 0.0), (-1.0, 0.0)]
    _, kind = drive_sides(Parts(), 0.0, there_and_back)
    assert kind.max() < 1e-9  # it drives back as it came
    _, kind = drive_sides(Parts(), 1.0)
    assert 1.0 < kind.max() <= pi / 2 + 1e-12
    rough = replace(Parts(), shortest_turn=lambda targets, angles: targets)
    _, turns = drive_sides(rough, 0.0, there_and_back)
    assert turns.max() == pytest.approx(pi)


def test_the_robot_reaches_a_still_target_and_stands():
    robot, goal = Simulator(sensors=IDEAL, start=(1.0, 1.0, 0.0)), np.array([1.8, 1.6, pi / 2])
    for _ in range(400):
        pose, now = robot.truth.pose, robot.read().module_angles
        wanted = swerve.pose_feedback(pose, goal, 2.0)
        robot.apply(module_command(Parts(), wanted, pose[2], now, dt=0.02))
        robot.step(0.02)
    # exp(-16), and below REST / gain = 0.05 mm no wheel moves any more.
    assert np.abs(robot.truth.pose - goal).max() < 2e-4


# --- beside another house's kinematics -----------------------------------------------------------


def test_inverse_and_forward_equal_wpimath_on_random_twists(wpi):
    kinematics, there, peer = wpi
    rows = random_twists()
    targets = swerve.module_targets(MODULES, rows, UNTURNED)
    rng = np.random.default_rng(5)
    slipping = targets.speeds + rng.normal(0.0, 0.3, targets.speeds.shape)
    motion = swerve.body_motion(MODULES, slipping, targets.angles)
    for k, twist in enumerate(rows):
        states = peer.toSwerveModuleStates(kinematics.ChassisSpeeds(*twist))
        assert [s.speed for s in states] == pytest.approx(targets.speeds[k], abs=1e-9)
        off = [s.angle.radians() for s in states] - targets.angles[k]
        np.testing.assert_allclose(geometry.wrap_angle(off), 0.0, atol=1e-9)
        read = [
            kinematics.SwerveModuleState(speed, there.Rotation2d(angle))
            for speed, angle in zip(slipping[k], targets.angles[k], strict=True)
        ]
        back = peer.toChassisSpeeds(tuple(read))
        assert [back.vx, back.vy, back.omega] == pytest.approx(motion.twist[k], abs=1e-9)


def test_discretize_and_field_to_robot_equal_wpimath(wpi):
    kinematics, there, _ = wpi
    rng = np.random.default_rng(6)
    for twist, theta in zip(random_twists(300), rng.uniform(-9.0, 9.0, 300), strict=True):
        peer = kinematics.ChassisSpeeds.discretize(*twist, 0.05)
        ours = swerve.discretize(twist, 0.05)
        assert [peer.vx, peer.vy, peer.omega] == pytest.approx(ours, abs=1e-9)
        peer = kinematics.ChassisSpeeds.fromFieldRelativeSpeeds(*twist, there.Rotation2d(theta))
        ours = swerve.field_to_robot(twist, theta)
        assert [peer.vx, peer.vy, peer.omega] == pytest.approx(ours, abs=1e-9)


def test_shortest_turn_and_cosine_compensation_equal_wpimath(wpi):
    kinematics, there, _ = wpi
    rng = np.random.default_rng(7)
    for _ in range(300):
        targets = targets_of(rng.uniform(-3, 3, 4), rng.uniform(-9, 9, 4))
        now = rng.uniform(-9, 9, 4)
        short = swerve.shortest_turn(targets, now)
        slowed = swerve.cosine_compensation(targets, now)
        for i in range(4):
            angle = there.Rotation2d(targets.angles[i])
            peer = kinematics.SwerveModuleState(targets.speeds[i], angle)
            peer.cosineScale(there.Rotation2d(now[i]))
            assert peer.speed == pytest.approx(slowed.speeds[i], abs=1e-9)
            peer = kinematics.SwerveModuleState(targets.speeds[i], angle)
            peer.optimize(there.Rotation2d(now[i]))
            assert peer.speed == short.speeds[i]
            off = geometry.wrap_angle(peer.angle.radians() - short.angles[i])
            assert off == pytest.approx(0.0, abs=1e-9)


def test_limit_speeds_equals_wpimath(wpi):
    kinematics, there, peer = wpi
    rows = swerve.module_targets(MODULES, random_twists(300), UNTURNED)
    limited = swerve.limit_speeds(rows, 2.5).speeds
    assert 0.1 < (rows.speeds.max(axis=1) > 2.5).mean() < 0.95  # both kinds are there
    for speeds, ours in zip(rows.speeds, limited, strict=True):
        states = tuple(kinematics.SwerveModuleState(s, there.Rotation2d()) for s in speeds)
        theirs = [state.speed for state in peer.desaturateWheelSpeeds(states, 2.5)]
        assert theirs == pytest.approx(ours, abs=1e-9)


# --- refusals ------------------------------------------------------------------------------------

ONE = targets_of([1.0, 1.0, 1.0, 1.0], UNTURNED)


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: swerve.module_targets(MODULES, [1.0, 2.0], UNTURNED), r"twist: expected shape"),
        (lambda: swerve.module_targets(MODULES, 1.0, UNTURNED), r"twist: expected shape \(3,\)"),
        (lambda: swerve.module_targets(MODULES, [1.0, nan, 0.0], UNTURNED), r"twist: entry \(1,\)"),
        (lambda: swerve.module_targets(MODULES, "fast", UNTURNED), "twist: expected numbers"),
        (
            lambda: swerve.module_targets(MODULES, np.zeros(3), np.zeros(3)),
            r"hold_angles: .*\(4,\)",
        ),
        (lambda: swerve.module_targets(MODULES, np.zeros(3), [0, 0, 0, nan]), "hold_angles: entry"),
        (
            lambda: swerve.module_targets(MODULES, np.zeros((5, 3)), np.zeros((4, 4))),
            r"hold_angles: expected shape \(4,\) or \(5, 4\), got \(4, 4\)",
        ),
        (lambda: swerve.module_targets(MODULES.T, np.zeros(3), UNTURNED), "positions: expected"),
        (
            lambda: swerve.module_targets([[0, nan], [1, 1]], np.zeros(3), [0, 0]),
            "positions: entry",
        ),
        (lambda: swerve.body_motion(MODULES, np.zeros(3), np.zeros(3)), "speeds: expected shape"),
        (
            lambda: swerve.body_twist(MODULES, np.zeros(4), np.zeros((1, 4))),
            "angles: expected shape",
        ),
        (lambda: swerve.find_slip(MODULES[:2], np.ones((5, 2)), np.ones((5, 2))), "three modules"),
        (lambda: swerve.find_slip(MODULES, UNTURNED, UNTURNED), r"speeds: expected shape \(n, 4\)"),
        (lambda: swerve.shortest_turn(ONE, np.zeros(3)), r"angles: expected shape \(4,\)"),
        (
            lambda: swerve.shortest_turn(ONE, np.zeros((2, 4))),
            r"angles: .* or \(4,\), got \(2, 4\)",
        ),
        (lambda: swerve.shortest_turn(ONE, [0, 0, inf, 0]), r"angles: entry \(2,\)"),
        (lambda: swerve.shortest_turn(UNTURNED, UNTURNED), "targets: expected ModuleTargets"),
        (lambda: swerve.shortest_turn(None, UNTURNED), "targets: .* got NoneType"),
        (lambda: swerve.limit_speeds((1.0, 2.0), 1.0), r"targets.speeds: expected shape \(n,\)"),
        (lambda: swerve.limit_speeds((UNTURNED, np.zeros(3)), 1.0), "targets.angles: expected"),
        (lambda: swerve.limit_speeds(([nan] * 4, UNTURNED), 1.0), "targets.speeds: entry"),
        (lambda: swerve.limit_speeds(ONE, 0.0), "max_speed: expected .* above 0, got 0.0"),
        (lambda: swerve.limit_speeds(ONE, nan), "max_speed"),
        (lambda: swerve.cosine_compensation(ONE, [0, 0, nan, 0]), "angles: entry"),
        (lambda: swerve.field_to_robot([1.0, 2.0], 0.0), "twist: expected shape"),
        (lambda: swerve.field_to_robot([1.0, 2.0, 3.0], "north"), "theta: expected numbers"),
        (lambda: swerve.discretize([1.0, 2.0, 3.0], 0.0), "dt: expected seconds above 0"),
        (lambda: swerve.discretize([1.0, 2.0, 3.0], nan), "dt: expected seconds above 0"),
        (lambda: swerve.discretize([1.0, 2.0, 7.0], 1.0), "dt: in 1.0 s .* whole turn; .* shorter"),
        (lambda: swerve.pose_feedback([0, 0, 0], [0, 0], 1.0), "target: expected shape"),
        (lambda: swerve.pose_feedback([0, 0, 0], [0, 0, 0], -1.0), "gain: expected a rate above 0"),
        (lambda: swerve.circle(nan), "t: entry"),
        (lambda: swerve.figure_eight(0.0, period=0.0), "period: expected seconds above 0"),
        (lambda: swerve.follow(MODULES, [0, 0], [0, 0, 0], 1.0), "start: expected shape"),
        (lambda: swerve.follow(MODULES, [0, 0, 0], [0, 0], 1.0), "target: expected shape"),
        (lambda: swerve.follow(MODULES, [0, 0, 0], [0, 0, 0], 200.0), "gain: .* below 2 / dt"),
        (lambda: swerve.follow(MODULES, [0, 0, 0], [0, 0, 0], 1.0, dt=0.0), "dt, duration"),
        (
            lambda: swerve.follow(MODULES, [0, 0, 0], lambda t: (t, t), 1.0),
            r"target.pose: expected shape \(1201, 3\), got \(1201,\)",
        ),
    ],
)
def test_a_wrong_argument_is_refused_with_a_sentence(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()


def test_the_kernels_text_is_plain_python():
    speeds, angles = np.empty((1, 4)), np.empty((1, 4))
    fill_targets.py_func(MODULES, np.array([[1.0, 2.0, 3.0]]), UNTURNED[None], speeds, angles)
    expected = swerve.module_targets(MODULES, [1.0, 2.0, 3.0], UNTURNED)
    np.testing.assert_allclose([speeds[0], angles[0]], expected, rtol=1e-15)
    twist, residual = np.empty((1, 3)), np.empty(1)
    solver = swerve.SwerveDrive(MODULES).solver
    fill_motion.py_func(MODULES, solver, speeds, angles, twist, residual)
    assert twist[0] == pytest.approx([1.0, 2.0, 3.0]) and residual[0] == pytest.approx(0.0)
