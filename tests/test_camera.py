"""The camera's geometry: points to pixels, pixels to rays, and where a robot's camera looks."""

from __future__ import annotations

from math import pi, radians, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course.vision.camera import MOUNT, Camera, camera_pose, looking, view_towards


def test_a_point_one_metre_ahead_and_half_aside_by_hand():
    plain = Camera(320, 240, focal=200.0, distortion=0.0)
    np.testing.assert_allclose(plain.pixels([[0.5, 0.25, 1.0]]), [[260.0, 170.0]])
    bent = Camera(320, 240, focal=200.0, distortion=-0.1)
    # r_u = 0.5: 0.5 (1 - 0.1 r_d^2) = r_d has the root (sqrt(1.1) - 1) / 0.1.
    expected = 160 + 200 * (np.sqrt(1.1) - 1) / 0.1
    np.testing.assert_allclose(bent.pixels([0.5, 0.0, 1.0])[0], expected)


@given(
    st.floats(0.0, 320.0), st.floats(0.0, 240.0), st.floats(0.2, 20.0), st.floats(-0.15, 0.05)
)  # fmt: skip
def test_what_a_pixel_looks_at_appears_in_that_pixel(u, v, far, distortion):
    camera = Camera(320, 240, 250.0, distortion)
    ray = camera.rays([u, v])
    assert np.linalg.norm(ray) == pytest.approx(1.0)
    np.testing.assert_allclose(camera.pixels(far * ray), [u, v], atol=1e-6)


def test_a_barrel_lens_draws_what_lies_aside_nearer_to_the_middle():
    points = [[0.8, 0.0, 1.0]]
    assert (
        Camera(distortion=-0.1).pixels(points)[0, 0] < Camera(distortion=0.0).pixels(points)[0, 0]
    )


def test_points_behind_the_camera_have_no_pixel():
    assert np.isnan(Camera().pixels([[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])).all()


def test_the_view_is_as_wide_as_asked():
    camera = Camera.with_view(radians(60), 320, 240, distortion=0.0)
    edge = camera.pixels([tan(radians(30)), 0.0, 1.0])
    np.testing.assert_allclose(edge, [320.0, 120.0])


def test_more_pixels_see_the_same():
    camera = Camera()
    point = [0.3, -0.2, 2.0]
    np.testing.assert_allclose(camera.scaled(2).pixels(point), 2 * camera.pixels(point))


def test_the_robots_camera_looks_ahead_and_its_right_is_the_pictures_right():
    T = camera_pose((1.0, 2.0, pi / 2), 0.25)
    np.testing.assert_allclose(T[:3, 3], (1.0 - MOUNT[1], 2.0 + MOUNT[0], 0.25 + MOUNT[2]))
    np.testing.assert_allclose(T[:3, 2], (0, 1, 0), atol=1e-12)
    np.testing.assert_allclose(T[:3, 0], (1, 0, 0), atol=1e-12)
    np.testing.assert_allclose(T[:3, 1], (0, 0, -1), atol=1e-12)


@given(st.floats(-pi, pi), st.floats(-1.2, 1.2), st.floats(-pi, pi))
def test_the_camera_frame_is_right_handed_and_its_axes_are_perpendicular(heading, tilt, roll):
    R = looking((0, 0, 1), heading, tilt, roll)[:3, :3]
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)


def test_tilt_looks_down_and_pan_looks_left():
    assert camera_pose((0, 0, 0), tilt=0.5)[2, 2] < -0.4
    assert camera_pose((0, 0, 0), pan=0.5)[1, 2] > 0.4


def test_roll_turns_what_the_picture_shows_clockwise():
    camera = Camera(distortion=0.0)
    T = looking((0, 0, 1), 0.0, 0.0, roll=0.1)
    above = T[:3, :3].T @ np.array([2.0, 0.0, 0.5])
    # What is straight above the middle moves to the right.
    assert camera.pixels(above)[0] > camera.centre[0]


@given(st.tuples(*[st.floats(-5, 5)] * 2, st.floats(0.2, 2)), st.floats(-pi, pi))
def test_the_target_is_in_the_middle_of_the_view(lens, roll):
    T = view_towards(lens, (9.0, 1.0, 0.1), roll)
    seen = T[:3, :3].T @ (np.array([9.0, 1.0, 0.1]) - T[:3, 3])
    np.testing.assert_allclose(Camera().pixels(seen), Camera().centre, atol=1e-6)


def test_a_point_that_is_no_point_is_refused():
    with pytest.raises(ValueError, match="points"):
        Camera().pixels([[1.0, 2.0]])
    with pytest.raises(ValueError, match="pose"):
        camera_pose((0.0, np.nan, 0.0))
