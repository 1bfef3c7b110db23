"""Which silo by order A, and how people get it wrong."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from robocon_course import mission
from robocon_course.answers.process import Reply
from robocon_course.exercises.compare import difference, kind_of
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.field import SILO_CAPACITY, SILOS
from robocon_course.mission import Rhythm, own_and_theirs
from robocon_course.worlds import Student
from robocon_course.worlds.missions import some_board

Choose = Callable[..., int | None]
RANKS = {(1, 1): 6, (2, 0): 5, (0, 2): 4, (0, 0): 3, (1, 0): 2, (0, 1): 1}
"""Order A: own and their balls in a silo, and how much it is wanted."""


def _by_order(
    *,
    ranks: dict[tuple[int, int], int] = RANKS,
    counts: Callable[[str, str], tuple[int, int]] = own_and_theirs,
    gap: Callable[[int, float], float] = lambda k, y: abs(SILOS[k][1] - y),
    free: Callable[[str], bool] = lambda filling: len(filling) < SILO_CAPACITY,
    nothing: Any = None,
    shown: Callable[[int], Any] = lambda k: k,
    last: bool = False,
) -> Choose:
    """Order A with one part wrong."""

    def function(fillings: Sequence[str], team: str, y: float, rhythm: Rhythm = Rhythm()) -> Any:  # noqa: B008
        places = [k for k in range(len(fillings)) if free(fillings[k])]
        if not places:
            return nothing
        order = places[::-1] if last else places
        best = max(order, key=lambda k: (ranks.get(counts(fillings[k], team), 0), -gap(k, y)))
        return shown(best)

    return function


_order = _by_order()


def _swapped(*pairs: tuple[int, int]) -> dict[tuple[int, int], int]:
    """The ranks with two of them exchanged."""
    one, other = pairs
    return RANKS | {one: RANKS[other], other: RANKS[one]}


WRONG: dict[str, tuple[str, Choose]] = {
    "other team's balls": (
        "Red and blue are swapped: these are the other team's wishes. Count your own letter: "
        "mission.own_and_theirs(filling, team) gives own, theirs.",
        _by_order(counts=lambda filling, team: own_and_theirs(filling, team)[::-1]),
    ),
    "always red": (
        "The own balls are always the red ones here. Ask team.",
        _by_order(counts=lambda filling, team: own_and_theirs(filling, "red")),
    ),
    "the nearest free one": (
        "This is the nearest silo that is not full. What it holds counts before the distance.",
        _by_order(ranks={}),
    ),
    "distance not looked at": (
        "Of several of one kind this takes the first. Take the nearest.",
        _by_order(gap=lambda k, y: 0.0),
    ),
    "the farthest": (
        "Of several of one kind this takes the farthest. Take the nearest.",
        _by_order(gap=lambda k, y: -abs(SILOS[k][1] - y)),
    ),
    "the fullest": (
        "This takes the silo with the most own balls. Look at the kinds in their order.",
        _by_order(ranks={(2, 0): 5, (1, 1): 4, (1, 0): 4}),
    ),
    "own pair before mixed pair": (
        "An own pair comes before a mixed pair here. A mixed pair that you fill is yours, if the "
        "other team comes first it is theirs: it is more urgent.",
        _by_order(ranks=_swapped((1, 1), (2, 0))),
    ),
    "their pair not blocked": (
        "The other team's pair comes last here. It comes before an empty silo: a ball of yours on "
        "top takes it from them.",
        _by_order(ranks=RANKS | {(0, 2): 0}),
    ),
    "empty last": (
        "An empty silo comes last here. It comes before a silo with a single ball.",
        _by_order(ranks=RANKS | {(0, 0): 0}),
    ),
    "empty first": (
        "An empty silo comes first here. It comes after all pairs.",
        _by_order(ranks=RANKS | {(0, 0): 7}),
    ),
    "the order upside down": (
        "The kinds are taken from the last to the first.",
        _by_order(ranks={kind: 7 - rank for kind, rank in RANKS.items()}),
    ),
    "distance from the middle": (
        "The distance is measured from the middle silo, not from the robot. Use y.",
        _by_order(gap=lambda k, y: abs(SILOS[k][1] - SILOS[2][1])),
    ),
    "silo 1 at the other end": (
        "The silos are counted from the other end: field.SILOS[k][1] says where silo k lies.",
        _by_order(gap=lambda k, y: abs(SILOS[len(SILOS) - 1 - k][1] - y)),
    ),
    "the last of equals": (
        "Of two that are as good and as near this takes the later one. Take the first.",
        _by_order(last=True),
    ),
    "counted from 1": (
        "The silo's number is returned. Asked for is its index, from 0.",
        _by_order(shown=lambda k: k + 1),
    ),
    "a full silo": (
        "This sends a ball to a full silo, where it rolls away. Leave full ones out.",
        _by_order(free=lambda filling: True, ranks=RANKS | {(2, 1): 7, (3, 0): 7}),
    ),
    "−1 where all are full": (
        "All silos are full: return None, not −1. An index of −1 is silo 5.",
        _by_order(nothing=-1),
    ),
    "0 where all are full": (
        "All silos are full: return None, not 0. That is silo 1.",
        _by_order(nothing=0),
    ),
}


def _board(rng: np.random.Generator, wrong: Choose, team: str) -> tuple:
    """A board where a wrong order takes another silo, and the order and the look-ahead agree."""
    while True:
        board, y = some_board(rng), float(np.round(rng.uniform(8.6, 11.4), 2))
        rhythm = Rhythm(next=float(np.round(rng.uniform(2.0, 25.0), 1)))
        right = _order(board, team, y)
        if right is not None and wrong(board, team, y) != right:
            if mission.choose_silo(board, team, y, rhythm) == right:
                return board, team, y, rhythm


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    full, usual = ("RRB", "BBR", "RBR", "RRR", "BRB"), Rhythm()
    middle = float(SILOS[2][1])
    rows = [
        ("all silos are full", (full, "red", 10.0, usual)),
        ("one silo is not full", ((*full[:4], "RB"), "red", 9.0, usual)),
        ("nothing is filled yet", (("",) * 5, "red", float(SILOS[3][1]), usual)),
        ("two are as good and as near", (("RRR", "RB", "BBB", "RB", "BBB"), "red", middle, usual)),
        ("your third silo is one ball away", (("RRR", "RBR", "", "RR", "R"), "red", 9.0, usual)),
    ]  # fmt: skip
    for what, (_, wrong) in WRONG.items():
        if what in ("−1 where all are full", "0 where all are full", "the last of equals"):
            continue
        team = TEAMS.get(what) or ("red", "blue")[int(rng.integers(2))]
        rows.append(("a board of your own", _board(rng, wrong, team)))
    return [_case(what, args) for what, args in rows]


TEAMS = {"always red": "blue", "other team's balls": "red"}
"""Where a mistake shows with one team only."""


def _index(value: Any) -> str:
    """An index in words, and anything else by its kind."""
    plain = value is None or (isinstance(value, int) and abs(value) < 1000)
    return repr(value) if plain else kind_of(value)


def _case(what: str, args: tuple) -> Case:
    expected = mission.choose_silo(*args)

    def judge(reply: Reply) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        if expected is None or reply.value is None:
            told = "None: all are full" if expected is None else f"index {expected}"
            same = expected is None and reply.value is None
            return None if same else f"expected {told}, got {_index(reply.value)}"
        return difference(reply.value, expected, 1e-9)

    return Case(what, args, judge=judge)


CHOOSE_SILO = Exercise(
    id="mission.choose_silo",
    title="Which silo: order A",
    points=4,
    reference=mission.choose_silo,
    cases=_cases,
    shortcuts=(
        "robocon_course.mission.silos.order_a",
        "robocon_course.mission.silos.order_b",
        "robocon_course.mission.silos._rank",
    ),
    hints=(
        "own, theirs = mission.own_and_theirs(filling, team) says what a silo holds. Give each of "
        "the six pairs a rank, in a dict.",
        "Of tuples the first entry counts before the second: key = (rank, −distance) puts the kind "
        "first, and the nearer one of two of a kind.",
        "places = [k for k in range(5) if not mission.is_full(fillings[k])]; if there is none, "
        "return None. Else max(places, key=…): of equals it takes the first.",
    ),
    mistakes=tuple(Mistake(name, message, wrong) for name, (message, wrong) in WRONG.items()),
)
