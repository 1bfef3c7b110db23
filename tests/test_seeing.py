"""The figures of vision draw what they are given."""

from __future__ import annotations

import numpy as np

from robocon_course.view import canvas, seeing
from robocon_course.vision import SILOS, Detections

IMAGE = np.full((60, 80, 3), 120, np.uint8)
FOUND = Detections(
    np.array([[10, 20, 40, 50], [50, 5, 70, 25]], np.float32), np.array([0.9, 0.5], np.float32),
    np.array([0, 2]),
)  # fmt: skip


def texts(fig) -> list[str]:
    return [text.get_text() for ax in fig.axes for text in ax.texts]


def test_a_picture_shows_a_box_and_a_score_for_each_detection():
    fig = seeing.draw_picture(IMAGE, FOUND, title="two balls")
    (ax,) = fig.axes
    assert [p.get_bbox().bounds for p in ax.patches] == [(10, 20, 30, 30), (50, 5, 20, 20)]
    assert texts(fig) == ["b 0.90", "r 0.50"]
    colours = [p.get_edgecolor()[:3] for p in ax.patches]
    assert colours[0] != colours[1]
    assert canvas.png(fig)[:4] == b"\x89PNG"


def test_silos_are_named_and_true_boxes_have_no_score():
    fig = seeing.draw_picture(IMAGE, FOUND, SILOS)
    assert texts(fig) == [f"{SILOS[0]} 0.90", f"{SILOS[2]} 0.50"]
    assert texts(seeing.draw_picture(IMAGE, seeing.as_truth(FOUND.boxes, FOUND.class_ids))) == []


def test_of_tags_that_would_cover_each_other_the_first_is_left():
    beside = FOUND.boxes + np.array([3, 1, 3, 1], np.float32)
    crowd = Detections(np.vstack([FOUND.boxes, beside]), np.full(4, 0.8), np.array([0, 2, 1, 1]))
    (ax,) = seeing.draw_picture(IMAGE, crowd).axes
    assert [words.get_visible() for words in ax.texts] == [True, True, False, False]
    assert len(ax.patches) == 4, "every box is still drawn"


def test_a_gallery_has_a_place_for_every_picture_and_leaves_the_rest_blank():
    fig = seeing.gallery([IMAGE] * 4, titles=list("abcd"), across=3)
    assert len(fig.axes) == 6 and sum(bool(ax.images) for ax in fig.axes) == 4
    assert [ax.get_title(loc="left") for ax in fig.axes[:4]] == list("abcd")


def test_an_overlap_is_drawn_only_where_there_is_one():
    assert texts(seeing.plot_iou([0, 0, 9, 9], [4, 4, 12, 12], 0.3)) == [" A ", " B ", "common"]
    assert texts(seeing.plot_iou([0, 0, 9, 9], [40, 4, 52, 12], 0.0)) == [" A ", " B "]


def test_a_confusion_matrix_shows_every_count_but_zero():
    fig = seeing.plot_confusion([[5, 0, 1], [2, 7, 0], [0, 3, 0]], ["a", "b"])
    assert sorted(texts(fig)) == ["1", "2", "3", "5", "7"]
    assert [t.get_text() for t in fig.axes[0].get_xticklabels()] == ["a", "b", "nothing"]


def test_curves_leave_out_what_was_not_measured():
    run = {
        k: np.array([3.0, 2.0, 1.0])
        for k in ("box", "class", "dfl", "val_box", "val_class", "val_dfl")
    }
    run |= {"epoch": np.arange(1.0, 4.0), "map50": np.array([0.1, np.nan, 0.7])}  # fmt: skip
    loss, score = seeing.plot_training({"one": run, "two": run}).axes
    assert loss.lines[0].get_ydata().tolist() == [9.0, 6.0, 3.0]
    assert score.lines[0].get_xdata().tolist() == [1.0, 3.0]
    few, many = seeing.plot_losses({"few": run, "many": run | {"val_box": run["box"] + 1}}).axes
    assert [ax.get_title(loc="left") for ax in (few, many)] == ["few", "many"]
    assert few.get_ylim() == many.get_ylim()
    assert [t.get_text() for t in many.texts] == ["at the end: 3.0 and 4.0"]


def test_growth_is_drawn_to_where_it_would_reach_what_is_wanted():
    shown, missing = [1e5, 4e5], [0.02, 0.01]  # four times the pictures, half of what is missing
    (ax,) = seeing.plot_growth(shown, missing, 0.0025, -0.5, np.log(0.02 * 1e5**0.5)).axes
    power, measured, _ = ax.lines
    assert measured.get_xdata().tolist() == shown
    np.testing.assert_allclose(np.interp(shown, *power.get_data()), missing, rtol=2e-3)
    np.testing.assert_allclose(power.get_xydata()[-1], [6.4e6, 0.0025])


def test_curves_of_one_class_each_differ_in_stroke_too():
    curve = np.array([0.2, 0.8]), np.array([1.0, 0.5])
    (ax,) = seeing.plot_precision_recall({name: curve for name in ("blue", "purple", "red")}).axes
    assert len({line.get_linestyle() for line in ax.lines}) == 3


def test_words_for_counts_and_orders():
    assert seeing.count_words([0, 2, 2]) == "1 blue, 2 red"
    assert seeing.count_words([]) == "nothing"
    assert seeing.silo_order(FOUND) == f"{SILOS[0]}, {SILOS[2]}"
