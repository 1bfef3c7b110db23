"""How bright each pixel is: the second of two passes from a scene to a picture.

Each pixel is shaded once, by what `render.seen` found there: paint, lamps, gloss, the balls'
shadows, the seams of a football.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.field import ORIGIN, SPAN
from robocon_course.vision.camera import Camera
from robocon_course.vision.render import FOOT, Image, around, edge_of_view, window
from robocon_course.vision.scene import FIELD_MAP, RADIUS, Packed

TILE = 256
"""Side of textures and grain [pixels]; a power of two, so that they repeat by masking bits."""
BIAS = 1 << 16
"""A multiple of `TILE` that makes coordinates positive, so that `int` rounds all of them down."""
RADIUS_32 = np.float32(RADIUS)
FLANK, SEAM = np.float32(0.18), np.float32(0.4)
"""How far a seam's flank leans, and how much light it takes."""
UPRIGHT = np.float32(0.85)
"""Share of the light from everywhere that reaches an upright wall."""
VEIL = np.float32(0.08)
"""Strength of a gloss's wide lobe, of its narrow one."""


def _panels() -> NDArray[np.float32]:
    """Normals of a football's 12 pentagons and 20 hexagons, over their planes' distances."""
    golden = (1 + sqrt(5)) / 2
    signs = [(s, t) for s in (-1, 1) for t in (-1, 1)]
    corners = [p for s, t in signs for p in _turns((0.0, s, t * golden))]
    faces = [p for s, t in signs for p in _turns((0.0, s / golden, t * golden))]
    faces += [(s, t, u) for s, t in signs for u in (-1, 1)]
    pentagons = np.array(corners) / np.linalg.norm(corners[0]) / 0.9393
    hexagons = np.array(faces) / np.sqrt(3.0) / 0.9149
    return np.vstack([pentagons, hexagons]).astype(np.float32)


def _turns(p: tuple[float, float, float]) -> list[tuple[float, float, float]]:
    return [p, (p[1], p[2], p[0]), (p[2], p[0], p[1])]


PANELS = _panels()


def shaded(
    scene: Packed,
    camera: Camera,
    T_map_camera: FloatArray,
    view: tuple[Image, Image, NDArray[np.int32]],
    textures: Image,
    floor_map: NDArray[np.uint8],
    paints: Image,
    grain: Image,
) -> Image:
    """The light that reaches each pixel, linear RGB, from what `seen` found.

    Parameters
    ----------
    scene : Packed
    camera : Camera
    T_map_camera : ndarray, shape (4, 4)
    view : (rays, depth, what)
        As `render.seen` returns them.
    textures : ndarray of float32, shape (k, s, s, 3)
        Linear RGB.
    floor_map : ndarray of uint8, shape (n, n)
        Which paint lies in each cell of the field; row 0 at the smallest y.
    paints : ndarray of float32, shape (k, 3)
        Linear RGB.
    grain : ndarray of float32, shape (s, s)
        Noise around 0, the same scale everywhere: dirt, wood, brush strokes.

    Returns
    -------
    ndarray of float32, shape (h, w, 3)
    """
    rays, depth, what = view
    turn, eye = T_map_camera[:3, :3].astype(np.float32), T_map_camera[:3, 3].astype(np.float32)
    key = np.ones(depth.shape, np.float32)
    sky = np.ones(depth.shape, np.float32)
    first = len(scene.rects)
    cast_shadows(
        scene.balls, scene.lamps[0], rays, eye, depth, what, first, edge_of_view(camera), turn,
        key, sky,
    )  # fmt: skip
    image = np.empty((*depth.shape, 3), np.float32)
    focal = np.float32(camera.focal)
    shade(
        scene, rays, eye, depth, what, key, sky, textures, floor_map, paints, grain, PANELS, focal,
        image,
    )  # fmt: skip
    return image


@njit(cache=True, fastmath=True, error_model="numpy")
def cast_shadows(balls, lamp, rays, eye, depth, what, first, edge, turn, key, sky):
    """How much of the first lamp, and of the light from everywhere, the balls leave to others."""
    reach = 3.0 * RADIUS
    lx, ly, lz = lamp[0], lamp[1], lamp[2]
    for q in range(len(balls)):
        bx, by, bz = balls[q, 0], balls[q, 1], balls[q, 2]
        corners = around(bx, by, bz - reach, reach, 2 * reach)
        top, bottom, left, right = window(corners, eye, edge, turn)
        for i in range(top, bottom):
            for j in range(left, right):
                t = depth[i, j]
                if what[i, j] == first + q or t > 1e6:
                    continue
                x = bx - eye[0] - t * rays[i, j, 0]
                y = by - eye[1] - t * rays[i, j, 1]
                z = bz - eye[2] - t * rays[i, j, 2]
                far = x * x + y * y + z * z
                if far > reach * reach:
                    continue
                sky[i, j] *= 1.0 - 0.75 * min(1.0, RADIUS * RADIUS / far) * max(0.0, z) / sqrt(far)
                along = x * lx + y * ly + z * lz
                if along > 0.0:
                    miss = sqrt(max(0.0, far - along * along)) / RADIUS
                    # Lamps are wide: the farther the shadow falls, the softer its rim.
                    soft = 0.15 + 0.6 * along / reach
                    lit = min(1.0, max(0.0, (miss - 1.0 + soft) / (2.0 * soft)))
                    key[i, j] *= 0.15 + 0.85 * lit


@njit(cache=True, fastmath=True, error_model="numpy")
def on_rect(rects, q, x, y, z, textures, floor_map, paints, grain):
    """Paint of a flat rectangle at a point: its colour, texture and dirt."""
    rx, ry, rz = x - rects[q, 0], y - rects[q, 1], z - rects[q, 2]
    a = rx * rects[q, 3] + ry * rects[q, 4] + rz * rects[q, 5] + rects[q, 19]
    b = rx * rects[q, 6] + ry * rects[q, 7] + rz * rects[q, 8] + rects[q, 20]
    texture = int(rects[q, 17])
    red, green, blue = rects[q, 14], rects[q, 15], rects[q, 16]
    if texture == FIELD_MAP:
        n = len(floor_map)
        per_metre = n / SPAN
        i = min(n - 1, max(0, int((y - ORIGIN[1]) * per_metre)))
        j = min(n - 1, max(0, int((x - ORIGIN[0]) * per_metre)))
        number = floor_map[i, j]
        red, green, blue = paints[number, 0], paints[number, 1], paints[number, 2]
    elif texture > FIELD_MAP:
        scale = rects[q, 18] * TILE
        i, j = int(b * scale + BIAS) & (TILE - 1), int(a * scale + BIAS) & (TILE - 1)
        red *= textures[texture - 1, i, j, 0]
        green *= textures[texture - 1, i, j, 1]
        blue *= textures[texture - 1, i, j, 2]
    spot = grain[int(b * 90.0 + BIAS) & (TILE - 1), int(a * 90.0 + BIAS) & (TILE - 1)]
    dirt = max(np.float32(0.05), 1 + rects[q, 21] * spot)
    return red * dirt, green * dirt, blue * dirt


@njit(cache=True, fastmath=True, error_model="numpy")
def seam(balls, q, nx, ny, nz, pixel, panels):
    """How deep in a seam a ball's surface is (0 to 1), and which way the panel beside it lies."""
    blur = pixel / RADIUS
    if blur > 0.25:
        return np.float32(0.0), nx, ny, nz
    mx = balls[q, 6] * nx + balls[q, 7] * ny + balls[q, 8] * nz
    my = balls[q, 9] * nx + balls[q, 10] * ny + balls[q, 11] * nz
    mz = balls[q, 12] * nx + balls[q, 13] * ny + balls[q, 14] * nz
    best, second, at = np.float32(-1.0), np.float32(-1.0), 0
    for k in range(len(panels)):
        here = panels[k, 0] * mx + panels[k, 1] * my + panels[k, 2] * mz
        if here > best:
            best, second, at = here, best, k
        elif here > second:
            second = here
    near = 1.0 - (best - second) / (0.025 + blur)
    depth = np.float32(max(0.0, near) * min(1.0, 0.025 / (0.015 + blur)))
    px, py, pz = panels[at, 0], panels[at, 1], panels[at, 2]
    ox = balls[q, 6] * px + balls[q, 9] * py + balls[q, 12] * pz
    oy = balls[q, 7] * px + balls[q, 10] * py + balls[q, 13] * pz
    oz = balls[q, 8] * px + balls[q, 11] * py + balls[q, 14] * pz
    return depth, ox, oy, oz


@njit(cache=True, fastmath=True, error_model="numpy")
def on_ball(balls, q, x, y, z, pixel, panels):
    """Normal and paint of a ball at a point."""
    nx, ny, nz = x - balls[q, 0], y - balls[q, 1], z - balls[q, 2]
    nx, ny, nz = nx / RADIUS_32, ny / RADIUS_32, nz / RADIUS_32
    deep, ox, oy, oz = seam(balls, q, nx, ny, nz, pixel, panels)
    # The flank of a seam leans to the neighbour: there the highlight breaks.
    lean = FLANK * deep
    dark = np.float32(1.0) - SEAM * deep
    nx, ny, nz = nx - lean * ox, ny - lean * oy, nz - lean * oz
    return nx, ny, nz, balls[q, 3] * dark, balls[q, 4] * dark, balls[q, 5] * dark


@njit(cache=True, fastmath=True, error_model="numpy")
def highlight(mirrored):
    """Phong's wide and narrow lobe, powers 8 and 32 of the mirrored look against the lamp."""
    if mirrored <= 0.5:
        return np.float32(0.0), np.float32(0.0)
    wide = mirrored * mirrored
    wide *= wide
    wide *= wide
    narrow = wide * wide
    return wide, narrow * narrow


@njit(cache=True, fastmath=True, error_model="numpy")
def lit(normal, paint, surface, look, key, sky, lamps, ambient):
    """Light that a surface sends back: what comes from everywhere, then lamp by lamp."""
    (nx, ny, nz), (red, green, blue), (dx, dy, dz) = normal, paint, look
    gloss, sheen = surface
    facing = nx * dx + ny * dy + nz * dz
    size = sqrt(nx * nx + ny * ny + nz * nz) + np.float32(1e-9)
    if facing > 0.0:
        size = -size
    nx, ny, nz, facing = nx / size, ny / size, nz / size, facing / size
    far = sqrt(dx * dx + dy * dy + dz * dz)
    around = sky * (UPRIGHT + (1 - UPRIGHT) * nz)
    r, g, b = red * ambient[0] * around, green * ambient[1] * around, blue * ambient[2] * around
    for lamp in range(len(lamps)):
        lx, ly, lz = lamps[lamp, 0], lamps[lamp, 1], lamps[lamp, 2]
        falls = nx * lx + ny * ly + nz * lz
        if falls <= 0.0:
            continue
        wide, narrow = highlight((dx * lx + dy * ly + dz * lz - 2 * facing * falls) / far)
        share = key if lamp == 0 else sky
        matt, shine = share * (falls + sheen * wide), share * gloss * (narrow + VEIL * wide)
        r += lamps[lamp, 3] * (red * matt + shine)
        g += lamps[lamp, 4] * (green * matt + shine)
        b += lamps[lamp, 5] * (blue * matt + shine)
    return r, g, b


@njit(cache=True, fastmath=True, error_model="numpy")
def shade(scene, rays, eye, depth, what, key, sky, textures, floor_map, paints, grain, panels,
          focal, image):  # fmt: skip
    """Paint times light, plus gloss, for every pixel."""
    h, w = depth.shape
    rects, balls, cages, pillars, lamps, ambient = scene
    n_rects, n_balls, n_cages = len(rects), len(balls), len(cages)
    for i in range(h):
        for j in range(w):
            q = what[i, j]
            if q < 0:
                image[i, j] = ambient
                continue
            dx, dy, dz = rays[i, j, 0], rays[i, j, 1], rays[i, j, 2]
            t = depth[i, j]
            x, y, z = eye[0] + t * dx, eye[1] + t * dy, eye[2] + t * dz
            sheen = np.float32(0.0)
            if q < n_rects:
                nx, ny, nz = rects[q, 9], rects[q, 10], rects[q, 11]
                red, green, blue = on_rect(
                    rects, q, x, y, z, textures, floor_map, paints, grain
                )  # fmt: skip
                gloss = rects[q, 22]
            elif q < n_rects + n_balls:
                nx, ny, nz, red, green, blue = on_ball(
                    balls, q - n_rects, x, y, z, t / focal, panels
                )  # fmt: skip
                gloss, sheen = np.float32(0.35), np.float32(0.5)
            elif q < n_rects + n_balls + n_cages:
                q -= n_rects + n_balls
                nx, ny, nz = x - cages[q, 0], y - cages[q, 1], np.float32(0.0)
                feet = cages[q, 3] > FOOT and z - cages[q, 2] < FOOT
                dark = np.float32(0.03) if feet else np.float32(1.0)
                red, green, blue = cages[q, 11] * dark, cages[q, 12] * dark, cages[q, 13] * dark
                gloss = np.float32(0.1)
            else:
                q -= n_rects + n_balls + n_cages
                nx, ny, nz = x - pillars[q, 0], y - pillars[q, 1], np.float32(0.0)
                red, green, blue = pillars[q, 5], pillars[q, 6], pillars[q, 7]
                gloss = np.float32(0.08)
            image[i, j, 0], image[i, j, 1], image[i, j, 2] = lit(
                (nx, ny, nz), (red, green, blue), (gloss, sheen), (dx, dy, dz), key[i, j],
                sky[i, j], lamps, ambient,
            )  # fmt: skip
