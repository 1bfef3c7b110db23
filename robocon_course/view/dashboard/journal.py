"""The event log, and the status bar: what is going on, in words."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from robocon_course.view.dashboard.inbox import Inbox
from robocon_course.view.dashboard.markup import escaped, head, minutes, number, stamp

LOW = 22.0
"""A battery below this is low [V]: six cells of 3.67 V, full 24 V."""
LOUD = ("warning", "error")
LONGEST = 160
"""So much of a drawing error is told [characters]."""


def journal(inbox: Inbox) -> str:
    """The event log, newest first, each line with its time and level.

    Parameters
    ----------
    inbox : Inbox

    Returns
    -------
    str
        HTML.
    """
    lines = "".join(_line(*entry) for entry in reversed(list(inbox.entries)))
    return f'{head("Events, newest first")}<div class="rc-log">{lines or "nothing yet"}</div>'


def _line(time: float, level: str, text: str) -> str:
    mark = f'<b class="rc-bad">{escaped(level)}</b>' if level in LOUD else escaped(level)
    return f"<div><time>{stamp(time)}</time> {mark}: {escaped(text)}</div>"


def connection(inbox: Inbox) -> str:
    """Whether a robot speaks, in words."""
    silence = inbox.silence()
    if silence is None:
        return "no robot"
    if inbox.connected():
        return "connected"
    return f"connection lost {number(silence, 0)} s ago"


def status_bar(inbox: Inbox, manual: bool, failures: Mapping[str, Exception]) -> str:
    """One line: connection, who drives, battery, warnings, score and time left.

    Parameters
    ----------
    inbox : Inbox
    manual : bool
        Whether the operator drives.
    failures : mapping of pane to exception
        What could not be drawn.

    Returns
    -------
    str
        HTML.
    """
    parts, failures = [], dict(failures)
    for make in (_link, partial(_mode, manual=manual), _battery, _counts, _score):
        try:
            parts += make(inbox)
        except Exception as error:  # the bar tells what fails elsewhere: it must not fail itself
            failures["status"] = error
    for pane, error in failures.items():
        words = f"{pane}: {type(error).__name__}: {error}"[:LONGEST]
        parts.append(f'<span class="rc-bad">{escaped(words)}</span>')
    return f'<div class="rc-bar" role="group" aria-label="Status">{"".join(parts)}</div>'


def _link(inbox: Inbox) -> list[str]:
    link = connection(inbox)
    tone, mark = ("rc-good", "●") if link == "connected" else ("rc-bad", "○")
    return [f'<span class="{tone}">{mark} {link}</span>']


def _mode(inbox: Inbox, manual: bool) -> list[str]:
    who = "manual" if manual else "automatic"
    return [f"<span>{who}, {'running' if inbox.running else 'stopped'}</span>"]


def _battery(inbox: Inbox) -> list[str]:
    seen = inbox.latest.get("/observation")
    if seen is None:
        return []
    text = f"battery {number(seen.battery, 1)} V"
    if seen.battery < LOW:
        return [f'<span class="rc-bad">{text}: low</span>']
    return [f"<span>{text}</span>"]


def _counts(inbox: Inbox) -> list[str]:
    """Warnings and errors so far, each in one word more than its number."""
    found = []
    for level, count in inbox.counts.items():
        words = f"{count} {level}{'' if count == 1 else 's'}"
        found.append(f'<span class="rc-bad">{words}</span>' if count else f"<span>{words}</span>")
    return found


def _score(inbox: Inbox) -> list[str]:
    told = inbox.latest.get("/score")
    if told is None:
        return ['<span class="rc-clock">--:--</span>']
    ended = {"own": "won", "theirs": "lost", "nobody": "drawn"}.get(told.winner, told.winner)
    end = f" {escaped(ended)}" if ended else ""
    why = f' title="{escaped(told.reason)}"' if told.reason else ""
    score = f"{number(told.own, 0)} : {number(told.theirs, 0)}"
    return [f'<span class="rc-clock"{why}>{score}{end} &nbsp; {minutes(told.left)}</span>']
