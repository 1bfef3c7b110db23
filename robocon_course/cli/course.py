"""Commands around lessons and marks: lab, doctor, build, check, grade, reset, status."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

from robocon_course import files
from robocon_course._arrays import CourseError
from robocon_course.cli.terminal import WRONG, app, console, progress, refusals


@app.command()
def lab(
    folder: Annotated[
        Path | None, typer.Argument(help="Workspace to open or make; default ./robocon.")
    ] = None,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Start the server without a browser.")
    ] = False,
) -> None:
    """Open the course in JupyterLab.

    In a checkout this opens notebooks/. Elsewhere it makes a workspace with every lesson and
    opens that; a notebook that is there already stays as it is.
    """
    with refusals():
        from robocon_course import desk

        workspace = desk.prepare(folder)
        command = [sys.executable, "-m", "jupyter", "lab", f"--ServerApp.root_dir={workspace}"]
        first = "/lab/tree/00_start.ipynb" if (workspace / "00_start.ipynb").is_file() else "/lab"
        command += [f"--LabApp.default_url={first}"]
        # No question about news, no look for updates: a lesson must not depend on a network.
        command += [
            f"--LabApp.app_settings_dir={files.PACKAGE / 'jupyter'}",
            "--LabApp.news_url=",
            "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        ]
        command += ["--no-browser"] if no_browser else []
        console.print(f"Opening {escape(str(workspace))} in JupyterLab. Stop it with Ctrl+C.")
        raise typer.Exit(subprocess.run(command).returncode)


@app.command()
def doctor() -> None:
    """Look at this installation and say how to mend what is wrong.

    Versions, the kernel that notebooks use, OpenCV installed twice, torch and torchvision that
    do not match. The last line is the verdict.
    """
    from robocon_course.doctor import examine, verdict

    table, lines = Table("", "what", "seen", box=None, padding=(0, 1)), []
    with console.status("looking …"):
        for line in examine():
            lines.append(line)
            table.add_row("✔" if line.well else "✘", escape(line.name), escape(line.seen))
    console.print(table)
    console.print(f"\n{escape(verdict(lines))}", soft_wrap=True)
    if not all(line.well for line in lines):
        raise typer.Exit(WRONG)


@app.command()
def build(
    check: Annotated[bool, typer.Option("--check", help="Compare only; write nothing.")] = False,
    only: Annotated[str | None, typer.Option(help="One lesson, by number: 01.")] = None,
) -> None:
    """Make the notebooks from solutions/NN_topic.py (maintainers; needs the extra "instructor").

    Writes notebooks/NN_topic.ipynb without solutions and executes solutions/NN_topic.ipynb.
    With --check nothing is written or executed: exit code 1 if anything is out of step.
    """
    from robocon_course import lessons

    with refusals():
        if not files.in_checkout():
            raise CourseError("there are no lesson sources here; build runs in a checkout")
        folder = files.CHECKOUT / "solutions"
        sources = [p for p in lessons.sources(folder) if only in (None, p.name[:2])]
        if not sources:
            raise CourseError(f"no lesson source {only or ''} in {folder}")
        problems: list[str] = []
        with progress("comparing" if check else "building", len(sources)) as done:
            for path in sources:
                problems += lessons.build_lesson(path, check=check)
                done(path.stem)
    for problem in problems:
        console.print(f"✘ {escape(problem)}", soft_wrap=True)
    if problems:
        raise typer.Exit(WRONG)
    console.print(f"✔ {len(sources)} lessons in step")


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="Your notebook, or a folder of them.")],
) -> None:
    """Judge your own notebook without opening it: the verdicts that the checks would show.

    Exit code 0 if every exercise has full points, 1 if not, 2 if the file cannot be read.
    """
    from robocon_course.grading.batch import grade_one

    with refusals():
        if not file.exists():
            raise CourseError(f"there is no file {file}")
        with console.status("judging …"):
            row = grade_one(file)
        if row.reason:
            raise CourseError(row.reason)
    for verdict in row.verdicts:
        console.print(escape(str(verdict)), soft_wrap=True)
    console.print(f"{row.points:g} of {row.out_of:g} points, student number {row.student}")
    if row.points < row.out_of:
        raise typer.Exit(WRONG)


@app.command()
def grade(
    folder: Annotated[Path, typer.Argument(help="Folder with one notebook or folder per student.")],
    csv: Annotated[Path, typer.Option(help="Where the table goes.")],
    time_limit: Annotated[float, typer.Option(help="Seconds for one submission.")] = 60.0,
    jobs: Annotated[int | None, typer.Option("--jobs", "-j", help="Side by side.")] = None,
) -> None:
    """Grade every notebook or folder under FOLDER: one row each in a CSV table.

    Each submission runs in fresh processes with a time limit; one that is broken gets a row with
    the reason and does not stop the rest. Those processes have limits but no walls: grade work
    of strangers inside a virtual machine or a container.
    """
    from robocon_course.grading.batch import grade_all, write_csv
    from robocon_course.grading.submission import find_submissions

    with refusals():
        if not folder.is_dir():
            raise CourseError(f"{folder} is not a folder")
        paths = find_submissions(folder)
        if not paths:
            raise CourseError(f"{folder} holds no notebook and no folder")
        if not csv.absolute().parent.is_dir():  # found out now, not after an hour of grading
            raise CourseError(f"there is no folder {csv.absolute().parent} to write the table to")
        with progress("grading", len(paths)) as done:
            rows = grade_all(
                paths, time_limit=time_limit, jobs=jobs, on_row=lambda row: done(row.name)
            )
        write_csv(rows, csv)
    table = Table("submission", "student", "points", "reason", box=None)
    for row in rows:
        points = f"{row.points:g} / {row.out_of:g}" if not row.reason else "-"
        table.add_row(escape(row.name), str(row.student), points, escape(row.reason or row.remark))
    console.print(table)
    console.print(f"{len(rows)} submissions, table in {escape(str(csv))}")


@app.command()
def reset(
    number: Annotated[str | None, typer.Argument(help="Lesson to begin anew: 01.")] = None,
    part: Annotated[
        str | None, typer.Option(help="Bring back an accepted part: imu.mahony_step.")
    ] = None,
    version: Annotated[
        int | None, typer.Option(help="Which accepted version; default the one before.")
    ] = None,
) -> None:
    """Begin a lesson anew, or bring back an earlier accepted part of your robot.

    The notebook you had is kept beside the new one as NN_topic.kept-1.ipynb.
    """
    from robocon_course import desk

    with refusals():
        if (number is None) == (part is None):
            raise CourseError("give a lesson (robocon reset 01) or a part (--part imu.mahony_step)")
        message = desk.reset_lesson(number) if number else desk.reset_part(str(part), version)
    console.print(escape(message))


@app.command()
def status() -> None:
    """Show points per chapter, the parts of your robot, and what comes next."""
    from robocon_course import desk
    from robocon_course.exercises.notebook import status_lines
    from robocon_course.exercises.workspace import Workspace

    with refusals():
        for line in status_lines(Workspace(desk.find())):
            console.print(escape(line), soft_wrap=True)
