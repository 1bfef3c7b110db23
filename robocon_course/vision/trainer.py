"""Ultralytics' trainer as the course uses it: quiet, nothing downloaded, a kill costs one epoch.

Everything that reaches into Ultralytics stands here. Importing this file loads torch.
"""

from __future__ import annotations

import getpass
import os
import random
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import yaml
from PIL import Image

from robocon_course.vision.curves import Epoch, TrainingError, new_epochs


def _own_folder() -> Path:
    """Where Ultralytics may keep its settings: a folder of this user, gone with the next start."""
    try:
        user = getpass.getuser()
    except (OSError, KeyError):  # a container may run under a number without a name
        user = "someone"
    return Path(tempfile.gettempdir()) / f"robocon-course-ultralytics-{user}"


# Ultralytics reads these when it is imported: install nothing, send nothing, say nothing.
os.environ["YOLO_AUTOINSTALL"] = "false"
os.environ["YOLO_VERBOSE"] = "false"
os.environ.setdefault("YOLO_CONFIG_DIR", str(_own_folder()))
Path(os.environ["YOLO_CONFIG_DIR"]).mkdir(parents=True, exist_ok=True)

# And it leaves other people's settings as it likes them: they are put back below.
_printing, _threads, _open = np.get_printoptions(), cv2.getNumThreads(), Image.open

import torch  # noqa: E402
from ultralytics import YOLO  # noqa: E402
from ultralytics.models.yolo.detect import DetectionTrainer  # noqa: E402
from ultralytics.nn.tasks import DetectionModel  # noqa: E402
from ultralytics.utils import RANK, SETTINGS  # noqa: E402
from ultralytics.utils.torch_utils import strip_optimizer  # noqa: E402

np.set_printoptions(**_printing)
cv2.setNumThreads(_threads)
Image.open = _open

__all__ = ["RECIPE", "YOLO", "Network", "Trainer", "ensure_torchvision", "read_checkpoint", "torch"]

RECIPE = "yolov8n.yaml"
DATA_KEYS = ("path", "train", "val", "test", "names")
"""What of a data.yaml is passed on; Ultralytics would run what stands under "download"."""


class Network(DetectionModel):
    """YOLOv8n; on a CPU that has bfloat16 it is trained in it, which takes half the time."""

    def loss(self, batch: dict, preds: Any = None) -> Any:
        """The losses of a batch, in float32 whatever the network was run in."""
        images = batch["img"]
        if preds is None and images.device.type == "cpu" and has_bfloat16():
            with torch.autocast("cpu", torch.bfloat16):
                preds = self.forward(images.contiguous(memory_format=torch.channels_last))
            preds = _in_float32(preds)
        return super().loss(batch, preds)


def has_bfloat16() -> bool:
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
    """Ultralytics' trainer with our network; the processes of several GPUs make one each."""

    def __init__(self, *args: Any, **kwargs: Any):
        ensure_torchvision()
        SETTINGS.update({"sync": False})
        self.told, self.progress = 0, None
        super().__init__(*args, **kwargs)
        # Half precision where the GPU has it: for the other kind Ultralytics downloads a test.
        halves = self.device.type == "cuda" and torch.cuda.is_bf16_supported(False)
        self.args.amp = "bf16" if halves else False

    def report(self, validate_every: int, progress: Callable[[Epoch], None] | None) -> None:
        """Set how often the network is validated, and who is told after each epoch."""
        before = list(new_epochs(self.save_dir, 0, 0)) if self.resume else []
        self.told, self.progress = len(before), progress
        seconds = before[-1].seconds if before else 0.0
        # A callback travels to the processes of several GPUs; an attribute would not.
        self.add_callback("on_train_start", partial(_count_on, seconds=seconds))
        self.add_callback("on_train_epoch_start", partial(_choose_validation, every=validate_every))
        if not self.ddp:
            self.add_callback("on_fit_epoch_end", Trainer._tell)

    def train(self) -> None:
        """Train here, or on several GPUs in a process each, telling of what those write."""
        if not self.ddp:
            super().train()
            return
        done = threading.Event()
        watching = threading.Thread(target=self._watch, args=(done,))
        watching.start()
        try:
            super().train()
        finally:
            done.set()
            watching.join()

    def _watch(self, done: threading.Event) -> None:
        while not done.wait(0.5):
            with suppress(TrainingError):  # the processes begin by emptying the folder
                self._tell()
        self._tell()

    def _tell(self) -> None:
        for one in new_epochs(self.save_dir, self.told, self.epochs):
            self.told += 1
            if self.progress is not None:
                self.progress(one)

    def get_dataset(self) -> dict:
        """The data set, from a description in which nothing but its pictures is named."""
        source = Path(self.args.data)
        about = yaml.safe_load(source.read_text(encoding="utf-8"))
        about = {key: about[key] for key in DATA_KEYS if key in about}
        # Ultralytics reads a relative folder from where it runs.
        about["path"] = str((source.parent / about.get("path", ".")).resolve())
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder) / "data.yaml"
            copy.write_text(yaml.safe_dump(about, sort_keys=False), encoding="utf-8")
            self.args.data = str(copy)
            found = super().get_dataset()
        self.args.data = str(source)
        return found

    def get_model(self, cfg: Any = None, weights: Any = None, verbose: bool = True) -> Network:
        """A new network, with the layers of `weights` where they fit."""
        model = Network(RECIPE, nc=self.data["nc"], ch=self.data["channels"], verbose=False)
        if weights:
            model.load(weights, verbose=False)
        return model.to(memory_format=torch.channels_last)

    def preprocess_batch(self, batch: dict) -> dict:
        """A batch as the network takes it, enlarged at random where that was asked for.

        Ultralytics would make it smaller as often, and lose what is small already.
        """
        reach, self.args.multi_scale = self.args.multi_scale, 0.0
        batch = super().preprocess_batch(batch)
        self.args.multi_scale = reach
        if reach > 0.0:
            size = self.args.imgsz
            side = random.choice(range(size, round(size * (1.0 + reach)) + 1, self.stride))
            batch["img"] = torch.nn.functional.interpolate(
                batch["img"], size=(side, side), mode="bilinear", align_corners=False
            )
        return batch

    def save_model(self) -> bool:
        """Write the checkpoints beside the old ones, and let them take their place when whole."""
        last, best = self.last, self.best
        self.last, self.best = _beside(last), _beside(best)
        try:
            written = super().save_model()
        finally:
            self.last, self.best = last, best
        for path in (last, best):
            if _beside(path).is_file():
                os.replace(_beside(path), path)
        return written

    def final_eval(self) -> None:
        """Keep of the checkpoints what is used later; the last epoch has been validated."""
        if RANK in (-1, 0):
            for path in (self.last, self.best):
                if path.is_file():
                    strip_optimizer(path, str(_beside(path)))
                    os.replace(_beside(path), path)


def _beside(path: Path) -> Path:
    return path.with_name(path.name + ".new")


def _count_on(trainer: Trainer, seconds: float) -> None:
    """A training that goes on has taken `seconds` already."""
    trainer.train_time_start -= seconds


def _choose_validation(trainer: Trainer, every: int) -> None:
    trainer.args.val = (trainer.epoch + 1) % every == 0


def read_checkpoint(path: Path, advice: str) -> dict:
    """What a checkpoint holds. Loading executes what it says, so only ever one's own.

    Parameters
    ----------
    path : Path
    advice : str
        What to do if it cannot be read; ends the sentence of the refusal.

    Returns
    -------
    dict
        ``epoch`` (from 0; -1 of a finished training), ``ema`` or ``model``, ``train_args``, …

    Raises
    ------
    TrainingError
        There is no such file, or it is no checkpoint.
    """
    if not path.is_file():
        raise TrainingError(f"{path} is not there; {advice}")
    try:
        found = torch.load(path, map_location="cpu", weights_only=False)
        _ = found["epoch"], (found["ema"] or found["model"]).names, found["train_args"]["imgsz"]
    except Exception:  # a cut-off file raises whatever its last bytes mean to pickle
        raise TrainingError(f"{path} cannot be read as a checkpoint; {advice}") from None
    return found


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
