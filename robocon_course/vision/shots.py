"""Which pictures are taken: scenes a robot or a person with a camera would come upon."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.vision import venue
from robocon_course.vision.camera import Camera, view_towards
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.scene import RADIUS, Scene

Shot = tuple[Scene, Camera, FloatArray]


class Subject(NamedTuple):
    """What a picture is about, and from where it is looked at.

    Attributes
    ----------
    scene : Scene
    target : ndarray, shape (3,)  [m, map]
    near, far : float  [m]
        Least and greatest distance of the camera along the floor.
    bearing : float or None  [rad, map]
        From the target to the camera; None is any.
    spread : float  [rad]
        Standard deviation of the bearing.
    """

    scene: Scene
    target: FloatArray
    near: float
    far: float
    bearing: float | None = None
    spread: float = 0.0


def shot(kind: str, rng: np.random.Generator, size: tuple[int, int]) -> Shot:
    """A scene, a camera, and where it is.

    Parameters
    ----------
    kind : {"ball", "silo"}
        What the picture is mostly about.
    rng : numpy.random.Generator
    size : (int, int)  [pixels]
        Width and height of the picture.
    """
    # Now and then a picture of nothing, which a network has to leave alone.
    if rng.uniform() < 0.05:
        makes = [_nothing]
        weights = [1.0]
    elif kind == "ball":
        makes, weights = [_pile, _strewn, _silos, _bench], [0.3, 0.35, 0.2, 0.15]
    else:
        makes, weights = [_row_of_silos, _one_silo, _silo_anywhere], [0.5, 0.35, 0.15]
    subject = makes[rng.choice(len(makes), p=weights)](rng)
    scene = subject.scene
    # A phone held upright or a wide webcam: what matters is the angle seen across.
    camera = Camera.with_view(rng.uniform(0.75, 1.35), *size, rng.uniform(-0.12, 0.02))
    strict = rng.uniform() < 0.8
    for _ in range(50):
        lens = _lens(rng, subject)
        off = 0.12 * np.linalg.norm(lens - subject.target)
        aim = subject.target + rng.normal(0, off, 3)
        roll = _roll(kind, rng)
        T_map_camera = view_towards(lens, aim, roll)
        if _is_free(scene, lens) and not (strict and _cuts_a_silo(scene, camera, T_map_camera)):
            break
    return scene, camera, T_map_camera


def _roll(kind: str, rng: np.random.Generator) -> float:
    """Nearly upright; for balls, which look alike from all sides, now and then not at all."""
    if kind == "silo":
        return rng.normal(0, 0.06)
    return rng.normal(0, 0.04) if rng.uniform() < 0.85 else rng.uniform(-np.pi, np.pi) * 0.5


def _cuts_a_silo(scene: Scene, camera: Camera, T_map_camera: FloatArray) -> bool:
    """Whether the border runs through a silo, so that nobody could say what is in it."""
    size = np.array([camera.width, camera.height])
    for cage in scene.cages:
        middle = cage.foot + np.array([0.0, 0.0, 0.26])
        at = (middle - T_map_camera[:3, 3]) @ T_map_camera[:3, :3]
        if at[2] < 0.1:
            continue
        ends = camera.pixels([at - T_map_camera[2, :3] * 0.26, at + T_map_camera[2, :3] * 0.26])
        if np.isnan(ends).any():
            continue
        half = 0.13 * camera.focal / at[2]
        low, high = ends.min(axis=0) - half * 0.7, ends.max(axis=0) + half * 0.7
        inside = np.clip(np.minimum(high, size) - np.maximum(low, 0.0), 0.0, None)
        share = float(np.prod(inside / (high - low)))
        if 0.05 < share < 0.85:
            return True
    return False


def _lens(rng: np.random.Generator, subject: Subject) -> FloatArray:
    """A place for the camera: on the robot, or in somebody's hand."""
    target = subject.target
    if subject.bearing is None:
        bearing = rng.uniform(0, 2 * np.pi)
    else:
        bearing = subject.bearing + rng.normal(0, subject.spread)
    away = np.exp(rng.uniform(np.log(subject.near), np.log(subject.far)))
    up = rng.uniform(0.2, 0.7) if rng.uniform() < 0.6 else rng.uniform(0.5, 1.6)
    floor = min(0.25, float(target[2]))
    return np.array(
        [target[0] + away * np.cos(bearing), target[1] + away * np.sin(bearing), floor + up]
    )


def _is_free(scene: Scene, lens: FloatArray) -> bool:
    """Whether the lens is in the room, and nothing round is about to touch it."""
    if not ((np.array(scene.low) + 0.1 < lens[:2]) & (lens[:2] < np.array(scene.high) - 0.1)).all():
        return False
    near = [b.centre for b in scene.balls] + [c.foot + np.array([0, 0, 0.2]) for c in scene.cages]
    near += [np.r_[p.foot[:2], lens[2]] for p in scene.pillars]
    return all(np.linalg.norm(lens - p) > 0.2 for p in near)


def _floor_at(x: float, y: float) -> float:
    x = x if x < 6 else 12 - x
    return float(field.floor_height(np.clip(x, 0.0, 5.8), np.clip(y, 0.0, 11.99)))


def _ball(scene: Scene, rng: np.random.Generator, x: float, y: float, name: str) -> FloatArray:
    """One more ball on the floor; returns its middle."""
    z = _floor_at(x, y) if scene.field_colours is not None else 0.0
    paint = venue.scene_paint(scene, rng, name)
    scene.add_ball((x, y, z + RADIUS), paint, BALLS.index(name), venue.rotation(rng))
    return scene.balls[-1].centre


def _pile(rng: np.random.Generator) -> Subject:
    """The 16 balls of a Storage Zone, whole or already partly taken and kicked about."""
    scene = venue.field_hall(rng)
    own = str(rng.choice(["blue", "red"]))
    names = rng.permutation([own] * 6 + ["purple"] * 10)
    broken = rng.uniform() < 0.5
    mirrored = rng.uniform() < 0.5
    for (x, y), name in zip(field.PILE_BALLS, names, strict=True):
        if broken and rng.uniform() < 0.4:
            if rng.uniform() < 0.5:
                continue
            x, y = _apart(scene, rng, lambda: rng.uniform((0.15, 8.2), (2.1, 11.8)))
        _ball(scene, rng, 12 - x if mirrored else x, y, str(name))
    for _ in range(int(rng.integers(0, 4))):
        x, y = _apart(scene, rng, lambda: rng.uniform((0.15, 8.2), (2.1, 11.8)))
        other = str(rng.choice(["blue", "red"]))
        _ball(scene, rng, 12 - x if mirrored else x, y, other)
    target = np.array([10.875 if mirrored else 1.125, 10.0, 0.2])
    return Subject(scene, target, 0.9, 4.0, np.pi if mirrored else 0.0, 0.9)


def _apart(
    scene: Scene, rng: np.random.Generator, draw: Callable[[], FloatArray]
) -> tuple[float, float]:
    """A place that no ball takes already; where all are taken, the last one tried."""
    for _ in range(20):
        x, y = draw()
        places = [b.centre[:2] for b in scene.balls]
        if all(
            min(np.hypot(p[0] - x, p[1] - y), np.hypot(12 - p[0] - x, p[1] - y)) > 2 * RADIUS
            for p in places
        ):
            break
    return float(x), float(y)


def _strewn(rng: np.random.Generator) -> Subject:
    """A few balls on the floor, one of them in the middle of interest."""
    scene = venue.field_hall(rng)
    x, y = rng.uniform((0.3, 0.3), (5.6, 11.7))
    if rng.uniform() < 0.5:
        x, y = rng.uniform((0.3, 8.3), (5.6, 11.7))
    reach = rng.uniform(0.3, 2.0)
    middle = _ball(scene, rng, x, y, str(rng.choice(BALLS)))
    for _ in range(int(rng.integers(0, 9))):
        bx, by = _apart(scene, rng, lambda: np.array([x, y]) + rng.normal(0, reach, 2))
        if 0.1 < bx < 11.9 and 0.1 < by < 11.9 and not 5.75 < bx < 6.25:
            _ball(scene, rng, bx, by, str(rng.choice(BALLS)))
    _field_things(scene, rng, (x, y))
    if rng.uniform() < 0.3:
        _fill_silos(scene, rng)
    return Subject(scene, middle, 0.3, 3.5)


def _field_things(scene: Scene, rng: np.random.Generator, near: tuple[float, float]) -> None:
    """Bags, boxes and legs that somebody left on the field."""
    for _ in range(int(rng.integers(0, 4))):
        tx, ty = np.array(near) + rng.normal(0, 1.0, 2)
        if np.hypot(tx - near[0], ty - near[1]) > 0.35:
            venue.thing(scene, rng, (tx, ty, _floor_at(tx, ty)), size=rng.uniform(0.3, 0.8))


def _fill_silos(scene: Scene, rng: np.random.Generator) -> None:
    """Five silos, each filling as likely as any other."""
    make = venue.silo_make(rng)
    for x, y in field.SILOS:
        label = int(rng.integers(len(SILOS)))
        venue.add_silo(scene, rng, (x, y, field.SILO_ZONE.height), label, make)


def _silos(rng: np.random.Generator, aside: float = 0.5) -> Subject:
    """The row of silos, from opposite or from nearer by, about `aside` off the normal [rad]."""
    scene = venue.field_hall(rng)
    _fill_silos(scene, rng)
    if rng.uniform() < 0.3:
        for _ in range(int(rng.integers(1, 4))):
            x, y = _apart(scene, rng, lambda: rng.uniform((3.3, 8.2), (5.7, 11.8)))
            _ball(scene, rng, x, y, str(rng.choice(BALLS)))
    side = np.pi if rng.uniform() < 0.5 else 0.0
    target = np.array([6.0, rng.uniform(8.3, 11.7), 0.35 + rng.uniform(0.1, 0.4)])
    return Subject(scene, target, 0.7, 2.8, side, aside)


def _row_of_silos(rng: np.random.Generator) -> Subject:
    """The row, looked at so that one silo rarely hides another."""
    return _silos(rng, aside=0.35)


def _one_silo(rng: np.random.Generator) -> Subject:
    """The approach: one silo near by."""
    subject = _silos(rng)
    subject.target[1] = subject.scene.cages[rng.integers(5)].foot[1]
    side = np.pi if rng.uniform() < 0.5 else 0.0
    return subject._replace(near=0.45, far=1.6, bearing=side, spread=0.45)


def _silo_anywhere(rng: np.random.Generator) -> Subject:
    """A silo or two on some floor, before the field was built."""
    scene = venue.workshop(rng)
    make = venue.silo_make(rng)
    for k in range(int(rng.integers(1, 4))):
        at = (0.45 * k + rng.normal(0, 0.05), rng.normal(0, 0.1), 0.0)
        venue.add_silo(scene, rng, at, int(rng.integers(len(SILOS))), make)
    return Subject(scene, np.array([0.2, 0.0, 0.25]), 0.6, 2.5)


def _bench(rng: np.random.Generator) -> Subject:
    """Balls near by on a bench or a floor."""
    scene = venue.workshop(rng)
    middle = _ball(scene, rng, 0.0, 0.0, str(rng.choice(BALLS)))
    for _ in range(int(rng.integers(0, 4))):
        x, y = _apart(scene, rng, lambda: rng.normal(0, 0.5, 2))
        _ball(scene, rng, x, y, str(rng.choice(BALLS)))
    return Subject(scene, middle, 0.35, 2.0)


def _nothing(rng: np.random.Generator) -> Subject:
    """No ball of ours, no silo."""
    scene = venue.field_hall(rng) if rng.uniform() < 0.6 else venue.workshop(rng)
    if scene.field_colours is None:
        return Subject(scene, np.array([0.0, 0.0, 0.2]), 0.4, 2.5)
    target = np.array([*rng.uniform((0.5, 0.5), (11.5, 11.5)), 0.3])
    return Subject(scene, target, 0.6, 4.0)
