"""Who else plays: the other team's Robot 2, and both Robots 1.

The other Robot 2 is its plan of times and order B; Robot 1 plants seedlings and sends balls by the
clock. What Robot 1 does for one team it does for the other.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from robocon_course import field
from robocon_course.field import SEEDLINGS
from robocon_course.mission import order_b
from robocon_course.simulator.balls import Balls
from robocon_course.simulator.referee import OPPONENTS, TEAMS, Referee, plan

PLANTS = 5.0
"""Robot 1 plants a seedling every so many seconds [s]."""
FEED = (12.0, 7.0)
"""It sends a ball from then on, so often [s]: own and empty in turns, and never more balls than
seedlings were planted."""


class Others:
    """All robots but the own Robot 2.

    Parameters
    ----------
    team : {"red", "blue"}
        The own one.
    opponent : {"weak", "middling", "strong"} or None
        None: the other team has no Robot 2.
    rng : mapping of numpy.random.Generator
        ``"opponent"`` and ``"feed"``.
    sent : int
        So many balls come from Robot 1. More than `SEEDLINGS` are against the rules and worth
        nothing: they are there so that a measurement does not run out of balls.
    """

    def __init__(
        self,
        team: str,
        opponent: str | None,
        rng: Mapping[str, np.random.Generator],
        sent: int = SEEDLINGS,
    ) -> None:
        self._colours = (team, "purple")
        self._theirs = "blue" if team == "red" else "red"
        self._rng = rng["feed"]
        self._plan = plan(rng["opponent"], OPPONENTS[opponent]) if opponent else []
        self._y = float(field.SILO_POST[1])
        self._sent, self._planted, self._fed = sent, 0, 0

    def act(self, now: float, referee: Referee, balls: Balls) -> None:
        """What they have done up to a time of the match [s].

        Parameters
        ----------
        now : float  [s]
        referee : Referee
            Is told.
        balls : Balls
            Those that are sent come to lie among them.
        """
        if referee.winner:  # the own robot has just won: nothing counts any more
            return
        while self._plan and self._plan[0][0] <= now and not referee.winner:
            self._store(now, referee, self._plan.pop(0)[1])
        if self._planted < SEEDLINGS and now >= PLANTS * (self._planted + 1):
            self._planted += 1
            for team in TEAMS:
                referee.give(now, team, "seedling")
        first, every = FEED
        may = self._sent if self._planted == SEEDLINGS else min(self._sent, self._planted)
        if self._fed < may and now >= first + every * self._fed:
            at = float(self._rng.uniform(0.5, 1.9)), 8.15
            speed = float(self._rng.uniform(-0.15, 0.15)), float(self._rng.uniform(0.5, 0.9))
            balls.add(at, speed, self._colours[self._fed % 2])
            self._fed += 1
            for team in TEAMS if self._fed <= SEEDLINGS else ():
                referee.give(now, team, "transfer")

    def _store(self, now: float, referee: Referee, falls_in: bool) -> None:
        """The other Robot 2 is at a silo."""
        silo = order_b(referee.fillings, self._theirs, self._y)
        if silo is None:
            return
        self._y = float(field.SILOS[silo][1])
        if falls_in:
            referee.store(now, "theirs", silo)
        else:
            referee.note(now, "lost ball", "theirs")
