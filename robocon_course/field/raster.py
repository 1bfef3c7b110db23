"""How the field becomes an array: the square that every raster covers, and shapes painted into it.

The square is 12.1 m wide, fences included; row 0 lies at y = -0.05. A cell takes the value at its
middle, and a shape narrower than a cell still gets one.
"""

from __future__ import annotations

from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field.layout import FENCE_THICKNESS, SIZE, Colour, Point, Rect

ORIGIN = (-FENCE_THICKNESS, -FENCE_THICKNESS)
"""Outer corner of cell (0, 0) of every raster [m, map]."""
SPAN = SIZE + 2 * FENCE_THICKNESS
"""Side of the square that the rasters cover [m]."""


def cells_across(resolution: float) -> int:
    """How many cells a raster has on a side.

    Parameters
    ----------
    resolution : float  [m]

    Returns
    -------
    int

    Raises
    ------
    ValueError
        A resolution that does not divide 12.1 m into whole cells.
    """
    resolution = float(as_floats(resolution, "resolution"))
    count = SPAN / resolution if resolution > 0.0 else 0.0
    if count < 1.0 or abs(count - round(count)) > 1e-6:
        raise ValueError(
            f"resolution: must divide {SPAN:.1f} m into whole cells (0.01 or 0.05, say), "
            f"got {resolution!r}"
        )
    return round(count)


def middles(count: int) -> tuple[FloatArray, FloatArray]:
    """Coordinates of the middles of all cells.

    Parameters
    ----------
    count : int
        Cells on a side.

    Returns
    -------
    x : ndarray, shape (1, count)  [m, map]
    y : ndarray, shape (count, 1)  [m, map]
    """
    ticks = ORIGIN[0] + (np.arange(count) + 0.5) * (SPAN / count)
    return ticks[None, :], ticks[:, None]


def window(x0: float, y0: float, x1: float, y1: float, count: int) -> tuple[slice, slice]:
    """Rows and columns whose middles lie in a rectangle, one of each at least.

    Parameters
    ----------
    x0, y0, x1, y1 : float  [m, map]
        Lower left and upper right corner.
    count : int
        Cells on a side.

    Returns
    -------
    (slice, slice)
    """
    # A middle on an edge belongs to the rectangle further up or right, whatever rounding says.
    first = [ceil((v - ORIGIN[0]) * count / SPAN - 0.5 - 1e-6) for v in (y0, x0, y1, x1)]
    rows = slice(max(first[0], 0), max(first[2], first[0] + 1))
    cols = slice(max(first[1], 0), max(first[3], first[1] + 1))
    return rows, cols


def paint_rect(raster: NDArray[Any], rect: Rect, value: float | Colour) -> None:
    """Fill a rectangle, in place.

    Parameters
    ----------
    raster : ndarray, shape (n, n) or (n, n, 3)
    rect : Rect
    value : number or colour
    """
    raster[window(*rect[1:5], len(raster))] = value


def paint_disc(raster: NDArray[Any], centre: Point, diameter: float, value: float | Colour) -> None:
    """Fill a disc, in place.

    Parameters
    ----------
    raster : ndarray, shape (n, n) or (n, n, 3)
    centre : (float, float)  [m, map]
    diameter : float  [m]
    value : number or colour
    """
    (x, y), half = centre, diameter / 2
    rows, cols = window(x - half, y - half, x + half, y + half, len(raster))
    across, up = middles(len(raster))
    inside = np.hypot(across[:, cols] - x, up[rows] - y) <= half
    raster[rows, cols][inside] = value


def mirror(raster: NDArray[Any]) -> None:
    """Overwrite the opponent's half with the mirror image of ours, in place.

    Parameters
    ----------
    raster : ndarray, shape (n, n) or (n, n, 3)
    """
    half = len(raster) // 2
    raster[:, len(raster) - half :] = raster[:, :half][:, ::-1]
