"""What the autonomy and the hardware agree on, and what is told about it while it runs.

=================  ==========================================================
``hardware``       sizes, `Observation`, `Command`, the `Robot` protocol
``lidar_frames``   the nine bytes of a TFmini Plus
``messages``       what is told on the bus, named as in ROS 2
``bus``            `Bus`: who tells, and who listens
``codec``          one JSON form of Observation and Command, to the bit
``forms``          the same as JSON Schema
``camera_frames``  the camera's part of it
``link``           a datagram of the link to hardware, and which ones are new
``udp``            `UdpRobot` drives a robot over the network
``udp_server``     `RobotServer`, the robot's side of it
``udp_end``        what both ends do
``text``           JSON text, and the fields of what came from elsewhere
=================  ==========================================================
"""

from robocon_course.robot import messages
from robocon_course.robot.bus import Bus
from robocon_course.robot.hardware import (
    BATTERY,
    DEAD_WHEELS,
    LIDAR_HEIGHT,
    LIDAR_RANGE,
    LIDARS,
    MASS,
    MAX_SPEED,
    MODULES,
    SATURATED,
    SIDE,
    WEAKEST,
    Command,
    Frame,
    LidarMount,
    LidarReading,
    Observation,
    Robot,
)
from robocon_course.robot.lidar_frames import (
    FRAME_HEAD,
    FRAME_SIZE,
    LidarFrames,
    decode_lidar,
    encode_lidar,
)

__all__ = [
    "BATTERY",
    "DEAD_WHEELS",
    "FRAME_HEAD",
    "FRAME_SIZE",
    "LIDARS",
    "LIDAR_HEIGHT",
    "LIDAR_RANGE",
    "MASS",
    "MAX_SPEED",
    "MODULES",
    "SATURATED",
    "SIDE",
    "WEAKEST",
    "Bus",
    "Command",
    "Frame",
    "LidarFrames",
    "LidarMount",
    "LidarReading",
    "Observation",
    "Robot",
    "decode_lidar",
    "encode_lidar",
    "messages",
]
