"""The robot plays by itself: observation in, command out, a hundred times a second.

    Observation → reckon → walls → pose ─┐
    Frame → sight → balls, silos ────────┼→ facts → mission table → play → target
                                         └→ route → follow → modules → Command

A reading that is missing, stale, frozen or absurd is counted and bridged. Where none can be used
for a while the mission says so (`State.NO_SENSORS`) and the robot stands. Nothing here raises for a
value.
"""

from __future__ import annotations

from math import hypot, inf, isfinite, nan, remainder
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import CourseError, FloatArray, as_floats
from robocon_course.autopilot.driver import NEAR, Driver
from robocon_course.autopilot.parts import Parts
from robocon_course.autopilot.plays import PLAYS, Order
from robocon_course.autopilot.sensing import Reckoning, lidar_y, reckon
from robocon_course.autopilot.sight import Sight
from robocon_course.autopilot.taking import approach_to_ball
from robocon_course.autopilot.walls import Walls, correct, found_again
from robocon_course.geometry import TURN
from robocon_course.mission import (
    LETTERS,
    RESETS,
    Facts,
    History,
    Rhythm,
    State,
    Table,
    Watch,
    mission_table,
    rhythm_seen,
)
from robocon_course.odometry import TrackingWheels
from robocon_course.robot import DEAD_WHEELS, Command, Observation

START_POSE = (*field.START, 0.0)
BLIND_AFTER = 30
"""So many observations in a row without use, and the robot stands."""
LONGEST_PAUSE = 10.0
"""A clock that leaps farther, or back, is taken for another clock [s]."""
PLACED = 0.005
"""How exactly a crew puts it down [m]."""
STANDS = 0.03
"""Slower than this by its wheels it stands [m/s]."""
STORING_TAKES = 3.0
"""From the choice of a silo to the ball in it [s]."""
GRIPS = 0.4
"""The rollers have so long for a ball before it counts as missed [s]."""
CHOICE = ("silo", "silos")
"""Notes of a choice: which silo, and what all of them held then."""
SPEAKS = 400
"""So many lines of its log are kept."""
BALL_STATES = (State.DETECT_BALL, State.SEARCH_BALL, State.TAKE_BALL, State.BACK_TO_STORAGE)


class Autopilot:
    """Plays a match.

    Parameters
    ----------
    parts : Parts
    wheels : TrackingWheels
        What it believes of its dead wheels.
    team : {"red", "blue"}
    start : array_like, shape (3,)  [m, m, rad; map]
        Where the crew put it.
    offsets : array_like, shape (4,), optional  [m]
        What each LiDAR reads too much.
    use_walls, use_imu : bool
        Whether LiDARs correct the pose; whether the gyroscope tells the heading.

    Attributes
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
        Where it believes to be.
    history : History
        Of the mission.
    facts : Facts
        What the mission decided by last.
    sight : Sight
        Balls and silos.
    walls : Walls
    driver : Driver
        Brings it where the mission wants it.
    motion : tuple of 2 floats  [m/s, map]
        How it moves, by its own wheels.
    pushes : int
        How often it drove into the pile.
    speaks : list of (float, str, str)
        Time [s], level and text of what the operator should know.
    spoken : int
        How many such lines there were; only the last ones are kept.

    Raises
    ------
    CourseError
        Another team.
    ValueError
        A start that is no pose.
    """

    def __init__(
        self,
        parts: Parts | None = None,
        wheels: TrackingWheels = DEAD_WHEELS,
        team: str = "red",
        *,
        start: ArrayLike = START_POSE,
        offsets: ArrayLike = (0.0, 0.0, 0.0, 0.0),
        use_walls: bool = True,
        use_imu: bool = True,
    ) -> None:
        if team not in LETTERS:
            raise CourseError(f"team: expected 'red' or 'blue', got {team!r}")
        self.parts, self.wheels, self.team = parts or Parts(), wheels, team
        self.use_walls, self.use_imu = use_walls, use_imu
        self.table: Table = mission_table()
        self.history: History = self.table.begin()
        self.facts = Facts()
        self.reckoning = Reckoning.at(start)
        self.walls = Walls((PLACED, PLACED), as_floats(offsets, "offsets", 4))
        self.sight = Sight(self.parts, team)
        self.notes: dict[str, Any] = {}
        self.speaks: list[tuple[float, str, str]] = []
        self.spoken = 0
        self.now, self._leapt = 0.0, 0.0
        self._begins, self._ends, self._began = inf, inf, 0.0
        self._stored: list[float] = []
        self._watch, self.motion = Watch(), (0.0, 0.0)
        self._tried = self.pushes = 0
        self._order, self._held, self._sought = Order(), False, -inf
        self.driver = Driver(self.parts, float(self.reckoning.pose[2]))

    # --- the crew ---------------------------------------------------------------------------------

    @property
    def stopped(self) -> bool:
        """Whether it waits for `start`."""
        return self._begins == inf

    def start(self, after: float = 0.0) -> None:
        """Play from now on, or in a while [s].

        After a `stop` the match has gone on meanwhile, and ends when it would have ended.
        """
        if not self.stopped:
            return
        self._begins = self.now + after
        if self._ends == inf:
            self._began, self._ends = self._begins, self._begins + field.MATCH_LENGTH

    def stop(self) -> None:
        """Stand still, until `start`."""
        self._begins = inf
        self.history = self.table.begin(self.now)
        self._enter(State.RESET)

    def restart(self, pose: ArrayLike, after: float = 0.0) -> None:
        """The crew put the robot somewhere and lets it begin again.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad; map]
        after : float  [s]
            It has to wait so long.
        """
        pose = as_floats(pose, "pose", 3).copy()
        heading = self.reckoning.heading._replace(yaw=float(pose[2]))
        self.reckoning = self.reckoning._replace(pose=pose, heading=heading)
        self.walls = self.walls._replace(sigma=(PLACED, PLACED), lost_for=(0.0, 0.0))
        self._begins = self.now + after
        self.driver.heading = float(pose[2])
        self.history = self.table.begin(self.now)
        self._enter(State.RESET)
        self._say("info", "retry")

    # --- what plays look at -----------------------------------------------------------------------

    @property
    def pose(self) -> FloatArray:
        """Where the robot believes to be, shape (3,) [m, m, rad; map]."""
        return self.reckoning.pose

    @property
    def state(self) -> State:
        """Of the mission."""
        return self.history.state

    @property
    def waited(self) -> float:
        """Since the state was entered [s]."""
        return self.now - self.history.since

    @property
    def speed(self) -> float:
        """How fast it moves [m/s]."""
        return hypot(*self.motion)

    @property
    def standing(self) -> bool:
        """Whether the robot stands."""
        return self.speed < STANDS

    @property
    def rhythm(self) -> Rhythm:
        """How often both teams come to a silo, as far as it was noticed."""
        arrival = self.now + STORING_TAKES
        return rhythm_seen(arrival, self._began, self._stored, self.sight.their_balls)

    def near(self, target: ArrayLike, gap: float = NEAR, turn: float = 0.06) -> bool:
        """Whether the robot is within `gap` [m] and `turn` [rad] of a pose."""
        x, y, theta = self.reckoning.pose.tolist()
        if not hypot(x - target[0], y - target[1]) < gap:
            return False
        return abs(remainder(theta - target[2], TURN)) < turn

    # --- the tick ---------------------------------------------------------------------------------

    def tick(self, seen: Observation) -> Command:
        """What to do after one more observation.

        Parameters
        ----------
        seen : Observation
            One that cannot be used is counted.

        Returns
        -------
        Command

        Raises
        ------
        ValueError
            Readings of another shape. Never for a value: this runs in a control loop.
        """
        self._locate(seen)
        if seen.frame is not None and self._order.watch:
            frame = seen.frame._replace(time=seen.frame.time - self._leapt)
            self.sight.look(frame, self._order.watch)
            if self.state in BALL_STATES and self._order.watch == "ball":
                self.notes["approach"] = approach_to_ball(self)
        self._decide(seen)
        self._order = order = PLAYS[self.state](self)
        target = None if self.facts.blind else order.target
        command = self.driver.drive(target, order.limits, self.reckoning, seen.module_angles)
        if self.driver.trouble:
            self._say("warning", self.driver.trouble)
        return Command(
            command.speeds, command.angles, order.intake, order.release, order.pan, order.tilt,
            order.watch,
        )  # fmt: skip

    def _locate(self, seen: Observation) -> None:
        """Dead reckoning, and what the walls say of it."""
        last = self.reckoning
        if not self.use_imu:
            seen = seen._replace(gyro=np.full_like(seen.gyro, nan))
        now = reckon(self.parts, last, seen, self.wheels)
        if now.missed == BLIND_AFTER:
            self._say("error", "no reading can be used")
        if not (now.fresh and isfinite(now.dt)):
            self.reckoning = now
            self._keep_time(now.time)
            return
        self._keep_time(now.time)
        x, y, _ = now.pose.tolist()
        last_x, last_y, _ = last.pose.tolist()
        self.motion = motion = (x - last_x) / now.dt, (y - last_y) / now.dt
        if self.use_walls:
            self.walls, pose = correct(self.walls, now.pose, seen, motion, now.dt)
            if self.state is State.LIDAR_RESET and not self.walls.sure:
                pose = self._search_pose(pose, seen)
            now = Reckoning(pose, *now[1:])
        self.reckoning = now
        self.sight.remember(self.now, now.pose)

    def _keep_time(self, time: float) -> None:
        """The robot's clock is the match's, but where it leaps the match goes on."""
        if not isfinite(time):
            return
        if 0.0 <= time - self._leapt - self.now <= LONGEST_PAUSE:
            self.now = time - self._leapt
        else:
            self._leapt = time - self.now

    def _search_pose(self, pose: FloatArray, seen: Observation) -> FloatArray:
        """Lost: where else could these distances be?"""
        if self.waited < 0.4 or self.now - self._sought < 0.5:
            return pose
        self._sought = self.now
        found = found_again(self.walls, pose, seen)
        if found is None:
            return pose
        self.walls = self.walls.doubted()
        self._say("warning", f"found again at ({found[0]:.2f}, {found[1]:.2f}) m")
        return found

    def _decide(self, seen: Observation) -> None:
        """One step of the mission."""
        self.facts = self._facts(seen)
        before = self.history
        self.history = self.table.step(before, self.facts, self.now, self.parts.next_transition)
        if self.history is not before:
            self._enter(self.history.state)
            self._held = bool(seen.holding)

    def _facts(self, seen: Observation) -> Facts:
        notes, target, state = self.notes, self._order.target, self.state
        speed = hypot(*self.driver.ordered)
        self._watch, stuck = self.parts.is_stuck(self._watch, self.now, self.pose, speed)
        arrived = target is not None and self.near(target, NEAR, 0.08) and self.standing
        if state is State.GO_TO_AREA_3:
            arrived = arrived and lidar_y(seen, self.pose[2]) > field.AREA_3_LINE
            arrived = arrived or (self.near((*field.AREA_3_GOAL, 0.0)) and self.waited > 25.0)
        if state is State.TAKE_BALL:
            arrived = arrived and bool(notes.get("close"))
            arrived = arrived and self.now - notes.setdefault("there", self.now) > GRIPS
        released = bool(notes.get("let go")) and self._held and not seen.holding
        if released and state is State.APPROACH_SILO:
            self._stored.append(self.now)
            self.sight.stored(notes["silo"], LETTERS[self.team])
        return Facts(
            waited=self.waited,
            started=self.now >= self._begins,
            over=self.now >= self._ends,
            arrived=arrived,
            in_area_3=bool(self.pose[1] > field.AREA_3_LINE - 0.45),
            reset_done=self.walls.sure and self._moved_off(state),
            lost=self.use_walls and self.walls.lost,
            blind=self.reckoning.missed > BLIND_AFTER,
            stuck=bool(stuck),
            holding=bool(seen.holding),
            ball=notes.get("approach") is not None,
            tried=self._tried,
            pushable=bool(self.sight.tracks),
            looked=bool(notes.get("looked")),
            silo=notes.get("silo") is not None,
            full=bool(notes.get("full")),
            released=released,
        )

    def _moved_off(self, state: State) -> bool:
        """Beside a silo a LiDAR is too near to its wall to measure it: first comes the way back."""
        return state is not State.RESET_AFTER_SILO or float(self.pose[0]) < 5.3

    def _enter(self, state: State) -> None:
        """Forget what the state says is to be forgotten."""
        resets, old = RESETS.get(state, ()), self.notes
        self.notes = {}
        if "choice" not in resets:
            self.notes.update({name: old[name] for name in CHOICE if name in old})
        if "balls" in resets:
            self.sight.forget_balls()
        if "pose" in resets:
            self.walls = self.walls.doubted()
        self.pushes += state is State.PUSH_PILE
        if state is State.TAKE_BALL:
            self.notes["approach"] = old.get("approach")
            self._tried += 1
        elif state not in (State.DETECT_BALL, State.REVERSE):
            self._tried = 0
        self._watch = Watch()
        self.driver.forget()
        if self.history.steps:
            self._say("info", f"{state.value}: {self.history.steps[-1].reason}")

    def _say(self, level: str, text: str) -> None:
        self.speaks.append((self.now, level, text))
        self.spoken += 1
        del self.speaks[:-SPEAKS]
