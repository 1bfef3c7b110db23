"""Chapter 04 on benchmark maps: of other people, every published length exactly; and made here.

N. Sturtevant, Benchmarks for Grid-Based Pathfinding, IEEE TCIAIG 4(2), 2012. Any other map of that
collection can be laid beside the three: each .scen file in the folder is run with its map. What
the three lack is made here: mazes, rooms and large maps, with the lengths that scipy finds.
"""

from __future__ import annotations

from functools import cache
from math import inf, sqrt
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from robocon_course.gridmap import GridMap, Scenario, load_map, load_scenarios
from robocon_course.planning import NoPathError, Replanner, astar

RESOLUTION, ORIGIN = 0.05, (-1.35, 20.2)  # m; lengths must not depend on where a map lies


@cache
def collection(folder: Path) -> list[tuple[GridMap, list[Scenario]]]:
    """Every map of a folder with its scenarios, in cells; several may belong to one map."""
    found = []
    for path in sorted((folder / "grid_maps").glob("*.map")):
        grid = GridMap(load_map(path).free, RESOLUTION, ORIGIN)
        for scenarios in sorted(path.parent.glob(f"{path.stem}*.scen")):
            pairs = load_scenarios(scenarios, grid)
            found.append((grid, [pair._replace(length=pair.length / RESOLUTION) for pair in pairs]))
    return found


def test_the_maps_are_those_the_readme_counts(recordings):
    pairs = {grid.shape: len(scenarios) for grid, scenarios in collection(recordings)}
    assert {(49, 49): 160, (81, 65): 320, (32, 32): 409}.items() <= pairs.items()


def test_every_published_length_is_found(recordings):
    for grid, scenarios in collection(recordings):
        for start, goal, length in scenarios:
            plan = astar(grid, start, goal)
            # Printed with six significant digits.
            assert plan.length / RESOLUTION == pytest.approx(length, abs=1e-3)


def test_every_way_ends_in_the_middle_of_the_cells_asked_for(recordings):
    for grid, scenarios in collection(recordings):
        for start, goal, _ in scenarios:
            plan = astar(grid, start, goal)
            np.testing.assert_array_equal(plan.xy[[0, -1]], [start, goal])
            np.testing.assert_array_equal(plan.xy, grid.centres(plan.cells))


def test_the_incremental_search_finds_every_tenth_published_length(recordings):
    for grid, scenarios in collection(recordings):
        for start, goal, length in scenarios[::10]:
            plan = Replanner(goal).plan(grid, start)
            assert plan.length / RESOLUTION == pytest.approx(length, abs=1e-3)


def test_with_corners_cut_the_published_lengths_are_too_long(recordings):
    shorter = 0
    for grid, scenarios in collection(recordings):
        for start, goal, length in scenarios[::5]:
            cut = astar(grid, start, goal, cut_corners=True).length / RESOLUTION
            assert cut <= length + 1e-3
            shorter += cut < length - 1e-3
    assert shorter > 50


# --- maps made here ---------------------------------------------------------------------------


def maze(side: int, seed: int) -> np.ndarray:
    """Corridors one cell wide between walls one cell wide, without a loop; side is odd."""
    rng = np.random.default_rng(seed)
    free = np.zeros((side, side), dtype=bool)
    free[0, 0], way = True, [(0, 0)]
    while way:  # dig on from where it ended, or from further back
        row, col = way[-1]
        for k in rng.permutation(4):
            dr, dc = ((0, 1), (1, 0), (0, -1), (-1, 0))[k]
            to = row + 2 * dr, col + 2 * dc
            if 0 <= min(to) and max(to) < side and not free[to]:
                free[to] = free[row + dr, col + dc] = True
                way.append(to)
                break
        else:
            way.pop()
    return free


def rooms(side: int, seed: int, room: int = 15) -> np.ndarray:
    """Square rooms with a door, or none, in each wall."""
    rng = np.random.default_rng(seed)
    free = np.ones((side, side), dtype=bool)
    free[room :: room + 1] = free[:, room :: room + 1] = False
    for row in range(0, side, room + 1):
        for col in range(0, side, room + 1):
            across, along = rng.integers(0, room, 2)
            if rng.random() < 0.8:
                free[min(row + across, side - 1), min(col + room, side - 1)] = True
            if rng.random() < 0.8:
                free[min(row + room, side - 1), min(col + along, side - 1)] = True
    return free


def serpentine(side: int) -> np.ndarray:
    """One corridor, to and fro: the longest way there can be; side is 1 more than 4 n."""
    free = np.ones((side, side), dtype=bool)
    free[1::2] = False
    free[1::4, -1] = free[3::4, 0] = True
    return free


def strewn(side: int, seed: int) -> np.ndarray:
    """Single obstacles on two cells of five: just about a way through."""
    return np.random.default_rng(seed).random((side, side)) > 0.4


def lengths_from(free: np.ndarray, start: tuple[int, int]) -> np.ndarray:
    """Length of the shortest way to every cell [cells], by scipy: no corner is cut."""
    number = np.arange(free.size).reshape(free.shape)
    rows, cols, lengths = [], [], []
    for dr, dc in ((0, 1), (1, 0), (1, 1), (1, -1)):
        up, right = max(dr, 0), max(dc, 0)
        here = (slice(0, free.shape[0] - up), slice(right - dc, free.shape[1] - right))
        there = (slice(up, None), slice(right, free.shape[1] + min(dc, 0)))
        open_ = free[here] & free[there]
        if dr and dc:
            open_ &= free[here[0], there[1]] & free[there[0], here[1]]
        rows.append(number[here][open_])
        cols.append(number[there][open_])
        lengths.append(np.full(open_.sum(), sqrt(dr * dr + dc * dc)))
    edges = np.concatenate(lengths), (np.concatenate(rows), np.concatenate(cols))
    graph = coo_array(edges, shape=(free.size, free.size)).tocsr()
    return dijkstra(graph, directed=False, indices=number[start]).reshape(free.shape)


def test_the_lengths_to_compare_with_are_right_by_hand():
    free = np.array([[c == "." for c in line] for line in ("..#.", "....", "#...")])
    shortest = lengths_from(free, (0, 0))
    assert shortest[0, 1] == 1.0 and shortest[1, 1] == sqrt(2.0)
    assert shortest[1, 2] == pytest.approx(1.0 + sqrt(2.0))  # not past the corner at (0, 2)
    assert shortest[0, 3] == pytest.approx(3.0 + sqrt(2.0)) and shortest[0, 2] == inf


MADE = {
    "maze": lambda large: maze(1023 if large else 201, seed=1),
    "another maze": lambda large: maze(511 if large else 101, seed=2),
    "serpentine": lambda large: serpentine(1025 if large else 201),
    "rooms": lambda large: rooms(1024 if large else 250, seed=3),
    "strewn": lambda large: strewn(1024 if large else 250, seed=4),
    "field of nothing": lambda large: np.ones((1024, 1024) if large else (90, 200), dtype=bool),
}


@pytest.mark.campaign
@pytest.mark.parametrize("kind", MADE)
def test_on_maps_made_here_every_way_is_as_long_as_scipy_says(kind, whole):
    free = MADE[kind](whole)
    rng, grid = np.random.default_rng(5), GridMap(free, 1.0)
    cells = np.argwhere(free)
    for start in cells[[0, rng.integers(len(cells))]]:
        shortest = lengths_from(free, tuple(start))
        goals = [start, cells[-1], *cells[rng.integers(0, len(cells), 12)]]
        for goal, wanted in ((goal, shortest[tuple(goal)]) for goal in goals):
            ends = grid.centres([start, goal])
            if wanted == inf:
                with pytest.raises(NoPathError, match="no way leads"):
                    astar(grid, *ends)
            else:
                # A thousandth is asked for; sums of a million terms agree to 10^-7.
                assert astar(grid, *ends).length == pytest.approx(wanted, abs=1e-6)
                assert astar(grid, *ends, weight=0).length == pytest.approx(wanted, abs=1e-6)


def test_from_a_cell_that_is_walled_in_no_way_is_found_on_a_large_map():
    free = np.ones((1024, 1024), dtype=bool)
    free[499:502, 499:502], free[500, 500] = False, True
    grid = GridMap(free, 1.0)
    inside, outside = grid.centres([[500, 500], [0, 0]])
    with pytest.raises(NoPathError, match="only 1 of the 1048568 free cells"):
        astar(grid, inside, outside)
    with pytest.raises(NoPathError, match="only 1048567 of the 1048568 free cells"):
        astar(grid, outside, inside)
    assert astar(grid, inside, inside).length == 0.0
