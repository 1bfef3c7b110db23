"""What every command shares: the app, its exit codes, refusals in a sentence, progress bars."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from robocon_course._arrays import CourseError

WRONG, UNUSABLE = 1, 2
VISION = ("torch", "torchvision", "ultralytics", "onnx")
"""What only training needs."""

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="markdown",
    help="Build a competition robot's autonomy, chapter by chapter.\n\n"
    "Students start with **robocon lab**; if anything is odd, **robocon doctor** "
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
def refusals() -> Iterator[None]:
    """Turn the course's own refusals into one sentence and exit code 2."""
    try:
        yield
    except ModuleNotFoundError as error:
        extra = "vision" if error.name in VISION else "instructor"
        say(f'this needs {error.name}: pip install -e ".[{extra}]"')
        raise typer.Exit(UNUSABLE) from None
    except (CourseError, ValueError, OSError) as error:
        say(str(error))
        raise typer.Exit(UNUSABLE) from None


def say(sentence: str) -> None:
    """A sentence for people, on the error stream."""
    err = Console(stderr=True, highlight=False, soft_wrap=True)
    err.print(f"[bold]robocon:[/bold] {escape(sentence)}")


@contextmanager
def progress(title: str, total: int) -> Iterator[Callable[[str], None]]:
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


@contextmanager
def shares(title: str) -> Iterator[Callable[[float], None]]:
    """A progress bar for what has no parts to count; the function it hands out takes a share."""
    columns = TextColumn("{task.description}"), BarColumn(), TimeRemainingColumn()
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda share: bar.update(task, completed=share)
