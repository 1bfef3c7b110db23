"""How far does a beam get? Walk along it, from cell to cell, until one stands in its way.

Along the ray (x + t dx, y + t dy), with t the distance gone, the next column begins at

    t_x = (column's edge - x) / dx,    and one more every 1 / |dx|

and likewise the next row. The smaller of the two comes first: no cell is left out, none is asked
twice, and the distance to a cell's edge is exact. Simulator, localization and mapping share this
one kernel.

Source: J. Amanatides, A. Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987.
"""

from __future__ import annotations

from math import cos, floor, inf, sin

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats, as_vectors
from robocon_course.gridmap import GridMap

ALONG = 1e-15
"""A ray that slants by less never leaves its row or column, and 1 / slant stays a number."""


@njit(cache=True)
def walk(height, x, y, z, dx, dy, dz, reach, cells):
    """How far a ray gets over a field of heights, and the cells that it visits.

    It stops where it goes below the surface: at the edge of a cell that is higher than the ray, or
    inside one that the ray comes down on. A start below the surface gives 0. A ray that leaves the
    array, or starts outside it, gives ``reach``. Through a corner it visits one of the two cells
    beside it. The kernel trusts its input.

    Parameters
    ----------
    height : ndarray, shape (rows, cols)  [m]
        Top of what stands in each cell.
    x, y : float  [cells]
        Start; x along the columns, y along the rows. Cell (row, col) begins at x = col, y = row.
    z : float  [m]
        Height of the start.
    dx, dy : float
        Horizontal direction, a unit vector.
    dz : float  [m per cell]
        What the ray climbs per cell of horizontal way.
    reach : float  [cells]
        Where it ends at the latest.
    cells : ndarray of int64, shape (m, 2)
        Receives (row, col) of the cells visited, the one that stopped it included, in order and as
        many as fit; m may be 0.

    Returns
    -------
    (float, int)
        Horizontal distance [cells], and the number of cells visited, those that did not fit too.
    """
    rows, cols = height.shape
    room = len(cells)
    col, row = floor(x), floor(y)
    step_x, step_y = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    every_x = 1.0 / abs(dx) if abs(dx) > ALONG else inf
    every_y = 1.0 / abs(dy) if abs(dy) > ALONG else inf
    next_x = (col + 1 - x if dx > 0.0 else x - col) * every_x if abs(dx) > ALONG else inf
    next_y = (row + 1 - y if dy > 0.0 else y - row) * every_y if abs(dy) > ALONG else inf
    falls = dz < 0.0
    t, visited = 0.0, 0
    while 0 <= row < rows and 0 <= col < cols and t < reach:
        if visited < room:
            cells[visited, 0] = row
            cells[visited, 1] = col
        visited += 1
        across = next_x < next_y
        leave = next_x if across else next_y
        top = float(height[row, col])
        if top > z + dz * (leave if falls else t):  # the ray's lowest point in this cell
            if top > z + dz * t:
                return t, visited
            return min((top - z) / dz, reach), visited
        t = leave
        if across:
            col += step_x
            next_x += every_x
        else:
            row += step_y
            next_y += every_y
    return reach, visited


@njit(cache=True)
def cast(blocked, rays, reach, out):
    """`walk` over a flat map for many rays; ``out`` takes their lengths.

    It stands beside the kernel it compiles in: numba looks only here for changes.

    Parameters
    ----------
    blocked : ndarray of uint8, shape (rows, cols)
        1 where a cell stops the ray, 0 where not.
    rays : ndarray, shape (n, 3)  [cells, cells, rad]
        Start and direction.
    reach : float  [cells]
    out : ndarray, shape (n,)  [cells]
    """
    no_cells = np.empty((0, 2), np.int64)
    for k in range(len(rays)):
        x, y, angle = rays[k]
        out[k], _ = walk(blocked, x, y, 0.5, cos(angle), sin(angle), 0.0, reach, no_cells)


def distances(grid: GridMap, origins: ArrayLike, angles: ArrayLike, max_range: float) -> FloatArray:
    """Distance from points to the first cell that is not free, along given directions.

    Parameters
    ----------
    grid : GridMap
    origins : array_like, shape (..., 2)  [m, map]
        Where the rays start.
    angles : array_like, shape (...)  [rad, map]
        Their directions; broadcast against the origins.
    max_range : float  [m]
        What a ray measures that meets nothing, leaves the map, or starts outside it.

    Returns
    -------
    ndarray, shape (...)  [m]
        0 where the start itself is not free, which on an edge is the cell that `GridMap.cells`
        names.

    Raises
    ------
    ValueError
        Shapes that do not fit together, an entry that is not finite, or a range that is not
        positive.

    Notes
    -----
    Amanatides and Woo 1987, section 2. One ray from each of n points takes origins (n, 2) and
    angles (n,); k rays from each take origins (n, 1, 2) and angles (k,).

    Examples
    --------
    >>> grid = GridMap(np.array([[True, True, True, False]]), 0.5)
    >>> distances(grid, [0.2, 0.2], [0.0, np.pi], 4.0).round(3).tolist()
    [1.3, 4.0]
    """
    origins, angles = as_vectors(origins, "origins", 2), np.asarray(angles)
    as_floats(origins.ravel(), "origins", None)
    angles = as_floats(angles, "angles", *(None,) * angles.ndim)
    if not 0.0 < max_range < inf:
        raise ValueError(f"max_range: must be a positive number of metres, got {max_range!r}")
    try:
        shape = np.broadcast_shapes(origins.shape[:-1], angles.shape)
    except ValueError:
        raise ValueError(
            f"angles: shape {angles.shape} does not fit origins of shape {origins.shape}; "
            "k rays from each of n points take origins (n, 1, 2) and angles (k,)"
        ) from None
    rays = np.empty((*shape, 3))
    rays[..., :2] = grid.to_cells(origins)[..., ::-1]
    rays[..., 2] = angles
    out = np.empty(shape)
    blocked = np.logical_not(grid.free).view(np.uint8)
    cast(blocked, rays.reshape(-1, 3), max_range / grid.resolution, out.reshape(-1))
    return out * grid.resolution
