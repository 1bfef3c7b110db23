"""Guards and rooms as data: they are called like functions, and can be sent and compared."""

from __future__ import annotations

from math import cos, sin
from typing import NamedTuple


class Fact(NamedTuple):
    """A guard: one of the facts is as wanted.

    Attributes
    ----------
    name : str
        Of a field of `Facts`.
    wanted : bool
    """

    name: str
    wanted: bool = True

    def __call__(self, facts: object) -> bool:
        """Whether it is so."""
        return bool(getattr(facts, self.name)) == self.wanted


class Room(NamedTuple):
    """A rectangle that a square body has to stay in.

    Attributes
    ----------
    x0, x1, y0, y1 : float  [m, map]
    side : float  [m]
        Of the body.
    """

    x0: float
    x1: float
    y0: float
    y1: float
    side: float

    def __call__(self, x: float, y: float, heading: float) -> bool:
        """Whether the square fits there, turned by a heading [m, m, rad]."""
        reach = 0.5 * self.side * (abs(cos(heading)) + abs(sin(heading)))
        return self.x0 + reach <= x <= self.x1 - reach and self.y0 + reach <= y <= self.y1 - reach
