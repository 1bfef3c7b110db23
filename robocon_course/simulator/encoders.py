"""What do the encoders say, given how far the wheels went and how the modules stand?

A dead wheel's counter says how many of its steps have passed; a module's encoders say the nearest
whole step.
"""

from __future__ import annotations

from math import floor

import numpy as np
from numba import njit


@njit(cache=True)
def count(travel, metres_per_tick, speeds, angles, speed_step, angle_step, ticks, modules):
    """The readings of all encoders.

    Parameters
    ----------
    travel : ndarray, shape (n,)  [m]
        What each dead wheel rolled, as far as its counter knows.
    metres_per_tick : ndarray, shape (n,)  [m]
    speeds, angles : ndarray, shape (4,)  [m/s, rad]
        Of the modules.
    speed_step, angle_step : float  [m/s, rad]
    ticks : ndarray of int64, shape (n,)
        Filled.
    modules : ndarray, shape (2, 4)  [m/s, rad]
        Filled: speeds, then angles.
    """
    for i in range(len(ticks)):
        ticks[i] = floor(travel[i] / metres_per_tick[i])
    for i in range(len(speeds)):
        modules[0, i] = np.rint(speeds[i] / speed_step) * speed_step
        modules[1, i] = np.rint(angles[i] / angle_step) * angle_step
