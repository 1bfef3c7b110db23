"""What does a TFmini Plus read, given where it is?

`beams` says where its light comes back from. A surface of reflectivity ρ brings back the strength

    16000 ρ Σ w_k cos(a_k) / d_k^2

16000 makes it 100, the weakest that counts, at 12 m before a surface of 90 %.

Source: Benewake, TFmini Plus data sheet SJ-GU-TFmini-Plus-01 A04 (range, accuracy, validity); the
split into offset and noise is assumed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course._arrays import FloatArray
from robocon_course.beams import LINE, SPOT, Surroundings, game_field, mean_distance
from robocon_course.robot import LIDAR_RANGE, SATURATED, WEAKEST

__all__ = ["LINE", "SPOT", "Lidars", "Surroundings", "game_field", "look"]

FULL_STRENGTH = 16000.0
BRIGHTEST = 60000.0
"""The sensor dims its lamp before a near surface drives it into saturation."""


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
        distance, light = mean_distance(
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
