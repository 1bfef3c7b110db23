"""A match as a short film and as one figure."""

from __future__ import annotations

import io
from collections.abc import Iterable
from math import cos, sin
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image, ImageDraw

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.robot import SIDE
from robocon_course.view.animation import LARGEST_GIF
from robocon_course.view.canvas import (
    MINE,
    RAW,
    TRUTH,
    WARN,
    Animation,
    figure,
    packed,
    styled,
)
from robocon_course.view.field_picture import draw_ground
from robocon_course.view.ground import painted_field
from robocon_course.view.raster import Scale, font, rgb

if TYPE_CHECKING:
    from robocon_course.worlds import MatchResult

PER_METRE = 70
"""Pixels of the film."""
WIDTH, HEIGHT, BAND = 474, 300, 26
"""Of the film's field, and of the line of words under it [pixels]."""
RATES = (6.0, 4.5, 3.5, 2.5)
"""Pictures a second: the first with which the film is small enough."""
COLOURS = 64
PAINTS = {
    "red": "#F03241", "blue": "#3278E1", "purple": "#A0559B", "R": "#F03241", "B": "#3278E1",
}  # fmt: skip
TRAIL = 60
"""So many rows of the record stay visible behind the robot."""
GROUPS = {
    "drives to Area 3": ("reset", "go_to_area_3", "lidar_reset"),
    "looks for balls": ("detect_ball", "search_ball", "push_ball_pile", "reverse"),
    "takes a ball": ("take_ball",),
    "brings it to a silo": ("search_silo", "approach_silo", "silo_full"),
    "goes back": ("reset_odometry_from_lidar", "back_to_storage"),
    "in trouble": ("stuck", "no_sensors"),
}
GROUP_COLOURS = (RAW, "#8A8420", MINE, "#882255", "#2A8C82", WARN)


def animate_match(result: MatchResult, *, speed: float = 6.0) -> Animation:
    """A match as a film that repeats for ever, for `show`.

    Where nothing can move, four of its pictures stand for it.

    Parameters
    ----------
    result : MatchResult
        Recorded with its balls: ``play_match(..., with_balls=True)``.
    speed : float
        How many times as fast as it was.

    Returns
    -------
    Animation
        Its GIF has less than a megabyte.

    Raises
    ------
    ValueError
        A match recorded without balls, or a speed that is not positive.
    """
    if not len(result.balls):
        raise ValueError("result: expected a match with its balls; play it with with_balls=True")
    if not 0.0 < speed < np.inf:
        raise ValueError(f"speed: expected a number above 0, got {speed!r}")
    for rate in RATES:
        moments = np.arange(0.0, result.time[-1] + 1e-9, speed / rate)
        rows = np.searchsorted(result.time, moments).clip(0, len(result.time) - 1)
        images = [_picture(result, int(row)) for row in (*rows, len(result.time) - 1)]
        film = _gif(images, rate)
        if len(film) < LARGEST_GIF:
            break
    return Animation(film, packed(_four(images)))


def _four(images: list[Image.Image]) -> Image.Image:
    """Four moments side by side, the last picture among them."""
    width, height = images[0].size
    sheet = Image.new("RGB", (2 * width + 6, 2 * height + 6), "white")
    for place in range(4):
        image = images[round((place + 1) / 4 * (len(images) - 1))]
        sheet.paste(image, (place % 2 * (width + 6), place // 2 * (height + 6)))
    return sheet


def _picture(result: MatchResult, row: int) -> Image.Image:
    """One picture of the film: the camera follows the robot up the field and stays in Area 3."""
    floor, scale = painted_field(PER_METRE, 0.25)
    half = 0.5 * HEIGHT / PER_METRE
    middle = float(np.clip(result.poses[row, 1], half - 0.05, field.SIZE - half + 0.05))
    top = int(np.clip(scale.bottom - (middle + half) * PER_METRE, 0, len(floor) - HEIGHT))
    image = Image.new("RGB", (WIDTH, HEIGHT + BAND), "white")
    image.paste(Image.fromarray(floor[top : top + HEIGHT, :WIDTH]), (0, 0))
    pen, here = ImageDraw.Draw(image), scale.moved(0, top)
    trail = here.pixels(result.poses[max(0, row - TRAIL) : row + 1, :2])
    if len(trail) > 1:
        pen.line([tuple(point) for point in trail.tolist()], fill=MINE, width=2)
    _draw_balls(pen, here, result.balls[row], result.colours[row])
    _draw_silos(pen, here, fillings_at(result, float(result.time[row])))
    _draw_robot(pen, here, result.poses[row], _holds(result, float(result.time[row])))
    pen.rectangle([0, HEIGHT, WIDTH, HEIGHT + BAND], fill="white")
    now = result.time[row]
    own, theirs = points_at(result, float(now))
    words = result.states[row].replace("_", " ")
    if row == len(result.time) - 1:
        words = f"{result.winner}: {result.reason}"
    pen.text((6, HEIGHT + 5), f"{int(now) // 60}:{int(now) % 60:02d}", TRUTH, font(14))
    pen.text((52, HEIGHT + 5), words, TRUTH, font(14))
    pen.text((WIDTH - 6, HEIGHT + 5), f"{own} : {theirs}", TRUTH, font(14), anchor="ra")
    return image


def _disc(pen: ImageDraw.ImageDraw, at: FloatArray, radius: float, fill: str | None) -> None:
    box = [at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius]
    pen.ellipse(box, fill=None if fill is None else rgb(fill), outline=rgb(TRUTH))


def _draw_balls(
    pen: ImageDraw.ImageDraw, scale: Scale, xy: FloatArray, colours: Iterable[str]
) -> None:
    for at, colour in zip(scale.pixels(xy.reshape(-1, 2)), colours, strict=True):
        _disc(pen, at, 0.5 * field.BALL_DIAMETER * PER_METRE, PAINTS[colour])


def _draw_silos(pen: ImageDraw.ImageDraw, scale: Scale, fillings: Iterable[str]) -> None:
    """What each holds lies beside it, the bottom ball first."""
    for number, ((x, y), filling) in enumerate(zip(field.SILOS, fillings, strict=True)):
        column, row = scale.pixels(np.array([[x, y]]))[0]
        _disc(pen, (column, row), 9, "#FFFFFF")
        pen.text((column, row), str(number + 1), TRUTH, font(11), anchor="mm")
        for place in range(field.SILO_CAPACITY):
            colour = PAINTS[filling[place]] if place < len(filling) else None
            _disc(pen, (column + 16 + 12 * place, row), 5.5, colour)


def _draw_robot(
    pen: ImageDraw.ImageDraw, scale: Scale, pose: FloatArray, holds: str | None
) -> None:
    x, y, theta = (float(number) for number in pose)
    c, s, half = cos(theta), sin(theta), 0.5 * SIDE

    def on_map(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
        placed = [(x + c * ahead - s * left, y + s * ahead + c * left) for ahead, left in points]
        return [tuple(point) for point in scale.pixels(np.array(placed)).tolist()]

    pen.polygon(on_map([(half, half), (-half, half), (-half, -half), (half, -half)]),
                fill=(255, 255, 255), outline=rgb(MINE), width=2)  # fmt: skip
    pen.polygon(on_map([(half, 0.12), (half - 0.14, 0.0), (half, -0.12)]), fill=rgb(MINE))
    if holds is not None:
        _disc(pen, on_map([(0.05, 0.0)])[0], 0.5 * field.BALL_DIAMETER * PER_METRE, PAINTS[holds])


def _gif(images: list[Image.Image], rate: float) -> bytes:
    step = max(1, len(images) // 12)
    sheet = Image.new("RGB", (images[0].width, images[0].height * len(images[::step])))
    for place, image in enumerate(images[::step]):
        sheet.paste(image, (0, place * image.height))
    table = sheet.quantize(COLOURS, dither=Image.Dither.NONE)
    flat = [image.quantize(palette=table, dither=Image.Dither.NONE) for image in images]
    each = 10 * round(100.0 / rate)  # a GIF counts hundredths of a second
    stream = io.BytesIO()
    flat[0].save(
        stream, "gif", save_all=True, append_images=flat[1:], loop=0, disposal=1,
        duration=[each] * (len(flat) - 1) + [2500],
    )  # fmt: skip
    return stream.getvalue()


def fillings_at(result: MatchResult, now: float) -> list[str]:
    """What the five silos held at a time [s], each from bottom to top."""
    held = [""] * len(field.SILOS)
    for event in result.events:
        if event.what == "stored" and event.time <= now:
            number, _, filling = event.detail.removeprefix("silo ").partition(": ")
            held[int(number) - 1] = filling
    return held


def points_at(result: MatchResult, now: float) -> tuple[int, int]:
    """Own points and theirs at a time [s]."""
    worth = {"stored": 30, "transfer": 10, "seedling": 10}
    points = {"own": 0, "theirs": 0}
    for event in result.events:
        if event.time <= now:
            points[event.team] += worth.get(event.what, 0)
    return points["own"], points["theirs"]


def _holds(result: MatchResult, now: float) -> str | None:
    """Colour of the ball in the gripper."""
    last = ""
    for event in result.events:
        ends = event.what in ("stored", "lost ball", "foul", "retry") and event.team == "own"
        dropped = event.what == "fault" and event.detail == "drop"
        if event.time <= now and (event.what == "taken" or ends or dropped):
            last = event.what
    own = next((e.detail[-1] for e in result.events if e.what == "stored" and e.team == "own"), "R")
    return own if last == "taken" else None


@styled()
def plot_match(result: MatchResult) -> Figure:
    """Where the robot was and what it did, and when silos were filled.

    Parameters
    ----------
    result : MatchResult

    Returns
    -------
    Figure
    """
    fig, (ground, line) = figure(7.4, 3.7, 2)
    window = (-0.05, 6.35, -0.05, 12.05)
    draw_ground(ground, window, 0.55)
    doing = np.array([_group(state) for state in result.states])
    for number, colour in enumerate(GROUP_COLOURS):
        xy = np.where((doing == number)[:, None], result.poses[:, :2], np.nan)
        ground.plot(*xy.T, color=colour, linewidth=1.4)
    ground.set(xlim=window[:2], ylim=window[2:], aspect="equal", xlabel="x [m]", ylabel="y [m]")
    edges = np.flatnonzero(np.diff(doing)) + 1
    for first, last in zip((0, *edges), (*edges, len(doing) - 1), strict=True):
        span = result.time[first], result.time[last] - result.time[first]
        line.broken_barh([span], (0.6, 0.8), facecolors=GROUP_COLOURS[doing[first]])
    for event in result.events:
        if event.what == "stored":
            height = 2.0 if event.team == "own" else 2.8
            line.plot(event.time, height, "o", color=PAINTS[event.detail[-1]], markersize=6)
    line.set(xlim=(0, max(result.ended, 1.0)), ylim=(0.4, 3.3), xlabel="t [s]",
             yticks=[1.0, 2.0, 2.8], yticklabels=["robot", "we store", "they store"])  # fmt: skip
    line.grid(False)
    used = [number for number in range(len(GROUPS)) if (doing == number).any()]
    line.legend(
        handles=[Patch(color=GROUP_COLOURS[k], label=tuple(GROUPS)[k]) for k in used],
        loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize=8, frameon=False,
    )  # fmt: skip
    return fig


def _group(state: str) -> int:
    known = [number for number, states in enumerate(GROUPS.values()) if state in states]
    return known[0] if known else 0


def match_twin(result: MatchResult) -> str:
    """A match in one line, for a figure's text twin."""
    share = {name: 0 for name in GROUPS}
    for state in result.states:
        share[tuple(GROUPS)[_group(state)]] += 1
    most = max(share, key=share.get)
    return (
        f"A match: {result.winner} by {result.reason} after {result.ended:.0f} s, {result.points} "
        f"to {result.their_points} points; {result.stored} balls stored; most of the time it "
        f"{most}."
    )
