"""Poses in the plane: where something is and where it looks.

A pose (x, y, theta) is read as a transform, T_map_base: the base's place and heading in the map.
Transforms chain so that inner names cancel, T_map_base ∘ T_base_camera = T_map_camera:

    (x, y, θ) ∘ (u, v, φ) = ((x, y) + R(θ) (u, v), θ + φ)

A twist (vx, vy, omega) held for one unit of time leads along an arc. Its chord is the twist's
translation turned by half the angle and shortened by sin(ω/2) / (ω/2); nothing is approximated,
and nothing is divided by a small angle.

Headings are not wrapped: a robot that turned twice has turned by 4 pi.

Source: J. Solà, J. Deray, D. Atchuthan, A micro Lie theory for state estimation in robotics,
arXiv:1812.01537, 2018, equations 129 to 134 (group SE(2)) and 154 to 158 (exp and log).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_vectors


def compose(pose: ArrayLike, delta: ArrayLike) -> FloatArray:
    """The pose reached from ``pose`` by a motion seen from it: T_map_base ∘ T_base_next.

    Parameters
    ----------
    pose : array_like, shape (..., 3)  [m, m, rad; map]
    delta : array_like, shape (..., 3)  [m, m, rad; base]

    Returns
    -------
    ndarray, shape (..., 3)  [m, m, rad; map]

    Raises
    ------
    ValueError
        A last axis is not 3 long.

    Examples
    --------
    >>> compose([1.0, 2.0, np.pi / 2], [1.0, 0.0, 0.0]).round(3).tolist()
    [1.0, 3.0, 1.571]
    """
    pose = as_vectors(pose, "pose", 3)
    delta = as_vectors(delta, "delta", 3)
    moved = _turned(delta, pose[..., 2])
    return pose + moved


def inverse(pose: ArrayLike) -> FloatArray:
    """The transform back: T_map_base -> T_base_map.

    Parameters
    ----------
    pose : array_like, shape (..., 3)  [m, m, rad]

    Returns
    -------
    ndarray, shape (..., 3)  [m, m, rad]

    Raises
    ------
    ValueError
        The last axis is not 3 long.
    """
    pose = as_vectors(pose, "pose", 3)
    return -_turned(pose, -pose[..., 2])


def se2_exp(twist: ArrayLike) -> FloatArray:
    """Pose reached by a constant twist after one unit of time, along an exact arc.

    Parameters
    ----------
    twist : array_like, shape (..., 3)  [m, m, rad; base]
        Velocity times time: forward, left, turn.

    Returns
    -------
    ndarray, shape (..., 3)  [m, m, rad; base at the start]

    Raises
    ------
    ValueError
        The last axis is not 3 long.

    Notes
    -----
    Solà 2018, equations 156 and 158, written with the chord: a quarter circle of length s ends
    (2 sqrt(2) / pi) s away, in the direction of 45 degrees.

    Examples
    --------
    >>> se2_exp([np.pi / 2, 0.0, np.pi / 2]).round(3).tolist()
    [1.0, 1.0, 1.571]
    """
    twist = as_vectors(twist, "twist", 3)
    half = twist[..., 2] / 2.0
    return _turned(twist, half, shrink=np.sinc(half / np.pi))


def se2_log(pose: ArrayLike) -> FloatArray:
    """The constant twist that reaches a pose in one unit of time: the inverse of `se2_exp`.

    Parameters
    ----------
    pose : array_like, shape (..., 3)  [m, m, rad]
        theta says how far to turn; within (-2 pi, 2 pi).

    Returns
    -------
    ndarray, shape (..., 3)  [m, m, rad; base at the start]

    Raises
    ------
    ValueError
        The last axis is not 3 long.

    Notes
    -----
    Solà 2018, equation 157. A whole turn that ends elsewhere than it began has no such twist: what
    comes out is huge (2.6e16 for a metre), as pi itself is rounded.
    """
    pose = as_vectors(pose, "pose", 3)
    half = pose[..., 2] / 2.0
    with np.errstate(divide="ignore", invalid="ignore"):
        return _turned(pose, -half, shrink=1.0 / np.sinc(half / np.pi))


def transform_points(pose: ArrayLike, points: ArrayLike) -> FloatArray:
    """Points given in the base, as seen in the map: p_map = T_map_base p_base.

    Parameters
    ----------
    pose : array_like, shape (..., 3)  [m, m, rad; map]
    points : array_like, shape (..., 2)  [m, base]
        Leading axes broadcast; one pose serves many points.

    Returns
    -------
    ndarray, shape (..., 2)  [m, map]

    Raises
    ------
    ValueError
        The last axis is not 3 (``pose``) or 2 (``points``) long.
    """
    pose = as_vectors(pose, "pose", 3)
    x, y = np.moveaxis(as_vectors(points, "points", 2), -1, 0)
    c, s = np.cos(pose[..., 2]), np.sin(pose[..., 2])
    return np.stack([pose[..., 0] + c * x - s * y, pose[..., 1] + s * x + c * y], axis=-1)


def _turned(
    motion: FloatArray, angle: FloatArray, *, shrink: FloatArray | float = 1.0
) -> FloatArray:
    """The translation of a motion turned by an angle and shortened; its own turn stays."""
    x, y = motion[..., 0], motion[..., 1]
    c, s = shrink * np.cos(angle), shrink * np.sin(angle)
    turned = np.empty((*np.broadcast_shapes(x.shape, c.shape), 3))
    turned[..., 0], turned[..., 1] = c * x - s * y, s * x + c * y
    turned[..., 2] = motion[..., 2]
    return turned
