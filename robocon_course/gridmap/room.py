"""What stands on a map, and what room it leaves for a robot with a size."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import as_distance, as_floats
from robocon_course.gridmap.grid import GridMap


def put_boxes(grid: GridMap, boxes: ArrayLike) -> GridMap:
    """The map with boxes standing on it: a cell that one overlaps, however little, is not free.

    Parameters
    ----------
    grid : GridMap
    boxes : array_like, shape (n, 4)  [m, map]
        Corners (x0, y0, x1, y1) with x0 <= x1 and y0 <= y1; they may stand out over the map.

    Returns
    -------
    GridMap

    Raises
    ------
    ValueError
        Another shape, not finite, or corners in another order.

    Examples
    --------
    >>> put_boxes(GridMap(np.ones((2, 3), dtype=bool), 1.0), [[0.5, 0.0, 2.0, 1.0]]).free.tolist()
    [[False, False, True], [True, True, True]]
    """
    boxes = as_floats(boxes, "boxes", None, 4)
    if (boxes[:, :2] > boxes[:, 2:]).any():
        raise ValueError("boxes: expected corners (x0, y0, x1, y1) with x0 <= x1 and y0 <= y1")
    first = np.floor(grid.to_cells(boxes[:, :2])).clip(0, grid.shape).astype(np.int64)
    end = np.ceil(grid.to_cells(boxes[:, 2:])).clip(0, grid.shape).astype(np.int64)
    free = grid.free.copy()
    for (row, col), (last_row, last_col) in zip(first, end, strict=True):
        free[row:last_row, col:last_col] = False
    return GridMap(free, grid.resolution, grid.origin)


def inflate(grid: GridMap, radius: float) -> GridMap:
    """The map for a round robot's middle: free where the whole robot has room.

    A cell stays free if every one of its points is at least ``radius`` away from every point of
    every cell that is not free, and from the edge of the map: what lies outside is unknown.

    Parameters
    ----------
    grid : GridMap
    radius : float  [m]
        0 changes nothing.

    Returns
    -------
    GridMap

    Raises
    ------
    ValueError
        Negative or not finite.

    Notes
    -----
    Two squares (r, c) cells apart leave a gap of (|r| - 1, |c| - 1), not below 0. So the distance
    between squares is the distance between middles once the obstacles have grown by one cell.

    Examples
    --------
    >>> free = np.ones((5, 5), dtype=bool)
    >>> inflate(GridMap(free, 1.0), 2.0).free.sum()
    np.int64(1)
    """
    import cv2

    radius = as_distance(radius, "radius")
    room = cv2.erode(np.pad(grid.free, 2).view(np.uint8), np.ones((3, 3), np.uint8))
    distance = cv2.distanceTransform(room, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[2:-2, 2:-2]
    # Squared, a distance in cells is a whole number: rounded, it is exact.
    squared, cells = np.square(distance, dtype=np.float64), radius / grid.resolution
    np.rint(squared, out=squared)
    wide = squared >= cells * cells * (1.0 - 1e-9)
    del distance, squared  # twelve bytes a cell, before the map takes its own
    return GridMap(grid.free & wide, grid.resolution, grid.origin)


def inflate_square(grid: GridMap, half: float) -> GridMap:
    """The map for the middle of a square robot that keeps its heading along the map's axes.

    A cell stays free if every one of its points is at least ``half`` away, in x or in y, from
    every point of every cell that is not free, and from the edge of the map. `inflate` asks for
    a distance: a square that fits by it hits an obstacle's corner with its own.

    Parameters
    ----------
    grid : GridMap
    half : float  [m]
        Half the side of the body; 0 changes nothing.

    Returns
    -------
    GridMap

    Raises
    ------
    ValueError
        Negative or not finite.

    Notes
    -----
    Two cells n rows apart leave a gap of n - 1 cells between them. So what is not free blocks all
    cells up to ceil(half / resolution) rows and columns away.

    Examples
    --------
    >>> free = np.ones((5, 5), dtype=bool)
    >>> inflate_square(GridMap(free, 1.0), 1.5).free.sum()
    np.int64(1)
    """
    import cv2

    half = as_distance(half, "half")
    # What rounding adds to a quotient must not cost a cell; beyond the whole map nothing changes.
    reach = ceil(min(half / grid.resolution, float(max(grid.shape))) - 1e-9)
    blocked = np.pad(~grid.free, 1, constant_values=True).astype(np.uint8)
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    grown = cv2.dilate(blocked, square)[1:-1, 1:-1].astype(bool) if reach else ~grid.free
    return GridMap(~grown, grid.resolution, grid.origin)
