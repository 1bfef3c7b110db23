"""A match in real time in a notebook: the operator's screen, and the simulator behind it."""

from __future__ import annotations

import asyncio
from time import monotonic
from typing import TYPE_CHECKING

from robocon_course.mission import mermaid, mission_table
from robocon_course.robot import Bus
from robocon_course.view.dashboard import Dashboard, dashboard

if TYPE_CHECKING:
    from robocon_course.worlds import Play

SLICE = 0.05
"""So much passes at a time; between two slices the kernel is free [s]."""
LAG = 0.5
"""A computer that falls back by more plays slower instead of catching up [s]."""


def play_live(play: Play, *, speed: float = 1.0) -> Dashboard:
    """Play a match in real time, with the operator's screen. Start it there.

    Parameters
    ----------
    play : Play
        Made with a bus.
    speed : float
        How many times as fast as real time, as far as the computer can.

    Returns
    -------
    Dashboard
        Closing it ends the match.

    Raises
    ------
    ValueError
        A play without a bus, a speed that is not positive, or no notebook around.
    """
    if not isinstance(play.bus, Bus):
        raise ValueError("play: expected one with a bus, such as Play(bus=Bus())")
    if not 0.0 < speed <= 20.0:
        raise ValueError(f"speed: expected a number above 0, at most 20, got {speed!r}")
    screen = dashboard(play.bus, states=mermaid(mission_table()))
    try:
        loop = asyncio.get_running_loop()
    except RuntimeError:
        return screen  # a plain script: whoever runs it lets time pass
    task = loop.create_task(_run(play, screen, speed))
    screen.task = task  # a task that nobody holds may be collected
    return screen


async def _run(play: Play, screen: Dashboard, speed: float) -> None:
    """Let the simulator keep pace with the clock on the wall."""
    due = monotonic()
    while not screen.closed:
        for _ in range(max(1, round(SLICE * speed / 0.01))):
            if not play.match.over:
                play.tick()
        due = max(due + SLICE, monotonic() - LAG)
        await asyncio.sleep(max(0.001, due - monotonic()))
