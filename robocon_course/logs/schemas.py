"""Schemas of the course's own messages, for which Foxglove has none."""

from __future__ import annotations

from robocon_course.robot.forms import COMMAND, OBSERVATION, many, number, own, whole, words

SILOS = own(
    "Silos",
    "What the five silos are believed to hold",
    {
        "time": number("[s]"),
        "fillings": many({"type": "string"}, "from silo 1 to 5, each from bottom to top"),
    },
)
STATE = own(
    "State",
    "What the mission does now",
    {"time": number("[s]"), "name": words("the state"), "reason": words("why it went there")},
)
SCORE = own(
    "Score",
    "How the match stands",
    {
        "time": number("[s]"),
        "own": whole("points"),
        "theirs": whole("points"),
        "left": number("until the end [s]"),
        "winner": words("own, theirs, nobody; empty while it is played"),
        "reason": words("why it ended"),
    },
)
TWIST = own(
    "Twist",
    "Where the operator's stick points",
    {"vx": number("[m/s]"), "vy": number("[m/s]"), "omega": number("[rad/s]")},
)
BUTTON = own(
    "Button",
    "A button of the operator's screen",
    {
        "name": words("which"),
        "text": words("what was chosen, if it is a word"),
        "number": number("what was chosen, if it is a number"),
    },
    ("text",),
)

__all__ = ["BUTTON", "COMMAND", "OBSERVATION", "SCORE", "SILOS", "STATE", "TWIST"]
