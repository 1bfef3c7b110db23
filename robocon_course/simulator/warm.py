"""The first robot on a computer has to be compiled."""

from __future__ import annotations

from collections.abc import Callable
from threading import Timer

from robocon_course.robot import Command
from robocon_course.simulator.machine import Simulator

PATIENCE = 3.0
"""Longer than this nobody should wait without a word; loading what was compiled takes less [s]."""


def warm_up(say: Callable[[str], object] = print) -> None:
    """Compile the simulator's kernels before they are needed, and say so where it takes long.

    numba keeps what it compiled: the next start is fast, and silent.

    Parameters
    ----------
    say : callable
        Takes one sentence.
    """
    words = "Compiling the simulator. This takes some ten seconds, once on this computer."
    waiting = Timer(PATIENCE, say, (words,))
    waiting.daemon = True
    waiting.start()
    try:
        robot = Simulator()
        robot.apply(Command.stop())
        robot.step(0.02)
        robot.read()
    finally:
        waiting.cancel()
