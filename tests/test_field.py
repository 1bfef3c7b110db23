"""The field's numbers against the table they come from, and against each other."""

from __future__ import annotations

import itertools
import math

import pytest

from robocon_course import field


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
