"""Angles, poses in the plane and attitudes in space: the numbers every room above stands on.

Frames follow REP-103: x forward, y left, z up, counter-clockwise positive. All functions work on
the last axis of arrays of any depth and broadcast over the others; a hole in a log (NaN) stays a
hole in the result.

===============  ========================================================
``angles``       `wrap_angle`
``paths``        `distance_along`
``poses``        SE(2): poses (x, y, theta) and twists (vx, vy, omega)
``quaternions``  attitudes in space (w, x, y, z), for the IMU
===============  ========================================================
"""

from robocon_course.geometry.angles import TURN, wrap_angle
from robocon_course.geometry.paths import distance_along
from robocon_course.geometry.poses import compose, inverse, se2_exp, se2_log, transform_points
from robocon_course.geometry.quaternions import (
    quaternion_conjugate,
    quaternion_from_euler,
    quaternion_from_rotation_vector,
    quaternion_multiply,
    rotate,
    rotation_vector,
)

GRAVITY = 9.80665
"""Standard gravity [m/s^2]: what a sensor at rest reads along the map's z axis."""

__all__ = [
    "GRAVITY",
    "TURN",
    "compose",
    "distance_along",
    "inverse",
    "quaternion_conjugate",
    "quaternion_from_euler",
    "quaternion_from_rotation_vector",
    "quaternion_multiply",
    "rotate",
    "rotation_vector",
    "se2_exp",
    "se2_log",
    "transform_points",
    "wrap_angle",
]
