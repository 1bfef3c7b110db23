"""Chapter 04 on benchmark maps of other people: every published length, exactly.

N. Sturtevant, Benchmarks for Grid-Based Pathfinding, IEEE TCIAIG 4(2), 2012. Any other map of that
collection can be laid beside the three: each .scen file in the folder is run with its map.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from robocon_course.gridmap import GridMap
from robocon_course.planning import Replanner, astar

MAPS = ("arena", "den312d", "random-32-32-20")
RESOLUTION, ORIGIN = 0.05, (-1.35, 20.2)  # m; lengths must not depend on where a map lies
PASSABLE = b".GS"


class Scenario(NamedTuple):
    """A pair of points [m] with the length of the shortest way [cells]."""

    start: tuple[float, float]
    goal: tuple[float, float]
    length: float


def load_octile(path: Path) -> GridMap:
    """A .map file; its first line is the largest y."""
    kind, height, width, word, *lines = path.read_text(encoding="ascii").split("\n")
    assert (kind, word) == ("type octile", "map")
    shape = int(height.removeprefix("height ")), int(width.removeprefix("width "))
    rows = np.array([list(line.encode()) for line in lines if line], dtype=np.uint8)
    assert rows.shape == shape
    return GridMap(np.isin(rows, list(PASSABLE))[::-1], RESOLUTION, ORIGIN)


def load_scenarios(path: Path, grid: GridMap) -> list[Scenario]:
    """All pairs of a .scen file; x counts columns, y counts rows from the top."""
    head, *lines = path.read_text(encoding="ascii").splitlines()
    assert head.startswith("version")
    pairs = []
    for line in filter(None, lines):
        _, _, width, height, x0, y0, x1, y1, length = line.split("\t")
        assert (int(height), int(width)) == grid.shape
        ends = [[grid.shape[0] - 1 - int(y), int(x)] for x, y in ((x0, y0), (x1, y1))]
        start, goal = grid.centres(ends).tolist()
        pairs.append(Scenario(tuple(start), tuple(goal), float(length)))
    return pairs


def collection(folder: Path) -> list[tuple[GridMap, list[Scenario]]]:
    """Every map of a folder with its scenarios; several may belong to one map."""
    found = []
    for path in sorted((folder / "grid_maps").glob("*.map")):
        grid = load_octile(path)
        for scenarios in sorted(path.parent.glob(f"{path.stem}*.scen")):
            found.append((grid, load_scenarios(scenarios, grid)))
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
