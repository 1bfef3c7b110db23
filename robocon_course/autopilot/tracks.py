"""Balls remembered from picture to picture: which sighting belongs to which, and which are gone.

The nearest sighting goes to each track, one to one; what is left begins a track of its own. A track
that is not found where it should be, several times in a row, is dropped.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import hypot
from typing import NamedTuple

from robocon_course.mission import SeenBall
from robocon_course.vision import BALLS

SAME = 0.13
"""Two sightings so near to each other are of one ball [m]; farther away they spread more."""
OTHER_COLOUR = 0.08
"""A sighting of another colour counts as so much farther away [m]."""
APART = 0.08
"""Tracks nearer to each other are of one ball [m]: two balls' middles are a diameter apart."""
MISSES = 4
"""So often not found where it should be, a ball is gone."""
ROLLED = 0.02
"""From one picture to the next a ball may have rolled so far [m]."""


class Spot(NamedTuple):
    """A ball as one picture shows it.

    Attributes
    ----------
    x, y : float  [m, map]
    variance : float  [m^2]
    colour : int
        Its class number.
    score : float
    """

    x: float
    y: float
    variance: float
    colour: int
    score: float


class Track(NamedTuple):
    """A ball that was seen, perhaps several times.

    Attributes
    ----------
    x, y : float  [m, map]
    variance : float  [m^2]
    votes : tuple of 3 floats
        For each colour, the sum of its scores.
    hits, misses : int
        How often it was found, and how often in a row not.
    """

    x: float
    y: float
    variance: float
    votes: tuple[float, float, float]
    hits: int
    misses: int

    @property
    def ball(self) -> SeenBall:
        """As the mission takes it."""
        return SeenBall(self.x, self.y, BALLS[self.colour])

    @property
    def colour(self) -> int:
        """Its most likely class number."""
        return self.votes.index(max(self.votes))


def matched(
    tracks: Sequence[Track], spots: Sequence[Spot], expected: Callable[[Track], bool]
) -> list[Track]:
    """Tracks after one more picture.

    Parameters
    ----------
    tracks : sequence of Track
    spots : sequence of Spot
        What the picture shows.
    expected : callable
        Whether a track's ball should be found in it.

    Returns
    -------
    list of Track
        The oftenest seen first.
    """
    pairs = sorted(
        (_gap(track, spot), i, j) for i, track in enumerate(tracks) for j, spot in enumerate(spots)
    )
    taken: dict[int, int] = {}
    for gap, i, j in pairs:
        near = gap < SAME + 2.0 * spots[j].variance ** 0.5
        if near and i not in taken and j not in taken.values():
            taken[i] = j
    kept = []
    for i, track in enumerate(tracks):
        if i in taken:
            kept.append(_updated(track, spots[taken[i]]))
        else:
            misses = track.misses + expected(track)
            if misses < MISSES:
                kept.append(track._replace(misses=misses))
    new = [spot for j, spot in enumerate(spots) if j not in taken.values()]
    kept += [Track(spot.x, spot.y, spot.variance, _vote(spot), 1, 0) for spot in new]
    return _one_each(kept)


def _gap(track: Track, spot: Spot) -> float:
    """How far a sighting is from a track, its colour counted [m]."""
    return hypot(track.x - spot.x, track.y - spot.y) + OTHER_COLOUR * (track.colour != spot.colour)


def _vote(spot: Spot) -> tuple[float, ...]:
    return tuple(spot.score if k == spot.colour else 0.0 for k in range(len(BALLS)))


def _updated(track: Track, spot: Spot) -> Track:
    """A track and one more sighting of it; balls may roll, so the old never counts for all."""
    before = track.variance + ROLLED**2
    gain = before / (before + spot.variance)
    votes = tuple(0.5 * old + new for old, new in zip(track.votes, _vote(spot), strict=True))
    return Track(
        track.x + gain * (spot.x - track.x), track.y + gain * (spot.y - track.y),
        (1.0 - gain) * before, votes, track.hits + 1, 0,
    )  # fmt: skip


def _one_each(tracks: Sequence[Track]) -> list[Track]:
    """Tracks of which no two can be of one ball; those that were seen oftenest stay."""
    apart: list[Track] = []
    for track in sorted(tracks, key=lambda one: -one.hits):
        k = next(
            (k for k, other in enumerate(apart)
             if hypot(track.x - other.x, track.y - other.y) < APART), None,
        )  # fmt: skip
        if k is None:
            apart.append(track)
        else:
            votes = tuple(a + b for a, b in zip(apart[k].votes, track.votes, strict=True))
            apart[k] = apart[k]._replace(votes=votes)
    return apart
