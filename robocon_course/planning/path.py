"""A way as a row of points: how long it is, and the same way with fewer or evenly spread points."""

from __future__ import annotations

from math import ceil

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import distance_along


def as_path(xy: ArrayLike) -> FloatArray:
    """A way, checked.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    ndarray, shape (n, 2)  [m, map]

    Raises
    ------
    ValueError
        Another shape, no points, or not finite.
    """
    points = as_floats(xy, "xy", None, 2)
    if not len(points):
        raise ValueError("xy: a way has at least one point, got none")
    return points


def as_positive(value: float, name: str) -> float:
    """A positive number, checked.

    Parameters
    ----------
    value : float
    name : str
        Name of the argument, for the message.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        Not finite or not positive.
    """
    number = float(as_floats(value, name))
    if number <= 0.0:
        raise ValueError(f"{name}: must be positive, got {value!r}")
    return number


def path_length(xy: ArrayLike) -> float:
    """Length of a way.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    float  [m]

    Raises
    ------
    ValueError
        Another shape, or not finite.
    """
    return float(distance_along(xy)[-1])


def thin_path(xy: ArrayLike, spacing: float) -> FloatArray:
    """Keep of a way's points only one every so often.

    It cuts corners, by up to half the spacing: look at the clearance afterwards, or use
    `shorten_path`, which knows the map.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]
    spacing : float  [m]
        Along the way, between the points kept; the last is kept in any case.

    Returns
    -------
    ndarray, shape (m, 2)  [m, map]

    Raises
    ------
    ValueError
        Another shape, not finite, or a spacing that is not positive.

    Examples
    --------
    >>> thin_path([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]], 2.0).tolist()
    [[0.0, 0.0], [2.0, 0.0], [3.0, 0.0]]
    """
    points, spacing = as_path(xy), as_positive(spacing, "spacing")
    # What rounding took from the sum of many steps must not cost a point.
    place = np.floor(distance_along(points) / spacing + 1e-9)
    keep = np.diff(place, prepend=-1.0) > 0.0
    keep[-1:] = True
    return points[keep]


def resample_path(xy: ArrayLike, spacing: float) -> FloatArray:
    """Points on the legs of a way, evenly spread along it.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]
    spacing : float  [m]
        At most; a whole number of equal pieces makes up the way.

    Returns
    -------
    ndarray, shape (m, 2)  [m, map]
        With the first and the last point; corners in between are cut like in `thin_path`.

    Raises
    ------
    ValueError
        Another shape, not finite, or a spacing that is not positive.

    Examples
    --------
    >>> resample_path([[0.0, 0.0], [3.0, 0.0]], 1.1).round(3).tolist()
    [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]
    """
    points, spacing = as_path(xy), as_positive(spacing, "spacing")
    along = distance_along(points)
    pieces = ceil(along[-1] / spacing - 1e-9)
    if pieces == 0:
        return points[:1].copy()
    at = np.linspace(0.0, along[-1], pieces + 1)
    return np.column_stack([np.interp(at, along, axis) for axis in points.T])


def subdivided(xy: ArrayLike, spacing: float) -> FloatArray:
    """All points of a way, and as many between them as make its legs short.

    Parameters
    ----------
    xy : array_like, shape (n, 2)  [m, map]
    spacing : float  [m]
        At most.

    Returns
    -------
    ndarray, shape (m, 2)  [m, map]

    Raises
    ------
    ValueError
        Another shape, not finite, or a spacing that is not positive.
    """
    points, spacing = as_path(xy), as_positive(spacing, "spacing")
    legs = np.hypot(*np.diff(points, axis=0).T)
    counts = np.ceil(legs / spacing - 1e-9).clip(1).astype(np.int64)
    parts = [
        a + (b - a) * np.arange(count)[:, None] / count
        for a, b, count in zip(points[:-1], points[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, points[-1:]])
