"""The networks that the course ships, their card, and the sorting of their errors."""

from __future__ import annotations

import importlib.util
import json
import sys
from functools import cache

import numpy as np
import pytest

from conftest import ROOT
from robocon_course.vision import Detections, load_detector
from robocon_course.vision.evaluation import LOWEST
from robocon_course.vision.pictures import Picture, picture

WEIGHTS = ROOT / "data" / "weights"
CARD = json.loads((WEIGHTS / "card.json").read_text(encoding="utf-8"))
THING, APART, DOUBTFUL = [0.0, 0.0, 10.0, 10.0], [40.0, 0.0, 50.0, 10.0], [20.0, 0.0, 30.0, 10.0]


@cache
def script(name: str):
    """A program of the weights' folder; they read each other."""
    sys.path.append(str(WEIGHTS))
    spec = importlib.util.spec_from_file_location(f"weights_{name}", WEIGHTS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def taken() -> Picture:
    """A blue ball, a red one apart from it, and one between that is seen too little."""
    image = np.zeros((20, 60, 3), np.uint8)
    return Picture(image, np.array([THING, APART]), np.array([0, 2]), np.array([DOUBTFUL]))


def reports(*rows: tuple) -> Detections:
    """Reports (box, class number), each less sure than the one before."""
    boxes = np.array([box for box, _ in rows], np.float32)
    scores = np.linspace(0.9, 0.1, len(rows), dtype=np.float32)
    return Detections(boxes, scores, np.array([number for _, number in rows]))


def test_each_report_is_of_one_kind():
    found = reports(
        (THING, 0),
        (THING, 0),
        (THING, 1),
        ([0.0, 0.0, 10.0, 3.0], 0),
        ([0.0, 0.0, 10.0, 3.0], 1),
        (DOUBTFUL, 1),
        ([0.0, 12.0, 5.0, 18.0], 0),
        (APART, 2),
    )
    assert script("errors").kinds_of(found, taken()) == [
        "hit",
        "duplicate",
        "class",
        "place",
        "class and place",
        "doubtful",
        "nothing there",
        "hit",
    ]


def test_a_thing_is_as_sure_as_its_best_right_report():
    found = reports((THING, 1), (THING, 0), (THING, 0))
    np.testing.assert_allclose(script("errors").surest(found, taken()), [0.5, 0.0])
    nothing = Detections(np.empty((0, 4)), np.empty(0), np.empty(0, int))
    assert script("errors").surest(nothing, taken()).tolist() == [0.0, 0.0]
    assert script("errors").kinds_of(nothing, taken()) == []


class Knowing:
    """Reports the truth of the pictures it is asked about in turn, or nothing at all."""

    size = 320

    def __init__(self, drawn, everything):
        self.drawn, self.everything = iter(drawn), everything

    def detect(self, image_bgr, min_score):
        one = next(self.drawn)
        many = len(one.boxes) if self.everything else 0
        return Detections(one.boxes[:many], np.ones(many), one.class_ids[:many])


@pytest.mark.filterwarnings("ignore:Mean of empty slice")  # without the unseen nothing is left
@pytest.mark.parametrize(("everything", "score"), [(True, 0.995), (False, 0.0)])
def test_the_table_of_errors_counts_what_is_never_seen(everything, score):
    drawn = [taken()] * 3
    head, _, *rows = script("errors").told("ball", Knowing(drawn, everything), drawn)
    assert head == f"ball at 320 pixels: mAP {score:.3f}"
    *kinds, never = [row for row in rows if "pixels" not in row]
    assert all(row.split()[-2:] == ["0", "+0.0000"] for row in kinds)
    assert never.split()[2] == ("0" if everything else "6")
    assert f"  8 to 12 pixels: {0 if everything else 6} missed of 6" in rows


@pytest.mark.parametrize(
    ("rows", "hard"),
    [
        ([(THING, 0, 0.9), (APART, 2, 0.7)], False),
        ([(THING, 0, 0.9), (APART, 2, 0.5)], True),  # right, but unsure
        ([(THING, 0, 0.9)], True),
        ([(THING, 0, 0.9), (APART, 2, 0.7), (APART, 1, 0.2)], False),  # wrong, but hardly sure
        ([(THING, 0, 0.9), (APART, 2, 0.7), (APART, 1, 0.4)], True),
        ([(THING, 0, 0.9), (APART, 2, 0.7), (DOUBTFUL, 1, 0.4)], True),
    ],
)
def test_hard_is_a_picture_with_something_to_learn(rows, hard):
    boxes, ids, scores = zip(*rows, strict=True)
    found = Detections(np.array(boxes), np.array(scores), np.array(ids))
    assert script("mine").is_hard(found, taken()) is hard


def test_a_mined_picture_is_kept_thrice_if_hard_and_else_a_third_of_them(tmp_path, monkeypatch):
    for part in ("images", "labels"):
        for split in ("train", "val"):
            (tmp_path / part / split).mkdir(parents=True)
    hard = [False, True, False, False, True, True, True]
    answers = iter(hard)
    monkeypatch.setattr(script("mine"), "is_hard", lambda found, taken: next(answers))
    assert [script("mine").keep("silo", 14, tmp_path, k) for k in range(len(hard))] == hard
    for part, ending in (("images", "jpg"), ("labels", "txt")):
        kept = [path.stem for path in (tmp_path / part).glob(f"*/*.{ending}")]
        times = [sum(f"_{k:06d}_" in name for name in kept) for k in range(len(hard))]
        assert times == [1, 3, 0, 1, 3, 3, 3]
        assert [path.stem for path in (tmp_path / part / "val").iterdir()] == ["silo_000000_0"]


@pytest.mark.parametrize("kind", ["ball", "silo"])
def test_the_cards_figure_holds_on_a_sample(kind):
    detector = load_detector(kind)
    drawn = [picture(kind, 888_000, index, None) for index in range(100)]
    rows = [
        (detector.detect(one.image_bgr, min_score=LOWEST), one.boxes, one.class_ids)
        for one in drawn
    ]
    assert script("errors").mean_ap(kind, rows) > CARD[kind]["again"]["map50"] - 0.03


def test_the_card_in_words_says_what_was_measured():
    assert (WEIGHTS / "README.md").read_text(encoding="utf-8") == script("make").in_words(CARD)


def test_the_curve_ends_with_the_network_that_is_shipped():
    curve = json.loads((WEIGHTS / "curve.json").read_text(encoding="utf-8"))
    passes = [point["passes"] for point in curve]
    assert passes == sorted(set(passes))
    assert curve[-1]["map50"] == CARD["silo"]["synthetic"]["map50"]
