"""Rules and points of a match, from Robot 2's side, and the other team as a clock with a taste.

Points: 10 for a seedling, 10 for a ball sent to the Storage Zone, 30 for a ball in a silo. Three
silos, each full, with two own balls or more and an own one on top, win at once (Mua Vang). A foul
(another ball than an own one gripped, or a second one) means a retry. The rules know two more, a
body over the Silo Zone or in the water: the simulator's walls let no body come there.

Source: rules of ABU Robocon 2024 as far as known; where nothing was found the numbers here are
proposals: unlimited retries of 5 s, the carried ball leaves the game.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from robocon_course._arrays import CourseError
from robocon_course.field import MATCH_LENGTH, SILOS
from robocon_course.mission import LETTERS, is_full, winner

TEAMS = ("own", "theirs")
MATCH = MATCH_LENGTH
"""[s]"""
RETRY_COSTS = 5.0
"""[s]"""
SEEDLING, TRANSFER, STORED = 10, 10, 30
"""Points."""
WORTH = {"stored": STORED, "transfer": TRANSFER, "seedling": SEEDLING}
"""Points by event. Of equal sums the balls in silos decide, then those sent, then seedlings."""
MUA_VANG = "Mua Vang"


class Event(NamedTuple):
    """Something that the referee saw.

    Attributes
    ----------
    time : float  [s]
    what : str
        ``"stored"``, ``"transfer"``, ``"seedling"``, ``"foul"``, ``"retry"``, ``"lost ball"`` …
    team : str
        ``"own"`` or ``"theirs"``.
    detail : str
    """

    time: float
    what: str
    team: str
    detail: str = ""


@dataclass
class Referee:
    """Keeps the score.

    Parameters
    ----------
    letter : {"R", "B"}
        Of the own team's balls.

    Attributes
    ----------
    fillings : list of str
        What the five silos hold, from bottom to top; ``""`` is empty.
    points : dict
        ``"own"`` and ``"theirs"``.
    events : list of Event
    winner, reason : str
        Empty while the match is played.
    ended : float  [s]
        When it did; until then, when it will at the latest.

    Raises
    ------
    CourseError
        Another letter; from the methods, another team, silo or deed.
    """

    letter: str
    fillings: list[str] = field(init=False, default_factory=lambda: [""] * len(SILOS))
    points: dict[str, int] = field(init=False, default_factory=lambda: {"own": 0, "theirs": 0})
    events: list[Event] = field(init=False, default_factory=list)
    winner: str = field(init=False, default="")
    reason: str = field(init=False, default="")
    ended: float = field(init=False, default=MATCH)

    def __post_init__(self) -> None:
        refuse("letter", self.letter, tuple(LETTERS.values()))

    def letter_of(self, team: str) -> str:
        """Of a team's balls."""
        refuse("team", team, TEAMS)
        return self.letter if team == "own" else "RB".replace(self.letter, "")

    def store(self, time: float, team: str, silo: int) -> bool:
        """A ball falls into a silo, 0 to 4; False if it is full, and the ball rolls away."""
        letter = self.letter_of(team)
        refuse("silo", silo, range(len(SILOS)))
        if is_full(self.fillings[silo]):
            self.note(time, "lost ball", team, f"silo {silo + 1} was full")
            return False
        self.fillings[silo] += letter
        self.points[team] += STORED
        self.note(time, "stored", team, f"silo {silo + 1}: {self.fillings[silo]}")
        if winner(self.fillings) == letter:
            self._end(time, team, MUA_VANG)
        return True

    def give(self, time: float, team: str, what: str) -> None:
        """Points for Robot 1's work: ``"transfer"`` or ``"seedling"``."""
        refuse("team", team, TEAMS)
        refuse("what", what, ("transfer", "seedling"))
        self.points[team] += WORTH[what]
        self.note(time, what, team)

    def note(self, time: float, what: str, team: str = "own", detail: str = "") -> None:
        """Write something down."""
        self.events.append(Event(time, what, team, detail))

    def time_is_up(self, time: float) -> None:
        """The match ends by points; where they and what they are made of are equal nobody wins."""
        own, theirs = (
            (self.points[team], *(self.count(what, team) for what in WORTH)) for team in TEAMS
        )
        winner = "own" if own > theirs else "theirs" if theirs > own else "nobody"
        self._end(time, winner, "points")

    def count(self, what: str, team: str = "own") -> int:
        """How often something was seen."""
        return sum(event.what == what and event.team == team for event in self.events)

    def _end(self, time: float, winner: str, reason: str) -> None:
        if not self.winner:
            self.winner, self.reason, self.ended = winner, reason, time


def refuse(name: str, got: object, known: Collection) -> None:
    """Refuse an argument that is none of those that are known.

    Parameters
    ----------
    name : str
        Of the argument.
    got : object
    known : collection

    Raises
    ------
    CourseError
    """
    if got not in known:
        raise CourseError(f"{name}: expected one of {', '.join(map(str, known))}, got {got!r}")


class Opponent(NamedTuple):
    """The other team's Robot 2, as often as it comes.

    Attributes
    ----------
    first : float  [s]
        When it stores its first ball.
    every, spread : float  [s]
        Time from one to the next, and its standard deviation.
    failing : float
        Share of its balls that miss.
    """

    first: float
    every: float
    spread: float
    failing: float


OPPONENTS = {
    "weak": Opponent(45.0, 30.0, 5.0, 0.15),
    "middling": Opponent(32.0, 20.0, 4.0, 0.10),
    "strong": Opponent(24.0, 13.0, 2.5, 0.04),
}


def plan(rng: np.random.Generator, opponent: Opponent) -> list[tuple[float, bool]]:
    """When the other team comes to a silo, and whether its ball falls in.

    Parameters
    ----------
    rng : numpy.random.Generator
    opponent : Opponent

    Returns
    -------
    list of (float, bool)
    """
    times, now = [], opponent.first + opponent.spread * rng.standard_normal()
    while now < MATCH:
        times.append((float(now), bool(rng.random() >= opponent.failing)))
        now += max(5.0, opponent.every + opponent.spread * rng.standard_normal())
    return times[:12]  # six from its pile, six that its Robot 1 sends
