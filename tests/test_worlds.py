"""What all worlds promise: nobody can change the truth that a right answer is judged by."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from robocon_course import worlds
from robocon_course._arrays import frozen

WORLDS = {
    "imu_world": lambda: worlds.imu_world(7),
    "imu_rungs": lambda: worlds.imu_rungs(7, 5.0)["rough"],
    "rough_drive": lambda: worlds.rough_drive(np.random.default_rng(7)),
    "odometry_world": lambda: worlds.odometry_world(7),
    "rough_drive_log": lambda: worlds.rough_drive_log(np.random.default_rng(7)),
    "swerve_world": lambda: worlds.swerve_world(7),
    "slip_log": lambda: worlds.slip_log(np.random.default_rng(7)),
    "simulated_drive": lambda: worlds.simulated_drive(7, "ideal", 0.2),
}


def arrays_in(record, name: str = "") -> dict[str, np.ndarray]:
    """Every array of a dataclass, those of the dataclasses in it too."""
    found = {}
    for field in fields(record):
        value, path = getattr(record, field.name), f"{name}.{field.name}"
        if is_dataclass(value):
            found |= arrays_in(value, path)
        elif isinstance(value, np.ndarray):
            found[path] = value
    return found


@pytest.mark.parametrize("name", WORLDS)
def test_nobody_can_change_a_world(name):
    found = arrays_in(WORLDS[name]())
    assert found
    for path, array in found.items():
        with pytest.raises(ValueError, match="read-only"):
            array += 1
        base = array.base
        assert base is None or not base.flags.writeable, path


def test_a_student_who_tries_leaves_the_truth_as_it_was():
    before = worlds.odometry_world(7).square.poses.copy()
    with pytest.raises(ValueError, match="read-only"):
        worlds.odometry_world(7).square.poses[:, :2] += 1.0
    np.testing.assert_array_equal(worlds.odometry_world(7).square.poses, before)
    own = worlds.odometry_world(7).square.poses.copy()
    own[:, :2] += 1.0


def test_what_is_frozen_is_a_copy_and_the_original_stays_free():
    original = np.arange(3.0)
    copy = frozen(original[:2])
    original[0] = 5.0
    assert copy.tolist() == [0.0, 1.0] and not copy.flags.writeable
