"""What the robot does next: states, the table between them, and its three choices.

===========  ==================================================================
``table``    `Transition`, `Table`: checked when built; the first match wins
``robot``    the robot's own states, what it knows (`Facts`), and its table
``silos``    which silo to fill: two teams' orders, and a better one
``rhythm``   how often both teams come to a silo, as far as was seen
``balls``    which ball to take, and from where
``watch``    whether the robot is stuck
``plain``    guards and rooms as data
===========  ==================================================================
"""

from robocon_course.mission.balls import Approach, SeenBall, approach_from, choose_ball, is_clear
from robocon_course.mission.plain import Fact, Room
from robocon_course.mission.rhythm import Rhythm, rhythm_seen
from robocon_course.mission.robot import LIMITS, MISSION, RESETS, Facts, State, mission_table
from robocon_course.mission.silos import (
    LETTERS,
    STRATEGIES,
    after,
    choose_silo,
    is_full,
    order_a,
    order_b,
    own_and_theirs,
    owner,
    winner,
)
from robocon_course.mission.table import (
    ANY,
    History,
    MissionError,
    Step,
    Table,
    Transition,
    dead_ends,
    mermaid,
    next_transition,
    reachable,
)
from robocon_course.mission.watch import Watch, is_stuck

__all__ = [
    "ANY",
    "LETTERS",
    "LIMITS",
    "MISSION",
    "RESETS",
    "STRATEGIES",
    "Approach",
    "Fact",
    "Facts",
    "History",
    "MissionError",
    "Rhythm",
    "Room",
    "SeenBall",
    "State",
    "Step",
    "Table",
    "Transition",
    "Watch",
    "after",
    "approach_from",
    "choose_ball",
    "choose_silo",
    "dead_ends",
    "is_clear",
    "is_full",
    "is_stuck",
    "mermaid",
    "mission_table",
    "next_transition",
    "order_a",
    "order_b",
    "own_and_theirs",
    "owner",
    "reachable",
    "rhythm_seen",
    "winner",
]
