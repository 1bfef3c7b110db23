"""Counts between the readings of a counter, and how people get them wrong."""

from __future__ import annotations

import numpy as np

from robocon_course import odometry, worlds
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.worlds import Student


def _tick_changes_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    square = worlds.odometry_world(student).square.counters
    start = int(rng.integers(1000, 2000))
    steps = rng.integers(-300, 300, (40, 3))
    walk = np.cumsum(np.vstack([rng.integers(0, 65536, 3), steps]), axis=0)
    forward = np.cumsum(np.vstack([[65400, 10, 30000], rng.integers(20, 90, (30, 3))]), axis=0)
    named = [
        ("forward, far from the end", [[start, start, 7], [start + 5, start + 9, 8]], 16),
        ("backwards, far from the end", [[start, start, 90], [start - 5, start - 9, 80]], 16),
        ("one counter runs over its end", [[65530, 100, 5], [4, 110, 15]], 16),
        ("one counter runs below 0", [[3, 100, 50], [65533, 90, 40]], 16),
        ("a long drive forward", forward % 65536, 16),
        ("there and back, past the end", walk % 65536, 16),
        ("a signed counter, from 32767 to -32768", [[32760, 0, -5], [-32766, 3, -9]], 16),
        ("a counter of 12 bits", [[4090, 2, 300], [5, 4091, 310]], 12),
        ("half the range, almost", [[1000, 31000, 5], [31000, 1000, 10]], 16),
        ("half the range of 12 bits, almost", [[50, 2050, 9], [2050, 50, 4]], 12),
        ("your own square", square[1000:1200], worlds.BITS),
    ]
    return [Case(what, (np.array(counters), bits), "counts", 0.0) for what, counters, bits in named]


def _wrapped(changes: np.ndarray, bits: int, modulus: int | None = None) -> np.ndarray:
    half, whole = 1 << (bits - 1), modulus or (1 << bits)
    return (changes + half) % whole - half


def _one_way(counters: np.ndarray, bits: int, *, up: bool) -> np.ndarray:
    changes = np.diff(counters, axis=0)
    half, whole = 1 << (bits - 1), 1 << bits
    if up:
        return np.where(changes < -half, changes + whole, changes)
    return np.where(changes > half, changes - whole, changes)


def _beyond(limit: int, counters: np.ndarray, bits: int) -> np.ndarray:
    """Every change beyond a fixed limit is taken for a run past the end."""
    changes = np.diff(counters, axis=0)
    return np.where(np.abs(changes) > limit, changes - np.sign(changes) * (1 << bits), changes)


TICK_CHANGES = Exercise(
    id="odometry.tick_changes",
    title="Counts between readings of a counter that wraps around",
    points=2,
    reference=odometry.tick_changes,
    cases=_tick_changes_cases,
    hints=(
        "np.diff(counters, axis=0) is right, except where a counter ran past its end.",
        "A step of 10 past the end of 16 bits reads as 10 − 65536. Every whole turn of the "
        "counter, 2**bits, may be added or taken away: choose the change nearest to 0.",
        "(change + half) % whole − half, with whole = 2**bits and half = whole // 2. It is the "
        "wrap_angle of chapter 00, for counters.",
    ),
    mistakes=(
        Mistake(
            "no wrap",
            "Where a counter ran past its end, the wheel seems to race back a whole turn of the "
            "counter. Bring the change into the range from −half to half.",
            lambda counters, bits: np.diff(counters, axis=0),
        ),
        Mistake(
            "never backwards",
            "Every change is positive: a wheel that rolls back by 5 seems to roll forward by "
            "65531. Take the change nearest to 0, whichever its sign.",
            lambda counters, bits: np.diff(counters, axis=0) % (1 << bits),
        ),
        Mistake(
            "wraps forward only",
            "It mends a counter that runs over its end, but not one that runs below 0 while the "
            "wheel rolls backwards.",
            lambda counters, bits: _one_way(counters, bits, up=True),
        ),
        Mistake(
            "wraps backwards only",
            "It mends a counter that runs below 0, but not one that runs over its end.",
            lambda counters, bits: _one_way(counters, bits, up=False),
        ),
        Mistake(
            "one count lost",
            "The counter is taken for one count shorter than it is. From 0 to 2**bits − 1 there "
            "are 2**bits counts.",
            lambda counters, bits: _wrapped(np.diff(counters, axis=0), bits, (1 << bits) - 1),
        ),
        Mistake(
            "sign reversed",
            "The older reading has to be taken from the newer one, not the other way round.",
            lambda counters, bits: _wrapped(-np.diff(counters, axis=0), bits),
        ),
        Mistake(
            "absolute values",
            "The sign is lost: a wheel that rolls back counts as if it rolled forward.",
            lambda counters, bits: np.abs(_wrapped(np.diff(counters, axis=0), bits)),
        ),
        Mistake(
            "always 16 bits",
            "The argument bits is not used: counters of another width wrap elsewhere.",
            lambda counters, bits: _wrapped(np.diff(counters, axis=0), 16),
        ),
        Mistake(
            "since the start",
            "These are counts since the first reading. Asked for are those since the reading "
            "before: one row less than there are readings.",
            lambda counters, bits: np.cumsum(_wrapped(np.diff(counters, axis=0), bits), axis=0),
        ),
        Mistake(
            "across the wheels",
            "This is the difference between two wheels. np.diff goes along the last axis unless "
            "it is told otherwise: axis=0 goes from reading to reading.",
            lambda counters, bits: _wrapped(np.diff(counters), bits),
        ),
        Mistake(
            "a row of zeros",
            "A row is too many: before the first reading nothing is known. The changes are one row "
            "less than the readings.",
            lambda counters, bits: _wrapped(np.diff(counters, axis=0, prepend=counters[:1]), bits),
        ),
        Mistake(
            "^ for a power",
            "2 ^ 16 is 18 in Python, where ^ compares bits. The power is 2 ** 16.",
            lambda counters, bits: (
                (np.diff(counters, axis=0) + (2 ^ bits) // 2) % (2 ^ bits) - (2 ^ bits) // 2
            ),
        ),
        Mistake(
            "a fixed limit",
            "A fixed number of counts decides whether a counter ran past its end. A faster wheel "
            "breaks it. Half the range decides: that change is nearest to 0.",
            lambda counters, bits: _beyond(1000, counters, bits),
        ),
    ),
)
