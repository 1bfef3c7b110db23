"""The challenge: a strategy that plays seasons of board games."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from robocon_course import mission
from robocon_course.answers.process import Reply
from robocon_course.exercises.model import Case, Exercise, Mistake, Score
from robocon_course.mission import Rhythm
from robocon_course.mission.silos import my_strategy
from robocon_course.worlds import Student
from robocon_course.worlds.missions import BoardGame, Season, board_game, board_season, tally

GAMES = 50
Strategy = Callable[[Sequence[str], str, float, Rhythm], Any]


class _Stopped(Exception):
    """The answer failed in the middle of a game."""

    def __init__(self, reply: Reply) -> None:
        super().__init__(reply.error)
        self.reply = reply


def _play(ask: Callable[[tuple], Reply], args: tuple) -> Reply:
    """Play a season's games, asking for each ball."""

    def choose(*position: Any) -> Any:
        reply = ask(position)
        if reply.error:
            raise _Stopped(reply)
        return reply.value

    try:
        return Reply(value=tally(board_season(choose, args[0])))
    except _Stopped as stopped:
        return stopped.reply
    except ValueError as refusal:
        return Reply(error="ValueError", message=str(refusal))


def _cases(student: Student, rng: np.random.Generator) -> list[Case]:
    return [
        Case(f"season {k}", ([board_game(rng, "strong") for _ in range(GAMES)],), judge=_form)
        for k in (1, 2, 3)
    ]


def _form(reply: Reply) -> str | None:
    return f"{reply.error}: {reply.message}" if reply.error else None


def _missing(case: Case, season: Season) -> float:
    """Share of the season's points that was not won [%]."""
    games: list[BoardGame] = case.args[0]
    return 100.0 * (1.0 - season.score / len(games))


def _free(fillings: Sequence[str]) -> list[int]:
    return [k for k in range(len(fillings)) if not mission.is_full(fillings[k])]


def _by(worth: Callable[[str], float]) -> Strategy:
    """The free silo whose filling is worth most; of equals the first."""
    return lambda fillings, team, y, rhythm: max(_free(fillings), key=lambda k: worth(fillings[k]))


MY_STRATEGY = Exercise(
    id="mission.my_strategy",
    title="Challenge: a strategy for a season",
    points=4,
    reference=my_strategy,
    cases=_cases,
    time_limit=5.0,
    play=_play,
    shortcuts=(
        "robocon_course.mission.silos.choose_silo",
        "robocon_course.mission.silos._outlook",
        "robocon_course.mission.silos._chance",
    ),
    score=Score(_missing, "% of the points missing", ((34.0, 1.0), (52.0, 0.5))),
    hints=(
        "Order A fills mixed pairs as fast as it can, and wins by points. For Mua Vang three silos "
        "must become yours: what is a silo worth that is only begun?",
        "Give every filling a value: yours 1, theirs −0.6, a pair of yours more than a single "
        "ball, their pair nothing. Take the silo after which the sum over all five is greatest.",
        "Does the other team come before your next ball (rhythm.next < rhythm.every)? Put a ball "
        "of theirs where mission.order_b would, before you count. A third silo wins at once.",
        "Try it on a season of your own before you ask for the verdict: the cell below the check "
        "makes one, and games.tally(games.board_season(my_strategy, season)).score counts it.",
    ),
    mistakes=(
        Mistake(
            "order A",
            "This plays as order A: it wins by points, and seldom by Mua Vang. Think of the third "
            "ball when you place the first.",
            mission.order_a,
        ),
        Mistake(
            "spread evenly",
            "The emptiest silo gets the ball. So every silo stays open, and the other team closes "
            "them.",
            _by(lambda filling: -len(filling)),
        ),
        Mistake(
            "where you have least",
            "Every ball goes where you have fewest. Your third ball comes too late everywhere.",
            _by(lambda filling: -filling.count("R")),
        ),
        Mistake(
            "the fullest",
            "The fullest silo gets the ball, whoever's balls are in it.",
            _by(len),
        ),
        Mistake(
            "the last free silo",
            "The balls go into the last silo that is not full, whatever it holds.",
            lambda fillings, team, y, rhythm: _free(fillings)[-1],
        ),
        Mistake(
            "a full silo",
            "The balls go into silo 1 even when it is full, and roll away.",
            lambda fillings, team, y, rhythm: 0,
        ),
    ),
)
