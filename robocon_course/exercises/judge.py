"""Judge an answer by asking it: the checks stay here, the student's code stays elsewhere."""

from __future__ import annotations

import copy
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from robocon_course.answers.process import AnswerProcess, Reply
from robocon_course.answers.wire import fields_of
from robocon_course.exercises.compare import difference
from robocon_course.exercises.model import (
    Case,
    Exercise,
    Finding,
    Mistake,
    Number,
    Outcome,
    Verdict,
)
from robocon_course.exercises.source import Answer, advice_on_missing
from robocon_course.worlds import Student, generator

Ask = Callable[[tuple], Reply]

ALIKE = 1e-9  # two computations of one wrong formula
SPECIAL = ("NotImplementedError", "NotYourOwn", "ChangedInput")
STOPPED = ("TimeLimit", "ProcessEnded", "TooLarge", "NotPlainData")


def judge(exercise: Exercise, ask: Ask, student: Student = 0, salt: str = "public") -> Verdict:
    """Try an answer on every case of an exercise.

    Parameters
    ----------
    exercise : Exercise
    ask : callable
        ``ask(args) -> Reply``: calls the answer, wherever it runs.
    student : int
        Student number; every student gets numbers of their own.
    salt : str
        Tells public from graded cases: the same functions, other numbers.

    Returns
    -------
    Verdict
        Full points, or the first case that failed and the likely cause.
    """
    cases = exercise.cases(student, generator(student, exercise.id, salt))
    ask = _played(exercise, ask)
    if exercise.score:
        return _judge_score(exercise, cases, ask)
    replies: list[Reply] = []
    for case in cases:
        replies.append(ask(case.args))
        sentence = _problem(exercise, case, replies[-1])
        if sentence:
            at = len(replies) - 1
            replies += _ask_the_rest(cases[at + 1 :], ask, replies[-1])
            return _failed(exercise, cases, replies, at, sentence)
    text = f"{len(cases)} of {len(cases)} cases are right."
    verdict = _verdict(
        exercise, Outcome.PASSED, text, cases=(len(cases), len(cases)), replies=replies
    )
    return replace(verdict, took=_took(cases, replies))


def judge_answer(
    process: AnswerProcess,
    exercise: Exercise,
    answer: Answer,
    student: Student,
    *,
    time_limit: float = math.inf,
    salt: str = "public",
    file: Path | None = None,
) -> Verdict:
    """Judge an assembled answer inside a running process; ``file`` is what came with it."""
    if answer.missing:
        return no_answer(exercise, advice_on_missing(answer, exercise.chapter))
    problem = process.give(file, exercise.file) if file is not None else ""
    if problem:
        return no_answer(exercise, f"{file.name} {problem}.")
    process.allow(min(exercise.time_limit, time_limit))
    loaded = process.load(answer.text, exercise.blocked)
    if loaded.error == "NotYourOwn":
        return _verdict(exercise, Outcome.WRONG, _not_own(loaded))
    if loaded.error:
        return no_answer(exercise, f"Your code does not load: {loaded.error}: {loaded.message}")
    return judge(exercise, lambda args: process.call(answer.name, args), student, salt)


def no_answer(exercise: Exercise | Number, message: str) -> Verdict:
    """The verdict on code that could not be tried at all."""
    return Verdict(exercise.id, Outcome.ERROR, 0.0, exercise.points, message)


def judge_number(number: Number, value: Any, student: Student = 0) -> Verdict:
    """Judge a number that a student found in their own world."""

    def verdict(outcome: Outcome, message: str, mistake: str = "") -> Verdict:
        points = number.points if outcome is Outcome.PASSED else 0.0
        return Verdict(number.id, outcome, points, number.points, message, mistake)

    unit, in_unit = (f" {number.unit}", f" in {number.unit}") if number.unit else ("", "")
    if value is None or value is ...:
        return verdict(Outcome.NOT_ATTEMPTED, "Put your number in place of the three dots.")
    if isinstance(value, tuple | list):
        text = "Expected one number; write the decimals with a point, not with a comma: 0.3."
        return verdict(Outcome.ERROR, text)
    try:
        value = float(value)
    except (TypeError, ValueError, OverflowError):
        kind = type(value).__name__
        return verdict(Outcome.ERROR, f"Expected one number{in_unit}, got a {kind}.")
    if not math.isfinite(value):
        return verdict(Outcome.ERROR, f"Expected a number{in_unit}, got {value}.")
    whose = f"the robot of student number {student}"
    if abs(value - number.truth(student)) <= number.tolerance:
        return verdict(Outcome.PASSED, f"{value:.4g}{unit}: that is right for {whose}.")
    for mistake in number.mistakes:
        # In parts: a small wrong number must not pass for another small wrong number.
        if math.isclose(value, mistake.function(student), rel_tol=number.likeness):
            return verdict(Outcome.WRONG, mistake.message, mistake.name)
    text = f"{value:.4g}{unit}: not within {number.tolerance:.2g}{unit} of the truth for {whose}."
    return verdict(Outcome.WRONG, text)


def ask_function(function: Callable[..., Any]) -> Ask:
    """Ask a function of the course itself: a reference, or a wrong answer of the catalogue."""

    def ask(args: tuple) -> Reply:
        own, started = copy.deepcopy(args), time.monotonic()
        try:
            return Reply(value=function(*own), seconds=time.monotonic() - started)
        except Exception as error:
            return Reply(error=type(error).__name__, message=str(error))

    return ask


def _played(exercise: Exercise, ask: Ask) -> Ask:
    """How a whole case is asked: by one call, or by all the calls of a game."""
    play = exercise.play
    return ask if play is None else lambda args: play(ask, args)


def _problem(exercise: Exercise, case: Case, reply: Reply) -> str | None:
    """What is wrong with the reply to one case, None if nothing."""
    if reply.error in STOPPED or reply.error in SPECIAL:
        return reply.message or reply.error
    if case.judge:
        return case.judge(reply)
    if reply.error:
        return f"{reply.error}: {reply.message}"
    expected = exercise.reference(*copy.deepcopy(case.args))
    return difference(reply.value, expected, case.atol, case.unit)


def _ask_the_rest(cases: Sequence[Case], ask: Ask, last: Reply) -> list[Reply]:
    """Replies to the remaining cases, by which a known mistake is recognised."""
    return [] if last.error in STOPPED else [ask(case.args) for case in cases]


def _failed(
    exercise: Exercise, cases: Sequence[Case], replies: list[Reply], at: int, sentence: str
) -> Verdict:
    """The verdict when case number ``at`` is the first that failed."""
    case, reply = cases[at], replies[at]
    special = _special(case, reply)
    if special:
        outcome, text = special
        return _verdict(exercise, outcome, text, replies=replies)
    right = sum(_problem(exercise, c, r) is None for c, r in zip(cases, replies, strict=False))
    mistake = _recognise(exercise, cases, replies)
    expected = None if case.judge else exercise.reference(*copy.deepcopy(case.args))
    finding = Finding(
        case,
        sentence,
        _judged(case, reply.value),
        _judged(case, expected),
    )
    text = f"In the case “{case.what}”: {sentence}" + ("" if sentence.endswith("?") else ".")
    outcome = Outcome.WRONG
    if mistake:
        text += f" {mistake.message}"
    elif reply.error:
        outcome = Outcome.ERROR
        text += f" It came from the line: {reply.line}" if reply.line else ""
    return _verdict(
        exercise,
        outcome,
        text,
        mistake=mistake,
        finding=finding,
        cases=(right, len(cases)),
        replies=replies,
    )


def _special(case: Case, reply: Reply) -> tuple[Outcome, str] | None:
    """Outcomes that say nothing about right or wrong numbers."""
    if reply.error == "NotImplementedError":
        return Outcome.NOT_ATTEMPTED, "Write the function in the cell above, run it, check again."
    if reply.error == "NotYourOwn":
        return Outcome.WRONG, _not_own(reply)
    if reply.error == "ChangedInput":
        return Outcome.WRONG, (
            f"In the case “{case.what}”: it changes what it was given (x[0] = … or x += …). "
            "Somebody else still needs that array: work on a copy, or write x = x + …."
        )
    if reply.error == "TimeLimit":
        return Outcome.ERROR, (
            f"In the case “{case.what}”: {reply.message}. "
            "Does a loop never end, or does it do far more work than needed?"
        )
    if reply.error in STOPPED:
        return Outcome.ERROR, f"In the case “{case.what}”: {reply.message}."
    return None


def _recognise(
    exercise: Exercise, cases: Sequence[Case], replies: Sequence[Reply]
) -> Mistake | None:
    """The known mistake that explains every reply, if there is one."""
    if len(replies) < len(cases):
        return None
    for mistake in exercise.mistakes:
        ask = _played(exercise, ask_function(mistake.function))
        if all(
            _alike(case, reply, ask(case.args)) for case, reply in zip(cases, replies, strict=True)
        ):
            return mistake
    return None


def _took(cases: Sequence[Case], replies: Sequence[Reply]) -> str:
    """How long the timed cases took, in words."""
    pairs = zip(cases, replies, strict=True)
    return " ".join(f"{c.timed} took {r.seconds:.2f} s." for c, r in pairs if c.timed)


def _alike(case: Case, reply: Reply, other: Reply) -> bool:
    if reply.error or other.error:
        return reply.error == other.error
    if reply.value is None or other.value is None:
        return reply.value is other.value
    if case.traits:
        try:
            return case.traits(reply.value) == case.traits(other.value)
        except (TypeError, ValueError, AttributeError, IndexError):
            pass  # a result without the form that has such traits
    return difference(reply.value, other.value, case.atol or ALIKE) is None


def _not_own(reply: Reply) -> str:
    return f"This calls the course's own {reply.message}; write your own."


def _judged(case: Case, value: Any) -> Any:
    """What of a result is worth drawing: the fields that are judged, or the whole."""
    fields = fields_of(value)
    if fields is None or not isinstance(case.atol, dict):
        return value if fields is None else fields
    return {name: fields[name] for name in case.atol if name in fields}


def _judge_score(exercise: Exercise, cases: Sequence[Case], ask: Ask) -> Verdict:
    """Judge a challenge by its worst case."""
    replies, errors = [], []
    for case in cases:
        replies.append(ask(case.args))
        sentence = _problem(exercise, case, replies[-1]) if replies[-1].error else None
        sentence = sentence or _shape_problem(exercise, case, replies[-1])
        if not sentence:
            try:
                errors.append(exercise.score.error(case, replies[-1].value))
            except ValueError as refusal:  # the right form, but no such thing: a zero quaternion
                sentence = str(refusal)
        if sentence:
            at = len(replies) - 1
            replies += _ask_the_rest(cases[at + 1 :], ask, replies[-1])
            return _failed(exercise, cases, replies, at, sentence)
    worst = max(errors, key=lambda e: math.inf if math.isnan(e) else e)
    share = exercise.score.share(worst)
    mistake = None if share == 1.0 else _recognise(exercise, cases, replies)
    limit, unit = exercise.score.levels[0][0], exercise.score.unit
    text = f"Worst case {worst:.3g} {unit}; at most {limit:g} earns all points."
    if mistake:
        text += f" {mistake.message}"
    outcome = Outcome.PASSED if share else Outcome.WRONG
    return _verdict(exercise, outcome, text, share=share, mistake=mistake, replies=replies)


def _shape_problem(exercise: Exercise, case: Case, reply: Reply) -> str | None:
    """A challenge's result must at least have the form of the reference's, or what is asked."""
    if case.judge:
        return case.judge(reply)
    expected = exercise.reference(*copy.deepcopy(case.args))
    return difference(reply.value, expected, sys.float_info.max, case.unit)


def _verdict(
    exercise: Exercise,
    outcome: Outcome,
    message: str,
    *,
    share: float = 1.0,
    mistake: Mistake | None = None,
    finding: Finding | None = None,
    cases: tuple[int, int] = (0, 0),
    replies: Sequence[Reply] = (),
) -> Verdict:
    return Verdict(
        exercise.id,
        outcome,
        exercise.points * share if outcome is Outcome.PASSED else 0.0,
        exercise.points,
        message,
        mistake.name if mistake else "",
        finding,
        cases,
        "".join(reply.printed for reply in replies),
    )
