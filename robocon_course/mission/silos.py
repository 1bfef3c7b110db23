"""Which silo to fill next.

A silo holds three balls. One that is full, with at least two of ours and one of ours on top, is
ours; three of them win the match at once (Mua Vang). The other team fills the same five.

Fillings are written from bottom to top as in `vision.SILOS`: ``"RB"`` is a blue ball on a red one.

Source: orders A and B of two teams' robots of 2024 (mixed pair before own pair before the other
team's pair before an empty silo before one own ball before one of theirs).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

from robocon_course._arrays import CourseError
from robocon_course.field import SILO_CAPACITY, SILOS

LETTERS = {"red": "R", "blue": "B"}
"""Of each team's balls."""
WINS = 3
"""So many silos win at once."""
DISTANCE_WEIGHT = 0.1
"""Order B takes off this much for a metre of way."""
DEPTH = 3
"""How many balls the better order looks ahead: ours, theirs, ours."""


def own_and_theirs(filling: str, team: str) -> tuple[int, int]:
    """How many balls of each team a silo holds.

    Parameters
    ----------
    filling : str
    team : {"red", "blue"}

    Returns
    -------
    own, theirs : int
    """
    letter = _letter(team)
    own = filling.count(letter)
    return own, len(filling.replace("empty", "")) - own


def is_full(filling: str) -> bool:
    """Whether no ball fits into a silo any more."""
    return len(_balls(filling)) >= SILO_CAPACITY


def owner(filling: str) -> str | None:
    """Whose a silo is: full, two balls of one team, the same team's on top.

    Returns
    -------
    {"R", "B"} or None
    """
    balls = _balls(filling)
    top = balls[-1:]
    return top if len(balls) == SILO_CAPACITY and balls.count(top) >= 2 else None


def winner(fillings: Sequence[str]) -> str | None:
    """The team that has `WINS` silos, or None."""
    owners = [owner(filling) for filling in fillings]
    return next((team for team in "RB" if owners.count(team) >= WINS), None)


def after(filling: str, letter: str) -> str:
    """A silo with one more ball on top."""
    return _balls(filling) + letter


def order_a(fillings: Sequence[str], team: str, y: float) -> int | None:
    """Order A: by the kind of filling, ties by distance.

    Parameters
    ----------
    fillings : sequence of str
        Of silos 1 to 5.
    team : {"red", "blue"}
    y : float  [m, map]
        Where the robot is along the row of silos.

    Returns
    -------
    int or None
        Index of the silo; None if all are full.
    """
    return _best(fillings, lambda k: (_rank(fillings[k], team), -abs(SILOS[k][1] - y)))


def order_b(fillings: Sequence[str], team: str, y: float) -> int | None:
    """Order B: points for the kind of filling, less a little for the way. As `order_a` else."""
    return _best(
        fillings,
        lambda k: _rank(fillings[k], team) - DISTANCE_WEIGHT * abs(SILOS[k][1] - y),
    )


def choose_silo(fillings: Sequence[str], team: str, y: float) -> int | None:
    """The better order: look ahead. We place a ball, they place their best, we place ours.

    What counts is silos won and lost, three at once more than all; then balls that the other team
    can no longer cover, and last the way.

    Parameters
    ----------
    fillings : sequence of str
        Of silos 1 to 5.
    team : {"red", "blue"}
    y : float  [m, map]
        Where the robot is along the row of silos.

    Returns
    -------
    int or None
        Index of the silo; None if all are full.
    """
    own = _letter(team)
    theirs = "B" if own == "R" else "R"
    known = tuple(_balls(filling) for filling in fillings)

    def worth(k: int) -> float:
        told = tuple(sorted((*known[:k], known[k] + own, *known[k + 1 :])))
        return -_outlook(told, theirs, own, DEPTH - 1) - 0.001 * abs(SILOS[k][1] - y)

    return _best(fillings, worth)


STRATEGIES: dict[str, Callable[[Sequence[str], str, float], int | None]] = {
    "A": order_a,
    "B": order_b,
    "ahead": choose_silo,
}
"""All orders by name."""


@cache
def _outlook(fillings: tuple[str, ...], mover: str, other: str, depth: int) -> float:
    """How good a position is for the team that places the next ball."""
    if depth == 0 or winner(fillings):
        return _position(fillings, mover, other)
    places = [k for k, filling in enumerate(fillings) if not is_full(filling)]
    if not places:
        return _position(fillings, mover, other)
    return max(
        -_outlook(
            tuple(sorted((*fillings[:k], fillings[k] + mover, *fillings[k + 1 :]))),
            other, mover, depth - 1,
        )
        for k in places
    )  # fmt: skip


def _position(fillings: Sequence[str], own: str, theirs: str) -> float:
    """Silos won and lost, and those that the next ball decides, as a number."""
    owners = [owner(filling) for filling in fillings]
    mine, lost = owners.count(own), owners.count(theirs)
    if mine >= WINS or lost >= WINS:
        return 100.0 if mine >= WINS else -100.0
    value = (3.0 + mine) * mine - (3.0 + lost) * lost
    for filling in fillings:
        if len(filling) == SILO_CAPACITY - 1:  # whose ball comes next decides
            value += 1.0 * (own in filling) - 1.0 * (theirs in filling)
        elif len(filling) == 1:
            value += 0.3 if filling == own else -0.3
    return value


def _rank(filling: str, team: str) -> float:
    """Points of orders A and B; 0 for a full silo."""
    own, theirs = own_and_theirs(filling, team)
    ranks = {(1, 1): 6, (2, 0): 5, (0, 2): 4, (0, 0): 3, (1, 0): 2, (0, 1): 1}
    return float(ranks.get((own, theirs), 0))


def _best(fillings: Sequence[str], worth: Callable) -> int | None:
    """The silo that is worth most; of equal ones the first."""
    if len(fillings) != len(SILOS):
        raise CourseError(f"fillings: expected {len(SILOS)}, one for each silo, got {fillings!r}")
    places = [k for k in range(len(fillings)) if not is_full(fillings[k])]
    return max(places, key=worth) if places else None


def _balls(filling: str) -> str:
    return filling.replace("empty", "")


def _letter(team: str) -> str:
    if team not in LETTERS:
        raise CourseError(f"team: expected 'red' or 'blue', got {team!r}")
    return LETTERS[team]
