"""Gains from an oscillation, and how people get them wrong."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robocon_course import tracking
from robocon_course.exercises.model import Case, Exercise, Mistake
from robocon_course.tracking import PidGains
from robocon_course.worlds import Student


def _ziegler_nichols_cases(student: Student, rng: np.random.Generator) -> list[Case]:
    cases = []
    for kind in ("PID", "PI", "P", "PID", "PI"):
        k_cr, p_cr = round(rng.uniform(0.5, 30.0), 2), round(rng.uniform(0.1, 0.9), 3)
        cases.append(Case(f"a {kind} controller", (float(k_cr), float(p_cr), kind), "", 1e-9))
    return cases


RULES = {"P": (0.5, 0.0, 0.0), "PI": (0.45, 1.2, 0.0), "PID": (0.6, 2.0, 0.125)}


def _rule(
    *,
    rules: dict[str, tuple[float, float, float]] = RULES,
    k_i: Callable[[float, float], float] = lambda k_p, t_i: k_p / t_i,
    k_d: Callable[[float, float], float] = lambda k_p, t_d: k_p * t_d,
    period: float = 1.0,
) -> Callable[..., PidGains]:
    """The table with one of its columns wrong."""

    def function(k_cr: float, p_cr: float, kind: str) -> PidGains:
        share, resets, rate = rules[kind]
        k_p, p_cr = share * k_cr, period * p_cr
        integral = k_i(k_p, p_cr / resets) if resets else 0.0
        return PidGains(k_p, integral, k_d(k_p, rate * p_cr) if rate else 0.0)

    return function


ZIEGLER_NICHOLS = Exercise(
    id="tracking.ziegler_nichols",
    title="Gains from an oscillation",
    points=1,
    reference=tracking.ziegler_nichols,
    cases=_ziegler_nichols_cases,
    hints=(
        "The table gives k_p, T_i and T_d. The controller wants k_i = k_p / T_i and k_d = k_p T_d.",
        "A P controller has neither T_i nor T_d: k_i and k_d are 0. A PI controller has no T_d.",
        'For "PID": k_p = 0.6 k_cr, k_i = k_p / (p_cr / 2), k_d = k_p · p_cr / 8.',
    ),
    mistakes=(
        Mistake(
            "times instead of gains",
            "These are T_i and T_d themselves. The controller wants k_i = k_p / T_i and "
            "k_d = k_p · T_d.",
            _rule(k_i=lambda k_p, t_i: t_i, k_d=lambda k_p, t_d: t_d),
        ),
        Mistake(
            "k_i multiplied",
            "k_i is k_p · T_i here. A long T_i means a slow integral: divide.",
            _rule(k_i=lambda k_p, t_i: k_p * t_i),
        ),
        Mistake(
            "k_d divided",
            "k_d is k_p / T_d here. Multiply.",
            _rule(k_d=lambda k_p, t_d: k_p / t_d),
        ),
        Mistake(
            "k_p forgotten",
            "k_i is 1 / T_i and k_d is T_d here, both without k_p. That is another way to write a "
            "PID controller; ours has three gains of its own.",
            _rule(k_i=lambda k_p, t_i: 1.0 / t_i, k_d=lambda k_p, t_d: t_d),
        ),
        Mistake(
            "critical gain for k_p",
            "k_p is the critical gain itself: with that the loop never comes to rest.",
            _rule(rules={kind: (1.0, *rest) for kind, (_, *rest) in RULES.items()}),
        ),
        Mistake(
            "0.6 for every kind",
            "k_p is 0.6 k_cr for each kind. It is 0.5 for P and 0.45 for PI.",
            _rule(rules={kind: (0.6, *rest) for kind, (_, *rest) in RULES.items()}),
        ),
        Mistake(
            "always PID",
            "The kind is ignored: a P controller must not get an integral.",
            _rule(rules=dict.fromkeys(RULES, RULES["PID"])),
        ),
        Mistake(
            "T_i of a PI as of a PID",
            "T_i of a PI controller is p_cr / 1.2, not p_cr / 2.",
            _rule(rules=RULES | {"PI": (0.45, 2.0, 0.0)}),
        ),
        Mistake(
            "T_i is the whole period",
            "T_i is the whole period here. It is p_cr / 2 for PID and p_cr / 1.2 for PI.",
            _rule(rules={k: (s, bool(i) * 1.0, d) for k, (s, i, d) in RULES.items()}),
        ),
        Mistake(
            "T_d a quarter",
            "T_d is p_cr / 4 here. It is p_cr / 8.",
            _rule(rules=RULES | {"PID": (0.6, 2.0, 0.25)}),
        ),
        Mistake(
            "milliseconds",
            "The period is taken in milliseconds. Then k_i is a thousand times too small and k_d "
            "as much too large for a loop that counts seconds.",
            _rule(period=1000.0),
        ),
    ),
)
