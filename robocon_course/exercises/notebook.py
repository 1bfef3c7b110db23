"""What a student calls in a notebook: begin, check, hint, answer, robot_parts, status."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry
from robocon_course.exercises.display import EDGE, Shown, show_finding, shown_verdict
from robocon_course.exercises.judge import judge_answer, judge_number, no_answer
from robocon_course.exercises.model import Exercise, Number, Outcome, Verdict
from robocon_course.exercises.source import (
    Answer,
    assemble,
    broken_definition,
    from_namespace,
    not_run,
)
from robocon_course.exercises.workspace import Workspace
from robocon_course.worlds import student_number

_spare: list[AnswerProcess] = []  # started ahead of need, so that nobody waits for imports
_last: dict[str, Callable[..., Any]] = {}  # the student's functions, by exercise


def begin(chapter: str, student: int | str | None = None, *, log: bool | None = None) -> int | str:
    """Start a chapter: which student, which points, and what is kept where.

    Parameters
    ----------
    chapter : str
        ``"imu"``.
    student : int or str, optional
        Your student number, in quotes if it holds letters or begins with 0. It is remembered
        for the chapters to come.
    log : bool, optional
        Keep a log of attempts (exercise, outcome, attempt, time) in ``my_robot/``; off unless
        you turn it on, and it never leaves your computer by itself.

    Returns
    -------
    int or str
        The student number in use; 0 is the course's example student.
    """
    workspace, about = Workspace(), registry.chapter(chapter)
    if student is not None:
        workspace.remember(student=student_number(student))
    if log is not None:
        workspace.remember(log=bool(log))
    keeps = "kept in my_robot/attempts.jsonl" if workspace.record.get("log") else "off"
    print(
        f"Chapter {about.number}: {about.title}. {about.points:g} points, "
        f"about {about.minutes} minutes.\n"
        f"Student number {workspace.student}. Log of attempts: {keeps}."
    )
    _start_spare()
    return workspace.student


def check(exercise_id: str, *, practice: bool = False) -> Callable[..., Any]:
    """Judge your function, say what came of it, and return the part to use from here on.

    Your own function if it was accepted, else the course's: later cells run either way.

    Parameters
    ----------
    exercise_id : str
        ``"imu.mahony_step"`` judges the function ``mahony_step`` of this notebook.
    practice : bool
        Show the verdict only: no points, nothing kept.
    """
    exercise = registry.exercise(exercise_id)
    if isinstance(exercise, Number):
        raise ValueError(f'{exercise_id} is a number: hand it in with answer("{exercise_id}", …)')
    workspace = Workspace()
    answer, verdict = _find(exercise)
    if answer:
        verdict = _judge_in_process(exercise, answer, workspace.student)
    if practice:
        _show(verdict, "Practice: nothing was noted.")
        return exercise.reference
    _report(workspace, verdict, _keep(workspace, exercise, answer, verdict))
    return _last[exercise_id] if verdict.accepted else exercise.reference


def answer(exercise_id: str, value: Any, *decimals: Any) -> None:
    """Hand in a number from your own sensor world.

    Parameters
    ----------
    exercise_id : str
    value : float
        In the unit that the exercise names; ``...`` means not attempted.
    *decimals
        What follows where a decimal comma was typed; the verdict then says so.
    """
    number = registry.exercise(exercise_id)
    if isinstance(number, Exercise):
        raise ValueError(f'{exercise_id} is a function: judge it with check("{exercise_id}")')
    workspace = Workspace()
    value = (value, *decimals) if decimals else value
    _report(workspace, judge_number(number, value, workspace.student), "")


def hint(exercise_id: str, level: int = 1) -> Shown:
    """A hint; higher levels say more.

    Parameters
    ----------
    exercise_id : str
    level : int
        1 is the gentlest.
    """
    hints = registry.exercise(exercise_id).hints
    level = min(max(int(level), 1), len(hints))
    more = f'More: hint("{exercise_id}", {level + 1})' if level < len(hints) else "The last hint."
    return Shown(f"Hint {level} of {len(hints)}", f"{hints[level - 1]}\n{more}", "#0969da")


def running_as_test() -> bool:
    """Whether this notebook runs in a test: long work may then be cut short.

    Set by the environment variable ROBOCON_TEST. Verdicts never depend on it.
    """
    return bool(os.environ.get("ROBOCON_TEST"))


def status() -> Shown:
    """Points per chapter, accepted parts, and what comes next."""
    return Shown("Where you are", "\n".join(status_lines(Workspace())), EDGE[Outcome.NOT_ATTEMPTED])


def status_lines(workspace: Workspace) -> list[str]:
    """The text of ``status`` for one workspace."""
    earned = workspace.record.get("points", {})
    lines, following = [], ""
    for about in registry.chapters():
        points = sum(earned.get(e.id, 0.0) for e in about.exercises)
        lines.append(f"{about.number} {about.title}: {points:g} of {about.points:g} points")
        open_ones = [e.id for e in about.exercises if earned.get(e.id, 0.0) == 0.0]
        following = following or (f"{open_ones[0]} in {about.name}.ipynb" if open_ones else "")
    parts = ", ".join(f"{k} (version {v})" for k, v in workspace.in_use().items())
    lines.append(f"Parts of your robot: {parts or 'none yet'}")
    lines.append(f"Next: {following or 'every exercise has points'}")
    return lines


def _start_spare() -> AnswerProcess:
    if not _spare:
        _spare.append(AnswerProcess())
    return _spare[0]


def _judge_in_process(exercise: Exercise, answer: Answer, student: int) -> Verdict:
    """Judge in a fresh process, and start the next one while the student reads the verdict."""
    _start_spare()
    process = _spare.pop()
    with process:
        file = Path(exercise.file) if exercise.file else None
        verdict = judge_answer(process, exercise, answer, student, file=file)
    _start_spare()
    return verdict


def _find(exercise: Exercise) -> tuple[Answer | None, Verdict | None]:
    """The student's function by name, or a verdict that says why there is none."""
    namespace = dict(_namespace())
    name = exercise.function_name
    broken = broken_definition(name, namespace.get("In", []))
    if broken:
        return None, no_answer(exercise, broken)
    found = namespace.get(name)
    if found is exercise.reference and exercise.id in _last:
        # The last check put the reference in its place; the student's own is what is judged.
        found = namespace[name] = _last[exercise.id]
    if found is None or found is exercise.reference:
        text = f"There is no function {name} in this notebook yet. Run the cell that defines it."
        return None, no_answer(exercise, text)
    _last[exercise.id] = found
    answer = assemble(name, from_namespace(namespace))
    if answer and not_run(answer, namespace.get("In", [])):
        text = (
            f"Your newest cell with def {name} did not run to its end. Run it and read its error."
        )
        return None, no_answer(exercise, text)
    if answer is None:
        text = f"{name} is not a function defined in a cell of this notebook (it is {found!r:.80})."
        return None, no_answer(exercise, text)
    return answer, None


def _namespace() -> dict[str, Any]:
    """The notebook's own names."""
    import __main__

    return vars(__main__)


def _keep(workspace: Workspace, exercise: Exercise, answer: Answer | None, verdict: Verdict) -> str:
    """Write an accepted answer to my_robot/ and say so."""
    if not verdict.accepted or answer is None:
        return ""
    clash = workspace.clash(exercise.id, answer.text)
    if clash:
        return (
            f"Not written to my_robot/: your helper {clash} has changed. "
            "Give one of the two another name and check again."
        )
    version = workspace.accept(exercise.id, answer.text)
    return f"Now part of your robot: my_robot/{exercise.chapter}.py, version {version}."


def _report(workspace: Workspace, verdict: Verdict, extra: str) -> None:
    workspace.note(verdict)
    _show(verdict, extra)
    # nbgrader counts a cell as solved unless it raises; a student's own run goes on.
    if os.environ.get("NBGRADER_EXECUTION") and verdict.points < verdict.out_of:
        raise AssertionError(str(verdict))


def _show(verdict: Verdict, extra: str) -> None:
    from IPython.display import display

    display(shown_verdict(verdict, extra or _advice(verdict)))
    show_finding(verdict)


def _advice(verdict: Verdict) -> str:
    """What to do after anything but full points."""
    if verdict.points == verdict.out_of:
        return ""
    name = verdict.id.partition(".")[2]
    known = registry.exercise(verdict.id)
    rejected = verdict.outcome in (Outcome.WRONG, Outcome.ERROR) and isinstance(known, Exercise)
    whose = f"From here on {name} is the course's; run your cell again to try yours. "
    return (whose if rejected else "") + f'Stuck? hint("{verdict.id}")'
