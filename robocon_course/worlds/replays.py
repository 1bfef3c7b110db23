"""A recorded match, fed back through the autopilot: does it do the same again?"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robocon_course._arrays import CourseError
from robocon_course.autopilot import Autopilot, Parts
from robocon_course.logs import read_log
from robocon_course.robot import Command, Observation
from robocon_course.worlds.drive import REFERENCE
from robocon_course.worlds.match import new_pilot
from robocon_course.worlds.student import Student


@dataclass(frozen=True)
class Replay:
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
    """

    commands: int
    different: int
    first: float | None
    states: tuple[tuple[float, str], ...]

    @property
    def same(self) -> bool:
        """Whether every command is the one in the log."""
        return self.commands > 0 and self.different == 0

    @property
    def lines(self) -> tuple[str, ...]:
        """The result in words."""
        told = [f"{time:8.2f} s  {state}" for time, state in self.states]
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
) -> Replay:
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
    Replay

    Raises
    ------
    CourseError
        No log, or one without observations or without the robot's set-up.
    """
    pilot: Autopilot | None = None
    commands = different = 0
    first, states, ours, last, by_hand = None, [], None, None, False
    for topic, message in read_log(path):
        if topic == "/operator" and message.name == "set_up":
            pilot = new_pilot(parts, student, message.value)
        elif topic == "/operator" and message.name == "manual":
            by_hand = message.value == "on"
        elif topic == "/operator" and pilot is not None:
            _press(pilot, message)
        elif topic == "/observation" and isinstance(message, Observation):
            if pilot is None:
                raise CourseError(f"{path}: the log does not hold how the robot was set up")
            ours = pilot.tick(message)
            if pilot.state != last:
                last = pilot.state
                states.append((float(message.time), str(last)))
            if commands % 500 == 0:
                on_time(min(1.0, commands / 18_500))
        elif topic == "/command" and ours is not None and not by_hand:
            commands += 1
            if not _equal(ours, message):
                different += 1
                first = pilot.now if first is None else first
    if not commands:
        raise CourseError(f"{path}: no observations with commands in it")
    return Replay(commands, different, first, tuple(states))


def _press(pilot: Autopilot, button: object) -> None:
    """What the crew did, as it stands in the log."""
    if button.name == "start":
        pilot.start()
    elif button.name == "stop":
        pilot.stop()
    elif button.name == "placed":
        *pose, after = (float(number) for number in str(button.value).split())
        pilot.restart(pose, after)


def _equal(ours: Command, told: Command) -> bool:
    return (
        np.array_equal(ours.speeds, told.speeds)
        and np.array_equal(ours.angles, told.angles)
        and (ours.intake, ours.release, ours.watch) == (told.intake, told.release, told.watch)
        and (ours.pan, ours.tilt) == (told.pan, told.tilt)
    )
