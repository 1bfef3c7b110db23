"""The bus: who tells, who listens, and that a listener stops nobody."""

from __future__ import annotations

import re

from robocon_course.robot import Bus, messages
from robocon_course.robot.messages import Log


def heard_by(bus: Bus, topic: str) -> tuple[list, object]:
    heard: list = []
    return heard, bus.subscribe(topic, lambda topic, message: heard.append((topic, message)))


def test_who_listens_to_a_topic_hears_all_of_it_in_order_and_nothing_else():
    bus = Bus()
    heard, _ = heard_by(bus, "/rosout")
    for k in range(3):
        bus.publish("/rosout", k)
        bus.publish("/odom", -k)
    assert heard == [("/rosout", 0), ("/rosout", 1), ("/rosout", 2)]


def test_the_star_hears_everything():
    bus = Bus()
    heard, _ = heard_by(bus, "*")
    bus.publish("/a", 1)
    bus.publish("/b", 2)
    assert heard == [("/a", 1), ("/b", 2)] and bus.latest == {"/a": 1, "/b": 2}


def test_who_has_stopped_listening_hears_no_more_and_may_stop_twice():
    bus = Bus()
    heard, stop = heard_by(bus, "/a")
    bus.publish("/a", 1)
    stop()
    stop()
    bus.publish("/a", 2)
    assert heard == [("/a", 1)]


def test_a_listener_that_raises_is_dropped_and_the_others_hear_on():
    bus, calls = Bus(), []

    def broken(topic, message):
        calls.append(message)
        raise ValueError("no screen")

    bus.subscribe("/a", broken)
    heard, _ = heard_by(bus, "/a")
    bus.publish("/a", 1)
    bus.publish("/a", 2)
    assert calls == [1] and [message for _, message in heard] == [1, 2]
    [(topic, error)] = bus.failed
    assert topic == "/a" and str(error) == "no screen"


def test_a_listener_that_stops_while_it_is_told_leaves_nobody_out():
    bus, heard = Bus(), []
    stops = []

    def once(topic, message):
        heard.append("once")
        stops[0]()

    stops.append(bus.subscribe("/a", once))
    bus.subscribe("/a", lambda topic, message: heard.append("always"))
    bus.publish("/a", 1)
    bus.publish("/a", 2)
    assert heard == ["once", "always", "always"]


def test_a_listener_may_tell_something_itself():
    bus = Bus()
    heard, _ = heard_by(bus, "/b")
    bus.subscribe("/a", lambda topic, message: bus.publish("/b", message + 1))
    bus.publish("/a", 1)
    assert heard == [("/b", 2)]


def test_every_message_of_the_table_is_a_type_with_its_time_or_none_by_nature():
    table = re.findall(r"^``/[a-z_/]+``\s+`(\w+)`", messages.__doc__, re.MULTILINE)
    assert len(table) == 14
    for name in set(table) - {"Observation", "Command"}:  # these are the robot's own
        fields = getattr(messages, name)._fields
        assert "time" in fields or name in ("Twist", "Button"), name
    assert Log(1.0, "info", "ready").text == "ready"
