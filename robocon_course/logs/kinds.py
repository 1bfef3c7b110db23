"""Every kind of message that a log keeps: how it is written, and how it is read back."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from robocon_course.logs import drawn, schemas
from robocon_course.logs.drawn import Piece
from robocon_course.robot import Command, Observation, codec, messages
from robocon_course.robot.forms import Form
from robocon_course.robot.text import Tree, field, number


class Kind(NamedTuple):
    """One kind of message.

    Attributes
    ----------
    write : callable
        Topic and message to pieces.
    read : callable
        The objects of a message's pieces to the message.
    rate : float  [Hz]
        More often than this it is not kept; 0: each one is.
    several : bool
        Whether it takes several pieces: the last one of a file that is cut off may lack some.
    """

    write: Callable[[str, Any], list[Piece]]
    read: Callable[[Sequence[Tree]], Any]
    rate: float = 0.0
    several: bool = False


def _whole(schema: Form, encode: Callable[[Any], Tree], decode: Callable[[Tree], Any]) -> Kind:
    """A kind whose message is one object of a schema of the course's own."""

    def write(topic: str, message: Any) -> list[Piece]:
        return [Piece(topic, schema, encode(message))]

    return Kind(write, lambda trees: decode(trees[0]))


def _silos(tree: Tree) -> messages.Silos:
    fillings = field(tree, "fillings", list)
    if not all(type(filling) is str for filling in fillings):
        raise ValueError(f"fillings: expected texts, got {fillings!r:.60}")
    return messages.Silos(number(tree, "time"), tuple(fillings))


def _state(tree: Tree) -> messages.State:
    return messages.State(
        number(tree, "time"), field(tree, "name", str), field(tree, "reason", str)
    )


def _score_tree(score: messages.Score) -> Tree:
    return {
        "time": float(score.time),
        "own": int(score.own),
        "theirs": int(score.theirs),
        "left": float(score.left),
        "winner": str(score.winner),
        "reason": str(score.reason),
    }


def _score(tree: Tree) -> messages.Score:
    return messages.Score(
        number(tree, "time"),
        field(tree, "own", int),
        field(tree, "theirs", int),
        number(tree, "left"),
        field(tree, "winner", str),
        field(tree, "reason", str),
    )


def _twist(tree: Tree) -> messages.Twist:
    return messages.Twist(*(number(tree, name) for name in messages.Twist._fields))


def _button_tree(button: messages.Button) -> Tree:
    if isinstance(button.value, str):
        return {"name": str(button.name), "text": button.value}
    return {"name": str(button.name), "number": float(button.value)}


def _button(tree: Tree) -> messages.Button:
    value = field(tree, "text", str) if "text" in tree else number(tree, "number")
    return messages.Button(field(tree, "name", str), value)


KINDS: dict[type, Kind] = {
    Observation: _whole(schemas.OBSERVATION, codec.encode_observation, codec.decode_observation),
    Command: _whole(schemas.COMMAND, codec.encode_command, codec.decode_command),
    messages.PoseStamped: Kind(drawn.write_pose, drawn.read_pose, 20.0),
    messages.Path: Kind(drawn.write_path, drawn.read_path),
    messages.LaserScan: Kind(drawn.write_scan, drawn.read_scan, 20.0, several=True),
    messages.Image: Kind(drawn.write_image, drawn.read_image, 10.0),
    messages.Detection2DArray: Kind(drawn.write_detections, drawn.read_detections),
    messages.Log: Kind(drawn.write_log, drawn.read_log_line),
    messages.Silos: _whole(
        schemas.SILOS,
        lambda m: {"time": float(m.time), "fillings": [str(one) for one in m.fillings]},
        _silos,
    ),
    messages.State: _whole(
        schemas.STATE,
        lambda m: {"time": float(m.time), "name": str(m.name), "reason": str(m.reason)},
        _state,
    ),
    messages.Score: _whole(schemas.SCORE, _score_tree, _score),
    messages.Twist: _whole(
        schemas.TWIST, lambda m: {name: float(getattr(m, name)) for name in m._fields}, _twist
    ),
    messages.Button: _whole(schemas.BUTTON, _button_tree, _button),
}
"""All kinds, by the type of the message."""
NAMES = {kind.__name__: kind for kind in KINDS}
"""The types by name, as a log's channels name them."""
