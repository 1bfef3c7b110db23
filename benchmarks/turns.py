"""Contenders that take turns: how every benchmark here measures."""

from __future__ import annotations

import sys
from collections.abc import Callable
from statistics import median
from time import process_time


def medians(contenders: dict[str, Callable[[], object]], repeats: int) -> dict[str, float]:
    """Median CPU time of one call of each contender [s]; noise meets all of them alike.

    Parameters
    ----------
    contenders : dict of callable
        A contender that does its work many times returns how often; its time is that of one.
    repeats : int
        Rounds that count. One more goes before: it compiles and warms the caches.
    """
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(repeats + 1):
        print(f"\r  round {turn} of {repeats}", end="", file=sys.stderr, flush=True)
        for name, contender in contenders.items():
            start = process_time()
            done = contender()
            elapsed = process_time() - start
            if turn:
                times[name].append(elapsed / done if type(done) is int else elapsed)
    print("\r" + " " * 30 + "\r", end="", file=sys.stderr)
    return {name: median(values) for name, values in times.items()}
