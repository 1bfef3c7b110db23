"""Train YOLOv8n on a data set of the course, from its recipe: no weights are downloaded.

``train`` can be killed at any time: called again with the same folder it goes on after the last
whole epoch. ``export`` turns the result into an .onnx file that `detection.load_detector` opens.

Needs the extra: ``pip install -e ".[vision]"``. Nothing else of the course imports torch.
"""

from __future__ import annotations

import csv
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import yaml

from robocon_course._arrays import CourseError, FloatArray
from robocon_course.vision.classes import CLASSES

# Ultralytics reads these when it is imported: install nothing, send nothing, say nothing.
os.environ["YOLO_AUTOINSTALL"] = "false"
os.environ["YOLO_VERBOSE"] = "false"
os.environ.setdefault(
    "YOLO_CONFIG_DIR", str(Path(tempfile.gettempdir()) / "robocon-course-ultralytics")
)
Path(os.environ["YOLO_CONFIG_DIR"]).mkdir(parents=True, exist_ok=True)

# And it leaves other people's settings as it likes them: they are put back below.
_printing, _threads = np.get_printoptions(), cv2.getNumThreads()

import torch  # noqa: E402
from ultralytics import YOLO  # noqa: E402
from ultralytics.models.yolo.detect import DetectionTrainer  # noqa: E402
from ultralytics.nn.tasks import DetectionModel  # noqa: E402
from ultralytics.utils import SETTINGS  # noqa: E402

np.set_printoptions(**_printing)
cv2.setNumThreads(_threads)

RECIPE = "yolov8n.yaml"
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
}
"""What Ultralytics changes in a picture each time it is shown; shares and probabilities."""
FINISHED = "finished.txt"


class TrainingError(CourseError):
    """A training that cannot start or go on."""


class Epoch(NamedTuple):
    """Where a training is, for whoever shows its progress.

    Attributes
    ----------
    number, of : int
        The epoch that has just ended, and how many there will be.
    loss : float
        Sum of the three losses on the training pictures.
    map50 : float
        mAP at an overlap of 0.5 on the validation pictures; NaN where it was not measured.
    seconds : float
        Since the training was started or continued.
    """

    number: int
    of: int
    loss: float
    map50: float
    seconds: float


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
        ``"cpu"``, ``"0"`` for a first GPU, ``"0,1"`` for two of them.
    start_from : path, optional
        A checkpoint whose layers serve as the start, as far as they fit.
    validate_every : int  [epochs]
    progress : callable, optional
        Called with an `Epoch` after each.

    Returns
    -------
    Path
        The checkpoint of the last epoch.

    Raises
    ------
    TrainingError
        No data set, another kind's data set, a device that is not there, a broken checkpoint.
    ValueError
        Settings that make no sense.
    """
    data, run = Path(data).resolve(), Path(run).resolve()
    _refuse_settings(kind, epochs, image_size, batch)
    _refuse_device(device)
    last = run / "weights" / "last.pt"
    if (run / FINISHED).is_file():
        return last
    ensure_torchvision()
    torch.set_num_threads(os.cpu_count() or 1)
    settings = {
        "model": RECIPE, "data": str(_in_full(_data_file(kind, data), run)), "epochs": epochs,
        "imgsz": image_size, "batch": batch, "nbs": batch, "lr0": rate, "lrf": 0.02,
        "cos_lr": True, "optimizer": "AdamW", "warmup_epochs": min(0.5, epochs / 4),
        "seed": seed, "device": device, "project": str(run.parent), "name": run.name,
        "exist_ok": True, "workers": 0, "plots": False, "amp": _amp(device), "patience": 10**6,
        "close_mosaic": max(1, epochs // 8), "pretrained": str(start_from or False),
        **AUGMENTATION,
    }  # fmt: skip
    if start_from is None:
        settings["pretrained"] = False
    whole = _last_whole(run)
    if whole is not None:
        settings |= {"model": str(whole), "resume": str(whole)}
    trainer = Trainer(overrides=settings)
    trainer.validate_every, trainer.progress = validate_every, progress
    trainer.train()
    last.with_name("previous.pt").unlink(missing_ok=True)
    (run / FINISHED).write_text(f"{epochs} epochs\n", encoding="ascii")
    return last


def _amp(device: str) -> bool | str:
    """Half precision on GPUs; as bfloat16, because for the other kind Ultralytics downloads."""
    return False if device in ("cpu", "mps") else "bf16"


def _refuse_settings(kind: str, epochs: int, image_size: int, batch: int) -> None:
    if kind not in CLASSES:
        raise ValueError(f"kind: expected 'ball' or 'silo', got {kind!r}")
    if epochs < 1:
        raise ValueError(f"epochs: expected at least 1, got {epochs}")
    if image_size < 32 or image_size % 32:
        raise ValueError(f"image_size: expected a multiple of 32, got {image_size}")
    if batch < 1:
        raise ValueError(f"batch: expected at least 1, got {batch}")


def _refuse_device(device: str) -> None:
    """A GPU that is not there is refused here: Ultralytics would print a page."""
    if device in ("cpu", "mps"):
        return
    numbers = str(device).split(",")
    there = torch.cuda.device_count()
    if not all(n.isdigit() and int(n) < there for n in numbers):
        raise TrainingError(
            f"device: asked for {device!r}, but this computer has {there} GPUs that torch can use; "
            "use --device cpu"
        )


def _data_file(kind: str, data: Path) -> Path:
    """The data set's description, compared with the classes of the course."""
    path = data / "data.yaml"
    try:
        names = yaml.safe_load(path.read_text(encoding="utf-8"))["names"]
        names = tuple(names[k] for k in sorted(names)) if isinstance(names, dict) else tuple(names)
    except OSError:
        raise TrainingError(
            f"{data}: no data set (no data.yaml); make one with: robocon dataset {kind}"
        ) from None
    except (yaml.YAMLError, KeyError, TypeError):
        raise TrainingError(f"{path}: no description of a data set; make it again") from None
    if names != CLASSES[kind]:
        raise TrainingError(f"{path}: its classes are {names[:3]}…, not those of {kind!r}")
    return path


def _in_full(description: Path, run: Path) -> Path:
    """A copy that names the data set's folder in full; Ultralytics reads "." from where it runs."""
    about = yaml.safe_load(description.read_text(encoding="utf-8"))
    about["path"] = str(description.parent)
    run.mkdir(parents=True, exist_ok=True)
    copy = run / "data.yaml"
    copy.write_text(yaml.safe_dump(about, sort_keys=False), encoding="utf-8")
    return copy


def _last_whole(run: Path) -> Path | None:
    """The newest checkpoint that can be read; a kill may have cut the last one short."""
    found = [run / "weights" / name for name in ("last.pt", "previous.pt")]
    found = [path for path in found if path.is_file()]
    for path in found:
        try:
            checkpoint = torch.load(path, map_location="cpu", weights_only=False)
            if checkpoint["epoch"] >= 0 and checkpoint["optimizer"] is not None:
                if path.name == "previous.pt":
                    shutil.copy2(path, run / "weights" / "last.pt")
                return run / "weights" / "last.pt"
        except Exception:  # a cut-off file raises whatever its last bytes mean to pickle
            continue
    if found:
        raise TrainingError(
            f"{run}: its checkpoints cannot be read; delete the folder and start again"
        )
    return None


# --- inside Ultralytics ---------------------------------------------------------------------------


class Network(DetectionModel):
    """YOLOv8n; on a CPU that has bfloat16 it is trained in it, which takes half the time."""

    def loss(self, batch: dict, preds: Any = None) -> Any:
        """The losses of a batch, in float32 whatever the network was run in."""
        images = batch["img"]
        if preds is None and images.device.type == "cpu" and _has_bfloat16():
            with torch.autocast("cpu", torch.bfloat16):
                preds = self.forward(images.contiguous(memory_format=torch.channels_last))
            preds = _in_float32(preds)
        return super().loss(batch, preds)


def _has_bfloat16() -> bool:
    """Whether this processor multiplies bfloat16 itself; elsewhere it would be slower."""
    return bool(getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)())


def _in_float32(value: Any) -> Any:
    if torch.is_tensor(value):
        return value.float() if value.is_floating_point() else value
    if isinstance(value, dict):
        return {key: _in_float32(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_in_float32(part) for part in value)
    return value


class Trainer(DetectionTrainer):
    """Ultralytics' trainer with our network, quiet, and with a checkpoint that a kill spares."""

    validate_every, told = 1, 0
    progress: Callable[[Epoch], None] | None = None

    def __init__(self, overrides: dict | None = None, _callbacks: Any = None, **kwargs: Any):
        ensure_torchvision()
        SETTINGS.update({"sync": False})
        super().__init__(overrides=overrides, _callbacks=_callbacks, **kwargs)
        self.add_callback("on_train_epoch_start", Trainer._choose_validation)
        self.add_callback("on_fit_epoch_end", Trainer._report)

    def get_model(self, cfg: Any = None, weights: Any = None, verbose: bool = True) -> Network:
        """A new network, with the layers of `weights` where they fit."""
        model = Network(RECIPE, nc=self.data["nc"], ch=self.data["channels"], verbose=False)
        if weights:
            model.load(weights, verbose=False)
        return model.to(memory_format=torch.channels_last)

    def save_model(self) -> bool:
        """Write the checkpoint, keeping the one before until the new one is whole."""
        if self.last.is_file():
            shutil.copy2(self.last, self.last.with_name("previous.pt"))
        return super().save_model()

    def _choose_validation(self) -> None:
        self.args.val = (self.epoch + 1) % self.validate_every == 0

    def _report(self) -> None:
        # The check of the finished network, after the last epoch, calls once more.
        if self.progress is not None and self.told <= self.epoch < self.epochs:
            self.told = self.epoch + 1
            loss = float(sum(self.tloss.values()))
            measured = self.args.val or self.epoch + 1 == self.epochs
            map50 = float(self.metrics.get("metrics/mAP50(B)", np.nan)) if measured else np.nan
            passed = time.time() - self.train_time_start
            self.progress(Epoch(self.epoch + 1, self.epochs, loss, map50, passed))


_kept: list[Any] = []


def ensure_torchvision() -> str:
    """Make `torchvision.ops.nms` work where torchvision came without its compiled part.

    Returns
    -------
    {"native", "shim"}
        Whose NMS it is.
    """
    try:
        import torchvision.ops as ops

        ops.nms(torch.tensor([[0.0, 0.0, 1.0, 1.0]]), torch.tensor([1.0]), 0.5)
        return "shim" if _kept else "native"
    except (ImportError, RuntimeError, NotImplementedError):
        pass
    for name in [m for m in sys.modules if m.split(".")[0] == "torchvision"]:
        del sys.modules[name]
    library = torch.library.Library("torchvision", "DEF")
    _kept.append(library)  # a library that is collected takes its operators with it
    for name in ("nms", "qnms"):
        library.define(f"{name}(Tensor dets, Tensor scores, float iou_threshold) -> Tensor")
    import torchvision.ops as ops
    from ultralytics.utils.nms import TorchNMS

    def nms(boxes: Any, scores: Any, iou_threshold: float) -> Any:
        return TorchNMS.nms(boxes, scores, iou_threshold)

    ops.nms = ops.boxes.nms = nms
    return "shim"


# --- results --------------------------------------------------------------------------------------


def history(run: str | Path) -> dict[str, FloatArray]:
    """The learning curves of a training.

    Parameters
    ----------
    run : path

    Returns
    -------
    dict of str to ndarray
        ``epoch``, ``box``, ``class``, ``dfl`` (losses on the training pictures), ``val_box``,
        ``val_class``, ``val_dfl``, ``precision``, ``recall``, ``map50``, ``map50_95``, ``seconds``;
        one value an epoch, NaN where it was not measured.
    """
    path = Path(run) / "results.csv"
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [{k.strip(): v for k, v in row.items()} for row in csv.DictReader(file)]
    except OSError:
        raise TrainingError(f"{run}: no training has ended an epoch there") from None
    found = {
        ours: np.array([float(row.get(theirs) or "nan") for row in rows])
        for ours, theirs in _COLUMNS.items()
    }
    # An epoch without validation repeats what was measured last, or 0.
    fresh = np.diff(found["val_box"], prepend=0.0) != 0.0
    for name in ("val_box", "val_class", "val_dfl", "precision", "recall", "map50", "map50_95"):
        found[name][~fresh] = np.nan
    return found


_COLUMNS = {
    "epoch": "epoch",
    "seconds": "time",
    "box": "train/box_loss",
    "class": "train/cls_loss",
    "dfl": "train/dfl_loss",
    "precision": "metrics/precision(B)",
    "recall": "metrics/recall(B)",
    "map50": "metrics/mAP50(B)",
    "map50_95": "metrics/mAP50-95(B)",
    "val_box": "val/box_loss",
    "val_class": "val/cls_loss",
    "val_dfl": "val/dfl_loss",
}


def export(checkpoint: str | Path, to: str | Path, image_size: int = 320) -> Path:
    """A checkpoint as an .onnx file: numbers only, nothing in it is executed when it is loaded.

    Parameters
    ----------
    checkpoint : path
        Of your own training: opening a stranger's checkpoint would run what it says.
    to : path
        The file to write.
    image_size : int  [pixels]

    Returns
    -------
    Path
        `to`.
    """
    ensure_torchvision()
    to = Path(to)
    to.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "weights.pt"
        shutil.copy2(checkpoint, copy)
        made = YOLO(copy).export(
            format="onnx", imgsz=image_size, simplify=False, opset=17, dynamic=False, verbose=False
        )
        shutil.move(made, to)
    return to
