"""From the modules back to the motion of the body, and the commands that lead somewhere.

Four modules measure eight velocity components of a motion that has three. The least squares gives
the twist; what is left over, the residual, is how badly the wheels disagree: a wheel that slips.

    twist = pinv(A) c,   residual = |A twist - c|,   c = (speed cos angle, speed sin angle)

Source: WPILib documentation, Swerve Drive Kinematics (forward kinematics by pseudo-inverse,
discretisation); I. Siradjuddin, S. Wibowo, A. Rofiq, Modelling and simulation of the kinematics of
a four-wheel swerve robot (in Indonesian), Politeknik Negeri Malang, 2022, equations 13 to 17
(field to robot) and 24 to 27 (control law ξ = -λ (x - x*)).
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats, as_vectors
from robocon_course.geometry import TURN, se2_log, wrap_angle
from robocon_course.swerve.modules import Drive, as_drive


class BodyMotion(NamedTuple):
    """What the modules say about the body.

    Attributes
    ----------
    twist : ndarray, shape (..., 3)  [m/s, m/s, rad/s; base]
    residual : ndarray, shape (...)  [m/s]
        How far a module's velocity is from what the twist gives its place: root mean square over
        the modules. Of wheels that roll it is less than their encoders' noise.
    """

    twist: FloatArray
    residual: FloatArray


@njit(cache=True)
def fill_motion(
    positions: FloatArray,
    solver: FloatArray,
    speeds: FloatArray,
    angles: FloatArray,
    twists: FloatArray,
    residuals: FloatArray,
) -> None:
    """Twist and residual of each row, written into ``twists`` and ``residuals``.

    The kernel behind `body_motion`, for loops that count nanoseconds. It trusts its input.

    Parameters
    ----------
    positions : ndarray of float64, shape (m, 2)  [m, base]
    solver : ndarray of float64, shape (3, 2 m)
        As in `SwerveDrive`.
    speeds, angles : ndarray of float64, shape (n, m)  [m/s, rad]
    twists : ndarray of float64, shape (n, 3)  [m/s, m/s, rad/s; base]
        Filled.
    residuals : ndarray of float64, shape (n,)  [m/s]
        Filled.
    """
    m = len(positions)
    for k in range(len(speeds)):
        vx = vy = omega = total = 0.0
        for i in range(m):
            forward = speeds[k, i] * cos(angles[k, i])
            left = speeds[k, i] * sin(angles[k, i])
            vx += solver[0, i] * forward + solver[0, m + i] * left
            vy += solver[1, i] * forward + solver[1, m + i] * left
            omega += solver[2, i] * forward + solver[2, m + i] * left
        for i in range(m):  # sine and cosine once more: for a single row cheaper than memory
            a = speeds[k, i] * cos(angles[k, i]) - (vx - omega * positions[i, 1])
            b = speeds[k, i] * sin(angles[k, i]) - (vy + omega * positions[i, 0])
            total += a * a + b * b
        twists[k, 0], twists[k, 1], twists[k, 2] = vx, vy, omega
        residuals[k] = sqrt(total / m)


def body_motion(drive: Drive, speeds: ArrayLike, angles: ArrayLike) -> BodyMotion:
    """Twist of the body from its modules, and how badly they disagree.

    Parameters
    ----------
    drive : SwerveDrive, or its (m, 2) positions  [m, base]
    speeds : array_like, shape (..., m)  [m/s]
    angles : array_like, shape (..., m)  [rad, base]

    Returns
    -------
    BodyMotion
        Twist (..., 3) and residual (...). A reading that is not finite leaves no finite twist,
        and a residual of NaN.

    Raises
    ------
    ValueError
        Wrong shapes. Never for a reading: this runs in a control loop.

    Notes
    -----
    WPILib, forward kinematics. Of four modules in a square, one that is off by e leaves a residual
    between 0.35 e (off along the circle round the centre) and 0.43 e (off along the radius); the
    twist takes up the rest. Modules that all agree with a wrong motion leave none.

    Examples
    --------
    One of four wheels spins on a wet spot, 1 m/s too fast.

    >>> square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
    >>> float(body_motion(square, [1.0, 1.0, 1.0, 2.0], np.zeros(4)).residual.round(3))
    0.395
    """
    drive = as_drive(drive)
    m = len(drive.positions)
    speeds = as_floats(speeds, "speeds", *(None,) * (np.ndim(speeds) - 1), m, finite=False)
    angles = as_floats(angles, "angles", *speeds.shape, finite=False)
    motion = BodyMotion(np.empty((*speeds.shape[:-1], 3)), np.empty(speeds.shape[:-1]))
    fill_motion(
        drive.positions,
        drive.solver,
        speeds.reshape(-1, m),
        angles.reshape(-1, m),
        motion.twist.reshape(-1, 3),
        motion.residual.reshape(-1),
    )
    return motion


def body_twist(drive: Drive, speeds: ArrayLike, angles: ArrayLike) -> FloatArray:
    """Twist of the body from its modules, in the least-squares sense.

    Parameters
    ----------
    drive : SwerveDrive, or its (m, 2) positions  [m, base]
    speeds : array_like, shape (..., m)  [m/s]
    angles : array_like, shape (..., m)  [rad, base]

    Returns
    -------
    ndarray, shape (..., 3)  [m/s, m/s, rad/s; base]
        Not finite where a reading is not.

    Raises
    ------
    ValueError
        Wrong shapes.

    Examples
    --------
    >>> square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
    >>> body_twist(square, np.full(4, 2.0), np.full(4, np.pi / 2)).round(3).tolist()
    [0.0, 2.0, 0.0]
    """
    return body_motion(drive, speeds, angles).twist


def field_to_robot(twist: ArrayLike, theta: ArrayLike) -> FloatArray:
    """A velocity in map axes, as the robot at heading ``theta`` has to drive it (field-centric).

    Parameters
    ----------
    twist : array_like, shape (..., 3)  [m/s, m/s, rad/s; map]
    theta : array_like, shape (...)  [rad, map]

    Returns
    -------
    ndarray, shape (..., 3)  [m/s, m/s, rad/s; base]
        Leading axes broadcast.

    Raises
    ------
    ValueError
        The last axis of ``twist`` is not 3 long, or ``theta`` is no number.

    Notes
    -----
    Siradjuddin 2022, equation 17: the rotation by -theta.

    Examples
    --------
    Towards the far end of the field, by a robot that looks to the left: to its right.

    >>> field_to_robot([0.0, 1.0, 0.0], np.pi).round(3).tolist()
    [0.0, -1.0, 0.0]
    """
    vx, vy, omega = np.moveaxis(as_vectors(twist, "twist", 3), -1, 0)
    theta = as_floats(theta, "theta", *(None,) * np.ndim(theta), finite=False)
    c, s = np.cos(theta), np.sin(theta)
    parts = np.broadcast_arrays(c * vx + s * vy, c * vy - s * vx, omega)
    return np.stack(parts, axis=-1)


def discretize(twist: ArrayLike, dt: float) -> FloatArray:
    """The twist to command so that after ``dt`` the robot is where the wanted one meant.

    A twist holds in the robot's axes, which turn while it drives. "Forward and turn left" then
    drifts to the left (skew); this aims to the right by as much.

    Parameters
    ----------
    twist : array_like, shape (..., 3)  [m/s, m/s, rad/s; base at the start of the step]
    dt : float  [s]
        How long the command will hold.

    Returns
    -------
    ndarray, shape (..., 3)  [m/s, m/s, rad/s; base]

    Raises
    ------
    ValueError
        The last axis is not 3 long, dt is not positive, or the robot would turn by a whole turn
        or more: no held twist does that and ends elsewhere.

    Notes
    -----
    log of the pose (vx dt, vy dt, omega dt), divided by dt.

    Examples
    --------
    >>> discretize([1.0, 0.0, 2.0], 0.1).round(4).tolist()
    [0.9967, -0.1, 2.0]
    """
    if not 0.0 < dt < np.inf:
        raise ValueError(f"dt: expected seconds above 0, got {dt}")
    motion = as_vectors(twist, "twist", 3) * dt
    if (np.abs(motion[..., 2]) >= TURN).any():
        raise ValueError(f"dt: in {dt} s the robot would turn by a whole turn; take shorter steps")
    return se2_log(motion) / dt


def pose_feedback(
    pose: ArrayLike,
    target: ArrayLike,
    gain: float,
    feedforward: ArrayLike = (0.0, 0.0, 0.0),
) -> FloatArray:
    """Velocity that makes the distance to a target fade like exp(-gain t).

    Parameters
    ----------
    pose, target : array_like, shape (..., 3)  [m, m, rad; map]
    gain : float  [1/s]
    feedforward : array_like, shape (..., 3)  [m/s, m/s, rad/s; map]
        The target's own velocity. Without it a moving target is followed late, by speed / gain.

    Returns
    -------
    ndarray, shape (..., 3)  [m/s, m/s, rad/s; map]
        Turns the shorter way round. For the robot's own axes: `field_to_robot`.

    Raises
    ------
    ValueError
        A last axis is not 3 long, or the gain is not positive.

    Notes
    -----
    Siradjuddin 2022, equation 27: ξ = -λ (x - x*), here plus the target's velocity.

    Examples
    --------
    >>> pose_feedback([0.0, 0.0, 3.0], [1.0, 0.0, -3.0], 0.5).round(3).tolist()
    [0.5, 0.0, 0.142]
    """
    if not 0.0 < gain < np.inf:
        raise ValueError(f"gain: expected a rate above 0 in 1/s, got {gain}")
    error = as_vectors(pose, "pose", 3) - as_vectors(target, "target", 3)
    error[..., 2] = wrap_angle(error[..., 2])
    return as_vectors(feedforward, "feedforward", 3) - gain * error
