"""The wheel is enough: lessons and data travel in it, and nothing of the people who built it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import venv
import zipfile
from pathlib import Path

import pytest

from conftest import ROOT, missing
from robocon_course.exercises import registry

LITTER = (
    "notebooks/my_robot/imu.py",
    "notebooks/my_robot/record.json",
    "notebooks/01_imu.kept-1.ipynb",
    "notebooks/.ipynb_checkpoints/01_imu-checkpoint.ipynb",
    "data/imu/__pycache__/make.cpython-311.pyc",
)


@pytest.fixture(scope="module")
def python(tmp_path_factory) -> Path:
    """The Python of an environment with nothing in it."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=True)
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


@pytest.fixture(scope="module")
def wheel(python, tmp_path_factory) -> Path:
    """The wheel of this checkout, built after a student has worked in it."""
    checkout, out = tmp_path_factory.mktemp("checkout"), tmp_path_factory.mktemp("dist")
    for path in ROOT.iterdir():
        if path.is_dir() and not path.name.startswith("."):
            shutil.copytree(path, checkout / path.name)
        elif path.is_file():
            shutil.copy(path, checkout)
    for name in LITTER:
        (checkout / name).parent.mkdir(parents=True, exist_ok=True)
        (checkout / name).write_text("{}")
    pip(python, "wheel", "--no-deps", "--wheel-dir", str(out), str(checkout))
    return next(out.glob("*.whl"))


@pytest.fixture(scope="module")
def workspace(python, wheel, tmp_path_factory) -> Path:
    """A workspace made by the installed wheel, far from the checkout."""
    pip(python, "install", "--no-compile", str(wheel))
    folder = tmp_path_factory.mktemp("elsewhere")
    # What `robocon lab` does before it starts the server.
    run(python, folder, "-c", "from robocon_course import desk; desk.prepare()")
    return folder / "robocon"


def pip(python: Path, *arguments: str) -> None:
    """Run pip; where it finds no packages (offline, for instance) there is nothing to test."""
    command = [python, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    if "No matching distribution" in done.stderr:
        missing(f"pip finds no packages to install: {done.stderr.strip().splitlines()[-1]}")
    assert done.returncode == 0, done.stderr


def run(python: Path, folder: Path, *arguments: str) -> str:
    """Run the environment's Python in a folder, with nobody's path and Jupyter settings."""
    mine = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "ROBOCON_WORKSPACE")}
    jupyter = dict.fromkeys(("JUPYTER_DATA_DIR", "JUPYTER_CONFIG_DIR"), str(folder / "jupyter"))
    done = subprocess.run(
        [python, *arguments], cwd=folder, env=mine | jupyter, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def execute(python: Path, notebook: Path) -> str:
    """Run a notebook from top to bottom where it lies; what it showed, as text."""
    command = ["-m", "nbconvert", "--to", "notebook", "--execute", "--inplace", notebook.name]
    run(python, notebook.parent, *command)
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output["output_type"] == "error"]
    texts = [o.get("data", {}).get("text/plain", o.get("text", [])) for o in outputs]
    return "\n".join("".join(text) for text in texts)


def test_the_wheel_holds_lessons_data_and_types(wheel):
    names = {name.removeprefix("robocon_course/") for name in zipfile.ZipFile(wheel).namelist()}
    lessons = {f"_lessons/{path.stem}.ipynb" for path in ROOT.glob("solutions/[0-9][0-9]_*.py")}
    data = {f"_data/imu/{path.name}" for path in ROOT.glob("data/imu/*.csv")}
    assert lessons and data
    assert lessons | data | {"py.typed", "jupyter/overrides.json"} <= names


def test_the_wheel_holds_nothing_of_a_student_and_no_tests(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0] for name in names if ".dist-info/" not in name} == {"robocon_course"}
    tests = "/tests/", "/test_", "conftest"
    for part in ("my_robot", ".kept-", ".ipynb_checkpoints", "__pycache__", "solutions", *tests):
        assert not [name for name in names if part in name], part


def test_the_installed_wheel_is_what_runs(python, workspace):
    where = run(python, workspace, "-c", "import robocon_course; print(robocon_course.__file__)")
    assert Path(where.strip()).is_relative_to(python.parents[1])


def test_an_untouched_chapter_runs_from_the_wheel_in_another_folder(python, workspace):
    shown = execute(python, workspace / "01_imu.ipynb")
    assert shown.count("– not attempted: imu.") == len(registry.chapter("imu").exercises)


def test_a_solved_chapter_earns_all_its_points_there(python, workspace):
    shutil.copy(ROOT / "solutions" / "01_imu.ipynb", workspace / "01_imu.ipynb")
    execute(python, workspace / "01_imu.ipynb")
    record = json.loads((workspace / "my_robot" / "record.json").read_text(encoding="utf-8"))
    assert sum(record["points"].values()) == registry.chapter("imu").points
    assert "def mahony_step" in (workspace / "my_robot" / "imu.py").read_text(encoding="utf-8")


def test_the_command_reports_the_points(python, workspace):
    said = run(python, workspace, "-m", "robocon_course.cli", "status")
    points = registry.chapter("imu").points
    assert f"{points:g} of {points:g} points" in said
