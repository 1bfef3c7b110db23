"""A submission: what a student handed in, read from files and never executed here.

Work is found by function name, not by cell: extra, split, moved or copied cells do not matter.
"""

from __future__ import annotations

import ast
import json
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robocon_course._arrays import CourseError
from robocon_course.exercises import registry
from robocon_course.exercises.model import Chapter, Exercise
from robocon_course.exercises.source import Lookup, from_cells, plain_code
from robocon_course.worlds import student_number

SIZE_LIMIT = 20 << 20  # bytes; a notebook with every figure in it stays below 3 MB
LEAST_DIGITS = 4  # a shorter number in a name is a chapter or a counter, not a student
COMPUTED = object()


class SubmissionError(CourseError):
    """This submission cannot be read; the message is the reason its row shows."""


@dataclass(frozen=True)
class Submission:
    """Code cells of one student, notebook by notebook."""

    path: Path
    notebooks: tuple[tuple[str, ...], ...]
    student: int | str

    @property
    def cells(self) -> tuple[str, ...]:
        """Code cells of all notebooks."""
        return tuple(cell for cells in self.notebooks for cell in cells)

    def lookup(self, exercise: Exercise) -> Lookup:
        """Where an exercise's function and its helpers are found: one notebook, never a mixture.

        The last one that defines the function; one that also checks it comes first.
        """
        defining = [c for c in self.notebooks if from_cells(c)(exercise.function_name)]
        checking = [c for c in defining if exercise.id in "\n".join(c)]
        return from_cells((checking or defining or [()])[-1])

    def file(self, exercise: Exercise) -> Path | None:
        """The file that an exercise asks for, None if it asks for none or there is none.

        In a folder it lies anywhere; beside a single notebook, ``amir.ipynb``, it may bear the
        notebook's name: ``amir.onnx``.
        """
        if not exercise.file:
            return None
        if self.path.is_dir():
            found = sorted(p for p in self.path.rglob(exercise.file) if _handed_in(p))
        else:
            own = self.path.with_suffix(Path(exercise.file).suffix)
            found = [p for p in (own, self.path.with_name(exercise.file)) if p.is_file()]
        return next(iter(found), None)

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
        notebooks = sorted(p for p in path.rglob("*.ipynb") if _handed_in(p))
        if not notebooks:
            raise SubmissionError("the folder holds no notebook (.ipynb)")
    else:
        notebooks = [path]
    parsed = [_code_cells(notebook) for notebook in notebooks]
    cells = tuple(tuple(plain_code(_text(c["source"])) for c in part) for part in parsed)
    printed = [_printed(cell) for part in parsed for cell in part]
    return Submission(path, cells, _student(path, sum(cells, ()), printed))


def _handed_in(path: Path) -> bool:
    """Whether a notebook is meant: no checkpoint, and not set aside by ``robocon reset``."""
    return ".ipynb_checkpoints" not in path.parts and ".kept-" not in path.name


def _code_cells(path: Path) -> list[dict[str, Any]]:
    """Code cells of a notebook file, as they are."""
    try:
        cells = json.loads(_read(path))["cells"]
        found = [cell for cell in cells if cell["cell_type"] == "code"]
        for cell in found:
            _text(cell["source"])  # refuse here what could not be read later
        return found
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        kind = type(error).__name__
        raise SubmissionError(f"{path.name} is not a notebook of format 4 ({kind})") from None


def _read(path: Path) -> str:
    """Text of a file that was handed in: a real one, of a reasonable size."""
    if path.is_symlink():
        raise SubmissionError(f"{path.name} is a link, not a file")
    if not path.is_file():
        raise SubmissionError(f"{path.name} is not a file")
    if path.stat().st_size > SIZE_LIMIT:
        raise SubmissionError(
            f"{path.name} is larger than {SIZE_LIMIT >> 20} MB; clear its outputs"
        )
    return path.read_text(encoding="utf-8")


def _text(source: Any) -> str:
    """Text of a cell or an output; the format allows a list of lines."""
    return source if isinstance(source, str) else "".join(source)


def _printed(cell: dict[str, Any]) -> str:
    """What a cell printed when it was last run and saved."""
    try:
        streams = [o for o in cell.get("outputs", []) if o.get("output_type") == "stream"]
        return "".join(_text(stream["text"]) for stream in streams)
    except (AttributeError, KeyError, TypeError):
        return ""


def _student(path: Path, cells: tuple[str, ...], printed: list[str]) -> int | str:
    """The student number: a name that is a number, what ``begin`` was given, else what it said."""
    if path.stem.isdecimal() and len(path.stem) >= LEAST_DIGITS:
        return int(path.stem)
    calls = [node for cell in cells for node in _calls(cell, "begin")]
    given = [k.value for node in calls for k in node.keywords if k.arg == "student"]
    given += [argument for node in calls for argument in node.args[1:2]]
    found = [node.value for node in given if isinstance(node, ast.Constant)]
    record = (path if path.is_dir() else path.parent) / "my_robot" / "record.json"
    try:
        found.append(json.loads(_read(record))["student"])
    except (SubmissionError, OSError, ValueError, KeyError, TypeError, RecursionError):
        found += re.findall(r"^Student number (\w{1,40})\.", "\n".join(printed), re.MULTILINE)
    for number in found:
        with suppress(ValueError):
            return student_number(number)
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
