"""Commands that make data for networks and networks from data: dataset, train."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from robocon_course._arrays import CourseError
from robocon_course.cli.terminal import WRONG, app, console, refusals

KIND = Annotated[str, typer.Argument(help="ball or silo.")]


def _bar(unit: str) -> Progress:
    """A bar that counts, names the unit, and says how long it will take."""
    columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn()
    more = TextColumn(unit), TimeRemainingColumn()
    return Progress(*columns, *more, console=Console(stderr=True), transient=True)


@app.command()
def dataset(
    kind: KIND,
    images: Annotated[int, typer.Option(help="How many pictures.")] = 1000,
    seed: Annotated[int, typer.Option(help="Another seed, other pictures.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder to make; default data-KIND here.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes, 160 MB each; default one a core, at most 2.")
    ] = None,
    check: Annotated[
        Path | None, typer.Option(help="Draw nothing: look for problems in this data set.")
    ] = None,
) -> None:
    """Draw a data set with exact boxes, ready for YOLO, and a contact sheet of it.

    With --check FOLDER an existing data set is looked at instead. Exit code 1 if anything is wrong
    with it, each problem in a line of its own; 2 if it cannot be drawn or read.
    """
    from robocon_course.vision import dataset as sets

    folder = check or out or Path(f"data-{kind}")
    with refusals():
        if check is None:
            with _bar("pictures") as bar:
                task = bar.add_task("drawing", total=images)
                sets.write_dataset(
                    kind, folder, images, seed, workers=workers,
                    progress=lambda done, _: bar.update(task, completed=done),
                )  # fmt: skip
            sheet = _contact_sheet(folder)
            console.print(f"{images} pictures; look at {escape(str(sheet))}", soft_wrap=True)
        with console.status("looking for problems …"):
            problems = sets.check_dataset(folder, kind=kind)
    if not problems:
        console.print(f"✔ {escape(str(folder))}: no problems", soft_wrap=True)
        return
    table = Table("file", "problem", box=None)
    for problem in problems:
        table.add_row(escape(problem.file), escape(problem.what))
    console.print(table)
    found = "1 problem" if len(problems) == 1 else f"{len(problems)} problems"
    console.print(f"✘ {escape(str(folder))}: {found}", soft_wrap=True)
    raise typer.Exit(WRONG)


def _contact_sheet(folder: Path) -> Path:
    """Write the contact sheet of a data set into its folder."""
    import cv2

    from robocon_course.vision.sheet import contact_sheet

    path = folder / "contact-sheet.jpg"
    if not cv2.imwrite(str(path), contact_sheet(folder, side=320)):
        raise CourseError(f"{path} could not be written")
    return path


@app.command()
def train(
    kind: KIND,
    data: Annotated[Path | None, typer.Option(help="Data set; default data-KIND here.")] = None,
    run: Annotated[
        Path | None, typer.Option(help="Folder of this training; default run-KIND here.")
    ] = None,
    epochs: Annotated[int, typer.Option(help="How often each picture is shown.")] = 100,
    image_size: Annotated[int, typer.Option(help="Side of the network's square [pixels].")] = 320,
    batch: Annotated[int, typer.Option(help="Pictures per step.")] = 16,
    seed: Annotated[int, typer.Option(help="Of weights, order and augmentation.")] = 0,
    device: Annotated[str, typer.Option(help="cpu, 0 for a GPU, 0,1 for two.")] = "cpu",
    start_from: Annotated[
        Path | None, typer.Option(help="Checkpoint (.pt) of your own, or .onnx, to start from.")
    ] = None,
) -> None:
    """Train YOLOv8n from scratch and export it as KIND.onnx. Nothing is downloaded or sent.

    Killed or stopped with Ctrl+C, it goes on after the last whole epoch when called again with the
    same folder. Needs the extra "vision".
    """
    with refusals():
        from robocon_course.vision import training

        data, run = data or Path(f"data-{kind}"), run or Path(f"run-{kind}")
        with _bar("epochs") as bar:
            task = bar.add_task("starting", total=epochs)

            def show(epoch: training.Epoch) -> None:
                if not bar.console.is_terminal:  # a log keeps a line an epoch
                    bar.console.print(epoch.in_words(), soft_wrap=True)
                score = "" if epoch.map50 != epoch.map50 else f", mAP50 {epoch.map50:.3f}"
                said = f"loss {epoch.loss:.2f}{score}"
                bar.update(task, completed=epoch.number, total=epoch.of, description=said)

            last = training.train(
                kind, data, run, epochs=epochs, image_size=image_size, batch=batch, seed=seed,
                device=device, start_from=start_from, progress=show,
            )  # fmt: skip
        weights = training.export(last, run / f"{kind}.onnx")
        score = training.history(run)["map50"][-1]
        told = f"✔ {escape(str(weights))}: mAP50 {score:.3f} on its validation pictures"
        console.print(told, soft_wrap=True)
        if (data / "images" / "test").is_dir():
            from robocon_course.vision.evaluation import evaluate

            each = [f"{name} {ap:.3f}" for name, ap in evaluate(weights, data).items()]
            console.print(f"  test pictures, class by class: {', '.join(each)}", soft_wrap=True)
