"""How well, and how fast, does the robot play?

    python benchmarks/match.py weak --seeds 200 --workers 2

``weak``      matches against a weak team, with enough balls: Mua Vang, fouls, contacts, position
``rules``     the same with no more balls than the rules allow
``strong``    orders A, B and ahead against a strong team, as a board game and, with enough balls,
              in the simulator
``faults``    each fault alone, and each pair of them
``position``  the position's error with and without set-up, LiDARs, gyroscope
``camera``    matches on drawn pictures, with the networks
``speed``     how much of a tick's 10 ms autopilot and simulator take, and whole matches

Everything is seeded: the same seeds play the same matches, on however many processes. Two orders
are compared on the same seeds, by the exact McNemar test: of the games that only one of them wins,
how often would a fair coin fall as unevenly?
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from functools import partial
from itertools import combinations
from math import comb
from multiprocessing import get_context
from time import perf_counter, process_time
from typing import NamedTuple

import numpy as np

from robocon_course.field import SEEDLINGS
from robocon_course.mission import LIMITS, STRATEGIES
from robocon_course.simulator.match import KINDS, Fault
from robocon_course.simulator.referee import MUA_VANG, OPPONENTS
from robocon_course.worlds import MatchResult, Play, play_match, season
from robocon_course.worlds.missions import board_game, board_season

Run = Callable[[Callable, list], Iterable]
LATE = 0.6
"""So much longer than its limit a state may seem to last, while the robot's clock is frozen [s]."""
FAULTS_AT = (12.0, 90.0)
"""Between these times a fault happens [s]."""
EVERY = 9.0
"""Of our balls in a board game [s]."""
ENOUGH = 24
"""Balls from Robot 1, that none is wanting."""
WHOLE = (2, 5)
"""Seeds of matches against a strong team that go the whole way."""
POSITIONS = {
    "full": {},
    "without set-up": {"set_up": False},
    "without LiDAR": {"walls": False},
    "without IMU": {"imu": False},
}
LABEL = {"A": "order A", "B": "order B", "ahead": "ahead"}


class Summary(NamedTuple):
    """Many matches in numbers.

    Attributes
    ----------
    matches : int
    won, mua_vang, clean : float
        Shares; clean: no foul, and nothing touched.
    error : float  [m]
        Root mean square of the position's error.
    at_resets : float  [m]
        Mean of the position's error when it was just measured.
    stored : float
        Balls a match.
    ended : float  [s]
        Mean.
    """

    matches: int
    won: float
    mua_vang: float
    clean: float
    error: float
    at_resets: float
    stored: float
    ended: float

    @property
    def line(self) -> str:
        """In one line."""
        return (
            f"{self.matches} matches: won {self.won:.1%}, Mua Vang {self.mua_vang:.1%}, no foul "
            f"and no contact {self.clean:.1%}, {self.stored:.1f} balls, {self.ended:.0f} s, "
            f"position {1000 * self.error:.1f} mm RMS, {1000 * self.at_resets:.1f} mm at resets"
        )


def summary(results: Sequence[MatchResult]) -> Summary:
    """What many matches have in common."""
    resets = np.concatenate([one.reset_errors for one in results])
    return Summary(
        matches=len(results),
        won=float(np.mean([one.winner == "own" for one in results])),
        mua_vang=float(np.mean([one.mua_vang for one in results])),
        clean=float(np.mean([one.fouls == 0 and one.contacts == 0 for one in results])),
        error=float(np.sqrt(np.mean([one.error**2 for one in results]))),
        at_resets=float(resets.mean()) if len(resets) else float("nan"),
        stored=float(np.mean([one.stored for one in results])),
        ended=float(np.mean([one.ended for one in results])),
    )


# --- orders -----------------------------------------------------------------------------------


def mcnemar(ones: Sequence[bool], others: Sequence[bool]) -> float:
    """Exact, one-sided: how likely a coin would favour the first at least so often.

    Only the games count that one of both wins, and not the other.
    """
    better = sum(a and not b for a, b in zip(ones, others, strict=True))
    worse = sum(b and not a for a, b in zip(ones, others, strict=True))
    count = better + worse
    return sum(comb(count, k) for k in range(better, count + 1)) / 2**count


def board_games(seeds: Iterable[int], opponent: str = "strong") -> dict[str, list[bool]]:
    """Which of the same games each order wins at once, by Mua Vang."""
    games = [board_game(np.random.default_rng([seed, 7]), opponent, EVERY) for seed in seeds]
    return {
        name: [one.winner == "own" and one.reason == MUA_VANG for one in board_season(order, games)]
        for name, order in STRATEGIES.items()
    }


def strong(seeds: Iterable[int], run: Run = map) -> dict[str, list[MatchResult]]:
    """The same matches against a strong team, with each order."""
    seeds = list(seeds)
    return {
        name: season(seeds, run=run, opponent="strong", sent=ENOUGH, strategy=name)
        for name in STRATEGIES
    }


# --- weak, position, camera --------------------------------------------------------------------


def weak(seeds: Iterable[int], run: Run = map, **settings: object) -> list[MatchResult]:
    """Matches against a weak team."""
    return season(seeds, run=run, **({"opponent": "weak", "sent": ENOUGH} | settings))


def position(seeds: Iterable[int], run: Run = map) -> dict[str, list[MatchResult]]:
    """The same matches with a sense less each."""
    seeds = list(seeds)
    return {name: season(seeds, run=run, **less) for name, less in POSITIONS.items()}


# --- faults ------------------------------------------------------------------------------------


def fault_sets() -> list[tuple[str, ...]]:
    """Each kind alone, then each two of them."""
    return [(kind,) for kind in KINDS] + list(combinations(KINDS, 2))


def play_with_faults(kinds: Sequence[str], seed: int) -> MatchResult:
    """A match in which these things go wrong, at seeded times."""
    rng = np.random.default_rng([seed, 13])
    faults = [Fault(kind, float(rng.uniform(*FAULTS_AT))) for kind in kinds]
    return play_match(seed=seed, faults=faults)


def faulty(kinds: Sequence[str], seeds: Iterable[int], run: Run = map) -> list[MatchResult]:
    """Matches with the same faults."""
    return list(run(partial(play_with_faults, tuple(kinds)), list(seeds)))


def overdue(result: MatchResult) -> list[str]:
    """States that lasted longer than their limit, in words."""
    limits = {str(state): limit for state, (limit, _) in LIMITS.items()}
    ends = [time for time, _, _ in result.history[1:]] + [result.ended]
    return [
        f"seed {result.seed}: {state} from {begin:.2f} s to {end:.2f} s"
        for (begin, state, _), end in zip(result.history, ends, strict=True)
        if end - begin > limits.get(state, np.inf) + LATE
    ]


# --- speed -------------------------------------------------------------------------------------


def speed(seed: int = 1, seconds: float = 60.0) -> dict[str, np.ndarray]:
    """How long each tick of a match takes, by who takes it [s]."""
    play = Play(seed=seed)
    play.start()
    took: dict[str, list[float]] = {"read": [], "autopilot": [], "apply and step": []}
    for _ in range(round(seconds * 100)):
        begin = perf_counter()
        seen = play.match.read()
        read = perf_counter()
        command = play.pilot.tick(seen)
        thought = perf_counter()
        play.match.apply(command)
        play.match.step()
        for name, time in zip(
            took, (read - begin, thought - read, perf_counter() - thought), strict=True
        ):
            took[name].append(time)
        if play.match.over:
            break
    return {name: np.array(times) for name, times in took.items()}


# --- printing ----------------------------------------------------------------------------------


def print_weak(seeds: list[int], run: Run, **settings: object) -> None:
    results = weak(seeds, run, **settings)
    print(summary(results).line)
    for one in results:
        if not one.mua_vang or one.fouls or one.contacts:
            print(f"  seed {one.seed}: {one.winner} by {one.reason}, {one.ended:.0f} s, "
                  f"{one.fouls} fouls, {one.contacts} contacts")  # fmt: skip


def print_strong(seeds: list[int], run: Run) -> None:
    for opponent in OPPONENTS:
        games = board_games(seeds, opponent)
        print_orders(f"board games against a {opponent} team: Mua Vang", games)
    results = strong(seeds, run)
    for what, counts in (("won", _won), ("Mua Vang", _at_once)):
        matches = {name: [counts(one) for one in played] for name, played in results.items()}
        print_orders(f"matches against a strong team: {what}", matches)


def _won(result: MatchResult) -> bool:
    return result.winner == "own"


def _at_once(result: MatchResult) -> bool:
    return result.mua_vang


def print_orders(title: str, won: dict[str, list[bool]]) -> None:
    print(f"{len(won['ahead'])} {title}")
    for name, games in won.items():
        chance = mcnemar(won["ahead"], games)
        told = "" if name == "ahead" else f", ahead is better: p = {chance:.2g}"
        print(f"  {LABEL[name]:8} {np.mean(games):.1%}{told}")


def print_faults(seeds: list[int], run: Run) -> None:
    for kinds in fault_sets():
        results = faulty(kinds, seeds, run)
        print(f"{' + '.join(kinds):18} {summary(results).line}")
        for one in results:
            for line in overdue(one):
                print(f"  too long: {line}")


def print_position(seeds: list[int], run: Run) -> None:
    for name, results in position(seeds, run).items():
        print(f"{name:16} {summary(results).line}")


def print_camera(seeds: list[int], run: Run) -> None:
    print(summary(weak(seeds, run, drawn=True)).line)


def print_speed(seeds: list[int], run: Run) -> None:
    speed(seconds=15.0)  # compiled
    for name, times in speed().items():
        middle, most = np.quantile(1e3 * times, [0.5, 0.99])
        longest = 1e3 * times.max()
        print(f"{name:16} median {middle:.3f}, 99 % under {most:.2f}, longest {longest:.1f} ms")
    for seed in WHOLE:
        begin = process_time()
        ended = play_match(seed=seed, opponent="strong").ended
        took = process_time() - begin
        print(f"a match of {ended:.0f} s: {took:.2f} s of one core, {1e3 * took / ended:.1f} ms/s")


CAMPAIGNS = {
    "weak": print_weak,
    "rules": partial(print_weak, sent=SEEDLINGS),
    "strong": print_strong,
    "faults": print_faults,
    "position": print_position,
    "camera": print_camera,
    "speed": print_speed,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("campaign", choices=CAMPAIGNS)
    parser.add_argument("--seeds", type=int, default=20, help="how many, from --first on")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1, help="processes")
    asked = parser.parse_args()
    sys.stdout.reconfigure(line_buffering=True)  # a campaign takes its time
    seeds = list(range(asked.first, asked.first + asked.seeds))
    alone = asked.workers == 1
    pool = nullcontext() if alone else ProcessPoolExecutor(
        asked.workers, mp_context=get_context("spawn")
    )  # fmt: skip
    with pool as workers:
        CAMPAIGNS[asked.campaign](seeds, map if alone else workers.map)


if __name__ == "__main__":
    main()
