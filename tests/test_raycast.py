"""The walk from cell to cell, against geometry and against a twin that knows no cleverness."""

from __future__ import annotations

import gzip
from itertools import pairwise
from math import cos, floor, hypot, inf, nan, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robocon_course.gridmap import GridMap
from robocon_course.raycast import distances, walk

NO_CELLS = np.empty((0, 2), dtype=np.int64)
compiled = settings(deadline=None)  # the first call compiles
angles = st.floats(-2 * pi, 2 * pi)
heights = arrays(np.float32, (6, 8), elements=st.sampled_from([0.0, 0.05, 0.25, 1.0]))


def flight(height, x, y, angle, *, z=0.5, climb=0.0, reach=100.0, cells=NO_CELLS):
    """`walk` by angle."""
    height = np.asarray(height, dtype=np.float32)
    return walk(height, x, y, z, cos(angle), sin(angle), climb, reach, cells)


def naive_walk(height, x, y, z, dx, dy, dz, reach):
    """All crossings of grid lines, sorted; between two of them the ray stays in one cell."""
    rows, cols = height.shape
    crossings = {0.0, reach}
    for start, slope, count in ((x, dx, cols), (y, dy, rows)):
        if slope != 0.0:
            crossings |= {(line - start) / slope for line in range(count + 1)}
    times = sorted(t for t in crossings if 0.0 <= t <= reach)
    visited = []
    for enter, leave in pairwise(times):
        middle = (enter + leave) / 2
        row, col = floor(y + middle * dy), floor(x + middle * dx)
        if not (0 <= row < rows and 0 <= col < cols):
            break
        visited.append((row, col))
        if height[row, col] > z + dz * enter:
            return enter, visited
        if height[row, col] > z + dz * leave:
            return (height[row, col] - z) / dz, visited
    return reach, visited


# --- hand cases -------------------------------------------------------------------------------

WALL = np.zeros((5, 10))
WALL[:, 7] = 1.0


@pytest.mark.parametrize(
    ("angle", "distance"),
    [(0.0, 4.5), (pi / 4, 2.5 * sqrt(2)), (0.3, 4.5 / cos(0.3)), (-0.3, 4.5 / cos(0.3))],
)
def test_a_ray_ends_at_the_face_of_a_wall_or_flies_out_beside_it(angle, distance):
    reached, _ = flight(WALL, 2.5, 2.5, angle, reach=50.0)
    assert reached == pytest.approx(50.0 if angle == pi / 4 else distance, abs=1e-12)


def test_the_cells_are_listed_in_order_the_one_that_stops_the_ray_included():
    cells = np.zeros((20, 2), dtype=np.int64)
    _, visited = flight(WALL, 4.5, 1.7, 0.5, cells=cells)
    expected = [[1, 4], [1, 5], [2, 5], [2, 6], [3, 6], [3, 7]]
    # y = 2 is crossed at x = 5.05, y = 3 at x = 6.88
    assert visited == 6 and cells[:6].tolist() == expected and not cells[6:].any()


def test_cells_that_do_not_fit_are_counted_all_the_same():
    cells = np.full((2, 2), -1, dtype=np.int64)
    distance, visited = flight(WALL, 4.5, 1.7, 0.5, cells=cells)
    assert visited == 6 and cells.tolist() == [[1, 4], [1, 5]]
    assert (distance, visited) == flight(WALL, 4.5, 1.7, 0.5)


def test_a_start_below_the_surface_gets_nowhere():
    assert flight(WALL, 7.5, 2.5, 1.0) == (0.0, 1)


@pytest.mark.parametrize(("x", "y"), [(-0.1, 2.5), (10.1, 2.5), (5.0, -3.0), (5.0, 5.0)])
def test_a_start_outside_the_array_sees_nothing(x, y):
    for angle in (0.0, pi / 2, pi, 3.0, -1.0):
        assert flight(WALL, x, y, angle, reach=9.0) == (9.0, 0)


def test_a_wall_just_beyond_the_reach_is_not_met_and_one_just_before_it_is():
    assert flight(WALL, 2.5, 2.5, 0.0, reach=4.49)[0] == 4.49
    assert flight(WALL, 2.5, 2.5, 0.0, reach=4.51)[0] == 4.5


@pytest.mark.parametrize("quarter", range(4))
def test_rays_along_the_axes_work_with_exact_zeros(quarter):
    dx, dy = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][quarter]
    ring = np.ones((7, 7), dtype=np.float32)
    ring[1:-1, 1:-1] = 0.0
    for zero in (0.0, -0.0):
        start = 3.25, 3.25, 0.5, dx or zero, dy or zero
        assert walk(ring, *start, 0.0, 99.0, NO_CELLS)[0] == (2.75 if quarter < 2 else 2.25)


def test_a_ray_along_a_grid_line_looks_at_the_cells_above_it():
    floor_of_ones = np.zeros((2, 5))
    floor_of_ones[1, 3] = 1.0
    assert flight(floor_of_ones, 0.5, 1.0, 0.0) == (2.5, 4)


def test_no_ray_slips_between_two_cells_that_meet_in_a_corner():
    wall = np.zeros((6, 6))
    wall[[2, 3], [3, 2]] = 1.0  # they meet at (3, 3)
    for x, y, dx, dy in ((1.0, 1.0, 1.0, 1.0), (5.0, 5.0, -1.0, -1.0)):
        start = x, y, 0.5, dx * sqrt(0.5), dy * sqrt(0.5)
        distance, _ = walk(wall, *start, 0.0, 99.0, NO_CELLS)
        assert distance == pytest.approx(2.0 * sqrt(2), abs=1e-12)


def test_a_ray_through_a_free_corner_visits_one_of_the_two_cells_beside_it():
    cells = np.zeros((10, 2), dtype=np.int64)
    _, visited = walk(np.zeros((3, 3)), 0.5, 0.5, 0.5, sqrt(0.5), sqrt(0.5), 0.0, 99.0, cells)
    assert visited == 5
    assert np.abs(np.diff(cells[:5], axis=0)).sum(axis=1).tolist() == [1] * 4


# --- heights ----------------------------------------------------------------------------------


def test_a_ray_that_comes_down_ends_on_the_floor_between_two_grid_lines():
    distance, visited = flight(np.zeros((1, 20)), 0.25, 0.5, 0.0, z=0.05, climb=-0.01)
    assert distance == pytest.approx(5.0, abs=1e-12) and visited == 6
    assert flight(np.zeros((1, 20)), 0.25, 0.5, 0.0, z=0.05, climb=-0.01, reach=4.9) == (4.9, 6)


def test_a_ray_that_climbs_clears_a_board_and_one_that_does_not_meets_it():
    board = np.zeros((1, 20))
    board[0, 10] = 0.1
    # At x = 10 it is at 0.05 + 9.5 climb: 0.0994 or 0.1004.
    assert flight(board, 0.5, 0.5, 0.0, z=0.05, climb=0.0052)[0] == 9.5
    assert flight(board, 0.5, 0.5, 0.0, z=0.05, climb=0.0053)[0] == 100.0


def test_a_ray_level_with_a_surface_passes_over_it():
    level = np.full((1, 5), 0.25)
    assert flight(level, 0.5, 0.5, 0.0, z=0.25)[0] == 100.0
    assert flight(level, 0.5, 0.5, 0.0, z=0.24)[0] == 0.0


def test_a_ray_comes_down_behind_a_board_that_it_clears():
    board = np.zeros((1, 30))
    board[0, 10] = 0.1
    distance, _ = flight(board, 0.5, 0.5, 0.0, z=0.3, climb=-0.015)
    assert distance == pytest.approx(20.0, abs=1e-6)
    # 0.3 - 0.019 * 10.5 = 0.1005 clears it too, 0.3 - 0.0195 * 10.5 = 0.095 ends on its top
    assert flight(board, 0.5, 0.5, 0.0, z=0.3, climb=-0.019)[0] > 11.0
    top = flight(board, 0.5, 0.5, 0.0, z=0.3, climb=-0.0195)[0]
    assert top == pytest.approx(0.2 / 0.0195, abs=1e-6) and 9.5 < top < 10.5


# --- properties -------------------------------------------------------------------------------


@compiled
@given(
    heights,
    st.floats(0.0, 7.999),
    st.floats(0.0, 5.999),
    angles,
    st.sampled_from([0.0, -0.02, -0.1, 0.03]),
    st.floats(0.1, 15.0),
)
def test_the_walk_agrees_with_its_naive_twin(height, x, y, angle, climb, reach):
    dx, dy, z = cos(angle), sin(angle), 0.2
    # A ray through a corner may visit either neighbour, and a start on a line either side.
    lines = [(k - x) / dx for k in range(9) if dx != 0.0]
    others = [(k - y) / dy for k in range(7) if dy != 0.0]
    assume(all(abs(a - b) > 1e-9 for a in lines for b in others))
    assume(min(abs(x - round(x)), abs(y - round(y))) > 1e-9)
    assume(all(abs(t - reach) > 1e-9 for t in lines + others))
    cells = np.zeros((40, 2), dtype=np.int64)
    distance, visited = walk(height, x, y, z, dx, dy, climb, reach, cells)
    expected, path = naive_walk(height.astype(float), x, y, z, dx, dy, climb, reach)
    assert distance == pytest.approx(expected, abs=1e-9)
    assert [tuple(cell) for cell in cells[:visited].tolist()] == path


@compiled
@given(st.integers(2, 40), st.integers(2, 40), st.floats(0.01, 0.99), st.floats(0.01, 0.99), angles)
@example(2, 27, 0.5, 1 / 3, -5e-324)  # along an edge, and 1 / slant would be infinite
def test_in_an_empty_box_the_distance_is_that_to_the_nearest_wall(width, depth, u, v, angle):
    free = np.zeros((depth + 2, width + 2), dtype=bool)
    free[1:-1, 1:-1] = True
    grid = GridMap(free, 0.25, (-0.25, -0.25))
    x, y = u * width * 0.25, v * depth * 0.25
    dx, dy = cos(angle), sin(angle)
    to_x = ((width * 0.25 if dx > 0 else 0.0) - x) / dx if abs(dx) > 1e-12 else inf
    to_y = ((depth * 0.25 if dy > 0 else 0.0) - y) / dy if abs(dy) > 1e-12 else inf
    found = distances(grid, [x, y], angle, 100.0)
    # Along a path of some 40 cells each edge is a sum of 40 terms: 40 x 40 x 2.2e-16 x 0.25 m.
    assert found == pytest.approx(min(to_x, to_y), abs=1e-11)


@compiled
@given(st.floats(0.5, 9.5), st.floats(0.5, 9.5), angles)
def test_what_one_end_sees_of_the_other_the_other_sees_of_it(x, y, angle):
    free = np.random.default_rng(3).random((10, 10)) > 0.15
    grid = GridMap(free, 1.0)
    assume(grid.is_free([x, y]))
    distance = float(distances(grid, [x, y], angle, 30.0))
    assume(1e-3 < distance < 30.0)
    shy = distance - 1e-6
    end = [x + shy * cos(angle), y + shy * sin(angle)]
    assert distances(grid, end, angle + pi, shy - 1e-6) == shy - 1e-6


def test_a_long_ray_gathers_no_error():
    grid = np.zeros((4000, 4000), dtype=np.float32)
    grid[:, -1] = 1.0
    for angle in (0.1, 0.5, 0.7853, pi / 4):
        reached, _ = flight(grid, 0.3, 0.4, angle, reach=1e6)
        # 8000 additions of numbers up to 5000: at most 8000 x 5000 x 1.1e-16 = 4e-9 cells.
        assert reached == pytest.approx(3998.7 / cos(angle), abs=5e-9)


# --- the door ---------------------------------------------------------------------------------


def room() -> GridMap:
    free = np.zeros((6, 8), dtype=bool)
    free[1:-1, 1:-1] = True
    return GridMap(free, 0.5, (-1.0, 2.0))


def test_distances_are_metres_from_points_of_the_map():
    found = distances(room(), [0.25, 3.0], [0.0, pi / 2, pi, -pi / 2], 9.0)
    assert found == pytest.approx([2.25, 1.5, 0.75, 0.5], abs=1e-12)


def test_a_start_on_an_edge_lies_in_the_cell_that_the_map_names():
    free = np.ones((4, 100), dtype=bool)
    free[:, 7] = False
    grid = GridMap(free, 0.05)
    # 0.35 / 0.05 is 6.999999999999999 in floating point: a start just before the wall.
    assert grid.cells([0.35, 0.1]).tolist() == [2, 7]
    assert distances(grid, [0.35, 0.1], [0.0, pi], 5.0).tolist() == [0.0, 0.0]
    assert distances(grid, [0.4, 0.1], [0.0, pi], 3.0).tolist() == [3.0, 0.0]


@pytest.mark.parametrize("far", [1e300, -1e300])
def test_a_start_far_off_the_map_measures_the_whole_range(far):
    assert distances(room(), [far, 3.0], [0.0, pi], 7.7).tolist() == [7.7, 7.7]


def test_origins_and_angles_are_broadcast():
    origins = np.array([[0.25, 3.0], [1.0, 4.0], [1.5, 3.3]])
    fan = np.linspace(0.0, 6.0, 5)
    found = distances(room(), origins[:, None], fan, 9.0)
    assert found.shape == (3, 5)
    each = [[float(distances(room(), origin, angle, 9.0)) for angle in fan] for origin in origins]
    assert found.tolist() == each
    assert distances(room(), origins, fan[:3], 9.0).tolist() == [each[k][k] for k in range(3)]
    assert distances(room(), np.empty((0, 2)), np.empty(0), 9.0).shape == (0,)


def test_what_is_not_met_measures_the_whole_range():
    grid = GridMap(np.ones((4, 4), dtype=bool), 0.3)
    assert distances(grid, [0.5, 0.5], [0.1, 2.0], 0.2).tolist() == [0.2, 0.2]
    assert distances(grid, [0.5, 0.5], [0.1, 2.0], 7.7).tolist() == [7.7, 7.7]
    assert distances(grid, [5.0, 0.5], pi, 7.7) == 7.7
    assert distances(room(), [-0.9, 2.1], 0.0, 7.7) == 0.0


@pytest.mark.parametrize(
    ("origins", "directions", "reach", "sentence"),
    [
        ([nan, 0.0], 0.0, 1.0, r"origins: .*not a finite number"),
        ([0.0, inf], 0.0, 1.0, r"origins: .*not a finite number"),
        ([0.0, 0.0, 0.0], 0.0, 1.0, "origins: expected shape"),
        ([0.0, 0.0], nan, 1.0, r"angles: .*not a finite number"),
        ([0.0, 0.0], "north", 1.0, "angles: expected numbers"),
        ([0.0, 0.0], 0.0, 0.0, "max_range: must be a positive"),
        ([0.0, 0.0], 0.0, nan, "max_range: must be a positive"),
        (np.zeros((3, 2)), np.zeros(5), 1.0, r"k rays from each of n points"),
    ],
)
def test_distances_refuses_what_makes_no_sense(origins, directions, reach, sentence):
    with pytest.raises(ValueError, match=sentence):
        distances(room(), origins, directions, reach)


# --- a recorded corridor ----------------------------------------------------------------------


def test_a_corridor_built_of_its_own_scans_is_measured_as_it_was(recordings):
    path = recordings / "laser_seattle" / "seattle-corrected.log.gz"
    with gzip.open(path, "rt", errors="replace") as file:
        rows = [line.split() for line in file if line.startswith("FLASER")]
    rows = [row for row in rows if row[1] == "361"][::20]
    ranges = np.array([row[2:363] for row in rows], dtype=float)
    poses = np.array([row[363:366] for row in rows], dtype=float)
    fan = poses[:, 2:] + np.radians(np.arange(-90.0, 90.1, 0.5))
    seen = ranges < 20.0
    ends = poses[:, None, :2] + ranges[..., None] * np.stack([np.cos(fan), np.sin(fan)], -1)
    grid = GridMap(np.ones((1200, 1600), dtype=bool), 0.1, (-80.0, -60.0))
    hits = ends[seen]
    assert len(rows) > 10 and grid.contains(hits).all()
    free = grid.free.copy()
    free[tuple(grid.cells(hits).T)] = False
    grid = GridMap(free, grid.resolution, grid.origin)
    found = distances(grid, poses[:, None, :2], fan, 30.0)[seen]
    # Each ray meets the cell of its own end at the latest, whose far corner is 0.1 m x √2 away;
    # it may end earlier where another scan saw something that had moved.
    assert (found <= ranges[seen] + 1e-9).all()
    assert np.median(ranges[seen] - found) < hypot(0.1, 0.1)
