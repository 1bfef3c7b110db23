"""Make the IMU recordings of this folder again, the same to the byte: python data/imu/make.py

The sensor is `UNCALIBRATED` of robocon_course.simulator.sensors, one and the same in every file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robocon_course import geometry
from robocon_course.simulator import sensors

FOLDER = Path(__file__).resolve().parent
DT = 0.01  # s
SENSOR = sensors.UNCALIBRATED
READING = ["gyr_x", "gyr_y", "gyr_z", "acc_x", "acc_y", "acc_z"]
READING_FORMAT = ["%.6f"] * 3 + ["%.5f"] * 3
TABLE = geometry.quaternion_from_euler(0.02, -0.03, 0.0)  # no table is quite level


def recorded(motion: sensors.Motion, seed: int) -> np.ndarray:
    """Time, gyroscope and accelerometer, (n, 7)."""
    gyro, accel = sensors.imu_measurements(*motion, DT, SENSOR, np.random.default_rng(seed))
    return np.column_stack([DT * np.arange(len(gyro)), gyro, accel])


def write(folder: Path, name: str, rows: np.ndarray, more: dict[str, str] | None = None) -> None:
    """One CSV file; ``more`` names further columns and their formats."""
    more = more or {}
    formats = ["%.2f", *READING_FORMAT, *more.values()]
    header = ",".join(["t_s", *READING, *more])
    # Adding 0.0 after rounding: whether a zero has a sign differs between processors.
    np.savetxt(folder / name, np.round(rows, 6) + 0.0, formats, ",", header=header, comments="")


def bumped_table(duration: float) -> sensors.Motion:
    """At rest, but at 12 s somebody leans on the table: 2 degrees over, and back within 0.8 s."""
    quaternions, accelerations = sensors.still(duration, DT, TABLE)
    u = np.clip((DT * np.arange(len(quaternions)) - 12.0) / 0.8, 0.0, 1.0)
    lean = np.radians(2.0) * np.sin(np.pi * u) ** 2
    bump = geometry.quaternion_from_euler(lean, 0.0, 0.0)
    return geometry.quaternion_multiply(bump, quaternions), accelerations


def six_rests(rng: np.random.Generator) -> np.ndarray:
    """Two seconds on each side, laid down by hand (up to 2 degrees off); last column: which side.

    Sides: 1, 2 = x up, x down; 3, 4 = y; 5, 6 = z. Five seconds between them are cut out.
    """
    half = np.pi / 2
    sides = [(0, -half), (0, half), (half, 0), (-half, 0), (0, 0), (2 * half, 0)]  # roll, pitch
    sections = []
    for k, (roll, pitch) in enumerate(sides):
        slip = np.append(np.radians(rng.uniform(-2.0, 2.0, 2)), 0.0)
        tilt = geometry.quaternion_multiply(
            geometry.quaternion_from_rotation_vector(slip),
            geometry.quaternion_from_euler(roll, pitch, 0.0),
        )
        section = recorded(sensors.still(2.0, DT, tilt), seed=30 + k)
        section[:, 0] += 7.0 * k
        sections.append(np.column_stack([section, np.full(len(section), k + 1.0)]))
    return np.concatenate(sections)


def main(folder: Path = FOLDER) -> None:
    """Write all recordings into ``folder``."""
    write(folder, "still.csv", recorded(sensors.still(20.0, DT, TABLE), seed=1))
    write(folder, "moved.csv", recorded(bumped_table(20.0), seed=2))
    write(folder, "rests.csv", six_rests(np.random.default_rng(3)), {"side": "%.0f"})
    write(folder, "turns.csv", recorded(sensors.slow_turns(DT, lean=0.15), seed=4))
    motion = sensors.drive(60.0, DT, np.random.default_rng(5))
    truth = dict.fromkeys(["q_w", "q_x", "q_y", "q_z"], "%.6f")
    write(folder, "drive.csv", np.column_stack([recorded(motion, seed=6), motion[0]]), truth)


if __name__ == "__main__":
    main()
