"""Train the small networks whose curves lesson 06 shows: python data/training/make.py

About ten minutes on two cores. Writes curves.npz: one array a run and column, "160/map50".
Needs the extra "vision". Another processor gives curves of the same shape, not the same numbers.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from robocon_course.vision import training
from robocon_course.vision.dataset import write_dataset

FOLDER = Path(__file__).resolve().parent
KEPT = ("epoch", "box", "class", "dfl", "val_box", "val_class", "val_dfl", "map50")
PICTURES, SEED = 400, 160
RUNS = {"96": (96, 12, 280), "160": (160, 12, 280), "224": (224, 12, 280), "few": (160, 120, 20)}
"""Image size, epochs, and how many of the training pictures are used."""


def main() -> None:
    curves = {}
    with tempfile.TemporaryDirectory() as place:
        folder = write_dataset("ball", Path(place) / "data", PICTURES, SEED, size=(160, 120))
        paths = sorted((folder / "images" / "train").iterdir())
        for name, (size, epochs, count) in RUNS.items():
            for path in paths[count:]:
                path.unlink(missing_ok=True)
            run = Path(place) / name
            training.train("ball", folder, run, epochs=epochs, image_size=size, progress=print)
            found = training.history(run)
            curves |= {f"{name}/{column}": found[column].astype(np.float32) for column in KEPT}
    np.savez_compressed(FOLDER / "curves.npz", **curves)


if __name__ == "__main__":
    main()
