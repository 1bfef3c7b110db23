"""How fast are pursuit and PID beside a plain search and two PID libraries?

    python benchmarks/tracking.py

One process; contenders take turns; the median of the repeats counts, in CPU time, so that a
busy neighbour matters less. Before any time is taken the results are compared.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf, sin

import numpy as np
from simple_pid import PID
from turns import medians
from wpimath.controller import PIDController

from robocon_course.geometry import distance_along
from robocon_course.tracking import (
    ACCEL,
    ARRIVED,
    CREEP,
    REACH,
    Cart,
    IncrementalPid,
    Pid,
    PidGains,
    TrackingSettings,
    nearest_point,
    path_curvature,
    pure_pursuit,
    speed_profile,
    start_pose,
    trial,
)
from robocon_course.tracking.polyline import look, nearest
from robocon_course.tracking.pursuit import pursue
from robocon_course.worlds import SOURCE_PATHS, finely

REPEATS = 15
LOOKAHEAD = 0.5
_S = np.linspace(0.0, 50.0, 1000)
PATH = np.column_stack([_S, np.sin(_S / 3.0)])
POSES = [(x, sin(x / 3.0) + 0.05, 0.1) for x in np.linspace(0.0, 45.0, 450).tolist()]
GAINS, DT = PidGains(1.0, 0.1, 0.05), 0.01
ZIGZAG = finely(SOURCE_PATHS["zigzag"])
MEASURED = np.sin(0.01 * np.arange(1000)).tolist()


def waypoint_search(xs: list[float], ys: list[float], x: float, y: float, start: int) -> list[int]:
    """Nearest waypoint from ``start`` on, and the first one after it beyond the look-ahead."""
    index, here = start, hypot(xs[start] - x, ys[start] - y)
    while index + 1 < len(xs):
        following = hypot(xs[index + 1] - x, ys[index + 1] - y)
        if here < following:
            break
        index, here = index + 1, following
    target = index
    while target + 1 < len(xs) and hypot(xs[target] - x, ys[target] - y) < LOOKAHEAD:
        target += 1
    return [index, target]


def plain_profile(max_speed: float, max_accel: float, max_lateral: float) -> list[float]:
    """The two passes of `speed_profile`, point by point."""
    gaps = np.diff(distance_along(PATH)).tolist()
    bends = np.abs(path_curvature(PATH)).tolist()
    square = [min(max_speed**2, max_lateral / bend if bend else inf) for bend in bends]
    square[0] = square[-1] = 0.0
    for k, gap in enumerate(gaps):
        square[k + 1] = min(square[k + 1], square[k] + 2.0 * max_accel * gap)
    for k in range(len(gaps) - 1, -1, -1):
        square[k] = min(square[k], square[k + 1] + 2.0 * max_accel * gaps[k])
    return [value**0.5 for value in square]


def by_doors(path: np.ndarray) -> int:
    """The loop of `trial`, written with the public functions: how many steps it took."""
    settings, cart, index = TrackingSettings(), Cart(pose=start_pose(path)), 0
    squares = speed_profile(path, settings.speed, ACCEL, settings.lateral) ** 2
    for step in range(5000):
        here = nearest_point(path, cart.pose[:2], index, REACH)
        square = np.interp(here.index + here.share, np.arange(len(path)), squares)
        speed = max(square**0.5, CREEP)
        far = settings.k * speed + settings.least
        found = pure_pursuit(path, cart.pose, far, here.index, tolerance=ARRIVED)
        if found.done:
            return step
        index = found.index
        cart.drive(speed, speed * found.curvature)
    raise AssertionError("the end was never reached")


def assert_equal_results() -> None:
    """The same targets, speeds and outputs from all, where they mean the same."""
    xs, ys = PATH.T.tolist()
    index = waypoint = 0
    for x, y, theta in POSES:
        (index, *_), (segment, share, *xy), _ = look(PATH, x, y, index, LOOKAHEAD)
        waypoint, target = waypoint_search(xs, ys, x, y, waypoint)
        # Ours lies on the segment that ends at the waypoint of the search.
        assert segment + 1 == target or share == 0.0
        assert pursue(PATH, (x, y, theta), LOOKAHEAD, index).target == tuple(xy)
        whole = np.hypot(*(PATH - (x, y)).T).argmin()
        assert nearest(PATH, x, y, 0, inf)[0] in (whole - 1, whole)
    assert abs(trial(ZIGZAG).duration - DT * by_doors(ZIGZAG)) < 1e-9
    np.testing.assert_allclose(speed_profile(PATH, 1.0, 1.0, 0.1), plain_profile(1.0, 1.0, 0.1))
    ours, theirs, third = Pid(GAINS), PIDController(*GAINS[:3], DT), simple()
    theirs.setIntegratorRange(-1e9, 1e9)
    for k, measured in enumerate(MEASURED):
        output = ours.update(1.0, measured, DT)
        wpilib = theirs.calculate(measured, 1.0)
        assert k == 0 or abs(wpilib - output) < 1e-9  # its first sample kicks
        assert abs(third(measured, dt=DT) - output) < 1e-9


def simple() -> PID:
    """simple_pid at every call, the derivative of the measurement, as ours."""
    return PID(*GAINS[:3], setpoint=1.0, sample_time=None)


def walk(step: Callable[[tuple[float, float, float], int], int]) -> Callable[[], int]:
    """A loop over all poses in which each call starts where the last one ended."""

    def loop() -> int:
        index = 0
        for pose in POSES:
            index = step(pose, index)
        return len(POSES)

    return loop


def each(call: Callable[[float], object]) -> Callable[[], int]:
    """A loop that calls for every measurement."""
    return lambda: len([call(measured) for measured in MEASURED])


def contenders() -> dict[str, Callable[[], int]]:
    """Pursuit over 450 poses of a path of 1000 points, PID over 1000 samples, one profile."""
    xs, ys = PATH.T.tolist()
    one, steps = Pid(GAINS), IncrementalPid(GAINS)
    theirs, third = PIDController(*GAINS[:3], DT), simple()

    def drive() -> int:
        return len(trial(ZIGZAG).time)

    def drive_by_doors() -> int:
        return by_doors(ZIGZAG)

    def once(call: Callable[..., object]) -> Callable[[], int]:
        return lambda: len([call(1.0, 1.0, 0.1)])

    def shortest(x: float, y: float) -> int:
        return int(np.hypot(*(PATH - (x, y)).T).argmin())

    return {
        "waypoint search, plain Python": walk(lambda p, k: waypoint_search(xs, ys, *p[:2], k)[0]),
        "look (kernel)": walk(lambda p, k: look(PATH, p[0], p[1], k, LOOKAHEAD)[0][0]),
        "pursue (no checks)": walk(lambda p, k: pursue(PATH, p, LOOKAHEAD, k).index),
        "pure_pursuit (checked)": walk(lambda p, k: pure_pursuit(PATH, p, LOOKAHEAD, k).index),
        "a step of the cart's loop, by doors": drive_by_doors,
        "a step of trial": drive,
        "nearest waypoint, whole path, numpy": walk(lambda p, _: shortest(*p[:2])),
        "nearest point, whole path (kernel)": walk(lambda p, _: nearest(PATH, *p[:2], 0, inf)[0]),
        "speed profile, plain Python": once(plain_profile),
        "speed_profile": once(lambda *limits: speed_profile(PATH, *limits)),
        "wpimath PIDController.calculate": each(lambda m: theirs.calculate(m, 1.0)),
        "simple_pid PID, dt given": each(lambda m: third(m, dt=DT)),
        "Pid.update": each(lambda m: one.update(1.0, m, DT)),
        "IncrementalPid.update": each(lambda m: steps.update(1.0, m, DT)),
    }


def main() -> None:
    """Print a time per call for each contender, then the ratios that matter."""
    assert_equal_results()
    times = medians(contenders(), REPEATS)
    print(f"Path tracking, median of {REPEATS} repeats, equal results checked\n")
    for name, seconds in times.items():
        print(f"  {name:38s} {seconds * 1e9:9.0f} ns a call")
    print()
    for ours, peer, wanted in (
        ("look (kernel)", "waypoint search, plain Python", 0.35),
        ("pursue (no checks)", "waypoint search, plain Python", 1.0),
        ("nearest point, whole path (kernel)", "nearest waypoint, whole path, numpy", 0.5),
        ("speed_profile", "speed profile, plain Python", 1.0),
        ("a step of trial", "a step of the cart's loop, by doors", 0.05),
        ("Pid.update", "wpimath PIDController.calculate", 1.6),
        ("Pid.update", "simple_pid PID, dt given", 0.5),
    ):
        ratio = times[ours] / times[peer]
        print(f"  {ours} / {peer}: {ratio:.2f}   wanted <= {wanted}")


if __name__ == "__main__":
    main()
