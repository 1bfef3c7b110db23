"""A robot without mass that follows a target, and the targets of the source.

The target has a pose x* and a velocity; the feedback turns the error into a velocity ξ, the modules
carry it out, and the robot moves by what its modules make of it:

    ξ = -λ (x - x*)  (+ velocity of x*)      error fades like exp(-λ t), whatever the path

Without the velocity in brackets a target that moves with speed v is followed v / λ behind.

Source: I. Siradjuddin, S. Wibowo, A. Rofiq, Modelling and simulation of the kinematics of a
four-wheel swerve robot (in Indonesian), Politeknik Negeri Malang, 2022, equations 24 to 37 and
figures 6 and 7; the derivatives are our own.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import TURN, compose, se2_exp, wrap_angle
from robocon_course.swerve.modules import Drive, as_drive, module_targets
from robocon_course.swerve.motion import body_twist, discretize, field_to_robot, pose_feedback


class Target(NamedTuple):
    """Where to be, and how that place moves.

    Attributes
    ----------
    pose : ndarray, shape (..., 3)  [m, m, rad; map]
        The heading counts its turns: it never jumps.
    twist : ndarray, shape (..., 3)  [m/s, m/s, rad/s; map]
        The exact derivative of the pose.
    """

    pose: FloatArray
    twist: FloatArray


class Following(NamedTuple):
    """What happened, one row for each instant, the start and the end included.

    Attributes
    ----------
    time : ndarray, shape (n,)  [s]
    poses, targets : ndarray, shape (n, 3)  [m, m, rad; map]
    twists : ndarray, shape (n, 3)  [m/s, m/s, rad/s; base]
        Commanded from this instant to the next.
    speeds, angles : ndarray, shape (n, m)  [m/s, rad]
        Of the modules: 0 or more, and in [-pi, pi] unless held.
    """

    time: FloatArray
    poses: FloatArray
    targets: FloatArray
    twists: FloatArray
    speeds: FloatArray
    angles: FloatArray

    @property
    def errors(self) -> FloatArray:
        """Pose minus target, heading the shorter way round; shape (n, 3)  [m, m, rad; map]."""
        errors = self.poses - self.targets
        errors[:, 2] = wrap_angle(errors[:, 2])
        return errors


def circle(t: ArrayLike, *, period: float = 1.0) -> Target:
    """A target on a circle of radius 2 m round the origin, looking where it goes.

    Parameters
    ----------
    t : array_like, shape (...)  [s]
    period : float  [s]
        Of one round. The print has 1 s, 12.6 m/s; wheels of 3.2 m/s need 5 s.

    Returns
    -------
    Target, shape (..., 3)

    Raises
    ------
    ValueError
        Times that are no finite numbers, or a period that is not positive.

    Notes
    -----
    Siradjuddin 2022, upper lines of equations 32 and 33.

    Examples
    --------
    >>> circle(3.0, period=12.0).pose.round(3).tolist()
    [0.0, 2.0, 3.142]
    """
    phase, rate = _phase(t, period)
    c, s = np.cos(phase), np.sin(phase)
    pose = np.stack([2.0 * c, 2.0 * s, phase + np.pi / 2], axis=-1)
    return Target(pose, rate * np.stack([-2.0 * s, 2.0 * c, np.ones_like(c)], axis=-1))


def figure_eight(t: ArrayLike, *, period: float = 1.0) -> Target:
    """A target on a lying figure eight, 1.4 m by 1.4 m round (1.2, 0.9), looking where it goes.

    Parameters
    ----------
    t : array_like, shape (...)  [s]
    period : float  [s]
        Of both loops together. The print has 1 s, up to 9.8 m/s; wheels of 3.2 m/s need 5 s.

    Returns
    -------
    Target, shape (..., 3)

    Raises
    ------
    ValueError
        Times that are no finite numbers, or a period that is not positive.

    Notes
    -----
    Siradjuddin 2022, lower lines of equations 32 and 33; heading and its rate as 29 to 31 mean
    them: atan2(y', x') and (x' y'' - y' x'') / (x'^2 + y'^2).

    Examples
    --------
    >>> figure_eight([0.0, 0.25]).pose.round(3).tolist()
    [[1.2, 0.9, 1.107], [1.9, 0.9, -1.571]]
    """
    phase, rate = _phase(t, period)
    x, y = 1.2 + 0.7 * np.sin(phase), 0.9 + 0.7 * np.sin(2.0 * phase)
    # By the phase: first, second derivative.
    dx, dy = 0.7 * np.cos(phase), 1.4 * np.cos(2.0 * phase)
    ddx, ddy = -0.7 * np.sin(phase), -2.8 * np.sin(2.0 * phase)
    # The path never leads straight to +y, so an angle that is cut there never jumps.
    heading = np.arctan2(dx, -dy) - np.pi / 2
    turning = (dx * ddy - dy * ddx) / (dx * dx + dy * dy)
    pose = np.stack([x, y, heading], axis=-1)
    return Target(pose, rate * np.stack([dx, dy, turning], axis=-1))


def follow(
    drive: Drive,
    start: ArrayLike,
    target: ArrayLike | Callable[[FloatArray], Target],
    gain: float,
    *,
    dt: float = 0.01,
    duration: float = 12.0,
    feedforward: bool = True,
) -> Following:
    """A robot without mass or slip that is led to a target by its modules.

    Parameters
    ----------
    drive : SwerveDrive, or its (m, 2) positions  [m, base]
    start : array_like, shape (3,)  [m, m, rad; map]
    target : array_like, shape (3,)  [m, m, rad; map], or function of times
        A pose that stands still; or a function like `circle`: times (n,) -> Target.
    gain : float  [1/s]
        λ: the error fades like exp(-gain t).
    dt, duration : float  [s]
        Step of the control loop, for which a command holds; and how long to follow.
    feedforward : bool
        Add the target's own velocity to the feedback.

    Returns
    -------
    Following
        duration / dt + 1 rows, rounded: where dt does not divide the duration, the last step ends
        at the nearest multiple of dt, 0.3 s and 1 s at 0.9 s.

    Raises
    ------
    ValueError
        Wrong shapes, times that are not positive, or a gain of 2 / dt and more: each step would
        then leave a greater error than it found.

    Notes
    -----
    Siradjuddin 2022, equation 27, with 17 to 22. Within a step the feed-forward does not change:
    what the target's acceleration a does meanwhile leaves an error of up to a dt / (2 gain).

    Examples
    --------
    >>> square = [[0.2, 0.2], [-0.2, 0.2], [-0.2, -0.2], [0.2, -0.2]]
    >>> run = follow(square, [0.0, 0.0, 0.0], [3.0, 6.0, np.pi / 2], gain=1.0)
    >>> run.poses[-1].round(3).tolist()
    [3.0, 6.0, 1.571]
    """
    drive, pose = as_drive(drive), as_floats(start, "start", 3)
    if not 0.0 < dt <= duration < np.inf:
        raise ValueError(f"dt, duration: expected 0 < dt <= duration, got {dt} and {duration}")
    if not 0.0 < gain * dt < 2.0:
        raise ValueError(f"gain: expected a rate above 0 and below 2 / dt in 1/s, got {gain}")
    time = dt * np.arange(round(duration / dt) + 1)
    goals = _sampled(target, time)
    velocities = goals.twist if feedforward else np.zeros_like(goals.twist)
    angles = np.zeros(len(drive.positions))
    rows = []
    for goal, velocity in zip(goals.pose, velocities, strict=True):
        wanted = field_to_robot(pose_feedback(pose, goal, gain, velocity), pose[2])
        twist = discretize(wanted, dt)
        speeds, angles = module_targets(drive, twist, angles)
        rows.append((pose, twist, speeds, angles))
        pose = compose(pose, se2_exp(body_twist(drive, speeds, angles) * dt))
    poses, twists, speeds, angles = map(np.array, zip(*rows, strict=True))
    return Following(time, poses, goals.pose, twists, speeds, angles)


def _phase(t: ArrayLike, period: float) -> tuple[FloatArray, float]:
    t = as_floats(t, "t", *(None,) * np.ndim(t))
    if not 0.0 < period < np.inf:
        raise ValueError(f"period: expected seconds above 0, got {period}")
    return t * (TURN / period), TURN / period


def _sampled(target: ArrayLike | Callable[[FloatArray], Target], time: FloatArray) -> Target:
    shape = (len(time), 3)
    if not callable(target):
        return Target(np.tile(as_floats(target, "target", 3), (len(time), 1)), np.zeros(shape))
    pose, twist = target(time)
    return Target(as_floats(pose, "target.pose", *shape), as_floats(twist, "target.twist", *shape))
