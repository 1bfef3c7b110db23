"""Data sets as YOLO networks are trained on: thousands of pictures and their boxes, and a check.

::

    data.yaml              where the splits lie, and the names of the classes
    background.txt         pictures that hold nothing on purpose
    images/train/ball_000000.jpg      labels/train/ball_000000.txt
    images/val/…                      labels/val/…
    images/test/…                     labels/test/…

A label file has a line a box: class number, middle x and y, width and height, each a share of the
picture's width or height. Of ten pictures in a row seven train, two validate and one tests.

Source: shares and augmentation as published for the swerve robot of Yogyakarta State University,
2024: brightness ±15 %, exposure ±10 %, saturation ±15 %, blur up to 1 pixel, noise on up to 0.1 %
of the pixels.
"""

from __future__ import annotations

import multiprocessing
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import yaml
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.classes import CLASSES, classes_of
from robocon_course.vision.inspection import (
    SPLITS,
    DatasetError,
    Problem,
    check_dataset,
    read_names,
)
from robocon_course.vision.reading import as_picture
from robocon_course.vision.sheet import contact_sheet

if TYPE_CHECKING:
    from robocon_course.vision.pictures import Picture

__all__ = [
    "SPLITS", "DatasetError", "Problem", "augment", "augmented", "check_dataset", "contact_sheet",
    "describe", "read_names", "split_of", "write_dataset", "write_labelled", "yolo_lines",
]  # fmt: skip

QUALITY = 92
"""Of the stored JPEG; the camera's own compression is part of the picture."""
CHUNK = 20
"""Pictures a worker draws at a time."""
FEWEST = 10
MOST_WORKERS = 2
"""That start by themselves: each needs 160 MB, and all together shall stay below 500 MB."""
FORSAKEN = 600.0
"""A half-drawn folder untouched for so long belongs to a run that was killed [s]."""


def split_of(index: int) -> str:
    """To which split picture number `index` belongs: 70 % train, 20 % val, 10 % test."""
    return "train" if index % 10 < 7 else "val" if index % 10 < 9 else "test"


def write_dataset(
    kind: str,
    folder: str | Path,
    images: int,
    seed: int = 0,
    *,
    size: tuple[int, int] | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Draw a data set. The same arguments give the same bytes, however many workers draw.

    Parameters
    ----------
    kind : {"ball", "silo"}
    folder : path
        Must not exist yet. It appears when it is whole; a run that is cut off leaves nothing there.
    images : int
        How many pictures, at least 10.
    seed : int
    size : (int, int), optional  [pixels]
        Width and height; left out, shapes are mixed (4:3, 16:9, square).
    workers : int, optional
        Processes, 160 MB each; left out, one a core, but two at most.
    progress : callable, optional
        Called with the pictures drawn so far and all.

    Returns
    -------
    Path
        `folder`.

    Raises
    ------
    DatasetError
        The folder exists or cannot be made, or a process was killed.
    ValueError
        Another kind, fewer than 10 pictures, a number that is none, or pictures below 32 pixels.

    Notes
    -----
    The processes start afresh. So in a script of its own the call has to stand below
    ``if __name__ == "__main__":``; a notebook needs nothing of the kind.
    """
    folder = Path(folder)
    _check_order(kind, images, seed, size, workers)
    part = _room(folder)
    try:
        empty, done = [], 0
        for names, count in _drawn(kind, part, images, seed, size, workers):
            empty, done = empty + names, done + count
            if progress is not None:
                progress(done, images)
        describe(kind, part)
        (part / "background.txt").write_text("".join(f"{n}\n" for n in empty), encoding="utf-8")
        folder.parent.mkdir(parents=True, exist_ok=True)
        part.rename(folder)
    except BrokenProcessPool:
        raise DatasetError(
            "a drawing process ended by itself: short of memory, give workers=1; in a script, "
            'call write_dataset below if __name__ == "__main__":'
        ) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder


def describe(kind: str, folder: Path, splits: Sequence[str] = SPLITS) -> None:
    """Write the data.yaml of a folder that has these splits."""
    about = {s: f"images/{s}" for s in splits} | {"names": dict(enumerate(CLASSES[kind]))}
    (folder / "data.yaml").write_text(yaml.safe_dump(about, sort_keys=False), encoding="utf-8")


def _check_order(
    kind: str, images: int, seed: int, size: tuple[int, int] | None, workers: int | None
) -> None:
    """Refuse what cannot be drawn, before any process starts."""
    classes_of(kind)
    asked = 1 if workers is None else workers
    numbers = (("images", images, FEWEST), ("seed", seed, 0), ("workers", asked, 1))
    for name, value, least in numbers:
        if not isinstance(value, int | np.integer) or value < least:
            raise ValueError(f"{name}: expected a whole number, at least {least}, got {value!r}")
    if size is not None and not (
        np.shape(size) == (2,) and all(isinstance(s, int | np.integer) and s >= 32 for s in size)
    ):
        raise ValueError(
            f"size: expected width and height, at least 32 whole pixels each, got {size!r}"
        )


def _room(folder: Path) -> Path:
    """A folder to draw in, beside the one to come; what killed runs left there is cleared away."""
    if folder.exists():
        raise DatasetError(f"{folder} exists; take another name, or delete it first")
    ground = folder.absolute().parent
    while not ground.exists():
        ground = ground.parent
    if not ground.is_dir() or not os.access(ground, os.W_OK):
        raise DatasetError(f"{folder} cannot be made: {ground} is no folder one can write to")
    for old in ground.iterdir():
        if old.name.startswith(f".{folder.name}.") and old.name.endswith(".part"):
            touched = max((p.stat().st_mtime for p in (old, *old.glob("*/*"))), default=0.0)
            if time.time() - touched > FORSAKEN:
                shutil.rmtree(old, ignore_errors=True)
    return ground / f".{folder.name}.{os.getpid()}.part"


def _drawn(
    kind: str, part: Path, images: int, seed: int, size: tuple[int, int] | None, workers: int | None
) -> Iterator[tuple[list[str], int]]:
    """Draw all pictures, chunk by chunk: names of those without boxes, and how many were drawn."""
    chunks = [range(k, min(k + CHUNK, images)) for k in range(0, images, CHUNK)]
    workers = min(workers or min(os.cpu_count() or 1, MOST_WORKERS), len(chunks))
    if workers <= 1:
        for chunk in chunks:
            yield _draw(kind, part, seed, size, chunk)
        return
    # Fresh processes: a fork of a notebook's kernel would inherit its threads' locks.
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=fresh, initializer=_end_with_parent) as pool:
        tasks = [pool.submit(_draw, kind, part, seed, size, chunk) for chunk in chunks]
        try:
            for task in tasks:
                yield task.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _end_with_parent() -> None:
    """In a worker: end when the process that started it is gone, killed for instance."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        parent.join()
        os._exit(1)

    if parent is not None:
        threading.Thread(target=watch, daemon=True).start()


def _draw(
    kind: str, part: Path, seed: int, size: tuple[int, int] | None, indices: range
) -> tuple[list[str], int]:
    """Some pictures and their labels, into their files: those without boxes, and a count."""
    import cv2

    # Not before the workers run: a script without its main guard calls again in each of them,
    # ends there when it starts workers of its own, and shall not have left a folder by then.
    for place in ("images", "labels"):
        for split in SPLITS:
            (part / place / split).mkdir(parents=True, exist_ok=True)
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # every core has its process; several threads each would only wait
    try:
        names = [_draw_one(kind, part, seed, size, index) for index in indices]
    finally:
        cv2.setNumThreads(threads)
    return [name for name in names if name], len(indices)


def _draw_one(kind: str, part: Path, seed: int, size: tuple[int, int] | None, index: int) -> str:
    """One picture and its label, into their files: its name if it has no boxes."""
    from robocon_course.vision import pictures

    taken = pictures.picture(kind, seed, index, size)
    split = split_of(index)
    if split == "train":
        taken = taken._replace(image_bgr=augmented(taken.image_bgr, seed, index))
    name = f"{split}/{kind}_{index:06d}"
    write_labelled(part, name, taken)
    return "" if len(taken.boxes) else name


def augmented(image_bgr: NDArray[np.uint8], seed: int, index: int) -> NDArray[np.uint8]:
    """Picture number `index` of the series `seed`, changed by chances of its own."""
    return augment(image_bgr, np.random.default_rng([seed, index, 15]))


def write_labelled(folder: Path, name: str, taken: Picture) -> None:
    """A picture and its label, into their files of a data set; `name` begins with the split."""
    import cv2

    height, width = taken.image_bgr.shape[:2]
    quality = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
    if not cv2.imwrite(str(folder / "images" / f"{name}.jpg"), taken.image_bgr, quality):
        raise OSError(f"{folder}: a picture could not be written; is the disk full?")
    lines = yolo_lines(taken.boxes, taken.class_ids, width, height)
    (folder / "labels" / f"{name}.txt").write_text(lines, encoding="ascii")


def yolo_lines(boxes: FloatArray, class_ids: NDArray[np.int64], width: int, height: int) -> str:
    """Boxes as a label file holds them: the inverse of `metrics.xyxy_from_yolo`.

    Parameters
    ----------
    boxes : ndarray, shape (n, 4)  [pixels]
    class_ids : ndarray, shape (n,)
    width, height : int  [pixels]
        Of the picture.

    Returns
    -------
    str
        A line a box; empty without boxes.
    """
    shares = np.asarray(boxes, float) / (width, height, width, height)
    middles, sides = (shares[:, :2] + shares[:, 2:]) / 2, shares[:, 2:] - shares[:, :2]
    rows = zip(class_ids, np.hstack([middles, sides]), strict=True)
    return "".join(f"{k} {x:.6f} {y:.6f} {w:.6f} {h:.6f}\n" for k, (x, y, w, h) in rows)


def augment(image_bgr: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """A picture changed as published: a little brighter or darker, paler, blurred, noisy.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of uint8, shape (h, w, 3)
        Boxes stay where they are.

    Raises
    ------
    ValueError
        Not a picture.
    """
    import cv2

    image_bgr = as_picture(image_bgr)
    light = image_bgr.astype(np.float32) / 255.0
    light = light + np.float32(rng.uniform(-0.15, 0.15) * light.mean())  # brightness: a shift
    light = light * np.float32(1.0 + rng.uniform(-0.10, 0.10))  # exposure: a gain
    grey = light @ np.array([0.114, 0.587, 0.299], np.float32)
    light = grey[..., None] + np.float32(1.0 + rng.uniform(-0.15, 0.15)) * (light - grey[..., None])
    blur = rng.uniform(0.0, 1.0)
    if blur > 0.2:
        light = cv2.GaussianBlur(light, (0, 0), blur)
    image = np.clip(light * 255.0 + 0.5, 0, 255).astype(np.uint8)
    spots = rng.integers(0, int(0.001 * grey.size) + 1)
    rows, cols = rng.integers(0, image.shape[0], spots), rng.integers(0, image.shape[1], spots)
    image[rows, cols] = rng.integers(0, 256, (spots, 3))
    return image
