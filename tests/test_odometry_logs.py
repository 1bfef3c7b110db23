"""Chapter 02 on recordings of real robots: the published formulas, and sizes that carry over."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from itertools import permutations
from math import pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest

from robocon_course.geometry import wrap_angle
from robocon_course.odometry import (
    SizePrior,
    TrackingWheels,
    body_deltas,
    integrate,
    self_calibrate,
    wheel_travel,
)

SQUARES = ("omni3_square_221220201934",) * 3
OMNI = [("omni3_joystick_211220201842", 1), *zip(SQUARES, (1, 2, 3), strict=True)]
TWO_WHEELS = ("diff_free_030120210001", 1)
# More than the nominal sizes may be off: a stand-in for no prior at all.
HARDLY_A_PRIOR = SizePrior(radius=1.0, lever=2.0)


@dataclass(frozen=True)
class Recording:
    """A drive of a real robot, and its drawing."""

    ticks: np.ndarray
    truth: np.ndarray
    sizes: dict[str, list[float]]

    @property
    def wheels(self) -> TrackingWheels:
        """Nominal sizes, placed so that the wheel matrix is the README's formula turned round."""
        (distance,), diameters = self.sizes["Li"], np.array(self.sizes["Di"])
        ticks_per_turn = self.sizes["ngear"][0] * self.sizes["encRes"][0]
        if len(diameters) == 2:  # right, left
            positions, directions = [[0.0, -distance / 2.0], [0.0, distance / 2.0]], [0.0, 0.0]
        else:
            # At -60, 60 and 180 degrees, each rolling to the right as seen from the centre.
            places = np.radians([-60.0, 60.0, 180.0])
            positions = distance * np.column_stack([np.cos(places), np.sin(places)])
            directions = places - pi / 2
        return TrackingWheels(positions, directions, diameters / 2.0, ticks_per_turn)

    @property
    def path(self) -> float:
        """Length of the true way [m]."""
        return float(np.hypot(*np.diff(self.truth[:, :2], axis=0).T).sum())

    def poses(self, wheels: TrackingWheels) -> np.ndarray:
        return integrate(body_deltas(wheels, wheel_travel(wheels, self.ticks)), self.truth[0])

    def end_error(self, wheels: TrackingWheels) -> float:
        """How far the last pose is from the true one [m]."""
        return float(np.hypot(*(self.poses(wheels)[-1] - self.truth[-1])[:2]))


@pytest.fixture(scope="module")
def runs(recordings) -> dict[tuple[str, int], Recording]:
    found = {}
    for name, number in [*OMNI, TWO_WHEELS]:
        folder = recordings / "wheel_odometry" / name
        rows = np.loadtxt(one(folder, f"*_run-{number:02d}.csv"), delimiter=",")
        with one(folder, "*_metadata.csv").open() as file:
            table = {key: [float(v) for v in values if v] for key, *values in numbers(file)}
        # The first row's ticks led to its pose, from which the drive begins.
        found[name, number] = Recording(rows[1:, 4:], rows[:, 1:4], table)
    return found


def one(folder: Path, pattern: str) -> Path:
    (path,) = folder.glob(pattern)
    return path


def numbers(file):
    return [row for row in csv.reader(file) if row[0] in ("ngear", "encRes", "Li", "Di")]


@pytest.fixture(scope="module")
def omni(runs) -> list[Recording]:
    return [runs[key] for key in OMNI]


def plain_formulas(run: Recording) -> np.ndarray:
    """The README's formulas, and a sum of arcs, written out once more."""
    (distance,), (gear,), (encoder,) = (run.sizes[key] for key in ("Li", "ngear", "encRes"))
    x, y, theta = run.truth[0]
    rows = [(x, y, theta)]
    for ticks in run.ticks:
        d = pi * np.array(run.sizes["Di"]) * ticks / (gear * encoder)
        if len(d) == 2:
            right, left_wheel = d
            forward, left, turn = (right + left_wheel) / 2, 0.0, (right - left_wheel) / distance
        else:
            forward, left = (d[1] - d[0]) / sqrt(3), (2 * d[2] - d[0] - d[1]) / 3
            turn = -d.sum() / (3 * distance)
        if turn:
            along, across = np.sin(turn) / turn, (1 - np.cos(turn)) / turn
        else:
            along, across = 1.0, 0.0
        forward, left = along * forward - across * left, across * forward + along * left
        x += np.cos(theta) * forward - np.sin(theta) * left
        y += np.sin(theta) * forward + np.cos(theta) * left
        theta += turn
        rows.append((x, y, theta))
    return np.array(rows)


def mean_end_error(wheels: TrackingWheels, runs: list[Recording]) -> float:
    return float(np.mean([run.end_error(wheels) for run in runs]))


def others(omni: list[Recording], trained: int) -> list[Recording]:
    return omni[:trained] + omni[trained + 1 :]


@pytest.mark.parametrize("key", [*OMNI, TWO_WHEELS], ids=lambda key: f"{key[0][:8]}-{key[1]}")
def test_the_wheel_matrix_gives_what_the_plain_formulas_give(runs, key):
    run = runs[key]
    # Two thousand steps of 1 cm, each good to 1e-17 m; (1 - cos)/turn costs the formulas more:
    # 1e-16 / 0.001 of a step.
    np.testing.assert_allclose(run.poses(run.wheels), plain_formulas(run), atol=1e-9)


@pytest.mark.parametrize("number, published", [(1, 0.0421), (2, 0.0388), (3, 0.0349)])
def test_nominal_sizes_on_the_square(runs, number, published):
    run = runs[SQUARES[0], number]
    share = run.end_error(run.wheels) / run.path
    assert share <= 0.045
    assert share == pytest.approx(published, abs=1e-4)


def test_nominal_sizes_by_joystick(runs):
    run = runs[OMNI[0]]
    assert run.end_error(run.wheels) / run.path <= 0.012


def test_two_wheels_as_a_third_that_never_rolls(runs):
    run = runs[TWO_WHEELS]
    assert run.path > 7.0
    assert run.end_error(run.wheels) / run.path <= 0.006


@pytest.mark.parametrize("trained", range(4), ids=["joystick", "square 1", "square 2", "square 3"])
def test_sizes_from_any_one_drive_at_least_halve_the_error_of_the_others(omni, trained):
    nominal = omni[trained].wheels
    found = self_calibrate(nominal, omni[trained].ticks, omni[trained].truth)
    rest = others(omni, trained)
    assert mean_end_error(found, rest) <= 0.5 * mean_end_error(nominal, rest)
    assert np.mean([run.end_error(found) / run.path for run in rest]) <= 0.025


def test_the_headings_of_the_other_drives_get_better_as_well(omni):
    for trained, run in enumerate(omni):
        found = self_calibrate(run.wheels, run.ticks, run.truth)
        for other in others(omni, trained):
            before, after = (
                abs(wrap_angle(other.poses(wheels)[-1, 2] - other.truth[-1, 2]))
                for wheels in (run.wheels, found)
            )
            assert after <= 0.6 * before


def test_the_prior_need_not_be_tuned(omni):
    # Each tolerance at half and at twice its value, from every drive: twelve combinations would do
    # worse than half the nominal error if the figure hung on one of them.
    for name, value in SizePrior()._asdict().items():
        for factor in (0.5, 2.0):
            prior = SizePrior()._replace(**{name: factor * value})
            for trained, run in enumerate(omni):
                found = self_calibrate(run.wheels, run.ticks, run.truth, prior=prior)
                rest = others(omni, trained)
                assert mean_end_error(found, rest) <= 0.5 * mean_end_error(run.wheels, rest)


def test_a_part_of_the_square_already_carries_over(omni):
    for trained in (1, 2, 3):
        run, half = omni[trained], len(omni[trained].ticks) // 2
        for part in (slice(0, half), slice(half, 2 * half)):
            truth = run.truth[part.start : part.stop + 1]
            found = self_calibrate(run.wheels, run.ticks[part], truth)
            rest = others(omni, trained)
            assert mean_end_error(found, rest) <= 0.5 * mean_end_error(run.wheels, rest)


def test_without_the_prior_the_sizes_fit_one_drive_and_fail_on_the_next(omni):
    square, joystick = omni[1], omni[0]
    plain = self_calibrate(square.wheels, square.ticks, square.truth, prior=HARDLY_A_PRIOR)
    weak = self_calibrate(square.wheels, square.ticks, square.truth)

    def mismatch(wheels):
        return float(np.hypot(*(square.poses(wheels) - square.truth)[:, :2].T).mean())

    assert mismatch(plain) < mismatch(weak) < mismatch(square.wheels)
    # On another drive plain least squares is worse than the drawing, several times.
    assert joystick.end_error(plain) > 3.0 * joystick.end_error(joystick.wheels)
    assert joystick.end_error(weak) < joystick.end_error(joystick.wheels)
    # A square shows the sum of the lever arms (how much it turned) and hardly each of them.
    assert np.abs(plain.matrix[:, 2] / square.wheels.matrix[:, 2] - 1.0).max() > 0.1
    assert np.abs(weak.matrix[:, 2] / square.wheels.matrix[:, 2] - 1.0).max() < 0.02


def test_poses_known_now_and_then_are_enough(omni):
    run = omni[2]
    truth = np.full_like(run.truth, np.nan)
    truth[:: len(truth) // 6] = run.truth[:: len(truth) // 6]
    found = self_calibrate(run.wheels, run.ticks, truth)
    rest = others(omni, 2)
    assert mean_end_error(found, rest) <= 0.5 * mean_end_error(run.wheels, rest)


@pytest.mark.parametrize("swap", [p for p in permutations(range(3)) if p != (0, 1, 2)])
def test_wheels_in_another_order_go_another_way(omni, swap):
    # A closed way forgives it at its end, where swapped wheels meet the start again.
    run = omni[1]
    swapped = Recording(run.ticks[:, swap], run.truth, run.sizes)
    right, wrong = (
        np.hypot(*(which.poses(run.wheels) - run.truth)[:, :2].T).max() for which in (run, swapped)
    )
    assert right < 0.3 and wrong > 1.0


def test_headings_may_be_wrapped(omni):
    run = omni[1]
    wrapped = run.truth.copy()
    wrapped[:, 2] = wrap_angle(wrapped[:, 2])
    found = self_calibrate(run.wheels, run.ticks, run.truth)
    again = self_calibrate(run.wheels, run.ticks, wrapped)
    np.testing.assert_allclose(again.radius, found.radius, rtol=1e-9)
    assert radians(340.0) < abs(run.truth[-1, 2])
