"""Recorded logs in, angles out.

A log is a CSV file with a header. Columns are known by their names, in any order and case, with
other columns beside them; commas, semicolons, tabs or spaces part the cells.

==========  ==========================================================  =========================
what        names                                                       unit, by the name's ending
==========  ==========================================================  =========================
time        t, time, timestamp, seconds_elapsed                         s; ``_ms``, ``_us``, ``_ns``
gyroscope   gyr_x, gyro_x, gyroscope_x, gx, wx, omega_x, ...            rad/s; ``_deg_s``, ``_dps``
accel.      acc_x, accel_x, accelerometer_x, acceleration_x, ax, ...    m/s²; ``_g``
==========  ==========================================================  =========================
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from math import radians
from os import PathLike

import numpy as np

from robocon_course._arrays import FloatArray
from robocon_course.geometry import GRAVITY
from robocon_course.imu.attitude import euler_angles
from robocon_course.imu.estimate import AttitudeLog

_SECOND = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_RATE = {"": 1.0, "rad_s": 1.0, "rads": 1.0, "rad_per_s": 1.0}
_RATE |= dict.fromkeys(("deg_s", "degs", "dps", "deg_per_s"), radians(1.0))
_ACCEL = {"": 1.0, "m_s2": 1.0, "ms2": 1.0, "m_s_2": 1.0, "mps2": 1.0, "g": GRAVITY}
_TIME_NAMES = "t|time|timestamp|time_stamp|elapsed|seconds_elapsed"
_GYRO_NAMES = "gyr|gyro|gyroscope|g|w|omega|angular_velocity|rotation_rate"
_ACCEL_NAMES = "acc|accel|accelerometer|acceleration|a"  # linear_acceleration lacks gravity


@dataclass(frozen=True)
class ImuLog:
    """A recorded log, one row per sample.

    Attributes
    ----------
    time : ndarray, shape (n,)  [s]
        As recorded; never runs backwards, but two rows may share a time.
    gyro : ndarray, shape (n, 3)  [rad/s, body]
        NaN where the cell was empty.
    accel : ndarray, shape (n, 3)  [m/s^2, body]
        NaN where the cell was empty.
    """

    time: FloatArray
    gyro: FloatArray
    accel: FloatArray

    @property
    def dt(self) -> FloatArray:
        """Time since the sample before, shape (n,) [s]; for the first, the median of the others."""
        steps = np.diff(self.time)
        return np.concatenate([[np.median(steps) if len(steps) else 0.0], steps])


def read_log(path: str | PathLike[str], *, rate: float | None = None) -> ImuLog:
    """Time, gyroscope and accelerometer of a CSV file.

    Parameters
    ----------
    path : path
        Columns as in the table at the head of this module. A line that starts with # is a remark.
    rate : float, optional  [Hz]
        Samples per second, for a file without time; it then takes the place of a time column.

    Returns
    -------
    ImuLog

    Raises
    ------
    FileNotFoundError
        No such file.
    ValueError
        A missing column, a cell that is no number, time that is missing, runs backwards or is not
        in seconds. Rows are counted as a spreadsheet does: the header is row 1.
    """
    if rate is not None and not 0.0 < rate < np.inf:
        raise ValueError(f"rate: must be a positive number of samples per second, got {rate!r}")
    with open(path, newline="", encoding="utf-8-sig", errors="replace") as file:
        lines = [(row, text) for row, text in enumerate(file, 1) if text.strip("\r\n\t ;,")]
    lines = [(row, text) for row, text in lines if not text.startswith("#")]
    if len(lines) < 2:
        raise ValueError(f"{path}: holds no header with rows below it; is it an IMU log?")
    header = lines[0][1]
    delimiter = max(",;\t", key=header.count) if any(mark in header for mark in ",;\t") else None
    names = _cells(header, delimiter)
    columns = _find_columns(names, path, need_time=rate is None)
    numbers = _numbers(lines[1:], names, columns, delimiter, path)
    time = np.arange(len(numbers)) / rate if rate else _checked_time(numbers[:, 0], lines, path)
    return ImuLog(time, numbers[:, -6:-3].copy(), numbers[:, -3:].copy())


def write_angles(path: str | PathLike[str], log: ImuLog, attitude: AttitudeLog) -> None:
    """Write angles as CSV: t_s, roll_deg, pitch_deg, yaw_deg, q_w, q_x, q_y, q_z.

    Parameters
    ----------
    path : path
        An existing file is replaced.
    log : ImuLog
        Gives the time of each row.
    attitude : AttitudeLog
        Of the same length.

    Raises
    ------
    ValueError
        Log and attitude differ in length.
    """
    if len(log.time) != len(attitude.quaternions):
        raise ValueError(
            f"attitude: has {len(attitude.quaternions)} rows, the log {len(log.time)}; "
            "give the attitude that was estimated from this log"
        )
    degrees = np.degrees(euler_angles(attitude.quaternions))
    with open(path, "w", newline="", encoding="utf-8") as file:
        file.write("t_s,roll_deg,pitch_deg,yaw_deg,q_w,q_x,q_y,q_z\n")
        rows = np.column_stack([log.time, degrees, attitude.quaternions])
        np.savetxt(file, rows, fmt=["%.6f"] + ["%.4f"] * 3 + ["%.8f"] * 4, delimiter=",")


def _cells(text: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return text.split()
    return [cell.strip() for cell in next(csv.reader([text], delimiter=delimiter))]


def _find_columns(
    names: list[str], path: str | PathLike[str], *, need_time: bool
) -> list[tuple[int, float]]:
    """Index and unit of time (if needed), gyro x y z, accel x y z."""
    wanted = [("time", _TIME_NAMES, "", _SECOND)] if need_time else []
    wanted += [(f"gyr_{axis}", _GYRO_NAMES, axis, _RATE) for axis in "xyz"]
    wanted += [(f"acc_{axis}", _ACCEL_NAMES, axis, _ACCEL) for axis in "xyz"]
    found = [_find(names, words, axis, units) for _, words, axis, units in wanted]
    missing = [label for (label, *_), column in zip(wanted, found, strict=True) if column is None]
    if missing:
        raise ValueError(
            f"{path}: no column for {', '.join(missing)}; found {', '.join(names)}. Needed are "
            "time (t_s), gyr_x, gyr_y, gyr_z in rad/s, acc_x, acc_y, acc_z in m/s² (names may end "
            "in _ms, _dps, _g); for a file without time give the rate"
        )
    return [column for column in found if column is not None]


def _find(
    names: list[str], words: str, axis: str, units: dict[str, float]
) -> tuple[int, float] | None:
    """First column of that name, one that states its unit before one that does not."""
    pattern = re.compile(rf"(?P<word>{words})_?{axis}(?:_(?P<unit>\w+))?")
    matches = []
    for index, name in enumerate(names):
        match = pattern.fullmatch(re.sub(r"\W+", "_", name.lower().replace("²", "2")).strip("_"))
        if match and (match["unit"] or "") in units:
            stated = bool(match["unit"]) or match["word"].startswith("seconds")
            matches.append((not stated, index, units[match["unit"] or ""]))
    return min(matches)[1:] if matches else None


def _numbers(
    lines: list[tuple[int, str]],
    names: list[str],
    columns: list[tuple[int, float]],
    delimiter: str | None,
    path: str | PathLike[str],
) -> FloatArray:
    """The wanted columns in SI units, (n, 6 or 7); an empty or missing cell is NaN."""
    numbers = np.full((len(lines), len(columns)), np.nan)
    for k, (row, text) in enumerate(lines):
        cells = _cells(text, delimiter)
        if len(cells) > len(names):
            raise ValueError(f"{path}: row {row} has {len(cells)} cells, the header {len(names)}")
        for j, (index, unit) in enumerate(columns):
            cell = cells[index] if index < len(cells) else ""
            if delimiter == ";":
                cell = cell.replace(",", ".")  # spreadsheets set to a decimal comma
            try:
                numbers[k, j] = unit * float(cell) if cell else np.nan
            except ValueError:
                raise ValueError(
                    f"{path}: row {row}, column {names[index]}: {cell!r} is not a number"
                ) from None
    return numbers


def _checked_time(
    time: FloatArray, lines: list[tuple[int, str]], path: str | PathLike[str]
) -> FloatArray:
    """Time that can be integrated over, refused otherwise."""
    rows = [row for row, _ in lines[1:]]
    if not np.isfinite(time).all():
        raise ValueError(f"{path}: row {rows[np.argmin(np.isfinite(time))]} has no time")
    steps = np.diff(time)
    if (steps < 0.0).any():
        k = int(np.argmax(steps < 0.0)) + 1
        raise ValueError(
            f"{path}: time runs backwards in row {rows[k]} "
            f"({time[k - 1]:.6g} s, then {time[k]:.6g} s); "
            "sort the rows, or cut the log where the clock was set"
        )
    if len(steps) and np.median(steps) > 0.5:
        raise ValueError(
            f"{path}: rows are {np.median(steps):.6g} s apart; if the time is not in seconds, let "
            "its name end in _ms, _us or _ns"
        )
    return time
