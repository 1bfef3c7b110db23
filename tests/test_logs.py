"""Match logs: what is written validates, and what is read equals what was told."""

from __future__ import annotations

import base64
import errno
import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mcap.reader import make_reader
from mcap.writer import Writer

from conftest import ROOT
from robocon_course.logs import LogError, MatchLog, Replay, foxglove, read_log, schemas, summary
from robocon_course.logs.kinds import KINDS
from robocon_course.robot import (
    Bus,
    Command,
    Frame,
    LidarReading,
    Observation,
    Robot,
    codec,
    messages,
)
from robocon_course.robot.text import from_text, to_text
from robocon_course.vision.classes import BALLS
from robocon_course.vision.reading import Detections

PICTURE = np.random.default_rng(1).integers(0, 256, (24, 32, 3), np.uint8)
FOUND = Detections(
    np.array([[1.5, 2.25, 10.125, 20.1]], np.float32),
    np.array([0.87], np.float32),
    np.array([2], np.int64),
)


def seen(at: float = 1.23, **changes) -> Observation:
    """An observation with two IMU samples."""
    numbers = np.random.default_rng(7)
    usual = Observation(
        time=at,
        ticks=np.array([16741, -3, 2**40]),
        imu_time=np.array([at - 0.01, at]),
        gyro=numbers.normal(size=(2, 3)),
        accel=numbers.normal(size=(2, 3)),
        lidar=(
            LidarReading(at - 0.004, 4.44, 199, 25.0),
            LidarReading(at - 0.006, 0.0, 65535, 25.125),
        ),
        module_speeds=numbers.normal(size=4),
        module_angles=numbers.normal(size=4),
        battery=23.97,
        holding=True,
    )
    return usual._replace(**changes)


ASKED = Command([0.1, -0.2, 0.3, 1 / 3], [0.0, -0.0, 3.0, 1e-17], -1.0, True, 0.4, -0.1, "silo")

TOLD = {
    "/observation": seen(frame=Frame(1.1, 0.25, -0.5, PICTURE)),
    "/command": ASKED,
    "/odom": messages.PoseStamped(1.23, np.array([0.5, -0.25, 2.5])),
    "/ground_truth": messages.PoseStamped(1.23, np.array([0.5, -0.25, -3.0])),
    "/plan": messages.Path(1.23, np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 3.0]])),
    "/scan": messages.LaserScan(
        1.23, np.array([0.0, 1.5707, 3.1415, -1.5707]), np.array([4.44, 3.59, 0.0, 0.71])
    ),
    "/camera/image": messages.Image(1.1, PICTURE),
    "/camera/detections": messages.Detection2DArray(
        1.1, "ball", np.array([[1.5, 2.0, 10.0, 20.1]]), np.array([0.87]), ("red",)
    ),
    "/silos": messages.Silos(1.23, ("", "R", "RB", "RBR", "")),
    "/mission/state": messages.State(1.23, "fetch", "a ball lies there"),
    "/rosout": messages.Log(1.23, "warning", "ball was lost"),
    "/score": messages.Score(1.23, 120, 80, 178.77, "own", "Mua Vang"),
    "/cmd_vel": messages.Twist(0.5, -0.25, 0.1),
    "/operator": messages.Button("colour", "red"),
}


def written(path: Path, told) -> MatchLog:
    """A closed log of (topic, message)."""
    bus = Bus()
    with MatchLog(path) as log:
        log.listen(bus)
        for topic, message in told:
            bus.publish(topic, message)
    assert bus.failed == []
    return log


def same(one, other) -> bool:
    """Whether two messages are equal to the bit; a NaN equals every NaN."""
    if isinstance(one, Command):
        return same(vars(one), vars(other))
    if isinstance(one, dict):
        return set(one) == set(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray | list):
        one, other = np.asarray(one), np.asarray(other)
        bits = one.dtype.kind == "f" and ~np.isnan(one)
        equal = one.shape == other.shape and one.dtype == other.dtype
        return equal and np.array_equal(one, other, equal_nan=one.dtype.kind == "f") and (
            bits is False or np.array_equal(np.signbit(one[bits]), np.signbit(other[bits]))
        )  # fmt: skip
    if isinstance(one, tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    if hasattr(one, "items"):
        return same(dict(one), dict(other))
    if isinstance(one, float):
        return repr(float(one)) == repr(other)
    return type(one) is type(other) and one == other


# --- what comes back ------------------------------------------------------------------------------


def test_a_log_gives_back_what_was_told_in_its_order(tmp_path):
    log = written(tmp_path / "m.mcap", TOLD.items())
    back = list(read_log(tmp_path / "m.mcap"))
    assert [topic for topic, _ in back] == list(TOLD)
    assert [type(message) for _, message in back] == [type(message) for message in TOLD.values()]
    assert set(map(type, TOLD.values())) == set(KINDS), "every kind of message has its turn"
    assert sum(log.kept.values()) == len(TOLD) and not log.left_out and not log.thinned
    assert [path.name for path in tmp_path.iterdir()] == ["m.mcap"]


@pytest.mark.parametrize(
    "topic",
    ["/observation", "/command", "/silos", "/mission/state", "/score", "/cmd_vel", "/operator",
     "/plan", "/scan", "/camera/detections", "/rosout"],
)  # fmt: skip
def test_a_message_comes_back_to_the_bit(tmp_path, topic):
    written(tmp_path / "m.mcap", [(topic, TOLD[topic])])
    assert same(TOLD[topic], dict(read_log(tmp_path / "m.mcap"))[topic])


@pytest.mark.parametrize("yaw", [0.0, 1.0, -3.0, np.pi, 3.5, -7.0])
def test_a_pose_comes_back_with_its_heading_between_minus_pi_and_pi(tmp_path, yaw):
    written(
        tmp_path / "m.mcap", [("/odom", messages.PoseStamped(2.5, np.array([1 / 3, 2.0, yaw])))]
    )
    ((_, back),) = read_log(tmp_path / "m.mcap")
    assert back.time == 2.5 and back.pose[:2].tolist() == [1 / 3, 2.0]
    assert abs(back.pose[2]) <= np.pi
    assert np.exp(1j * back.pose[2]) == pytest.approx(np.exp(1j * yaw))


def test_a_picture_on_its_topic_comes_back_nearly(tmp_path):
    smooth = np.add.outer(np.arange(48), np.arange(64))[..., None].repeat(3, 2).astype(np.uint8)
    written(tmp_path / "m.mcap", [("/camera/image", messages.Image(1.0, smooth))])
    ((_, back),) = read_log(tmp_path / "m.mcap")
    assert back.image_bgr.shape == smooth.shape
    assert np.abs(back.image_bgr.astype(int) - smooth).mean() < 3.0


def test_a_button_may_carry_a_number(tmp_path):
    told = [("/operator", messages.Button("pan", 0.25)), ("/operator", messages.Button("start"))]
    written(tmp_path / "m.mcap", told)
    assert [message for _, message in read_log(tmp_path / "m.mcap")] == [m for _, m in told]


FLOATS = st.floats(width=64)
SHARES = st.floats(0, 1, width=32)


def arrays(*shape: int) -> st.SearchStrategy:
    return hnp.arrays(np.float64, shape, elements=FLOATS)


@st.composite
def frames(draw) -> Frame:
    shape = st.tuples(st.integers(1, 6), st.integers(1, 6), st.just(3))
    picture = draw(st.none() | hnp.arrays(np.uint8, shape))
    count = draw(st.integers(0, 3))
    box = hnp.arrays(np.float32, (count, 4), elements=st.floats(0, 1000, width=32))
    found = Detections(
        draw(box),
        draw(hnp.arrays(np.float32, count, elements=SHARES)),
        draw(hnp.arrays(np.int64, count, elements=st.integers(0, len(BALLS) - 1))),
    )
    kinds = draw(st.sampled_from([{}, {"ball": found}, {"silo": found}]))
    return Frame(draw(FLOATS), draw(FLOATS), draw(FLOATS), picture, kinds)


READINGS = st.builds(LidarReading, FLOATS, FLOATS, st.integers(0, 65535), FLOATS)


@st.composite
def observations(draw) -> Observation:
    count = draw(st.integers(0, 4))
    return Observation(
        draw(FLOATS),
        draw(hnp.arrays(np.int64, draw(st.sampled_from([2, 3])))),
        draw(arrays(count)),
        draw(arrays(count, 3)),
        draw(arrays(count, 3)),
        draw(st.lists(READINGS, max_size=4).map(tuple)),
        draw(arrays(4)),
        draw(arrays(4)),
        draw(FLOATS),
        draw(st.booleans()),
        draw(st.none() | frames()),
    )


COMMANDS = st.builds(
    Command, arrays(4), arrays(4), FLOATS, st.booleans(), FLOATS, FLOATS, st.text(max_size=5)
)


@settings(deadline=None)
@given(observations())
def test_every_observation_survives_its_json_and_validates(observation):
    text = to_text(codec.encode_observation(observation))
    assert same(observation, codec.decode_observation(from_text(text)))
    validator(schemas.OBSERVATION["title"]).validate(json.loads(text))


@settings(deadline=None)
@given(COMMANDS)
def test_every_command_survives_its_json_and_validates(command):
    text = to_text(codec.encode_command(command))
    assert same(command, codec.decode_command(from_text(text)))
    validator(schemas.COMMAND["title"]).validate(json.loads(text))


def test_the_json_of_a_command_by_hand():
    text = to_text(codec.encode_command(Command([1, 2, 3, np.nan], [0.5, 0, np.inf, -np.inf])))
    assert json.loads(text)["modules"] == [
        {"speed": 1.0, "angle": 0.5},
        {"speed": 2.0, "angle": 0.0},
        {"speed": 3.0, "angle": np.inf},
        {"angle": -np.inf},
    ]
    assert b'"angle":1e999' in text and b"NaN" not in text and b"Infinity" not in text


# --- what is in the file --------------------------------------------------------------------------

ALL = {
    form["title"]: form
    for room in (foxglove, schemas)
    for form in (getattr(room, name) for name in room.__all__)
    if isinstance(form, dict)
}


@cache
def validator(name: str) -> jsonschema.Validator:
    """Checks objects by a schema, and has checked the schema."""
    jsonschema.Draft202012Validator.check_schema(ALL[name])
    return jsonschema.Draft202012Validator(ALL[name])


@pytest.fixture(scope="module")
def everything(tmp_path_factory) -> list:
    """Schema, channel, message and object of a log with a message of each kind."""
    path = tmp_path_factory.mktemp("log") / "m.mcap"
    found = TOLD | {"/observation": seen(frame=Frame(1.1, 0.0, 0.0, None, {"ball": FOUND}))}
    written(path, found.items())
    with path.open("rb") as file:
        whole = list(make_reader(file, validate_crcs=True).iter_messages(log_time_order=False))
    return [(*parts, json.loads(parts[2].data)) for parts in whole]


def test_every_message_validates_against_the_schema_in_the_file(everything):
    names = set()
    for schema, channel, message, tree in everything:
        assert (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
        assert json.loads(schema.data) == ALL[schema.name]
        validator(schema.name).validate(tree)
        assert message.log_time == message.publish_time
        names.add(schema.name)
    assert names == set(ALL)


def test_a_message_with_a_field_too_few_would_be_found(everything):
    for schema, _, _, tree in everything:
        for name in ALL[schema.name].get("required", []):
            rest = {key: value for key, value in tree.items() if key != name}
            assert not validator(schema.name).is_valid(rest)


def test_each_topic_has_the_schema_that_viewers_draw(everything):
    found = {channel.topic: schema.name for schema, channel, _, _ in everything}
    assert found["/odom"] == found["/ground_truth"] == "foxglove.PoseInFrame"
    assert found["/plan"] == "foxglove.PosesInFrame" and found["/rosout"] == "foxglove.Log"
    assert found["/tf"] == "foxglove.FrameTransform"
    assert found["/camera/image"] == "foxglove.CompressedImage"
    assert found["/camera/detections"] == "foxglove.ImageAnnotations"
    beams = {topic for topic, name in found.items() if name == "foxglove.LaserScan"}
    assert beams == {"/scan/front", "/scan/left", "/scan/rear", "/scan/right"}
    assert {name for topic, name in found.items() if topic in ("/observation", "/command")} == {
        "robocon.Observation", "robocon.Command"
    }  # fmt: skip


def test_the_robots_frame_lies_in_the_map_where_the_pose_says(everything):
    moved = {t["child_frame_id"]: t for s, _, _, t in everything if "child_frame_id" in t}
    assert set(moved) == {"base", "base_true"}
    assert moved["base"]["parent_frame_id"] == "map"
    assert moved["base"]["translation"] == {"x": 0.5, "y": -0.25, "z": 0.0}
    turn = moved["base"]["rotation"]
    assert 2.0 * np.arctan2(turn["z"], turn["w"]) == pytest.approx(2.5)


def test_a_beam_starts_at_its_sensor_and_can_be_drawn(everything):
    beams = {c.topic: tree for s, c, _, tree in everything if s.name == "foxglove.LaserScan"}
    front, rear = beams["/scan/front"], beams["/scan/rear"]
    assert front["pose"]["position"] == {"x": 0.31, "y": 0.14, "z": 0.05}
    assert front["frame_id"] == "base" and front["ranges"] == [4.44, 4.44]
    step = (front["end_angle"] - front["start_angle"]) / (len(front["ranges"]) - 1)
    assert step == 0.0, "a viewer divides by the number of distances less one"
    assert len(front["intensities"]) == len(front["ranges"])
    assert rear["ranges"] == [], "nothing is drawn where the sensor does not trust itself"


def test_a_picture_in_an_observation_is_its_png():
    tree = codec.encode_observation(seen(frame=Frame(1.1, 0.0, 0.0, PICTURE)))
    assert base64.b64decode(tree["frame"]["png"]).startswith(b"\x89PNG")


def test_messages_without_a_time_get_the_latest_one(everything):
    times = {channel.topic: message.log_time for _, channel, message, _ in everything}
    assert times["/cmd_vel"] == times["/operator"] == times["/command"] == 1_230_000_000
    assert times["/camera/image"] == 1_100_000_000


def unread_by_viewers(form: dict, name: str = "") -> list[str]:
    """Places of a schema that Foxglove's viewers refuse (Lichtblick, parseJsonSchema.ts)."""
    kind = form.get("type")
    if kind == "object":
        inner = form.get("properties") or {"": {}}
        return [place for key, one in inner.items() for place in unread_by_viewers(one, key)]
    if kind == "array":
        items = form["items"]
        nested = items.get("type") == "array" or "contentEncoding" in items
        return [name] if nested else unread_by_viewers(items, name)
    return [] if kind in ("boolean", "string", "number", "integer") else [name]


@pytest.mark.parametrize("name", ALL)
def test_viewers_understand_a_schema(name):
    assert ALL[name]["type"] == "object" and unread_by_viewers(ALL[name]) == []


def test_what_viewers_refuse_would_be_found():
    rows = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}
    either = {"type": ["number", "null"]}
    form = {"type": "object", "properties": {"rows": rows, "either": either, "empty": {}}}
    assert unread_by_viewers(form) == ["rows", "either", "empty"]


@pytest.mark.parametrize("name", [name for name in ALL if name.startswith("robocon.")])
def test_an_own_schema_says_which_json_schema_it_is(name):
    assert ALL[name]["$schema"] == "https://json-schema.org/draft/2020-12/schema"


# --- thinning, and what cannot be written ---------------------------------------------------------


STAMPED = ("/odom", "/ground_truth", "/scan", "/camera/image", "/mission/state")


def test_poses_and_beams_are_thinned_to_20_a_second_and_pictures_to_10(tmp_path):
    told = []
    for k in range(100):
        at = k / 100
        told += [("/observation", seen(at)), ("/command", ASKED)]
        told += [(topic, TOLD[topic]._replace(time=at)) for topic in STAMPED]
    log = written(tmp_path / "m.mcap", told)
    assert log.kept == {
        "/observation": 100, "/command": 100, "/odom": 20, "/ground_truth": 20, "/scan": 20,
        "/camera/image": 10, "/mission/state": 100,
    }  # fmt: skip
    assert log.thinned["/odom"] == 80 and log.thinned["/camera/image"] == 90
    found = summary(tmp_path / "m.mcap")
    assert found.topics == dict(log.kept) and found.duration == 0.99 and found.trouble == ""
    assert found.size == (tmp_path / "m.mcap").stat().st_size
    assert list(found.topics) == sorted(found.topics)


def test_what_has_no_time_is_on_the_clock_that_runs_now(tmp_path):
    told = []
    for at in (186.0, 185.92, 0.0, 0.01):  # a picture; then another match
        told += [("/observation", seen(at)), ("/command", ASKED)]
    written(tmp_path / "m.mcap", told)
    with (tmp_path / "m.mcap").open("rb") as stream:
        found = make_reader(stream).iter_messages(topics=["/command"], log_time_order=False)
        times = [message.log_time / 1e9 for _, _, message in found]
    assert times == [186.0, 186.0, 0.0, 0.01]


def test_a_clock_that_begins_anew_does_not_silence_a_topic(tmp_path):
    times = (100.0, 100.01, 0.0, 0.01, 0.05)
    told = [("/odom", messages.PoseStamped(at, np.zeros(3))) for at in times]
    written(tmp_path / "m.mcap", told)
    assert [m.time for _, m in read_log(tmp_path / "m.mcap")] == [100.0, 0.0, 0.05]


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("/odom", messages.PoseStamped(1.0, np.array([0.0, np.nan, 0.0]))),
        ("/odom", messages.PoseStamped(np.nan, np.zeros(3))),
        ("/plan", messages.Path(1.0, np.zeros((3, 3)))),
        ("/plan", messages.Path(np.inf, np.zeros((3, 2)))),
        ("/scan", messages.LaserScan(1.0, np.zeros(4), np.zeros(3))),
        ("/camera/image", messages.Image(1.0, np.zeros((4, 4)))),
        ("/camera/image", messages.Image(1.0, None)),
        ("/camera/detections", TOLD["/camera/detections"]._replace(labels=())),
        ("/command", Command([0.0] * 3, [0.0] * 4)),
        ("/command", Command("fast", [0.0] * 4)),
        ("/observation", seen(gyro=np.zeros((3, 3)))),
        ("/observation", seen(ticks=np.zeros(3))),
        ("/observation", seen(battery="low")),
        ("/score", messages.Score(1.0, None, 1, 2.0)),
        ("/mine", "a text"),
        ("/mine", {"time": 1.0}),
    ],
)
def test_what_cannot_be_written_is_counted_and_the_log_goes_on(tmp_path, topic, message):
    log = written(tmp_path / "m.mcap", [(topic, message), ("/rosout", TOLD["/rosout"])])
    assert log.left_out == {topic: 1} and log.kept == {"/rosout": 1}
    assert [t for t, _ in read_log(tmp_path / "m.mcap")] == ["/rosout"]


def test_a_broken_clock_does_not_lose_an_observation(tmp_path):
    broken = [seen(2.0), seen(np.nan), seen(-0.004), seen(np.inf)]
    written(tmp_path / "m.mcap", [("/observation", one) for one in broken])
    back = [message for _, message in read_log(tmp_path / "m.mcap")]
    assert same(tuple(broken), tuple(back))


def test_a_beam_that_is_not_finite_is_none(tmp_path):
    scan = messages.LaserScan(1.0, np.array([0.0, 1.0]), np.array([np.nan, np.inf]))
    written(tmp_path / "m.mcap", [("/scan", scan)])
    ((_, back),) = read_log(tmp_path / "m.mcap")
    assert back.ranges.tolist() == [0.0, 0.0] and back.angles.tolist() == [0.0, 1.0]


# --- opening, closing, being killed ---------------------------------------------------------------


def test_closing_twice_is_fine_and_afterwards_nothing_is_heard(tmp_path):
    bus, log = Bus(), MatchLog(tmp_path / "m.mcap")
    log.listen(bus)
    bus.publish("/rosout", TOLD["/rosout"])
    log.close()
    log.close()
    bus.publish("/rosout", TOLD["/rosout"])
    assert log.kept == {"/rosout": 1} and bus.failed == []
    with pytest.raises(LogError, match="is closed; open a new log"):
        log.write("/rosout", TOLD["/rosout"])


def test_an_exception_in_the_match_still_closes_its_log(tmp_path):
    with pytest.raises(RuntimeError), MatchLog(tmp_path / "m.mcap") as log:
        log.write("/rosout", TOLD["/rosout"])
        raise RuntimeError("the match broke")
    assert len(list(read_log(tmp_path / "m.mcap"))) == 1


def test_an_empty_log_can_be_read(tmp_path):
    MatchLog(tmp_path / "m.mcap").close()
    assert list(read_log(tmp_path / "m.mcap")) == []
    assert summary(tmp_path / "m.mcap")[:2] == ({}, 0.0)


def test_a_place_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match="cannot be written"):
        MatchLog(tmp_path / "file" / "m.mcap")


def test_a_name_that_is_a_folder_leaves_the_part(tmp_path):
    (tmp_path / "m.mcap" / "inside").mkdir(parents=True)
    log = MatchLog(tmp_path / "m.mcap")
    log.write("/rosout", TOLD["/rosout"])
    with pytest.raises(LogError, match=r"was not finished: .* stays in m.mcap.part"):
        log.close()
    log.close()
    assert len(list(read_log(tmp_path / "m.mcap.part"))) == 1


def test_a_full_disk_ends_the_log_and_nothing_else(tmp_path, monkeypatch):
    bus, log = Bus(), MatchLog(tmp_path / "m.mcap")
    log.listen(bus)
    bus.publish("/rosout", TOLD["/rosout"])

    def full() -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(log, "_file", SimpleNamespace(closed=False, flush=full))
    bus.publish("/rosout", TOLD["/rosout"])
    bus.publish("/score", TOLD["/score"])
    assert [topic for topic, _ in bus.failed] == ["/rosout"] and bus.latest["/score"]


def test_a_disk_that_was_full_for_a_while_leaves_the_part_and_no_file(tmp_path, monkeypatch):
    log, full = MatchLog(tmp_path / "m.mcap"), OSError(errno.ENOSPC, "No space left on device")

    def add(*_: object) -> None:
        raise full

    log.write("/rosout", TOLD["/rosout"])
    with monkeypatch.context() as patch, pytest.raises(OSError, match="No space left"):
        patch.setattr(log._writer, "add_message", add)
        log.write("/rosout", TOLD["/rosout"])
    assert log.kept == {"/rosout": 1}
    with pytest.raises(LogError, match=r"m.mcap was not finished: No space left .* m.mcap.part"):
        log.close()
    log.close()
    assert os.listdir(tmp_path) == ["m.mcap.part"]


KILLED = """
import sys
from robocon_course.logs import MatchLog
from robocon_course.robot import Command
log = MatchLog(sys.argv[1])
for k in range(4000):
    log.write("/command", Command([k, 0.0, 0.0, 0.0], [0.0] * 4))
print("told", flush=True)
sys.stdin.read()
"""


def test_a_kill_leaves_no_file_and_a_part_that_can_be_read(tmp_path):
    path = tmp_path / "m.mcap"
    process = subprocess.Popen(
        [sys.executable, "-c", KILLED, str(path)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT,
    )  # fmt: skip
    assert process.stdout.readline() == b"told\n"
    process.kill()
    process.wait()
    process.stdin.close()
    process.stdout.close()
    assert os.listdir(tmp_path) == ["m.mcap.part"]
    log = read_log(tmp_path / "m.mcap.part")
    numbers = [message.speeds[0] for _, message in log]
    assert numbers == list(range(len(numbers))) and 2000 < len(numbers) < 4000
    assert log.trouble == (
        f"m.mcap.part is cut off or damaged; {len(numbers)} messages could be read"
    )
    assert summary(tmp_path / "m.mcap.part").topics == {"/command": len(numbers)}


def test_a_chunk_is_on_the_disk_as_soon_as_it_is_whole(tmp_path):
    line = messages.Log(1.0, "info", "the same " * 1000)  # which becomes very small
    with MatchLog(tmp_path / "m.mcap") as log:
        for _ in range(60):
            log.write("/rosout", line)
        assert len(list(read_log(log.part))) > 55


@pytest.fixture(scope="module")
def long_log(tmp_path_factory) -> bytes:
    """The bytes of a log of several chunks."""
    path = tmp_path_factory.mktemp("log") / "m.mcap"
    written(path, [("/observation", seen(k / 100)) for k in range(900)])
    return path.read_bytes()


SHORT = [seen(k / 100, battery=20.0 + k) for k in range(10)]


@pytest.fixture(scope="module")
def short_log(tmp_path_factory) -> tuple[Path, bytes]:
    """A place for a file, and the bytes of a log of one chunk."""
    path = tmp_path_factory.mktemp("log") / "m.mcap"
    written(path, [("/observation", one) for one in SHORT])
    return path, path.read_bytes()


@pytest.mark.parametrize("share", [0.3, 0.5, 0.7, 0.9, 0.999])
def test_a_file_that_is_cut_off_gives_what_is_whole(tmp_path, long_log, share):
    path = tmp_path / "cut.mcap"
    path.write_bytes(long_log[: int(share * len(long_log))])
    log = read_log(path)
    back = [message.time for _, message in log]
    assert back == [k / 100 for k in range(len(back))]
    assert log.count == len(back) and f"{len(back)} messages could be read" in log.trouble
    assert len(back) > 900 * share - 450, "two chunks at most are lost"
    again = [message.time for _, message in log]
    assert again == back, "a log can be read again"


def test_a_scan_whose_beams_are_cut_off_is_none(tmp_path, monkeypatch):
    monkeypatch.setattr("robocon_course.logs.writer.CHUNK", 700)  # two beams and a bit
    told = [("/scan", TOLD["/scan"]._replace(time=k / 10)) for k in range(12)]
    written(tmp_path / "m.mcap", told)
    data, whole = (tmp_path / "m.mcap").read_bytes(), TOLD["/scan"].ranges.tolist()
    for end in range(100, len(data), 50):
        (tmp_path / "cut.mcap").write_bytes(data[:end])
        found = [message for _, message in read_log(tmp_path / "cut.mcap")]
        assert [one.ranges.tolist() for one in found] == [whole] * len(found)
    assert len(list(read_log(tmp_path / "m.mcap"))) == 12


@given(st.integers(0, 10**6), st.integers(0, 7))
def test_a_flipped_bit_never_changes_what_is_read(short_log, place, bit):
    path, whole = short_log
    data = bytearray(whole)
    data[120 + place % (len(data) - 120)] ^= 1 << bit
    path.write_bytes(data)
    log = read_log(path)
    back = [message for _, message in log]
    assert back == [] or same(tuple(back), tuple(SHORT))
    assert back or log.trouble


@given(st.integers(0, 120), st.integers(0, 7))
def test_no_bit_of_the_beginning_makes_a_reader_stumble(short_log, place, bit):
    path, whole = short_log
    data = bytearray(whole)
    data[place] ^= 1 << bit
    path.write_bytes(data)
    try:
        back = list(read_log(path))
    except LogError as error:
        assert str(path) in str(error)
    else:
        assert len(back) <= len(SHORT)


# --- replay ---------------------------------------------------------------------------------------


def played(path: Path) -> Path:
    """A log in which the speed told is the time seen."""
    told = [("/rosout", TOLD["/rosout"])]
    for k in range(5):
        told += [("/observation", seen(k / 10)), ("/odom", TOLD["/odom"]), ("/command", drive(k))]
    written(path, told)
    return path


def drive(k: int) -> Command:
    return Command(np.full(4, k / 10), np.zeros(4))


def test_a_replayed_log_is_a_robot_that_sees_and_is_told_the_same(tmp_path):
    robot = Replay(played(tmp_path / "m.mcap"))
    assert isinstance(robot, Robot)
    for k in range(5):
        assert not robot.ended
        assert same(robot.read(), seen(k / 10))
        assert robot.expected.speeds.tolist() == [k / 10] * 4
        robot.apply(Command([k / 10] * 4, [0.0] * 4))
    assert robot.ended and (robot.applied, robot.different) == (5, 0)
    again = robot.read()
    assert again.time == 0.4 and len(again.imu_time) == len(again.gyro) == 0
    assert robot.expected is None and robot.first_different is None


def test_a_replay_tells_from_when_on_commands_differ(tmp_path):
    robot = Replay(played(tmp_path / "m.mcap"))
    for k in range(5):
        robot.read()
        robot.apply(drive(k) if k != 2 else Command(np.full(4, np.nextafter(0.2, 1)), np.zeros(4)))
    assert (robot.applied, robot.different, robot.first_different) == (5, 1, 0.2)


def test_a_log_without_observations_cannot_be_replayed(tmp_path):
    written(tmp_path / "m.mcap", [("/rosout", TOLD["/rosout"])])
    with pytest.raises(LogError, match="holds no observations to replay"):
        Replay(tmp_path / "m.mcap")


# --- what is no log -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "data", [b"", b"time,x\n1,2\n", b"\x89MCAP0\r\n", b"\x89PNG\r\n\x1a\n" + bytes(300)]
)
@pytest.mark.parametrize("door", [read_log, summary])
def test_what_is_no_mcap_is_refused(tmp_path, data, door):
    path = tmp_path / "x.mcap"
    path.write_bytes(data)
    with pytest.raises(LogError, match=r"x\.mcap is no MCAP file, or ends within its first bytes"):
        door(path)


@pytest.mark.parametrize("door", [read_log, summary])
def test_a_file_that_is_not_there_is_refused(tmp_path, door):
    with pytest.raises(LogError, match="cannot be read: No such file"):
        door(tmp_path / "x.mcap")
    with pytest.raises(LogError, match="cannot be read"):
        door(tmp_path)


def foreign(path: Path, profile: str, library: str = "rosbag2") -> Path:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start(profile, library)
        writer.finish()
    return path


def test_a_log_of_another_program_is_refused_with_its_name(tmp_path):
    with pytest.raises(LogError, match="no match log of this course: it was written by rosbag2"):
        read_log(foreign(tmp_path / "x.mcap", "ros2"))


def test_a_log_of_a_newer_course_is_refused(tmp_path):
    with pytest.raises(LogError, match="written by a newer course; install that one"):
        read_log(foreign(tmp_path / "x.mcap", "robocon-2"))


def test_a_message_that_no_one_can_read_is_passed_over_and_counted(tmp_path):
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start("robocon-1", "")
        for name, data in [("Command", b"{}"), ("Later", b"{}"), ("Score", b"no"), ("Log", b"[1]")]:
            about = {"topic": "/x", "message": name}
            writer.add_message(writer.register_channel("/x", "json", 0, about), 0, data, 0)
        writer.finish()
    log = read_log(path)
    assert list(log) == [] and log.skipped >= 1 and log.trouble == ""


def test_without_the_library_a_log_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mcap", None)
    monkeypatch.setitem(sys.modules, "mcap.writer", None)
    with pytest.raises(LogError, match=r"pip install \"robocon-course\[logs\]\""):
        MatchLog(tmp_path / "m.mcap")
