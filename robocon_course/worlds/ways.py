"""The planning world of chapter 04: the game field with boxes that belong to one student."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, freeze_arrays, frozen
from robocon_course.gridmap import GridMap, inflate, inflate_square, put_boxes
from robocon_course.planning import NoPathError, astar, resample_path
from robocon_course.robot import SIDE
from robocon_course.tracking import path_curvature, profile_times, speed_profile
from robocon_course.worlds.student import Student, generator

HALF = SIDE / 2
"""Half the side of the robot's body [m]."""
COARSE, FINE = 0.05, 0.01
"""Cells for plain Python, and for what is compiled [m]."""
RAMP_TOP = (0.6, 4.65)
"""Where ramp 1 ends, with more than half a metre of room around it [m, map]."""
ZONES = ((5, 85, 560, 255), (5, 425, 560, 665), (335, 835, 560, 1160))
"""Corners of where boxes stand, in Areas 1, 2 and 3 [cm, map]."""
KEPT_FREE = ((0, 400, 125, 530), (365, 640, 495, 850), (365, 935, 495, 1065))
"""Top of ramp 1, ramp 2 and the goal [cm, map]."""
NUMBERS = (4, 6, 3)
SIZES = (25, 75)  # cm
NARROWEST, WIDEST = 0.36, 0.48
"""Half sides between which the narrowest passage lies [m]."""


@dataclass(frozen=True)
class WaysWorld:
    """One student's field.

    Attributes
    ----------
    boxes : ndarray, shape (n, 4)  [m, map]
        Corners (x0, y0, x1, y1) of the boxes that the student knows of.
    hidden : ndarray, shape (m, 4)  [m, map]
        Boxes that only the robot finds, on its way.
    start, goal : (float, float)  [m, map]
    grid : GridMap
        Field and boxes, in cells of 5 cm.
    fine : GridMap
        The same in cells of 1 cm.
    truth : GridMap
        With the hidden boxes, in cells of 5 cm.
    """

    boxes: FloatArray
    hidden: FloatArray
    start: tuple[float, float]
    goal: tuple[float, float]
    grid: GridMap
    fine: GridMap
    truth: GridMap

    __post_init__ = freeze_arrays


@functools.lru_cache(maxsize=16)
def ways_world(student: Student) -> WaysWorld:
    """One student's field: the same to the bit on every machine.

    Boxes are drawn until there is a way, boxes and corners matter to it, and the narrowest
    passage is one between boxes.

    Parameters
    ----------
    student : int or str
        Student number.

    Returns
    -------
    WaysWorld
    """
    rng = generator(student, "own boxes")
    while True:
        boxes = strewn_boxes(rng)
        grid, fine = (boxed_field(boxes, cell) for cell in (COARSE, FINE))
        if _is_telling(grid) and NARROWEST < (half := widest_half(fine)) < WIDEST:
            if widest_half(grid) < half:
                break
    way = way_length(inflate_square(grid, HALF))
    while True:
        hidden = strewn_boxes(rng, (0, 3, 1))
        truth = put_boxes(grid, hidden)
        if way + 0.1 < way_length(inflate_square(truth, HALF)) < 1.5 * way:
            break
    ends = field.START, field.AREA_3_GOAL
    return WaysWorld(frozen(boxes), frozen(hidden), *ends, grid, fine, truth)


def strewn_boxes(rng: np.random.Generator, numbers: Sequence[int] = NUMBERS) -> FloatArray:
    """Boxes strewn over Areas 1 to 3, beside ramp, goal and each other's like.

    Parameters
    ----------
    rng : numpy.random.Generator
    numbers : sequence of int
        How many in each area.

    Returns
    -------
    ndarray, shape (n, 4)  [m, map]
        Corners (x0, y0, x1, y1), in whole centimetres.
    """
    boxes = []
    for (x0, y0, x1, y1), count in zip(ZONES, numbers, strict=True):
        wanted = len(boxes) + count
        while len(boxes) < wanted:
            width, height = rng.integers(*SIZES, 2).tolist()
            left, low = int(rng.integers(x0, x1 - width)), int(rng.integers(y0, y1 - height))
            box = left, low, left + width, low + height
            if not any(_overlap(box, other) for other in (*boxes, *KEPT_FREE)):
                boxes.append(box)
    return np.array(boxes) / 100.0


def _overlap(one: Sequence[int], other: Sequence[int]) -> bool:
    return (
        one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
    )  # fmt: skip


def boxed_field(boxes: ArrayLike, resolution: float = COARSE) -> GridMap:
    """The game field with boxes on it.

    Parameters
    ----------
    boxes : array_like, shape (n, 4)  [m, map]
    resolution : float  [m]

    Returns
    -------
    GridMap
    """
    return put_boxes(field.obstacle_map(resolution), boxes)


def passable_field(rng: np.random.Generator) -> GridMap:
    """The game field with other boxes each time, and always with a way for the robot.

    Parameters
    ----------
    rng : numpy.random.Generator

    Returns
    -------
    GridMap
        In cells of 5 cm, not inflated.
    """
    while True:
        grid = boxed_field(strewn_boxes(rng))
        if way_length(inflate_square(grid, HALF)) < float("inf"):
            return grid


def way_length(
    room: GridMap,
    start: ArrayLike = field.START,
    goal: ArrayLike = field.AREA_3_GOAL,
    *,
    cut_corners: bool = False,
) -> float:
    """Length of the shortest way through a room for the robot's middle.

    Parameters
    ----------
    room : GridMap
        Inflated already.
    start, goal : array_like, shape (2,)  [m, map]
    cut_corners : bool
        As in `planning.astar`.

    Returns
    -------
    float  [m]
        Infinity where there is none.
    """
    try:
        return astar(room, start, goal, cut_corners=cut_corners).length
    except NoPathError:
        return float("inf")


def widest_half(grid: GridMap) -> float:
    """Half the side of the largest square, in whole cm, that gets from ramp 1 to the goal.

    Parameters
    ----------
    grid : GridMap
        Not inflated.

    Returns
    -------
    float  [m]
        0 where nothing gets there.
    """
    fits, fails = 0, 60
    while fails - fits > 1:
        tried = (fits + fails) // 2
        room = inflate_square(grid, tried / 100.0)
        if way_length(room, RAMP_TOP) < float("inf"):
            fits = tried
        else:
            fails = tried
    return fits / 100.0


def wrong_lengths(grid: GridMap) -> dict[str, float]:
    """Lengths of the ways that come of usual slips, and of the right one.

    Parameters
    ----------
    grid : GridMap
        Not inflated.

    Returns
    -------
    dict of float  [m]
        ``right``, and what comes with ``corners`` cut, with a ``disc`` for the body, without its
        ``size``, and on the field without ``boxes``.
    """
    room = inflate_square(grid, HALF)
    return {
        "right": way_length(room),
        "corners": way_length(room, cut_corners=True),
        "disc": way_length(inflate(grid, HALF)),
        "size": way_length(grid),
        "boxes": way_length(inflate_square(field.obstacle_map(grid.resolution), HALF)),
    }


def _is_telling(grid: GridMap) -> bool:
    """Whether there is a way, and every usual slip changes it."""
    lengths = np.array(sorted(wrong_lengths(grid).values()))
    return bool(np.isfinite(lengths).all() and np.diff(lengths).min() > 0.015)


def driving_time(xy: ArrayLike, max_curvature: float) -> float:
    """How long the robot takes for a way, from rest to rest.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]
    max_curvature : float  [1/m]
        Where the way bends more than that, by a quarter or further, the modules cannot follow: the
        robot stops and goes on from rest.

    Returns
    -------
    float  [s]
        With at most 2 m/s, 2 m/s^2 along the way and 3 m/s^2 across it, on points 5 cm apart.
    """
    points = resample_path(xy, 0.05)
    if len(points) < 2:
        return 0.0
    tight = np.flatnonzero(np.abs(path_curvature(points)) > 1.25 * max_curvature)
    stops = [0, *tight.tolist(), len(points) - 1]
    return sum(_leg_time(points[a : b + 1]) for a, b in pairwise(stops) if a < b)


def _leg_time(points: FloatArray) -> float:
    """Time for a leg from rest to rest."""
    if len(points) == 2:  # between two stops it needs a point to be fast at
        points = np.array([points[0], points.mean(axis=0), points[1]])
    return float(profile_times(points, speed_profile(points, 2.0, 2.0, 3.0))[-1])
