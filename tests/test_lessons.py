"""Every lesson, by discovery: in step with its source, solved 100 %, untouched 0 %, well formed."""

from __future__ import annotations

import ast
import copy
import json
import re
import shutil
from functools import cache
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient
from nbgrader.nbgraderformat.v3 import MetadataValidatorV3
from nbgrader.utils import determine_grade
from typer.testing import CliRunner

from conftest import ROOT
from robocon_course import cli, files, lessons
from robocon_course.exercises import registry
from robocon_course.exercises.model import Outcome
from robocon_course.grading.batch import grade_one

SOURCES = lessons.sources(ROOT / "solutions")
LESSONS = [path.stem for path in SOURCES]
STUDENT = {name: ROOT / "notebooks" / f"{name}.ipynb" for name in LESSONS}
SOLVED = {name: ROOT / "solutions" / f"{name}.ipynb" for name in LESSONS}
CODE_LINES = 15

by_lesson = pytest.mark.parametrize("name", LESSONS)


@pytest.fixture(autouse=True)
def workspace(tmp_path, monkeypatch) -> Path:
    """A workspace of the test's own, so that none writes into a student's."""
    monkeypatch.setenv("ROBOCON_WORKSPACE", str(tmp_path / "workspace"))
    return tmp_path / "workspace"


@cache
def read(path: Path):
    """A notebook file."""
    return nbformat.read(path, as_version=4)


def roles(notebook, role: str) -> list:
    """Cells of a notebook that bear a role: exercise, check or answer."""
    return [cell for cell in notebook.cells if role in cell.metadata.get("robocon", {})]


def executed(path: Path, needed=lambda cell: True, **settings):
    """A notebook's cells with the outputs of a fresh run."""
    notebook = copy.deepcopy(read(path))
    notebook.cells = [cell for cell in notebook.cells if needed(cell)]
    NotebookClient(notebook, timeout=120, kernel_name="python3", **settings).execute()
    return notebook


def graded_or_import(cell) -> bool:
    """Whether nbgrader's marks depend on a cell; the rest is run elsewhere."""
    return "nbgrader" in cell.metadata or "import " in cell.source


def errors(cell) -> list:
    """Exceptions in a cell's outputs."""
    return [o for o in cell.get("outputs", []) if o.output_type == "error"]


# --- in step ----------------------------------------------------------------------------------


def test_there_is_a_lesson_for_every_chapter():
    assert [about.name for about in registry.chapters()] == LESSONS


def test_build_check_finds_the_repository_in_step():
    done = CliRunner().invoke(cli.app, ["build", "--check"])
    assert (done.exit_code, "in step" in done.output) == (0, True), done.output


@by_lesson
def test_a_lesson_asks_for_every_exercise_of_its_chapter_once(name):
    notebook = read(SOLVED[name])
    asked = [c.metadata.robocon[r] for r in ("check", "answer") for c in roles(notebook, r)]
    assert sorted(asked) == sorted(e.id for e in registry.chapter(name).exercises)


@by_lesson
def test_the_solved_lesson_earns_exactly_all_points(name):
    row = grade_one(SOLVED[name])
    assert row.reason == ""
    assert row.points == row.out_of == registry.chapter(name).points


@by_lesson
def test_the_untouched_lesson_earns_exactly_nothing(name):
    row = grade_one(STUDENT[name])
    assert (row.reason, row.points, row.out_of) == ("", 0.0, registry.chapter(name).points)
    assert {verdict.outcome for verdict in row.verdicts} == {Outcome.NOT_ATTEMPTED}


@by_lesson
def test_the_untouched_lesson_runs_from_top_to_bottom(name, workspace):
    notebook = executed(STUDENT[name])
    assert not any(errors(cell) for cell in notebook.cells)
    said = "".join(lessons.output_text(o) for c in notebook.cells for o in c.get("outputs", []))
    for exercise in registry.chapter(name).exercises:
        assert f"– not attempted: {exercise.id}, 0 of {exercise.points:g} points" in said
    assert not (workspace / "my_robot").exists()  # nothing earned, nothing kept


# --- nbgrader ---------------------------------------------------------------------------------


@by_lesson
def test_nbgrader_finds_its_metadata_valid(name):
    for path in (STUDENT[name], SOLVED[name]):
        MetadataValidatorV3().validate_nb(copy.deepcopy(read(path)))


@by_lesson
def test_nbgrader_gives_an_untouched_lesson_no_points(name, monkeypatch):
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    notebook = executed(STUDENT[name], graded_or_import, allow_errors=True)
    graded = [cell for cell in notebook.cells if cell.metadata.get("nbgrader", {}).get("grade")]
    assert graded, "a lesson has points"
    for cell in graded:
        assert errors(cell)[0].ename == "AssertionError", cell.source
        assert determine_grade(cell)[0] == 0
    assert sum(determine_grade(c)[1] for c in graded) == registry.chapter(name).points


def test_nbgrader_gives_a_solved_check_its_points(monkeypatch):
    monkeypatch.setenv("NBGRADER_EXECUTION", "autograde")
    notebook = executed(SOLVED["00_start"], graded_or_import, allow_errors=True)
    assert [determine_grade(cell) for cell in roles(notebook, "check")] == [(1, 1)]


# --- well formed ------------------------------------------------------------------------------


@by_lesson
def test_a_generated_notebook_says_so_and_carries_no_outputs(name):
    notebook = read(STUDENT[name])
    nbformat.validate(notebook)
    assert f"generated, edit solutions/{name}.py" in notebook.metadata.robocon.generated
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in code)
    assert "SOLUTION" not in STUDENT[name].read_text(encoding="utf-8")


@by_lesson
def test_cell_ids_are_unique(name):
    ids = [cell.id for cell in read(STUDENT[name]).cells]
    assert len(set(ids)) == len(ids)


@by_lesson
def test_no_line_of_a_solution_stands_in_the_students_notebook(name):
    student = {c.id: c.source for c in read(STUDENT[name]).cells}
    for cell in roles(read(SOLVED[name]), "exercise") + roles(read(SOLVED[name]), "answer"):
        body = re.search(r"### BEGIN SOLUTION(.*)### END SOLUTION", cell.source, re.DOTALL)[1]
        lines = [line.strip() for line in body.splitlines() if line.strip()]
        assert lines and not any(line in student[cell.id] for line in lines)


@by_lesson
def test_a_stub_raises_only_inside_its_function(name):
    for cell in roles(read(STUDENT[name]), "exercise"):
        namespace: dict = {}
        exec(compile(cell.source, "<stub>", "exec"), namespace)
        function = cell.metadata.robocon.exercise.partition(".")[2]
        arguments = ast.parse(cell.source).body[0].args.args
        with pytest.raises(NotImplementedError, match="not solved yet"):
            namespace[function](*arguments)


@by_lesson
def test_a_stub_has_the_references_arguments_and_a_description(name):
    for cell in roles(read(STUDENT[name]), "exercise"):
        [function] = ast.parse(cell.source).body
        assert cell.metadata.robocon.exercise.endswith(f".{function.name}")
        text = ast.get_docstring(function)
        assert "returns" in text
        assert all(argument.arg in text for argument in function.args.args)


@by_lesson
def test_whoever_is_stuck_can_type_what_the_verdict_says(name):
    tree = ast.parse((ROOT / "solutions" / f"{name}.py").read_text("utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert "hint" in {one.name for node in imports for one in node.names}


@by_lesson
def test_a_code_cell_is_short_enough_to_read(name):
    for cell in read(SOLVED[name]).cells:
        if cell.cell_type == "code":
            without = re.sub(r'"""(.*?)"""', "", cell.source, flags=re.DOTALL)
            lines = [line for line in without.splitlines() if line.strip()]
            marks = sum(line.strip().startswith("###") for line in lines)
            assert len(lines) - marks <= CODE_LINES + 1, cell.source


@by_lesson
def test_no_cell_of_which_the_output_is_compared_says_what_depends_on_the_clock(name):
    for cell in read(SOLVED[name]).cells:
        if "nbval-check-output" in cell.metadata.get("tags", []):
            assert "warm_up()" not in cell.source, "it speaks where the first start is slow"


@by_lesson
def test_notebooks_stay_small(name):
    assert STUDENT[name].stat().st_size < 100_000
    assert SOLVED[name].stat().st_size < 3_000_000


# --- what `build --check` must find -----------------------------------------------------------

LESSON = """# %% [markdown]
# # A lesson

# %% exercise="start.wrap_angle"
def wrap_angle(angle):
    \"\"\"Wrap.\"\"\"
    ### BEGIN SOLUTION
    return angle
    ### END SOLUTION


# %% check="start.wrap_angle"
wrap_angle = check("start.wrap_angle")
"""


def problems_of(text: str, folder: Path) -> str:
    """Why a lesson's source is refused."""
    path = folder / "00_start.py"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(lessons.LessonError) as refusal:
        lessons.read_source(path)
    return str(refusal.value)


def test_a_small_lesson_is_well_formed(tmp_path):
    path = tmp_path / "00_start.py"
    path.write_text(LESSON, encoding="utf-8")
    source = lessons.read_source(path)
    assert [cell.cell_type for cell in source.cells] == ["markdown", "code", "code"]
    assert lessons.STUB.splitlines()[1] in lessons.student_notebook(source).cells[1].source


IMAGE = "# # A lesson\n#\n# "
FAULTS = {
    "an end mark is missing": ("    ### END SOLUTION\n", "", "unbalanced solution marks"),
    "a begin mark is missing": ("    ### BEGIN SOLUTION\n", "", "unbalanced solution marks"),
    "marks are swapped": (
        "### BEGIN SOLUTION\n    return angle\n    ### END SOLUTION",
        "### END SOLUTION\n    return angle\n    ### BEGIN SOLUTION",
        "unbalanced",
    ),
    "marks are nested": (
        "    return angle\n",
        "    ### BEGIN SOLUTION\n    return angle\n    ### END SOLUTION\n",
        "unbalanced",
    ),
    "no marks at all": (
        "    ### BEGIN SOLUTION\n    return angle\n    ### END SOLUTION\n",
        "    return angle\n",
        "no solution marks",
    ),
    "marks outside a function": (
        "    ### BEGIN SOLUTION\n    return angle\n    ### END SOLUTION\n",
        "    return angle\n### BEGIN SOLUTION\nx = 1\n### END SOLUTION\n",
        "outside a function",
    ),
    "marks in another cell": (
        'wrap_angle = check("start.wrap_angle")',
        "### BEGIN SOLUTION\nx = 1\n### END SOLUTION",
        "in a cell that names no exercise",
    ),
    "two H1": ("# # A lesson", "# # A lesson\n#\n# # Another", "2 H1"),
    "no H1": ("# # A lesson", "# ## A lesson", "0 H1"),
    "an image without alt text": (
        "# # A lesson",
        f"{IMAGE}![](field.png)",
        "image without alt text: field.png",
    ),
    "an image tag without alt text": (
        "# # A lesson",
        f'{IMAGE}<img src="field.png">',
        "image without alt text",
    ),
    "an unknown exercise": ("start.wrap_angle", "start.wrap", "unknown exercise 'start.wrap'"),
    "an exercise without a check": ('# %% check="start.wrap_angle"', "# %%", "do not match"),
}


@pytest.mark.parametrize("old, new, sentence", FAULTS.values(), ids=FAULTS)
def test_a_source_that_is_not_well_formed_is_refused(old, new, sentence, tmp_path):
    assert old in LESSON
    assert sentence in problems_of(LESSON.replace(old, new), tmp_path)


def test_a_heading_inside_a_code_block_is_no_heading(tmp_path):
    path = tmp_path / "00_start.py"
    path.write_text(LESSON.replace("# # A lesson", "# # A lesson\n# ```\n# # no title\n# ```"))
    lessons.read_source(path)


def test_an_exercise_without_cases_is_refused(tmp_path, monkeypatch):
    wrap = registry.exercise("start.wrap_angle")
    empty = type(wrap)(**{**vars(wrap), "cases": lambda student, rng: []})
    monkeypatch.setattr(registry, "exercises", lambda: {wrap.id: empty})
    assert "exercise start.wrap_angle has no cases" in problems_of(LESSON, tmp_path)


@pytest.fixture
def checkout(tmp_path, monkeypatch) -> Path:
    """A copy of the first lesson that `build` takes for the repository."""
    folder = tmp_path / "checkout"
    for kind in ("solutions", "notebooks"):
        (folder / kind).mkdir(parents=True)
        shutil.copy(ROOT / kind / "00_start.ipynb", folder / kind)
    shutil.copy(ROOT / "solutions" / "00_start.py", folder / "solutions")
    shutil.copy(ROOT / "pyproject.toml", folder)
    monkeypatch.setattr(files, "CHECKOUT", folder)
    return folder


def tamper(path: Path, change) -> None:
    """Change a notebook file."""
    notebook = nbformat.read(path, as_version=4)
    change(notebook)
    nbformat.write(notebook, path)


def figure_cell(notebook):
    """The first cell with a picture, the picture, and its text."""
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if "image/png" in output.get("data", {}):
                return cell, output
    raise AssertionError("the lesson has no figure")


def without_twin(notebook) -> None:
    cell, picture = figure_cell(notebook)
    picture.data.pop("text/plain", None)
    cell.outputs = [o for o in cell.outputs if o.output_type != "stream"]


def without_alt(notebook) -> None:
    figure_cell(notebook)[1].metadata = nbformat.from_dict({})


def say_instead(cell, old: str, new: str) -> None:
    """Change the text of a cell's outputs."""
    text = json.dumps(cell.outputs, ensure_ascii=False)
    assert old in text
    cell.outputs = [nbformat.from_dict(output) for output in json.loads(text.replace(old, new))]


def unsolved(notebook) -> None:
    say_instead(roles(notebook, "check")[0], "✔ passed", "✘ wrong")


def fewer_points(notebook) -> None:
    say_instead(roles(notebook, "check")[0], "1 of 1 points", "0.5 of 1 points")


def raising(notebook) -> None:
    error = nbformat.v4.new_output("error", ename="KeyError", evalue="x", traceback=[])
    next(c for c in notebook.cells if c.cell_type == "code").outputs.append(error)


def other_source(notebook) -> None:
    notebook.cells[3].source += "\n# edited by hand"


def other_metadata(notebook) -> None:
    roles(notebook, "check")[0].metadata.nbgrader.points = 5


def no_longer_generated(notebook) -> None:
    del notebook.metadata["robocon"]


def one_cell_less(notebook) -> None:
    del notebook.cells[-1]


DRIFT = {
    "edited by hand": ("notebooks", other_source, "has another source"),
    "edited by hand, solved": ("solutions", other_source, "has another source"),
    "other points": ("notebooks", other_metadata, "has another metadata"),
    "no longer marked as generated": ("notebooks", no_longer_generated, "other notebook metadata"),
    "a cell less": ("notebooks", one_cell_less, "cells, its source"),
    "a figure without its text twin": ("solutions", without_twin, "a figure without its text twin"),
    "a figure without alt text": ("solutions", without_alt, "a figure without alt text"),
    "a check that is not passed": ("solutions", unsolved, "start.wrap_angle is not passed"),
    "a check without full points": ("solutions", fewer_points, "does not earn its full points"),
    "a cell that raised": ("solutions", raising, "a cell raises KeyError"),
}


def build_check() -> tuple[int, str]:
    """What `robocon build --check` says."""
    done = CliRunner().invoke(cli.app, ["build", "--check"])
    return done.exit_code, " ".join(done.output.split())


def test_an_untampered_copy_is_in_step(checkout):
    assert build_check()[0] == 0


@pytest.mark.parametrize("folder, change, sentence", DRIFT.values(), ids=DRIFT)
def test_build_check_fails_on_a_notebook_out_of_step(checkout, folder, change, sentence):
    tamper(checkout / folder / "00_start.ipynb", change)
    code, said = build_check()
    assert code == 1 and sentence in said


def edit_source(checkout: Path, old: str, new: str) -> None:
    """Change the lesson's source and nothing made from it."""
    path = checkout / "solutions" / "00_start.py"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")


def test_build_check_fails_on_a_source_edited_since(checkout):
    edit_source(checkout, "## 1. Begin", "## 1. Start")
    code, said = build_check()
    assert code == 1 and "notebooks/00_start.ipynb" in said and "solutions/00_start.ipynb" in said


def test_build_check_fails_on_a_source_that_is_not_well_formed(checkout):
    edit_source(checkout, "### END SOLUTION", "")
    code, said = build_check()
    assert code == 1 and "unbalanced solution marks" in said


@pytest.mark.parametrize("folder", ["notebooks", "solutions"])
def test_build_check_fails_on_a_missing_or_unreadable_notebook(checkout, folder):
    path = checkout / folder / "00_start.ipynb"
    path.unlink()
    assert build_check()[0] == 1
    path.write_text("{")
    assert build_check()[0] in (1, 2)


def test_build_check_writes_nothing(checkout):
    tamper(checkout / "notebooks" / "00_start.ipynb", other_source)
    before = {p: p.read_bytes() for p in checkout.rglob("*") if p.is_file()}
    build_check()
    assert before == {p: p.read_bytes() for p in checkout.rglob("*") if p.is_file()}


# --- building ---------------------------------------------------------------------------------


def test_a_solved_lesson_is_run_away_from_the_maintainers_own_robot(tmp_path, workspace):
    path = tmp_path / "00_start.py"
    text = LESSON.replace("return angle\n", "return (angle + math.pi) % (2 * math.pi) - math.pi\n")
    head = "# %%\nimport math\nfrom robocon_course.exercises import check\n\n# %% exercise="
    path.write_text(text.replace("# %% exercise=", head), encoding="utf-8")
    source = lessons.read_source(path)
    (tmp_path / "own").mkdir()
    solved = lessons.executed_notebook(source, tmp_path / "own")
    assert list(lessons.solved_problems(solved)) == []
    assert (tmp_path / "own" / "my_robot" / "start.py").is_file()
    assert not workspace.exists()


def test_a_file_that_an_exercise_asks_for_is_taken_from_beside_its_solution(tmp_path):
    folder = tmp_path / "solutions"
    folder.mkdir()
    (tmp_path / "notebooks").mkdir()
    (folder / "ball.onnx").write_text("a network")
    text = LESSON.replace("start.wrap_angle", "vision.find_balls").split("# %% check")[0]
    text += """
# %%
print("it holds", open("ball.onnx").read())
check = lambda name: None

# %% check="vision.find_balls"
check("vision.find_balls")
"""
    (folder / "06_vision.py").write_text(text, encoding="utf-8")
    lessons.build_lesson(folder / "06_vision.py")
    solved = nbformat.read(folder / "06_vision.ipynb", as_version=4)
    assert "it holds a network" in [o.text.strip() for o in solved.cells[2].outputs]


def test_a_lesson_that_raises_is_not_written_and_says_where(tmp_path):
    path = tmp_path / "00_start.py"
    path.write_text(LESSON, encoding="utf-8")  # nothing imports check
    with pytest.raises(lessons.LessonError, match="NameError: name 'check' is not defined"):
        lessons.executed_notebook(lessons.read_source(path), tmp_path)


def test_building_twice_gives_the_same_notebook(tmp_path):
    for source in SOURCES:
        one, two = (lessons.student_notebook(lessons.read_source(source)) for _ in range(2))
        assert nbformat.writes(one) == nbformat.writes(two)
