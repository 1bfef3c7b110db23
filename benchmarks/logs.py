"""A match's log: how large it gets, what writing it takes of the match, and reading it back."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from robocon_course.logs import MatchLog, read_log, summary
from robocon_course.robot import Bus, Command, messages
from robocon_course.simulator import SensorModel, Simulator

SECONDS = 180.0
RATE = 100
"""Of observations and commands [Hz]; the IMU is set to twice that."""


def a_match(seconds: float) -> list[tuple[str, object]]:
    """What is told while the robot drives about with all sensors, without pictures."""
    robot, told = Simulator(sensors=SensorModel(imu_rate=250.0)), []
    for k in range(round(seconds * RATE)):
        robot.step(1.0 / RATE)
        seen, pose = robot.read(), robot.truth.pose
        turn = 0.4 * np.sin(0.7 * seen.time)
        command = Command(np.full(4, 0.8 * np.cos(0.9 * seen.time)), np.full(4, turn))
        robot.apply(command)
        beams = np.array([reading.distance for reading in seen.lidar])
        angles = np.array([0.0, np.pi / 2, np.pi, -np.pi / 2])
        told += [
            ("/observation", seen),
            ("/command", command),
            ("/odom", messages.PoseStamped(seen.time, pose)),
            ("/ground_truth", messages.PoseStamped(seen.time, pose)),
            ("/scan", messages.LaserScan(seen.time, angles, beams)),
        ]
        if k % 500 == 0:
            told.append(
                ("/plan", messages.Path(seen.time, np.random.default_rng(k).random((80, 2))))
            )
            told.append(("/mission/state", messages.State(seen.time, "drive", "there is a ball")))
    return told


def main(seconds: float = SECONDS) -> None:
    """Print the table."""
    told = a_match(seconds)
    seen = [message for topic, message in told if topic == "/observation"]
    count, samples = len(seen), sum(len(observation.imu_time) for observation in seen)
    with TemporaryDirectory() as folder:
        path, bus = Path(folder) / "match.mcap", Bus()
        start = process_time()
        with MatchLog(path) as log:
            log.listen(bus)
            for topic, message in told:
                bus.publish(topic, message)
        written = process_time()
        back = [message for topic, message in read_log(path) if topic == "/observation"]
        read = process_time()
        found = summary(path)
        summed = process_time()
    for one, other in zip(seen, back, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(one[:5], other[:5], strict=True))
    print(f"{seconds:g} s, {count} observations with {samples / count:.1f} IMU samples each")
    print(f"  told {len(told)}, kept {sum(found.topics.values())} messages")
    print(f"  size     {found.size / 1e6:6.2f} MB")
    print(
        f"  writing  {written - start:6.2f} s CPU, {100 * (written - start) / seconds:.1f} % of it"
    )
    print(f"  reading  {read - written:6.2f} s CPU")
    print(f"  summary  {summed - read:6.2f} s CPU")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS)
