"""Motions that are known exactly, for a simulated IMU to record: rests, slow turns, a drive.

They are pure functions of time and, where they draw, of the generator they are given.

Source of the smooth step: T. Flash, N. Hogan, The coordination of arm movements, Journal of
Neuroscience 5(7), 1985.
"""

from __future__ import annotations

from math import pi, radians, sqrt

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import (
    quaternion_from_euler,
    quaternion_from_rotation_vector,
    quaternion_multiply,
)

RAMP = radians(5.7)  # the field's ramps: 100 mm up on 1000 mm
FIELD_LOW, FIELD_HIGH = np.array([0.5, 0.5]), np.array([5.4, 11.5])  # m, one team's half
ACCELERATION = (1.0, 3.0)  # m/s^2, hardest push of a leg
TURN_RATE = 1.2  # rad/s, fastest turn of a leg

Motion = tuple[FloatArray, FloatArray]
"""True attitudes (n, 4), body -> map, and accelerations (n, 3) [m/s^2, map]."""


def still(duration: float, dt: float, tilt: ArrayLike = (1.0, 0.0, 0.0, 0.0)) -> Motion:
    """Nothing moves.

    Parameters
    ----------
    duration, dt : float  [s]
        round(duration / dt) samples.
    tilt : array_like, shape (4,)
        Unit quaternion of the resting attitude, body -> map.

    Returns
    -------
    quaternions : ndarray, shape (n, 4)
    accelerations : ndarray, shape (n, 3)  [m/s^2, map]

    Raises
    ------
    ValueError
        Wrong shape, or a time that is not positive.
    """
    n = len(_times(duration, dt))
    return np.tile(as_floats(tilt, "tilt", 4), (n, 1)), np.zeros((n, 3))


def slow_turns(dt: float, *, turn: float = 10.0, lean: float = 0.0) -> Motion:
    """One full turn about x, one about y, and one about z lying on its side.

    Gravity passes over each axis, up and down. Before the third it takes a quarter turn onto the
    side, and back at the end.

    Parameters
    ----------
    dt : float  [s]
    turn : float  [s]
        Time for a full turn; the fastest rate is 1.875 * 2 pi / turn.
    lean : float  [rad]
        Lean of the whole exercise: other than 0, no axis is ever exactly vertical.

    Returns
    -------
    quaternions : ndarray, shape (n, 4)
    accelerations : ndarray, shape (n, 3)  [m/s^2, map]
        Zeros: it turns about its own middle.

    Raises
    ------
    ValueError
        A time that is not positive.
    """
    turn = _positive(turn, "turn")
    x, y, z = np.eye(3)
    attitude = quaternion_from_rotation_vector(lean * (x + y) / sqrt(2.0))
    parts = [attitude[None]]
    for axis, angle in ((x, 2 * pi), (y, 2 * pi), (x, pi / 2), (z, 2 * pi), (x, -pi / 2)):
        time = _times(turn * abs(angle) / (2 * pi), dt) + dt
        angles = angle * _smooth_step(time / time[-1])[0]
        parts.append(
            quaternion_multiply(attitude, quaternion_from_rotation_vector(angles[:, None] * axis))
        )
        attitude = parts[-1][-1]
    quaternions = np.concatenate(parts)
    return quaternions, np.zeros((len(quaternions), 3))


def drive(duration: float, dt: float, rng: np.random.Generator) -> Motion:
    """A robot drives about its half of the field: legs, turns on the way, two ramps, short stops.

    Parameters
    ----------
    duration, dt : float  [s]
        round(duration / dt) samples; the first second stands still.
    rng : numpy.random.Generator
        Draws where the legs go, how hard they push, and how long the stops are.

    Returns
    -------
    quaternions : ndarray, shape (n, 4)
    accelerations : ndarray, shape (n, 3)  [m/s^2, map]
        Up to 3 m/s^2 along the ground.

    Raises
    ------
    ValueError
        A time that is not positive.
    """
    time = _times(duration, dt)
    legs = _legs(time[-1], rng)
    ramps = {len(legs) // 3, 2 * len(legs) // 3}
    yaw, tilt, velocity_z = np.zeros((3, len(time)))
    tilt_axis, accelerations = np.zeros((2, len(time), 3))
    for k, (start, length, way, turn) in enumerate(legs):
        progress, speed, push = _smooth_step((time - start) / length)
        yaw += turn * progress
        accelerations[:, :2] += way * push[:, None] / length**2
        if k in ramps:
            climb = _smooth_step((time - start) / length * 5.0 - 1.0)[0]
            climb -= _smooth_step((time - start) / length * 5.0 - 3.0)[0]
            tilt += RAMP * climb
            tilt_axis += (climb > 0.0)[:, None] * _across(way)
            velocity_z += np.hypot(*way) * speed / length * np.tan(RAMP * climb)
    if len(time) > 1:
        accelerations[:, 2] = np.gradient(velocity_z, time)
    slope = quaternion_from_rotation_vector(tilt[:, None] * tilt_axis)
    return quaternion_multiply(slope, quaternion_from_euler(0.0, 0.0, yaw)), accelerations


def _legs(
    duration: float, rng: np.random.Generator
) -> list[tuple[float, float, FloatArray, float]]:
    """Start and length [s], way (2,) [m, map] and turn [rad] of each leg, one after the other."""
    legs, start, place = [], 1.0, FIELD_LOW
    while start < duration:
        target = rng.uniform(FIELD_LOW, FIELD_HIGH)
        turn = rng.uniform(-2.0, 2.0)
        hardest = 10.0 / sqrt(3.0) * np.hypot(*(target - place)) / rng.uniform(*ACCELERATION)
        length = max(sqrt(hardest), 1.875 * abs(turn) / TURN_RATE)
        legs.append((start, length, target - place, turn))
        start += length + rng.uniform(0.2, 1.0)
        place = target
    return legs


def _across(way: FloatArray) -> FloatArray:
    """Axis about which a climb along ``way`` lifts the front: level, to the right of it."""
    return np.array([way[1], -way[0], 0.0]) / np.hypot(*way)


def _smooth_step(u: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """From 0 to 1 while u goes from 0 to 1, with the least jerk; value and two derivatives."""
    u = np.clip(u, 0.0, 1.0)
    return (
        u**3 * (10.0 + u * (6.0 * u - 15.0)),
        30.0 * u**2 * (1.0 - u) ** 2,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )


def _times(duration: float, dt: float) -> FloatArray:
    count = round(_positive(duration, "duration") / _positive(dt, "dt"))
    if count < 1:
        raise ValueError(f"duration: {duration} s hold no sample at {dt} s each; record longer")
    return np.arange(count) * dt


def _positive(value: float, name: str) -> float:
    if not 0.0 < value < np.inf:
        raise ValueError(f"{name}: must be a positive number of seconds, got {value!r}")
    return float(value)
