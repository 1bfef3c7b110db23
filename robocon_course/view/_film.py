"""A match as a film: the field from above, the silos beside it, clock, score, and what is done."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageDraw

from robocon_course import field, robot
from robocon_course._arrays import FloatArray
from robocon_course.swerve import field_to_robot, module_targets
from robocon_course.view._record import (
    counts_for,
    holding,
    in_words,
    last_seen,
    own_letter,
    points_at,
)
from robocon_course.view.animation import LARGEST_GIF, as_gif, colour_table, flattened
from robocon_course.view.body import RobotPicture, Shape, ball_shapes, robot_shapes
from robocon_course.view.canvas import MINE, RAW, TRUTH, Animation, colours_of, packed
from robocon_course.view.ground import painted_field
from robocon_course.view.missions import BALL, COLOURS
from robocon_course.view.raster import Pixels, font, paint, rgb, trace

if TYPE_CHECKING:
    from robocon_course.worlds import MatchResult

PER_METRE = 70
PALE = 0.4
"""How far the floor is mixed with white, so that robot and balls stand out."""
WIDTH, HEIGHT = 432, 322
"""Of the piece of field that is seen [pixel]: all of its breadth, 4.6 m of its length."""
HEAD, FOOT, SIDE_BAND = 56, 22, 48
"""Words above and a key below; the silos at the right [pixel]."""
GOES_UP = (1.5, 8.0)
"""Between these y of the robot the view moves from Area 1 up to Area 3 [m]."""
PACES = (10, 13, 17, 25, 34)
"""A picture stays so long: the first with which the file is small enough [0.01 s]."""
LASTS, REST = 30.0, 2.5
"""The longest film, and how long its last picture stays, which is part of it [s]."""
TRAIL, PIECES = 12.0, 4
"""So much of the way is seen behind the robot [s of the match], fading in so many pieces."""
STAYS = 9.0
"""What was last seen stays so long in the line of words [s of the match]."""
STILLS = (0.06, 0.35, 0.7, 1.0)
"""Which pictures stand for the film where nothing can move: shares of it."""
STILLS_WIDTH = 900


def animate_match(result: MatchResult, *, speed: float = 6.0) -> Animation:
    """A match as a film that repeats for ever, for `show`.

    The view goes up the field with the robot and stays at Area 3 with the Storage Zone. Where
    nothing can move, four of its pictures stand for it.

    Parameters
    ----------
    result : MatchResult
        Recorded with its balls: ``play_match(..., with_balls=True)``.
    speed : float
        How many times as fast as it was; faster where the film would last longer than 30 s.

    Returns
    -------
    Animation
        Its GIF has less than a megabyte.

    Raises
    ------
    ValueError
        A match recorded without balls or without a row, a speed that is not positive, or a film
        that stays too large.
    """
    if not len(result.time):
        raise ValueError("result: expected a match with at least one row in its record, got none")
    if len(result.balls) != len(result.time):
        raise ValueError("result: expected a match with its balls; play it with with_balls=True")
    if not 0.0 < speed < np.inf:
        raise ValueError(f"speed: expected a number above 0, got {speed!r}")
    film = _Film(result, max(speed, result.ended / (LASTS - REST)))
    images = [film.picture(now) for now in np.linspace(0.0, result.ended, 9)]
    table = colour_table(images)
    for each in PACES:
        moments = film.moments(each)
        gif = as_gif([flattened(film.picture(t), table) for t in moments], each, REST - each / 100)
        if len(gif) < LARGEST_GIF:
            return Animation(gif, packed(_sheet([film.picture(share * result.ended)
                                                 for share in STILLS])))  # fmt: skip
    raise ValueError(f"result: {len(gif)} bytes even with {len(moments)} pictures; raise speed")


def _sheet(images: list[Image.Image]) -> Image.Image:
    """Pictures in two columns, as wide as a notebook's page."""
    gap = 8
    width, height = images[0].size
    rows = -(-len(images) // 2)
    sheet = Image.new("RGB", (2 * width + gap, rows * (height + gap) - gap), "white")
    for place, image in enumerate(images):
        sheet.paste(image, (place % 2 * (width + gap), place // 2 * (height + gap)))
    return sheet.resize((STILLS_WIDTH, round(STILLS_WIDTH * sheet.height / sheet.width)))


class _Film:
    """Pictures of a match at any time."""

    def __init__(self, result: MatchResult, speed: float) -> None:
        self.result, self.speed = result, speed
        self.letter = own_letter(result)
        self.paints = {"own": BALL[self.letter], "theirs": BALL["RB".replace(self.letter, "")]}
        self.own = next(iter(colours_of([result.parts]).values()), MINE)
        self.holds = holding(result)
        self.angles = wheel_angles(result.time, result.poses)

    def moments(self, each: int) -> list[float]:
        """Times of the pictures where each stays so long [0.01 s]; the last is the match's end."""
        return [*np.arange(0.0, self.result.ended, each / 100 * self.speed), self.result.ended]

    def picture(self, now: float) -> Image.Image:
        """The match at a time [s]."""
        row = max(0, int(np.searchsorted(self.result.time, now, side="right")) - 1)
        image = Image.new("RGB", (WIDTH + SIDE_BAND, HEAD + HEIGHT + FOOT), "white")
        image.paste(Image.fromarray(self._field(row, now)), (0, HEAD))
        pen = ImageDraw.Draw(image)
        self._head(pen, row, now)
        self._silos(pen, now)
        self._foot(pen)
        return image

    def _field(self, row: int, now: float) -> Pixels:
        """The piece of field around the robot with all that lies on it."""
        floor, scale = painted_field(PER_METRE, PALE)
        half = 0.5 * HEIGHT / PER_METRE
        ends = half - field.FENCE_THICKNESS, field.SIZE + field.FENCE_THICKNESS - half
        middle = float(np.interp(self.result.poses[row, 1], GOES_UP, ends))
        top = int(np.clip(scale.bottom - (middle + half) * PER_METRE, 0, len(floor) - HEIGHT))
        piece, here = floor[top : top + HEIGHT, :WIDTH].copy(), scale.moved(0, top)
        edges = np.searchsorted(self.result.time, now - TRAIL * np.linspace(1.0, 0.0, PIECES + 1))
        for k, (first, last) in enumerate(pairwise(edges), 1):
            if last - first > 0:
                bare = piece.copy()
                trace(piece, self.result.poses[first : last + 1, :2], here, self.own, 3)
                piece = (bare + (k / PIECES) * (piece.astype(float) - bare)).astype(np.uint8)
        held = self.paints["own"] if self.holds[row] and now < self.result.ended else ""
        pose, angles = self.result.poses[row], self.angles[row]
        paint(piece, self._balls(row), here)
        paint(piece, robot_shapes(RobotPicture(pose, angles, colour=self.own, gripper=held)), here)
        paint(piece, _silo_rings(), here)
        return piece

    def _balls(self, row: int) -> Iterator[Shape]:
        """Balls on the floor; the empty ones have a pale middle, which every eye tells apart."""
        pairs = zip(self.result.balls[row], self.result.colours[row], strict=True)
        for centre, colour in pairs:
            yield from ball_shapes(centre, COLOURS[colour])
            if colour not in ("red", "blue"):
                yield Shape(_circle(centre, 0.035), "#FFFFFF")

    def _head(self, pen: ImageDraw.ImageDraw, row: int, now: float) -> None:
        """Clock and score above, what the robot does and what was last seen below."""
        result, middle = self.result, (WIDTH + SIDE_BAND) // 2
        over = now >= result.ended
        pen.text((6, 4), f"{int(now) // 60}:{int(now) % 60:02d}", TRUTH, font(20, True))
        pen.text((middle, 4), ":", TRUTH, font(20, True), anchor="ma")
        names = "red", "blue"
        pairs = zip(("own", "theirs"), points_at(result, now), (-1, 1), "rl", strict=True)
        for name, (team, points, side, anchor) in zip(
            names if self.letter == "R" else names[::-1], pairs, strict=True
        ):
            paint = {"fill": self.paints[team], "anchor": f"{anchor}a"}
            pen.text((middle + 9 * side, 4), str(points), font=font(20, True), **paint)
            pen.text((middle + 62 * side, 9), name, font=font(14), **paint)
        pace = f"{self.speed:.3g}× as fast"
        pen.text((WIDTH + SIDE_BAND - 6, 11), pace, "#666666", font(12), anchor="ra")
        words = _outcome(result) if over else in_words(result.states[row])
        pen.text((6, 32), words, TRUTH, font(15, over))
        if not over:
            told = last_seen(result, now, now - STAYS)
            colour = self.paints["theirs" if told.startswith("their") else "own"]
            pen.text((WIDTH + SIDE_BAND - 6, 32), told, colour, font(15), anchor="ra")

    def _silos(self, pen: ImageDraw.ImageDraw, now: float) -> None:
        """The five silos as stacks of balls, each at the height of its silo in Area 3."""
        for k, filling in enumerate(self.result.fillings_at(now)):
            row = HEAD + (field.SIZE + field.FENCE_THICKNESS - field.SILOS[k][1]) * PER_METRE
            good = counts_for(filling)
            box = [WIDTH + 21, row - 24, WIDTH + 41, row + 24]
            rim = BALL.get(good, RAW)
            pen.rounded_rectangle(box, 4, "white", rim, 3 if good else 1)
            pen.text((WIDTH + 10, row), str(k + 1), TRUTH, font(14, bool(good)), anchor="mm")
            for level, letter in enumerate(filling):
                _disc(pen, WIDTH + 31, row + 15 - 15 * level, 6, BALL[letter])

    def _foot(self, pen: ImageDraw.ImageDraw) -> None:
        """What the colours mean."""
        row, words = HEAD + HEIGHT + FOOT // 2, {"fill": TRUTH, "font": font(12), "anchor": "lm"}
        for left, colour, name in (
            (12, self.paints["own"], "own ball"), (92, COLOURS["purple"], "empty"),
            (158, self.paints["theirs"], "theirs"),
        ):  # fmt: skip
            _disc(pen, left, row, 6, colour)
            pen.text((left + 11, row), name, **words)
        _disc(pen, 92, row, 2, "#FFFFFF")
        pen.rounded_rectangle([222, row - 7, 232, row + 7], 3, "white", self.paints["own"], 3)
        pen.text((238, row), "silo that counts: three are Mua Vang", **words)


def _outcome(result: MatchResult) -> str:
    how = {"own": "won", "theirs": "lost", "nobody": "a draw"}[result.winner]
    return f"{how} by {result.reason}"


def _disc(pen: ImageDraw.ImageDraw, x: float, y: float, radius: float, colour: str) -> None:
    pen.ellipse([x - radius, y - radius, x + radius, y + radius], rgb(colour))


def _circle(centre: FloatArray, radius: float) -> FloatArray:
    turn = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    return np.asarray(centre) + radius * np.column_stack([np.cos(turn), np.sin(turn)])


def _silo_rings() -> Iterator[Shape]:
    for silo in field.SILOS:
        yield Shape(_circle(np.array(silo), field.SILO_DIAMETER / 2), TRUTH)
        yield Shape(_circle(np.array(silo), field.SILO_BORE / 2 - 0.02), "#FFFFFF")


def wheel_angles(time: FloatArray, poses: FloatArray) -> FloatArray:
    """How the modules of a robot stand that moved like this: its record does not hold them.

    Parameters
    ----------
    time : ndarray, shape (n,)  [s]
    poses : ndarray, shape (n, 3)  [m, m, rad; map]

    Returns
    -------
    ndarray, shape (n, 4)  [rad, base]
        A wheel that stands keeps its angle, at first 0.
    """
    if len(time) < 2:
        return np.zeros((len(time), len(robot.MODULES)))
    turned = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    twists = np.gradient(turned, time, axis=0)
    twists = field_to_robot(twists, poses[:, 2])
    twists[np.abs(twists).max(axis=1) < 0.02] = 0.0
    speeds, angles = module_targets(robot.MODULES, twists, np.zeros((len(time), 4)))
    rows = np.where(speeds > 0.0, np.arange(len(time))[:, None], 0)
    return np.take_along_axis(angles, np.maximum.accumulate(rows), axis=0)
