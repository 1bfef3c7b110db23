"""Where a ball is: bearings and ranges from boxes, and what a robot wants to know of them."""

from __future__ import annotations

from math import atan2, hypot, pi

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course.simulator.camera import FieldCamera
from robocon_course.vision.camera import MOUNT, Camera, camera_pose, looking
from robocon_course.vision.detection import Detections
from robocon_course.vision.locate import (
    EDGE_SIGMA,
    bearing_and_range,
    locate_ball,
    nearest_own_ball,
    on_floor,
    silo_contents,
)

PLAIN = Camera(320, 240, 300.0, 0.0)
WAY = np.random.default_rng(0).normal(size=(20_000, 3))
WAY /= np.linalg.norm(WAY, axis=1, keepdims=True)


def outline(camera: Camera, tilt: float, centre) -> np.ndarray:
    """Box of a ball in the robot frame of a lens at the origin, 0.42 m above the floor."""
    T = looking((0.0, 0.0, MOUNT[2]), 0.0, tilt)
    seen = camera.pixels((np.asarray(centre) + 0.095 * WAY - T[:3, 3]) @ T[:3, :3])
    return np.r_[seen.min(axis=0), seen.max(axis=0)]


def test_a_ball_one_metre_ahead_by_hand():
    # Seen under 2 asin(0.095 / 1); its edges at 300 tan of half of that.
    half = 300 * 0.095 / np.sqrt(1 - 0.095**2)
    found = bearing_and_range((160 - half, 120 - half, 160 + half, 120 + half), PLAIN)
    assert found.bearing == 0.0
    assert found.range == pytest.approx(1.0, rel=1e-6)


@given(st.floats(0.4, 4.0), st.floats(-0.45, 0.45), st.floats(0.0, 0.5))
def test_a_projected_ball_is_found_where_it_is(far, bearing, tilt):
    camera = Camera(320, 240, 300.0, -0.05)
    centre = (far * np.cos(bearing), far * np.sin(bearing), 0.095)
    box = outline(camera, tilt, centre)
    for found in (
        bearing_and_range(box, camera, tilt),
        on_floor(box, camera, tilt, MOUNT[2]),
        locate_ball(box, camera, tilt, MOUNT[2]),
    ):
        assert abs(found.bearing - bearing) < max(found.bearing_sigma, 0.004)
        assert abs(found.range - far) < max(found.range_sigma, 0.01 * far)


def test_deviations_are_those_of_shaken_boxes():
    rng, box = np.random.default_rng(1), outline(PLAIN, 0.2, (1.5, 0.3, 0.095))
    shaken = box + rng.normal(0, EDGE_SIGMA, (4000, 4))
    for ruler in (
        lambda b: bearing_and_range(b, PLAIN, 0.2),
        lambda b: on_floor(b, PLAIN, 0.2, MOUNT[2]),
    ):
        found = np.array([ruler(b)[:2] for b in shaken])
        said = ruler(box)
        assert said.bearing_sigma == pytest.approx(found[:, 0].std(), rel=0.35)
        assert said.range_sigma == pytest.approx(found[:, 1].std(), rel=0.5)


def test_both_rulers_together_are_surer_than_either():
    box = outline(PLAIN, 0.2, (2.0, 0.0, 0.095))
    both = locate_ball(box, PLAIN, 0.2, MOUNT[2])
    size, floor = bearing_and_range(box, PLAIN, 0.2), on_floor(box, PLAIN, 0.2, MOUNT[2])
    assert both.range_sigma < min(size.range_sigma, floor.range_sigma)
    assert min(size.range, floor.range) <= both.range <= max(size.range, floor.range)


def test_left_is_positive_and_right_is_negative():
    assert bearing_and_range(outline(PLAIN, 0, (1, 0.3, 0.4)), PLAIN).bearing > 0.25
    assert bearing_and_range(outline(PLAIN, 0, (1, -0.3, 0.4)), PLAIN).bearing < -0.25


def test_half_a_ball_at_the_border_keeps_its_range_and_loses_certainty():
    whole = outline(PLAIN, 0, (1.0, 0.5, 0.4))
    cut = whole.copy()
    cut[0] = (whole[0] + whole[2]) / 2
    there, here = bearing_and_range(cut, PLAIN), bearing_and_range(whole, PLAIN)
    assert there.range == pytest.approx(here.range, rel=0.06)
    assert there.range_sigma > 5 * here.range_sigma
    assert abs(there.bearing - here.bearing) < there.bearing_sigma


def test_a_ball_in_a_corner_of_the_picture_is_not_said_to_be_sure():
    rng, compared, slivers = np.random.default_rng(4), 0, 0
    for _ in range(1500):
        far, bearing, tilt = rng.uniform((0.35, 0.3, 0.0), (1.5, 0.6, 0.6))
        bearing *= rng.choice([-1, 1])
        box = outline(PLAIN, tilt, (far * np.cos(bearing), far * np.sin(bearing), 0.095))
        seen = np.clip(box, 0, (320, 240, 320, 240))
        sides, whole = seen[2:] - seen[:2], box[2:] - box[:2]
        if not (np.isfinite(box).all() and (sides < whole).all() and (sides > 6).all()):
            continue
        found = locate_ball(seen, PLAIN, tilt, MOUNT[2])
        # Of what is cut by half each way at most, the truth lies within one deviation; slivers that
        # show less still within four.
        half = (sides >= whole / 2).all()
        compared, slivers = compared + half, slivers + (not half)
        assert abs(found.range - far) < (1 if half else 4) * found.range_sigma
        assert abs(found.bearing - bearing) < (1 if half else 4) * found.bearing_sigma
    assert compared > 30 and slivers > 10


def test_one_border_takes_nothing_from_the_certainty_and_a_corner_does():
    box = outline(PLAIN, 0.2, (1.0, 0.0, 0.095))
    aside, down = (box[0], 0, box[0], 0), (0, 240 - box[3], 0, 240 - box[3])
    places = (box - aside + 5, box - aside, box - aside + down)
    free, at_border, in_corner = (locate_ball(b, PLAIN, 0.2, MOUNT[2]) for b in places)
    assert at_border.bearing_sigma == pytest.approx(free.bearing_sigma, rel=0.3)
    assert at_border.range_sigma == pytest.approx(free.range_sigma, rel=0.3)
    assert in_corner.bearing_sigma > 5 * at_border.bearing_sigma


def test_a_ball_above_the_horizon_is_not_on_the_floor():
    box = outline(PLAIN, 0.0, (1.0, 0.0, 0.8))
    assert on_floor(box, PLAIN, 0.0, 0.42).range == np.inf
    assert locate_ball(box, PLAIN, 0.0, 0.42) == bearing_and_range(box, PLAIN, 0.0)


def test_a_ball_in_the_simulators_picture_is_found_on_the_field():
    eye, pose, tilt = FieldCamera(4), (3.6, 10.0, pi), 0.25
    for x, y in ((1.5, 9.7), (2.0, 10.4), (1.2, 10.0)):
        taken = eye.look(pose, tilt=tilt, balls=[((x, y, 0.15 + 0.095), "red")])
        T = camera_pose(pose, 0.25)
        found = locate_ball(taken.boxes[0], Camera(), tilt, T[2, 3] - 0.15)
        dx, dy = x - T[0, 3], y - T[1, 3]
        assert found.range == pytest.approx(hypot(dx, dy), abs=3 * found.range_sigma)
        bearing = (atan2(dy, dx) - pi + pi) % (2 * pi) - pi
        assert found.bearing == pytest.approx(bearing, abs=0.01)


@pytest.mark.parametrize(
    ("box", "rule"),
    [((0, 0, 0, 10), "left < right"), ((0, 0, 1), "shape"), ((0, 0, np.nan, 1), "finite")],
)
def test_what_is_no_box_is_refused(box, rule):
    with pytest.raises(ValueError, match=f"box.*{rule}"):
        bearing_and_range(box, PLAIN)
    with pytest.raises(ValueError, match="height"):
        on_floor((0, 0, 1, 1), PLAIN, 0.0, 0.09)


def detections(*rows) -> Detections:
    boxes = np.array([row[0] for row in rows], np.float32).reshape(-1, 4)
    scores = np.array([row[1] for row in rows], np.float32)
    return Detections(boxes, scores, np.array([row[2] for row in rows], np.int64))


def test_the_nearest_own_ball_is_the_largest_of_the_own_colour_and_never_purple():
    found = detections(
        ((0, 0, 90, 90), 0.9, 1), ((0, 0, 20, 20), 0.9, 2), ((50, 0, 80, 30), 0.5, 2),
        ((0, 0, 60, 60), 0.9, 0),
    )  # fmt: skip
    assert nearest_own_ball(found, "red") == 2
    assert nearest_own_ball(found, "blue") == 3
    assert nearest_own_ball(detections(((0, 0, 9, 9), 0.9, 1)), "red") is None
    assert nearest_own_ball(detections(), "blue") is None
    with pytest.raises(ValueError, match="'red' or 'blue'"):
        nearest_own_ball(found, "purple")


def test_silos_are_read_from_left_to_right_and_each_once():
    found = detections(
        ((200, 0, 240, 90), 0.95, 4), ((10, 0, 50, 90), 0.9, 0), ((11, 0, 51, 90), 0.7, 14),
        ((100, 0, 140, 90), 0.8, 14),
    )  # fmt: skip
    assert silo_contents(found) == ("empty", "RRR", "BR")
    assert silo_contents(detections()) == ()
