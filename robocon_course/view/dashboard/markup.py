"""Words, numbers and colours of the operator's page. Everything from outside is escaped here."""

from __future__ import annotations

import base64
import html
import math
from typing import Any

from robocon_course.view.canvas import MINE, TRUTH, WARN

PLANNED = "#882255"
"""The way that is planned."""
QUIET, LINE = "#5F6B76", "#D5DAE0"
BALLS = {"R": "#E0334A", "B": "#2D6CDF", "P": "#A64FB0"}
"""Fill of a ball by the first letter of its colour, which is written on it too."""
STYLE = f"""<style>
.robocon-dash {{ background: #fff; color: {TRUTH}; padding: 4px; box-sizing: border-box;
  --jp-widgets-label-color: {TRUTH}; --jp-widgets-readout-color: {TRUTH};
  --jp-widgets-color: {TRUTH}; --jp-content-font-color1: {TRUTH};
  --jp-ui-font-color0: {TRUTH}; --jp-ui-font-color1: {TRUTH};
  --jp-ui-font-color2: {QUIET}; --jp-ui-font-color3: {QUIET};
  --jp-border-color1: #B4BCC4; --jp-border-color2: {LINE}; --jp-border-color3: {LINE};
  --jp-layout-color0: #fff; --jp-layout-color1: #fff; --jp-layout-color2: #EDF0F3;
  --jp-layout-color3: #C3CAD1; --jp-layout-color4: #9AA4AE;
  --jp-widgets-input-color: {TRUTH}; --jp-widgets-input-background-color: #fff;
  --jp-widgets-input-border-color: #B4BCC4; }}
.robocon-dash .widget-html, .robocon-dash .widget-html > .widget-html-content {{
  line-height: 1.3; font-size: 12px; min-width: 0; color: {TRUTH}; }}
.robocon-dash .widget-html > .widget-html-content {{ width: 100%; }}
.robocon-dash .rc-bar {{ display: flex; flex-wrap: wrap; gap: 2px 18px; align-items: baseline;
  padding: 5px 8px; background: #EEF1F4; border-radius: 4px; font-size: 13px; }}
.robocon-dash .rc-clock {{ order: 1; margin-left: auto; font-size: 15px; font-weight: bold; }}
.robocon-dash .rc-bad {{ color: #A84300; font-weight: bold; }}
.robocon-dash .rc-good {{ color: #00704F; font-weight: bold; }}
.robocon-dash .rc-head {{ font-weight: bold; font-size: 12px; color: {QUIET};
  border-bottom: 1px solid {LINE}; margin: 0 0 3px; padding: 0 0 1px; }}
.robocon-dash table.rc {{ width: 100%; border-collapse: collapse; table-layout: fixed; }}
.robocon-dash table.rc td, .robocon-dash table.rc th {{ padding: 1px 4px; text-align: right;
  font-variant-numeric: tabular-nums; font-weight: normal; border: none; background: none;
  white-space: nowrap; font-size: 12px; color: {TRUTH}; }}
.robocon-dash table.rc th {{ color: {QUIET}; }}
.robocon-dash table.rc th:first-child {{ text-align: left; padding-left: 0; }}
.robocon-dash table.rc tr, .robocon-dash table.rc tr:nth-child(even) {{ background: none; }}
.robocon-dash table.rc tr.rc-top:not(:first-child) {{ border-top: 1px solid {LINE}; }}
.robocon-dash table.rc svg {{ vertical-align: middle; }}
.robocon-dash .rc-events > .widget-html-content {{ display: flex; flex-direction: column;
  height: 100%; }}
.robocon-dash .rc-log {{ flex: 1 1 0; min-height: 84px; overflow-y: auto;
  overflow-wrap: anywhere; }}
.robocon-dash .rc-log div {{ padding: 1px 0; }}
.robocon-dash .rc-log time {{ color: {QUIET}; font-variant-numeric: tabular-nums; }}
.robocon-dash svg text {{ font-family: var(--jp-ui-font-family, sans-serif); }}
.robocon-dash .widget-slider, .robocon-dash .widget-text {{ width: auto; }}
.robocon-dash .widget-readout {{ min-width: 3.2em; }}
.robocon-dash .jupyter-button {{ padding: 0 6px; min-width: 0; }}
.robocon-dash .widget-toggle-buttons {{ display: flex; flex-flow: row nowrap;
  align-items: center; overflow: hidden; }}
.robocon-dash .widget-toggle-buttons > .widget-label {{ width: auto; min-width: 0;
  padding-right: 6px; margin: 0; }}
</style>"""


def escaped(value: Any) -> str:
    """Text that no browser takes for markup."""
    return html.escape(str(value), quote=True)


def number(value: Any, digits: int = 2) -> str:
    """A number with so many decimals, a dash where there is none."""
    value = float(value)
    if not math.isfinite(value):
        return "–"
    text = f"{value:.{digits}f}"
    return text.removeprefix("-") if not float(text) else text.replace("-", "−")


def minutes(seconds: Any) -> str:
    """Minutes and seconds as ``mm:ss``; a begun second counts, as on a match clock."""
    seconds = float(seconds)
    if not math.isfinite(seconds):
        return "--:--"
    whole = max(0, math.ceil(seconds - 1e-9))
    return f"{whole // 60:02d}:{whole % 60:02d}"


def stamp(seconds: Any) -> str:
    """A time of the robot's clock for the log, such as ``01:02.5``."""
    seconds = float(seconds)
    if not math.isfinite(seconds) or seconds < 0.0:
        return "--:--.-"
    tenths = int(seconds * 10 + 1e-6)
    return f"{tenths // 600:02d}:{tenths // 10 % 60:02d}.{tenths % 10}"


def head(text: str) -> str:
    """The heading of a pane."""
    return f'<div class="rc-head">{text}</div>'


def data_uri(data: bytes, kind: str) -> str:
    """A picture file as an address that holds it: ``png`` or ``jpeg``."""
    return f"data:image/{kind};base64,{base64.b64encode(data).decode('ascii')}"


def ball(x: float, y: float, radius: float, letter: str) -> str:
    """A ball with its letter, as a piece of SVG."""
    colour = BALLS.get(letter, QUIET)
    return (
        f'<circle cx="{x:g}" cy="{y:g}" r="{radius:g}" fill="{colour}"/>'
        f'<text x="{x:g}" y="{y:g}" dy=".36em" text-anchor="middle" font-size="{1.4 * radius:g}" '
        f'font-weight="bold" fill="#fff">{escaped(letter)}</text>'
    )


__all__ = [
    "MINE", "PLANNED", "QUIET", "STYLE", "TRUTH", "WARN", "ball", "data_uri", "escaped", "head",
    "minutes", "number", "stamp",
]  # fmt: skip
