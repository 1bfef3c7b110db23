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
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import matplotlib
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

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

OTHERS = (MINE, WARN, REFERENCE, *XYZ)
"""For lines without a fixed meaning, in this order."""

STYLE = {
    "font.size": 10,
    "text.color": TRUTH,
    "axes.labelcolor": TRUTH,
    "axes.edgecolor": "#777777",
    "axes.facecolor": "white",
    "axes.prop_cycle": cycler(color=OTHERS),
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "figure.facecolor": "white",
    "figure.dpi": 110,
    "legend.frameon": False,
}
SHORTEST_TWIN = 20
PRINTED = 100
"""Characters in a printed line: as many as fit beside the file list of a small laptop's screen."""


class Panel(Axes):
    """Axes whose title stands bold at the left, where reading begins."""

    def set_title(self, label: str, *args: Any, **kw: Any) -> Any:
        """As ``Axes.set_title``, with the course's defaults."""
        kw = {"loc": "left", "fontsize": 11, "fontweight": "bold"} | kw
        return super().set_title(label, *args, **kw)

    def legend(self, *args: Any, **kw: Any) -> Any:
        """As ``Axes.legend``, with the course's defaults."""
        return super().legend(*args, **({"frameon": False, "fontsize": 10} | kw))


@dataclass(frozen=True, eq=False, repr=False)
class Animation:
    """A moving picture, and one that stands for it where nothing can move.

    Attributes
    ----------
    gif, still : bytes
        Files: a GIF, and a PNG.
    """

    gif: bytes
    still: bytes


@contextmanager
def styled() -> Iterator[None]:
    """The course's style for what is drawn inside, whatever style the notebook has set.

    Serves as a decorator too. Everything is put back afterwards.
    """
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


def figure(
    width: float = 7.0,
    height: float = 3.5,
    columns: int = 1,
    rows: int = 1,
    *,
    mosaic: list[list[str]] | None = None,
    **kw: Any,
) -> tuple[Figure, Any]:
    """An empty figure in the course's style, and its axes.

    Parameters
    ----------
    width, height : float  [inch, at 110 dots per inch]
    columns, rows : int
        Panels side by side and one above the other.
    mosaic : rows of panel names, optional
        A freer layout, in the place of columns and rows.
    **kw
        Passed on to ``Figure.subplots`` (``sharex=True`` for instance).

    Returns
    -------
    Figure
    Axes, an array of Axes where there is more than one panel, or a mosaic's dictionary of them
    """
    with styled():
        fig = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(fig)
        kw["subplot_kw"] = {"axes_class": Panel}
        if mosaic is not None:
            return fig, fig.subplot_mosaic(mosaic, **kw)
        return fig, fig.subplots(rows, columns, **kw)


def png(figure: Figure) -> bytes:
    """The figure as the bytes of a PNG file with 256 colours: a third of the usual size.

    A notebook carries each picture twice, see `bundle`.
    """
    if not isinstance(figure, Figure):
        raise ValueError(
            f"figure: expected a matplotlib Figure, got {type(figure).__name__}; "
            "a plot function of the course returns one"
        )
    drawn = io.BytesIO()
    with styled():
        figure.savefig(drawn, format="png", dpi=STYLE["figure.dpi"])
    return packed(Image.open(drawn).convert("RGB"))


def packed(image: Image.Image) -> bytes:
    """An RGB image as the bytes of a PNG file with 256 colours."""
    stream = io.BytesIO()
    # Of two hundred greens and one blue ball, the most frequent colours would be greens alone.
    rare_ones_too = Image.Quantize.MAXCOVERAGE
    flat = image.quantize(256, rare_ones_too, kmeans=2, dither=Image.Dither.NONE)
    flat.save(stream, format="png", optimize=True)
    return stream.getvalue()


def show(figure: Figure | Animation, twin: str) -> None:
    """Show a figure in the notebook, and print its text twin under it.

    Parameters
    ----------
    figure : Figure or Animation
    twin : str
        One line with the numbers that matter, at least 20 characters: what somebody learns who
        cannot see the picture. It is the picture's alt text too.

    Raises
    ------
    ValueError
        No figure, or a twin that is empty or shorter than 20 characters.
    """
    publish(figure, twin)
    # JupyterLab breaks what is printed anywhere, between the digits of a number as well.
    print(
        fill(f"Figure: {one_line(twin)}", PRINTED, break_long_words=False, break_on_hyphens=False)
    )


def publish(
    figure: Figure | Animation, twin: str, display_id: str | None = None, update: bool = False
) -> None:
    """Send a figure to the notebook, as a new output or in the place of ``display_id``.

    Outside a notebook nothing is sent; the twin is still checked and the figure still drawn.
    """
    twin = one_line(twin)
    if isinstance(figure, Animation):
        data, metadata = bundle(figure.still, twin, figure.gif)
    else:
        data, metadata = bundle(png(figure), twin)
        if pyplot := sys.modules.get("matplotlib.pyplot"):
            pyplot.close(figure)  # a student's own pyplot figure would come a second time otherwise
    if in_ipython():
        from IPython.display import publish_display_data

        transient = {"display_id": display_id} if display_id else None
        publish_display_data(data, metadata, transient=transient, update=update)


def bundle(
    picture: bytes, twin: str, moving: bytes | None = None
) -> tuple[dict[str, str], dict[str, dict[str, str]]]:
    """Data and metadata of a notebook output that holds a picture (PNG) and its words.

    JupyterLab does not pass the alt text of the metadata on to the page, so a piece of HTML
    does; the plain PNG stays beside it for every tool that looks for pictures. Where there is a
    moving picture (GIF), the HTML shows that one.
    """
    encoded = base64.b64encode(picture).decode("ascii")
    alt = html.escape(twin, quote=True)
    source = f"data:image/png;base64,{encoded}"
    if moving is not None:
        source = f"data:image/gif;base64,{base64.b64encode(moving).decode('ascii')}"
    data = {
        "image/png": encoded,
        "text/html": f'<img alt="{alt}" src="{source}">',
        "text/plain": twin,
    }
    return data, {"image/png": {"alt": twin}}


def one_line(twin: str) -> str:
    """The text twin as a single line; refuses one that says nothing."""
    line = " ".join(twin.split()) if isinstance(twin, str) else ""
    if len(line) < SHORTEST_TWIN:
        raise ValueError(
            f"twin: expected a line of at least {SHORTEST_TWIN} characters, got {twin!r}; "
            "say in words and numbers what the picture shows"
        )
    return line


def in_ipython() -> bool:
    """Whether there is an IPython session that a picture can be sent to."""
    module = sys.modules.get("IPython")
    return module is not None and module.get_ipython() is not None


def colours_of(labels: Iterable[str]) -> dict[str, str]:
    """A colour per label: the fixed one where its first word has a meaning, else the next free."""
    meant = {label: MEANINGS.get(label.lower().split()[0].strip(",:")) for label in labels if label}
    free = iter([colour for colour in OTHERS if colour not in meant.values()] * len(meant))
    return {label: colour or next(free, RAW) for label, colour in meant.items()}
