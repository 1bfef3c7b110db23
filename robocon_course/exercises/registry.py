"""Every chapter and every exercise, by name."""

from __future__ import annotations

import difflib
import functools
import importlib

from robocon_course.exercises.model import Chapter, Exercise, Number, UnknownExercise

TOPICS = ("start", "imu", "odometry", "swerve", "planning", "tracking", "vision", "mission")


@functools.cache
def chapters() -> tuple[Chapter, ...]:
    """All chapters in their order."""
    return tuple(
        importlib.import_module(f"robocon_course.exercises.{topic}").CHAPTER for topic in TOPICS
    )


def chapter(name: str) -> Chapter:
    """A chapter by topic (``"imu"``), number (``"01"``) or notebook name (``"01_imu"``).

    Raises
    ------
    UnknownExercise
        There is no such chapter; the message lists them.
    """
    for found in chapters():
        if name in (found.topic, found.number, found.name, found.number.lstrip("0")):
            return found
    known = ", ".join(found.name for found in chapters())
    raise UnknownExercise(f"there is no chapter {name!r}; there are {known}")


def exercises() -> dict[str, Exercise | Number]:
    """All exercises of all chapters."""
    return {e.id: e for about in chapters() for e in about.exercises}


def exercise(exercise_id: str) -> Exercise | Number:
    """An exercise by name.

    Raises
    ------
    UnknownExercise
        There is no such exercise; the message names the nearest.
    """
    known = exercises()
    if exercise_id in known:
        return known[exercise_id]
    near = difflib.get_close_matches(str(exercise_id), known, n=1, cutoff=0.4)
    advice = f"did you mean {near[0]!r}?" if near else "see the chapter's list of exercises"
    raise UnknownExercise(f"there is no exercise {exercise_id!r}; {advice}")
