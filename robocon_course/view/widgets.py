"""Sliders under a figure: the same picture, drawn again for other numbers."""

from __future__ import annotations

import html
import uuid
from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

from matplotlib.figure import Figure

from robocon_course.view.canvas import in_ipython, one_line, publish, show

Drawing = Callable[..., tuple[Figure, str]]


def explore(draw: Drawing, /, **sliders: tuple[float, float, float, float] | list) -> None:
    """Show a figure, and sliders under it that draw it again.

    The static figure always comes first, exactly as `show` gives it. Where there are no sliders
    (a script, a notebook viewer), it stays alone and a sentence says so.

    Parameters
    ----------
    draw : callable
        ``draw(**values) -> (figure, twin)``, called with one value per slider.
    **sliders : (smallest, largest, step, start) or list of choices
        Four whole numbers make a slider of whole numbers. A list starts at its first choice.

    Raises
    ------
    ValueError
        A slider that is neither, or whose start lies outside its range.
    """
    for name, spec in sliders.items():
        _check(name, spec)
    start = {name: s[0] if isinstance(s, list) else s[3] for name, s in sliders.items()}
    figure, twin = draw(**start)
    if not has_sliders():
        show(figure, twin)
        values = ", ".join(f"{name} = {value}" for name, value in start.items())
        print(f"Sliders need ipywidgets and a notebook; the figure above is for {values}.")
        return
    display_id = uuid.uuid4().hex
    publish(figure, twin, display_id)
    _show_sliders(draw, sliders, display_id, twin)


def _show_sliders(draw: Drawing, sliders: dict[str, Any], display_id: str, twin: str) -> None:
    import ipywidgets
    from IPython.display import publish_display_data

    controls = {name: _control(name, spec) for name, spec in sliders.items()}
    # The text twin moves with the sliders. A Label would cut a long line off; HTML wraps it.
    readout = ipywidgets.HTML(_unbroken(twin))

    def redraw(change: Any) -> None:
        try:
            figure, twin = draw(**{name: control.value for name, control in controls.items()})
            publish(figure, twin, display_id, update=True)
            readout.value = _unbroken(twin)
        except Exception as error:  # a callback's exception would vanish into a log nobody reads
            message = html.escape(f"{type(error).__name__}: {error}")
            readout.value = f"{message} <i>(The picture is the last that worked.)</i>"

    for control in controls.values():
        control.observe(redraw, names="value")
    box = ipywidgets.VBox([*controls.values(), readout])
    data = box._repr_mimebundle_()
    data["text/plain"] = "Sliders: " + ", ".join(sliders)
    publish_display_data(data)


def _unbroken(twin: str) -> str:
    """The text twin as HTML; JupyterLab would break its lines within words."""
    style = "word-break: normal; overflow-wrap: normal; white-space: normal"
    return f'<span style="{style}">Figure: {html.escape(one_line(twin))}</span>'


def _control(name: str, spec: tuple | list) -> Any:
    import ipywidgets

    common = {
        "description": name,
        "style": {"description_width": "8em"},
        "layout": ipywidgets.Layout(width="28em"),
    }
    if isinstance(spec, list):
        return ipywidgets.Dropdown(options=spec, value=spec[0], **common)
    low, high, step, start = spec
    whole = all(isinstance(number, int) for number in spec)
    decimals = 0 if whole else len(f"{step:.6f}".rstrip("0").partition(".")[2])
    slider = ipywidgets.IntSlider if whole else ipywidgets.FloatSlider
    return slider(
        value=start,
        min=low,
        max=high,
        step=step,
        continuous_update=False,
        readout_format="d" if whole else f".{decimals}f",
        **common,
    )


def _check(name: str, spec: Any) -> None:
    if isinstance(spec, list) and spec:
        return
    if not isinstance(spec, tuple) or len(spec) != 4:
        raise ValueError(
            f"{name}: expected (smallest, largest, step, start) or a list of choices, got {spec!r}"
        )
    low, high, step, start = spec
    if not (low <= start <= high and low < high and step > 0):
        raise ValueError(f"{name}: expected smallest <= start <= largest and step > 0, got {spec}")


def has_sliders() -> bool:
    """Whether a kernel runs this (a terminal has no sliders) and ipywidgets is installed."""
    if not in_ipython() or find_spec("ipywidgets") is None:
        return False
    from IPython import get_ipython

    return hasattr(get_ipython(), "kernel")
