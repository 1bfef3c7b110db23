"""How well does the practice robot keep to a path? The whole loop, compiled, with its faults.

    own odometry → nearest point → speed of the profile → look-ahead → circle → both wheels

A trial of twenty seconds takes some milliseconds, so a slider may run one at every move and a
search hundreds. `Cart`, `nearest_point`, `lookahead_distance` and `pure_pursuit` in a loop of plain
Python do the same.
"""

from __future__ import annotations

from math import ceil, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray
from robocon_course.geometry import distance_along
from robocon_course.tracking.along import nearest_points
from robocon_course.tracking.differential import DT, DifferentialModel
from robocon_course.tracking.loop import CREEP, follow
from robocon_course.tracking.polyline import as_path
from robocon_course.tracking.profile import profile_times, speed_profile

ACCEL = 0.5
"""What the practice robot's tyres hold along the path [m/s^2]."""
PACE = 0.5
"""Share of the wheels' top speed that a robot has to keep on average: see `time_allowed`."""


class TrackingSettings(NamedTuple):
    """How a robot tracks.

    Attributes
    ----------
    k, least : float  [s, m]
        Look-ahead L = k v + least.
    speed : float  [m/s]
        On the straight.
    lateral : float  [m/s^2]
        Acceleration across the path that it allows itself in bends.
    """

    k: float = 0.1
    least: float = 0.05
    speed: float = 0.4
    lateral: float = 0.3


class Faults(NamedTuple):
    """What is wrong with the pose that the loop sees.

    Attributes
    ----------
    delay : float  [s]
        How old it is.
    dropped : float
        Share of the samples without one: the last order holds.
    noise : float  [m]
        Standard deviation of x and y; of the heading as many radians.
    """

    delay: float = 0.0
    dropped: float = 0.0
    noise: float = 0.0


class Trial(NamedTuple):
    """What came of it.

    Attributes
    ----------
    time : ndarray, shape (n,)  [s]
    poses : ndarray, shape (n, 3)  [m, m, rad; map]
        Where it really was.
    targets : ndarray, shape (n, 2)  [m, map]
        Look-ahead points.
    speeds : ndarray, shape (n,)  [m/s]
        Ordered.
    feet : ndarray, shape (n, 2)  [m, map]
        Nearest points of the path.
    cross_track : ndarray, shape (n,)  [m]
        Distance from the path; positive to its left.
    done : bool
        Whether it reached the end. Then ``duration`` counts.
    duration : float  [s]
        Until it reached it; infinity where it did not.
    """

    time: FloatArray
    poses: FloatArray
    targets: FloatArray
    speeds: FloatArray
    feet: FloatArray
    cross_track: FloatArray
    done: bool
    duration: float

    @property
    def worst(self) -> float:
        """Largest distance from the path  [m]."""
        return float(np.abs(self.cross_track).max())


def trial(
    path: ArrayLike,
    model: DifferentialModel = DifferentialModel(),  # noqa: B008 - frozen
    settings: TrackingSettings = TrackingSettings(),  # noqa: B008 - a NamedTuple cannot change
    *,
    faults: Faults = Faults(),  # noqa: B008
    rng: np.random.Generator | None = None,
) -> Trial:
    """Let the practice robot drive along a path, from its first point on and facing its second.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
        Finely drawn: see `path_curvature`.
    model : DifferentialModel
    settings : TrackingSettings
    faults : Faults
    rng : Generator, optional
        For what the faults leave to chance; without it, the same draws each time.

    Returns
    -------
    Trial
        Until it rests at the end, or gives up after four times what the profile takes.

    Raises
    ------
    ValueError
        No path, or settings or faults that mean nothing.

    Examples
    --------
    >>> run = trial([[0.0, 0.0], [1.0, 0.0]])
    >>> run.done, run.worst < 1e-3
    (True, True)
    """
    path, settings = as_path(path), _checked(TrackingSettings(*map(float, settings)))
    speeds = speed_profile(path, settings.speed, ACCEL, settings.lateral)
    longest = 4.0 * profile_times(path, np.maximum(speeds, CREEP))[-1] + 5.0
    noise, late = _drawn(Faults(*map(float, faults)), ceil(longest / DT), rng)
    out = np.empty((len(noise), 6))
    out[0, :3] = start_pose(path)
    sizes = model.wheel_base, model.metres_per_tick, model.lag, model.max_speed
    rows, end = follow(path, speeds**2, settings[:2], sizes, late, noise, out)
    poses = out[:rows, :3].copy()
    feet, away = nearest_points(path, poses)
    duration = DT * end if end >= 0 else inf
    time = DT * np.arange(rows)
    return Trial(time, poses, out[:rows, 3:5], out[:rows, 5], feet, away, end >= 0, duration)


def start_pose(path: ArrayLike) -> FloatArray:
    """A robot at a path's beginning that faces along it.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]

    Returns
    -------
    ndarray, shape (3,)  [m, m, rad; map]
        Heading 0 where all points are one.

    Raises
    ------
    ValueError
        No path.
    """
    path = as_path(path)
    dx, dy = path[np.argmax(np.any(path != path[0], axis=1))] - path[0]
    return np.array([*path[0], np.arctan2(dy, dx)])


def time_allowed(path: ArrayLike, model: DifferentialModel) -> float:
    """How long a trial may take that shall count: creeping keeps to any path.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    model : DifferentialModel

    Returns
    -------
    float  [s]
        On average at least half as fast as the wheels can.

    Raises
    ------
    ValueError
        No path.
    """
    return float(distance_along(as_path(path))[-1] / (PACE * model.max_speed))


def _drawn(faults: Faults, rows: int, rng: np.random.Generator | None) -> tuple[FloatArray, int]:
    """What is added to each pose, and how many samples old it is."""
    delay, dropped, noise = faults
    if not (0.0 <= delay < inf and 0.0 <= dropped < 1.0 and 0.0 <= noise < inf):
        raise ValueError(
            f"faults: expected a delay and noise from 0 on and a share below 1, got {faults}"
        )
    rng = np.random.default_rng(5) if rng is None else rng
    drawn = rng.normal(0.0, noise, (rows, 3)) if noise else np.zeros((rows, 3))
    if dropped:
        drawn[rng.random(rows) < dropped] = np.nan
    return drawn, round(delay / DT)


def _checked(settings: TrackingSettings) -> TrackingSettings:
    k, least, speed, lateral = settings
    if not (0.0 <= k < inf and all(0.0 < value < inf for value in (least, speed, lateral))):
        raise ValueError(
            f"settings: expected k from 0 s on, least, speed and lateral above 0, got {settings}"
        )
    return settings
