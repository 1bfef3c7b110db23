"""Where the robot is, by the distances to the walls around it.

Every LiDAR that looks squarely at a wall measures one coordinate. The robot knows its map, so it
knows what each should read where it believes to be; what is left over, the *residual*, moves the
pose along the beam, by as much as the pose is unsure beside the reading (a Kalman filter for each
axis):

    K = P / (P + R),    p <- p - K r u,    P <- (1 - K) P

A residual too large for both is a leg, or a broken sensor: it is counted and not believed. Where
all of them are too large for a while, it is the pose that is wrong.
"""

from __future__ import annotations

from functools import cache
from math import cos, hypot, inf, isfinite, pi, remainder, sin, sqrt
from typing import NamedTuple

import numpy as np
from numba import njit

from robocon_course import field
from robocon_course._arrays import FloatArray
from robocon_course.beams import SPOT, Surroundings, game_field, mean_distance
from robocon_course.field.maps import FLOOR_TABLE
from robocon_course.field.standing import floor_plane
from robocon_course.robot import LIDAR_HEIGHT, LIDARS, MODULES, SATURATED, WEAKEST, Observation

NOISE = 0.012
"""Of one reading, its rounding included: standard deviation [m]."""
BLUR = 0.0015
"""More of it for each metre: what the cone of light sees beside the wall."""
STALE = 0.1
"""A reading that is older, or from the future, is left alone [s]."""
NEAR, FAR = 0.13, 4.2
"""Readings outside of this are left alone [m]."""
SQUARE = 0.4
"""So much of a beam's light must meet something squarely: the mean cosine to its normal, where what
passes over a board counts 0. A floor gives a tenth."""
ASLANT = 0.35
"""No beam farther than this from an axis of the map is used [rad]."""
DRIFT, IDLE = 0.008, 0.0005
"""So unsure the pose gets over a metre of way, and in a second of standing [m]; the variance grows
with the way and the time."""
GATE = 0.05
"""A residual may be so large, and three standard deviations of the pose more [m]."""
WIDEST = 0.30
"""But no more than this [m]."""
UNSURE = 0.05
"""What a reset makes of the pose: so unsure it is then [m]."""
SURE = 0.003
"""So sure of both coordinates, a reset is done [m]."""
LOST_AFTER = 0.6
"""So long no reading fits, and the robot is lost [s]."""
CANDIDATES = 30
"""Of all places that are tried when lost, so many are looked at closely."""
FITS, CLEARLY = 0.04, 0.02
"""A place fits when its readings are off by no more than this in the mean [m], and clearly when
every other place is off by so much more."""
LOUD = 0.03
"""A surface that brings back so much light (cosine through distance squared) is always heard."""
_MOUNTS = np.array([(m.x, m.y, LIDAR_HEIGHT, m.angle) for m in LIDARS])
_HALF = 0.5 * np.radians(3.6)
_RAYS = SPOT * (_HALF, _HALF, 1.0)
_NO_CELLS = np.empty((0, 2), np.int64)


class Walls(NamedTuple):
    """What is remembered of the distances to the walls.

    Attributes
    ----------
    sigma : tuple of 2 floats  [m]
        How unsure x and y are.
    offsets : ndarray, shape (4,)  [m]
        What each LiDAR reads too much, as far as known.
    times : tuple of 4 floats  [s]
        Of the last reading of each that was looked at.
    used, refused : int
        Readings that moved the pose; readings that did not fit.
    lost_for : tuple of 2 floats  [s]
        How long none has fitted, along x and along y.
    """

    sigma: tuple[float, float]
    offsets: FloatArray
    times: tuple[float, ...] = (-inf,) * len(LIDARS)
    used: int = 0
    refused: int = 0
    lost_for: tuple[float, float] = (0.0, 0.0)

    @property
    def lost(self) -> bool:
        """Whether the walls have not been where they should be for a while."""
        return max(self.lost_for) > LOST_AFTER

    @property
    def sure(self) -> bool:
        """Whether both coordinates were measured."""
        return self.sigma[0] < SURE and self.sigma[1] < SURE

    def doubted(self) -> Walls:
        """After a reset: the pose is to be measured anew."""
        return self._replace(sigma=(UNSURE, UNSURE), lost_for=(0.0, 0.0))


@njit(cache=True)
def expected(x, y, theta, mounts, rays, world, modules, table, no_cells, out):
    """What each LiDAR should read, and how squarely it looks at that.

    Parameters
    ----------
    x, y, theta : float  [m, m, rad; map]
    mounts : ndarray, shape (n, 4)  [m, m, m, rad; base]
        x, y, height above the floor, direction.
    rays : ndarray, shape (k, 3)
        As `beams.SPOT`.
    world : Surroundings
    modules : ndarray, shape (4, 2)  [m, base]
        What the robot stands on.
    table : ndarray, shape (k, 7)
        `field.FLOOR_TABLE`.
    no_cells : ndarray of int64, shape (0, 2)
    out : ndarray, shape (n, 2)
        Distance [m] and mean cosine.
    """
    row = np.zeros(9)
    row[0], row[1], row[2] = x, y, theta
    floor_plane(x, y, theta, modules, table, row[6:])
    for j in range(len(mounts)):
        distance, light = mean_distance(row, mounts[j], rays, world, no_cells)
        out[j, 0] = distance
        out[j, 1] = light * distance * distance


@cache
def _map() -> Surroundings:
    return game_field()


def expected_readings(pose: FloatArray) -> FloatArray:
    """What each LiDAR should read at a pose.

    Parameters
    ----------
    pose : array_like, shape (3,)  [m, m, rad; map]

    Returns
    -------
    ndarray, shape (4, 2)
        Distance [m] and mean cosine to the surface: 1 for a wall, small for a floor.
    """
    out = np.empty((len(LIDARS), 2))
    x, y, theta = map(float, pose)
    expected(x, y, theta, _MOUNTS, _RAYS, _map(), MODULES, FLOOR_TABLE, _NO_CELLS, out)
    return out


def correct(
    walls: Walls, pose: FloatArray, seen: Observation, motion: tuple[float, float], dt: float
) -> tuple[Walls, FloatArray]:
    """A pose, moved by what the LiDARs say of it.

    Parameters
    ----------
    walls : Walls
        Before; it is left as it is.
    pose : ndarray, shape (3,)  [m, m, rad; map]
        By dead reckoning.
    seen : Observation
    motion : tuple of 2 floats  [m/s, map]
        How the robot moves: a reading is a little older than the counters.
    dt : float  [s]
        Since the step before.

    Returns
    -------
    walls : Walls
    pose : ndarray, shape (3,)  [m, m, rad; map]
    """
    vx, vy = map(float, motion)
    way = hypot(vx, vy) * dt
    variance = [sigma * sigma + DRIFT**2 * way + IDLE**2 * dt for sigma in walls.sigma]
    times, offsets = list(walls.times), walls.offsets.tolist()
    x, y, theta = pose.tolist()
    fits, misfits = [0, 0], [0, 0]
    if abs(remainder(theta, pi / 2)) < ASLANT and inside(x, y):
        should = expected_readings((x, y, theta)).tolist()
        moved = [x, y]
        for j, (mount, reading) in enumerate(zip(LIDARS, seen.lidar, strict=False)):
            age = seen.time - reading.time
            if reading.time == times[j] or not abs(age) <= STALE:
                continue
            times[j] = reading.time
            distance, square = should[j]
            strong = WEAKEST <= reading.strength < SATURATED and isfinite(reading.distance)
            if not (strong and NEAR < distance < FAR and square > SQUARE):
                continue
            c, s = cos(theta + mount.angle), sin(theta + mount.angle)
            axis, along = (0, c) if abs(c) > abs(s) else (1, s)
            # The reading was taken a little way back; along the beam that way counts.
            residual = reading.distance - offsets[j] - distance
            residual -= (vx * c + vy * s) * min(max(age, 0.0), 0.05)
            gate = min(GATE + 3.0 * sqrt(variance[axis]), WIDEST)
            if abs(residual) > gate:
                misfits[axis] += 1
                continue
            fits[axis] += 1
            noise = NOISE**2 + (BLUR * distance) ** 2
            gain = variance[axis] / (variance[axis] + noise)
            moved[axis] -= gain * residual / along
            variance[axis] *= 1.0 - gain
        pose = np.array([*moved, theta])
    lost_x, lost_y = (
        0.0 if fit else lost + dt * bool(misfit)
        for fit, misfit, lost in zip(fits, misfits, walls.lost_for, strict=True)
    )
    return Walls(
        (sqrt(variance[0]), sqrt(variance[1])), walls.offsets, tuple(times),
        walls.used + sum(fits), walls.refused + sum(misfits), (lost_x, lost_y),
    ), pose  # fmt: skip


def inside(x: float, y: float) -> bool:
    """Whether a point lies inside the own half.

    Parameters
    ----------
    x, y : float  [m, map]

    Returns
    -------
    bool
    """
    return bool(0.0 < x < field.EDGE and 0.0 < y < field.SIZE)


def measured_offsets(told: list) -> FloatArray:
    """What each LiDAR reads too much, from where the crew put the robot before the match.

    Parameters
    ----------
    told : list of (pose, readings)
        The pose (3,) [m, m, rad; map] that was meant, and tuples of `LidarReading`.

    Returns
    -------
    ndarray, shape (4,)  [m]
        0 for a LiDAR that never looked at a near wall.
    """
    offsets = np.zeros(len(LIDARS))
    nearest = np.full(len(LIDARS), 1.0)
    for pose, readings in told:
        should = expected_readings(pose)
        for j in range(len(LIDARS)):
            good = [r[j].distance for r in readings if WEAKEST <= r[j].strength < SATURATED]
            distance, square = should[j]
            if good and square > SQUARE and NEAR < distance < nearest[j]:
                nearest[j] = distance
                offsets[j] = float(np.mean(good)) - distance
    return offsets


def found_again(
    walls: Walls, pose: FloatArray, seen: Observation, step: float = 0.1
) -> FloatArray | None:
    """Where in Area 3 and the Storage Zone the four distances fit, whatever the pose was.

    Parameters
    ----------
    walls : Walls
    pose : ndarray, shape (3,)  [m, m, rad; map]
        Of which only the heading is believed.
    seen : Observation
    step : float  [m]
        Between the places that are tried.

    Returns
    -------
    ndarray, shape (3,), or None
        None: fewer than two readings, or no place fits clearly best.
    """
    heard = np.array([
        r.distance if WEAKEST <= r.strength < SATURATED else np.nan for r in seen.lidar
    ]) - walls.offsets  # fmt: skip
    theta = float(pose[2])
    if np.isfinite(heard).sum() < 2 or abs(remainder(theta, pi / 2)) > ASLANT:
        return None
    places = sorted(
        (_misfit(expected_readings((x, y, theta)), heard), x, y)
        for x in np.arange(0.5, 5.5, step)
        for y in np.arange(8.5, 11.55, step)
    )
    found = sorted(_slid(x, y, theta, heard) for _, x, y in places[:CANDIDATES])
    least, x, y = found[0]
    others = [misfit for misfit, ox, oy in found if hypot(ox - x, oy - y) > 0.3]
    clear = least < FITS and min(others, default=inf) > least + CLEARLY
    return np.array([x, y, theta]) if clear else None


def _slid(x: float, y: float, theta: float, heard: FloatArray) -> tuple[float, float, float]:
    """A place, moved along the beams to where they fit; how badly they then do comes first."""
    for _ in range(12):
        should = expected_readings((x, y, theta))
        for j, mount in enumerate(LIDARS):
            if np.isfinite(heard[j]) and should[j, 1] > SQUARE and heard[j] < FAR:
                angle = theta + mount.angle
                residual = float(np.clip(heard[j] - should[j, 0], -0.1, 0.1))
                x, y = x - 0.5 * residual * cos(angle), y - 0.5 * residual * sin(angle)
    return _misfit(expected_readings((x, y, theta)), heard), x, y


def _misfit(should: FloatArray, heard: FloatArray) -> float:
    """How badly readings fit a place: the mean distance that each is off, at most half a metre.

    All of them count, floors too, and a wall that should be heard and is not: a place may not fit
    because little is to be heard there.
    """
    distance, square = should.T
    loud = square > LOUD * distance**2
    off = np.minimum(np.abs(distance - heard), 0.5)
    silent = np.where(loud, 0.5, 0.0)
    return float(np.where(np.isfinite(heard), np.where(distance > 0.0, off, 0.5), silent).mean())
