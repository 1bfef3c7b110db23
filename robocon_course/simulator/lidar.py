"""What does a TFmini Plus read, given where it is?

It lights a cone of 3.6 degrees and tells one distance. Seven rays stand for the cone: its middle
with a quarter of the light, six around it with an eighth each. A ray that meets a surface at the
distance d_k and the angle a_k to its normal brings back

    I_k = w_k ρ cos(a_k) / d_k^2        strength = 16000 Σ I_k        distance = Σ I_k d_k / Σ I_k

so a spot that is half on a board and half on the floor behind it reads somewhere between. 16000
makes the strength 100, the weakest that counts, at 12 m before a surface of 90 % reflectivity.

Source: Benewake, TFmini Plus data sheet SJ-GU-TFmini-Plus-01 A04 (range, accuracy, field of view,
validity); M. Abramowitz, I. Stegun, Handbook of Mathematical Functions, 1964, formula 25.4.61,
seven points (the mean over a disc); the split into offset and noise is assumed.
"""

from __future__ import annotations

from functools import cache
from math import cos, floor, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course._arrays import FloatArray
from robocon_course.field import ORIGIN, height_map
from robocon_course.raycast import walk
from robocon_course.robot import LIDAR_RANGE, SATURATED, WEAKEST

FULL_STRENGTH = 16000.0
BRIGHTEST = 60000.0
"""The sensor dims its lamp before a near surface drives it into saturation."""

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


class Lidars(NamedTuple):
    """A robot's LiDARs, as the kernel takes them.

    Attributes
    ----------
    mounts : ndarray, shape (n, 4)  [m, m, m, rad; base]
        x, y, height above the floor, direction.
    rays : ndarray, shape (k, 3)  [rad, rad, -]
        To the left, upwards, share of the light.
    offsets : ndarray, shape (n,)  [m]
    phases : ndarray of int64, shape (n,)
        Sensor j measures at the ticks phases[j] + every * k.
    every : int
    noise, band : float  [m]
    step_mm : float
    reflectivity : float
    """

    mounts: FloatArray
    rays: FloatArray
    offsets: FloatArray
    phases: np.ndarray
    every: int
    noise: float
    band: float
    step_mm: float
    reflectivity: float


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


@njit(cache=True)
def look(track, tick, lidars, world, noise, first, out):
    """The latest reading of each LiDAR at a tick.

    Parameters
    ----------
    track : ndarray, shape (rows, TRACK)
        As `physics.advance` leaves it.
    tick : int
    lidars : Lidars
    world : Surroundings
    noise : ndarray, shape (m, n)
        Standard normal numbers, a row a sample; sample k of a sensor has row k + 1 - ``first``.
    first : int
    out : ndarray, shape (n, 3)
        Tick of the measurement, distance [m], strength.
    """
    no_cells = np.empty((0, 2), np.int64)
    for j in range(len(out)):
        samples = (tick - lidars.phases[j]) // lidars.every
        moment = lidars.phases[j] + lidars.every * samples
        distance, light = _mean_distance(
            track[moment % len(track)], lidars.mounts[j], lidars.rays, world, no_cells
        )
        strength = round(min(FULL_STRENGTH * lidars.reflectivity * light, BRIGHTEST))
        error = lidars.offsets[j] + lidars.noise * noise[samples + 1 - first, j]
        band = max(lidars.band, 0.01 * distance)
        reading = distance + min(max(error, -band), band)
        if distance < LIDAR_RANGE[0] and strength >= WEAKEST:
            strength = SATURATED
        if strength < WEAKEST or strength == SATURATED or reading > LIDAR_RANGE[1]:
            reading = 0.0
        out[j, 0], out[j, 2] = moment, strength
        out[j, 1] = np.rint(reading * 1000.0 / lidars.step_mm) * lidars.step_mm / 1000.0


@njit
def _mean_distance(row, mount, rays, world, no_cells):
    """Where the light of one sensor comes back from, and how much of it (Σ w cos / d^2)."""
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
            share *= cosine / max(distance, LIDAR_RANGE[0]) ** 2
            light += share
            way += share * distance
    return (way / light if light > 0.0 else 0.0), light


@njit
def _meet(world, x, y, z, angle, climb, no_cells):
    """Distance [m] at which a ray meets a surface, and the cosine to its normal; 0 for nothing."""
    dx, dy, size = cos(angle), sin(angle), world.resolution
    reach = LIDAR_RANGE[1] / size
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
