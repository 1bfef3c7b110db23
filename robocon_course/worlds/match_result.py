"""How a match went: the end, the record, and what was written down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from robocon_course._arrays import FloatArray, freeze_arrays


@dataclass(frozen=True)
class MatchResult:
    """How a match went.

    Attributes
    ----------
    seed : int
    parts : str
        Whose parts played.
    winner : str
        ``"own"``, ``"theirs"`` or ``"nobody"``.
    reason : str
        ``"Mua Vang"`` or ``"points"``.
    ended : float  [s]
    points, their_points : int
    stored, fouls, retries, contacts : int
        Balls in silos; fouls; retries; how often the body began to touch something.
    fillings : tuple of str
        Of the silos at the end, from bottom to top.
    time : ndarray, shape (n,)  [s]
        Of the record, from the start.
    poses, estimates : ndarray, shape (n, 3)  [m, m, rad; map]
        The truth, and what the robot believed.
    states : tuple of str
        One for each row.
    error : float  [m]
        Root mean square of the position's error over the match.
    reset_errors : ndarray, shape (k,)  [m]
        Each time the pose had just been measured against the walls.
    history : tuple of (float, str, str)
        Time [s], state and reason of each change of state.
    events : tuple
        What the referee wrote down; see `simulator.referee.Event`.
    rejected : int
        Readings that the robot could not use.
    balls : tuple of ndarray, each (m, 2)  [m, map]
        Where the balls lay, a row of the record each; with their colours in `colours`.
    """

    seed: int
    parts: str
    winner: str
    reason: str
    ended: float
    points: int
    their_points: int
    stored: int
    fouls: int
    retries: int
    contacts: int
    fillings: tuple[str, ...]
    time: FloatArray
    poses: FloatArray
    estimates: FloatArray
    states: tuple[str, ...]
    error: float
    reset_errors: FloatArray
    history: tuple[tuple[float, str, str], ...]
    events: tuple[Any, ...]
    rejected: int
    balls: tuple[FloatArray, ...] = ()
    colours: tuple[tuple[str, ...], ...] = ()

    __post_init__ = freeze_arrays

    @property
    def mua_vang(self) -> bool:
        """Whether the own team won before the time was up."""
        return self.winner == "own" and self.reason == "Mua Vang"

    @property
    def lines(self) -> tuple[str, ...]:
        """The match in words and numbers."""
        mark = {"own": "✔ won", "theirs": "✘ lost", "nobody": "– a draw"}[self.winner]
        silos = "  ".join(f"{k + 1} {filling or '–'}" for k, filling in enumerate(self.fillings))
        return (
            f"{mark} by {self.reason} after {self.ended:.1f} s, {self.points} : "
            f"{self.their_points} points",
            f"silos from bottom to top: {silos}",
            f"{self.stored} balls stored, {self.fouls} fouls, {self.retries} retries, touched "
            f"something {self.contacts} times, {self.rejected} readings rejected",
            f"position: {1000 * self.error:.0f} mm RMS off over the match, "
            f"{1000 * float(np.mean(self.reset_errors)) if len(self.reset_errors) else 0:.1f} mm "
            f"at {len(self.reset_errors)} resets",
        )

    def fillings_at(self, now: float) -> tuple[str, ...]:
        """What the five silos held at a time [s], each from bottom to top; ``""`` is empty."""
        held = [""] * len(self.fillings)
        for event in self.events:
            if event.what == "stored" and event.time <= now:
                silo, filling = stored_in(event.detail)
                held[silo] = filling
        return tuple(held)


def stored_in(detail: str) -> tuple[int, str]:
    """Which silo, from 0, and what it then held: of an event's detail such as ``silo 3: RB``."""
    number, _, filling = detail.removeprefix("silo ").partition(": ")
    return int(number) - 1, filling
