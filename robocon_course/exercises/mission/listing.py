"""Numbers from the printed mission, and from a student's own copy of it."""

from __future__ import annotations

from robocon_course import mission
from robocon_course.exercises.model import Mistake, Number
from robocon_course.worlds import Student
from robocon_course.worlds.missions import PRINTED, PRINTED_CASES, own_listing

START, GOAL = "start reset", "back to storage"
REACHED = mission.reachable(PRINTED, START)


def _never(student: Student) -> float:
    return float(len(set(PRINTED_CASES) - REACHED))


NEVER_REACHED = Number(
    id="mission.never_reached",
    title="How many of the printed cases are never reached",
    points=1,
    truth=_never,
    tolerance=0.1,
    unit="cases",
    hints=(
        'reachable(printed, "start reset") are the states that the robot ever comes to.',
        "A case is a state with a row of its own: cases = {source for source, _ in printed}.",
        "len(cases - reachable(...)).",
    ),
    mistakes=(
        Mistake(
            "those that are reached",
            "That is how many cases are reached. Asked for are the others.",
            lambda student: float(len(set(PRINTED_CASES) & REACHED)),
        ),
        Mistake(
            "one that has no case",
            "This counts “approach silo” as well. It is jumped to, but it has no case.",
            lambda student: float(len(mission.dead_ends(PRINTED, _named(), ())) - len(REACHED)),
        ),
        Mistake(
            "no way in at all",
            "That is how many cases no row leads to, the start left out. Some more have a way in, "
            "but only from cases that are never reached themselves.",
            lambda student: float(len(set(PRINTED_CASES) - {t for _, t in PRINTED}) - 1),
        ),
        Mistake(
            "no way in, with the start",
            "That is how many cases no row leads to. The start needs none, and some more have a "
            "way in only from cases that are never reached.",
            lambda student: float(len(set(PRINTED_CASES) - {t for _, t in PRINTED})),
        ),
        Mistake(
            "all cases",
            "That is how many cases there are.",
            lambda student: float(len(PRINTED_CASES)),
        ),
        Mistake(
            "a state too many reached",
            "The start is reached, too, and “reverse after push” has no case.",
            lambda student: float(len(REACHED)),
        ),
    ),
)


def _named() -> set[str]:
    return {state for edge in PRINTED for state in edge}


def _dead(student: Student) -> set:
    rows = own_listing(student)
    return mission.dead_ends(rows, PRINTED_CASES, (GOAL,))


OWN_DEAD_ENDS = Number(
    id="mission.own_dead_ends",
    title="How many dead ends your own copy of the listing has",
    points=1,
    truth=lambda student: float(len(_dead(student))),
    tolerance=0.1,
    unit="states",
    hints=(
        'The goal is the end here: ends = ["back to storage"]. States are the 16 cases.',
        'dead_ends(own, cases, ["back to storage"]) gives the set.',
        "One state has no row any more. Whatever leads only there is a dead end as well: count "
        "them all.",
    ),
    mistakes=(
        Mistake(
            "only the state without a row",
            "That is the one state without a row. What leads only there is a dead end as well.",
            lambda student: 1.0,
        ),
        Mistake(
            "those that live",
            "That is how many states lead to the goal. Asked for are the others.",
            lambda student: float(len(PRINTED_CASES) - len(_dead(student))),
        ),
        Mistake(
            "the goal with them",
            "The goal itself is counted. There the mission is where it should be.",
            lambda student: float(len(_dead(student)) + 1),
        ),
        Mistake(
            "what is reached from the start",
            "That is how many states are reached from the start. Asked for is who cannot come to "
            "“back to storage”.",
            lambda student: float(len(mission.reachable(own_listing(student), START))),
        ),
        Mistake(
            "all states",
            "That is how many states there are. Spell “back to storage” as the listing does.",
            lambda student: float(len(PRINTED_CASES)),
        ),
        Mistake(
            "rows",
            "That is how many rows the copy has.",
            lambda student: float(len(own_listing(student))),
        ),
    ),
)
