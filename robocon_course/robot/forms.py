"""JSON schemas of `Observation` and `Command`, and the small parts that other schemas are built of.

Viewers of logs (Foxglove, Lichtblick) read a part of JSON Schema only: every field has one type
in words, an array holds no arrays, an object names its properties. All schemas here keep to it.
"""

from __future__ import annotations

from typing import Any

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The JSON Schema that these texts are written in."""

Form = dict[str, Any]


def number(text: str) -> Form:
    """A number; a field with none that is required nowhere, for NaN is left out."""
    return {"type": "number", "description": text}


def whole(text: str) -> Form:
    """A whole number."""
    return {"type": "integer", "description": text}


def words(text: str) -> Form:
    """A text of any length."""
    return {"type": "string", "description": text}


def truth(text: str) -> Form:
    """True or false."""
    return {"type": "boolean", "description": text}


def picture(text: str) -> Form:
    """Bytes of a picture's file."""
    return {"type": "string", "contentEncoding": "base64", "description": text}


def many(items: Form, text: str, count: int | None = None) -> Form:
    """An array of entries of one kind.

    Parameters
    ----------
    items : dict
        Schema of each of its entries, which is no array.
    text : str
        What it holds.
    count : int, optional
        Its length, where that is fixed.
    """
    form = {"type": "array", "items": items, "description": text}
    return form if count is None else form | {"minItems": count, "maxItems": count}


def thing(text: str, fields: dict[str, Form], optional: tuple[str, ...] = ()) -> Form:
    """An object. All fields are required but the numbers, which may be NaN, and the `optional`.

    Parameters
    ----------
    text : str
        What it is.
    fields : dict
        Schemas by name.
    optional : tuple of str
        Names of other fields that may be missing.
    """
    required = [
        name for name, form in fields.items() if form["type"] != "number" and name not in optional
    ]
    form = {"type": "object", "description": text, "properties": fields}
    return form | {"required": required} if required else form


def own(name: str, text: str, fields: dict[str, Form], optional: tuple[str, ...] = ()) -> Form:
    """The schema of a message of the course's own.

    Parameters
    ----------
    name : str
        Its title will be ``robocon.<name>``.
    text, fields, optional
        As for `thing`.
    """
    head = {"$schema": DIALECT, "$id": f"urn:robocon-course:{name}:1", "title": f"robocon.{name}"}
    return head | thing(text, fields, optional)


def _axes(text: str) -> Form:
    return thing(text, {axis: number(f"along {axis}") for axis in "xyz"})


_BOX = {
    "left": number("[pixels]"),
    "top": number("[pixels]"),
    "right": number("[pixels]"),
    "bottom": number("[pixels]"),
    "score": number("how sure, 0 to 1"),
    "class_id": whole("number of the class"),
}
_FRAME = {
    "time": number("when it was taken [s, robot's clock]"),
    "pan": number("where the camera looked: to the left of ahead [rad]"),
    "tilt": number("and down [rad]"),
    "png": picture("the picture as PNG, which loses nothing"),
    "jpeg": picture("or as JPEG, over a link"),
    "found": many(
        thing(
            "What one network found",
            {
                "kind": words("ball or silo"),
                "boxes": many(thing("One thing", _BOX), "the surest first"),
            },
        ),
        "what was found, by the kind of network",
    ),
}

OBSERVATION = own(
    "Observation",
    "All that the robot knows about the world at one moment",
    {
        "time": number("the robot's clock [s]"),
        "ticks": many({"type": "integer"}, "counters of the dead wheels: left, right, rear"),
        "imu": many(
            thing(
                "A sample",
                {
                    "time": number("[s]"),
                    "gyro": _axes("[rad/s, base]"),
                    "accel": _axes("specific force [m/s^2, base]"),
                },
            ),
            "samples since the last observation, oldest first",
        ),
        "lidar": many(
            thing(
                "The latest of a sensor",
                {
                    "time": number("when it was measured [s]"),
                    "distance": number("[m]; 0 where the sensor does not trust itself"),
                    "strength": whole("of the returned light, 0 to 65535"),
                    "temperature": number("[deg C]"),
                },
            ),
            "front, left, rear, right",
        ),
        "modules": many(
            thing(
                "A swerve module",
                {"speed": number("of its wheel [m/s]"), "angle": number("[rad, base]")},
            ),
            "front left, rear left, rear right, front right",
            4,
        ),
        "battery": number("[V]"),
        "holding": truth("whether the light barrier in the gripper is interrupted"),
        "frame": thing("A picture that arrived", _FRAME, ("png", "jpeg")),
    },
    ("frame",),
)

COMMAND = own(
    "Command",
    "What the four modules, the gripper and the camera are asked to do",
    {
        "modules": many(
            thing(
                "A swerve module",
                {
                    "speed": number("of its wheel [m/s]; negative is backwards"),
                    "angle": number("where it shall point [rad, base]"),
                },
            ),
            "front left, rear left, rear right, front right",
            4,
        ),
        "intake": number("rollers: above 0 in, below 0 out"),
        "release": truth("put the held ball into a silo"),
        "pan": number("of the camera: to the left of ahead [rad]"),
        "tilt": number("and down [rad]"),
        "watch": words("what the next pictures are for: ball, silo, or nothing"),
    },
)
