"""What does the sensor read when nothing happens, and how long is its g?

    gyroscope        rate         = raw - bias               bias: the mean while nothing moves
    accelerometer    acceleration = (raw - bias) * scale     axis by axis

Gravity is the ruler: at rest |acceleration| = g whichever way the sensor lies. With an axis held
straight up and straight down, bias = (max + min)/2 and scale = 2 g/(max - min). With any other
mixture of directions the raw samples lie on an ellipsoid, whose centre is the bias and whose
half-axes are g/scale. (The mean of one still log is no accelerometer bias: it holds gravity.)

Source: F. Ferraris, U. Grimaldi, M. Parvis, Procedure for effortless in-field calibration of
three-axis rate gyros and accelerometers, Sensors and Materials 7(5), 1995; the fit: I. Frosio,
F. Pedersini, N. Borghese, Autocalibration of MEMS accelerometers, IEEE Transactions on
Instrumentation and Measurement 58(6), 2009, equations 2 to 6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import CourseError, FloatArray, as_floats, as_vectors
from robocon_course.geometry import GRAVITY

# A still log of 15 to 20 s has 1500 rows and more; below 100 a mean says little and a bump hides.
FEWEST_ROWS = 100
# Movement shows as a block whose mean or spread leaves the others. The absolute limits, 0.57 deg/s
# and 1.7 deg/s, let a table that hums pass; the relative ones noisy sensors, and raw counts, where
# 0.01 means nothing. Ten rows of white noise keep both within 2 sigma; 3 and 5 leave room.
MEAN_LIMIT, MEAN_SIGMAS = 0.01, 3.0
# A mean of many rows scatters less than one row: what is usual among the blocks themselves counts.
MEAN_SPREADS = 8.0
SPREAD_LIMIT, SPREAD_SIGMAS = 0.03, 5.0
# Smallest singular value per sqrt(row) of the ellipsoid fit. One over it is how much worse bias or
# scale gets than a plain mean: 20. Six rests give 0.58, tilting by 20 degrees each way 0.01.
LEAST_SPAN = 0.05
# Scatter of the corrected lengths, in g. Slow turns in a hand stay below 0.1; the noise of a
# sensor at rest, taken for an ellipsoid, has 0.35 and more.
MOST_SCATTER = 0.15


class MovedError(CourseError, ValueError):
    """The log that was meant to be still holds movement.

    Attributes
    ----------
    rows : tuple of (int, int)
        First and last row of the stretch that moved first.
    """

    def __init__(self, message: str, rows: tuple[int, int]) -> None:
        super().__init__(message)
        self.rows = rows


@dataclass(frozen=True)
class GyroCalibration:
    """What to subtract from a gyroscope.

    Attributes
    ----------
    bias : ndarray, shape (3,)  [unit of the raw log]
    noise : ndarray, shape (3,)  [unit of the raw log]
        Standard deviation of one sample around its slow drift.
    """

    bias: FloatArray
    noise: FloatArray

    def apply(self, raw: ArrayLike) -> FloatArray:
        """Rates without the bias.

        Parameters
        ----------
        raw : array_like, shape (..., 3)  [unit of the still log]

        Returns
        -------
        ndarray, shape (..., 3)
        """
        return as_vectors(raw, "raw", 3) - self.bias


@dataclass(frozen=True)
class AccelerometerCalibration:
    """Bias and scale of an accelerometer, axis by axis.

    Attributes
    ----------
    bias : ndarray, shape (3,)  [raw unit]
    scale : ndarray, shape (3,)  [m/s^2 per raw unit]
    """

    bias: FloatArray
    scale: FloatArray

    def apply(self, raw: ArrayLike) -> FloatArray:
        """Accelerations (raw - bias) * scale.

        Parameters
        ----------
        raw : array_like, shape (..., 3)  [raw unit]

        Returns
        -------
        ndarray, shape (..., 3)  [m/s^2]
        """
        return (as_vectors(raw, "raw", 3) - self.bias) * self.scale


def calibrate_gyro(still: ArrayLike, *, dt: float | None = None) -> GyroCalibration:
    """Bias and noise of a gyroscope from a log during which nothing moved.

    Parameters
    ----------
    still : array_like, shape (n, 3)  [rad/s or raw counts]
        15 to 20 s are good. Rows with NaN are left out; 100 must remain.
    dt : float, optional  [s]
        Time between rows, so that a refusal can say when in seconds.

    Returns
    -------
    GyroCalibration

    Raises
    ------
    MovedError
        The sensor moved; the message says in which rows, and what to do.
    ValueError
        Wrong shape, or fewer than 100 usable rows.

    Examples
    --------
    >>> rng = np.random.default_rng(1)
    >>> calibrate_gyro(rng.normal([0.02, 0.0, -0.01], 0.001, (2000, 3))).bias.round(3).tolist()
    [0.02, 0.0, -0.01]
    """
    still = as_floats(still, "still", None, 3, finite=False)
    rows = np.flatnonzero(np.isfinite(still).all(axis=1))
    if len(rows) < FEWEST_ROWS:
        raise ValueError(
            f"still: {len(rows)} usable rows are too few for a bias, {FEWEST_ROWS} the least; "
            "record 15 to 20 s at rest"
        )
    usable = still[rows]
    blocks = np.array_split(np.arange(len(usable)), len(usable) // max(10, len(usable) // 40))
    noise = _sample_noise(usable, blocks)
    mean = np.array([usable[block].mean(axis=0) for block in blocks])
    spread = np.array([usable[block].std(axis=0) for block in blocks])
    off = np.abs(mean - np.median(mean, axis=0))
    usual = np.maximum(1.4826 * np.median(off, axis=0), noise / np.sqrt(len(blocks[0])))
    far = np.minimum(MEAN_SIGMAS * noise, MEAN_SPREADS * usual)
    moved = (off > np.maximum(MEAN_LIMIT, far)) | (
        spread > np.maximum(SPREAD_LIMIT, SPREAD_SIGMAS * noise)
    )
    if moved.any():
        raise _moved([rows[block] for block in blocks], moved, dt)
    return GyroCalibration(bias=usable.mean(axis=0), noise=noise)


def _sample_noise(usable: FloatArray, blocks: list[np.ndarray]) -> FloatArray:
    """Standard deviation of the white part, (3,): neighbours' differences hide slow motion."""
    steps = [np.diff(usable[block], axis=0) for block in blocks]
    typical = np.median([np.sqrt((step**2).mean(axis=0)) for step in steps], axis=0)
    # A quiet axis may rest on one code of a coarse converter in most blocks and flicker in a few.
    overall = np.sqrt((np.diff(usable, axis=0) ** 2).mean(axis=0))
    return np.where(typical > 0.0, typical, overall) / np.sqrt(2.0)


def _moved(rows: list[np.ndarray], moved: np.ndarray, dt: float | None) -> MovedError:
    """The refusal, naming the first stretch of blocks that moved."""
    which = moved.any(axis=1)
    first = int(np.argmax(which))
    still_again = np.flatnonzero(~which[first:])
    last = first + int(still_again[0]) - 1 if len(still_again) else len(which) - 1
    start, stop = int(rows[first][0]), int(rows[last][-1])
    when = f"rows {start} to {stop}"
    if dt is not None:
        when += f" ({start * dt:.2f} s to {stop * dt:.2f} s)"
    axes = ", ".join("xyz"[axis] for axis in np.flatnonzero(moved[first : last + 1].any(axis=0)))
    return MovedError(
        f"still: the sensor moved in {when}, axis {axes}; "
        "record again without touching it, or cut those rows away",
        (start, stop),
    )


def calibrate_accelerometer(rests: ArrayLike, gravity: float = GRAVITY) -> AccelerometerCalibration:
    """Bias and scale of an accelerometer from the means of resting sections.

    Parameters
    ----------
    rests : array_like, shape (k, 3), k >= 6  [m/s^2 or raw counts]
        One mean reading per rest. Exactly six: each axis once up and once down, in any order. More
        than six: any directions that go all around.
    gravity : float  [m/s^2]

    Returns
    -------
    AccelerometerCalibration

    Raises
    ------
    ValueError
        Fewer than six rests, one not finite, six that are not up and down on each axis, or more
        that do not go all around.

    Notes
    -----
    Six: bias = (max + min)/2 and scale = 2 g/(max - min) per axis (Ferraris 1995). An axis off the
    vertical reads too short, by 0.4 % at 5 degrees; more rests go to `fit_ellipsoid`: no such loss.

    Examples
    --------
    >>> up_down = [[10, 0, 1], [-9, 0, 1], [0.5, 9, 1], [0.5, -9, 1], [0.5, 0, 11], [0.5, 0, -9]]
    >>> calibrate_accelerometer(up_down).bias.tolist()
    [0.5, 0.0, 1.0]
    """
    rests = as_floats(rests, "rests", None, 3)
    if len(rests) < 6:
        raise ValueError(
            f"rests: six or more are needed, got {len(rests)}; rest it with each axis up and down"
        )
    if len(rests) > 6:
        return fit_ellipsoid(rests, gravity)
    most, least = rests.max(axis=0), rests.min(axis=0)
    if len({*rests.argmax(axis=0), *rests.argmin(axis=0)}) == 6:
        bias = (most + least) / 2.0
        scale = 2.0 * _positive(gravity) / (most - least)
        lengths = np.linalg.norm((rests - bias) * scale, axis=1) / gravity
        if np.abs(lengths - 1.0).max() < 0.05:  # 5 %: about 18 degrees off the vertical
            return AccelerometerCalibration(bias, scale)
    raise ValueError(
        "rests: six must hold each axis once up and once down; lay the sensor on its six sides, or "
        "give more directions (fit_ellipsoid takes slow turns, no axis ever vertical)"
    )


def fit_ellipsoid(samples: ArrayLike, gravity: float = GRAVITY) -> AccelerometerCalibration:
    """Bias and scale of an accelerometer from samples at rest or in slow turns, any directions.

    Parameters
    ----------
    samples : array_like, shape (n, 3)  [m/s^2 or raw counts]
        Rows with NaN are left out; six must remain. A push would count as gravity: turn slowly.
    gravity : float  [m/s^2]

    Returns
    -------
    AccelerometerCalibration

    Raises
    ------
    ValueError
        Too few samples, or directions that do not span: turned about one axis only, or hardly.

    Notes
    -----
    Minimises the sum of (|(raw - bias) * scale| - g)^2 by Gauss-Newton (Frosio 2009, equation 6)
    from the ellipsoid A x^2 + B y^2 + C z^2 + D x + E y + F z = 1 fitted by linear least squares.
    """
    samples = as_floats(samples, "samples", None, 3, finite=False)
    samples = samples[np.isfinite(samples).all(axis=1)]
    gravity = _positive(gravity)
    if len(samples) < 6:
        raise ValueError(f"samples: six or more usable rows are needed, got {len(samples)}")
    middle, size = samples.mean(axis=0), np.ptp(samples, axis=0).max() / 2.0
    if size == 0.0:
        raise _no_span()
    unit = (samples - middle) / size  # counts or m/s^2: the fit sees numbers around 1
    try:
        bias, scale, length, jacobian = _fit(unit)
    except np.linalg.LinAlgError:
        raise _no_span() from None
    if np.linalg.svd(jacobian, compute_uv=False)[-1] < LEAST_SPAN * np.sqrt(len(unit)):
        raise _no_span()
    if (length - 1.0).std() > MOST_SCATTER:
        raise ValueError(
            "samples: they do not lie on an ellipsoid; a sensor that lay still, or was shaken, "
            "shows no gravity in all directions. Turn it slowly about all three axes"
        )
    return AccelerometerCalibration(middle + bias * size, scale * gravity / size)


def _fit(unit: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Centre, 1/half-axis, length of every corrected sample, and the last Jacobian."""
    bias, scale = _algebraic_fit(unit)
    for _ in range(10):
        moved = (unit - bias) * scale
        length = np.linalg.norm(moved, axis=1, keepdims=True)
        ray = moved / length
        jacobian = np.hstack([-ray, ray * moved])  # d length / d (bias * scale, log scale)
        step = np.linalg.lstsq(jacobian, 1.0 - length[:, 0])[0]
        bias, scale = bias + step[:3] / scale, scale * np.exp(np.clip(step[3:], -1.0, 1.0))
        if not np.isfinite([*bias, *scale]).all():
            raise np.linalg.LinAlgError
    return bias, scale, length[:, 0], jacobian


def _algebraic_fit(unit: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and 1/half-axis of the ellipsoid through ``unit``, linear least squares."""
    design = np.hstack([unit**2, unit])
    coefficients, _, rank, _ = np.linalg.lstsq(design, np.ones(len(unit)))
    square, linear = coefficients[:3], coefficients[3:]
    if rank < 6 or (square <= 0.0).any():
        raise _no_span()
    centre = -linear / (2.0 * square)
    return centre, np.sqrt(square / (1.0 + (square * centre**2).sum()))


def _no_span() -> ValueError:
    return ValueError(
        "samples: their directions do not span an ellipsoid; "
        "turn the sensor slowly all the way round about x, y and z"
    )


def _positive(gravity: float) -> float:
    if not 0.0 < gravity < np.inf:
        raise ValueError(f"gravity: must be a positive number of m/s^2, got {gravity!r}")
    return float(gravity)
