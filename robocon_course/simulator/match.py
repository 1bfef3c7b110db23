"""A whole match in the simulator: robot, balls, silos, camera, the other team, the clock.

A `Match` is a `Robot`: `read` and `apply` are all that autonomy sees of it. Who runs it calls
`step` in between, and looks at `referee` and `robot.truth` for the score and the truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, pi, radians, sin
from typing import Any

import numpy as np

from robocon_course import field
from robocon_course._arrays import CourseError, FloatArray
from robocon_course.field import SEEDLINGS
from robocon_course.mission import LETTERS
from robocon_course.robot import Command, Frame, LidarReading, Observation
from robocon_course.simulator import balls as rolling
from robocon_course.simulator.balls import FREE, HELD, OUT, Balls
from robocon_course.simulator.camera import FieldCamera, view_from
from robocon_course.simulator.faults import HAPPENS, KINDS, Fault, slipping
from robocon_course.simulator.glimpse import balls_seen, silos_seen
from robocon_course.simulator.machine import START, Simulator
from robocon_course.simulator.model import RobotModel
from robocon_course.simulator.others import Others
from robocon_course.simulator.referee import MATCH, OPPONENTS, RETRY_COSTS, Referee, refuse
from robocon_course.simulator.sensors import SensorModel
from robocon_course.vision.camera import Camera

CAMERA = Camera()
CYCLE = 0.01
"""Of control [s]."""
FRAMES, LATENCY = 0.1, 0.08
"""A picture is taken so often, and arrives so much later [s]."""
SERVO = 4.0
"""The camera turns so fast [rad/s]."""
RETRY_POSE = (0.5, 5.5, 0.0)
PLACED, TURNED = 0.003, radians(0.1)
"""How exactly a crew puts the robot down: at most so far off [m], standard deviation [rad]."""
ARM = 0.50
"""Where the gripper lets a ball fall: so far ahead of the robot's middle [m]."""
LETTING_GO = 0.5
"""It takes so long [s]."""
BORE = 0.06
"""A ball that falls no farther than this beside a silo's middle slides in [m]."""
STREAMS = ("pile", "placing", "opponent", "feed", "camera", "sensors")


class Match:
    """A match of three minutes, ready for its set-up.

    Parameters
    ----------
    seed : int
        Of everything: pile, placing, other team, noise, hall.
    team : {"red", "blue"}
    opponent : {"weak", "middling", "strong"} or None
        None: nobody plays against us.
    model, sensors
        As for `Simulator`.
    drawn : bool
        Draw what the camera sees; else frames hold what a detector would say.
    faults : sequence of Fault
    sent : int
        Balls that Robot 1 sends; the rules allow as many as seedlings were planted.

    Attributes
    ----------
    robot : Simulator
    balls : Balls
    referee : Referee
    started : float or None  [s]
        On the robot's clock.
    retries : int
        How often the crew put the robot into the Retry Zone.
    pan, tilt : float  [rad]
        Of the camera servo now.

    Raises
    ------
    CourseError
        Another team, opponent or fault, a seed or a number of balls that is none.
    """

    def __init__(
        self,
        seed: int = 0,
        *,
        team: str = "red",
        opponent: str | None = "weak",
        model: RobotModel | None = None,
        sensors: SensorModel | None = None,
        drawn: bool = False,
        faults: Sequence[Fault] = (),
        sent: int = SEEDLINGS,
    ) -> None:
        refuse("team", team, tuple(LETTERS))
        refuse("opponent", opponent, (None, *OPPONENTS))
        for fault in faults:
            refuse("faults", fault.kind, KINDS)
        for name, number in (("seed", seed), ("sent", sent)):
            if not isinstance(number, int | np.integer) or number < 0:
                raise CourseError(f"{name}: expected a whole number, 0 or more, got {number!r}")
        words = np.random.SeedSequence([int(seed), 2024]).spawn(len(STREAMS))
        self._rng = {name: np.random.Generator(np.random.PCG64(w))
                     for name, w in zip(STREAMS, words, strict=True)}  # fmt: skip
        self.team, self.seed, self.faults = team, seed, tuple(faults)
        self.referee = Referee(LETTERS[team])
        self.robot = Simulator(model, sensors=sensors, start=START)
        self.robot.reset(int(self._rng["sensors"].integers(1 << 31)))
        pile = self._rng["pile"].permutation([team] * 6 + ["purple"] * 10)
        self.balls = Balls(np.array(field.PILE_BALLS), [str(name) for name in pile])
        self._others = Others(team, opponent, self._rng, sent)
        self._eye = FieldCamera(int(self._rng["camera"].integers(1 << 31))) if drawn else None
        self.started: float | None = None
        self.retries, self._waits_until, self._area_2 = 0, 0.0, False
        self.pan = self.tilt = 0.0
        self._command = Command.stop()
        self._pulled = self._released = 0.0
        self._frames: list[Frame] = []
        self._next_frame = 0.0
        self._done: set[Fault] = set()
        self._last: Observation | None = None

    # --- before the match -------------------------------------------------------------------------

    def set_up(self, seconds: float = 1.0) -> list[tuple[FloatArray, list[tuple[LidarReading]]]]:
        """What the LiDARs say while the crew turns the robot by quarter turns on its start.

        One after the other, each looks at the fence on the left of the start zone. Then the robot
        stands at its start.

        Parameters
        ----------
        seconds : float
            At each heading.

        Returns
        -------
        list of (pose, readings)
            The pose (3,) [m, m, rad; map] the crew meant, and one tuple of readings a cycle.
        """
        told = []
        for heading in (0.0, pi / 2, pi, -pi / 2):
            meant = np.array([START[0], START[1] + 0.05, heading])
            self.robot.place(self._put(meant))
            readings = []
            for _ in range(round(seconds / CYCLE)):
                self.robot.step(CYCLE)
                readings.append(self.robot.read().lidar)
            told.append((meant, readings))
        self.robot.place(self._put(np.array(START)))
        self.robot.step(0.5)
        return told

    def start(self) -> None:
        """The clock runs from now on."""
        self.started = self.robot.time
        self.robot.sensors = slipping(self.robot.sensors, self.faults, self.started)
        self._next_frame = self.robot.time

    def _put(self, pose: FloatArray) -> FloatArray:
        rng = self._rng["placing"]
        off = rng.uniform(-PLACED, PLACED, 2)
        turn = TURNED * float(np.clip(rng.standard_normal(), -2.0, 2.0))
        return pose + np.array([*off, turn])

    # --- the Robot protocol -----------------------------------------------------------------------

    def read(self) -> Observation:
        """What the sensors say now, the gripper and the camera among them."""
        if self._last is not None and self._now("frozen"):
            return self._last
        seen = self.robot.read()
        if self._now("lidar"):
            dead = tuple(r._replace(distance=0.0, strength=0) for r in seen.lidar)
            seen = seen._replace(lidar=dead)
        frame = None
        while self._frames and self._frames[0].time + LATENCY <= seen.time + 1e-9:
            frame = self._frames.pop(0)
        self._last = Observation(*seen[:-2], holding=self.balls.held >= 0, frame=frame)
        return self._last

    def apply(self, command: Command) -> None:
        """Do this from now on, until the next command."""
        if self.waiting:
            command = Command.stop(self.robot.truth.module_angles)
        self.robot.apply(command)
        self._command = command

    # --- time -------------------------------------------------------------------------------------

    @property
    def clock(self) -> float:
        """Since the start [s]; 0 before it."""
        return 0.0 if self.started is None else self.robot.time - self.started

    @property
    def waiting(self) -> bool:
        """Whether the robot stands in the Retry Zone and has to wait."""
        return self.clock < self._waits_until

    @property
    def wait_left(self) -> float:
        """So long it still has to wait there [s]."""
        return max(0.0, self._waits_until - self.clock)

    @property
    def over(self) -> bool:
        """Whether the match has ended."""
        return bool(self.referee.winner)

    def step(self) -> None:
        """Let a control cycle pass."""
        self.robot.step(CYCLE)
        pose, motion = self.robot.motion
        self._turn_camera()
        pull = 0.0 if self.waiting else float(self._command.intake)
        touched = rolling.roll(
            self.balls.xy, self.balls.velocity, self.balls.place, pose, motion, pull, CYCLE
        )
        if self.started is None or self.over:
            return
        self._grip(touched, pull)
        self._let_go(pose, pull)
        self._others.act(self.clock, self.referee, self.balls)
        if self.faults:
            self._go_wrong(self.robot.motion[0])  # a foul may have put it elsewhere by now
        self._area_2 |= bool(pose[1] > 4.5)
        if self._command.watch and self.robot.time >= self._next_frame - 1e-9:
            self._take_frame(pose)
            self._next_frame = self.robot.time + FRAMES
        if self.clock >= MATCH - 1e-9:
            self.referee.time_is_up(MATCH)

    def retry(self) -> None:
        """The crew carries the robot to the Retry Zone; the ball it carried leaves the game."""
        if self.balls.held >= 0:
            self.balls.place[self.balls.held] = OUT
        self.robot.place(self._put(np.array(self.home)))
        self.apply(Command.stop())
        self.retries += 1
        self._waits_until = self.clock + RETRY_COSTS
        self._frames.clear()
        self._pulled = self._released = 0.0
        self.referee.note(self.clock, "retry")

    @property
    def home(self) -> tuple[float, float, float]:
        """Where a retry puts the robot, as the crew means it [m, m, rad; map]."""
        return RETRY_POSE if self._area_2 else START

    # --- gripper ----------------------------------------------------------------------------------

    def _grip(self, touched: int, pull: float) -> None:
        """Rollers that turn take the ball before them, whatever it is."""
        self._pulled = self._pulled + CYCLE if touched >= 0 and pull > 0.0 else 0.0
        if self._pulled < rolling.PULL:
            return
        self._pulled = 0.0
        colour = self.balls.colours[touched]
        if self.balls.held >= 0 or colour != self.team:
            what = "a second ball" if self.balls.held >= 0 else f"a {colour} ball"
            self.referee.note(self.clock, "foul", "own", f"gripped {what}")
            self.balls.place[touched] = OUT
            self.retry()
            return
        self.balls.place[touched] = HELD
        self.referee.note(self.clock, "taken")

    def _let_go(self, pose: FloatArray, pull: float) -> None:
        """The held ball over the front edge into a silo, or through the rollers to the floor."""
        ball = self.balls.held
        self._released = self._released + CYCLE if ball >= 0 and self._command.release else 0.0
        ejected = ball >= 0 and pull < 0.0
        if self._released < LETTING_GO and not ejected:
            return
        c, s = cos(pose[2]), sin(pose[2])
        if ejected:
            reach = 0.45
            self.put_down(ball, (pose[0] + reach * c, pose[1] + reach * s), (0.4 * c, 0.4 * s))
            self._released = 0.0
        if self._released < LETTING_GO:
            return
        self._released = 0.0
        x, y = pose[0] + ARM * c, pose[1] + ARM * s
        away = [hypot(x - sx, y - sy) for sx, sy in field.SILOS]
        silo = int(np.argmin(away))
        if away[silo] <= BORE:
            self.balls.place[ball] = OUT  # from a full silo it rolls away, as the referee notes
            self.referee.store(self.clock, "own", silo)
        elif x > 5.75:  # on the Silo Zone nobody gets it any more
            self.balls.place[ball] = OUT
            self.referee.note(self.clock, "lost ball", "own", f"{away[silo]:.3f} m beside a silo")
        else:
            self.put_down(ball, (x, y), (0.0, 0.0))
            self.referee.note(self.clock, "lost ball", "own", "let go over the floor")

    def put_down(self, ball: int, xy: tuple, velocity: tuple) -> None:
        """A held ball lies on the floor, or rolls there [m, m/s; map]."""
        self.balls.xy[ball] = np.clip(xy, rolling.LOW, rolling.HIGH)
        self.balls.velocity[ball] = velocity
        self.balls.place[ball] = FREE

    # --- camera -----------------------------------------------------------------------------------

    def _turn_camera(self) -> None:
        most, command = SERVO * CYCLE, self._command
        self.pan += min(max(float(command.pan) - self.pan, -most), most)
        self.tilt += min(max(float(command.tilt) - self.tilt, -most), most)

    def _take_frame(self, pose: FloatArray) -> None:
        kind, pan, tilt = self._command.watch, self.pan, self.tilt
        dark = self._now("dark")
        image, found = None, {}
        if self._eye is not None:
            image = np.zeros((240, 320, 3), np.uint8) if dark else self._eye.look(
                pose, pan=pan, tilt=tilt, kind=kind,
                balls=[(tuple(c), name) for c, name in zip(*self._lying(), strict=True)],
                silos=self._standing(),
            ).image_bgr  # fmt: skip
        elif not dark:
            found = {kind: self._said(pose, kind)}
        self._frames.append(Frame(self.robot.time, pan, tilt, image, found))

    def _said(self, pose: FloatArray, kind: str) -> Any:
        T_map_camera = view_from(pose, self.pan, self.tilt)
        rng, camera = self._rng["camera"], CAMERA
        if kind == "ball":
            return balls_seen(camera, T_map_camera, *self._lying(), rng)
        return silos_seen(camera, T_map_camera, self._standing(), rng)

    def _lying(self) -> tuple[FloatArray, list[str]]:
        """Middles (n, 3) [m, map] and colours of the balls on the floor."""
        free = self.balls.free
        xy = self.balls.xy[free]
        heights = rolling.floor_under(xy) + rolling.RADIUS
        return np.column_stack([xy, heights]), [self.balls.colours[k] for k in free]

    def _standing(self) -> list[str]:
        """What the silos hold, as `vision.SILOS` writes it."""
        return [filling or "empty" for filling in self.referee.fillings]

    # --- faults -----------------------------------------------------------------------------------

    def _now(self, kind: str) -> bool:
        """Whether a fault that lasts is there."""
        if self.started is None:
            return False
        for fault in self.faults:
            if fault.kind == kind and fault.start <= self.clock < fault.start + fault.duration:
                return True
        return False

    def _go_wrong(self, pose: FloatArray) -> None:
        """Faults that happen once, as soon as they can after their time."""
        for fault in self.faults:
            if fault in self._done or self.clock < fault.start:
                continue
            happen = HAPPENS.get(fault.kind)
            if happen is not None and happen(self, pose):
                self._done.add(fault)
                self.referee.note(self.clock, "fault", "own", fault.kind)
