"""The autopilot: from a velocity on the field to a command, and a match on any readings."""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import cache
from math import inf, isfinite, nan, pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course import swerve
from robocon_course._arrays import CourseError
from robocon_course.autopilot import Autopilot, Parts, module_command, plays
from robocon_course.geometry import se2_exp
from robocon_course.mission import State
from robocon_course.robot import MODULES, Command, Frame, LidarReading, Observation
from robocon_course.vision import Detections
from robocon_course.worlds.match import Play

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


# --- a whole match's autopilot, whatever is read -----------------------------------------------


@cache
def played(seconds: float) -> Play:
    """A match some time after its start; copy it before going on."""
    play = Play(seed=2) if seconds == 0.0 else copy.deepcopy(played(EARLIER[seconds]))
    if seconds == 0.0:
        play.start()
    while play.match.clock < seconds:
        play.tick()
    return play


EARLIER = {4.0: 0.0, 11.5: 4.0, 16.5: 11.5}
"""On the way to Area 3; at the first ball; on the way to a silo. And what each goes on from."""
JUNK = (nan, inf, -inf, 1e300, -1e300, 0.0, 1e9, -3.7)


def junk(rng, *shape) -> np.ndarray:
    return rng.choice(JUNK, shape)


def junk_lidar(rng) -> tuple[LidarReading, ...]:
    count = int(rng.integers(0, 6))
    return tuple(LidarReading(*junk(rng, 2), float(junk(rng)), 25.0) for _ in range(count))


def junk_frame(rng, seen) -> Frame:
    count = int(rng.integers(0, 5))
    boxes = rng.uniform(-50.0, 400.0, (count, 4)).astype(np.float32)
    boxes[rng.random((count, 4)) < 0.3] = rng.choice([nan, inf, -inf, 1e30])
    found = Detections(boxes, rng.random(count).astype(np.float32), rng.integers(0, 3, count))
    time = float(rng.choice([seen.time, seen.time - 5.0, *JUNK]))
    pan, tilt = (float(rng.choice([0.0, 0.3, *JUNK])) for _ in range(2))
    return Frame(time, pan, tilt, None, {"ball": found, "silo": found})


SPOIL = {
    "time": lambda rng, seen: {"time": float(rng.choice(JUNK))},
    "an older time": lambda rng, seen: {"time": seen.time - rng.uniform(0.0, 20.0)},
    "ticks": lambda rng, seen: {"ticks": junk(rng, 3)},
    "ticks that leap": lambda rng, seen: {"ticks": seen.ticks + rng.integers(-(10**6), 10**6, 3)},
    "gyro": lambda rng, seen: {"gyro": junk(rng, int(rng.integers(0, 4)), 3)},
    "accel": lambda rng, seen: {"accel": junk(rng, 1, 3)},
    "lidar": lambda rng, seen: {"lidar": junk_lidar(rng)},
    "no lidar": lambda rng, seen: {"lidar": ()},
    "modules": lambda rng, seen: {"module_angles": junk(rng, 4), "module_speeds": junk(rng, 4)},
    "battery": lambda rng, seen: {"battery": float(junk(rng))},
    "holding": lambda rng, seen: {"holding": bool(rng.integers(2))},
    "frame": lambda rng, seen: {"frame": junk_frame(rng, seen)},
}


def spoiled(rng, seen: Observation, kinds) -> Observation:
    for kind in kinds:
        seen = seen._replace(**SPOIL[kind](rng, seen))
    return seen


def ticks(play: Play, seconds: float, change=lambda seen: seen) -> list[Command]:
    """A match goes on while the autopilot sees something else."""
    commands = []
    for _ in range(round(seconds * 100)):
        command = play.pilot.tick(change(play.match.read()))
        command.checked()
        assert all(isfinite(x) for x in (command.intake, command.pan, command.tilt))
        play.match.apply(command)
        play.match.step()
        commands.append(command)
    return commands


def drives(commands) -> bool:
    return any(np.abs(command.speeds).max() > 0.05 for command in commands)


@pytest.mark.parametrize("seconds", EARLIER)
@pytest.mark.parametrize("kind", SPOIL)
def test_junk_in_one_sense_raises_nothing_and_with_readings_back_it_goes_on(kind, seconds):
    play, rng = copy.deepcopy(played(seconds)), np.random.default_rng([7, int(seconds)])
    ticks(play, 0.6, lambda seen: spoiled(rng, seen, [kind]) if rng.random() < 0.7 else seen)
    commands = ticks(play, 1.5)
    pilot = play.pilot
    assert np.isfinite(pilot.pose).all() and not pilot.facts.blind
    assert pilot.state is not State.NO_SENSORS
    assert drives(commands) or drives(ticks(play, 2.5))


@pytest.mark.parametrize("seed", range(4))
def test_junk_in_every_sense_at_once_raises_nothing_and_with_readings_back_it_goes_on(seed):
    play, rng = copy.deepcopy(played(11.5)), np.random.default_rng(seed)
    ticks(play, 1.0, lambda seen: spoiled(rng, seen, [k for k in SPOIL if rng.random() < 0.5]))
    assert np.isfinite(play.pilot.pose).all()
    commands = ticks(play, 4.0)
    assert play.pilot.state is not State.NO_SENSORS and drives(commands)


@cache
def first_look() -> Observation:
    return copy.deepcopy(played(11.5)).match.read()


@settings(max_examples=60, deadline=None)
@given(
    time=anything, counters=st.lists(anything, min_size=3, max_size=3), rates=anything,
    distances=st.lists(anything, min_size=4, max_size=4), angles=st.lists(
        anything, min_size=4, max_size=4), box=st.lists(anything, min_size=4, max_size=4),
    watch=st.sampled_from(["ball", "silo"]),
)  # fmt: skip
def test_one_observation_of_any_numbers_is_answered_by_a_command(
    time, counters, rates, distances, angles, box, watch
):
    pilot, seen = copy.deepcopy(played(11.5).pilot), first_look()
    found = Detections(np.array([box]), np.array([0.9], np.float32), np.array([2]))
    with np.errstate(all="ignore"):
        bad = seen._replace(
            time=time, ticks=np.array(counters), gyro=np.full((1, 3), rates),
            lidar=tuple(LidarReading(time, d, 500, 25.0) for d in distances),
            module_angles=np.array(angles), frame=Frame(seen.time, 0.0, 0.3, None, {watch: found}),
        )  # fmt: skip
        pilot.tick(bad).checked()
    for later in range(1, 4):
        pilot.tick(seen._replace(time=seen.time + 0.01 * later)).checked()
    assert np.isfinite(pilot.pose).all()


@pytest.mark.parametrize("shape", [(240, 320, 3), (120, 160, 3), (241, 317, 3), (10, 400, 3)])
def test_a_black_picture_of_any_size_shows_nothing_and_stops_nothing(shape):
    play = copy.deepcopy(played(11.5))
    looked = play.pilot.sight.frames

    def black(seen):
        return seen._replace(frame=Frame(seen.time, 0.0, 0.3, np.zeros(shape, np.uint8)))

    ticks(play, 0.03, black)
    assert play.pilot.sight.frames > looked
    assert len(play.pilot.sight.found[1].scores) == 0


def test_a_frozen_observation_makes_it_stand_and_it_comes_back():
    play = copy.deepcopy(played(4.0))
    frozen = play.match.read()
    commands = ticks(play, 0.6, lambda seen: frozen)
    assert play.pilot.state is State.NO_SENSORS and play.pilot.facts.blind
    assert drives(commands[:5]) and not drives(commands[-5:])
    assert any(level == "error" for _, level, _ in play.pilot.speaks)
    commands = ticks(play, 1.5)
    assert play.pilot.state is State.GO_TO_AREA_3 and drives(commands)


@pytest.mark.parametrize("leap", [1e9, -3.0, 1000.0])
def test_a_clock_that_goes_on_elsewhere_neither_ends_the_match_nor_stops_it(leap):
    play = copy.deepcopy(played(11.5))
    begun, before = play.pilot.now, play.match.clock

    def later(seen):
        frame = seen.frame and seen.frame._replace(time=seen.frame.time + leap)
        lidar = tuple(r._replace(time=r.time + leap) for r in seen.lidar)
        return seen._replace(time=seen.time + leap, lidar=lidar, frame=frame)

    commands = ticks(play, 4.0, later)
    pilot = play.pilot
    assert pilot.state not in (State.FINISHED, State.NO_SENSORS) and drives(commands[100:])
    # A few readings pass before the new clock is believed.
    assert pilot.now - begun == pytest.approx(play.match.clock - before, abs=0.3)
    assert pilot.sight.last > begun and pilot.walls.used > 0
    ticks(play, 1.0)  # and back
    assert pilot.state not in (State.FINISHED, State.NO_SENSORS)


def test_a_lidar_that_told_a_time_to_come_is_heard_again():
    play = copy.deepcopy(played(11.5))
    late = [tuple(r._replace(time=1e6) for r in play.match.read().lidar)]
    ticks(play, 0.05, lambda seen: seen._replace(lidar=late[0]))
    used = play.pilot.walls.used
    ticks(play, 1.0)
    assert play.pilot.walls.used > used + 50


def test_a_picture_from_a_time_that_nobody_remembers_is_not_placed():
    play = copy.deepcopy(played(11.5))
    found = Detections(np.array([[100.0, 100, 150, 150]]), np.array([0.9]), np.array([2]))
    looked = play.pilot.sight.frames
    ticks(
        play, 0.05, lambda s: s._replace(frame=Frame(s.time - 3, 0.0, 0.3, None, {"ball": found}))
    )
    assert play.pilot.sight.frames == looked


def test_stop_stands_still_until_start():
    play = copy.deepcopy(played(4.0))
    play.pilot.stop()
    assert play.pilot.state is State.RESET and not drives(ticks(play, 0.5))
    play.pilot.start(after=0.3)
    assert not drives(ticks(play, 0.25)) and drives(ticks(play, 0.6))


def test_put_down_elsewhere_it_waits_and_begins_again_from_there():
    play = copy.deepcopy(played(11.5))
    home = (0.5, 5.5, 0.0)
    play.match.robot.place(home)
    play.pilot.restart(home, after=0.5)
    assert play.pilot.state is State.RESET and play.pilot.pose == pytest.approx(home)
    assert not drives(ticks(play, 0.45))
    assert drives(ticks(play, 1.0)) and play.pilot.state is State.GO_TO_AREA_3
    truth, _ = play.match.robot.motion
    assert np.hypot(*(play.pilot.pose - truth)[:2]) < 0.02


def test_when_the_match_is_over_it_stands_and_stays_finished():
    play = copy.deepcopy(played(4.0))
    play.pilot._ends = play.pilot.now + 0.1
    assert not drives(ticks(play, 0.5)[30:]) and play.pilot.state is State.FINISHED
    assert not drives(ticks(play, 0.3)) and play.pilot.state is State.FINISHED


def test_while_all_silos_are_full_no_order_is_asked_for_one():
    asked = []

    def choose_silo(silos, team, y, rhythm):
        asked.append(list(silos))
        return 2

    pilot = Autopilot(replace(Parts(), choose_silo=choose_silo))
    pilot.sight.silos = ["RRB"] * 5
    plays._choose(pilot)
    assert not asked and "silo" not in pilot.notes
    pilot.sight.silos[2] = "RR"
    plays._choose(pilot)
    assert len(asked) == 1 and pilot.notes["silo"] == 2


def test_another_team_and_a_start_that_is_no_pose_are_refused():
    with pytest.raises(CourseError, match="team: expected 'red' or 'blue', got 'green'"):
        Autopilot(team="green")
    with pytest.raises(ValueError, match="pose: expected shape"):
        Autopilot(start=(0.5, 0.3))
    with pytest.raises(ValueError, match="offsets: expected shape"):
        Autopilot(offsets=(0.0,) * 3)
    with pytest.raises(ValueError, match=r"observation\.ticks: expected shape"):
        seen = copy.deepcopy(played(0.0)).match.read()
        Autopilot().tick(seen._replace(ticks=np.zeros(2)))


def test_the_log_keeps_its_last_lines_and_counts_all():
    pilot = Autopilot()
    for k in range(500):
        pilot._say("info", str(k))
    assert pilot.spoken == 500 and len(pilot.speaks) == 400 and pilot.speaks[-1][2] == "499"
