"""Angles: one direction, one number in [-pi, pi)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray

TURN = 2.0 * np.pi


def wrap_angle(angle: ArrayLike) -> FloatArray:
    """The same direction as ``angle``, in [-pi, pi).

    Parameters
    ----------
    angle : array_like  [rad]

    Returns
    -------
    ndarray or float  [rad]
        Exact: an angle already in the interval comes back to the bit.

    Examples
    --------
    >>> float(wrap_angle(np.radians(190)).round(4)) == float(np.radians(-170).round(4))
    True
    """
    rest = np.fmod(np.asarray(angle, dtype=np.float64), TURN)  # exact, in (-2 pi, 2 pi)
    return rest - TURN * (rest >= np.pi) + TURN * (rest < -np.pi)
