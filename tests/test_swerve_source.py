"""Chapter 03 beside its two printed sources: what holds after renaming, and what does not.

Thesis: swerve robot of Yogyakarta State University, 2024: derivation, and a listing that drives.
Paper: I. Siradjuddin, S. Wibowo, A. Rofiq, Politeknik Negeri Malang, 2022, equations 13 to 37.

=========  ===========================================  ======================================
..         module order and axes                        ours
=========  ===========================================  ======================================
thesis     derivation: wheels 1 to 4 at any (rx, ry)    the same, in the order of the positions
..         listing: front left, front right, rear left,
           rear right; strafe to the right and turn
           clockwise positive; degrees                  order [0, 2, 3, 1], two signs, radians
paper      front left, rear left, rear right, front
           right; body a long and b wide                the same order as `MODULES`
=========  ===========================================  ======================================
"""

from __future__ import annotations

from math import atan, atan2, cos, degrees, hypot, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course import swerve
from robocon_course.geometry import wrap_angle
from robocon_course.robot import MODULES

UNTURNED = np.zeros(4)
CORNERS = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])  # in our order
FROM_LISTING = [0, 2, 3, 1]  # front left, rear left, rear right, front right, out of the listing's
GOAL = np.array([3.0, 6.0, pi / 2])
speeds = st.floats(-1.0, 1.0)
compiled = settings(deadline=None)  # the first call compiles


# --- thesis: the derivation ----------------------------------------------------------------------


def test_the_thesis_matrix_and_its_pseudo_inverse_are_ours():
    drive = swerve.SwerveDrive(MODULES)
    x, y = MODULES.T
    one, none = np.ones(4), np.zeros(4)
    printed = np.vstack([np.column_stack([one, none, -y]), np.column_stack([none, one, x])])
    assert np.array_equal(drive.matrix, printed)
    # Its second form takes x and y of each wheel in turn: the same rows in another order.
    interleaved = printed[[0, 4, 1, 5, 2, 6, 3, 7]]
    forward = np.linalg.pinv(interleaved)
    assert forward[:, [0, 2, 4, 6, 1, 3, 5, 7]] == pytest.approx(drive.solver)


# --- thesis: the listing -------------------------------------------------------------------------


class Listing:
    """What the listing does with four modules, in its order and units."""

    def __init__(self, angles):
        self.speeds, self.angles = [0.0] * 4, list(angles)  # [share], [deg]

    def move(self, speed, heading, forward, strafe, rotation):
        if forward == strafe == rotation == 0.0:
            front_left, front_right, rear_left, rear_right = self.angles
            self.angles = [front_left, rear_left, front_right, rear_right]
            return
        vx, vy, turn = forward, -strafe, -rotation
        c, s = cos(radians(heading)), sin(radians(heading))
        ahead, left = vx * c + vy * s, -vx * s + vy * c
        places = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        wheels = [(ahead - turn * y, left + turn * x) for x, y in places]
        sizes = [hypot(a, b) for a, b in wheels]
        slow = max(1.0, *sizes)
        self.speeds = [size / slow * speed for size in sizes]
        self.angles = [degrees(atan2(b, a)) for a, b in wheels]


@compiled
@given(speeds, speeds, speeds, st.floats(-360.0, 360.0))
def test_a_moving_listing_gives_our_modules_after_renaming(forward, strafe, rotation, heading):
    listing = Listing(UNTURNED)
    listing.move(2.5, heading, forward, strafe, rotation)
    twist = swerve.field_to_robot([forward, -strafe, -rotation], radians(heading))
    ours = swerve.limit_speeds(swerve.module_targets(CORNERS, twist, UNTURNED), 1.0)
    theirs = np.array([listing.speeds, np.radians(listing.angles)])[:, FROM_LISTING]
    assert theirs[0] / 2.5 == pytest.approx(ours.speeds, abs=swerve.REST)
    moving = ours.speeds > 0.0
    off = wrap_angle(theirs[1] - ours.angles)[moving]
    # Near REST a rounding of 1e-16 turns the wheel by 1e-12.
    assert np.abs(off).max(initial=0.0) < 1e-9


def test_at_zero_command_the_listing_leaves_the_wheels_running_and_ours_stop():
    listing = Listing(UNTURNED)
    listing.move(2.0, 0.0, 1.0, 0.0, 0.0)
    listing.move(2.0, 0.0, 0.0, 0.0, 0.0)
    assert listing.speeds == [2.0] * 4
    assert not swerve.module_targets(CORNERS, np.zeros(3), UNTURNED).speeds.any()


def test_at_zero_command_the_listing_swaps_two_held_angles_and_ours_keep_theirs():
    turn_on_the_spot = swerve.module_targets(CORNERS, [0.0, 0.0, 1.0], UNTURNED).angles
    listing = Listing([])
    listing.move(1.0, 0.0, 0.0, 0.0, -1.0)  # to the left
    before = np.radians(listing.angles)[FROM_LISTING]
    assert before == pytest.approx(turn_on_the_spot)
    listing.move(1.0, 0.0, 0.0, 0.0, 0.0)
    after = np.radians(listing.angles)[FROM_LISTING]
    turned = np.degrees(wrap_angle(after - before))
    # Rear left and front right steer half a turn while the robot should stand still.
    assert np.abs(turned) == pytest.approx([0.0, 180.0, 0.0, 180.0])
    ours = swerve.module_targets(CORNERS, np.zeros(3), turn_on_the_spot)
    assert np.array_equal(ours.angles, turn_on_the_spot)


def test_the_listing_never_takes_the_shorter_turn_and_ours_does():
    listing = Listing(UNTURNED)
    listing.move(1.0, 0.0, 1.0, 0.0, 0.0)
    ahead = list(listing.angles)
    listing.move(1.0, 0.0, -1.0, 0.0, 0.0)
    assert np.abs(np.subtract(listing.angles, ahead)) == pytest.approx([180.0] * 4)
    back = swerve.module_targets(CORNERS, [-1.0, 0.0, 0.0], UNTURNED)
    ours = swerve.shortest_turn(back, np.radians(ahead))
    assert not ours.angles.any() and ours.speeds.tolist() == [-1.0] * 4


def test_a_stick_that_does_not_rest_at_exactly_zero_turns_the_listings_wheels_and_not_ours():
    listing = Listing([90.0] * 4)
    listing.move(1.0, 0.0, 1e-6, 0.0, 0.0)
    assert listing.angles == pytest.approx([0.0] * 4)
    held = np.full(4, pi / 2)
    assert np.array_equal(swerve.module_targets(CORNERS, [1e-6, 0.0, 0.0], held).angles, held)


# --- paper: inverse kinematics -------------------------------------------------------------------


@given(st.floats(0.1, 2.0), st.floats(0.1, 2.0))
def test_equation_20_is_our_matrix_for_its_four_wheels(a, b):
    printed = np.array(
        [
            [[1, 0, -b / 2], [0, 1, a / 2]],
            [[1, 0, -b / 2], [0, 1, -a / 2]],
            [[1, 0, b / 2], [0, 1, -a / 2]],
            [[1, 0, b / 2], [0, 1, a / 2]],
        ]
    )
    wheels = np.array([[a, b], [-a, b], [-a, -b], [a, -b]]) / 2
    ours = swerve.SwerveDrive(wheels).matrix
    np.testing.assert_allclose(np.concatenate([printed[:, 0], printed[:, 1]]), ours, atol=1e-15)
    assert (np.sign(wheels) == np.sign(MODULES)).all()  # the same order


def test_equation_17_turns_a_map_velocity_into_the_body_and_15_and_18_turn_it_away():
    theta, velocity = radians(30.0), np.array([1.0, 0.5])
    c, s = cos(theta), sin(theta)
    ours = swerve.field_to_robot([*velocity, 0.0], theta)[:2]
    assert np.array([[c, s], [-s, c]]) @ velocity == pytest.approx(ours)
    printed = np.array([[c, -s], [s, c]]) @ velocity
    angle = np.angle((printed @ [1.0, 1j]) / (ours @ [1.0, 1j]))
    assert degrees(angle) == pytest.approx(60.0)  # wrong by twice the heading


def test_equation_21_with_a_plain_arctangent_drives_backwards_forwards():
    back = swerve.module_targets(MODULES, [-1.0, -0.2, 0.0], UNTURNED)
    printed = atan(-0.2 / -1.0)
    assert degrees(back.angles[0] - printed) == pytest.approx(-180.0)
    driven = swerve.body_twist(MODULES, back.speeds, np.full(4, printed))
    assert driven == pytest.approx([1.0, 0.2, 0.0])  # asked for: -1, -0.2


@compiled
@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(-9.0, 9.0))
def test_equations_16_to_22_give_our_modules(vx, vy, omega, theta):
    ours = swerve.module_targets(MODULES, swerve.field_to_robot([vx, vy, omega], theta), UNTURNED)
    c, s = cos(theta), sin(theta)
    for i, (x, y) in enumerate(MODULES):
        a = c * vx + s * vy - y * omega
        b = -s * vx + c * vy + x * omega
        assert ours.speeds[i] == pytest.approx(hypot(a, b), abs=swerve.REST)
        if ours.speeds[i]:
            assert wrap_angle(atan2(b, a) - ours.angles[i]) == pytest.approx(0.0, abs=1e-9)


# --- paper: the still target ---------------------------------------------------------------------


def still_run(gain):
    return swerve.follow(MODULES, [0.0, 0.0, 0.0], GOAL, gain, dt=0.01, duration=12.0)


def test_the_still_target_is_reached_in_twelve_seconds_on_a_straight_path():
    run = still_run(0.5)  # no gain is printed: 0.5/s is what twelve seconds ask for
    assert len(run.time) == 1201 and run.time[-1] == 12.0
    assert np.abs(run.poses[:, 1] - 2.0 * run.poses[:, 0]).max() < 1e-9
    share = np.abs(run.errors[-1] / GOAL)
    assert share == pytest.approx([(1 - 0.005) ** 1200] * 3, rel=1e-6)  # 0.24 %: 0 in a plot
    assert np.abs(still_run(0.25).errors[-1] / GOAL).min() > 0.04  # and this would show
    # "Fast when far, slow when near": all four wheels slow down from first to last.
    assert (np.diff(run.speeds, axis=0) < 0.0).all()


def test_wheel_speeds_of_the_still_run_start_at_gain_times_distance():
    run = still_run(0.5)
    body = np.array([1.5, 3.0, pi / 4])
    expected = swerve.module_targets(MODULES, swerve.discretize(body, 0.01), UNTURNED)
    np.testing.assert_allclose(run.speeds[0], expected.speeds, rtol=1e-12)
    assert run.speeds[0].round(2).tolist() == [3.44, 3.11, 3.28, 3.6]
    assert np.degrees(run.angles[0]).round(1).tolist() == [67.3, 64.7, 58.9, 61.9]


def test_equation_28_without_the_rotation_does_not_reach_the_target():
    poses = [np.array([0.0, 0.0, pi / 2])]
    goal = np.array([3.0, 0.0, pi / 2])
    for _ in range(1200):  # the error in map axes, handed to the modules as if it were the body's
        x, y, theta = poses[-1]
        twist = 0.5 * (goal - poses[-1])
        c, s = cos(theta), sin(theta)
        step = [c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[2]]
        poses.append(np.array([x, y, theta]) + 0.01 * np.array(step))
    distance = np.hypot(*(np.array(poses) - goal)[:, :2].T)
    assert distance.min() == pytest.approx(3.0) and distance[-1] > 2.99  # a circle round the goal
    ours = swerve.follow(MODULES, poses[0], goal, 0.5)
    assert np.hypot(*ours.errors[-1, :2]) < 0.01


# --- paper: the moving targets -------------------------------------------------------------------

T = np.linspace(0.0, 1.0, 400, endpoint=False)
W = 2 * pi


def derivative(values):
    """Of a periodic function sampled at T, exact for these few harmonics."""
    return np.fft.ifft(2j * pi * np.fft.fftfreq(len(T), T[1]) * np.fft.fft(values)).real


PRINTED = {  # symbol: place, its printed derivatives, and how often to derive
    "circle x'": (2 * np.cos(W * T), -4 * pi * np.sin(W * T), 1, True),
    "eight x'": (0.7 * np.sin(W * T), 1.4 * pi * np.cos(W * T), 1, True),
    "circle y'": (2 * np.sin(W * T), 2 * np.cos(W * T), 1, False),
    "eight y'": (0.7 * np.sin(2 * W * T), 2.8 * np.cos(2 * W * T), 1, False),
    "circle x''": (2 * np.cos(W * T), -8 * pi * np.cos(W * T), 2, False),
    "eight x''": (0.7 * np.sin(W * T), -2.8 * pi * np.sin(W * T), 2, False),
    "circle y''": (2 * np.sin(W * T), -8 * np.sin(W * T), 2, False),
    "eight y''": (0.7 * np.sin(2 * W * T), -4.6 * np.sin(2 * W * T), 2, False),
}
MENDED = {
    "circle y'": 4 * pi * np.cos(W * T),
    "eight y'": 2.8 * pi * np.cos(2 * W * T),
    "circle x''": -8 * pi**2 * np.cos(W * T),
    "eight x''": -2.8 * pi**2 * np.sin(W * T),
    "circle y''": -8 * pi**2 * np.sin(W * T),
    "eight y''": -11.2 * pi**2 * np.sin(2 * W * T),
}


@pytest.mark.parametrize("name", PRINTED)
def test_of_the_derivatives_34_to_37_two_hold_and_six_lack_factors_of_pi(name):
    place, printed, times, holds = PRINTED[name]
    true = derivative(place) if times == 1 else derivative(derivative(place))
    assert np.allclose(printed, true, atol=1e-9) == holds
    if not holds:
        np.testing.assert_allclose(MENDED[name], true, atol=1e-9)
        assert np.abs(printed).max() < 0.33 * np.abs(true).max()


def test_equations_32_and_33_are_our_targets_with_a_period_of_one_second():
    for target, x, y in (
        (swerve.circle, 2 * np.cos(W * T), 2 * np.sin(W * T)),
        (swerve.figure_eight, 1.2 + 0.7 * np.sin(W * T), 0.9 + 0.7 * np.sin(2 * W * T)),
    ):
        pose, twist = target(T)
        np.testing.assert_allclose(pose[:, 0], x, atol=1e-12)
        np.testing.assert_allclose(pose[:, 1], y, atol=1e-12)
        np.testing.assert_allclose(twist[:, 0], derivative(x), atol=1e-9)
        np.testing.assert_allclose(twist[:, 1], derivative(y), atol=1e-9)


def test_equation_29_is_no_heading_and_31_no_turning_rate():
    dx, dy = 1.4 * pi * np.cos(W * T), MENDED["eight y'"]
    ddx, ddy = MENDED["eight x''"], MENDED["eight y''"]
    pose, twist = swerve.figure_eight(T)
    heading = np.arctan2(dy, dx)
    np.testing.assert_allclose(wrap_angle(pose[:, 2] - heading), 0.0, atol=1e-9)
    printed = np.arctan(dx + dy)
    assert np.abs(wrap_angle(printed - heading)).max() > radians(150.0)
    rate = (dx * ddy - dy * ddx) / (dx**2 + dy**2)
    np.testing.assert_allclose(twist[:, 2], rate, rtol=1e-9)
    # The print divides by x' + y', which is 0 four times in a round of the eight.
    without_squares = (dx * ddy - dy * ddx) / (dx + dy)
    assert np.median(np.abs(without_squares - rate)) > 2.0 * np.median(np.abs(rate))


def test_the_printed_time_scale_is_one_round_a_second_which_no_wheel_drives():
    circle, eight = swerve.circle(T).twist, swerve.figure_eight(T).twist
    assert np.hypot(*circle[:, :2].T) == pytest.approx(4 * pi)  # 12.6 m/s
    assert np.hypot(*eight[:, :2].T).max() == pytest.approx(9.83, abs=0.01)


def test_the_printed_bends_are_a_quarter_period_apart_and_mostly_after_the_end():
    bends = np.array([8.0, 20.0, 31.0, 43.0])
    assert (bends > 12.0).sum() == 3  # of a run said to last 12 s
    spacing = np.polyfit(range(4), bends, 1)[0]
    assert np.abs(bends - np.polyval(np.polyfit(range(4), bends, 1), range(4))).max() < 0.5
    period = 4 * spacing
    assert period == pytest.approx(46.4)
    t = np.linspace(0.0, period, 4001)
    rate = np.abs(swerve.figure_eight(t, period=period).twist[:, 2])
    tight = t[1:-1][(rate[1:-1] > rate[:-2]) & (rate[1:-1] > rate[2:]) & (rate[1:-1] > 0.5)]
    assert np.diff(tight) == pytest.approx([spacing] * 3, abs=1.0)  # four in a round, as printed


@pytest.mark.parametrize("gain", [1.0, 4.0])
@pytest.mark.parametrize("target", [swerve.circle, swerve.figure_eight])
def test_the_papers_law_lags_behind_a_moving_target_and_feedforward_does_not(target, gain):
    def slow(t):
        return target(t, period=12.0)

    start = slow(0.0).pose
    late = swerve.follow(MODULES, start, slow, gain, dt=0.02, duration=24.0, feedforward=False)
    led = swerve.follow(MODULES, start, slow, gain, dt=0.02, duration=24.0)
    second_round = late.time >= 12.0
    lag = np.hypot(*late.errors[second_round, :2].T).mean()
    speed = np.hypot(*slow(late.time[second_round]).twist[:, :2].T).mean()
    # speed / λ, somewhat less where the target's own turns are as fast as the loop.
    assert 0.6 * speed / gain < lag < 1.01 * speed / gain
    assert np.hypot(*led.errors[:, :2].T).max() < 0.012
