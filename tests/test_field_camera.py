"""The simulator's camera: one hall, one lens, and what the match puts before it."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from robocon_course import field
from robocon_course.simulator.camera import FieldCamera
from robocon_course.vision.camera import Camera, camera_pose, looking

POST = (4.2, 9.98, 0.0)
"""Where the robot looks for a silo."""


def test_the_pile_is_seen_from_the_slope_with_every_ball_in_its_colour():
    names = ["red"] * 6 + ["purple"] * 10
    balls = [
        ((x, y, 0.15 + 0.095), name) for (x, y), name in zip(field.PILE_BALLS, names, strict=True)
    ]
    taken = FieldCamera(3).look((3.4, 10.0, pi), tilt=0.15, balls=balls)
    found = np.bincount(taken.class_ids, minlength=3)
    assert found[0] == 0 and found[1] <= 10 and found[2] <= 6 and found.sum() >= 10


def test_a_ball_appears_where_the_cameras_geometry_says():
    eye, centre = FieldCamera(3), np.array([1.9, 9.7, 0.245])
    taken = eye.look((3.6, 10.0, pi), tilt=0.3, balls=[(centre, "blue")])
    T = camera_pose((3.6, 10.0, pi), float(field.floor_height(3.6, 10.0)), tilt=0.3)
    at = Camera().pixels((centre - T[:3, 3]) @ T[:3, :3])
    middle = (taken.boxes[0, :2] + taken.boxes[0, 2:]) / 2
    np.testing.assert_allclose(middle, at, atol=1.5)


def test_on_the_slope_the_camera_tips_with_the_robot():
    # In the middle of the slope, looking down it: the floor falls by a tenth.
    eye, centre = FieldCamera(3), np.array([1.4, 9.8, 0.245])
    taken = eye.look((2.75, 10.0, pi), tilt=0.3, balls=[(centre, "blue")])
    lens = np.array([2.75, 10.0, 0.2]) + np.array([-0.25, 0.0, -0.025]) + [-0.0418, 0.0, 0.4179]
    T = looking(lens + [0.00125, 0.0, 0.000125], pi, 0.3 + np.arctan(0.1))
    at = Camera().pixels((centre - T[:3, 3]) @ T[:3, :3])
    middle = (taken.boxes[0, :2] + taken.boxes[0, 2:]) / 2
    np.testing.assert_allclose(middle, at, atol=1.5)


def test_the_silos_stand_where_they_stand_and_hold_what_they_hold():
    taken = FieldCamera(3).look(POST, silos=["RRB", "empty", "BR", "R", "BBB"], kind="silo")
    order = np.argsort(taken.boxes[:, 0])
    # From our side silo 5, the farthest from Area 2, is on the left.
    assert [int(k) for k in taken.class_ids[order]] == [2, 4, 0]


def test_one_seed_is_one_hall_and_each_picture_has_noise_of_its_own():
    def pictures(seed):
        eye = FieldCamera(seed)
        return [eye.look(POST, silos=["R"] * 5).image_bgr for _ in range(2)]

    first, second = pictures(5)
    again = pictures(5)
    np.testing.assert_array_equal(first, again[0])
    np.testing.assert_array_equal(second, again[1])
    assert (first != second).any()
    assert np.abs(first.astype(int) - second).mean() < 20
    assert np.abs(first.astype(int) - pictures(6)[0]).mean() > 20


@pytest.mark.parametrize(
    ("what", "rule"),
    [
        ({"balls": [((1, 10, 0.2), "green")]}, "blue, purple, red"),
        ({"balls": [((1, 10), "red")]}, "shape"),
        ({"silos": ["RRRR"]}, "fillings"),
        ({"silos": ["R"] * 6}, "5"),
    ],
)
def test_what_is_not_on_the_field_is_refused(what, rule):
    with pytest.raises(ValueError, match=rule):
        FieldCamera(1).look(POST, **what)
