"""Every sensor of the simulated robot: how often it measures, and how far from the truth.

The IMU's formulas stand in `inertial`, the LiDARs' in `lidar`, the encoders' in `encoders`, known
motions to record in `motions`; their public names are here as well.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import pi, radians
from numbers import Integral, Real

from robocon_course.geometry import GRAVITY
from robocon_course.simulator.inertial import UNCALIBRATED, ImuErrors, imu_measurements
from robocon_course.simulator.motions import (
    ACCELERATION,
    FIELD_HIGH,
    FIELD_LOW,
    RAMP,
    TURN_RATE,
    Motion,
    drive,
    slow_turns,
    still,
)
from robocon_course.simulator.numbers import require
from robocon_course.simulator.physics import TICK

__all__ = [
    "ACCELERATION",
    "FIELD_HIGH",
    "FIELD_LOW",
    "GRAVITY",
    "IDEAL",
    "RAMP",
    "TURN_RATE",
    "UNCALIBRATED",
    "ImuErrors",
    "LidarErrors",
    "Motion",
    "SensorModel",
    "drive",
    "imu_measurements",
    "slow_turns",
    "still",
]


@dataclass(frozen=True)
class LidarErrors:
    """What parts a TFmini Plus's reading from the truth.

    Attributes
    ----------
    offset : float  [m]
        Every sensor has its own, drawn at reset between minus and plus this much.
    noise : float  [m]
        Standard deviation of a reading.
    band : float  [m]
        The two together stay within it up to 6 m, and within 1 % of the distance beyond.
    step_mm : int
        Readings are whole multiples of it: 10 in the sensor's centimetre mode, 5 is its resolution.
    spot : float  [rad]
        Full angle of the cone of light; 0 makes it a line.
    reflectivity : float
        Of everything it hits.
    """

    offset: float = 0.030
    noise: float = 0.010
    band: float = 0.050
    step_mm: int = 10
    spot: float = radians(3.6)
    reflectivity: float = 0.5

    def __post_init__(self) -> None:
        require(self, "offset", "noise", "band", "spot", zero=True)
        require(self, "step_mm")
        if self.step_mm != int(self.step_mm):
            raise ValueError(f"step_mm: must be whole millimetres, got {self.step_mm!r}")
        if not (isinstance(self.reflectivity, Real) and 0.0 < self.reflectivity <= 1.0):
            raise ValueError(f"reflectivity: between 0 and 1, got {self.reflectivity!r}")


@dataclass(frozen=True)
class SensorModel:
    """The sensors of one robot; ``dataclasses.replace`` makes another set of it.

    Attributes
    ----------
    imu : ImuErrors
    lidar : LidarErrors
    imu_rate, lidar_rate : float  [Hz]
        500 divided by a whole number. Each LiDAR measures at moments of its own.
    angle_step, speed_step : float  [rad, m/s]
        Resolution of the modules' encoders.
    encoder_gaps : tuple of (wheel, start, end)
        Times [s] in which a dead wheel (0, 1, 2) rolls and its counter does not count: it hangs in
        the air, or its plug is loose.
    """

    imu: ImuErrors = field(default_factory=ImuErrors)
    lidar: LidarErrors = field(default_factory=LidarErrors)
    imu_rate: float = 100.0
    lidar_rate: float = 100.0
    angle_step: float = 2.0 * pi / 4096
    speed_step: float = 0.001
    encoder_gaps: tuple[tuple[int, float, float], ...] = ()

    def __post_init__(self) -> None:
        for name, kind in (("imu", ImuErrors), ("lidar", LidarErrors)):
            got = getattr(self, name)
            if not isinstance(got, kind):
                wanted = kind.__name__
                raise ValueError(f"{name}: expected {wanted}, got {type(got).__name__}")
        require(self, "angle_step", "speed_step")
        for name in ("imu_rate", "lidar_rate"):
            ticks_between(getattr(self, name), name)
        if not isinstance(self.encoder_gaps, tuple | list) or not all(
            map(_is_gap, self.encoder_gaps)
        ):
            raise ValueError(
                "encoder_gaps: a tuple of (wheel 0, 1 or 2, start, end), seconds in order, "
                f"got {self.encoder_gaps!r}"
            )


def _is_gap(gap: object) -> bool:
    """Whether this is the number of a wheel and two times in order."""
    if not isinstance(gap, tuple | list) or len(gap) != 3:
        return False
    wheel, start, end = gap
    times = isinstance(start, Real) and isinstance(end, Real) and start <= end
    return times and isinstance(wheel, Integral) and 0 <= wheel <= 2


def ticks_between(rate: float, name: str = "rate") -> int:
    """Ticks of the physics between two samples of a sensor.

    Parameters
    ----------
    rate : float  [Hz]
    name : str
        For the message.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        The physics' 500 Hz is no whole multiple of it, or it is below 1 Hz.
    """
    every = 1.0 / (TICK * rate) if isinstance(rate, Real) and rate > 0.0 else 0.0
    if every < 0.5 or abs(every - round(every)) > 1e-6 or rate < 1.0:
        raise ValueError(f"{name}: must be 500 Hz divided by a whole number, got {rate!r}")
    return round(every)


IDEAL = SensorModel(
    imu=replace(
        ImuErrors(),
        gyro_bias=(0.0, 0.0, 0.0),
        gyro_noise_density=0.0,
        gyro_walk=0.0,
        accel_noise_density=0.0,
        gyro_resolution=1e-9,
        accel_resolution=1e-9,
    ),
    lidar=LidarErrors(offset=0.0, noise=0.0, step_mm=1, spot=0.0),
    angle_step=1e-9,
    speed_step=1e-9,
)
"""Sensors that tell the truth; the dead wheels still count whole ticks, the LiDARs millimetres."""
