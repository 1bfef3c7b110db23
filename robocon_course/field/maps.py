"""The field as tables and rasters: floor under the wheels, obstacles, what a beam hits.

All rasters cover the same square of 12.1 m, fences included; row 0 lies at y = -0.05.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field import layout
from robocon_course.field.layout import Rect
from robocon_course.gridmap import GridMap

ORIGIN = (-layout.FENCE_THICKNESS, -layout.FENCE_THICKNESS)
"""Outer corner of the rasters' cell (0, 0) [m, map]."""
SPAN = layout.SIZE + 2 * layout.FENCE_THICKNESS
"""Side of the square that the rasters cover [m]."""

FLOOR_TABLE: FloatArray = np.array(
    [
        (r.x0, r.y0, r.x1, r.y1, r.height, *r.slope)
        for r in (*layout.FLOOR, layout.RAMP_1, layout.RAMP_2)
    ]
)
"""Floor of our half and the middle strip, for kernels, (10, 7): x0, y0, x1, y1, height, slope_x,
slope_y; where rows overlap, the later one holds. The water basin counts as Area 2."""
FLOOR_TABLE.setflags(write=False)


def floor_height(x: ArrayLike, y: ArrayLike) -> FloatArray:
    """Height of the floor, ramps included, without what stands on it.

    Parameters
    ----------
    x, y : array_like, broadcast together  [m, map]
        Both halves; outside the fence it is the height of the nearest floor.

    Returns
    -------
    ndarray  [m above the ground under the stage]

    Raises
    ------
    ValueError
        Not finite, or shapes that do not fit together.

    Examples
    --------
    Foot, middle and top of ramp 1:

    >>> floor_height(0.5, [3.0, 3.5, 4.0]).round(3).tolist()
    [0.05, 0.1, 0.15]
    """
    x = as_floats(x, "x", *(None,) * np.ndim(x))
    y = as_floats(y, "y", *(None,) * np.ndim(y))
    x, y = np.broadcast_arrays(x.clip(0.0, layout.SIZE), y.clip(0.0, layout.SIZE))
    x = np.minimum(x, layout.SIZE - x)  # the other half mirrors ours
    height = np.full(x.shape, np.nan)
    for x0, y0, x1, y1, foot, slope_x, slope_y in FLOOR_TABLE:
        here = (x0 <= x) & (x <= x1) & (y0 <= y) & (y <= y1)
        height = np.where(here, foot + slope_x * (x - x0) + slope_y * (y - y0), height)
    return height


def obstacle_map(resolution: float = 0.01) -> GridMap:
    """Where the chassis may be: a cell that an obstacle overlaps, however little, is not free.

    Parameters
    ----------
    resolution : float  [m]
        Has to divide 12.1 m into whole cells.

    Returns
    -------
    GridMap
        Of the 12.1 m square around both halves; only our half has free cells.

    Raises
    ------
    ValueError
        A resolution that does not divide 12.1 m.
    """
    return _obstacle_map(_cells_across(resolution), float(resolution))


@cache
def _obstacle_map(count: int, resolution: float) -> GridMap:
    """`obstacle_map`, once per resolution."""
    free = np.ones((count, count), dtype=bool)
    for rect in layout.OBSTACLES:
        edges = (np.array(rect[1:5]) - (*ORIGIN, *ORIGIN)) / resolution
        x0, y0 = np.floor(edges[:2] + 1e-6).astype(int)
        x1, y1 = np.ceil(edges[2:] - 1e-6).astype(int)
        free[y0:y1, x0:x1] = False
    return GridMap(free, resolution, ORIGIN)


def height_map(resolution: float = 0.01) -> NDArray[np.float32]:
    """Height of the highest thing at every place: what a beam of light can hit.

    Floor, ramps, fences, water frame, rack, dividers, silo strip, and silos as full cylinders;
    no balls and no robots.

    Parameters
    ----------
    resolution : float  [m]
        Has to divide 12.1 m into whole cells.

    Returns
    -------
    ndarray of float32, shape (n, n)  [m above the ground under the stage]
        Of the 12.1 m square; read-only. A cell has the height at its middle.

    Raises
    ------
    ValueError
        A resolution that does not divide 12.1 m.
    """
    return _height_map(_cells_across(resolution))


@cache
def _height_map(count: int) -> NDArray[np.float32]:
    """`height_map`, once per resolution."""
    x, y = _middles(count)
    height = floor_height(x, y)
    for rect in (layout.WATER_FRAME, layout.WATER, layout.WATER_BACK, *_STANDING):
        height[_inside(rect, x, y)] = rect.height
    for silo in layout.SILOS:
        disc = np.hypot(x - silo[0], y - silo[1]) < layout.SILO_DIAMETER / 2
        height[disc] = layout.SILO_ZONE.height + layout.SILO_HEIGHT
    height = height.astype(np.float32)
    height.setflags(write=False)
    return height


_STANDING = (*layout.FENCES, layout.SEEDLING_RACK)


def _cells_across(resolution: float) -> int:
    """How many cells the rasters have on a side."""
    resolution = float(as_floats(resolution, "resolution"))
    count = SPAN / resolution if resolution > 0.0 else 0.0
    if count < 1.0 or abs(count - round(count)) > 1e-6:
        raise ValueError(
            f"resolution: must divide {SPAN:.1f} m into whole cells (0.01 or 0.05, say), "
            f"got {resolution!r}"
        )
    return round(count)


def _middles(count: int) -> tuple[FloatArray, FloatArray]:
    """Coordinates x (1, n) and y (n, 1) of the middles of the cells."""
    ticks = ORIGIN[0] + (np.arange(count) + 0.5) * (SPAN / count)
    return ticks[None, :], ticks[:, None]


def _inside(rect: Rect, x: FloatArray, y: FloatArray) -> NDArray[np.bool_]:
    """Which points lie in a rectangle of our half, or in its mirror image."""
    x = np.minimum(x, layout.SIZE - x)
    return (rect.x0 <= x) & (x <= rect.x1) & (rect.y0 <= y) & (y <= rect.y1)
