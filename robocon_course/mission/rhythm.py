"""How often the two teams come to a silo, and what can be known of that during a match."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

ON_THEIR_WAY = 12.0
"""The other team's robot gets to Area 3 in about this time [s], as ours does."""
SHORTEST, LONGEST = 8.0, 45.0
"""No robot comes more often, or more seldom [s]."""
OWN_SHORTEST, OWN_LONGEST = 6.0, 20.0
OWN_LAST = 4
"""Our own pace is that of so many last balls."""


class Rhythm(NamedTuple):
    """How often the two teams come to a silo.

    Attributes
    ----------
    every : float  [s]
        From one of our balls to the next.
    next : float  [s]
        From our next ball to theirs, as far as can be said; below 0 they are late.
    period, spread : float  [s]
        From one of their balls to the next, and how unsure that is.
    """

    every: float = 9.0
    next: float = 12.0
    period: float = 20.0
    spread: float = 4.0


def rhythm_seen(
    arrival: float, began: float, stored: Sequence[float], theirs: Sequence[float]
) -> Rhythm:
    """Both teams' rhythm by what was seen of them.

    Their pace counts from when their robot got to Area 3, as if a ball had come then: so the first
    ball tells it already. Where they are late by more than half of it, one was missed, by them or
    by the camera.

    Parameters
    ----------
    arrival : float  [s]
        When our next ball will be at its silo.
    began : float  [s]
        When the match began.
    stored, theirs : sequence of float  [s]
        When our balls and theirs came into silos.

    Returns
    -------
    Rhythm

    Examples
    --------
    They came after 25 and 38 s, so every 13 s; we came after 18 and 27 s and come again after 36.

    >>> rhythm_seen(36.0, 0.0, [18.0, 27.0], [25.0, 38.0])
    Rhythm(every=9.0, next=15.0, period=13.0, spread=2.6)
    """
    usual = Rhythm()
    first = began + ON_THEIR_WAY
    last = theirs[-1] if theirs else first
    period = (last - first) / len(theirs) if theirs else usual.period
    period = min(max(float(period), SHORTEST), LONGEST)
    own = np.diff(stored)[-OWN_LAST:]
    every = (2 * usual.every + own.sum()) / (2 + len(own))
    since = arrival - last
    awaited = max(1, round(since / period)) * period
    return Rhythm(
        min(max(float(every), OWN_SHORTEST), OWN_LONGEST), awaited - since, period, 0.2 * period
    )
