"""Attitude of a robot that is bumped, pushed and sometimes not heard."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.imu.estimate import estimate_attitude
from robocon_course.imu.mahony import MahonyGains

# In motion few samples are pure gravity. A narrow gate keeps those whose length is right within
# four times the data sheet's noise, and a low gain lets the gyroscope carry the rest.
IN_MOTION = MahonyGains(k_p=0.3, k_i=0.0, gate=0.02)
REST = 0.8  # s


def attitude_in_motion(gyro: ArrayLike, accel: ArrayLike, dt: float) -> FloatArray:
    """Attitude during a rough drive that begins with a second at rest.

    The bias is the mean over that rest; the rate is interpolated over gaps; only accelerometer
    samples as long as gravity correct the tilt.

    Parameters
    ----------
    gyro : array_like, shape (n, 3)  [rad/s, body]
        Rows may be NaN.
    accel : array_like, shape (n, 3)  [m/s^2, body]
        Calibrated; rows may be NaN or saturated.
    dt : float  [s]

    Returns
    -------
    ndarray, shape (n, 4)
        Unit quaternions (w, x, y, z), body -> map.

    Raises
    ------
    ValueError
        Wrong shape, or no usable gyroscope sample during the rest.
    """
    gyro = as_floats(gyro, "gyro", None, 3, finite=False)
    seen = np.flatnonzero(np.isfinite(gyro).all(axis=1))
    resting = seen[seen < REST / dt]
    if not len(resting):
        raise ValueError(f"gyro: no usable sample in the first {REST} s; start at rest")
    rows = np.arange(len(gyro))
    bridged = np.column_stack([np.interp(rows, seen, gyro[seen, k]) for k in range(3)])
    rates = bridged - gyro[resting].mean(axis=0)
    return estimate_attitude(rates, accel, dt, gains=IN_MOTION).quaternions
