"""Overlap, precision, average precision, confusion: by hand and against Ultralytics."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course.vision.detection import Detections
from robocon_course.vision.metrics import (
    average_precision,
    average_precisions,
    box_iou,
    confusion_matrix,
    match_detections,
    precision_recall,
    score_pictures,
    xyxy_from_yolo,
)

corner = st.tuples(st.floats(0, 50), st.floats(0, 50))
side = st.tuples(st.floats(0.1, 50), st.floats(0.1, 50))
box = st.builds(lambda c, s: [*c, c[0] + s[0], c[1] + s[1]], corner, side)


def test_annotations_by_hand():
    np.testing.assert_allclose(
        xyxy_from_yolo([[2, 0.5, 0.25, 0.1, 0.5]], 320, 240), [[144, 0, 176, 120]]
    )
    assert xyxy_from_yolo([], 320, 240).shape == (0, 4)
    with pytest.raises(ValueError, match="rows"):
        xyxy_from_yolo([[1, 2, 3]], 320, 240)


def test_overlap_by_hand():
    a = [[0, 0, 10, 10]]
    b = [[0, 0, 10, 10], [5, 0, 15, 10], [10, 0, 20, 10], [2, 2, 4, 4]]
    np.testing.assert_allclose(box_iou(a, b), [[1, 1 / 3, 0, 0.04]])
    assert box_iou(np.empty((0, 4)), b).shape == (0, 4)
    assert box_iou([[1, 1, 1, 1]], [[1, 1, 1, 1]])[0, 0] == 0


@given(box, box)
def test_overlap_is_symmetric_and_at_most_one(a, b):
    there, back = box_iou([a], [b])[0, 0], box_iou([b], [a])[0, 0]
    assert there == pytest.approx(back) and 0 <= there <= 1 + 1e-9
    assert box_iou([a], [a])[0, 0] == pytest.approx(1)


@given(box, box)
def test_overlap_is_that_of_counted_points(a, b):
    x, y = np.meshgrid(np.linspace(0, 100, 201), np.linspace(0, 100, 201))
    inside = [(k[0] <= x) & (x <= k[2]) & (k[1] <= y) & (y <= k[3]) for k in (a, b)]
    common, either = (inside[0] & inside[1]).sum(), (inside[0] | inside[1]).sum()
    if either > 2000:
        assert box_iou([a], [b])[0, 0] == pytest.approx(common / either, abs=0.12)


def test_a_true_box_is_found_once_and_by_its_own_class():
    true = [[0, 0, 10, 10]]
    boxes = [[0, 0, 10, 10], [0, 0, 10, 9], [0, 0, 10, 10]]
    assert match_detections(boxes, [0, 0, 1], true, [0]).tolist() == [True, False, False]
    assert match_detections(boxes, [0, 0, 1], np.empty((0, 4)), []).tolist() == [False] * 3
    assert match_detections([], [], true, [0]).shape == (0,)


def test_the_surest_finds_a_true_box_even_if_another_overlaps_better():
    true = [[0, 0, 10, 10], [20, 0, 30, 10]]
    boxes = [[0, 0, 10, 8], [0, 0, 10, 10], [21, 0, 30, 10]]
    assert match_detections(boxes, [0, 0, 0], true, [0, 0]).tolist() == [True, False, True]
    # The second best is good enough where the best is taken.
    true = [[0, 0, 10, 10], [0, 0, 10, 9]]
    boxes = [[0, 0, 10, 10], [0, 0, 10, 10]]
    assert match_detections(boxes, [0, 0], true, [0, 0]).tolist() == [True, True]


def test_pictures_need_not_come_with_the_surest_first():
    boxes, scores = np.array([[0, 0, 10, 10], [0, 0, 10, 7]]), np.array([0.3, 0.9])
    scored = score_pictures([(Detections(boxes, scores, np.array([0, 0])), boxes[:1], [0])], 1)
    assert scored.hits[scored.scores == 0.9] and not scored.hits[scored.scores == 0.3]


def test_a_report_of_what_is_doubtful_is_not_judged():
    true, doubtful = np.array([[0, 0, 10, 10]]), np.array([[50, 0, 60, 10], [0, 0, 10, 9]])
    boxes = np.array([[0, 0, 10, 10], [50, 0, 60, 8], [50, 0, 60, 8], [50, 0, 60, 4]])
    found = Detections(boxes, np.array([0.9, 0.8, 0.7, 0.6]), np.array([0, 0, 1, 0]))
    strict = score_pictures([(found, true, [0])], 2)
    assert strict.hits.tolist() == [True, False, False, False]
    # Whatever it is called; but a box that hardly covers it was reported in vain.
    scored = score_pictures([(found, true, [0], doubtful)], 2)
    assert scored.scores.tolist() == [0.9, 0.6] and scored.hits.tolist() == [True, False]
    assert scored.truths.tolist() == strict.truths.tolist() == [1, 0]


def test_what_is_doubtful_excuses_no_error_about_what_is_not():
    true, doubtful = np.array([[0, 0, 10, 10]]), np.array([[0, 0, 10, 8]])
    boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 9.5], [0, 0, 10, 9.5]])
    found = Detections(boxes, np.array([0.9, 0.8, 0.7]), np.array([0, 0, 1]))
    scored = score_pictures([(found, true, [0], doubtful)], 2)
    # Twice reported, and under a wrong name.
    assert scored.hits.tolist() == [True, False, False]


def test_nothing_doubtful_changes_nothing():
    pictures = random_pictures(np.random.default_rng(3))
    none = [(*one, np.empty((0, 4))) for one in pictures]
    for there, here in zip(score_pictures(pictures, 4), score_pictures(none, 4), strict=True):
        np.testing.assert_array_equal(there, here)


def test_what_is_right_equals_ultralytics():
    pytest.importorskip("robocon_course.vision.training")
    import torch
    from ultralytics.engine.validator import BaseValidator

    judge = SimpleNamespace(iouv=torch.tensor([0.5]))
    rng = np.random.default_rng(7)
    for found, true, ids in random_pictures(rng, 200, 2):
        # Each a second time, a little beside.
        twice = np.vstack([found.boxes, found.boxes + rng.normal(0, 2, found.boxes.shape)])
        order = rng.permutation(len(twice))
        boxes, said = twice.astype(np.float32)[order], np.tile(found.class_ids, 2)[order]
        overlap = torch.from_numpy(box_iou(true, boxes))
        theirs = BaseValidator.match_predictions(
            judge, torch.from_numpy(said), torch.from_numpy(ids), overlap
        )
        ours = match_detections(boxes, said, true, ids)
        np.testing.assert_array_equal(ours, theirs[:, 0].numpy())


def test_precision_and_recall_by_hand():
    recall, precision = precision_recall([0.9, 0.6, 0.8], [True, True, False], 4)
    np.testing.assert_allclose(recall, [0.25, 0.25, 0.5])
    np.testing.assert_allclose(precision, [1, 0.5, 2 / 3])


def test_average_precision_by_hand():
    # The last of 101 recalls has precision 0: a perfect detector has 0.995, as in Ultralytics.
    assert average_precision([1.0], [1.0]) == pytest.approx(0.995)
    assert average_precision([], []) == 0.0
    # Half of all found without a mistake, the rest never: half the area, but for the last step.
    assert average_precision([0.5], [1.0]) == pytest.approx(0.5, abs=0.01)


def random_pictures(rng, count=30, classes=4):
    """Truths, and detections that are some of them shaken, some invented."""
    made = []
    for _ in range(count):
        corners = rng.uniform(0, 80, (rng.integers(0, 6), 2))
        true = np.hstack([corners, corners + rng.uniform(8, 40, corners.shape)])
        ids = rng.integers(0, classes, len(true))
        shaken = true + rng.normal(0, 3, true.shape)
        extra = rng.uniform(0, 80, (rng.integers(0, 3), 2))
        boxes = np.vstack([shaken, np.hstack([extra, extra + 15])]).astype(np.float32)
        said = np.r_[np.where(rng.uniform(size=len(true)) < 0.8, ids, 0), [1] * len(extra)]
        scores = rng.uniform(0, 1, len(boxes)).astype(np.float32)
        made.append((Detections(boxes, scores, said.astype(np.int64)), true, ids))
    return made


def test_average_precision_equals_ultralytics():
    pytest.importorskip("robocon_course.vision.training")
    from ultralytics.utils.metrics import ap_per_class

    for seed in range(20):
        pictures = random_pictures(np.random.default_rng(seed))
        scored = score_pictures(pictures, 4)
        true_ids = np.concatenate([ids for *_, ids in pictures])
        theirs = ap_per_class(scored.hits[:, None], scored.scores, scored.class_ids, true_ids)
        ours = average_precisions(scored)
        np.testing.assert_allclose(ours[theirs[6]], theirs[5][:, 0], atol=1e-6)


def test_a_class_that_is_not_there_has_no_average_precision():
    scored = score_pictures(random_pictures(np.random.default_rng(1), 5, 2), 4)
    assert np.isnan(average_precisions(scored)[2:]).all()


def test_confusion_equals_ultralytics():
    training = pytest.importorskip("robocon_course.vision.training")
    training.ensure_torchvision()
    import torch
    from ultralytics.utils.metrics import ConfusionMatrix

    for seed in range(10):
        pictures = random_pictures(np.random.default_rng(seed))
        theirs = ConfusionMatrix(names=dict(enumerate("abcd")), task="detect")
        for found, true, ids in pictures:
            theirs.process_batch(
                {"bboxes": torch.tensor(found.boxes), "conf": torch.tensor(found.scores),
                 "cls": torch.tensor(found.class_ids)},
                {"bboxes": torch.tensor(true, dtype=torch.float32), "cls": torch.tensor(ids)},
                conf=0.25, iou_thres=0.45,
            )  # fmt: skip
        np.testing.assert_array_equal(confusion_matrix(pictures, 4), theirs.matrix)


def test_confusion_by_hand():
    true = [[0, 0, 10, 10], [50, 50, 60, 60]]
    found = Detections(
        np.array([[0, 0, 10, 10], [80, 80, 90, 90]], np.float32),
        np.array([0.9, 0.8], np.float32), np.array([1, 0]),
    )  # fmt: skip
    table = confusion_matrix([(found, true, [0, 1])], 2)
    # 0 taken for 1; 1 missed; a 0 seen where nothing is.
    assert table.tolist() == [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
