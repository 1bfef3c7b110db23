"""The field's numbers against the table they come from, and against each other."""

from __future__ import annotations

import importlib.util
import itertools
import math

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from conftest import ROOT
from robocon_course import field
from robocon_course.field.standing import standing
from robocon_course.files import data_file
from robocon_course.gridmap import GridMap, inflate, load_map
from robocon_course.raycast import walk
from robocon_course.robot import MODULES


def rects() -> list[field.Rect]:
    return [value for value in vars(field).values() if isinstance(value, field.Rect)]


def lines() -> list[field.Line]:
    return [*field.GUIDE_LINES, *field.FRAME_LINES, *field.ROBOT_1_LINES, *field.STEPS]


def overlap(one: field.Rect, other: field.Rect) -> float:
    """Common area of two rectangles."""
    width = min(one.x1, other.x1) - max(one.x0, other.x0)
    height = min(one.y1, other.y1) - max(one.y0, other.y0)
    return max(0.0, width) * max(0.0, height)


def area(rect: field.Rect) -> float:
    return (rect.x1 - rect.x0) * (rect.y1 - rect.y0)


def test_the_silos_stand_on_the_centre_line_750_mm_apart():
    expected = [(6.0, 8.5), (6.0, 9.25), (6.0, 10.0), (6.0, 10.75), (6.0, 11.5)]
    assert list(field.SILOS) == expected
    assert all(field.SILO_ZONE.contains(*silo) for silo in field.SILOS)


def test_the_floor_tiles_our_half_and_the_strip_without_gap_or_overlap():
    total = sum(area(rect) for rect in field.FLOOR)
    assert total == pytest.approx(field.SILO_ZONE.x1 * field.SIZE, abs=1e-9)
    for one, other in itertools.combinations(field.FLOOR, 2):
        assert overlap(one, other) == 0.0, f"{one.name} overlaps {other.name}"


def test_the_strip_lies_evenly_about_the_centre_line():
    for rect in (field.SILO_ZONE, field.DIVIDER_1, field.DIVIDER_2):
        assert rect.centre[0] == pytest.approx(field.SIZE / 2)


def test_zones_do_not_overlap_each_other():
    for one, other in itertools.combinations([*field.ZONES, field.WATER_FRAME], 2):
        assert overlap(one, other) == pytest.approx(0.0), f"{one.name} overlaps {other.name}"


@pytest.mark.parametrize(
    ("inner", "outer"),
    [
        (field.START_ZONE, field.AREA_1),
        (field.START_ZONE_R1, field.AREA_1),
        (field.SEEDLING_RACK, field.AREA_1),
        (field.RAMP_1, field.AREA_1),
        (field.RETRY_ZONE, field.AREA_2),
        (field.RAMP_2, field.AREA_2),
        (field.WATER_FRAME, field.AREA_2),
        (field.WATER, field.WATER_FRAME),
    ],
    ids=lambda rect: rect.name,
)
def test_a_zone_lies_inside_its_area(inner, outer):
    assert overlap(inner, outer) == pytest.approx(area(inner))


def test_everything_lies_inside_the_fence():
    corners = [(r.x0, r.y0) for r in rects()] + [(r.x1, r.y1) for r in rects()]
    ends = [(l.x0, l.y0) for l in lines()] + [(l.x1, l.y1) for l in lines()]
    spots = [*field.PILE_BALLS, *field.HARVEST_SPOTS, *field.PLANTING_SPOTS, *field.SILOS]
    for x, y in [*corners, *ends, *spots, *field.WAY_TO_AREA_3, *field.SEEDLING_HOLES]:
        assert 0.0 <= x <= field.SIZE and 0.0 <= y <= field.SIZE


def test_every_rectangle_has_its_corners_in_order():
    for rect in rects():
        assert rect.x0 < rect.x1 and rect.y0 < rect.y1, rect.name


@pytest.mark.parametrize(
    ("ramp", "foot", "top"),
    [
        (field.RAMP_1, field.AREA_1, field.AREA_2),
        (field.RAMP_2, field.AREA_2, field.AREA_3),
    ],
)
def test_a_ramp_joins_the_floors_below_and_above_it(ramp, foot, top):
    x, _ = ramp.centre
    assert ramp.height_at(x, ramp.y0) == pytest.approx(foot.height)
    assert ramp.height_at(x, ramp.y1) == pytest.approx(top.height)
    assert top.contains(x, ramp.y1)


def test_the_side_slope_joins_storage_zone_and_platform():
    slope = field.SIDE_SLOPE
    assert slope.height_at(slope.x0, 10.0) == pytest.approx(field.STORAGE_ZONE.height)
    assert slope.height_at(slope.x1, 10.0) == pytest.approx(field.AREA_3.height)


def test_the_program_s_points_lie_where_the_source_puts_them():
    assert field.START_ZONE.contains(*field.START)
    assert field.START[1] == pytest.approx(field.START_ZONE.centre[1])
    assert field.AREA_3_GOAL == pytest.approx((field.RAMP_2.centre[0], field.SILOS[2][1]))
    assert field.AREA_3.contains(*field.SILO_POST)
    assert math.dist(field.PILE_TARGET, field.PILE) < field.PILE_HALF_DIAGONAL
    # Above this line the whole robot is over the edge of Area 3, however it is turned (0.46 m).
    assert field.AREA_3_LINE - field.AREA_3.y0 == pytest.approx(0.325 * math.sqrt(2), abs=0.01)


def test_the_middles_of_the_silos_span_80_degrees_seen_from_the_post():
    x, y = field.SILO_POST
    bearings = [math.degrees(math.atan2(b - y, a - x)) for a, b in field.SILOS]
    assert bearings[-1] - bearings[0] == pytest.approx(80.0, abs=1.0)
    assert bearings[2] == pytest.approx(0.0, abs=1.0)  # silo 3 lies straight ahead


def test_the_way_to_area_3_climbs_both_ramps_and_keeps_off_water_and_steps():
    half = 0.325
    for (xa, ya), (xb, yb) in itertools.pairwise(field.WAY_TO_AREA_3):
        for k in range(101):
            x, y = xa + (xb - xa) * k / 100, ya + (yb - ya) * k / 100
            body = field.Rect("body", x - half, y - half, x + half, y + half, 0.0, field.GREY)
            assert overlap(body, field.WATER_FRAME) == 0.0
            for step in field.STEPS:
                crossed = body.y0 < step.y0 < body.y1 and body.x1 > step.x0
                assert not crossed, f"the body stands on a step at ({x:.2f}, {y:.2f})"


def test_the_pile_is_a_square_of_touching_balls_turned_by_45_degrees():
    mean = [sum(axis) / 16 for axis in zip(*field.PILE_BALLS, strict=True)]
    assert mean == pytest.approx(field.PILE)
    nearest = [
        min(math.dist(ball, other) for other in field.PILE_BALLS if other != ball)
        for ball in field.PILE_BALLS
    ]
    assert nearest == pytest.approx([field.BALL_DIAMETER] * 16)
    assert max(x for x, _ in field.PILE_BALLS) - field.PILE[0] == pytest.approx(0.403, abs=1e-3)


def test_the_balls_are_as_many_as_the_rules_say():
    assert field.PILE_EXAMPLE.count(field.RED) == 6
    assert field.PILE_EXAMPLE.count(field.PURPLE) == 10
    assert field.HARVEST_EXAMPLE.count(field.RED) == field.HARVEST_EXAMPLE.count(field.PURPLE) == 6
    assert len(field.PLANTING_SPOTS) == len(field.HARVEST_SPOTS) == len(field.SEEDLING_HOLES) == 12


def test_the_upper_row_of_the_harvest_starts_with_an_empty_grain():
    colours = dict(zip(field.HARVEST_SPOTS, field.HARVEST_EXAMPLE, strict=True))
    assert colours[(2.375, 5.75)] == field.PURPLE
    assert colours[(2.375, 5.25)] == field.RED
    assert colours[(4.875, 5.75)] == field.RED


# --- obstacles --------------------------------------------------------------------------------

CLEARANCE = 0.325
"""Half of the robot's side [m]."""


def reachable(grid: GridMap) -> bool:
    """Whether a round robot gets from the start to the goal in Area 3."""
    room = inflate(grid, CLEARANCE)
    labels, _ = ndimage.label(room.free)
    start, goal = (labels[tuple(room.cells(point))] for point in (field.START, field.AREA_3_GOAL))
    return bool(start and start == goal)


def closed(grid: GridMap, rect: field.Rect) -> GridMap:
    """The map with a rectangle blocked."""
    middles = grid.centres(np.moveaxis(np.indices(grid.shape), 0, -1))
    x, y = np.moveaxis(middles, -1, 0)
    inside = (rect.x0 < x) & (x < rect.x1) & (rect.y0 < y) & (y < rect.y1)
    return GridMap(grid.free & ~inside, grid.resolution, grid.origin)


def test_every_obstacle_lies_in_the_picture_and_has_its_corners_in_order():
    low, high = -field.FENCE_THICKNESS, field.SIZE + field.FENCE_THICKNESS
    for rect in field.OBSTACLES:
        assert low <= rect.x0 < rect.x1 <= high and low <= rect.y0 < rect.y1 <= high, rect.name
        assert 0.05 < rect.height <= 0.35, rect.name


def test_the_fences_close_our_half_without_a_gap():
    for fence in field.FENCES:
        assert min(fence.x1 - fence.x0, fence.y1 - fence.y0) == pytest.approx(0.05)
    outer = [f for f in field.FENCES if f.x1 == 0.0]
    assert [f.y0 for f in outer[1:]] == [f.y1 for f in outer[:-1]]
    assert outer[0].y0 == -0.05 and outer[-1].y1 == 12.05


def test_a_fence_stands_100_mm_above_the_floor_beside_it_and_200_mm_in_the_storage_zone():
    tops = {f.name: f.height for f in field.FENCES}
    assert tops["fence of Area 1"] - field.AREA_1.height == pytest.approx(0.1)
    assert tops["fence of Area 2"] - field.AREA_2.height == pytest.approx(0.1)
    assert tops["fence of the Storage Zone"] - field.STORAGE_ZONE.height == pytest.approx(0.2)
    assert tops["end fence"] - field.AREA_3.height == pytest.approx(0.1)
    assert tops["start fence"] - field.AREA_1.height == pytest.approx(0.1)
    assert field.WATER_BACK.height - field.AREA_3.height == pytest.approx(0.1)


def test_a_ledge_lies_on_the_lower_floor_and_its_top_is_the_upper_one():
    for ledge in field.LEDGES:
        x, y = ledge.centre
        assert field.floor_height(x, y) <= ledge.height - 0.1 + 1e-9, ledge.name
        assert min(ledge.x1 - ledge.x0, ledge.y1 - ledge.y0) == pytest.approx(0.05)


@pytest.mark.parametrize("resolution", [0.01, 0.05])
def test_a_robot_gets_to_area_3_over_both_ramps_and_only_over_them(resolution):
    grid = field.obstacle_map(resolution)
    assert reachable(grid)
    assert not reachable(closed(grid, field.RAMP_1))
    assert not reachable(closed(grid, field.RAMP_2))


@pytest.mark.parametrize(
    ("name", "ramp"), [("ledge of Area 2", field.RAMP_1), ("ledge of Area 3", field.RAMP_2)]
)
def test_without_a_ledge_there_would_be_a_way_beside_its_ramp(name, ramp):
    rest = [rect for rect in field.OBSTACLES if rect.name != name]
    assert reachable(closed(drawn(rest), ramp))


def drawn(rects) -> GridMap:
    """A map of 5 cm with these obstacles, by the definition: a cell that one overlaps."""
    grid = field.obstacle_map(0.05)
    corners = grid.centres(np.moveaxis(np.indices(grid.shape), 0, -1)) - 0.025
    x, y = np.moveaxis(corners, -1, 0)
    free = np.ones(grid.shape, dtype=bool)
    for r in rects:
        hit = (x < r.x1 - 1e-6) & (x + 0.05 > r.x0 + 1e-6)
        free &= ~(hit & (y < r.y1 - 1e-6) & (y + 0.05 > r.y0 + 1e-6))
    return GridMap(free, 0.05, grid.origin)


def test_the_frame_of_the_pile_is_no_obstacle():
    x, y = field.PILE
    corner = (x + field.PILE_HALF_DIAGONAL - field.PILE_FRAME_WIDTH / 2, y)
    assert field.obstacle_map().is_free([field.PILE, corner]).all()
    assert not any(rect.contains(*corner) for rect in field.OBSTACLES)


def test_the_obstacle_map_is_the_obstacles_drawn_cell_by_cell():
    assert (field.obstacle_map(0.05).free == drawn(field.OBSTACLES).free).all()


def test_the_free_area_is_what_a_ruler_says():
    free = field.obstacle_map().free.sum() * 0.01**2
    half = 5.87 * 12.0  # the cell that the strip's edge at 5.875 cuts is not free
    rack, water = 3.25 * 0.25, 3.8 * 1.0
    ledges = 4.87 * 0.05 + 0.05 * 0.95 + 1.07 * 0.05 + 0.05 * 0.95
    assert free == pytest.approx(half - rack - water - ledges, abs=1e-9)


def test_the_way_to_area_3_is_free_for_the_whole_robot():
    room = inflate(field.obstacle_map(), CLEARANCE)
    for one, other in itertools.pairwise(field.WAY_TO_AREA_3):
        assert room.is_free(np.linspace(one, other, 500)).all()


def test_no_cell_beyond_the_strip_and_none_in_a_fence_is_free():
    grid = field.obstacle_map()
    rows, cols = np.nonzero(grid.free)
    points = grid.centres(np.stack([rows, cols], axis=-1))
    assert points.min() > 0.0 and points[:, 0].max() < field.EDGE and points[:, 1].max() < 12.0


# --- heights ----------------------------------------------------------------------------------


@pytest.mark.parametrize("ramp", [field.RAMP_1, field.RAMP_2])
def test_the_floor_is_continuous_over_a_ramp_and_steps_beside_it(ramp):
    y = np.linspace(ramp.y0 - 0.5, ramp.y1 + 0.4, 1000)
    x = np.linspace(ramp.x0 + 0.01, ramp.x1 - 0.01, 7)
    height = field.floor_height(x, y[:, None])
    assert np.abs(np.diff(height, axis=0)).max() <= 0.1 * (y[1] - y[0]) + 1e-12
    assert height[-1] - height[0] == pytest.approx(0.1)
    beside = ramp.x1 + 0.3
    low, high = field.floor_height(beside, [ramp.y1 - 1e-9, ramp.y1 + 1e-9])
    assert high - low == pytest.approx(0.1)


def test_the_side_slope_has_no_step_along_its_way_down_to_the_storage_zone():
    x = np.linspace(1.5, 4.0, 1000)
    height = field.floor_height(x, 9.0)
    assert np.abs(np.diff(height)).max() <= 0.1 * (x[1] - x[0]) + 1e-12
    assert height[[0, -1]].tolist() == pytest.approx([0.15, 0.25])


def test_the_floor_s_height_is_known_everywhere_and_mirrored():
    x, y = np.random.default_rng(2).uniform(-1.0, 13.0, (2, 2000))
    height = field.floor_height(x, y)
    assert np.isfinite(height).all() and height.min() >= 0.05 and height.max() <= 0.35
    assert height == pytest.approx(field.floor_height(12.0 - x, y), abs=1e-12)
    assert field.floor_height(-3.0, 2.0) == 0.05


def test_the_table_s_last_matching_row_holds():
    x, y = np.random.default_rng(4).uniform((0.0, 0.0), (6.0, 12.0), (500, 2)).T
    for a, b, height in zip(x, y, field.floor_height(x, y), strict=True):
        for x0, y0, x1, y1, foot, slope_x, slope_y in field.FLOOR_TABLE[::-1]:
            if x0 <= a <= x1 and y0 <= b <= y1:
                assert height == pytest.approx(foot + slope_x * (a - x0) + slope_y * (b - y0))
                break


@pytest.mark.parametrize(("x", "y"), [(math.nan, 1.0), (1.0, math.inf), ([1.0, 2.0], [1.0] * 3)])
def test_floor_height_refuses_points_that_are_none(x, y):
    with pytest.raises(ValueError, match=r"^[xy]: "):
        field.floor_height(x, y)


def test_the_height_map_is_the_floor_with_all_that_stands_on_it():
    height = field.height_map(0.05)
    grid = field.obstacle_map(0.05)
    assert height.shape == grid.shape and height.dtype == np.float32

    def at(x: float, y: float) -> float:
        return float(height[tuple(grid.cells([x, y]))])

    expected = {
        (3.0, 1.0): 0.05,
        (0.52, 3.52): 0.1025,  # on ramp 1: the middle of its cell lies at y = 3.525
        (2.0, 0.12): 0.11,
        (-0.02, 2.0): 0.15,
        (-0.02, 10.0): 0.35,
        (3.0, 12.02): 0.35,
        (2.0, 7.5): 0.05,
        (2.0, 7.02): 0.25,
        (2.0, 7.97): 0.35,
        (6.0, 2.0): 0.145,
        (6.0, 9.6): 0.35,
        (6.02, 10.02): 0.775,
    }
    for (x, y), z in expected.items():
        assert at(x, y) == pytest.approx(z, abs=1e-6), (x, y)
        assert at(12.0 - x - 1e-6, y) == pytest.approx(z, abs=1e-6), (x, y)


def test_a_beam_at_the_goal_meets_strip_end_fence_and_outer_fence():
    x, y = (np.array(field.AREA_3_GOAL) + 0.05) / 0.01
    beam = 0.25 + 0.05  # half the height of the boards
    cells = np.empty((0, 2), dtype=np.int64)
    for direction, distance in {(1, 0): 1.575, (0, 1): 2.0, (-1, 0): 4.3}.items():
        found, _ = walk(field.height_map(), x, y, beam, *map(float, direction), 0.0, 1200.0, cells)
        # The strip begins in the middle of a cell, which counts whole: half a cell.
        assert found * 0.01 == pytest.approx(distance, abs=0.005 + 1e-9)
    # Towards Area 1 the floor falls away: the beam passes over all boards.
    assert walk(field.height_map(), x, y, beam, 0.0, -1.0, 0.0, 1200.0, cells)[0] == 1200.0


# --- rasters ----------------------------------------------------------------------------------


@pytest.mark.parametrize("make", [field.obstacle_map, field.height_map, field.picture])
@pytest.mark.parametrize("resolution", [0.03, 0.0, -0.01, math.nan, 50.0, "fine"])
def test_a_resolution_that_does_not_divide_the_picture_is_refused(make, resolution):
    with pytest.raises(ValueError, match="resolution: "):
        make(resolution)


@pytest.mark.parametrize("resolution", [0.01, 0.02, 0.05, 0.1])
def test_rasters_are_made_once_cannot_change_and_are_mirror_images(resolution):
    for make in (field.height_map, field.picture):
        raster = make(resolution)
        assert raster is make(resolution) and not raster.flags.writeable
    height, pixels = field.height_map(resolution), field.picture(resolution)
    assert (height == height[:, ::-1]).all()
    assert (np.abs(pixels.astype(int) - pixels[:, ::-1]).sum(axis=-1) > 0).mean() < 0.02
    assert field.obstacle_map(resolution) is field.obstacle_map(resolution)


def colour_at(x: float, y: float) -> tuple[int, ...]:
    row, col = field.obstacle_map().cells([x, y])
    return tuple(int(c) for c in field.picture()[row, col])


@pytest.mark.parametrize(
    ("x", "y", "colour"),
    [
        (5.0, 1.0, field.ORANGE),
        (0.8, 3.5, field.ORANGE),
        (3.0, 4.5, field.GREEN),
        (1.0, 11.5, field.GREEN),
        (2.5, 11.5, field.YELLOW),
        (5.0, 8.2, field.YELLOW),
        (1.0, 7.5, field.WATER_BLUE),
        (3.78, 7.5, field.GREY),
        (0.2, 0.6, field.RED),
        (1.2, 0.3, field.RED),
        (0.1, 5.3, field.RED),
        (0.5, 2.0, field.WHITE),
        (0.3, 0.35, field.WHITE),
        (0.3, 5.5, field.WHITE),
        (4.3, 9.0, field.WHITE),
        (5.0, 10.0, field.WHITE),
        (2.25, 0.125, field.WHITE),
        (2.35, 0.125, field.GREY),
        (2.375, 2.75, field.WHITE),
        (4.875, 5.25, field.WHITE),
        (1.125, 10.57, field.GREY),
        (1.125, 10.0, field.GREEN),
        (-0.02, 6.0, field.GREY),
        (6.0, 10.2, field.GREY),
    ],
)
def test_the_picture_has_the_right_colour_in_both_halves(x, y, colour):
    assert colour_at(x, y) == colour
    other = field.BLUE if colour == field.RED else colour
    assert colour_at(12.0 - x, y) == other


def test_white_lines_are_30_mm_wide_and_meet_in_full_corners():
    white = (field.picture() == field.WHITE).all(axis=-1)
    row, col = field.obstacle_map().cells([0.5, 2.0])
    # 0.485 to 0.515, and a pixel whose middle lies on the upper edge is not in it
    assert np.flatnonzero(white[row, :100]).tolist() == [col - 2, col - 1, col]
    row, col = field.obstacle_map().cells([0.485, 6.425])
    assert white[row, col] and not white[row + 1, col] and not white[row, col - 1]


def test_the_colours_are_those_of_the_table():
    packed = np.unique(field.picture().astype(np.int64) @ [65536, 256, 1])
    pixels = np.stack([packed >> 16, packed >> 8 & 255, packed & 255], axis=-1)
    known = {field.ORANGE, field.GREEN, field.YELLOW, field.WATER_BLUE, field.GREY, field.WHITE}
    assert {tuple(map(int, p)) for p in pixels} == known | {field.RED, field.BLUE}


@pytest.mark.parametrize(("name", "resolution"), [("obstacles_1cm", 0.01), ("obstacles_5cm", 0.05)])
def test_the_map_files_hold_the_obstacle_map(name, resolution):
    loaded, drawn_now = load_map(data_file(f"field/{name}.yaml")), field.obstacle_map(resolution)
    assert (loaded.free == drawn_now.free).all()
    assert (loaded.resolution, loaded.origin) == (resolution, (-0.05, -0.05))


def test_the_picture_file_holds_the_picture_top_row_first():
    stored = np.asarray(Image.open(data_file("field/picture.png")))
    assert (stored == field.picture()[::-1]).all()


def test_the_files_are_made_again_by_their_script_and_small(tmp_path):
    spec = importlib.util.spec_from_file_location("make_field", ROOT / "data/field/make.py")
    make = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(make)
    make.main(tmp_path)
    for path in tmp_path.iterdir():
        stored = data_file(f"field/{path.name}")
        if path.suffix == ".yaml":
            assert path.read_text(encoding="utf-8") == stored.read_text(encoding="utf-8")
        else:
            assert (np.asarray(Image.open(path)) == np.asarray(Image.open(stored))).all()
    assert len(list(tmp_path.iterdir())) == 5
    assert sum(p.stat().st_size for p in data_file("field").iterdir()) < 400_000


# --- standing ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pose", "plane"),
    [
        ((3.0, 2.0, 0.7), (0.0, 0.0, 0.05)),  # Area 1
        ((0.5, 3.5, math.pi / 2), (0.1, 0.0, 0.10)),  # ramp 1, looking up
        ((0.5, 3.5, -math.pi / 2), (-0.1, 0.0, 0.10)),  # and down
        ((0.5, 3.5, 0.0), (0.0, 0.1, 0.10)),  # and along it
        ((2.75, 10.0, math.pi), (-0.1, 0.0, 0.20)),  # the side slope, towards the pile
        ((4.3, 10.0, 0.3), (0.0, 0.0, 0.25)),  # Area 3
    ],
)
def test_a_robot_stands_as_the_floor_under_its_wheels_slopes(pose, plane):
    assert standing(pose, MODULES) == pytest.approx(plane, abs=1e-9)


def test_half_on_the_ramp_it_stands_on_the_plane_nearest_to_its_wheels():
    pose = (0.5, 3.0, math.pi / 2)
    out = standing(pose, MODULES)
    heights = [
        float(field.floor_height(pose[0] - y, pose[1] + x)) for x, y in MODULES
    ]  # the base's axes, turned by a quarter
    A = np.column_stack([MODULES, np.ones(4)])
    expected, *_ = np.linalg.lstsq(A, heights, rcond=None)
    assert out == pytest.approx(expected, abs=1e-9) and 0.0 < out[0] < 0.1


def test_what_is_no_pose_stands_nowhere():
    with pytest.raises(ValueError, match="pose: expected shape"):
        standing((1.0, 2.0), MODULES)
