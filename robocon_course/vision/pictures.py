"""Pictures of the field that nobody took, with exact boxes around what is to be found.

``picture("ball", seed, index)`` is a pure function: the same arguments give the same picture, to
the byte on one machine and library version. The simulator's camera uses `take`, too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision import film, paint, render, shading, shots
from robocon_course.vision.camera import Camera
from robocon_course.vision.classes import CLASSES, classes_of
from robocon_course.vision.scene import Scene, linear

FINENESS = 1.5
"""Rays per pixel and direction."""
LEAST_SIDE = {"ball": 4.0, "silo": 8.0}
"""Nothing narrower or lower than this gets a box [pixels]."""
LEAST_SHARE = {"ball": 0.15, "silo": 0.6}
"""Nor anything of which less than this share is seen."""
LEAST_OF_A_FILLING = 0.25
"""Nor a silo if less than this share is seen of one of its balls, or of the place where its next
one would lie: nobody could name its filling."""
SEEN_AT_ALL = 2.0
"""Of what gets no box, a part this wide and high can still be seen, and is doubtful [pixels]."""
SIZES = ((320, 240), (320, 180), (320, 320), (320, 240))
"""Shapes of picture that are drawn when none is asked for."""


class Picture(NamedTuple):
    """A picture and what is in it.

    Attributes
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    boxes : ndarray of float32, shape (n, 4)
        Left, top, right, bottom of the visible part [pixels].
    class_ids : ndarray of int64, shape (n,)
        By the order of `classes.CLASSES`.
    doubtful : ndarray of float32, shape (k, 4)
        Boxes like the others, around what is seen and yet too little for a label: who reports it is
        not wrong, and who does not misses nothing. Data sets do not hold them.
    """

    image_bgr: NDArray[np.uint8]
    boxes: NDArray[np.float32]
    class_ids: NDArray[np.int64]
    doubtful: NDArray[np.float32]


def picture(kind: str, seed: int, index: int, size: tuple[int, int] | None = (320, 240)) -> Picture:
    """A picture for a data set, number `index` of the series `seed`.

    Parameters
    ----------
    kind : {"ball", "silo"}
        What the boxes are drawn around.
    seed, index : int
    size : (int, int) or None  [pixels]
        Width and height; None draws one of `SIZES`.

    Returns
    -------
    Picture

    Raises
    ------
    ValueError
        Another kind, or a picture of less than 32 pixels a side.
    """
    classes_of(kind)
    if size is not None and not (len(size) == 2 and min(size) >= 32):
        raise ValueError(f"size: expected width and height, at least 32 pixels each, got {size!r}")
    rng = np.random.default_rng([seed, index, list(CLASSES).index(kind)])
    if size is None:
        size = SIZES[rng.integers(len(SIZES))]
    scene, camera, T_map_camera = shots.shot(kind, rng, size)
    return take(scene, camera, T_map_camera, film.Film.random(rng, size[0]), rng, kind=kind)


def take(
    scene: Scene,
    camera: Camera,
    T_map_camera: FloatArray,
    on: film.Film,
    rng: np.random.Generator,
    *,
    kind: str = "ball",
) -> Picture:
    """A picture of a scene.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    T_map_camera : ndarray, shape (4, 4)
        Where the camera is.
    on : Film
    rng : numpy.random.Generator
        For the noise.
    kind : {"ball", "silo"}
        What the boxes are drawn around.

    Returns
    -------
    Picture
    """
    fine = camera.scaled(FINENESS)
    packed = scene.packed()
    view = render.seen(packed, fine, T_map_camera)
    textures = np.stack(scene.textures or [np.zeros((shading.TILE, shading.TILE, 3), np.uint8)])
    paints = linear(_paints(scene)).astype(np.float32)
    light = shading.shaded(
        packed, fine, T_map_camera, view,
        film.to_linear(textures), paint.field_map(), paints, paint.grain(),
    )  # fmt: skip
    image = film.develop(light, (camera.width, camera.height), on, rng)
    return Picture(image, *visible(scene, view, fine, T_map_camera, kind))


def _paints(scene: Scene) -> FloatArray:
    return np.zeros((1, 3)) if scene.field_colours is None else scene.field_colours


def visible(
    scene: Scene, view: render.View, fine: Camera, T_map_camera: FloatArray, kind: str
) -> tuple[NDArray[np.float32], NDArray[np.int64], NDArray[np.float32]]:
    """Boxes around the visible part of each ball, or of each silo with its balls.

    Those with a label, their classes, and those of which too little is seen for one.
    """
    first = len(scene.rects)
    total = first + len(scene.balls) + len(scene.cages)
    spans, counts = (found[first:] for found in render.spans(view[2], first, total))
    middles = np.array([ball.centre for ball in scene.balls]).reshape(-1, 3)
    shares = counts[: len(middles)] / render.whole_balls(middles, fine, T_map_camera)
    if kind == "ball":
        boxes, ids, enough = _balls(scene, spans, shares)
    else:
        places = _places(scene, view, fine, T_map_camera)
        whole = render.whole_cages(scene, fine, T_map_camera)
        boxes, ids, enough = _silos(scene, spans, counts, shares, places, whole)
    boxes = np.array(boxes, np.float32).reshape(-1, 4) / FINENESS
    side = (boxes[:, 2:] - boxes[:, :2]).min(axis=1, initial=np.inf)
    named = np.array(enough, bool) & (side >= LEAST_SIDE[kind])
    doubtful = ~named & (side >= SEEN_AT_ALL)
    return boxes[named], np.array(ids, np.int64)[named], boxes[doubtful]


Boxes = tuple[list[FloatArray], list[int], list[bool]]


def _balls(scene: Scene, spans: FloatArray, shares: FloatArray) -> Boxes:
    """Boxes [rays] and colours of the balls that are seen, and whether enough is."""
    kept = [k for k, ball in enumerate(scene.balls) if ball.label >= 0 and shares[k] > 0]
    ids = [scene.balls[k].label for k in kept]
    return [spans[k] for k in kept], ids, [shares[k] >= LEAST_SHARE["ball"] for k in kept]


def _places(scene: Scene, view: render.View, fine: Camera, T_map_camera: FloatArray) -> list[float]:
    """Which share is seen of the place of each silo's next ball; 1 where there is none."""
    places = [scene.next_place(k) for k in range(len(scene.cages))]
    return [
        1.0 if place is None else render.share_of_another(place, view, fine, T_map_camera)
        for place in places
    ]


def _silos(
    scene: Scene,
    spans: FloatArray,
    counts: FloatArray,
    shares: FloatArray,
    places: list[float],
    whole: FloatArray,
) -> Boxes:
    """Boxes [rays] and fillings of the silos that are seen, and whether enough is.

    Enough of the silo, of its every ball, and of the place above them.
    """
    boxes, ids, enough = [], [], []
    for k, cage in enumerate(scene.cages):
        me, held = len(scene.balls) + k, scene.held(k)
        parts = [part for part in (me, *held) if counts[part] > 0]
        if not parts:
            continue
        box = np.r_[spans[parts, :2].min(axis=0), spans[parts, 2:].max(axis=0)]
        boxes.append(box)
        ids.append(cage.filling)
        enough.append(
            counts[me] > 0
            and min([places[k], *shares[held]]) >= LEAST_OF_A_FILLING
            and np.prod(box[2:] - box[:2]) >= LEAST_SHARE["silo"] * whole[k]
        )
    return boxes, ids, enough
