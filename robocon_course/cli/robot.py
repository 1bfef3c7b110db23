"""Commands that run the robot, or look at what it recorded: drive, attitude."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from robocon_course import field
from robocon_course._arrays import CourseError
from robocon_course.cli.terminal import WRONG, app, console, refusals, shares


@app.command()
def drive(
    goal: Annotated[
        tuple[float, float], typer.Option(help="x and y on the field [m].")
    ] = field.AREA_3_GOAL,
    parts: Annotated[
        str, typer.Option(help="mixed: your accepted parts and the course's; mine; reference.")
    ] = "mixed",
    kind: Annotated[
        str, typer.Option(help="ideal, noisy or degraded: how kind the world is.")
    ] = "noisy",
    student: Annotated[
        str | None, typer.Option(help="Whose robot; default your own student number.")
    ] = None,
    gif: Annotated[Path | None, typer.Option(help="File for an animation of the drive.")] = None,
) -> None:
    """Let the simulated robot plan its way from the start to a goal, and drive it by itself.

    It has nothing but its own sensors. Exit code 0 if it arrives without touching anything, 1 if
    not, 2 if no way leads there.
    """
    with refusals():
        from robocon_course import desk, worlds
        from robocon_course.simulator import warm_up

        if gif is not None and not gif.absolute().parent.is_dir():
            raise CourseError(f"there is no folder {gif.absolute().parent} to write the film to")
        own, number = desk.own_parts(parts)
        whose = number if student is None else worlds.student_number(student)
        console.print(f"Robot of student {whose}, parts: {escape(own.label)}")
        warm_up(console.print)
        with shares("driving") as share:
            run = worlds.field_drive(whose, own, goal, kind=kind, on_time=share)
        if gif is not None:
            from robocon_course.view import animate

            film = animate(
                run.time,
                {run.parts: run.poses},
                angles=run.module_angles,
                speeds=run.module_speeds,
                markers={"goal": goal},
            )
            gif.write_bytes(film.gif)
    for line in run.lines:
        console.print(escape(line), soft_wrap=True)
    if not run.arrived or run.contacts:
        raise typer.Exit(WRONG)


@app.command()
def attitude(
    file: Annotated[Path, typer.Argument(help="CSV with time, gyro and accel columns.")],
    k_p: Annotated[float, typer.Option("--kp", help="Proportional gain [1/s].")] = 0.5,
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
    with refusals():
        from robocon_course.imu import MahonyGains
        from robocon_course.recordings import attitude_of_file

        with console.status("working …"):
            gains = MahonyGains(k_p, k_i)
            results = attitude_of_file(file, gains, still=still, rate=rate, out=out)
    for line in results:
        console.print(escape(line), soft_wrap=True)
