"""Random numbers by row: sample k of a sensor gets row k, whoever asks and when."""

from __future__ import annotations

import numpy as np

BLOCK = 256
"""Rows drawn at a time."""


class Noise:
    """Rows of standard normal numbers, drawn in order; a window on the latest is kept.

    Attributes
    ----------
    window : ndarray, shape (2 * BLOCK, width)
    first : int
        Number of the window's first row.
    """

    def __init__(self, rng: np.random.Generator, width: int) -> None:
        self.rng = rng
        self.window = rng.standard_normal((2 * BLOCK, width))
        self.first = 0

    def reach(self, row: int) -> None:
        """Move the window on until it holds a row."""
        while row >= self.first + 2 * BLOCK:
            self.window[:BLOCK] = self.window[BLOCK:]
            self.window[BLOCK:] = self.rng.standard_normal((BLOCK, self.window.shape[1]))
            self.first += BLOCK
