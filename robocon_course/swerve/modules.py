"""From a twist of the body to speed and angle of each module.

The module at r = (x, y) has to move with the velocity of its own place, v + ω × r:

    a = vx - ω y        b = vy + ω x        speed = sqrt(a² + b²)        angle = atan2(b, a)

which are two rows of the wheel matrix: a virtual wheel that rolls forward, and one that rolls left.

Source: I. Siradjuddin, S. Wibowo, A. Rofiq, Modelling and simulation of the kinematics of a
four-wheel swerve robot (in Indonesian), Politeknik Negeri Malang, 2022, equations 16 to 22 (with
the rotation of 17, and atan2 in 21); desaturation, optimisation and cosine compensation: WPILib
documentation, Swerve Drive Kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import atan2, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats, frozen
from robocon_course.drivetrain import wheel_matrix
from robocon_course.geometry import wrap_angle

REST = 1e-4
"""Slower than this a module counts as still, and its angle is kept [m/s]."""
APART = 1e-3
"""Modules nearer to each other than this cannot feel a turn [m]."""


@dataclass(frozen=True, eq=False)
class SwerveDrive:
    """Where the modules of a swerve drive stand.

    Attributes
    ----------
    positions : array_like, shape (m, 2)  [m, base]
        At least two modules, not all in one place; the order is that of all speeds and angles.

    Raises
    ------
    ValueError
        Wrong shape, an entry that is not finite, or modules all within a millimetre.
    """

    positions: ArrayLike

    def __post_init__(self) -> None:
        positions = as_floats(self.positions, "positions", None, 2)
        if len(positions) < 2 or np.ptp(positions, axis=0).max() < APART:
            raise ValueError(
                "positions: a swerve drive needs two modules in different places, "
                f"got {positions.tolist()}"
            )
        object.__setattr__(self, "positions", frozen(positions))

    @cached_property
    def matrix(self) -> FloatArray:
        """(m forward components, m left components) = matrix @ twist; shape (2 m, 3)."""
        twice = np.tile(self.positions, (2, 1))
        directions = np.repeat([0.0, np.pi / 2], len(self.positions))
        return frozen(wheel_matrix(twice, directions).round(15))  # cos(pi / 2) is 6e-17

    @cached_property
    def solver(self) -> FloatArray:
        """twist = solver @ components, the least squares; shape (3, 2 m)."""
        return frozen(np.linalg.pinv(self.matrix))


Drive = SwerveDrive | ArrayLike


class ModuleTargets(NamedTuple):
    """What the modules are told.

    Attributes
    ----------
    speeds : ndarray, shape (..., m)  [m/s]
        Along the angle; negative rolls backwards.
    angles : ndarray, shape (..., m)  [rad, base]
    """

    speeds: FloatArray
    angles: FloatArray


def as_drive(drive: Drive) -> SwerveDrive:
    """A drive, or the positions (m, 2) [m, base] of its modules, as a drive."""
    return drive if isinstance(drive, SwerveDrive) else SwerveDrive(drive)


@njit(cache=True)
def fill_targets(
    positions: FloatArray,
    twists: FloatArray,
    hold_angles: FloatArray,
    speeds: FloatArray,
    angles: FloatArray,
) -> None:
    """Targets for each row of ``twists``, written into ``speeds`` and ``angles``.

    The kernel behind `module_targets`, for loops that count nanoseconds. It trusts its input.

    Parameters
    ----------
    positions : ndarray of float64, shape (m, 2)  [m, base]
    twists : ndarray of float64, shape (n, 3)  [m/s, m/s, rad/s; base]
    hold_angles : ndarray of float64, shape (1, m) or (n, m)  [rad, base]
    speeds, angles : ndarray of float64, shape (n, m)  [m/s, rad]
        Filled.
    """
    hold_rows = len(hold_angles)
    for k in range(len(twists)):
        vx, vy, omega = twists[k, 0], twists[k, 1], twists[k, 2]
        held = hold_angles[k % hold_rows]
        for i in range(len(positions)):
            a = vx - omega * positions[i, 1]
            b = vy + omega * positions[i, 0]
            speed = sqrt(a * a + b * b)
            still = speed < REST
            speeds[k, i] = 0.0 if still else speed
            angles[k, i] = held[i] if still else atan2(b, a)


def module_targets(drive: Drive, twist: ArrayLike, hold_angles: ArrayLike) -> ModuleTargets:
    """Speed and angle of each module for a twist of the body.

    Parameters
    ----------
    drive : SwerveDrive, or its (m, 2) positions  [m, base]
    twist : array_like, shape (..., 3)  [m/s, m/s, rad/s; base]
    hold_angles : array_like, shape (m,) or (..., m)  [rad, base]
        Angles the modules have: one that is to stand still keeps its angle.

    Returns
    -------
    ModuleTargets
        Speeds are 0 or more, angles in [-pi, pi] except those that are kept.

    Raises
    ------
    ValueError
        Wrong shapes, or an entry that is not finite.

    Notes
    -----
    Siradjuddin 2022, equations 16 to 22.

    Examples
    --------
    A left turn on the spot: each wheel stands across the line to the centre.

    >>> square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
    >>> turn = module_targets(square, [0.0, 0.0, 1.0], np.zeros(4))
    >>> np.degrees(turn.angles).round().tolist()
    [135.0, -135.0, -45.0, 45.0]
    """
    drive = as_drive(drive)
    twist = as_floats(twist, "twist", *(None,) * (np.ndim(twist) - 1), 3)
    m = len(drive.positions)
    shape = (*twist.shape[:-1], m)
    held = _angles_now(hold_angles, "hold_angles", shape)
    targets = ModuleTargets(np.empty(shape), np.empty(shape))
    fill_targets(
        drive.positions,
        twist.reshape(-1, 3),
        held.reshape(-1, m),
        targets.speeds.reshape(-1, m),
        targets.angles.reshape(-1, m),
    )
    return targets


def shortest_turn(targets: ModuleTargets, angles: ArrayLike) -> ModuleTargets:
    """The same motion with at most a quarter turn of steering: backwards where that is nearer.

    Parameters
    ----------
    targets : ModuleTargets, shape (..., m)
    angles : array_like, shape (m,) or (..., m)  [rad, base]
        Angles the modules have now; a steering that counts its turns may have any number.

    Returns
    -------
    ModuleTargets
        Angles within a quarter turn of ``angles``, not wrapped; speeds with their sign.

    Raises
    ------
    ValueError
        Wrong shapes, or an entry that is not finite.

    Examples
    --------
    >>> shortest_turn(ModuleTargets(np.array([1.0]), np.array([3.0])), [0.0]).speeds.tolist()
    [-1.0]
    """
    speeds, wanted = _checked(targets)
    now = _angles_now(angles, "angles", wanted.shape)
    turn = wrap_angle(wanted - now)
    flip = np.abs(turn) > np.pi / 2
    turn = np.where(flip, turn - np.copysign(np.pi, turn), turn)
    return ModuleTargets(np.where(flip, -speeds, speeds), now + turn)


def limit_speeds(targets: ModuleTargets, max_speed: float) -> ModuleTargets:
    """All speeds slowed by one factor, so that the fastest module can follow (desaturation).

    Parameters
    ----------
    targets : ModuleTargets, shape (..., m)
    max_speed : float  [m/s]

    Returns
    -------
    ModuleTargets
        The same path, slower; cutting off single wheels would bend it.

    Raises
    ------
    ValueError
        Wrong shapes, an entry that is not finite, or a limit that is not positive.
    """
    speeds, angles = _checked(targets)
    if not 0.0 < max_speed < np.inf:
        raise ValueError(f"max_speed: expected metres per second above 0, got {max_speed}")
    fastest = np.abs(speeds).max(axis=-1, keepdims=True, initial=max_speed)
    # Divided first: the fastest then gets the limit to the bit, never a rounding above it.
    slowed = speeds / fastest * max_speed
    return ModuleTargets(np.where(fastest > max_speed, slowed, speeds), angles)


def cosine_compensation(targets: ModuleTargets, angles: ArrayLike) -> ModuleTargets:
    """Speeds for modules that have not yet reached their angle.

    Parameters
    ----------
    targets : ModuleTargets, shape (..., m)
    angles : array_like, shape (m,) or (..., m)  [rad, base]
        Angles the modules have now.

    Returns
    -------
    ModuleTargets
        Speeds times the cosine of what is still to turn: across its way a wheel stands still
        instead of pushing sideways.

    Raises
    ------
    ValueError
        Wrong shapes, or an entry that is not finite.
    """
    speeds, wanted = _checked(targets)
    now = _angles_now(angles, "angles", wanted.shape)
    return ModuleTargets(speeds * np.cos(wanted - now), wanted)


def _checked(targets: ModuleTargets) -> ModuleTargets:
    try:
        speeds, angles = targets
    except (TypeError, ValueError):
        kind = type(targets).__name__
        raise ValueError(f"targets: expected ModuleTargets (speeds, angles), got {kind}") from None
    speeds = as_floats(speeds, "targets.speeds", *(None,) * max(np.ndim(speeds), 1))
    return ModuleTargets(speeds, as_floats(angles, "targets.angles", *speeds.shape))


def _angles_now(angles: ArrayLike, name: str, shape: tuple[int, ...]) -> FloatArray:
    """Angles of the modules as they are: one row for all targets, or one for each."""
    angles = as_floats(angles, name, *(None,) * (np.ndim(angles) - 1), shape[-1])
    if angles.ndim > 1 and angles.shape != shape:
        raise ValueError(f"{name}: expected shape ({shape[-1]},) or {shape}, got {angles.shape}")
    return angles
