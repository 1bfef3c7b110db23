"""From encoder counts to the distance each dead wheel rolled.

A dead wheel is not driven. It only rolls along and counts: an encoder of P pulses per turn, read on
both edges of both channels, counts 4 P steps a turn.

    travel = 2 π radius · counts / counts_per_turn

A counter in a microcontroller has 16 or 32 bits. It wraps around, and the difference of two
readings is the signed number that fits: the one nearest to 0.

Source: thesis on the localisation of a swerve robot, Universitas Negeri Yogyakarta, 2024 (sizes of
the robot's three wheels); path tracking thesis, PENS Surabaya (pulses per millimetre).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats, frozen
from robocon_course.drivetrain import wheel_matrix

WELL_POSED = 1e-6  # smallest singular value of a wheel matrix beside its largest


@dataclass(frozen=True, eq=False)
class TrackingWheels:
    """Where a robot's measuring wheels stand and how large they are.

    Attributes
    ----------
    positions : array_like, shape (n, 2)  [m, base]
        Where the wheels touch the floor.
    directions : array_like, shape (n,)  [rad, base]
        Where each wheel rolls to when its counter counts up.
    radius : float or array_like, shape (n,)  [m]
        One number for all wheels, or one for each.
    ticks_per_turn : float
        Counts of the encoder in one turn of the wheel: 4 times its pulses, times the gear ratio.

    Raises
    ------
    ValueError
        Wrong shapes, an entry that is not finite, or a size that is not positive.
    """

    positions: ArrayLike
    directions: ArrayLike
    radius: ArrayLike
    ticks_per_turn: float

    def __post_init__(self) -> None:
        positions = as_floats(self.positions, "positions", None, 2)
        n = len(positions)
        one_size = np.ndim(self.radius) == 0
        radius = as_floats([self.radius] * n if one_size else self.radius, "radius", n)
        if not (radius > 0.0).all():
            raise ValueError(f"radius: expected metres above 0, got {radius.min():g}")
        if not 0.0 < self.ticks_per_turn < np.inf:
            raise ValueError(f"ticks_per_turn: expected counts above 0, got {self.ticks_per_turn}")
        checked = {
            "positions": positions,
            "directions": as_floats(self.directions, "directions", n),
            "radius": radius,
        }
        for name, value in checked.items():
            object.__setattr__(self, name, frozen(value))

    @cached_property
    def metres_per_tick(self) -> FloatArray:
        """How far each wheel rolls from one count to the next, shape (n,) [m]."""
        return frozen(2.0 * np.pi * self.radius / self.ticks_per_turn)

    @cached_property
    def matrix(self) -> FloatArray:
        """Wheel travel = matrix @ (forward, left, turn); shape (n, 3)."""
        return frozen(wheel_matrix(self.positions, self.directions))

    @cached_property
    def solver(self) -> FloatArray:
        """(forward, left, turn) = solver @ travel in the least-squares sense; shape (3, n)."""
        return frozen(self._inverse(3)[:, : len(self.radius)])

    @cached_property
    def shift_solver(self) -> FloatArray:
        """(forward, left) = shift_solver @ travel + shift_per_turn * turn; shape (2, n)."""
        return frozen(self._inverse(2)[:, : len(self.radius)])

    @cached_property
    def shift_per_turn(self) -> FloatArray:
        """What a turn known from elsewhere takes off the wheels' travel; shape (2,) [m]."""
        return frozen(-self._inverse(2) @ self._constraints[:, 2])

    @cached_property
    def per_tick(self) -> FloatArray:
        """How each wheel's count moves the base, its turn known from elsewhere; shape (3, n)."""
        shift = self.shift_solver * self.metres_per_tick
        return frozen(np.vstack([shift, np.zeros(len(self.radius))]))

    @cached_property
    def per_turn(self) -> FloatArray:
        """How such a turn moves the base, as seen by the wheels; shape (3,)."""
        return frozen(np.append(self.shift_per_turn, 1.0))

    @cached_property
    def turn_per_tick(self) -> FloatArray:
        """How each wheel's count turns the base, by the wheels alone; shape (n,) [rad]."""
        return frozen(self.solver[2] * self.metres_per_tick)

    @cached_property
    def _constraints(self) -> FloatArray:
        """The wheel matrix, with one more row where the wheels imply a wheel that never rolls."""
        if len(self.radius) != 2 or abs(np.sin(np.diff(self.directions)[0])) > WELL_POSED:
            return self.matrix
        # Side by side: their axle cannot slide along itself, as if a third wheel stood across in
        # its middle.
        middle, across = self.positions.mean(axis=0), self.directions[0] + np.pi / 2
        return np.concatenate([self.matrix, wheel_matrix([middle], [across])])

    def _inverse(self, unknowns: int) -> FloatArray:
        matrix = self._constraints[:, :unknowns]
        strengths = np.linalg.svd(matrix, compute_uv=False)
        if len(strengths) < unknowns or strengths[-1] < WELL_POSED * strengths[0]:
            raise ValueError(
                f"wheels: these {len(self.radius)} wheels cannot tell forward, left and turn "
                "apart; put one of them across the others, and away from the centre"
            )
        return np.linalg.pinv(matrix)


def tick_changes(counters: ArrayLike, bits: int = 64) -> NDArray[np.int64]:
    """Counts between readings of counters that wrap around.

    Parameters
    ----------
    counters : array_like of int, shape (n + 1, ...)
        Readings of the counters, one row a sample.
    bits : int
        Width of the counters, signed or not: 16 for most timers of a microcontroller.

    Returns
    -------
    ndarray of int64, shape (n, ...)
        The change nearest to 0 that explains two readings; right as long as no wheel turns by
        half the counter's range between samples.

    Raises
    ------
    ValueError
        Not whole numbers, no readings, or bits that are no whole number from 1 to 64.

    Examples
    --------
    >>> tick_changes([65530, 4, 65534], bits=16).tolist()
    [10, -6]
    """
    counters = np.asarray(counters)
    if counters.dtype.kind not in "iu" or counters.ndim == 0:
        raise ValueError(
            "counters: expected whole numbers, one row a sample, got "
            f"{counters.dtype} of shape {counters.shape}; convert with .astype(int) if they are"
        )
    if not len(counters):
        raise ValueError("counters: expected at least one reading, got none")
    if not isinstance(bits, int | np.integer) or not 1 <= bits <= 64:
        raise ValueError(f"bits: expected a whole number from 1 to 64, got {bits!r}")
    changes = np.diff(counters.astype(np.uint64), axis=0)  # wraps around at 64 bits, as it should
    unused = np.uint64(64 - bits)
    return (changes << unused).view(np.int64) >> np.int64(unused)  # the sign moves down again


def wheel_travel(wheels: TrackingWheels, ticks: ArrayLike) -> FloatArray:
    """Distance that each wheel rolled.

    Parameters
    ----------
    wheels : TrackingWheels
        n wheels.
    ticks : array_like, shape (..., n)
        Counts since the sample before, as `tick_changes` gives them.

    Returns
    -------
    ndarray, shape (..., n)  [m]

    Raises
    ------
    ValueError
        Another number of wheels, or an entry that is not finite.

    Examples
    --------
    >>> wheels = TrackingWheels([[0, 0.25], [0, -0.25]], [0, 0], radius=0.03, ticks_per_turn=3200)
    >>> wheel_travel(wheels, [3200, -1600]).round(4).tolist()
    [0.1885, -0.0942]
    """
    leading = (None,) * (np.ndim(ticks) - 1)
    return as_floats(ticks, "ticks", *leading, len(wheels.radius)) * wheels.metres_per_tick
