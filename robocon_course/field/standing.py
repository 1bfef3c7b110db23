"""How a robot stands on the floor: the plane through the floor under its wheels."""

from __future__ import annotations

from math import cos, sin

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field.maps import FLOOR_TABLE


def standing(pose: ArrayLike, wheels: FloatArray) -> FloatArray:
    """The plane that a robot stands on.

    Parameters
    ----------
    pose : array_like, shape (3,)  [m, m, rad; map]
    wheels : ndarray, shape (4, 2)  [m, base]
        In a square around the robot's middle.

    Returns
    -------
    ndarray, shape (3,)
        Rise along x and along y of the base [m per m], height of the middle [m].

    Raises
    ------
    ValueError
        Not a pose.

    Examples
    --------
    In the middle of ramp 1, looking up:

    >>> square = np.array([(0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2)])
    >>> standing((0.5, 3.5, np.pi / 2), square).round(3).tolist()
    [0.1, 0.0, 0.1]
    """
    out = np.empty(3)
    x, y, theta = as_floats(pose, "pose", 3).tolist()
    floor_plane(x, y, theta, wheels, FLOOR_TABLE, out)
    return out


@njit(cache=True)
def floor_plane(x, y, theta, modules, table, out):
    """The plane a robot stands on, through the floor under its modules.

    Parameters
    ----------
    x, y, theta : float  [m, m, rad; map]
    modules : ndarray, shape (4, 2)  [m, base]
        In a square around the middle.
    table : ndarray, shape (k, 7)
        `field.FLOOR_TABLE`.
    out : ndarray, shape (3,)
        Rise along x and y of the base [m per m], height of the middle [m].
    """
    c, s = cos(theta), sin(theta)
    square = 0.0
    out[:] = 0.0
    for k in range(len(modules)):
        mx, my = modules[k, 0], modules[k, 1]
        px, py = x + c * mx - s * my, y + s * mx + c * my
        height = 0.0
        for row in range(len(table)):
            x0, y0, x1, y1, foot, slope_x, slope_y = table[row]
            if x0 <= px <= x1 and y0 <= py <= y1:
                height = foot + slope_x * (px - x0) + slope_y * (py - y0)
        out[0] += mx * height
        out[1] += my * height
        out[2] += height / len(modules)
        square += mx * mx
    out[0] /= square
    out[1] /= square
