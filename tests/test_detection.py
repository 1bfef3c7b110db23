"""Detection: the same boxes as Ultralytics', in numpy; weights that are ours or are refused."""

from __future__ import annotations

import os
import subprocess
import sys

import cv2
import numpy as np
import pytest

from conftest import ROOT, benchmark, missing
from robocon_course import files
from robocon_course.vision import detection
from robocon_course.vision.classes import CLASSES, MIN_SCORE
from robocon_course.vision.detection import (
    WeightsError,
    decode,
    letterbox,
    load_detector,
    non_max_suppression,
)
from robocon_course.vision.metrics import box_iou, xyxy_from_yolo
from robocon_course.vision.pictures import picture

KINDS = ("ball", "silo")


# --- letterbox, decode, suppression ---------------------------------------------------------------


def test_a_wide_picture_is_letterboxed_by_hand():
    image = np.zeros((180, 320, 3), np.uint8)
    image[:, :, 0] = 255
    tensor, scale, shift = letterbox(image, 160)
    assert tensor.shape == (1, 3, 160, 160) and tensor.dtype == np.float32
    assert (scale, shift) == (0.5, (0, 35))
    np.testing.assert_allclose(tensor[0, :, 80, 80], (0, 0, 1))  # blue is the last plane
    np.testing.assert_allclose(tensor[0, :, 0, 0], 114 / 255)


@pytest.mark.parametrize("shape", [(1, 1), (1, 1000), (1000, 1), (319, 321), (8, 3), (1080, 1920)])
def test_any_shape_fits_into_the_square_and_points_find_back(shape):
    image = np.zeros((*shape, 3), np.uint8)
    tensor, scale, (left, top) = letterbox(image, 320)
    assert tensor.shape == (1, 3, 320, 320)
    filled = np.argwhere(tensor[0, 0] == 0)
    assert filled.min(axis=0).tolist() == [top, left]
    bottom, right = filled.max(axis=0) + 1
    assert bottom - top == max(1, round(shape[0] * scale))
    assert right - left == max(1, round(shape[1] * scale))


def test_decode_by_hand():
    output = np.array([[50, 10], [40, 10], [20, 4], [10, 4], [0.1, 0.2], [0.7, 0.3]], float)
    boxes, scores, class_ids = decode(output, 0.5)
    np.testing.assert_allclose(boxes, [[40, 35, 60, 45]])
    assert scores.tolist() == [0.7] and class_ids.tolist() == [1]
    for part, shape in zip(decode(output, 0.9), [(0, 4), (0,), (0,)], strict=True):
        assert part.shape == shape


def test_suppression_by_hand():
    boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 9], [20, 0, 30, 10], [0, 0, 10, 10]], float)
    kept = non_max_suppression(boxes, np.array([0.6, 0.9, 0.5, 0.8]), np.array([0, 0, 0, 1]))
    assert kept.tolist() == [1, 3, 2]
    assert non_max_suppression(np.empty((0, 4)), np.empty(0), np.empty(0)).shape == (0,)


def test_suppression_keeps_what_a_naive_twin_keeps():
    rng = np.random.default_rng(0)
    for _ in range(50):
        corner, ids = rng.uniform(0, 30, (40, 2)), rng.integers(0, 3, 40)
        boxes = np.hstack([corner, corner + rng.uniform(5, 30, (40, 2))])
        scores = rng.uniform(0, 1, 40).round(1)
        expected = []
        for k in sorted(range(40), key=lambda k: (-scores[k], k)):
            rivals = [j for j in expected if ids[j] == ids[k]]
            if all(box_iou([boxes[k]], [boxes[j]])[0, 0] <= 0.5 for j in rivals):
                expected.append(k)
        assert non_max_suppression(boxes, scores, ids, 0.5).tolist() == expected


@pytest.mark.parametrize("kind", KINDS)
def test_boxes_are_those_of_ultralytics_on_200_pictures(kind):
    training = pytest.importorskip("robocon_course.vision.training")
    training.ensure_torchvision()
    theirs = training.YOLO(str(files.data_file(f"weights/{kind}.onnx")), task="detect")
    ours, compared, left_out = load_detector(kind), 0, 0
    for index in range(200):
        # Every shape, and so low a threshold that many boxes overlap.
        image = picture(kind, 31, index, None).image_bgr
        if index % 4 == 0:
            image = cv2.resize(image, None, fx=2.3, fy=2.3)
        mine = ours.detect(image, min_score=0.05)
        found = theirs.predict(image, imgsz=ours.size, conf=0.05, iou=0.7, verbose=False)[0].boxes
        boxes, ids, scores = (part.numpy() for part in (found.xyxy, found.cls, found.conf))
        mine, found_there = without_ties(*mine), without_ties(boxes, scores, ids)
        assert mine.class_ids.tolist() == found_there.class_ids.astype(int).tolist()
        np.testing.assert_allclose(mine.boxes, found_there.boxes, atol=0.5)
        np.testing.assert_allclose(mine.scores, found_there.scores, atol=1e-3)
        compared, left_out = compared + len(mine.scores), left_out + len(ids) - len(mine.scores)
    assert compared > 300 and left_out <= 2


def without_ties(boxes, scores, ids):
    """Without boxes that overlap a surer one by the very limit of suppression, to 4 digits.

    Ultralytics moves the boxes of each class 7680 pixels away before it compares them in float32:
    its fourth digit is rounding.
    """
    overlap = np.triu(box_iou(boxes, boxes) * (ids[:, None] == ids[None, :]), 1)
    kept = (np.abs(overlap - 0.7) > 1e-4).all(axis=0)
    return detection.Detections(boxes[kept], scores[kept], ids[kept])


def test_the_benchmark_compares_both_sizes(monkeypatch, capsys):
    pytest.importorskip("robocon_course.vision.training")
    detection_times = benchmark("detection")
    for name, few in (("COUNT", 2), ("REPEATS", 1), ("PAUSE", 0.0)):
        monkeypatch.setattr(detection_times, name, few)
    detection_times.main()
    told = capsys.readouterr().out
    for size in (320, 480):
        assert told.count(f"at {size} pixels: detect") == 2


# --- detect ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_results_have_the_promised_types_and_order(kind):
    detector = load_detector(kind)
    assert detector.names == CLASSES[kind] and detector.min_score == MIN_SCORE[kind]
    for index in range(20):
        image = picture(kind, 17, index).image_bgr
        found = detector.detect(image)
        assert found.boxes.dtype == np.float32 and found.boxes.shape == (len(found.scores), 4)
        assert found.scores.dtype == np.float32 and found.class_ids.dtype == np.int64
        assert (np.diff(found.scores) <= 0).all() and (found.scores > MIN_SCORE[kind]).all()
        assert (found.boxes >= 0).all() and (found.boxes <= (320, 240, 320, 240)).all()


def test_nothing_in_the_picture_gives_empty_arrays():
    for image in (np.zeros((240, 320, 3), np.uint8), np.full((1, 1, 3), 200, np.uint8)):
        found = load_detector("ball").detect(image)
        assert found.boxes.shape == (0, 4) and found.scores.shape == found.class_ids.shape == (0,)


def test_grey_and_four_channels_and_views_are_taken():
    detector, image = load_detector("ball"), picture("ball", 17, 1).image_bgr
    plain = detector.detect(image)
    with_alpha = detector.detect(np.dstack([image, image[..., 0]]))
    np.testing.assert_array_equal(plain.boxes, with_alpha.boxes)
    large = np.zeros((480, 640, 3), np.uint8)
    large[::2, ::2] = image
    view = large[::2, ::2]
    view.setflags(write=False)
    np.testing.assert_array_equal(plain.boxes, detector.detect(view).boxes)
    np.testing.assert_array_equal(
        detector.detect(image[:, ::-1]).boxes, detector.detect(image[:, ::-1].copy()).boxes
    )
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    np.testing.assert_array_equal(
        detector.detect(grey).boxes, detector.detect(np.dstack([grey] * 3)).boxes
    )


@pytest.mark.parametrize(
    ("image", "rule"),
    [
        (None, "does the file exist"),
        ([[0, 0, 0]], "cv2.imread"),
        (np.zeros((4, 4, 3)), "uint8"),
        (np.zeros((4, 4, 3), np.uint16), "divide by 257"),
        (np.zeros((4, 4, 2), np.uint8), "shape"),
        (np.zeros((0, 4, 3), np.uint8), "no side of 0"),
        (np.zeros(4, np.uint8), "shape"),
    ],
)
def test_what_is_no_picture_is_refused(image, rule):
    with pytest.raises(ValueError, match=f"image_bgr.*{rule}"):
        load_detector("ball").detect(image)


@pytest.mark.parametrize("score", [-0.1, 1.1, float("nan"), "0.4", []])
def test_a_score_that_is_none_is_refused(score):
    with pytest.raises(ValueError, match="min_score"):
        load_detector("ball").detect(np.zeros((8, 8, 3), np.uint8), min_score=score)


def test_a_students_parts_take_their_place_in_the_detector():
    image, called = picture("ball", 17, 1).image_bgr, []

    def own_decode(output, min_score):
        called.append("decode")
        return decode(output, min_score)

    def own_suppression(boxes, scores, class_ids, max_iou):
        called.append("suppress")
        return list(non_max_suppression(boxes, scores, class_ids, max_iou))

    detector = load_detector("ball")
    mine = detector.with_parts(own_decode, own_suppression)
    np.testing.assert_array_equal(mine.detect(image).boxes, detector.detect(image).boxes)
    assert called == ["decode", "suppress"]


# --- weights --------------------------------------------------------------------------------------


@pytest.fixture
def shipped(monkeypatch, tmp_path):
    """A folder in the place of data/weights, with the ball network in it."""
    for name in ("ball.onnx", "SHA256SUMS"):
        (tmp_path / name).write_bytes(files.data_file(f"weights/{name}").read_bytes())

    def data_file(name):
        path = tmp_path / name.removeprefix("weights/")
        if not path.exists():
            raise FileNotFoundError(f"the course has no data file {name!r}; install it again")
        return path

    monkeypatch.setattr(detection.files, "data_file", data_file)
    detection._shipped.cache_clear()
    yield tmp_path
    detection._shipped.cache_clear()


def flip_a_bit(path):
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)


@pytest.mark.parametrize(
    ("spoil", "rule"),
    [
        (flip_a_bit, "SHA-256"),
        (lambda path: path.write_bytes(path.read_bytes()[:1000]), "SHA-256"),
        (lambda path: path.write_bytes(b""), "empty"),
        (lambda path: path.unlink(), "no data file"),
        (lambda path: path.with_name("SHA256SUMS").write_text(""), "expected none"),
        (
            lambda path: path.with_name("SHA256SUMS").write_text("\nno sums at all\n"),
            "expected none",
        ),
        (lambda path: path.with_name("SHA256SUMS").write_bytes(b"\xff\x00"), "not text"),
        (lambda path: path.with_name("SHA256SUMS").unlink(), "no data file"),
    ],
)
def test_weights_that_are_not_the_courses_are_refused(shipped, spoil, rule):
    spoil(shipped / "ball.onnx")
    with pytest.raises(WeightsError, match=rule):
        load_detector("ball")


@pytest.mark.parametrize(
    ("data", "rule"),
    [(b"", "empty"), (b"no network", "not a network"), (b"\0" * 14_000_000, "13 MB")],
)
def test_a_file_that_is_no_network_is_refused(tmp_path, data, rule):
    path = tmp_path / "mine.onnx"
    path.write_bytes(data)
    with pytest.raises(WeightsError, match=rule):
        load_detector(path)
    with pytest.raises(WeightsError, match="cannot be read"):
        load_detector(tmp_path / "nowhere.onnx")


@pytest.mark.parametrize("weights", [None, 3, ("ball",)])
def test_what_is_no_name_and_no_path_is_refused(weights):
    with pytest.raises(WeightsError, match="'ball', 'silo' or a path"):
        load_detector(weights)


def small_network(path, *, number="FLOAT", more=(), gives=(1, 6, 8), names="{0: 'a', 1: 'b'}"):
    """A network that says the same of every picture: nothing."""
    onnx = pytest.importorskip("onnx")
    helper, kind = onnx.helper, onnx.TensorProto
    takes = [helper.make_tensor_value_info("images", getattr(kind, number), [1, 3, 32, 32])]
    takes += [helper.make_tensor_value_info(name, kind.FLOAT, [1]) for name in more]
    nothing = helper.make_tensor("c", kind.FLOAT, gives, [0.0] * int(np.prod(gives)))
    graph = helper.make_graph(
        [helper.make_node("Constant", [], ["found"], value=nothing)], "small", takes,
        [helper.make_tensor_value_info("found", kind.FLOAT, gives)],
    )  # fmt: skip
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    helper.set_model_props(model, {"names": names})
    path.write_bytes(model.SerializeToString())
    return path


def test_a_network_of_other_classes_is_taken_with_its_own_names(tmp_path):
    detector = load_detector(small_network(tmp_path / "mine.onnx"))
    assert (detector.names, detector.size, detector.min_score) == (("a", "b"), 32, 0.25)
    assert detector.detect(np.zeros((8, 9, 3), np.uint8)).boxes.shape == (0, 4)


@pytest.mark.parametrize(
    ("other", "rule"),
    [
        ({"gives": (1, 84, 8)}, "for 2 classes"),
        ({"gives": (1, 300, 6)}, "for 2 classes"),
        ({"names": "{}"}, "for 0 classes"),
        ({"names": "__import__('os')"}, "not a network that can be opened"),
        ({"number": "FLOAT16"}, "without half=True"),
        ({"more": ("thresholds",)}, "takes 2 inputs"),
    ],
)
def test_a_network_of_another_shape_is_refused_when_it_is_loaded(tmp_path, other, rule):
    path = small_network(tmp_path / "mine.onnx", **other)
    with pytest.raises(WeightsError, match=rule):
        load_detector(path)


def test_own_weights_are_opened_by_their_path(tmp_path):
    path = tmp_path / "mine.onnx"
    path.write_bytes(files.data_file("weights/ball.onnx").read_bytes())
    image = picture("ball", 17, 1).image_bgr
    mine, ours = load_detector(path), load_detector("ball")
    assert mine.names == ours.names
    np.testing.assert_array_equal(mine.detect(image).boxes, ours.detect(image).boxes)


def test_detection_needs_no_torch():
    code = (
        "import sys; sys.modules['torch'] = sys.modules['ultralytics'] = None\n"
        "import numpy as np\n"
        "from robocon_course.vision import detection, metrics, locate, colour, dataset, pictures\n"
        "detection.load_detector('ball').detect(np.zeros((240, 320, 3), np.uint8))\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, env=dict(os.environ))


# --- photographs ----------------------------------------------------------------------------------

PHOTOGRAPHS = ROOT.parent / "shared" / "data" / "balls_robocon2024"
CONTENTS = {
    "c9bec1ee-529.jpg": ["RRB", "RRB"],
    "14347cf8-592.jpg": ["RRB", "BBR", "empty"],
    "09bb05c9-121.jpg": ["RRB", "RRB", "BBR", "empty"],
}


def photograph(name):
    if not PHOTOGRAPHS.is_dir():
        missing("the photographs of the contest's balls are not here")
    return cv2.imread(str(PHOTOGRAPHS / name))


def truths(name, image):
    """Boxes and class names of a photograph's balls."""
    names = (PHOTOGRAPHS / "classes.txt").read_text().split()
    rows = np.loadtxt((PHOTOGRAPHS / name).with_suffix(".txt"), ndmin=2)
    return xyxy_from_yolo(rows, *image.shape[1::-1]), [names[int(k)] for k in rows[:, 0]]


def photographs():
    return sorted(p.name for p in PHOTOGRAPHS.glob("*.[jp][pn]g")) or ["the photographs"]


@pytest.mark.parametrize("name", photographs())
def test_every_unoccluded_ball_of_the_photographs_is_found_with_its_colour(name):
    """Unoccluded: as high as wide to a quarter, inside the border, no nearer ball's box over it."""
    image = photograph(name)
    boxes, names = truths(name, image)
    found = load_detector("ball").detect(image)
    overlap = box_iou(boxes, found.boxes)
    for k, (box, colour) in enumerate(zip(boxes, names, strict=True)):
        width, height = box[2:] - box[:2]
        inside = box[:2].min() > 3 and (box[2:] < np.array(image.shape[1::-1]) - 3).all()
        others = np.delete(boxes, k, axis=0)
        free = (box_iou([box], others) < 0.02).all() if len(others) else True
        if inside and free and 0.8 < width / height < 1.25:
            hits = overlap[k] > 0.4
            assert hits.any(), (name, k, colour)
            best = np.flatnonzero(hits)[0]
            assert BALL_NAMES[found.class_ids[best]] == colour, (name, k)


BALL_NAMES = CLASSES["ball"]


@pytest.mark.parametrize("name", CONTENTS)
def test_the_silos_of_the_photographs_hold_what_they_hold(name):
    from robocon_course.vision.locate import silo_contents

    image = photograph(name)
    found = load_detector("silo").detect(image)
    whole = found.boxes[:, 0] > 0.02 * image.shape[1]  # one is cut by the left border
    found = detection.Detections(*(part[whole] for part in found))
    assert list(silo_contents(found)) == CONTENTS[name]


# --- another size ----------------------------------------------------------------------------


def test_the_same_network_looks_at_smaller_pictures_and_finds_the_same_balls():
    detector, taken = load_detector("ball"), picture("ball", 17, 1)
    fast = detector.with_size(320)
    assert (fast.size, detector.size) == (320, 480)
    assert max(fast.letterbox(taken.image_bgr)[0].shape) == 320
    small, big = (one.detect(taken.image_bgr, min_score=0.6) for one in (fast, detector))
    assert len(small.scores) > 0
    best = box_iou(small.boxes, big.boxes).max(axis=1)
    assert (best > 0.7).all()


@pytest.mark.parametrize("size", [0, 16, 100, 320.0, "480", True, -32])
def test_a_size_that_no_network_takes_is_refused(size):
    with pytest.raises(ValueError, match="size: expected a multiple of 32 pixels"):
        load_detector("ball").with_size(size)


def test_a_network_for_squares_of_one_size_takes_no_other(tmp_path):
    detector = load_detector(small_network(tmp_path / "mine.onnx"))
    assert detector.step == detector.size == 32
    with pytest.raises(ValueError, match=r"takes 32 pixels only, got 64"):
        detector.with_size(64)
    assert detector.with_size(detector.size).size == detector.size
