"""Places on a path: when two answers mean the same one, and paths to try answers on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course.exercises.likeness import like_case
from robocon_course.exercises.model import Case
from robocon_course.tracking import PathPoint

CLOSE = 1e-7
L_SHAPE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]])
HAIRPIN = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 0.2], [0.0, 0.2]])
Path = np.ndarray


def point_case(what: str, reference: Callable[..., PathPoint], *args: object) -> Case:
    """A case whose answer is right where it is the same place of the path.

    The end of one segment and the beginning of the next are one place.

    Parameters
    ----------
    what : str
        The situation in words.
    reference : callable
    *args : object
        What answer and reference are called with.
    """

    def same(came: PathPoint, expected: PathPoint) -> PathPoint:
        apart = abs(came.index + came.share - expected.index - expected.share)
        if apart < CLOSE and 0 <= came.index <= len(args[0]) - 2:
            return came._replace(index=expected.index, share=expected.share)
        return came

    return like_case(what, reference, args, same, CLOSE)


def some_path(rng: np.random.Generator, points: int = 7) -> Path:
    """Straight pieces of half a metre or so, none of them straight back."""
    way = np.cumsum(rng.uniform(-1.1, 1.1, points - 1)) + rng.uniform(-3.0, 3.0)
    steps = rng.uniform(0.3, 0.8, points - 1)[:, None] * np.column_stack([np.cos(way), np.sin(way)])
    return np.round(np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]), 3)


def beside(path: Path, rng: np.random.Generator, off: float) -> tuple[np.ndarray, int]:
    """A place beside a segment that is neither the first nor the last, and its index."""
    k = int(rng.integers(1, len(path) - 2))
    share, way = rng.uniform(0.3, 0.7), path[k + 1] - path[k]
    left = np.array([-way[1], way[0]]) / np.hypot(*way)
    return np.round(path[k] + share * way + rng.choice([-1.0, 1.0]) * off * left, 3), k
