"""Are two answers the same command? Full turns of a module's angle do not matter."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course.exercises.likeness import like_case
from robocon_course.exercises.model import Case
from robocon_course.geometry import wrap_angle
from robocon_course.swerve import ModuleTargets

CLOSE = 1e-9


def modules_case(what: str, reference: Callable[..., ModuleTargets], *args: object) -> Case:
    """A case whose answer is right where each module rolls the same way as the reference's.

    Parameters
    ----------
    what : str
        The situation in words.
    reference : callable
    *args : object
        What answer and reference are called with.
    """

    def same(came: ModuleTargets, expected: ModuleTargets) -> ModuleTargets:
        angles = np.asarray(came.angles, float)
        alike = np.abs(wrap_angle(angles - expected.angles)) < CLOSE
        return ModuleTargets(came.speeds, np.where(alike, expected.angles, angles))

    return like_case(what, reference, args, same, CLOSE)
