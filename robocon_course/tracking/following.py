"""A path, with a speed for each point -> the velocity of a robot that drives in any direction.

A swerve robot need not steer: it moves where it is told and looks where it is told. So

    v = v(s) sqrt(1 - (e/L)²) t  +  λ (f - p)        f: nearest point, e = |f - p|
    ω = v(s) dθ/ds               +  λ (θ(s) - θ)

t points from f to the look-ahead point. On a bend that is the path's direction L/2 ahead, which is
what modules need that turn late: L = 2 · lag · v. The second terms lead back, like exp(-λ t).

Source: the control law is that of I. Siradjuddin, S. Wibowo, A. Rofiq, Modelling and simulation of
the kinematics of a four-wheel swerve robot (in Indonesian), Politeknik Negeri Malang, 2022,
equation 27, with the path's own velocity in place of the target's.
"""

from __future__ import annotations

from math import hypot, inf, isfinite, remainder, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.geometry import TURN
from robocon_course.tracking.polyline import as_path, check_start, look
from robocon_course.tracking.pursuit import TOLERANCE

CREEP = 0.05
"""Slowest speed on the way [m/s]: at its ends a profile says 0."""
GAIN = 3.0
"""λ [1/s]: back on the path in a second. Noise of the pose times this is noise of the velocity."""


class LookAhead(NamedTuple):
    """How far ahead to look: L = k v + least.

    Attributes
    ----------
    k : float  [s]
        Twice the lag of its steering.
    least : float  [m]
    """

    k: float = 0.1
    least: float = 0.05


class PathTwist(NamedTuple):
    """What `follow_path` says.

    Attributes
    ----------
    twist : ndarray, shape (3,)  [m/s, m/s, rad/s; map]
    index : int
        Segment of the nearest point: the next call's ``start_index``.
    speed : float  [m/s]
        Along the path.
    cross_track : float  [m]
        Distance from the path; positive where the robot is to its left.
    done : bool
        The end is reached. The twist goes on holding the robot there.
    """

    twist: FloatArray
    index: int
    speed: float
    cross_track: float
    done: bool


class FollowerState(NamedTuple):
    """All that a `PathFollower` remembers.

    Attributes
    ----------
    index : int
        Segment of the nearest point.
    speed : float  [m/s]
        Along the path, at the last sample.
    twist : tuple of 3 floats  [m/s, m/s, rad/s; map]
        The last one.
    done : bool
    missed : int
        Samples in a row without a pose.
    rejected : int
        All samples without one.
    """

    index: int = 0
    speed: float = 0.0
    twist: tuple[float, float, float] = (0.0, 0.0, 0.0)
    done: bool = False
    missed: int = 0
    rejected: int = 0


def follow_path(
    path: ArrayLike,
    speeds: ArrayLike,
    pose: ArrayLike,
    lookahead: float,
    start_index: int = 0,
    *,
    headings: ArrayLike | None = None,
    gain: float = GAIN,
    creep: float = CREEP,
    tolerance: float = TOLERANCE,
) -> PathTwist:
    """Velocity that leads along a path and back to it.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    speeds : array_like, shape (n,)  [m/s]
        At each point, as from `speed_profile`.
    pose : array_like, shape (3,)  [m, m, rad; map]
        Where it is not finite, the twist is not either and the index stays.
    lookahead : float  [m]
    start_index : int
        Segment from which the search begins: ``index`` of the call before.
    headings : array_like, shape (n,) or (), optional  [rad, map]
        Where to look at each point, or everywhere; between points the shorter way round. None: it
        does not turn.
    gain : float  [1/s]
    creep : float  [m/s]
        Slowest speed along the path short of its end.
    tolerance : float  [m]
        How near to the end counts as there.

    Returns
    -------
    PathTwist

    Raises
    ------
    ValueError
        Wrong shapes or settings. Never for the pose: this runs in a control loop.

    Examples
    --------
    To the left of a path along x, half a look-ahead off: ahead, and back to the right.

    >>> found = follow_path([[0, 0], [2, 0]], [1.0, 1.0], [0.5, 0.125, 0.0], 0.25, gain=2.0)
    >>> found.twist.round(3).tolist(), found.cross_track
    ([0.866, -0.25, 0.0], 0.125)
    """
    path, start = as_path(path), int(start_index)
    speeds = as_floats(speeds, "speeds", len(path))
    pose = as_floats(pose, "pose", 3, finite=False)
    headings = _as_headings(headings, len(path))
    for name, value in (("lookahead", lookahead), ("gain", gain), ("tolerance", tolerance)):
        if not 0.0 < value < inf:
            raise ValueError(f"{name}: expected a number above 0, got {value}")
    if not 0.0 <= creep < inf or (speeds < 0.0).any():
        raise ValueError("creep, speeds: expected m/s from 0 on")
    check_start(path, start)
    top = max(float(speeds.max()), creep)
    settings = (lookahead, gain, creep, top, tolerance)
    return _follow(path, speeds, headings, pose, settings, start)


def _follow(
    path: FloatArray,
    speeds: FloatArray,
    headings: FloatArray | None,
    pose: FloatArray,
    settings: tuple[float, float, float, float, float],
    start: int,
) -> PathTwist:
    if not np.isfinite(pose).all():
        return PathTwist(np.full(3, np.nan), start, np.nan, np.nan, False)
    lookahead, gain, creep, top, tolerance = settings
    x, y, theta = pose.tolist()
    (index, share, fx, fy, away), (segment, s, tx, ty), way = look(path, x, y, start, lookahead)
    at_end = segment == len(path) - 2 and s == 1.0
    # v² is a straight line over a segment. At the end the speed fades with the way that is left.
    square = speeds[index] ** 2 + share * (speeds[index + 1] ** 2 - speeds[index] ** 2)
    speed = max(sqrt(square), min(creep, gain * way) if at_end else creep)
    along = speed * sqrt(max(0.0, 1.0 - (away / lookahead) ** 2))
    chord = hypot(tx - fx, ty - fy)
    ux, uy = ((tx - fx) / chord, (ty - fy) / chord) if chord > 0.0 else (0.0, 0.0)
    # Far off the path the way back is no faster than the way along may be.
    pull = gain if gain * away <= top else top / away
    turn = 0.0
    if headings is not None:
        here, there = _heading_at(headings, index, share), _heading_at(headings, segment, s)
        # ω = v dθ/ds + λ (θ(s) - θ)
        turn = along * remainder(there - here, TURN) / way if way > 0.0 else 0.0
        turn += gain * remainder(here - theta, TURN)
    twist = np.array([along * ux + pull * (fx - x), along * uy + pull * (fy - y), turn])
    dx, dy = path[index + 1] - path[index]
    left = dx * (y - fy) - dy * (x - fx) >= 0.0
    done = at_end and way + away <= tolerance
    return PathTwist(twist, index, along, away if left else -away, done)


class PathFollower:
    """Follows one path in a control loop; remembers how far it is.

    Parameters
    ----------
    path : array_like, shape (n, 2)  [m, map]
    speeds : array_like, shape (n,)  [m/s]
        As from `speed_profile`.
    headings : array_like, shape (n,) or (), optional  [rad, map]
    lookahead : LookAhead
    gain : float  [1/s]
    patience : int
        For so many samples in a row without a pose the last twist holds; then the robot stops.

    Attributes
    ----------
    path, speeds, headings : as given

    Raises
    ------
    ValueError
        Wrong shapes or settings.
    """

    def __init__(
        self,
        path: ArrayLike,
        speeds: ArrayLike,
        *,
        headings: ArrayLike | None = None,
        lookahead: LookAhead = LookAhead(),  # noqa: B008 - a NamedTuple cannot change
        gain: float = GAIN,
        patience: int = 10,
    ) -> None:
        if not (0.0 <= lookahead.k < inf and 0.0 < lookahead.least < inf):
            raise ValueError(
                f"lookahead: expected k from 0 s on and least above 0 m, got {lookahead}"
            )
        if patience < 0:
            raise ValueError(f"patience: expected samples from 0 on, got {patience}")
        follow_path(path, speeds, np.full(3, np.nan), 1.0, headings=headings, gain=gain)
        self.path, self.headings = as_path(path).copy(), _as_headings(headings, len(path))
        self.speeds = as_floats(speeds, "speeds", len(path)).copy()
        self._lookahead, self._gain, self._patience = lookahead, float(gain), int(patience)
        self._top = max(float(self.speeds.max()), CREEP)
        self.state = FollowerState()

    def update(self, pose: ArrayLike) -> FloatArray:
        """The velocity after one more look at the pose.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]
            Where it is not finite, the last twist holds for a while, and the sample is counted.

        Returns
        -------
        ndarray, shape (3,)  [m/s, m/s, rad/s; map]
            For the robot's own axes: `swerve.field_to_robot`.

        Raises
        ------
        ValueError
            Not three numbers.
        """
        pose, old = as_floats(pose, "pose", 3, finite=False), self.state
        distance = self._lookahead.k * old.speed + self._lookahead.least
        settings = (distance, self._gain, CREEP, self._top, TOLERANCE)
        found = _follow(self.path, self.speeds, self.headings, pose, settings, old.index)
        if isfinite(found.speed):
            twist = tuple(found.twist.tolist())
            self.state = FollowerState(
                found.index, found.speed, twist, found.done, rejected=old.rejected
            )
        else:
            missed = old.missed + 1
            twist = old.twist if missed <= self._patience else (0.0, 0.0, 0.0)
            self.state = old._replace(twist=twist, missed=missed, rejected=old.rejected + 1)
        return np.array(self.state.twist)

    @property
    def done(self) -> bool:
        """Whether the end is reached."""
        return self.state.done

    @property
    def rejected(self) -> int:
        """How many samples had no pose."""
        return self.state.rejected


def _as_headings(headings: ArrayLike | None, n: int) -> FloatArray | None:
    if headings is None:
        return None
    return as_floats(np.full(n, headings) if np.ndim(headings) == 0 else headings, "headings", n)


def _heading_at(headings: FloatArray, index: int, share: float) -> float:
    first, second = headings[index], headings[index + 1]
    return float(first + share * remainder(second - first, TURN))
