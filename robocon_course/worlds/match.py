"""A match: one student's robot, set up by its crew, plays three minutes by itself.

Before it starts its dead wheels were calibrated, as for every drive, and the crew turned it by
quarter turns beside the fence, so that each LiDAR's own error is known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from robocon_course._arrays import CourseError, as_floats
from robocon_course.autopilot import Autopilot, Parts, Telemetry, measured_offsets
from robocon_course.field import MATCH_LENGTH, SEEDLINGS
from robocon_course.mission import LETTERS, STRATEGIES
from robocon_course.robot import LIDARS, Bus
from robocon_course.robot.messages import Button, Log, PoseStamped, Score
from robocon_course.worlds.by_hand import ByHand
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.imu import own_imu
from robocon_course.worlds.robot import own_robot
from robocon_course.worlds.student import Student, generator
from robocon_course.worlds.to_area_3 import calibrated_wheels

if TYPE_CHECKING:
    from robocon_course.simulator.match import Fault, Match

REST = 2.0
"""The robot stands so long before the start: the gyroscope's bias is learnt then [s]."""
HALF = "left"
"""Of the field: where the map's x is below 6 m."""
SET_UP_TAKES = 4.5
"""The crew turns the robot for so long [s]."""


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

    Raises
    ------
    CourseError
        A setting that is none.
    """
    try:
        team, *numbers, walls, imu = setting.split()
        offsets = as_floats([float(number) for number in numbers], "offsets", len(LIDARS))
    except (AttributeError, ValueError):
        raise CourseError(
            f"setting: expected a team, {len(LIDARS)} numbers and two flags, got {setting!r:.80}"
        ) from None
    return Autopilot(
        parts, calibrated_wheels(student, parts), team, offsets=offsets,
        use_walls=walls == "1", use_imu=imu == "1",
    )  # fmt: skip


class Play:
    """A match that can be played bit by bit: for screens, logs, and `play_match`.

    Parameters
    ----------
    student : int or str
    parts : Parts
    seed : int
    team, opponent, drawn, faults, sent
        As for `simulator.match.Match`.
    strategy : str, optional
        One of `mission.STRATEGIES`: in place of the part ``choose_silo``.
    bus : Bus, optional
        Told everything, and listened to: ``/operator`` and ``/cmd_vel``.
    walls, imu, set_up : bool
        False: without LiDARs; without gyroscope; with LiDARs whose own errors nobody measured.

    Attributes
    ----------
    match : Match
    pilot : Autopilot

    Raises
    ------
    CourseError
        Another strategy, team, opponent or fault.
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
        sent: int = SEEDLINGS,
        strategy: str | None = None,
        bus: Bus | None = None,
        walls: bool = True,
        imu: bool = True,
        set_up: bool = True,
    ) -> None:
        if strategy is not None:
            if strategy not in STRATEGIES:
                known = ", ".join(STRATEGIES)
                raise CourseError(f"strategy: expected one of {known}, got {strategy!r}")
            parts = replace(parts, choose_silo=STRATEGIES[strategy])
        self.student, self.parts, self.seed, self.bus = student, parts, seed, bus
        self._team = team
        self._match = {"opponent": opponent, "drawn": drawn, "faults": faults, "sent": sent}
        self._pilot = {"walls": walls, "imu": imu, "set_up": set_up}
        self._by_hand = ByHand()
        self._prepare()
        if bus is not None:
            bus.subscribe("/operator", self._pressed)
            bus.subscribe("/cmd_vel", self._by_hand.steer)

    def _prepare(self) -> None:
        """A new match, until the robot stands at its start and knows its gyroscope."""
        from robocon_course.simulator import SensorModel
        from robocon_course.simulator.match import Match

        student, team, setting = self.student, self._team, self._pilot
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
            after = self.match.wait_left  # of a retry: who drives against it takes itself for stuck
            self.pilot.start(after)
            self._tell("start", repr(after) if after else "")

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
            self._tell_events()
            if round(match.robot.time * 100) % 10 == 0:
                self._tell_score()
        over = match.over
        match.step()
        if match.over and not over and self._telemetry is not None:
            self._tell_events()  # whoever plays stops here: nothing else would tell the end
            self._tell_score()
        if match.retries != self._retries:
            self._retries = match.retries
            self._place()

    def _place(self) -> None:
        """The crew has put the robot down; one that was stopped goes on waiting for "start"."""
        from robocon_course.simulator.referee import RETRY_COSTS

        home, stopped = self.match.home, self.pilot.stopped
        self.pilot.restart(home, RETRY_COSTS)
        self._tell("placed", " ".join(map(repr, map(float, (*home, RETRY_COSTS)))))
        if stopped:
            self.pilot.stop()
            self._tell("stop")

    def _pressed(self, topic: str, button: Button) -> None:
        """The operator's buttons; one that means nothing here is told, and changes nothing."""
        try:
            self._do(str(button.name), button)
        except Exception as error:  # a listener that raises is dropped: "stop" must work on
            kind = "" if isinstance(error, CourseError) else f"{type(error).__name__}: "
            line = f"a button that means nothing here: {kind}{error}"
            self.bus.publish("/rosout", Log(self.match.robot.time, "warning", line))

    def _do(self, name: str, button: Button) -> None:
        match = self.match
        if name == "start" and match.over:
            self.seed += 1
            self._prepare()
            self.start()
        elif name == "start":
            self.start()
        elif name == "colour":
            self._choose_team(str(button.value))
        elif name == "side":
            self._refuse_side(button.value)
        elif name == "retry" and match.started is not None and not match.over:
            match.retry()
        else:
            if name == "stop":
                self.pilot.stop()
            self._by_hand.press(button)

    def _choose_team(self, team: str) -> None:
        """Before a match: of this one. Later: of the next."""
        if team not in LETTERS:
            raise CourseError(f"colour: expected one of {', '.join(LETTERS)}, got {team!r}")
        before, self._team = self._team, team
        if self.match.started is None and team != before:
            self._prepare()

    def _refuse_side(self, side: str | float) -> None:
        """Told back to the screen, that it shows no half in which nobody plays."""
        if side != HALF:
            self._tell("side", HALF)
            raise CourseError(
                f"side: this field's robot plays in its {HALF} half, got {side!r}; "
                "only a robot on the link may know the other one"
            )

    def _tell(self, name: str, value: str = "") -> None:
        """What the crew did, for whoever writes it down."""
        if self.bus is not None:
            self.bus.publish("/operator", Button(name, value))

    def _tell_events(self) -> None:
        """What the referee saw since it was told last."""
        events, now = self.match.referee.events, self.match.robot.time
        for event in events[self._events :]:
            bad = event.team == "own" and event.what in ("foul", "retry", "fault", "lost ball")
            text = f"{event.team}: {event.what} {event.detail}".rstrip()
            self.bus.publish("/rosout", Log(now, "warning" if bad else "info", text))
        self._events = len(events)

    def _tell_score(self) -> None:
        """How the match stands, and where the robot is indeed."""
        match, referee, now = self.match, self.match.referee, self.match.robot.time
        pose, _ = match.robot.motion
        self.bus.publish("/ground_truth", PoseStamped(now, pose))
        left = MATCH_LENGTH - min(match.clock, referee.ended)
        points = referee.points["own"], referee.points["theirs"]
        self.bus.publish("/score", Score(now, *points, left, referee.winner, referee.reason))
