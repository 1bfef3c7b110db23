"""How fast is a picture turned into boxes, beside Ultralytics?

    python benchmarks/detection.py

The same .onnx file and the same pictures, in one process, taking turns; the median counts. First
the boxes are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter

import numpy as np

from robocon_course import files
from robocon_course.vision import load_detector
from robocon_course.vision.pictures import picture
from robocon_course.vision.training import YOLO, ensure_torchvision

COUNT, REPEATS = 20, 60


def main() -> None:
    ensure_torchvision()
    images = [picture("ball", 11, k).image_bgr for k in range(COUNT)]
    ours = load_detector("ball")
    theirs = YOLO(str(files.data_file("weights/ball.onnx")), task="detect")

    def predict(image: np.ndarray) -> np.ndarray:
        return theirs.predict(image, imgsz=320, conf=0.4, iou=0.7, verbose=False)[0].boxes

    for image in images:
        np.testing.assert_allclose(ours.detect(image).boxes, predict(image).xyxy, atol=0.5)
    large = np.resize(images[1], (1080, 1920, 3))
    for name, image in (("320 x 240", images[0]), ("1920 x 1080", large)):
        one, other = taking_turns((ours.detect, predict), image)
        print(
            f"{name}: detect {1e3 * one:.1f} ms, YOLO.predict {1e3 * other:.1f} ms, "
            f"ratio {one / other:.2f} (at most 0.6 wanted)"
        )


def taking_turns(contenders: tuple[Callable, ...], image: np.ndarray) -> list[float]:
    """Median time of each [s]. By the clock, not by CPU time: both use several threads."""
    times: list[list[float]] = [[] for _ in contenders]
    for _ in range(REPEATS):
        for contender, taken in zip(contenders, times, strict=True):
            started = perf_counter()
            contender(image)
            taken.append(perf_counter() - started)
    return [median(taken) for taken in times]


if __name__ == "__main__":
    main()
