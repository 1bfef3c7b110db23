"""Figures, their text twins, sliders, moving pictures, and the robot under one's own hands."""

from __future__ import annotations

import asyncio
import base64
import dataclasses
import io
import subprocess
import sys
import warnings
from functools import cache
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from IPython.core.interactiveshell import InteractiveShell
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from PIL import Image

from robocon_course import field, robot, view
from robocon_course.autopilot import Parts
from robocon_course.geometry import inverse, transform_points
from robocon_course.simulator import Simulator
from robocon_course.view import (
    animation,
    body,
    canvas,
    comparison,
    driving,
    field_picture,
    lines,
    live,
    runs,
    widgets,
)

TWIN = "A line that rises from 1 to 2 within 1 s."
TIME = np.linspace(0.0, 5.0, 200)
WAVES = 0.1 * np.sin(np.outer(TIME, [1.0, 2.0, 3.0]))
SPHERE = 9.8 * np.eye(3)[np.arange(30) % 3]

POSES = np.column_stack([1.0 + TIME / 5, 1.0 + np.sin(TIME) / 2, np.cos(TIME)])
FOUR = np.column_stack([WAVES, WAVES[:, 0]])
ROBOT = view.RobotPicture((2.0, 3.0, 0.5), [0.1, 0.2, 0.3, 0.4], [1.0, -1.0, 0.5, 2.0], [1.0, 0.0])

PICTURES = {
    "draw_field": lambda: view.draw_field(),
    "draw_field with all": lambda: view.draw_field(
        {"truth": POSES, "mine (dead wheels only)": POSES[:, :2] + 0.1, "reference": POSES},
        ROBOT,
        markers={"goal": field.AREA_3_GOAL},
    ),
    "draw_field, our half": lambda: view.draw_field({"raw": POSES}, window=view.OUR_HALF),
    "draw_field, small": lambda: view.draw_field(robot=(2.0, 3.0, 0.0)),
    "plot_paths": lambda: view.plot_paths({"mine": POSES, "truth": POSES[:, :2]}, headings=5),
    "plot_paths, a narrow one": lambda: view.plot_paths({"mine": [[0, 0], [0, 5]]}),
    "plot_pose_errors": lambda: view.plot_pose_errors(TIME, {"mine": POSES + 0.1}, POSES),
    "plot_modules": lambda: view.plot_modules(TIME, FOUR, FOUR, target_speeds=FOUR + 0.01),
    "plot_tracking": lambda: view.plot_tracking(TIME, POSES, POSES + 0.05),
    "plot_tracking of a target at rest": lambda: view.plot_tracking(TIME, POSES, [2, 1, 0]),
    "plot_distribution": lambda: view.plot_distribution(
        {"mine": np.linspace(0, 0.3, 50), "reference": [0.1, 0.2]}, limit=0.25
    ),
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


@cache
def drawn(name):
    """A picture and its PNG file, drawn once for all tests that look at it."""
    fig = PICTURES[name]()
    return fig, view.png(fig)


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_is_a_png_of_its_stated_size_with_something_in_it(name):
    fig, picture = drawn(name)
    grey = pixels(picture)
    height, width = grey.shape
    assert (width, height) == pytest.approx(fig.get_size_inches() * 110, abs=1)
    assert 0.01 < (grey < 200).mean() < 0.9


@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_fits_a_notebook_page(name):
    assert drawn(name)[0].get_figwidth() * 110 <= 910


@pytest.mark.parametrize("name", PICTURES)
def test_no_words_of_a_picture_stick_out_of_it(name):
    fig, _ = drawn(name)
    inked, (width, height) = fig.get_tightbbox(), fig.get_size_inches()
    assert inked.x0 >= -0.02 and inked.x1 <= width + 0.02
    assert inked.y0 >= -0.02 and inked.y1 <= height + 0.02


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


# The field


def colours_at(fig, *points):
    """The colours of the picture at points of the map."""
    FigureCanvasAgg(fig).draw()
    places = fig.axes[0].transData.transform(points).astype(int)
    image = np.asarray(fig.canvas.buffer_rgba())[::-1, :, :3]
    return [tuple(image[row, column].tolist()) for column, row in places]


@pytest.mark.parametrize("window", [view.WHOLE_FIELD, (-1.0, 13.0, -1.0, 13.0)])
def test_the_field_lies_where_the_axes_say(window):
    surfaces = {
        (0.3, 0.2): field.RED,
        (11.7, 0.2): field.BLUE,
        (2.3, 7.4): field.WATER_BLUE,
        (4.6, 9.6): field.YELLOW,
        (3.2, 4.6): field.GREEN,
        (3.2, 1.6): field.ORANGE,
    }
    fig = view.draw_field(window=window, pale=0.0)
    assert colours_at(fig, *surfaces) == list(surfaces.values())


def test_a_pale_field_is_mixed_with_white():
    mixed = [round(0.6 * part + 0.4 * 255) for part in field.GREEN]
    (colour,) = colours_at(view.draw_field(window=(3.0, 4.0, 4.2, 4.9)), (3.2, 4.6))
    assert colour == pytest.approx(mixed, abs=1)


def test_a_crop_shows_the_same_field_as_the_whole():
    crop = view.draw_field(window=(3.3, 5.7, 7.2, 9.1), pale=0.0)
    colours = colours_at(crop, (3.4, 7.6), (3.4, 8.3), (5.2, 7.6))
    assert colours == [field.WATER_BLUE, field.YELLOW, field.GREEN]


def test_the_steps_that_stop_the_robot_are_seen_in_both_halves():
    for x0 in (3.0, 8.0):
        fig = view.draw_field(window=(x0, x0 + 1.0, 3.6, 4.2), pale=0.0)
        step, floor = colours_at(fig, (x0 + 0.4, 3.97), (x0 + 0.4, 3.9))
        assert step != field.ORANGE and floor == field.ORANGE


@given(place=st.tuples(*[st.floats(0.4, 11.6)] * 2), reach=st.tuples(*[st.floats(-0.3, 0.3)] * 2))
def test_a_window_shows_all_that_is_drawn_and_no_strip_of_nothing(place, reach):
    path = np.array([place, np.add(place, reach)])
    x0, x1, y0, y1 = field_picture._window(None, [path], [])
    assert (path > (x0, y0)).all() and (path < (x1, y1)).all()
    assert min(x0, y0) >= -0.051 and max(x1, y1) <= 12.051
    assert min(x1 - x0, y1 - y0) >= 2.4 - 1e-9


def test_a_window_around_a_long_straight_way_is_no_narrow_strip():
    x0, x1, y0, y1 = field_picture._window(None, [np.array([[3.0, 1.0], [3.0, 10.0]])], [])
    assert (y1 - y0, x1 - x0) == pytest.approx((9.0 + 1.3, 0.6 * (9.0 + 1.3)))


def test_a_window_fits_the_robot_too():
    ax = view.draw_field(robot=(5.0, 9.0, 0.0)).axes[0]
    assert (*ax.get_xlim(), *ax.get_ylim()) == pytest.approx((3.8, 6.2, 7.8, 10.2))


def test_a_path_keeps_its_points_and_its_meaning():
    ax = view.draw_field({"truth": POSES, "mine": POSES[:, :2] + 0.1}).axes[0]
    truth, mine = ax.lines[:2]
    assert np.array_equal(mine.get_xydata(), POSES[:, :2] + 0.1)
    assert (truth.get_color(), mine.get_color()) == (canvas.TRUTH, canvas.MINE)
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["truth", "mine"]


def test_a_path_with_a_hole_is_drawn_with_a_gap():
    path = POSES.copy()
    path[50:60] = np.nan
    assert np.isnan(view.draw_field({"mine": path}).axes[0].lines[0].get_xdata()).sum() == 10


def test_the_field_can_be_a_panel_of_a_larger_figure():
    fig, panels = view.figure(8.0, 4.0, columns=2)
    assert view.draw_field({"mine": POSES}, ax=panels[0]) is fig
    assert panels[0].images and not panels[1].images


def test_draw_field_refuses_what_it_cannot_draw():
    with pytest.raises(ValueError, match="window: expected \\(x0, x1, y0, y1\\)"):
        view.draw_field(window=(3.0, 1.0, 0.0, 1.0))
    with pytest.raises(ValueError, match="mine: expected shape"):
        view.draw_field({"mine": np.zeros((5, 4))})
    with pytest.raises(ValueError, match="robot: expected shape"):
        view.draw_field(robot=(1.0, 2.0))


# The robot on it


def test_the_robot_faces_where_its_pose_says():
    """Facing north at (2, 3): the nose north of the middle, the front left wheel in the west."""
    shapes = body.robot_shapes(view.RobotPicture((2.0, 3.0, np.pi / 2)))
    outline, _, nose, *wheels = (shape.corners for shape in shapes)
    assert outline.min(axis=0) == pytest.approx([2 - 0.325, 3 - 0.325])
    assert outline.max(axis=0) == pytest.approx([2 + 0.325, 3 + 0.325])
    assert nose[:, 1].max() == pytest.approx(3 + 0.28) and (nose[:, 1] > 3.0).all()
    assert wheels[0].mean(axis=0) == pytest.approx([2 - 0.235, 3 + 0.235])


def test_an_arrow_points_where_its_wheel_rolls():
    """Facing east; the front left module points left, its wheel rolls backwards: south."""
    picture = view.RobotPicture((0, 0, 0), angles=[np.pi / 2, 0, 0, 0], speeds=[-1.0, 0, 0, 0])
    arrow = body.robot_shapes(picture)[-1].corners
    tip = arrow[arrow[:, 1].argmin()]
    assert tip == pytest.approx([0.235, 0.235 - body.ARROW - 0.06])
    still = view.RobotPicture((0, 0, 0), speeds=[0.0] * 4)
    assert len(body.robot_shapes(still)) == len(body.robot_shapes(picture)) - 1


def test_a_beam_is_as_long_as_measured_and_a_missing_one_is_not_drawn():
    picture = view.RobotPicture((1.0, 1.0, 0.0), beams=[2.0, 0.0, 1.5, 0.0])
    front, rear = (s.corners for s in body.robot_shapes(picture) if s.opacity < 1.0)
    mount = robot.LIDARS[0]
    assert front[0] == pytest.approx([1 + mount.x, 1 + mount.y])
    assert front[1:].mean(axis=0) == pytest.approx([1 + mount.x + 2.0, 1 + mount.y])
    assert rear[1:, 0].max() < 1.0


@given(pose=st.tuples(*[st.floats(-10, 10)] * 3))
def test_the_robot_has_one_shape_wherever_it_stands(pose):
    here = body.robot_shapes(dataclasses.replace(ROBOT, pose=pose))
    home = body.robot_shapes(dataclasses.replace(ROBOT, pose=(0.0, 0.0, 0.0)))
    for one, other in zip(here, home, strict=True):
        assert transform_points(inverse(pose), one.corners) == pytest.approx(other.corners)


def test_an_observation_brings_wheels_and_beams():
    machine = Simulator()
    machine.apply(robot.Command([1.0] * 4, [0.5] * 4))
    machine.step(0.5)
    seen = machine.read()
    picture = view.RobotPicture.seen(machine.truth.pose, seen)
    assert np.array_equal(picture.angles, seen.module_angles)
    assert picture.beams == [reading.distance for reading in seen.lidar]
    body.robot_shapes(picture)


def blocks(pixels, side=6):
    """The mean colour of blocks of pixels: what smooth edges make of one pixel no longer counts."""
    rows, columns = (length // side for length in pixels.shape[:2])
    cut = pixels[: rows * side, : columns * side].astype(float)
    return cut.reshape(rows, side, columns, side, 3).mean(axis=(1, 3))


def test_painted_and_drawn_robots_are_the_same_picture():
    """The two painters are each other's naive twin; one makes its polygons half a pixel larger."""
    around = {"window": (1.0, 4.0, 2.0, 4.5)}
    backdrop, scale, inside = animation.backdrop_of(view.draw_field(**around))
    painted = blocks(np.asarray(animation._frame(backdrop, scale, inside, 0.0, [ROBOT]))[inside])
    drawn = blocks(animation.backdrop_of(view.draw_field(robot=ROBOT, **around))[0][inside])
    changed = np.abs(drawn - blocks(backdrop[inside])).max(axis=-1)
    assert (changed > 60).sum() > 300
    assert np.abs(painted - drawn).max() < 60


# Plots of motion


def texts(ax):
    return [text.get_text() for text in ax.texts]


def test_pose_errors_are_distance_and_the_shorter_turn():
    """3-4-5 in centimetres; 179 degrees against -179 is 2 degrees off."""
    truth = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.radians(-179)]])
    mine = np.array([[0.0, 0.0, 0.0], [0.03, 0.04, np.radians(179)]])
    far, turned = view.plot_pose_errors([0.0, 1.0], {"mine": mine}, truth).axes
    assert far.lines[0].get_ydata().tolist() == pytest.approx([0.0, 50.0])
    assert texts(far) == ["mine\n50"] and "[mm]" in far.get_title("left")
    assert turned.lines[0].get_ydata().tolist() == pytest.approx([0.0, -2.0])
    assert texts(turned) == ["mine\n−2.0°"]


def test_large_pose_errors_are_in_metres():
    ax = view.plot_pose_errors([0.0, 1.0], {"mine": [[0, 0, 0], [3, 4, 0]]}, np.zeros((2, 3))).axes[
        0
    ]
    assert texts(ax) == ["mine\n5.00"] and "[m]" in ax.get_title("left")


def test_modules_are_named_in_the_order_of_the_robot():
    speeds = np.tile([1.0, 2.0, 3.0, 4.0], (9, 1))
    fig = view.plot_modules(np.arange(9.0), np.zeros((9, 4)), speeds)
    last = [line.get_ydata()[-1] for line in fig.axes[1].lines]
    assert last == [1.0, 2.0, 3.0, 4.0]
    names = {text.get_text(): text.get_color() for text in fig.axes[1].texts}
    for name, (x, y), line in zip(names, robot.MODULES, fig.axes[1].lines, strict=True):
        assert name == f"{'front' if x > 0 else 'rear'} {'left' if y > 0 else 'right'}"
        assert names[name] == line.get_color()


def test_a_module_that_counts_its_turns_is_drawn_as_the_direction_it_has():
    angles = np.full((3, 4), 2 * np.pi + 0.5)
    fig = view.plot_modules(np.arange(3.0), angles, np.zeros((3, 4)), target_angles=angles)
    for line in fig.axes[0].lines:
        assert line.get_ydata() == pytest.approx(np.degrees(0.5))


def test_tracking_repeats_a_target_that_stands():
    fig = view.plot_tracking(TIME, POSES, (3.0, 6.0, np.pi / 2))
    ends = [ax.lines[0].get_ydata() for ax in fig.axes if ax.get_xlabel() != "x [m]"]
    assert [set(np.round(values, 9)) for values in ends] == [{3.0}, {6.0}, {90.0}]


def test_a_distribution_says_median_and_worst_in_its_unit():
    fig = view.plot_distribution({"mine": [0.01, 0.02, np.nan, 0.09]}, "Error", "cm", limit=0.05)
    assert "median 2 cm\nworst 9 cm\n3 runs" in texts(fig.axes[0])
    assert "limit" in texts(fig.axes[0])
    with pytest.raises(ValueError, match="unit: expected one of m, cm, mm"):
        view.plot_distribution({"mine": [1.0]}, unit="inch")
    with pytest.raises(ValueError, match="mine: expected at least one finite number"):
        view.plot_distribution({"mine": [np.nan]})


@settings(max_examples=10)
@given(st.sampled_from(sorted(runs.UNITS)), st.floats(0.001, 3.0))
def test_a_distribution_s_dots_lie_at_the_converted_values(unit, value):
    ax = view.plot_distribution({"mine": [value, value / 2]}, unit=unit).axes[0]
    assert ax.lines[0].get_xdata() == pytest.approx(np.array([value, value / 2]) * runs.UNITS[unit])


def test_headings_stand_evenly_along_the_way():
    way = np.column_stack([np.linspace(0, 2, 101) ** 2, np.zeros(101), np.zeros(101)])
    ax = view.plot_paths({"mine": way}, headings=5).axes[0]
    assert ax.collections[0].X == pytest.approx([0, 1, 2, 3, 4], abs=0.08)


# Moving pictures


def gif_frames(moving):
    gif = Image.open(io.BytesIO(moving.gif))
    frames = []
    for k in range(gif.n_frames):
        gif.seek(k)
        frames.append((np.asarray(gif.convert("RGB")).astype(int), gif.info["duration"]))
    return frames


SMALL = (0.0, 4.0, 1.0, 3.0)
WAY = np.column_stack([np.linspace(1.0, 3.0, 200), np.full(200, 2.0), np.zeros(200)])


def test_an_animation_shows_the_robot_where_it_is_at_that_time():
    moving = view.animate(TIME, {"mine": WAY}, window=SMALL, frames=11)
    frames = gif_frames(moving)
    assert len(frames) == 11
    paint = np.array([round(255 * part) for part in to_rgb(body.BODY)])
    _, scale, (rows, columns) = animation.backdrop_of(view.draw_field(window=SMALL))
    bodies = [np.abs(frame[rows, columns] - paint).max(axis=-1) < 8 for frame, _ in frames]
    middles = [np.argwhere(seen)[:, 1].mean() for seen in bodies]
    # A steady drive over 2 m: ten equal steps of 33 pixels, but for a few pixels of edges.
    assert np.diff(middles) == pytest.approx(0.2 * scale.per_metre, abs=2.5)


def test_an_animation_plays_in_real_time_and_a_long_one_in_eight_seconds():
    for factor, wanted in ((1.0, 5.0), (10.0, 8.0)):
        moving = view.animate(factor * TIME, {"mine": WAY}, window=SMALL, frames=16)
        pauses = [pause for _, pause in gif_frames(moving)]
        assert len(pauses) == 16
        assert sum(pauses[:-1]) / 1000 == pytest.approx(wanted, rel=0.03)  # pauses: whole 10 ms
        assert pauses[-1] > 1000


def test_an_animation_s_surfaces_have_exact_colours():
    first, _ = gif_frames(view.animate(TIME, {"mine": WAY}, window=SMALL, frames=3))[0]
    green = np.all(first == [round(0.6 * part + 102) for part in field.ORANGE], axis=-1)
    assert green.mean() > 0.4 and (first[2, 2] == 255).all()


def test_an_animation_too_large_for_a_notebook_gets_fewer_frames(monkeypatch):
    short = {"time": TIME, "poses": {"mine": WAY}, "window": SMALL, "frames": 12}
    whole = view.animate(**short)
    monkeypatch.setattr(animation, "LARGEST_GIF", len(whole.gif) * 9 // 10)
    assert len(gif_frames(view.animate(**short))) == 8
    monkeypatch.setattr(animation, "LARGEST_GIF", 1000)
    with pytest.raises(ValueError, match="bytes even with 3 frames; choose a smaller window"):
        view.animate(**short)


@pytest.mark.campaign
def test_an_animation_stays_below_a_megabyte_at_its_largest():
    circle = np.column_stack([3 + 1.5 * np.cos(TIME), 2.2 + 1.5 * np.sin(TIME), 3 * TIME])
    extras = {"angles": FOUR * 9, "speeds": FOUR * 9, "beams": np.abs(FOUR) * 20}
    moving = view.animate(TIME, {"truth": circle, "mine": circle + 0.3}, frames=120, **extras)
    assert 300_000 < len(moving.gif) <= 1_000_000 and len(moving.still) < 100_000


def test_an_animation_refuses_times_that_stand_still():
    with pytest.raises(ValueError, match="time: expected at least two increasing times"):
        view.animate([0.0, 0.0], {"mine": WAY[:2]})
    with pytest.raises(ValueError, match="mine: expected shape"):
        view.animate(TIME, {"mine": WAY[:-1]})


def test_show_sends_an_animation_once_and_a_still_picture_beside_it(notebook, capsys):
    moving = view.animate(TIME, {"mine": WAY}, window=SMALL, frames=3)
    view.show(moving, TWIN)
    ((data, metadata, _, _),) = notebook.messages
    encoded = base64.b64encode(moving.gif).decode()
    assert data["text/html"] == f'<img alt="{TWIN}" src="data:image/gif;base64,{encoded}">'
    assert notebook.picture(0) == moving.still
    assert metadata["image/png"]["alt"] == data["text/plain"] == TWIN
    assert capsys.readouterr().out == f"Figure: {TWIN}\n"


# Driving by hand


def test_drive_shows_a_picture_and_a_button_and_starts_no_simulator(notebook, monkeypatch):
    monkeypatch.setattr(driving, "Simulator", None)
    view.drive()
    (figure, *_), (button, *_) = notebook.messages
    assert "heading 0°, parts: reference" in figure["text/plain"]
    assert button["text/plain"] == "Button: Drive (starts the simulator)"


def test_without_a_notebook_drive_says_so(capsys):
    view.drive()
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith("Figure: Robot 2 on the field at (0.55, 0.35) m")
    assert second.startswith("Driving needs a notebook")


class Driver:
    """Somebody at the panel: presses the button, moves sliders, waits."""

    def __init__(self, parts=None, simulator=None):
        self.panel = driving.Panel(parts or Parts(), simulator, "id")

    def run(self, *steps):
        async def session():
            self.panel.open()
            await self.rest()
            for step in steps:
                step()
                await self.rest()

        asyncio.run(asyncio.wait_for(session(), 120))  # a robot that never stops ends the test

    async def rest(self):
        while not self.panel.task.done():
            await asyncio.sleep(0.001)

    def push(self, *values):
        for slider, value in zip(self.panel.sliders, values, strict=True):
            slider.value = value

    def after(self, seconds, act):
        """Act once the robot has driven for some seconds of its own time."""

        async def wait():
            start = self.panel.ride.observation.time
            while self.panel.ride.observation.time < start + seconds:
                await asyncio.sleep(0.001)
            act()

        self.waiting = asyncio.get_running_loop().create_task(wait())


@pytest.fixture
def hurry(monkeypatch):
    """No waiting for the real time to pass."""
    sleep = asyncio.sleep
    monkeypatch.setattr(driving.asyncio, "sleep", lambda _: sleep(0))


def test_a_slider_moves_the_robot_and_stop_ends_it(notebook, hurry):
    driver = Driver()
    panel, pictures = driver.panel, []

    def go():
        pictures.append(bytes(panel.image.value))
        driver.push(0.5, 0.0, 0.0)
        driver.after(2.0, panel.stop.click)

    driver.run(go)
    assert panel.ride.pose[0] == pytest.approx(0.55 + 1.0, abs=0.2)
    assert not panel.ride.moving and panel.task.done()
    picture = bytes(panel.image.value)
    assert picture != pictures[0] and picture.startswith(b"\x89PNG")
    assert (
        f"x {panel.ride.pose[0]:.2f} m, y 0.35 m, heading 0°; touches nothing"
        in panel.readout.value
    )
    (update,) = [message for message in notebook.messages if message[3]]
    assert update[2] == "id", "the live panel takes the place of the still picture"


def test_along_the_map_s_axes_the_robot_s_heading_does_not_matter(notebook, hurry):
    driver = Driver(simulator=Simulator(start=(2.0, 1.2, np.pi / 2)))

    def go():
        driver.panel.field_centric.value = True
        driver.push(0.5, 0.0, 0.0)
        driver.after(1.0, driver.panel.stop.click)

    driver.run(go)
    x, y, _ = driver.panel.ride.pose
    assert x > 2.3 and y == pytest.approx(1.2, abs=0.05)


def test_the_robot_stops_where_nobody_drives_any_more(notebook, hurry, monkeypatch):
    monkeypatch.setattr(driving, "PATIENCE", 0.2)
    driver = Driver()
    driver.run(lambda: driver.push(0.0, 0.0, 1.0))
    assert "Stopped: no input for 0.2 s." in driver.panel.readout.value
    assert [slider.value for slider in driver.panel.sliders] == [0.0, 0.0, 0.0]


def test_a_closed_panel_drives_no_further(notebook, hurry):
    driver = Driver()

    def go():
        driver.push(0.0, 0.0, 1.0)
        driver.after(0.5, driver.panel.image.close)

    driver.run(go)
    assert driver.panel.ride.moving and driver.panel.task.done()


def test_a_student_s_own_part_drives_and_its_exception_is_shown(notebook, hurry):
    from robocon_course import swerve

    calls = []

    def module_targets(*arguments):
        calls.append(arguments)
        if len(calls) > 20:
            raise ZeroDivisionError("division by <zero>")
        return swerve.module_targets(*arguments)

    driver = Driver(dataclasses.replace(Parts(), module_targets=module_targets))
    driver.run(lambda: driver.push(0.0, 0.0, 1.0))
    assert driver.panel.readout.value == "ZeroDivisionError: division by &lt;zero&gt;"
    assert len(calls) == 21
    driver.panel.ride.simulator.step(2.0)
    assert not driver.panel.ride.moving, "a robot whose program broke stops"


def test_the_left_stick_drives_and_the_right_stick_turns(notebook, hurry):
    driver = Driver()

    def tilt(left_x, left_y, right_x):
        axes = [SimpleNamespace(value=value) for value in (left_x, left_y, right_x)]
        driver.panel.pad = SimpleNamespace(axes=axes)
        driver.panel._sticks(None)
        return [slider.value for slider in driver.panel.sliders]

    async def session():
        driver.panel.open()
        assert tilt(0.0, -1.0, 0.0) == [2.0, 0.0, 0.0], "up is forward"
        assert tilt(-0.5, 0.1, 1.0) == [0.0, 1.0, -3.0], "left is left, right turns right"
        assert tilt(0.0, 0.0, 0.0) == [0.0, 0.0, 0.0]
        await driver.rest()

    asyncio.run(session())


@pytest.mark.parametrize("place", [(0.55, 0.35), (6.0, 6.0), (11.6, 11.6), (5.5, 11.6)])
def test_the_camera_keeps_the_robot_in_its_picture(place):
    view_of, scale = live._field_at(*place)
    column, row = scale.pixels(np.array(place))
    assert view_of.shape == (live.VIEW[1], live.VIEW[0], 3)
    assert 30 < column < live.VIEW[0] - 30 and 30 < row < live.VIEW[1] - 30


def test_the_camera_shows_the_field_that_is_there():
    view_of, scale = live._field_at(2.0, 6.8)
    column, row = scale.pixels(np.array([2.0, 7.5])).astype(int)
    water = [round(0.75 * part + 0.25 * 255) for part in field.WATER_BLUE]
    assert view_of[row, column] == pytest.approx(water, abs=1)


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


def test_a_long_twin_is_printed_in_lines_that_end_between_words(notebook, capsys):
    long = "Balls: " + ", ".join(f"{k}.{k:02d} m" for k in range(40)) + "."
    view.show(line()[0], long)
    printed = capsys.readouterr().out
    assert all(len(one) <= 100 for one in printed.splitlines()) and printed.count("\n") > 2
    assert " ".join(printed.split()) == f"Figure: {long}"
    assert notebook.messages[0][0]["text/plain"] == long, "a screen reader hears one line"


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
    assert "Figure: A line that rises by 2.00 within 1 s." in readout.value
    controls["slope"].value = 4.5
    assert "ValueError: slope: 4 at most, &lt;b&gt;" in readout.value
    assert len(notebook.figures) == 2
    controls["slope"].value = 1.5
    assert "Figure: A line that rises by 1.50 within 1 s." in readout.value
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
