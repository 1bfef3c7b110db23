"""Make the pictures of this folder again: python data/pictures/make.py

The same to the byte on one machine and library version; elsewhere single pixels may differ by one.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from robocon_course.vision.dataset import write_dataset

FOLDER = Path(__file__).resolve().parent
SETS = {"ball": (90, 2024), "silo": (90, 2025)}
"""How many pictures, and their seed."""


def main() -> None:
    for kind, (images, seed) in SETS.items():
        shutil.rmtree(FOLDER / kind, ignore_errors=True)
        write_dataset(kind, FOLDER / kind, images, seed, size=(320, 240))
        print(FOLDER / kind)


if __name__ == "__main__":
    main()
