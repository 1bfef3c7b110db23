"""The operator's screen, fed from a bus: what it shows, what it tells, and what it survives."""

from __future__ import annotations

import asyncio
import base64
import re
from functools import cache
from html import unescape
from html.parser import HTMLParser
from itertools import pairwise
from types import SimpleNamespace
from xml.etree import ElementTree

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from IPython.core.interactiveshell import InteractiveShell

from robocon_course import field
from robocon_course.robot import BATTERY, Bus, LidarReading, Observation, messages
from robocon_course.view.dashboard import Dashboard, dashboard, field_map, markup, states
from robocon_course.view.stick import LIMITS, pushed
from robocon_course.worlds import Play

WAYS = (
    ("wait", "drive", "start"),
    ("drive", "wait", "arrived"),
    ("drive", "stuck", "coming <nowhere>"),
    ("stuck", "wait", "free & well"),
)
EVIL = '<script>alert("x")</script>'
SAFE = "&lt;script&gt;alert(&quot;x&quot;)&lt;/script&gt;"


class Clock:
    """Wall time that stands still until somebody moves it."""

    def __init__(self):
        self.now = 50.0

    def __call__(self):
        return self.now


class Match:
    """A robot that says what the test tells it, and the screen that listens."""

    def __init__(self, **kw):
        self.bus, self.clock = Bus(), Clock()
        self.told = []
        self.bus.subscribe("*", lambda topic, message: self.told.append((topic, message)))
        self.screen = Dashboard(self.bus, clock=self.clock, **kw)
        self.controls = self.screen.controls

    def say(self, topic, message):
        self.bus.publish(topic, message)
        return self

    def pose(self, x, y, theta=0.0, time=1.0):
        return self.say("/odom", messages.PoseStamped(time, np.array([x, y, theta])))

    def pane(self, name):
        self.screen.draw()
        assert self.screen.failures == {} and self.bus.failed == []
        return self.screen.panes[name].value

    def text(self, name):
        """The words of a pane, without its markup."""
        words = re.sub(r"<title>.*?</title>|</?b\b[^>]*>", "", self.pane(name))
        return " ".join(unescape(re.sub(r"<[^>]*>", " ", words)).split())

    def heard(self, topic):
        return [message for name, message in self.told if name == topic]

    def buttons(self):
        return [(one.name, one.value) for one in self.heard("/operator")]

    def by_hand(self):
        self.say("/observation", seen())
        self.screen.draw()
        self.controls.manual.value = True
        self.told.clear()
        return self

    def started(self):
        self.say("/observation", seen())
        self.controls.start.click()
        self.screen.draw()
        return self


def seen(time=1.0, ticks=(100, 200, -30), battery=23.4, **kw):
    beams = ((1.23, 800), (0.0, 60), (4.56, 1200), (0.0, 65535))
    lidar = tuple(LidarReading(time, distance, strength, 30.0) for distance, strength in beams)
    return Observation(
        time,
        np.array(ticks),
        np.array([time]),
        np.array([[0.0, 0.0, 0.52]]),
        np.array([[0.1, -0.2, 9.81]]),
        lidar,
        np.array([1.2, 0.0, -1.1, 0.5]),
        np.array([0.3, 1.2, -2.0, 0.0]),
        battery,
        **kw,
    )


@pytest.fixture
def match():
    return Match()


# --- what is shown ----------------------------------------------------------------------------


def test_where_nobody_speaks_the_screen_says_no_robot_and_stands_still(match):
    first = {name: match.pane(name) for name in match.screen.panes}
    assert "no robot" in match.text("status") and "no pose yet" in match.text("where")
    match.clock.now += 1000.0
    assert {name: match.pane(name) for name in match.screen.panes} == first


def test_a_robot_silent_for_more_than_a_second_is_lost_and_comes_back(match):
    match.pose(1.0, 1.0)
    assert match.text("status").startswith("● connected")
    match.clock.now += 0.99
    assert match.text("status").startswith("● connected")
    match.clock.now += 1.01
    assert match.text("status").startswith("○ connection lost 2 s ago")
    match.pose(1.0, 1.0, time=3.0)
    assert match.text("status").startswith("● connected")


def test_what_operators_say_is_no_sign_of_a_robot(match):
    match.controls.start.click()
    match.say("/cmd_vel", messages.Twist(0.0, 0.0, 0.0))
    assert "no robot" in match.text("status")


def test_a_screen_that_opens_late_knows_what_was_told_but_waits_for_a_sign_of_life():
    bus = Bus()
    bus.publish("/mission/state", messages.State(2.0, "drive", "start"))
    bus.publish("/silos", messages.Silos(2.0, ("RB", "", "", "", "")))
    screen = Dashboard(bus)
    screen.draw()
    assert "drive" in screen.panes["state"].value and ">B</text>" in screen.panes["map"].value
    assert "no robot" in screen.panes["status"].value


class Robot(HTMLParser):
    """Finds where the robot's group is put on the map."""

    def handle_starttag(self, tag, attrs):
        if dict(attrs).get("class") == "rc-robot":
            self.transform = dict(attrs)["transform"]


def test_the_robot_stands_on_the_map_where_its_pose_says(match):
    finder = Robot()
    finder.feed(match.pose(1.5, 2.25, np.pi / 2).pane("map"))
    assert finder.transform == "translate(150.0 -225.0) rotate(-90.0)"
    assert match.text("where").startswith("x 1.50 m, y 2.25 m, heading 90°")


def test_map_and_floor_lie_on_one_another():
    """The picture's first and last pixel are the ends of the overlay's box."""
    left, top, width, height = map(float, field_map.BOX.split())
    source = re.search(r'src="data:image/png;base64,([^"]+)"', field_map.floor())[1]
    picture = cv2.imdecode(np.frombuffer(base64.b64decode(source), np.uint8), cv2.IMREAD_COLOR)
    rows, columns, _ = picture.shape
    assert (rows, columns) == (height, width), "one pixel to a centimetre"
    x, y = field.WATER.centre
    blue, _, red = picture[round(-100 * y - top), round(100 * x - left)].astype(int)
    assert blue > red + 20, "the water is blue where the map says water"
    x, y = field.AREA_1.centre
    blue, _, red = picture[round(-100 * y - top), round(100 * x - left)].astype(int)
    assert red > blue + 20, "and Area 1 is orange"


def test_the_overlay_is_well_formed_and_small(match):
    for k in range(1000):
        match.pose(0.5 + 0.005 * k, 0.5 + 0.002 * k, 0.01 * k, time=0.01 * k)
    match.say("/observation", seen(10.0)).say("/plan", messages.Path(10.0, np.ones((50, 2))))
    match.say("/ground_truth", messages.PoseStamped(10.0, np.array([5.4, 2.5, 0.0])))
    page = match.pane("map")
    ElementTree.fromstring(page)
    assert len(page) < 8000


def test_the_driven_path_is_drawn_without_a_line_over_a_jump(match):
    for x in (1.0, 1.1, 1.2, 4.0, 4.1):
        match.pose(x, 2.0)
    assert 'd="M100 -200l10 0l10 0M400 -200l10 0"' in match.pane("map")


def test_the_planned_path_ends_in_a_ring_that_fills_when_the_robot_is_there(match):
    match.say("/plan", messages.Path(0.0, np.array([[1.0, 1.0], [2.0, 1.0]])))
    assert 'd="M100 -100L200 -100"' in match.pane("map")
    match.pose(1.75, 1.0)
    assert "rc-reached" not in match.pane("map")
    match.pose(1.85, 1.0)
    assert "rc-reached" in match.pane("map") and "target reached" in match.text("where")
    match.pose(1.0, 1.0)
    assert "rc-reached" in match.pane("map"), "it was there"
    match.say("/plan", messages.Path(0.0, np.array([[1.0, 1.0], [5.0, 1.0]])))
    assert "rc-reached" not in match.pane("map"), "another target"


def test_silos_show_their_balls_from_the_bottom_with_their_letters(match):
    match.say("/silos", messages.Silos(0.0, ("RB", "", "", "", "BBR")))
    page = ElementTree.fromstring(match.pane("map"))
    at = [
        (one.text, float(one.get("x")), float(one.get("y")))
        for one in page.iter("text")
        if one.text in "RB"
    ]
    rows = {y: [letter for letter, x, row in sorted(at, key=lambda a: a[1]) if row == y]
            for _, _, y in at}  # fmt: skip
    assert rows == {-850.0: ["R", "B"], -1150.0: ["B", "B", "R"]}


def test_only_a_simulator_s_truth_draws_the_dashed_outline(match):
    assert "rc-truth" not in match.pose(1.0, 1.0).pane("map")
    match.say("/ground_truth", messages.PoseStamped(1.0, np.array([1.1, 1.0, 0.0])))
    assert 'class="rc-truth" transform="translate(110.0 -100.0)' in match.pane("map")


def test_sensors_are_shown_in_numbers_and_what_cannot_be_trusted_in_words(match):
    match.say("/observation", seen())
    match.say("/observation", seen(1.5, ticks=(600, 200, -130), holding=True))
    words = match.text("sensors")
    for part in (
        "ticks 600 200 −130 holds a ball",
        "ticks/s 1000 0 −200",
        "distance [m] 1.23 – 4.56 –",
        "strength 800 60 weak 1200 too much",
        "0.52 0.1 −0.2 9.8",
        "angle [°] 17 69 −115 0",
        "speed [m/s] 1.20 0.00 −1.10 0.50",
    ):
        assert part in words, part
    page = match.pane("sensors")
    assert page.count("rc-module") == 4 and page.count('<path transform="translate') == 3


def test_a_module_that_rolls_backwards_has_its_arrow_on_the_other_side(match):
    from robocon_course.view.dashboard.readings import arrow

    ahead, back = (re.search(r"translate\((\S+) (\S+)\)", arrow(0.0, v)) for v in (1.0, -1.0))
    assert float(ahead[2]) < 0 < float(back[2]), "the robot's front is at the top"
    left = re.search(r"translate\((\S+) (\S+)\)", arrow(np.pi / 2, 1.0))
    assert float(left[1]) < -5 and abs(float(left[2])) < 0.1


def test_a_low_battery_is_told_in_a_word(match):
    assert "battery 24.0 V" in match.say("/observation", seen(battery=BATTERY)).text("status")
    assert "low" not in match.text("status")
    assert "battery 21.9 V: low" in match.say("/observation", seen(battery=21.9)).text("status")


def picture_of(match):
    source = re.search(r'src="data:image/jpeg;base64,([^"]+)"', match.pane("camera"))[1]
    return cv2.imdecode(np.frombuffer(base64.b64decode(source), np.uint8), cv2.IMREAD_COLOR)


def test_the_camera_s_picture_has_its_boxes_where_they_were_found(match):
    match.say("/camera/image", messages.Image(3.0, np.zeros((240, 320, 3), np.uint8)))
    assert picture_of(match).max() < 12
    box = np.array([[80.0, 60.0, 160.0, 120.0]])
    found = messages.Detection2DArray(3.0, "ball", box, np.array([0.87]), ("red",))
    match.say("/camera/detections", found)
    drawn = picture_of(match)
    scale = drawn.shape[1] / 320
    on_edge = drawn[round(90 * scale), round(80 * scale) - 2 : round(80 * scale) + 3]
    assert on_edge[:, 2].max() > 150 and drawn[round(90 * scale), round(120 * scale)].max() < 40
    assert "balls: 1 red" in match.text("camera")


def test_boxes_of_another_picture_are_not_drawn_and_a_picture_only_once(match):
    match.say("/camera/image", messages.Image(3.0, np.zeros((240, 320, 3), np.uint8)))
    found = messages.Detection2DArray(1.0, "ball", np.zeros((1, 4)), np.ones(1), ("red",))
    assert "1 red" not in match.say("/camera/detections", found).text("camera")
    assert match.pane("camera") is match.pane("camera")


def test_without_a_picture_detections_are_drawn_on_an_empty_one(match):
    assert "no picture yet" in match.text("camera")
    boxes = np.array([[200.0, 60, 240, 120], [20.0, 60, 60, 120]])
    found = messages.Detection2DArray(1.0, "silo", boxes, np.array([0.9, 0.8]), ("RB", "B"))
    assert "silos from the left: B, RB" in match.say("/camera/detections", found).text("camera")


def test_without_a_picture_what_was_found_long_ago_is_not_drawn_over_what_is_found_now(match):
    box, sure = np.array([[20.0, 60, 60, 120]]), np.array([0.9])
    for time, kind, label in ((1.0, "silo", "RB"), (1.2, "ball", "red")):
        match.say("/camera/detections", messages.Detection2DArray(time, kind, box, sure, (label,)))
    assert "RB" in match.text("camera") and "1 red" in match.text("camera")
    later = messages.Detection2DArray(3.0, "ball", box, sure, ("blue",))
    words = match.say("/camera/detections", later).text("camera")
    assert "1 blue" in words and "RB" not in words


def test_clock_and_score_are_the_referee_s(match):
    assert match.text("status").endswith("--:--")
    match.say("/score", messages.Score(58.8, 30, 20, 121.2))
    assert match.text("status").endswith("30 : 20 02:02")
    match.say("/score", messages.Score(180.0, 90, 20, 0.0, "own", "Mua Vang"))
    assert match.text("status").endswith("90 : 20 won 00:00")


@given(st.floats(0, 6000))
def test_a_begun_second_counts_as_on_a_match_clock(left):
    whole, seconds = map(int, markup.minutes(left).split(":"))
    assert -1e-6 <= 60 * whole + seconds - left < 1.0


def test_the_log_keeps_the_last_200_lines_newest_first_and_counts_what_is_bad(match):
    for k in range(250):
        level = ("info", "warning", "error")[k % 3]
        match.say("/rosout", messages.Log(0.1 * k, level, f"line {k};"))
    words = match.text("events")
    assert re.findall(r"line (\d+);", words) == [str(k) for k in range(249, 49, -1)]
    assert "00:24.9 info: line 249;" in words and "00:24.8 error: line 248;" in words
    assert "83 warnings" in match.text("status") and "83 errors" in match.text("status")


def test_what_is_told_on_two_topics_is_one_line_of_the_log_but_warnings_are_counted(match):
    match.say("/mission/state", messages.State(4.0, "drive", "start"))
    match.say("/rosout", messages.Log(4.0, "info", "drive: start"))
    assert match.text("events").count("drive: start") == 1
    match.say("/rosout", messages.Log(9.0, "info", "drive: start"))
    assert match.text("events").count("drive: start") == 2, "later it is another event"
    for _ in range(2):
        match.say("/rosout", messages.Log(9.0, "warning", "own: foul"))
    assert match.text("events").count("own: foul") == 2 and "2 warnings" in match.text("status")


def test_numbers_that_are_for_a_recording_are_not_shown(match):
    match.say("/operator", messages.Button("set_up", "blue -0.0136592 1 1"))
    match.say("/operator", messages.Button("placed", "0.5 5.5 0.0136592 5.0"))
    words = match.text("events")
    assert "operator: set_up blue" in words and "operator: placed" in words
    assert "0.0136592" not in words


# --- the mission's states ---------------------------------------------------------------------


def test_the_live_state_is_marked_and_the_last_change_told_in_words():
    match = Match(states=WAYS)
    match.say("/mission/state", messages.State(1.0, "wait", ""))
    match.say("/mission/state", messages.State(4.0, "drive", "start"))
    match.pose(1.0, 1.0, time=6.0)
    page = match.pane("mission")
    assert re.findall(r'<g class="rc-live"><title>(\w+)', page) == ["drive"]
    assert re.findall(r"<g><title>(\w+)", page) == ["wait", "stuck"]
    assert match.text("state") == "drive for 2 s from wait: start"
    assert "00:04.0 state: drive: start" in match.text("events")


def test_the_ways_that_are_open_carry_their_labels_escaped():
    match = Match(states=WAYS).say("/mission/state", messages.State(1.0, "drive", "start"))
    ElementTree.fromstring(match.pane("mission").split("</div>", 1)[1])
    titles = re.findall(r"<path [^>]*><title>(.*?)</title>", match.pane("mission"))
    assert titles == ["arrived", "coming &lt;nowhere&gt;"]


def test_a_state_told_again_is_no_change(match):
    for time in (1.0, 1.0, 1.0):
        match.say("/mission/state", messages.State(time, "wait", "begin"))
    assert match.text("events").count("state: wait") == 1


def test_without_a_table_the_states_are_a_history(match):
    for k, name in enumerate(("wait", "drive", "stuck")):
        match.say("/mission/state", messages.State(float(k), name, f"reason {k}"))
    assert match.text("mission") == "Mission"
    assert match.text("state") == (
        "stuck from drive: reason 2 00:01.0 drive: reason 1 00:00.0 wait: reason 0"
    )


def test_a_state_that_the_table_lacks_is_told():
    match = Match(states=WAYS).say("/mission/state", messages.State(0.0, "lost", "who knows"))
    assert "This state is not in the picture." in match.text("state")


def test_a_text_in_mermaid_is_the_same_as_a_list():
    text = "stateDiagram-v2\n    [*] --> wait\n" + "".join(
        f"    {source} --> {target}: {label}\n" for source, target, label in WAYS
    )
    text += "    wait --> [*]\n    classDef live fill:#ffb000\n    class wait live\n"
    assert states.ways_of(text) == WAYS == states.ways_of([list(way) for way in WAYS])


def test_states_that_everything_leads_to_are_no_tangle():
    names = [f"s{k}" for k in range(12)]
    ways = [(a, b, "on") for a, b in pairwise(names)]
    ways += [(name, "end", "over") for name in names]
    diagram = states.Diagram(states.ways_of(ways))
    assert len(diagram.pale) == 11 and "end" in diagram.places
    lying = {
        (round(x), round(y))
        for x, y in diagram.places.values()
        if 0 <= x - states.BOX[0] / 2 and x + states.BOX[0] / 2 <= states.CELL[0] * states.COLUMNS
    }
    assert len(lying) == 13, "every state has a place of its own inside the picture"


@pytest.mark.parametrize(
    ("kw", "sentence"),
    [
        ({"states": [("a", "b")]}, "rows (source, target, label)"),
        ({"states": ["abc"]}, "rows (source, target, label)"),
        ({"states": [("a", "b", 3)]}, "rows (source, target, label)"),
        ({"states": "a -> b"}, "lines such as"),
        ({"refresh": 0.01}, "refresh: expected seconds from 0.05 to 1"),
        ({"refresh": "fast"}, "refresh: expected seconds"),
    ],
)
def test_what_cannot_be_shown_is_refused(kw, sentence):
    bus = Bus()
    with pytest.raises(ValueError, match=re.escape(sentence)):
        dashboard(bus, **kw)
    assert bus._listeners == {}, "and nothing listens"
    with pytest.raises(ValueError, match="bus: expected a Bus, got dict"):
        dashboard({})


# --- strangers --------------------------------------------------------------------------------


def test_nothing_from_outside_is_taken_for_markup():
    match = Match(states=[(EVIL, "b", EVIL), ("b", EVIL, EVIL)])
    match.say("/mission/state", messages.State(0.0, "b", EVIL))
    match.say("/mission/state", messages.State(1.0, EVIL, EVIL))
    match.say("/rosout", messages.Log(0.0, EVIL, EVIL)).pose(1.0, 1.0)
    match.say("/silos", messages.Silos(0.0, (EVIL,) * 5))
    match.say("/score", messages.Score(0.0, 1, 2, 3.0, EVIL, EVIL))
    match.say("/operator", messages.Button(EVIL, EVIL))
    found = messages.Detection2DArray(0.0, "ball", np.ones((1, 4)), np.ones(1), (EVIL,))
    match.say("/camera/detections", found)
    match.screen.draw()
    pages = [pane.value for pane in match.screen.panes.values()]
    assert not any("<script" in page for page in pages)
    assert sum(SAFE in page for page in pages) >= 4


STRANGE = st.one_of(
    st.none(), st.text(), st.integers(), st.floats(), st.lists(st.floats(), max_size=4)
)
TOPICS = {
    "/odom": messages.PoseStamped,
    "/ground_truth": messages.PoseStamped,
    "/plan": messages.Path,
    "/scan": messages.LaserScan,
    "/camera/image": messages.Image,
    "/camera/detections": messages.Detection2DArray,
    "/silos": messages.Silos,
    "/mission/state": messages.State,
    "/rosout": messages.Log,
    "/score": messages.Score,
    "/operator": messages.Button,
    "/observation": Observation,
    "/command": SimpleNamespace,
}


@settings(max_examples=60, deadline=None)
@given(st.data(), st.sampled_from(sorted(TOPICS)))
def test_whatever_is_told_the_bus_does_not_notice_and_the_screen_draws_on(data, topic):
    match = long_lived()
    kind = TOPICS[topic]
    names = getattr(kind, "_fields", ("pan", "tilt"))
    message = data.draw(st.one_of(STRANGE, st.fixed_dictionaries(dict.fromkeys(names, STRANGE))))
    match.bus.publish(topic, kind(**message) if isinstance(message, dict) else message)
    match.screen.draw()
    assert match.bus.failed == [] and "status" not in match.screen.failures
    page = match.screen.panes["status"].value
    assert all(
        f"{pane}: {type(error).__name__}" in page for pane, error in match.screen.failures.items()
    )


@cache
def long_lived():
    """One screen that hears everything strange, one message after the other."""
    return Match(states=WAYS)


def test_what_cannot_be_drawn_is_told_in_the_status_bar_and_the_rest_is_drawn(match):
    match.say("/observation", seen()).pose(1.0, 1.0)
    match.say("/plan", messages.Path(0.0, np.array([["a <b>", "b"]])))
    match.screen.draw()
    assert "map: ValueError: /plan: xy: expected numbers" in match.screen.panes["status"].value
    assert "ticks" in match.screen.panes["sensors"].value
    match.say("/plan", messages.Path(0.0, np.ones((2, 2))))
    assert "ValueError" not in match.pane("status"), "the next good message heals it"


def test_a_score_that_cannot_be_read_leaves_the_rest_of_the_status_bar(match):
    match.say("/score", messages.Score(0.0, "many", 0, None))
    match.screen.draw()
    words = match.screen.panes["status"].value
    assert "connected" in words and "status: ValueError: could not convert" in words


def test_a_message_that_cannot_be_read_is_one_line_of_the_log_however_often_it_comes(match):
    for _ in range(50):
        match.say("/odom", "here")
    assert match.text("events").count("/odom cannot be read: AttributeError") == 1
    assert "1 error" in match.text("status")


def test_the_driven_path_keeps_a_point_every_few_centimetres(match):
    for k in range(101):
        match.pose(1.0 + 0.01 * k, 1.0, time=k / 100)
    trail = list(match.screen.inbox.trail)
    steps = np.diff([x for x, _ in trail])
    assert 20 < len(trail) < 30 and steps.min() > 0.039 and steps.max() < 0.06


@pytest.mark.parametrize("last", [2.0, 104.0])
def test_a_robot_that_is_switched_on_anew_begins_a_new_path(match, last):
    for k in range(5):
        match.pose(1.0 + 0.1 * k, 1.0, time=last - 0.1 * (4 - k))
    match.pose(1.5, 1.0, time=last - 0.5)  # an older one that was late
    assert len(match.screen.inbox.trail) == 6
    match.pose(0.5, 0.3, time=0.0)
    assert list(match.screen.inbox.trail) == [(0.5, 0.3)] and match.screen.inbox.now() == 0.0


# --- what is told -----------------------------------------------------------------------------


def test_start_tells_what_is_chosen_and_then_starts(match):
    match.controls.colour.value = "blue"
    match.controls.side.value = "right"
    match.told.clear()
    match.controls.start.click()
    assert match.buttons() == [("colour", "blue"), ("side", "right"), ("start", "")]


def test_a_half_that_the_robot_does_not_play_in_is_not_shown_as_chosen(match):
    match.controls.side.value = "right"
    match.controls.refresh()
    assert match.controls.side.value == "right", "nobody objected"
    match.say("/operator", messages.Button("side", "left"))
    match.told.clear()
    match.controls.refresh()
    assert match.controls.side.value == "left" and ("side", "left") not in match.buttons()


def test_stop_and_retry_are_told(match):
    match.started().told.clear()
    match.controls.retry.click()
    match.controls.stop.click()
    assert match.buttons() == [("retry", ""), ("stop", "")]


def test_what_a_button_causes_comes_after_it_in_the_log(match):
    def robot(topic, button):
        if button.name == "start":
            match.say("/mission/state", messages.State(0.0, "drive", "start"))

    match.bus.subscribe("/operator", robot)
    match.controls.start.click()
    lines = [(entry.level, entry.text) for entry in match.screen.inbox.entries]
    assert lines[-2:] == [("operator", "start"), ("state", "drive: start")]
    assert lines.count(("operator", "start")) == 1


def disabled(match):
    match.screen.draw()
    names = ("start", "stop", "retry", "colour", "side", "manual", "intake", "release", "pan")
    return {name for name in names if getattr(match.controls, name).disabled}


def test_buttons_that_make_no_sense_cannot_be_pressed(match):
    by_hand = {"intake", "release", "pan"}
    assert disabled(match) == {"retry", "manual", *by_hand}, "no robot"
    match.say("/observation", seen())
    assert disabled(match) == {"retry", *by_hand}, "a robot that waits"
    match.controls.start.click()
    assert disabled(match) == {"start", "colour", "side", *by_hand}, "a match"
    match.controls.manual.value = True
    assert disabled(match) == {"start", "colour", "side"}
    match.clock.now += 5.0
    assert disabled(match) == {"start", "retry", "colour", "side", *by_hand}, "lost; stop works"
    match.say("/score", messages.Score(180.0, 1, 0, 0.0, "own", "time"))
    assert disabled(match) == {"retry"}, "the match is over"


def test_another_screen_s_start_counts_here_too(match):
    match.say("/observation", seen()).say("/operator", messages.Button("start"))
    assert "start" in disabled(match)
    match.say("/operator", messages.Button("stop"))
    assert "start" not in disabled(match)


def test_by_hand_the_stick_is_told_at_once_and_at_every_picture(match):
    match.by_hand()
    match.controls.sliders[0].value = 1.0
    assert match.heard("/cmd_vel")[-1] == messages.Twist(1.0, 0.0, 0.0)
    count = len(match.heard("/cmd_vel"))
    match.screen.draw()
    assert match.heard("/cmd_vel")[count:] == [messages.Twist(1.0, 0.0, 0.0)]


def test_who_does_not_drive_by_hand_tells_no_speed(match):
    match.say("/observation", seen())
    match.screen.draw()
    match.controls.sliders[0].value = 1.0
    match.controls.pan.value = 30
    match.screen.draw()
    assert match.heard("/cmd_vel") == [] and match.buttons() == []


def test_taking_over_and_handing_back_both_stand_still(match):
    match.say("/observation", seen())
    match.screen.draw()
    match.controls.sliders[0].value = 1.0
    match.controls.manual.value = True
    assert {*match.heard("/cmd_vel")} == {messages.Twist(0.0, 0.0, 0.0)}
    match.controls.sliders[1].value = -1.0
    match.controls.manual.value = False
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0)
    aimed = [("pan", 0.0), ("tilt", 0.0)]
    assert match.buttons() == [("manual", "on"), *aimed, ("manual", "off")]


def test_who_takes_over_has_the_camera_that_is_shown_and_rollers_that_stand(match):
    match.say("/observation", seen()).say("/command", SimpleNamespace(pan=0.5, tilt=0.3))
    match.screen.draw()
    match.controls.manual.value = True
    match.controls.intake.label = "in"
    match.controls.manual.value = False
    assert match.controls.intake.label == "hold"
    asked = match.buttons()
    aimed = pytest.approx(0.5, abs=0.01), pytest.approx(0.3, abs=0.01)
    assert asked[:3] == [("manual", "on"), ("pan", aimed[0]), ("tilt", aimed[1])]
    assert asked[3:] == [("intake", 1.0), ("manual", "off"), ("intake", 0.0)]


@pytest.mark.parametrize("name", ["stop", "set_up"])
def test_who_is_stopped_or_set_up_anew_is_not_driven_by_hand_any_more(match, name):
    match.by_hand().say("/operator", messages.Button(name, "red"))
    assert "automatic" in match.text("status") and not match.controls.manual.value
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0)


@pytest.mark.parametrize("value", ["on", True, 1.0])  # a log keeps a number
def test_taking_over_is_told_in_words_or_as_a_truth(match, value):
    match.by_hand().say("/operator", messages.Button("manual", value))
    assert "manual" in match.text("status") and match.controls.manual.value


def test_the_stop_button_ends_driving_by_hand(match):
    match.by_hand().controls.stop.click()
    assert not match.controls.manual.value
    assert match.buttons() == [("stop", ""), ("manual", "off")]


def test_the_team_that_was_set_up_is_the_one_that_is_shown_and_a_choice_after_it_stays():
    bus = Bus()
    bus.publish("/operator", messages.Button("set_up", "blue 0.0 0.0 0.0 0.0 1 1"))
    told = []
    bus.subscribe("/operator", lambda topic, message: told.append(message.name))
    screen = Dashboard(bus, clock=Clock())
    screen.draw()
    assert screen.controls.colour.value == "blue" and told == []
    screen.controls.colour.value = "red"
    screen.draw()
    assert screen.controls.colour.value == "red" and told == ["colour"]
    bus.publish("/operator", messages.Button("set_up", "blue 0.0 0.0 0.0 0.0 1 1"))
    bus.publish("/operator", messages.Button("set_up", "green"))
    screen.draw()
    assert screen.controls.colour.value == "red", "the last one is no team"
    assert "set_up blue<" in screen.panes["events"].value


def test_stop_lets_the_stick_go(match):
    match.by_hand().controls.sliders[2].value = 2.0
    match.controls.stop.click()
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0)
    assert [slider.value for slider in match.controls.sliders] == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("axes", "twist"),
    [
        ((0.0, -1.0, 0.0, 0.0), (2.0, 0.0, 0.0)),
        ((-1.0, 0.0, 1.0, 0.0), (0.0, 2.0, -3.0)),
        ((0.14, -0.14, 0.149, 0.0), (0.0, 0.0, 0.0)),
        ((0.16, 0.0, 0.0, 0.0), (0.0, -0.32, 0.0)),
        ((0.0,), (0.0, 0.0, 0.0)),
    ],
)
def test_a_gamepad_s_sticks_are_a_twist_with_a_dead_zone(match, axes, twist):
    assert pushed(axes) == pytest.approx(twist)
    match.by_hand()
    match.controls.pad = SimpleNamespace(axes=[SimpleNamespace(value=axis) for axis in axes])
    match.controls._stick_moved(None)
    assert match.heard("/cmd_vel") == [pytest.approx(twist)]


def test_a_gamepad_moves_nothing_that_is_not_driven_by_hand(match):
    match.controls.pad = SimpleNamespace(axes=[SimpleNamespace(value=1.0)] * 4)
    match.controls._stick_moved(None)
    assert match.heard("/cmd_vel") == []


def test_a_key_drives_as_long_as_it_repeats(match):
    match.by_hand()
    for held in ("w", "ww", "www"):
        match.controls.keys.value = held
        match.clock.now += 0.4
        match.say("/observation", seen(match.clock.now))
        match.screen.draw()
        assert match.heard("/cmd_vel")[-1] == messages.Twist(0.5 * LIMITS[0], 0.0, 0.0)
    match.clock.now += 0.4
    match.screen.draw()
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0)
    assert match.controls.keys.value == ""


@pytest.mark.parametrize(
    ("key", "share"),
    [("s", (-1, 0, 0)), ("A", (0, 1, 0)), ("d", (0, -1, 0)), ("q", (0, 0, 1)), ("e", (0, 0, -1))],
)
def test_each_key_has_its_direction_and_others_have_none(match, key, share):
    match.by_hand().controls.keys.value = f"x{key}"
    assert match.heard("/cmd_vel")[-1] == messages.Twist(*np.multiply(share, LIMITS) / 2)
    match.controls.keys.value += " "
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0), "the space bar halts"
    count = len(match.heard("/cmd_vel"))
    match.controls.keys.value += "x"
    assert len(match.heard("/cmd_vel")) == count


def test_a_stick_that_nobody_touches_or_no_robot_hears_goes_back_to_the_middle(match):
    match.by_hand().controls.sliders[0].value = 1.0
    for _ in range(9):
        match.clock.now += 1.0
        match.say("/observation", seen(match.clock.now))
        match.screen.draw()
    assert match.controls.sliders[0].value == 1.0
    match.clock.now += 1.5
    match.say("/observation", seen(match.clock.now))
    match.screen.draw()
    assert match.controls.sliders[0].value == 0.0 and match.heard("/cmd_vel")[-1].vx == 0.0
    match.controls.sliders[0].value = 1.0
    match.clock.now += 2.0
    match.screen.draw()
    assert match.controls.sliders[0].value == 0.0, "lost"


def test_gripper_and_camera_are_told_in_the_robot_s_units(match):
    match.by_hand()
    controls = match.controls
    controls.intake.label = "in"
    controls.intake.label = "out"
    controls.release.click()
    controls.pan.value, controls.tilt.value = 90, -10
    names = [
        ("intake", 1.0),
        ("intake", -1.0),
        ("intake", 0.0),
        ("release", ""),
        ("pan", pytest.approx(np.pi / 2)),
        ("tilt", pytest.approx(-0.1745, abs=1e-3)),
    ]
    assert match.buttons() == names


def test_the_sliders_follow_a_camera_that_the_robot_aims(match):
    match.say("/observation", seen()).say("/command", SimpleNamespace(pan=0.5, tilt=9.0))
    match.screen.draw()
    assert match.controls.pan.value == 29 and match.controls.tilt.value == match.controls.tilt.max
    assert match.buttons() == []


@pytest.mark.parametrize("seed", range(2))
def test_in_whatever_order_buttons_are_pressed_screen_and_match_agree(monkeypatch, seed):
    """Start, stop, retry, colour and driving by hand: twice, before a start, after the end."""
    monkeypatch.setattr("robocon_course.simulator.match.MATCH", 1.5)
    rng, bus = np.random.default_rng(seed), Bus()
    play = Play(seed=seed, opponent=None, bus=bus)
    screen = Dashboard(bus, clock=lambda: play.match.robot.time)
    controls, done = screen.controls, set()

    def other(toggle, values):
        toggle.value = values[toggle.value == values[0]]

    presses = {
        "start": controls.start.click, "stop": controls.stop.click, "retry": controls.retry.click,
        "colour": lambda: other(controls.colour, ("red", "blue")),
        "manual": lambda: other(controls.manual, (False, True)),
        "release": controls.release.click, "intake": lambda: other(controls.intake, (0.0, 1.0)),
    }  # fmt: skip
    for name in rng.choice(list(presses), 60):
        for _ in range(int(rng.integers(1, 40))):
            if not play.match.over:
                play.tick()
        screen.draw()
        if not getattr(controls, name).disabled:
            presses[name]()
            done.add((str(name), play.match.started is None, play.match.over))
        screen.draw()
        assert bus.failed == [] and screen.failures == {}
        assert screen.inbox.running == (play.match.started is not None and not play.match.over
                                        and not play.pilot.stopped), name  # fmt: skip
        assert controls.manual.value == play._by_hand.on, name
        assert controls.colour.value == play._team, name
        if play.match.started is None:
            assert play._team == play.match.team == play.pilot.team
    assert len(done) > 6


# --- opening and closing ----------------------------------------------------------------------


def test_a_closed_screen_stands_still_listens_no_more_and_draws_no_more(match):
    match.by_hand().controls.sliders[0].value = 1.0
    match.screen.close()
    match.screen.close()
    assert match.heard("/cmd_vel")[-1] == messages.Twist(0.0, 0.0, 0.0)
    assert match.buttons() == [("manual", "off")]
    before = match.screen.panes["status"].value
    match.pose(1.0, 1.0)
    match.screen.draw()
    assert "/odom" not in match.screen.inbox.latest
    assert match.screen.panes["status"].value == before
    assert match.screen.widget.comm is None


def test_the_next_screen_on_a_bus_closes_the_one_before_and_goes_on_with_it():
    bus = Bus()
    first = dashboard(bus)
    bus.publish("/odom", messages.PoseStamped(3.0, np.array([1.0, 2.0, 0.0])))
    bus.publish("/rosout", messages.Log(3.0, "warning", "look out"))
    first.controls.start.click()
    second = dashboard(bus)
    assert first.closed and not second.closed and len(bus._listeners["*"]) == 1
    assert "look out" in second.panes["events"].value
    assert "1 warning<" in second.panes["status"].value
    assert second.controls.start.disabled, "the match runs on"
    second.close()


@pytest.fixture
def notebook(monkeypatch):
    """A kernel's shell, and what was sent to the page."""
    shell = InteractiveShell()
    sent = []
    monkeypatch.setattr("robocon_course.view.dashboard.screen.has_sliders", lambda: True)
    monkeypatch.setattr(
        "IPython.display.publish_display_data", lambda data, *a, **kw: sent.append(data)
    )
    yield sent
    shell.history_manager.end_session()


def test_in_a_notebook_a_task_draws_until_the_screen_is_closed(notebook):
    async def session():
        bus = Bus()
        screen = dashboard(bus, refresh=0.05)
        bus.publish("/odom", messages.PoseStamped(0.0, np.array([1.0, 2.0, 0.0])))
        for _ in range(100):
            await asyncio.sleep(0.01)
            if "y 2.00 m" in screen.panes["where"].value:
                break
        else:
            pytest.fail("nobody drew")
        screen.widget.close()  # as a page does whose output is thrown away
        await asyncio.wait_for(screen._task, 2.0)
        assert screen.closed and not bus._listeners["*"]

    asyncio.run(session())
    assert notebook[0]["text/plain"].startswith("Dashboard: status, map")


def test_without_a_running_loop_the_screen_is_drawn_by_hand(notebook):
    screen = dashboard(Bus())
    assert screen._task is None and "no robot" in screen.panes["status"].value
    screen.close()
