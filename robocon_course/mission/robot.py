"""The mission of Robot 2: its states, what it knows when it decides, and the table.

Source: mission of the swerve robot of Yogyakarta State University, 2024: its states and their
order. Where its listing leads nowhere ("reverse", "silo full", "stuck", the resets) the rows below
lead on.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import StrEnum
from functools import cache
from typing import NamedTuple

from robocon_course.mission.table import ANY, Table, Transition


class State(StrEnum):
    """What Robot 2 is doing."""

    RESET = "reset"
    GO_TO_AREA_3 = "go_to_area_3"
    LIDAR_RESET = "lidar_reset"
    DETECT_BALL = "detect_ball"
    SEARCH_BALL = "search_ball"
    PUSH_PILE = "push_ball_pile"
    REVERSE = "reverse"
    TAKE_BALL = "take_ball"
    SEARCH_SILO = "search_silo"
    APPROACH_SILO = "approach_silo"
    SILO_FULL = "silo_full"
    RESET_AFTER_SILO = "reset_odometry_from_lidar"
    BACK_TO_STORAGE = "back_to_storage"
    STUCK = "stuck"
    NO_SENSORS = "no_sensors"
    FINISHED = "finished"


class Facts(NamedTuple):
    """All that the table decides by.

    Attributes
    ----------
    waited : float  [s]
        Since the state was entered.
    started, over : bool
        Whether the match runs; whether it has ended.
    arrived : bool
        At the place this state drives to.
    in_area_3 : bool
        In Area 3 or the Storage Zone, as far as the robot knows.
    reset_done : bool
        The pose was measured against walls since the state was entered.
    lost : bool
        The walls are not where the pose says, for a while.
    blind : bool
        No observation could be used, for a while.
    stuck : bool
        Told to drive, and coming nowhere.
    holding : bool
        A ball is in the gripper.
    ball : bool
        An own ball is known that can be come at.
    tried : int
        So often in a row a ball was driven to and not taken, without a look from elsewhere.
    pushable : bool
        There are balls to push apart.
    looked : bool
        Every direction was looked in.
    silo : bool
        A silo is chosen.
    full : bool
        The chosen silo is full.
    released : bool
        The ball went out over a silo in this state.
    """

    waited: float = 0.0
    started: bool = False
    over: bool = False
    arrived: bool = False
    in_area_3: bool = False
    reset_done: bool = False
    lost: bool = False
    blind: bool = False
    stuck: bool = False
    holding: bool = False
    ball: bool = False
    tried: int = 0
    pushable: bool = False
    looked: bool = False
    silo: bool = False
    full: bool = False
    released: bool = False


LOOK = 0.35
"""So long the robot looks before it decides for a ball [s]."""
MOST_TRIES = 4
"""After so many it looks from elsewhere."""
S = State
LIMITS: dict[State, tuple[float, State]] = {
    S.GO_TO_AREA_3: (40.0, S.STUCK),
    S.LIDAR_RESET: (2.5, S.BACK_TO_STORAGE),
    S.DETECT_BALL: (2.0, S.SEARCH_BALL),
    S.SEARCH_BALL: (6.0, S.PUSH_PILE),
    S.PUSH_PILE: (6.0, S.REVERSE),
    S.REVERSE: (4.0, S.DETECT_BALL),
    S.TAKE_BALL: (9.0, S.REVERSE),
    S.SEARCH_SILO: (10.0, S.SILO_FULL),
    S.APPROACH_SILO: (10.0, S.SILO_FULL),
    S.SILO_FULL: (4.0, S.SEARCH_SILO),
    S.RESET_AFTER_SILO: (1.0, S.BACK_TO_STORAGE),
    S.BACK_TO_STORAGE: (10.0, S.DETECT_BALL),
    S.STUCK: (3.0, S.LIDAR_RESET),
}
"""How long a state may last [s], and what comes then. `RESET` waits for the start,
`NO_SENSORS` for the sensors, `FINISHED` for nothing."""
RESETS: dict[State, tuple[str, ...]] = {
    S.RESET: ("balls", "choice"),
    S.LIDAR_RESET: ("pose",),
    S.REVERSE: ("balls",),
    S.SEARCH_SILO: ("choice",),
    S.SILO_FULL: ("choice",),
    S.RESET_AFTER_SILO: ("pose",),
    S.BACK_TO_STORAGE: ("balls",),
}
"""What is forgotten when a state is entered, besides its target and its path, which every state
chooses anew: where the balls were seen, which silo was chosen; ``"pose"`` is measured anew against
the walls."""


def _as_it_stands(source: State, guard: Callable[[Facts], bool], label: str) -> list[Transition]:
    """Rows that lead on to wherever the robot's situation belongs."""
    return [
        Transition(source, S.GO_TO_AREA_3, lambda f: guard(f) and not f.in_area_3,
                   f"{label}, not in Area 3 yet"),
        Transition(source, S.SEARCH_SILO, lambda f: guard(f) and f.holding,
                   f"{label}, with a ball"),
        Transition(source, S.BACK_TO_STORAGE, guard, f"{label}, without a ball"),
    ]  # fmt: skip


MISSION: tuple[Transition, ...] = (
    Transition(ANY, S.FINISHED, lambda f: f.over, "the match is over"),
    Transition(S.RESET, S.GO_TO_AREA_3, lambda f: f.started, "start"),
    Transition(ANY, S.NO_SENSORS, lambda f: f.blind and f.started, "no reading can be used"),
    *_as_it_stands(S.NO_SENSORS, lambda f: not f.blind, "readings are back"),
    *(
        Transition(state, S.LIDAR_RESET, lambda f: f.lost, "the walls are not where they should be")
        for state in S
        if state not in (S.RESET, S.LIDAR_RESET, S.NO_SENSORS, S.FINISHED)
    ),
    *(
        Transition(state, S.STUCK, lambda f: f.stuck, "coming nowhere")
        for state in (
            S.GO_TO_AREA_3, S.SEARCH_BALL, S.REVERSE, S.SEARCH_SILO, S.APPROACH_SILO, S.SILO_FULL,
            S.BACK_TO_STORAGE,
        )
    ),
    Transition(S.GO_TO_AREA_3, S.LIDAR_RESET, lambda f: f.arrived, "arrived, and the LiDAR agrees"),
    *_as_it_stands(S.LIDAR_RESET, lambda f: f.reset_done, "pose measured"),
    Transition(S.DETECT_BALL, S.SEARCH_SILO, lambda f: f.holding, "a ball is in the gripper"),
    Transition(S.DETECT_BALL, S.SEARCH_BALL, lambda f: f.tried >= MOST_TRIES, "tried too often"),
    Transition(S.DETECT_BALL, S.TAKE_BALL, lambda f: f.ball and f.waited > LOOK, "own ball seen"),
    Transition(S.DETECT_BALL, S.GO_TO_AREA_3, lambda f: not f.in_area_3, "not in Area 3"),
    Transition(S.DETECT_BALL, S.SEARCH_BALL, lambda f: f.waited > 0.5, "no own ball in sight"),
    Transition(S.SEARCH_BALL, S.SEARCH_SILO, lambda f: f.holding, "a ball is in the gripper"),
    Transition(S.SEARCH_BALL, S.TAKE_BALL, lambda f: f.ball, "own ball seen"),
    Transition(S.SEARCH_BALL, S.PUSH_PILE, lambda f: f.looked and f.pushable,
               "no own ball to come at, but others"),
    Transition(S.SEARCH_BALL, S.BACK_TO_STORAGE, lambda f: f.looked, "no ball at all"),
    Transition(S.PUSH_PILE, S.REVERSE, lambda f: f.arrived or f.stuck, "pushed"),
    Transition(S.REVERSE, S.DETECT_BALL, lambda f: f.arrived, "away from the balls"),
    Transition(S.TAKE_BALL, S.SEARCH_SILO, lambda f: f.holding, "taken"),
    Transition(S.TAKE_BALL, S.REVERSE, lambda f: f.arrived or f.stuck, "missed"),
    Transition(S.TAKE_BALL, S.DETECT_BALL, lambda f: not f.ball, "out of sight"),
    Transition(S.SEARCH_SILO, S.BACK_TO_STORAGE, lambda f: not f.holding, "the ball is lost"),
    Transition(S.SEARCH_SILO, S.APPROACH_SILO, lambda f: f.silo, "silo chosen"),
    Transition(S.APPROACH_SILO, S.RESET_AFTER_SILO, lambda f: f.released, "stored"),
    Transition(S.APPROACH_SILO, S.BACK_TO_STORAGE, lambda f: not f.holding, "the ball is lost"),
    Transition(S.APPROACH_SILO, S.SILO_FULL, lambda f: f.full, "filled meanwhile"),
    Transition(S.SILO_FULL, S.BACK_TO_STORAGE, lambda f: not f.holding, "the ball is lost"),
    Transition(S.SILO_FULL, S.SEARCH_SILO, lambda f: f.arrived, "look for another"),
    Transition(S.RESET_AFTER_SILO, S.BACK_TO_STORAGE, lambda f: f.reset_done, "pose measured"),
    Transition(S.BACK_TO_STORAGE, S.SEARCH_SILO, lambda f: f.holding, "a ball is in the gripper"),
    Transition(S.BACK_TO_STORAGE, S.TAKE_BALL, lambda f: f.ball, "own ball seen"),
    Transition(S.BACK_TO_STORAGE, S.DETECT_BALL, lambda f: f.arrived, "back"),
    *_as_it_stands(S.STUCK, lambda f: f.arrived, "free again"),
)  # fmt: skip
"""The table, in the order in which the rows are tried."""


@cache
def mission_table() -> Table:
    """The checked table of Robot 2.

    Returns
    -------
    Table
    """
    return Table(MISSION, tuple(State), State.RESET, (State.FINISHED,), limits=LIMITS)
