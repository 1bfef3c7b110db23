"""A state machine as one table: source, target, guard, label. The first row that matches wins.

The table is checked when it is built: one start, every target is a state, every state can be
reached, and from every state an end can be reached. What it then can do wrong is written in it.

Source: the mission of the swerve robot of Yogyakarta State University, 2024, a chain of cases, from
two of which nothing leads on: a table can be searched for that, a chain of cases cannot.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from math import inf
from typing import Any, NamedTuple

from robocon_course._arrays import CourseError

ANY = "*"
"""As a source: every state but the ends."""
REMEMBERED = 200
"""So many steps stay in a history."""


class MissionError(CourseError):
    """A table that cannot be right."""


class Transition(NamedTuple):
    """A row of the table.

    Attributes
    ----------
    source, target : hashable
        States; `ANY` as a source is every state but the ends.
    guard : callable
        From the facts to True or False.
    label : str
        Why, in words; it goes into the history.
    """

    source: Hashable
    target: Hashable
    guard: Callable[[Any], bool]
    label: str


class Step(NamedTuple):
    """One change of state.

    Attributes
    ----------
    time : float  [s]
    source, target : hashable
    reason : str
    """

    time: float
    source: Hashable
    target: Hashable
    reason: str


class History(NamedTuple):
    """Where a mission is, since when, and how it came there.

    Attributes
    ----------
    state : hashable
    since : float  [s]
        When it got there.
    steps : tuple of Step
        The last changes, oldest first.
    """

    state: Hashable
    since: float
    steps: tuple[Step, ...] = ()


def reachable(edges: Iterable[tuple[Hashable, Hashable]], start: Hashable) -> set:
    """The states that some way leads to.

    Parameters
    ----------
    edges : iterable of (source, target)
    start : hashable

    Returns
    -------
    set
        With the start.
    """
    ways: dict[Hashable, list[Hashable]] = {}
    for source, target in edges:
        ways.setdefault(source, []).append(target)
    found, waiting = {start}, [start]
    while waiting:
        new = [state for state in ways.get(waiting.pop(), ()) if state not in found]
        found.update(new)
        waiting.extend(new)
    return found


def dead_ends(
    edges: Iterable[tuple[Hashable, Hashable]],
    states: Iterable[Hashable],
    ends: Iterable[Hashable],
) -> set:
    """The states from which no way leads to an end.

    Parameters
    ----------
    edges : iterable of (source, target)
    states : iterable of hashable
    ends : iterable of hashable
        States in which the mission may stop.

    Returns
    -------
    set
        A state without a row of its own is one, and so is a circle that nothing leads out of.
    """
    back = [(target, source) for source, target in edges]
    living: set = set()
    for end in ends:
        living |= reachable(back, end)
    return set(states) - living


def next_transition(rows: Sequence[Transition], state: Hashable, facts: Any) -> Transition | None:
    """The first row of a state whose guard holds.

    Parameters
    ----------
    rows : sequence of Transition
    state : hashable
    facts : object
        Handed to the guards.

    Returns
    -------
    Transition or None
        None: stay.
    """
    for row in rows:
        if row.source == state and row.guard(facts):
            return row
    return None


class Table:
    """A checked table of transitions.

    Parameters
    ----------
    rows : sequence of Transition
        In the order in which they are tried.
    states : sequence of hashable
    start : hashable
    ends : sequence of hashable
        States in which the mission may stop.
    limits : mapping, optional
        State to (seconds, target): a row that is tried last, when the facts' ``waited`` is longer.

    Attributes
    ----------
    rows : tuple of Transition
        With `ANY` and the limits written out.
    states, ends : tuple
    start : hashable

    Raises
    ------
    MissionError
        A row from or to no state, a state that nothing leads to or that leads to no end, an end
        that is left, a limit that no time reaches or passes at once.
    """

    def __init__(
        self,
        rows: Sequence[Transition],
        states: Sequence[Hashable],
        start: Hashable,
        ends: Sequence[Hashable],
        *,
        limits: Mapping[Hashable, tuple[float, Hashable]] | None = None,
    ) -> None:
        self.states, self.start, self.ends = tuple(states), start, tuple(ends)
        self.limits = dict(limits or {})
        self.rows = tuple(self._written_out(rows)) + tuple(
            Transition(state, target, _longer_than(seconds), f"longer than {seconds:g} s")
            for state, (seconds, target) in self.limits.items()
        )
        self._check()
        self._of = {state: [row for row in self.rows if row.source == state] for state in states}

    def _written_out(self, rows: Sequence[Transition]) -> Iterable[Transition]:
        for row in rows:
            if row.source == ANY:
                for state in self.states:
                    if state not in (*self.ends, row.target):
                        yield row._replace(source=state)
            else:
                yield row

    def _check(self) -> None:
        known = set(self.states)
        edges = [(row.source, row.target) for row in self.rows]
        strangers = {state for edge in edges for state in edge} | {self.start, *self.ends}
        never = {state for state, (seconds, _) in self.limits.items() if not 0.0 < seconds < inf}
        rules = (
            (never, "its limit is no time above 0 s"),
            (strangers - known, "no state of this table"),
            ({row.source for row in self.rows} & set(self.ends), "an end, but a row leads on"),
            (known - reachable(edges, self.start), f"never reached from {_name(self.start)}"),
            (dead_ends(edges, known, self.ends), "a dead end: no way leads to an end"),
        )
        for wrong, why in rules:
            if wrong:
                names = ", ".join(sorted(map(_name, wrong)))
                raise MissionError(f"table: {names}: {why}")

    def step(self, at: History, facts: Any, now: float, choose: Callable = next_transition) -> Any:
        """Where the mission is after one more look at the facts.

        Parameters
        ----------
        at : History
        facts : object
            Handed to the guards; limits read its ``waited`` [s].
        now : float  [s]
        choose : callable
            Takes the state's rows, the state and the facts; `next_transition`, or a student's.

        Returns
        -------
        History
        """
        row = choose(self._of[at.state], at.state, facts)
        if row is None:
            return at
        step = Step(now, at.state, row.target, row.label)
        return History(row.target, now, (*at.steps, step)[-REMEMBERED:])

    def begin(self, now: float = 0.0) -> History:
        """At the start [s]."""
        return History(self.start, now)


def _longer_than(seconds: float) -> Callable[[Any], bool]:
    return lambda facts: facts.waited > seconds


def mermaid(table: Table, live: Hashable = None) -> str:
    """The table as a state diagram in Mermaid's language.

    Parameters
    ----------
    table : Table
    live : hashable, optional
        A state to paint.

    Returns
    -------
    str
    """
    lines = ["stateDiagram-v2", f"    [*] --> {_name(table.start)}"]
    merged: dict[tuple[str, str], list[str]] = {}
    for row in table.rows:
        merged.setdefault((_name(row.source), _name(row.target)), []).append(row.label)
    for (source, target), labels in merged.items():
        lines.append(f"    {source} --> {target}: {' / '.join(dict.fromkeys(labels))}")
    lines += [f"    {_name(end)} --> [*]" for end in table.ends]
    if live is not None:
        lines += ["    classDef live fill:#ffb000,color:#000", f"    class {_name(live)} live"]
    return "\n".join(lines) + "\n"


def _name(state: Hashable) -> str:
    return str(getattr(state, "value", state))
