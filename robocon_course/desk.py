"""A student's desk: the folder with their notebooks, and my_robot/ beside them."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from robocon_course import files
from robocon_course._arrays import CourseError
from robocon_course.autopilot import Parts
from robocon_course.exercises import registry
from robocon_course.exercises.parts import robot_parts
from robocon_course.exercises.workspace import Workspace
from robocon_course.worlds import Student


def prepare(folder: Path | None = None) -> Path:
    """The folder to work in: notebooks/ of a checkout, else a workspace with every lesson.

    Parameters
    ----------
    folder : Path, optional
        Default: notebooks/ when called inside a checkout, else ./robocon. A notebook that is
        there already stays as it is.
    """
    if folder is None and files.in_checkout() and Path.cwd().is_relative_to(files.CHECKOUT):
        return files.CHECKOUT / "notebooks"
    desk = (folder or Path("robocon")).resolve()
    desk.mkdir(parents=True, exist_ok=True)
    for lesson in sorted(files.lessons_folder().glob("*.ipynb")):
        if not (desk / lesson.name).exists():
            shutil.copyfile(lesson, desk / lesson.name)
    return desk


def find() -> Path:
    """Where a student's notebooks lie, seen from the current folder.

    Raises
    ------
    CourseError
        There are none in it, in notebooks/ or in robocon/.
    """
    if os.environ.get("ROBOCON_WORKSPACE"):
        return Path(os.environ["ROBOCON_WORKSPACE"])
    here = Path.cwd()
    for folder in (here, here / "notebooks", here / "robocon"):
        if list(folder.glob("[0-9][0-9]_*.ipynb")):
            return folder
    raise CourseError(f"{here} holds no lessons; go to the folder with your notebooks")


def own_parts(which: str = "mixed") -> tuple[Parts, Student]:
    """The parts and the student number of the desk that the current folder belongs to.

    Parameters
    ----------
    which : {"mixed", "mine", "reference"}
        As for `robot_parts`. Where there is no desk, ``"mixed"`` is the course's.

    Returns
    -------
    (Parts, int or str)

    Raises
    ------
    CourseError
        ``"mine"`` was asked for and there is no desk, or parts are missing.
    """
    try:
        workspace = Workspace(find())
    except CourseError:
        if which == "mine":
            raise
        return robot_parts("reference" if which == "mixed" else which), 0
    return robot_parts(which, workspace=workspace), workspace.student


def reset_lesson(number: str) -> str:
    """Put a pristine notebook in place, the old one kept beside it; says what was done."""
    name = f"{registry.chapter(number).name}.ipynb"
    fresh = pristine(name)
    target = find() / name
    kept = ""
    if target.exists():
        counts = range(1, 10_000)
        names = (target.with_name(f"{target.stem}.kept-{count}.ipynb") for count in counts)
        beside = next(path for path in names if not path.exists())
        target.rename(beside)
        kept = f"; yours is kept as {beside.name}"
    target.write_bytes(fresh)
    return f"{name} is new again{kept}"


def pristine(name: str) -> bytes:
    """A lesson as it was shipped; in a checkout notebooks/ may hold a student's own work."""
    packed = files.PACKAGE / "_lessons" / name
    if packed.is_file():
        return packed.read_bytes()
    show = ["git", "-C", str(files.CHECKOUT), "show", f"HEAD:notebooks/{name}"]
    try:
        done = subprocess.run(show, capture_output=True)
    except OSError:
        done = None
    if done and done.returncode == 0:
        return done.stdout
    import nbformat

    from robocon_course import lessons

    source = files.CHECKOUT / "solutions" / name.replace(".ipynb", ".py")
    notebook = lessons.student_notebook(lessons.read_source(source))
    return (nbformat.writes(notebook) + "\n").encode()


def reset_part(part: str, version: int | None = None) -> str:
    """Bring back an accepted version of a part, by default the one before; says what was done."""
    workspace = Workspace(find())
    version = version or max(workspace.in_use().get(part, 1) - 1, 1)
    workspace.use(part, version)
    return f"{part} is version {version} of {len(workspace.versions(part))} again"
