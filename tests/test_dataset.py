"""Data sets: layout and shares, the same bytes however drawn, and a check that finds each fault."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from robocon_course import cli
from robocon_course.vision import dataset, inspection, sheet
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


def spoil_label(text):
    return lambda f: first(f, "labels/val/*").write_text(text)


def describe(**changes):
    """Change lines of data.yaml; None takes one out."""

    def spoil(folder):
        path = folder / "data.yaml"
        about = yaml.safe_load(path.read_text()) | changes
        path.write_text(yaml.safe_dump({k: v for k, v in about.items() if v is not None}))

    return spoil


def tear(folder):
    path = first(folder, "images/test/*")
    path.write_bytes(path.read_bytes()[:-40])


def twice_in_one_split(folder):
    shutil.copy(first(folder, "images/train/*"), folder / "images/train/again.jpg")
    shutil.copy(first(folder, "labels/train/*"), folder / "labels/train/again.txt")


SPOILT = {
    "missing label": (lambda f: first(f, "labels/train/*").unlink(), "has no label file"),
    "label of nothing": (lambda f: first(f, "images/train/*").unlink(), "has no picture"),
    "empty label": (lambda f: first(f, "labels/val/*8.txt").write_text(""), "is empty"),
    "no picture": (lambda f: first(f, "images/test/*").write_bytes(b"JPEG"), "cannot be read"),
    "empty picture": (lambda f: first(f, "images/test/*").write_bytes(b""), "cannot be read"),
    "torn picture": (tear, "cannot be read"),
    "four numbers": (spoil_label("0 .5 .5 .1\n"), "five numbers"),
    "words": (spoil_label("ball . . . .\n"), "five numbers"),
    "nan": (spoil_label("0 nan .5 .1 .1\n"), "five numbers"),
    "class 3": (spoil_label("3 .5 .5 .1 .1\n"), "class 3"),
    "class 0.5": (spoil_label("0.5 .5 .5 .1 .1\n"), "class 0.5"),
    "class below 0": (spoil_label("-1 .5 .5 .1 .1\n"), "class -1"),
    "out of it": (spoil_label("0 .98 .5 .1 .1\n"), "leaves"),
    "no size": (spoil_label("0 .5 .5 0 .1\n"), "without size"),
    "line twice": (spoil_label("0 .5 .5 .1 .1\n0 .5 .5 .1 .1\n"), "line 1 again"),
    "twice": (
        lambda f: shutil.copy(first(f, "images/train/*"), f / "images/val/ball_000007.jpg"),
        "is the same picture as images/train",
    ),
    "twice in one split": (twice_in_one_split, "is the same picture as images/train"),
    "two pictures, one label": (
        lambda f: shutil.copy(
            f / "images/train/ball_000001.jpg", f / "images/train/ball_000000.png"
        ),
        "shares its label file",
    ),
    "no split": (lambda f: shutil.rmtree(f / "images/test"), "holds no picture"),
    "unknown background": (
        lambda f: (f / "background.txt").open("a").write("train/nobody\n"),
        "names train/nobody",
    ),
    "background with boxes": (
        lambda f: (f / "background.txt").open("a").write("train/ball_000000\n"),
        "says the picture has none",
    ),
    "broken description": (lambda f: (f / "data.yaml").write_text("names: ["), "no description"),
    "empty description": (lambda f: (f / "data.yaml").write_text(""), "no description"),
    "names in a word": (describe(names="ball"), "from number 0 on"),
    "no names": (describe(names=[]), "from number 0 on"),
    "a gap": (describe(names={0: "blue", 2: "purple", 3: "red"}), "from number 0 on"),
    "one name twice": (describe(names=["blue", "red", "red"]), "two classes"),
    "another count": (describe(nc=5), "nc is 5"),
    "leads elsewhere": (describe(train="pictures/train"), "expected 'images/train'"),
    "leads nowhere": (describe(val=None), "names nothing for val"),
}


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


def test_a_torn_jpeg_is_told_even_where_the_decoder_fills_it_up(tmp_path, monkeypatch):
    filled = np.zeros((4, 4, 3), np.uint8)
    monkeypatch.setattr(cv2, "imdecode", lambda *_: filled)
    head, scan, end = b"\xff\xd8 \xff\xd8 thumbnail \xff\xd9", b"\xff\xda light", b"\xff\xd9"
    path = tmp_path / "a.jpg"
    for data, whole in (
        (head + scan, False),
        (head + scan + end, True),
        (head + scan + end + b"more", True),
    ):
        path.write_bytes(data)
        assert (inspection.read_picture(path) is filled) == whole


def test_a_folder_without_a_description_is_refused(mine):
    (mine / "data.yaml").unlink()
    for look in (check_dataset, dataset.read_names, contact_sheet):
        with pytest.raises(DatasetError, match=r"no data\.yaml"):
            look(mine)


def test_classes_of_another_kind_are_a_problem(mine):
    assert check_dataset(mine, kind="ball") == []
    assert any("a silo set has empty, B" in p.what for p in check_dataset(mine, kind="silo"))
    with pytest.raises(ValueError, match="'ball' or 'silo'"):
        check_dataset(mine, kind="cube")


def test_a_broken_description_hides_no_other_problem(mine):
    (mine / "data.yaml").write_text("names: [")
    first(mine, "labels/train/*").unlink()
    found = [problem.what for problem in check_dataset(mine)]
    assert any("no description" in what for what in found) and "has no label file" in found


@pytest.mark.parametrize("name", SPOILT)
def test_the_contact_sheet_shows_a_spoilt_set_or_refuses_it(mine, name):
    SPOILT[name][0](mine)
    try:
        shown = [
            contact_sheet(mine, split=s) for s in dataset.SPLITS if any(mine.glob(f"images/{s}/*"))
        ]
    except DatasetError as error:
        assert "data.yaml" in str(error)
    else:
        assert all(sheet.shape[1] > 240 for sheet in shown)


def test_the_contact_sheet_shows_pictures_with_their_boxes(whole):
    shown = contact_sheet(whole, 7, across=3)
    assert shown.shape[1] == 3 * 240 and shown.shape[0] % 3 == 0
    white = (shown == 255).all(axis=(1, 2))
    assert white[: shown.shape[0] // 3].sum() <= 4  # the margin, no empty band
    with_boxes = (np.abs(shown.astype(int) - sheet.COLOURS["red"]) < 12).all(axis=2)
    assert with_boxes.sum() > 20
    assert contact_sheet(whole, 2).shape[1] == 2 * 240
    with pytest.raises(DatasetError, match="no pictures"):
        contact_sheet(whole, split="nowhere")
    for wrong in ({"count": 0}, {"across": 0}, {"side": 8}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            contact_sheet(whole, **wrong)


def test_what_cannot_be_written_is_refused(whole, tmp_path):
    with pytest.raises(DatasetError, match="exists"):
        write_dataset("ball", whole, 20)
    (tmp_path / "file").touch()
    with pytest.raises(DatasetError, match="file is no folder"):
        write_dataset("ball", tmp_path / "file" / "x", 20)


@pytest.mark.parametrize(
    ("order", "rule"),
    [
        ({"images": 9}, "images: .*at least 10, got 9"),
        ({"images": 10.5}, "images: expected a whole number"),
        ({"kind": "cube"}, "'ball' or 'silo'"),
        ({"seed": -1}, "seed: .*at least 0"),
        ({"workers": 0}, "workers: .*at least 1"),
        ({"size": (10, 10)}, "size: .*at least 32"),
        ({"size": 320}, "size: expected width and height"),
    ],
)
def test_an_order_that_cannot_be_drawn_is_refused_before_anything_is_made(tmp_path, order, rule):
    with pytest.raises(ValueError, match=rule):
        write_dataset(**{"kind": "ball", "folder": tmp_path / "x", "images": 20} | order)
    assert list(tmp_path.iterdir()) == []


def test_augmentation_takes_what_the_detector_takes_and_refuses_the_rest():
    rng = np.random.default_rng(0)
    assert augment(np.zeros((8, 8), np.uint8), rng).shape == (8, 8, 3)
    with pytest.raises(ValueError, match="uint16"):
        augment(np.zeros((8, 8, 3), np.uint16), rng)


def test_drawing_leaves_the_threads_of_opencv_as_they_were(tmp_path):
    threads = cv2.getNumThreads()
    cv2.setNumThreads(2)
    try:
        write_dataset("ball", tmp_path / "x", 10, size=SMALL, workers=1)
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(threads)


def test_what_killed_runs_left_is_cleared_and_what_runs_now_is_not(tmp_path):
    old, new = tmp_path / ".x.1.part", tmp_path / ".x.2.part"
    other = tmp_path / ".y.3.part"
    for left in (old, new, other):
        (left / "images" / "train").mkdir(parents=True)
    past = time.time() - 2 * dataset.FORSAKEN
    for path in (*old.rglob("*"), old, other / "images" / "train", other / "images", other):
        os.utime(path, (past, past))
    write_dataset("ball", tmp_path / "x", 10, size=SMALL, workers=1)
    assert sorted(p.name for p in tmp_path.iterdir()) == [".x.2.part", ".y.3.part", "x"]


def test_a_script_without_its_main_guard_is_told_so(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from robocon_course.vision.dataset import write_dataset\n"
        "write_dataset('ball', 'set', 40, size=(32, 32), workers=2)\n"
    )
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True)
    told = [line for line in done.stderr.splitlines() if "DatasetError: " in line]
    assert done.returncode == 1 and len(told) == 1 and "__main__" in told[0]
    assert list(tmp_path.iterdir()) == [script]


def children(pid: int) -> list[int]:
    listed = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [int(child) for child in listed]


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see processes")
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGKILL])
def test_a_run_that_is_ended_takes_its_workers_along(tmp_path, how):
    command = [sys.executable, "-m", "robocon_course.cli", "dataset", "ball"]
    command += ["--images", "5000", "--out", "deep/set", "--workers", "2"]
    run = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
        env=os.environ | {"PYTHONPATH": str(Path(dataset.__file__).parents[2])},
    )  # fmt: skip
    try:
        until = time.monotonic() + 90
        while not list(tmp_path.rglob("*.jpg")) and time.monotonic() < until:
            time.sleep(0.1)
        assert list(tmp_path.rglob("*.jpg")), "nothing was drawn"
        workers = children(run.pid)
        run.send_signal(how)
        run.wait(60)
        while any(map(alive, workers)) and time.monotonic() < until:
            time.sleep(0.1)
        assert workers and not any(map(alive, workers))
    finally:
        run.kill()
    if how == signal.SIGINT:
        assert list(tmp_path.iterdir()) == []
    assert not (tmp_path / "deep").exists()


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
    assert code == 1 and "has no label file" in said and said.endswith(": 1 problem")
    code, said = robocon("dataset", "silo", "--check", mine)
    assert code == 1 and "a silo set has" in said
    assert robocon("dataset", "cube", "--check", mine)[0] == 2


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [(("cube",), "'ball' or 'silo'"), (("ball", "--images", 3), "at least 10")],
)
def test_robocon_dataset_refuses_in_a_sentence(tmp_path, monkeypatch, arguments, rule):
    monkeypatch.chdir(tmp_path)
    code, said = robocon("dataset", *arguments)
    assert code == 2 and rule in said
