"""Chapter 04 on the way: maps that change, and obstacles that are only seen when they are near."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robocon_course import field
from robocon_course.gridmap import GridMap, inflate
from robocon_course.planning import (
    NoPathError,
    Replanner,
    astar,
    path_length,
    replanning,
    travel,
    visible_cells,
)

GOAL = [1.55, 0.05]  # m; the arena of the thesis has 16 x 16 cells, its finish is a corner


def arena(seed: int) -> GridMap:
    """A 16 x 16 arena with obstacles, in which start and goal are joined."""
    rng = np.random.default_rng(seed)
    while True:
        free = rng.random((16, 16)) > 0.3
        free[15, 0] = free[0, 15] = True
        grid = GridMap(free, 0.1)
        try:
            astar(grid, [0.05, 1.55], GOAL)
        except NoPathError:
            continue
        return grid


def length_or_none(plan, *arguments, **options) -> float | None:
    """Length of a plan, None where there is none."""
    try:
        return plan(*arguments, **options).length
    except NoPathError:
        return None


# --- D* Lite ----------------------------------------------------------------------------------


def test_a_new_obstacle_lengthens_the_plan_as_by_hand_and_is_forgotten_when_it_goes():
    free = np.ones((5, 9), dtype=bool)
    replanner = Replanner([8.5, 2.5])
    assert replanner.plan(GridMap(free, 1.0), [0.5, 2.5]).length == 8.0
    wall = free.copy()
    wall[1:5, 4] = False
    plan = replanner.plan(GridMap(wall, 1.0), [0.5, 2.5])
    # Down to row 0 and up again in diagonal steps, and straight past the wall's end.
    assert plan.length == pytest.approx(4 * np.sqrt(2.0) + 4)
    assert [0, 4] in plan.cells.tolist()
    assert replanner.plan(GridMap(free, 1.0), [1.5, 2.5]).length == 7.0


@settings(deadline=None, max_examples=80)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_mended_plans_are_as_short_as_new_ones(seed, cut_corners):
    rng = np.random.default_rng(seed)
    free = rng.random(rng.integers(1, 14, 2)) > rng.uniform(0.0, 0.5)
    at, goal = (tuple(rng.integers(free.shape)) for _ in range(2))
    free[at] = free[goal] = True
    grid = GridMap(free, 0.2, (-1.0, 3.0))
    target = grid.centres(goal)
    replanner = Replanner(target, cut_corners=cut_corners)
    for _ in range(8):
        grid = GridMap(free, 0.2, (-1.0, 3.0))
        here = grid.centres(at)
        fresh = length_or_none(astar, grid, here, target, cut_corners=cut_corners)
        mended = length_or_none(replanner.plan, grid, here)
        assert mended == (fresh if fresh is None else pytest.approx(fresh, abs=1e-9))
        if mended is not None:
            cells = replanner.plan(grid, here).cells
            assert free[tuple(cells.T)].all() and (np.abs(np.diff(cells, axis=0)) <= 1).all()
            at = tuple(cells[min(len(cells) - 1, rng.integers(4))])
        free = free ^ (rng.random(free.shape) < rng.choice([0.0, 0.02, 0.1, 0.5]))
        free[at] = free[goal] = True


@pytest.mark.campaign
def test_mended_plans_stay_as_short_over_long_drives(whole):
    for seed in range(40 if whole else 2):
        rng = np.random.default_rng(seed)
        free = rng.random((60, 60)) > 0.2
        free[0, 0] = free[-1, -1] = True
        replanner, here = Replanner([59.5, 59.5]), np.array([0.5, 0.5])
        for _ in range(30):
            grid = GridMap(free, 1.0)
            fresh = length_or_none(astar, grid, here, [59.5, 59.5])
            if fresh is None:
                assert length_or_none(replanner.plan, grid, here) is None
            else:
                plan = replanner.plan(grid, here)
                assert plan.length == pytest.approx(fresh, abs=1e-9)
                here = plan.xy[min(2, len(plan.xy) - 1)]
            free = free ^ (rng.random(free.shape) < 0.01)
            free[tuple(grid.cells(here))] = free[-1, -1] = True


def test_a_robot_that_is_carried_elsewhere_still_gets_the_shortest_way():
    """Then the estimates of all that waits are off by much; only the drift makes up for it."""
    rng = np.random.default_rng(6)
    free = rng.random((40, 40)) > 0.25
    free[-1, -1] = True
    replanner = Replanner([39.5, 39.5])
    for _ in range(40):
        grid = GridMap(free, 1.0)
        here = grid.centres(rng.choice(np.argwhere(free)))
        mended = length_or_none(replanner.plan, grid, here)
        fresh = length_or_none(astar, grid, here, [39.5, 39.5])
        assert mended == (fresh if fresh is None else pytest.approx(fresh, abs=1e-9))
        free = free ^ (rng.random(free.shape) < 0.02)
        free[-1, -1] = True


def test_nothing_changed_is_nothing_to_do():
    grid = inflate(field.obstacle_map(0.05), 0.325)
    replanner = Replanner([4.30, 10.00])
    first = replanner.plan(grid, [0.55, 0.35])
    assert first.length == pytest.approx(astar(grid, [0.55, 0.35], [4.30, 10.00]).length)
    again = replanner.plan(grid, [0.55, 0.35])
    assert first.expanded > 1000 and again.expanded == 0
    np.testing.assert_array_equal(again.cells, first.cells)


def test_after_one_obstacle_it_takes_fewer_cells_than_a_new_search():
    grid = inflate(field.obstacle_map(0.05), 0.325)
    replanner = Replanner([4.30, 10.00])
    plan = replanner.plan(grid, [0.55, 0.35])
    on_the_way = plan.cells[len(plan.cells) // 2]
    free = grid.free.copy()
    free[tuple(on_the_way)] = False
    changed = GridMap(free, grid.resolution, grid.origin)
    here = plan.xy[len(plan.xy) // 3]
    mended, fresh = replanner.plan(changed, here), astar(changed, here, [4.30, 10.00])
    assert mended.length == pytest.approx(fresh.length)
    assert mended.expanded < fresh.expanded / 10
    assert on_the_way.tolist() not in mended.cells.tolist()


def test_a_replanner_survives_a_map_without_a_way_and_a_map_of_another_size():
    free = np.ones((4, 5), dtype=bool)
    closed = free.copy()
    closed[:, 2] = False
    replanner = Replanner([4.5, 0.5], clearance=0.0)
    assert replanner.plan(GridMap(free, 1.0), [0.5, 0.5]).length == 4.0
    with pytest.raises(NoPathError, match="no way leads") as caught:
        replanner.plan(GridMap(closed, 1.0), [0.5, 0.5])
    assert caught.value.reason == "enclosed"
    with pytest.raises(NoPathError, match=r"start: .*in an obstacle"):
        replanner.plan(GridMap(closed, 1.0), [2.5, 0.5])
    assert replanner.plan(GridMap(free, 1.0), [1.5, 0.5]).length == 3.0
    wide = GridMap(np.ones((2, 20), dtype=bool), 0.5)
    assert replanner.plan(wide, [0.25, 0.75]).length == 4.5
    with pytest.raises(ValueError, match=r"goal: .*not a finite"):
        Replanner([np.nan, 0.0])


def test_the_kernel_of_the_repair_read_as_plain_python_does_the_same(monkeypatch):
    grid, other = arena(0), arena(1)
    maps = (grid, GridMap(grid.free | other.free, 0.1), grid)
    compiled, plain = Replanner(GOAL), Replanner(GOAL)
    here = grid.centres([15, 0])
    expected = [compiled.plan(each, here) for each in maps]
    for name in ("repair", "descend", "urgency", "look_ahead", "estimate", "may_step"):
        monkeypatch.setattr(replanning, name, getattr(replanning, name).py_func)
    for each, plan in zip(maps, expected, strict=True):
        again = plain.plan(each, here)
        np.testing.assert_array_equal(again.cells, plan.cells)
        assert again.expanded == plan.expanded


# --- obstacles discovered on the way ----------------------------------------------------------


def test_a_sensor_sees_up_to_the_first_obstacle_and_no_further_than_it_reaches():
    free = np.ones((9, 9), dtype=bool)
    free[2:7, 5] = False
    grid = GridMap(free, 0.1)
    seen = visible_cells(grid, [0.25, 0.45], 0.45)
    assert seen[4, 2] and seen[4, 5] and not seen[4, 6:].any()
    assert seen[4, 0] and not seen[0, 8] and not seen[4, 8]
    centres = grid.centres(np.argwhere(seen))
    # A beam stops within the cell that it reaches: at most half a diagonal from its middle.
    assert np.hypot(*(centres - [0.25, 0.45]).T).max() <= 0.45 + 0.1 * np.sqrt(0.5)


def test_a_sensor_in_an_open_room_sees_every_cell_within_reach():
    grid = GridMap(np.ones((41, 41), dtype=bool), 0.1)
    seen = visible_cells(grid, [2.05, 2.05], 1.5)
    middles = grid.centres(np.argwhere(np.ones((41, 41))))
    near = np.hypot(*(middles - [2.05, 2.05]).T) < 1.4
    assert seen[near.reshape(41, 41)].all()


def from_nothing(grid, xy):
    return astar(grid, xy, GOAL)


@pytest.mark.parametrize("planner", [None, from_nothing], ids=["mended", "from nothing"])
def test_ten_of_ten_runs_through_unknown_obstacles_arrive(planner):
    """The thesis of 2015 tells the same of its simulation, chapter 4.3."""
    replans = 0
    for run in range(10):
        truth = arena(run)
        journey = travel(truth, [0.05, 1.55], GOAL, reach=0.15, planner=planner)
        np.testing.assert_allclose(journey.xy[[0, -1]], [[0.05, 1.55], GOAL])
        cells = truth.cells(journey.xy)
        assert truth.free[tuple(cells.T)].all(), "it drove through an obstacle"
        steps = np.abs(np.diff(cells, axis=0))
        assert (steps.max(axis=1) == 1).all()
        (row, col), (to_row, to_col) = cells[:-1].T, cells[1:].T
        assert truth.free[row, to_col].all() and truth.free[to_row, col].all()
        assert path_length(journey.xy) >= astar(truth, [0.05, 1.55], GOAL).length - 1e-9
        assert not (truth.free & ~journey.known.free).any(), "it knows an obstacle that is none"
        replans += len(journey.legs) - 1
    assert replans > 40


def test_on_the_same_journey_mending_takes_fewer_cells_than_starting_from_nothing():
    truth = arena(3)
    replanner, taken = Replanner(GOAL), []

    def both(grid, xy):
        fresh, mended = from_nothing(grid, xy), replanner.plan(grid, xy)
        assert mended.length == pytest.approx(fresh.length)
        taken.append((fresh.expanded, mended.expanded))
        return fresh

    travel(truth, [0.05, 1.55], GOAL, reach=0.15, planner=both)
    fresh, mended = np.sum(taken[1:], axis=0)  # the first search starts from nothing anyway
    assert len(taken) > 3 and mended < fresh


def test_what_is_known_from_the_start_is_not_found_again():
    truth = arena(5)
    journey = travel(truth, [0.05, 1.55], GOAL, reach=0.15, known=truth)
    assert len(journey.legs) == 1 and len(journey.legs[0].found) == 0
    assert path_length(journey.xy) == pytest.approx(astar(truth, [0.05, 1.55], GOAL).length)


def test_a_journey_tells_what_was_found_before_each_plan():
    truth = arena(7)
    journey = travel(truth, [0.05, 1.55], GOAL, reach=0.3)
    found = np.concatenate([leg.found for leg in journey.legs])
    assert len(found) == len(np.unique(found, axis=0)), "each obstacle is found once"
    assert not truth.free[tuple(found.T)].any()
    known = np.ones((16, 16), dtype=bool)
    for leg in journey.legs:
        known[tuple(leg.found.T)] = False
        assert leg.plan.length == pytest.approx(astar(GridMap(known, 0.1), leg.at, GOAL).length)
        assert leg.at.tolist() in journey.xy.tolist()


def test_on_the_field_without_a_map_the_robot_arrives_with_its_clearance():
    truth = field.obstacle_map(0.05)
    room = inflate(truth, 0.325)
    journey = travel(truth, [0.55, 0.35], [4.30, 10.00], reach=1.5, clearance=0.325)
    np.testing.assert_allclose(journey.xy[-1], [4.30, 10.00], atol=0.026)
    # A corner comes into sight one step too late at most.
    near = journey.xy[~room.is_free(journey.xy)]
    assert inflate(truth, 0.325 - 0.05 * np.sqrt(2.0)).is_free(near).all()
    assert path_length(journey.xy) > astar(room, [0.55, 0.35], [4.30, 10.00]).length


def test_a_goal_that_turns_out_to_be_walled_in_is_given_up_with_the_reason():
    free = np.ones((9, 9), dtype=bool)
    free[5:8, 5] = free[5:8, 7] = free[5, 5:8] = free[7, 5:8] = False
    with pytest.raises(NoPathError, match="no way leads") as caught:
        travel(GridMap(free, 0.1), [0.05, 0.05], [0.65, 0.65], reach=0.2)
    assert caught.value.reason == "enclosed"


def test_a_map_that_does_not_lie_on_the_truth_is_refused():
    truth = arena(0)
    other = GridMap(np.ones((16, 16), dtype=bool), 0.2)
    with pytest.raises(ValueError, match="known: must have the shape"):
        travel(truth, [0.05, 1.55], GOAL, reach=0.2, known=other)
    with pytest.raises(ValueError, match="reach: must be positive"):
        travel(truth, [0.05, 1.55], GOAL, reach=0.0)
    with pytest.raises(NoPathError, match=r"goal: .*outside"):
        travel(truth, [0.05, 1.55], [9.0, 9.0], reach=0.2)
