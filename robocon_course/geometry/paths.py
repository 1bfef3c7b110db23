"""Ways as rows of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats


def distance_along(xy: ArrayLike) -> FloatArray:
    """Distance gone along a way until each of its points.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m]

    Returns
    -------
    ndarray, shape (n,)  [m]

    Raises
    ------
    ValueError
        Another shape, no points, or not finite.

    Examples
    --------
    >>> distance_along([[0, 0], [3, 4], [3, 5]]).tolist()
    [0.0, 5.0, 6.0]
    """
    points = as_floats(xy, "xy", None, 2)
    if not len(points):
        raise ValueError("xy: a way has at least one point, got none")
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
