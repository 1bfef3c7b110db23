"""One JSON form of `Observation` and `Command`, for logs and for the link to hardware.

Decoding gives back every bit that was encoded. `forms` describes it as JSON Schema, `text` writes
it, `camera_frames` holds the part about pictures.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import index
from typing import Any

import numpy as np

from robocon_course._arrays import as_floats
from robocon_course.robot.camera_frames import decode_frame, encode_frame
from robocon_course.robot.hardware import Command, LidarReading, Observation
from robocon_course.robot.text import Tree, field, number, rows, things, wholes

# --- observation ----------------------------------------------------------------------------------


def encode_observation(observation: Observation) -> Tree:
    """An observation as a JSON object.

    Parameters
    ----------
    observation : Observation

    Returns
    -------
    dict
        As `forms.OBSERVATION` describes; `to_text` writes it.

    Raises
    ------
    ValueError
        An array of another shape, counters that are not whole, a picture that is none.
    """
    times = _floats(observation.imu_time, "imu_time", None)
    gyro = _floats(observation.gyro, "gyro", len(times), 3)
    accel = _floats(observation.accel, "accel", len(times), 3)
    speeds = _floats(observation.module_speeds, "module_speeds", 4)
    angles = _floats(observation.module_angles, "module_angles", 4)
    ticks = np.asarray(observation.ticks)
    if ticks.ndim != 1 or ticks.dtype.kind not in "iu":
        raise ValueError(f"ticks: expected whole numbers, got {observation.ticks!r:.60}")
    tree = {
        "time": _floats(observation.time, "time"),
        "ticks": ticks.tolist(),
        "imu": [
            {"time": time, "gyro": _axes(g), "accel": _axes(a)}
            for time, g, a in zip(times, gyro, accel, strict=True)
        ],
        "lidar": _lidar(observation.lidar),
        "modules": [{"speed": v, "angle": a} for v, a in zip(speeds, angles, strict=True)],
        "battery": _floats(observation.battery, "battery"),
        "holding": bool(observation.holding),
    }
    if observation.frame is not None:
        tree["frame"] = encode_frame(observation.frame)
    return tree


def _axes(vector: list[float]) -> Tree:
    x, y, z = vector
    return {"x": x, "y": y, "z": z}


def _lidar(readings: Sequence[LidarReading]) -> list[Tree]:
    numbers = [(reading.time, reading.distance, reading.temperature) for reading in readings]
    values = _floats(numbers or np.empty((0, 3)), "lidar", None, 3)
    return [
        {"time": t, "distance": d, "strength": _whole(reading.strength), "temperature": c}
        for (t, d, c), reading in zip(values, readings, strict=True)
    ]


def _whole(strength: Any) -> int:
    try:
        return index(strength)
    except TypeError:
        raise ValueError(f"strength: expected a whole number, got {strength!r:.40}") from None


def decode_observation(tree: Tree) -> Observation:
    """The observation that a JSON object describes.

    Parameters
    ----------
    tree : dict
        As `encode_observation` makes it.

    Returns
    -------
    Observation

    Raises
    ------
    ValueError
        A field that is missing or of another type; the message names it.
    """
    imu, modules = things(tree, "imu"), things(tree, "modules", 4)
    return Observation(
        time=number(tree, "time"),
        ticks=wholes(field(tree, "ticks", list), "ticks"),
        imu_time=rows(imu, "time")[:, 0],
        gyro=rows([field(sample, "gyro", dict) for sample in imu], *"xyz"),
        accel=rows([field(sample, "accel", dict) for sample in imu], *"xyz"),
        lidar=tuple(
            LidarReading(
                number(item, "time"),
                number(item, "distance"),
                field(item, "strength", int),
                number(item, "temperature"),
            )
            for item in things(tree, "lidar")
        ),
        module_speeds=rows(modules, "speed")[:, 0],
        module_angles=rows(modules, "angle")[:, 0],
        battery=number(tree, "battery"),
        holding=field(tree, "holding", bool),
        frame=decode_frame(field(tree, "frame", dict)) if "frame" in tree else None,
    )


# --- command --------------------------------------------------------------------------------------


def encode_command(command: Command) -> Tree:
    """A command as a JSON object.

    Parameters
    ----------
    command : Command

    Returns
    -------
    dict
        As `forms.COMMAND` describes.

    Raises
    ------
    ValueError
        Not four speeds and four angles.
    """
    speeds = _floats(command.speeds, "speeds", 4)
    angles = _floats(command.angles, "angles", 4)
    return {
        "modules": [{"speed": v, "angle": a} for v, a in zip(speeds, angles, strict=True)],
        "intake": _floats(command.intake, "intake"),
        "release": bool(command.release),
        "pan": _floats(command.pan, "pan"),
        "tilt": _floats(command.tilt, "tilt"),
        "watch": str(command.watch),
    }


def decode_command(tree: Tree) -> Command:
    """The command that a JSON object describes.

    Parameters
    ----------
    tree : dict

    Returns
    -------
    Command
        A number that was missing is NaN, which `Command.checked` refuses.

    Raises
    ------
    ValueError
        A field that is missing or of another type; the message names it.
    """
    modules = things(tree, "modules", 4)
    return Command(
        rows(modules, "speed")[:, 0],
        rows(modules, "angle")[:, 0],
        intake=number(tree, "intake"),
        release=field(tree, "release", bool),
        pan=number(tree, "pan"),
        tilt=number(tree, "tilt"),
        watch=field(tree, "watch", str),
    )


def _floats(value: Any, name: str, *shape: int | None) -> Any:
    """Plain floats, in lists of the shape that is wanted."""
    return as_floats(value, name, *shape, finite=False).tolist()
