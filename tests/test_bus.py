"""The bus: who tells, who listens, and that a listener stops nobody."""

from __future__ import annotations

import re

import pytest

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


def test_a_listener_that_stops_and_then_raises_disturbs_nobody():
    bus, stops = Bus(), []

    def broken(topic, message):
        stops[0]()
        raise ValueError("no screen")

    stops.append(bus.subscribe("/a", broken))
    heard, _ = heard_by(bus, "/a")
    bus.publish("/a", 1)
    assert [message for _, message in heard] == [1] and len(bus.failed) == 1


def test_a_listener_that_fails_at_what_it_told_itself_fails_twice_and_disturbs_nobody():
    bus = Bus()

    def broken(topic, message):
        if message:
            bus.publish("/a", message - 1)
        raise ValueError("no screen")

    bus.subscribe("/a", broken)
    heard, _ = heard_by(bus, "/a")
    bus.publish("/a", 1)
    assert [message for _, message in heard] == [0, 1] and len(bus.failed) == 2


def test_who_listens_twice_hears_twice_and_stops_each_by_itself():
    bus, heard = Bus(), []

    def listener(topic, message):
        heard.append(message)

    stop, _ = bus.subscribe("/a", listener), bus.subscribe("/a", listener)
    bus.publish("/a", 1)
    stop()
    stop()
    bus.publish("/a", 2)
    assert heard == [1, 1, 2]


def test_what_cannot_be_called_does_not_listen():
    with pytest.raises(ValueError, match="listener: expected a function, got list"):
        Bus().subscribe("/a", [])


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


def test_what_a_listener_tells_comes_before_what_made_it_speak():
    bus, heard = Bus(), []
    bus.subscribe("*", lambda topic, message: heard.append(topic))
    bus.subscribe("/a", lambda topic, message: bus.publish("/b", message))
    bus.publish("/a", 1)
    assert heard == ["/b", "/a"]


def test_every_message_of_the_table_is_a_type_with_its_time_or_none_by_nature():
    table = re.findall(r"^``/[a-z_/]+``\s+`(\w+)`", messages.__doc__, re.MULTILINE)
    assert len(table) == 14
    for name in set(table) - {"Observation", "Command"}:  # these are the robot's own
        fields = getattr(messages, name)._fields
        assert "time" in fields or name in ("Twist", "Button"), name
    assert Log(1.0, "info", "ready").text == "ready"
