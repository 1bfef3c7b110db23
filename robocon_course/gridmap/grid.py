"""A map of square cells, and from points to cells and back.

Cell (row, col) covers the square from origin + resolution (col, row) to one resolution further, so
row 0 lies at the smallest y and a point (x, y) belongs to

    col = floor((x - x0) / resolution),    row = floor((y - y0) / resolution)

Anything outside the map is not free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats, as_vectors

BoolArray = NDArray[np.bool_]

SNAP = 1e-9
"""So near to an edge a point lies on it [cells]: what rounding took away must not cost a cell."""
FARTHEST = 2.0**62
"""Cell numbers end here: as a float it is exact, and an int64 holds it."""


@dataclass(frozen=True, eq=False)
class GridMap:
    """A map of square cells, each free or not; it cannot change.

    Attributes
    ----------
    free : ndarray of bool, shape (rows, cols)
        True where the robot may be; row 0 at the smallest y. A read-only copy of what was given.
    resolution : float  [m]
        Side of a cell.
    origin : (float, float)  [m, map]
        Outer corner of cell (0, 0): smallest x and y of the map.

    Raises
    ------
    ValueError
        ``free`` is not two-dimensional bool or has no cells, the resolution is not positive, or
        the origin is not two finite numbers.
    """

    free: BoolArray
    resolution: float
    origin: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        free = np.array(self.free, order="C")
        if free.dtype != np.bool_ or free.ndim != 2 or free.size == 0:
            raise ValueError(
                "free: expected a two-dimensional array of bool (True = free), "
                f"got {free.dtype} of shape {free.shape}"
            )
        free.setflags(write=False)
        x, y = as_floats(self.origin, "origin", 2)
        resolution = float(as_floats(self.resolution, "resolution"))
        if resolution <= 0.0:
            raise ValueError(f"resolution: must be a positive number of metres, got {resolution}")
        object.__setattr__(self, "free", free)
        object.__setattr__(self, "resolution", resolution)
        object.__setattr__(self, "origin", (float(x), float(y)))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and columns."""
        rows, cols = self.free.shape
        return rows, cols

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Outer edges (x0, x1, y0, y1) [m, map], as matplotlib's ``imshow`` takes them."""
        (x, y), (rows, cols) = self.origin, self.shape
        return x, x + cols * self.resolution, y, y + rows * self.resolution

    def cells(self, xy: ArrayLike) -> NDArray[np.int64]:
        """The cells that points lie in; on a shared edge the cell further up or right.

        Parameters
        ----------
        xy : array_like, shape (..., 2)  [m, map]

        Returns
        -------
        ndarray of int64, shape (..., 2)
            (row, col); outside the map it is negative or too large: ask `contains`. Beyond 2**62
            cells, far off any map, it is 2**62.

        Raises
        ------
        ValueError
            Another last axis, or an entry that is not finite.
        """
        if not np.isfinite(as_vectors(xy, "xy", 2)).all():
            raise ValueError("xy: a point that is not finite lies in no cell; remove it first")
        return np.floor(self.to_cells(xy)).clip(-FARTHEST, FARTHEST).astype(np.int64)

    def to_cells(self, xy: ArrayLike) -> FloatArray:
        """Points counted in cells: cell (r, c) covers r to r + 1 and c to c + 1.

        Parameters
        ----------
        xy : array_like, shape (..., 2)  [m, map]

        Returns
        -------
        ndarray, shape (..., 2)  [cells]
            (row, col). Within a billionth of a cell of an edge it is the edge itself: 0.35 m is
            7 cells of 0.05 m, not the 6.999... that rounding makes of it. What is not finite
            stays so.

        Raises
        ------
        ValueError
            Another last axis.

        Examples
        --------
        >>> GridMap(np.ones((4, 10), dtype=bool), 0.05).to_cells([0.35, 0.12]).round(9).tolist()
        [2.4, 7.0]
        """
        points = as_vectors(xy, "xy", 2)
        with np.errstate(over="ignore", invalid="ignore"):
            cells = ((points - self.origin) / self.resolution)[..., ::-1]
            edges = np.rint(cells)
            return np.where(np.abs(cells - edges) <= SNAP, edges, cells)

    def centres(self, cells: ArrayLike) -> FloatArray:
        """Middle points of cells.

        Parameters
        ----------
        cells : array_like, shape (..., 2)
            (row, col); they need not lie in the map.

        Returns
        -------
        ndarray, shape (..., 2)  [m, map]

        Raises
        ------
        ValueError
            Another last axis.
        """
        cells = as_vectors(cells, "cells", 2)
        return (cells[..., ::-1] + 0.5) * self.resolution + self.origin

    def contains(self, xy: ArrayLike) -> BoolArray:
        """Whether points lie in the map; a point that is not finite does not.

        Parameters
        ----------
        xy : array_like, shape (..., 2)  [m, map]

        Returns
        -------
        ndarray of bool, shape (...)

        Raises
        ------
        ValueError
            Another last axis.
        """
        cells = self.to_cells(xy)
        return ((cells >= 0) & (cells < self.shape)).all(axis=-1)

    def is_free(self, xy: ArrayLike) -> BoolArray:
        """Whether points lie in free cells; outside the map nothing is free.

        Parameters
        ----------
        xy : array_like, shape (..., 2)  [m, map]

        Returns
        -------
        ndarray of bool, shape (...)

        Raises
        ------
        ValueError
            Another last axis.
        """
        cells, inside = self.to_cells(xy), self.contains(xy)
        row, col = np.where(inside[..., None], cells, 0.0).astype(np.int64).T
        return inside & self.free[row, col].T
