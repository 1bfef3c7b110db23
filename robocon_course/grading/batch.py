"""Judge many submissions: each in a fresh process and a time of its own, one row each."""

from __future__ import annotations

import csv
import os
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry
from robocon_course.exercises.judge import judge_answer, judge_number, no_answer
from robocon_course.exercises.model import Exercise, Number, Outcome, Verdict
from robocon_course.exercises.source import Lookup, assemble, broken_definition
from robocon_course.grading.submission import (
    COMPUTED,
    Submission,
    SubmissionError,
    read_submission,
)


@dataclass(frozen=True)
class Row:
    """One submission's result: verdicts, or the reason why there are none.

    ``remark`` says what an instructor would otherwise look for: a file that was not handed in.
    """

    name: str
    student: int | str = 0
    verdicts: tuple[Verdict, ...] = ()
    reason: str = ""
    seconds: float = field(default=0.0, compare=False)
    remark: str = ""

    @property
    def points(self) -> float:
        """Points earned."""
        return sum(v.points for v in self.verdicts)

    @property
    def out_of(self) -> float:
        """Points to be had in the chapters that were handed in."""
        return sum(v.out_of for v in self.verdicts)


def grade_one(path: Path, *, time_limit: float = 60.0) -> Row:
    """Judge one submission; never raises for what it contains.

    Parameters
    ----------
    path : Path
        A notebook or a folder of notebooks.
    time_limit : float  [s]
        For the whole submission; each exercise keeps its own limit within it.
    """
    started = time.monotonic()
    try:
        submission = read_submission(path)
        exercises = [e for about in submission.chapters for e in about.exercises]
        if not exercises:
            raise SubmissionError("no exercise of the course was found in it")
        verdicts = tuple(_verdicts(submission, exercises, started + time_limit))
    except (SubmissionError, OSError) as error:
        return Row(path.name, reason=str(error), seconds=time.monotonic() - started)
    except Exception as error:  # one broken submission never stops the batch
        reason = f"could not be judged ({type(error).__name__}: {error})"
        return Row(path.name, reason=reason, seconds=time.monotonic() - started)
    seconds, remark = time.monotonic() - started, _missing_files(submission, exercises)
    return Row(path.name, submission.student, verdicts, "", seconds, remark)


def grade_all(
    paths: list[Path],
    *,
    time_limit: float = 60.0,
    jobs: int | None = None,
    on_row: Callable[[Row], None] = lambda row: None,
) -> list[Row]:
    """Judge submissions side by side; ``on_row`` hears of each as it is done.

    Returns
    -------
    list of Row
        In the order of ``paths``.
    """
    rows: dict[Path, Row] = {}
    # Threads suffice: the work is done by one process per submission, which they wait for.
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as pool:
        futures = {pool.submit(grade_one, p, time_limit=time_limit): p for p in paths}
        for future in as_completed(futures):
            rows[futures[future]] = row = future.result()
            on_row(row)
    return [rows[path] for path in paths]


def write_csv(rows: list[Row], path: Path) -> None:
    """One row per submission, one column per exercise; written beside, then renamed."""
    ids = list(registry.exercises())
    beside = path.with_name(path.name + ".new")
    # A name from a foreign archive may hold bytes that are no text; it must not cost the table.
    with beside.open("w", newline="", encoding="utf-8", errors="backslashreplace") as file:
        table = csv.writer(file)
        table.writerow(["submission", "student", "points", "out_of", *ids, "reason"])
        for row in rows:
            points = {v.id: f"{v.points:g}" for v in row.verdicts}
            total = [f"{row.points:g}", f"{row.out_of:g}"]
            cells = [points.get(exercise_id, "") for exercise_id in ids]
            table.writerow([row.name, row.student, *total, *cells, row.reason or row.remark])
    os.replace(beside, path)


def _missing_files(submission: Submission, exercises: list[Exercise | Number]) -> str:
    """Which files the exercises ask for and nobody handed in."""
    wanted = [e for e in exercises if isinstance(e, Exercise) and e.file]
    return ", ".join(f"{e.file} was not handed in" for e in wanted if not submission.file(e))


def _verdicts(
    submission: Submission, exercises: list[Exercise | Number], deadline: float
) -> Iterator[Verdict]:
    functions = [e for e in exercises if isinstance(e, Exercise)]
    verdicts: dict[str, Verdict] = {}
    # As in the notebook: what was not accepted is the course's from its check onwards.
    references: dict[str, str] = {}
    for e in functions:
        found = _handed_on(submission.lookup(e), e.function_name, references.values())
        verdicts[e.id] = _function_verdict(submission, e, found, deadline - time.monotonic())
        if not verdicts[e.id].accepted:
            references[e.id] = e.blocked[0]
    numbers = submission.numbers
    if COMPUTED in numbers.values():
        computed = _computed(submission, references, deadline)
        numbers = {k: computed.get(k, v) if v is COMPUTED else v for k, v in numbers.items()}
    for exercise in exercises:
        if isinstance(exercise, Number) and numbers.get(exercise.id) is COMPUTED:
            text = "The cells gave no number when they ran in order: one raised or never ended."
            yield no_answer(exercise, text)
        elif isinstance(exercise, Number):
            yield judge_number(exercise, numbers.get(exercise.id), submission.student)
        else:
            yield verdicts[exercise.id]


def _handed_on(lookup: Lookup, own: str, references: Iterable[str]) -> Lookup:
    """The notebook's definitions, with the course's own in place of those not accepted."""
    lines = {}
    for dotted in references:
        module, _, name = dotted.rpartition(".")
        lines[name] = f"from {module} import {name}"

    def find(name: str) -> str | None:
        text = lookup(name)
        return text if text is None or name == own else lines.get(name, text)

    return find


def _function_verdict(
    submission: Submission, exercise: Exercise, lookup: Lookup, time_left: float
) -> Verdict:
    answer = assemble(exercise.function_name, lookup)
    if answer is None:
        broken = broken_definition(exercise.function_name, submission.cells)
        if broken:
            return no_answer(exercise, broken)
        text = f"There is no function {exercise.function_name} in the notebook."
        return Verdict(exercise.id, Outcome.NOT_ATTEMPTED, 0.0, exercise.points, text)
    if time_left <= 0:
        text = "The time for the whole submission was used up."
        return Verdict(exercise.id, Outcome.ERROR, 0.0, exercise.points, text)
    with AnswerProcess() as process:
        return judge_answer(
            process, exercise, answer, submission.student,
            time_limit=time_left, file=submission.file(exercise),
        )  # fmt: skip


def _computed(
    submission: Submission, references: dict[str, str], deadline: float
) -> dict[str, float]:
    """Numbers that are worked out in the notebook: its cells run once, in a fresh process."""
    with AnswerProcess(max(deadline - time.monotonic(), 0.0)) as process:
        reply = process.run(list(submission.cells), submission.student, references)
    return {} if reply.error else {str(k): v for k, v in reply.value}
