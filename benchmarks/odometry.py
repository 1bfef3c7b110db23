"""How fast is dead reckoning beside a peer's pose exponential?

    python benchmarks/odometry.py

One process; contenders take turns; the median of the repeats counts, in CPU time, so that a
busy neighbour matters less. Before any time is taken the poses are compared. The peer has no
odometry for three dead wheels: its rows get the motion of the base ready made, as `integrate`
does, or multiply by the matrix in plain Python, as its users write it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from turns import medians
from wpimath.geometry import Pose2d, Twist2d

from robocon_course import odometry
from robocon_course.geometry import wrap_angle
from robocon_course.robot import DEAD_WHEELS

SAMPLES = 100_000  # about a quarter of an hour at 100 Hz
REPEATS = 7


def drive() -> np.ndarray:
    """Counts of the three wheels, (n, 3): up to 1.5 m/s and 2 rad/s, changing slowly."""
    time = np.arange(SAMPLES) * 0.01
    deltas = 0.01 * np.column_stack(
        [1.2 * np.sin(0.31 * time), 0.9 * np.sin(0.17 * time + 1.0), 2.0 * np.sin(0.11 * time)]
    )
    turned = np.cumsum(deltas @ DEAD_WHEELS.matrix.T / DEAD_WHEELS.metres_per_tick, axis=0)
    return np.diff(np.floor(turned), axis=0, prepend=0.0).astype(np.int64)


def contenders(ticks: np.ndarray) -> dict[str, Callable[[], np.ndarray]]:
    """Every one goes once through the drive and returns the last pose."""
    travel = odometry.wheel_travel(DEAD_WHEELS, ticks)
    deltas = odometry.body_deltas(DEAD_WHEELS, travel)
    twists = [Twist2d(*row) for row in deltas.tolist()]
    rows, plain = list(ticks), travel.tolist()
    (a, b, c), (d, e, f), (g, h, i) = DEAD_WHEELS.solver.tolist()
    per_tick, no_turn = DEAD_WHEELS.solver * DEAD_WHEELS.metres_per_tick, np.zeros(3)
    floats = list(ticks.astype(float))

    def peer_exponentials() -> np.ndarray:
        pose = Pose2d()
        for twist in twists:
            pose = pose.exp(twist)
        return as_row(pose)

    def peer_with_matrix() -> np.ndarray:
        pose = Pose2d()
        for left, right, rear in plain:
            forward = a * left + b * right + c * rear
            aside = d * left + e * right + f * rear
            pose = pose.exp(Twist2d(forward, aside, g * left + h * right + i * rear))
        return as_row(pose)

    def batch() -> np.ndarray:
        return odometry.integrate(odometry.body_deltas(DEAD_WHEELS, travel))[-1]

    def arcs() -> np.ndarray:
        return odometry.integrate(deltas)[-1]

    def kernel() -> np.ndarray:
        pose = np.zeros(3)
        for row in floats:
            odometry.odometry_update(pose, row, per_tick, no_turn, 0.0)
        return pose

    def stream() -> np.ndarray:
        robot = odometry.Odometry(DEAD_WHEELS)
        for row in rows:
            robot.update(row)
        return robot.pose

    return {
        "wpimath Pose2d.exp, motions ready": peer_exponentials,
        "integrate, motions ready": arcs,
        "matrix in Python, wpimath Pose2d.exp": peer_with_matrix,
        "body_deltas and integrate": batch,
        "odometry_update": kernel,
        "Odometry.update": stream,
    }


def as_row(pose: Pose2d) -> np.ndarray:
    return np.array([pose.x, pose.y, pose.rotation().radians()])


def assert_equal_results(every: dict[str, Callable[[], np.ndarray]]) -> None:
    """All end in the same pose: 100 000 steps of 1 cm, each good to 1e-16, on both sides."""
    first, *others = (contender() for contender in every.values())
    for other in others:
        difference = other - first
        difference[2] = wrap_angle(difference[2])
        np.testing.assert_allclose(difference, 0.0, atol=1e-9)


def main() -> None:
    """Print a time per sample for each contender, then the ratios that matter."""
    every = contenders(drive())
    assert_equal_results(every)
    times = {name: seconds / SAMPLES for name, seconds in medians(every, REPEATS).items()}
    print(f"Odometry, {SAMPLES} samples, median of {REPEATS} repeats, poses equal to 1e-9\n")
    for name, seconds in times.items():
        print(f"  {name:38s} {seconds * 1e9:8.0f} ns a sample")
    poses = times["wpimath Pose2d.exp, motions ready"] / times["integrate, motions ready"]
    peer = times["matrix in Python, wpimath Pose2d.exp"]
    print(f"\n  from motions to poses, times faster    {poses:8.0f}       wanted >= 20")
    batch = peer / times["body_deltas and integrate"]
    print(f"  from travel to poses, times faster     {batch:8.0f}       wanted >= 20")
    print(f"  kernel, share of the peer's time       {times['odometry_update'] / peer:8.2f}")
    print(f"  stream, share of the peer's time       {times['Odometry.update'] / peer:8.2f}")


if __name__ == "__main__":
    main()
