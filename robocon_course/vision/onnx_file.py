"""A trained network as an .onnx file, and back. Importing this loads torch; opening it does not."""

from __future__ import annotations

import ast
import os
import shutil
import tempfile
from pathlib import Path

import cv2
import numpy as np

from robocon_course.vision.curves import TrainingError
from robocon_course.vision.inspection import PICTURES
from robocon_course.vision.reading import letterbox
from robocon_course.vision.trainer import (
    RECIPE,
    YOLO,
    Network,
    ensure_torchvision,
    read_checkpoint,
    torch,
)

SAMPLE = 256
"""Pictures over which a reopened network's batch normalization is set."""


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


def reopen(weights: str | Path, data: str | Path, to: str | Path, image_size: int = 320) -> Path:
    """A checkpoint to train on from, of a network of which only the .onnx file is left.

    In the file each convolution has its batch normalization folded into it. Here each gets one
    again that undoes nothing of what it answers: mean and variance of what it sees on pictures of
    the data set, and a scale and shift that give back the mean and the variance.

    Parameters
    ----------
    weights : path
        As `export` wrote it.
    data : path
        Folder of a data set with training pictures like those to be trained on.
    to : path
        The checkpoint to write.
    image_size : int  [pixels]

    Returns
    -------
    Path
        `to`.

    Raises
    ------
    TrainingError
        Not a network that `export` wrote.
    """
    import onnx

    if not Path(weights).is_file():
        raise TrainingError(f"{weights} is not there; give an .onnx file that was exported")
    ensure_torchvision()
    try:
        model = onnx.load(weights)
        noted = {entry.key: entry.value for entry in model.metadata_props}
        names = ast.literal_eval(noted["names"])
        numbers = {one.name: onnx.numpy_helper.to_array(one) for one in model.graph.initializer}
        network = Network(RECIPE, nc=len(names), ch=3, verbose=False)
        biases = _fill(network, numbers)
    except Exception:  # whatever other bytes and other networks raise
        raise TrainingError(f"{weights} is no network that `robocon train` exported") from None
    listed = sorted((Path(data) / "images" / "train").iterdir())
    paths = [path for path in listed if path.suffix.lower() in PICTURES]
    chosen = np.random.default_rng(0).permutation(len(paths))[:SAMPLE]
    some = [letterbox(cv2.imread(str(paths[k])), image_size)[0] for k in chosen]
    _normalize(network, biases, torch.from_numpy(np.concatenate(some)))
    network.names = names
    noted = {"epoch": -1, "model": network, "ema": None, "train_args": {"imgsz": image_size}}
    torch.save(noted, to)
    return Path(to)


def _fill(network: Network, numbers: dict) -> dict:
    """The file's numbers into the convolutions; the biases of those that have none themselves."""
    biases = {}
    for name, layer in network.named_modules():
        if isinstance(layer, torch.nn.Conv2d):
            layer.weight.data.copy_(torch.tensor(numbers[f"{name}.weight"]))
            if f"{name}.bias" in numbers:
                bias = torch.tensor(numbers[f"{name}.bias"])
                if layer.bias is None:
                    biases[name.removesuffix("conv") + "bn"] = bias
                else:
                    layer.bias.data.copy_(bias)
    return biases


def _normalize(network: Network, biases: dict, pictures: torch.Tensor) -> None:
    """Set each batch normalization, in the order in which they are run."""

    def set_by(layer: torch.nn.BatchNorm2d, bias: torch.Tensor, seen: torch.Tensor) -> None:
        layer.running_var, layer.running_mean = torch.var_mean(seen, (0, 2, 3), correction=0)
        layer.weight.data = torch.sqrt(layer.running_var + layer.eps)
        layer.bias.data = layer.running_mean + bias

    layers = dict(network.named_modules())
    hooks = [
        layers[name].register_forward_pre_hook(
            lambda layer, seen, bias=bias: set_by(layer, bias, seen[0])
        )
        for name, bias in biases.items()
    ]
    with torch.no_grad():
        network.eval()(pictures)
    for hook in hooks:
        hook.remove()
