"""``my_robot/``: the accepted answers of one student, every version kept.

::

    my_robot/imu.py                              the parts in use, one file per chapter
    my_robot/versions/imu.mahony_step/001.py     every accepted version
    my_robot/record.json                         student number, points, versions in use
    my_robot/attempts.jsonl                      the log of attempts, if the student wants one
"""

from __future__ import annotations

import ast
import importlib.util
import json
import os
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

from robocon_course._arrays import CourseError
from robocon_course.exercises.model import Verdict


class WorkspaceError(CourseError):
    """The workspace does not hold what was asked for; the message says what it holds."""


class Workspace:
    """The folder of one student's work; notebooks lie in it, ``my_robot/`` beside them.

    Parameters
    ----------
    folder : path, optional
        Default: environment variable ``ROBOCON_WORKSPACE``, else the current folder.
    """

    def __init__(self, folder: str | Path | None = None) -> None:
        self.folder = Path(folder or os.environ.get("ROBOCON_WORKSPACE") or Path.cwd())
        self.robot = self.folder / "my_robot"

    @property
    def record(self) -> dict[str, Any]:
        """Student number, points and versions; empty before the first check."""
        path = self.robot / "record.json"
        if not path.is_file():
            return {}
        try:
            return _checked(json.loads(path.read_text(encoding="utf-8")))
        except (ValueError, OSError):
            return self._mend(path)

    def _mend(self, path: Path) -> dict[str, Any]:
        """Set a damaged record aside and begin a new one with every part that was accepted."""
        names = (path.with_name(f"record.damaged-{count}.json") for count in range(1, 10_000))
        aside = next(name for name in names if not name.exists())
        os.replace(path, aside)
        accepted = sorted(p.name for p in (self.robot / "versions").glob("*.*") if p.is_dir())
        record = {"in_use": {name: len(self.versions(name)) for name in accepted}}
        self._write(path, json.dumps(record, indent=1) + "\n")
        warnings.warn(
            f"my_robot/record.json was damaged and is kept as {aside.name}. Your parts are back "
            "in use; points return when you check again. Give your student number again: begin.",
            stacklevel=4,
        )
        return record

    @property
    def student(self) -> int | str:
        """The student number in use; 0 until one is given."""
        return self.record.get("student", 0)

    def remember(self, **changes: Any) -> None:
        """Change entries of the record."""
        self._write(self.robot / "record.json", json.dumps(self.record | changes, indent=1) + "\n")

    def note(self, verdict: Verdict) -> None:
        """Keep the best points of an exercise; log the attempt only where a student wants it."""
        points = self.record.get("points", {})
        if verdict.points > points.get(verdict.id, 0.0):
            self.remember(points=points | {verdict.id: verdict.points})
        if self.record.get("log"):
            self._log(verdict)

    def _log(self, verdict: Verdict) -> None:
        """Add a line to the log of attempts; the attempt's number is counted in the log itself."""
        path = self.robot / "attempts.jsonl"
        before = path.read_text(encoding="utf-8") if path.is_file() else ""
        entry = {
            "id": verdict.id,
            "outcome": verdict.outcome.name.lower(),
            "mistake": verdict.mistake,
            "attempt": before.count(f'"id": "{verdict.id}"') + 1,
            "time": time.strftime("%Y-%m-%dT%H:%M:%S"),
        }
        with path.open("a", encoding="utf-8") as log:
            log.write(json.dumps(entry) + "\n")

    def accept(self, exercise_id: str, text: str) -> int:
        """Keep an accepted answer and put it in use; returns the number of its version."""
        versions = self.versions(exercise_id)
        if versions and versions[-1].read_text(encoding="utf-8") == text:
            number = len(versions)
        else:
            number = len(versions) + 1
            self._write(self._version(exercise_id, number), text)
        self.use(exercise_id, number)
        return number

    def versions(self, exercise_id: str) -> list[Path]:
        """Every accepted version of a part, oldest first."""
        return sorted((self.robot / "versions" / exercise_id).glob("[0-9]*.py"))

    def use(self, exercise_id: str, number: int) -> None:
        """Put an accepted version in use and write the chapter's file anew.

        Raises
        ------
        WorkspaceError
            There is no such version.
        """
        count = len(self.versions(exercise_id))
        if not 1 <= number <= count:
            kept = f"versions 1 to {count}" if count else "no accepted version"
            raise WorkspaceError(f"{exercise_id}: no version {number}; my_robot/ holds {kept}")
        self.remember(in_use=self.record.get("in_use", {}) | {exercise_id: number})
        self._write_chapter(exercise_id.partition(".")[0])

    def in_use(self, chapter: str | None = None) -> dict[str, int]:
        """Parts in use and their versions, of one chapter or of all."""
        used = self.record.get("in_use", {})
        return {k: v for k, v in used.items() if chapter in (None, k.partition(".")[0])}

    def part(self, exercise_id: str) -> Callable[..., Any]:
        """An accepted part as a function, loaded from the chapter's file.

        Raises
        ------
        WorkspaceError
            The part was not accepted yet, or its file was damaged.
        """
        chapter, _, name = exercise_id.partition(".")
        path = self.robot / f"{chapter}.py"
        if exercise_id not in self.in_use() or not path.is_file():
            raise WorkspaceError(f"{exercise_id}: not accepted yet; solve its exercise first")
        spec = importlib.util.spec_from_file_location(f"my_robot.{chapter}", path)
        module = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
        try:
            spec.loader.exec_module(module)
            return getattr(module, name)
        except Exception as error:
            raise WorkspaceError(
                f"{path.name} does not load ({type(error).__name__}: {error}); "
                f"bring the part back with: robocon reset --part {exercise_id}"
            ) from error

    def text_in_use(self, exercise_id: str) -> str:
        """Text of the version in use."""
        path = self._version(exercise_id, self.in_use()[exercise_id])
        return path.read_text(encoding="utf-8")

    def _version(self, exercise_id: str, number: int) -> Path:
        return self.robot / "versions" / exercise_id / f"{number:03d}.py"

    def _write_chapter(self, chapter: str) -> None:
        """One readable file per chapter; a helper or import that parts share stands once."""
        parts = {exercise_id.partition(".")[2]: exercise_id for exercise_id in self.in_use(chapter)}
        blocks: dict[str, None] = {}
        for exercise_id in parts.values():
            for block, name in _blocks(self.text_in_use(exercise_id)).items():
                # Where one part calls another, the other's own version in use is what it calls.
                if parts.get(name, exercise_id) == exercise_id:
                    blocks[block] = None
        imports = [b for b in blocks if b.startswith(("import ", "from "))]
        body = [b for b in blocks if b not in imports]
        used = ", ".join(f"{k} (version {v})" for k, v in self.in_use(chapter).items())
        head = (
            f'"""My robot, chapter {chapter}: {used}."""\n\nfrom __future__ import annotations\n\n'
        )
        text = head + "\n".join(imports) + "\n\n\n" + "\n\n\n".join(body) + "\n"
        self._write(self.robot / f"{chapter}.py", text)

    def clash(self, exercise_id: str, text: str) -> str:
        """Name of a helper that another part in use defines differently, empty if none.

        A helper that is a part itself is no clash: the part in use is what both call.
        """
        others = [k for k in self.in_use(exercise_id.partition(".")[0]) if k != exercise_id]
        parts = {"", *(k.partition(".")[2] for k in (exercise_id, *others))}
        new = {name: block for block, name in _blocks(text).items() if name not in parts}
        for other in others:
            for block, name in _blocks(self.text_in_use(other)).items():
                if new.get(name, block) != block:
                    return f"{name} (also used by {other})"
        return ""

    @staticmethod
    def _write(path: Path, text: str) -> None:
        """Write beside, then rename: an interrupted write loses nothing."""
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_name(path.name + ".new")
        beside.write_text(text, encoding="utf-8")
        os.replace(beside, path)


def _checked(record: Any) -> dict[str, Any]:
    """A record whose entries have the right form; anything else is damage."""
    forms = {"student": (int, str), "points": dict, "in_use": dict, "log": bool}
    if not isinstance(record, dict):
        raise ValueError("not a record")
    for name, form in forms.items():
        entry = record.get(name)
        whole = entry is None or isinstance(entry, form)
        if whole and isinstance(entry, dict):
            whole = all(isinstance(number, int | float) for number in entry.values())
        if not whole:
            raise ValueError(f"{name} is {entry!r}")
    return record


def _blocks(text: str) -> dict[str, str]:
    """Top-level statements of a version's text, and the name that each defines, if it does."""
    lines = text.splitlines()
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.ImportFrom) and node.module == "__future__":
            continue
        first = min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", []))])
        target = getattr(node, "target", next(iter(getattr(node, "targets", [])), None))
        block = "\n".join(lines[first - 1 : node.end_lineno])
        aliases = getattr(node, "names", [])
        imported = (aliases[0].asname or aliases[0].name) if len(aliases) == 1 else ""
        found[block] = getattr(node, "name", getattr(target, "id", imported))
    return found
