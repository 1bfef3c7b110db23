"""A trained network as an .onnx file. Importing this loads torch; opening the file does not."""

from __future__ import annotations

import ast
import os
import shutil
import tempfile
from pathlib import Path

import numpy as np

from robocon_course.vision.curves import TrainingError
from robocon_course.vision.trainer import YOLO, ensure_torchvision, read_checkpoint, torch


def export(checkpoint: str | Path, to: str | Path, image_size: int | None = None) -> Path:
    """A checkpoint as an .onnx file: numbers only, nothing in it is executed when it is loaded.

    Parameters
    ----------
    checkpoint : path
        Of your own training: opening a stranger's checkpoint would run what it says.
    to : path
        The file to write.
    image_size : int, optional  [pixels]
        Longer side of what the file is meant to take; as trained where it is not given.

    Returns
    -------
    Path
        `to`, of which onnxruntime gives what torch gives.

    Raises
    ------
    TrainingError
        The checkpoint cannot be read, or the two do not agree.
    """
    ensure_torchvision()
    to = Path(to)
    found = read_checkpoint(Path(checkpoint), "export needs the last.pt of a training of your own")
    size = image_size or int(found["train_args"]["imgsz"])
    to.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=to.parent) as folder:
        copy = Path(folder) / "weights.pt"
        shutil.copy2(checkpoint, copy)
        made = YOLO(copy).export(
            format="onnx", imgsz=size, simplify=False, opset=17, dynamic=True, verbose=False
        )
        _describe(made)
        _compare(copy, made, size)
        os.replace(made, to)
    return to


def _describe(made: str) -> None:
    """Say what it is; Ultralytics names the folder of the data set instead, and the minute."""
    import onnx

    model = onnx.load(made)
    noted = {entry.key: entry.value for entry in model.metadata_props}
    for entry in list(model.metadata_props):
        if entry.key == "description":
            entry.value = "YOLOv8n trained with robocon-course"
        elif entry.key == "date":
            model.metadata_props.remove(entry)
    # The number of rows never changes, but with sides left open the exporter no longer says so.
    rows = 4 + len(ast.literal_eval(noted["names"]))
    model.graph.output[0].type.tensor_type.shape.dim[1].dim_value = rows
    onnx.save(model, made)


def _compare(copy: Path, made: str, size: int) -> None:
    """Refuse a file that answers otherwise than the network did."""
    import onnxruntime

    image = np.random.default_rng(0).random((1, 3, size, max(32, size // 64 * 32)), np.float32)
    session = onnxruntime.InferenceSession(made, providers=["CPUExecutionProvider"])
    ours = session.run(None, {session.get_inputs()[0].name: image})[0]
    with torch.no_grad():
        theirs = YOLO(copy).model.float().eval()(torch.from_numpy(image))[0].numpy()
    worst = float(np.abs(ours - theirs).max())
    if not worst < 0.1:  # pixels; scores are far closer
        raise TrainingError(f"{copy.name}: exported, it answers otherwise by {worst:.3g} pixels")
