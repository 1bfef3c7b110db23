"""A contact sheet: pictures of a data set side by side, each with its boxes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.inspection import (
    PICTURES,
    DatasetError,
    read_names,
    read_picture,
    read_rows,
)
from robocon_course.vision.metrics import xyxy_from_yolo

COLOURS = {"blue": (255, 190, 60), "purple": (255, 90, 255), "red": (80, 80, 255)}
"""Of the balls' boxes and tags on a picture, BGR."""
OTHER = (0, 225, 255)
"""Of any other class: silos are framed in yellow."""
MARGIN = 2
"""White around each picture [pixels]."""


def contact_sheet(
    folder: str | Path,
    count: int = 24,
    *,
    across: int = 6,
    split: str = "train",
    side: int = 240,
) -> NDArray[np.uint8]:
    """The first pictures of a split side by side, with their boxes.

    Balls bear the first letter of their colour, silos their filling. Lines of a label that are no
    box are left out, and a picture that cannot be read is a grey tile: `check_dataset` names both.

    Parameters
    ----------
    folder : path
    count, across : int
        How many pictures, and how many in a row.
    split : {"train", "val", "test"}
    side : int  [pixels]
        Width of a tile.

    Returns
    -------
    ndarray of uint8, shape (h, w, 3), BGR

    Raises
    ------
    DatasetError
        No data set, or no pictures in the split.
    ValueError
        No picture asked for, none in a row, or tiles of less than 32 pixels.
    """
    for name, value, least in (("count", count, 1), ("across", across, 1), ("side", side, 32)):
        if value < least:
            raise ValueError(f"{name}: expected at least {least}, got {value!r}")
    folder = Path(folder)
    names = read_names(folder)
    place = folder / "images" / split
    listed = sorted(place.iterdir()) if place.is_dir() else []
    paths = [path for path in listed if path.suffix.lower() in PICTURES][:count]
    if not paths:
        raise DatasetError(f"{folder}: no pictures in images/{split}")
    tiles = [_tile(folder / "labels" / split, path, names, side) for path in paths]
    height = max(tile.shape[0] for tile in tiles) + 2 * MARGIN
    tiles = [_padded(tile, side, height) for tile in tiles]
    across = min(across, len(tiles))
    tiles += [np.full((height, side, 3), 255, np.uint8)] * (-len(tiles) % across)
    rows = [np.hstack(tiles[k : k + across]) for k in range(0, len(tiles), across)]
    return np.vstack(rows)


def _tile(labels: Path, path: Path, names: tuple[str, ...], side: int) -> NDArray[np.uint8]:
    """A picture scaled into a square of `side`, margin included, and its boxes drawn on it."""
    import cv2

    inside = side - 2 * MARGIN
    image = read_picture(path)
    if image is None:
        return np.full((inside * 3 // 4, inside, 3), 128, np.uint8)
    scale = inside / max(image.shape[:2])
    size = [max(1, round(scale * length)) for length in image.shape[1::-1]]
    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    label = labels / f"{path.stem}.txt"
    text = label.read_text(encoding="utf-8", errors="replace") if label.is_file() else ""
    rows, _ = read_rows(text, len(names))
    # After scaling: lines stay one pixel thin and letters sharp.
    for box, k in zip(xyxy_from_yolo(rows, *size), rows[:, 0].astype(int), strict=True):
        draw_box(small, box, names[k])
    return small


def draw_box(image_bgr: NDArray[np.uint8], box: FloatArray, name: str) -> None:
    """A thin box in the class's colour, drawn into the picture, with its name where there is room.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
        Drawn on.
    box : ndarray, shape (4,)  [pixels]
        Left, top, right, bottom.
    name : str
        Of the class; of a ball's colour only the first letter is written.
    """
    import cv2

    left, top, right, bottom = (round(float(edge)) for edge in box)
    colour = COLOURS.get(name, OTHER)
    cv2.rectangle(image_bgr, (left, top), (right - 1, bottom - 1), colour, 1)
    ball = name in COLOURS
    tag, font, size = name[:1] if ball else name, cv2.FONT_HERSHEY_SIMPLEX, 0.32
    (width, height), _ = cv2.getTextSize(tag, font, size, 1)
    if ball and right - left < 2 * width:
        return
    if ball:  # inside: in a pile, a letter above would hide the ball that lies behind
        left, foot = left + 2, top + height + 2
    else:
        left = min(max(left, 1), max(1, image_bgr.shape[1] - width - 2))
        foot = top - 2 if top > height + 3 else min(bottom + height + 2, image_bgr.shape[0] - 2)
        corner = (left + width, foot + 1)
        cv2.rectangle(image_bgr, (left - 1, foot - height - 1), corner, (30, 30, 30), cv2.FILLED)
    for ink, thick in (((0, 0, 0), 2), ((255, 255, 255) if ball else colour, 1)):
        cv2.putText(image_bgr, tag, (left, foot), font, size, ink, thick, cv2.LINE_AA)


def _padded(tile: NDArray[np.uint8], width: int, height: int) -> NDArray[np.uint8]:
    """A tile in the middle of a white one of the given size."""
    top, left = (height - tile.shape[0]) // 2, (width - tile.shape[1]) // 2
    white = np.full((height, width, 3), 255, np.uint8)
    white[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return white
