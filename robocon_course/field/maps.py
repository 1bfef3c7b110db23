"""The field as tables and maps: floor under the wheels, obstacles, what a beam hits."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field import layout, raster
from robocon_course.field.raster import ORIGIN
from robocon_course.gridmap import GridMap, put_boxes

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
    try:
        x, y = np.broadcast_arrays(x.clip(0.0, layout.SIZE), y.clip(0.0, layout.SIZE))
    except ValueError:
        raise ValueError(
            f"y: shape {y.shape} does not fit x of shape {x.shape}; give one y for each x"
        ) from None
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
    return _obstacle_map(raster.cells_across(resolution), float(resolution))


@cache
def _obstacle_map(count: int, resolution: float) -> GridMap:
    """`obstacle_map`, once per resolution."""
    grid = GridMap(np.ones((count, count), dtype=bool), resolution, ORIGIN)
    return put_boxes(grid, [rect[1:5] for rect in layout.OBSTACLES])


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
    return _height_map(raster.cells_across(resolution))


@cache
def _height_map(count: int) -> NDArray[np.float32]:
    """`height_map`, once per resolution."""
    height = floor_height(*raster.middles(count)).astype(np.float32)
    for rect in (layout.WATER_FRAME, layout.WATER, layout.WATER_BACK, layout.SEEDLING_RACK):
        raster.paint_rect(height, rect, rect.height)
    for rect in layout.FENCES:
        raster.paint_rect(height, rect, rect.height)
    raster.mirror(height)
    for silo in layout.SILOS:
        top = layout.SILO_ZONE.height + layout.SILO_HEIGHT
        raster.paint_disc(height, silo, layout.SILO_DIAMETER, top)
    height.setflags(write=False)
    return height
