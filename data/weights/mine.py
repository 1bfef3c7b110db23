"""A data set of what a network finds hard: python data/weights/mine.py silo hard-silos

Draws pictures and keeps those on which the network of this folder is unsure or wrong, three times
each; of the others it keeps a third, so that what is known is not forgotten. Validation pictures
are of the easy ones: they tell that a training goes on, not how good it is.

Source: Shrivastava, Gupta, Girshick: Training Region-based Object Detectors with Online Hard
Example Mining (2016), section 4; here once, before a training, and by whole pictures.
"""

from __future__ import annotations

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import cache, partial
from pathlib import Path

import cv2
import numpy as np
from errors import kinds_of, surest
from rich.progress import track

from robocon_course.vision import CLASSES, Detections, Detector, load_detector
from robocon_course.vision.dataset import augmented, describe, write_labelled
from robocon_course.vision.pictures import Picture, picture

SURE, WRONG = 0.6, 0.3
"""A picture is hard if something is rightly reported with less, or a wrong report has more."""
TIMES, EVERY = 3, 3
"""How often a hard picture is kept, and each how manieth of the others."""
VALIDATION = 300
"""Each how manieth picture, if it is easy, validates."""


def is_hard(found: Detections, taken: Picture) -> bool:
    """Whether a network that reports `found` has something to learn from a picture."""
    wrong = np.array(kinds_of(found, taken), object) != "hit"
    return bool((surest(found, taken) < SURE).any() or (found.scores[wrong] > WRONG).any())


def keep(kind: str, seed: int, folder: Path, index: int) -> bool:
    """Draw a picture and write it as often as it is kept: whether it is hard."""
    taken = picture(kind, seed, index, None)
    hard = is_hard(detector(kind).detect(taken.image_bgr, min_score=WRONG / 2), taken)
    times = TIMES if hard else int(index % EVERY == 0)
    split = "val" if not hard and index % VALIDATION == 0 else "train"
    if index % 2:  # the others stay as the camera gave them
        taken = taken._replace(image_bgr=augmented(taken.image_bgr, seed, index))
    for time in range(times):
        write_labelled(folder, f"{split}/{kind}_{index:06d}_{time}", taken)
    return hard


@cache
def detector(kind: str) -> Detector:
    """Once in a process."""
    cv2.setNumThreads(1)
    return load_detector(Path(__file__).with_name(f"{kind}.onnx"))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=CLASSES)
    parser.add_argument("folder", type=Path, help="must not exist yet")
    parser.add_argument("--seed", type=int, default=14)
    parser.add_argument("--pictures", type=int, default=26_000)
    asked = parser.parse_args()
    splits = ("train", "val")
    for part in ("images", "labels"):
        for split in splits:
            (asked.folder / part / split).mkdir(parents=True)
    order = partial(keep, asked.kind, asked.seed, asked.folder)
    with ProcessPoolExecutor() as processes:
        drawn = processes.map(order, range(asked.pictures), chunksize=50)
        hard = sum(track(drawn, "drawing", asked.pictures))
    describe(asked.kind, asked.folder, splits)
    print(f"{hard} of {asked.pictures} pictures are hard")


if __name__ == "__main__":
    main()
