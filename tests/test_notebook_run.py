"""pytest's own run of the lessons tells the truth, whatever lies beside them."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import ROOT

LESSON = ROOT / "solutions" / "00_start.ipynb"
VERDICT = "✔ passed: start.wrap_angle, 1 of 1 points"
RECORD = '{"student": 7, "log": true}'


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """A copy of one lesson as it is, three that lie, and what an earlier run left beside them."""
    folder = tmp_path_factory.mktemp("copy")
    (folder / "tests").mkdir()
    for name in ("conftest.py", "pyproject.toml", "tests/nbval.cfg"):
        shutil.copy(ROOT / name, folder / name)
    solutions = folder / "solutions"
    old = solutions / "my_robot" / "versions" / "start.wrap_angle" / "001.py"
    old.parent.mkdir(parents=True)
    old.write_text("def wrap_angle(angle):\n    return angle\n")
    (solutions / "my_robot" / "record.json").write_text(RECORD)
    text = LESSON.read_text(encoding="utf-8")
    for name, old_text, new_text in (
        ("as_it_is", "", ""),
        ("verdict_changed", VERDICT, VERDICT.replace("1 of", "2 of")),
        ("figure_changed", "12 m square", "13 m square"),
        ("answer_changed", "% (2 * math.pi) - math.pi", "% (2 * math.pi)"),
    ):
        assert old_text in text
        changed = text.replace(old_text, new_text) if old_text else text
        (solutions / f"{name}.ipynb").write_text(changed, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def failures(copy) -> dict[str, str]:
    """The cells that fail, by lesson; everything else has passed."""
    command = [sys.executable, "-m", "pytest", "solutions", "-rf", "--color=no"]
    done = subprocess.run(
        [*command, "-p", "no:cacheprovider"], cwd=copy, capture_output=True, text=True
    )
    assert done.returncode == 1, done.stdout
    found = re.findall(r"^FAILED solutions/(\w+)\.ipynb::(Cell \d+)", done.stdout, re.MULTILINE)
    assert f"{len(found)} failed" in done.stdout and "error" not in done.stdout.splitlines()[-1]
    return {lesson: cell for lesson, cell in found}


def test_a_lesson_passes_whatever_an_earlier_run_left_beside_it(failures):
    assert "as_it_is" not in failures


@pytest.mark.parametrize("lie", ["verdict_changed", "figure_changed", "answer_changed"])
def test_a_stored_output_that_is_not_what_the_cells_do_fails(failures, lie):
    assert lie in failures


def test_running_lessons_leaves_nothing_beside_them(copy, failures):
    robot = copy / "solutions" / "my_robot"
    files = {path.relative_to(robot).as_posix() for path in robot.rglob("*") if path.is_file()}
    assert files == {"record.json", "versions/start.wrap_angle/001.py"}
    assert (robot / "record.json").read_text() == RECORD
