"""Boards, balls, listings and board games of chapter 07, and answers in other styles."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, permutations
from math import pi

import numpy as np
import pytest
from matplotlib.patches import FancyArrowPatch

from robocon_course import mission, view, worlds
from robocon_course._arrays import CourseError
from robocon_course.answers import wire
from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry
from robocon_course.exercises.compare import difference
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.model import Outcome
from robocon_course.exercises.source import Answer
from robocon_course.mission import Fact, Facts, Room
from robocon_course.simulator.match import Fault
from robocon_course.view import lanes
from robocon_course.view import missions as drawn
from robocon_course.worlds import missions

STUDENTS = [*range(0, 60, 7), "H1D021001"]
STRATEGY = registry.exercise("mission.my_strategy")

# --- guards and rooms as data ---------------------------------------------------------------------


def test_a_guard_as_data_asks_one_fact():
    assert Fact("ball")(Facts(ball=True)) and not Fact("ball")(Facts())
    assert Fact("ball", False)(Facts()) and not Fact("ball", False)(Facts(ball=True))


def test_a_turned_square_needs_more_room():
    room = Room(0.0, 1.0, 0.0, 1.0, 0.8)
    assert room(0.5, 0.5, 0.0) and room(0.5, 0.5, pi / 2) and not room(0.5, 0.5, pi / 4)
    assert room(0.4, 0.4, 0.0) and not room(0.39, 0.5, 0.0) and not room(0.5, 0.61, 0.0)


def test_guards_rooms_and_sets_travel_to_an_answer_and_back():
    for value in (Fact("ball", False), missions.STORAGE, {"a", "b"}, set(), frozenset({1, 2})):
        assert wire.loads(wire.dumps(value)) == value
    with pytest.raises(ValueError, match="not plain data"):
        wire.loads(b'{"set": [{"list": []}]}\n')


def test_two_sets_differ_by_what_is_missing_or_too_much():
    assert difference({"a", "b"}, {"b", "a"}, 0.0) is None
    assert difference({"a"}, {"a", "b", "c"}, 0.0) == "'b', 'c' are missing"
    assert difference({"a", "d"}, {"a"}, 0.0) == "'d' is too much"
    assert difference(["a"], {"a"}, 0.0) == "expected a set, got a list of 1"


# --- the printed listing --------------------------------------------------------------------------


def test_as_printed_the_mission_ends_after_the_first_push():
    states = mission.reachable(missions.PRINTED, "start reset")
    assert states - set(missions.PRINTED_CASES) == {"reverse after push"}
    assert len(missions.PRINTED_CASES) == 16 and len(states) == 6
    never = {source for source, _ in missions.PRINTED} - {target for _, target in missions.PRINTED}
    assert never == {"start reset", "detect ball", "odometry reset after silo", "stuck"}


@pytest.mark.parametrize("student", STUDENTS)
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    own = missions.own_listing(student)
    assert len(own) == 15 and set(missions.PRINTED_CASES) >= {s for edge in own for s in edge}
    # As somebody does it by hand: go on from each state until the goal, or until nothing is new.
    count = 0
    for state in missions.PRINTED_CASES:
        here, ways = state, dict(own)
        for _ in range(20):
            here = ways.get(here, here) if here != "back to storage" else here
        count += here != "back to storage"
    assert judge_number(registry.exercise("mission.own_dead_ends"), count, student).accepted


def test_students_have_different_copies():
    assert len({frozenset(missions.own_listing(s)) for s in range(40)}) == len(missions.CUTS)


# --- boards and balls -----------------------------------------------------------------------------


def test_a_board_holds_no_more_than_fits():
    rng = np.random.default_rng(1)
    boards = [missions.some_board(rng) for _ in range(200)]
    assert all(len(b) == 5 and max(map(len, b)) <= 3 for b in boards)
    assert 1 <= min(len("".join(b)) for b in boards) and max(len("".join(b)) for b in boards) <= 9


def test_balls_do_not_lie_in_one_another():
    balls = missions.some_balls(np.random.default_rng(2), 14)
    gaps = [
        np.hypot(a.x - b.x, a.y - b.y) for k, a in enumerate(balls) for b in balls[:k]
    ]  # fmt: skip
    assert len(balls) == 14 and min(gaps) > 0.19


# --- board games ----------------------------------------------------------------------------------


def test_a_board_game_is_the_same_on_every_machine_and_times_rise():
    game = missions.board_game(worlds.generator(21306141022, "game"), "strong")
    again = missions.board_game(worlds.generator(21306141022, "game"), "strong")
    assert game == again
    for times in (game.ours, game.theirs):
        assert (np.diff(times) > 4.9).all() and len(times) <= 12 and times[-1] < 180.0


def test_a_game_by_hand_three_own_silos_win_at_once():
    game = missions.BoardGame(tuple(10.0 * k for k in range(1, 13)), (), 20.0, 1.0)
    plan = iter([0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3])
    end = missions.play_board(game, lambda *_: next(plan))
    assert (end.winner, end.reason, end.ended) == ("own", "Mua Vang", 90.0)
    assert end.fillings == ("RRR", "RRR", "RRR", "", "") and end.points == 270


def test_the_other_team_plays_order_b_and_a_ball_on_a_full_silo_is_lost():
    game = missions.BoardGame((1.0, 2.0, 3.0, 4.0), (5.0,), 20.0, 1.0)
    end = missions.play_board(game, lambda *_: 4)
    assert end.fillings.count("RRR") == 1 and end.points == 90 and end.choices == (4,) * 4
    assert end.their_points == 30 and end.fillings[mission.order_b(["", "", "", "", "RRR"],
                                                                 "blue", 10.0)] == "B"  # fmt: skip


def test_a_strategy_is_told_nothing_of_what_is_to_come():
    game = missions.board_game(np.random.default_rng(3), "strong")
    later = game._replace(theirs=(*game.theirs[:4], *(t + 3.0 for t in game.theirs[4:])))
    for now in game.ours:
        if now < game.theirs[4]:
            assert missions.rhythm_of(game, now) == missions.rhythm_of(later, now)


@pytest.mark.parametrize("chosen", [5, -1, 0.5, None, True, "2", [1]])
def test_what_is_no_silo_is_refused(chosen):
    game = missions.board_game(np.random.default_rng(4), "weak")
    with pytest.raises(ValueError, match="expected the index of a silo, 0 to 4"):
        missions.play_board(game, lambda *_: chosen)


def test_an_unknown_opponent_is_refused():
    with pytest.raises(CourseError, match="opponent: expected one of weak, middling, strong"):
        missions.board_game(np.random.default_rng(5), "mighty")


def test_looking_ahead_wins_more_by_mua_vang_than_order_a():
    rng = np.random.default_rng(6)
    games = [missions.board_game(rng, "strong") for _ in range(60)]
    ahead, order = (
        missions.tally(missions.board_season(choose, games))
        for choose in (mission.choose_silo, mission.order_a)
    )
    assert ahead.mua_vang > 2 * order.mua_vang and ahead.score > order.score + 5
    assert ahead.mua_vang + ahead.won + ahead.lost <= 60


# --- the challenge --------------------------------------------------------------------------------


def test_order_a_earns_part_of_the_challenge_and_the_look_ahead_all():
    for student in range(3):
        assert judge(STRATEGY, ask_function(mission.choose_silo), student).points == 4.0
        order = judge(STRATEGY, ask_function(mission.order_a), student)
        assert 0.0 < order.points < 4.0 and order.mistake == "order A"


def test_who_fails_in_the_middle_of_a_game_is_told_what_happened():
    def failing(fillings, team, y, rhythm):
        if "RB" in fillings:
            raise KeyError("RB")
        return mission.order_a(fillings, team, y)

    verdict = judge(STRATEGY, ask_function(failing))
    assert verdict.points == 0.0 and "KeyError" in verdict.message
    none = judge(STRATEGY, ask_function(lambda *_: 7))
    assert none.points == 0.0 and "expected the index of a silo" in none.message


def test_a_strategy_that_calls_the_courses_own_is_no_answer():
    text = (
        "from robocon_course import mission\ndef my_strategy(fillings, team, y, rhythm):\n"
        "    return mission.STRATEGIES['ahead'](fillings, team, y, rhythm)\n"
    )
    with AnswerProcess() as process:
        verdict = judge_answer(process, STRATEGY, Answer("my_strategy", text), 0)
    assert verdict.points == 0.0 and "the course's own" in verdict.message


# --- the first balls of a match -------------------------------------------------------------------


def test_a_lost_ball_costs_time_and_the_mission_goes_on():
    usual = missions.opening(0, 7, balls=3)
    dropped = missions.opening(0, 7, balls=3, faults=[Fault("drop", 15.0)])
    assert usual.stored == dropped.stored == 3
    assert dropped.ended > usual.ended
    assert any(event.what == "fault" for event in dropped.events)
    assert usual.history[0][1] == "go_to_area_3"


# --- pictures -------------------------------------------------------------------------------------

HISTORY = [(0.0, "go_to_area_3", "start"), (9.0, "take_ball", "seen"), (12.0, "juggle", "fun")]
PICTURES = {
    "states": lambda: drawn.draw_states(
        missions.PRINTED, start="start reset", dead=["reverse after push"], unreached=["stuck"],
        live="take ball",
    ),
    "histories": lambda: drawn.plot_histories(
        {"one": HISTORY, "two": HISTORY[:2]}, {"one": 20.0, "two": 15.0}, marks={"here": 5.0}
    ),
    "silos": lambda: drawn.draw_silos({"a": ("", "R", "RB", "BBR", "RRR"), "b": ("",) * 5}),
    "match": lambda: drawn.draw_match([(0.5, 0.5, 0.0), (4.3, 9.0, 1.0)], ["reset", "take_ball"]),
    "choice": lambda: drawn.draw_choice(
        balls := missions.some_balls(np.random.default_rng(5), 9), (3.6, 10.0, pi),
        mission.choose_ball(balls, "red", (3.6, 10.0, pi), missions.STORAGE),
    ),
    "no choice": lambda: drawn.draw_choice([], (3.6, 10.0, pi), None),
}  # fmt: skip


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_of_the_mission_is_drawn(name):
    assert view.png(PICTURES[name]())[:4] == b"\x89PNG"


def test_a_diagram_shows_every_state_once():
    fig = drawn.draw_states(missions.PRINTED, start="start reset")
    names = [text.get_text().replace("\n", " ") for text in fig.axes[0].texts]
    assert sorted(names) == sorted({state for edge in missions.PRINTED for state in edge})


def test_the_more_often_a_jump_the_thicker_its_arrow():
    fig = drawn.draw_states({("a", "b"): 1, ("b", "a"): 7}, start="a")
    once, often = (p.get_linewidth() for p in fig.axes[0].patches if isinstance(p, FancyArrowPatch))
    assert 0 < once < often


GRID = [(column, row) for column in range(4) for row in range(5)]


def inside(points: np.ndarray, place: tuple[int, int]) -> np.ndarray:
    """Which points lie within a box, its rim left out."""
    away = np.abs(points - lanes.middle(place))
    return (away < (lanes.WIDE / 2 - 1e-9, lanes.TALL / 2 - 1e-9)).all(axis=1)


def test_no_arrow_crosses_a_box_and_each_ends_at_its_own():
    used = Counter()  # as in one crowded figure
    for source, target in permutations(GRID, 2):
        way = np.array(lanes._way(source, target, used))
        share = np.linspace(0.0, 1.0, 41)[:, None]
        points = np.vstack([one + share * (other - one) for one, other in pairwise(way)])
        assert not any(inside(points, place).any() for place in GRID), (source, target)
        for end, place in ((way[0], source), (way[-1], target)):
            away = np.abs(end - lanes.middle(place)) - (lanes.WIDE / 2, lanes.TALL / 2)
            assert away.max() == pytest.approx(0.0, abs=1e-9), (source, target)


def test_an_arrow_from_a_box_to_itself_is_refused():
    with pytest.raises(ValueError, match="expected two boxes"):
        drawn.draw_states([("a", "a")], start="a")


# --- other ways to say the same -------------------------------------------------------------------

OTHER_STYLES = {
    "mission.next_transition": """
def next_transition(rows, state, facts):
    return next((r for r in rows if r.source == state and r.guard(facts)), None)
""",
    "mission.reachable": """
def reachable(edges, start):
    found, before = {start}, set()
    while found != before:
        before = set(found)
        found |= {b for a, b in edges if a in before}
    return frozenset(found)
""",
    "mission.dead_ends": """
def dead_ends(edges, states, ends):
    def lives(state, seen):
        if state in ends:
            return True
        return any(lives(b, seen | {b}) for a, b in edges if a == state and b not in seen)
    return {state for state in states if not lives(state, {state})}
""",
    "mission.is_stuck": """
import math
from robocon_course.mission import Watch
def is_stuck(watch, now, pose, ordered):
    if math.isnan(ordered) or ordered <= 0.1:
        return Watch(x=watch.x, y=watch.y), False
    moved = math.dist(pose[:2], (watch.x, watch.y))
    if math.isinf(watch.since) or math.isnan(moved) or moved > 0.03:
        return Watch(float(now), pose[0], pose[1]), False
    return watch, watch.since + 1.5 < now
""",
    "mission.choose_ball": """
import math
from robocon_course import mission
def choose_ball(balls, team, pose, fits):
    ways = []
    for ball in [b for b in balls if b.colour == team]:
        first = math.atan2(ball.y - pose[1], ball.x - pose[0])
        ways += [mission.approach_from(ball, first - k * math.pi / 16) for k in range(32)]
    def price(w):
        turn = abs(math.remainder(w.heading - pose[2], 2 * math.pi))
        return math.dist(w.ready, pose[:2]) + 0.25 * turn
    for way in sorted(ways, key=price):
        if mission.is_clear(way, balls):
            if all(fits(*place, way.heading) for place in (way.ready, way.take)):
                return way
""",
    "mission.choose_silo": """
from robocon_course import field
def choose_silo(fillings, team, y, rhythm):
    mine = team[0].upper()
    order = ["10", "11", "00", "", "1", "0"]
    best = None
    for k, filling in enumerate(fillings):
        kind = "".join(sorted(("1" if c == mine else "0" for c in filling), reverse=True))
        if kind not in order:
            continue
        key = (order.index(kind), abs(field.SILOS[k][1] - y), k)
        if best is None or key < best:
            best = key
    return best and best[2]
""",
}


@pytest.mark.parametrize("exercise_id", OTHER_STYLES)
def test_a_right_answer_in_another_style_earns_all_points(exercise_id):
    exercise = registry.exercise(exercise_id)
    with AnswerProcess() as process:
        for student in (0, 7, 12):
            answer = Answer(exercise.function_name, OTHER_STYLES[exercise_id])
            verdict = judge_answer(process, exercise, answer, student)
            assert verdict.outcome is Outcome.PASSED, verdict.message
