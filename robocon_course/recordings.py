"""From a recording to results: files in, files out, for people who have a log and a question."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robocon_course import imu
from robocon_course.view import plots


def attitude_of_file(
    file: Path,
    gains: imu.MahonyGains,
    *,
    still: float = 0.0,
    rate: float | None = None,
    out: Path | None = None,
) -> list[str]:
    """Roll, pitch and yaw of an IMU recording as CSV and picture.

    Parameters
    ----------
    file : Path
        CSV with time, gyro and accel columns, found by name (`imu.read_log`).
    gains : MahonyGains
    still : float  [s]
        Time at rest at the start; its mean is taken off as gyroscope bias. 0: nothing is.
    rate : float, optional  [Hz]
        Samples per second, for a file without time.
    out : Path, optional
        Folder for the results; default beside the file.

    Returns
    -------
    list of str
        What was found and where the results lie, one line each.
    """
    log = imu.read_log(file, rate=rate)
    lines = _remarks(log)
    gyro = log.gyro
    if still:
        rest = log.time - log.time[0] < still
        calibration = imu.calibrate_gyro(gyro[rest], dt=float(np.median(log.dt[1:])))
        gyro = calibration.apply(gyro)
        bias = np.degrees(calibration.bias).round(3)
        lines.append(f"Gyro bias from {still:g} s at rest: {bias} deg/s")
    result = imu.estimate_attitude(gyro, log.accel, log.dt, gains=gains)
    folder = out or file.parent
    folder.mkdir(parents=True, exist_ok=True)
    table, picture = (folder / f"{file.stem}_attitude.{end}" for end in ("csv", "png"))
    imu.write_angles(table, log, result)
    angles = imu.euler_angles(result.quaternions)
    picture.write_bytes(plots.png(plots.plot_angles(log.time, {"angles": angles})))
    roll, pitch, yaw = np.degrees(angles[-1])
    lines.append(
        f"{len(log.time)} samples, {result.rejected} not fully used; "
        f"at the end roll {roll:.1f}°, pitch {pitch:.1f}°, yaw {yaw:.1f}°"
    )
    return [*lines, f"Angles: {table}", f"Picture: {picture}"]


def _remarks(log: imu.ImuLog) -> list[str]:
    """What a reader should know about a log before believing its angles.

    Raises
    ------
    ValueError
        The accelerometer is not in m/s².
    """
    force = float(np.nanmedian(np.linalg.norm(log.accel, axis=1)))
    if not 4.0 < force < 25.0:
        raise ValueError(
            f"accel: its median length is {force:.4g}, and gravity is 9.81 m/s²; give m/s², or "
            "name the columns acc_x_g … for multiples of g. Raw counts need a calibration first"
        )
    gaps = log.dt[log.dt > max(0.2, 5.0 * float(np.median(log.dt)))]
    if not len(gaps):
        return []
    return [f"{len(gaps)} gaps, the longest {gaps.max():.2f} s: turns during a gap are not known"]
