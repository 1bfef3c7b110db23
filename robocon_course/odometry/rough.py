"""Dead reckoning on a drive on which wheels slip, an encoder falls silent and the gyroscope too.

The gyroscope and the two parallel wheels know the turn twice. With the gyroscope's turn taken off,
left and right wheel must say the same way forward. Where they do not, one of them is wrong, and it
is the one that says less: a dead wheel has no motor, so it can roll too little, never too much.
Where the gyroscope is silent, the wheels' own turn bridges the gap.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.odometry.motion import integrate
from robocon_course.odometry.wheels import TrackingWheels, wheel_travel

REST = 0.8  # s
# Two wheels that roll differ by a count each (0.06 mm) and by the gyroscope's noise over half the
# track (0.0004 mm) in 10 ms. Five counts are neither.
APART = 5


def rough_drive_poses(
    wheels: TrackingWheels, ticks: ArrayLike, gyro: ArrayLike, dt: float
) -> FloatArray:
    """Poses of a rough drive that begins with a second at rest.

    Parameters
    ----------
    wheels : TrackingWheels
        Left and right, both rolling ahead, and rear, rolling to the left; calibrated.
    ticks : array_like, shape (n, 3)
        Counts of each sample.
    gyro : array_like, shape (n,)  [rad/s, base]
        Rate about z, with a constant bias; NaN where no sample came.
    dt : float  [s]

    Returns
    -------
    ndarray, shape (n + 1, 3)  [m, m, rad; map]
        From (0, 0, 0).

    Raises
    ------
    ValueError
        Wrong shapes, or no gyroscope sample during the rest.
    """
    travel = wheel_travel(wheels, as_floats(ticks, "ticks", None, 3))
    gyro = as_floats(gyro, "gyro", len(travel), finite=False)
    rest = gyro[: round(REST / dt)]
    if not np.isfinite(rest).any():
        raise ValueError(f"gyro: no sample in the first {REST} s; start at rest")
    by_wheels = travel @ wheels.solver[2]
    turn = np.where(np.isfinite(gyro), (gyro - np.nanmean(rest)) * dt, by_wheels)
    left, right, rear = (travel - turn[:, None] * wheels.matrix[:, 2]).T
    larger = np.where(np.abs(left) > np.abs(right), left, right)
    apart = np.abs(left - right) > APART * wheels.metres_per_tick[:2].max()
    forward = np.where(apart, larger, (left + right) / 2)
    return integrate(np.column_stack([forward, rear, turn]))
