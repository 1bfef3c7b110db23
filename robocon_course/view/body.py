"""The robot as a handful of polygons on the map; ``field_picture`` and ``live`` paint them.

What the robot looks like stands here once. Every painter, matplotlib or pixels, gets the same
polygons in metres.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import robot
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field import BALL_DIAMETER
from robocon_course.geometry import transform_points
from robocon_course.view.canvas import MINE, TRUTH, WARN

BODY, STEEL, RUBBER = "#EEF1F4", "#5C6670", "#30363C"
WHEEL = (0.12, 0.05)
"""Length and width of a module's wheel, a little larger than life."""
ARROW = 0.22
"""Length of a wheel's arrow per speed [m per m/s]."""
_ROUND = np.column_stack([f(np.linspace(0.0, 2.0 * np.pi, 20, False)) for f in (np.cos, np.sin)])
SPOT = np.radians(1.8)
"""Half the angle that a LiDAR's light spreads."""


class Shape(NamedTuple):
    """A polygon in one colour.

    Attributes
    ----------
    corners : ndarray, shape (n, 2)  [m, map]
    colour : str
    opacity : float, 0 to 1
    """

    corners: FloatArray
    colour: str
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class RobotPicture:
    """A robot to be drawn: where it stands, how its wheels turn, what its LiDARs measure.

    Attributes
    ----------
    pose : array_like, shape (3,)  [m, m, rad; map]
    angles : array_like, shape (4,), optional  [rad, base]
        Where the modules point; without it straight ahead.
    speeds : array_like, shape (4,), optional  [m/s]
        An arrow per wheel; without it none.
    beams : array_like, shape (k,), optional  [m]
        What the LiDARs measured, in the order of `robot.LIDARS`; 0 draws no beam.
    colour : str
        Of the outline and the nose; `MINE`, `REFERENCE` and so on mean what they mean elsewhere.
    gripper : str, optional
        Draw the gripper, with a ball of this colour in it; ``""`` for an empty one.
    """

    pose: ArrayLike
    angles: ArrayLike | None = None
    speeds: ArrayLike | None = None
    beams: ArrayLike | None = None
    colour: str = MINE
    gripper: str | None = None

    @classmethod
    def seen(
        cls, pose: ArrayLike, observation: robot.Observation, colour: str = MINE
    ) -> RobotPicture:
        """The robot at a pose, with wheels and beams as an observation says."""
        beams = [reading.distance for reading in observation.lidar]
        return cls(pose, observation.module_angles, observation.module_speeds, beams, colour)


def robot_shapes(picture: RobotPicture) -> list[Shape]:
    """The polygons of a robot, lowest first.

    Raises
    ------
    ValueError
        A pose, angles, speeds or beams that are not so many finite numbers.
    """
    pose = as_floats(picture.pose, "pose", 3)
    shapes = [
        *_beams(picture), *_gripper(picture.gripper), *_body(picture.colour), *_wheels(picture)
    ]  # fmt: skip
    return [shape._replace(corners=transform_points(pose, shape.corners)) for shape in shapes]


def _beams(picture: RobotPicture) -> Iterator[Shape]:
    distances = as_floats([] if picture.beams is None else picture.beams, "beams", None)
    for mount, distance in zip(robot.LIDARS, distances, strict=False):
        if distance > 0.0:
            end = distance * np.array([[1.0, -np.tan(SPOT)], [1.0, np.tan(SPOT)]])
            pose = (mount.x, mount.y, mount.angle)
            yield Shape(transform_points(pose, [(0.0, 0.0), *end]), WARN, 0.55)


def _gripper(ball: str | None) -> Iterator[Shape]:
    """Two fingers before the front, as long as the ball that they hold."""
    if ball is None:
        return
    for y in (-0.115, 0.115):
        reach = [(0.3, y - 0.016), (0.51, y - 0.016), (0.51, y + 0.016), (0.3, y + 0.016)]
        yield Shape(np.array(reach), STEEL)
    if ball:
        yield from ball_shapes((0.42, 0.0), ball)


def ball_shapes(centre: ArrayLike, colour: str) -> Iterator[Shape]:
    """A ball from above, with a dark rim.

    Parameters
    ----------
    centre : array_like, shape (2,)  [m, map]
    colour : str
    """
    for radius, paint in ((BALL_DIAMETER / 2, TRUTH), (BALL_DIAMETER / 2 - 0.014, colour)):
        yield Shape(np.asarray(centre, float) + radius * _ROUND, paint)


def _body(colour: str) -> Iterator[Shape]:
    half, cut = robot.SIDE / 2, 0.05
    for grow, paint in ((0.0, colour), (-0.022, BODY)):
        a, b = half + grow, half + grow - cut
        around = [(a, b), (b, a), (-b, a), (-a, b), (-a, -b), (-b, -a), (b, -a), (a, -b)]
        yield Shape(np.array(around), paint)
    yield Shape(np.array([(half - 0.045, 0.0), (0.12, 0.11), (0.12, -0.11)]), colour)


def _wheels(picture: RobotPicture) -> Iterator[Shape]:
    count = len(robot.MODULES)
    angles = np.zeros(count) if picture.angles is None else as_floats(picture.angles, "angles", 4)
    speeds = np.zeros(count) if picture.speeds is None else as_floats(picture.speeds, "speeds", 4)
    length, width = np.array(WHEEL) / 2
    tyre = [(length, width), (-length, width), (-length, -width), (length, -width)]
    poses = [(*place, angle) for place, angle in zip(robot.MODULES, angles, strict=True)]
    for pose in poses:
        yield Shape(transform_points(pose, tyre), RUBBER)
    for pose, speed in zip(poses, speeds, strict=True):
        if abs(speed) > 0.02:
            yield Shape(transform_points(pose, _arrow(ARROW * speed)), picture.colour)


def _arrow(reach: float) -> FloatArray:
    """An arrow along x of a signed length, with a head that a slow wheel shows too."""
    sign = np.sign(reach)
    tip, neck = reach + 0.06 * sign, reach - 0.02 * sign
    outline = [(0.0, 0.012), (neck, 0.012), (neck, 0.042), (tip, 0.0)]
    return np.array(outline + [(x, -y) for x, y in outline[2::-1]])
