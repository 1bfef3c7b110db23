"""Figures: one style, one palette with fixed meanings, and a line of text beside every picture.

Nothing here touches ``pyplot``: a figure is an object that is drawn, turned into PNG bytes and
shown. Every figure that is shown carries its *text twin*, one line with the numbers that matter,
which is read aloud by a screen reader, searched, and compared by the tests.
"""

from __future__ import annotations

import base64
import html
import io
import sys
from typing import Any

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

MINE = "#0072B2"
"""What the student's own code produced."""
REFERENCE = "#009E73"
"""What the course's code produced."""
TRUTH = "#222222"
"""What really happened (only a simulator or a better instrument knows)."""
RAW = "#9A9A9A"
"""What the sensor said before anything was done to it."""
WARN = "#D55E00"
"""Where it goes wrong."""
XYZ = ("#882255", "#8A8420", "#2A8C82")
"""The three axes x, y, z of a sensor."""
MEANINGS = {"mine": MINE, "reference": REFERENCE, "truth": TRUTH, "raw": RAW, "wrong": WARN}

STYLE = {
    "font.size": 10.5,
    "text.color": "#222222",
    "axes.labelcolor": "#222222",
    "axes.edgecolor": "#777777",
    "axes.facecolor": "white",
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.labelsize": 10.5,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "xtick.labelsize": 10,
    "ytick.labelsize": 10,
    "lines.linewidth": 1.5,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "figure.facecolor": "white",
    "figure.dpi": 110,
}
SHORTEST_TWIN = 20


def figure(
    width: float = 7.0, height: float = 3.5, columns: int = 1, rows: int = 1, **kw: Any
) -> tuple[Figure, Any]:
    """An empty figure in the course's style, and its axes.

    Parameters
    ----------
    width, height : float  [inch, at 110 dots per inch]
    columns, rows : int
        Panels side by side and one above the other.
    **kw
        Passed on to ``Figure.subplots`` (``sharex=True`` for instance).

    Returns
    -------
    Figure
    Axes, or an array of Axes where there is more than one panel
    """
    with matplotlib.rc_context(STYLE):
        fig = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(fig)
        return fig, fig.subplots(rows, columns, **kw)


def png(figure: Figure) -> bytes:
    """The figure as the bytes of a PNG file."""
    if not isinstance(figure, Figure):
        raise ValueError(
            f"figure: expected a matplotlib Figure, got {type(figure).__name__}; "
            "a plot function of the course returns one"
        )
    stream = io.BytesIO()
    with matplotlib.rc_context(STYLE):
        figure.savefig(stream, format="png", dpi=STYLE["figure.dpi"])
    return stream.getvalue()


def show(figure: Figure, twin: str) -> None:
    """Show a figure in the notebook, and print its text twin under it.

    Parameters
    ----------
    figure : Figure
    twin : str
        One line with the numbers that matter, at least 20 characters: what somebody learns who
        cannot see the picture. It is the picture's alt text too.

    Raises
    ------
    ValueError
        No figure, or a twin that is empty, too short, or longer than one line.
    """
    publish(figure, twin)
    print(f"Figure: {twin}")


def publish(figure: Figure, twin: str, display_id: str | None = None, update: bool = False) -> None:
    """Send a figure to the notebook, as a new output or in the place of ``display_id``.

    Outside a notebook nothing is sent; the twin is still checked and the figure still drawn.
    """
    check_twin(twin)
    data, metadata = bundle(png(figure), twin)
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close(figure)  # a student's own pyplot figure would come a second time otherwise
    if in_ipython():
        from IPython.display import publish_display_data

        transient = {"display_id": display_id} if display_id else None
        publish_display_data(data, metadata, transient=transient, update=update)


def bundle(picture: bytes, twin: str) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Data and metadata of a notebook output that holds a picture and its words.

    JupyterLab does not pass the alt text of the metadata on to the page, so a piece of HTML
    does; the plain PNG stays beside it for every tool that looks for pictures.
    """
    encoded = base64.b64encode(picture).decode("ascii")
    alt = html.escape(twin, quote=True)
    data = {
        "image/png": encoded,
        "text/html": f'<img alt="{alt}" src="data:image/png;base64,{encoded}">',
        "text/plain": twin,
    }
    return data, {"image/png": {"alt": twin}}


def check_twin(twin: str) -> None:
    """Refuse a text twin that says nothing."""
    if not isinstance(twin, str) or len(twin.strip()) < SHORTEST_TWIN:
        raise ValueError(
            f"twin: expected one line of at least {SHORTEST_TWIN} characters, got {twin!r}; "
            "say in words and numbers what the picture shows"
        )
    if "\n" in twin:
        raise ValueError("twin: expected one line, got several; put the numbers into one sentence")


def in_ipython() -> bool:
    """Whether there is an IPython session that a picture can be sent to."""
    module = sys.modules.get("IPython")
    return module is not None and module.get_ipython() is not None
