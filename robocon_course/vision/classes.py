"""What the two networks tell apart, in the order of their class numbers."""

from __future__ import annotations

from itertools import product

BALLS = ("blue", "purple", "red")
"""Classes of the ball network: two teams' Paddy Rice and, between them, the Empty Grain."""

SILOS = ("empty", *("".join(balls) for n in (1, 2, 3) for balls in product("BR", repeat=n)))
"""Classes of the silo network: 15 fillings, each written from bottom to top (B blue, R red)."""

CLASSES = {"ball": BALLS, "silo": SILOS}

MIN_SCORE = {"ball": 0.4, "silo": 0.6}
"""Lowest score that counts. Source: swerve robot of Yogyakarta State University, 2024."""


def classes_of(kind: str) -> tuple[str, ...]:
    """The classes of a network, by its kind.

    Parameters
    ----------
    kind : {"ball", "silo"}

    Returns
    -------
    tuple of str

    Raises
    ------
    ValueError
        Another kind.
    """
    if kind not in CLASSES:
        raise ValueError(f"kind: expected 'ball' or 'silo', got {kind!r}")
    return CLASSES[kind]
