"""How much faster than real time is the simulator, and how long does the first one take?

    python benchmarks/simulator.py

One process, one core: read, apply and step(0.01) for a minute of the robot's time, all sensors
on, five times; the median counts, in CPU time, so that a busy neighbour matters less. The runs
have to end at the same place to the bit. The first simulator is built in processes of their own,
with an empty cache of compiled kernels and then with a full one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from statistics import median
from time import process_time

import numpy as np

from robocon_course.robot import Command
from robocon_course.simulator import Simulator

MINUTE = 6000  # cycles of 10 ms
REPEATS = 5
START = (3.0, 1.6, 0.0)
FIRST = """
import time
start = time.perf_counter()
from robocon_course.robot import Command
from robocon_course.simulator import Simulator
imported = time.perf_counter()
robot = Simulator()
robot.apply(Command.stop())
robot.step(0.01)
robot.read()
print(imported - start, time.perf_counter() - imported)
"""


def commands() -> list[Command]:
    """A new direction and speed every second, within the open part of Area 1 on average."""
    rng = np.random.default_rng(0)
    return [
        Command(
            rng.uniform(-1.0, 1.0) + rng.uniform(-0.2, 0.2, 4), rng.uniform(-3.0, 3.0) * np.ones(4)
        )
        for _ in range(MINUTE // 100)
    ]


def minute(robot: Simulator, orders: list[Command]) -> None:
    """One minute of the robot's time, as an autonomy would spend it."""
    robot.reset(1, START)
    for k in range(MINUTE):
        robot.read()
        robot.apply(orders[k // 100])
        robot.step(0.01)


def timed(action: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median CPU time of an action [s]."""
    times = []
    for _ in range(repeats):
        start = process_time()
        action()
        times.append(process_time() - start)
    return median(times)


def first_simulator(cache: str) -> tuple[float, float]:
    """Seconds for importing, and from there to the first reading, in a fresh process."""
    env = {**os.environ, "NUMBA_CACHE_DIR": cache}
    done = subprocess.run([sys.executable, "-c", FIRST], env=env, capture_output=True, check=True)
    return tuple(float(word) for word in done.stdout.split())


def parts(robot: Simulator, order: Command) -> dict[str, float]:
    """CPU time of each call [s]."""
    robot.reset(1, START)
    calls = {
        "apply": lambda: robot.apply(order),
        "step(0.01)": lambda: robot.step(0.01),
        "read": robot.read,
        "truth": lambda: robot.truth,
    }
    return {
        name: timed(lambda call=call: [call() for _ in range(2000)]) / 2000
        for name, call in calls.items()
    }


def main() -> None:
    """Print the factor, its parts, and the first simulator's time."""
    robot, orders = Simulator(), commands()
    minute(robot, orders)
    ends = [robot.truth.pose]

    def run() -> None:
        minute(robot, orders)
        ends.append(robot.truth.pose)

    seconds = timed(run)
    assert all(np.array_equal(end, ends[0]) for end in ends), "runs of one seed differ"
    print(f"a minute of read, apply, step(0.01), median of {REPEATS}; ends equal to the bit\n")
    for name, each in parts(robot, orders[0]).items():
        print(f"  {name:12s} {each * 1e6:8.1f} us")
    print(f"  {'cycle':12s} {seconds / MINUTE * 1e6:8.1f} us")
    print(f"\n  times faster than real time {60.0 / seconds:8.0f}      wanted >= 150")
    with tempfile.TemporaryDirectory() as cache:
        for cached in ("empty", "full"):
            importing, first = first_simulator(cache)
            print(
                f"  first reading, {cached:5s} cache {first:8.1f} s + {importing:.1f} s of import"
            )


if __name__ == "__main__":
    main()
