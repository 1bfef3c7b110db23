"""What a detector would say of a scene, without a picture: true outlines, and its usual mistakes.

For campaigns of hundreds of matches. Each thing in view is found with a chance that falls with its
size and with what is seen of it, framed a little wrong, and now and then taken for another. Balls
hide one another; silos, which stand in a row, hide nothing and are hidden by nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.vision import BALLS, SILOS, Camera, Detections
from robocon_course.vision.camera import cross


class Mistakes(NamedTuple):
    """How a detector errs.

    Attributes
    ----------
    edge : float  [pixels]
        Standard deviation of each side of a box.
    miss : float
        Chance that a thing in full view is not found.
    other : float
        Chance that it is taken for another colour, or a silo for one of another filling.
    small : float  [pixels]
        Of a thing that is so wide, half are missed.
    """

    edge: float = 0.8
    miss: float = 0.03
    other: float = 0.01
    small: float = 6.0


_ANGLES = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
# Points of a disc: its rim, and a ring inside it.
_DISC = np.vstack([np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)]) * r for r in (1.0, 0.55)])
# And of a cylinder: its foot and its top.
_CYLINDER = np.array([(np.cos(a), np.sin(a), z) for a in _ANGLES for z in (0.0, 1.0)])
STICKS_OUT = 0.135
"""So far the third ball stands out of its silo [m]."""
_HALF, _TALL = 0.5 * field.SILO_DIAMETER, field.SILO_HEIGHT
# Each silo as it stands on the map, first without a third ball and then with it: it looks out.
_SILOS_STANDING = np.array([
    [_CYLINDER * (_HALF, _HALF, tall) + (x, y, field.SILO_ZONE.height) for x, y in field.SILOS]
    for tall in (_TALL, _TALL + STICKS_OUT)
])  # fmt: skip
AHEAD = 0.3
"""Nothing nearer before the lens is seen [m]."""
LEAST_SEEN = 0.15
"""Of a ball of which less is seen nothing is said."""
LEAST_INSIDE = 0.6
"""And of a silo of which less lies inside the picture."""


def balls_seen(
    camera: Camera,
    T_map_camera: FloatArray,
    centres: FloatArray,
    colours: Sequence[str],
    rng: np.random.Generator,
    mistakes: Mistakes = Mistakes(),  # noqa: B008 - a NamedTuple cannot change
) -> Detections:
    """The balls in view.

    Parameters
    ----------
    camera : Camera
    T_map_camera : ndarray, shape (4, 4)
    centres : ndarray, shape (n, 3)  [m, map]
    colours : sequence of str
    rng : numpy.random.Generator
    mistakes : Mistakes

    Returns
    -------
    Detections
    """
    away = (np.asarray(centres, float).reshape(-1, 3) - T_map_camera[:3, 3]) @ T_map_camera[:3, :3]
    order = np.argsort(away[:, 2], kind="stable")
    order = order[away[order, 2] > AHEAD]
    points = camera.pixels(_outlines(away[order]))
    framed, seen = np.empty((len(order), 4)), np.empty(len(order))
    frame_seen(points, len(_ANGLES), float(camera.width), float(camera.height), framed, seen)
    kept = np.flatnonzero(seen >= LEAST_SEEN)
    ids = [BALLS.index(colours[k]) for k in order[kept]]
    return _told(camera, framed[kept], ids, seen[kept], len(BALLS), rng, mistakes)


def silos_seen(
    camera: Camera,
    T_map_camera: FloatArray,
    fillings: Sequence[str],
    rng: np.random.Generator,
    mistakes: Mistakes = Mistakes(),  # noqa: B008 - a NamedTuple cannot change
) -> Detections:
    """The silos in view.

    Parameters
    ----------
    camera : Camera
    T_map_camera : ndarray, shape (4, 4)
    fillings : sequence of 5 str
        Of silos 1 to 5, as `vision.SILOS` writes them: ``"empty"`` for an empty one.
    rng : numpy.random.Generator
    mistakes : Mistakes

    Returns
    -------
    Detections
    """
    full = [int(len(filling) == field.SILO_CAPACITY) for filling in fillings]
    outlines = _SILOS_STANDING[full, range(len(field.SILOS))]
    away = (outlines - T_map_camera[:3, 3]) @ T_map_camera[:3, :3]
    ahead = np.flatnonzero(away[..., 2].min(axis=1) >= AHEAD)
    points = camera.pixels(away[ahead])
    boxes = np.concatenate([points.min(axis=1), points.max(axis=1)], axis=1)
    cut = np.clip(boxes, 0, (camera.width, camera.height) * 2)
    shares = _area(cut) / _area(boxes)
    kept = np.flatnonzero(shares >= LEAST_INSIDE)
    ids = [SILOS.index(fillings[k]) for k in ahead[kept]]
    return _told(camera, cut[kept], ids, shares[kept], len(SILOS), rng, mistakes)


def _area(boxes: FloatArray) -> FloatArray:
    return (boxes[:, 2] - boxes[:, 0]) * (boxes[:, 3] - boxes[:, 1])


@njit(cache=True)
def frame_seen(points, rim, width, height, boxes, shares):
    """Boxes around the seen points of things that stand one behind the other.

    Parameters
    ----------
    points : ndarray, shape (n, k, 2)  [pixels]
        Of each thing, the nearest first; the first `rim` of the k lie on its outline.
    rim : int
    width, height : float  [pixels]
        Of the picture.
    boxes : ndarray, shape (n, 4)
        Filled: left, top, right, bottom.
    shares : ndarray, shape (n,)
        Filled: how many of a thing's points are seen.
    """
    count, many = points.shape[0], points.shape[1]
    middle, radius = np.zeros((count, 2)), np.zeros(count)
    for i in range(count):
        left, right = np.inf, -np.inf
        for j in range(many):
            middle[i, 0] += points[i, j, 0] / many
            middle[i, 1] += points[i, j, 1] / many
            if j < rim:
                left, right = min(left, points[i, j, 0]), max(right, points[i, j, 0])
        radius[i] = 0.5 * (right - left)
        boxes[i, 0] = boxes[i, 1] = np.inf
        boxes[i, 2] = boxes[i, 3] = -np.inf
        seen = 0
        for j in range(many):
            x, y = points[i, j, 0], points[i, j, 1]
            shown = 0.0 < x < width and 0.0 < y < height
            for other in range(i):
                dx, dy = x - middle[other, 0], y - middle[other, 1]
                if dx * dx + dy * dy <= radius[other] ** 2:
                    shown = False
            if shown:
                seen += 1
                boxes[i, 0], boxes[i, 1] = min(boxes[i, 0], x), min(boxes[i, 1], y)
                boxes[i, 2], boxes[i, 3] = max(boxes[i, 2], x), max(boxes[i, 3], y)
        shares[i] = seen / many


def _outlines(away: FloatArray) -> FloatArray:
    """Points on the balls' outlines and inside them, (n, k, 3) [m, camera], from their middles."""
    far = np.linalg.norm(away, axis=1, keepdims=True)
    towards = away / far
    share = (0.5 * field.BALL_DIAMETER / far) ** 2
    radius = 0.5 * field.BALL_DIAMETER * np.sqrt(1.0 - np.minimum(share, 0.9))
    across = np.stack(cross(towards.T, (0.0, 1.0, 0.0)), axis=1)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    upright = np.stack(cross(towards.T, across.T), axis=1)
    flat = _DISC[None, :, :1] * across[:, None] + _DISC[None, :, 1:] * upright[:, None]
    return (away * (1.0 - share))[:, None] + radius[:, None] * flat


def _told(
    camera: Camera,
    boxes: FloatArray,
    ids: list[int],
    shares: FloatArray,
    classes: int,
    rng: np.random.Generator,
    mistakes: Mistakes,
) -> Detections:
    """What is said of the things in view."""
    count = len(boxes)
    framed = boxes + rng.normal(0.0, mistakes.edge, (count, 4))
    luck, other, doubt = rng.random((3, count))
    number = np.array(ids, np.int64)
    side = (framed[:, 2:] - framed[:, :2]).min(axis=1, initial=np.inf)
    chance = (1.0 - mistakes.miss) * np.minimum(3.0 * shares, 1.0)
    chance = chance * (1.0 - 0.5 ** np.maximum(side / mistakes.small, 0.0))
    shift = rng.integers(1, classes, count)
    number = np.where(other < mistakes.other, (number + shift) % classes, number)
    scores = (0.95 - 0.25 * doubt * (1.5 - np.minimum(shares, 1.0))).astype(np.float32)
    framed = np.clip(framed, 0, (camera.width, camera.height) * 2).astype(np.float32)
    kept = np.flatnonzero((luck < chance) & (side > 2.0))
    kept = kept[np.argsort(-scores[kept], kind="stable")]
    return Detections(framed[kept], scores[kept], number[kept])
