"""The learning curves of a training: read from what it writes after each epoch. Loads no torch."""

from __future__ import annotations

import csv
import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from robocon_course._arrays import CourseError, FloatArray

RESULTS = "results.csv"
COLUMNS = {
    "epoch": "epoch",
    "seconds": "time",
    "box": "train/box_loss",
    "class": "train/cls_loss",
    "dfl": "train/dfl_loss",
    "precision": "metrics/precision(B)",
    "recall": "metrics/recall(B)",
    "map50": "metrics/mAP50(B)",
    "map50_95": "metrics/mAP50-95(B)",
    "val_box": "val/box_loss",
    "val_class": "val/cls_loss",
    "val_dfl": "val/dfl_loss",
}
"""Our names of the columns, and Ultralytics'."""
MEASURED = ("val_box", "val_class", "val_dfl", "precision", "recall", "map50", "map50_95")


class TrainingError(CourseError):
    """A training that cannot start or go on."""


class Epoch(NamedTuple):
    """Where a training is, for whoever shows its progress.

    Attributes
    ----------
    number, of : int
        The epoch that has just ended, and how many there will be.
    loss : float
        Sum of the three losses on the training pictures.
    map50 : float
        mAP at an overlap of 0.5 on the validation pictures; NaN where it was not measured.
    seconds : float
        That the training has taken so far; a time in which it lay still does not count.
    """

    number: int
    of: int
    loss: float
    map50: float
    seconds: float

    def in_words(self) -> str:
        """One line, with the time that is left if the epochs go on as long as so far.

        Examples
        --------
        >>> Epoch(3, 12, 7.04, 0.25, 60.0).in_words()
        'epoch 3 of 12: loss 7.04, mAP50 0.250, 3 min left'
        """
        score = "" if np.isnan(self.map50) else f", mAP50 {self.map50:.3f}"
        left = self.seconds / self.number * (self.of - self.number)
        time = f"{left:.0f} s" if left < 100 else f"{left / 60:.0f} min"
        return f"epoch {self.number} of {self.of}: loss {self.loss:.2f}{score}, {time} left"


def history(run: str | Path) -> dict[str, FloatArray]:
    """The learning curves of a training.

    Parameters
    ----------
    run : path

    Returns
    -------
    dict of str to ndarray
        ``epoch``, ``box``, ``class``, ``dfl`` (losses on the training pictures), ``val_box``,
        ``val_class``, ``val_dfl``, ``precision``, ``recall``, ``map50``, ``map50_95``, ``seconds``;
        one value an epoch, NaN where it was not measured.

    Raises
    ------
    TrainingError
        Nothing was trained there.
    """
    try:
        rows = _rows(Path(run) / RESULTS)
    except OSError:
        raise TrainingError(f"{run}: no training has ended an epoch there") from None
    found = {
        ours: np.array([_number(row.get(theirs)) for row in rows])
        for ours, theirs in COLUMNS.items()
    }
    # An epoch without validation repeats what was measured last, or 0.
    measured = np.array([found[name] for name in MEASURED])
    fresh = (np.diff(measured, prepend=0.0) != 0.0).any(axis=0) & measured.any(axis=0)
    for name in MEASURED:
        found[name][~fresh] = np.nan
    return found


def new_epochs(run: Path, told: int, of: int) -> Iterator[Epoch]:
    """What a training has written since `told` of its epochs were told of."""
    if not (run / RESULTS).is_file():
        return
    found = history(run)
    for k in range(told, len(found["epoch"])):
        loss = float(found["box"][k] + found["class"][k] + found["dfl"][k])
        number, map50 = int(found["epoch"][k]), float(found["map50"][k])
        yield Epoch(number, of, loss, map50, float(found["seconds"][k]))


def forget_after(run: Path, epoch: int) -> None:
    """Strike out what was written of epochs of which no checkpoint was kept.

    A kill after an epoch's figures and before its checkpoint leaves a row that will come again.
    """
    path = run / RESULTS
    if not path.is_file():
        return
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    whole = [line for line in lines[1:] if line.endswith("\n") and _number(line) <= epoch]
    new = path.with_suffix(".new")
    new.write_text("".join(lines[:1] + whole), encoding="utf-8")
    os.replace(new, path)


def _rows(path: Path) -> list[dict]:
    """The whole lines of a table; another process may be writing the next."""
    text = path.read_text(encoding="utf-8")
    lines = text[: text.rfind("\n") + 1].splitlines()
    return [{k.strip(): v for k, v in row.items() if k} for row in csv.DictReader(lines)]


def _number(text: str | None) -> float:
    """The number that a text begins with; NaN where there is none."""
    try:
        return float((text or "").partition(",")[0])
    except ValueError:
        return np.nan
