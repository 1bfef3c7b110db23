"""What chapter 07 is tried with: silos, balls, a room, a listing, board games.

A *board game* is a match without robots: both teams' balls arrive at seeded times, each team only
says which silo they go to. It takes a millisecond, so that a strategy can be tried on a season.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from robocon_course._arrays import CourseError
from robocon_course.autopilot import Parts
from robocon_course.field import BALL_DIAMETER, SILO_CAPACITY, SILOS
from robocon_course.mission import Rhythm, Room, SeenBall, is_full, order_b
from robocon_course.robot import SIDE
from robocon_course.simulator.match import Fault
from robocon_course.simulator.referee import MATCH, MUA_VANG, OPPONENTS, Referee, plan
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.match import Play
from robocon_course.worlds.student import Student, generator

PRINTED: tuple[tuple[str, str], ...] = (
    ("start reset", "to area 3"),
    ("to area 3", "first lidar reset"),
    ("first lidar reset", "push balls"),
    ("push balls", "reverse reset"),
    ("reverse reset", "reverse after push"),
    ("detect ball", "ball reset"),
    ("ball reset", "take ball"),
    ("take ball", "silo reset"),
    ("silo reset", "search silo"),
    ("search silo", "approach reset"),
    ("approach reset", "approach silo 3"),
    ("approach silo 3", "silo full"),
    ("silo full", "approach silo"),
    ("odometry reset after silo", "back to storage"),
    ("back to storage", "ball reset"),
    ("stuck", "ball reset"),
)
"""The jumps of the printed mission, from case to case, in English words.

Source: listing "Pelaksanaan Misi Robot Secara Otomatis", thesis on a swerve robot, Yogyakarta State
University, 2024."""
PRINTED_CASES: tuple[str, ...] = tuple(source for source, _ in PRINTED)
"""States for which the listing has a case."""


STORAGE = Room(0.3, 4.9, 8.2, 11.8, SIDE)
"""Where balls are taken."""


def own_listing(student: Student = 0) -> tuple[tuple[str, str], ...]:
    """The printed jumps with the first mend: after "reverse" balls are looked for; shuffled.

    Parameters
    ----------
    student : int or str
        In each student's copy another jump is missing.

    Returns
    -------
    tuple of (source, target)
    """
    rng = generator(student, "mission listing")
    mended = [row for row in PRINTED if row[1] not in ("reverse after push", "approach silo")]
    mended += [("reverse reset", "detect ball"), ("silo full", "odometry reset after silo")]
    cut = CUTS[int(rng.integers(len(CUTS)))]
    rows = [row for row in mended if row[0] != cut]
    return tuple(rows[k] for k in rng.permutation(len(rows)))


CUTS = ("take ball", "silo reset", "search silo", "approach reset")
"""One of these states has no way out in a student's copy of the listing."""


def some_board(rng: np.random.Generator, most: int = 9) -> tuple[str, ...]:
    """What five silos may hold in the middle of a match.

    Parameters
    ----------
    rng : numpy.random.Generator
    most : int
        Balls at most; how many is drawn.

    Returns
    -------
    tuple of 5 str
        From bottom to top.
    """
    fillings = [""] * len(SILOS)
    for _ in range(int(rng.integers(1, most + 1))):
        k = int(rng.integers(len(SILOS)))
        if len(fillings[k]) < SILO_CAPACITY:
            fillings[k] += "RB"[int(rng.integers(2))]
    return tuple(fillings)


def some_balls(rng: np.random.Generator, count: int = 8) -> list[SeenBall]:
    """Balls in Area 3, none upon another.

    Parameters
    ----------
    rng : numpy.random.Generator
    count : int

    Returns
    -------
    list of SeenBall
    """
    balls: list[SeenBall] = []
    while len(balls) < count:
        x, y = np.round([rng.uniform(0.5, 3.2), rng.uniform(8.5, 11.5)], 3)
        if all(np.hypot(x - b.x, y - b.y) > 1.1 * BALL_DIAMETER for b in balls):
            colour = ("red", "blue", "purple")[int(rng.integers(3))]
            balls.append(SeenBall(float(x), float(y), colour))
    return balls


# --- board games --------------------------------------------------------------------------------


class BoardGame(NamedTuple):
    """When the balls of both teams arrive.

    Attributes
    ----------
    ours : tuple of float  [s]
    theirs : tuple of float  [s]
        Of those that fall in.
    period, spread : float  [s]
        How often theirs come, and how unsure that is.
    every : float  [s]
        How often ours come.
    """

    ours: tuple[float, ...]
    theirs: tuple[float, ...]
    period: float
    spread: float
    every: float = 9.5  # as `EVERY`


class BoardResult(NamedTuple):
    """How a board game ended.

    Attributes
    ----------
    points, their_points : int
    winner, reason : str
        As `Referee` says them.
    ended : float  [s]
    fillings : tuple of str
    choices : tuple of int
        Silos of our balls, 0 to 4.
    """

    points: int
    their_points: int
    winner: str
    reason: str
    ended: float
    fillings: tuple[str, ...]
    choices: tuple[int, ...]


FIRST, EVERY, VARY = 17.0, 9.5, 2.0
"""Our first ball, from one to the next, standard deviation [s]: a quick robot. The course's own
needs about 12 s for a ball."""
BALLS = 12
"""Six from the pile, six that Robot 1 sends."""


def board_game(
    rng: np.random.Generator, opponent: str = "strong", every: float = EVERY
) -> BoardGame:
    """A game to play.

    Parameters
    ----------
    rng : numpy.random.Generator
    opponent : {"weak", "middling", "strong"}
    every : float  [s]
        From one of our balls to the next.

    Returns
    -------
    BoardGame
    """
    if opponent not in OPPONENTS:
        raise CourseError(f"opponent: expected one of {', '.join(OPPONENTS)}, got {opponent!r}")
    other = OPPONENTS[opponent]
    gaps = np.maximum(6.0, every + VARY * rng.standard_normal(BALLS - 1))
    ours = FIRST + np.concatenate([[0.0], np.cumsum(gaps)])
    theirs = [time for time, falls_in in plan(rng, other) if falls_in]
    return BoardGame(
        tuple(float(t) for t in np.round(ours[ours < MATCH], 2)),
        tuple(float(t) for t in np.round(theirs, 2)),
        other.every,
        other.spread,
        every,
    )


def play_board(game: BoardGame, choose: Callable[..., int | None]) -> BoardResult:
    """Play a board game: our balls go where `choose` says, theirs by order B.

    Parameters
    ----------
    game : BoardGame
    choose : callable
        ``choose(fillings, team, y, rhythm)``, as `mission.choose_silo`; we are red.

    Returns
    -------
    BoardResult

    Raises
    ------
    ValueError
        It chose what is no silo.
    """
    referee, choices, y, their_y = Referee("R"), [], 10.0, 10.0
    turns = sorted([(time, 1) for time in game.ours] + [(time, 0) for time in game.theirs])
    for time, own in turns:
        if referee.winner or all(map(is_full, referee.fillings)):
            break
        told = tuple(referee.fillings)
        if own:
            k = _silo(choose(told, "red", y, rhythm_of(game, time)))
            choices.append(k)
        else:
            k = order_b(told, "blue", their_y)
        referee.store(time, "own" if own else "theirs", k)
        y, their_y = (SILOS[k][1], their_y) if own else (y, SILOS[k][1])
    referee.time_is_up(MATCH)
    return BoardResult(
        referee.points["own"], referee.points["theirs"], referee.winner, referee.reason,
        float(referee.ended), tuple(referee.fillings), tuple(choices),
    )  # fmt: skip


def rhythm_of(game: BoardGame, now: float) -> Rhythm:
    """What is known of both teams' rhythm at a time [s] of a game: what has come, no more."""
    before = [time for time in game.theirs if time < now]
    last = before[-1] if before else 24.0 - game.period
    return Rhythm(game.every, round(last + game.period - now, 2), game.period, game.spread)


def board_season(
    choose: Callable[..., int | None], games: Sequence[BoardGame]
) -> list[BoardResult]:
    """Many board games, in their order."""
    return [play_board(game, choose) for game in games]


def _silo(chosen: object) -> int:
    number = isinstance(chosen, int | float | np.number) and not isinstance(chosen, bool)
    if not number or chosen not in range(len(SILOS)):
        said = " ".join(repr(chosen).split())[:40]
        raise ValueError(f"expected the index of a silo, 0 to {len(SILOS) - 1}, got {said}")
    return int(chosen)


class Season(NamedTuple):
    """What a season of board games brought.

    Attributes
    ----------
    mua_vang, won, lost : int
        Games; ``won`` counts those by points alone.
    choices : tuple of int
        Of all games, one after the other.
    """

    mua_vang: int
    won: int
    lost: int
    choices: tuple[int, ...]

    @property
    def score(self) -> float:
        """One for Mua Vang, a half for a game won by points."""
        return self.mua_vang + 0.5 * self.won


def tally(results: Sequence[BoardResult]) -> Season:
    """Count games.

    Parameters
    ----------
    results : sequence of BoardResult

    Returns
    -------
    Season
    """
    best = [one.winner == "own" and one.reason == MUA_VANG for one in results]
    won = sum(one.winner == "own" for one in results) - sum(best)
    lost = sum(one.winner == "theirs" for one in results)
    return Season(sum(best), won, lost, tuple(k for one in results for k in one.choices))


# --- matches that are cut short -----------------------------------------------------------------


class Opening(NamedTuple):
    """The first balls of a match.

    Attributes
    ----------
    ended : float  [s]
        When the last of them was stored, or the time was up.
    stored : int
    history : tuple of (float, str, str)
        Time [s], state and reason of each change of state.
    events : tuple
        What the referee wrote down of the own team.
    """

    ended: float
    stored: int
    history: tuple[tuple[float, str, str], ...]
    events: tuple


def opening(
    student: Student = 0,
    seed: int = 0,
    *,
    balls: int = 3,
    faults: Sequence[Fault] = (),
    parts: Parts = REFERENCE,
) -> Opening:
    """Play a match until so many balls are stored: to see what a fault costs.

    Parameters
    ----------
    student : int or str
    seed : int
    balls : int
    faults : sequence of Fault
    parts : Parts

    Returns
    -------
    Opening
    """
    play = Play(student, parts, seed, faults=faults)
    play.start()
    match, began = play.match, play.match.robot.time
    while not match.over and match.referee.count("stored") < balls:
        play.tick()
    steps = [(float(s.time - began), str(s.target), s.reason) for s in play.pilot.history.steps]
    own = tuple(event for event in match.referee.events if event.team == "own")
    return Opening(float(match.clock), match.referee.count("stored"), tuple(steps), own)
