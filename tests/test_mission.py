"""The mission table, the choice of silos and balls, and whether the robot is stuck."""

from __future__ import annotations

from itertools import pairwise, product
from math import cos, hypot, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from conftest import benchmark
from robocon_course import field, mission
from robocon_course._arrays import CourseError
from robocon_course.autopilot import Autopilot
from robocon_course.autopilot.plays import PLAYS, fits
from robocon_course.autopilot.tracks import Track
from robocon_course.mission import (
    ANY,
    LIMITS,
    MISSION,
    RESETS,
    Facts,
    History,
    MissionError,
    Rhythm,
    SeenBall,
    State,
    Table,
    Transition,
    Watch,
    balls,
    choose_ball,
    choose_silo,
    dead_ends,
    is_stuck,
    mermaid,
    mission_table,
    order_a,
    order_b,
    owner,
    reachable,
    rhythm_seen,
    winner,
)

FILLINGS = ["".join(balls) for k in range(4) for balls in product("RB", repeat=k)]
fillings = st.lists(st.sampled_from(FILLINGS), min_size=5, max_size=5)
places = st.floats(8.5, 11.5)
SWAP = str.maketrans("RB", "BR")


def always(facts) -> bool:
    return True


def never(facts) -> bool:
    return False


def rows(*edges) -> list[Transition]:
    return [Transition(*edge, always, "on") for edge in edges]


# --- the table's refusals ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("edges", "limits", "sentence"),
    [
        ([("a", "b"), ("b", "x")], {}, "x: no state of this table"),
        ([("a", "b"), ("y", "b")], {}, "y: no state of this table"),
        ([("a", "b"), ("b", "c"), ("c", "a")], {}, "c: an end, but a row leads on"),
        ([("a", "c"), ("b", "c")], {}, "b: never reached from a"),
        ([("a", "c"), ("a", "b")], {}, "b: a dead end: no way leads to an end"),
        ([("a", "c"), ("a", "b"), ("b", "b")], {}, "b: a dead end"),
        ([("a", "b"), ("b", "c")], {"b": (2.0, "z")}, "z: no state of this table"),
        ([("a", "b"), ("b", "c")], {"c": (2.0, "a")}, "c: an end, but a row leads on"),
        ([("a", "b"), ("b", "c")], {"a": (0.0, "c")}, "a: its limit is no time above 0 s"),
        ([("a", "b"), ("b", "c")], {"b": (float("nan"), "c")}, "b: its limit is no time"),
    ],
)
def test_a_table_that_cannot_be_right_is_refused_with_the_state_and_the_rule(
    edges, limits, sentence
):
    with pytest.raises(MissionError, match=f"table: {sentence}"):
        Table(rows(*edges), "abc", "a", "c", limits=limits)


def test_a_start_and_an_end_that_are_no_states_are_refused_too():
    with pytest.raises(MissionError, match="table: s: no state of this table"):
        Table(rows(("a", "c")), "ac", "s", "c")
    with pytest.raises(MissionError, match="table: e: no state of this table"):
        Table(rows(("a", "c")), "ac", "a", "e")


def test_a_way_out_by_a_limit_alone_is_a_way_out():
    assert Table(rows(("a", "b")), "abc", "a", "c", limits={"b": (2.0, "c")}).limits


# --- which row wins ----------------------------------------------------------------------------


def test_the_first_row_that_matches_wins():
    table = Table(
        [
            Transition("a", "b", never, "never"),
            Transition("a", "c", always, "first"),
            Transition("a", "b", always, "second"),
            *rows(("b", "c")),
        ],
        "abc", "a", "c",
    )  # fmt: skip
    after = table.step(table.begin(1.0), Facts(), 3.5)
    assert (after.state, after.since) == ("c", 3.5)
    assert after.steps == ((3.5, "a", "c", "first"),)


def test_where_no_row_matches_the_history_stays_the_same_object():
    table = Table([Transition("a", "c", never, "no")], "ac", "a", "c")
    history = table.begin(1.0)
    assert table.step(history, Facts(), 9.0) is history


def test_a_limit_is_tried_last_and_only_when_it_has_passed():
    table = Table(
        [Transition("a", "c", lambda f: f.arrived, "there"), *rows(("b", "c"))],
        "abc", "a", "c", limits={"a": (2.0, "b")},
    )  # fmt: skip
    begun = table.begin()
    assert table.step(begun, Facts(waited=2.0), 2.0) is begun
    late = table.step(begun, Facts(waited=2.01), 2.01)
    assert late.state == "b" and late.steps[0].reason == "longer than 2 s"
    assert table.step(begun, Facts(waited=9.0, arrived=True), 9.0).state == "c"


def test_any_stands_for_every_state_but_the_ends_and_its_own_target():
    table = Table([Transition(ANY, "b", always, "any"), *rows(("b", "c"))], "abc", "a", "c")
    assert [(row.source, row.target) for row in table.rows] == [("a", "b"), ("b", "c")]


def test_a_history_remembers_the_last_steps_only():
    table = Table(
        [*rows(("a", "b"), ("b", "a")), Transition("a", "c", never, "-")], "abc", "a", "c"
    )
    history = table.begin()
    for k in range(500):
        history = table.step(history, Facts(), float(k))
    assert len(history.steps) == mission.table.REMEMBERED and history.steps[-1].time == 499.0


def test_a_student_s_choice_takes_the_place_of_the_first_match():
    table = Table([*rows(("a", "b"), ("a", "c")), *rows(("b", "c"))], "abc", "a", "c")
    last = table.step(table.begin(), Facts(), 1.0, lambda rows, state, facts: rows[-1])
    assert last.state == "c"


# --- graphs ------------------------------------------------------------------------------------


def closure(edges, count) -> np.ndarray:
    """Naive twin: Floyd and Warshall's, whether a way leads from i to j."""
    way = np.eye(count, dtype=bool)
    for i, j in edges:
        way[i, j] = True
    for k in range(count):
        way |= way[:, k : k + 1] & way[k]
    return way


@given(
    edges=st.lists(st.tuples(st.integers(0, 7), st.integers(0, 7)), max_size=20),
    start=st.integers(0, 7),
    ends=st.lists(st.integers(0, 7), max_size=3),
)
def test_reachable_and_dead_ends_are_what_floyd_and_warshall_say(edges, start, ends):
    way = closure(edges, 8)
    assert reachable(edges, start) == set(np.flatnonzero(way[start]))
    assert dead_ends(edges, range(8), ends) == {k for k in range(8) if not way[k, ends].any()}


PRINTED = {
    "reset": ["go to area 3"], "go to area 3": ["lidar reset"], "lidar reset": ["push pile"],
    "push pile": ["reverse"], "reverse": ["reverse after the push"],
    "detect ball": ["search ball, reset"], "search ball, reset": ["search ball"],
    "search ball": ["search silo, reset"], "search silo, reset": ["search silo"],
    "search silo": ["approach, reset"], "approach, reset": ["approach silo 4"],
    "approach silo 4": ["silo full"], "silo full": ["approach"],
    "reset after silo": ["back to storage"], "back to storage": ["search ball, reset"],
    "stuck": ["search ball, reset"],
}  # fmt: skip
"""The ways of the printed mission of 2024: from each case to where it jumps."""


def test_the_printed_mission_deadlocks_after_the_first_push_and_the_checks_find_all_of_it():
    edges = [(source, target) for source, targets in PRINTED.items() for target in targets]
    no_case = {target for _, target in edges} - set(PRINTED)
    assert no_case == {"reverse after the push", "approach"}
    found = reachable(edges, "reset")
    assert "reverse" in found and "search ball" not in found
    entered = {target for _, target in edges}
    assert set(PRINTED) - entered - {"reset"} == {"detect ball", "reset after silo", "stuck"}
    # From where a ball is being looked for, nothing leads back for a second one.
    assert "search silo" in dead_ends(edges, PRINTED, ["back to storage"])
    with pytest.raises(MissionError, match="approach, reverse after the push: no state"):
        Table(rows(*edges), tuple(PRINTED), "reset", ["back to storage"])


def test_with_the_missing_cases_and_an_end_it_is_refused_for_what_is_never_reached():
    edges = [(source, target) for source, targets in PRINTED.items() for target in targets]
    edges.append(("back to storage", "end of the match"))
    states = (*PRINTED, "reverse after the push", "approach", "end of the match")
    with pytest.raises(MissionError, match=r"search ball.* stuck: never reached from reset"):
        Table(rows(*edges), states, "reset", ["end of the match"])


# --- Robot 2's own table -----------------------------------------------------------------------


def test_every_state_has_a_play_and_all_but_three_have_a_limit():
    assert set(PLAYS) == set(State)
    assert set(State) - set(LIMITS) == {State.RESET, State.NO_SENSORS, State.FINISHED}


def test_what_is_forgotten_is_known_by_name():
    assert set(RESETS) <= set(State)
    assert set().union(*RESETS.values()) == {"pose", "balls", "choice"}


def test_by_its_limits_alone_the_mission_leaves_every_state_it_starts_in():
    table = mission_table()
    for state in LIMITS:
        facts = Facts(waited=1e3, started=True, holding=False, in_area_3=True)
        after = table.step(mission.History(state, 0.0), facts, 1e3)
        assert after.state != state, state


@given(
    facts=st.builds(Facts, waited=st.floats(0, 50), **{
        name: st.booleans() for name in Facts._fields[1:]
    }),
    state=st.sampled_from(list(State)),
)  # fmt: skip
def test_whatever_is_known_the_mission_goes_to_a_state_and_a_match_that_is_over_ends(facts, state):
    after = mission_table().step(mission.History(state, 0.0), facts, 1.0)
    assert after.state in State
    if facts.over:
        assert after.state is State.FINISHED


def test_with_a_ball_and_a_silo_it_goes_its_round():
    """One ball, from the table alone."""
    story = [
        (State.GO_TO_AREA_3, Facts(started=True)),
        (State.LIDAR_RESET, Facts(started=True, arrived=True, in_area_3=True)),
        (State.BACK_TO_STORAGE, Facts(started=True, reset_done=True, in_area_3=True)),
        (State.TAKE_BALL, Facts(started=True, ball=True, in_area_3=True)),
        (State.SEARCH_SILO, Facts(started=True, holding=True, in_area_3=True)),
        (State.APPROACH_SILO, Facts(started=True, holding=True, silo=True, in_area_3=True)),
        (State.RESET_AFTER_SILO, Facts(started=True, released=True, in_area_3=True)),
        (State.BACK_TO_STORAGE, Facts(started=True, reset_done=True, in_area_3=True)),
    ]
    table = mission_table()
    history = table.begin()
    for k, (state, facts) in enumerate(story):
        history = table.step(history, facts, float(k))
        assert history.state is state


@pytest.mark.parametrize(
    ("facts", "state"),
    [
        (Facts(), State.GO_TO_AREA_3),
        (Facts(in_area_3=True, holding=True), State.SEARCH_SILO),
        (Facts(in_area_3=True), State.BACK_TO_STORAGE),
        (Facts(in_area_3=True, over=True), State.FINISHED),
        (Facts(started=True, blind=True), State.NO_SENSORS),
    ],
)
def test_when_readings_are_back_the_robot_goes_on_where_it_stands(facts, state):
    after = mission_table().step(mission.History(State.NO_SENSORS, 0.0), facts, 1.0)
    assert after.state is state


def test_the_diagram_shows_every_state_and_every_way_and_paints_the_live_one():
    table = mission_table()
    drawn = mermaid(table, State.TAKE_BALL).splitlines()
    assert drawn[:2] == ["stateDiagram-v2", "    [*] --> reset"]
    ways = {(row.source.value, row.target.value) for row in table.rows}
    arrows = [line for line in drawn if "-->" in line and "[*]" not in line]
    assert len(arrows) == len(ways)  # several reasons for one way share its arrow
    assert {tuple(line.split(":")[0].split(" --> ")) for line in map(str.strip, arrows)} == ways
    assert "    finished --> [*]" in drawn and drawn[-1] == "    class take_ball live"
    assert "live" not in mermaid(table)


def test_a_small_diagram_by_hand():
    table = Table([*rows(("a", "c")), Transition("a", "c", never, "again")], "ac", "a", "c")
    assert (
        mermaid(table) == "stateDiagram-v2\n    [*] --> a\n    a --> c: on / again\n    c --> [*]\n"
    )


def test_an_own_ball_is_taken_only_after_a_look():
    table, at = mission.mission_table(), History(State.DETECT_BALL, 0.0)
    seen = Facts(started=True, in_area_3=True, ball=True)
    hasty = table.step(at, seen._replace(waited=0.9 * mission.robot.LOOK), 1.0)
    assert hasty is at
    calm = table.step(at, seen._replace(waited=1.1 * mission.robot.LOOK), 1.0)
    assert calm.state is State.TAKE_BALL


@pytest.mark.parametrize("state", list(State))
def test_what_a_state_forgets_is_what_it_finds_anew(state):
    """Balls where others may have moved them, a silo where another is sought, the pose at walls."""
    pilot = Autopilot()
    pilot.sight.tracks = [Track(1.0, 9.0, 0.01, (0.0, 0.0, 1.0), 3, 0)]
    pilot.notes = {"silo": 2}
    pilot._enter(state)
    assert (not pilot.sight.tracks) == (state in ("reset", "reverse", "back_to_storage"))
    assert ("silo" not in pilot.notes) == (state in ("reset", "search_silo", "silo_full"))
    again = ("lidar_reset", "reset_odometry_from_lidar")
    assert (max(pilot.walls.sigma) > 0.04) == (state in again)


def test_every_row_says_why():
    assert all(row.label and row.label == row.label.strip() for row in MISSION)


# --- silos -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("filling", "whose"),
    [
        ("RRR", "R"), ("BRR", "R"), ("RBR", "R"), ("RRB", None), ("RBB", "B"), ("BBB", "B"),
        ("BBR", None), ("RR", None), ("", None), ("empty", None),
    ],
)  # fmt: skip
def test_a_silo_is_owned_when_full_with_two_balls_and_the_top_one(filling, whose):
    assert owner(filling) == whose


@given(filling=st.sampled_from([f for f in FILLINGS if len(f) == 3]))
def test_of_full_silos_a_quarter_is_nobody_s(filling):
    expected = filling[2] if filling.count(filling[2]) >= 2 else None
    assert owner(filling) == expected


def test_three_silos_win_and_two_do_not():
    assert winner(["RRR", "BRR", "RBR", "", ""]) == "R"
    assert winner(["RRR", "BRR", "RRB", "RR", ""]) is None
    assert winner(["BBB", "RBB", "BRB", "RRR", "RRR"]) == "B"


def test_a_ball_more_lies_on_top():
    assert mission.after("RB", "R") == "RBR" and mission.after("empty", "B") == "B"
    assert mission.own_and_theirs("RBR", "blue") == (1, 2)
    assert mission.own_and_theirs("empty", "red") == (0, 0)


KINDS = ("RB", "RR", "BB", "", "R", "B")
"""In the order in which both teams of 2024 would take them, for red."""


@pytest.mark.parametrize("order", [order_a, order_b])
def test_both_orders_rank_the_kinds_of_filling_as_their_teams_did(order):
    for better, worse in pairwise(KINDS):
        known = ["RRR", worse, worse, better, worse]
        assert order(known, "red", 10.0) == 3, (better, worse)
        assert order([f.translate(SWAP) for f in known], "blue", 10.0) == 3


@pytest.mark.parametrize("order", [order_a, order_b])
def test_of_equal_silos_the_nearest_is_taken_and_of_full_ones_none(order):
    assert order([""] * 5, "red", 10.9) == 3
    assert order(["R", "BR", "", "RB", "BR"], "red", 8.6) == 1
    assert order(["RBR"] * 5, "red", 10.0) is None


@given(known=fillings, y=places, team=st.sampled_from(["red", "blue"]))
def test_as_points_are_whole_and_no_way_is_worth_one_both_orders_are_the_same(known, y, team):
    assert order_a(known, team, y) == order_b(known, team, y)


@given(known=fillings, y=places)
def test_orders_a_and_b_are_called_as_ahead_is_and_mind_no_rhythm(known, y):
    for order in (order_a, order_b):
        assert order(known, "red", y, Rhythm(next=1.0)) == order(known, "red", y)


@given(known=fillings, y=places, order=st.sampled_from(list(mission.STRATEGIES)))
def test_no_order_takes_a_full_silo_and_all_take_one_while_there_is_room(known, y, order):
    silo = mission.STRATEGIES[order](known, "red", y)
    room = [k for k, filling in enumerate(known) if len(filling) < 3]
    assert silo in room if room else silo is None


@given(known=fillings, y=places, order=st.sampled_from(list(mission.STRATEGIES)))
def test_the_other_team_would_choose_the_same_in_the_mirror(known, y, order):
    choose = mission.STRATEGIES[order]
    mirrored = [filling.translate(SWAP) for filling in known]
    assert choose(known, "red", y) == choose(mirrored, "blue", y)


@given(known=fillings, y=places, soon=st.floats(-5.0, 40.0))
def test_ahead_takes_a_win_that_one_ball_brings(known, y, soon):
    if winner(known):
        return
    wins = [
        k
        for k, filling in enumerate(known)
        if len(filling) < 3 and winner([*known[:k], filling + "R", *known[k + 1 :]]) == "R"
    ]
    if wins:
        assert choose_silo(known, "red", y, Rhythm(next=soon)) in wins


def test_before_the_other_team_comes_ahead_does_not_leave_it_a_third_ball():
    # Two silos are theirs, and a pair of theirs waits for one more: the top must be ours.
    known = ["BBB", "BRB", "BB", "R", ""]
    assert choose_silo(known, "red", 10.0, Rhythm(next=1.0)) == 2


def test_a_pair_is_finished_when_the_other_team_comes_next_and_may_wait_when_it_is_far():
    known = ["RR", "", "", "", ""]
    assert choose_silo(known, "red", 10.0, Rhythm(next=1.0, spread=0.5)) == 0
    assert choose_silo(known, "red", 10.0, Rhythm(next=60.0, period=60.0)) != 0


@pytest.mark.parametrize("order", list(mission.STRATEGIES))
def test_another_team_and_four_silos_are_refused(order):
    choose = mission.STRATEGIES[order]
    with pytest.raises(CourseError, match="team: expected 'red' or 'blue', got 'green'"):
        choose([""] * 5, "green", 10.0)
    with pytest.raises(CourseError, match="fillings: expected 5, one for each silo"):
        choose([""] * 4, "red", 10.0)
    with pytest.raises(CourseError, match="fillings: expected R and B, or empty, got 'RX'"):
        choose(["", "RX", "", "", ""], "red", 10.0)
    assert choose(["RR?", "???", "empty", "BBB", "RRR"], "red", 10.0) == 2, "full is full"


@pytest.mark.parametrize("opponent", ["middling", "strong"])
def test_ahead_wins_more_board_games_at_once_than_both_orders(opponent):
    match = benchmark("match")
    won = match.board_games(range(60), opponent)
    for other in "AB":
        assert match.mcnemar(won["ahead"], won[other]) < 1e-3
    assert match.mcnemar(won["A"], won["ahead"]) > 0.99


def test_mcnemar_s_test_counts_only_games_that_one_of_both_wins():
    match = benchmark("match")
    assert match.mcnemar([True] * 9, [True] * 9) == 1.0
    assert match.mcnemar([True] * 5, [False] * 5) == 2**-5
    assert match.mcnemar([True, False], [False, True]) == 0.75  # a coin: at least one of two


def test_mcnemar_s_test_agrees_with_scipy_s_sign_test():
    from scipy.stats import binomtest

    match, rng = benchmark("match"), np.random.default_rng(3)
    ones, others = rng.random((2, 80)) < [[0.6], [0.5]]
    better, worse = int((ones & ~others).sum()), int((others & ~ones).sum())
    expected = binomtest(better, better + worse, alternative="greater").pvalue
    assert match.mcnemar(ones.tolist(), others.tolist()) == pytest.approx(expected)


# --- rhythm ----------------------------------------------------------------------------------


def test_before_anything_was_seen_the_usual_rhythm_is_expected_from_area_3_on():
    assert rhythm_seen(15.0, 0.0, [], []) == Rhythm(9.0, 17.0, 20.0, 4.0)
    assert rhythm_seen(115.0, 100.0, [], []) == Rhythm(9.0, 17.0, 20.0, 4.0)


@pytest.mark.parametrize("period", [9.0, 13.0, 30.0])
def test_their_first_ball_tells_their_rhythm_and_more_balls_tell_the_same(period):
    for count in (1, 2, 5):
        theirs = [12.0 + period * (k + 1) for k in range(count)]
        told = rhythm_seen(theirs[-1] + 4.0, 0.0, [], theirs)
        assert told.period == pytest.approx(period) and told.next == pytest.approx(period - 4.0)


def test_a_ball_that_nobody_noticed_does_not_make_them_late_for_ever():
    told = rhythm_seen(25.0 + 2.2 * 13.0, 0.0, [], [25.0])
    assert told.next == pytest.approx(-0.2 * 13.0)
    assert rhythm_seen(25.0 + 2.8 * 13.0, 0.0, [], [25.0]).next == pytest.approx(0.2 * 13.0)


def test_our_own_rhythm_goes_by_the_last_balls_and_stays_within_reason():
    assert rhythm_seen(60.0, 0.0, [18.0, 30.0, 42.0], []).every == pytest.approx(10.5)
    assert rhythm_seen(400.0, 0.0, [100.0, 300.0], []).every == 20.0
    assert rhythm_seen(60.0, 0.0, [18.0, 18.1, 18.2, 18.3, 18.4], []).every == 6.0


# --- balls -------------------------------------------------------------------------------------


def anywhere(x, y, heading) -> bool:
    return True


def test_the_ball_straight_ahead_is_come_at_straight():
    way = choose_ball([SeenBall(1.0, 10.0, "red")], "red", (3.0, 10.0, pi), anywhere)
    assert abs(abs(way.heading) - pi) < 1e-9
    assert way.ready == pytest.approx((1.0 + balls.REACH + balls.RUN_UP, 10.0))
    assert way.take == pytest.approx((1.0 + balls.REACH, 10.0))


def test_of_two_own_balls_the_nearer_is_taken_and_another_colour_never():
    seen = [SeenBall(1.0, 10.6, "red"), SeenBall(2.0, 9.6, "red"), SeenBall(2.4, 10.0, "purple")]
    assert choose_ball(seen, "red", (4.0, 10.0, pi), anywhere).ball is seen[1]
    assert choose_ball(seen, "blue", (4.0, 10.0, pi), anywhere) is None
    assert choose_ball([], "red", (4.0, 10.0, pi), anywhere) is None


def test_a_purple_ball_on_the_lane_makes_it_come_from_elsewhere():
    own, other = SeenBall(1.0, 10.0, "red"), SeenBall(1.3, 10.0, "purple")
    way = choose_ball([own, other], "red", (3.0, 10.0, pi), anywhere)
    along = np.array([cos(way.heading), sin(way.heading)])
    off = np.array([other.x - own.x, other.y - own.y])
    ahead, aside = along @ off, abs(along[0] * off[1] - along[1] * off[0])
    assert aside >= balls.LANE or not -(balls.REACH + balls.RUN_UP) < ahead < 0.06


def test_a_ball_ringed_by_others_is_left():
    ring = [
        SeenBall(1.2 + 0.2 * cos(a), 10 + 0.2 * sin(a), "purple") for a in np.arange(0, 6.2, 0.4)
    ]
    assert choose_ball([SeenBall(1.2, 10.0, "red"), *ring], "red", (3, 10, pi), anywhere) is None


def test_in_a_corner_no_approach_fits():
    corner = SeenBall(0.095, 8.095, "red")
    assert choose_ball([corner], "red", (3.0, 10.0, pi), anywhere) is not None
    assert choose_ball([corner], "red", (3.0, 10.0, pi), fits) is None


seen_balls = st.builds(
    SeenBall, st.floats(0.1, 3.0), st.floats(8.1, 11.9), st.sampled_from(["red", "purple"])
)


@given(
    seen=st.lists(seen_balls, max_size=8),
    pose=st.tuples(st.floats(0.6, 5.2), st.floats(8.6, 11.4), st.floats(-pi, pi)),
)
def test_whatever_lies_about_the_chosen_way_is_free_fits_and_is_the_cheapest_of_its_kind(
    seen, pose
):
    way = choose_ball(seen, "red", pose, fits)
    if way is None:
        return
    assert way.ball in seen and way.ball.colour == "red"
    assert fits(*way.ready, way.heading) and fits(*way.take, way.heading)
    c, s = cos(way.heading), sin(way.heading)
    for other in seen:
        if other is not way.ball:
            dx, dy = other.x - way.ball.x, other.y - way.ball.y
            assert abs(c * dy - s * dx) >= balls.LANE or not (
                -(balls.REACH + balls.RUN_UP) < c * dx + s * dy < 0.3 * field.BALL_DIAMETER
            )
    gone = hypot(way.take[0] - way.ball.x, way.take[1] - way.ball.y)
    assert gone == pytest.approx(balls.REACH)


# --- stuck -------------------------------------------------------------------------------------


def watched(poses, ordered=0.5, dt=0.1) -> list[bool]:
    watch, said = Watch(), []
    for k, pose in enumerate(poses):
        watch, stuck = is_stuck(watch, k * dt, np.array([*pose, 0.0]), ordered)
        said.append(stuck)
    return said


def test_who_drives_and_comes_nowhere_is_stuck_after_a_while():
    said = watched([(1.0, 2.0)] * 20)
    assert said.index(True) == 16  # 1.5 s, and one more look
    assert not any(watched([(1.0 + 0.05 * k, 2.0) for k in range(40)]))
    assert not any(watched([(1.0, 2.0)] * 40, ordered=0.05))
    assert not any(watched([(1.0, 2.0)] * 40, ordered=nan))


def test_standing_for_a_moment_in_between_counts_from_anew():
    watch, stuck = Watch(), False
    for k in range(40):
        watch, stuck = is_stuck(watch, 0.1 * k, np.zeros(3), 0.0 if k % 10 == 9 else 0.5)
        assert not stuck


@given(
    pose=st.tuples(*[st.floats(allow_nan=True, allow_infinity=True)] * 3),
    ordered=st.floats(allow_nan=True, allow_infinity=True),
    now=st.floats(allow_nan=True),
)
def test_no_value_stops_the_watch_and_afterwards_it_watches_on(pose, ordered, now):
    watch, _ = is_stuck(Watch(0.0, 1.0, 2.0), now, np.array(pose), ordered)
    later = [0.1 * k for k in range(40)]
    for time in later:
        watch, stuck = is_stuck(watch, time, np.array([3.0, 4.0, 0.0]), 0.5)
    assert stuck
