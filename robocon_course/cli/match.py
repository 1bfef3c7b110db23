"""Commands that play: match, season, replay."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from rich.markup import escape
from rich.table import Table

from robocon_course._arrays import CourseError
from robocon_course.cli.terminal import WRONG, app, console, progress, refusals, shares

if TYPE_CHECKING:
    from robocon_course.autopilot import Parts
    from robocon_course.worlds import MatchResult

Opponent = Annotated[str, typer.Option(help="weak, middling, strong, or none.")]
Mine = Annotated[bool, typer.Option("--mine", help="Play on your own accepted parts.")]
Team = Annotated[str, typer.Option(help="red or blue.")]
Strategy = Annotated[
    str | None, typer.Option(help="How silos are chosen: A, B or ahead; default your own or ahead.")
]
Sent = Annotated[
    int | None,
    typer.Option(
        help="Balls from Robot 1. The rules allow 12, the default; with 24 none is wanting."
    ),
]
Camera = Annotated[
    bool, typer.Option("--camera", help="Draw what the camera sees and run the networks on it.")
]


@app.command()
def match(
    seed: Annotated[int, typer.Option(help="Another seed, another match.")] = 0,
    mine: Mine = False,
    opponent: Opponent = "weak",
    team: Team = "red",
    camera: Camera = False,
    strategy: Strategy = None,
    sent: Sent = None,
    record: Annotated[
        Path | None, typer.Option(help="Folder for the log (.mcap) and an animation (.gif).")
    ] = None,
) -> None:
    """Let the robot play a match of three minutes by itself, in the simulator.

    Exit code 0 if it wins, 1 if not, 2 if it cannot be played.
    """
    with refusals():
        from robocon_course import worlds
        from robocon_course.robot import Bus
        from robocon_course.simulator import warm_up

        settings = _settings(opponent, team, strategy, sent) | {"drawn": camera}
        if record is not None and record.exists() and not record.is_dir():
            raise CourseError(f"--record: expected a folder, {record} is a file")
        parts, number = _parts(mine)
        console.print(f"Robot of student {number}, parts: {escape(parts().label)}, seed {seed}")
        warm_up(console.print)
        bus = Bus() if record is not None else None
        with _recording(record, bus), shares("playing") as share:
            result = worlds.play_match(
                number, parts(), seed, on_time=share, with_balls=record is not None, bus=bus,
                **settings,
            )  # fmt: skip
        if record is not None:
            from robocon_course.view.matches import animate_match

            (record / "match.gif").write_bytes(animate_match(result).gif)
    _told(result)
    if record is not None:
        console.print(f"log and animation: {escape(str(record))}", soft_wrap=True)
    if result.winner != "own":
        raise typer.Exit(WRONG)


@app.command()
def season(
    seeds: Annotated[int, typer.Option(help="How many matches.")] = 20,
    first: Annotated[int, typer.Option(help="Seed of the first.")] = 0,
    mine: Mine = False,
    opponent: Opponent = "weak",
    team: Team = "red",
    camera: Camera = False,
    strategy: Strategy = None,
    sent: Sent = None,
    workers: Annotated[
        int | None, typer.Option(help="Processes; default one for each core.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help='A Dask cluster, such as "tcp://host:8786".')
    ] = None,
    patience: Annotated[float, typer.Option(help="Seconds to wait for that cluster.")] = 20.0,
) -> None:
    """Let the robot play many matches, on all cores, and count.

    The results do not depend on how many processes there are, or where.
    """
    if seeds < 1:
        raise typer.BadParameter("at least one match", param_hint="--seeds")
    if workers is not None and workers < 1:
        raise typer.BadParameter("at least one process", param_hint="--workers")
    with refusals():
        from robocon_course import worlds
        from robocon_course.simulator import warm_up

        settings = _settings(opponent, team, strategy, sent) | {"drawn": camera}
        parts, number = _parts(mine)
        console.print(f"Robot of student {number}, parts: {escape(parts().label)}")
        warm_up(console.print)
        with _mapping(workers, scheduler, patience) as run, progress("playing", seeds) as done:
            results = worlds.season(
                range(first, first + seeds), number, parts, run=run,
                on_match=lambda result: done(f"seed {result.seed}"), **settings,
            )  # fmt: skip
    console.print(season_table(results))


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(help="A log that robocon match --record wrote.")],
    mine: Mine = False,
) -> None:
    """Feed a recorded match back through the autopilot, and compare what it does with the log.

    Exit code 0 if every command is the same, 1 if not, 2 if the log cannot be read.
    """
    with refusals():
        from robocon_course.worlds.replays import replay_log

        parts, number = _parts(mine)
        with shares("replaying") as share:
            found = replay_log(file, number, parts(), on_time=share)
    for line in found.lines:
        console.print(escape(line), soft_wrap=True)
    if not found.same:
        raise typer.Exit(WRONG)


ENDED = {"own": "won by", "theirs": "lost by", "nobody": "drawn by"}


def season_table(results: Iterable[MatchResult]) -> Table:
    """All matches in one table, and their sums below."""
    results = list(results)
    table = Table(title=f"{len(results)} matches")
    for name in ("seed", "result", "after", "points", "stored", "fouls", "contacts", "RMS"):
        table.add_column(name, justify="left" if name == "result" else "right")
    for one in results:
        table.add_row(
            str(one.seed), f"{ENDED[one.winner]} {one.reason}", f"{one.ended:.0f} s",
            f"{one.points} : {one.their_points}", str(one.stored), str(one.fouls),
            str(one.contacts), f"{1000 * one.error:.0f} mm",
        )  # fmt: skip
    table.add_section()
    count = len(results)
    table.add_row(
        "all", f"won {sum(one.winner == 'own' for one in results)} of {count}, Mua Vang "
        f"{sum(one.mua_vang for one in results)}",
        f"{np.mean([one.ended for one in results]):.0f} s",
        f"{np.mean([one.points for one in results]):.0f} : "
        f"{np.mean([one.their_points for one in results]):.0f}",
        f"{np.mean([one.stored for one in results]):.1f}",
        str(sum(one.fouls for one in results)), str(sum(one.contacts for one in results)),
        f"{1000 * np.sqrt(np.mean([one.error**2 for one in results])):.0f} mm",
    )  # fmt: skip
    return table


def _told(result: MatchResult) -> None:
    for time, state, reason in result.history:
        console.print(f"[dim]{time:6.1f} s  {escape(state):26} {escape(reason)}[/dim]")
    for line in result.lines:
        console.print(escape(line), soft_wrap=True)


def _settings(opponent: str, team: str, strategy: str | None, sent: int | None) -> dict:
    """What was asked for, refused before anything is compiled or played."""
    from robocon_course.field import SEEDLINGS
    from robocon_course.mission import LETTERS, STRATEGIES
    from robocon_course.simulator.referee import OPPONENTS

    for name, got, known in (
        ("opponent", opponent, [*OPPONENTS, "none"]),
        ("team", team, LETTERS),
        ("strategy", strategy, [*STRATEGIES, None]),
    ):
        if got not in known:
            words = ", ".join(one for one in known if one is not None)
            raise CourseError(f"--{name}: expected one of {words}, got {got!r}")
    if sent is not None and sent < 0:
        raise CourseError(f"--sent: expected a number of balls, got {sent}")
    return {
        "opponent": None if opponent == "none" else opponent, "team": team, "strategy": strategy,
        "sent": SEEDLINGS if sent is None else sent,
    }  # fmt: skip


def _parts(mine: bool) -> tuple[Callable[[], Parts], str | int]:
    """The parts, as something that loads them, and whose robot it is."""
    from robocon_course import desk

    kind = "mixed" if mine else "reference"
    _, number = desk.own_parts(kind)
    return partial(_loaded, kind), number


@cache
def _loaded(kind: str) -> Parts:
    """A student's parts are read once in each process."""
    from robocon_course import desk

    return desk.own_parts(kind)[0]


@contextmanager
def _recording(folder: Path | None, bus: object) -> Iterator[None]:
    if folder is None:
        yield
        return
    from robocon_course.logs import MatchLog

    folder.mkdir(parents=True, exist_ok=True)
    with MatchLog(folder / "match.mcap") as log:
        log.listen(bus)
        yield


@contextmanager
def _mapping(workers: int | None, scheduler: str | None, patience: float) -> Iterator[Callable]:
    """What maps the matches: the cores of this machine, or a cluster."""
    if scheduler is None:
        from concurrent.futures import ProcessPoolExecutor
        from multiprocessing import get_context

        if workers == 1:
            yield map
            return
        with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
            yield pool.map
        return
    try:
        from distributed import Client
    except ImportError:
        raise CourseError('--scheduler needs Dask: pip install -e ".[scale]"') from None
    try:
        client = Client(scheduler, timeout=patience)
    except (OSError, TimeoutError, ValueError) as error:
        raise CourseError(
            f"--scheduler: no Dask scheduler answers at {scheduler} ({error})"
        ) from None
    with client:
        yield lambda work, items: (one.result() for one in client.map(work, items, pure=False))
