"""The own world of chapter 06: what a student's detector reported, boxes to try answers on."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.worlds.student import Student, generator

STEP = 0.01
"""Thresholds worth trying lie this far apart."""


@dataclass(frozen=True)
class EyeWorld:
    """One student's detector, run on pictures whose balls are known.

    Attributes
    ----------
    scores : ndarray, shape (n,)
        Of all that it reported, to two decimals; in no order.
    hits : ndarray of bool, shape (n,)
        Whether there was such a ball.
    truths : int
        How many balls there were.
    """

    scores: FloatArray
    hits: NDArray[np.bool_]
    truths: int

    def thresholds(self) -> FloatArray:
        """0.01, 0.02, … 0.99."""
        return np.round(np.arange(STEP, 1.0, STEP), 2)


@functools.lru_cache(maxsize=400)
def eye_world(student: Student) -> EyeWorld:
    """One student's log: the same on every machine."""
    rng = generator(student, "eyes")
    while True:
        world = _some_log(rng)
        if _is_clear(world):
            return world


def _some_log(rng: np.random.Generator) -> EyeWorld:
    truths = int(rng.integers(180, 260))
    found, wrong = int(truths * rng.uniform(0.85, 0.95)), int(truths * rng.uniform(0.8, 1.6))
    # Right ones score high, wrong ones low, and in between nobody can tell.
    middle = rng.uniform(0.5, 0.72)
    right = np.clip(middle + 0.2 + 0.16 * _bell(rng, found), 0.02, 0.98)
    false = np.clip(middle - 0.2 + 0.16 * _bell(rng, wrong), 0.02, 0.98)
    order = rng.permutation(found + wrong)
    scores = np.round(np.concatenate([right, false]), 2)[order]
    return EyeWorld(scores, (np.arange(found + wrong) < found)[order], truths)


def _is_clear(world: EyeWorld) -> bool:
    """Whether one threshold alone is best, and precision equals recall somewhere else."""
    levels = world.thresholds()
    counted = world.scores >= levels[:, None] - 1e-9
    said, right = counted.sum(axis=1), (counted & world.hits).sum(axis=1)
    f1 = 2.0 * right / (said + world.truths)
    best, equal = levels[f1.argmax()], levels[np.abs(said - world.truths).argmin()]
    return bool(np.sum(f1 > f1.max() - 1e-6) == 1 and abs(best - equal) > 1.5 * STEP)


def _bell(rng: np.random.Generator, count: int) -> FloatArray:
    """Numbers around 0, spread by about 1: sums of even ones, alike on every machine."""
    return np.round(rng.integers(0, 1001, (count, 12)).sum(axis=1) / 1000.0 - 6.0, 3)


def some_boxes(rng: np.random.Generator, count: int, side: float = 320.0) -> FloatArray:
    """Boxes all over a picture, to a tenth of a pixel, shape (count, 4) [pixels]."""
    corner = rng.uniform(0.0, 0.7 * side, (count, 2))
    return np.round(np.hstack([corner, corner + rng.uniform(8.0, 0.3 * side, (count, 2))]), 1)
