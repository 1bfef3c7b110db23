"""Is the robot stuck? It drives, and for a while comes no nearer to anything."""

from __future__ import annotations

from math import hypot, isfinite
from typing import NamedTuple

from robocon_course._arrays import FloatArray

WINDOW = 1.5
"""So long it may come nowhere [s]."""
LEAST = 0.03
"""Less than this is nowhere [m]."""
ORDERED = 0.1
"""A robot that is told to drive slower than this does not count as driving [m/s]."""


class Watch(NamedTuple):
    """What is remembered of the way so far.

    Attributes
    ----------
    since : float  [s]
        From when on it has come nowhere while it was told to drive; infinite: it came somewhere.
    x, y : float  [m, map]
        Where it was then.
    """

    since: float = float("inf")
    x: float = 0.0
    y: float = 0.0


def is_stuck(watch: Watch, now: float, pose: FloatArray, ordered: float) -> tuple[Watch, bool]:
    """One more look at a driving robot.

    Parameters
    ----------
    watch : Watch
        Before; it is left as it is.
    now : float  [s]
    pose : array_like, shape (3,)  [m, m, rad; map]
    ordered : float  [m/s]
        How fast it was told to drive.

    Returns
    -------
    watch : Watch
    stuck : bool
        Whether it was told to drive for `WINDOW` and came nowhere.
    """
    x, y = float(pose[0]), float(pose[1])
    if not ordered > ORDERED:
        return Watch(), False
    moved = hypot(x - watch.x, y - watch.y)
    if not isfinite(watch.since) or not moved <= LEAST:
        return Watch(now, x, y), False
    return watch, now - watch.since > WINDOW
