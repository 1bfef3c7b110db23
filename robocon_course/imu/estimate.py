"""The Mahony filter over time: sample by sample on a running robot, or a whole log at once."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.imu.attitude import attitude_from_accel, euler_angles, has_direction
from robocon_course.imu.mahony import (
    MahonyGains,
    MahonyState,
    as_memory,
    checked_gains,
    mahony_run,
    mahony_update,
)


class AttitudeFilter:
    """The Mahony filter for a running robot: it only remembers the state between samples.

    Starts level and takes the tilt from the first usable accelerometer sample. A bad sample
    is bridged and counted, never raised: NaN, no direction, outside the gate, or a time step that
    is not a positive number (two datagrams with one time stamp).

    Parameters
    ----------
    gains : MahonyGains
    initial : array_like, shape (4,), optional
        Unit quaternion to start from instead, body -> map.

    Attributes
    ----------
    rejected : int
        Samples not fully used so far.
    """

    def __init__(
        self,
        gains: MahonyGains = MahonyGains(),  # noqa: B008 - a NamedTuple cannot change
        initial: ArrayLike | None = None,
    ) -> None:
        self._gains = checked_gains(gains)
        self._memory = _start(initial)
        self._started = initial is not None
        self.rejected = 0

    def update(self, gyro: ArrayLike, accel: ArrayLike, dt: float) -> FloatArray:
        """Take one sample in; the attitude after it.

        Parameters
        ----------
        gyro : array_like, shape (3,)  [rad/s, body]
        accel : array_like, shape (3,)  [m/s^2, body]
        dt : float  [s]
            Time since the sample before.

        Returns
        -------
        ndarray, shape (4,)
            Unit quaternion (w, x, y, z), body -> map.

        Raises
        ------
        ValueError
            Wrong shape.
        """
        gyro = as_floats(gyro, "gyro", 3, finite=False)
        accel = as_floats(accel, "accel", 3, finite=False)
        if not self._started and has_direction(accel):
            self._memory[:4] = attitude_from_accel(accel)
            self._started = True
        elif not (
            0.0 < dt < inf and mahony_update(self._memory, gyro, accel, float(dt), *self._gains)
        ):
            self.rejected += 1
        return self._memory[:4].copy()

    @property
    def state(self) -> MahonyState | None:
        """What to keep and give back later; None before the first usable sample."""
        memory = self._memory.copy()
        return MahonyState(memory[:4], memory[4:]) if self._started else None

    @state.setter
    def state(self, state: MahonyState | None) -> None:
        self._memory = _start(None) if state is None else as_floats(as_memory(state), "state", 7)
        self._started = state is not None


@dataclass(frozen=True)
class AttitudeLog:
    """Attitude after each sample of a log.

    Attributes
    ----------
    quaternions : ndarray, shape (n, 4)
        Unit quaternions (w, x, y, z), body -> map.
    rejected : int
        Samples that were not fully used: NaN, no direction, or outside the gate.
    """

    quaternions: FloatArray
    rejected: int

    @property
    def roll(self) -> FloatArray:
        """Turn about the body's x axis, shape (n,) [rad]."""
        return euler_angles(self.quaternions)[:, 0]

    @property
    def pitch(self) -> FloatArray:
        """Turn about the y axis, nose down positive, shape (n,) [rad]."""
        return euler_angles(self.quaternions)[:, 1]

    @property
    def yaw(self) -> FloatArray:
        """Turn about the map's z axis, shape (n,) [rad]."""
        return euler_angles(self.quaternions)[:, 2]


def estimate_attitude(
    gyro: ArrayLike,
    accel: ArrayLike,
    dt: ArrayLike,
    *,
    gains: MahonyGains = MahonyGains(),  # noqa: B008 - a NamedTuple cannot change
    initial: ArrayLike | None = None,
) -> AttitudeLog:
    """Attitude after each sample of a recorded log.

    Parameters
    ----------
    gyro : array_like, shape (n, 3)  [rad/s, body]
    accel : array_like, shape (n, 3)  [m/s^2, body]
        Samples that are not finite are bridged as in `mahony_step`, and counted.
    dt : float or array_like, shape (n,)  [s]
        Time since the sample before; as an array it may hold zeros (two rows with one time stamp).
    gains : MahonyGains
    initial : array_like, shape (4,), optional
        Unit quaternion before the first sample, body -> map. Without it the first row is the tilt
        that the first usable accelerometer sample shows, with yaw 0; rows before that one follow
        the gyroscope from level.

    Returns
    -------
    AttitudeLog

    Raises
    ------
    ValueError
        Wrong shapes or lengths, a time step that is negative or not finite, wrong gains or initial.

    Notes
    -----
    Row by row the same numbers as `AttitudeFilter`.

    Examples
    --------
    >>> log = estimate_attitude(np.zeros((3, 3)), [[0.0, 1.0, 1.0]] * 3, 0.01)
    >>> np.degrees(log.roll).round(3).tolist()
    [45.0, 45.0, 45.0]
    """
    gyro = as_floats(gyro, "gyro", None, 3, finite=False)
    n = len(gyro)
    accel = as_floats(accel, "accel", n, 3, finite=False)
    steps = _steps(dt, n)
    gains = checked_gains(gains)
    state, out = _start(initial), np.empty((n, 4))
    start = _first_usable(accel) if initial is None else n
    rejected = mahony_run(state, gyro[:start], accel[:start], steps[:start], *gains, out)
    if start < n:
        state[:4] = out[start] = attitude_from_accel(accel[start])
        after = slice(start + 1, n)
        rejected += mahony_run(state, gyro[after], accel[after], steps[after], *gains, out[after])
    return AttitudeLog(out, rejected)


def _first_usable(accel: FloatArray) -> int:
    """Row of the first sample with a direction; the number of rows if there is none."""
    for rows in (accel[:1], accel):  # nearly always the very first: spare a long log the search
        usable = np.flatnonzero(has_direction(rows))
        if len(usable):
            return int(usable[0])
    return len(accel)


def _start(initial: ArrayLike | None) -> FloatArray:
    """Memory of the kernel, (7,): level, or the given attitude."""
    if initial is None:
        return as_memory(MahonyState.level())
    quaternion = as_floats(initial, "initial", 4)
    norm = np.linalg.norm(quaternion)
    if abs(norm - 1.0) > 0.01:
        raise ValueError(f"initial: must be a unit quaternion (w, x, y, z), got length {norm:.6g}")
    return np.concatenate([quaternion / norm, np.zeros(3)])


def _steps(dt: ArrayLike, n: int) -> FloatArray:
    """Time steps as an array, (n,)."""
    if np.ndim(dt) == 0:
        if not 0.0 < dt < inf:
            raise ValueError(f"dt: must be a positive number of seconds, got {dt!r}")
        return np.full(n, dt, dtype=np.float64)
    steps = as_floats(dt, "dt", n)
    if (steps < 0.0).any():
        k = int(np.argmax(steps < 0.0))
        raise ValueError(f"dt: is {steps[k]} s in row {k}; sort the log by time first")
    return steps
