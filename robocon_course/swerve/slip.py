"""Which wheel slips? The one without which the others agree."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.swerve.modules import Drive, as_drive

NO_SLIP = -1
"""What `find_slip` says of a moment at which all wheels roll."""
SLIP_SPEED = 0.1
"""A wheel that is off by more than this slips [m/s]."""
SLIP_WINDOW = 7
"""Samples that are looked at together; noise changes from sample to sample, slip does not."""


def find_slip(drive: Drive, speeds: ArrayLike, angles: ArrayLike) -> NDArray[np.intp]:
    """The wheel that slips at each moment of a log.

    Parameters
    ----------
    drive : SwerveDrive, or its (m, 2) positions  [m, base]
        At least three modules; of two nobody can say which is wrong.
    speeds : array_like, shape (n, m)  [m/s]
    angles : array_like, shape (n, m)  [rad, base]

    Returns
    -------
    ndarray of int, shape (n,)
        Number of the module, or `NO_SLIP`.

    Raises
    ------
    ValueError
        Fewer than three modules, wrong shapes, or an entry that is not finite.

    Notes
    -----
    A slipping wheel errs along its rolling direction d by an unknown s. With the projector P on
    what no twist explains, the least-squares estimate is s = (d · P c) / (d · P d), and it
    explains (d · P c)² / (d · P d) of the squared residual: the generalised likelihood ratio of
    one outlier. In the median over a few samples, the wheel that explains most is to blame.
    """
    drive = as_drive(drive)
    m = len(drive.positions)
    if m < 3:
        raise ValueError(f"drive: to tell which wheel slips takes three modules, got {m}")
    speeds = as_floats(speeds, "speeds", None, m)
    angles = as_floats(angles, "angles", len(speeds), m)
    c, s = np.cos(angles), np.sin(angles)
    projector = np.eye(2 * m) - drive.matrix @ drive.solver
    residual = np.hstack([speeds * c, speeds * s]) @ projector
    along = c * residual[:, :m] + s * residual[:, m:]
    forward, left = projector[:m, :m].diagonal(), projector[m:, m:].diagonal()
    mixed = projector[:m, m:].diagonal()
    share = c * c * forward + s * s * left + 2.0 * c * s * mixed
    explained = _smoothed(along**2 / share)
    slip = _smoothed(np.abs(along / share))
    suspect = explained.argmax(axis=1)
    slips = np.take_along_axis(slip, suspect[:, None], axis=1)[:, 0] > SLIP_SPEED
    return np.where(slips, suspect, NO_SLIP)


def _smoothed(values: FloatArray) -> FloatArray:
    """Medians over a window around each row; a median keeps the edges of a step where they are."""
    half = SLIP_WINDOW // 2
    rows = np.arange(len(values))[:, None] + np.arange(-half, half + 1)
    return np.median(values[rows.clip(0, len(values) - 1)], axis=1)
