"""Chapter 04: A*, its estimates and weights, and what is made of a way afterwards."""

from __future__ import annotations

import tracemalloc
from heapq import heappop, heappush
from itertools import pairwise
from math import hypot, inf, nan, sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.ndimage import minimum_filter

from robocon_course import field
from robocon_course.gridmap import GridMap, inflate, load_map, save_map
from robocon_course.planning import (
    NoPathError,
    anytime_astar,
    astar,
    line_of_sight,
    moves,
    nearest_free,
    neighbours,
    octile_distance,
    path_curvature,
    path_length,
    plan_through,
    resample_path,
    search,
    shorten_path,
    smooth_path,
    thin_path,
)

ROOT2 = sqrt(2.0)
START, GOAL = (0.55, 0.35), (4.30, 10.00)  # on the game field, as the thesis plans
RADIUS = 0.325


def drawn(picture: str, resolution: float = 1.0) -> GridMap:
    """A map from a drawing: its top line is the largest y, '#' is an obstacle."""
    lines = picture.split()
    return GridMap(np.array([[c != "#" for c in line] for line in lines])[::-1], resolution)


def naive_length(free: np.ndarray, start, goal, cut_corners: bool = False) -> float:
    """Dijkstra's search with a dictionary: length of the shortest way [cells], or infinity."""

    def is_free(row: int, col: int) -> bool:
        return 0 <= row < free.shape[0] and 0 <= col < free.shape[1] and bool(free[row, col])

    start, goal = tuple(start), tuple(goal)
    length, queue = {start: 0.0}, [(0.0, start)]
    while queue:
        so_far, (row, col) = heappop(queue)
        if (row, col) == goal:
            return so_far
        for dr in (-1, 0, 1):
            for dc in (-1, 0, 1):
                to = row + dr, col + dc
                beside = is_free(row + dr, col) and is_free(row, col + dc)
                if to == (row, col) or not is_free(*to) or not (beside or cut_corners):
                    continue
                new = so_far + hypot(dr, dc)
                if new < length.get(to, inf) - 1e-9:
                    length[to] = new
                    heappush(queue, (new, to))
    return inf


def assert_is_a_way(plan, grid: GridMap, cut_corners: bool = False) -> None:
    """Steps to neighbours, in free cells, past no corner, and as long as it says."""
    steps = np.diff(plan.cells, axis=0)
    assert (np.abs(steps).max(axis=1, initial=0) == 1).all() or len(steps) == 0
    assert grid.free[tuple(plan.cells.T)].all()
    if not cut_corners:
        (row, col), (to_row, to_col) = plan.cells[:-1].T, plan.cells[1:].T
        assert grid.free[row, to_col].all() and grid.free[to_row, col].all()
    assert plan.length == pytest.approx(path_length(plan.xy), abs=1e-9)


def serpentine(side: int) -> np.ndarray:
    """A corridor to and fro, one cell wide: the longest way there can be."""
    free = np.ones((side, side), dtype=bool)
    free[1::2] = False
    free[1::4, 0] = free[3::4, -1] = True
    return free


bitmaps = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=12))


@st.composite
def tasks(draw):
    """A map with two free cells on it, not always joined."""
    free = draw(bitmaps)
    cells = np.argwhere(free)
    assume(len(cells))
    start, goal = (cells[draw(st.integers(0, len(cells) - 1))] for _ in range(2))
    return free, start, goal


# --- the shortest way -------------------------------------------------------------------------


def test_astar_goes_round_a_wall_as_by_hand():
    grid = drawn("....... ...#... ...#... ...#... .......")
    plan = astar(grid, [1.5, 2.5], [5.5, 2.5])
    # A diagonal step, then straight up to the end of the wall; over it; and the same downwards.
    assert plan.length == pytest.approx(2 * ROOT2 + 4)
    assert plan.cells[[0, -1]].tolist() == [[2, 1], [2, 5]]
    assert_is_a_way(plan, grid)


def test_a_corner_is_cut_only_if_that_is_allowed():
    grid = drawn("..# ... #..")
    assert astar(grid, [0.5, 1.5], [1.5, 2.5]).length == pytest.approx(ROOT2)
    grid = drawn(".# #.")
    assert astar(grid, [0.5, 1.5], [1.5, 0.5], cut_corners=True).length == pytest.approx(ROOT2)
    with pytest.raises(NoPathError, match="no way leads"):
        astar(grid, [0.5, 1.5], [1.5, 0.5])
    grid = drawn(".. #.")
    assert astar(grid, [0.5, 1.5], [1.5, 0.5]).length == pytest.approx(2.0)


@settings(deadline=None, max_examples=500)
@given(
    tasks(), st.booleans(), st.sampled_from(["octile", "euclidean"]), st.sampled_from([0, 0.5, 1])
)
def test_astar_finds_ways_as_short_as_dijkstra_does(task, cut_corners, heuristic, weight):
    free, start, goal = task
    grid, shortest = GridMap(free, 1.0), naive_length(free, start, goal, cut_corners)
    ends, rules = grid.centres([start, goal]), dict(cut_corners=cut_corners)
    if shortest == inf:
        with pytest.raises(NoPathError, match="no way leads") as caught:
            astar(grid, *ends, weight=weight, heuristic=heuristic, **rules)
        assert caught.value.reason == "enclosed"
        return
    plan = astar(grid, *ends, weight=weight, heuristic=heuristic, **rules)
    assert plan.length == pytest.approx(shortest, abs=1e-9)
    assert plan.cells[0].tolist() == start.tolist() and plan.cells[-1].tolist() == goal.tolist()
    assert_is_a_way(plan, grid, cut_corners)


@pytest.mark.campaign
def test_astar_agrees_with_dijkstra_on_random_maps(whole):
    rng = np.random.default_rng(4)
    for _ in range(500 if whole else 25):
        free = rng.random(rng.integers(1, 41, 2)) > rng.uniform(0.0, 0.45)
        free.flat[0] = free.flat[-1] = True
        goal = np.subtract(free.shape, 1)
        for cut_corners in (False, True):
            shortest = naive_length(free, (0, 0), goal, cut_corners)
            grid = GridMap(free, 0.1)
            if shortest == inf:
                with pytest.raises(NoPathError):
                    astar(grid, [0.05, 0.05], grid.centres(goal), cut_corners=cut_corners)
                continue
            plan = astar(grid, [0.05, 0.05], grid.centres(goal), cut_corners=cut_corners)
            assert plan.length == pytest.approx(0.1 * shortest, abs=1e-9)
            assert_is_a_way(plan, grid, cut_corners)


def test_costs_order_ways_as_their_lengths_do():
    # S² 2 - D² = ±1 makes D / S a best approximation of √2: off by 1 / (2 √2 S²).
    assert abs(moves.DIAGONAL**2 - 2 * moves.STRAIGHT**2) == 1
    a, b = 665857, 470832  # straight, diagonal: 665857 is nearly 470832 √2
    assert (a * moves.STRAIGHT > b * moves.DIAGONAL) == (a**2 > 2 * b**2)


def test_a_way_along_a_maze_of_many_bends_is_found():
    """It is far longer than the ring of buckets is wide."""
    free = serpentine(121)
    plan = astar(GridMap(free, 1.0), [120.5, 0.5], [0.5, 120.5])
    assert plan.length == pytest.approx(naive_length(free, (0, 120), (120, 0)))
    assert plan.length > 7000


def test_the_same_question_gets_the_same_way_to_the_bit():
    rng = np.random.default_rng(8)
    grid = GridMap(rng.random((80, 80)) > 0.3, 0.05)
    start, goal = (nearest_free(grid, p) for p in ([0.2, 0.2], [3.8, 3.8]))
    first, second = (astar(GridMap(grid.free.copy(), 0.05), start, goal) for _ in range(2))
    np.testing.assert_array_equal(first.xy, second.xy)
    assert (first.length, first.expanded) == (second.length, second.expanded)


def test_the_kernel_read_as_plain_python_does_the_same(monkeypatch):
    rng = np.random.default_rng(3)
    grid = GridMap(rng.random((30, 30)) > 0.25, 1.0)
    start, goal = nearest_free(grid, [5.0, 5.0]), nearest_free(grid, [28.0, 28.0])
    compiled = [astar(grid, start, goal, weight=w, watch=True) for w in (1.0, 1.5)]
    for name in ("search", "trace", "left", "estimate", "walls_around"):
        monkeypatch.setattr(search, name, getattr(search, name).py_func)
    for plan, w in zip(compiled, (1.0, 1.5), strict=True):
        plain = astar(grid, start, goal, weight=w, watch=True)
        np.testing.assert_array_equal(plain.cells, plan.cells)
        np.testing.assert_array_equal(plain.order, plan.order)


NINE = [(row, col) for row in range(3) for col in range(3)]  # a cell and all that is around it


def length_past_the_middle(free: np.ndarray, start, end, cut_corners: bool) -> float:
    """Length of the shortest way on nine cells that never enters the one in the middle."""
    length = {cell: inf for cell in NINE} | {tuple(start): 0.0}
    for _ in range(8):
        for row, col in NINE:
            for to in NINE:
                beside = free[to[0], col] and free[row, to[1]]
                one_step = max(abs(to[0] - row), abs(to[1] - col)) == 1
                if one_step and free[to] and to != (1, 1) and (beside or cut_corners):
                    length[to] = min(length[to], length[row, col] + hypot(to[0] - row, to[1] - col))
    return length[tuple(end)]


@pytest.mark.parametrize("cut_corners", [False, True])
def test_a_step_is_needless_just_if_its_end_is_reached_as_cheaply_without_it(cut_corners):
    table, around = (
        moves.worthwhile(cut_corners, False),
        list(zip(moves.D_ROW.tolist(), moves.D_COL.tolist(), strict=True)),
    )
    judged = 0
    for walls in range(256):
        free = np.ones((3, 3), dtype=bool)
        for k, (dr, dc) in enumerate(around):
            free[1 + dr, 1 + dc] = not walls >> k & 1
        for came, (dr, dc) in enumerate(around):
            before, step = (1 - dr, 1 - dc), hypot(dr, dc)
            if not free[before] or not (cut_corners or (free[1 - dr, 1] and free[1, 1 - dc])):
                continue  # nobody comes that way
            row = int(table[came, walls])
            worth = [row >> 4 * i & 7 for i in range(8) if row >> 4 * i & 8]
            for k, (up, right) in enumerate(around):
                end, through = (1 + up, 1 + right), step + hypot(up, right)
                opened = free[end] and (cut_corners or (free[end[0], 1] and free[1, end[1]]))
                past = length_past_the_middle(free, before, end, cut_corners)
                # Of two equally long ways the one that begins with the diagonal step is kept.
                needless = past < through - 1e-9 or (came % 2 == 0 and past < through + 1e-9)
                assert (k in worth) == (opened and not needless), (walls, came, k)
                judged += 1
    assert judged > 5000


def test_where_a_cell_is_gone_on_from_once_only_steps_back_are_needless():
    straight_on, at_the_start = moves.worthwhile(False, True)[[0, moves.NOWHERE], 0].tolist()
    # Two eighths to each side, straight on last: what is put on a pile last is taken up first.
    assert f"{straight_on:x}" == "89fae"
    assert sorted(f"{at_the_start:x}") == sorted("89abcdef")


@pytest.mark.parametrize("weight", [1.0, 1.5, 5.0])
def test_a_search_that_ran_out_of_room_is_made_again_with_more(monkeypatch, weight):
    rng, kernel, tries = np.random.default_rng(6), search.search, []
    grid = GridMap(rng.random((60, 60)) > 0.25, 1.0)
    ends = nearest_free(grid, [1.0, 1.0]), nearest_free(grid, [58.0, 58.0])
    wanted = astar(grid, *ends, weight=weight, watch=True)

    def in_a_corner(*arguments):
        *others, top, pool = arguments
        found = kernel(*others, top[: len(top) // 1024], pool[:, : pool.shape[1] // 256].copy())
        tries.append(found[1])
        return found

    monkeypatch.setattr(search, "search", in_a_corner)
    plan = astar(grid, *ends, weight=weight, watch=True)
    np.testing.assert_array_equal(plan.cells, wanted.cells)
    np.testing.assert_array_equal(plan.order, wanted.order)
    assert -2 in tries and (-1 in tries) == (weight > 1.0) and tries[-1] == plan.expanded


# --- estimates and weights --------------------------------------------------------------------


@settings(deadline=None)
@given(st.integers(-60, 60), st.integers(-60, 60))
def test_only_manhattan_ever_estimates_too_much(rows, cols):
    far, near = max(abs(rows), abs(cols)), min(abs(rows), abs(cols))
    true = moves.STRAIGHT * (far - near) + moves.DIAGONAL * near  # on an empty map
    assert moves.estimate(rows, cols, moves.OCTILE) == true
    assert moves.estimate(rows, cols, moves.EUCLIDEAN) <= true
    manhattan = moves.estimate(rows, cols, moves.MANHATTAN)
    assert true <= manhattan <= true * ROOT2 + 1
    assert (manhattan > true) == (near > 0)


@settings(deadline=None)
@given(st.integers(-2000, 2000), st.integers(-2000, 2000), st.integers(0, 7))
def test_an_admissible_estimate_falls_by_no_more_than_the_step_costs(rows, cols, k):
    step = moves.DIAGONAL if k % 2 else moves.STRAIGHT
    for kind in (moves.OCTILE, moves.EUCLIDEAN):
        before = moves.estimate(rows, cols, kind)
        assert before - moves.estimate(rows + moves.D_ROW[k], cols + moves.D_COL[k], kind) <= step


def test_manhattan_can_miss_the_shortest_way():
    """Diagonal steps look twice as good as they are, so it takes too many of them at once."""
    rng = np.random.default_rng(0)
    longer = 0
    for _ in range(200):
        free = rng.random((20, 20)) > 0.3
        free[0, 0] = free[-1, -1] = True
        grid = GridMap(free, 1.0)
        try:
            shortest = astar(grid, [0.5, 0.5], [19.5, 19.5]).length
        except NoPathError:
            continue
        manhattan = astar(grid, [0.5, 0.5], [19.5, 19.5], heuristic="manhattan").length
        assert shortest - 1e-9 <= manhattan <= ROOT2 * shortest + (ROOT2 - 1.0)
        longer += manhattan > shortest + 1e-9
    assert longer > 20


@settings(deadline=None, max_examples=300)
@given(tasks(), st.floats(1.1, 6.0), st.sampled_from(["octile", "euclidean", "manhattan"]))
def test_a_weight_makes_no_way_longer_than_it_says(task, weight, heuristic):
    free, start, goal = task
    shortest = naive_length(free, start, goal)
    assume(shortest < inf)
    grid = GridMap(free, 1.0)
    plan = astar(grid, *grid.centres([start, goal]), weight=weight, heuristic=heuristic)
    w = weight * (ROOT2 if heuristic == "manhattan" else 1.0)
    assert shortest - 1e-9 <= plan.length <= w * shortest + (w - 1.0) + 1e-9
    assert_is_a_way(plan, grid)
    assert plan.expanded <= free.sum(), "with a weight no cell is gone on from twice"


@pytest.mark.parametrize("weight", [1.0, 1.0 + 1e-9, 1.05])
def test_a_weight_of_hardly_more_than_one_still_finds_the_shortest_way(weight):
    grid = drawn("....... ...#... ...#... ...#... .......")
    assert astar(grid, [1.5, 2.5], [5.5, 2.5], weight=weight).length == pytest.approx(4 + 2 * ROOT2)


def test_a_better_estimate_looks_at_fewer_cells():
    grid = inflate(field.obstacle_map(0.05), RADIUS)
    cells = [
        astar(grid, START, GOAL, heuristic=heuristic, weight=weight).expanded
        for heuristic, weight in (("octile", 1.5), ("octile", 1), ("euclidean", 1), ("octile", 0))
    ]
    assert cells == sorted(cells) and len(set(cells)) == 4


@pytest.mark.parametrize("goal", [(199, 60), (60, 199), (199, 199), (0, 199)])
def test_on_an_empty_map_the_search_hardly_leaves_the_way(goal):
    """Thousands of ways are equally short; it must not look at all of them."""
    grid = GridMap(np.ones((200, 200), dtype=bool), 1.0)
    for start, end in (((0, 0), goal), (goal, (0, 0))):
        plan = astar(grid, *grid.centres([start, end]))
        assert plan.expanded < 2 * len(plan.cells)


def test_anytime_search_tells_a_bound_that_falls_to_one():
    grid = inflate(field.obstacle_map(0.05), RADIUS)
    attempts = list(anytime_astar(grid, START, GOAL, weights=(5.0, 2.5, 1.5, 1.0)))
    shortest = astar(grid, START, GOAL)
    bounds, lengths = [a.bound for a in attempts], [a.plan.length for a in attempts]
    assert bounds == sorted(bounds, reverse=True) and lengths == sorted(lengths, reverse=True)
    assert bounds[0] > 1.05 and bounds[-1] == 1.0
    np.testing.assert_array_equal(attempts[-1].plan.cells, shortest.cells)
    for bound, length in zip(bounds, lengths, strict=True):
        assert length <= bound * shortest.length + 1e-9


@settings(deadline=None, max_examples=100)
@given(tasks())
def test_the_bound_of_the_anytime_search_holds(task):
    free, start, goal = task
    shortest = naive_length(free, start, goal)
    assume(shortest < inf)
    grid = GridMap(free, 1.0)
    for attempt in anytime_astar(grid, *grid.centres([start, goal]), weights=(6.0, 2.0, 1.2)):
        assert shortest - 1e-9 <= attempt.plan.length <= attempt.bound * shortest + 1e-9


def test_anytime_search_stops_as_soon_as_nothing_can_be_gained():
    grid = GridMap(np.ones((20, 20), dtype=bool), 0.1)
    assert len(list(anytime_astar(grid, [0.0, 0.0], [1.9, 0.7]))) == 1
    (only,) = anytime_astar(grid, [0.0, 0.0], [0.0, 0.0])
    assert (only.bound, only.plan.length) == (1.0, 0.0)


def test_a_watched_search_tells_in_which_order_it_went():
    grid = drawn(".... .##. ....")
    plan = astar(grid, [0.5, 0.5], [3.5, 2.5], watch=True)
    assert plan.order.shape == grid.shape
    assert plan.order[0, 0] == 1 and plan.order.max() == plan.expanded
    assert (plan.order[~grid.free] == 0).all()
    # Each step of the way leads on from a cell that was gone on from before.
    order = plan.order[tuple(plan.cells[:-1].T)]
    assert (order > 0).all() and (np.diff(order) > 0).all()
    assert astar(grid, [0.5, 0.5], [3.5, 2.5]).order is None


# --- the field, and other maps ----------------------------------------------------------------


def test_on_the_game_field_the_way_leads_over_both_ramps():
    grid = field.obstacle_map(0.01)
    plan = astar(grid, START, GOAL, clearance=RADIUS)
    room = inflate(grid, RADIUS)
    assert_is_a_way(plan, room)
    for ramp in (field.RAMP_1, field.RAMP_2):
        x, y = plan.xy.T
        across = x[(ramp.y0 <= y) & (y <= ramp.y1)]
        assert len(across) >= 100
        assert (across >= ramp.x0 + RADIUS).all() and (across <= ramp.x1 - RADIUS).all()
    # In a straight line it is 10.35 m; the ramps lie 1.3 m off it on either side.
    assert 10.8 < plan.length < 12.0
    np.testing.assert_allclose(plan.xy[[0, -1]], [START, GOAL], atol=0.0051)


def test_a_narrower_robot_finds_no_longer_a_way():
    grid = field.obstacle_map(0.05)
    lengths = [astar(grid, START, GOAL, clearance=c).length for c in (0.0, 0.1, 0.2, RADIUS)]
    assert lengths == sorted(lengths)
    with pytest.raises(NoPathError, match=r"clearance of 0\.6 m"):
        astar(grid, START, GOAL, clearance=0.6)


def test_a_map_of_ros_can_be_planned_on(tmp_path):
    grid = GridMap(drawn("..... .###. .....").free, 0.25, (-3.0, 7.0))
    save_map(grid, tmp_path / "hall.yaml", image="pgm")
    plan = astar(load_map(tmp_path / "hall.yaml"), [-2.4, 7.1], [-2.4, 7.7])
    assert plan.length == pytest.approx(0.25 * 6)
    np.testing.assert_allclose(plan.xy[0], [-2.375, 7.125])


def test_a_map_that_map_server_wrote_can_be_planned_on(tmp_path):
    """As map_saver writes it: a comment, 254 free, 0 wall, 205 unknown; row 0 at the top."""
    rows = [
        "#########",
        "#.......#",
        "#.####..#",
        "#.#??#..#",
        "#.####..#",
        "#.......#",
        "#########",
    ]
    grey = {"#": 0, ".": 254, "?": 205}
    pixels = bytes(grey[sign] for row in rows for sign in row)
    header = b"P5\n# CREATOR: map_saver.cpp 0.050 m/pix\n9 7\n255\n"
    (tmp_path / "hall.pgm").write_bytes(header + pixels)
    (tmp_path / "hall.yaml").write_text(
        "image: hall.pgm\nresolution: 0.050000\norigin: [-12.200000, -13.800000, 0.000000]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n\n"
    )
    grid = load_map(tmp_path / "hall.yaml")
    corners = grid.centres([(1, 1), (5, 1)])  # bottom left to top left: straight up
    assert astar(grid, *corners).length == pytest.approx(0.05 * 4)
    assert not grid.free[3, 3] and grid.free.sum() == 23
    with pytest.raises(NoPathError, match="lies in an obstacle"):
        astar(grid, corners[0], grid.centres((3, 3)))


def peaks_of(grid: GridMap, monkeypatch, **options) -> tuple[float, float]:
    """Most memory held [bytes a cell of the map] until the goal was reached, and in the end."""
    reached, trace = [], search.trace

    def watched_trace(*arguments):
        reached.append(tracemalloc.get_traced_memory()[1])
        return trace(*arguments)

    first, last = grid.centres([[2, 2], np.subtract(grid.shape, 3)])
    astar(grid, first, first, **options)  # what compiling needs is not counted
    monkeypatch.setattr(search, "trace", watched_trace)
    tracemalloc.start()
    astar(grid, first, last, **options)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return reached[0] / grid.free.size, peak / grid.free.size


@pytest.mark.parametrize(
    "options",
    [
        dict(),
        dict(weight=0),
        dict(weight=1.11),
        dict(weight=100, heuristic="manhattan"),
        dict(cut_corners=True),
        dict(watch=True),
        dict(clearance=1.0),
    ],
    ids=str,
)
def test_memory_for_a_cell_stays_below_sixteen_bytes(options, monkeypatch):
    free = np.random.default_rng(2).random((1001, 1001)) > (0.02 if "clearance" in options else 0.2)
    free[:4, :4] = free[-4:, -4:] = True
    _, peak = peaks_of(GridMap(free, 1.0), monkeypatch, **options)
    assert 9.0 < peak <= 16.0


@pytest.mark.parametrize("weight", [0, 1, 1.11, 100])
def test_the_search_takes_no_more_memory_in_a_maze(weight, monkeypatch):
    """The way, half a million points long, is not counted: each takes four numbers."""
    reached, _ = peaks_of(GridMap(serpentine(1001), 1.0), monkeypatch, weight=weight)
    assert 9.0 < reached <= 16.0


# --- odd maps and refusals --------------------------------------------------------------------


def test_where_start_is_the_goal_the_way_is_one_cell():
    grid = GridMap(np.ones((3, 3), dtype=bool), 1.0)
    plan = astar(grid, [1.2, 1.9], [1.7, 1.1], watch=True)
    assert plan.cells.tolist() == [[1, 1]] and plan.length == 0.0
    assert plan.xy.tolist() == [[1.5, 1.5]] and plan.expanded == 0


@pytest.mark.parametrize("shape", [(1, 9), (9, 1), (1, 1)])
def test_a_map_one_cell_wide_is_a_map(shape):
    grid = GridMap(np.ones(shape, dtype=bool), 0.5)
    plan = astar(grid, grid.centres([0, 0]), grid.centres(np.subtract(shape, 1)))
    assert plan.length == pytest.approx(0.5 * (max(shape) - 1))


@pytest.mark.parametrize("heuristic", ["octile", "manhattan"])
@pytest.mark.parametrize("weight", [0, 1, 1.5, 100])
def test_a_corridor_of_a_hundred_thousand_cells_is_no_trouble(weight, heuristic):
    """A hundred times the estimate of its length, before it is divided, needs 65 bits."""
    grid = GridMap(np.ones((1, 100_000), dtype=bool), 1.0)
    plan = astar(grid, [20_000.5, 0.5], [99_999.5, 0.5], weight=weight, heuristic=heuristic)
    assert plan.length == 79_999.0
    assert plan.expanded <= (80_000 if weight else 100_000), "it went back"


TWO_ROOMS = drawn("..#.. ..#.. ..#..")


@pytest.mark.parametrize(
    ("start", "goal", "clearance", "reason", "sentence"),
    [
        ([0.5, 0.5], [4.5, 2.5], 0.0, "enclosed", "only 6 of the 12 free cells"),
        ([2.5, 0.5], [4.5, 2.5], 0.0, "blocked", r"start: \(2.5, 0.5\) m lies in an obstacle"),
        ([0.5, 0.5], [2.5, 1.5], 0.0, "blocked", "goal: .* lies in an obstacle"),
        ([-0.1, 0.5], [4.5, 2.5], 0.0, "outside", "start: .*outside the map, which spans x 0 to 5"),
        ([0.5, 0.5], [4.5, 3.0], 0.0, "outside", "goal: .*outside the map"),
        ([0.5, 0.5], [1.5, 2.5], 0.5, "blocked", "start: .*nearer than the clearance of 0.5 m"),
        ([0.5, 0.5], [1.5, 2.5], 1e9, "blocked", "start: .*nearer than the clearance of 1e"),
        ([0.5, 0.5], [1.5, 2.5], 1e300, "blocked", "start: .*nearer than the clearance of 1e"),
    ],
)
def test_where_there_is_no_way_the_message_says_why(start, goal, clearance, reason, sentence):
    with pytest.raises(NoPathError, match=sentence) as caught:
        astar(TWO_ROOMS, start, goal, clearance=clearance)
    assert caught.value.reason == reason


def test_on_a_map_without_a_free_cell_nothing_can_be_planned():
    grid = GridMap(np.zeros((4, 4), dtype=bool), 1.0)
    with pytest.raises(NoPathError, match="lies in an obstacle"):
        astar(grid, [0.5, 0.5], [3.5, 3.5])
    with pytest.raises(NoPathError, match="no cell of the map is free"):
        nearest_free(grid, [0.5, 0.5])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (dict(start=[nan, 0.5]), "start: .*not a finite number"),
        (dict(goal=[0.5, inf]), "goal: .*not a finite number"),
        (dict(goal=[0.5, 0.5, 0.0]), "goal: expected shape"),
        (dict(start="here"), "start: expected numbers"),
        (dict(clearance=-0.1), "clearance: must not be negative"),
        (dict(clearance=nan), "clearance: .*not a finite number"),
        (dict(weight=-1.0), "weight: must be from 0"),
        (dict(weight=nan), "weight: must be from 0"),
        (dict(weight=1e9), "weight: must be from 0"),
        (dict(weight="much"), "weight: expected numbers, got str"),
        (dict(clearance=inf), "clearance: .*not a finite number"),
        (dict(heuristic=["octile"]), "heuristic: must be one of octile"),
        (dict(heuristic="chebyshev"), "heuristic: must be one of octile"),
    ],
)
def test_arguments_that_make_no_sense_are_refused(options, sentence):
    with pytest.raises(ValueError, match=sentence) as caught:
        astar(TWO_ROOMS, **{"start": [0.5, 0.5], "goal": [1.5, 2.5], **options})
    assert not isinstance(caught.value, NoPathError)


def test_the_nearest_free_point_is_free_and_no_other_is_nearer():
    grid = inflate(field.obstacle_map(0.05), RADIUS)
    for point in ([0.1, 0.1], [-3.0, 5.0], [2.0, 7.5]):
        found = nearest_free(field.obstacle_map(0.05), point, clearance=RADIUS)
        assert grid.is_free(found)
        others = grid.centres(np.argwhere(grid.free)) - point
        assert np.hypot(*(found - point)) == pytest.approx(np.hypot(*others.T).min())


# --- in sight, and shortened ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("end", "seen"),
    [
        ([3.5, 0.5], True),
        ([0.5, 2.5], True),
        ([3.5, 2.5], False),  # through the obstacle
        ([1.5, 1.5], False),  # past its corner, but that touches it
        ([3.5, 0.999], True),
        ([3.5, 1.5], False),
        ([4.5, 0.5], False),  # off the map
    ],
)
def test_a_line_that_touches_an_obstacle_is_no_line_of_sight(end, seen):
    grid = drawn(".... .... .#.. ....")  # the obstacle is x 1 to 2, y 1 to 2
    assert line_of_sight(grid, [0.5, 0.5], end) is seen
    assert line_of_sight(grid, end, [0.5, 0.5]) is seen


def test_a_line_along_an_obstacles_side_touches_it():
    grid = drawn(".... .... .#.. ....")
    assert not line_of_sight(grid, [1.5, 0.5], [1.5, 2.5]), "straight up, through it"
    assert not line_of_sight(grid, [1.5, 2.5], [1.5 + 1e-7, 0.5])
    assert not line_of_sight(grid, [0.0, 1.0], [3.0, 1.0])
    assert not line_of_sight(grid, [2.0, 0.0], [2.0, 3.0])
    assert line_of_sight(grid, [0.1, 0.9999], [3.0, 0.9999])


@settings(deadline=None, max_examples=200)
@given(bitmaps, st.data())
def test_a_line_of_sight_has_only_free_points(free, data):
    grid = GridMap(free, 1.0)
    sides = st.floats(0.01, 0.99).map(lambda v: round(v, 6))
    start, end = (
        [data.draw(sides) * free.shape[1], data.draw(sides) * free.shape[0]] for _ in range(2)
    )
    points = np.linspace(start, end, 400)
    if line_of_sight(grid, start, end):
        assert grid.is_free(points).all()
    elif grid.is_free(points).all():
        # Then it only touches something between two of the points, or on an edge.
        around = points[:, None, None] + 0.05 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1]), -1)
        assert not grid.is_free(around).all()


def test_a_shortened_way_on_the_field_has_seven_points_and_keeps_its_clearance():
    grid = field.obstacle_map(0.01)
    room = inflate(grid, RADIUS)
    plan = astar(room, START, GOAL)
    short = shorten_path(grid, plan.xy, clearance=RADIUS)
    assert len(plan.xy) > 1000 and len(short) == 7
    assert path_length(short) == pytest.approx(11.332, abs=0.002)
    np.testing.assert_array_equal(short[[0, -1]], plan.xy[[0, -1]])
    assert_keeps_clear(short, grid, room)


def assert_keeps_clear(xy, grid, room) -> None:
    """Legs in sight on the inflated map, and points as far from every obstacle as they must be."""
    for a, b in pairwise(xy):
        assert line_of_sight(room, a, b)
    beside_free = grid.free | ~minimum_filter(~grid.free, 3)
    rim = grid.centres(np.argwhere(~grid.free & beside_free))
    half = grid.resolution / 2.0
    for point in resample_path(xy, 0.1):
        gaps = np.hypot(*(np.abs(rim - point) - half).clip(0.0).T)
        assert gaps.min() >= RADIUS - 1e-9


@settings(deadline=None, max_examples=200)
@given(tasks())
def test_a_shortened_way_is_not_longer_and_cannot_be_shortened_again(task):
    free, start, goal = task
    grid = GridMap(free, 1.0)
    try:
        plan = astar(grid, *grid.centres([start, goal]))
    except NoPathError:
        assume(False)
    short = shorten_path(grid, plan.xy)
    assert path_length(short) <= plan.length + 1e-9
    assert path_length(shorten_path(grid, short)) == pytest.approx(path_length(short), rel=1e-5)
    np.testing.assert_array_equal(short[[0, -1]], plan.xy[[0, -1]])
    for a, b in pairwise(short):
        assert line_of_sight(grid, a, b)


# --- smooth -----------------------------------------------------------------------------------


def three_point_curvature(a, b, c) -> float:
    """One over the radius through three points, from the lengths of the sides (Heron)."""
    x, y, z = np.hypot(*(b - a)), np.hypot(*(c - b)), np.hypot(*(c - a))
    s = (x + y + z) / 2.0
    return 4.0 * sqrt(max(s * (s - x) * (s - y) * (s - z), 0.0)) / (x * y * z)


def test_the_curvature_of_a_circle_is_one_over_its_radius():
    angle = np.linspace(0.0, 5.0, 40)
    circle = 2.5 * np.column_stack([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(path_curvature(circle)[1:-1], 0.4, atol=1e-9)
    assert path_curvature([[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]]).tolist() == [0.0, inf, 0.0]
    assert path_curvature([[0.0, 0.0], [1.0, 0.0], [0.5, 0.0]]).tolist() == [0.0, 4.0, 0.0]
    assert path_curvature([[0.0, 0.0], [1.0, 0.0], [3.0, 0.0]]).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("radius", [0.2, 0.5])
def test_a_smooth_way_bends_no_more_than_allowed_and_keeps_its_clearance(radius):
    grid = field.obstacle_map(0.01)
    room = inflate(grid, RADIUS)
    short = shorten_path(room, astar(room, START, GOAL).xy)
    smooth = smooth_path(grid, short, max_curvature=1.0 / radius, clearance=RADIUS)
    np.testing.assert_array_equal(smooth[[0, -1]], short[[0, -1]])
    bends = [three_point_curvature(*smooth[i : i + 3]) for i in range(len(smooth) - 2)]
    assert max(bends) <= 1.0 / radius + 1e-9
    np.testing.assert_allclose(path_curvature(smooth)[1:-1], bends, atol=1e-6)
    assert_keeps_clear(smooth, grid, room)
    assert path_length(smooth) < path_length(short) * 1.02
    assert path_curvature(resample_path(short, 0.05)).max() > 1.0 / radius, "nothing to do"


def test_a_straight_way_is_smooth_already():
    grid = GridMap(np.ones((20, 20), dtype=bool), 0.1)
    smooth = smooth_path(grid, [[0.2, 0.2], [1.7, 0.2]], max_curvature=0.5, spacing=0.3)
    np.testing.assert_allclose(smooth, np.linspace([0.2, 0.2], [1.7, 0.2], 6), atol=1e-12)


def test_a_bend_that_a_passage_is_too_narrow_for_is_refused():
    free = np.zeros((30, 30), dtype=bool)
    free[2:5, 2:28] = free[2:28, 25:28] = True  # three cells wide
    grid = GridMap(free, 0.1)
    corner = shorten_path(grid, astar(grid, [0.35, 0.35], [2.65, 2.65]).xy)
    smooth_path(grid, corner, max_curvature=5.0)
    with pytest.raises(NoPathError, match="cannot bend less than") as caught:
        smooth_path(grid, corner, max_curvature=0.5)
    assert caught.value.reason == "bent"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (dict(max_curvature=0.0), "max_curvature: must be positive"),
        (dict(max_curvature=nan), "max_curvature: .*not a finite"),
        (dict(spacing=-1.0), "spacing: must be positive"),
        (dict(xy=np.empty((0, 2))), "xy: a way has at least one point"),
        (dict(xy=[[0.5, 0.5], [nan, 1.0]]), "xy: .*not a finite"),
        (dict(xy=[[0.5, 0.5], [4.5, 0.5]]), r"xy: the way has no clearance of 0 m near \("),
    ],
)
def test_a_way_that_cannot_be_smoothed_is_refused(options, sentence):
    with pytest.raises(ValueError, match=sentence):
        smooth_path(TWO_ROOMS, **{"xy": [[0.5, 0.5], [1.5, 2.5]], "max_curvature": 1.0, **options})


# --- ways as rows of points -------------------------------------------------------------------


def test_a_thinned_way_keeps_some_points_and_both_ends():
    grid = field.obstacle_map(0.01)
    plan = astar(grid, START, GOAL, clearance=RADIUS)
    thin = thin_path(plan.xy, 0.2)
    assert {tuple(p) for p in thin} <= {tuple(p) for p in plan.xy}
    np.testing.assert_array_equal(thin[[0, -1]], plan.xy[[0, -1]])
    gaps = np.hypot(*np.diff(thin, axis=0).T)
    assert gaps.max() <= 0.2 + 0.015 and len(thin) == pytest.approx(plan.length / 0.2, abs=2)


def test_thinning_by_a_whole_number_of_steps_loses_none_to_rounding():
    line = np.column_stack([np.arange(101) * 0.01, np.zeros(101)])
    assert thin_path(line, 0.1)[:, 0].tolist() == line[::10, 0].tolist()


@settings(max_examples=100)
@given(
    arrays(np.float64, st.tuples(st.integers(1, 12), st.just(2)), elements=st.floats(-9, 9)),
    st.floats(0.05, 20.0),
)
def test_resampled_points_lie_on_the_way_evenly_spread(xy, spacing):
    even = resample_path(xy, spacing)
    np.testing.assert_allclose(even[0], xy[0])
    if path_length(xy) > 1e-9:
        np.testing.assert_allclose(even[-1], xy[-1], atol=1e-9)
    gaps = np.hypot(*np.diff(even, axis=0).T)
    assert (gaps <= spacing * (1.0 + 1e-6) + 1e-9).all()
    assert path_length(even) <= path_length(xy) + 1e-9
    thin = thin_path(xy, spacing)
    assert {tuple(p) for p in thin} <= {tuple(p) for p in xy} and tuple(thin[-1]) == tuple(xy[-1])


@pytest.mark.parametrize("function", [thin_path, resample_path])
def test_a_spacing_that_is_not_positive_is_refused(function):
    with pytest.raises(ValueError, match="spacing: must be positive"):
        function([[0.0, 0.0], [1.0, 0.0]], 0.0)


# --- one cell and its steps -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("goal", "cells"),
    [((0, 0), 0.0), ((0, 7), 7.0), ((-5, 0), 5.0), ((4, 4), 4 * ROOT2), ((3, -4), 1 + 3 * ROOT2)],
)
def test_octile_distance_counts_diagonal_steps_first(goal, cells):
    assert octile_distance((0, 0), goal) == pytest.approx(cells, abs=1e-12)
    assert octile_distance(goal, (0, 0)) == octile_distance((0, 0), goal)


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 11), st.integers(0, 8))
def test_octile_distance_is_the_length_of_the_way_on_an_empty_map(row, col):
    grid = GridMap(np.ones((12, 9), dtype=bool), 1.0)
    plan = astar(grid, grid.centres((2, 3)), grid.centres((row, col)))
    assert octile_distance((2, 3), (row, col)) == pytest.approx(plan.length)


def naive_steps(free: np.ndarray, row: int, col: int, cut: bool) -> dict:
    """Open steps by the rule, cell by cell."""
    found = {}
    for dr in (-1, 0, 1):
        for dc in (-1, 0, 1):
            r, c = row + dr, col + dc
            if (dr, dc) == (0, 0) or not (0 <= r < free.shape[0] and 0 <= c < free.shape[1]):
                continue
            if free[r, c] and (cut or not (dr and dc) or (free[r, col] and free[row, c])):
                found[r, c] = ROOT2 if dr and dc else 1.0
    return found


@settings(deadline=None, max_examples=80)
@given(arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=6)), st.data(), st.booleans())
def test_neighbours_are_the_cells_that_the_rule_allows(free, data, cut):
    row, col = (data.draw(st.integers(0, n - 1)) for n in free.shape)
    steps = neighbours(GridMap(free, 0.3), (row, col), cut_corners=cut)
    assert dict(steps) == naive_steps(free, row, col, cut)
    assert len(steps) == len(dict(steps))


@pytest.mark.parametrize("cell", [(-1, 0), (0, 3), (2, 0), (0.5, 0), (0, 0, 0), "here"])
def test_neighbours_of_no_cell_are_refused(cell):
    with pytest.raises(ValueError, match="cell:"):
        neighbours(GridMap(np.ones((2, 3), dtype=bool), 1.0), cell)
    if cell not in ((-1, 0), (0, 3), (2, 0)):
        with pytest.raises(ValueError, match="goal:"):
            octile_distance((0, 0), cell)


def test_a_plan_through_a_list_of_cells_knows_its_points_and_its_length():
    grid = GridMap(np.ones((5, 5), dtype=bool), 0.2, (1.0, -1.0))
    plan = plan_through(grid, [(0, 0), (1, 1), (1, 2), (0, 3)], 17)
    assert plan.length == pytest.approx(0.2 * (1 + 2 * ROOT2))
    np.testing.assert_allclose(plan.xy, [[1.1, -0.9], [1.3, -0.7], [1.5, -0.7], [1.7, -0.9]])
    assert (plan.expanded, plan.cells.dtype) == (17, np.int64)
    alone = plan_through(grid, [(2, 2)], 0)
    assert alone.length == 0.0 and alone.xy.shape == (1, 2)


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        ([], "cells: "),
        ([(0, 0), (0, 2)], r"from \[0, 0\] to \[0, 2\] is no step"),
        ([(0, 0), (0, 0)], "is no step"),
        ([(0.5, 0.5)], "are these metres"),
        ([(0, 0, 0)], "cells: expected shape"),
    ],
)
def test_cells_that_are_no_way_are_refused(cells, sentence):
    with pytest.raises(ValueError, match=sentence):
        plan_through(GridMap(np.ones((3, 3), dtype=bool), 1.0), cells, 1)
