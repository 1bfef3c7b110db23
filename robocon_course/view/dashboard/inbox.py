"""What was heard on the bus, kept until it is drawn: a listener stores, and nothing else."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Any, NamedTuple

from robocon_course.robot import Bus
from robocon_course.vision.classes import classes_of

OWN = ("/operator", "/cmd_vel")
"""Topics on which operators speak, not robots."""
CLOCKS = ("/observation", "/odom", "/ground_truth")
"""Topics that tell the robot's time; elsewhere it may be that of an older picture."""
LOST = 1.0
"""So long may a robot be silent [s, wall]."""
LINES = 200
"""So many lines the event log keeps."""
TRAIL = 800
"""So many points of the driven path are kept."""
SPACING = 0.04
"""Distance between two of them [m]."""
JUMP = 0.6
"""A longer step is no driving: the robot was carried, or the pose was measured anew [m]."""
ARRIVED = 0.2
"""Nearer than this to its end, the planned way is done [m]. Source: swerve robot of Yogyakarta
State University, 2024."""


AGAIN = 0.05
"""The same words so soon after are one event [s]."""


class Entry(NamedTuple):
    """A line of the event log.

    Attributes
    ----------
    time : float  [s]
    level : str
    text : str
    """

    time: float
    level: str
    text: str


class Inbox:
    """Listens to everything on a bus and keeps what a screen wants to know.

    Parameters
    ----------
    bus : Bus
        What was told on it before is taken over, but counts as no sign of life.
    clock : callable
        Wall time [s].

    Attributes
    ----------
    latest : dict
        The last message of each topic.
    entries : deque of Entry
        The event log, newest last.
    states : deque of messages.State
        The mission's changes, newest last.
    trail : deque of (x, y)  [m, map]
        Where the robot believed to be, some centimetres apart.
    ticks : deque of (time, ticks)
        The dead wheels of the last half second.
    found : dict of kind to messages.Detection2DArray
        The last of each network.
    counts : dict
        How many warnings and errors there were.
    reached : bool
        Whether the robot has come to the end of its planned way.
    running : bool
        Whether somebody pressed start, and neither stop nor the end of the match came since.
    manual : bool
        Whether an operator took over; a stop, and a crew that sets the robot up, end it.
    set_up : messages.Button or None
        What the crew told last when it set the robot up: its team stands first.
    side : str
        The half of the field that was told last, by whomever.
    """

    def __init__(self, bus: Bus, clock: Callable[[], float]) -> None:
        self._clock = clock
        self.latest: dict[str, Any] = {}
        self.entries: deque[Entry] = deque(maxlen=LINES)
        self.states: deque[Any] = deque(maxlen=LINES)
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL)
        self.ticks: deque[tuple[float, Any]] = deque(maxlen=50)
        self.found: dict[str, Any] = {}
        self.counts = {"warning": 0, "error": 0}
        self.reached = self.running = self.manual = False
        self.set_up: Any = None
        self.side = "left"
        self._heard: float | None = None
        self._now = 0.0
        self._complained: set[str] = set()
        self._keepers: dict[str, Callable[[Any], None]] = {
            "/observation": self._observation,
            "/odom": self._odom,
            "/plan": self._plan,
            "/camera/detections": self._detections,
            "/rosout": self._log,
            "/mission/state": self._state,
            "/operator": self._button,
            "/score": self._score,
        }
        for topic, message in list(bus.latest.items()):
            if topic not in OWN:
                self._take(topic, message)
        last = bus.latest.get("/operator")
        if getattr(last, "name", "") == "set_up":
            self.set_up = last
        self._bus = bus
        self._said: Any = None
        self._stop = bus.subscribe("*", self.hear)

    def hear(self, topic: str, message: Any) -> None:
        """Store a message; one that cannot be understood becomes a line of the log."""
        if message is self._said:
            return
        if topic not in OWN:
            self._heard = self._clock()
        self._take(topic, message)

    def tell(self, topic: str, message: Any) -> None:
        """Store a message and tell it: what it causes comes after it in the log."""
        self._take(topic, message)
        self._said = message
        self._bus.publish(topic, message)

    def silence(self) -> float | None:
        """How long no robot has spoken [s, wall]; None if none ever did."""
        return None if self._heard is None else self._clock() - self._heard

    def connected(self) -> bool:
        """Whether a robot spoke within the last second."""
        silence = self.silence()
        return silence is not None and silence <= LOST

    def now(self) -> float:
        """The robot's clock, as far as it is known [s]."""
        return self._now

    def note(self, level: str, text: str) -> None:
        """Write a line of the screen's own into the log."""
        self._enter(Entry(self._now, level, text))

    def inherit(self, other: Inbox) -> None:
        """Go on where another screen on this bus ends: its log, its path, whether a match runs."""
        self.entries, self.states = other.entries.copy(), other.states.copy()
        self.trail, self.counts = other.trail.copy(), dict(other.counts)
        self.running, self.reached, self._now = other.running, other.reached, other.now()
        self.set_up, self.side = other.set_up, other.side

    def close(self) -> None:
        """Listen no longer."""
        self._stop()

    def _take(self, topic: str, message: Any) -> None:
        try:
            if topic in CLOCKS:
                self._tell_time(float(message.time))
            keep = self._keepers.get(topic)
            if keep is not None:
                keep(message)
            self.latest[topic] = message
        except Exception as error:  # what comes from outside may be anything
            if topic not in self._complained:
                self._complained.add(topic)
                self.note("error", f"{topic} cannot be read: {type(error).__name__}: {error}")

    def _tell_time(self, time: float) -> None:
        if not math.isfinite(time):
            return
        if time < self._now - 1.0:  # a log that begins again, or a robot that was switched on
            self.trail.clear()
            self.ticks.clear()
            self._now = time
        self._now = max(self._now, time)

    def _observation(self, message: Any) -> None:
        self.ticks.append((float(message.time), message.ticks))

    def _odom(self, message: Any) -> None:
        x, y, _ = map(float, message.pose)
        if not (math.isfinite(x) and math.isfinite(y)):
            return
        if not self.trail or math.dist(self.trail[-1], (x, y)) >= SPACING:
            self.trail.append((x, y))
        plan = self.latest.get("/plan")
        if plan is not None and not self.reached and len(plan.xy):
            self.reached = math.dist(plan.xy[-1], (x, y)) < ARRIVED

    def _plan(self, message: Any) -> None:
        len(message.xy)
        self.reached = False

    def _detections(self, message: Any) -> None:
        classes_of(message.kind)
        if not len(message.boxes) == len(message.scores) == len(message.labels):
            raise ValueError("boxes, scores and labels are not equally many")
        self.found[message.kind] = message

    def _log(self, message: Any) -> None:
        self._enter(Entry(float(message.time), str(message.level), str(message.text)))

    def _enter(self, entry: Entry) -> None:
        if self.entries and entry.level.lower() not in self.counts:
            before = self.entries[-1]
            if entry.text == before.text and abs(entry.time - before.time) < AGAIN:
                return  # a change of state is told on two topics, a button by both its ends
        self.entries.append(entry)
        for level in self.counts:
            if entry.level.lower() == level:
                self.counts[level] += 1

    def _state(self, message: Any) -> None:
        if self.states and self.states[-1] == message:
            return
        name, reason = str(message.name), str(message.reason)
        self.states.append(message)
        self._enter(Entry(float(message.time), "state", f"{name}: {reason}" if reason else name))

    def _button(self, message: Any) -> None:
        name, value = str(message.name), message.value
        if name in ("pan", "tilt"):  # a slider on its way would fill the log
            return
        if name in ("start", "stop"):
            self.running = name == "start"
        if name in ("manual", "stop", "set_up"):
            self.manual = name == "manual" and value in ("on", 1.0)
        if name == "set_up":  # what follows the team is for the autopilot
            self.set_up, value = message, str(value).partition(" ")[0]
        if name == "side":
            self.side = str(value)
        if name == "start":
            self.trail.clear()
        if name == "placed":  # where, is for a recording
            value = ""
        self.note("operator", f"{name} {value}".strip())

    def _score(self, message: Any) -> None:
        if message.winner:
            self.running = False
