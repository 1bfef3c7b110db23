"""A recorded match, fed back through the autopilot: does it do the same again?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from robocon_course._arrays import CourseError
from robocon_course.autopilot import Autopilot, Parts
from robocon_course.logs import Replay
from robocon_course.robot.messages import Button
from robocon_course.worlds.by_hand import ByHand
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.match import new_pilot
from robocon_course.worlds.student import Student

TICKS = 18_500
"""Of a whole match and the rest before it."""

CREW = ("start", "placed")
"""Buttons of which the crew's own carry numbers."""


@dataclass(frozen=True)
class Replayed:
    """What came out of a replayed log.

    Attributes
    ----------
    commands : int
        How many were compared.
    different : int
        How many were not the same to the bit.
    first : float or None  [s]
        When the first of them was.
    states : tuple of (float, str)
        Time [s] and state, each time it changed.
    trouble : str
        Empty; else why the log ends before its end.
    """

    commands: int
    different: int
    first: float | None
    states: tuple[tuple[float, str], ...]
    trouble: str = ""

    @property
    def same(self) -> bool:
        """Whether every command is the one in the log."""
        return self.commands > 0 and self.different == 0

    @property
    def lines(self) -> tuple[str, ...]:
        """The result in words."""
        told = [f"{time:8.2f} s  {state}" for time, state in self.states]
        told += [f"– {self.trouble}"] if self.trouble else []
        if self.same:
            return (*told, f"✔ all {self.commands} commands are those of the log")
        when = "" if self.first is None else f", the first at {self.first:.2f} s"
        return (*told, f"✘ {self.different} of {self.commands} commands are others{when}")


def replay_log(
    path: str | Path,
    student: Student = 0,
    parts: Parts = REFERENCE,
    *,
    on_time: Callable[[float], object] = lambda share: None,
) -> Replayed:
    """Feed the observations of a log to a new autopilot.

    Parameters
    ----------
    path : path
        As `robocon match --record` writes it.
    student : int or str
        Whose robot it was.
    parts : Parts
        Others than those that played decide otherwise: where, the result tells.
    on_time : callable
        Told now and then which share of the log has passed.

    Returns
    -------
    Replayed

    Raises
    ------
    CourseError
        No log, or one without observations or without the robot's set-up.
    """
    log, pilot, by_hand, states = Replay(path), None, ByHand(), []
    while not log.ended:
        seen = log.read()
        for topic, message in log.heard:
            if topic == "/cmd_vel":
                by_hand.steer(topic, message)
            elif topic == "/operator":
                pilot = _press(pilot, by_hand, message, lambda at: new_pilot(parts, student, at))
        if pilot is None:
            raise CourseError(f"{path}: the log does not hold how the robot was set up")
        command = pilot.tick(seen)
        if by_hand.on:
            command = by_hand.command(parts, seen)
        if log.expected is not None:
            log.apply(command)
        if not states or pilot.state != states[-1][1]:
            states.append((float(seen.time), str(pilot.state)))
        if log.applied % 500 == 0:
            on_time(min(1.0, log.applied / TICKS))
    if not log.applied:
        raise CourseError(f"{path}: no observations with commands in it")
    return Replayed(log.applied, log.different, log.first_different, tuple(states), log.trouble)


def _press(
    pilot: Autopilot | None, by_hand: ByHand, button: Button, made: Callable[[str], Autopilot]
) -> Autopilot | None:
    """What the crew and the operator did, as it stands in the log; who plays from then on."""
    try:
        by_hand.press(button)
        told = [float(word) for word in str(button.value).split()] if button.name in CREW else []
    except ValueError:  # in the match, too, it changed nothing
        return pilot
    if button.name == "set_up":
        return made(str(button.value))
    if pilot is None:
        return None
    if button.name == "start":
        pilot.start(*told)
    elif button.name == "stop":
        pilot.stop()
    elif button.name == "placed":
        pilot.restart(told[:3], *told[3:])
    return pilot
