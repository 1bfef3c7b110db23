"""The command ``robocon``. Exit codes: 0 fine, 1 wrong answers or drift, 2 unusable input."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from robocon_course import files
from robocon_course._arrays import CourseError

WRONG, UNUSABLE = 1, 2

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    help="Build a competition robot's autonomy, chapter by chapter.\n\n"
    "Students start with [bold]robocon lab[/bold]; if anything is odd, [bold]robocon doctor[/bold] "
    "says what and how to mend it.\n\n"
    "Exit codes: 0 fine, 1 wrong answers or drift, 2 unusable input.",
)
console = Console(highlight=False)


@app.callback()
def _any_terminal() -> None:
    """Let a terminal or a pipe without our signs (✔, °) show "?" instead of ending in an error."""
    for stream in (sys.stdout, sys.stderr):
        stream.reconfigure(errors="replace")


@contextmanager
def _refusals() -> Iterator[None]:
    """Turn the course's own refusals into one sentence and exit code 2."""
    try:
        yield
    except ModuleNotFoundError as error:
        _say(f'this needs {error.name}: pip install -e ".[instructor]"')
        raise typer.Exit(UNUSABLE) from None
    except (CourseError, ValueError, OSError) as error:
        _say(str(error))
        raise typer.Exit(UNUSABLE) from None


def _say(sentence: str) -> None:
    err = Console(stderr=True, highlight=False, soft_wrap=True)
    err.print(f"[bold]robocon:[/bold] {escape(sentence)}")


@contextmanager
def _progress(title: str, total: int) -> Iterator[Callable[[str], None]]:
    """A progress bar; the function it hands out counts one and names what is done."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=total)
        yield lambda done: bar.update(task, advance=1, description=escape(f"{title}: {done}"))


@app.command()
def lab(
    folder: Annotated[
        Path | None, typer.Argument(help="Workspace to open or make; default ./robocon.")
    ] = None,
    no_browser: Annotated[bool, typer.Option(help="Start the server without a browser.")] = False,
) -> None:
    """Open the course in JupyterLab.

    In a checkout this opens notebooks/. Elsewhere it makes a workspace with every lesson and
    opens that; a notebook that is there already stays as it is.
    """
    with _refusals():
        workspace = _workspace(folder)
        command = [sys.executable, "-m", "jupyter", "lab", f"--ServerApp.root_dir={workspace}"]
        first = "/lab/tree/00_start.ipynb" if (workspace / "00_start.ipynb").is_file() else "/lab"
        command += [f"--ServerApp.default_url={first}"]
        # No question about news, no look for updates: a lesson must not depend on a network.
        command += [
            f"--LabApp.app_settings_dir={files.PACKAGE / 'jupyter'}",
            "--LabApp.news_url=",
            "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        ]
        command += ["--no-browser"] if no_browser else []
        console.print(f"Opening {escape(str(workspace))} in JupyterLab. Stop it with Ctrl+C.")
        raise typer.Exit(subprocess.run(command).returncode)


def _workspace(folder: Path | None) -> Path:
    """The folder to work in: notebooks/ of a checkout, else a workspace that is filled up."""
    if folder is None and files.in_checkout() and Path.cwd().is_relative_to(files.CHECKOUT):
        return files.CHECKOUT / "notebooks"
    workspace = (folder or Path("robocon")).resolve()
    workspace.mkdir(parents=True, exist_ok=True)
    for lesson in sorted(files.lessons_folder().glob("*.ipynb")):
        if not (workspace / lesson.name).exists():
            shutil.copyfile(lesson, workspace / lesson.name)
    return workspace


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

    with _refusals():
        if not files.in_checkout():
            raise CourseError("there are no lesson sources here; build runs in a checkout")
        folder = files.CHECKOUT / "solutions"
        sources = [p for p in lessons.sources(folder) if only in (None, p.name[:2])]
        if not sources:
            raise CourseError(f"no lesson source {only or ''} in {folder}")
        problems: list[str] = []
        with _progress("comparing" if check else "building", len(sources)) as done:
            for path in sources:
                problems += _build_one(path, check)
                done(path.stem)
    for problem in problems:
        console.print(f"✘ {escape(problem)}", soft_wrap=True)
    if problems:
        raise typer.Exit(WRONG)
    console.print(f"✔ {len(sources)} lessons in step")


def _build_one(path: Path, check: bool) -> list[str]:
    """Build or compare one lesson; what is out of step."""
    import tempfile

    from robocon_course import lessons

    student = files.CHECKOUT / "notebooks" / f"{path.stem}.ipynb"
    solved = path.with_suffix(".ipynb")
    try:
        source = lessons.read_source(path)
    except lessons.LessonError as error:
        return str(error).splitlines()
    if not check:
        lessons.write_notebook(lessons.student_notebook(source), student)
        with tempfile.TemporaryDirectory() as workspace:
            try:
                executed = lessons.executed_notebook(source, Path(workspace))
            except lessons.LessonError as error:
                return [f"{path.name}: {error}"]
        lessons.write_notebook(executed, solved)
    return lessons.check_lesson(source, student, solved)


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="Your notebook, or a folder of them.")],
) -> None:
    """Judge your own notebook without opening it: the verdicts that the checks would show.

    Exit code 0 if every exercise has full points, 1 if not, 2 if the file cannot be read.
    """
    from robocon_course.grading.batch import grade_one

    with _refusals():
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

    with _refusals():
        if not folder.is_dir():
            raise CourseError(f"{folder} is not a folder")
        paths = find_submissions(folder)
        if not paths:
            raise CourseError(f"{folder} holds no notebook and no folder")
        with _progress("grading", len(paths)) as done:
            rows = grade_all(
                paths, time_limit=time_limit, jobs=jobs, on_row=lambda row: done(row.name)
            )
        write_csv(rows, csv)
    table = Table("submission", "student", "points", "reason", box=None)
    for row in rows:
        points = f"{row.points:g} / {row.out_of:g}" if not row.reason else "-"
        table.add_row(escape(row.name), str(row.student), points, escape(row.reason))
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
    with _refusals():
        if (number is None) == (part is None):
            raise CourseError("give a lesson (robocon reset 01) or a part (--part imu.mahony_step)")
        message = _reset_lesson(number) if number else _reset_part(str(part), version)
    console.print(escape(message))


def _reset_lesson(number: str) -> str:
    from robocon_course.exercises import registry

    name = f"{registry.chapter(number).name}.ipynb"
    pristine = _pristine(name)
    target = _student_folder() / name
    kept = ""
    if target.exists():
        beside = next(
            path
            for count in range(1, 1000)
            if not (path := target.with_name(f"{target.stem}.kept-{count}.ipynb")).exists()
        )
        target.rename(beside)
        kept = f"; yours is kept as {beside.name}"
    target.write_bytes(pristine)
    return f"{name} is new again{kept}"


def _pristine(name: str) -> bytes:
    """A lesson as it was shipped; in a checkout notebooks/ may hold a student's own work."""
    packed = files.PACKAGE / "_lessons" / name
    if packed.is_file():
        return packed.read_bytes()
    source = files.CHECKOUT / "solutions" / name.replace(".ipynb", ".py")
    show = ["git", "-C", str(files.CHECKOUT), "show", f"HEAD:notebooks/{name}"]
    done = subprocess.run(show, capture_output=True)
    if done.returncode == 0:
        return done.stdout
    import nbformat

    from robocon_course import lessons

    notebook = lessons.student_notebook(lessons.read_source(source))
    return (nbformat.writes(notebook) + "\n").encode()


def _reset_part(part: str, version: int | None) -> str:
    from robocon_course.exercises.workspace import Workspace

    workspace = Workspace(_student_folder())
    version = version or max(workspace.in_use().get(part, 1) - 1, 1)
    workspace.use(part, version)
    return f"{part} is version {version} of {len(workspace.versions(part))} again"


def _student_folder() -> Path:
    """Where a student's notebooks lie, seen from where the command was typed."""
    import os

    if os.environ.get("ROBOCON_WORKSPACE"):
        return Path(os.environ["ROBOCON_WORKSPACE"])
    here = Path.cwd()
    if list(here.glob("[0-9][0-9]_*.ipynb")):
        return here
    for folder in (here / "notebooks", here / "robocon"):
        if folder.is_dir():
            return folder
    raise CourseError(f"{here} holds no lessons; go to the folder with your notebooks")


@app.command()
def status() -> None:
    """Show points per chapter, the parts of your robot, and what comes next."""
    from robocon_course.exercises.notebook import status_lines
    from robocon_course.exercises.workspace import Workspace

    with _refusals():
        for line in status_lines(Workspace(_student_folder())):
            console.print(escape(line), soft_wrap=True)


@app.command()
def attitude(
    file: Annotated[Path, typer.Argument(help="CSV with time, gyro and accel columns.")],
    k_p: Annotated[float, typer.Option("--kp", help="Proportional gain [1/s].")] = 1.0,
    k_i: Annotated[float, typer.Option("--ki", help="Integral gain [1/s²].")] = 0.0,
    still: Annotated[
        float, typer.Option(help="Seconds at rest at the start: their mean is the gyro bias.")
    ] = 0.0,
    rate: Annotated[
        float | None, typer.Option(help="Samples per second, for a file without time.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder for the results; default beside the file.")
    ] = None,
) -> None:
    """Turn an IMU recording into roll, pitch and yaw: a CSV and a picture.

    Columns are found by name, in any order: t_s or time_ms …, gyr_x … in rad/s (gyr_x_deg_s in
    deg/s), acc_x … in m/s² (acc_x_g in g).
    """
    with _refusals():
        results = _attitude(file, k_p, k_i, still, rate, out)
    for line in results:
        console.print(escape(line), soft_wrap=True)


def _attitude(
    file: Path, k_p: float, k_i: float, still: float, rate: float | None, out: Path | None
) -> list[str]:
    import numpy as np

    from robocon_course import imu
    from robocon_course.view import plots

    with console.status("reading …"):
        log = imu.read_log(file, rate=rate)
    gyro = log.gyro
    lines = []
    if still:
        rest = log.time - log.time[0] < still
        bias = imu.calibrate_gyro(gyro[rest], dt=float(np.median(log.dt[1:]))).bias
        gyro = gyro - bias
        lines.append(f"Gyro bias from {still:g} s at rest: {np.degrees(bias).round(3)} deg/s")
    result = imu.estimate_attitude(gyro, log.accel, log.dt, gains=imu.MahonyGains(k_p, k_i))
    folder = out or file.parent
    folder.mkdir(parents=True, exist_ok=True)
    table, picture = (folder / f"{file.stem}_attitude.{end}" for end in ("csv", "png"))
    imu.write_angles(table, log, result)
    angles: dict[str, Any] = {n: getattr(result, n) for n in ("roll", "pitch", "yaw")}
    picture.write_bytes(plots.png(plots.plot_angles(log.time, angles)))
    ends = ", ".join(f"{n} {np.degrees(v[-1]):.1f}°" for n, v in angles.items())
    lines.append(f"{len(log.time)} samples, {result.rejected} not fully used; at the end {ends}")
    return [*lines, f"Angles: {table}", f"Picture: {picture}"]


if __name__ == "__main__":
    app()
