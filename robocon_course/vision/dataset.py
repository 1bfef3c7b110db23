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

import hashlib
import multiprocessing
import os
import shutil
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from robocon_course._arrays import CourseError, FloatArray
from robocon_course.vision.classes import CLASSES
from robocon_course.vision.metrics import xyxy_from_yolo

SPLITS = ("train", "val", "test")
QUALITY = 92
"""Of the stored JPEG; the camera's own compression is part of the picture."""
CHUNK = 20
"""Pictures a worker draws at a time."""
FEWEST = 10
RAREST = 0.2
"""A class with fewer boxes than this share of the mean is reported."""


class DatasetError(CourseError):
    """A data set that cannot be written or read."""


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
        Processes; left out, one a core.
    progress : callable, optional
        Called with the pictures drawn so far and all.

    Returns
    -------
    Path
        `folder`.

    Raises
    ------
    DatasetError
        The folder exists.
    ValueError
        Another kind, or fewer than 10 pictures.
    """
    folder = Path(folder)
    if kind not in CLASSES:
        raise ValueError(f"kind: expected 'ball' or 'silo', got {kind!r}")
    if images < FEWEST:
        raise ValueError(f"images: expected at least {FEWEST}, one for each tenth, got {images}")
    if folder.exists():
        raise DatasetError(f"{folder} exists; take another name, or delete it first")
    part = folder.with_name(f".{folder.name}.part")
    shutil.rmtree(part, ignore_errors=True)
    try:
        for split in SPLITS:
            (part / "images" / split).mkdir(parents=True)
            (part / "labels" / split).mkdir(parents=True)
        empty, done = [], 0
        for names, count in _drawn(kind, part, images, seed, size, workers):
            empty, done = empty + names, done + count
            if progress is not None:
                progress(done, images)
        about = {**{s: f"images/{s}" for s in SPLITS},
                 "names": dict(enumerate(CLASSES[kind]))}  # fmt: skip
        (part / "data.yaml").write_text(yaml.safe_dump(about, sort_keys=False), encoding="utf-8")
        (part / "background.txt").write_text("".join(f"{n}\n" for n in empty), encoding="utf-8")
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder


def _drawn(
    kind: str, part: Path, images: int, seed: int, size: tuple[int, int] | None, workers: int | None
) -> Iterator[tuple[list[str], int]]:
    """Draw all pictures, chunk by chunk: names of those without boxes, and how many were drawn."""
    chunks = [range(k, min(k + CHUNK, images)) for k in range(0, images, CHUNK)]
    workers = min(workers or os.cpu_count() or 1, len(chunks))
    if workers <= 1:
        for chunk in chunks:
            yield _draw(kind, part, seed, size, chunk)
        return
    # Fresh processes: a fork of a notebook's kernel would inherit its threads' locks.
    fresh = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=fresh) as pool:
        tasks = [pool.submit(_draw, kind, part, seed, size, chunk) for chunk in chunks]
        try:
            for task in tasks:
                yield task.result()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _draw(
    kind: str, part: Path, seed: int, size: tuple[int, int] | None, indices: range
) -> tuple[list[str], int]:
    """Some pictures and their labels, into their files."""
    import cv2

    from robocon_course.vision import pictures

    cv2.setNumThreads(1)
    empty = []
    for index in indices:
        taken = pictures.picture(kind, seed, index, size)
        image, split, name = taken.image_bgr, split_of(index), f"{kind}_{index:06d}"
        if split == "train":
            image = augment(image, np.random.default_rng([seed, index, 15]))
        height, width = image.shape[:2]
        lines = yolo_lines(taken.boxes, taken.class_ids, width, height)
        quality = [cv2.IMWRITE_JPEG_QUALITY, QUALITY]
        if not cv2.imwrite(str(part / "images" / split / f"{name}.jpg"), image, quality):
            raise OSError(f"{part}: a picture could not be written; is the disk full?")
        (part / "labels" / split / f"{name}.txt").write_text(lines, encoding="ascii")
        if not lines:
            empty.append(f"{split}/{name}")
    return empty, len(indices)


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
    """
    import cv2

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


# --- looking at a data set ------------------------------------------------------------------------


class Problem(NamedTuple):
    """Something wrong with a data set: in which file, and what."""

    file: str
    what: str


def check_dataset(folder: str | Path) -> list[Problem]:
    """Everything that is wrong with a data set; an empty list if nothing is.

    Parameters
    ----------
    folder : path
        With data.yaml in it.

    Returns
    -------
    list of Problem
        Labels that are missing or empty (unless background.txt names the picture), labels without a
        picture, pictures that cannot be read, lines that are no box, unknown classes, boxes that
        leave the picture or have no size, one picture in two splits, classes that are rare.

    Raises
    ------
    DatasetError
        No data.yaml, or one that is no description of a data set.
    """
    folder = Path(folder)
    names = read_names(folder)
    noted = folder / "background.txt"
    meant = set(noted.read_text(encoding="utf-8").split()) if noted.is_file() else set()
    problems: list[Problem] = []
    counts: Counter[int] = Counter()
    first: dict[str, tuple[str, str]] = {}
    for split in SPLITS:
        images = {p.stem: p for p in _files(folder / "images" / split, (".jpg", ".jpeg", ".png"))}
        labels = {p.stem: p for p in _files(folder / "labels" / split, (".txt",))}
        for stem in sorted(labels.keys() - images.keys()):
            problems.append(Problem(f"labels/{split}/{stem}.txt", "has no picture"))
        for stem, path in sorted(images.items()):
            where = f"images/{split}/{path.name}"
            problems += _picture_problems(path, where, split, first)
            if stem not in labels:
                problems.append(Problem(where, "has no label file"))
                continue
            text = labels[stem].read_text(encoding="utf-8", errors="replace")
            if not text.strip() and f"{split}/{stem}" not in meant:
                what = "is empty; name it in background.txt if that is meant"
                problems.append(Problem(f"labels/{split}/{stem}.txt", what))
            problems += _label_problems(text, f"labels/{split}/{stem}.txt", names, counts)
    return problems + _balance_problems(names, counts)


def read_names(folder: str | Path) -> tuple[str, ...]:
    """The classes of a data set, from its data.yaml.

    Raises
    ------
    DatasetError
        There is none, or it is no description of a data set.
    """
    path = Path(folder) / "data.yaml"
    try:
        names = yaml.safe_load(path.read_text(encoding="utf-8"))["names"]
        listed = [names[k] for k in sorted(names)] if isinstance(names, dict) else list(names)
    except OSError:
        raise DatasetError(f"{folder}: no data set (no data.yaml)") from None
    except (yaml.YAMLError, KeyError, TypeError, UnicodeDecodeError):
        raise DatasetError(f"{path}: no description of a data set; make it again") from None
    return tuple(str(name) for name in listed)


def _files(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    found = folder.iterdir() if folder.is_dir() else ()
    return [path for path in found if path.suffix.lower() in endings]


def _picture_problems(
    path: Path, where: str, split: str, first: dict[str, tuple[str, str]]
) -> Iterator[Problem]:
    """A picture that cannot be read, or that another split has, too."""
    import cv2

    image = cv2.imdecode(np.frombuffer(path.read_bytes() or b"0", np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        yield Problem(where, "cannot be read as a picture")
        return
    content = hashlib.sha256(image.tobytes()).hexdigest()
    other_split, other = first.setdefault(content, (split, where))
    if other_split != split:
        yield Problem(where, f"is the same picture as {other}")


def _label_problems(
    text: str, where: str, names: tuple[str, ...], counts: Counter[int]
) -> Iterator[Problem]:
    """Lines of a label file that are no box of a known class inside the picture."""
    for number, line in enumerate(text.splitlines(), 1):
        at = f"{where}:{number}"
        try:
            values = [float(word) for word in line.split()]
        except ValueError:
            values = []
        if len(values) != 5 or not np.isfinite(values).all():
            yield Problem(at, f"is not five numbers: {line[:40]!r}")
            continue
        if values[0] not in range(len(names)):
            yield Problem(at, f"has class {values[0]:g}; there are 0 to {len(names) - 1}")
            continue
        counts[int(values[0])] += 1
        left, top, right, bottom = xyxy_from_yolo([values], 1, 1)[0]
        if values[3] <= 0 or values[4] <= 0:
            yield Problem(at, "has a box without size")
        elif min(left, top) < -1e-5 or max(right, bottom) > 1 + 1e-5:
            yield Problem(at, "has a box that leaves the picture")


def _balance_problems(names: tuple[str, ...], counts: Counter[int]) -> list[Problem]:
    """Classes without boxes, or with few."""
    mean = sum(counts.values()) / max(1, len(names))
    return [
        Problem("data.yaml", f"class {name!r} has {counts[k]} boxes, the mean is {mean:.0f}")
        for k, name in enumerate(names)
        if counts[k] == 0 or counts[k] < RAREST * mean
    ]


COLOURS = {"blue": (255, 190, 60), "purple": (255, 90, 255), "red": (80, 80, 255)}
"""Of boxes and tags, BGR; any other class is drawn in yellow."""


def contact_sheet(
    folder: str | Path, count: int = 24, *, across: int = 6, split: str = "train"
) -> NDArray[np.uint8]:
    """The first pictures of a split side by side, with their boxes.

    Parameters
    ----------
    folder : path
    count, across : int
        How many pictures, and how many in a row.
    split : {"train", "val", "test"}

    Returns
    -------
    ndarray of uint8, shape (h, w, 3), BGR

    Raises
    ------
    DatasetError
        No data set, or no pictures in the split.
    """
    import cv2

    folder = Path(folder)
    names = read_names(folder)
    paths = sorted(_files(folder / "images" / split, (".jpg", ".jpeg", ".png")))[:count]
    if not paths:
        raise DatasetError(f"{folder}: no pictures in images/{split}")
    tiles, images = [], [cv2.imread(str(path)) for path in paths]
    tallest = max(min(1.0, image.shape[0] / image.shape[1]) for image in images)
    for path, image in zip(paths, images, strict=True):
        label = folder / "labels" / split / f"{path.stem}.txt"
        lines = label.read_text(encoding="ascii").splitlines() if label.is_file() else []
        rows = np.array([line.split() for line in lines], float).reshape(-1, 5)
        boxes = xyxy_from_yolo(rows, image.shape[1], image.shape[0])
        for box, k in zip(boxes, rows[:, 0].astype(int), strict=True):
            draw_box(image, box, names[k])
        tiles.append(_fitted(image, 240, tallest))
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % across)
    rows = [np.hstack(tiles[k : k + across]) for k in range(0, len(tiles), across)]
    return np.vstack(rows)


def draw_box(image_bgr: NDArray[np.uint8], box: FloatArray, name: str, tag: str = "") -> None:
    """A thin box in the class's colour, into the picture; silos with their filling above."""
    import cv2

    left, top, right, bottom = (round(float(side)) for side in box)
    colour = COLOURS.get(name, (0, 230, 255))
    cv2.rectangle(image_bgr, (left, top), (right - 1, bottom - 1), colour, 1)
    tag = tag or ("" if name in COLOURS else name)
    if tag:
        at = (left + 1, top - 3 if top > 12 else bottom + 10)
        cv2.putText(image_bgr, tag, at, cv2.FONT_HERSHEY_SIMPLEX, 0.35, (0, 0, 0), 3, cv2.LINE_AA)
        cv2.putText(image_bgr, tag, at, cv2.FONT_HERSHEY_SIMPLEX, 0.35, colour, 1, cv2.LINE_AA)


def _fitted(image: NDArray[np.uint8], side: int, tallest: float) -> NDArray[np.uint8]:
    """A picture in a tile of its own, with a white margin; `tallest` is the tile's shape."""
    import cv2

    width, height = side, round(side * tallest)
    scale = min((width - 4) / image.shape[1], (height - 4) / image.shape[0])
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    tile = np.full((height, width, 3), 255, np.uint8)
    top, left = (height - small.shape[0]) // 2, (width - small.shape[1]) // 2
    tile[top : top + small.shape[0], left : left + small.shape[1]] = small
    return tile
