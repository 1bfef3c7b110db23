"""Are two answers the same command? Full turns of a module's angle do not matter."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable

import numpy as np

from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import difference
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

    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        expected = reference(*copy.deepcopy(args))
        wrong_form = difference(reply.value, expected, sys.float_info.max)
        if wrong_form:
            return wrong_form
        angles = np.asarray(reply.value.angles, float)
        same = np.abs(wrap_angle(angles - expected.angles)) < CLOSE
        came = ModuleTargets(reply.value.speeds, np.where(same, expected.angles, angles))
        return difference(came, expected, CLOSE)

    return Case(what, args, "", CLOSE, judge=judge)
