"""Training: seeded, quiet, on any CPU, resumable after a kill, and nothing is downloaded."""

from __future__ import annotations

import signal
import socket
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from robocon_course import cli
from robocon_course.vision import pictures
from robocon_course.vision.classes import CLASSES
from robocon_course.vision.detection import WeightsError, letterbox, load_detector

training = pytest.importorskip(
    "robocon_course.vision.training", reason='needs pip install -e ".[vision]"'
)
SMALL = {"image_size": 64, "batch": 4}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Eight pictures of balls, as small as a network can take them."""
    folder = tmp_path_factory.mktemp("data")
    for split, indices in (("train", range(8)), ("val", range(8, 12))):
        (folder / "images" / split).mkdir(parents=True)
        (folder / "labels" / split).mkdir(parents=True)
        for k in indices:
            taken = pictures.picture("ball", 3, k, (64, 64))
            cv2.imwrite(str(folder / "images" / split / f"{k}.jpg"), taken.image_bgr)
            boxes = taken.boxes / 64
            rows = np.c_[
                taken.class_ids, (boxes[:, :2] + boxes[:, 2:]) / 2, boxes[:, 2:] - boxes[:, :2]
            ]
            np.savetxt(folder / "labels" / split / f"{k}.txt", rows, fmt=["%d"] + ["%.6f"] * 4)
    about = {"path": str(folder), "train": "images/train", "val": "images/val",
             "names": dict(enumerate(CLASSES["ball"]))}  # fmt: skip
    (folder / "data.yaml").write_text(yaml.safe_dump(about))
    return folder


@pytest.fixture(scope="module")
def trained(data, tmp_path_factory):
    run, told = tmp_path_factory.mktemp("runs") / "one", []
    # Whoever asks the network for anything fails here.
    keep, socket.socket.connect = socket.socket.connect, None
    try:
        last = training.train("ball", data, run, epochs=3, progress=told.append, **SMALL)
    finally:
        socket.socket.connect = keep
    return run, last, told


def test_every_epoch_is_told_once_with_a_finite_loss(trained):
    _, _, told = trained
    assert [(one.number, one.of) for one in told] == [(1, 3), (2, 3), (3, 3)]
    assert np.isfinite([one.loss for one in told]).all()


def test_the_history_has_a_row_an_epoch(trained):
    run, _, told = trained
    curves = training.history(run)
    assert curves["epoch"].tolist() == [1, 2, 3]
    total = curves["box"] + curves["class"] + curves["dfl"]
    np.testing.assert_allclose(total, [one.loss for one in told], rtol=1e-3)


def test_the_same_seed_gives_the_same_losses_and_another_seed_others(trained, data, tmp_path):
    run, *_ = trained
    training.train("ball", data, tmp_path / "again", epochs=3, **SMALL)
    np.testing.assert_array_equal(
        training.history(run)["box"], training.history(tmp_path / "again")["box"]
    )
    training.train("ball", data, tmp_path / "other", epochs=1, seed=1, **SMALL)
    assert training.history(tmp_path / "other")["box"][0] != training.history(run)["box"][0]


def test_a_finished_run_is_left_as_it_is(trained, data):
    run, last, _ = trained
    before = last.stat().st_mtime_ns
    assert training.train("ball", data, run, epochs=3, **SMALL) == last
    assert last.stat().st_mtime_ns == before


KILLED = """
import sys
from robocon_course.vision import training
def told(epoch):
    print(epoch.number, flush=True)
training.train("ball", sys.argv[1], sys.argv[2], epochs=40, image_size=64, batch=4, progress=told)
"""


def test_a_killed_run_goes_on_after_its_last_whole_epoch(data, tmp_path):
    run = tmp_path / "killed"
    command = [sys.executable, "-c", KILLED, str(data), str(run)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        for line in child.stdout:
            if int(line) == 3:
                child.send_signal(signal.SIGKILL)
                break
    # And the kill came while the newest checkpoint was being written.
    last = run / "weights" / "last.pt"
    last.write_bytes(last.read_bytes()[: last.stat().st_size // 2])
    numbers = []

    # Three epochs are enough to see where it goes on.
    def stop(epoch):
        numbers.append(epoch.number)
        if len(numbers) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        training.train("ball", data, run, progress=stop)
    assert numbers[0] in (2, 3, 4) and numbers[1] == numbers[0] + 1
    assert numbers[0] > 1


def test_the_exported_network_answers_as_the_trained_one(trained, tmp_path):
    import onnxruntime
    import torch
    from ultralytics import YOLO

    _, last, _ = trained
    path = training.export(last, tmp_path / "ball.onnx", 64)
    assert path.stat().st_size < 13_000_000
    detector = load_detector(path)
    assert detector.names == CLASSES["ball"] and detector.size == 64
    tensor, *_ = letterbox(pictures.picture("ball", 4, 0).image_bgr, 64)
    ours = onnxruntime.InferenceSession(str(path)).run(None, {"images": tensor})[0]
    with torch.no_grad():
        theirs = YOLO(last).model.float().eval()(torch.from_numpy(tensor))[0].numpy()
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


def test_another_run_can_be_the_start(trained, data, tmp_path):
    _, last, _ = trained
    training.train("ball", data, tmp_path / "next", epochs=1, start_from=last, **SMALL)
    begun = training.history(tmp_path / "next")["box"][0]
    assert begun != training.history(trained[0])["box"][0]


def test_several_gpus_would_find_our_trainer(data, tmp_path):
    """Ultralytics starts one process a GPU with a file that imports the trainer by name."""
    import torch
    from ultralytics.utils.dist import generate_ddp_file

    trainer = training.Trainer(overrides={"model": training.RECIPE, "data": str(data / "data.yaml"),
                                          "device": "cpu", "project": str(tmp_path)})  # fmt: skip
    script = Path(generate_ddp_file(trainer))
    kept = script.with_suffix(".pt")
    try:
        state = torch.load(kept, weights_only=False)
        again = state["trainer"](overrides=state["args"], _callbacks=state["callbacks"])
    finally:
        script.unlink()
        kept.unlink()
    assert type(again) is training.Trainer
    assert again.args.data == trainer.args.data


@pytest.mark.parametrize(
    ("change", "rule"),
    [
        ({"kind": "cube"}, "'ball' or 'silo'"),
        ({"epochs": 0}, "at least 1"),
        ({"image_size": 100}, "multiple of 32"),
        ({"batch": 0}, "at least 1"),
        ({"device": "7"}, "--device cpu"),
        ({"kind": "silo"}, "not those of 'silo'"),
        ({"data": "nowhere"}, "robocon dataset"),
    ],
)
def test_what_cannot_be_trained_is_refused(data, tmp_path, change, rule):
    asked = {"kind": "ball", "data": data, "run": tmp_path / "run", "epochs": 1} | change
    kind, folder, run = (asked.pop(name) for name in ("kind", "data", "run"))
    with pytest.raises((ValueError, training.TrainingError), match=rule):
        training.train(kind, folder, run, **asked)
    assert not (tmp_path / "run").exists()


def test_checkpoints_that_are_all_broken_are_said_to_be(data, tmp_path):
    (tmp_path / "run" / "weights").mkdir(parents=True)
    (tmp_path / "run" / "weights" / "last.pt").write_bytes(b"nothing")
    with pytest.raises(training.TrainingError, match="delete the folder"):
        training.train("ball", data, tmp_path / "run", epochs=1, **SMALL)


def test_a_checkpoint_is_no_file_of_weights(trained):
    with pytest.raises(WeightsError, match=r"not a network"):
        load_detector(trained[1])


# --- the command ----------------------------------------------------------------------------------


def robocon(*arguments) -> tuple[int, str]:
    done = CliRunner().invoke(cli.app, [str(a) for a in arguments], env={"COLUMNS": "200"})
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done.exit_code, " ".join((done.output + done.stderr).split())


def test_robocon_train_leaves_a_network_that_opens(data, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    line = "train", "ball", "--data", data, "--epochs", 1, "--image-size", 64, "--batch", 4
    code, said = robocon(*line)
    assert code == 0 and "run-ball/ball.onnx" in said and "mAP50" in said
    assert load_detector(tmp_path / "run-ball" / "ball.onnx").size == 64
    # Typed again it finds everything done.
    assert robocon(*line)[0] == 0


@pytest.mark.parametrize(
    ("more", "rule"),
    [((), "robocon dataset ball"), (("--epochs", 0), "at least 1"), (("--device", "3"), "cpu")],
)
def test_robocon_train_refuses_in_a_sentence(tmp_path, monkeypatch, more, rule):
    monkeypatch.chdir(tmp_path)
    code, said = robocon("train", "ball", *more)
    assert code == 2 and rule in said
    assert list(tmp_path.iterdir()) == []
