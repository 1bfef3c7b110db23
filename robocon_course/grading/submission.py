"""A submission: what a student handed in, read from files and never executed here.

Work is found by function name, not by cell: extra, split, moved or copied cells do not matter.
"""

from __future__ import annotations

import ast
import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robocon_course._arrays import CourseError
from robocon_course.exercises import registry
from robocon_course.exercises.model import Chapter, Exercise
from robocon_course.exercises.source import from_cells, plain_code

SIZE_LIMIT = 20 << 20  # bytes; a notebook with every figure in it stays below 3 MB
COMPUTED = object()


class SubmissionError(CourseError):
    """This submission cannot be read; the message is the reason its row shows."""


@dataclass(frozen=True)
class Submission:
    """Code cells of one student, all notebooks of a folder together."""

    path: Path
    cells: tuple[str, ...]
    student: int

    @property
    def chapters(self) -> tuple[Chapter, ...]:
        """Chapters that the cells work on."""
        text, defined = "\n".join(self.cells), from_cells(self.cells)
        return tuple(
            about
            for about in registry.chapters()
            if re.search(rf"""(begin|check|answer)\(\s*["']{about.topic}["'.]""", text)
            or any(defined(e.function_name) for e in about.exercises if isinstance(e, Exercise))
        )

    @property
    def numbers(self) -> dict[str, Any]:
        """Numbers handed in with ``answer``: plain ones as they are, others as COMPUTED."""
        found: dict[str, Any] = {}
        for cell in self.cells:
            found |= dict(_answers(cell))
        return found


def find_submissions(folder: Path) -> list[Path]:
    """Every notebook and every folder directly under ``folder``, in order."""
    return sorted(
        path
        for path in folder.iterdir()
        if not path.name.startswith(".")
        and (path.suffix == ".ipynb" or path.is_dir())
        and path.name != "my_robot"
    )


def read_submission(path: Path) -> Submission:
    """Read one notebook, or all notebooks of a folder.

    Raises
    ------
    SubmissionError
        Not a notebook, too large, a link, or a folder without notebooks.
    """
    if path.is_symlink():
        raise SubmissionError("a link, not a file; hand in the file itself")
    if path.is_dir():
        notebooks = sorted(p for p in path.rglob("*.ipynb") if ".ipynb_checkpoints" not in p.parts)
        if not notebooks:
            raise SubmissionError("the folder holds no notebook (.ipynb)")
        cells = [cell for notebook in notebooks for cell in _cells(notebook)]
    else:
        cells = _cells(path)
    return Submission(path, tuple(cells), _student(path, cells))


def _cells(path: Path) -> list[str]:
    """Code cells of a notebook file, magics removed."""
    if path.is_symlink():
        raise SubmissionError(f"{path.name} is a link, not a file")
    if not path.is_file():
        raise SubmissionError(f"{path.name} is not a file")
    if path.stat().st_size > SIZE_LIMIT:
        raise SubmissionError(
            f"{path.name} is larger than {SIZE_LIMIT >> 20} MB; clear its outputs"
        )
    try:
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        sources = [c["source"] for c in cells if c["cell_type"] == "code"]
        return [plain_code(s if isinstance(s, str) else "".join(s)) for s in sources]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        kind = type(error).__name__
        raise SubmissionError(f"{path.name} is not a notebook of format 4 ({kind})") from None


def _student(path: Path, cells: list[str]) -> int:
    """The student number: from ``begin``, from my_robot/, else 0."""
    for cell in cells:
        for node in _calls(cell, "begin"):
            given = [k.value for k in node.keywords if k.arg == "student"] + node.args[1:2]
            if given and isinstance(given[0], ast.Constant) and isinstance(given[0].value, int):
                return given[0].value
    folder = path if path.is_dir() else path.parent
    try:
        record = json.loads((folder / "my_robot" / "record.json").read_text(encoding="utf-8"))
        return int(record["student"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0


def _answers(cell: str) -> list[tuple[str, Any]]:
    """Ids and values of the ``answer`` calls of a cell."""
    found = []
    for node in _calls(cell, "answer"):
        values = node.args[1:2] + [k.value for k in node.keywords if k.arg == "value"]
        if not node.args or not isinstance(node.args[0], ast.Constant) or not values:
            continue
        try:
            found.append((node.args[0].value, ast.literal_eval(values[0])))
        except (ValueError, TypeError, MemoryError, RecursionError):
            found.append((node.args[0].value, COMPUTED))
    return found


def _calls(cell: str, name: str) -> list[ast.Call]:
    try:
        tree = ast.parse(cell)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return []
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
    ]
