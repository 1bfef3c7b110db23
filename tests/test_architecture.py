"""The house: imports run downwards only, importing is light, nothing names a machine."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT, missing
from robocon_course.exercises import registry

PACKAGE = ROOT / "robocon_course"

# Ground floor first. A room imports from floors below its own, never from its own or above.
FLOORS = (
    ("_arrays", "files"),
    ("geometry",),
    ("gridmap", "drivetrain"),
    ("raycast",),
    ("field",),
    ("beams", "imu", "odometry", "swerve", "planning", "tracking", "vision", "mission"),
    ("robot",),
    ("simulator", "autopilot", "logs"),
    ("worlds",),
    ("view",),
    ("answers", "recordings"),
    ("exercises",),
    ("grading", "lessons"),
    ("desk", "doctor"),
    ("cli",),
)
FLOOR = {room: level for level, rooms in enumerate(FLOORS) for room in rooms}
FILES = {
    path: path.relative_to(PACKAGE).parts[0].removesuffix(".py") for path in PACKAGE.rglob("*.py")
}


def imported(text: str) -> set[str]:
    """Modules of the package that a text imports, in functions too, without the package's name."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module == "robocon_course":
            names = [f"robocon_course.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are written in full"
            names = [node.module]
        else:
            continue
        found |= {
            n.removeprefix("robocon_course.") for n in names if n.startswith("robocon_course.")
        }
    return found


def uphill(room: str, text: str) -> list[str]:
    """Imports of a room's file that do not run downwards."""
    rooms = {module.partition(".")[0] for module in imported(text)} - {room}
    return sorted(other for other in rooms if FLOOR[other] >= FLOOR[room])


def test_every_room_has_a_floor():
    assert set(FILES.values()) - {"__init__"} == set(FLOOR)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_run_downwards_only(path):
    room = FILES[path]
    text = path.read_text(encoding="utf-8")
    if room == "__init__":
        assert imported(text) == set(), "importing the package loads none of its rooms"
    else:
        assert uphill(room, text) == []


def test_an_import_that_runs_upwards_would_be_found():
    assert uphill("imu", "from robocon_course import view, geometry") == ["view"]
    assert uphill("view", "def f():\n    import robocon_course.exercises.judge") == ["exercises"]
    assert uphill("odometry", "from robocon_course.swerve import body_twist") == ["swerve"]


CHAPTERS = [about.topic for about in registry.chapters()]


@pytest.mark.parametrize("topic", CHAPTERS)
def test_chapters_do_not_import_each_other(topic):
    others = set(CHAPTERS) - {topic}
    for path in PACKAGE.rglob("*.py"):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        if topic in parts[:2]:
            modules = imported(path.read_text(encoding="utf-8"))
            rooms = {m.removeprefix("exercises.").partition(".")[0] for m in modules}
            assert not rooms & others, path


@pytest.mark.parametrize("topic", CHAPTERS)
def test_chapter_notebook_exercises_and_module_bear_one_name(topic):
    about = registry.chapter(topic)
    assert (ROOT / "solutions" / f"{about.name}.py").is_file()
    home = PACKAGE / "exercises" / topic
    assert home.is_dir() or home.with_suffix(".py").is_file()


HEAVY = {"torch", "matplotlib", "ipywidgets", "numba", "IPython", "scipy", "cv2", "nbgrader"}
DRAWING = {"torch", "matplotlib", "ipywidgets", "IPython", "jupytext", "nbgrader", "cv2"}


def loaded(module: str) -> set[str]:
    """Top-level names of everything that importing a module brings with it."""
    code = f"import sys, {module}; print(*{{n.partition('.')[0] for n in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, cwd=ROOT, check=True)
    return set(done.stdout.decode().split())


def test_importing_the_package_loads_nothing_heavy():
    assert not loaded("robocon_course") & (HEAVY | {"numpy"})


@pytest.mark.parametrize("module", ["exercises", "grading.batch", "cli", "lessons", "doctor"])
def test_importing_a_room_loads_no_drawing_and_no_training(module):
    assert not loaded(f"robocon_course.{module}") & DRAWING


def test_an_answers_process_starts_light():
    assert not loaded("robocon_course.answers.worker") & HEAVY


# --- the repository ---------------------------------------------------------------------------


def tracked() -> list[Path]:
    """Files of the repository, those not yet added too."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z"]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True)
    except OSError:
        missing("no git here to list the repository's files")
    if done.returncode:
        missing("this is no git checkout, so nothing lists the repository's files")
    names = done.stdout.decode().split("\0")
    return [ROOT / name for name in names if name and (ROOT / name).is_file()]


# Written so that this file does not find itself.
PLACES = [rf"[\s\"'(=]{top}/\w" for top in ("/root", "/home", "/mnt", "/Users")]
PLACES += [r"[A-Z]:\\\\?Users", "site" + "-packages/"]


def test_no_file_names_a_folder_of_somebodys_machine():
    rule = re.compile("|".join(PLACES), re.IGNORECASE)
    found = []
    for path in tracked():
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except UnicodeDecodeError:
            continue
        for number, line in enumerate(lines, 1):
            match = rule.search(line)
            if match and path != Path(__file__):
                found.append(f"{path.relative_to(ROOT)}:{number}: {match[0]}")
    assert found == []


@pytest.mark.parametrize("line", ["see /root/x", '"/home/ann/x"', "(/mnt/y", "C:\\Users\\x"])
def test_a_line_that_names_one_would_be_found(line):
    assert re.search("|".join(PLACES), line, re.IGNORECASE)


def test_the_repository_stays_small():
    sizes = {path: path.stat().st_size for path in tracked()}
    weights = {path for path in sizes if path.suffix == ".onnx"}
    assert sum(sizes.values()) < 60_000_000
    assert [p for p, size in sizes.items() if size > 3_000_000 and p not in weights] == []
    assert [p for p in weights if sizes[p] > 13_000_000] == [] and len(weights) <= 3
