"""Where light comes back from: one sensor's cone of light in a world of walls.

A TFmini Plus lights a cone of 3.6 degrees and tells one distance. Seven rays stand for the cone:
its middle with a quarter of the light, six around it with an eighth each. A ray that meets a
surface at the distance d_k and the angle a_k to its normal brings back

    I_k = w_k cos(a_k) / d_k^2          distance = Σ I_k d_k / Σ I_k

so a spot that is half on a board and half on the floor behind it reads somewhere between. The
simulator measures with it; the robot asks it what it should measure where it believes to be.

Source: Benewake, TFmini Plus data sheet SJ-GU-TFmini-Plus-01 A04 (field of view); M. Abramowitz,
I. Stegun, Handbook of Mathematical Functions, 1964, formula 25.4.61, seven points (the mean over a
disc).
"""

from __future__ import annotations

from functools import cache
from math import cos, floor, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course.field import ORIGIN, height_map
from robocon_course.raycast import walk

NEAREST = 0.1
"""Light from nearer than this is taken to come from here [m]."""
REACH = 12.0
"""Light from farther away is lost [m]."""

_A, _B, _C = sqrt(2 / 3), sqrt(1 / 6), sqrt(1 / 2)
SPOT = np.array(
    [
        (0.0, 0.0, 1 / 4),
        *((x, y, 1 / 8) for x, y in ((_A, 0.0), (-_A, 0.0))),
        *((x, y, 1 / 8) for x in (_B, -_B) for y in (_C, -_C)),
    ]
)
"""Rays of a cone of half angle 1: to the left, upwards, share of the light."""
LINE = np.array([(0.0, 0.0, 1.0)])
"""The same of a cone that is none."""


class Surroundings(NamedTuple):
    """What the light meets.

    Attributes
    ----------
    height : ndarray, shape (rows, cols)  [m]
        Of the highest thing in each cell.
    blocks : ndarray, shape (rows / BLOCK, cols / BLOCK)  [m]
        The highest of the cells in each block.
    x, y : float  [m, map]
        Outer corner of cell (0, 0).
    resolution : float  [m]
    """

    height: np.ndarray
    blocks: np.ndarray
    x: float
    y: float
    resolution: float


BLOCK = 10
"""Cells on a side of a block."""


@cache
def game_field() -> Surroundings:
    """The game field at 1 cm."""
    resolution = 0.01
    height = height_map(resolution)
    rows, cols = height.shape
    blocks = height.reshape(rows // BLOCK, BLOCK, cols // BLOCK, BLOCK).max(axis=(1, 3))
    return Surroundings(height, blocks, *ORIGIN, resolution)


@njit
def mean_distance(row, mount, rays, world, no_cells):
    """Where the light of one sensor comes back from [m], and how much of it (Σ w cos / d^2).

    Parameters
    ----------
    row : ndarray, shape (9,)
        x, y, heading of the robot [m, m, rad; map] first, then at 6, 7, 8 the slopes of the floor
        along its axes and the floor's height [m].
    mount : ndarray, shape (4,)  [m, m, m, rad; base]
        x, y, height above the floor, direction.
    rays : ndarray, shape (k, 3)  [rad, rad, -]
        To the left, upwards, share of the light.
    world : Surroundings
    no_cells : ndarray of int64, shape (0, 2)
    """
    heading, rise_x, rise_y = row[2], row[6], row[7]
    c, s = cos(heading), sin(heading)
    x = (row[0] + c * mount[0] - s * mount[1] - world.x) / world.resolution
    y = (row[1] + s * mount[0] + c * mount[1] - world.y) / world.resolution
    z = row[8] + rise_x * mount[0] + rise_y * mount[1] + mount[2]
    light = way = 0.0
    for k in range(len(rays)):
        left, up, share = rays[k, 0], rays[k, 1], rays[k, 2]
        angle = mount[3] + left
        climb = rise_x * cos(angle) + rise_y * sin(angle) + up  # the beam tilts with the robot
        distance, cosine = _meet(world, x, y, z, heading + angle, climb, no_cells)
        if cosine > 0.0:
            share *= cosine / max(distance, NEAREST) ** 2
            light += share
            way += share * distance
    return (way / light if light > 0.0 else 0.0), light


@njit
def _meet(world, x, y, z, angle, climb, no_cells):
    """Distance [m] at which a ray meets a surface, and the cosine to its normal; 0 for nothing."""
    dx, dy, size = cos(angle), sin(angle), world.resolution
    reach = REACH / size
    # In long steps to the first block that might be in the way, in short ones from there.
    way, _ = walk(
        world.blocks, x / BLOCK, y / BLOCK, z, dx, dy, climb * size * BLOCK, reach / BLOCK, no_cells
    )
    way *= BLOCK
    if way < reach:
        x, y, z = x + way * dx, y + way * dy, z + way * climb * size
        rest, _ = walk(world.height, x, y, z, dx, dy, climb * size, reach - way, no_cells)
        way, x, y = way + rest, x + rest * dx, y + rest * dy
    if way >= reach:
        return 0.0, 0.0
    col, row = floor(x + 1e-6 * dx), floor(y + 1e-6 * dy)  # behind the edge
    rows, cols = world.height.shape
    left, right = max(col - 1, 0), min(col + 1, cols - 1)
    below, above = max(row - 1, 0), min(row + 1, rows - 1)
    rise_x = (world.height[row, right] - world.height[row, left]) / ((right - left) * size)
    rise_y = (world.height[above, col] - world.height[below, col]) / ((above - below) * size)
    slant = sqrt(1.0 + climb * climb)
    cosine = (dx * rise_x + dy * rise_y - climb) / slant
    return way * size * slant, cosine / sqrt(1.0 + rise_x * rise_x + rise_y * rise_y)
