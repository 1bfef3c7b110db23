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

from math import cos, sin

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import compose, inverse, se2_log, wrap_angle
from robocon_course.odometry.wheels import TrackingWheels, wheel_travel

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
        return travel @ wheels.solver.T
    turn = wrap_angle(np.diff(as_floats(yaw, "yaw", len(travel) + 1)))
    rolled_by_turn = turn[:, None] * wheels.matrix[:, 2]
    return np.column_stack([(travel - rolled_by_turn) @ wheels.shift_solver.T, turn])


@njit(cache=True)
def integrate_arcs(deltas: FloatArray, poses: FloatArray) -> None:
    """Poses along exact arcs, written into ``poses``; row 0 holds the start."""
    x, y, theta = poses[0, 0], poses[0, 1], poses[0, 2]
    for k in range(len(deltas)):
        forward, left, turn = deltas[k, 0], deltas[k, 1], deltas[k, 2]
        half = turn / 2.0
        # An arc's chord points along the heading halfway and is shorter by sin(half) / half.
        chord = sin(half) / half if half != 0.0 else 1.0
        c, s = chord * cos(theta + half), chord * sin(theta + half)
        x += c * forward - s * left
        y += s * forward + c * left
        theta += turn
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = x, y, theta


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


class Odometry:
    """Dead reckoning for a control loop: remembers the pose, nothing else.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    rejected : int
        Samples that were not finite and were left out.

    Parameters
    ----------
    wheels : TrackingWheels
    start : array_like, shape (3,)  [m, m, rad; map]
    """

    def __init__(self, wheels: TrackingWheels, start: ArrayLike = START) -> None:
        self.wheels = wheels
        self.rejected = 0
        self.reset(start)

    def reset(self, pose: ArrayLike) -> None:
        """Stand at another pose (3,) [m, m, rad; map], as after a look at the walls."""
        self.pose = as_floats(pose, "pose", 3)
        self._yaw: float | None = None

    def update(self, ticks: ArrayLike, yaw: float | None = None) -> FloatArray:
        """The pose after one more sample.

        Parameters
        ----------
        ticks : array_like, shape (number of wheels,)
            Counts since the sample before. One that is not finite is counted, and only the
            gyroscope moves the pose.
        yaw : float, optional  [rad]
            A gyroscope's heading. From the second in a row on, its turn replaces the wheels'.

        Returns
        -------
        ndarray, shape (3,)  [m, m, rad; map]
        """
        yaw = float(yaw) if yaw is not None and np.isfinite(yaw) else None
        headings = None if yaw is None or self._yaw is None else (self._yaw, yaw)
        self._yaw = yaw
        if np.isfinite(ticks).all():
            travel = wheel_travel(self.wheels, ticks)
            deltas = body_deltas(self.wheels, travel[None], headings)
        else:
            self.rejected += 1
            deltas = [[0.0, 0.0, 0.0 if headings is None else wrap_angle(yaw - headings[0])]]
        self.pose = integrate(deltas, self.pose)[1]
        return self.pose
