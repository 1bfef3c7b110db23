"""What is wrong with a data set, and how it looks.

Networks learn from whatever they are given and never complain. So every file is looked at here:
the description, each picture, each line of each label.
"""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from numpy.typing import NDArray

from robocon_course._arrays import CourseError, FloatArray
from robocon_course.vision.classes import classes_of

SPLITS = ("train", "val", "test")
PICTURES = (".jpg", ".jpeg", ".png", ".bmp", ".webp")
"""Endings of what counts as a picture."""
RAREST = 0.2
"""A class with fewer boxes than this share of the mean is reported."""


class DatasetError(CourseError):
    """A data set that cannot be written or read."""


class Problem(NamedTuple):
    """Something wrong with a data set: in which file, and what."""

    file: str
    what: str


def check_dataset(folder: str | Path, *, kind: str | None = None) -> list[Problem]:
    """Everything that is wrong with a data set; an empty list if nothing is.

    Parameters
    ----------
    folder : path
        With data.yaml in it.
    kind : {"ball", "silo"}, optional
        What the classes have to be; left out, those of data.yaml are taken.

    Returns
    -------
    list of Problem
        A data.yaml that is broken or leads elsewhere, splits without pictures, labels that are
        missing or empty (unless background.txt names the picture), labels without a picture,
        pictures that cannot be read or stand there twice, lines that are no box or stand there
        twice, unknown classes, boxes that leave the picture or have no size, classes that are rare.

    Raises
    ------
    DatasetError
        No data.yaml.
    ValueError
        Another kind.
    """
    folder = Path(folder)
    wanted = None if kind is None else classes_of(kind)
    about, problems = _description(folder)
    try:
        names = _names(folder, about)
    except DatasetError as error:
        names = ()
        problems.append(Problem("data.yaml", str(error).partition(": ")[2]))
    if wanted and names and names != wanted:
        what = f"has the classes {', '.join(names)}; a {kind} set has {', '.join(wanted)}"
        problems.append(Problem("data.yaml", what))
    counts: Counter[int] = Counter()
    first: dict[str, str] = {}
    meant = _meant(folder)
    for split in SPLITS:
        problems += _split_problems(folder, split, names, meant, counts, first)
    problems += [Problem("background.txt", f"names {n}: no such picture") for n in sorted(meant)]
    return problems + _balance_problems(names, counts)


def read_names(folder: str | Path) -> tuple[str, ...]:
    """The classes of a data set, from its data.yaml.

    Parameters
    ----------
    folder : path

    Returns
    -------
    tuple of str
        In the order of their numbers.

    Raises
    ------
    DatasetError
        There is no data.yaml, or it is no description of a data set.
    """
    return _names(Path(folder), _description(Path(folder))[0])


def _description(folder: Path) -> tuple[dict[str, Any], list[Problem]]:
    """What data.yaml says (nothing if it is broken), and where it leads elsewhere."""
    path = folder / "data.yaml"
    try:
        about = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError:
        raise DatasetError(f"{folder}: no data set (no data.yaml)") from None
    except (yaml.YAMLError, UnicodeDecodeError):
        return {}, []
    if not isinstance(about, dict):
        return {}, []
    problems = []
    for split in SPLITS[:2] if "test" not in about else SPLITS:
        wanted, named = f"images/{split}", about.get(split)
        there = folder / str(about.get("path") or "") / str(named)
        if named is None or there.resolve() != (folder / wanted).resolve():
            got = "nothing" if named is None else repr(named)
            problems.append(Problem("data.yaml", f"names {got} for {split}; expected '{wanted}'"))
    return about, problems


def _names(folder: Path, about: dict[str, Any]) -> tuple[str, ...]:
    """The classes, or a refusal that begins with the file."""
    names, where = about.get("names"), f"{folder / 'data.yaml'}"
    if isinstance(names, dict) and set(names) == set(range(len(names))):
        names = [names[k] for k in range(len(names))]
    if not isinstance(names, list) or not names:
        rule = "names has to list the classes from number 0 on"
        raise DatasetError(f"{where}: no description of a data set; {rule}")
    if len({str(name) for name in names}) < len(names):
        raise DatasetError(f"{where}: two classes bear one name; give each its own")
    if about.get("nc", len(names)) != len(names):
        raise DatasetError(f"{where}: nc is {about['nc']}, but names lists {len(names)} classes")
    return tuple(str(name) for name in names)


def _meant(folder: Path) -> set[str]:
    """Pictures that hold nothing on purpose, as ``split/stem``."""
    noted = folder / "background.txt"
    if not noted.is_file():
        return set()
    return set(noted.read_text(encoding="utf-8", errors="replace").split("\n")) - {""}


def _files(folder: Path, endings: tuple[str, ...]) -> list[Path]:
    found = folder.iterdir() if folder.is_dir() else ()
    return sorted(path for path in found if path.suffix.lower() in endings and path.is_file())


def _split_problems(
    folder: Path,
    split: str,
    names: tuple[str, ...],
    meant: set[str],
    counts: Counter[int],
    first: dict[str, str],
) -> Iterator[Problem]:
    """Problems of one split; strikes its pictures from `meant`, adds to `counts` and `first`."""
    images = _files(folder / "images" / split, PICTURES)
    labels = {path.stem: path for path in _files(folder / "labels" / split, (".txt",))}
    if not images:
        yield Problem(f"images/{split}", "holds no picture")
    stems: dict[str, str] = {}
    for stem in sorted(labels.keys() - {path.stem for path in images}):
        yield Problem(f"labels/{split}/{stem}.txt", "has no picture")
    for path in images:
        where, stem = f"images/{split}/{path.name}", path.stem
        yield from _picture_problems(path, where, first)
        if stems.setdefault(stem, where) != where:
            yield Problem(where, f"shares its label file with {stems[stem]}")
            continue
        empty_on_purpose = f"{split}/{stem}" in meant
        meant.discard(f"{split}/{stem}")
        if stem not in labels:
            yield Problem(where, "has no label file")
            continue
        text, label = _text(labels[stem]), f"labels/{split}/{stem}.txt"
        if not text.strip() and not empty_on_purpose:
            yield Problem(label, "is empty; name it in background.txt if that is meant")
        elif text.strip() and empty_on_purpose:
            yield Problem(label, "holds boxes, but background.txt says the picture has none")
        rows, wrong = read_rows(text, len(names) or None)
        yield from (Problem(f"{label}:{number}", what) for number, what in wrong)
        counts.update(rows[:, 0].astype(int).tolist())


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace")


def _picture_problems(path: Path, where: str, first: dict[str, str]) -> Iterator[Problem]:
    """A picture that cannot be read, or that stands in the data set already."""
    image = read_picture(path)
    if image is None:
        yield Problem(where, "cannot be read as a picture")
        return
    content = hashlib.sha256(f"{image.shape}".encode() + image.tobytes()).hexdigest()
    if first.setdefault(content, where) != where:
        yield Problem(where, f"is the same picture as {first[content]}")


def read_picture(path: Path) -> NDArray[np.uint8] | None:
    """A picture from its file; None if it cannot be read as a whole.

    Parameters
    ----------
    path : Path

    Returns
    -------
    ndarray of uint8, shape (h, w, 3), BGR, or None
    """
    import cv2

    data = path.read_bytes()
    # Some decoders fill up a torn JPEG with grey: its end mark has to follow its last scan.
    if data[:2] == b"\xff\xd8" and data.rfind(b"\xff\xd9") < data.rfind(b"\xff\xda"):
        return None
    return cv2.imdecode(np.frombuffer(data or b"0", np.uint8), cv2.IMREAD_COLOR)


def read_rows(text: str, classes: int | None = None) -> tuple[FloatArray, list[tuple[int, str]]]:
    """The boxes of a label file, and what is wrong with its other lines.

    Parameters
    ----------
    text : str
    classes : int, optional
        How many there are; left out, any number from 0 on is one.

    Returns
    -------
    ndarray, shape (n, 5)
        Class, middle x, middle y, width, height as shares: the lines that can be drawn.
    list of (int, str)
        Number of a line, from 1 on, and what is wrong there.
    """
    rows: dict[tuple[float, ...], int] = {}
    wrong = []
    for number, line in enumerate(text.splitlines(), 1):
        values, what = _row(line, classes)
        if what:
            wrong.append((number, what))
        elif rows.setdefault(values, number) != number:
            wrong.append((number, f"is the box of line {rows[values]} again"))
    return np.array(list(rows), float).reshape(-1, 5), wrong


def _row(line: str, classes: int | None) -> tuple[tuple[float, ...], str]:
    """The numbers of a line, or what is wrong with it."""
    try:
        values = tuple(float(word) for word in line.split())
    except ValueError:
        values = ()
    if len(values) != 5 or not np.isfinite(values).all():
        return (), f"is not five numbers: {line[:40]!r}"
    k, x, y, w, h = values
    if k != int(k) or k < 0 or (classes is not None and k >= classes):
        known = "whole numbers from 0 on" if classes is None else f"0 to {classes - 1}"
        return (), f"has class {k:g}; there are {known}"
    if w <= 0 or h <= 0:
        return (), "has a box without size"
    if min(x - w / 2, y - h / 2) < -1e-5 or max(x + w / 2, y + h / 2) > 1 + 1e-5:
        return (), "has a box that leaves the picture"
    return values, ""


def _balance_problems(names: tuple[str, ...], counts: Counter[int]) -> list[Problem]:
    """Classes without boxes, or with few."""
    mean = sum(counts.values()) / max(1, len(names))
    return [
        Problem("data.yaml", f"class {name!r} has {counts[k]} boxes, the mean is {mean:.0f}")
        for k, name in enumerate(names)
        if counts[k] == 0 or counts[k] < RAREST * mean
    ]
