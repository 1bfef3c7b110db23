"""Whole matches, one or many, and the record of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from math import hypot
from typing import Any

import numpy as np

from robocon_course.autopilot import Parts
from robocon_course.field import MATCH_LENGTH
from robocon_course.mission import State
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.match import Play
from robocon_course.worlds.match_result import MatchResult
from robocon_course.worlds.student import Student

EVERY = 5
"""Of so many ticks one is kept in the record."""
RESET_STATES = (State.LIDAR_RESET, State.RESET_AFTER_SILO)


class _Record:
    """What is kept of a match while it is played."""

    def __init__(self, play: Play, with_balls: bool) -> None:
        self.play, self.with_balls = play, with_balls
        self.rows: list[tuple[float, ...]] = []
        self.states: list[str] = []
        self.history: list[tuple[float, str, str]] = []
        self.resets: list[float] = []
        self.balls: list[np.ndarray] = []
        self.colours: list[tuple[str, ...]] = []
        self.squares, self.ticks, self._since = 0.0, 0, None

    def tick(self) -> None:
        """Let the match go on by one cycle, and note it."""
        match, pilot = self.play.match, self.play.pilot
        pose, _ = match.robot.motion  # where it is as it reads its sensors
        self.play.tick()
        off = hypot(pilot.pose[0] - pose[0], pilot.pose[1] - pose[1])
        self.squares, self.ticks = self.squares + off * off, self.ticks + 1
        if pilot.history.since != self._since:
            self._since = pilot.history.since
            self._note_state(off)
        if self.ticks % EVERY == 0:
            self.rows.append((match.clock, *pose, *pilot.pose))
            self.states.append(str(pilot.state))
            if self.with_balls:
                free = match.balls.free
                self.balls.append(match.balls.xy[free].copy())
                self.colours.append(tuple(match.balls.colours[k] for k in free))

    def _note_state(self, off: float) -> None:
        """The mission is in another state; how far off the pose is where it was just measured."""
        match, pilot = self.play.match, self.play.pilot
        step = pilot.history.steps[-1] if pilot.history.steps else None
        if step is not None and step.source in RESET_STATES and not match.waiting:
            self.resets.append(off)
        reason = "" if step is None else step.reason
        self.history.append((match.clock, str(pilot.state), reason))

    def result(self, seed: int) -> MatchResult:
        """All of it."""
        match, pilot, referee = self.play.match, self.play.pilot, self.play.match.referee
        table = np.array(self.rows)
        return MatchResult(
            seed=seed, parts=pilot.parts.label, winner=referee.winner, reason=referee.reason,
            ended=float(referee.ended), points=referee.points["own"],
            their_points=referee.points["theirs"], stored=referee.count("stored"),
            fouls=referee.count("foul"), retries=match.retries,
            contacts=match.robot.truth.contacts, fillings=tuple(referee.fillings),
            time=table[:, 0], poses=table[:, 1:4], estimates=table[:, 4:7],
            states=tuple(self.states), error=float(np.sqrt(self.squares / self.ticks)),
            reset_errors=np.array(self.resets), history=tuple(self.history),
            events=tuple(referee.events), rejected=pilot.reckoning.rejected,
            balls=tuple(self.balls), colours=tuple(self.colours),
        )  # fmt: skip


def play_match(
    student: Student = 0,
    parts: Parts = REFERENCE,
    seed: int = 0,
    *,
    on_time: Callable[[float], object] = lambda share: None,
    with_balls: bool = False,
    **settings: Any,
) -> MatchResult:
    """One match, from the start to the end.

    Parameters
    ----------
    student : int or str
        Whose robot it is: another one has other sizes and sensors.
    parts : Parts
    seed : int
        Of pile, other team and noise.
    on_time : callable
        Told now and then which share of the match has passed.
    with_balls : bool
        Keep where the balls lay, for an animation.
    **settings
        As for `Play`.

    Returns
    -------
    MatchResult
    """
    play = Play(student, parts, seed, **settings)
    record = _Record(play, with_balls)
    play.start()
    while not play.match.over:
        record.tick()
        if record.ticks % 100 == 0:
            on_time(play.match.clock / MATCH_LENGTH)
    return record.result(seed)


def season(
    seeds: Iterable[int],
    student: Student = 0,
    parts: Parts | Callable[[], Parts] = REFERENCE,
    *,
    run: Callable[[Callable, list], Iterable] = map,
    on_match: Callable[[MatchResult], object] = lambda result: None,
    **settings: Any,
) -> list[MatchResult]:
    """Many matches.

    Parameters
    ----------
    seeds : iterable of int
    student : int or str
    parts : Parts, or callable that gives them
        A student's own functions cannot travel to other processes: there they are loaded again.
    run : callable
        Maps a function over a list: `map`, an executor's, or a Dask cluster's. The results do not
        depend on it.
    on_match : callable
        Told of each match as it ends.
    **settings
        As for `Play`.

    Returns
    -------
    list of MatchResult
        In the order of the seeds.
    """
    results = []
    for result in run(partial(_one, student, parts, settings), list(seeds)):
        on_match(result)
        results.append(result)
    return results


def _one(
    student: Student, parts: Parts | Callable[[], Parts], settings: dict, seed: int
) -> MatchResult:
    known = parts if isinstance(parts, Parts) else parts()
    return play_match(student, known, seed, **settings)
