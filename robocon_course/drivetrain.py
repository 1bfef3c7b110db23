"""How fast does each wheel roll when the body moves?

A wheel at r = (x, y) that rolls in the direction d = (cos a, sin a) sees, of a body that moves with
the twist (vx, vy, omega), the velocity of its own place along its own direction:

    v_wheel = d · (v + ω × r) = cos(a) vx + sin(a) vy + (x sin(a) - y cos(a)) ω

One row a wheel: a linear map, the same for every drive. Dead wheels measure with it, omni wheels
drive with it, a swerve module is two such wheels (forward and left), and a differential drive is
two wheels side by side.

Source: G. Campion, G. Bastin, B. d'Andréa-Novel, Structural properties and classification of
kinematic and dynamic models of wheeled mobile robots, IEEE Transactions on Robotics and
Automation 12(1), 1996, section II.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats


def wheel_matrix(positions: ArrayLike, directions: ArrayLike) -> FloatArray:
    """The linear map from a body twist to the speeds of its wheels.

    Parameters
    ----------
    positions : array_like, shape (n, 2)  [m, base]
        Where the wheels touch the floor.
    directions : array_like, shape (n,)  [rad, base]
        Where each wheel rolls to when it turns forward; 0 is ahead, pi/2 is to the left.

    Returns
    -------
    ndarray, shape (n, 3)
        Wheel speeds = matrix @ (vx, vy, omega); the same for distances and small motions.

    Raises
    ------
    ValueError
        Wrong shapes, or an entry that is not finite.

    Notes
    -----
    Campion et al. 1996, equation 7, for a wheel without an offset.

    Examples
    --------
    A wheel half a metre behind the centre, across: a left turn pushes it to the right.

    >>> wheel_matrix([[-0.5, 0.0]], [np.pi / 2]).round(3).tolist()
    [[0.0, 1.0, -0.5]]
    """
    positions = as_floats(positions, "positions", None, 2)
    directions = as_floats(directions, "directions", len(positions))
    x, y = positions.T
    c, s = np.cos(directions), np.sin(directions)
    return np.column_stack([c, s, x * s - y * c])
