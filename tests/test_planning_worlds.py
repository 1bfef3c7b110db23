"""Planning's worlds, how its answers are judged, and the pictures of a search."""

from __future__ import annotations

import hashlib
import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from robocon_course import field, planning, view, worlds
from robocon_course.answers.process import AnswerProcess, Reply
from robocon_course.exercises import display, registry
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.model import Outcome
from robocon_course.exercises.planning import search
from robocon_course.exercises.source import Answer
from robocon_course.gridmap import GridMap, inflate_square
from robocon_course.view import searching

STUDENTS = [*range(0, 60, 7), "H1D021001"]
ASTAR = registry.exercise("planning.astar")

# --- worlds -----------------------------------------------------------------------------------


def test_a_students_field_is_the_same_to_the_bit_on_every_machine():
    world = worlds.ways_world(21306141022)
    parts = (world.boxes, world.hidden, world.grid.free, world.fine.free, world.truth.free)
    digest = hashlib.sha256(b"".join(np.asarray(p, "<f8").tobytes() for p in parts)).hexdigest()
    assert digest[:16] == "184e6330dc048fe6"


@pytest.mark.parametrize("student", STUDENTS)
def test_on_every_students_field_there_is_a_way_and_every_slip_changes_it(student):
    world = worlds.ways_world(student)
    lengths = worlds.ways.wrong_lengths(world.grid)
    assert np.isfinite(list(lengths.values())).all()
    assert np.diff(sorted(lengths.values())).min() > 0.01
    room = inflate_square(world.truth, worlds.HALF)
    assert worlds.way_length(room) > lengths["right"] + 0.1, "the hidden boxes matter"


@pytest.mark.parametrize("student", STUDENTS)
def test_boxes_stand_apart_and_leave_ramp_and_goal_free(student):
    world = worlds.ways_world(student)
    for i, (x0, y0, x1, y1) in enumerate(world.boxes):
        for a0, b0, a1, b1 in world.boxes[i + 1 :]:
            assert x1 <= a0 or a1 <= x0 or y1 <= b0 or b1 <= y0
    for point in (world.start, world.goal, worlds.RAMP_TOP):
        assert inflate_square(world.fine, worlds.HALF).is_free(point)


@pytest.mark.parametrize("student", STUDENTS[:4])
def test_the_widest_half_gets_through_and_a_centimetre_more_does_not(student):
    world = worlds.ways_world(student)
    half = worlds.ways.widest_half(world.fine)
    for tried, fits in ((half, True), (half + 0.01, False)):
        length = worlds.way_length(inflate_square(world.fine, tried), worlds.RAMP_TOP)
        assert np.isfinite(length) == fits


def test_a_straight_way_is_driven_as_by_hand():
    # 2 m/s is reached after 1 m and 1 s; then 4 m at 2 m/s, and braking.
    assert worlds.driving_time([[0.0, 0.0], [6.0, 0.0]], 5.0) == pytest.approx(1 + 2 + 1, abs=0.01)
    assert worlds.driving_time([[1.0, 1.0]], 5.0) == 0.0


def test_a_bend_that_is_too_tight_costs_a_stop_and_one_of_the_right_radius_does_not():
    kink = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]]
    alone = worlds.driving_time(kink[:2], 5.0)
    assert worlds.driving_time(kink, 5.0) == pytest.approx(2 * alone, abs=0.1)
    angle = np.linspace(-np.pi / 2, 0.0, 60)
    arc = np.column_stack([2.5 + 0.5 * np.cos(angle), 0.5 + 0.5 * np.sin(angle)])
    assert worlds.driving_time([kink[0], *arc, kink[2]], 5.0) < 2 * alone - 0.5


# --- the exercises ----------------------------------------------------------------------------


@pytest.mark.parametrize("student", STUDENTS)
def test_the_lessons_own_way_to_a_number_is_right_for_every_student(student):
    world = worlds.ways_world(student)
    room = inflate_square(world.grid, worlds.HALF)
    length = planning.astar(room, world.start, world.goal).length

    def passes(half: float) -> bool:
        place = inflate_square(world.fine, half)
        return np.isfinite(worlds.way_length(place, worlds.RAMP_TOP))

    half = max(cm for cm in range(30, 60) if passes(cm / 100)) / 100
    for number, value in ("planning.own_length", length), ("planning.own_gap", half):
        assert judge_number(registry.exercise(number), value, student).accepted


def test_another_shortest_way_is_as_right_as_the_courses():
    grid = GridMap(np.ones((7, 11), dtype=bool), 0.1)
    case = search.way_case("open", grid, *grid.centres([(0, 0), (3, 8)]))
    diagonal_last = [(0, k) for k in range(6)] + [(1, 6), (2, 7), (3, 8)]
    assert case.judge(Reply(value=planning.plan_through(grid, diagonal_last, 9))) is None
    detour = [*diagonal_last[:-1], (3, 7), (3, 8)]
    assert "there is one of" in case.judge(Reply(value=planning.plan_through(grid, detour, 9)))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda plan: plan._replace(length=plan.length + 0.1), "length: expected"),
        (lambda plan: plan._replace(xy=plan.xy + 0.01), "xy: expected the middles"),
        (lambda plan: plan._replace(expanded=-1), "expanded: expected"),
        (lambda plan: plan._replace(expanded=True), "expanded: expected"),
        (lambda plan: plan._replace(cells=plan.cells[:-1]), "a point for each cell"),
        (lambda plan: plan._replace(cells=plan.cells + 0.5), "expected whole numbers"),
        (lambda plan: plan.xy, "shape (9, 2); planning.plan_through(grid, cells, expanded) makes"),
        (lambda plan: None, "returned nothing"),
    ],
)
def test_a_plan_with_a_part_that_is_wrong_is_told_which(change, sentence):
    grid = GridMap(np.ones((7, 11), dtype=bool), 0.1)
    ends = grid.centres([(0, 0), (3, 8)])
    case = search.way_case("open", grid, *ends)
    assert sentence in case.judge(Reply(value=change(planning.astar(grid, *ends))))


def test_the_verdict_tells_how_long_the_way_took_and_the_points_do_not_know():
    quick = judge(ASTAR, ask_function(planning.astar), 7)
    slow = judge(ASTAR, lambda args: replace(ask_function(planning.astar)(args), seconds=33.0), 7)
    assert quick == slow and slow.points == 5
    assert slow.took == "The way over the field took 33.00 s."
    assert slow.took in str(slow) and slow.took in repr(display.shown_verdict(slow))
    assert "took" not in slow.message + slow.line


def test_an_answer_in_a_process_of_its_own_is_timed_from_outside():
    with AnswerProcess() as process:
        process.load("import time\ndef wait():\n    time.sleep(0.2)\n")
        assert 0.2 <= process.call("wait").seconds < 5.0


SOMEWHAT_WRONG = """
import heapq, math
import numpy as np
from robocon_course import planning

def astar(grid, start, goal):
    first, last = (tuple(grid.cells(p).tolist()) for p in (start, goal))
    cost, came, queue = {first: 0.0}, {}, [(0.0, first)] if grid.is_free(start) else []
    while queue:
        _, cell = heapq.heappop(queue)
        if cell == last:
            way = [last]
            while way[-1] in came:
                way.append(came[way[-1]])
            return planning.plan_through(grid, way, len(cost))
        for to, step in planning.neighbours(grid, cell):
            if cost[cell] + step < cost.get(to, math.inf):
                cost[to], came[to] = cost[cell] + step, cell
                heapq.heappush(queue, (cost[to] + planning.octile_distance(to, last), to))
    raise planning.NoPathError("no way", "enclosed")
"""


def test_a_students_own_program_with_a_known_mistake_is_told_by_name_though_its_way_is_another():
    with AnswerProcess() as process:
        verdict = judge_answer(process, ASTAR, Answer("astar", SOMEWHAT_WRONG), 7)
    assert (verdict.outcome, verdict.mistake) == (Outcome.WRONG, "from goal to start")


@pytest.mark.parametrize(
    "line",
    [
        "return planning.astar(grid, start, goal)",
        "return planning.Replanner(goal).plan(grid, start)",
        "return list(planning.anytime_astar(grid, start, goal))[-1].plan",
        "return planning.travel(grid, start, goal, reach=99.0).legs[0].plan",
    ],
)
def test_the_courses_own_search_is_no_answer(line):
    text = f"from robocon_course import planning\ndef astar(grid, start, goal):\n    {line}\n"
    with AnswerProcess() as process:
        verdict = judge_answer(process, ASTAR, Answer("astar", text), 7)
    assert verdict.points == 0.0 and "the course's own" in verdict.message


SHORTER = {
    "octile_distance": (
        "grid = GridMap(np.ones((200, 200), dtype=bool), 1.0)",
        "ends = grid.centres(cell), grid.centres(goal)",
        "return {}.length",
    ),
    "neighbours": (
        "row, col = cell",
        "found, ends = [], (grid.centres(cell), grid.centres((row, col + 1)))",
        "return [((row, col + 1), {}.length / grid.resolution)]",
    ),
}


@pytest.mark.parametrize("name", SHORTER)
@pytest.mark.parametrize(
    "call",
    [
        "planning.astar(grid, *ends)",
        "next(planning.anytime_astar(grid, *ends)).plan",
        "planning.Replanner(ends[1]).plan(grid, ends[0])",
    ],
)
def test_the_courses_search_is_no_answer_to_its_smaller_parts(name, call):
    args = "cell, goal" if name == "octile_distance" else "grid, cell"
    lines = [line.format(call) for line in SHORTER[name]]
    head = ["import numpy as np", "from robocon_course import planning"]
    head += ["from robocon_course.gridmap import GridMap", f"def {name}({args}):"]
    text = "\n    ".join(["\n".join(head), *lines]) + "\n"
    with AnswerProcess() as process:
        exercise = registry.exercise(f"planning.{name}")
        verdict = judge_answer(process, exercise, Answer(name, text), 7)
    assert verdict.points == 0.0 and "the course's own" in verdict.message


@pytest.mark.parametrize(
    "name",
    ["inflate_square", "neighbours", "astar", "thin_path", "shorten_path", "smooth_path"],
)
def test_nothing_is_asked_whether_a_return_is_missing(name):
    verdict = judge(registry.exercise(f"planning.{name}"), lambda args: Reply(value=None), 7)
    assert "nothing (None); is a return missing?" in verdict.message


def test_steps_that_are_yet_to_be_made_are_called_what_they_are():
    text = "from robocon_course import planning\ndef neighbours(grid, cell):\n    yield cell, 1.0\n"
    exercise = registry.exercise("planning.neighbours")
    with AnswerProcess() as process:
        verdict = judge_answer(process, exercise, Answer("neighbours", text), 7)
    assert "expected a list" in verdict.message and "got a generator" in verdict.message


@pytest.mark.parametrize("name", ["shorten_path", "smooth_path"])
@pytest.mark.parametrize("kind", [tuple, list])
def test_points_may_come_as_a_tuple_or_a_list(name, kind):
    exercise = registry.exercise(f"planning.{name}")

    def function(*args):
        return kind(kind(point) for point in exercise.reference(*args).tolist())

    assert judge(exercise, ask_function(function), 7).points == exercise.points


def test_a_cell_that_is_wrongly_free_is_named():
    exercise = registry.exercise("planning.inflate_square")
    unchanged = judge(exercise, ask_function(lambda grid, half: grid), 7)
    assert "cell (0, 0) should not be free, and is." in unchanged.message
    whole = judge(
        exercise, ask_function(lambda grid, half: inflate_square(grid, half + grid.resolution)), 7
    )
    assert "cell (2, 6) should be free, and is not." in whole.message


def test_a_way_that_could_be_shorter_is_told_by_how_much():
    case = registry.exercise("planning.shorten_path").cases(7, worlds.generator(7, "short"))[0]
    sentence = case.judge(Reply(value=case.args[1]))
    assert "your way is 1.883 m long" in sentence and "gives at most 1.826 m" in sentence


@pytest.mark.parametrize("student", STUDENTS[:4])
def test_half_a_centimetre_too_much_is_not_taken_for_a_whole_one(student):
    number = registry.exercise("planning.own_gap")
    half = number.truth(student)
    assert judge_number(number, half + 0.005, student).mistake == ""
    assert judge_number(number, half + 0.01, student).mistake == "first that fails"


def test_the_rooms_of_the_course_do_not_offer_the_answers_to_the_numbers():
    assert not hasattr(worlds, "widest_half") and not hasattr(worlds, "wrong_lengths")


def test_better_than_the_course_is_nothing_missed():
    exercise = registry.exercise("planning.smooth_path")
    case = exercise.cases(7, worlds.generator(7, exercise.id, "public"))[0]
    first, best = case.truth
    slower = replace(case, truth=(first, best + 0.1))
    assert exercise.score.error(slower, planning.smooth_path(*case.args)) == 0.0


def test_a_half_smooth_way_earns_half():
    exercise = registry.exercise("planning.smooth_path")
    for case in exercise.cases(7, worlds.generator(7, exercise.id, "public")):
        assert exercise.score.error(case, case.args[1]) == pytest.approx(100.0)
        assert exercise.score.error(case, planning.smooth_path(*case.args)) == pytest.approx(0.0)
    assert [exercise.score.share(e) for e in (-5.0, 39.9, 84.9, 86.0)] == [1.0, 1.0, 0.5, 0.0]


# --- through the unknown ----------------------------------------------------------------------


@pytest.mark.parametrize("planner", ["mended", "from nothing"])
@pytest.mark.parametrize("student", STUDENTS[:2])
def test_ten_of_ten_journeys_of_a_square_body_arrive_and_touch_nothing(student, planner):
    known = field.obstacle_map(0.05)

    def room(grid: GridMap) -> GridMap:
        return inflate_square(grid, worlds.HALF)

    for k in range(10):
        truth = worlds.passable_field(worlds.generator(student, "journeys", str(k)))
        run = planning.travel(
            truth,
            field.START,
            field.AREA_3_GOAL,
            reach=1.5,
            known=known,
            room=room,
            planner=None
            if planner == "mended"
            else lambda seen, xy: planning.astar(room(seen), xy, field.AREA_3_GOAL),
        )
        assert truth.cells(run.xy[-1]).tolist() == truth.cells(field.AREA_3_GOAL).tolist()
        assert truth.is_free(run.xy).all()
        assert room(truth).is_free(run.xy).all()


# --- pictures ---------------------------------------------------------------------------------


@pytest.fixture
def small() -> tuple[GridMap, planning.Plan]:
    """A map on the field, and a search through it."""
    grid = worlds.boxed_field([(1.0, 1.2, 2.0, 1.6)])
    return grid, planning.astar(grid, (0.55, 0.35), (3.0, 2.5), watch=True)


def test_early_cells_are_pale_and_late_ones_dark(small):
    grid, plan = small
    layer = searching._layer(grid, None, plan)
    first, last = (np.argwhere(plan.order == k)[0] for k in (1, plan.order.max()))
    assert layer[tuple(first)][:3].sum() > layer[tuple(last)][:3].sum()
    assert (layer[~grid.free] == searching.BLOCKED).all()
    assert (layer[(plan.order == 0) & grid.free] == 0).all()


def test_the_animation_of_a_search_grows_and_ends_with_the_way(small):
    grid, plan = small
    moving = view.animate_search(grid, plan, window=(0.0, 4.0, 0.0, 3.0), frames=8)
    assert len(moving.gif) < 300_000
    gif = Image.open(io.BytesIO(moving.gif))
    still = []
    for k in range(gif.n_frames):
        gif.seek(k)
        still.append(np.asarray(gif.convert("RGB")).astype(int))
    changed = [int((np.abs(s - still[0]).max(axis=-1) > 12).sum()) for s in still]
    assert changed[0] == 0 and (np.diff(changed) >= 0).all() and changed[-1] > 10_000
    green = np.array([0x00, 0x9E, 0x73])
    assert (np.abs(still[-1] - green).max(axis=-1) < 12).any()
    assert not (np.abs(still[1] - green).max(axis=-1) < 12).any()


def test_ways_off_the_field_are_drawn_on_white(small):
    grid = GridMap(np.ones((6, 9), dtype=bool), 0.1)
    fig = view.draw_ways(
        grid, {"mine": [[0.05, 0.05], [0.8, 0.5]]}, window=None, markers={"a": (0.1, 0.1)}
    )
    ax = fig.axes[0]
    assert ax.get_xlim() == pytest.approx((0.0, 0.9)) and ax.get_ylim() == pytest.approx((0.0, 0.6))
    assert len(view.png(fig)) > 1000


def test_a_plan_that_does_not_know_its_order_is_refused(small):
    grid, _ = small
    plan = planning.astar(grid, (0.55, 0.35), (3.0, 2.5))
    with pytest.raises(ValueError, match="watch=True"):
        view.draw_ways(grid, plan=plan)
