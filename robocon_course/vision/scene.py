"""What stands in front of the camera: a list of flat rectangles, balls, cages and pillars.

Map frame, metres. Colours are sRGB, 0 to 1, as a paint would look in white light of full strength.
A scene is built by adding things; `packed` hands it to the renderer as plain arrays.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.field import BALL_DIAMETER, SILO_BORE, SILO_CAPACITY, SILO_DIAMETER

RADIUS = BALL_DIAMETER / 2
NO_TEXTURE, FIELD_MAP = -1, 0
"""Which picture a rectangle wears; 1 and up are `Scene.textures`."""


class Ball(NamedTuple):
    """A ball: where its middle is, its colour, how it lies (rotation of its pattern)."""

    centre: FloatArray
    colour: FloatArray
    turn: FloatArray
    label: int
    cage: int


class Cage(NamedTuple):
    """A silo: an open cage of rings on posts.

    Attributes
    ----------
    foot : ndarray, shape (3,)  [m, map]
        Middle of its base.
    rings : ndarray, shape (4,)  [m]
        Heights of the rings' middles above the base; the posts end at the last.
    ring, post : float  [m]
        Height of a ring's tube, width of a post.
    posts : int
    turn : float  [rad]
        Bearing of the first post.
    colour : ndarray, shape (3,)
    filling : int
        Class number of what is in it.
    """

    foot: FloatArray
    rings: FloatArray
    ring: float
    post: float
    posts: int
    turn: float
    colour: FloatArray
    filling: int


class Pillar(NamedTuple):
    """An upright cylinder: a pipe, a bottle, a leg, a body. Rounded off at the top or flat."""

    foot: FloatArray
    height: float
    radius: float
    colour: FloatArray


class Lamp(NamedTuple):
    """A lamp far away: direction to it (unit vector, map) and its light (linear RGB)."""

    direction: FloatArray
    light: FloatArray


@dataclass
class Scene:
    """Everything that a camera could see.

    Attributes
    ----------
    rects : list of ndarray, shape (18,)
        Origin, two perpendicular edges, colour, texture, its scale [1/m] and shift, grain, gloss.
    balls, cages, pillars, lamps : list
    textures : list of ndarray of uint8, shape (h, w, 3)
        sRGB, repeated endlessly.
    ambient : ndarray, shape (3,)
        Light from everywhere, linear RGB.
    field_colours : ndarray, shape (k, 3), or None
        Paints of the field map, by the numbers of `paint.field_map`.
    low, high : (float, float)  [m, map]
        Corners of the room.
    """

    rects: list[FloatArray] = field(default_factory=list)
    balls: list[Ball] = field(default_factory=list)
    cages: list[Cage] = field(default_factory=list)
    pillars: list[Pillar] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)
    textures: list[NDArray[np.uint8]] = field(default_factory=list)
    ambient: FloatArray = field(default_factory=lambda: np.full(3, 0.5))
    field_colours: FloatArray | None = None
    low: tuple[float, float] = (-np.inf, -np.inf)
    high: tuple[float, float] = (np.inf, np.inf)

    def add_rect(
        self,
        origin: Sequence[float],
        u: Sequence[float],
        v: Sequence[float],
        colour: Sequence[float],
        *,
        texture: int = NO_TEXTURE,
        scale: float = 1.0,
        shift: tuple[float, float] = (0.0, 0.0),
        grain: float = 0.08,
        gloss: float = 0.0,
    ) -> None:
        """A flat rectangle with a corner and two edges; seen from both sides."""
        row = [*origin, *u, *v, *colour, texture, scale, *shift, grain, gloss]
        self.rects.append(np.array(row, dtype=float))

    def add_box(
        self,
        low: Sequence[float],
        high: Sequence[float],
        colour: Sequence[float],
        *,
        turn: float = 0.0,
        **look: float,
    ) -> None:
        """A box without a bottom from its low to its high corner, turned about its middle [rad]."""
        (x0, y0, z0), (x1, y1, z1) = low, high
        mx, my = (x0 + x1) / 2, (y0 + y1) / 2
        c, s = np.cos(turn), np.sin(turn)
        a = np.array([c, s, 0.0]) * (x1 - x0)
        b = np.array([-s, c, 0.0]) * (y1 - y0)
        up = np.array([0.0, 0.0, z1 - z0])
        corner = np.array([mx, my, z0]) - (a + b) / 2
        self.add_rect(corner + up, a, b, colour, **look)
        for origin, edge in ((corner, a), (corner + b, a), (corner, b), (corner + a, b)):
            self.add_rect(origin, edge, up, colour, **look)

    def add_ball(
        self, centre: Sequence[float], colour: FloatArray, label: int, turn: FloatArray, cage=-1
    ) -> None:
        """A ball; `label` is its class, -1 for one that no network shall report."""
        self.balls.append(Ball(np.asarray(centre, float), colour, turn, label, cage))

    def held(self, cage: int) -> list[int]:
        """Numbers of the balls in a silo, from bottom to top."""
        return [number for number, ball in enumerate(self.balls) if ball.cage == cage]

    def next_place(self, cage: int) -> FloatArray | None:
        """Middle of one more ball in a silo, taken on its axis [m, map]; None if it is full."""
        held, middle = self.held(cage), self.cages[cage].foot + np.array([0.0, 0.0, RADIUS])
        if len(held) == SILO_CAPACITY:
            return None
        if held:
            middle[2] = self.balls[held[-1]].centre[2] + BALL_DIAMETER
        return middle

    def packed(self) -> Packed:
        """The scene as arrays, for the renderer."""
        balls, cages, pillars = self.balls, self.cages, self.pillars
        rects = np.array(self.rects).reshape(-1, 18)
        u, v = rects[:, 3:6], rects[:, 6:9]
        long = np.linalg.norm(u, axis=1, keepdims=True), np.linalg.norm(v, axis=1, keepdims=True)
        u, v = u / long[0], v / long[1]
        rects = np.hstack(
            [rects[:, :3], u, v, np.cross(u, v), *long, linear(rects[:, 9:12]), rects[:, 12:]]
        )
        return Packed(
            rects=rects.astype(np.float32),
            balls=_rows([np.r_[b.centre, linear(b.colour), b.turn.ravel()] for b in balls], 15),
            cages=_rows(
                [
                    np.r_[c.foot, c.rings, c.ring, c.post, c.posts, c.turn, linear(c.colour)]
                    for c in cages
                ],
                14,
            ),
            pillars=_rows(
                [np.r_[p.foot, p.height, p.radius, linear(p.colour)] for p in pillars], 8
            ),
            lamps=_rows([np.r_[lamp.direction, lamp.light] for lamp in self.lamps], 6),
            ambient=np.asarray(self.ambient, np.float32),
        )


class Packed(NamedTuple):
    """A scene as float32 arrays, one row a thing, colours linear; columns as in the classes above.

    Rectangles: origin, unit edges and normal (columns 0 to 11), the edges' lengths (12, 13), colour
    (14 to 16), texture (17), its scale and shift (18 to 20), grain (21), gloss (22).
    """

    rects: NDArray[np.float32]
    balls: NDArray[np.float32]
    cages: NDArray[np.float32]
    pillars: NDArray[np.float32]
    lamps: NDArray[np.float32]
    ambient: NDArray[np.float32]


def linear(colour: FloatArray) -> FloatArray:
    """Light of an sRGB colour (0 to 1), its curve taken as a power of 2.2."""
    return np.asarray(colour) ** 2.2


def _rows(rows: list[FloatArray], width: int) -> NDArray[np.float32]:
    return np.array(rows, dtype=np.float32).reshape(len(rows), width)


def stack(rng: np.random.Generator, count: int) -> FloatArray:
    """Middles of balls dropped into a silo, each leaning on the cage and on the one below.

    Parameters
    ----------
    rng : numpy.random.Generator
    count : int

    Returns
    -------
    ndarray, shape (count, 3)  [m]
        From the middle of the silo's base.
    """
    play = (SILO_BORE - BALL_DIAMETER) / 2
    middles = np.empty((count, 3))
    bearing = rng.uniform(0.0, 2 * np.pi)
    for k in range(count):
        aside = play * np.sqrt(rng.uniform()) if k == 0 else play
        middles[k, :2] = aside * np.cos(bearing), aside * np.sin(bearing)
        if k == 0:
            middles[k, 2] = RADIUS
        else:
            away = float(np.hypot(*(middles[k, :2] - middles[k - 1, :2])))
            middles[k, 2] = middles[k - 1, 2] + np.sqrt(BALL_DIAMETER**2 - away**2)
        bearing += np.pi + rng.normal(0.0, 0.8)
    return middles


CAGE_RADIUS = SILO_DIAMETER / 2
