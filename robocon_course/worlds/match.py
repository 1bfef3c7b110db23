"""A match: one student's robot, set up by its crew, plays three minutes by itself.

Before it starts its dead wheels were calibrated, as for every drive, and the crew turned it by
quarter turns beside the fence, so that each LiDAR's own error is known.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import hypot
from typing import TYPE_CHECKING, Any

import numpy as np

from robocon_course._arrays import FloatArray, freeze_arrays
from robocon_course.autopilot import (
    Autopilot,
    Parts,
    Telemetry,
    measured_offsets,
    module_command,
)
from robocon_course.field import MATCH_LENGTH
from robocon_course.mission import STRATEGIES, State
from robocon_course.robot import Bus, Command, Observation
from robocon_course.robot.messages import Button, Log, PoseStamped, Score, Twist
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.imu import own_imu
from robocon_course.worlds.robot import own_robot
from robocon_course.worlds.student import Student, generator
from robocon_course.worlds.to_area_3 import calibrated_wheels

if TYPE_CHECKING:
    from robocon_course.simulator.match import Fault, Match

REST = 2.0
"""The robot stands so long before the start: the gyroscope's bias is learnt then [s]."""
EVERY = 5
"""Of so many ticks one is kept in the record."""
RESET_STATES = (State.LIDAR_RESET, State.RESET_AFTER_SILO)


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


def new_pilot(parts: Parts, student: Student, setting: str) -> Autopilot:
    """An autopilot as its crew sets it up.

    Parameters
    ----------
    parts : Parts
    student : int or str
    setting : str
        Team, what each of the four LiDARs reads too much [m], and 1 or 0 for the use of LiDARs and
        of the gyroscope, with blanks between: as it stands in a log.

    Returns
    -------
    Autopilot
    """
    team, *numbers, walls, imu = setting.split()
    return Autopilot(
        parts, calibrated_wheels(student, parts), team,
        offsets=[float(number) for number in numbers],
        use_walls=walls == "1", use_imu=imu == "1",
    )  # fmt: skip


class ByHand:
    """What the operator's stick and buttons ask for.

    Attributes
    ----------
    on : bool
        Whether they drive in place of the autopilot.
    """

    def __init__(self) -> None:
        self.on = False
        self._twist = (0.0, 0.0, 0.0)
        self._held: dict[str, float] = {}

    def steer(self, topic: str, twist: Twist) -> None:
        """The stick moved."""
        self._twist = (float(twist.vx), float(twist.vy), float(twist.omega))

    def press(self, button: Button) -> None:
        """A button that is about driving by hand."""
        if button.name == "manual":
            self.on = button.value in ("on", True)
            self._twist, self._held = (0.0, 0.0, 0.0), {}
        elif button.name in ("intake", "pan", "tilt"):
            self._held[button.name] = float(button.value)
        elif button.name == "release":
            self._held["release"] = LETS_GO
            self._held["intake"] = 0.0

    def command(self, parts: Parts, seen: Observation) -> Command:
        """What they ask for, as a command; the stick's axes are the robot's own."""
        order = module_command(parts, self._twist, 0.0, seen.module_angles, dt=CYCLE)
        left = self._held.get("release", 0.0)
        self._held["release"] = max(0.0, left - CYCLE)
        return Command(
            order.speeds, order.angles, self._held.get("intake", 0.0), left > 0.0,
            self._held.get("pan", 0.0), self._held.get("tilt", 0.3), "ball",
        )  # fmt: skip


CYCLE = 0.01
"""Of control [s]."""
LETS_GO = 0.7
"""So long the gripper is told to let go after its button [s]."""


class Play:
    """A match that can be played bit by bit: for screens, logs, and `play_match`.

    Parameters
    ----------
    student : int or str
    parts : Parts
    seed : int
    team, opponent, drawn, faults
        As for `simulator.match.Match`.
    strategy : str, optional
        One of `mission.STRATEGIES`: in place of the part ``choose_silo``.
    bus : Bus, optional
        Told everything, and listened to: ``/operator`` and ``/cmd_vel``.
    walls, imu, set_up : bool
        Without LiDARs; without gyroscope; with LiDARs whose own errors nobody measured.

    Attributes
    ----------
    match : Match
    pilot : Autopilot
    """

    def __init__(
        self,
        student: Student = 0,
        parts: Parts = REFERENCE,
        seed: int = 0,
        *,
        team: str = "red",
        opponent: str | None = "weak",
        drawn: bool = False,
        faults: Sequence[Fault] = (),
        strategy: str | None = None,
        bus: Bus | None = None,
        walls: bool = True,
        imu: bool = True,
        set_up: bool = True,
    ) -> None:
        if strategy is not None:
            parts = replace(parts, choose_silo=STRATEGIES[strategy])
        self.student, self.parts, self.seed, self.bus = student, parts, seed, bus
        self._match = {"opponent": opponent, "drawn": drawn, "faults": faults}
        self._pilot = {"walls": walls, "imu": imu, "set_up": set_up}
        self._by_hand = ByHand()
        if bus is not None:
            bus.subscribe("/operator", self._pressed)
            bus.subscribe("/cmd_vel", self._by_hand.steer)
        self._prepare(team)

    def _prepare(self, team: str) -> None:
        """A new match, until the robot stands at its start and knows its gyroscope."""
        from robocon_course.simulator import SensorModel
        from robocon_course.simulator.match import Match

        student, setting = self.student, self._pilot
        self.match: Match = Match(
            int(generator(student, "match", str(self.seed)).integers(1 << 31)), team=team,
            model=own_robot(student), sensors=SensorModel(imu=own_imu(student)), **self._match,
        )  # fmt: skip
        told = self.match.set_up()
        offsets = measured_offsets(told) if setting["set_up"] else np.zeros(4)
        flags = map(str, (int(setting["walls"]), int(setting["imu"])))
        words = " ".join([team, *map(repr, offsets.tolist()), *flags])
        self.pilot = new_pilot(self.parts, student, words)
        self._telemetry = None if self.bus is None else Telemetry(self.bus, self.pilot)
        self._retries = self._events = 0
        self._by_hand.on = False
        self._tell("set_up", words)
        while self.match.robot.time < REST + SET_UP_TAKES:
            self.tick()

    def start(self) -> None:
        """Start the clock, or go on after a stop: the clock ran on."""
        if self.match.started is None:
            self.match.start()
        if self.pilot.stopped:
            self.pilot.start()
            self._tell("start")

    def tick(self) -> None:
        """One control cycle."""
        match, pilot = self.match, self.pilot
        seen = match.read()
        command = pilot.tick(seen)
        if self._by_hand.on:
            command = self._by_hand.command(self.parts, seen)
        match.apply(command)
        if self._telemetry is not None:
            self._telemetry.tell(seen, command)
            self._tell_score()
        match.step()
        if match.retries != self._retries:
            self._retries = match.retries
            from robocon_course.simulator.referee import RETRY_COSTS

            pilot.restart(match.home, RETRY_COSTS)
            self._tell("placed", " ".join(map(repr, map(float, (*match.home, RETRY_COSTS)))))

    def _pressed(self, topic: str, button: Button) -> None:
        """The operator's buttons."""
        match = self.match
        if button.name == "start" and match.over:
            self.seed += 1
            self._prepare(match.team)
            self.start()
        elif button.name == "start":
            self.start()
        elif button.name == "colour" and match.started is None and button.value != match.team:
            self._prepare(str(button.value))
        elif button.name == "retry" and match.started is not None and not match.over:
            match.retry()
        elif button.name == "stop":
            self.pilot.stop()
            self._by_hand.on = False
        else:
            self._by_hand.press(button)

    def _tell(self, name: str, value: str = "") -> None:
        """What the crew did, for whoever writes it down."""
        if self.bus is not None:
            self.bus.publish("/operator", Button(name, value))

    def _tell_score(self) -> None:
        match, bus, referee = self.match, self.bus, self.match.referee
        now = match.robot.time
        for event in referee.events[self._events :]:
            level = "warning" if event.what in ("foul", "retry", "fault", "lost ball") else "info"
            bus.publish("/rosout", Log(now, level, f"{event.team}: {event.what} {event.detail}"))
        self._events = len(referee.events)
        if round(now * 100) % 10 == 0:
            pose, _ = match.robot.motion
            bus.publish("/ground_truth", PoseStamped(now, pose))
            score = Score(
                now, referee.points["own"], referee.points["theirs"], MATCH_LENGTH - match.clock,
                referee.winner, referee.reason,
            )  # fmt: skip
            bus.publish("/score", score)


SET_UP_TAKES = 4.5
"""The crew turns the robot for so long [s]."""


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
    match, pilot = play.match, play.pilot
    play.start()
    rows, states, errors, resets, history, balls, colours = [], [], 0.0, [], [], [], []
    last, ticks = None, 0
    while not match.over:
        pose, _ = match.robot.motion  # where it is as it reads its sensors
        play.tick()
        off = hypot(pilot.pose[0] - pose[0], pilot.pose[1] - pose[1])
        errors, ticks = errors + off * off, ticks + 1
        if pilot.history.since != last:
            step = pilot.history.steps[-1:] or None
            if step and step[0].source in RESET_STATES and not match.waiting:
                resets.append(off)
            last = pilot.history.since
            history.append((match.clock, str(pilot.state), step[0].reason if step else ""))
        if ticks % EVERY == 0:
            rows.append((match.clock, *pose, *pilot.pose))
            states.append(str(pilot.state))
            if with_balls:
                free = match.balls.free
                balls.append(match.balls.xy[free].copy())
                colours.append(tuple(match.balls.colours[k] for k in free))
        if ticks % 100 == 0:
            on_time(match.clock / MATCH_LENGTH)
    table, referee = np.array(rows), match.referee
    return MatchResult(
        seed=seed, parts=pilot.parts.label, winner=referee.winner, reason=referee.reason,
        ended=float(referee.ended), points=referee.points["own"],
        their_points=referee.points["theirs"], stored=referee.count("stored"),
        fouls=referee.count("foul"), retries=match.retries,
        contacts=match.robot.truth.contacts, fillings=tuple(referee.fillings),
        time=table[:, 0], poses=table[:, 1:4], estimates=table[:, 4:7], states=tuple(states),
        error=float(np.sqrt(errors / ticks)), reset_errors=np.array(resets),
        history=tuple(history), events=tuple(referee.events), rejected=pilot.reckoning.rejected,
        balls=tuple(balls), colours=tuple(colours),
    )  # fmt: skip


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
