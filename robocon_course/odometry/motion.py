"""From wheel travel to the motion of the body, and from motion to pose.

With A the wheel matrix, the travel d of the wheels in one sample gives the motion
Δ = (forward, left, turn) of the body in its own axes, and the motion moves the pose along an
exact arc:

    A Δ = d                      least squares, where there are more wheels than unknowns
    pose ← pose ∘ exp(Δ)

If a gyroscope knows the turn better, its turn is put in and the wheels only say how far:

    A[:, :2] (forward, left) = d - A[:, 2] turn

Source: J. Solà et al., A micro Lie theory, arXiv:1812.01537, 2018, equation 156 (exp);
K. Lynch, F. Park, Modern Robotics, Cambridge 2017, section 13.4 (odometry by pseudo-inverse).
"""

from __future__ import annotations

from math import cos, isfinite, sin

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import compose, inverse, se2_log, wrap_angle
from robocon_course.odometry.wheels import TrackingWheels

START = (0.0, 0.0, 0.0)


def body_deltas(
    wheels: TrackingWheels, travel: ArrayLike, yaw: ArrayLike | None = None
) -> FloatArray:
    """Motion of the base in each sample, from the travel of its measuring wheels.

    Parameters
    ----------
    wheels : TrackingWheels
        Three wheels or more that together feel forward, left and turn; or two side by side, a
        differential drive, whose sideways motion is taken as 0.
    travel : array_like, shape (n, number of wheels)  [m]
        Distance that each wheel rolled since the sample before.
    yaw : array_like, shape (n + 1,), optional  [rad, map]
        Heading from a gyroscope, before the first sample and after each; its turn takes the
        place of the wheels' own. It may be wrapped.

    Returns
    -------
    ndarray, shape (n, 3)  [m, m, rad; base at the start of each sample]

    Raises
    ------
    ValueError
        Wrong shapes, an entry that is not finite, or wheels that cannot tell all motions apart.

    Notes
    -----
    Lynch and Park 2017, section 13.4, in the least-squares sense.

    Examples
    --------
    The rear wheel of a robot that turns on the spot rolls, too; the base does not.

    >>> wheels = TrackingWheels(
    ...     [[0.0, 0.25], [0.0, -0.25], [-0.3, 0.0]], [0.0, 0.0, np.pi / 2], 0.03, 3200
    ... )
    >>> body_deltas(wheels, [[-0.025, 0.025, -0.03]]).round(6).tolist()
    [[0.0, 0.0, 0.1]]
    """
    travel = as_floats(travel, "travel", None, len(wheels.radius))
    if yaw is None:
        return _rows_through(wheels.solver, travel)
    turn = wrap_angle(np.diff(as_floats(yaw, "yaw", len(travel) + 1)))[:, None]
    shift = _rows_through(wheels.shift_solver, travel) + turn * wheels.shift_per_turn
    return np.concatenate([shift, turn], axis=1)


def _rows_through(matrix: FloatArray, rows: FloatArray) -> FloatArray:
    # rows @ matrix.T would wake the threads of the linear algebra library for three columns: many
    # times the CPU time, and last bits that depend on how the rows are shared out.
    out = np.empty((len(rows), len(matrix)))
    multiply_rows(matrix, rows, out)
    return out


@njit(cache=True)
def multiply_rows(matrix, rows, out):
    """Each row multiplied by the matrix, written into ``out``; it trusts its input.

    Parameters
    ----------
    matrix : ndarray, shape (m, n)
    rows : ndarray, shape (k, n)
    out : ndarray, shape (k, m)
    """
    for k in range(len(rows)):
        for i in range(matrix.shape[0]):
            total = 0.0
            for j in range(matrix.shape[1]):
                total += matrix[i, j] * rows[k, j]
            out[k, i] = total


@njit(cache=True)
def arc(x, y, theta, forward, left, turn):
    """The pose after one motion of the base along an exact arc: pose ∘ exp(motion).

    Parameters
    ----------
    x, y, theta : float  [m, m, rad; map]
    forward, left, turn : float  [m, m, rad; base at the start]

    Returns
    -------
    tuple of 3 floats  [m, m, rad; map]
    """
    half = turn / 2.0
    # An arc's chord points along the heading halfway and is shorter by sin(half) / half.
    chord = sin(half) / half if half != 0.0 else 1.0
    c, s = chord * cos(theta + half), chord * sin(theta + half)
    return x + (c * forward - s * left), y + (s * forward + c * left), theta + turn


@njit(cache=True)
def integrate_arcs(deltas, poses):
    """Poses along exact arcs, written into ``poses``; it trusts its input.

    Parameters
    ----------
    deltas : ndarray, shape (n, 3)  [m, m, rad; base at the start of each step]
    poses : ndarray, shape (n + 1, 3)  [m, m, rad; map]
        Row 0 holds the start; the others take the poses.
    """
    x, y, theta = poses[0, 0], poses[0, 1], poses[0, 2]
    for k in range(len(deltas)):
        x, y, theta = arc(x, y, theta, deltas[k, 0], deltas[k, 1], deltas[k, 2])
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = x, y, theta


@njit(cache=True)
def odometry_update(pose, ticks, per_tick, per_turn, turn):
    """One arc of ``pose``, in place, by the counts of one sample; False if they are not finite.

    The kernel behind `Odometry`; beside `arc`, as numba looks only here for changes.

    Parameters
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    ticks : ndarray of float64, shape (n,)
    per_tick : ndarray, shape (3, n)  [m, m, rad per count; base]
        How each wheel's count moves the base.
    per_turn : ndarray, shape (3,)  [m, m, rad per rad; base]
        How a turn known from elsewhere moves it, seen by the wheels.
    turn : float  [rad]

    Returns
    -------
    bool
    """
    forward, left, turned = per_turn[0] * turn, per_turn[1] * turn, per_turn[2] * turn
    for i in range(len(ticks)):
        forward += per_tick[0, i] * ticks[i]
        left += per_tick[1, i] * ticks[i]
        turned += per_tick[2, i] * ticks[i]
    if not isfinite(forward + left + turned):
        return False
    pose[0], pose[1], pose[2] = arc(pose[0], pose[1], pose[2], forward, left, turned)
    return True


def integrate(deltas: ArrayLike, start: ArrayLike = START) -> FloatArray:
    """Poses from motions of the base, along exact arcs.

    Parameters
    ----------
    deltas : array_like, shape (n, 3)  [m, m, rad; base at the start of each step]
    start : array_like, shape (3,)  [m, m, rad; map]

    Returns
    -------
    ndarray, shape (n + 1, 3)  [m, m, rad; map]
        The start, then the pose after each step; theta is not wrapped.

    Raises
    ------
    ValueError
        Wrong shape, or an entry that is not finite.

    Notes
    -----
    pose ← pose ∘ exp(Δ), Solà 2018, equations 156 and 158.

    Examples
    --------
    A quarter of a circle of radius 1 m in one step ends where it should.

    >>> integrate([[np.pi / 2, 0.0, np.pi / 2]])[-1].round(3).tolist()
    [1.0, 1.0, 1.571]
    """
    deltas = as_floats(deltas, "deltas", None, 3)
    poses = np.empty((len(deltas) + 1, 3))
    poses[0] = as_floats(start, "start", 3)
    integrate_arcs(deltas, poses)
    return poses


def body_velocity(poses: ArrayLike, dt: float) -> FloatArray:
    """Velocity between poses, with its signs, in the robot's own axes.

    Parameters
    ----------
    poses : array_like, shape (n + 1, 3)  [m, m, rad; map]
        Poses every ``dt``; headings may be wrapped.
    dt : float  [s]
        0.05 s on the robot of the source: long enough that single counts do not show.

    Returns
    -------
    ndarray, shape (n, 3)  [m/s, m/s, rad/s; base]
        The constant twist that leads from each pose to the next; negative is backwards, right
        and clockwise.

    Raises
    ------
    ValueError
        Wrong shape, an entry that is not finite, or dt that is not positive.

    Notes
    -----
    log(pose_k^-1 ∘ pose_(k+1)) / dt, the inverse of `integrate`.
    """
    poses = as_floats(poses, "poses", None, 3)
    if not 0.0 < dt < np.inf:
        raise ValueError(f"dt: expected seconds above 0, got {dt}")
    steps = compose(inverse(poses[:-1]), poses[1:])
    steps[:, 2] = wrap_angle(steps[:, 2])
    return se2_log(steps) / dt
