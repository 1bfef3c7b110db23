"""Colour tracking: what thresholds on hue find, and where they are blind."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from robocon_course.vision import colour
from robocon_course.vision.colour import COLOURS, colour_mask, heading_from_landmarks, largest_blob
from robocon_course.vision.paint import hsv

HUES = {"blue": 219, "purple": 290, "red": 353, "green": 130, "orange": 30}


def disc(name, at=(60, 50), radius=20, image=None, value=0.8):
    """A disc of one colour on grey, or on a picture."""
    if image is None:
        image = np.full((120, 160, 3), 90, np.uint8)
    paint = (hsv(HUES[name], 0.8, value) * 255).astype(int)[::-1].tolist()
    cv2.circle(image, at, radius, paint, -1)
    return image


@pytest.mark.parametrize("name", COLOURS)
def test_a_disc_is_found_where_it_is_by_its_own_colour_only(name):
    blob = largest_blob(disc(name), name)
    np.testing.assert_allclose(blob.centre, (60, 50), atol=0.5)
    np.testing.assert_allclose(blob.box, (40, 30, 81, 71), atol=1)
    assert blob.area == pytest.approx(np.pi * 20**2, rel=0.05)
    for other in COLOURS.keys() - {name}:
        assert largest_blob(disc(name), other) is None


def test_of_two_blobs_the_larger_is_taken_and_specks_are_not():
    image = disc("red", (120, 80), 9, disc("red"))
    assert largest_blob(image, "red").centre[0] == pytest.approx(60, abs=0.5)
    assert largest_blob(disc("red", radius=1), "red") is None


def test_the_eye_stays_with_a_blob_until_another_is_twice_as_large():
    image = disc("red", (120, 80), 15, disc("red", (40, 40), 12))
    assert largest_blob(image, "red").centre[0] == pytest.approx(120, abs=0.5)
    kept = largest_blob(image, "red", near=np.array([42.0, 38.0]))
    assert kept.centre[0] == pytest.approx(40, abs=0.5)
    grown = disc("red", (120, 80), 20, disc("red", (40, 40), 12))
    assert largest_blob(grown, "red", near=np.array([42.0, 38.0])).centre[0] > 100


def test_loose_pixels_count_only_where_they_touch_strict_ones():
    dark = disc("blue", value=0.2)  # too dark to start a blob
    assert not colour_mask(dark, COLOURS["blue"]).any()
    lit = disc("blue", radius=8, image=dark.copy())
    assert colour_mask(lit, COLOURS["blue"]).sum() == pytest.approx(np.pi * 20**2, rel=0.05)


def test_red_is_found_on_both_sides_of_zero():
    for hue in (345, 353, 1, 6):
        image = np.full((50, 50, 3), (hsv(hue, 0.8, 0.8) * 255)[::-1], np.uint8)
        assert colour_mask(image, COLOURS["red"]).all()


@pytest.mark.parametrize(
    ("seen", "heading"),
    [
        (("green", "blue"), 0),
        (("orange", "green"), 90),
        (("red", "orange"), 180),
        (("blue", "red"), 270),
        (("red", "green"), None),
        (("red",), None),
        ((), None),
        (("red", "blue", "green"), None),
    ],
)
def test_pairs_of_landmarks_tell_the_heading(seen, heading):
    assert heading_from_landmarks(seen) == heading
    assert heading_from_landmarks(reversed(seen)) == heading


def test_under_a_warm_lamp_purple_passes_for_red():
    image = disc("purple")
    warm = np.clip(image * np.array([0.45, 1.0, 1.3]), 0, 255).astype(np.uint8)
    assert largest_blob(image, "red") is None
    assert largest_blob(warm, "red") is not None and largest_blob(warm, "purple") is None


def test_glare_eats_a_hole_and_a_white_balance_hides_the_ball():
    image = disc("blue")
    pale = np.clip(image.astype(int) + 150, 0, 255).astype(np.uint8)
    assert largest_blob(pale, "blue") is None
    tinted = np.clip(image * np.array([0.6, 1.3, 1.0]), 0, 255).astype(np.uint8)
    assert largest_blob(tinted, "blue") is None


def test_what_has_no_window_is_refused():
    with pytest.raises(ValueError, match=r"blue, purple, red"):
        largest_blob(disc("red"), "white")
    with pytest.raises(ValueError, match="image_bgr"):
        colour.colour_mask(None, COLOURS["red"])
