"""From boxes in a picture to bearings and ranges on the field, and to what a robot wants to know.

Robot frame: x ahead, y to the left, bearings counter-clockwise from ahead (REP-103), measured at
the lens. Two rulers: a ball's known size, and the floor it lies on. Each gives a range with its
standard deviation; together they are as good as the better one.
"""

from __future__ import annotations

from math import atan2, cos, hypot, isfinite, sin, sqrt, tan
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import as_floats
from robocon_course.field import BALL_DIAMETER
from robocon_course.vision.camera import Camera
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.metrics import box_iou
from robocon_course.vision.reading import Detections

EDGE_SIGMA = 1.0
"""How exactly a detector finds the edge of a ball: standard deviation [pixels]."""
SAME_SILO = 0.5
"""Two boxes of silos that share more than this are one silo."""
OWN = {"red": BALLS.index("red"), "blue": BALLS.index("blue")}
"""The class of each team's balls."""


class Sighting(NamedTuple):
    """Where a ball is, seen from the camera.

    Attributes
    ----------
    bearing : float  [rad]
        To the left of where the robot looks; positive is left.
    range : float  [m]
        Along the floor, from below the lens to below the ball's middle.
    bearing_sigma : float  [rad]
    range_sigma : float  [m]
        Standard deviations; infinite where nothing can be said.
    """

    bearing: float
    range: float
    bearing_sigma: float
    range_sigma: float


def bearing_and_range(box: ArrayLike, camera: Camera, tilt: float = 0.0) -> Sighting:
    """Where a ball is, from the size it appears in.

    From above, the looks at a ball's left and right edge touch a circle: it lies halfway between
    them, and its distance is radius / sin(half their angle). The same holds from the side. What
    hides a part of the ball makes it look farther away, never nearer: the nearer one is believed.
    That fails where width and height are cut alike, in a corner of the picture: see `locate_ball`.

    Parameters
    ----------
    box : array_like, shape (4,)  [pixels]
        Left, top, right, bottom.
    camera : Camera
    tilt : float  [rad]
        How far the camera looks down.

    Returns
    -------
    Sighting

    Raises
    ------
    ValueError
        Not four finite numbers, or a box without size.
    """
    look = _look(box, camera)
    depth = min(look.by_width, look.by_height)
    bearing, ahead, _ = _levelled(look, tilt)
    edges = EDGE_SIGMA / sqrt(2)
    pixels = edges + look.missing(camera) / 2
    far = depth * ahead
    sigma = pixels / camera.focal * depth / (BALL_DIAMETER / 2)
    return Sighting(bearing, far, (edges + look.missing(camera)) / camera.focal, far * sigma)


def on_floor(box: ArrayLike, camera: Camera, tilt: float, height: float) -> Sighting:
    """Where a ball is, from how far below the horizon its middle appears.

    Parameters
    ----------
    box : array_like, shape (4,)  [pixels]
    camera : Camera
    tilt : float  [rad]
        How far the camera looks down.
    height : float  [m]
        Of the lens above the floor that the ball lies on.

    Returns
    -------
    Sighting
        Infinitely far, and infinitely unsure, for a box whose middle is not below the horizon. A
        ball in a corner of the picture may reach out of it: its middle is as unsure as its box is
        large.

    Raises
    ------
    ValueError
        Not four finite numbers, a box without size, or a lens lower than a ball's middle.
    """
    look = _look(box, camera)
    above = float(height) - BALL_DIAMETER / 2
    if not above > 0:
        raise ValueError(f"height: expected a lens above a ball's middle (0.095 m), got {height}")
    bearing, ahead, down = _levelled(look, tilt)
    hidden = look.missing(camera) + _cornered(box, camera)
    sigma = (EDGE_SIGMA / sqrt(2) + hidden) / camera.focal
    if down <= 1e-6:
        return Sighting(bearing, float("inf"), sigma, float("inf"))
    far = above * ahead / down
    return Sighting(bearing, far, sigma, sigma * (above**2 + far**2) / above)


def locate_ball(box: ArrayLike, camera: Camera, tilt: float, height: float) -> Sighting:
    """Where a ball on the floor is, by its size and by the floor, each weighted by its variance.

    Parameters
    ----------
    box : array_like, shape (4,)  [pixels]
    camera : Camera
    tilt : float  [rad]
    height : float  [m]
        Of the lens above the floor.

    Returns
    -------
    Sighting
    """
    size, floor = bearing_and_range(box, camera, tilt), on_floor(box, camera, tilt, height)
    hidden = _cornered(box, camera)
    if hidden > 0:
        aside = size.bearing_sigma + hidden / camera.focal
        size = size._replace(bearing_sigma=aside, range_sigma=size.range)
    return both_rulers(size, floor)


def both_rulers(size: Sighting, floor: Sighting) -> Sighting:
    """One sighting from a ball's size and from the floor, each weighted by its variance.

    Parameters
    ----------
    size, floor : Sighting
        As `bearing_and_range` and `on_floor` give them.

    Returns
    -------
    Sighting
        The first alone, where the floor says nothing.
    """
    if not isfinite(floor.range):
        return size
    trust = size.range_sigma**-2, floor.range_sigma**-2
    far = (size.range * trust[0] + floor.range * trust[1]) / sum(trust)
    return Sighting(size.bearing, far, size.bearing_sigma, sum(trust) ** -0.5)


class _Look(NamedTuple):
    """A ball in the camera frame: its middle at (x, y, 1) times its depth, by either side."""

    x: float
    y: float
    by_width: float
    by_height: float

    def missing(self, camera: Camera) -> float:
        """How far a hidden part may have shifted the middle of the box [pixels]."""
        apart = abs(1 / self.by_width - 1 / self.by_height)
        return BALL_DIAMETER / 2 * camera.focal * apart


def _look(box: ArrayLike, camera: Camera) -> _Look:
    left, top, right, bottom = box = as_floats(box, "box", 4).tolist()
    if not (right > left and bottom > top):
        raise ValueError(f"box: expected left < right and top < bottom, got {box}")
    x, y = (left + right) / 2, (top + bottom) / 2
    ends = camera.rays([[left, y], [right, y], [x, top], [x, bottom]])
    aside = ends[[0, 1, 2, 3], [0, 0, 1, 1]]  # of left and right end to the right, else down
    first, last, upper, lower = np.arctan2(aside, ends[:, 2]).tolist()
    across, down = (first + last) / 2, (upper + lower) / 2
    return _Look(
        tan(across),
        tan(down),
        BALL_DIAMETER / 2 / sin((last - first) / 2) * cos(across),
        BALL_DIAMETER / 2 / sin((lower - upper) / 2) * cos(down),
    )


def _cornered(box: ArrayLike, camera: Camera) -> float:
    """How much of a ball a corner of the picture may hide [pixels]: as much as is seen, or none.

    Where only one border cuts a ball, its other side still tells its size. In a corner both sides
    are cut, perhaps alike, and nothing in the box shows it.
    """
    left, top, right, bottom = as_floats(box, "box", 4).tolist()
    near = 2 * EDGE_SIGMA
    beside = left <= near or right >= camera.width - near
    over = top <= near or bottom >= camera.height - near
    return max(right - left, bottom - top) if beside and over else 0.0


def _levelled(look: _Look, tilt: float) -> tuple[float, float, float]:
    """Bearing of a ball, and for each metre of depth how far along the floor and down it lies."""
    ahead, left = cos(tilt) - look.y * sin(tilt), -look.x
    return atan2(left, ahead), hypot(ahead, left), look.y * cos(tilt) + sin(tilt)


def nearest_own_ball(detections: Detections, team: str) -> int | None:
    """Which detection is the nearest ball of the own colour.

    Parameters
    ----------
    detections : Detections
        Of the ball network.
    team : {"red", "blue"}

    Returns
    -------
    int or None
        Its index: the largest box of the own colour; a purple ball never. None if there is none.

    Raises
    ------
    ValueError
        Another team.
    """
    if team not in OWN:
        raise ValueError(f"team: expected 'red' or 'blue', got {team!r}")
    sides = detections.boxes[:, 2:] - detections.boxes[:, :2]
    size = np.where(detections.class_ids == OWN[team], sides.max(axis=1, initial=0.0), 0.0)
    return int(size.argmax()) if size.any() else None


def silo_contents(detections: Detections) -> tuple[str, ...]:
    """What the silos hold, from left to right.

    Parameters
    ----------
    detections : Detections
        Of the silo network.

    Returns
    -------
    tuple of str
        Fillings as `classes.SILOS` writes them, from bottom to top; of several for one silo the
        surest.
    """
    kept: list[int] = []
    for k in np.argsort(-detections.scores, kind="stable"):
        if not kept or box_iou(detections.boxes[[k]], detections.boxes[kept]).max() <= SAME_SILO:
            kept.append(int(k))
    kept.sort(key=lambda k: float(detections.boxes[k, 0] + detections.boxes[k, 2]))
    return tuple(SILOS[detections.class_ids[k]] for k in kept)
