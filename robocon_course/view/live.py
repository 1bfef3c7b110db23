"""A simulated robot under somebody's hands, and a camera that follows it from above."""

from __future__ import annotations

import io
from collections import deque

import numpy as np
from PIL import Image, ImageDraw

from robocon_course import field, robot
from robocon_course.autopilot import Parts, module_command
from robocon_course.geometry import wrap_angle
from robocon_course.simulator import Simulator
from robocon_course.view.body import RobotPicture, robot_shapes
from robocon_course.view.canvas import MINE, TRUTH
from robocon_course.view.ground import painted_field
from robocon_course.view.raster import Pixels, Scale, font, paint, trace

CONTROL = 0.02
"""Time between two commands to the modules [s]."""
PER_METRE = 120
VIEW = (480, 420)
"""Width and height of the live picture [pixel]: 4 m by 3.5 m; sliders find room beside it."""
MARGIN = (34, 24)
"""Room at the left and below for the numbers of the axes [pixel]."""
PALE = 0.25
"""How far the floor is mixed with white."""
TRAIL = 400
"""How many pictures long the trail is."""
STILL = 0.01
"""Slower than this the robot counts as standing [m/s, rad/s]."""


class Ride:
    """A simulator that is driven by a twist, with a trail of where it was.

    Attributes
    ----------
    twist : tuple (vx, vy, omega)  [m/s, m/s, rad/s]
        What is asked for, in the robot's frame, or in the map's with ``field_centric``.
    field_centric : bool
        Whether vx and vy count along the map's axes. Like the picture, this uses the simulator's
        true heading.
    """

    def __init__(self, simulator: Simulator, parts: Parts) -> None:
        self.simulator, self.parts = simulator, parts
        self.twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
        self.field_centric = False
        self.observation = simulator.read()
        self.trail: deque[tuple[float, float]] = deque(maxlen=TRAIL)
        self.trail.append(self.pose[:2])

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the robot really stands [m, m, rad; map]."""
        x, y, theta = (float(number) for number in self.simulator.truth.pose)
        return x, y, theta

    @property
    def moving(self) -> bool:
        """Whether something is asked for, or the robot still rolls."""
        return any(self.twist) or bool(np.abs(self.simulator.truth.twist).max() > STILL)

    def advance(self, seconds: float) -> None:
        """Let time pass: read, command and step, fifty times a second."""
        for _ in range(round(seconds / CONTROL)):
            self.simulator.apply(self._command())
            self.simulator.step(CONTROL)
            self.observation = self.simulator.read()
        self.trail.append(self.pose[:2])

    def halt(self) -> None:
        """Ask for nothing any more, without the student's parts."""
        self.twist = (0.0, 0.0, 0.0)
        self.simulator.apply(robot.Command.stop(self.observation.module_angles))

    def readout(self) -> str:
        """Pose, LiDARs and contact in two lines."""
        x, y, theta = self.pose
        heading = float(np.degrees(wrap_angle(theta)))
        beams = ", ".join(
            f"{mount.name} {reading.distance:.2f}" if reading.distance else f"{mount.name} –"
            for mount, reading in zip(robot.LIDARS, self.observation.lidar, strict=True)
        )
        touch = "touches something" if self.simulator.truth.contact else "touches nothing"
        where = f"x {x:.2f} m, y {y:.2f} m, heading {heading:.0f}°"
        return f"{self.observation.time:.1f} s: {where}; {touch}\nLiDARs [m]: {beams}"

    def _command(self) -> robot.Command:
        theta = self.pose[2] if self.field_centric else 0.0
        angles = self.observation.module_angles
        return module_command(self.parts, self.twist, theta, angles, dt=CONTROL)


def photograph(ride: Ride) -> bytes:
    """The robot from above with the field around it, as the bytes of a PNG file."""
    view, scale = _field_at(*ride.pose[:2])
    for colour, width in (("#FFFFFF", 4), (MINE, 2)):
        trace(view, np.array(ride.trail), scale, colour, width)
    paint(view, robot_shapes(RobotPicture.seen(ride.pose, ride.observation)), scale)
    stream = io.BytesIO()
    _framed(view, scale).save(stream, "png", compress_level=1)
    return stream.getvalue()


def _field_at(x: float, y: float) -> tuple[Pixels, Scale]:
    """A piece of the field around a point, but never beyond the fences."""
    floor, whole = painted_field(PER_METRE, PALE)
    rows, columns, _ = floor.shape
    column, row = whole.pixels(np.array([x, y])).round().astype(int).tolist()
    width, height = VIEW
    left = min(max(column - width // 2, 0), columns - width)
    top = min(max(row - height // 2, 0), rows - height)
    piece = floor[top : top + height, left : left + width].copy()
    return piece, whole.moved(left, top)


def _framed(view: Pixels, scale: Scale) -> Image.Image:
    """The piece of field with its x below and its y at the left, every metre."""
    height, width, _ = view.shape
    left, below = MARGIN
    image = Image.new("RGB", (left + width, height + below), "white")
    image.paste(Image.fromarray(view), (left, 0))
    draw = ImageDraw.Draw(image)
    for metre in range(round(field.SIZE) + 1):
        column, row = scale.pixels(np.array([metre, metre]))
        words = {"fill": TRUTH, "font": font(13)}
        if 12 < column < width - 12:
            draw.text((left + column, height + 4), f"{metre} m", anchor="ma", **words)
        if 8 < row < height - 8:
            draw.text((left - 4, row), f"{metre} m", anchor="rm", **words)
    return image
