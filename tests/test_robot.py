"""What autonomy and hardware agree on: sizes, commands, the LiDAR's nine bytes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course import robot
from robocon_course.robot import Command, LidarReading, decode_lidar, encode_lidar
from robocon_course.simulator import Simulator

# 123 cm, strength 1000, 25 deg C, as worked out by hand from the manual.
WORKED = bytes.fromhex("59 59 7B 00 E8 03 C8 08 E8")


def test_the_sizes_are_those_of_the_machine():
    assert (robot.SIDE, robot.MASS) == (0.65, 24.75)
    left, right, rear = robot.DEAD_WHEELS.positions
    assert left[1] - right[1] == pytest.approx(0.5377) and rear[0] == -0.2745
    assert robot.DEAD_WHEELS.radius.tolist() == [0.0296028] * 3
    assert robot.DEAD_WHEELS.ticks_per_turn == 4 * 800


def test_modules_run_counter_clockwise_from_the_front_left():
    angles = np.arctan2(robot.MODULES[:, 1], robot.MODULES[:, 0])
    np.testing.assert_allclose(np.degrees(angles), [45.0, 135.0, -135.0, -45.0])


def test_everything_mounted_lies_on_the_body():
    spots = [robot.MODULES, robot.DEAD_WHEELS.positions, [(m.x, m.y) for m in robot.LIDARS]]
    assert np.abs(np.concatenate(spots)).max() < robot.SIDE / 2


def test_each_lidar_looks_away_from_the_robot():
    for mount in robot.LIDARS:
        assert mount.x * np.cos(mount.angle) + mount.y * np.sin(mount.angle) > 0.3


def test_the_simulator_is_a_robot():
    assert isinstance(Simulator(), robot.Robot)
    assert not isinstance(object(), robot.Robot)


def test_stop_asks_every_wheel_for_nothing():
    speeds, angles = Command.stop([0.1, 0.2, 0.3, 0.4]).checked()
    assert speeds.tolist() == [0.0] * 4 and angles.tolist() == [0.1, 0.2, 0.3, 0.4]
    assert Command.stop().checked()[1].tolist() == [0.0] * 4


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (Command([1.0] * 3, [0.0] * 4), r"command.speeds: expected shape \(4,\)"),
        (Command([1.0] * 4, [[0.0] * 4]), r"command.angles: expected shape \(4,\)"),
        (Command([1.0, 1.0, np.nan, 1.0], [0.0] * 4), "command.speeds: entry .* is not a finite"),
        (Command([1.0] * 4, [0.0, np.inf, 0.0, 0.0]), "command.angles: entry .* is not a finite"),
        (Command("fast", [0.0] * 4), "command.speeds: expected numbers"),
    ],
)
def test_a_wrong_command_is_refused_with_its_place(command, message):
    with pytest.raises(ValueError, match=message):
        command.checked()


# --- the frame -----------------------------------------------------------------------------------

READINGS = st.builds(
    LidarReading,
    time=st.just(7.5),
    distance=st.integers(0, 65535).map(lambda n: n / 100),
    strength=st.integers(100, 65534),
    temperature=st.integers(0, 65535).map(lambda n: n / 8 - 256),
)


def test_the_worked_frame_is_made_and_read():
    reading = LidarReading(0.0, 1.23, 1000, 25.0)
    assert encode_lidar(reading) == WORKED
    assert decode_lidar(WORKED) == ([reading], 0, b"")


@given(st.lists(READINGS, max_size=5))
def test_what_is_encoded_is_decoded_to_the_bit(readings):
    stream = b"".join(encode_lidar(reading) for reading in readings)
    assert decode_lidar(stream, time=7.5) == (readings, 0, b"")


@given(st.lists(READINGS, min_size=1, max_size=4), st.lists(st.integers(0, 40), max_size=4))
def test_a_stream_may_arrive_in_any_pieces(readings, cuts):
    stream = b"".join(encode_lidar(reading) for reading in readings)
    found, rest, bad = [], b"", 0
    edges = sorted(min(cut, len(stream)) for cut in cuts)
    for start, end in zip([0, *edges], [*edges, len(stream)], strict=True):
        part, wrong, rest = decode_lidar(rest + stream[start:end], time=7.5)
        found, bad = found + part, bad + wrong
    assert found == readings and rest == b"" and bad == 0


@given(st.binary(max_size=40).map(lambda b: b.replace(b"Y", b"")), READINGS)
def test_noise_before_a_frame_is_passed_over(noise, reading):
    assert decode_lidar(noise + encode_lidar(reading), time=7.5) == ([reading], 0, b"")


@pytest.mark.parametrize("noise", [b"Y", b"YY", b"YYY", b"YY\x01\x02", WORKED[:8], WORKED[:3]])
def test_what_looks_like_a_head_before_a_frame_does_not_hide_it(noise):
    found = decode_lidar(noise + WORKED)
    assert len(found.readings) == 1 and found.rest == b""


def test_joining_a_stream_in_the_middle_of_a_frame_loses_that_frame_only():
    stream = WORKED[4:] + WORKED + WORKED
    assert len(decode_lidar(stream).readings) == 2


def test_a_flipped_bit_is_counted_and_skipped():
    broken = bytearray(WORKED * 3)
    broken[9 + 2] ^= 0x10
    found = decode_lidar(bytes(broken))
    assert len(found.readings) == 2 and found.bad == 1 and found.rest == b""


def test_a_head_inside_a_frame_is_no_head():
    reading = LidarReading(0.0, 0x5959 / 100, 0x5959, 25.0)
    stream = encode_lidar(reading) * 3
    assert decode_lidar(stream).readings == [reading] * 3
    assert decode_lidar(stream[1:]).readings == [reading] * 2


@pytest.mark.parametrize(
    ("strength", "distance"), [(99, 0.0), (100, 1.5), (65534, 1.5), (65535, 0)]
)
def test_a_strength_that_cannot_be_trusted_makes_the_distance_nothing(strength, distance):
    frame = encode_lidar(LidarReading(0.0, 1.5, strength, 25.0))
    assert decode_lidar(frame).readings[0].distance == distance


def test_a_sensor_set_to_millimetres_is_told_by_its_steps():
    reading = LidarReading(0.0, 1.235, 1000, 25.0)
    frame = encode_lidar(reading, per_metre=1000)
    assert decode_lidar(frame, per_metre=1000).readings == [reading]


@pytest.mark.parametrize(
    ("reading", "name"),
    [
        (LidarReading(0.0, 700.0, 1000, 25.0), "distance"),
        (LidarReading(0.0, float("nan"), 1000, 25.0), "distance"),
        (LidarReading(0.0, 1.0, -1, 25.0), "strength"),
        (LidarReading(0.0, 1.0, 70000, 25.0), "strength"),
        (LidarReading(0.0, 1.0, 1000, -300.0), "temperature"),
    ],
)
def test_what_does_not_fit_the_frame_is_refused(reading, name):
    with pytest.raises(ValueError, match=f"reading.{name}: .* does not fit the frame"):
        encode_lidar(reading)
