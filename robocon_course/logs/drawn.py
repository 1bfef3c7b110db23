"""Messages that Foxglove's viewers draw, in Foxglove's own words, and back.

They come back as close as their form allows: times to the nanosecond, headings between -pi and pi,
pictures as JPEG gives them. Observation and command, which are replayed to the bit, are not here.

A scan becomes one message to each beam, on topics of their own (``/scan/front``). The four beams
neither start at one place nor do viewers draw a scan of one distance (their step between two
angles would be 0/0), so each beam gives its distance twice, at one angle. Where the sensor does not
trust itself there is no distance, and nothing is drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, cos, isfinite, pi, remainder, sin
from typing import NamedTuple

import numpy as np

from robocon_course._arrays import as_floats
from robocon_course.logs import foxglove
from robocon_course.robot import LIDAR_HEIGHT, LIDARS, messages
from robocon_course.robot.camera_frames import decode_picture, encode_picture
from robocon_course.robot.forms import Form
from robocon_course.robot.text import Tree, field, number, things

CHILDREN = {"/odom": "base", "/ground_truth": "base_true"}
"""Frames that lie in the map where a pose says, by the pose's topic."""
QUALITY = 80
"""Of the pictures' JPEG."""
_COLOURS = {"red": (1.0, 0.2, 0.2), "blue": (0.2, 0.5, 1.0), "purple": (0.7, 0.3, 1.0)}
_OTHER, _NONE = (1.0, 0.8, 0.1), dict.fromkeys("rgba", 0.0)


class Piece(NamedTuple):
    """One message of a log's file.

    Attributes
    ----------
    topic : str
    schema : dict
    tree : dict
    derived : bool
        It says again what another piece says, for the viewers; a reader passes it over.
    """

    topic: str
    schema: Form
    tree: Tree
    derived: bool = False


def nanoseconds(time: float) -> int:
    """A time of the robot's clock [ns], at least 0.

    Raises
    ------
    ValueError
        It is not finite, or beyond what a log's file can hold.
    """
    if not 0.0 <= abs(time) < 1.8e10:
        raise ValueError(f"time: expected seconds, got {time!r}")
    return max(round(time * 1e9), 0)


def _stamp(time: float) -> Tree:
    seconds, rest = divmod(nanoseconds(time), 1_000_000_000)
    return {"sec": seconds, "nsec": rest}


def _time(tree: Tree, name: str = "timestamp") -> float:
    stamp = field(tree, name, dict)
    return (field(stamp, "sec", int) * 1_000_000_000 + field(stamp, "nsec", int)) / 1e9


def _position(x: float, y: float, z: float = 0.0) -> Tree:
    return {"x": x, "y": y, "z": z}


def _rotation(yaw: float) -> Tree:
    return {"x": 0.0, "y": 0.0, "z": sin(0.5 * yaw), "w": cos(0.5 * yaw)}


def _pose(x: float, y: float, yaw: float) -> Tree:
    return {"position": _position(x, y), "orientation": _rotation(yaw)}


# --- poses and ways -------------------------------------------------------------------------------


def write_pose(topic: str, message: messages.PoseStamped) -> list[Piece]:
    """A pose, and where it puts the robot's frame in the map."""
    x, y, yaw = as_floats(message.pose, "pose", 3).tolist()
    stamp, pose = _stamp(message.time), _pose(x, y, yaw)
    tree = {"timestamp": stamp, "frame_id": "map", "pose": pose}
    pieces = [Piece(topic, foxglove.POSE, tree)]
    if topic in CHILDREN:
        frames = {"parent_frame_id": "map", "child_frame_id": CHILDREN[topic]}
        place = {"translation": pose["position"], "rotation": pose["orientation"]}
        moved = {"timestamp": stamp, **frames, **place}
        pieces.append(Piece("/tf", foxglove.TRANSFORM, moved, derived=True))
    return pieces


def read_pose(trees: Sequence[Tree]) -> messages.PoseStamped:
    """The pose; its heading between -pi and pi."""
    pose = field(trees[0], "pose", dict)
    place, turn = field(pose, "position", dict), field(pose, "orientation", dict)
    yaw = remainder(2.0 * atan2(number(turn, "z"), number(turn, "w")), 2.0 * pi)
    return messages.PoseStamped(
        _time(trees[0]), np.array([number(place, "x"), number(place, "y"), yaw])
    )


def write_path(topic: str, message: messages.Path) -> list[Piece]:
    """A way: its points, each looking towards the next."""
    xy = as_floats(message.xy, "xy", None, 2)
    along = np.diff(xy, axis=0)
    yaws = np.arctan2(along[:, 1], along[:, 0]).tolist()
    yaws += yaws[-1:] or [0.0] * len(xy)
    poses = [_pose(x, y, yaw) for (x, y), yaw in zip(xy.tolist(), yaws, strict=True)]
    tree = {"timestamp": _stamp(message.time), "frame_id": "map", "poses": poses}
    return [Piece(topic, foxglove.POSES, tree)]


def read_path(trees: Sequence[Tree]) -> messages.Path:
    """The way, without the headings."""
    places = [field(pose, "position", dict) for pose in things(trees[0], "poses")]
    xy = [(number(place, "x"), number(place, "y")) for place in places]
    return messages.Path(_time(trees[0]), np.array(xy, float).reshape(-1, 2))


# --- beams ----------------------------------------------------------------------------------------


def write_scan(topic: str, message: messages.LaserScan) -> list[Piece]:
    """One piece to each beam."""
    angles = as_floats(message.angles, "angles", None).tolist()
    ranges = as_floats(message.ranges, "ranges", len(angles), finite=False).tolist()
    stamp, known = _stamp(message.time), len(angles) == len(LIDARS)
    pieces = []
    for k, (angle, distance) in enumerate(zip(angles, ranges, strict=True)):
        name, x, y = LIDARS[k][:3] if known else (str(k), 0.0, 0.0)
        trusted = isfinite(distance) and distance > 0.0
        origin = {"position": _position(x, y, LIDAR_HEIGHT), "orientation": _rotation(0.0)}
        tree = {
            "timestamp": stamp,
            "frame_id": "base",
            "pose": origin,
            "start_angle": angle,
            "end_angle": angle,
            "ranges": [distance] * 2 if trusted else [],
            "intensities": [1.0] * 2 if trusted else [],
        }
        pieces.append(Piece(f"{topic}/{name}", foxglove.SCAN, tree))
    return pieces


def read_scan(trees: Sequence[Tree]) -> messages.LaserScan:
    """The beams together; 0 for a distance that is not there."""
    angles = [number(tree, "start_angle") for tree in trees]
    ranges = [float((field(tree, "ranges", list) or [0.0])[0]) for tree in trees]
    return messages.LaserScan(_time(trees[0]), np.array(angles), np.array(ranges))


# --- pictures -------------------------------------------------------------------------------------


def write_image(topic: str, message: messages.Image) -> list[Piece]:
    """A picture, as JPEG."""
    tree = {
        "timestamp": _stamp(message.time),
        "frame_id": "camera",
        "data": encode_picture(message.image_bgr, QUALITY),
        "format": "jpeg",
    }
    return [Piece(topic, foxglove.IMAGE, tree)]


def read_image(trees: Sequence[Tree]) -> messages.Image:
    """The picture, as JPEG gives it."""
    return messages.Image(_time(trees[0]), decode_picture(field(trees[0], "data", str)))


def write_detections(topic: str, message: messages.Detection2DArray) -> list[Piece]:
    """Boxes with their names over a picture, and in its corner what was looked for."""
    boxes = as_floats(message.boxes, "boxes", None, 4).tolist()
    scores = as_floats(message.scores, "scores", len(boxes)).tolist()
    stamp = _stamp(message.time)
    title = f"{message.kind}: {len(boxes)}"
    texts = [_label(stamp, 4.0, 16.0, title, _OTHER, {"kind": str(message.kind)})]
    points = []
    for box, score, label in zip(boxes, scores, message.labels, strict=True):
        colour = _COLOURS.get(label, _OTHER)
        points.append(_frame(stamp, box, colour, {"label": str(label), "score": repr(score)}))
        texts.append(_label(stamp, box[0], box[1], f"{label} {score:.2f}", colour, {}))
    return [Piece(topic, foxglove.ANNOTATIONS, {"circles": [], "points": points, "texts": texts})]


def _colour(rgb: tuple[float, float, float]) -> Tree:
    return dict(zip("rgba", (*rgb, 1.0), strict=True))


def _remarks(remarks: dict[str, str]) -> list[Tree]:
    return [{"key": key, "value": value} for key, value in remarks.items()]


def _label(stamp: Tree, x: float, y: float, text: str, rgb: tuple, remarks: dict) -> Tree:
    return {
        "timestamp": stamp,
        "position": {"x": x, "y": y},
        "text": text,
        "font_size": 12.0,
        "text_color": _colour(rgb),
        "background_color": {"r": 0.0, "g": 0.0, "b": 0.0, "a": 0.5},
        "metadata": _remarks(remarks),
    }


def _frame(stamp: Tree, box: list[float], rgb: tuple, remarks: dict) -> Tree:
    left, top, right, bottom = box
    corners = (left, top), (right, top), (right, bottom), (left, bottom)
    return {
        "timestamp": stamp,
        "type": foxglove.LINE_LOOP,
        "points": [{"x": x, "y": y} for x, y in corners],
        "outline_color": _colour(rgb),
        "outline_colors": [],
        "fill_color": _NONE,
        "thickness": 2.0,
        "metadata": _remarks(remarks),
    }


def read_detections(trees: Sequence[Tree]) -> messages.Detection2DArray:
    """What was found."""
    title, frames = things(trees[0], "texts")[0], things(trees[0], "points")
    remarks = [
        {field(one, "key", str): field(one, "value", str) for one in things(frame, "metadata")}
        for frame in frames
    ]
    corners = [things(frame, "points", 4) for frame in frames]
    boxes = [[number(c[k], axis) for k in (0, 2) for axis in "xy"] for c in corners]
    return messages.Detection2DArray(
        _time(title),
        field(things(title, "metadata", 1)[0], "value", str),
        np.array(boxes, float).reshape(-1, 4),
        np.array([float(field(one, "score", str)) for one in remarks]),
        tuple(field(one, "label", str) for one in remarks),
    )


# --- words ----------------------------------------------------------------------------------------


def write_log(topic: str, message: messages.Log) -> list[Piece]:
    """A line for the operator."""
    known = message.level in foxglove.LEVELS
    tree = {
        "timestamp": _stamp(message.time),
        "level": foxglove.LEVELS.index(message.level) if known else 0,
        "message": str(message.text),
        "name": "robocon",
        "file": "",
        "line": 0,
    }
    return [Piece(topic, foxglove.LOG, tree)]


def read_log_line(trees: Sequence[Tree]) -> messages.Log:
    """The line for the operator."""
    level = field(trees[0], "level", int)
    names = dict(enumerate(foxglove.LEVELS))
    return messages.Log(
        _time(trees[0]), names.get(level, "unknown"), field(trees[0], "message", str)
    )
