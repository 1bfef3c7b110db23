"""Where pictures are taken: the game field in a hall, or a ball somewhere in a workshop.

Every hall is painted, lit and cluttered anew from the generator it is given: boards of wood or
grey, walls of panels, concrete or bricks, pipes, people, boxes. Only the field's geometry is fixed.
"""

from __future__ import annotations

import numpy as np

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.vision import paint
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


# --- venues ---------------------------------------------------------------------------------------


def room(scene: Scene, rng: np.random.Generator, low: tuple, high: tuple, ground: float) -> None:
    """Four walls, a ceiling and a ground around everything."""
    scene.textures = [paint.wall_texture(rng), paint.plank_texture(rng), paint.wall_texture(rng)]
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
    scene.add_rect((x0, y0, top), *across, paint.any_colour(rng) * 0.5 + 0.5)
    dull = paint.hsv(rng.uniform(0, 360), rng.uniform(0, 0.2), rng.uniform(0.25, 0.8))
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
    spread = np.clip(rng.normal(1.0, 0.07, (len(paint.PAINTS), 3)), 0.8, 1.2)
    paints = np.clip(np.array(paint.PAINTS) / 255.0 * spread, 0, 1)
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
        colour = paint.any_colour(rng)
        scene.pillars.append(Pillar(np.array(at), size * height, size * radius, colour))
    elif kind == 3 and rng.uniform() < 0.4:
        # Balls of other sports are no balls of ours.
        hue = rng.choice([rng.uniform(20, 160), rng.uniform(20, 160)])
        colour = paint.hsv(hue, rng.uniform(0.0, 0.9), rng.uniform(0.3, 1.0))
        scene.add_ball((x, y, z + RADIUS), colour, -1, rotation(rng))
    else:
        w, d, h = size * np.exp(rng.uniform(np.log(0.08), np.log(0.9), 3))
        low, high = (x - w / 2, y - d / 2, z), (x + w / 2, y + d / 2, z + h)
        look = {"texture": int(rng.choice([-1, -1, 2, 3])), "scale": rng.uniform(0.5, 3.0)}
        colour = paint.any_colour(rng) if look["texture"] != 2 else np.ones(3)
        scene.add_box(low, high, colour, turn=rng.uniform(0, np.pi), **look)


def person(scene: Scene, rng: np.random.Generator, at: tuple) -> None:
    """Two legs, a body, a head."""
    x, y, z = at
    tall = rng.uniform(1.5, 1.9)
    trousers, shirt = paint.any_colour(rng), paint.any_colour(rng)
    skin = paint.hsv(rng.uniform(15, 30), rng.uniform(0.25, 0.6), rng.uniform(0.35, 0.95))
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
    colour = paint.any_colour(rng)
    look = {"texture": int(rng.choice([-1, 2, 3])), "gloss": rng.uniform(0, 0.3)}
    if look["texture"] != -1:
        colour = 0.6 + 0.4 * colour
    scene.add_rect(
        (-w, -d, 0.002), (2 * w, 0, 0), (0, 2 * d, 0), colour, grain=0.1, scale=1.0, **look
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
    white = paint.hsv(rng.uniform(0, 360), rng.uniform(0, 0.08), rng.uniform(0.85, 1.0))
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
        colour = scene_paint(scene, rng, name)
        at = np.array(foot) + middle
        scene.add_ball(at, colour, BALLS.index(name), rotation(rng), cage=len(scene.cages) - 1)


def scene_paint(scene: Scene, rng: np.random.Generator, name: str) -> FloatArray:
    """The paint of one more ball: near that of its brothers in the scene, if there are any."""
    number = BALLS.index(name)
    for ball in scene.balls:
        if ball.label == number:
            return np.clip(ball.colour * rng.normal(1.0, 0.04), 0, 1)
    return paint.ball_colour(name, rng)
