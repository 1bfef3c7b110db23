"""A recorded match fed back through the autopilot: the same decisions, or where they part."""

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from robocon_course._arrays import CourseError
from robocon_course.autopilot import Parts
from robocon_course.cli import app
from robocon_course.logs import MatchLog, summary
from robocon_course.robot import Bus
from robocon_course.robot.messages import Button, Twist
from robocon_course.worlds import Play
from robocon_course.worlds.match import new_pilot
from robocon_course.worlds.replays import replay_log


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Twelve seconds in which the crew does all that it can."""
    path, bus = tmp_path_factory.mktemp("log") / "m.mcap", Bus()
    presses = {
        50: [Button("start")], 200: [Button("stop")], 300: [Button("start")],
        500: [Button("manual", "on")], 520: [Twist(0.0, 0.3, 0.0)], 600: [Button("manual", "off")],
        700: [Button("retry")], 900: [Button("manual", "on"), Twist(0.0, 0.0, 0.5)],
        910: [Button("intake", 1.0), Button("pan", "left"), Button("pan", 0.3)],
        950: [Button("release")], 980: [Button("stop")], 1000: [Button("start")],
        1300: [Button("stop")], 1310: [Button("retry")],
    }  # fmt: skip
    with MatchLog(path) as log:
        log.listen(bus)
        play = Play(0, seed=2, bus=bus)
        for tick in range(1500):
            for message in presses.get(tick, ()):
                bus.publish("/cmd_vel" if isinstance(message, Twist) else "/operator", message)
            play.tick()
    assert play.match.retries == 2 and not bus.failed
    return path


def test_a_log_gives_the_same_commands_whatever_the_crew_did_meanwhile(recorded):
    found = replay_log(recorded, 0)
    told = summary(recorded).topics["/command"]
    assert found.same and found.commands == told > 1490, "those that were given by hand as well"
    assert [state for _, state in found.states].count("go_to_area_3") == 3
    assert found.states[-1][1] == "reset", "it was stopped"
    assert found.lines[-1] == f"✔ all {found.commands} commands are those of the log"


def test_other_parts_are_told_where_they_first_decide_otherwise(recorded):
    slow = replace(
        Parts(), speed_profile=lambda *args: 0.9 * np.asarray(Parts.speed_profile(*args))
    )
    found = replay_log(recorded, 0, slow)
    assert not found.same and found.first is not None and found.different > 100
    assert f"the first at {found.first:.2f} s" in found.lines[-1]


def test_a_log_that_is_cut_off_is_replayed_as_far_as_it_goes_and_says_so(recorded, tmp_path):
    cut = tmp_path / "m.mcap"
    cut.write_bytes(recorded.read_bytes()[: recorded.stat().st_size * 3 // 4])
    found = replay_log(cut, 0)
    assert found.same and 300 < found.commands < 1490
    assert found.lines[-2].startswith("– m.mcap is cut off or damaged; ")
    assert replay_log(recorded, 0).trouble == ""


@pytest.mark.parametrize("setting", ["", "red 0.0 0.0 1 1", "red 0 0 x 0 1 1", "green 0 0 0 0 1 1"])
def test_a_set_up_that_is_none_is_refused(setting):
    with pytest.raises(CourseError, match=r"setting: expected a team, 4 numbers|team: expected"):
        new_pilot(Parts(), 0, setting)


def test_a_log_without_the_robots_set_up_is_refused(tmp_path):
    bus = Bus()
    play = Play(0, seed=2, bus=bus)
    with MatchLog(tmp_path / "m.mcap") as log:
        log.listen(bus)
        play.tick()
    with pytest.raises(CourseError, match="does not hold how the robot was set up"):
        replay_log(tmp_path / "m.mcap")


def test_the_command_says_it_by_its_exit_code(recorded, tmp_path):
    told = CliRunner().invoke(app, ["replay", str(recorded)])
    assert told.exit_code == 0 and "commands are those of the log" in told.output
    assert CliRunner().invoke(app, ["replay", str(tmp_path / "none.mcap")]).exit_code == 2
