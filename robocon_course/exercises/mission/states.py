"""The table of states: the next row, what is reached, what is a dead end; wrong ways to each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from robocon_course import mission
from robocon_course.exercises.compare import kind_of
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.mission import Fact, Facts, Transition
from robocon_course.worlds import Student

Edges = Iterable[tuple[str, str]]
FACTS = ("arrived", "holding", "ball", "looked", "stuck", "full")
NAMES = ("wait", "drive", "look", "take", "carry", "store", "flee", "stop")


def _row(source: str, target: str, fact: str, wanted: bool = True) -> Transition:
    return Transition(source, target, Fact(fact, wanted), f"{fact} is {wanted}")


def _rows(rng: np.random.Generator, count: int = 14) -> list[Transition]:
    """Rows of any states, in any order."""
    return [
        _row(
            NAMES[int(rng.integers(4))],
            NAMES[int(rng.integers(len(NAMES)))],
            FACTS[int(rng.integers(len(FACTS)))],
            bool(rng.integers(2)),
        )
        for _ in range(count)
    ]


def _facts(rng: np.random.Generator) -> Facts:
    return Facts(**{name: bool(rng.integers(2)) for name in FACTS})


def _next_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    both = [
        _row("drive", "stop", "stuck"),
        _row("take", "flee", "stuck"),
        _row("take", "carry", "holding"),
        _row("take", "look", "ball", False),
        _row("carry", "store", "arrived"),
    ]
    rows = [
        ("one guard holds", both, "take", Facts(holding=True, ball=True)),
        ("two guards hold: the first row wins", both, "take", Facts(holding=True, stuck=True)),
        ("three guards hold", both, "take", Facts(holding=True, stuck=True, ball=False)),
        ("the guard wants a fact to be False", both, "take", Facts()),
        ("no guard of this state holds", both, "take", Facts(ball=True)),
        ("a row of another state stands first", both, "carry", Facts(stuck=True, arrived=True)),
        ("a state without rows", both, "stop", Facts(stuck=True, arrived=True)),
        ("no rows at all", [], "take", Facts(holding=True)),
        ("a row that leads back to its own state", [_row("look", "look", "looked")], "look",
         Facts(looked=True)),
    ]  # fmt: skip
    rows += [("any table", _rows(rng), NAMES[int(rng.integers(4))], _facts(rng)) for _ in range(8)]
    return [_next_case(*row) for row in rows]


def _next_case(what: str, rows: Sequence[Transition], state: str, facts: Facts) -> Case:
    expected = mission.next_transition(rows, state, facts)

    def judge(reply: Any) -> str | None:
        if reply.error:
            return f"{reply.error}: {reply.message}"
        came = reply.value
        if came is None or expected is None:
            told = "None: stay" if expected is None else f"the row to {expected.target!r}"
            return None if came is expected else f"expected {told}, got {_told(came)}"
        if type(came).__name__ != "Transition":
            return f"expected a row of the table, a mission.Transition, got {_told(came)}"
        same = tuple(came) == tuple(expected)
        return None if same else f"expected the row to {expected.target!r}, got {_told(came)}"

    return Case(what, (list(rows), state, facts), judge=judge, traits=_told)


def _told(row: Any) -> str:
    """A row in words, and anything else as it is."""
    if type(row).__name__ != "Transition":
        return repr(row)[:60] if row is None or isinstance(row, str) else kind_of(row)
    return f"the row {row.source!r} to {row.target!r} ({row.label})"


def _next(
    *,
    order: Callable[[Sequence], Sequence] = lambda rows: rows,
    mine: Callable[[Transition, str], bool] = lambda row, state: row.source == state,
    holds: Callable[[Transition, Facts], bool] = lambda row, facts: row.guard(facts),
    shown: Callable[[Transition], Any] = lambda row: row,
    nothing: Callable[[str], Any] = lambda state: None,
) -> Callable[..., Any]:
    """The search with one part wrong."""

    def function(rows: Sequence[Transition], state: str, facts: Facts) -> Any:
        for row in order(rows):
            if mine(row, state) and holds(row, facts):
                return shown(row)
        return nothing(state)

    return function


def _first_of_state(rows: Sequence[Transition], state: str, facts: Facts) -> Transition | None:
    for row in rows:
        if row.source == state:
            return row if row.guard(facts) else None
    return None


def _best_last(rows: Sequence[Transition], state: str, facts: Facts) -> Transition | None:
    found = None
    for row in rows:
        if row.source == state and row.guard(facts):
            found = row
    return found


NEXT_TRANSITION = Exercise(
    id="mission.next_transition",
    title="The first row that matches",
    points=2,
    reference=mission.next_transition,
    cases=_next_cases,
    hints=(
        "Go through the rows in their order. A row counts if row.source == state.",
        "row.guard is a function: row.guard(facts) says True or False.",
        "Return the row itself as soon as one matches. Behind the loop: return None.",
    ),
    mistakes=(
        Mistake(
            "the last match wins",
            "Of several rows that match the last one is taken. The first one wins: return at once.",
            _best_last,
        ),
        Mistake(
            "state ignored",
            "Rows of other states are looked at too. A row counts only if its source is the state.",
            _next(mine=lambda row, state: True),
        ),
        Mistake(
            "target for source",
            "The state is compared with the row's target. Compare it with its source.",
            _next(mine=lambda row, state: row.target == state),
        ),
        Mistake(
            "guard not asked",
            "The first row of the state is taken whether its guard holds or not: a function that "
            "is not called counts as true. Call it: row.guard(facts).",
            _next(holds=lambda row, facts: bool(row.guard)),
        ),
        Mistake(
            "guard the wrong way round",
            "A row is taken when its guard does not hold.",
            _next(holds=lambda row, facts: not row.guard(facts)),
        ),
        Mistake(
            "only the first row of the state",
            "If the state's first row does not match, the search ends. Go on to the next row: "
            "return None behind the loop, not in it.",
            _first_of_state,
        ),
        Mistake(
            "only the first row of all",
            "If the very first row does not match, the search ends. Go on to the next row: return "
            "None behind the loop, not in an else.",
            lambda rows, state, facts: next(
                (row for row in rows[:1] if row.source == state and row.guard(facts)), None
            ),
        ),
        Mistake(
            "the target",
            "This returns the state to go to. Asked for is the whole row, with its label: the "
            "history wants to know why.",
            _next(shown=lambda row: row.target),
        ),
        Mistake(
            "the label",
            "This returns the row's label. Asked for is the row.",
            _next(shown=lambda row: row.label),
        ),
        Mistake(
            "the state instead of None",
            "Where nothing matches this returns the state. Asked for is None: stay.",
            _next(nothing=lambda state: state),
        ),
        Mistake(
            "staying is no step",
            "A row that leads back to its own state is passed over. It counts as any other.",
            _next(mine=lambda row, state: row.source == state != row.target),
        ),
    ),
)


# --- reachable ----------------------------------------------------------------------------------


def _some_edges(rng: np.random.Generator, count: int = 11, names: int = 10) -> list:
    letters = "abcdefghijklmnop"[:names]
    return [
        (letters[int(rng.integers(names))], letters[int(rng.integers(names))]) for _ in range(count)
    ]


CHAIN = [("c", "d"), ("b", "c"), ("a", "b"), ("x", "a"), ("d", "e"), ("f", "f")]
LOOP = [("a", "b"), ("b", "c"), ("c", "a"), ("d", "c"), ("c", "e")]
DIAMOND = [("a", "b"), ("a", "c"), ("b", "d"), ("c", "d"), ("d", "e"), ("y", "z")]


def _reach_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    rows = [
        ("a chain whose rows stand in another order", CHAIN, "a"),
        ("a circle", LOOP, "a"),
        ("two ways to one state", DIAMOND, "a"),
        ("a start without a way out", DIAMOND, "e"),
        ("a start that no row names", DIAMOND, "q"),
        ("no rows", [], "a"),
        ("a start that nothing leads to", LOOP, "d"),
    ]
    rows += [("any table", _some_edges(rng), "abc"[int(rng.integers(3))]) for _ in range(5)]
    return [Case(what, (list(edges), start)) for what, edges, start in rows]


def _two_steps(edges: Edges, start: str) -> set:
    found = {start}
    for _ in range(2):
        found |= {t for s, t in edges if s in found}
    return found


def _one_pass(edges: Edges, start: str) -> set:
    found = {start}
    for source, target in edges:
        if source in found:
            found.add(target)
    return found


def _one_way(edges: Edges, start: str) -> set:
    """Follows the last row of a state only."""
    way, found = dict(edges), {start}
    while start in way and way[start] not in found:
        start = way[start]
        found.add(start)
    return found


def _first_way(edges: Edges, start: str) -> set:
    return _one_way(list(edges)[::-1], start)


def _backwards(edges: Edges, start: str) -> set:
    return mission.reachable([(t, s) for s, t in edges], start)


def _both_ways(edges: Edges, start: str) -> set:
    edges = list(edges)
    return mission.reachable(edges + [(t, s) for s, t in edges], start)


def _all_states(edges: Edges, start: str) -> set:
    return {state for edge in edges for state in edge} | {start}


REACHABLE = Exercise(
    id="mission.reachable",
    title="What can be reached",
    points=2,
    reference=mission.reachable,
    cases=_reach_cases,
    shortcuts=("robocon_course.mission.table.dead_ends",),
    hints=(
        "Begin with found = {start}. What a row's source in found leads to, its target, is found "
        "too.",
        "One pass over the rows is not enough: they stand in any order. Go on until a whole pass "
        "finds nothing new.",
        "Or keep a list of states that wait: take one, add the targets of its rows that are not "
        "found yet to both, until the list is empty. A circle then ends by itself.",
    ),
    mistakes=(
        Mistake(
            "one step",
            "Only the states one step away are found. Go on from those, until nothing is new.",
            lambda edges, start: {start} | {t for s, t in edges if s == start},
        ),
        Mistake(
            "two steps",
            "The search ends after two steps. Go on until nothing is new.",
            _two_steps,
        ),
        Mistake(
            "one pass over the rows",
            "The rows are gone through once, in their order. A row that stands above the one that "
            "finds its source is missed: repeat until nothing is new.",
            _one_pass,
        ),
        Mistake(
            "one way out of a state",
            "Of several rows of a state only the last is followed: in dict(edges) each state has "
            "one target. Keep a list of targets for each state.",
            _one_way,
        ),
        Mistake(
            "the first way out of a state",
            "Of several rows of a state only the first is followed. Follow all of them.",
            _first_way,
        ),
        Mistake(
            "start left out",
            "The start is missing. It is reached before the first step.",
            lambda edges, start: mission.reachable(edges, start) - {start},
        ),
        Mistake(
            "against the arrows",
            "The rows are followed from target to source: these are the states that lead to the "
            "start.",
            _backwards,
        ),
        Mistake(
            "both directions",
            "The rows are followed in both directions. A jump has no way back.",
            _both_ways,
        ),
        Mistake(
            "all states",
            "These are all states that occur in the rows, reached or not.",
            _all_states,
        ),
        Mistake(
            "what cannot be reached",
            "These are the states that cannot be reached. Asked for are the others.",
            lambda edges, start: _all_states(edges, start) - mission.reachable(edges, start),
        ),
        Mistake(
            "a list",
            "This is a list. Asked for is a set.",
            lambda edges, start: sorted(mission.reachable(edges, start)),
        ),
    ),
)


# --- dead ends ----------------------------------------------------------------------------------


def _dead_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    circle = [("a", "b"), ("b", "c"), ("c", "b"), ("a", "d"), ("d", "e")]
    late = [("c", "end"), ("b", "c"), ("a", "b"), ("x", "y")]
    rows = [
        ("a circle that nothing leads out of", circle, "abcde", "e"),
        ("a state that only leads into another dead end",
         [("a", "b"), ("b", "c"), ("a", "z")], "abcz", "z"),
        ("rows in another order", late, ("a", "b", "c", "end", "x", "y"), ("end",)),
        ("two ends", circle, "abcde", "ce"),
        ("an end from which rows lead on", [("a", "b"), ("b", "c")], "abc", "b"),
        ("a state that no row names", [("a", "b")], "abq", "b"),
        ("no dead ends", DIAMOND[:5], "abcde", "e"),
        ("no end at all", DIAMOND[:5], "abcde", ""),
    ]  # fmt: skip
    names = "abcdefghij"
    rows += [
        ("any table", _some_edges(rng, 9), names, names[int(rng.integers(10))]) for _ in range(5)
    ]
    return [
        Case(what, (list(edges), list(states), list(ends))) for what, edges, states, ends in rows
    ]


def _no_row(edges: Edges, states: Iterable[str], ends: Iterable[str]) -> set:
    return set(states) - {s for s, _ in edges} - set(ends)


def _forwards(edges: Edges, states: Iterable[str], ends: Iterable[str]) -> set:
    living: set = set()
    for end in ends:
        living |= mission.reachable(edges, end)
    return set(states) - living


def _one_back(edges: Edges, states: Iterable[str], ends: Iterable[str]) -> set:
    ends = set(ends)
    return set(states) - ends - {s for s, t in edges if t in ends}


def _every_end(edges: Edges, states: Iterable[str], ends: Iterable[str]) -> set:
    back = [(t, s) for s, t in edges]
    living = set(states)
    for end in ends:
        living &= mission.reachable(back, end)
    return set(states) - living


def _first_end(edges: Edges, states: Iterable[str], ends: Sequence[str]) -> set:
    return mission.dead_ends(edges, states, list(ends)[:1])


def _ends_too(edges: Edges, states: Iterable[str], ends: Sequence[str]) -> set:
    return mission.dead_ends(edges, states, ends) | set(ends)


def _named_only(edges: Edges, states: Iterable[str], ends: Sequence[str]) -> set:
    named = {state for edge in edges for state in edge}
    return mission.dead_ends(edges, named, ends)


DEAD_ENDS = Exercise(
    id="mission.dead_ends",
    title="Where a mission stops for ever",
    points=2,
    reference=mission.dead_ends,
    cases=_dead_cases,
    hints=(
        "A state lives if some way leads from it to an end. All others are dead ends.",
        "Turn every row round, (target, source). Then what can be reached from an end is what "
        "leads to it.",
        "living: the union of your reachable(turned, end) over all ends. Return set(states) - "
        "living.",
    ),
    mistakes=(
        Mistake(
            "only states without a row",
            "These are the states that no row leads out of. A circle that nothing leads out of is "
            "a dead end as well, and so is what leads only there.",
            _no_row,
        ),
        Mistake(
            "not turned round",
            "This follows the rows from the ends onwards. Turn them round: (target, source).",
            _forwards,
        ),
        Mistake(
            "one step from an end",
            "Only states one step from an end count as living. Follow the turned rows as far as "
            "they go.",
            _one_back,
        ),
        Mistake(
            "all ends wanted",
            "A state must lead to every end here. One is enough: unite the sets.",
            _every_end,
        ),
        Mistake(
            "only the first end",
            "Only the first end is looked at.",
            _first_end,
        ),
        Mistake(
            "ends are dead ends",
            "The ends themselves are called dead ends. There the mission may stop.",
            _ends_too,
        ),
        Mistake(
            "living instead of dead",
            "These are the states that lead to an end. Asked for are the others.",
            lambda edges, states, ends: set(states) - mission.dead_ends(edges, states, ends),
        ),
        Mistake(
            "only states that rows name",
            "A state that no row names is missing. Take the states from the argument.",
            _named_only,
        ),
        Mistake(
            "a list",
            "This is a list. Asked for is a set.",
            lambda edges, states, ends: sorted(mission.dead_ends(edges, states, ends)),
        ),
    ),
)
