"""How good a network is on a data set: read as written, judged as Ultralytics judges."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from robocon_course import files
from robocon_course.vision import CLASSES, Detections, evaluation
from robocon_course.vision.dataset import DatasetError
from robocon_course.vision.evaluation import evaluate, read_split


@pytest.fixture(scope="module")
def balls():
    return files.data_file("pictures/ball")


class Knowing:
    """A detector that reports what a data set says, but for one class."""

    names = CLASSES["ball"]

    def __init__(self, data, blind):
        self.known = {one.image_bgr.tobytes(): one for one in read_split(data)}
        self.blind = blind

    def detect(self, image, *, min_score):
        one = self.known[image.tobytes()]
        kept = one.class_ids != self.blind
        boxes = one.boxes[kept].astype(np.float32)
        return Detections(boxes, np.ones(len(boxes), np.float32), one.class_ids[kept])


def test_who_knows_all_of_two_classes_and_nothing_of_the_third(balls, monkeypatch):
    monkeypatch.setattr(evaluation, "load_detector", lambda _: Knowing(balls, blind=1))
    found = evaluate("ball", balls)
    assert found == pytest.approx({"blue": 0.995, "purple": 0.0, "red": 0.995}, abs=0.0051)


def test_a_picture_is_read_with_its_boxes_in_pixels(balls):
    first = next(read_split(balls, "val"))
    height, width = first.image_bgr.shape[:2]
    assert len(first.boxes) == len(first.class_ids) > 0
    assert (first.boxes >= -0.5).all() and (first.boxes <= [width + 0.5, height + 0.5] * 2).all()


def test_as_many_pictures_as_there_are_files(balls):
    files_there = list((balls / "images" / "test").glob("*.jpg"))
    assert len(list(read_split(balls))) == len(files_there)


def test_what_cannot_be_judged_is_refused(balls, tmp_path):
    with pytest.raises(DatasetError, match="no pictures"):
        next(read_split(balls, "exam"))
    with pytest.raises(DatasetError, match="those of the network"):
        evaluate("silo", balls)
    with pytest.raises(DatasetError, match=r"no data\.yaml"):
        evaluate("silo", tmp_path)


@pytest.mark.parametrize("text", ["0 0.5 0.5", "7 0.5 0.5 0.1 0.1", "blue 0.5 0.5 0.1 0.1"])
def test_a_label_that_is_none_is_named(balls, tmp_path, text):
    copy = shutil.copytree(balls, tmp_path / "copy")
    label = min((copy / "labels" / "test").iterdir())
    label.write_text(text)
    with pytest.raises(DatasetError, match=label.stem):
        list(read_split(copy))
    label.unlink()
    with pytest.raises(DatasetError, match=label.stem):
        list(read_split(copy))
