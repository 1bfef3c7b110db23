"""How fast is the Mahony filter beside its peers?

    python benchmarks/imu.py

One process; contenders take turns; the median of the repeats counts, in CPU time, so that a
busy neighbour matters less. Before any time is taken the results are compared.
"""

from __future__ import annotations

from collections.abc import Callable

import ahrs
import imufusion
import numpy as np
from turns import medians

from robocon_course import imu
from robocon_course.simulator import sensors

DT = 0.0025  # s
SAMPLES = 50_000  # two minutes
REPEATS = 7
GAINS = imu.MahonyGains(k_p=1.0, k_i=0.3)


def simulated_drive() -> tuple[np.ndarray, np.ndarray]:
    """Gyroscope and accelerometer, (n, 3) each, of a noisy, uncalibrated sensor."""
    motion = sensors.drive(SAMPLES * DT, DT, np.random.default_rng(1))
    return sensors.imu_measurements(*motion, DT, sensors.UNCALIBRATED, np.random.default_rng(2))


def assert_equal_results(gyro: np.ndarray, accel: np.ndarray) -> None:
    """The peer, the batch, the stream and the single steps tell the same attitudes."""
    peer = ahrs.filters.Mahony(gyro, accel, Dt=DT, k_P=GAINS.k_p, k_I=GAINS.k_i).Q
    ours = imu.estimate_attitude(gyro, accel, DT, gains=GAINS).quaternions
    np.testing.assert_allclose(ours, peer, rtol=0.0, atol=1e-9)
    stream = imu.AttitudeFilter(GAINS)
    for g, a in zip(gyro, accel, strict=True):
        last = stream.update(g, a, DT)
    np.testing.assert_array_equal(last, ours[-1])


def contenders(gyro: np.ndarray, accel: np.ndarray) -> dict[str, Callable[[], object]]:
    """Every one goes once through the log; the streams get the same rows in the same loop."""
    rows = list(zip(gyro, accel, strict=True))
    peer_rows = list(zip(np.degrees(gyro), accel / imu.GRAVITY, strict=True))  # its units

    def peer_update() -> None:
        filter_ = imufusion.Ahrs()
        filter_.set_sample_period(DT)
        for g, a in peer_rows:
            filter_.update_no_magnetometer(g, a)

    def peer_update_and_read() -> None:
        filter_ = imufusion.Ahrs()
        filter_.set_sample_period(DT)
        for g, a in peer_rows:
            filter_.update_no_magnetometer(g, a)
            filter_.get_quaternion()

    def kernel() -> None:
        state = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
        for g, a in rows:
            imu.mahony_update(state, g, a, DT, 1.0, 0.3, np.inf)

    def stream() -> None:
        filter_ = imu.AttitudeFilter(GAINS)
        for g, a in rows:
            filter_.update(g, a, DT)

    def steps() -> None:
        state = imu.MahonyState.level()
        for g, a in rows:
            state = imu.mahony_step(state, g, a, DT, GAINS)

    return {
        "ahrs.filters.Mahony, batch": lambda: ahrs.filters.Mahony(
            gyro, accel, Dt=DT, k_P=GAINS.k_p, k_I=GAINS.k_i
        ),
        "imu.estimate_attitude, batch": lambda: imu.estimate_attitude(gyro, accel, DT, gains=GAINS),
        "imufusion update": peer_update,
        "imufusion update, get_quaternion": peer_update_and_read,
        "imu.mahony_update": kernel,
        "imu.AttitudeFilter.update": stream,
        "imu.mahony_step": steps,
    }


def main() -> None:
    """Print a time per sample for each contender, then the three ratios that matter."""
    gyro, accel = simulated_drive()
    assert_equal_results(gyro, accel)
    times = {name: t / SAMPLES for name, t in medians(contenders(gyro, accel), REPEATS).items()}
    print(f"Mahony filter, {SAMPLES} samples, median of {REPEATS} repeats, results equal to 1e-9\n")
    for name, seconds in times.items():
        print(f"  {name:34s} {seconds * 1e9:10.0f} ns a sample")
    batch = times["ahrs.filters.Mahony, batch"] / times["imu.estimate_attitude, batch"]
    stream = times["imu.mahony_update"] / times["imufusion update"]
    step = times["imu.mahony_step"] * 1e6
    print(f"\n  batch, times faster than ahrs      {batch:10.0f}       wanted >= 1000")
    print(f"  stream, share of imufusion's time  {stream:10.2f}       wanted <= 1.5")
    print(f"  one checked step                   {step:10.1f} us    wanted <= 10")


if __name__ == "__main__":
    main()
