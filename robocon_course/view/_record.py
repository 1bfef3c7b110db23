"""What the record of a match says at a moment: silos, points, the gripper, what was last seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robocon_course.mission import owner
from robocon_course.simulator.referee import SEEDLING, STORED, TRANSFER
from robocon_course.worlds.match_result import stored_in

if TYPE_CHECKING:
    from robocon_course.worlds import MatchResult

WORTH = {"stored": STORED, "transfer": TRANSFER, "seedling": SEEDLING}
EMPTIES = ("stored", "lost ball", "foul", "retry")
"""After one of these the own gripper holds nothing."""
TEAMS = {"R": "red", "B": "blue"}
DOING = {
    "reset": "waits until it may start",
    "go_to_area_3": "drives to Area 3",
    "lidar_reset": "measures its pose at the walls",
    "detect_ball": "looks at the balls",
    "search_ball": "looks for a ball of its own",
    "push_ball_pile": "pushes the balls apart",
    "reverse": "backs away from the balls",
    "take_ball": "takes a ball",
    "search_silo": "looks at the silos",
    "approach_silo": "carries the ball to a silo",
    "silo_full": "the silo is full, looks again",
    "reset_odometry_from_lidar": "measures its pose at the walls",
    "back_to_storage": "drives back to the balls",
    "stuck": "is stuck, frees itself",
    "no_sensors": "stands, as no sensor answers",
    "finished": "has finished",
}
"""States of the mission in words."""


def own_letter(result: MatchResult) -> str:
    """Of the own team's balls, R or B: a silo's last letter is that of who stored.

    A match in which nobody stored tells it by the balls; one without those is a red team's.
    """
    for event in result.events:
        if event.what == "stored":
            last = event.detail[-1]
            return last if event.team == "own" else "RB".replace(last, "")
    return "B" if any("blue" in row for row in result.colours[:1]) else "R"


def in_words(state: str) -> str:
    """What the robot does in a state; a state of another mission keeps its name."""
    return DOING.get(state, state.replace("_", " "))


def counts_for(filling: str) -> str:
    """For whose Mua Vang a silo counts: R, B or nothing.

    It counts for the team whose ball is on top of the full silo, with two of that team or more.
    """
    return owner(filling) or ""


def points_at(result: MatchResult, now: float) -> tuple[int, int]:
    """Own points and theirs at a time [s]."""
    points = {"own": 0, "theirs": 0}
    for event in result.events:
        if event.time <= now:
            points[event.team] += WORTH.get(event.what, 0)
    return points["own"], points["theirs"]


def holding(result: MatchResult) -> NDArray[np.bool_]:
    """Whether the gripper held a ball, for each row of the record.

    A ball that falls or is put down on the floor is no event: it is seen by one more ball there
    than since the taking, those that Robot 1 sent apart.
    """
    own = [event for event in result.events if event.team == "own"]
    sent = np.array([event.time for event in own if event.what == "transfer"])
    floor = np.array([len(row) for row in result.colours]) - np.searchsorted(
        sent, result.time, side="right"
    )
    held = np.zeros(len(result.time), bool)
    marks = [event for event in own if event.what in ("taken", *EMPTIES)]
    ends = [event.time for event in marks[1:]] + [np.inf]
    for event, end in zip(marks, ends, strict=True):
        if event.what == "taken":
            first, last = np.searchsorted(result.time, (event.time, end))
            held[first:last] = np.logical_and.accumulate(floor[first:last] <= floor[first])
    return held


def last_seen(result: MatchResult, now: float, since: float) -> str:
    """The last thing worth telling between two times [s], or nothing."""
    told = ""
    for event in result.events:
        if since < event.time <= now:
            told = _told(event.what, event.team, event.detail) or told
    return told


def _told(what: str, team: str, detail: str) -> str:
    who = "own" if team == "own" else "their"
    if what == "stored":
        return f"{who} ball in silo {stored_in(detail)[0] + 1}: +{STORED}"
    if what in ("lost ball", "foul", "retry"):
        return f"{who} {what}"
    return f"fault: {detail}" if what == "fault" else ""
