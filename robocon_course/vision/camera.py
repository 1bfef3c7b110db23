"""A camera: from points in front of it to pixels, from pixels back to directions.

Camera frame: origin in the lens, x to the right, y down, z forward along the optical axis
(REP-103's optical frame). Pixels count from the picture's upper left corner; the middle of the
first pixel is (0.5, 0.5).

Source: one-parameter division model of lens distortion: Fitzgibbon, "Simultaneous linear estimation
of multiple view geometry and lens distortion", CVPR 2001, eq. 1: x_u = x_d / (1 + k |x_d|^2). It is
exact in both directions, which the polynomial models are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin, tan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats, as_vectors

MOUNT = (0.25, 0.0, 0.42)
"""Where the lens sits on the robot [m, base; z above the floor]."""
SERVO_RANGE = (-0.2, 1.2)
"""Tilt of the camera servo [rad]: 0 looks level, positive looks down."""


@dataclass(frozen=True)
class Camera:
    """A pinhole with mild barrel distortion.

    Attributes
    ----------
    width, height : int  [pixels]
    focal : float  [pixels]
        Distance of the picture plane; a point 1 m ahead and 1 m aside lies about this far from
        the middle.
    distortion : float
        k of the division model, for distances from the axis in units of the focal length. Negative
        is a barrel: straight lines bulge outwards.
    """

    width: int = 320
    height: int = 240
    focal: float = 277.0
    distortion: float = -0.05

    @classmethod
    def with_view(
        cls, angle: float, width: int = 320, height: int = 240, distortion: float = -0.05
    ) -> Camera:
        """A camera that sees an angle [rad] across its width, distortion not counted."""
        return cls(width, height, 0.5 * width / tan(0.5 * angle), distortion)

    @property
    def centre(self) -> tuple[float, float]:
        """Where the optical axis meets the picture [pixels]."""
        return self.width / 2, self.height / 2

    def scaled(self, factor: float) -> Camera:
        """The same camera with `factor` times as many pixels each way."""
        size = round(self.width * factor), round(self.height * factor)
        return Camera(*size, self.focal * factor, self.distortion)

    def pixels(self, points: ArrayLike) -> FloatArray:
        """Where points appear in the picture.

        Parameters
        ----------
        points : array_like, shape (..., 3)  [m, camera]

        Returns
        -------
        ndarray, shape (..., 2)  [pixels]
            Inside the picture or not. NaN for points behind the camera, and so far aside that this
            lens cannot bend their light into the picture.
        """
        points = as_vectors(points, "points", 3)
        depth = np.where(points[..., 2:] > 1e-9, points[..., 2:], np.nan)
        flat = points[..., :2] / depth
        squared = _squared(flat)[..., None]
        with np.errstate(invalid="ignore"):
            # The root of k r_u r_d^2 - r_d + r_u = 0 that tends to r_u as k does to 0.
            shrunk = 2.0 / (1.0 + np.sqrt(1.0 - 4.0 * self.distortion * squared))
        return flat * shrunk * self.focal + self.centre

    def rays(self, pixels: ArrayLike) -> FloatArray:
        """Directions in which pixels look: the inverse of `pixels`.

        Parameters
        ----------
        pixels : array_like, shape (..., 2)  [pixels]

        Returns
        -------
        ndarray, shape (..., 3)  [camera]
            Unit vectors.
        """
        flat = (as_vectors(pixels, "pixels", 2) - self.centre) / self.focal
        squared = _squared(flat)
        depth = 1.0 + self.distortion * squared
        far = np.sqrt(squared + depth * depth)
        return np.concatenate([flat, depth[..., None]], axis=-1) / far[..., None]


def _squared(flat: FloatArray) -> FloatArray:
    """x^2 + y^2 of points (..., 2): numpy's sum over an axis of two is slow to begin."""
    x, y = flat[..., 0], flat[..., 1]
    return x * x + y * y


def camera_pose(
    pose: ArrayLike,
    floor: float = 0.0,
    *,
    pan: float = 0.0,
    tilt: float = 0.0,
    roll: float = 0.0,
    rise: tuple[float, float] = (0.0, 0.0),
) -> FloatArray:
    """Where the robot's camera is and which way it looks.

    Parameters
    ----------
    pose : array_like, shape (3,)  [m, m, rad, map]
        Of the robot.
    floor : float  [m, map]
        Height of the floor under it.
    pan, tilt, roll : float  [rad]
        Of the servos: pan to the left, tilt down; roll turns what the picture shows clockwise.
    rise : (float, float)  [m per m]
        Of the floor along the robot's x and y axis: on a slope the camera tips with the robot.

    Returns
    -------
    ndarray, shape (4, 4)
        ``T_map_camera``: takes points from the camera frame to the map frame.
    """
    x, y, theta = as_floats(pose, "pose", 3).tolist()
    ahead, left, up = MOUNT
    lens = (
        x + ahead * cos(theta) - left * sin(theta),
        y + ahead * sin(theta) + left * cos(theta),
        floor + up,
    )
    level = looking(lens, theta + pan, tilt, roll)
    return level if not any(rise) else _tipped(rise, theta, (x, y, floor)) @ level


def _tipped(rise: tuple[float, float], theta: float, foot: tuple) -> FloatArray:
    """What takes points around a level robot to where they are when it stands on a slope."""
    ahead, left = np.array([1.0, 0.0, rise[0]]), np.array([0.0, 1.0, rise[1]])
    ahead /= np.linalg.norm(ahead)
    left -= ahead * (ahead @ left)
    left /= np.linalg.norm(left)
    turn = np.array([(cos(theta), -sin(theta), 0.0), (sin(theta), cos(theta), 0.0), (0, 0, 1.0)])
    T = np.eye(4)
    up = cross(ahead.tolist(), left.tolist())
    T[:3, :3] = turn @ np.array([ahead, left, up]).T @ turn.T
    T[:3, 3] = foot - T[:3, :3] @ foot
    return T


def looking(lens: ArrayLike, heading: float, tilt: float, roll: float = 0.0) -> FloatArray:
    """``T_map_camera`` of a camera anywhere.

    Parameters
    ----------
    lens : array_like, shape (3,)  [m, map]
    heading : float  [rad, map]
    tilt, roll : float  [rad]
        Tilt looks down; roll turns what the picture shows clockwise.
    """
    forward = (cos(heading) * cos(tilt), sin(heading) * cos(tilt), -sin(tilt))
    right = (sin(heading), -cos(heading), 0.0)
    down = cross(forward, right)
    c, s, place = cos(roll), sin(roll), as_floats(lens, "lens", 3).tolist()
    rows = [
        (c * r - s * d, s * r + c * d, f, p)
        for r, d, f, p in zip(right, down, forward, place, strict=True)
    ]
    return np.array([*rows, (0.0, 0.0, 0.0, 1.0)])


def cross(one: Sequence[Any], other: Sequence[Any]) -> tuple[Any, Any, Any]:
    """The cross product of two vectors, of numbers or of arrays: numpy's is slow to begin.

    Parameters
    ----------
    one, other : sequence of 3

    Returns
    -------
    tuple of 3
    """
    (ax, ay, az), (bx, by, bz) = one, other
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


def view_towards(lens: ArrayLike, target: ArrayLike, roll: float = 0.0) -> FloatArray:
    """``T_map_camera`` of a camera at `lens` with `target` in the middle of its picture."""
    ahead = as_floats(target, "target", 3) - as_floats(lens, "lens", 3)
    heading = np.arctan2(ahead[1], ahead[0])
    return looking(lens, heading, -np.arctan2(ahead[2], np.hypot(ahead[0], ahead[1])), roll)
