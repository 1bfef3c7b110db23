"""Make the maps of this folder again, the same to the pixel: python data/field/make.py"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

from robocon_course import field
from robocon_course.gridmap import save_map

FOLDER = Path(__file__).resolve().parent
RESOLUTIONS = {"obstacles_1cm": 0.01, "obstacles_5cm": 0.05}  # m


def main(folder: Path = FOLDER) -> None:
    """Write all files into a folder."""
    for name, resolution in RESOLUTIONS.items():
        save_map(field.obstacle_map(resolution), folder / f"{name}.yaml")
    # An image's first row is its top, the field's first row lies at the smallest y.
    Image.fromarray(field.picture()[::-1]).save(folder / "picture.png", optimize=True)


if __name__ == "__main__":
    main()
