"""An exercise is data: what is asked, with which inputs it is tried, how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from robocon_course._arrays import CourseError
from robocon_course.answers.process import Reply
from robocon_course.worlds import Student


class Outcome(Enum):
    """The four things a check can say. Sign and word, so that colour is never needed."""

    PASSED = "✔ passed"
    WRONG = "✘ wrong"
    NOT_ATTEMPTED = "– not attempted"
    ERROR = "! error"


@dataclass(frozen=True)
class Case:
    """One call of the answer, with inputs, and how the reply is judged.

    Attributes
    ----------
    what : str
        The situation in words: "a robot that leans 20° to the left".
    args : tuple
        What the function is called with.
    unit : str
    atol : float or dict of float
        Largest difference from the reference that still counts as equal, in ``unit``. By field
        for a result object; fields that it does not name must only have the right form.
    judge : callable, optional
        ``judge(reply) -> sentence or None``; takes the place of the comparison with the
        reference where a property, or a refusal, is what matters.
    truth : object, optional
        What the answer is measured against in a challenge; the answer never sees it.
    traits : callable, optional
        ``traits(value)``: by what of a result one mistake is told from another, where several
        results are equally right. Without it, by all of it.
    timed : str
        Where somebody wants to know how long the answer took: what took so long, "The way over
        the field". Points never depend on it.
    """

    what: str
    args: tuple
    unit: str = ""
    atol: float | dict[str, float] = 1e-9
    judge: Callable[[Reply], str | None] | None = None
    truth: Any = None
    traits: Callable[[Any], Any] | None = None
    timed: str = ""


@dataclass(frozen=True)
class Mistake:
    """A wrong answer that people really give, as code, with what to tell them."""

    name: str
    message: str
    function: Callable[..., Any]


@dataclass(frozen=True)
class Exercise:
    """A function to write.

    Attributes
    ----------
    id : str
        ``"chapter.function"``; the reference bears the same name in the same module.
    cases : callable
        ``cases(student, rng) -> sequence of Case``: fresh numbers for every student and purpose.
    shortcuts : tuple of str
        More course functions, by dotted name, that an answer must not call.
    score : Score, optional
        For a challenge: how good is good enough, instead of equality.
    file : str
        Name of a file that is handed in beside the notebook, for the answer to open: weights that
        took too long to train to do it again.
    play : callable, optional
        ``play(ask, args) -> Reply``: for an answer that is asked more than once in a case, as a
        strategy is in a game. Without it the answer is called with ``args``, once.
    """

    id: str
    title: str
    points: float
    reference: Callable[..., Any]
    cases: Callable[[Student, np.random.Generator], Sequence[Case]]
    mistakes: tuple[Mistake, ...]
    hints: tuple[str, ...]
    time_limit: float = 5.0
    shortcuts: tuple[str, ...] = ()
    score: Score | None = None
    file: str = ""
    play: Callable[[Callable[[tuple], Reply], tuple], Reply] | None = None

    @property
    def function_name(self) -> str:
        """Name of the function that the student writes."""
        return self.id.partition(".")[2]

    @property
    def chapter(self) -> str:
        """Name of the chapter, which is also the module's."""
        return self.id.partition(".")[0]

    @property
    def blocked(self) -> tuple[str, ...]:
        """What an answer must not call: the course's own answer first, then its shortcuts."""
        return (f"{self.reference.__module__}.{self.reference.__name__}", *self.shortcuts)


@dataclass(frozen=True)
class Score:
    """How a challenge is marked: an error measured on every case, and what each level is worth.

    Attributes
    ----------
    error : callable
        ``error(case, value) -> float``; smaller is better.
    unit : str
    levels : tuple of (float, float)
        (largest error allowed, share of the points), best level first.
    """

    error: Callable[[Case, Any], float]
    unit: str
    levels: tuple[tuple[float, float], ...]

    def share(self, error: float) -> float:
        """Share of the points that an error of this size earns."""
        return next((share for limit, share in self.levels if error <= limit), 0.0)


@dataclass(frozen=True)
class Number:
    """A number to find in the student's own world.

    Attributes
    ----------
    truth : callable
        ``truth(student) -> float``.
    tolerance : float
        Largest difference accepted, in ``unit``.
    mistakes : tuple of Mistake
        Their functions take the student number, too.
    likeness : float
        So near to a mistake's number, in parts of it, a wrong number is taken for that mistake.
    """

    id: str
    title: str
    points: float
    truth: Callable[[Student], float]
    tolerance: float
    unit: str
    mistakes: tuple[Mistake, ...]
    hints: tuple[str, ...]
    likeness: float = 0.02

    @property
    def chapter(self) -> str:
        """Name of the chapter."""
        return self.id.partition(".")[0]


@dataclass(frozen=True)
class Finding:
    """The first case that did not work out: what was called, what came, what was expected."""

    case: Case
    sentence: str
    got: Any = None
    expected: Any = None


@dataclass(frozen=True)
class Verdict:
    """What a check says.

    ``took`` is how long the answer took, in words, where the exercise tells that: the only thing
    here that no two runs agree on.
    """

    id: str
    outcome: Outcome
    points: float
    out_of: float
    message: str
    mistake: str = ""
    finding: Finding | None = None
    cases: tuple[int, int] = (0, 0)
    printed: str = field(default="", compare=False)
    took: str = field(default="", compare=False)

    @property
    def accepted(self) -> bool:
        """Whether the answer may become part of the robot."""
        return self.outcome is Outcome.PASSED

    @property
    def line(self) -> str:
        """The verdict in one line, the same in every run."""
        return f"{self.outcome.value}: {self.id}, {self.points:g} of {self.out_of:g} points"

    def __str__(self) -> str:
        return "\n  ".join(part for part in (self.line, self.message, self.took) if part)


class UnknownExercise(CourseError, KeyError):
    """No exercise of that name; the message lists near ones."""

    def __str__(self) -> str:
        return str(self.args[0])


@dataclass(frozen=True)
class Chapter:
    """A chapter: its place in the course and its exercises.

    Attributes
    ----------
    number : str
        Two digits.
    topic : str
        Name of notebook, module, tests and exercise prefix.
    minutes : int
        Time a student should set aside.
    """

    number: str
    topic: str
    title: str
    minutes: int
    needs: tuple[str, ...]
    exercises: tuple[Exercise | Number, ...]

    @property
    def name(self) -> str:
        """Name of the notebook, without its ending."""
        return f"{self.number}_{self.topic}"

    @property
    def points(self) -> float:
        """Points to be had in the chapter."""
        return total(self.exercises)


def total(exercises: Iterable[Exercise | Number]) -> float:
    """Sum of the points of some exercises."""
    return sum(exercise.points for exercise in exercises)
