"""Paint: the field's, the balls', and whatever walls and things are covered with.

Colours are sRGB, 0 to 1, as three numbers.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.vision.shading import TILE

MAP_RESOLUTION = 0.005

PAINTS = (
    field.ORANGE, field.GREEN, field.YELLOW, field.WATER_BLUE, field.GREY, field.WHITE,
    field.RED, field.BLUE,
)  # fmt: skip


@cache
def field_map() -> NDArray[np.uint8]:
    """Which paint lies in each cell of the field, by number; row 0 at the smallest y."""
    pixels = field.picture(MAP_RESOLUTION)
    numbers = np.zeros(pixels.shape[:2], np.uint8)
    for k, paint in enumerate(PAINTS):
        numbers[(pixels == np.array(paint, np.uint8)).all(axis=2)] = k
    return numbers


@cache
def grain() -> NDArray[np.float32]:
    """Noise around 0 with structure at several sizes; repeats without a seam."""
    rng = np.random.default_rng(2024)
    total = np.zeros((TILE, TILE), np.float32)
    for cells in (4, 16, 64, 256):
        noise = rng.normal(size=(cells, cells)).astype(np.float32)
        wrapped = np.pad(noise, 1, mode="wrap")
        step = TILE // cells
        large = cv2.resize(wrapped, None, fx=step, fy=step, interpolation=cv2.INTER_CUBIC)
        total += large[step : step + TILE, step : step + TILE]
    return total


def hsv(hue: float, saturation: float, value: float) -> FloatArray:
    """sRGB of a colour; hue in degrees."""
    k = (np.array([5.0, 3.0, 1.0]) + hue / 60.0) % 6.0
    return value * (1.0 - saturation * np.clip(np.minimum(k, 4.0 - k), 0.0, 1.0))


def ball_colour(name: str, rng: np.random.Generator) -> FloatArray:
    """A ball's paint: as drawn in the rules, spread as far as cameras and makers spread it."""
    if name == "blue":
        return hsv(rng.normal(219.0, 5.0), rng.uniform(0.66, 0.92), rng.uniform(0.5, 0.9))
    if name == "red":
        return hsv(
            float(np.clip(rng.normal(353.0, 4.0), 344.0, 363.0)),
            rng.uniform(0.66, 0.88),
            rng.uniform(0.6, 0.95),
        )
    # "Purple" runs from violet to magenta.
    return hsv(rng.uniform(257.0, 307.0), rng.uniform(0.42, 0.78), rng.uniform(0.45, 0.85))


def any_colour(rng: np.random.Generator) -> FloatArray:
    """Mostly dull, sometimes gaudy."""
    if rng.uniform() < 0.55:
        return hsv(rng.uniform(0, 360), rng.uniform(0.0, 0.25), rng.uniform(0.1, 0.95))
    return hsv(rng.uniform(0, 360), rng.uniform(0.3, 1.0), rng.uniform(0.15, 0.95))


def wall_texture(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Panels with joints, concrete, bricks, or a jumble of things; sRGB."""
    base = hsv(rng.uniform(0, 360), rng.uniform(0.0, 0.15), rng.uniform(0.2, 0.9))
    rough = np.roll(grain(), tuple(rng.integers(0, TILE, 2)), (0, 1))[..., None]
    tile = _bytes(base.astype(np.float32) * (1.0 + 0.08 * rough))
    style = rng.integers(0, 4)
    joint = _bytes(base * rng.choice([0.5, 0.75, 1.4, 1.8])).tolist()
    if style == 0:
        step = int(rng.integers(24, 100))
        for x in range(int(rng.integers(0, step)), TILE, step):
            cv2.line(tile, (x, 0), (x, TILE), joint, int(rng.integers(1, 5)))
    elif style == 1:
        step = int(rng.integers(12, 50))
        for k, y in enumerate(range(0, TILE, step)):
            cv2.line(tile, (0, y), (TILE, y), joint, 1)
            for x in range(step * (k % 2), TILE, 2 * step):
                cv2.line(tile, (x, y), (x, y + step), joint, 1)
    clutter(tile, rng, int(rng.integers(0, 7)) if style < 3 else int(rng.integers(15, 50)))
    return tile


def _bytes(colour: FloatArray) -> NDArray[np.uint8]:
    return (
        cv2.convertScaleAbs(colour, alpha=255.0)
        if colour.ndim == 3
        else np.uint8(np.clip(colour * 255.0, 0, 255))
    )


def clutter(tile: NDArray[np.uint8], rng: np.random.Generator, count: int) -> None:
    """Posters, doors, pipes, cables and letters on a wall."""
    for _ in range(count):
        colour = _bytes(any_colour(rng)).tolist()
        x, y = (int(v) for v in rng.integers(0, TILE, 2))
        w, h = (int(v) for v in np.exp(rng.uniform(1.0, 4.5, 2)))
        kind = rng.integers(0, 6)
        if kind <= 1:
            cv2.rectangle(tile, (x, y), (x + w, y + h), colour, -1)
        elif kind == 2:
            cv2.rectangle(tile, (x, y), (x + w, y + h), colour, int(rng.integers(1, 4)))
        elif kind == 3:
            cv2.line(tile, (x, y), (x + w, y + h), colour, int(rng.integers(1, 8)))
        elif kind == 4:
            cv2.ellipse(tile, (x, y), (w, max(2, h // 3)), 30.0 * w, 0, 360, colour, 2)
        else:
            word = "".join(chr(65 + k) for k in rng.integers(0, 26, 4))
            cv2.putText(tile, word, (x, y), 0, 0.3 + w / 80, colour, 1)


def plank_texture(rng: np.random.Generator) -> NDArray[np.uint8]:
    """Wood, plywood or cardboard: grain drawn out along one side; sRGB."""
    base = hsv(rng.uniform(25, 42), rng.uniform(0.15, 0.5), rng.uniform(0.5, 0.9))
    lines = cv2.blur(np.roll(grain(), int(rng.integers(TILE)), 0), (63, 1))
    return _bytes(base.astype(np.float32) * (1.0 + 0.25 * lines[..., None]))
