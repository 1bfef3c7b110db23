"""Submissions of strangers: whatever comes gets its row, and costs no other its points."""

from __future__ import annotations

import csv
import json
import os
import sys
from pathlib import Path

import nbformat
import pytest

from conftest import ROOT
from robocon_course import lessons
from robocon_course.exercises import registry
from robocon_course.exercises.model import Outcome
from robocon_course.grading import submission as submissions
from robocon_course.grading.batch import grade_all, grade_one, write_csv
from robocon_course.grading.submission import find_submissions, read_submission

HEAD = """import math
import numpy as np
from robocon_course import geometry, imu
from robocon_course.exercises import *
"""
RIGHT = "def wrap_angle(angle):\n    return (angle + math.pi) % (2 * math.pi) - math.pi"
CHECK = "wrap_angle = check('start.wrap_angle')"


def write(path: Path, *cells: str) -> Path:
    """A notebook file with these code cells."""
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(c) for c in cells])
    path.write_text(json.dumps(notebook), encoding="utf-8")
    return path


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Where submissions lie; nothing is written into a student's own workspace."""
    monkeypatch.setenv("ROBOCON_WORKSPACE", str(tmp_path / "workspace"))
    (tmp_path / "in").mkdir()
    return tmp_path / "in"


@pytest.fixture
def row_of(folder):
    """Grade one notebook of these cells."""

    def graded(*cells: str, **settings):
        return grade_one(write(folder / "one.ipynb", HEAD, *cells), **settings)

    return graded


# --- code that is hostile, or only careless ---------------------------------------------------

FULL = {
    "as it should be": [RIGHT, CHECK],
    "no check cell": [RIGHT],
    "checks deleted, cells moved": [CHECK, RIGHT],
    "the same cell twice": [RIGHT, RIGHT, CHECK, CHECK],
    "the last of two definitions counts": ["def wrap_angle(angle):\n    return angle", RIGHT],
    "a syntax error in another cell": ["def x(:", RIGHT],
    "a cell that raises": ["1 / 0", RIGHT],
    "a cell that leaves": ["import sys\nsys.exit(1)", RIGHT],
    "a cell that never ends": ["while True: pass", RIGHT],
    "a cell that awaits": ["import asyncio\nawait asyncio.sleep(0)\n" + RIGHT],
    "a cell with ten thousand signs": ["x = " + "-" * 50_000 + "1", RIGHT],
    "a cell with ten thousand brackets": ["x = " + "(" * 10_000 + ")" * 10_000, RIGHT],
    "a cell with ten thousand terms": ["x = " + "+".join("1" * 20_000), RIGHT],
    "an answer with ten thousand signs": ["answer('imu.x', " + "-" * 50_000 + "1)", RIGHT],
    "a null byte": ["x = 1\0", RIGHT],
    "half a letter": ["x = '\ud800'", RIGHT],
    "magics": ["%matplotlib inline\n!rm -rf /nothing\n" + RIGHT, "%%bash\nexit 1"],
    "it prints without end": [RIGHT.replace("    return", "    print('x' * 10**6)\n    return")],
    "with a decorator": ["from functools import cache", "@cache\n" + RIGHT],
    "a helper and a constant": [
        "TURN = 2 * math.pi\ndef shift(angle):\n    return angle + TURN / 2",
        "def wrap_angle(angle):\n    return shift(angle) % TURN - TURN / 2",
    ],
    "it changes the course's judge": [
        "import robocon_course.exercises.judge as judge\njudge.judge = None",
        RIGHT,
    ],
}


def test_an_answer_that_reaches_for_the_judge_is_told_so(row_of):
    reach = "    import robocon_course.exercises.judge as j\n    j.difference = None\n    return"
    at_the_top = "from robocon_course.exercises.start import CHAPTER\n"
    by_name = RIGHT.replace("    return", "    CHAPTER\n    return")
    for cell in (RIGHT.replace("    return", reach), at_the_top + by_name):
        row = row_of(cell)
        [verdict] = [v for v in row.verdicts if v.id == "start.wrap_angle"]
        assert verdict.points == 0
        assert "This calls the course's own robocon_course.exercises" in verdict.message


@pytest.mark.parametrize("cells", FULL.values(), ids=FULL)
def test_a_right_answer_counts_whatever_stands_around_it(row_of, cells):
    row = row_of(*cells, time_limit=20.0)
    assert row.reason == ""
    assert {v.id: v.points for v in row.verdicts}["start.wrap_angle"] == 1


def body(text: str) -> str:
    """The function with another body."""
    return "def wrap_angle(angle):\n    " + text.replace("\n", "\n    ")


NOTHING = {
    "an endless loop": (body("while True: pass"), "! error", "stopped after 2 s"),
    "a loop that swallows every exception": (
        body("while True:\n    try:\n        while True: pass\n    except BaseException: pass"),
        "! error",
        "stopped after 2 s",
    ),
    "it ends its process": (body("import os\nos._exit(0)"), "! error", "process"),
    "it leaves": (body("raise SystemExit"), "! error", "SystemExit"),
    "it fills the memory": (body("return bytearray(10**11)"), "! error", "MemoryError"),
    "it calls itself without end": (body("return wrap_angle(angle)"), "! error", "Recursion"),
    "a result equal to everything": (
        body("class Sly:\n    def __eq__(self, other): return True\nreturn Sly()"),
        "✘ wrong",
        "an object of type Sly",
    ),
    "a float equal to everything": (
        body("class Sly(float):\n    def __eq__(self, o): return True\nreturn Sly(99)"),
        "✘ wrong",
        "got 99 rad",
    ),
    "an array that says it is close": (
        body("class Sly(np.ndarray):\n    def __array_ufunc__(self, *a, **k): return True\n"
             "return np.zeros(()).view(Sly)"),
        "✘ wrong",
        "",
    ),
    "a number larger than any float": (body("return 10**400"), "✘ wrong", "too large"),
    "a list in itself": (body("a = []\na.append(a)\nreturn a"), "", ""),
    "the course's own": (body("return geometry.wrap_angle(angle)"), "✘ wrong", "course's own"),
    "the exercise's reference": (
        body("from robocon_course.exercises import registry\n"
             "return registry.exercise('start.wrap_angle').reference(angle)"),
        "✘ wrong",
        "course's own",
    ),
    "the untouched stub": (body("raise NotImplementedError"), "– not attempted", ""),
    "a stray variable": (body("return angle - turn"), "! error", "uses turn"),
    "a syntax error": ("def wrap_angle(angle)\n    return 0", "! error", "SyntaxError in line 1"),
    "an error that only compiling finds": (body("break"), "! error", "SyntaxError in line 2"),
    "too deep to compile": (body("return " + "-" * 50_000 + "1"), "! error", "cannot be read"),
    "a known mistake": (body("return angle % (2 * math.pi)"), "✘ wrong", "from 0 to 2π"),
    "a name and no function": ("wrap_angle = 3", "– not attempted", "no function wrap_angle"),
    "it raises while loading": ("WRAP = 1 / 0\n" + body("return WRAP"), "! error", "ZeroDivision"),
    "it forges a reply": (
        body("import os\nfor k in range(3, 20):\n    try: os.write(k, b'{\"dict\": {}}\\n')\n"
             "    except OSError: pass\nreturn 0.0"),
        "",
        "",
    ),
}  # fmt: skip


@pytest.mark.parametrize("cell, sign, said", NOTHING.values(), ids=NOTHING)
def test_a_wrong_or_hostile_answer_gets_no_points_and_its_reason(row_of, cell, sign, said):
    row = row_of(cell, CHECK)
    assert row.reason == ""
    [verdict] = row.verdicts
    assert (row.points, row.out_of) == (0, 1)
    assert verdict.line.startswith(sign) and said in verdict.message


def alive(mark: str) -> list[str]:
    """Processes whose command line bears a mark."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            ended = (process / "stat").read_text().rpartition(")")[2].split()[0] == "Z"
            if mark in (process / "cmdline").read_text() and not ended:
                found.append(process.name)
        except OSError:
            continue
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="looks at processes in /proc")
def test_processes_that_an_answer_left_running_are_ended(row_of):
    mark = "61.0625"
    row = row_of(body(f"import subprocess\nsubprocess.Popen(['sleep', '{mark}'])\nreturn 0.0"))
    assert row.points == 0 and alive(mark) == []


def test_a_module_beside_the_notebook_is_not_taken_for_numpy(folder, monkeypatch):
    (folder / "numpy.py").write_text("raise SystemExit")
    (folder / "robocon_course.py").write_text("raise SystemExit")
    monkeypatch.chdir(folder)
    assert grade_one(write(folder / "one.ipynb", HEAD, RIGHT)).points == 1


def test_the_submissions_own_time_limit_ends_it(row_of):
    names = [e.function_name for e in registry.chapter("imu").exercises if hasattr(e, "cases")]
    loops = [f"def {name}(*args):\n    while True: pass" for name in names]
    row = row_of(*loops, time_limit=3.0)
    assert (row.points, row.reason) == (0, "") and row.seconds < 30
    said = [verdict.message for verdict in row.verdicts]
    assert any("stopped after" in text for text in said)
    assert "The time for the whole submission was used up." in said


# --- numbers ----------------------------------------------------------------------------------

TRUTH = registry.exercise("imu.own_bias").truth


def number_verdict(row):
    """The verdict on the own bias."""
    return {v.id: v for v in row.verdicts}["imu.own_bias"]


@pytest.mark.parametrize(
    "cells, outcome",
    [
        ([f"answer('imu.own_bias', {TRUTH(7)})"], Outcome.PASSED),
        ([f"answer('imu.own_bias', value={TRUTH(7)})"], Outcome.PASSED),
        ([f"answer('imu.own_bias', {TRUTH(7)} * 1)"], Outcome.PASSED),
        ([f"b = {TRUTH(7)}", "1 / 0", "answer('imu.own_bias', b)"], Outcome.PASSED),
        ([f"b = {TRUTH(7)}", "raise SystemExit", "answer('imu.own_bias', b)"], Outcome.PASSED),
        ([f"answer('imu.own_bias', {TRUTH(8)})"], Outcome.WRONG),
        (["answer('imu.own_bias', 0.0)", f"answer('imu.own_bias', {TRUTH(7)})"], Outcome.PASSED),
        (["answer('imu.own_bias', ...)"], Outcome.NOT_ATTEMPTED),
        (["answer('imu.own_bias', nowhere)"], Outcome.ERROR),
        (["while True: pass", "answer('imu.own_bias', 1 + 1)"], Outcome.ERROR),
        (["answer('imu.own_bias', 1" + "0" * 400 + ")"], Outcome.ERROR),
        (["answer('imu.own_bias', [1, 2])"], Outcome.ERROR),
        (["answer('imu.own_bias', float('nan'))"], Outcome.ERROR),
        (["answer('imu.own_bias')", "answer()", "answer([], 2)"], Outcome.NOT_ATTEMPTED),
    ],
)  # fmt: skip
def test_a_number_counts_as_it_did_in_the_notebook(row_of, cells, outcome):
    limit = 4.0 if "while True" in cells[0] else 30.0
    row = row_of("student = begin('imu', student=7)", *cells, time_limit=limit)
    assert row.reason == "" and row.student == 7
    assert number_verdict(row).outcome is outcome


def test_a_number_worked_out_with_a_part_that_was_not_accepted_uses_the_courses(row_of):
    cells = [
        "student = begin('imu', student=7)\nfrom robocon_course import worlds\n"
        "world = worlds.imu_world(student)",
        "def calibrate_gyro(still):\n    raise NotImplementedError",
        "calibrate_gyro = check('imu.calibrate_gyro')",
        "answer('imu.own_bias', float(np.degrees(calibrate_gyro(world.still).bias[2])))",
    ]
    row = row_of(*cells)
    assert number_verdict(row).accepted and row.points == 1


def test_an_answer_that_uses_a_part_that_was_not_accepted_gets_the_courses(row_of):
    source = lessons.read_source(ROOT / "solutions" / "01_imu.py")
    cells = [
        "from robocon_course import imu\nstudent = begin('imu', student=7)",
        "def gravity_direction(quaternion):\n    return np.zeros(3)",
        "gravity_direction = check('imu.gravity_direction')",
        next(cell.source for cell in source.cells if "def mahony_step" in cell.source),
        "mahony_step = check('imu.mahony_step')",
    ]
    verdicts = {v.id: v for v in row_of(*cells).verdicts}
    assert not verdicts["imu.gravity_direction"].accepted
    assert verdicts["imu.mahony_step"].accepted, verdicts["imu.mahony_step"].message


# --- whose it is ------------------------------------------------------------------------------


def student_of(path: Path) -> int:
    """The student number that a submission is judged with."""
    return read_submission(path).student


def test_the_student_number_is_found_in_the_name_in_begin_or_in_the_record(folder):
    assert student_of(write(folder / "21306141022.ipynb", "begin('imu', student=5)")) == 21306141022
    assert student_of(write(folder / "ann.ipynb", "begin('imu', student=5)")) == 5
    assert student_of(write(folder / "ben.ipynb", "begin('imu', 6)")) == 6
    assert student_of(write(folder / "cy.ipynb", "begin('imu', student=me)")) == 0
    (folder / "dee" / "my_robot").mkdir(parents=True)
    (folder / "dee" / "my_robot" / "record.json").write_text('{"student": 8}')
    write(folder / "dee" / "01_imu.ipynb", "begin('imu')")
    assert student_of(folder / "dee") == 8


@pytest.mark.parametrize(
    "record", ["", "[]", "{}", '{"student": "not me"}', '{"student": null}', "ÿ"]
)
def test_a_damaged_record_means_the_example_student(folder, record):
    (folder / "my_robot").mkdir()
    (folder / "my_robot" / "record.json").write_text(record, encoding="latin-1")
    assert student_of(write(folder / "ann.ipynb", "begin('imu')")) == 0


# --- files that are no submissions ------------------------------------------------------------

V3 = {"nbformat": 3, "metadata": {}, "worksheets": [{"cells": []}]}
UNREADABLE = {
    "empty": (b"", "not a notebook of format 4"),
    "an empty object": (b"{}", "not a notebook of format 4 (KeyError)"),
    "a list": (b"[]", "not a notebook of format 4"),
    "not JSON": (b"hello", "not a notebook of format 4"),
    "cut off": (b'{"cells": [{"cell_type": "code", "source": "x', "not a notebook of format 4"),
    "not UTF-8": (b'{"cells": "\xff"}', "not a notebook of format 4 (UnicodeDecodeError)"),
    "UTF-16": ("{}".encode("utf-16"), "not a notebook of format 4"),
    "format 3": (json.dumps(V3).encode(), "not a notebook of format 4"),
    "cells that are no cells": (b'{"cells": [1, 2]}', "not a notebook of format 4"),
    "cells without source": (b'{"cells": [{"cell_type": "code"}]}', "not a notebook of format 4"),
    "a source of numbers": (
        b'{"cells": [{"cell_type": "code", "source": [1]}]}',
        "not a notebook of format 4",
    ),
    "a hundred thousand brackets": (b"[" * 100_000, "not a notebook of format 4"),
    "no cells": (b'{"cells": []}', "no exercise of the course was found"),
    "another course's": (
        b'{"cells": [{"cell_type": "code", "source": "x = 1"}]}',
        "no exercise of the course was found",
    ),
}


@pytest.mark.parametrize("content, reason", UNREADABLE.values(), ids=UNREADABLE)
def test_a_file_that_is_no_notebook_gets_a_row_with_the_reason(folder, content, reason):
    path = folder / "one.ipynb"
    path.write_bytes(content)
    row = grade_one(path)
    assert reason in row.reason
    assert (row.points, row.out_of, row.verdicts) == (0, 0, ())


def test_a_link_a_missing_file_and_an_empty_folder_get_rows_with_the_reason(folder, monkeypatch):
    write(folder / "real.ipynb", RIGHT)
    (folder / "link.ipynb").symlink_to(folder / "real.ipynb")
    (folder / "away.ipynb").symlink_to(folder / "nowhere.ipynb")
    (folder / "inside").mkdir()
    (folder / "inside" / "link.ipynb").symlink_to(folder / "real.ipynb")
    (folder.parent / "other").mkdir()
    write(folder.parent / "other" / "one.ipynb", RIGHT)
    (folder / "elsewhere").symlink_to(folder.parent / "other")
    (folder / "folder.ipynb").mkdir()
    (folder / "bare").mkdir()
    reasons = {path.name: grade_one(path).reason for path in find_submissions(folder)}
    assert reasons.pop("real.ipynb") == ""
    assert "a link" in reasons["link.ipynb"] and "a link" in reasons["away.ipynb"]
    assert "link.ipynb is a link" in reasons["inside"] and "a link" in reasons["elsewhere"]
    assert "no notebook" in reasons["bare"] and "no notebook" in reasons["folder.ipynb"]
    assert grade_one(folder / "gone.ipynb").reason
    monkeypatch.setattr(submissions, "SIZE_LIMIT", 10)
    assert "larger than" in grade_one(folder / "real.ipynb").reason


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_that_never_says_anything_holds_nobody_up(folder):
    os.mkfifo(folder / "pipe.ipynb")
    assert grade_one(folder / "pipe.ipynb").reason == "pipe.ipynb is not a file"


def test_a_folder_counts_as_one_submission_and_its_leftovers_do_not_count(folder):
    ann = folder / "ann"
    for kept in (".ipynb_checkpoints", "my_robot"):
        (ann / kept).mkdir(parents=True)
    wrong = "def wrap_angle(angle):\n    return angle"
    write(ann / "00_start.ipynb", HEAD, RIGHT, CHECK)
    write(ann / "00_start.kept-1.ipynb", HEAD, wrong, CHECK)
    write(ann / ".ipynb_checkpoints" / "99_start-checkpoint.ipynb", HEAD, wrong, CHECK)
    assert find_submissions(folder) == [ann]
    row = grade_one(ann)
    assert (row.points, row.out_of) == (1, 1)


def test_notebooks_of_one_folder_do_not_share_their_helpers(folder):
    ann = folder / "ann"
    ann.mkdir()
    helper = "def shift(angle):\n    return angle + math.pi"
    solution = "def wrap_angle(angle):\n    return shift(angle) % (2 * math.pi) - math.pi"
    write(ann / "00_start.ipynb", HEAD, helper, solution, CHECK)
    write(ann / "01_imu.ipynb", HEAD, helper.replace("math.pi", "1"), "begin('imu')")
    assert {v.id: v.points for v in grade_one(ann).verdicts}["start.wrap_angle"] == 1


def test_an_exercise_is_taken_from_the_notebook_that_checks_it(folder):
    ann = folder / "ann"
    ann.mkdir()
    write(ann / "00_start.ipynb", HEAD, RIGHT, CHECK)
    write(ann / "99_play.ipynb", HEAD, "def wrap_angle(angle):\n    return angle")
    assert grade_one(ann).points == 1


# --- the batch --------------------------------------------------------------------------------


@pytest.fixture
def batch(folder) -> list:
    """Two good submissions with bad ones before, between and after; graded side by side."""
    solved = ROOT / "solutions" / "00_start.ipynb"
    (folder / "a_broken.ipynb").write_text("{")
    write(folder / "b_good.ipynb", HEAD, RIGHT, CHECK)
    write(folder / "c_loop.ipynb", HEAD, body("while True: pass"), CHECK)
    write(folder / "d_exit.ipynb", HEAD, body("import os\nos._exit(0)"), CHECK)
    (folder / "e_empty").mkdir()
    (folder / "f_good.ipynb").write_bytes(solved.read_bytes())
    (folder / "g_link.ipynb").symlink_to(solved)
    write(folder / "h_half.ipynb", HEAD, body("return angle"), CHECK)
    (folder / "notes.txt").write_text("not a submission")
    (folder / ".hidden.ipynb").write_text("{")
    heard: list = []
    rows = grade_all(find_submissions(folder), jobs=3, on_row=heard.append)
    assert sorted(row.name for row in heard) == [row.name for row in rows]
    return rows


def test_bad_submissions_in_a_batch_cost_the_good_ones_nothing(batch, folder):
    assert [row.name[0] for row in batch] == list("abcdefgh")
    points = {row.name[0]: row.points for row in batch}
    assert points == dict.fromkeys("acdegh", 0) | {"b": 1, "f": 1}
    assert {row.name[0] for row in batch if row.reason} == set("aeg")


def test_the_table_has_a_row_for_each_and_a_column_for_every_exercise(batch, tmp_path):
    path = tmp_path / "points.csv"
    write_csv(batch, path)
    with path.open(newline="", encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    ids = list(registry.exercises())
    assert list(table[0]) == ["submission", "student", "points", "out_of", *ids, "reason"]
    assert [row["submission"] for row in table] == [row.name for row in batch]
    good, broken = table[1], table[0]
    assert (good["points"], good["out_of"], good["start.wrap_angle"]) == ("1", "1", "1")
    assert good["imu.mahony_step"] == "" and good["reason"] == ""
    assert broken["points"] == "0" and "not a notebook" in broken["reason"]
    assert [p.name for p in tmp_path.glob("*.new")] == []


@pytest.mark.skipif(sys.platform != "linux", reason="file names are bytes on Linux only")
def test_a_file_name_that_is_no_text_does_not_cost_the_table(folder, tmp_path):
    path = folder / os.fsdecode(b"\xff.ipynb")
    write(path, HEAD, RIGHT)
    write_csv(grade_all(find_submissions(folder)), tmp_path / "points.csv")
    assert "1,1" in (tmp_path / "points.csv").read_text(encoding="utf-8")


def test_grading_touches_neither_the_submission_nor_a_workspace(folder, tmp_path):
    path = write(folder / "one.ipynb", HEAD, "begin('start', 3)", RIGHT, CHECK)
    before = path.read_bytes()
    assert grade_one(path).points == 1
    assert path.read_bytes() == before and [p.name for p in folder.iterdir()] == ["one.ipynb"]
    assert not (tmp_path / "workspace").exists()


def test_a_file_that_was_not_handed_in_is_named(folder, tmp_path):
    cells = (HEAD, "def find_balls(images):\n    return []", "check('vision.find_balls')")
    write(folder / "amir.ipynb", *cells)
    write(folder / "budi.ipynb", *cells)
    (folder / "budi.onnx").write_bytes(b"no network, but a file")
    rows = grade_all(find_submissions(folder))
    assert [row.remark for row in rows] == ["ball.onnx was not handed in", ""]
    assert [row.reason for row in rows] == ["", ""], "both were judged"
    write_csv(rows, tmp_path / "t.csv")
    with (tmp_path / "t.csv").open(encoding="utf-8") as file:
        assert [line["reason"] for line in csv.DictReader(file)] == [row.remark for row in rows]
