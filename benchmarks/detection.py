"""How fast is a picture turned into boxes, beside Ultralytics?

    python benchmarks/detection.py

The same pictures in one process, in turns of random order with a pause before each, as between
two pictures of a camera: without it the threads of one contender, which wait a while for more work,
take the cores from the next. The median counts. First the boxes are compared.

There are two readings of `YOLO.predict`. On the same .onnx file both run the same network in the
same onnxruntime; only what is around it can differ. On a network of torch, which is what training
leaves and `YOLO("best.pt")` opens, the network itself is slower. Its layers are those of the ball
network, its weights are not trained: that does not change the time.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter, sleep

import numpy as np

from robocon_course import files
from robocon_course.vision import load_detector
from robocon_course.vision.pictures import picture
from robocon_course.vision.trainer import YOLO, DetectionModel, ensure_torchvision

SIZES = (320, 480)
"""Longer side of what the networks look at [pixels]: that of the published robot, and our own."""
COUNT, REPEATS, PAUSE = 20, 60, 0.05


def main() -> None:
    ensure_torchvision()
    images = [picture("ball", 11, k).image_bgr for k in range(COUNT)]
    ours = load_detector("ball")
    same_file = YOLO(str(files.data_file("weights/ball.onnx")), task="detect")
    torch = YOLO("yolov8n.yaml", task="detect")
    torch.model = DetectionModel("yolov8n.yaml", nc=len(ours.names), verbose=False)
    large = np.resize(images[1], (1080, 1920, 3))
    for size in SIZES:
        detect = ours.with_size(size).detect
        theirs = predict(same_file, size), predict(torch, size)
        for image in images:
            np.testing.assert_allclose(detect(image).boxes, theirs[0](image).xyxy, atol=0.5)
        for name, image in (("320 x 240", images[0]), ("1920 x 1080", large)):
            mine, same, slow = taking_turns((detect, *theirs), image)
            print(
                f"a picture of {name} at {size} pixels: detect {1e3 * mine:.1f} ms; YOLO.predict "
                f"on the same .onnx {1e3 * same:.1f} ms, ratio {mine / same:.2f}; on a network "
                f"of torch {1e3 * slow:.1f} ms, ratio {mine / slow:.2f} (at most 0.6 wanted)",
                flush=True,
            )


def predict(network: YOLO, size: int) -> Callable:
    """Ultralytics' own way from a picture to boxes."""
    return lambda image: (
        network.predict(image, imgsz=size, conf=0.4, iou=0.7, verbose=False)[0].boxes
    )


def taking_turns(contenders: tuple[Callable, ...], image: np.ndarray) -> list[float]:
    """Median time of each [s]. By the clock, not by CPU time: both use several threads."""
    times: list[list[float]] = [[] for _ in contenders]
    rng = np.random.default_rng(0)
    for contender in contenders:
        contender(image)
    for _ in range(REPEATS):
        for k in rng.permutation(len(contenders)):
            sleep(PAUSE)
            started = perf_counter()
            contenders[k](image)
            times[k].append(perf_counter() - started)
    return [median(taken) for taken in times]


if __name__ == "__main__":
    main()
