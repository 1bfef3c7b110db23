"""The mission's states as a picture: boxes in the order of the table, arrows out of the live one.

A mission has many more ways than can be told apart in a small picture. So all of them are pale, the
way that was taken last and the ways that are open now are not, and those into states that nearly
every state leads to (the end, a loss of the sensors) are drawn only while they are open.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from math import hypot

from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.dashboard.markup import (
    LINE,
    MINE,
    QUIET,
    TRUTH,
    escaped,
    head,
    number,
    stamp,
)

Ways = tuple[tuple[str, str, str], ...]
COLUMNS, CELL, BOX = 4, (96, 40), (80, 27)
"""Boxes in a row; room for one and its size [pixel]."""
ROOM = 9
"""Above and below, for the arrows along the outer rows [pixel]."""
COMMON = 0.4
"""A state that this share of the others leads to is left out of the pale ways."""
RECENT = 6
"""So many changes are listed where no picture is known."""
ARROW = re.compile(r"^\s*(\S+)\s*-->\s*(\S+?)\s*(?::\s*(.*?))?\s*$")


def ways_of(states: str | Iterable[Iterable[str]]) -> Ways:
    """Ways between states, from a list or from Mermaid's language.

    Parameters
    ----------
    states : str or iterable of (source, target, label)
        Of a text in Mermaid's language the lines ``source --> target: label`` count.

    Returns
    -------
    tuple of (source, target, label)

    Raises
    ------
    ValueError
        A row that is not three texts, or a text without any such line.

    Examples
    --------
    >>> ways_of("stateDiagram-v2\\n  [*] --> wait\\n  wait --> drive: start")
    (('wait', 'drive', 'start'),)
    """
    if isinstance(states, str):
        lines = [ARROW.match(line) for line in states.splitlines()]
        found = [line.groups(default="") for line in lines if line]
        if states.strip() and not found:
            raise ValueError(
                "states: expected lines such as 'wait --> drive: start'; found none in this text"
            )
        return tuple(way for way in found if "[*]" not in way[:2])
    ways = []
    for row in states:
        way = () if isinstance(row, str) else tuple(row)
        if len(way) != 3 or not all(isinstance(part, str) for part in way):
            raise ValueError(f"states: expected rows (source, target, label), got {row!r}")
        ways.append(way)
    return tuple(ways)


class Diagram:
    """The picture of a table of states, drawn anew for each live state.

    Parameters
    ----------
    ways : tuple of (source, target, label)
        Empty: only names and history are shown.
    """

    def __init__(self, ways: Ways) -> None:
        self.ways = ways
        into = Counter(target for _, target in {way[:2] for way in ways})
        names = list(dict.fromkeys([way[0] for way in ways] + [way[1] for way in ways]))
        common = {name for name in names if into[name] > max(3, COMMON * len(names))}
        self.pale = {way[:2] for way in ways if way[1] not in common and way[0] != way[1]}
        self.places = {
            name: (CELL[0] * (k % COLUMNS + 0.5), CELL[1] * (k // COLUMNS + 0.5))
            for k, name in enumerate(names)
        }

    def draw(self, inbox: Inbox) -> str:
        """The picture: it changes with the state alone, so that words over its arrows can be read.

        Parameters
        ----------
        inbox : Inbox

        Returns
        -------
        str
            HTML.
        """
        names = [str(one.name) for one in list(inbox.states)[-2:]]
        live, before = names[-1] if names else "", names[0] if len(names) > 1 else ""
        return head("Mission") + (self._picture(live, before) if self.places else "")

    def words(self, inbox: Inbox) -> str:
        """Where the mission is, for how long, and why; without a picture, where it was before.

        Parameters
        ----------
        inbox : Inbox

        Returns
        -------
        str
            HTML.
        """
        *earlier, last = [*inbox.states] or [None]
        if last is None:
            return "no state yet"
        waited = inbox.now() - last.time
        since = f" for {number(waited, 0)} s" if waited >= 0.0 else ""
        came = f"from {escaped(earlier[-1].name)}: " if earlier else ""
        lines = [
            f'<b class="rc-state">{escaped(last.name)}</b>{since}',
            came + (escaped(last.reason) or "no reason given"),
        ]
        if not self.places:
            lines += [
                f"{stamp(one.time)} {escaped(one.name)}: {escaped(one.reason)}"
                for one in reversed(earlier[-RECENT:])
            ]
        elif str(last.name) not in self.places:
            lines.append('<span class="rc-bad">This state is not in the picture.</span>')
        return "".join(f"<div>{line}</div>" for line in lines)

    def _picture(self, live: str, before: str) -> str:
        rows = -(-len(self.places) // COLUMNS)
        width, height = CELL[0] * COLUMNS, CELL[1] * rows + 2 * ROOM
        lines = [self._arrow(*way, LINE, 1.0) for way in sorted(self.pale) if way[0] != live]
        lines += [
            self._arrow(source, target, TRUTH, 1.2, label)
            for source, target, label in self.ways
            if source == live and target != live
        ]
        if before in self.places and live in self.places and before != live:
            lines.append(self._arrow(before, live, MINE, 2.2))
        boxes = [self._box(name, name == live) for name in self.places]
        label = f"States of the mission; now {escaped(live) or 'none'}"
        return (
            f'<svg viewBox="0 {-ROOM} {width} {height}" style="display:block;width:100%;'
            f'max-height:{height}px" role="img" aria-label="{label}">'
            f"{''.join(lines)}{''.join(boxes)}</svg>"
        )

    def _box(self, name: str, live: bool) -> str:
        x, y = self.places[name]
        (wide, high), fill = BOX, MINE if live else "#fff"
        words, ink = _wrapped(name), "#fff" if live else TRUTH
        weight, first = "bold" if live else "normal", y + 3.4 - 4.8 * (len(words) - 1)
        text = "".join(
            f'<text x="{x:g}" y="{first + 9.6 * k:g}" text-anchor="middle" font-size="9.5" '
            f'font-weight="{weight}" fill="{ink}">{escaped(word)}</text>'
            for k, word in enumerate(words)
        )
        mark = ' class="rc-live"' if live else ""
        return (
            f'<g{mark}><title>{escaped(name)}</title><rect x="{x - wide / 2:g}" '
            f'y="{y - high / 2:g}" width="{wide}" height="{high}" rx="5" fill="{fill}" '
            f'stroke="{MINE if live else QUIET}"/>{text}</g>'
        )

    def _arrow(self, source: str, target: str, colour: str, width: float, label: str = "") -> str:
        """An arrow from box to box, a little bent, so that there and back are two lines."""
        start, end = self.places[source], self.places[target]
        dx, dy = end[0] - start[0], end[1] - start[1]
        length = hypot(dx, dy)
        bend = 0.12 * length if length < 1.2 * CELL[0] else 0.2 * length
        middle = (start[0] + end[0]) / 2 - bend * dy / length, (start[1] + end[1]) / 2
        middle = middle[0], middle[1] + bend * dx / length
        (a, b), (c, d) = _edge(start, middle), _edge(end, middle)
        ux, uy = c - middle[0], d - middle[1]
        far = max(hypot(ux, uy), 1e-9)
        ux, uy = 5 * ux / far, 5 * uy / far
        tip = (
            f"M{c - ux - uy / 2:.1f} {d - uy + ux / 2:.1f}L{c:.1f} {d:.1f}"
            f"L{c - ux + uy / 2:.1f} {d - uy - ux / 2:.1f}"
        )
        title = f"<title>{escaped(label)}</title>" if label else ""
        return (
            f'<path d="M{a:.1f} {b:.1f}Q{middle[0]:.1f} {middle[1]:.1f} {c:.1f} {d:.1f}{tip}" '
            f'fill="none" stroke="{colour}" stroke-width="{width}">{title}</path>'
        )


def _edge(centre: tuple[float, float], towards: tuple[float, float]) -> tuple[float, float]:
    """Where the way from a box's centre leaves the box."""
    dx, dy = towards[0] - centre[0], towards[1] - centre[1]
    share = min(
        (BOX[0] / 2 + 1) / abs(dx) if dx else float("inf"),
        (BOX[1] / 2 + 1) / abs(dy) if dy else float("inf"),
        1.0,
    )
    return centre[0] + share * dx, centre[1] + share * dy


def _wrapped(name: str) -> list[str]:
    """A name in one or two lines that fit its box."""
    words = name.replace("_", " ").split() or [name]
    if len(" ".join(words)) <= 14 or len(words) == 1:
        return [_cut(" ".join(words))]
    k = min(
        range(1, len(words)), key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:])))
    )
    return [_cut(" ".join(words[:k])), _cut(" ".join(words[k:]))]


def _cut(text: str) -> str:
    return text if len(text) <= 16 else text[:15] + "…"
