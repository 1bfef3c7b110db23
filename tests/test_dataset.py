"""Data sets: layout and shares, the same bytes however drawn, and a check that finds each fault."""

from __future__ import annotations

import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from robocon_course import cli
from robocon_course.vision import dataset
from robocon_course.vision.classes import BALLS, CLASSES
from robocon_course.vision.dataset import (
    DatasetError,
    augment,
    check_dataset,
    contact_sheet,
    split_of,
    write_dataset,
    yolo_lines,
)
from robocon_course.vision.metrics import xyxy_from_yolo
from robocon_course.vision.pictures import picture

SMALL = (96, 72)


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("sets") / "balls"
    return write_dataset("ball", folder, 60, seed=5, size=SMALL, workers=1)


@pytest.fixture
def mine(whole, tmp_path) -> Path:
    """A copy to spoil."""
    return Path(shutil.copytree(whole, tmp_path / "copy"))


def contents(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_seven_of_ten_train_two_validate_one_tests():
    shares = [split_of(k) for k in range(1000)]
    assert [shares.count(s) for s in dataset.SPLITS] == [700, 200, 100]


def test_every_picture_has_its_label_file_and_its_place(whole):
    files = contents(whole)
    for k in range(60):
        assert f"images/{split_of(k)}/ball_{k:06d}.jpg" in files
        assert f"labels/{split_of(k)}/ball_{k:06d}.txt" in files
    about = yaml.safe_load(files["data.yaml"])
    assert about["names"] == dict(enumerate(BALLS)) and about["train"] == "images/train"
    assert check_dataset(whole) == []


def test_labels_are_the_boxes_of_the_picture(whole):
    taken = picture("ball", 5, 8, SMALL)
    rows = np.loadtxt(whole / "labels" / "val" / "ball_000008.txt", ndmin=2)
    np.testing.assert_allclose(xyxy_from_yolo(rows, *SMALL), taken.boxes, atol=1e-3)
    np.testing.assert_array_equal(rows[:, 0], taken.class_ids)
    stored = cv2.imread(str(whole / "images" / "val" / "ball_000008.jpg"))
    assert np.abs(stored.astype(int) - taken.image_bgr).mean() < 4


def test_yolo_lines_by_hand():
    assert (
        yolo_lines([[10, 20, 30, 60]], [2], 100, 100) == "2 0.200000 0.400000 0.200000 0.400000\n"
    )
    assert yolo_lines(np.empty((0, 4)), [], 100, 100) == ""


def test_two_workers_write_the_bytes_of_one(whole, tmp_path):
    told = []
    again = write_dataset(
        "ball", tmp_path / "two", 60, seed=5, size=SMALL, workers=2,
        progress=lambda done, of: told.append((done, of)),
    )  # fmt: skip
    assert contents(again) == contents(whole)
    assert told[-1] == (60, 60) and told == sorted(told)


def test_another_seed_draws_other_pictures(whole, tmp_path):
    other = write_dataset("ball", tmp_path / "o", 10, seed=6, size=SMALL, workers=1)
    name = "images/train/ball_000000.jpg"
    assert contents(other)[name] != contents(whole)[name]


def test_a_run_that_is_cut_off_leaves_nothing(tmp_path):
    def stop(done, of):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_dataset("ball", tmp_path / "cut", 40, size=SMALL, workers=1, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_augmentation_stays_within_what_was_published():
    grey = np.full((120, 160, 3), 128, np.uint8)
    means = []
    for seed in range(200):
        changed = augment(grey, np.random.default_rng(seed))
        assert changed.shape == grey.shape and changed.dtype == np.uint8
        means.append(np.median(changed) / 128)
        spots = (np.abs(changed.astype(int) - np.median(changed)) > 2).any(axis=2)
        assert spots.mean() <= 0.0011
    assert 0.85 * 0.9 - 0.01 <= min(means) < 0.9 and 1.1 < max(means) <= 1.15 * 1.1 + 0.01
    same = [augment(grey, np.random.default_rng(3)) for _ in range(2)]
    np.testing.assert_array_equal(*same)


def first(folder: Path, pattern: str) -> Path:
    return sorted(folder.glob(pattern))[0]


SPOILT = {
    "missing label": (lambda f: first(f, "labels/train/*").unlink(), "has no label file"),
    "label of nothing": (lambda f: first(f, "images/train/*").unlink(), "has no picture"),
    "empty label": (lambda f: first(f, "labels/val/*8.txt").write_text(""), "is empty"),
    "no picture": (lambda f: first(f, "images/test/*").write_bytes(b"JPEG"), "cannot be read"),
    "empty picture": (lambda f: first(f, "images/test/*").write_bytes(b""), "cannot be read"),
    "four numbers": (lambda f: first(f, "labels/val/*").write_text("0 .5 .5 .1\n"), "five numbers"),
    "words": (lambda f: first(f, "labels/val/*").write_text("ball . . . .\n"), "five numbers"),
    "nan": (lambda f: first(f, "labels/val/*").write_text("0 nan .5 .1 .1\n"), "five numbers"),
    "class 3": (lambda f: first(f, "labels/val/*").write_text("3 .5 .5 .1 .1\n"), "class 3"),
    "class 0.5": (lambda f: first(f, "labels/val/*").write_text("0.5 .5 .5 .1 .1\n"), "class 0.5"),
    "out of it": (lambda f: first(f, "labels/val/*").write_text("0 .98 .5 .1 .1\n"), "leaves"),
    "no size": (lambda f: first(f, "labels/val/*").write_text("0 .5 .5 0 .1\n"), "without size"),
    "twice": (
        lambda f: shutil.copy(first(f, "images/train/*"), f / "images/val/ball_000007.jpg"),
        "is the same picture as images/train",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILT)
def test_each_fault_is_named_with_its_file(mine, name):
    spoil, what = SPOILT[name]
    spoil(mine)
    problems = check_dataset(mine)
    assert any(what in problem.what for problem in problems), problems
    assert all(problem.file for problem in problems)


def test_a_class_without_boxes_is_reported(mine):
    for path in mine.glob("labels/*/*.txt"):
        kept = [line for line in path.read_text().splitlines() if line[0] != "1"]
        path.write_text("".join(f"{line}\n" for line in kept))
    assert any("'purple' has 0 boxes" in problem.what for problem in check_dataset(mine))


def test_a_background_picture_is_no_fault_and_a_forgotten_label_is(mine):
    first(mine, "labels/val/*").write_text("")
    assert any("is empty" in problem.what for problem in check_dataset(mine))
    (mine / "background.txt").write_text("val/ball_000007\n")
    assert check_dataset(mine) == []


@pytest.mark.parametrize("text", [None, "names: [", "path: .", "names: 7"])
def test_a_folder_without_a_description_is_refused(mine, text):
    path = mine / "data.yaml"
    path.unlink() if text is None else path.write_text(text)
    with pytest.raises(DatasetError, match=r"data\.yaml"):
        check_dataset(mine)


def test_the_contact_sheet_shows_pictures_with_their_boxes(whole):
    sheet = contact_sheet(whole, 7, across=3)
    assert sheet.shape[1] == 3 * 240 and sheet.shape[0] % 3 == 0
    white = (sheet == 255).all(axis=(1, 2))
    assert white[: sheet.shape[0] // 3].sum() <= 4  # the margin, no empty band
    with_boxes = (np.abs(sheet.astype(int) - dataset.COLOURS["red"]) < 12).all(axis=2)
    assert with_boxes.sum() > 20
    with pytest.raises(DatasetError, match="no pictures"):
        contact_sheet(whole, split="nowhere")


def test_what_cannot_be_written_is_refused(whole, tmp_path):
    with pytest.raises(DatasetError, match="exists"):
        write_dataset("ball", whole, 20)
    with pytest.raises(ValueError, match="at least 10"):
        write_dataset("ball", tmp_path / "x", 9)
    with pytest.raises(ValueError, match="'ball' or 'silo'"):
        write_dataset("cube", tmp_path / "x", 20)


# --- the command ----------------------------------------------------------------------------------


def robocon(*arguments) -> tuple[int, str]:
    done = CliRunner().invoke(cli.app, [str(a) for a in arguments], env={"COLUMNS": "200"})
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, " ".join((done.output + done.stderr).split())


def test_robocon_dataset_draws_checks_and_shows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, said = robocon("dataset", "silo", "--images", 100, "--seed", 2, "--workers", 1)
    assert "data-silo" in said and code in (0, 1)  # a hundred may lack one filling of fifteen
    assert (tmp_path / "data-silo" / "contact-sheet.jpg").stat().st_size > 20_000
    assert dataset.read_names("data-silo") == CLASSES["silo"]
    code, said = robocon("dataset", "silo", "--images", 100)
    assert code == 2 and "exists" in said


def test_robocon_dataset_check_lists_problems(mine):
    assert robocon("dataset", "ball", "--check", mine)[0] == 0
    first(mine, "labels/train/*").unlink()
    code, said = robocon("dataset", "ball", "--check", mine)
    assert code == 1 and "has no label file" in said and "1 problems" in said


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [(("cube",), "'ball' or 'silo'"), (("ball", "--images", 3), "at least 10")],
)
def test_robocon_dataset_refuses_in_a_sentence(tmp_path, monkeypatch, arguments, rule):
    monkeypatch.chdir(tmp_path)
    code, said = robocon("dataset", *arguments)
    assert code == 2 and rule in said
