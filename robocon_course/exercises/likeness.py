"""Cases whose answer may be written in more than one way."""

from __future__ import annotations

import copy
import sys
from collections.abc import Callable
from typing import Any

from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import difference
from robocon_course.exercises.model import Case


def like_case(
    what: str,
    reference: Callable[..., Any],
    args: tuple,
    same: Callable[[Any, Any], Any],
    close: float,
) -> Case:
    """A case whose answer is compared after it was put into the reference's words.

    Parameters
    ----------
    what : str
        The situation in words.
    reference : callable
    args : tuple
        What answer and reference are called with.
    same : callable
        ``same(came, expected)``: the answer, with what only looks different made equal.
    close : float
        Largest difference that still counts as equal.

    Returns
    -------
    Case
    """

    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        expected = reference(*copy.deepcopy(args))
        wrong_form = difference(reply.value, expected, sys.float_info.max)
        return wrong_form or difference(same(reply.value, expected), expected, close)

    return Case(what, args, "", close, judge=judge)
