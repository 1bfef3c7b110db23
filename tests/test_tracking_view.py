"""The plots of path tracking: what is drawn, in which colour, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex

from robocon_course import tracking, worlds
from robocon_course.view import plots, png

TIME = 0.01 * np.arange(100)
PATH = worlds.finely(worlds.SOURCE_PATHS["roof"], 0.02)


def lines(ax) -> dict[str, np.ndarray]:
    """Colour -> the values of the last line that has it."""
    return {to_hex(line.get_color()).upper(): np.asarray(line.get_ydata()) for line in ax.lines}


def test_responses_keep_the_colours_that_have_a_meaning_and_show_target_and_limits():
    panels = {
        "Heading [deg]": {"mine": np.sin(TIME), "wrong: late": np.cos(TIME)},
        "Output [m/s]": {"mine": 0.5 * TIME},
    }
    fig = plots.plot_responses(
        TIME, panels, targets={"Heading [deg]": 1.0}, limits={"Output [m/s]": (-0.6, 0.6)}
    )
    heading, output = fig.axes
    assert [ax.get_title(loc="left") for ax in fig.axes] == list(panels)
    drawn = lines(heading)
    assert np.array_equal(drawn[plots.MINE], np.sin(TIME))
    assert np.array_equal(drawn[plots.WARN], np.cos(TIME))
    assert np.array_equal(drawn[plots.TRUTH], np.ones(100))
    dotted = [line.get_ydata()[0] for line in output.lines if line.get_linestyle() == ":"]
    assert dotted == [-0.6, 0.6]
    assert png(fig).startswith(b"\x89PNG")


def test_the_circle_of_pursuit_leads_from_the_robot_to_its_target():
    pose = np.array([0.1, 0.05, 1.2])
    found = tracking.pure_pursuit(PATH, pose, 0.4)
    foot = tracking.nearest_point(PATH, pose[:2])
    fig = plots.plot_pursuit(PATH, pose, found.target, found.curvature, foot.xy)
    arc = max(fig.axes[0].lines, key=lambda line: len(line.get_xdata()) == 60)
    x, y = arc.get_data()
    assert (x[0], y[0]) == pytest.approx(pose[:2])
    assert (x[-1], y[-1]) == pytest.approx(found.target)
    words = {text.get_text() for text in fig.axes[0].texts}
    assert {"look-ahead point", "nearest point", "L = 0.40 m"} <= words


def test_straight_ahead_there_is_no_circle():
    fig = plots.plot_pursuit([[0, 0], [1, 0]], [0.0, 0.0, 0.0], (0.5, 0.0), 0.0, (0.0, 0.0))
    assert not any("r =" in text.get_text() for text in fig.axes[0].texts)


def test_errors_of_runs_are_drawn_in_centimetres_beside_their_paths():
    run = tracking.trial(PATH)
    fig = plots.plot_path_errors(PATH, {"reference": run, "wrong": run}, limit=0.03)
    plane, errors = fig.axes
    assert np.array_equal(lines(errors)[plots.REFERENCE], 100.0 * run.cross_track)
    assert np.array_equal(lines(plane)[plots.REFERENCE], run.poses[:, 1])
    dotted = [line.get_ydata()[0] for line in errors.lines if line.get_linestyle() == ":"]
    assert dotted == [-3.0, 3.0]
    assert len(fig.legends) == 1
    assert not plots.plot_path_errors(PATH, {"reference": run}).legends


def test_speeds_are_drawn_over_the_way_and_on_the_path():
    speeds = tracking.speed_profile(PATH, 0.5, 0.5, 0.3)
    fig = plots.plot_speeds(PATH, speeds, {"limit": np.full(len(PATH), 0.6)})
    plane, over = fig.axes[:2]
    assert np.array_equal(lines(over)[plots.REFERENCE], speeds)
    coloured = plane.collections[0].get_array()
    assert np.asarray(coloured) == pytest.approx(0.5 * (speeds[:-1] + speeds[1:]))


def test_source_paths_stand_side_by_side_with_one_key():
    runs = {name: {"reference": np.zeros((5, 3))} for name in worlds.SOURCE_PATHS}
    fig = plots.plot_source_paths(worlds.SOURCE_PATHS, runs)
    assert len(fig.axes) == 3 and len(fig.legends) == 1
    assert all(ax.get_legend() is None for ax in fig.axes)


@pytest.mark.parametrize(
    "call, sentence",
    [
        (lambda: plots.plot_responses(TIME, {"a": {"b": [1.0]}}), r"b: expected shape \(100,\)"),
        (lambda: plots.plot_speeds(PATH, [1.0]), r"speeds: expected shape"),
        (lambda: plots.plot_pursuit(PATH, [0.0, 0.0], (0, 0), 0.0, (0, 0)), r"pose: expected"),
    ],
)
def test_what_cannot_be_drawn_is_refused(call, sentence):
    with pytest.raises(ValueError, match=sentence):
        call()
