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
from robocon_course.mission.rhythm import Rhythm

LETTERS = {"red": "R", "blue": "B"}
"""Of each team's balls."""
WINS = 3
"""So many silos win at once."""
DISTANCE_WEIGHT = 0.1
"""Order B takes off this much for a metre of way."""
AHEAD = 5
"""How many balls the better order looks ahead after its own."""
MOMENTS = ((0.25, -1.2), (0.5, 0.0), (0.25, 1.2))
"""Weight, and how much later than expected they come, in spreads."""
WIN, SOONER = 2.0, 0.02
"""What a win counts beside any position, and how much more for each ball sooner."""
CHANCES = {
    "": (0.40, 0.40), "o": (0.55, 0.30), "t": (0.30, 0.55), "oo": (0.60, 0.0), "tt": (0.0, 0.60),
    "ot": (0.45, 0.45), "to": (0.45, 0.45),
}  # fmt: skip
"""Chances that a silo becomes ours, and theirs, by what it holds (o ours, t theirs)."""


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


def order_a(
    fillings: Sequence[str], team: str, y: float, rhythm: Rhythm | None = None
) -> int | None:
    """Order A: by the kind of filling, ties by distance.

    Parameters
    ----------
    fillings : sequence of str
        Of silos 1 to 5.
    team : {"red", "blue"}
    y : float  [m, map]
        Where the robot is along the row of silos.
    rhythm : Rhythm, optional
        Not looked at: all orders are called alike.

    Returns
    -------
    int or None
        Index of the silo; None if all are full.

    Raises
    ------
    CourseError
        Another team, or fillings that are none; as all orders do.
    """
    return _best(fillings, lambda k: (_rank(fillings[k], team), -abs(SILOS[k][1] - y)))


def order_b(
    fillings: Sequence[str], team: str, y: float, rhythm: Rhythm | None = None
) -> int | None:
    """Order B: points for the kind of filling, less a little for the way. As `order_a` else."""
    return _best(
        fillings,
        lambda k: _rank(fillings[k], team) - DISTANCE_WEIGHT * abs(SILOS[k][1] - y),
    )


def choose_silo(
    fillings: Sequence[str],
    team: str,
    y: float,
    rhythm: Rhythm = Rhythm(),  # noqa: B008 - a NamedTuple cannot change
) -> int | None:
    """The better order: look ahead, and mind who comes next.

    A pair of ours is safe as long as the other team does not come before our third ball. So all
    ways to place our next balls are tried, theirs go where order B would put them, and what counts
    in the end is the chance to have three silos before they do. When they come is not sure: it is
    done for three moments.

    Parameters
    ----------
    fillings : sequence of str
        Of silos 1 to 5.
    team : {"red", "blue"}
    y : float  [m, map]
        Where the robot is along the row of silos.
    rhythm : Rhythm

    Returns
    -------
    int or None
        Index of the silo; None if all are full.
    """
    own = _letter(team)
    theirs = "B" if own == "R" else "R"
    known = tuple(_balls(filling) for filling in fillings)
    turns = [
        (weight, _turns(rhythm, rhythm.next + late * rhythm.spread)) for weight, late in MOMENTS
    ]

    def worth(k: int) -> float:
        told = tuple(sorted((*known[:k], known[k] + own, *known[k + 1 :])))
        chance = sum(weight * _outlook(told, turn, own, theirs) for weight, turn in turns)
        return chance - 0.001 * abs(SILOS[k][1] - y)

    return _best(fillings, worth)


def my_strategy(fillings: Sequence[str], team: str, y: float, rhythm: Rhythm) -> int | None:
    """The course's answer to the challenge: to look ahead. As `choose_silo`."""
    return choose_silo(fillings, team, y, rhythm)


STRATEGIES: dict[str, Callable[..., int | None]] = {
    "A": order_a,
    "B": order_b,
    "ahead": choose_silo,
}
"""All orders by name."""


def _turns(rhythm: Rhythm, theirs: float) -> str:
    """Who places the balls after our next one: ``"o"`` we, ``"t"`` they."""
    turns, ours, period = "", rhythm.every, max(rhythm.period, 1.0)
    while len(turns) < AHEAD:
        if theirs <= ours:
            turns, theirs = turns + "t", max(theirs, 0.0) + period
        else:
            turns, ours = turns + "o", ours + max(rhythm.every, 1.0)
    return turns


@cache
def _outlook(fillings: tuple[str, ...], turns: str, own: str, theirs: str) -> float:
    """How good a position is for us, if both go on as well as they know."""
    won = winner(fillings)
    if won:
        soon = WIN + SOONER * len(turns)
        return soon if won == own else -soon
    places = [k for k in range(len(fillings)) if not is_full(fillings[k])]
    if not turns or not places:
        return _chance(fillings, own, theirs)
    letter = own if turns[0] == "o" else theirs
    if letter == theirs:
        team = next(name for name, known in LETTERS.items() if known == theirs)
        places = [max(places, key=lambda k: _rank(fillings[k], team))]
    return max(
        _outlook(_with(fillings, k, letter), turns[1:], own, theirs)
        for k in places
        if fillings[k] not in fillings[:k]
    )


def _with(fillings: tuple[str, ...], k: int, letter: str) -> tuple[str, ...]:
    return tuple(sorted((*fillings[:k], fillings[k] + letter, *fillings[k + 1 :])))


def _chance(fillings: Sequence[str], own: str, theirs: str) -> float:
    """Our chance to get three silos less theirs, and a little for each silo."""
    ours, others = zip(*(_shares(filling, own, theirs) for filling in fillings), strict=True)
    return _three(ours) - _three(others) + 0.05 * (sum(ours) - sum(others))


def _shares(filling: str, own: str, theirs: str) -> tuple[float, float]:
    """Chances that a silo becomes ours, and theirs: rough, and the same for both teams."""
    if len(filling) == SILO_CAPACITY:
        return float(owner(filling) == own), float(owner(filling) == theirs)
    return CHANCES[filling.replace(own, "o").replace(theirs, "t")]


def _three(chances: Sequence[float]) -> float:
    """The chance that three or more of some independent things come true."""
    exactly = [1.0, 0.0, 0.0, 0.0]
    for p in chances:
        none, one, two, more = exactly
        exactly = [
            none * (1 - p),
            one * (1 - p) + none * p,
            two * (1 - p) + one * p,
            more + two * p,
        ]
    return exactly[3]


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
    for k in places:
        if set(_balls(fillings[k])) - set(LETTERS.values()):
            raise CourseError(f"fillings: expected R and B, or empty, got {fillings[k]!r:.40}")
    return max(places, key=worth) if places else None


def _balls(filling: str) -> str:
    return filling.replace("empty", "")


def _letter(team: str) -> str:
    if team not in LETTERS:
        raise CourseError(f"team: expected 'red' or 'blue', got {team!r}")
    return LETTERS[team]
