"""The schemas of Foxglove that a match log uses, so that its viewers draw what they find.

Names, fields, types and meaning are those of the published JSON schemas (foxglove-sdk,
``schemas/jsonschema``); the optional fields about where a message came from are left away. A choice
such as `LEVELS` has its type beside its values, because older viewers ask for one.
"""

from __future__ import annotations

from robocon_course.robot.forms import Form, many, number, picture, words

LEVELS = ("unknown", "debug", "info", "warning", "error", "fatal")
"""Of a log line, in the order of their numbers."""
POINTS = ("UNKNOWN", "POINTS", "LINE_LOOP", "LINE_STRIP", "LINE_LIST")
"""What points on a picture are joined to, in the order of their numbers."""
LINE_LOOP = POINTS.index("LINE_LOOP")


def _record(title: str, text: str, /, **fields: Form) -> Form:
    """An object, every field of which is required."""
    return {
        "title": title,
        "description": text,
        "type": "object",
        "properties": fields,
        "required": list(fields),
    }


def _choice(title: str, text: str, names: tuple[str, ...]) -> Form:
    kinds = [{"title": name.upper(), "const": value} for value, name in enumerate(names)]
    return {"title": title, "description": text, "type": "integer", "oneOf": kinds}


def _numbers(title: str, text: str, names: str) -> Form:
    return _record(title, text, **{name: number(name) for name in names})


_TIME = {
    "type": "object",
    "title": "time",
    "description": "on the robot's clock",
    "properties": {
        "sec": {"type": "integer", "minimum": 0},
        "nsec": {"type": "integer", "minimum": 0, "maximum": 999_999_999},
    },
    "required": ["sec", "nsec"],
}
_POSITION = _numbers("foxglove.Vector3", "Place [m]", "xyz")
_ORIENTATION = _numbers("foxglove.Quaternion", "Rotation", "xyzw")
_POSE = _record("foxglove.Pose", "Pose", position=_POSITION, orientation=_ORIENTATION)
_COLOUR = _numbers("foxglove.Color", "Colour, 0 to 1", "rgba")
_PIXEL = _numbers(
    "foxglove.Point2", "Place in a picture, from its upper left corner [pixels]", "xy"
)
_PAIR = _record("foxglove.KeyValuePair", "A remark", key=words("name"), value=words("value"))
_REMARKS = many(_PAIR, "remarks")

POSE = _record(
    "foxglove.PoseInFrame",
    "A pose at a time",
    timestamp=_TIME,
    frame_id=words("frame that the pose is in"),
    pose=_POSE,
)
POSES = _record(
    "foxglove.PosesInFrame",
    "Poses in a row",
    timestamp=_TIME,
    frame_id=words("frame that the poses are in"),
    poses=many(_POSE, "the poses"),
)
TRANSFORM = _record(
    "foxglove.FrameTransform",
    "Where one frame lies in another",
    timestamp=_TIME,
    parent_frame_id=words("the other"),
    child_frame_id=words("the one"),
    translation=_POSITION,
    rotation=_ORIENTATION,
)
SCAN = _record(
    "foxglove.LaserScan",
    "Distances at angles in equal steps, from one origin",
    timestamp=_TIME,
    frame_id=words("frame that the origin is in"),
    pose=_POSE,
    start_angle=number("of the first distance [rad]"),
    end_angle=number("of the last distance [rad]"),
    ranges=many({"type": "number"}, "distances [m]"),
    intensities=many({"type": "number"}, "strength of each"),
)
IMAGE = _record(
    "foxglove.CompressedImage",
    "A picture's file",
    timestamp=_TIME,
    frame_id=words("frame of the camera"),
    data=picture("the file"),
    format=words("jpeg, png, webp or avif"),
)
LOG = _record(
    "foxglove.Log",
    "A line for the operator",
    timestamp=_TIME,
    level=_choice("foxglove.LogLevel", "how grave", LEVELS),
    message=words("the line"),
    name=words("who says it"),
    file=words("file of the program"),
    line={"type": "integer", "minimum": 0, "description": "line of the file"},
)
_CIRCLE = _record(
    "foxglove.CircleAnnotation",
    "A circle",
    timestamp=_TIME,
    position=_PIXEL,
    diameter=number("[pixels]"),
    thickness=number("of its line [pixels]"),
    fill_color=_COLOUR,
    outline_color=_COLOUR,
    metadata=_REMARKS,
)
_POINTS = _record(
    "foxglove.PointsAnnotation",
    "Points, or lines between them",
    timestamp=_TIME,
    type=_choice("foxglove.PointsAnnotationType", "how they are joined", POINTS),
    points=many(_PIXEL, "the points"),
    outline_color=_COLOUR,
    outline_colors=many(_COLOUR, "of each point or line"),
    fill_color=_COLOUR,
    thickness=number("of the lines [pixels]"),
    metadata=_REMARKS,
)
_TEXT = _record(
    "foxglove.TextAnnotation",
    "A text",
    timestamp=_TIME,
    position=_PIXEL,
    text=words("what it says"),
    font_size=number("[pixels]"),
    text_color=_COLOUR,
    background_color=_COLOUR,
    metadata=_REMARKS,
)
ANNOTATIONS = _record(
    "foxglove.ImageAnnotations",
    "What is drawn over a picture",
    circles=many(_CIRCLE, "circles"),
    points=many(_POINTS, "points and lines"),
    texts=many(_TEXT, "texts"),
)

__all__ = [
    "ANNOTATIONS",
    "IMAGE",
    "LEVELS",
    "LINE_LOOP",
    "LOG",
    "POSE",
    "POSES",
    "SCAN",
    "TRANSFORM",
]
