"""The simulated robot: physics moves it, sensors watch; `read` and `apply` are all it shows.

Time runs on a grid of 2 ms. Sensors sample on it, whoever asks and how often; ``step`` may end
between two points of the grid, and then moves the rest of the way next time.
"""

from __future__ import annotations

from math import floor, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.robot import LIDAR_HEIGHT, LIDARS, Command, LidarReading, Observation
from robocon_course.simulator import encoders, inertial, lidar, physics
from robocon_course.simulator.model import RobotModel, game_field
from robocon_course.simulator.noise import Noise
from robocon_course.simulator.physics import TICK
from robocon_course.simulator.sensors import SensorModel, ticks_between
from robocon_course.simulator.truth import Truth, truth_of

START = (*field.START, 0.0)
"""Where Robot 2 starts [m, m, rad; map]: in its zone, looking towards the other team."""
LONGEST_STEP = 60.0
"""A longer `step` is taken for a mistake [s]."""
UNREAD = 1000
"""IMU samples that wait for a `read`; of more, the oldest are lost."""
TEMPERATURE = 25.0
"""Of the LiDARs [deg C]."""
RATE = round(1.0 / TICK)
"""Ticks in a second; a tick's number divided by it gives the decimal one writes."""
_ROWS = 512  # ticks that the track remembers
_CHUNK = 250  # ticks at a time, fewer than it remembers


class Simulator:
    """A robot on the game field, without hardware. Ready to use as built, and after each `reset`.

    Parameters
    ----------
    model : RobotModel
        Its true sizes.
    sensors : SensorModel
    start : array_like, shape (3,)  [m, m, rad; map]

    Attributes
    ----------
    clamped : int
        Commands that asked for more than the top speed; they were carried out as far as it goes.

    Raises
    ------
    ValueError
        Not a model or not sensors; a gap of a dead wheel that the model lacks; a start that is
        not a pose, or stands in an obstacle.

    Examples
    --------
    >>> robot = Simulator()
    >>> robot.apply(Command([0.5] * 4, [0.0] * 4))
    >>> robot.step(2.0)
    >>> robot.read().ticks.tolist(), robot.truth.pose.round(2).tolist()
    ([16741, 16741, 0], [1.52, 0.35, 0.0])
    """

    def __init__(
        self,
        model: RobotModel | None = None,
        *,
        sensors: SensorModel | None = None,
        start: ArrayLike = START,
    ) -> None:
        self.model = _checked(model, "model", RobotModel)
        self.sensors = _checked(sensors, "sensors", SensorModel)
        self._body, self._world = self.model.body(), game_field()
        self._metres_per_tick = self.model.dead_wheels.metres_per_tick
        self._light = lidar.game_field()
        self._imu_every = ticks_between(self.sensors.imu_rate)
        self._imu_table = inertial.error_table(self.sensors.imu, self._imu_every * TICK)
        for wheel, _, _ in self.sensors.encoder_gaps:
            if wheel >= len(self._body.dead_wheels):
                count = len(self._body.dead_wheels)
                raise ValueError(f"encoder_gaps: wheel {wheel} is not there, the model has {count}")
        self._start = self._free_pose(start)
        self.reset(0)

    def reset(self, seed: int = 0, start: ArrayLike | None = None) -> None:
        """Back to the start, at rest, with time and counters at 0.

        Parameters
        ----------
        seed : int
            Of the sensors' noise and the LiDARs' offsets; the same one gives the same run.
        start : array_like, shape (3,), optional  [m, m, rad; map]
            Another start, from now on.

        Raises
        ------
        ValueError
            A seed that is not a whole number from 0 on; a start in an obstacle.
        """
        if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
            raise ValueError(f"seed: expected a whole number, 0 or more, got {seed!r}")
        if start is not None:
            self._start = self._free_pose(start)
        self.clamped = 0
        self._tick, self._part, self._owed = 0, 0.0, 0.0
        self._command = np.zeros((2, 4))
        self._track = np.empty((_ROWS, physics.TRACK))
        self._state = self._at_rest(self._start, self._track)
        self._track[1:] = self._track[0]  # it has always stood here
        self._uncounted = np.zeros_like(self._state.travel)
        words = np.random.SeedSequence(int(seed)).spawn(3)
        rngs = [np.random.Generator(np.random.PCG64(word)) for word in words]
        self._imu_noise = Noise(rngs[0], inertial.NOISES)
        self._lidar_noise = Noise(rngs[1], len(LIDARS))
        self._lidars = self._drawn_lidars(rngs[2])
        self._imu_memory, self._imu_walk = np.zeros(8), np.zeros(3)
        inertial.attitude(*self._track[0, [2, 6, 7]], self._imu_memory[:4])
        self._imu_memory[7] = self._imu_every * TICK
        self._imu = np.empty((UNREAD, 6))
        self._unread = 0

    def place(self, pose: ArrayLike) -> None:
        """Somebody lifts the robot and puts it down elsewhere: at rest, clock and counters go on.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]

        Raises
        ------
        ValueError
            Not a pose, or one in an obstacle; the robot stays where it is.
        """
        pose, old = self._free_pose(pose), self._state
        state = self._at_rest(pose, np.empty((1, physics.TRACK)))
        state.travel[:] = old.travel  # wheels in the air do not count
        state.battery[:] = old.battery
        state.contact[1] = old.contact[1]
        self._state = state
        # Its gyroscope does not see the turn: whoever carries it presses its start button again.
        inertial.attitude(pose[2], *state.floor[:2], self._imu_memory[:4])

    def step(self, dt: float) -> None:
        """Let time pass.

        Parameters
        ----------
        dt : float  [s]
            Above 0, at most a minute.

        Raises
        ------
        ValueError
            Another dt.
        """
        if not isinstance(dt, (float, int, np.number)) or not 0.0 < dt <= LONGEST_STEP:
            raise ValueError(f"dt: must be seconds above 0, at most {LONGEST_STEP:g}, got {dt!r}")
        part = self._part + self._owed + dt / TICK
        ticks = floor(part + 1e-6)
        if ticks and self._part:
            self._advance((1.0 - self._part) * TICK, 1)
            self._part, ticks, part = 0.0, ticks - 1, part - 1.0
        while ticks:
            chunk = min(ticks, 1 if self.sensors.encoder_gaps else _CHUNK)
            self._advance(TICK, chunk)
            ticks, part = ticks - chunk, part - chunk
        if part - self._part > 1e-6:
            self._move((part - self._part) * TICK, 1)
            self._part = part
        self._owed = part - self._part  # too short to move by, and not to be forgotten

    def apply(self, command: Command) -> None:
        """Drive like this from now on, until the next command.

        Parameters
        ----------
        command : Command
            Speeds beyond the top speed are cut, and the command is counted in ``clamped``.

        Raises
        ------
        ValueError
            Not a command, or not four finite numbers each; the command before stays in force.
        """
        if not isinstance(command, Command):
            raise ValueError(
                f"command: expected Command(speeds, angles), got {type(command).__name__}"
            )
        speeds, angles = command.checked()
        # The wheels themselves end at the top speed.
        fastest = max(map(abs, speeds.tolist()))
        self.clamped += fastest > self._body.max_speed * (1.0 + 1e-9)
        # A module has no end stop; of a huge angle the direction is all that a float can still add.
        self._command[0] = speeds
        np.fmod(angles, 2.0 * pi, self._command[1])

    def read(self) -> Observation:
        """What the sensors say now; hands over the IMU samples since the last call.

        Returns
        -------
        Observation
        """
        state, sensors, count = self._state, self.sensors, self._unread
        samples, self._unread = self._imu[:count].copy(), 0
        every, last = self._imu_every, self._tick // self._imu_every
        looks = np.empty((len(LIDARS), 3))
        noise = self._lidar_noise
        lidar.look(
            self._track, self._tick, self._lidars, self._light, noise.window, noise.first, looks
        )
        ticks, modules = np.empty(len(state.travel), np.int64), np.empty((2, 4))
        encoders.count(
            state.travel - self._uncounted, self._metres_per_tick, state.speeds, state.angles,
            sensors.speed_step, sensors.angle_step, ticks, modules,
        )  # fmt: skip
        readings = [
            LidarReading(tick / RATE, distance, int(strength), TEMPERATURE)
            for tick, distance, strength in looks.tolist()
        ]
        return Observation(
            time=self.time,
            ticks=ticks,
            imu_time=np.array([k * every / RATE for k in range(last - count + 1, last + 1)]),
            gyro=samples[:, :3],
            accel=samples[:, 3:],
            lidar=tuple(readings),
            module_speeds=modules[0],
            module_angles=modules[1],
            battery=round(float(state.battery[0]), 2),
        )

    @property
    def time(self) -> float:
        """Since the last reset [s]."""
        return (self._tick + self._part) / RATE

    @property
    def motion(self) -> tuple[FloatArray, FloatArray]:
        """Pose (3,) [m, m, rad; map] and how it changes (3,) [m/s, m/s, rad/s; map]: the truth, in
        brief. Copies."""
        return self._state.pose.copy(), self._state.velocity[:3].copy()

    @property
    def truth(self) -> Truth:
        """What is really so, for graders and plots; a copy."""
        return truth_of(self._state, self._body, self.time)

    # --- inside ----------------------------------------------------------------------------------

    def _free_pose(self, start: ArrayLike) -> FloatArray:
        """A start, checked."""
        pose = as_floats(start, "start", 3)
        x, y, theta = pose
        if not (0.0 < x < field.SIZE and 0.0 < y < field.SIZE):
            raise ValueError(f"start: ({x:g}, {y:g}) m lies outside the field")
        if not np.array_equal(self._at_rest(pose, np.empty((1, physics.TRACK))).pose, pose):
            raise ValueError(
                f"start: the robot would stand in an obstacle at ({x:g}, {y:g}) m, "
                f"{np.degrees(theta):.0f} deg; its middle needs 0.325 m to a wall, 0.46 m turned"
            )
        return pose.copy()

    def _at_rest(self, pose: FloatArray, track: FloatArray) -> physics.State:
        """All that moves, at rest at a pose (also in track row 0), pushed out of any obstacle."""
        state = physics.State.at_rest(pose, self._body)
        physics.advance(state, np.zeros((2, 4)), self._body, self._world, TICK, 0, 0, track)
        state.contact[1] = 0
        return state

    def _drawn_lidars(self, rng: np.random.Generator) -> lidar.Lidars:
        """This run's LiDARs: offsets, and moments on the grid."""
        errors, every = self.sensors.lidar, ticks_between(self.sensors.lidar_rate)
        half = 0.5 * errors.spot
        return lidar.Lidars(
            mounts=np.array([(m.x, m.y, LIDAR_HEIGHT, m.angle) for m in LIDARS]),
            rays=(lidar.SPOT if half else lidar.LINE) * (half, half, 1.0),
            offsets=rng.uniform(-errors.offset, errors.offset, len(LIDARS)),
            phases=rng.integers(0, every, len(LIDARS)),
            every=every,
            noise=float(errors.noise),
            band=float(errors.band),
            step_mm=float(errors.step_mm),
            reflectivity=float(errors.reflectivity),
        )

    def _move(self, h: float, ticks: int) -> None:
        """Run the physics."""
        state = self._state
        before = state.travel.copy() if self.sensors.encoder_gaps else None
        physics.advance(
            state, self._command, self._body, self._world, h, self._tick + 1, ticks, self._track
        )
        for wheel, start, end in self.sensors.encoder_gaps:
            if start <= self.time < end:
                self._uncounted[wheel] += state.travel[wheel] - before[wheel]

    def _advance(self, h: float, ticks: int) -> None:
        """Run the physics to a point of the grid, and let the sensors sample on the way."""
        self._move(h, ticks)
        every, before = self._imu_every, self._tick // self._imu_every
        self._tick += ticks
        count = self._tick // every - before
        if count:
            self._sample_imu(before + 1, count)
        self._lidar_noise.reach((self._tick // self._lidars.every) + 1)

    def _sample_imu(self, first: int, count: int) -> None:
        """The IMU's samples number ``first`` and following."""
        noise = self._imu_noise
        noise.reach(first + count)
        lost = max(self._unread + count - UNREAD, 0)
        if lost:
            self._imu[: UNREAD - lost] = self._imu[lost:].copy()
            self._unread -= lost
        row = first - noise.first
        inertial.read_track(
            self._track,
            first * self._imu_every,
            self._imu_every,
            self._imu_table,
            noise.window[row : row + count],
            self._imu_memory,
            self._imu_walk,
            self._imu[self._unread : self._unread + count],
        )
        self._unread += count


def _checked(given: object, name: str, kind: type) -> Any:
    """A model as it was given, or the usual one."""
    if given is not None and not isinstance(given, kind):
        raise ValueError(f"{name}: expected a {kind.__name__}, got {type(given).__name__}")
    return kind() if given is None else given
