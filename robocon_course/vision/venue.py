"""Where pictures are taken: the game field in a hall, or a ball somewhere in a workshop.

Every hall is painted, lit and cluttered anew from the generator it is given: boards of wood or
grey, walls of panels, concrete or bricks, pipes, people, boxes. Only the field's geometry is fixed.
"""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.scene import (
    FIELD_MAP,
    RADIUS,
    Cage,
    Lamp,
    Pillar,
    Scene,
    stack,
)
from robocon_course.vision.shading import TILE

MAP_RESOLUTION = 0.005

_PAINTS = (
    field.ORANGE, field.GREEN, field.YELLOW, field.WATER_BLUE, field.GREY, field.WHITE,
    field.RED, field.BLUE,
)  # fmt: skip


@cache
def field_map() -> NDArray[np.uint8]:
    """Which paint lies in each cell of the field, by number; row 0 at the smallest y."""
    pixels = field.picture(MAP_RESOLUTION)
    numbers = np.zeros(pixels.shape[:2], np.uint8)
    for k, paint in enumerate(_PAINTS):
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


def rotation(rng: np.random.Generator) -> FloatArray:
    """A rotation matrix, every one as likely."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    return q * np.sign(np.diag(r))


# --- light ----------------------------------------------------------------------------------------


def light_up(scene: Scene, rng: np.random.Generator) -> None:
    """Lamps overhead, one of them strong, and light from everywhere."""
    warm = rng.normal(0.0, 0.08)
    tint = np.array([1.0 + warm, 1.0, 1.0 - warm])
    total = rng.uniform(0.5, 1.1)
    for k in range(int(rng.integers(1, 5))):
        bearing, high = rng.uniform(0, 2 * np.pi), rng.uniform(0.35, 1.5)
        way = (np.cos(bearing) * np.cos(high), np.sin(bearing) * np.cos(high), np.sin(high))
        scene.lamps.append(Lamp(np.array(way), tint * total * (1.0 if k == 0 else 0.4)))
    scene.ambient = np.array(tint * rng.uniform(0.4, 0.9))


# --- textures -------------------------------------------------------------------------------------


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


# --- venues ---------------------------------------------------------------------------------------


def room(scene: Scene, rng: np.random.Generator, low: tuple, high: tuple, ground: float) -> None:
    """Four walls, a ceiling and a ground around everything."""
    scene.textures = [wall_texture(rng), plank_texture(rng), wall_texture(rng)]
    scene.low, scene.high = low, high
    (x0, y0), (x1, y1) = low, high
    top = ground + rng.uniform(2.5, 7.0)
    tall = top - ground
    for origin, edge in (
        ((x0, y0, ground), (x1 - x0, 0, 0)),
        ((x0, y1, ground), (x1 - x0, 0, 0)),
        ((x0, y0, ground), (0, y1 - y0, 0)),
        ((x1, y0, ground), (0, y1 - y0, 0)),
    ):
        look = {"texture": int(rng.choice([1, 3])), "scale": 1.0 / rng.uniform(1.5, 6.0)}
        scene.add_rect(
            origin, edge, (0, 0, tall), (1, 1, 1), shift=tuple(rng.uniform(0, 1, 2)), **look
        )
    across = ((x1 - x0, 0, 0), (0, y1 - y0, 0))
    scene.add_rect((x0, y0, top), *across, any_colour(rng) * 0.5 + 0.5)
    dull = hsv(rng.uniform(0, 360), rng.uniform(0, 0.2), rng.uniform(0.25, 0.8))
    scene.add_rect((x0, y0, ground), *across, dull, grain=0.12, gloss=rng.uniform(0, 0.2))


def field_hall(rng: np.random.Generator) -> Scene:
    """The game field in a hall of its own, without balls and silos."""
    scene = Scene()
    light_up(scene, rng)
    gap = np.exp(rng.uniform(np.log(0.4), np.log(5.0), 4))
    room(scene, rng, (-gap[0], -gap[1]), (12 + gap[2], 12 + gap[3]), 0.0)
    _floor(scene, rng)
    _boards(scene, rng)
    _bystanders(scene, rng)
    return scene


def _floor(scene: Scene, rng: np.random.Generator) -> None:
    """The terraces, both halves, in this hall's paints."""
    spread = np.clip(rng.normal(1.0, 0.07, (len(_PAINTS), 3)), 0.8, 1.2)
    paints = np.clip(np.array(_PAINTS) / 255.0 * spread, 0, 1)
    # As cameras see them: the green darker, the yellow deeper than drawn.
    paints[1] *= rng.uniform(0.65, 1.0)
    paints[2] *= np.array([0.92, rng.uniform(0.85, 1.0), rng.uniform(0.25, 1.0)])
    scene.field_colours = paints
    look = {"texture": FIELD_MAP, "grain": rng.uniform(0.02, 0.08), "gloss": rng.uniform(0, 0.35)}
    for rect in (*field.FLOOR, field.RAMP_1, field.RAMP_2, field.WATER):
        for mirrored in (False, True):
            x0, x1 = (12 - rect.x1, 12 - rect.x0) if mirrored else (rect.x0, rect.x1)
            z0, rise = rect.height, rect.slope[0] * (x1 - x0)
            if mirrored:
                z0, rise = z0 + rise, -rise
            up = rect.slope[1] * (rect.y1 - rect.y0)
            u, v = (x1 - x0, 0.0, rise), (0.0, rect.y1 - rect.y0, up)
            scene.add_rect((x0, rect.y0, z0), u, v, (1, 1, 1), **look)
    zone = scene.field_colours[2 if rng.uniform() < 0.6 else 4]
    strip = field.SILO_ZONE
    scene.add_box(
        (strip.x0, strip.y0, 0.0), (strip.x1, strip.y1, strip.height + 0.001), zone,
        grain=look["grain"], gloss=look["gloss"],
    )  # fmt: skip
    for x0, x1, y, z0, z1, number in (
        (1.0, 11.0, 4.0, 0.05, 0.15, 0), (4.8, 7.2, 8.0, 0.15, 0.25, 1)
    ):  # fmt: skip
        scene.add_rect((x0, y, z0), (x1 - x0, 0, 0), (0, 0, z1 - z0), scene.field_colours[number])


def _boards(scene: Scene, rng: np.random.Generator) -> None:
    """Fences and frames: bare wood, grey, or painted."""
    wood = rng.uniform() < 0.6
    colour = (
        np.ones(3) if wood else np.clip(field.GREY / np.array(255.0) * rng.uniform(0.5, 1.3), 0, 1)
    )
    look = {"texture": 2, "scale": 0.7} if wood else {"grain": 0.05}
    rise = rng.uniform(0.0, 0.08)
    for fence in (*field.FENCES, field.WATER_BACK):
        for mirrored in (False, True):
            x0, x1 = (12 - fence.x1, 12 - fence.x0) if mirrored else (fence.x0, fence.x1)
            top = fence.height + rise
            scene.add_box((x0, fence.y0, 0.0), (x1, fence.y1, top), colour, **look)
    if rng.uniform() < 0.5:
        for y in (0.0, 4.0):
            low = field.DIVIDER_1 if y == 0.0 else field.DIVIDER_2
            scene.add_box((low.x0, low.y0, 0.0), (low.x1, low.y1, low.height), colour, **look)


def _bystanders(scene: Scene, rng: np.random.Generator) -> None:
    """People, pipes, boxes and bags beyond the fences."""
    for _ in range(int(rng.integers(3, 14))):
        side = rng.integers(0, 4)
        along, away = rng.uniform(0, 12), rng.uniform(0.3, 3.0)
        x, y = [(along, -away), (along, 12 + away), (-away, along), (12 + away, along)][side]
        thing(scene, rng, (x, y, 0.0))


def thing(scene: Scene, rng: np.random.Generator, at: tuple, size: float = 1.0) -> None:
    """Something that stands about: a person, a pipe or post, a box, a ball of another colour."""
    x, y, z = at
    kind = rng.integers(0, 6)
    if kind == 0:
        person(scene, rng, at)
    elif kind <= 2:
        radius, height = np.exp(rng.uniform(np.log(0.015), np.log(0.15))), rng.uniform(0.1, 2.5)
        scene.pillars.append(Pillar(np.array(at), size * height, size * radius, any_colour(rng)))
    elif kind == 3 and rng.uniform() < 0.4:
        # Balls of other sports are no balls of ours.
        hue = rng.choice([rng.uniform(20, 160), rng.uniform(20, 160)])
        paint = hsv(hue, rng.uniform(0.0, 0.9), rng.uniform(0.3, 1.0))
        scene.add_ball((x, y, z + RADIUS), paint, -1, rotation(rng))
    else:
        w, d, h = size * np.exp(rng.uniform(np.log(0.08), np.log(0.9), 3))
        low, high = (x - w / 2, y - d / 2, z), (x + w / 2, y + d / 2, z + h)
        look = {"texture": int(rng.choice([-1, -1, 2, 3])), "scale": rng.uniform(0.5, 3.0)}
        colour = any_colour(rng) if look["texture"] != 2 else np.ones(3)
        scene.add_box(low, high, colour, turn=rng.uniform(0, np.pi), **look)


def person(scene: Scene, rng: np.random.Generator, at: tuple) -> None:
    """Two legs, a body, a head."""
    x, y, z = at
    tall = rng.uniform(1.5, 1.9)
    trousers, shirt = any_colour(rng), any_colour(rng)
    skin = hsv(rng.uniform(15, 30), rng.uniform(0.25, 0.6), rng.uniform(0.35, 0.95))
    bearing = rng.uniform(0, np.pi)
    for sign in (-0.1, 0.1):
        foot = np.array([x + sign * np.cos(bearing), y + sign * np.sin(bearing), z])
        scene.pillars.append(Pillar(foot, 0.48 * tall, 0.08, trousers))
    scene.pillars.append(Pillar(np.array([x, y, z + 0.47 * tall]), 0.33 * tall, 0.19, shirt))
    scene.pillars.append(Pillar(np.array([x, y, z + 0.85 * tall]), 0.1 * tall, 0.09, skin))


def workshop(rng: np.random.Generator) -> Scene:
    """A floor or bench with things on it, nowhere near the field."""
    scene = Scene()
    light_up(scene, rng)
    reach = rng.uniform(1.5, 5.0, 4)
    room(scene, rng, (-reach[0], -reach[1]), (reach[2], reach[3]), -rng.choice([0.0, 0.8]))
    w, d = rng.uniform(0.6, 2.5, 2)
    paint = any_colour(rng)
    look = {"texture": int(rng.choice([-1, 2, 3])), "gloss": rng.uniform(0, 0.3)}
    if look["texture"] != -1:
        paint = 0.6 + 0.4 * paint
    scene.add_rect(
        (-w, -d, 0.002), (2 * w, 0, 0), (0, 2 * d, 0), paint, grain=0.1, scale=1.0, **look
    )  # fmt: skip
    for _ in range(int(rng.integers(2, 14))):
        x, y = rng.uniform(-1.2, 1.2, 2)
        if np.hypot(x, y) > 0.3:
            thing(scene, rng, (x, y, 0.0), size=rng.uniform(0.2, 0.7))
    return scene


# --- silos and balls ------------------------------------------------------------------------------


def silo_make(rng: np.random.Generator) -> Cage:
    """How the silos of one field are built; all five are alike."""
    top = rng.uniform(0.395, 0.44)
    rings = top - rng.uniform(0.105, 0.14) * np.array([3.0, 2.0, 1.0, 0.0])
    white = hsv(rng.uniform(0, 360), rng.uniform(0, 0.08), rng.uniform(0.85, 1.0))
    return Cage(
        np.zeros(3), np.maximum(rings, 0.008), rng.uniform(0.009, 0.026),
        rng.uniform(0.008, 0.018), int(rng.integers(3, 6)), 0.0, white, 0,
    )  # fmt: skip


def add_silo(scene: Scene, rng: np.random.Generator, foot: tuple, label: int, make: Cage) -> None:
    """A silo of a make, with the balls of the filling `SILOS[label]`."""
    turn = rng.uniform(0, 2 * np.pi)
    scene.cages.append(make._replace(foot=np.array(foot), turn=turn, filling=label))
    balls = "" if label == 0 else SILOS[label]
    for middle, letter in zip(stack(rng, len(balls)), balls, strict=True):
        name = {"B": "blue", "R": "red"}[letter]
        paint = scene_paint(scene, rng, name)
        at = np.array(foot) + middle
        scene.add_ball(at, paint, BALLS.index(name), rotation(rng), cage=len(scene.cages) - 1)


def scene_paint(scene: Scene, rng: np.random.Generator, name: str) -> FloatArray:
    """The paint of one more ball: near that of its brothers in the scene, if there are any."""
    number = BALLS.index(name)
    for ball in scene.balls:
        if ball.label == number:
            return np.clip(ball.colour * rng.normal(1.0, 0.04), 0, 1)
    return ball_colour(name, rng)
