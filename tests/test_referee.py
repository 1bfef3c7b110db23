"""Points, Mua Vang, the end of a match, and the other team's plan."""

from __future__ import annotations

from itertools import combinations_with_replacement, product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course import mission
from robocon_course._arrays import CourseError
from robocon_course.simulator.referee import (
    MATCH,
    MUA_VANG,
    OPPONENTS,
    SEEDLING,
    STORED,
    TRANSFER,
    Event,
    Opponent,
    Referee,
    plan,
)

FILLINGS = ["".join(balls) for k in range(4) for balls in product("RB", repeat=k)]


def full_of_three(fillings, letter) -> bool:
    """The rule, spelled out: three silos, each full, two own balls or more, an own one on top."""
    good = 0
    for filling in fillings:
        if len(filling) == 3:
            first, second, top = filling
            good += top == letter and letter in (first, second)
    return good >= 3


def test_points_are_those_of_the_rules():
    assert (SEEDLING, TRANSFER, STORED, MATCH) == (10, 10, 30, 180.0)
    referee = Referee("R")
    referee.give(5.0, "own", "seedling")
    referee.give(12.0, "theirs", "transfer")
    assert referee.store(20.0, "own", 2) and referee.store(21.0, "theirs", 2)
    assert referee.points == {"own": 40, "theirs": 40} and referee.fillings[2] == "RB"
    assert referee.events[0] == Event(5.0, "seedling", "own", "")
    assert referee.count("stored") == referee.count("stored", "theirs") == 1


def test_a_ball_into_a_full_silo_rolls_away_and_scores_nothing():
    referee = Referee("B")
    for time in range(3):
        referee.store(time, "own", 0)
    assert not referee.store(4.0, "own", 0)
    assert referee.points["own"] == 90 and referee.fillings[0] == "BBB"
    assert referee.events[-1] == Event(4.0, "lost ball", "own", "silo 1 was full")


def test_mua_vang_is_exactly_the_rule_whatever_the_silos_hold():
    seen = {True: 0, False: 0}
    for fillings in combinations_with_replacement(FILLINGS, 5):  # places do not matter
        if len(fillings[0]) == 3 or any(full_of_three(fillings, letter) for letter in "RB"):
            continue
        for team, letter in (("own", "R"), ("theirs", "B")):
            referee = Referee("R")
            referee.fillings = list(fillings)
            referee.store(30.0, team, 0)
            expected = full_of_three((fillings[0] + letter, *fillings[1:]), letter)
            assert (referee.winner == team) == expected, fillings
            seen[expected] += 1
    assert seen[True] > 100 and seen[False] > 1000


def test_the_robot_knows_the_rule_that_the_referee_plays_by():
    for fillings in combinations_with_replacement(FILLINGS, 5):
        if full_of_three(fillings, "R"):
            assert mission.winner(fillings) == "R"
        elif full_of_three(fillings, "B"):
            assert mission.winner(fillings) == "B"
        else:
            assert mission.winner(fillings) is None


@given(
    moves=st.lists(st.tuples(st.sampled_from(["own", "theirs"]), st.integers(0, 4)), max_size=30)
)
def test_whoever_first_has_three_silos_wins_then_and_nothing_changes_it(moves):
    referee, first = Referee("B"), None
    for time, (team, silo) in enumerate(moves):
        referee.store(float(time), team, silo)
        for who, letter in (("own", "B"), ("theirs", "R")):
            if first is None and full_of_three(referee.fillings, letter):
                first = (float(time), who)
    if first is None:
        assert referee.winner == ""
    else:
        assert (referee.ended, referee.winner, referee.reason) == (*first, MUA_VANG)
    referee.time_is_up(MATCH)
    assert first is None or (referee.ended, referee.winner) == first
    balls = sum(map(len, referee.fillings))
    assert sum(referee.points.values()) == STORED * balls


def test_after_mua_vang_nothing_changes_who_won():
    referee = Referee("B")
    for time, silo in enumerate([0] * 3 + [1] * 3 + [2] * 3):
        assert referee.winner == ""
        referee.store(float(time), "own", silo)
    for silo in (3, 3, 3, 4, 4, 4):
        referee.store(9.0, "theirs", silo)
    referee.points["theirs"] += 1000
    referee.time_is_up(MATCH)
    assert (referee.winner, referee.reason, referee.ended) == ("own", MUA_VANG, 8.0)


@pytest.mark.parametrize(
    ("own", "theirs", "winner"), [(2, 1, "own"), (1, 2, "theirs"), (1, 1, "nobody")]
)
def test_when_time_is_up_points_decide(own, theirs, winner):
    referee = Referee("R")
    for k in range(own):
        referee.store(1.0, "own", k)
    for k in range(theirs):
        referee.store(2.0, "theirs", k)
    referee.time_is_up(MATCH)
    assert (referee.winner, referee.reason, referee.ended) == (winner, "points", MATCH)


@pytest.mark.parametrize(
    ("own", "theirs", "winner"),
    [
        ({"stored": 1}, {"transfer": 3}, "own"),
        ({"transfer": 3}, {"stored": 1}, "theirs"),
        ({"seedling": 2}, {"transfer": 2}, "theirs"),
        ({"transfer": 1, "seedling": 1}, {"seedling": 2}, "own"),
        ({"stored": 1, "seedling": 1}, {"stored": 1, "seedling": 1}, "nobody"),
    ],
)
def test_of_equal_points_silos_count_first_then_balls_that_were_sent(own, theirs, winner):
    referee = Referee("R")
    for team, deeds in (("own", own), ("theirs", theirs)):
        for what, count in deeds.items():
            for _ in range(count):
                done = referee.store(1.0, team, 0) if what == "stored" else None
                assert done is not False
                if what != "stored":
                    referee.give(1.0, team, what)
    assert referee.points["own"] == referee.points["theirs"] > 0
    referee.time_is_up(MATCH)
    assert (referee.winner, referee.reason) == (winner, "points")


@pytest.mark.parametrize(
    ("deed", "sentence"),
    [
        (lambda: Referee("G"), "letter: expected one of R, B, got 'G'"),
        (lambda: Referee("R").store(1.0, "red", 0), "team: expected one of own, theirs, got 'red'"),
        (lambda: Referee("R").store(1.0, "own", -1), "silo: expected one of 0, 1, 2, 3, 4, got -1"),
        (lambda: Referee("R").give(1.0, "own", "stored"), "what: expected one of transfer, see"),
        (lambda: Referee("R").give(1.0, "we", "transfer"), "team: expected one of own, theirs"),
    ],
)
def test_what_no_rule_knows_is_refused(deed, sentence):
    with pytest.raises(CourseError, match=sentence):
        deed()


def test_what_is_refused_changes_nothing():
    referee = Referee("R")
    with pytest.raises(CourseError):
        referee.store(1.0, "we", 0)
    assert referee == Referee("R")


def test_two_referees_share_nothing():
    one, other = Referee("R"), Referee("R")
    one.store(1.0, "own", 0)
    assert other.fillings == [""] * 5 and other.points["own"] == 0 and not other.events


# --- the other team ----------------------------------------------------------------------------


def planned(seed: int, name: str):
    return plan(np.random.default_rng(seed), OPPONENTS[name])


@pytest.mark.parametrize("name", OPPONENTS)
def test_the_same_seed_is_the_same_plan_and_another_seed_another(name):
    assert planned(4, name) == planned(4, name) != planned(5, name)


@pytest.mark.parametrize("name", OPPONENTS)
def test_they_come_in_order_at_their_own_pace_within_the_match_and_have_twelve_balls(name):
    team = OPPONENTS[name]
    plans = [planned(seed, name) for seed in range(200)]
    for one in plans:
        times = np.array([time for time, _ in one])
        assert len(one) <= 12 and (np.diff(times) >= 5.0).all() and times[-1] < MATCH
    firsts = np.array([one[0][0] for one in plans])
    gaps = np.concatenate([np.diff([time for time, _ in one]) for one in plans])
    # Means of 200 and of more draws lie within four of their own spreads.
    assert abs(firsts.mean() - team.first) < 4 * team.spread / np.sqrt(200)
    # Gaps that reach beyond the end do not count: the mean is a little less.
    assert -1.0 < gaps.mean() - team.every < 4 * team.spread / np.sqrt(len(gaps))
    falls_in = np.mean([good for one in plans for _, good in one])
    assert abs(1 - falls_in - team.failing) < 4 * np.sqrt(team.failing / len(gaps))


def test_no_team_stores_two_balls_within_five_seconds():
    hasty = Opponent(10.0, 3.0, 4.0, 0.0)
    gaps = [np.diff([at for at, _ in plan(np.random.default_rng(k), hasty)]) for k in range(20)]
    assert np.concatenate(gaps).min() == pytest.approx(5.0)
    assert np.concatenate(gaps).max() > 6.0


def test_a_stronger_team_comes_sooner_and_more_often():
    weak, middling, strong = (
        np.mean([len(planned(seed, name)) for seed in range(50)]) for name in OPPONENTS
    )
    assert list(OPPONENTS) == ["weak", "middling", "strong"] and weak < middling < strong
