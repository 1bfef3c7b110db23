"""solutions/NN_topic.py is the only source of a lesson; everything else is made from it.

``student_notebook`` takes the solutions out; ``executed_notebook`` runs the whole;
``check_lesson`` compares what lies in the repository with what the source says, without running
anything. Reading and stripping are jupytext's and nbgrader's; what is ours is written here.

A code cell of the source names its exercise in the cell header::

    # %% exercise="imu.gravity_direction"
    # %% check="imu.gravity_direction"
    # %% answer="imu.own_bias"
"""

from __future__ import annotations

import copy
import hashlib
import os
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nbformat
from nbformat import NotebookNode

from robocon_course._arrays import CourseError
from robocon_course.exercises import registry

STUB = '# YOUR CODE HERE\nraise NotImplementedError("not solved yet")'
NUMBER_STUB = "...,  # YOUR NUMBER HERE"
KERNEL = {"display_name": "Python 3 (ipykernel)", "language": "python", "name": "python3"}
CELL_TIME_LIMIT = 300  # s


class LessonError(CourseError):
    """A lesson's source is not well formed; the message says where."""


def sources(folder: Path) -> list[Path]:
    """The lesson sources of a solutions/ folder, in order."""
    return sorted(folder.glob("[0-9][0-9]_*.py"))


def build_lesson(path: Path, *, check: bool = False) -> list[str]:
    """Make the two notebooks of a lesson, or only compare them with their source.

    Parameters
    ----------
    path : Path
        solutions/NN_topic.py; the student's notebook goes to notebooks/ beside solutions/.
    check : bool
        Write and execute nothing.

    Returns
    -------
    list of str
        What is not well formed, raises, or is out of step; empty when all is well.
    """
    student = path.parent.parent / "notebooks" / f"{path.stem}.ipynb"
    solved = path.with_suffix(".ipynb")
    try:
        source = read_source(path)
        if not check:
            write_notebook(student_notebook(source), student)
            with tempfile.TemporaryDirectory() as workspace:
                _bring_files(source, path.parent, Path(workspace))
                write_notebook(executed_notebook(source, Path(workspace)), solved)
        return check_lesson(source, student, solved)
    except LessonError as error:
        return [f"{path.name}: {line}" for line in str(error).splitlines()]


def read_source(path: Path) -> NotebookNode:
    """A lesson source as a notebook with our metadata, fixed cell ids and nothing executed.

    Raises
    ------
    LessonError
        Unbalanced solution marks, an exercise without cases, an unknown exercise, more than one
        H1, an image without alt text.
    """
    import jupytext

    notebook = jupytext.read(path, fmt="py:percent")
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    notebook.metadata = nbformat.from_dict(
        {
            "kernelspec": KERNEL,
            "language_info": {"name": "python"},
            "robocon": {
                "generated": f"generated, edit solutions/{path.name} and run: robocon build"
            },
        }
    )
    taken: set[str] = set()
    for cell in notebook.cells:
        _mark(cell, taken, path)
    problems = list(source_problems(notebook))
    if problems:
        raise LessonError("\n".join(problems))
    return notebook


def student_notebook(source: NotebookNode) -> NotebookNode:
    """The notebook a student opens: solutions replaced by stubs, no outputs, checksums set."""
    from nbgrader.preprocessors import ClearOutput, ComputeChecksums, LockCells

    notebook = copy.deepcopy(source)
    for cell in notebook.cells:
        _strip(cell)
    for step in (ClearOutput(), LockCells(), ComputeChecksums()):
        notebook, _ = step.preprocess(notebook, {})
    return notebook


def executed_notebook(source: NotebookNode, workspace: Path) -> NotebookNode:
    """The solved notebook with its outputs; accepted parts go to ``workspace``.

    Raises
    ------
    LessonError
        A cell raises; the message shows the cell and the exception.
    """
    from nbclient import NotebookClient
    from nbclient.exceptions import CellExecutionError

    notebook = copy.deepcopy(source)
    notebook.metadata.kernelspec = dict(KERNEL)
    client = NotebookClient(
        notebook,
        timeout=CELL_TIME_LIMIT,
        kernel_name="python3",
        resources={"metadata": {"path": str(workspace)}},
        record_timing=False,
    )
    try:
        # Whoever builds may be a student too: their robot and their number stay out of it.
        own = os.environ | {"ROBOCON_WORKSPACE": str(workspace)}
        client.execute(stderr=subprocess.DEVNULL, env=own)
    except CellExecutionError as error:
        first = str(error).splitlines()[2]
        raise LessonError(f"a cell raises {error.ename}: {error.evalue} (cell {first!r})") from None
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
    notebook.metadata = copy.deepcopy(source.metadata)
    return notebook


def _bring_files(source: NotebookNode, folder: Path, workspace: Path) -> None:
    """Files that the exercises ask for: from beside the solution to beside the notebook."""
    for cell in source.cells:
        known = registry.exercises().get(cell.metadata.get("robocon", {}).get("exercise", ""))
        file = getattr(known, "file", None)
        if file and (folder / file).is_file():
            shutil.copy2(folder / file, workspace / file)


def write_notebook(notebook: NotebookNode, path: Path) -> None:
    """Write a notebook, refusing one that breaks the format."""
    nbformat.validate(notebook)
    path.write_text(nbformat.writes(notebook) + "\n", encoding="utf-8")


def check_lesson(source: NotebookNode, student_path: Path, solved_path: Path) -> list[str]:
    """What is out of step between a source and the two notebooks made from it.

    Compares cell sources, metadata and verdict lines; never pictures, and without running.

    Returns
    -------
    list of str
        One sentence per problem; empty when all is in step.
    """
    problems = _drift(student_notebook(source), student_path)
    problems += _drift(source, solved_path)
    if solved_path.is_file():
        problems += [f"{solved_path.name}: {p}" for p in solved_problems(_read(solved_path))]
    return problems


def source_problems(notebook: NotebookNode) -> Iterator[str]:
    """What is wrong with a lesson's source, one sentence each."""
    titles = [t for cell in _markdown(notebook) for t in _headings(cell.source) if t[0] == 1]
    if len(titles) != 1:
        yield f"{len(titles)} H1 headings; a lesson has one"
    for cell in _markdown(notebook):
        yield from image_problems(cell.source)
    for cell in notebook.cells:
        about = cell.metadata.get("robocon", {})
        yield from _mark_problems(cell, about)
        for role in ("exercise", "check", "answer"):
            if role in about:
                yield from _exercise_problems(about[role])
    asked = [c.metadata.robocon.exercise for c in notebook.cells if _role(c, "exercise")]
    judged = [c.metadata.robocon.check for c in notebook.cells if _role(c, "check")]
    if asked != judged:
        yield f"exercises {asked} and checks {judged} do not match one to one, in order"


def solved_problems(notebook: NotebookNode) -> Iterator[str]:
    """What is wrong with an executed lesson: verdicts, errors, figures without text."""
    for cell in notebook.cells:
        if cell.cell_type != "code":
            continue
        wanted = cell.metadata.get("robocon", {})
        exercise_id = wanted.get("check") or wanted.get("answer")
        text = "".join(output_text(output) for output in cell.outputs)
        if exercise_id and f"✔ passed: {exercise_id}" not in text:
            yield f"{exercise_id} is not passed in the executed lesson"
        if exercise_id and not _full_points(exercise_id, text):
            yield f"{exercise_id} does not earn its full points in the executed lesson"
        for output in cell.outputs:
            if output.output_type == "error":
                yield f"a cell raises {output.ename}: {cell.source.splitlines()[0]!r}"
        yield from figure_problems(cell)


def figure_problems(cell: NotebookNode) -> Iterator[str]:
    """Figures of an executed cell that lack their text twin or alt text."""
    printed = "".join(o.text for o in cell.outputs if o.output_type == "stream")
    for output in cell.outputs:
        if "image/png" not in output.get("data", {}):
            continue
        alt = output.get("metadata", {}).get("image/png", {}).get("alt", "")
        first = cell.source.splitlines()[0] if cell.source else ""
        if not alt.strip():
            yield f"a figure without alt text in the cell {first!r}; use show(figure, twin)"
        elif alt not in printed and alt not in output.data.get("text/plain", ""):
            yield f"a figure without its text twin in the cell {first!r}"


def image_problems(markdown: str) -> Iterator[str]:
    """Images of a markdown text that lack alt text."""
    for alt, target in re.findall(r"!\[([^\]]*)\]\(([^)]*)\)", markdown):
        if not alt.strip():
            yield f"image without alt text: {target}"
    for tag in re.findall(r"<img\b[^>]*>", markdown):
        if not re.search(r'\balt\s*=\s*"[^"]+"', tag):
            yield f"image without alt text: {tag}"


def output_text(output: NotebookNode) -> str:
    """The text of an output: what was printed, or the plain form of what was displayed."""
    if output.output_type == "stream":
        return output.text
    return output.get("data", {}).get("text/plain", "")


def _mark(cell: NotebookNode, taken: set[str], path: Path) -> None:
    """Turn a cell header's names into metadata, and give the cell a fixed id."""
    roles = {r: cell.metadata.pop(r) for r in ("exercise", "check", "answer") if r in cell.metadata}
    cell.metadata.pop("lines_to_next_cell", None)
    if roles:
        role, exercise_id = next(iter(roles.items()))
        cell.metadata["robocon"] = nbformat.from_dict(roles)
        cell.metadata["nbgrader"] = nbformat.from_dict(_nbgrader(role, exercise_id))
        name = f"{role}-{exercise_id}".replace(".", "-")
    else:
        name = hashlib.sha256(f"{cell.cell_type}{cell.source}".encode()).hexdigest()[:8]
    tags = [*cell.metadata.get("tags", []), *_tags(cell, roles)]
    if tags:
        cell.metadata["tags"] = tags
    while name in taken:
        name += "x"
    taken.add(name)
    cell["id"] = name[:64]
    if cell.cell_type == "code":
        cell.outputs, cell.execution_count = [], None


def _tags(cell: NotebookNode, roles: dict[str, str]) -> list[str]:
    """What nbval and Run All should know of a cell."""
    if "exercise" in roles:
        return ["raises-exception"]  # a syntax error in an answer must not stop Run All
    figure = cell.cell_type == "code" and re.search(r"^show\(", cell.source, re.MULTILINE)
    # Verdicts and the text twins of figures are what a run is compared by.
    return ["nbval-check-output"] if roles or figure else []


def _nbgrader(role: str, exercise_id: str) -> dict[str, Any]:
    """nbgrader's metadata, schema 3: an answer cell, or a locked cell with points."""
    grade_id = f"{role}-{exercise_id}".replace(".", "-")
    data: dict[str, Any] = {
        "schema_version": 3,
        "grade_id": grade_id,
        "grade": role != "exercise",
        "solution": role != "check",
        "locked": role == "check",
        "task": False,
    }
    known = registry.exercises().get(exercise_id)
    if role != "exercise" and known:
        data["points"] = known.points
    if role in ("exercise", "check"):
        data["cell_type"] = "code"
    return data


def _strip(cell: NotebookNode) -> None:
    """Replace the solution of a cell by a stub; numbers get three dots."""
    from nbgrader.preprocessors import ClearSolutions

    about = cell.metadata.get("robocon", {})
    if "exercise" not in about and "answer" not in about:
        return
    stub = NUMBER_STUB if "answer" in about else STUB
    ClearSolutions(code_stub={"python": stub}).preprocess_cell(cell, {"language": "python"}, 0)
    cell.source = cell.source.rstrip()


def _mark_problems(cell: NotebookNode, about: dict[str, str]) -> Iterator[str]:
    first = cell.source.splitlines()[0] if cell.source else ""
    marks = re.findall(r"### (BEGIN|END) SOLUTION", cell.source)
    if marks != ["BEGIN", "END"] * (len(marks) // 2):
        yield f"unbalanced solution marks in the cell {first!r}"
    solves = "exercise" in about or "answer" in about
    if solves and not marks:
        yield f"no solution marks in the cell {first!r}"
    if marks and not solves:
        yield f"solution marks in a cell that names no exercise: {first!r}"
    if "exercise" in about and re.search(r"^### BEGIN SOLUTION", cell.source, re.MULTILINE):
        yield f"solution outside a function in the cell {first!r}; its stub would raise at the top"


def _exercise_problems(exercise_id: str) -> Iterator[str]:
    known = registry.exercises().get(exercise_id)
    if known is None:
        yield f"unknown exercise {exercise_id!r}"
    elif hasattr(known, "cases") and not list(known.cases(0, _any_numbers())):
        yield f"exercise {exercise_id} has no cases"


def _any_numbers() -> Any:
    from robocon_course.worlds import generator

    return generator(0, "build")


def _full_points(exercise_id: str, text: str) -> bool:
    points = registry.exercise(exercise_id).points
    return f"{exercise_id}, {points:g} of {points:g} points" in text


def _drift(wanted: NotebookNode, path: Path) -> list[str]:
    """Where a notebook file differs from what its source says."""
    if not path.is_file():
        return [f"{path.name} is missing in {path.parent.name}/; run: robocon build"]
    found, where = _read(path), f"{path.parent.name}/{path.name}"
    if len(found.cells) != len(wanted.cells):
        return [f"{where} has {len(found.cells)} cells, its source {len(wanted.cells)}"]
    problems = [] if found.metadata == wanted.metadata else [f"{where}: other notebook metadata"]
    for number, (cell, source) in enumerate(zip(found.cells, wanted.cells, strict=True), 1):
        for key in ("cell_type", "id", "source", "metadata"):
            if cell.get(key) != source.get(key):
                problems.append(f"{where}: cell {number} has another {key.replace('_', ' ')}")
    return problems


def _read(path: Path) -> NotebookNode:
    try:
        return nbformat.read(path, as_version=4)
    except Exception as error:
        raise LessonError(f"{path.name} cannot be read: {error}") from None


def _markdown(notebook: NotebookNode) -> list[NotebookNode]:
    return [cell for cell in notebook.cells if cell.cell_type == "markdown"]


def _headings(markdown: str) -> list[tuple[int, str]]:
    text = re.sub(r"```.*?```", "", markdown, flags=re.DOTALL)
    return [
        (len(marks), title) for marks, title in re.findall(r"^(#+)\s+(.+)$", text, re.MULTILINE)
    ]


def _role(cell: NotebookNode, role: str) -> bool:
    return role in cell.metadata.get("robocon", {})
