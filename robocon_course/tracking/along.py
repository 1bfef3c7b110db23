"""Many poses of one drive: the nearest point of the path to each, found going along it.

The kernel compiles in that of `polyline`: after an edit there, touch this file.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.tracking.polyline import as_path, nearest

REACH = 0.3
"""So much of the path is searched past the nearest point so far [m]."""


class PathPoints(NamedTuple):
    """Points on a path, one for each pose.

    Attributes
    ----------
    xy : ndarray, shape (n, 2)  [m, map]
    cross_track : ndarray, shape (n,)  [m]
        Distance of the pose from it; positive to the left of the path.
    """

    xy: FloatArray
    cross_track: FloatArray


@njit(cache=True)
def walk(path, poses, reach, feet, away):
    """Nearest point of a path to each pose, one after the other; it trusts its input.

    Parameters
    ----------
    path : ndarray, shape (n, 2)  [m, map]
    poses : ndarray, shape (m, 2) or (m, 3)  [m, map]
    reach : float  [m]
    feet : ndarray, shape (m, 2)  [m, map]
    away : ndarray, shape (m,)  [m]
        Take the result: places, and distances, positive to the left.
    """
    index = 0
    for k in range(len(poses)):
        x, y = poses[k, 0], poses[k, 1]
        index, _, fx, fy, far = nearest(path, x, y, index, reach)
        dx, dy = path[index + 1, 0] - path[index, 0], path[index + 1, 1] - path[index, 1]
        feet[k, 0], feet[k, 1] = fx, fy
        away[k] = far if dx * (y - fy) - dy * (x - fx) >= 0.0 else -far


def nearest_points(path: ArrayLike, poses: ArrayLike, *, reach: float = REACH) -> PathPoints:
    """The nearest point of a path to each pose of a drive along it.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    poses : array_like, shape (m, 3)  [m, m, rad; map]
        In the order of the drive; the first lies near the path's beginning.
    reach : float  [m]
        As in `nearest_point`.

    Returns
    -------
    PathPoints

    Raises
    ------
    ValueError
        No path, another shape, a pose that is not finite, or a reach that is not positive.

    Examples
    --------
    >>> nearest_points([[0.0, 0.0], [2.0, 0.0]], [[0.5, 0.25, 0.0], [1.0, -0.5, 0.0]]).cross_track
    array([ 0.25, -0.5 ])
    """
    path, poses = as_path(path), as_floats(poses, "poses", None, 3)
    if not reach > 0.0:
        raise ValueError(f"reach: expected metres above 0, got {reach}")
    feet, away = np.empty((len(poses), 2)), np.empty(len(poses))
    walk(path, poses, float(reach), feet, away)
    return PathPoints(feet, away)
