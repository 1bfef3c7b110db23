"""How fast are the swerve kinematics beside those of wpimath?

    python benchmarks/swerve.py

One process; contenders take turns; the median of the repeats counts, in CPU time, so that a
busy neighbour matters less. Before any time is taken the results are compared.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from turns import medians
from wpimath.geometry import Rotation2d, Translation2d
from wpimath.kinematics import ChassisSpeeds, SwerveDrive4Kinematics, SwerveModuleState

from robocon_course import swerve
from robocon_course.robot import MODULES
from robocon_course.swerve.modules import fill_targets
from robocon_course.swerve.motion import fill_motion

ROWS = 20_000
REPEATS = 9
DRIVE = swerve.SwerveDrive(MODULES)
PEER = SwerveDrive4Kinematics(*[Translation2d(*place) for place in MODULES])
HELD = np.zeros(4)


def peer_inverse(vx: float, vy: float, omega: float) -> tuple[list[float], list[float]]:
    """Floats in, floats out, by the peer."""
    states = PEER.toSwerveModuleStates(ChassisSpeeds(vx, vy, omega))
    return [s.speed for s in states], [s.angle.radians() for s in states]


def peer_forward(speeds: list[float], angles: list[float]) -> tuple[float, float, float]:
    """Floats in, floats out, by the peer."""
    found = PEER.toChassisSpeeds(peer_states(speeds, angles))
    return found.vx, found.vy, found.omega


def peer_states(speeds: list[float], angles: list[float]) -> tuple[SwerveModuleState, ...]:
    """Readings in the peer's own objects."""
    pairs = zip(speeds, angles, strict=True)
    return tuple(SwerveModuleState(speed, Rotation2d(angle)) for speed, angle in pairs)


def assert_equal_results(
    twists: np.ndarray, targets: swerve.ModuleTargets, speeds: np.ndarray
) -> None:
    """The peer, the batch and the single calls tell the same modules and the same motion."""
    motion = swerve.body_motion(DRIVE, speeds, targets.angles)
    for k, twist in enumerate(twists):
        theirs = peer_inverse(*twist)
        single = swerve.module_targets(DRIVE, twist, HELD)
        np.testing.assert_array_equal(single, (targets.speeds[k], targets.angles[k]))
        np.testing.assert_allclose(theirs[0], single.speeds, rtol=0.0, atol=1e-9)
        off = np.exp(1j * np.array(theirs[1])) - np.exp(1j * single.angles)
        np.testing.assert_allclose(off, 0.0, atol=1e-9)
        back = peer_forward(speeds[k], targets.angles[k])
        np.testing.assert_allclose(back, motion.twist[k], rtol=0.0, atol=1e-9)


def each(call: Callable[..., object], rows: list[tuple]) -> Callable[[], None]:
    """A loop that calls for every row and drops the results."""

    def loop() -> None:
        for row in rows:
            call(*row)

    return loop


def contenders(
    twists: np.ndarray, targets: swerve.ModuleTargets, speeds: np.ndarray
) -> dict[str, Callable[[], object]]:
    """Every one goes once through the same rows.

    A batch returns all its results, so the loop beside it keeps all of its own; single calls
    drop theirs.
    """
    angles = targets.angles
    chassis = [ChassisSpeeds(*row) for row in twists.tolist()]
    states = [peer_states(*row) for row in zip(speeds.tolist(), angles.tolist(), strict=True)]
    places, solver, out = DRIVE.positions, DRIVE.solver, np.empty((2, 1, 4))
    twist, residual = np.empty((1, 3)), np.empty(1)
    inverse_rows = [(places, row[None], HELD[None], *out) for row in twists]
    pairs = list(zip(speeds, angles, strict=True))
    forward_rows = [(places, solver, s[None], a[None], twist, residual) for s, a in pairs]
    return {
        "wpimath inverse, loop": lambda: [PEER.toSwerveModuleStates(c) for c in chassis],
        "wpimath inverse, bare call": each(PEER.toSwerveModuleStates, [(c,) for c in chassis]),
        "wpimath inverse, floats to floats": each(peer_inverse, twists.tolist()),
        "swerve.module_targets, batch": lambda: swerve.module_targets(DRIVE, twists, HELD),
        "fill_targets, one row": each(fill_targets, inverse_rows),
        "swerve.module_targets, one row": each(
            swerve.module_targets, [(DRIVE, row, HELD) for row in twists]
        ),
        "wpimath forward, loop": lambda: [PEER.toChassisSpeeds(s) for s in states],
        "wpimath forward, bare call": each(PEER.toChassisSpeeds, [(s,) for s in states]),
        "wpimath forward, floats to floats": each(
            peer_forward, list(zip(speeds.tolist(), angles.tolist(), strict=True))
        ),
        "swerve.body_motion, batch": lambda: swerve.body_motion(DRIVE, speeds, angles),
        "fill_motion, one row": each(fill_motion, forward_rows),
        "swerve.body_motion, one row": each(swerve.body_motion, [(DRIVE, s, a) for s, a in pairs]),
    }


def main() -> None:
    """Print a time per row for each contender, then the six ratios that matter."""
    twists = np.random.default_rng(1).uniform(-4.0, 4.0, (ROWS, 3))
    targets = swerve.module_targets(DRIVE, twists, HELD)
    speeds = targets.speeds + np.random.default_rng(2).normal(0.0, 0.2, targets.speeds.shape)
    assert_equal_results(twists, targets, speeds)
    rows = medians(contenders(twists, targets, speeds), REPEATS)
    times = {name: seconds / ROWS for name, seconds in rows.items()}
    print(f"Swerve kinematics, {ROWS} rows, median of {REPEATS} repeats, results equal to 1e-9\n")
    for name, seconds in times.items():
        print(f"  {name:36s} {seconds * 1e9:8.0f} ns a row")
    for way, kernel, door, wanted in (
        ("inverse", "fill_targets", "module_targets", 15.0),
        ("forward", "fill_motion", "body_motion", 4.5),
    ):
        bare, whole = times[f"wpimath {way}, bare call"], times[f"wpimath {way}, floats to floats"]
        batch = times[f"wpimath {way}, loop"] / times[f"swerve.{door}, batch"]
        one, call = times[f"{kernel}, one row"] / bare, times[f"swerve.{door}, one row"] / whole
        print(
            f"\n  {way}: batch, times faster than a loop         {batch:6.1f}   wanted >= {wanted}"
        )
        print(f"  {way}: kernel, share of wpimath's bare call    {one:6.2f}   wanted <= 1")
        print(f"  {way}: checked call, share of floats to floats {call:6.2f}   wanted <= 3")


if __name__ == "__main__":
    main()
