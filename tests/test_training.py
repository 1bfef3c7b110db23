"""Training: seeded, quiet, on any CPU, resumable after a kill, and nothing is downloaded."""

from __future__ import annotations

import shutil
import signal
import socket
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from robocon_course import cli, files
from robocon_course.vision import curves, pictures
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
    found = training.history(run)
    assert found["epoch"].tolist() == [1, 2, 3]
    total = found["box"] + found["class"] + found["dfl"]
    np.testing.assert_allclose(total, [one.loss for one in told], rtol=1e-3)


def test_an_epoch_that_was_not_validated_has_no_figures(tmp_path):
    head = ",".join(curves.COLUMNS.values())
    lines = [
        "1,5,1,1,1,0,0,0,0,0,0,0",
        "2,9,1,1,1,.5,.5,.5,.5,2,2,2",
        "3,12,1,1,1,.5,.5,.5,.5,2,2,2",
        "4,20,1,1,1,.5,.5,.6,.5,2,2,2",
        "5,21,1,1",
    ]
    (tmp_path / "results.csv").write_text("\n".join([head, *lines]))
    found = training.history(tmp_path)
    # The last line is still being written.
    assert found["epoch"].tolist() == [1, 2, 3, 4]
    np.testing.assert_array_equal(found["map50"], [np.nan, 0.5, np.nan, 0.6])
    assert [one.seconds for one in curves.new_epochs(tmp_path, 2, 4)] == [12, 20]
    curves.forget_after(tmp_path, 2)
    assert training.history(tmp_path)["epoch"].tolist() == [1, 2]


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
import os, signal, sys
from pathlib import Path
from robocon_course.vision import training

write, written = Path.write_bytes, []

def half_written(self, data):
    written.append(self.name.startswith("last.pt"))
    if sum(written) == 4:
        write(self, data[: len(data) // 2])
        os.kill(os.getpid(), signal.SIGKILL)
    return write(self, data)

Path.write_bytes = half_written
training.train("ball", sys.argv[1], sys.argv[2], epochs=6, image_size=64, batch=4)
"""


def test_a_run_killed_while_it_writes_its_checkpoint_loses_one_epoch(data, tmp_path):
    run, told = tmp_path / "killed", []
    done = subprocess.run([sys.executable, "-c", KILLED, str(data), str(run)])
    assert done.returncode == -signal.SIGKILL
    # The fourth epoch's figures are written, its checkpoint is not.
    assert training.history(run)["epoch"].tolist() == [1, 2, 3, 4]
    # It goes on with its own settings, whatever this call would have begun with.
    last = training.train("ball", data, run, epochs=99, image_size=96, progress=told.append)
    assert [(one.number, one.of) for one in told] == [(4, 6), (5, 6), (6, 6)]
    found = training.history(run)
    assert found["epoch"].tolist() == [1, 2, 3, 4, 5, 6]
    assert (np.diff(found["seconds"]) > 0).all()
    assert sorted(path.name for path in last.parent.iterdir()) == ["best.pt", "last.pt"]
    assert training.export(last, tmp_path / "own.onnx").is_file()
    assert load_detector(tmp_path / "own.onnx").size == 64


def test_the_exported_network_answers_as_the_trained_one(trained, tmp_path):
    import onnxruntime
    import torch
    from ultralytics import YOLO

    _, last, _ = trained
    path = training.export(last, tmp_path / "ball.onnx", 64)
    assert path.stat().st_size < 13_000_000
    assert b"data.yaml" not in path.read_bytes()  # whose folder it was trained in is not told
    detector = load_detector(path)
    assert detector.names == CLASSES["ball"] and detector.size == 64
    tensor, *_ = letterbox(pictures.picture("ball", 4, 0).image_bgr, 64)
    ours = onnxruntime.InferenceSession(str(path)).run(None, {"images": tensor})[0]
    with torch.no_grad():
        theirs = YOLO(last).model.float().eval()(torch.from_numpy(tensor))[0].numpy()
    np.testing.assert_allclose(ours, theirs, atol=1e-3)


def test_a_network_of_which_only_the_file_is_left_can_be_trained_on(data, tmp_path):
    import onnxruntime
    import torch

    path = files.data_file("weights/ball.onnx")
    kept = training.reopen(path, data, tmp_path / "again.pt", 64)
    network = torch.load(kept, weights_only=False)["model"]
    shown = [pictures.picture("ball", 3, k, (64, 64)).image_bgr for k in range(8)]
    tensor = np.concatenate([letterbox(image, 64)[0] for image in shown])
    session = onnxruntime.InferenceSession(str(path))
    theirs = session.run(None, {"images": tensor})[0]
    with torch.no_grad():
        ours = network.eval()(torch.from_numpy(tensor))[0].numpy()
    np.testing.assert_allclose(ours, theirs, atol=2e-3)
    # Batch by batch, as in training, it hardly differs: it goes on from where it was.
    head, inputs = network.model[-1], []
    head.register_forward_pre_hook(lambda _, given: inputs.append(given[0][0].clone()))
    with torch.no_grad():
        network.eval()(torch.from_numpy(tensor))
        network.train()(torch.from_numpy(tensor))
    still, training_mode = inputs
    assert (still - training_mode).std() < 0.2 * still.std()


def test_a_file_of_weights_can_be_the_start(data, tmp_path):
    import onnx
    import torch

    start = files.data_file("weights/ball.onnx")
    slow = SMALL | {"epochs": 1, "rate": 1e-6}
    last = training.train("ball", data, tmp_path / "on", start_from=start, **slow)
    numbers = {
        one.name: onnx.numpy_helper.to_array(one) for one in onnx.load(start).graph.initializer
    }
    layers = torch.load(last, weights_only=False)["model"].state_dict()
    for name in ("model.0.conv.weight", "model.9.cv2.conv.weight", "model.22.cv3.0.2.weight"):
        ours, theirs = layers[name].float().numpy().ravel(), numbers[name].ravel()
        assert np.corrcoef(ours, theirs)[0, 1] > 0.99


def test_another_run_can_be_the_start(trained, data, tmp_path):
    _, last, _ = trained
    training.train("ball", data, tmp_path / "next", epochs=1, start_from=last, **SMALL)
    begun = training.history(tmp_path / "next")["box"][0]
    assert begun != training.history(trained[0])["box"][0]


def test_batches_are_enlarged_by_up_to_what_was_asked_for_also_when_it_goes_on(
    data, tmp_path, monkeypatch
):
    from robocon_course.vision import trainer

    class Stop(Exception):
        pass

    def loss(self, batch, preds=None):
        if self.training:
            sides.append(batch["img"].shape[2:])
        return of_network(self, batch, preds)

    def stop(one):
        raise Stop

    sides, of_network = [], trainer.Network.loss
    monkeypatch.setattr(trainer.Network, "loss", loss)
    asked = {"epochs": 8, "changes": {"multi_scale": 1.0}, **SMALL}
    with pytest.raises(Stop):
        training.train("ball", data, tmp_path / "run", progress=stop, **asked)
    before = len(sides)
    training.train("ball", data, tmp_path / "run", **asked)
    assert set(sides[before:]) == {(64, 64), (96, 96), (128, 128)}
    assert before == 2 and len(sides) == 16


def test_processes_for_gpus_find_our_trainer_and_are_told_of(data, tmp_path, monkeypatch):
    """Where Ultralytics would start one process a GPU, one starts here, on the CPU."""
    from ultralytics.engine import trainer as theirs
    from ultralytics.utils.dist import generate_ddp_file

    def command(trainer):
        shutil.rmtree(trainer.save_dir)  # as Ultralytics does
        file = generate_ddp_file(trainer)
        return [sys.executable, file], file

    def in_processes(self, *settings):
        self.ddp = True
        report(self, *settings)

    report, told = training.Trainer.report, []
    monkeypatch.setattr(training.Trainer, "report", in_processes)
    monkeypatch.setattr(theirs, "generate_ddp_command", command)
    asked = {"epochs": 3, "validate_every": 2, "progress": told.append}
    last = training.train("ball", data, tmp_path / "run", **asked, **SMALL)
    assert [one.number for one in told] == [1, 2, 3]
    assert last.is_file()
    # The network is ours there, too, and validated as seldom as was asked.
    assert type(training.YOLO(last).model).__name__ == "Network"
    measured = np.isfinite(training.history(tmp_path / "run")["map50"])
    assert measured.tolist() == [False, True, True]


def test_an_error_in_the_processes_is_said(data, tmp_path, monkeypatch):
    def failing(self):
        raise subprocess.CalledProcessError(1, "training")

    monkeypatch.setattr(training.Trainer, "train", failing)
    with pytest.raises(training.TrainingError, match="GPUs cpu ended in an error"):
        training.train("ball", data, tmp_path / "run", epochs=1, **SMALL)


def test_half_precision_gives_nearly_the_same_losses(monkeypatch):
    import torch
    from ultralytics.utils import DEFAULT_CFG

    from robocon_course.vision import trainer

    if not trainer.has_bfloat16():
        pytest.skip("this processor does not multiply bfloat16")
    torch.manual_seed(0)
    network = trainer.Network(training.RECIPE, nc=3, ch=3, verbose=False).train()
    network.args = DEFAULT_CFG
    batch = {"img": torch.rand(4, 3, 64, 64), "batch_idx": torch.arange(4.0),
             "cls": torch.zeros(4, 1), "bboxes": torch.full((4, 4), 0.5)}  # fmt: skip
    half = [float(v) for v in network.loss(batch)[1].values()]
    monkeypatch.setattr(trainer, "has_bfloat16", lambda: False)
    full = [float(v) for v in network.loss(batch)[1].values()]
    assert half != full
    np.testing.assert_allclose(half, full, rtol=0.03)


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
        ({"device": "0,0"}, "--device cpu"),
        ({"device": "gpu"}, "--device cpu"),
        ({"validate_every": 0}, "at least 1"),
        ({"changes": {"mosiac": 0.0}}, "got 'mosiac'"),
        ({"changes": {"cls": -1.0}}, "cls is a number from 0"),
        ({"changes": {"cls": "much"}}, "cls is a number from 0"),
        ({"start_from": "nowhere.pt"}, "start_from: give the last.pt"),
        ({"start_from": __file__}, "start_from: give the last.pt"),
        ({"start_from": "nowhere.onnx"}, "not there"),
    ],
)
def test_what_cannot_be_trained_is_refused(data, tmp_path, change, rule):
    asked = {"kind": "ball", "data": data, "run": tmp_path / "run", "epochs": 1} | change
    kind, folder, run = (asked.pop(name) for name in ("kind", "data", "run"))
    with pytest.raises((ValueError, training.TrainingError), match=rule):
        training.train(kind, folder, run, **asked)
    assert not (tmp_path / "run").exists()


def test_a_folder_with_other_things_is_not_trained_in(data, tmp_path):
    (tmp_path / "letter.txt").write_text("dear reader")
    for run, rule in ((tmp_path, "new or empty"), (data, "holds the data"), (data.parent, "holds")):
        with pytest.raises(training.TrainingError, match=rule):
            training.train("ball", data, run, epochs=1, **SMALL)
    with pytest.raises(training.TrainingError, match="is a file"):
        training.train("ball", data, tmp_path / "letter.txt", epochs=1, **SMALL)
    assert (tmp_path / "letter.txt").read_text() == "dear reader"


def test_a_finished_run_is_not_trained_for_longer_nor_for_other_classes(trained, data):
    run, *_ = trained
    with pytest.raises(
        training.TrainingError, match=r"after its 3 epochs; .*start from .*last\.pt"
    ):
        training.train("ball", data, run, epochs=4, **SMALL)
    with pytest.raises(training.TrainingError, match="not of 'silo'"):
        training.train("silo", data, run, epochs=3, **SMALL)


def test_a_data_set_without_its_pictures_is_refused_and_what_it_would_run_is_not(data, tmp_path):
    about = yaml.safe_load((data / "data.yaml").read_text())
    about |= {"download": f"open({str(tmp_path / 'ran')!r}, 'w')", "train": "images/nothing"}
    (tmp_path / "data.yaml").write_text(yaml.safe_dump(about))
    with pytest.raises(training.TrainingError, match="no pictures are there"):
        training.train("ball", tmp_path, tmp_path / "run", epochs=1, **SMALL)
    asked = training.Trainer(overrides={"model": training.RECIPE, "data": str(data / "data.yaml"),
                                        "device": "cpu", "project": str(tmp_path)})  # fmt: skip
    asked.args.data = str(tmp_path / "data.yaml")
    about["val"] = "images/nothing"
    (tmp_path / "data.yaml").write_text(yaml.safe_dump(about))
    with pytest.raises(RuntimeError):
        asked.get_dataset()
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("text", ["", "names: 3", "[1, 2]", "{", "names: [blue, purple, red]"])
def test_a_data_yaml_that_is_none_is_refused(tmp_path, text):
    (tmp_path / "data.yaml").write_text(text)
    with pytest.raises(training.TrainingError, match="no description of a data set"):
        training.train("ball", tmp_path, tmp_path / "run", epochs=1, **SMALL)


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
    assert "epoch 1 of 1: loss" in said
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
