"""Train YOLOv8n on a data set of the course, from its recipe: no weights are downloaded.

``train`` can be killed at any time: called again with the same folder it goes on after the last
whole epoch. ``export`` turns the result into an .onnx file that `detection.load_detector` opens.

Needs the extra: ``pip install -e ".[vision]"``. Nothing else of the course imports torch.
"""

from __future__ import annotations

import os
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml

from robocon_course.vision.classes import CLASSES, classes_of
from robocon_course.vision.curves import Epoch, TrainingError, forget_after, history
from robocon_course.vision.onnx_file import export, reopen
from robocon_course.vision.trainer import (
    RECIPE,
    YOLO,
    Trainer,
    ensure_torchvision,
    read_checkpoint,
    torch,
)

__all__ = [
    "AUGMENTATION",
    "LOSSES",
    "RECIPE",
    "YOLO",
    "Epoch",
    "Trainer",
    "TrainingError",
    "ensure_torchvision",
    "export",
    "history",
    "reopen",
    "train",
]

AUGMENTATION = {
    "hsv_h": 0.008,  # colour is the class: hue hardly moves
    "hsv_s": 0.3,
    "hsv_v": 0.3,
    "fliplr": 0.5,  # a mirrored silo holds the same balls from bottom to top
    "flipud": 0.0,
    "degrees": 0.0,
    "translate": 0.1,
    "scale": 0.35,
    "mosaic": 0.3,
    "mixup": 0.0,
    "cutmix": 0.0,
    "erasing": 0.0,
    "multi_scale": 0.0,  # each batch enlarged at random by up to this share of its size
}
"""What Ultralytics changes in a picture each time it is shown; shares and probabilities."""
LOSSES = {"box": 7.5, "cls": 0.5, "dfl": 1.5}
"""How much the errors of box, class and box's rim weigh; Ultralytics' own numbers."""


def train(
    kind: str,
    data: str | Path,
    run: str | Path,
    *,
    epochs: int = 100,
    image_size: int = 320,
    batch: int = 16,
    rate: float = 0.0015,
    seed: int = 0,
    device: str = "cpu",
    start_from: str | Path | None = None,
    validate_every: int = 1,
    changes: Mapping[str, float] | None = None,
    progress: Callable[[Epoch], None] | None = None,
) -> Path:
    """Train a network, or go on with a training that was cut off.

    Parameters
    ----------
    kind : {"ball", "silo"}
    data : path
        Folder of a data set, as `dataset.write_dataset` makes it.
    run : path
        Folder for everything this training writes. If it holds an unfinished training, that one is
        continued with its own settings; if it holds a finished one, nothing is done.
    epochs : int
        How often each picture is shown.
    image_size : int  [pixels]
        Side of the network's square; a multiple of 32.
    batch : int
        Pictures per step.
    rate : float
        Learning rate of AdamW at its highest; it falls along a cosine.
    seed : int
    device : str
        ``"cpu"``, ``"0"`` for a first GPU, ``"0,1"`` for two of them. May change when it goes on.
    start_from : path, optional
        A checkpoint of your own, or an .onnx file that `export` wrote, whose layers serve as the
        start, as far as they fit.
    validate_every : int  [epochs]
        After the last epoch it is validated in any case.
    changes : mapping, optional
        Numbers to take in place of those of `AUGMENTATION` and `LOSSES`.
    progress : callable, optional
        Called with an `Epoch` after each.

    Returns
    -------
    Path
        The checkpoint of the last epoch.

    Raises
    ------
    TrainingError
        No data set, another kind's data set or training, a device that is not there, a broken
        checkpoint, a folder that holds other things.
    ValueError
        Settings that make no sense.
    """
    data, run = Path(data).resolve(), Path(run).resolve()
    _refuse_settings(kind, epochs, image_size, batch, validate_every)
    _refuse_changes(changes or {})
    last = run / "weights" / "last.pt"
    begun = _begun(run, kind) if last.is_file() else None
    if begun is not None and begun["epoch"] < 0:
        _refuse_more(run, begun, epochs)
        return last
    _refuse_device(device)
    description = _data_file(kind, data)
    _refuse_folder(run, data)
    _refuse_start(start_from)
    given = {"data": str(description), "device": device, "workers": 0, "plots": False}
    if begun is not None:
        forget_after(run, begun["epoch"] + 1)
        given |= {"model": str(last), "resume": str(last)}
    else:
        given |= _settings(run, epochs, image_size, batch, rate) | dict(changes or {}) | {
            "seed": seed, "pretrained": str(start_from) if start_from else False,
        }  # fmt: skip
    torch.set_num_threads(_cores())
    with tempfile.TemporaryDirectory() as folder:
        if begun is None and _is_onnx(start_from):
            start = Path(folder) / "start.pt"
            given["pretrained"] = str(reopen(start_from, data, start, image_size))
        trainer = Trainer(overrides=given)
        trainer.report(validate_every, progress)
        try:
            trainer.train()
        except subprocess.CalledProcessError:
            raise TrainingError(
                f"device: the training on GPUs {device} ended in an error, told above; the same "
                "call goes on after its last epoch"
            ) from None
    return last


def _is_onnx(start_from: str | Path | None) -> bool:
    return start_from is not None and Path(start_from).suffix == ".onnx"


def _settings(run: Path, epochs: int, image_size: int, batch: int, rate: float) -> dict[str, Any]:
    """What Ultralytics is told of a new training."""
    return {
        "model": RECIPE, "epochs": epochs, "imgsz": image_size, "batch": batch, "nbs": batch,
        "optimizer": "AdamW", "lr0": rate, "lrf": 0.02, "cos_lr": True,
        "warmup_epochs": min(0.5, epochs / 4), "close_mosaic": max(1, epochs // 8),
        "patience": 10**6, "project": str(run.parent), "name": run.name, "exist_ok": True,
        **AUGMENTATION, **LOSSES,
    }  # fmt: skip


def _cores() -> int:
    """Processor cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


# --- refusals -------------------------------------------------------------------------------------


def _refuse_settings(kind: str, epochs: int, image_size: int, batch: int, every: int) -> None:
    classes_of(kind)
    if image_size < 32 or image_size % 32:
        raise ValueError(f"image_size: expected a multiple of 32, got {image_size}")
    for name, value in (("epochs", epochs), ("batch", batch), ("validate_every", every)):
        if value < 1:
            raise ValueError(f"{name}: expected at least 1, got {value}")


def _refuse_changes(changes: Mapping[str, float]) -> None:
    known = AUGMENTATION | LOSSES
    for name, value in changes.items():
        if name not in known:
            raise ValueError(f"changes: expected some of {', '.join(known)}, got {name!r}")
        if not (isinstance(value, int | float) and 0.0 <= value < 100.0):
            raise ValueError(f"changes: {name} is a number from 0 to 100, got {value!r}")


def _refuse_device(device: str) -> None:
    """A GPU that is not there is refused here: Ultralytics would print a page."""
    if device == "cpu" or (device == "mps" and torch.backends.mps.is_available()):
        return
    numbers, there = str(device).split(","), torch.cuda.device_count()
    known = all(n.isdecimal() and int(n) < there for n in numbers)
    if not known or len(set(numbers)) < len(numbers):
        raise TrainingError(
            f"device: asked for {device!r}, but this computer has {there} GPUs that torch can use; "
            "use --device cpu"
        )


def _data_file(kind: str, data: Path) -> Path:
    """The data set's description, compared with the classes of the course."""
    path = data / "data.yaml"
    try:
        about = yaml.safe_load(path.read_text(encoding="utf-8"))
        names = about["names"]
        names = tuple(names[k] for k in sorted(names)) if isinstance(names, dict) else tuple(names)
        folders = {part: data / about.get("path", ".") / about[part] for part in ("train", "val")}
    except OSError:
        raise TrainingError(
            f"{data}: no data set (no data.yaml); make one with: robocon dataset {kind}"
        ) from None
    except (yaml.YAMLError, ValueError, KeyError, TypeError):
        raise TrainingError(f"{path}: no description of a data set; make it again") from None
    if names != CLASSES[kind]:
        raise TrainingError(f"{path}: its classes are {names[:3]}…, not those of {kind!r}")
    for part, folder in folders.items():
        if not folder.is_dir() or not any(folder.iterdir()):
            raise TrainingError(f"{path}: {part} should be {folder}, but no pictures are there")
    return path


def _refuse_folder(run: Path, data: Path) -> None:
    """A folder with other things in it: with several GPUs, Ultralytics empties it first."""
    if run == data or run in data.parents:
        raise TrainingError(f"run: {run} holds the data set; a training needs a folder of its own")
    if run.exists() and not run.is_dir():
        raise TrainingError(f"run: {run} is a file; a training needs a folder of its own")
    there = {path.name for path in run.iterdir()} if run.is_dir() else set()
    if there - {"weights"} and "args.yaml" not in there:
        raise TrainingError(
            f"run: {run} holds things that are no training's; name a folder that is new or empty"
        )


def _refuse_start(start_from: str | Path | None) -> None:
    """A file that is not there is refused here: Ultralytics would look for it in the network."""
    if start_from is not None and not _is_onnx(start_from):
        read_checkpoint(Path(start_from), "start_from: give the last.pt of a training of your own")


def _begun(run: Path, kind: str) -> dict:
    """The checkpoint of a training that was begun here, if it can be gone on with."""
    path = run / "weights" / "last.pt"
    found = read_checkpoint(path, "delete the folder of this training and start again")
    names = (found["ema"] or found["model"]).names
    if tuple(names[k] for k in sorted(names)) != CLASSES[kind]:
        raise TrainingError(
            f"run: {run} is a training of {len(names)} other classes, not of {kind!r}; "
            "name another folder"
        )
    return found


def _refuse_more(run: Path, begun: dict, epochs: int) -> None:
    had = begun["train_args"]["epochs"]
    if epochs > had:
        raise TrainingError(
            f"run: {run} is finished after its {had} epochs; for more, name another folder and "
            f"let it start from {run / 'weights' / 'last.pt'}"
        )
