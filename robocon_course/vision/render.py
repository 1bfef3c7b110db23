"""From a scene to light: what each pixel sees, and how bright it is there.

Two passes, both compiled. The first finds for every pixel the nearest surface (a depth buffer, one
thing after the other, each only where it can appear). The second shades each pixel once: paint,
lamps, gloss, shadows of the balls. The numbers of what is seen give the boxes, exactly.
"""

from __future__ import annotations

from math import atan2, floor, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.field import ORIGIN, SPAN
from robocon_course.vision.camera import Camera
from robocon_course.vision.scene import CAGE_RADIUS, FIELD_MAP, RADIUS, Packed

Image = NDArray[np.float32]

TAU = 2.0 * np.pi
FOOT = 0.03
"""Height of a cage's black feet [m]; a cage whose lowest ring lies lower has none."""
WALL = 0.006
"""How far a ring reaches inwards [m]."""
TILE = 256
"""Side of textures and grain [pixels]; a power of two, so that they repeat by masking bits."""
BIAS = 1 << 16
"""A multiple of `TILE` that makes coordinates positive, so that `int` rounds all of them down."""
RADIUS_32 = np.float32(RADIUS)
FLANK, SEAM = np.float32(0.18), np.float32(0.4)
"""How far a seam's flank leans, and how much light the seam keeps."""
UPRIGHT = np.float32(0.85)
"""Share of the light from everywhere that reaches an upright wall."""
VEIL = np.float32(0.08)
"""Strength of a gloss's wide lobe, of its narrow one."""
LEAST_DEPTH = 0.05
"""Corners nearer to the lens's plane than this are not projected [m]."""
NEAR = 0.03
"""Nothing nearer than this is seen [m]."""


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


def seen(
    scene: Packed, camera: Camera, T_map_camera: FloatArray
) -> tuple[Image, Image, NDArray[np.int32]]:
    """What each pixel sees.

    Returns
    -------
    rays : ndarray of float32, shape (h, w, 3)
        Where each pixel looks [map], 1 m forward along the axis.
    depth : ndarray of float32, shape (h, w)
        How many such steps away the nearest surface is; inf for none.
    what : ndarray of int32, shape (h, w)
        Its number: rectangles first, then balls, cages and pillars; -1 for none.
    """
    h, w = camera.height, camera.width
    turn, eye = T_map_camera[:3, :3].astype(np.float32), T_map_camera[:3, 3].astype(np.float32)
    rays = np.empty((h, w, 3), np.float32)
    look(rays, np.float32(camera.focal), np.float32(camera.distortion), turn)
    depth = np.full((h, w), np.inf, np.float32)
    what = np.full((h, w), -1, np.int32)
    edge = _edge_of_view(camera)
    see_rects(scene.rects, rays, eye, depth, what, edge, turn)
    first = len(scene.rects)
    see_balls(scene.balls, rays, eye, depth, what, first, edge, turn)
    first += len(scene.balls)
    see_cages(scene.cages, rays, eye, depth, what, first, edge, turn)
    first += len(scene.cages)
    see_pillars(scene.pillars, rays, eye, depth, what, first, edge, turn)
    return rays, depth, what


def _edge_of_view(camera: Camera) -> NDArray[np.float32]:
    """Focal length, distortion and half size, for `window`."""
    return np.array(
        [camera.focal, camera.distortion, camera.width / 2, camera.height / 2], np.float32
    )


@njit(cache=True, error_model="numpy")
def look(rays, focal, distortion, turn):
    """Directions of all pixels, in the map; `Camera.rays` without the last division."""
    h, w = rays.shape[:2]
    for i in range(h):
        for j in range(w):
            x = (j + 0.5 - w / 2) / focal
            y = (i + 0.5 - h / 2) / focal
            z = 1.0 + distortion * (x * x + y * y)
            for k in range(3):
                rays[i, j, k] = (turn[k, 0] * x + turn[k, 1] * y) / z + turn[k, 2]


@njit(cache=True, error_model="numpy")
def window(points, eye, edge, turn):
    """Rows and columns in which something with these corners can appear; all if one is behind."""
    focal, distortion, cx, cy = edge
    left, right, top, bottom = np.inf, -np.inf, np.inf, -np.inf
    behind = 0
    for k in range(len(points)):
        x, y, z = points[k] - eye
        depth = turn[0, 2] * x + turn[1, 2] * y + turn[2, 2] * z
        if depth < 0.5 * LEAST_DEPTH:
            behind += 1
            continue
        u = (turn[0, 0] * x + turn[1, 0] * y + turn[2, 0] * z) / depth
        v = (turn[0, 1] * x + turn[1, 1] * y + turn[2, 1] * z) / depth
        # A barrel picture's straight edges bow outwards between the corners: a margin for that.
        shrunk = 2.0 / (1.0 + sqrt(1.0 - 4.0 * distortion * (u * u + v * v)))
        u, v = u * focal, v * focal
        left, right = min(left, u * shrunk, u), max(right, u * shrunk, u)
        top, bottom = min(top, v * shrunk, v), max(bottom, v * shrunk, v)
    h, w = int(2 * cy), int(2 * cx)
    if behind == len(points):
        return 0, 0, 0, 0
    if behind > 0:
        return 0, h, 0, w
    rows = max(0, int(top + cy) - 2), min(h, int(bottom + cy) + 3)
    cols = max(0, int(left + cx) - 2), min(w, int(right + cx) + 3)
    return rows[0], rows[1], cols[0], cols[1]


@njit(cache=True, error_model="numpy")
def in_front(corners, eye, turn):
    """The part of a flat polygon that lies before the camera: a polygon again."""
    n = len(corners)
    kept = np.empty((2 * n, 3), np.float32)
    count = 0
    for k in range(n):
        here, there = corners[k], corners[(k + 1) % n]
        a = np.sum((here - eye) * turn[:, 2]) - LEAST_DEPTH
        b = np.sum((there - eye) * turn[:, 2]) - LEAST_DEPTH
        if a >= 0.0:
            kept[count] = here
            count += 1
        if (a >= 0.0) != (b >= 0.0):
            kept[count] = here + a / (a - b) * (there - here)
            count += 1
    return kept[:count]


@njit(cache=True, error_model="numpy")
def around(x, y, z, radius, up):
    """Corners of the upright box around something `radius` wide that rises from z to z + up."""
    corners = np.empty((8, 3), np.float32)
    for k in range(8):
        corners[k, 0] = x + (radius if k & 1 else -radius)
        corners[k, 1] = y + (radius if k & 2 else -radius)
        corners[k, 2] = z + (up if k & 4 else 0.0)
    return corners


@njit(cache=True, fastmath=True, error_model="numpy")
def see_rects(rects, rays, eye, depth, what, edge, turn):
    """Flat rectangles into the depth buffer."""
    corners = np.empty((4, 3), np.float32)
    for q in range(len(rects)):
        lu, lv = rects[q, 12], rects[q, 13]
        for k in range(3):
            corners[0, k] = rects[q, k]
            corners[1, k] = corners[0, k] + rects[q, 3 + k] * lu
            corners[2, k] = corners[1, k] + rects[q, 6 + k] * lv
            corners[3, k] = corners[0, k] + rects[q, 6 + k] * lv
        part = in_front(corners, eye, turn)
        if len(part) == 0:
            continue
        top, bottom, left, right = window(part, eye, edge, turn)
        x, y, z = rects[q, 0] - eye[0], rects[q, 1] - eye[1], rects[q, 2] - eye[2]
        ux, uy, uz = rects[q, 3], rects[q, 4], rects[q, 5]
        vx, vy, vz = rects[q, 6], rects[q, 7], rects[q, 8]
        nx, ny, nz = rects[q, 9], rects[q, 10], rects[q, 11]
        ahead = nx * x + ny * y + nz * z
        ou, ov = x * ux + y * uy + z * uz, x * vx + y * vy + z * vz
        for i in range(top, bottom):
            for j in range(left, right):
                dx, dy, dz = rays[i, j, 0], rays[i, j, 1], rays[i, j, 2]
                t = ahead / (nx * dx + ny * dy + nz * dz)
                if NEAR < t < depth[i, j]:
                    a = t * (ux * dx + uy * dy + uz * dz) - ou
                    b = t * (vx * dx + vy * dy + vz * dz) - ov
                    if 0.0 <= a <= lu and 0.0 <= b <= lv:
                        depth[i, j] = t
                        what[i, j] = q


@njit(cache=True, fastmath=True, error_model="numpy")
def see_balls(balls, rays, eye, depth, what, first, edge, turn):
    """Balls into the depth buffer."""
    for q in range(len(balls)):
        x, y, z = balls[q, 0] - eye[0], balls[q, 1] - eye[1], balls[q, 2] - eye[2]
        corners = around(balls[q, 0], balls[q, 1], balls[q, 2] - RADIUS, RADIUS, 2 * RADIUS)
        top, bottom, left, right = window(corners, eye, edge, turn)
        c = x * x + y * y + z * z - RADIUS * RADIUS
        for i in range(top, bottom):
            for j in range(left, right):
                dx, dy, dz = rays[i, j, 0], rays[i, j, 1], rays[i, j, 2]
                a = dx * dx + dy * dy + dz * dz
                b = dx * x + dy * y + dz * z
                root = b * b - a * c
                if root > 0.0:
                    t = (b - sqrt(root)) / a
                    if NEAR < t < depth[i, j]:
                        depth[i, j] = t
                        what[i, j] = first + q


@njit(cache=True, fastmath=True, error_model="numpy")
def on_cage(cage, px, py, pz):
    """Whether a point of the cylinder (from the middle of the base) is a ring or a post."""
    if pz < 0.0 or pz > cage[6] + 0.5 * cage[7]:
        return False
    for k in range(3, 7):
        if abs(pz - cage[k]) < 0.5 * cage[7]:
            return True
    step = TAU / cage[9]
    bearing = (atan2(py, px) - cage[10]) / step
    away = abs(bearing - floor(bearing + 0.5)) * step * CAGE_RADIUS
    # Feet are clumsier than posts.
    return away < (0.018 if pz < FOOT < cage[3] else 0.5 * cage[8])


@njit(cache=True, fastmath=True, error_model="numpy")
def see_cages(cages, rays, eye, depth, what, first, edge, turn):
    """Cages into the depth buffer: a cylinder with holes, its wall, and the rings from above."""
    inner = CAGE_RADIUS - WALL
    for q in range(len(cages)):
        cage = cages[q]
        x, y, z = cage[0] - eye[0], cage[1] - eye[1], cage[2] - eye[2]
        corners = around(cage[0], cage[1], cage[2], CAGE_RADIUS, cage[6] + cage[7])
        top, bottom, left, right = window(corners, eye, edge, turn)
        for i in range(top, bottom):
            for j in range(left, right):
                dx, dy, dz = rays[i, j, 0], rays[i, j, 1], rays[i, j, 2]
                a = dx * dx + dy * dy
                b = dx * x + dy * y
                best = depth[i, j]
                for radius in (CAGE_RADIUS, inner):
                    root = b * b - a * (x * x + y * y - radius * radius)
                    if root > 0.0:
                        for sign in (-1.0, 1.0):
                            t = (b + sign * sqrt(root)) / a
                            if NEAR < t < best and on_cage(
                                cage, t * dx - x, t * dy - y, t * dz - z
                            ):
                                best = t
                for k in range(3, 7):
                    level = z + cage[k] + (0.5 if z + cage[k] < 0.0 else -0.5) * cage[7]
                    t = level / dz
                    if NEAR < t < best:
                        px, py = t * dx - x, t * dy - y
                        if inner * inner < px * px + py * py < CAGE_RADIUS * CAGE_RADIUS:
                            best = t
                if best < depth[i, j]:
                    depth[i, j] = best
                    what[i, j] = first + q


@njit(cache=True, fastmath=True, error_model="numpy")
def see_pillars(pillars, rays, eye, depth, what, first, edge, turn):
    """Upright cylinders into the depth buffer, each with a round head."""
    for q in range(len(pillars)):
        x, y, z = pillars[q, 0] - eye[0], pillars[q, 1] - eye[1], pillars[q, 2] - eye[2]
        height, radius = pillars[q, 3], pillars[q, 4]
        corners = around(pillars[q, 0], pillars[q, 1], pillars[q, 2], radius, height + radius)
        top, bottom, left, right = window(corners, eye, edge, turn)
        c = x * x + y * y - radius * radius
        head = z + height
        for i in range(top, bottom):
            for j in range(left, right):
                dx, dy, dz = rays[i, j, 0], rays[i, j, 1], rays[i, j, 2]
                a = dx * dx + dy * dy
                b = dx * x + dy * y
                root = b * b - a * c
                if root > 0.0:
                    t = (b - sqrt(root)) / a
                    up = t * dz - z
                    if NEAR < t < depth[i, j] and 0.0 <= up <= height:
                        depth[i, j] = t
                        what[i, j] = first + q
                    # The head: a flattened ball, half as high as wide.
                    a3 = a + 4.0 * dz * dz
                    b3 = b + 4.0 * dz * head
                    root = b3 * b3 - a3 * (c + 4.0 * head * head)
                    if root > 0.0:
                        t = (b3 - sqrt(root)) / a3
                        if NEAR < t < depth[i, j] and t * dz > head:
                            depth[i, j] = t
                            what[i, j] = first + q


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
    textures : ndarray of float32, shape (k, s, s, 3)
        Linear RGB.
    floor_map : ndarray of uint8, shape (n, n)
        Which paint lies in each cell of the field; row 0 at the smallest y.
    paints : ndarray of float32, shape (k, 3)
        Linear RGB.
    grain : ndarray of float32, shape (s, s)
        Noise around 0, the same scale everywhere: dirt, wood, brush strokes.
    """
    rays, depth, what = view
    turn, eye = T_map_camera[:3, :3].astype(np.float32), T_map_camera[:3, 3].astype(np.float32)
    key = np.ones(depth.shape, np.float32)
    sky = np.ones(depth.shape, np.float32)
    first = len(scene.rects)
    cast_shadows(
        scene.balls, scene.lamps[0], rays, eye, depth, what, first, _edge_of_view(camera), turn,
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
                q -= n_rects
                nx, ny, nz = x - balls[q, 0], y - balls[q, 1], z - balls[q, 2]
                nx, ny, nz = nx / RADIUS_32, ny / RADIUS_32, nz / RADIUS_32
                deep, ox, oy, oz = seam(balls, q, nx, ny, nz, t / focal, panels)
                # The flank of a seam leans to the neighbour: there the highlight breaks.
                lean = FLANK * deep
                nx, ny, nz = nx - lean * ox, ny - lean * oy, nz - lean * oz
                dark = np.float32(1.0) - SEAM * deep
                red, green, blue = balls[q, 3] * dark, balls[q, 4] * dark, balls[q, 5] * dark
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
            facing = nx * dx + ny * dy + nz * dz
            size = sqrt(nx * nx + ny * ny + nz * nz) + np.float32(1e-9)
            if facing > 0.0:
                size = -size
            nx, ny, nz, facing = nx / size, ny / size, nz / size, facing / size
            far = sqrt(dx * dx + dy * dy + dz * dz)
            around = sky[i, j] * (UPRIGHT + (1 - UPRIGHT) * nz)
            r, g, b = (
                red * ambient[0] * around,
                green * ambient[1] * around,
                blue * ambient[2] * around,
            )
            for lamp in range(len(lamps)):
                lx, ly, lz = lamps[lamp, 0], lamps[lamp, 1], lamps[lamp, 2]
                falls = nx * lx + ny * ly + nz * lz
                if falls <= 0.0:
                    continue
                wide, narrow = highlight((dx * lx + dy * ly + dz * lz - 2 * facing * falls) / far)
                lit = key[i, j] if lamp == 0 else sky[i, j]
                matt, shine = lit * (falls + sheen * wide), lit * gloss * (narrow + VEIL * wide)
                r += lamps[lamp, 3] * (red * matt + shine)
                g += lamps[lamp, 4] * (green * matt + shine)
                b += lamps[lamp, 5] * (blue * matt + shine)
            image[i, j, 0], image[i, j, 1], image[i, j, 2] = r, g, b


@njit(cache=True, error_model="numpy")
def spans(what, first, total):
    """Left, top, right, bottom [rays] and number of rays of each thing seen, `first` and up."""
    h, w = what.shape
    found = np.empty((total, 4), np.int64)
    found[:, :2] = max(h, w)
    found[:, 2:] = 0
    counts = np.zeros(total, np.int64)
    for i in range(h):
        for j in range(w):
            q = what[i, j]
            if first <= q < total:
                counts[q] += 1
                found[q, 0] = min(found[q, 0], j)
                found[q, 1] = min(found[q, 1], i)
                found[q, 2] = max(found[q, 2], j + 1)
                found[q, 3] = max(found[q, 3], i + 1)
    return found, counts


def whole_ball(scene, camera: Camera, T_map_camera: FloatArray) -> FloatArray:
    """How many rays each ball would fill if nothing hid it."""
    turn, eye = T_map_camera[:3, :3], T_map_camera[:3, 3]
    middles = np.array([b.centre for b in scene.balls]).reshape(-1, 3) - eye
    depth = np.maximum(middles @ turn[:, 2], 0.05)
    return np.pi * (camera.focal * RADIUS / depth) ** 2


def whole_cage(scene, camera: Camera, T_map_camera: FloatArray) -> FloatArray:
    """How many rays the upright rectangle around each cage would fill if nothing hid it."""
    turn, eye = T_map_camera[:3, :3], T_map_camera[:3, 3]
    middles = np.array([c.foot + np.array([0, 0, 0.2]) for c in scene.cages]).reshape(-1, 3) - eye
    depth = np.maximum(middles @ turn[:, 2], 0.05)
    heights = np.array([c.rings[3] for c in scene.cages])
    return 2 * CAGE_RADIUS * heights * (camera.focal / depth) ** 2
