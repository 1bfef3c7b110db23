"""What a network says of each place, films with boxes, balls from above: drawn as given."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from robocon_course.view import canvas, looking
from robocon_course.vision import SILOS, Detections, Sighting
from robocon_course.vision.camera import Camera

IMAGE = np.full((60, 80, 3), 120, np.uint8)
FOUND = Detections(
    np.array([[10, 20, 40, 50]], np.float32), np.array([0.9], np.float32), np.array([2])
)
NOTHING = Detections(np.empty((0, 4), np.float32), np.empty(0, np.float32), np.empty(0, int))
SEEN = {"by size": [Sighting(0.3, 2.1, 0.01, 0.2)], "both": [Sighting(0.3, 2.05, 0.01, 0.1)]}


def frames(gif: bytes) -> list[np.ndarray]:
    film = Image.open(io.BytesIO(gif))
    seen = []
    for k in range(film.n_frames):
        film.seek(k)
        seen.append(np.asarray(film.convert("RGB")).astype(int))
    return seen


def test_a_film_shows_a_box_only_in_the_picture_where_something_was_found():
    film = looking.film([IMAGE, IMAGE], [FOUND, NOTHING], ["one", "none"])
    first, second = frames(film.gif)
    assert first.shape == (60 + looking.CAPTION, 80, 3)
    assert np.ptp(first[40, 10]) > 50  # the box's left side is coloured
    assert np.ptp(second[:60], axis=2).max() < 10  # all grey
    assert (first[60:] != second[60:]).any()  # the words differ
    assert film.still[:4] == b"\x89PNG"


def test_a_film_tags_silos_with_their_filling():
    both = [FOUND, FOUND._replace(class_ids=np.array([14]))]
    assert SILOS[2] != SILOS[14]
    first, second = frames(looking.film([IMAGE] * 2, both, ["", ""], SILOS).gif)
    assert (first[:20] != second[:20]).any()


def test_a_film_needs_words_for_each_picture():
    with pytest.raises(ValueError, match="shorter"):
        looking.film([IMAGE, IMAGE], [FOUND, FOUND], ["one"])


def test_each_place_is_drawn_where_it_lies_in_the_square():
    scores = np.zeros(64 + 16 + 4)
    scores[8 * 2 + 5] = 0.9  # the fine grid: row 2, column 5
    scores[64 + 16 + 3] = 0.8  # the coarse one: row 1, column 1
    fig = looking.plot_places(np.full((1, 3, 64, 64), 0.5, np.float32), scores)
    fine, middle, coarse = (ax.images[1].get_array() for ax in fig.axes[:3])
    assert (fine.shape, middle.shape, coarse.shape) == ((8, 8), (4, 4), (2, 2))
    assert fine[2, 5] == 0.9 and fine.count() == 1
    assert middle.count() == 0
    assert coarse[1, 1] == 0.8 and coarse.count() == 1
    assert fig.axes[3].get_ylabel() == "best score"


def test_the_pinhole_says_how_many_pixels_a_ball_has():
    said = [t.get_text() for t in looking.plot_pinhole(1.0, 277.0, 0.095).axes[0].texts]
    ends = Camera(focal=277.0, distortion=0.0).pixels([[0, -0.095, 1.0], [0, 0.095, 1.0]])
    assert f"picture: {np.ptp(ends[:, 1]):.0f} pixels" in said


def test_the_looks_touch_the_ball_and_the_radius_ends_where_they_do():
    (ax,) = looking.plot_touching_looks(0.45, 0.6, 0.095).axes
    (ball,) = ax.patches
    lines = {line.get_color(): line.get_xydata() for line in ax.lines}
    for line in ax.lines[:2]:
        _, end = line.get_xydata()
        gap = abs(end[0] * ball.center[1] - end[1] * ball.center[0]) / np.hypot(*end)
        assert gap == pytest.approx(0.095)
    middle, touch = lines[canvas.WARN]
    assert np.hypot(*(touch - middle)) == pytest.approx(0.095)
    assert touch @ (touch - middle) == pytest.approx(0.0, abs=1e-12), "a right angle"


def test_balls_to_the_left_are_drawn_on_the_left_and_errors_in_centimetres():
    above, error = looking.plot_sightings(SEEN, ["red"], [(0.3, 2.0)]).axes
    (ball,) = above.patches
    assert ball.center == pytest.approx((-2 * np.sin(0.3), 2 * np.cos(0.3)))
    x, y = above.lines[0].get_xydata()[0]
    assert (x, y) == pytest.approx((-2.05 * np.sin(0.3), 2.05 * np.cos(0.3)))
    offs = [bar.lines[0].get_xdata()[0] for bar in error.containers]
    assert offs == pytest.approx([10.0, 5.0])
    assert error.get_yticklabels()[0].get_text() == "red, 2.0 m"


def test_a_rare_colour_survives_the_packing():
    rng = np.random.default_rng(0)
    picture = np.zeros((100, 100, 3), np.uint8)
    picture[..., 1] = rng.integers(60, 256, (100, 100))  # two hundred greens
    picture[..., 0] = rng.integers(0, 40, (100, 100))
    picture[40:44, 40:44] = (20, 40, 220)
    seen = Image.open(io.BytesIO(canvas.packed(Image.fromarray(picture)))).convert("RGB")
    assert np.abs(np.asarray(seen)[41, 41].astype(int) - (20, 40, 220)).max() < 25
