"""Figures, their text twins, and sliders."""

from __future__ import annotations

import base64
import io
import subprocess
import sys
import warnings

import matplotlib
import numpy as np
import pytest
from IPython.core.interactiveshell import InteractiveShell
from PIL import Image

from robocon_course import view
from robocon_course.view import canvas, comparison, lines, widgets

TWIN = "A line that rises from 1 to 2 within 1 s."
TIME = np.linspace(0.0, 5.0, 200)
WAVES = 0.1 * np.sin(np.outer(TIME, [1.0, 2.0, 3.0]))
SPHERE = 9.8 * np.eye(3)[np.arange(30) % 3]

PICTURES = {
    "draw_plan": lambda: view.draw_plan(),
    "draw_plan without a way": lambda: view.draw_plan(None),
    "draw_robot": lambda: view.draw_robot(),
    "draw_system": lambda: view.draw_system(done=("00", 1), here="02"),
    "plot_imu": lambda: view.plot_imu(TIME, WAVES, WAVES + 9.8),
    "plot_angles": lambda: view.plot_angles(TIME, {"mine": WAVES, "raw": WAVES + 0.1}, WAVES),
    "plot_angles of one": lambda: view.plot_angles(TIME, {"roll": WAVES[:, 0]}),
    "plot_tilt_error": lambda: view.plot_tilt_error(TIME, {"gyro only": WAVES[:, 0]}),
    "plot_sphere": lambda: view.plot_sphere(SPHERE + 0.2, SPHERE),
    "plot_still": lambda: view.plot_still(TIME, WAVES, [0.01, 0.0, -0.01], moved=[(1.0, 2.0)]),
    "counter-example, bars": lambda: view.plot_counter_example("a", [1, 2], [1, 3], "m"),
    "counter-example, lines": lambda: view.plot_counter_example("a", WAVES, -WAVES, "rad"),
}


class Notebook:
    """What a notebook would have received."""

    def __init__(self):
        self.messages = []

    def publish(self, data, metadata=None, *, transient=None, update=False, **_):
        self.messages.append((data, metadata or {}, (transient or {}).get("display_id"), update))

    @property
    def figures(self):
        return [message for message in self.messages if "image/png" in message[0]]

    def picture(self, number):
        return base64.b64decode(self.figures[number][0]["image/png"])


@pytest.fixture
def notebook(monkeypatch):
    shell = InteractiveShell.instance()
    received = Notebook()
    monkeypatch.setattr(shell.display_pub, "publish", received.publish)
    monkeypatch.setattr(shell, "kernel", object(), raising=False)
    yield received
    InteractiveShell.clear_instance()


@pytest.fixture
def controls(monkeypatch):
    """The widgets that `explore` makes, by name."""
    made = {}

    def keep(name, spec, original=widgets._control):
        made[name] = original(name, spec)
        return made[name]

    monkeypatch.setattr(widgets, "_control", keep)
    return made


def line(slope=1.0):
    fig, ax = view.figure()
    ax.plot([0.0, 1.0], [1.0, 1.0 + slope])
    return fig, f"A line that rises by {slope:.2f} within 1 s."


def pixels(picture):
    return np.asarray(Image.open(io.BytesIO(picture)).convert("L"))


# Figures


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_a_png_of_its_stated_size_with_something_in_it(name):
    fig = PICTURES[name]()
    grey = pixels(view.png(fig))
    height, width = grey.shape
    assert (width, height) == pytest.approx(fig.get_size_inches() * 110, abs=1)
    assert 0.01 < (grey < 200).mean() < 0.9


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_fits_a_notebook_page(name):
    assert PICTURES[name]().get_figwidth() * 110 <= 910


@pytest.mark.parametrize("name", PICTURES)
def test_no_words_of_a_picture_stick_out_of_it(name):
    fig = PICTURES[name]()
    view.png(fig)
    drawn, (width, height) = fig.get_tightbbox(), fig.get_size_inches()
    assert drawn.x0 >= -0.02 and drawn.x1 <= width + 0.02
    assert drawn.y0 >= -0.02 and drawn.y1 <= height + 0.02


def test_a_figure_leaves_the_notebook_s_own_style_alone():
    before = dict(matplotlib.rcParams)
    view.png(view.draw_system())
    assert dict(matplotlib.rcParams) == before


def test_a_figure_looks_the_same_whatever_style_the_notebook_has():
    plain = view.png(view.plot_imu(TIME, WAVES, WAVES))
    strange = {
        "text.color": "white",
        "font.size": 20,
        "xtick.major.size": 30,
        "lines.dashed_pattern": [1, 9],
        "lines.linewidth": 9,
        "axes.titlepad": 40,
    }
    with matplotlib.rc_context(strange):
        assert view.png(view.plot_imu(TIME, WAVES, WAVES)) == plain


def test_the_package_loads_no_plotting_and_the_view_no_pyplot():
    code = (
        "import sys, robocon_course; assert 'matplotlib' not in sys.modules\n"
        "import robocon_course.view as view; view.png(view.draw_system())\n"
        "assert 'matplotlib.pyplot' not in sys.modules and 'ipywidgets' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_png_refuses_what_is_not_a_figure():
    with pytest.raises(ValueError, match="figure: expected a matplotlib Figure, got tuple"):
        view.png(view.figure())


def test_lines_are_named_at_their_ends_without_overlap():
    places = lines._spread({"a": 0.99, "b": 0.98, "c": 0.5, "d": 1.2}, dict.fromkeys("abcd", 0.1))
    assert list(places) == ["c", "b", "a", "d"]
    values = list(places.values())
    assert np.diff(values).min() >= 0.1 - 1e-12
    assert max(values) <= 0.95 + 1e-12 and places["c"] == 0.5
    low = lines._spread({"a": 0.0, "b": 0.01}, dict.fromkeys("ab", 0.1))
    assert low == pytest.approx({"a": 0.05, "b": 0.15})


def test_a_label_s_first_word_decides_its_colour():
    colours = canvas.colours_of(["mine (k_p = 1)", "truth", "gyro only", "Raw gyroscope"])
    assert colours["mine (k_p = 1)"] == canvas.MINE
    assert colours["truth"] == canvas.TRUTH
    assert colours["Raw gyroscope"] == canvas.RAW
    assert colours["gyro only"] not in {canvas.MINE, canvas.TRUTH, canvas.RAW}


def test_angles_are_drawn_in_degrees_with_a_gap_where_they_wrap():
    heading = np.angle(np.exp(1j * np.linspace(0.0, 4.0, 9)))
    fig = view.plot_angles(np.arange(9.0), {"mine": heading})
    drawn = fig.axes[0].lines[0].get_ydata()
    assert np.isnan(drawn).sum() == 1
    assert drawn[2] == pytest.approx(np.degrees(1.0))


def test_the_tilt_error_says_its_rms_and_ignores_what_is_not_known():
    fig = view.plot_tilt_error([0.0, 1.0, 2.0], {"mine": np.radians([3.0, np.nan, 4.0])})
    words = [text.get_text() for text in fig.axes[0].texts]
    assert words == ["mine\nRMS 3.54°"]


def test_plots_refuse_logs_of_different_lengths():
    with pytest.raises(ValueError, match="gyro: expected shape"):
        view.plot_imu(TIME, WAVES[:-1], WAVES)


def test_the_system_ticks_what_is_done_and_refuses_unknown_chapters():
    words = [t.get_text() for t in view.draw_system(done=["02", 7]).axes[0].texts]
    assert "02\n✔" in words and "07\n✔" in words and "01" in words
    with pytest.raises(ValueError, match="chapter: expected one of 00, 01"):
        view.draw_system(here="42")


# Counter-examples


@pytest.mark.parametrize(
    ("got", "expected", "panels"),
    [
        (0.5, 0.3, 1),
        ([1.0, np.inf], [1.0, 2.0, 3.0], 1),
        (np.r_[np.inf, TIME], TIME, 1),
        (WAVES[:50, 0], WAVES[:60, 0], 1),
        (WAVES, WAVES, 3),
        (np.eye(3), np.eye(3), 1),
        ({"bias": [1, 2, 3], "note": "x"}, {"bias": [1, 2, 4], "note": "y"}, 1),
        ({"bias": [1, 2, 3], "scale": [1, 1, 1]}, {"bias": [1, 2, 4], "scale": [1, 1, 2]}, 2),
    ],
)
def test_a_counter_example_draws_whatever_came(got, expected, panels):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fig = view.plot_counter_example("case", got, expected, "m")
        assert len(fig.axes) == panels
        assert pixels(view.png(fig)).min() < 200


@pytest.mark.parametrize("got", [None, "text", object(), [[1, 2], [3]], [], {}])
def test_a_counter_example_refuses_what_has_no_numbers(got):
    with pytest.raises(ValueError, match="nothing in them can be drawn"):
        view.plot_counter_example("case", got, [1.0, 2.0])


def test_a_counter_example_says_both_numbers():
    fig = view.plot_counter_example("case", [0.25], [0.5], "m")
    assert "came 0.25\nexpected 0.5" in [text.get_text() for text in fig.axes[0].texts]


def test_many_columns_do_not_make_an_endless_picture():
    many = np.zeros((50, 40))
    fig = view.plot_counter_example("case", many, many)
    assert len(fig.axes) == comparison.MOST_PANELS


# Showing


def test_show_sends_a_picture_with_its_words_as_alt_text(notebook, capsys):
    fig, _ = line()
    assert view.show(fig, TWIN) is None
    ((data, metadata, _, update),) = notebook.messages
    assert notebook.picture(0) == view.png(fig)
    assert data["text/plain"] == TWIN
    assert metadata["image/png"]["alt"] == TWIN
    assert f'alt="{TWIN}"' in data["text/html"]
    assert not update
    assert capsys.readouterr().out == f"Figure: {TWIN}\n"


def test_show_writes_quotes_and_brackets_into_the_alt_text_safely(notebook):
    view.show(line()[0], 'A line with "quotes" & <b>brackets</b> in its words.')
    html = notebook.messages[0][0]["text/html"]
    assert "&quot;quotes&quot; &amp; &lt;b&gt;" in html


def test_show_makes_one_line_of_the_twin(notebook, capsys):
    view.show(line()[0], "A line that rises\n   from 1 to 2 m.")
    assert capsys.readouterr().out == "Figure: A line that rises from 1 to 2 m.\n"


@pytest.mark.parametrize("twin", ["", "   \n  ", "too short", None, 3.0])
def test_show_refuses_a_twin_that_says_nothing(notebook, capsys, twin):
    with pytest.raises(ValueError, match="twin: expected a line of at least 20 characters"):
        view.show(line()[0], twin)
    assert notebook.messages == [] and capsys.readouterr().out == ""


def test_show_works_in_a_plain_script(capsys):
    view.show(line()[0], TWIN)
    assert capsys.readouterr().out == f"Figure: {TWIN}\n"


def test_show_closes_a_student_s_pyplot_figure(notebook):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    with matplotlib.rc_context({"backend": "agg"}):
        fig = pyplot.figure()
        view.show(fig, TWIN)
        assert fig.number not in pyplot.get_fignums()


# Sliders


def test_a_slider_redraws_the_same_output(notebook, controls, capsys):
    view.explore(line, slope=(0.0, 5.0, 0.5, 1.0))
    assert capsys.readouterr().out == ""  # the text twin stands under the sliders, and moves
    controls["slope"].value = 3.0
    (_, _, first_id, first_update), (data, metadata, second_id, second_update) = notebook.figures
    assert first_id == second_id and first_id is not None
    assert (first_update, second_update) == (False, True)
    assert notebook.picture(0) != notebook.picture(1) == view.png(line(3.0)[0])
    assert metadata["image/png"]["alt"] == data["text/plain"] == line(3.0)[1]


def test_the_readout_says_the_new_twin_and_survives_an_exception(notebook, controls, monkeypatch):
    import ipywidgets

    boxes = []
    original = ipywidgets.VBox.__init__

    def keep(self, *args, **kw):
        boxes.append(self)
        original(self, *args, **kw)

    monkeypatch.setattr(ipywidgets.VBox, "__init__", keep)

    def draw(slope):
        if slope > 4.0:
            raise ValueError("slope: 4 at most, <b>")
        return line(slope)

    view.explore(draw, slope=(0.0, 5.0, 0.5, 1.0))
    readout = boxes[0].children[-1]
    controls["slope"].value = 2.0
    assert readout.value == "Figure: A line that rises by 2.00 within 1 s."
    controls["slope"].value = 4.5
    assert "ValueError: slope: 4 at most, &lt;b&gt;" in readout.value
    assert len(notebook.figures) == 2
    controls["slope"].value = 1.5
    assert readout.value == "Figure: A line that rises by 1.50 within 1 s."
    assert len(notebook.figures) == 3


def test_each_kind_of_slider_gets_its_widget(notebook, controls):
    import ipywidgets

    seen = []

    def draw(**values):
        seen.append(values)
        return line()

    view.explore(draw, gain=(0.0, 1.0, 0.005, 0.25), count=(1, 9, 2, 3), way=["sun", "moon"])
    assert seen == [{"gain": 0.25, "count": 3, "way": "sun"}]
    assert isinstance(controls["gain"], ipywidgets.FloatSlider)
    assert controls["gain"].readout_format == ".3f"
    assert isinstance(controls["count"], ipywidgets.IntSlider)
    assert not controls["gain"].continuous_update
    controls["way"].value = "moon"
    assert seen[-1] == {"gain": 0.25, "count": 3, "way": "moon"}


def test_the_sliders_come_after_the_figure_and_name_themselves(notebook):
    view.explore(line, slope=(0.0, 5.0, 0.5, 1.0))
    (figure, *_), (sliders, *_) = notebook.messages
    assert "image/png" in figure and "application/vnd.jupyter.widget-view+json" in sliders
    assert sliders["text/plain"] == "Sliders: slope"


def test_without_a_notebook_the_figure_stands_alone_and_a_sentence_says_why(capsys):
    view.explore(line, slope=(0.0, 5.0, 0.5, 2.0))
    first, second = capsys.readouterr().out.splitlines()
    assert first == "Figure: A line that rises by 2.00 within 1 s."
    assert second.startswith("Sliders need ipywidgets") and "slope = 2.0" in second


def test_without_ipywidgets_the_figure_stands_alone(notebook, monkeypatch, capsys):
    monkeypatch.setattr(widgets, "find_spec", lambda name: None)
    view.explore(line, slope=(0.0, 5.0, 0.5, 2.0))
    assert len(notebook.messages) == 1
    assert "Sliders need ipywidgets" in capsys.readouterr().out


@pytest.mark.parametrize("spec", [(0.0, 1.0), [], "abc", (0.0, 1.0, 0.1, 2.0), (1, 0, 1, 1), 5])
def test_explore_refuses_a_slider_it_cannot_make(spec):
    with pytest.raises(ValueError, match="slope: expected"):
        view.explore(line, slope=spec)
