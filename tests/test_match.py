"""Whole matches: the gripper's and the crew's rules, faults, what is told, and campaigns.

The suite plays a few matches; the campaign many (``-m campaign``), by benchmarks/match.py.
"""

from __future__ import annotations

import re
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache
from math import hypot, pi
from multiprocessing import get_context

import numpy as np
import pytest

from conftest import benchmark, solved_parts
from robocon_course import field
from robocon_course._arrays import CourseError
from robocon_course.autopilot import Parts
from robocon_course.mission import State, order_b
from robocon_course.robot import SIDE, Bus, Command, messages
from robocon_course.robot.messages import Button, Twist
from robocon_course.simulator import balls as rolling
from robocon_course.simulator.balls import FREE, HELD, OUT, Balls
from robocon_course.simulator.match import (
    ARM,
    FRAMES,
    HAPPENS,
    KINDS,
    LATENCY,
    RETRY_POSE,
    SERVO,
    START,
    Fault,
    Match,
)
from robocon_course.simulator.others import Others
from robocon_course.simulator.referee import OPPONENTS, Referee, plan
from robocon_course.worlds import MatchResult, Play, play_match, season
from robocon_course.worlds.by_hand import ByHand
from robocon_course.worlds.season import EVERY

STAND = Command.stop()
SAMPLE = (1, 2)
"""Seeds of whole matches that the suite plays."""
TOPICS = set(re.findall(r"^``(/[a-z_/]+)``", messages.__doc__, re.MULTILINE))


@cache
def whole_match(seed: int) -> MatchResult:
    return play_match(seed=seed)


def begun(seed=3, **settings) -> Match:
    """A match whose clock runs, and which nobody plays."""
    match = Match(seed, opponent=None, **settings)
    match.robot.step(0.5)
    match.start()
    return match


def let_pass(match: Match, seconds: float, command: Command = STAND) -> None:
    for _ in range(round(seconds * 100)):
        match.apply(command)
        match.step()


def whats(match: Match) -> list[str]:
    return [event.what for event in match.referee.events]


# --- one whole match ---------------------------------------------------------------------------


def test_the_robot_wins_a_match_against_a_weak_team():
    result = whole_match(1)
    assert result.winner == "own" and result.points > result.their_points
    assert result.stored >= 6 and result.contacts == 0
    assert result.error < 0.05 and result.reset_errors.mean() < 0.01
    assert result.history[0][1] == State.GO_TO_AREA_3 and result.states[-1] in set(State)


def test_no_state_of_it_lasts_longer_than_its_limit():
    assert benchmark("match").overdue(whole_match(1)) == []


def test_overdue_tells_a_state_that_did():
    slow = ((0.0, "go_to_area_3", "start"), (55.0, "lidar_reset", "arrived"))
    told = benchmark("match").overdue(replace(whole_match(1), history=slow, ended=56.0))
    assert told == ["seed 1: go_to_area_3 from 0.00 s to 55.00 s"]


def test_its_numbers_fit_each_other():
    result = whole_match(1)
    stored = sum(filling.count("R") for filling in result.fillings)
    assert stored == result.stored
    events = [event.what for event in result.events if event.team == "own"]
    scored = 30 * stored + 10 * (events.count("transfer") + events.count("seedling"))
    assert result.points == scored
    off = np.hypot(*(result.poses - result.estimates)[:, :2].T)
    assert np.sqrt((off**2).mean()) == pytest.approx(result.error, rel=0.2)
    assert len(result.time) == len(result.states) == len(result.poses)
    assert any("mm RMS" in line for line in result.lines) and result.lines[0].startswith("✔ won")


def test_played_again_beside_a_broken_listener_it_is_the_same_to_the_bit():
    bus = Bus()

    def broken(topic, message):
        raise RuntimeError("no screen")

    bus.subscribe("/odom", broken)
    play, poses = Play(seed=1, bus=bus), []
    play.start()
    for tick in range(3000):
        pose, _ = play.match.robot.motion
        play.tick()
        if (tick + 1) % EVERY == 0:
            poses.append((*pose, *play.pilot.pose))
    first = whole_match(1)
    known = np.column_stack([first.poses, first.estimates])[: len(poses)]
    assert np.array(poses).tobytes() == np.ascontiguousarray(known).tobytes()
    assert [topic for topic, _ in bus.failed] == ["/odom"]  # and is not asked again


@cache
def on_two_processes() -> tuple[list[MatchResult], list[int]]:
    heard: list[int] = []
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        results = season(SAMPLE, run=pool.map, on_match=lambda one: heard.append(one.seed))
    return results, heard


def test_a_season_on_two_processes_is_in_order_and_the_same_as_here():
    results, heard = on_two_processes()
    assert heard == [one.seed for one in results] == list(SAMPLE)
    there, here = results[0], whole_match(SAMPLE[0])
    assert there.history == here.history and there.events == here.events
    assert there.poses.tobytes() == here.poses.tobytes()
    assert results[1].history != here.history


def test_in_one_process_a_season_is_a_row_of_matches(monkeypatch):
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 0.5)
    results = season([4, 2], opponent=None)
    assert [one.seed for one in results] == [4, 2]
    assert all(one.winner == "nobody" and one.ended == 0.5 for one in results)


# --- clock and points --------------------------------------------------------------------------


def test_a_match_that_nobody_plays_ends_after_three_minutes_without_a_winner():
    match = begun()
    match.robot.place((0.6, 5.5, 0.0))
    while not match.over:
        match.step()
    referee = match.referee
    assert (referee.winner, referee.reason, referee.ended) == ("nobody", "points", 180.0)
    assert match.clock == pytest.approx(180.0)
    assert referee.count("seedling") == referee.count("transfer") == 12
    assert referee.points == {"own": 240, "theirs": 240}
    fed = match.balls.colours[16:]
    assert fed == ["red", "purple"] * 6  # Robot 1 sends own and empty ones in turns
    assert match.balls.xy[match.balls.free, 1].min() > 8.0


@pytest.mark.parametrize(("sent", "balls", "points"), [(0, 0, 120), (5, 5, 170), (15, 15, 240)])
def test_a_measurement_may_have_other_balls_and_those_beyond_the_rules_are_worth_nothing(
    sent, balls, points
):
    others, referee = Others("red", None, {"feed": np.random.default_rng(1)}, sent), Referee("R")
    floor = Balls(np.empty((0, 2)), [])
    for tick in range(18_000):
        others.act(0.01 * tick, referee, floor)
    assert len(floor.xy) == balls and referee.points == {"own": points, "theirs": points}


@pytest.mark.parametrize("sent", [-1, 2.5, "12", None])
def test_a_number_of_balls_that_is_none_is_refused(sent):
    with pytest.raises(CourseError, match="sent: expected a whole number, 0 or more"):
        Match(0, sent=sent)


def test_no_more_balls_are_sent_than_seedlings_were_planted(monkeypatch):
    monkeypatch.setattr("robocon_course.simulator.others.FEED", (1.0, 1.0))
    match = begun()
    match.robot.place((0.6, 5.5, 0.0))
    for _ in range(2200):
        match.step()
        assert match.referee.count("transfer") <= match.referee.count("seedling")
    assert match.referee.count("transfer") == 4


def others(opponent: str | None = None) -> Others:
    rng = {name: np.random.default_rng(k) for k, name in enumerate(("opponent", "feed"))}
    return Others("red", opponent, rng)


def test_what_robot_1_does_after_a_win_at_once_does_not_count():
    referee, balls = Referee("R"), Balls(np.empty((0, 2)), [])
    for silo in (0, 1, 2):
        for _ in range(3):
            referee.store(12.0, "own", silo)
    points, count = dict(referee.points), len(referee.events)
    others("strong").act(12.0, referee, balls)
    assert referee.points == points and len(referee.events) == count and not len(balls.xy)


def test_the_other_team_fills_silos_by_order_b_and_misses_some():
    referee, balls, team = Referee("R"), Balls(np.empty((0, 2)), []), others("weak")
    expected, y = Referee("R"), field.SILO_POST[1]
    for at, falls_in in plan(np.random.default_rng(0), OPPONENTS["weak"]):
        silo = order_b(expected.fillings, "blue", y)
        y = field.SILOS[silo][1]
        if falls_in:
            expected.store(at, "theirs", silo)
    for now in np.arange(0.0, 180.0, 0.01):
        team.act(float(now), referee, balls)
    assert referee.fillings == expected.fillings and not expected.winner
    planned = len(plan(np.random.default_rng(0), OPPONENTS["weak"]))
    missed = planned - referee.count("stored", "theirs")
    assert 0 < missed == referee.count("lost ball", "theirs")


def test_before_the_start_no_clock_runs_and_nothing_counts():
    match = Match(1)
    let_pass(match, 1.0)
    assert match.clock == 0.0 and match.started is None and not match.referee.events


@pytest.mark.parametrize("team", ["red", "blue"])
def test_the_pile_holds_six_own_balls_and_ten_empty_ones_in_seeded_order(team):
    piles = [Match(seed, team=team).balls.colours for seed in (1, 1, 2)]
    assert sorted(piles[0]) == sorted(["purple"] * 10 + [team] * 6)
    assert piles[0] == piles[1] != piles[2]


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"team": "green"}, "team: expected one of red, blue, got 'green'"),
        ({"opponent": "mean"}, "opponent: expected one of None, weak, .*, got 'mean'"),
        ({"faults": [Fault("rain", 3.0)]}, "faults: expected one of dark, lidar, .*, got 'rain'"),
        ({"seed": -1}, "seed: expected a whole number, 0 or more, got -1"),
        ({"seed": 1.5}, "seed: expected a whole number, 0 or more, got 1.5"),
    ],
)  # fmt: skip
def test_another_team_opponent_fault_or_seed_is_refused(settings, sentence):
    with pytest.raises(CourseError, match=sentence):
        Match(**{"seed": 1} | settings)


# --- gripper -----------------------------------------------------------------------------------


def at_a_ball(colour: str, **settings) -> Match:
    """The robot stands before a ball, in the Storage Zone."""
    match = begun(**settings)
    match.balls.place[:] = OUT
    match.robot.place((2.0, 10.0, pi))
    match.balls.add((2.0 - SIDE / 2 - rolling.RADIUS - 0.005, 10.0), (0.0, 0.0), colour)
    return match


PULLS = Command(np.zeros(4), np.zeros(4), intake=1.0)


def test_rollers_that_turn_take_an_own_ball_after_a_quarter_of_a_second():
    match = at_a_ball("red")
    let_pass(match, 0.2, PULLS)
    assert not match.read().holding
    let_pass(match, 0.1, PULLS)
    assert match.read().holding and whats(match) == ["taken"]


def test_rollers_that_stand_take_nothing():
    match = at_a_ball("red")
    let_pass(match, 1.0)
    assert not match.read().holding and whats(match) == []


@pytest.mark.parametrize("colour", ["purple", "blue"])
def test_another_ball_is_a_foul_and_the_crew_carries_the_robot_away(colour):
    match = at_a_ball(colour)
    match._area_2 = True
    let_pass(match, 0.3, PULLS)
    assert whats(match)[:2] == ["foul", "retry"] and match.referee.events[0].detail.endswith(
        f"{colour} ball"
    )
    pose, _ = match.robot.motion
    assert np.abs(pose - RETRY_POSE).max() < 0.01 and match.retries == 1
    assert match.balls.place[-1] == OUT and not match.read().holding


def test_a_second_ball_is_a_foul_and_the_first_one_is_lost_too():
    match = at_a_ball("red")
    let_pass(match, 0.3, PULLS)
    pose, _ = match.robot.motion
    match.balls.add((pose[0] - SIDE / 2 - rolling.RADIUS - 0.005, 10.0), (0.0, 0.0), "red")
    let_pass(match, 0.3, PULLS)
    assert match.referee.events[1].detail == "gripped a second ball"
    assert match.balls.held == -1 and match.balls.place[-2] == OUT


def test_after_a_retry_the_robot_waits_five_seconds_whatever_it_is_told():
    match = begun()
    go = Command(np.full(4, 0.5), np.zeros(4))
    match.retry()
    assert match.home == START  # it never left Area 1
    before, _ = match.robot.motion
    let_pass(match, 4.9, go)
    assert match.waiting and np.abs(match.robot.motion[0] - before).max() < 1e-6
    let_pass(match, 0.5, go)
    assert not match.waiting and match.robot.motion[0][0] > before[0] + 0.01


def holding(x: float, y: float, heading: float = 0.0) -> Match:
    match = begun()
    match.balls.place[:] = OUT
    match.robot.place((x, y, heading))
    match.balls.add((1.0, 9.0), (0.0, 0.0), "red")
    match.balls.place[-1] = HELD
    return match


LETS_GO = Command(np.zeros(4), np.zeros(4), release=True)


def test_let_go_over_a_silo_the_ball_is_stored_and_the_gripper_empty():
    match = holding(6.0 - ARM, 9.25)
    let_pass(match, 0.4, LETS_GO)
    assert match.read().holding
    let_pass(match, 0.2, LETS_GO)
    assert match.referee.fillings == ["", "R", "", "", ""] and not match.read().holding
    assert match.referee.points["own"] == 30


@pytest.mark.parametrize("aside", [0.07, -0.07])
def test_let_go_beside_a_silo_s_bore_the_ball_is_lost(aside):
    match = holding(6.0 - ARM, 9.25 + aside)
    let_pass(match, 0.6, LETS_GO)
    assert match.referee.fillings == [""] * 5 and whats(match) == ["lost ball"]
    assert match.balls.place[-1] == OUT


def test_what_is_let_go_over_the_silo_zone_s_edge_is_lost_to_all():
    match = holding(5.80 - ARM, 9.6)
    let_pass(match, 0.6, LETS_GO)
    assert match.balls.place[-1] == OUT and whats(match) == ["lost ball"]


def test_who_waits_in_a_retry_takes_no_ball():
    match = begun()
    match.balls.place[:] = OUT
    match.retry()
    match.robot.place((2.0, 10.0, 0.0))
    match.balls.add((2.0 + SIDE / 2 + rolling.RADIUS + 0.005, 10.0), (0.0, 0.0), "red")
    let_pass(match, 0.6, PULLS)
    assert match.waiting and match.balls.held < 0 and whats(match) == ["retry"]


def test_no_picture_from_before_a_retry_comes_after_it():
    match = begun()
    assert not frames_of(match, 0.05, WATCH) and match._frames
    match.retry()
    assert not frames_of(match, 0.3, STAND)


def test_let_go_over_a_full_silo_the_ball_is_lost_once():
    match = holding(6.0 - ARM, 9.25)
    match.referee.fillings[1] = "BBR"
    let_pass(match, 0.6, LETS_GO)
    assert [event[1:] for event in match.referee.events] == [
        ("lost ball", "own", "silo 2 was full")
    ]
    assert match.balls.place[-1] == OUT and match.referee.fillings[1] == "BBR"


def test_a_ball_that_goes_out_through_the_rollers_is_not_stored_as_well():
    match = holding(6.0 - ARM, 9.25)
    let_pass(match, 0.49, LETS_GO)
    let_pass(match, 0.02, replace(LETS_GO, intake=-1.0))
    assert match.referee.fillings == [""] * 5 and match.balls.place[-1] == FREE


def test_let_go_over_the_floor_it_lies_there():
    match = holding(4.0, 10.0)
    let_pass(match, 0.6, LETS_GO)
    assert match.balls.place[-1] == FREE
    assert np.abs(match.balls.xy[-1] - (4.0 + ARM, 10.0)).max() < 0.01


def test_rollers_that_turn_outwards_let_the_ball_go_ahead():
    match = holding(4.0, 10.0, pi)
    let_pass(match, 0.3, Command(np.zeros(4), np.zeros(4), intake=-1.0))
    assert match.balls.place[-1] == FREE and match.balls.velocity[-1, 0] < -0.1


def test_a_ball_held_by_the_robot_that_is_carried_away_leaves_the_game():
    match = holding(4.0, 10.0)
    match.retry()
    assert match.balls.place[-1] == OUT


# --- camera ------------------------------------------------------------------------------------

WATCH = Command(np.zeros(4), np.zeros(4), tilt=0.4, watch="ball")


def frames_of(match: Match, seconds: float, command: Command) -> list:
    """Frames and when they arrived."""
    seen = []
    for _ in range(round(seconds * 100)):
        match.apply(command)
        match.step()
        now = match.read()
        if now.frame is not None:
            seen.append((now.time, now.frame))
    return seen


def test_pictures_come_ten_times_a_second_80_ms_after_they_were_taken_and_only_when_asked_for():
    match = begun()
    match.robot.place((2.9, 10.0, pi))
    assert not frames_of(match, 0.5, STAND)
    seen = frames_of(match, 1.0, WATCH)
    taken = np.array([frame.time for _, frame in seen])
    np.testing.assert_allclose(np.diff(taken), FRAMES, atol=1e-6)
    np.testing.assert_allclose([now - frame.time for now, frame in seen], LATENCY, atol=1e-6)
    assert sum(len(frame.found["ball"].scores) for _, frame in seen[3:]) > 10


def test_the_camera_turns_as_fast_as_its_servo():
    match = begun()
    seen = frames_of(match, 0.5, Command(np.zeros(4), np.zeros(4), pan=0.8, watch="silo"))
    pans = [frame.pan for _, frame in seen]
    assert pans[0] < 0.2 and pans[-1] == pytest.approx(0.8)
    assert max(np.diff(pans)) <= SERVO * FRAMES + 1e-9


# --- faults ------------------------------------------------------------------------------------


def test_each_kind_of_fault_is_tested_below():
    assert set(KINDS) == {"dark", "lidar", "slip", "drop", "filled", "kidnap", "frozen"}
    assert set(HAPPENS) < set(KINDS)


def test_dark_the_camera_sees_nothing_for_a_while():
    match = begun(faults=[Fault("dark", 0.5, 0.5)])
    match.robot.place((2.9, 10.0, pi))
    counts = {
        round(frame.time - match.started, 2): len(frame.found["ball"].scores) if frame.found else 0
        for _, frame in frames_of(match, 1.6, WATCH)
    }
    dark = [n for time, n in counts.items() if 0.5 <= time < 1.0]
    assert dark and not any(dark)
    assert all(n for time, n in counts.items() if 0.2 < time < 0.45 or time > 1.05)


def test_lidar_no_lidar_answers_for_a_while():
    match, silent = begun(faults=[Fault("lidar", 0.2, 0.3)]), []
    for _ in range(80):
        match.step()
        silent.append(all(reading.strength == 0 for reading in match.read().lidar))
    assert silent[25:45] == [True] * 20 and not any(silent[:15]) and not any(silent[55:])


def test_slip_a_dead_wheel_loses_its_way_when_it_is_told():
    match = begun(faults=[Fault("slip", 1.0, 0.3)])
    match.robot.place((0.6, 5.5, 0.0))
    ahead, lost = Command(np.full(4, 0.5), np.zeros(4)), []
    for _ in range(200):
        match.apply(ahead)
        match.step()
        left, right, _ = match.read().ticks
        lost.append(int(right - left))
    lost = np.array(lost)
    per_metre = 1.0 / match.robot.model.dead_wheels.metres_per_tick[0]
    assert abs(lost[:98]).max() < 40  # wheels differ a little
    assert lost[-1] == pytest.approx(0.3 * 0.5 * per_metre, rel=0.1)
    assert abs(lost[135:] - lost[135]).max() < 40


def test_drop_the_ball_rolls_away_from_the_gripper():
    match = holding(4.0, 10.0)
    match.faults = (Fault("drop", 0.2),)
    let_pass(match, 0.15)
    assert match.balls.held >= 0
    let_pass(match, 0.2)
    assert match.balls.held == -1 and match.balls.place[-1] == FREE and "fault" in whats(match)
    assert hypot(*(match.balls.xy[-1] - (4.0, 10.0))) > 0.5


def test_filled_the_other_team_fills_the_silo_before_the_robot():
    match = holding(5.1, 10.75)
    match.faults = (Fault("filled", 0.1),)
    let_pass(match, 0.3)
    assert match.referee.fillings == ["", "", "", "BBB", ""]
    assert whats(match).count("fault") == 1


def test_kidnap_the_robot_stands_elsewhere_at_once():
    match = begun(faults=[Fault("kidnap", 0.1)])
    match.robot.place((4.3, 10.5, 0.0))
    let_pass(match, 0.3)
    pose, _ = match.robot.motion
    assert hypot(pose[0] - 4.3, pose[1] - 10.5) > 1.0 and whats(match) == ["fault"]


def test_after_a_foul_no_fault_puts_the_robot_back_where_it_was():
    def at_a_purple_ball(*faults) -> Match:
        match = begun(faults=faults)
        match.balls.place[:] = OUT
        match.robot.place((4.3, 10.5, pi))
        match.balls.add((4.3 - SIDE / 2 - rolling.RADIUS - 0.005, 10.5), (0.0, 0.0), "purple")
        let_pass(match, 0.4, PULLS)
        return match

    foul = at_a_purple_ball().referee.events[0]
    match = at_a_purple_ball(Fault("kidnap", foul.time))  # possible in the very same cycle
    assert whats(match) == ["foul", "retry"]
    assert np.abs(match.robot.motion[0] - match.home)[:2].max() < 0.01


def test_frozen_every_read_is_the_same():
    match = begun(faults=[Fault("frozen", 0.1, 0.2)])
    let_pass(match, 0.05)
    before = match.read()
    let_pass(match, 0.1)
    frozen = match.read()
    assert frozen is before
    let_pass(match, 0.2)
    assert match.read().time > frozen.time + 0.2


# --- the autopilot after a retry, and the crew's buttons ----------------------------------------


def test_after_a_retry_the_robot_begins_again_from_the_retry_zone_and_takes_a_ball():
    play = Play(seed=1)
    play.start()
    while play.match.clock < 11.0:
        play.tick()
    taken = play.match.referee.count("taken")
    play.match.retry()
    states = set()
    while play.match.clock < 32.0 and play.match.referee.count("taken") == taken:
        play.tick()
        states.add(play.pilot.state)
    assert play.match.referee.count("taken") == taken + 1
    assert {State.RESET, State.GO_TO_AREA_3, State.LIDAR_RESET, State.TAKE_BALL} <= states


@pytest.mark.parametrize("y", [9.2, 9.6, 10.0])
def test_a_ball_that_lies_against_the_fence_is_taken_at_the_first_try(y):
    play = Play(seed=1, opponent=None)
    play.start()
    while play.match.clock < 10.0:
        play.tick()
    balls = play.match.balls
    balls.place[:], balls.velocity[:] = OUT, 0.0
    balls.xy[0], balls.place[0], balls.colours[0] = (rolling.RADIUS, y), FREE, "red"
    while play.match.clock < 22.0 and balls.held < 0:
        play.tick()
    assert balls.held == 0
    assert "missed" not in [step.reason for step in play.pilot.history.steps]


def test_the_operator_starts_stops_and_retries():
    bus = Bus()
    play = Play(seed=1, bus=bus)
    assert bus.latest["/operator"].name == "set_up"
    bus.publish("/operator", Button("start"))
    assert play.match.started is not None
    for _ in range(300):
        play.tick()
    assert play.match.robot.motion[0][1] > 0.8
    bus.publish("/operator", Button("stop"))
    for _ in range(100):
        play.tick()
    assert play.pilot.state is State.RESET and np.abs(play.match.robot.motion[1]).max() < 0.01
    bus.publish("/operator", Button("retry"))
    told = []
    bus.subscribe("/operator", lambda topic, button: told.append(button.name))
    for _ in range(600):
        play.tick()
    assert play.match.retries == 1 and told == ["placed", "stop"]
    assert play.pilot.state is State.RESET, "who was stopped waits for start, after a retry too"
    bus.publish("/operator", Button("start"))
    play.tick()
    assert play.pilot.state is State.GO_TO_AREA_3


def test_a_start_during_a_retry_waits_for_its_end():
    bus = Bus()
    play = Play(seed=1, opponent=None, bus=bus)
    for name in ("start", "retry", "stop", "start"):
        bus.publish("/operator", Button(name))
        for _ in range(100):
            play.tick()
    assert play.match.waiting and play.match.wait_left == pytest.approx(2.0, abs=0.05)
    assert play.pilot.state is State.RESET and not play.pilot.stopped
    for _ in range(210):
        play.tick()
    assert play.match.wait_left == 0.0 and play.pilot.state is State.GO_TO_AREA_3


BAD_BUTTONS = [
    Button("colour", "green"), Button("colour", 1.0), Button("pan", "left"), Button("pan", np.nan),
    Button("intake", ""), Button("tilt", None), Button("dance", "on"), "no button",
]  # fmt: skip


def test_buttons_that_cannot_be_are_told_and_the_others_work_on():
    bus, lines = Bus(), []
    play = Play(seed=1, bus=bus)
    bus.subscribe("/rosout", lambda topic, message: lines.append((message.level, message.text)))
    for button in BAD_BUTTONS:
        bus.publish("/operator", button)
    assert bus.failed == [] and play.match.team == "red"
    assert {level for level, _ in lines} == {"warning"} and len(lines) == len(BAD_BUTTONS) - 1
    assert "colour: expected one of red, blue, got 'green'" in lines[0][1]
    assert "pan: expected a number, got 'left'" in lines[2][1]
    bus.publish("/operator", Button("start"))
    assert play.match.started is not None


@pytest.mark.parametrize("stick", [Twist(np.nan, 0.0, 0.0), Twist("fast", 0, 0), None])
def test_a_stick_that_is_nowhere_is_in_the_middle_and_is_heard_on(stick):
    bus = Bus()
    play = Play(seed=1, bus=bus)
    bus.publish("/operator", Button("manual", "on"))
    for told, moves in ((Twist(0.3, 0.0, 0.0), True), (stick, False), (Twist(0.3, 0, 0), True)):
        bus.publish("/cmd_vel", told)
        for _ in range(60):
            play.tick()
        assert (abs(play.match.robot.motion[1][0]) > 0.1) == moves
    assert bus.failed == []


def test_release_lets_go_for_a_while_with_rollers_that_stand():
    hand, seen = ByHand(), Match(1, opponent=None).read()
    hand.press(Button("manual", True))
    hand.press(Button("intake", 1.0))
    hand.press(Button("pan", 0.4))
    before = hand.command(Parts(), seen)
    assert hand.on and (before.intake, before.release, before.pan) == (1.0, False, 0.4)
    hand.press(Button("release"))
    told = [hand.command(Parts(), seen) for _ in range(100)]
    assert {one.intake for one in told} == {0.0}
    assert [one.release for one in told] == [True] * 70 + [False] * 30
    hand.press(Button("manual", "on"))
    assert hand.command(Parts(), seen).pan == 0.0, "whoever takes over begins anew"


def test_the_stick_is_in_the_robots_own_axes():
    hand, seen = ByHand(), Match(1, opponent=None).read()
    hand.steer("/cmd_vel", Twist(0.3, 0.0, 0.0))
    ahead = hand.command(Parts(), seen)
    np.testing.assert_allclose(np.asarray(ahead.speeds) * np.cos(ahead.angles), 0.3, atol=1e-9)


def test_before_a_match_its_colour_is_chosen_after_it_the_next_one_s(half_a_second):
    bus = Bus()
    play = Play(seed=1, opponent=None, bus=bus)
    bus.publish("/operator", Button("colour", "blue"))
    assert play.match.team == play.pilot.team == "blue" and play.match.started is None
    bus.publish("/operator", Button("start"))
    first = play.match
    bus.publish("/operator", Button("colour", "red"))
    assert play.match is first and first.team == "blue", "in a match it is the next one's, too"
    bus.publish("/operator", Button("colour", "blue"))
    for _ in range(60):
        play.tick()
    bus.publish("/operator", Button("colour", "red"))
    assert play.match is first, "the score stays until the next start"
    bus.publish("/operator", Button("start"))
    assert play.match is not first and play.match.team == play.pilot.team == "red"
    assert play.match.started is not None and play.seed == 2


def test_after_the_end_and_after_a_stop_nobody_drives_by_hand_any_more(half_a_second):
    bus = Bus()
    play = Play(seed=1, opponent=None, bus=bus)
    for last in (Button("stop"), Button("start")):
        bus.publish("/operator", Button("start"))
        bus.publish("/operator", Button("manual", "on"))
        assert play._by_hand.on
        while not play.match.over:
            play.tick()
        bus.publish("/operator", last)
        assert not play._by_hand.on


def test_the_half_where_nobody_plays_is_refused_in_words_and_told_back():
    bus, lines, told = Bus(), [], []
    play = Play(seed=1, opponent=None, bus=bus)
    bus.subscribe("/rosout", lambda topic, message: lines.append(message.text))
    bus.subscribe("/operator", lambda topic, button: told.append((button.name, button.value)))
    bus.publish("/operator", Button("side", "left"))
    assert lines == [] and bus.failed == []
    bus.publish("/operator", Button("side", "right"))
    assert ("side", "left") in told and play.match.started is None
    begin = "a button that means nothing here: side: this field's robot plays in its left half"
    assert lines[0].startswith(begin)


def test_another_strategy_is_refused():
    with pytest.raises(CourseError, match="strategy: expected one of A, B, ahead, got 'C'"):
        Play(strategy="C")


@pytest.fixture
def half_a_second(monkeypatch):
    """Matches are over at once."""
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 0.5)


def test_how_a_match_ended_is_told_though_nobody_ticks_on(monkeypatch):
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 5.0)
    bus, lines = Bus(), []
    bus.subscribe("/rosout", lambda topic, message: lines.append(message.text))
    play = Play(seed=1, opponent=None, bus=bus)
    play.start()
    while not play.match.over:
        play.tick()
    score = bus.latest["/score"]
    assert (score.winner, score.reason) == ("nobody", "points")
    assert score.time == pytest.approx(play.match.robot.time)
    assert "own: seedling" in lines, "it was planted in the last step"


def test_after_the_end_the_match_clock_stands_and_never_runs_below_nothing(half_a_second):
    bus = Bus()
    play = Play(seed=1, opponent=None, bus=bus)
    play.start()
    for _ in range(100):
        play.tick()
    assert bus.latest["/score"].left == 180.0 - play.match.referee.ended


def test_what_the_other_team_loses_is_no_warning_to_us():
    bus, lines = Bus(), []
    bus.subscribe("/rosout", lambda topic, message: lines.append((message.level, message.text)))
    play = Play(seed=1, opponent=None, bus=bus)
    play.match.referee.note(1.0, "lost ball", "theirs")
    play.match.referee.note(1.0, "lost ball", "own", "let go over the floor")
    play.tick()
    assert lines[-2:] == [
        ("info", "theirs: lost ball"),
        ("warning", "own: lost ball let go over the floor"),
    ]


# --- what is told, and the drawn camera ---------------------------------------------------------


@cache
def drawn() -> tuple[Play, dict]:
    """The first seconds of a match on drawn pictures, until a ball is taken."""
    bus, told = Bus(), {}
    bus.subscribe("*", lambda topic, message: told.setdefault(topic, []).append(message))
    play = Play(seed=1, bus=bus, drawn=True)
    play.start()
    bus.publish("/cmd_vel", Twist(0.0, 0.0, 0.0))
    while play.match.clock < 30.0 and not play.match.referee.count("taken"):
        play.tick()
    return play, told


def test_on_drawn_pictures_the_first_ball_is_taken_in_half_a_minute_without_a_foul():
    play, _ = drawn()
    assert play.match.referee.count("taken") == 1 and play.match.referee.count("foul") == 0
    assert play.pilot.sight.frames > 10


def test_every_topic_that_is_promised_is_told_and_no_other():
    _, told = drawn()
    for _ in range(20):
        drawn()[0].tick()
    assert len(TOPICS) == 14
    assert set(told) | {"/silos"} == TOPICS
    kinds = {
        "/odom": messages.PoseStamped, "/ground_truth": messages.PoseStamped,
        "/plan": messages.Path, "/scan": messages.LaserScan, "/camera/image": messages.Image,
        "/camera/detections": messages.Detection2DArray, "/mission/state": messages.State,
        "/rosout": messages.Log, "/score": messages.Score,
    }  # fmt: skip
    for topic, kind in kinds.items():
        assert all(isinstance(message, kind) for message in told[topic]), topic


def test_what_is_told_is_what_is():
    play, told = drawn()
    observations = told["/observation"]
    assert [one.time for one in observations] == sorted(one.time for one in observations)
    assert len(observations) == len(told["/command"])
    states = [message.name for message in told["/mission/state"]]
    assert "take_ball" in states and states.index("go_to_area_3") < states.index("take_ball")
    assert (np.diff([message.time for message in told["/odom"]]) > 0.04).all()
    last = told["/score"][-1]
    assert last.left == pytest.approx(180.0 - play.match.clock, abs=0.3) and last.winner == ""
    image = told["/camera/image"][-1].image_bgr
    assert image.shape == (240, 320, 3) and image.std() > 5
    boxes = told["/camera/detections"][-1]
    assert len(boxes.boxes) == len(boxes.scores) == len(boxes.labels)
    truth, belief = told["/ground_truth"][-1], told["/odom"][-1]
    assert hypot(*(truth.pose - belief.pose)[:2]) < 0.1


def test_in_the_dark_the_drawn_picture_is_black():
    match = begun(drawn=True, faults=[Fault("dark", 0.0, 9.0)])
    seen = frames_of(match, 0.3, WATCH)
    assert seen and not any(frame.image_bgr.any() for _, frame in seen)


# --- campaigns ---------------------------------------------------------------------------------


def test_campaign_weak_team(whole):
    """Mua Vang in nine of ten; no foul and no contact in 19 of 20; 20 mm, 5 mm at resets."""
    match = benchmark("match")
    results = match.weak(range(200)) if whole else on_two_processes()[0]
    told = match.summary(results)
    print(told.line)
    assert told.won == 1.0 if not whole else told.won >= 0.95
    assert told.at_resets <= 0.005 if whole else told.at_resets <= 0.008
    if whole:
        assert told.mua_vang >= 0.90 and told.clean >= 0.95 and told.error <= 0.020


@pytest.mark.campaign
def test_campaign_strong_team():
    """Looking ahead wins at once more often than orders A and B, on the same seeds."""
    match = benchmark("match")
    match.print_strong(list(range(200)), map)
    won = match.board_games(range(200), "middling")
    assert match.mcnemar(won["ahead"], won["A"]) < 1e-3
    assert match.mcnemar(won["ahead"], won["B"]) < 1e-3


FAULTY = [("kidnap", "frozen"), ("drop", "lidar")]


@pytest.mark.parametrize("kinds", FAULTY, ids="+".join)
def test_whatever_goes_wrong_every_state_is_left_in_time(kinds):
    match = benchmark("match")
    [result] = match.faulty(kinds, [1])
    assert match.overdue(result) == [] and result.ended <= 180.0
    assert result.stored >= 1
    happened = [event.detail for event in result.events if event.what == "fault"]
    assert set(happened) == set(kinds) & set(HAPPENS)


@pytest.mark.campaign
@pytest.mark.parametrize("kinds", benchmark("match").fault_sets(), ids="+".join)
def test_campaign_faults(kinds):
    match = benchmark("match")
    results = match.faulty(kinds, range(20))
    print(" + ".join(kinds), match.summary(results).line)
    assert [line for one in results for line in match.overdue(one)] == []


@pytest.mark.campaign
def test_campaign_position():
    """What each sense is worth: the position's error with one less."""
    match = benchmark("match")
    errors = {}
    for name, results in match.position(range(20)).items():
        told = match.summary(results)
        errors[name] = told.error
        print(f"{name:16} {told.line}")
    assert errors["full"] < min(errors["without LiDAR"], errors["without set-up"])


@pytest.mark.campaign
def test_campaign_camera():
    match = benchmark("match")
    told = match.summary(match.weak(range(20), drawn=True))
    print(told.line)
    assert told.won >= 0.8


def test_a_robot_that_was_stopped_goes_on_when_start_is_pressed_and_the_clock_ran_on():
    bus = Bus()
    play = Play(seed=1, opponent=None, bus=bus)
    bus.publish("/operator", Button("start"))
    for _ in range(300):
        play.tick()
    bus.publish("/operator", Button("stop"))
    for _ in range(200):
        play.tick()
    here = play.match.robot.motion[0]
    assert play.pilot.state is State.RESET and play.match.clock == pytest.approx(5.0)
    bus.publish("/operator", Button("start"))
    bus.publish("/operator", Button("start"))  # twice makes no difference
    for _ in range(200):
        play.tick()
    assert play.pilot.state is State.GO_TO_AREA_3
    assert hypot(*(play.match.robot.motion[0] - here)[:2]) > 0.5
    assert play.pilot._ends == pytest.approx(play.match.started + 180.0, abs=0.02)


def test_parts_that_are_all_a_students_own_bring_two_balls_to_silos():
    play = Play(0, solved_parts(), seed=1, opponent=None, strategy="A")
    assert play.pilot.parts.label == "mine"
    play.start()
    while play.match.clock < 50.0 and play.match.referee.count("stored") < 2:
        play.tick()
    assert play.match.referee.count("stored") == 2 and play.match.referee.count("foul") == 0


@pytest.mark.campaign
def test_campaign_parts():
    """On none, some and all parts of a student's own that are right, it plays as well."""
    match, own, course = benchmark("match"), solved_parts(), Parts()
    some = {name: getattr(own, name) for name in own.mine[::2]}
    kinds = {"none": course, "some": replace(course, **some, mine=tuple(some)), "all": own}
    told = {}
    for name, parts in kinds.items():
        told[name] = match.summary(match.weak(range(20), parts=parts))
        print(f"{name:5} {parts.label:24} {told[name].line}")
    for one in told.values():
        assert one.won == 1.0 and one.mua_vang >= 0.8 and one.clean >= 0.8
        assert abs(one.stored - told["none"].stored) < 1.0
