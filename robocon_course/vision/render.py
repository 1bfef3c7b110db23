"""What each pixel sees of a scene: the first of two passes from a scene to a picture.

A depth buffer, filled by one thing after the other, each only where it can appear; all compiled.
The numbers of what is seen give the boxes, exactly. `shading` is the second pass.
"""

from __future__ import annotations

from math import atan2, floor, sqrt

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray
from robocon_course.vision.camera import Camera
from robocon_course.vision.scene import CAGE_RADIUS, RADIUS, Packed, Scene

Image = NDArray[np.float32]

TAU = 2.0 * np.pi
FOOT = 0.03
"""Height of a cage's black feet [m]; a cage whose lowest ring lies lower has none."""
WALL = 0.006
"""How far a ring reaches inwards [m]."""
LEAST_DEPTH = 0.05
"""Corners nearer to the lens's plane than this are not projected [m]."""
NEAR = 0.03
"""Nothing nearer than this is seen [m]."""


View = tuple[Image, Image, NDArray[np.int32]]
"""What `seen` returns."""


def seen(scene: Packed, camera: Camera, T_map_camera: FloatArray) -> View:
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
    edge = edge_of_view(camera)
    see_rects(scene.rects, rays, eye, depth, what, edge, turn)
    first = len(scene.rects)
    see_balls(scene.balls, rays, eye, depth, what, first, edge, turn)
    first += len(scene.balls)
    see_cages(scene.cages, rays, eye, depth, what, first, edge, turn)
    first += len(scene.cages)
    see_pillars(scene.pillars, rays, eye, depth, what, first, edge, turn)
    return rays, depth, what


def edge_of_view(camera: Camera) -> NDArray[np.float32]:
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


def whole_balls(middles: FloatArray, camera: Camera, T_map_camera: FloatArray) -> FloatArray:
    """How many rays balls with these middles [m, map] would fill if nothing hid them."""
    turn, eye = T_map_camera[:3, :3], T_map_camera[:3, 3]
    depth = np.maximum((middles - eye) @ turn[:, 2], 0.05)
    return np.pi * (camera.focal * RADIUS / depth) ** 2


def share_of_another(
    middle: FloatArray, view: View, camera: Camera, T_map_camera: FloatArray
) -> float:
    """Which share would be seen of one more ball, with its middle here [m, map]."""
    rays, depth, what = view
    turn, eye = T_map_camera[:3, :3].astype(np.float32), T_map_camera[:3, 3].astype(np.float32)
    balls, its_own = np.array([middle], np.float32), np.full_like(what, -1)
    see_balls(balls, rays, eye, depth.copy(), its_own, 0, edge_of_view(camera), turn)
    return np.count_nonzero(its_own == 0) / whole_balls(middle, camera, T_map_camera)


def whole_cages(scene: Scene, camera: Camera, T_map_camera: FloatArray) -> FloatArray:
    """How many rays the upright rectangle around each cage would fill if nothing hid it."""
    turn, eye = T_map_camera[:3, :3], T_map_camera[:3, 3]
    middles = np.array([c.foot + np.array([0, 0, 0.2]) for c in scene.cages]).reshape(-1, 3) - eye
    depth = np.maximum(middles @ turn[:, 2], 0.05)
    heights = np.array([c.rings[3] for c in scene.cages])
    return 2 * CAGE_RADIUS * heights * (camera.focal / depth) ** 2
