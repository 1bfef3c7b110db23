"""How a verdict looks: a sign, a word and a sentence; colour only repeats what they say."""

from __future__ import annotations

from html import escape

from robocon_course.exercises.model import Outcome, Verdict

EDGE = {
    Outcome.PASSED: "#1a7f37",
    Outcome.WRONG: "#b3261e",
    Outcome.NOT_ATTEMPTED: "#6b7280",
    Outcome.ERROR: "#9a6700",
}


class Shown:
    """A verdict, or a hint, that Jupyter displays as a box and everything else as text."""

    def __init__(self, title: str, body: str, edge: str) -> None:
        self.title, self.body, self.edge = title, body, edge

    def __repr__(self) -> str:
        return "\n  ".join([self.title, *self.body.splitlines()])

    def _repr_html_(self) -> str:
        body = "<br>".join(escape(line) for line in self.body.splitlines())
        return (
            f'<div role="status" style="border-left:5px solid {self.edge};padding:6px 12px;'
            f'margin:4px 0;line-height:1.5"><b>{escape(self.title)}</b>'
            + (f"<br>{body}" if body else "")
            + "</div>"
        )


def shown_verdict(verdict: Verdict, extra: str = "") -> Shown:
    """A verdict ready to display; ``extra`` says what happened to the accepted part."""
    lines = [verdict.message, verdict.took, extra]
    if verdict.printed and not verdict.accepted:
        lines.append("Your function printed: " + verdict.printed.strip()[:300])
    body = "\n".join(line for line in lines if line)
    return Shown(verdict.line, body, EDGE[verdict.outcome])


def show_finding(verdict: Verdict) -> None:
    """Draw the first failing case where a picture says more than its numbers."""
    finding = verdict.finding
    if finding is None or finding.got is None or finding.expected is None:
        return
    from robocon_course.view.plots import plot_counter_example, show

    try:
        figure = plot_counter_example(
            finding.case.what, finding.got, finding.expected, finding.case.unit
        )
    except (TypeError, ValueError):
        return  # what came has no shape that could be drawn; the sentence has said so
    if figure is not None:
        show(
            figure, f"What came beside what was expected, {finding.case.what}: {finding.sentence}."
        )
