"""Verdicts: how results are compared, answers found, judged, kept, and shown in a notebook."""

from __future__ import annotations

import json
import linecache
import math
import textwrap
from dataclasses import replace

import nbformat
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from nbclient import NotebookClient

from robocon_course import imu
from robocon_course.answers.process import AnswerProcess, Reply
from robocon_course.answers.wire import Foreign, fields_of
from robocon_course.exercises import display, judge, registry, source
from robocon_course.exercises.compare import difference, shown
from robocon_course.exercises.model import (
    Case,
    Exercise,
    Mistake,
    Number,
    Outcome,
    Score,
    UnknownExercise,
)
from robocon_course.exercises.parts import robot_parts
from robocon_course.exercises.source import (
    assemble,
    broken_definition,
    free_names,
    from_cells,
    from_namespace,
)
from robocon_course.exercises.workspace import Workspace, WorkspaceError

EXERCISES = [e for e in registry.exercises().values() if isinstance(e, Exercise)]
NUMBERS = [e for e in registry.exercises().values() if isinstance(e, Number)]


@pytest.fixture(autouse=True)
def workspace(tmp_path, monkeypatch) -> Workspace:
    """A workspace of the test's own, so that none writes into a student's."""
    monkeypatch.setenv("ROBOCON_WORKSPACE", str(tmp_path))
    return Workspace()


# --- compare ----------------------------------------------------------------------------------

ARRAYS = hnp.arrays(
    np.float64, hnp.array_shapes(max_dims=2, max_side=4), elements=st.floats(-1e6, 1e6)
)
RESULTS = st.recursive(
    st.floats(-1e6, 1e6) | st.integers(-1000, 1000) | ARRAYS,
    lambda inner: st.tuples(inner, inner) | st.builds(imu.MahonyState, inner, inner),
    max_leaves=6,
)


@settings(deadline=None)
@given(RESULTS)
def test_a_result_does_not_differ_from_itself(value):
    assert difference(value, value, 0.0) is None


@settings(deadline=None)
@given(ARRAYS, st.data())
def test_one_entry_beyond_the_tolerance_is_found_and_its_place_named(array, data):
    place = data.draw(st.sampled_from(list(np.ndindex(array.shape))))
    other = array.copy()
    other[place] += 0.02
    assert difference(other, array, 0.03) is None
    sentence = difference(other, array, 0.01, "rad")
    assert f"at entry {list(place)}" in sentence and " rad" in sentence


STATE = imu.MahonyState(np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3))


@pytest.mark.parametrize(
    "got, expected, sentence",
    [
        (1.0, 2.0, "expected 2 m, got 1 m"),
        (None, 2.0, "the function returned nothing (None); is a return missing?"),
        ([1, 2, 3], np.array([1.0, 2.0, 3.0]), None),
        (np.ones(2), np.ones(3), "expected an array of shape (3,), got an array of shape (2,)"),
        (math.nan, math.nan, None),
        (math.nan, 1.0, "expected 1 m, got nan m"),
        ("two", 2.0, "expected a number, got a str"),
        (10**400, 2.0, "expected a number, got one too large for a float"),
        ([[1, 2], [3]], np.ones(2), "expected an array of shape (2,), got a list of 2"),
        (["1", "2"], np.ones(2), "expected an array of shape (2,), got a list of 2"),
        (1.0 + 1e-6, 1.0, "expected 1 m, got 1.000001 m"),
        (Foreign("Sly", "?"), 2.0, "expected a number, got an object of type Sly"),
        (
            {"bias": 1.0, "scale": 2.0},
            imu.AccelerometerCalibration(np.ones(3), np.ones(3)),
            "expected imu.AccelerometerCalibration(bias=…, scale=…), got a dict",
        ),
        (
            imu.GyroCalibration(1.5 * np.ones(3), np.ones(3)),
            imu.GyroCalibration(np.ones(3), np.ones(3)),
            "bias: expected 1 m, got 1.5 m",
        ),
        (
            (np.ones(2), np.zeros(2)),
            (np.ones(2), np.ones(2)),
            "result 2 of 2: expected 1 m, got 0 m at entry",
        ),
        (np.array(3.0), (np.ones(2), np.ones(2)), "expected 2 results, got a number"),
        (STATE, STATE._replace(integral=np.ones(3)), "integral: expected 1 m, got 0 m at entry"),
        (tuple(STATE), STATE, "expected imu.MahonyState(quaternion=…, integral=…), got a tuple"),
        (True, "left", "expected 'left', got True"),
        (False, False, None),
    ],
)
def test_the_sentence_says_what_differs(got, expected, sentence):
    found = difference(got, expected, 1e-9, "m")
    assert found is None if sentence is None else found.startswith(sentence)


def test_a_value_is_shown_as_a_student_would_write_it():
    assert shown(np.array([0.123456, 2.0])) == "[0.1235, 2.    ]"
    assert shown((1.0, Foreign("Sly", "?"))) == "(1., Sly object)"
    assert shown(imu.MahonyState(1.0, 2.0)) == "quaternion = 1., integral = 2."
    assert shown(np.zeros((20, 3))) == "array of shape (20, 3), first row [0., 0., 0.]"


ODD = [
    10**400,
    True,
    "x",
    b"x",
    [],
    {},
    (None, None),
    [[1, 2], [3]],
    {"bias": "x"},
    math.nan,
    math.inf,
    np.array(3.0),
    np.array([]),
    np.zeros((5, 4)),
    np.full((4000, 4), 1e200),
    (np.zeros(4), np.zeros(3)),
    (np.zeros(4), np.zeros(3), 1),
    Foreign("Sly", "?"),
]


@pytest.mark.parametrize("exercise", EXERCISES, ids=lambda e: e.id)
def test_whatever_a_function_returns_gets_a_verdict_and_no_points(exercise):
    for value in ODD:
        verdict = judge.judge(exercise, lambda args, value=value: Reply(value=value))
        assert verdict.points == 0.0 and verdict.outcome in (Outcome.WRONG, Outcome.ERROR), value
        assert verdict.message in repr(display.shown_verdict(verdict))
        display.show_finding(replace(verdict, finding=None))


@pytest.mark.parametrize("exercise", EXERCISES, ids=lambda e: e.id)
def test_a_result_of_the_right_form_without_meaning_gets_no_points(exercise):
    def emptied(value):
        if isinstance(value, tuple | list):
            parts = [emptied(part) for part in value]
            return type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
        if isinstance(value, str | set):
            return type(value)()
        return None if value is None else np.asarray(value) * 0.0

    def ask(args):
        try:
            right = exercise.reference(*args)
        except ValueError:
            return Reply(error="ValueError")
        fields = fields_of(right)
        if fields is None:
            return Reply(value=emptied(right))
        empty = {name: emptied(value) for name, value in fields.items()}
        try:
            return Reply(value=type(right)(**empty))
        except ValueError:  # wheels of no size: an answer that makes them raises
            return Reply(error="ValueError")

    assert judge.judge(exercise, ask).points == 0.0


@pytest.mark.parametrize("number", NUMBERS, ids=lambda e: e.id)
@pytest.mark.parametrize("value", [*ODD, [1.0], np.ones(2), "", math.nan, -math.inf])
def test_whatever_is_handed_in_as_a_number_gets_a_verdict_and_no_points(number, value):
    verdict = judge.judge_number(number, value)
    assert (verdict.points, verdict.accepted) == (0.0, False)


# --- judge ------------------------------------------------------------------------------------


def double(number: float) -> float:
    """Twice a number; not one below zero."""
    if number < 0:
        raise ValueError("below zero")
    return 2 * number


def refuses(reply: Reply) -> str | None:
    """A judge for the case that must be refused."""
    return None if reply.error == "ValueError" else "it was not refused"


def toy_cases(student: int, rng: np.random.Generator) -> list[Case]:
    """Two numbers everybody gets, one of one's own, and one to refuse."""
    own = Case("a number of your own", (float(rng.uniform(2, 9)),), "m", 1e-9)
    fixed = [Case("zero", (0.0,), "m", 1e-9), Case("one", (1.0,), "m", 1e-9)]
    return [*fixed, own, Case("below zero", (-1.0,), judge=refuses)]


class Toy(Exercise):
    """An exercise whose reference lies here, where an answer's process cannot reach it."""

    blocked = ()


TOY = Toy(
    id="toy.double",
    title="Twice",
    points=2,
    reference=double,
    cases=toy_cases,
    time_limit=2.0,
    mistakes=(Mistake("squared", "This is the square.", lambda x: x * x if x >= 0 else double(x)),),
    hints=("Add it to itself.",),
)


def judged(body: str, exercise: Exercise = TOY, student: int = 0):
    """The verdict on ``def double(x): <body>``, judged in a process as a student's is."""
    text = f"def {exercise.function_name}(x):\n{textwrap.indent(body, '    ')}\n"
    with AnswerProcess() as process:
        return judge.judge_answer(
            process, exercise, source.Answer(exercise.function_name, text), student
        )


RIGHT = "if x < 0:\n    raise ValueError\nreturn x + x"


def test_a_right_answer_passes_with_full_points():
    verdict = judged(RIGHT)
    assert verdict.outcome is Outcome.PASSED and verdict.points == 2
    assert verdict.line == "✔ passed: toy.double, 2 of 2 points"
    assert verdict.cases == (4, 4)


def test_a_wrong_answer_shows_the_first_case_that_failed():
    verdict = judged("return x + 1")
    assert verdict.outcome is Outcome.WRONG and verdict.points == 0
    assert verdict.message == "In the case “zero”: expected 0 m, got 1 m."
    assert (verdict.finding.case.what, verdict.finding.got, verdict.finding.expected) == (
        "zero",
        1.0,
        0.0,
    )
    assert verdict.cases == (1, 4)


def test_an_answer_that_behaves_like_a_known_mistake_is_told_its_name():
    verdict = judged("if x < 0:\n    raise ValueError\nreturn x ** 2")
    assert verdict.mistake == "squared"
    assert verdict.message.endswith("This is the square.")


def test_an_answer_with_a_second_fault_is_not_taken_for_the_mistake():
    assert judged("return x ** 2").mistake == ""


def test_a_case_that_must_be_refused_fails_an_answer_that_does_not():
    verdict = judged("return x + x")
    assert verdict.message == "In the case “below zero”: it was not refused."


def test_an_empty_frame_is_not_attempted():
    verdict = judged("raise NotImplementedError('not solved yet')")
    assert verdict.outcome is Outcome.NOT_ATTEMPTED


def test_an_exception_is_an_error_with_its_line():
    verdict = judged("y = x\nreturn y.real_part")
    assert verdict.outcome is Outcome.ERROR
    assert "AttributeError" in verdict.message
    assert verdict.message.endswith("It came from the line: return y.real_part")


def test_an_endless_loop_is_an_error_that_says_how_long_it_ran():
    verdict = judged("while x == x: pass", replace(TOY, time_limit=0.5))
    assert verdict.outcome is Outcome.ERROR
    assert "stopped after 0.5 s. Does a loop never end" in verdict.message


def test_a_missing_name_is_named_before_anything_runs():
    answer = source.Answer("double", "def double(x): return x * factor", ("factor",))
    with AnswerProcess() as process:
        verdict = judge.judge_answer(process, TOY, answer, 0)
    assert verdict.outcome is Outcome.ERROR
    assert verdict.message.startswith("double uses factor, which it is not given.")


def test_a_module_that_was_never_imported_is_named_with_the_line_to_write():
    answer = source.Answer("double", "def double(x): return math.fabs(x)", ("math",))
    with AnswerProcess() as process:
        verdict = judge.judge_answer(process, TOY, answer, 0)
    assert "Write import math above the function" in verdict.message


def test_a_name_that_a_room_of_the_course_has_is_told_with_its_room():
    answer = source.Answer("module_targets", "def module_targets(): return REST", ("REST",))
    with AnswerProcess() as process:
        verdict = judge.judge_answer(process, registry.exercise("swerve.module_targets"), answer, 0)
    assert verdict.message.endswith("Write swerve.REST.")
    answer = source.Answer("wrap_angle", "def wrap_angle(angle): return half", ("half",))
    with AnswerProcess() as process:
        verdict = judge.judge_answer(process, registry.exercise("start.wrap_angle"), answer, 0)
    assert "In the robot there is no notebook" in verdict.message


def test_of_two_definitions_in_a_cell_the_last_one_counts(lab):
    wrong = "def wrap_angle(angle):\n    return angle\n"
    assert "✘ wrong" in lab.run(f"{WRAP}\n\n{wrong}") + lab.run(CHECK)
    assert "✔ passed" in lab.run(f"{wrong}\n\n{WRAP}") + lab.run(CHECK)


def test_a_unit_for_each_column_is_named_where_it_belongs():
    expected, got = np.zeros((4, 3)), np.zeros((4, 3))
    got[2, 1], got[3, 2] = 0.5, 0.25
    assert "expected 0 m/s, got 0.5 m/s" in difference(got, expected, 1e-9, "m, m/s, rad")
    got[2, 1] = 0.0
    assert "expected 0 rad, got 0.25 rad" in difference(got, expected, 1e-9, "m, m/s, rad")


def test_counts_are_printed_whole_and_the_dust_of_rounding_as_zero():
    assert "expected 10 counts, got -65526 counts" in difference(-65526, 10, 0.5, "counts")
    assert "expected 0 m, got 0.5 m" in difference(0.5, 6.1e-17, 1e-9, "m")


def test_what_a_wrong_answer_printed_is_shown():
    verdict = judged("print('x is', x)\nreturn x")
    assert "Your function printed: x is 0.0" in repr(display.shown_verdict(verdict))


def test_an_object_equal_to_everything_is_not_the_right_answer():
    sly = "class Sly:\n    def __eq__(self, other): return True\nreturn Sly()"
    assert judged(sly).message.endswith("expected a number, got an object of type Sly.")


def test_an_answer_that_overwrites_its_input_does_not_move_the_truth():
    def reference(array: np.ndarray) -> np.ndarray:
        return array + 1

    def overwrite(array: np.ndarray) -> np.ndarray:
        array += 1
        return array

    exercise = replace(
        TOY, reference=reference, cases=lambda s, rng: [Case("ones", (np.ones(3),))], mistakes=()
    )
    assert judge.judge(exercise, judge.ask_function(overwrite)).accepted


def test_cases_are_the_same_for_one_student_and_purpose_and_other_for_another():
    asked: dict[tuple, list] = {}
    for key in ((1, "public"), (1, "graded"), (2, "public"), (1, "public")):
        inputs: list = []

        def ask(args, inputs=inputs):
            inputs.append(args)
            return judge.ask_function(double)(args)

        judge.judge(TOY, ask, *key)
        assert asked.setdefault(key, inputs) == inputs
    assert len({inputs[2] for inputs in asked.values()}) == 3


CHALLENGE = replace(
    TOY,
    cases=lambda student, rng: [Case("near", (1.0,)), Case("far", (2.0,))],
    score=Score(lambda case, value: abs(value - 2 * case.args[0]), "m", ((0.1, 1.0), (0.5, 0.25))),
    mistakes=(Mistake("unchanged", "That is the number as it came.", lambda x: x),),
)


@pytest.mark.parametrize(
    "answer, points, outcome",
    [
        (lambda x: 2 * x + 0.1 * (x - 1), 2.0, Outcome.PASSED),
        (lambda x: 2 * x + 0.2 * (x - 1), 0.5, Outcome.PASSED),
        (lambda x: 2 * x + 0.6 * (x - 1), 0.0, Outcome.WRONG),
        (lambda x: math.nan, 0.0, Outcome.WRONG),
        (lambda x: [x, x], 0.0, Outcome.WRONG),
        (lambda x: 1 / 0, 0.0, Outcome.ERROR),
    ],
)
def test_a_challenge_is_marked_by_its_worst_case(answer, points, outcome):
    verdict = judge.judge(CHALLENGE, judge.ask_function(answer))
    assert (verdict.points, verdict.outcome) == (points, outcome)


def test_a_challenge_says_how_far_it_is_and_which_known_way_was_taken():
    verdict = judge.judge(CHALLENGE, judge.ask_function(lambda x: x))
    assert verdict.mistake == "unchanged"
    assert verdict.message.startswith("Worst case 2 m; at most 0.1 earns all points.")


def test_a_challenge_answered_with_what_its_measure_refuses_is_wrong():
    def refuse(case, value):
        raise ValueError("no such thing")

    challenge = replace(CHALLENGE, score=replace(CHALLENGE.score, error=refuse))
    verdict = judge.judge(challenge, judge.ask_function(double))
    assert verdict.outcome is Outcome.WRONG and "no such thing" in verdict.message


def test_a_challenge_whose_measure_is_no_number_in_one_case_earns_nothing():
    def error(case, value):
        return math.nan if case.what == "far" else 0.0

    challenge = replace(CHALLENGE, score=replace(CHALLENGE.score, error=error))
    assert judge.judge(challenge, judge.ask_function(double)).points == 0.0


NUMBER = Number(
    id="toy.length",
    title="A length",
    points=1,
    truth=lambda student: 2.0 + student,
    tolerance=0.1,
    unit="m",
    mistakes=(Mistake("in mm", "That is in mm.", lambda student: 1000 * (2.0 + student)),),
    hints=("Measure.",),
)


@pytest.mark.parametrize(
    "value, student, outcome, mistake",
    [
        (2.05, 0, Outcome.PASSED, ""),
        (2.15, 0, Outcome.WRONG, ""),
        (2.05, 1, Outcome.WRONG, ""),
        (2000.0, 0, Outcome.WRONG, "in mm"),
        (np.float64(3.0), 1, Outcome.PASSED, ""),
        (..., 0, Outcome.NOT_ATTEMPTED, ""),
        (None, 0, Outcome.NOT_ATTEMPTED, ""),
        ([2.0], 0, Outcome.ERROR, ""),
        (math.inf, 0, Outcome.ERROR, ""),
        (10**400, 0, Outcome.ERROR, ""),
    ],
)
def test_a_number_is_measured_against_the_students_own_world(value, student, outcome, mistake):
    verdict = judge.judge_number(NUMBER, value, student)
    assert (verdict.outcome, verdict.mistake) == (outcome, mistake)
    assert verdict.points == (1 if outcome is Outcome.PASSED else 0)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(UnknownExercise, match=r"did you mean 'imu\.mahony_step'"):
        registry.exercise("imu.mahony")
    with pytest.raises(UnknownExercise, match="there are 00_start, 01_imu"):
        registry.chapter("99")


# --- source: from a notebook to a text that runs on its own -----------------------------------

HALF = "def f(x):\n    return x / 2"
NOTEBOOKS = {
    "one function": [HALF],
    "the last definition counts": ["def f(x):\n    return x", HALF],
    "the same cell twice": [HALF, HALF],
    "a helper and its helper": [
        "def h(x):\n    return g(x)\ndef g(x):\n    return x / 2",
        "def f(x):\n    return h(x)",
    ],
    "two that call each other": [
        "def f(x, n=3):\n    return g(x, n) if n else x / 2",
        "def g(x, n):\n    return f(x, n - 1)",
    ],
    "an import, once and under another name": [
        "import math, numpy as np\nfrom math import sqrt as root",
        "def f(x):\n    return np.float64(root(x * x)) * math.cos(math.pi / 3)",
    ],
    "constants": [
        "A, B = 1, 2\nC: float = 0.5\nD = [1, 2]\nE = A / B",
        "def f(x):\n    return (x * E + x * C) * A / D[1]",
    ],
    "a constant worked out from an import": [
        "import math\nHALF = math.sin(math.pi / 6)",
        "def f(x):\n    return x * HALF",
    ],
    "a constant array": [
        "import numpy as np\nWEIGHTS = np.array([0.25, 0.25])",
        "def f(x):\n    return float(x * WEIGHTS.sum())",
    ],
    "a constant without end": ["FAR = float('inf')", "def f(x):\n    return min(x / 2, FAR)"],
    "a default value": ["HALF = 0.5\ndef f(x, factor=HALF):\n    return x * factor"],
    "a class": [
        "class Halver:\n    def __call__(self, x):\n        return x / 2",
        "def f(x):\n    return Halver()(x)",
    ],
    "a data class": [
        "from dataclasses import dataclass\n@dataclass\nclass Halver:\n    by: float = 2.0",
        "def f(x):\n    return x / Halver().by",
    ],
    "a decorator of one's own": [
        "import functools\ndef halved(g):\n    @functools.wraps(g)\n    def inner(x):\n"
        "        return g(x) / 2\n    return inner",
        "@halved\ndef f(x):\n    return x",
    ],
    "a cache": ["import functools\n@functools.lru_cache\ndef f(x):\n    return x / 2"],
    "a lambda": ["f = lambda x: x / 2"],
    "another name": ["def half(x):\n    return x / 2\nf = half"],
    "a comprehension and an inner function": [
        "def f(x):\n    def g(y):\n        return y / 2\n    return sum(g(z) for z in [x])"
    ],
    "magics around it": ["%time 1\n!echo hello\n" + HALF],
    "a broken cell after it": [HALF, "def g(:"],
    "a future import": [
        "from __future__ import annotations\ndef f(x: Later) -> Later:\n    return x / 2"
    ],
}


def live(cells: list[str]) -> dict:
    """The namespace of a notebook that ran these cells."""
    namespace: dict = {"__name__": "__main__", "In": [""]}
    for number, cell in enumerate(cells):
        code = source.plain_code(cell)
        namespace["In"].append(cell)
        name = f"<test cell {number} {hash(cell)}>"
        linecache.cache[name] = (len(code), None, code.splitlines(True), name)
        try:
            exec(compile(code, name, "exec"), namespace)
        except SyntaxError:
            continue
    return namespace


@pytest.mark.parametrize("cells", NOTEBOOKS.values(), ids=NOTEBOOKS)
@pytest.mark.parametrize("rules", ["live", "file"])
def test_an_answer_is_found_with_all_it_needs_in_a_live_notebook_and_in_a_file(cells, rules):
    lookup = from_namespace(live(cells)) if rules == "live" else from_cells(cells)
    answer = assemble("f", lookup)
    assert answer.missing == ()
    with AnswerProcess() as process:
        assert process.load(answer.text).error == ""
        assert process.call("f", (3.0,)).value == pytest.approx(1.5)
    Workspace().accept("toy.f", answer.text)
    assert Workspace().part("toy.f")(3.0) == pytest.approx(1.5)


STRAY = {
    "a variable": ["factor = 0.5", "def f(x):\n    return x * factor", "factor"],
    "a variable of a helper": ["k = 2\ndef g(x): return x / k", "def f(x): return g(x)", "k"],
    "a name that is nowhere": ["", "def f(x):\n    return wrap(x)", "wrap"],
}


@pytest.mark.parametrize("cells", STRAY.values(), ids=STRAY)
@pytest.mark.parametrize("rules", ["live", "file"])
def test_a_function_that_leans_on_the_notebook_is_told_which_name_it_misses(cells, rules):
    *cells, name = cells
    lookup = from_namespace(live(cells)) if rules == "live" else from_cells(cells)
    assert assemble("f", lookup).missing == (name,)


@pytest.mark.parametrize(
    "cells",
    [
        [],
        ["g = 3"],
        ["def f(x"],
        ["def f(x): break"],
        ["def f(x, x): return x"],
        ["%%writefile f.py\ndef f(x): return x"],
        ["f = check('toy.f')"],
        ["def f(x): return " + "-" * 50_000 + "x"],
        ["def f(x): return " + "+".join("x" * 20_000)],
        ["def f(x):\0"],
    ],
    ids=lambda cells: repr(cells)[:30],
)
def test_what_defines_nothing_is_nothing_and_does_not_raise(cells):
    assert assemble("f", from_cells(cells)) is None


def test_only_the_newest_cell_with_a_definition_is_asked_whether_it_is_broken():
    assert broken_definition("f", ["def f(x", "def f(x): return x"]) == ""
    said = broken_definition("f", ["def f(x): return x", "x = 1\ndef f(x)\n    return x"])
    assert said == "The cell with def f has a SyntaxError in line 2: def f(x)"
    assert broken_definition("f", ["def ff(x", "def g(x"]) == ""
    assert "cannot be read" in broken_definition("f", ["def f(x): " + "-" * 50_000 + "1"])


def test_free_names_are_those_from_outside():
    text = "def f(x, y=K):\n    z = [g(i) for i in x]\n    return len(z) + h(z) + f(x)"
    assert sorted(free_names(text)) == ["K", "g", "h", "len"]


# --- workspace --------------------------------------------------------------------------------

HELPER = "def half(x):\n    return x / 2"


def version(name: str, *helpers: str, body: str = "return half(x)") -> str:
    """An accepted text as ``assemble`` writes it."""
    blocks = ["from __future__ import annotations", "import math", *helpers]
    return "\n\n".join([*blocks, f"def {name}(x):\n    {body}"]) + "\n"


def test_every_accepted_version_is_kept_and_the_newest_is_in_use(workspace):
    texts = [version("one", body=f"return {k}") for k in range(3)]
    assert [workspace.accept("toy.one", text) for text in texts] == [1, 2, 3]
    assert [path.read_text() for path in workspace.versions("toy.one")] == texts
    assert workspace.part("toy.one")(0) == 2
    assert workspace.in_use() == {"toy.one": 3}


def test_accepting_the_same_text_again_makes_no_new_version(workspace):
    text = version("one", body="return 1")
    assert [workspace.accept("toy.one", text) for _ in range(2)] == [1, 1]


def test_an_earlier_version_comes_back(workspace):
    for k in range(3):
        workspace.accept("toy.one", version("one", body=f"return {k}"))
    workspace.use("toy.one", 2)
    assert workspace.part("toy.one")(0) == 1
    with pytest.raises(WorkspaceError, match="no version 4; my_robot/ holds versions 1 to 3"):
        workspace.use("toy.one", 4)
    with pytest.raises(WorkspaceError, match="no accepted version"):
        workspace.use("toy.two", 1)


def test_parts_of_one_chapter_share_a_file_and_their_helper_stands_once(workspace):
    workspace.accept("toy.one", version("one", HELPER))
    workspace.accept("toy.two", version("two", HELPER))
    text = (workspace.robot / "toy.py").read_text()
    assert (text.count("def half"), text.count("import math")) == (1, 1)
    assert workspace.part("toy.one")(3) == workspace.part("toy.two")(3) == 1.5


def test_a_helper_that_another_part_defines_differently_is_named(workspace):
    workspace.accept("toy.one", version("one", HELPER))
    other = version("two", HELPER.replace("/ 2", "* 0.5"))
    assert workspace.clash("toy.two", other) == "half (also used by toy.one)"
    assert workspace.clash("toy.two", version("two", HELPER)) == ""
    assert workspace.clash("toy.one", version("one", HELPER.replace("/ 2", "* 0.5"))) == ""


def test_a_part_improves_after_another_that_calls_it_was_accepted(workspace):
    first, second = version("half", body="return x / 2"), version("half", body="return 0.5 * x")
    workspace.accept("toy.half", first)
    workspace.accept("toy.one", version("one", "def half(x):\n    return x / 2"))
    assert workspace.clash("toy.half", second) == ""
    workspace.accept("toy.half", second)
    assert workspace.clash("toy.one", version("one", "def half(x):\n    return 0.5 * x")) == ""
    text = (workspace.robot / "toy.py").read_text()
    assert "0.5 * x" in text and "x / 2" not in text
    assert workspace.part("toy.one")(3) == 1.5


def test_a_damaged_file_says_how_to_bring_the_part_back(workspace):
    workspace.accept("toy.one", version("one", body="return 1"))
    (workspace.robot / "toy.py").write_text("def one(:")
    with pytest.raises(WorkspaceError, match=r"robocon reset --part toy\.one"):
        workspace.part("toy.one")
    workspace.use("toy.one", 1)
    assert workspace.part("toy.one")(0) == 1


DAMAGED = ("", "{", "[1]", "\x00", '{"points": []}', '{"in_use": {"a": "b"}}', '{"student": 1.5}')


@pytest.mark.parametrize("text", DAMAGED)
def test_a_damaged_record_is_set_aside_and_the_parts_stay_in_use(workspace, text):
    workspace.remember(student=7)
    assert Workspace().student == 7
    for version in ("def double(x):\n    return 2 * x\n", "def double(x):\n    return x + x\n"):
        workspace.accept("toy.double", version)
    (workspace.robot / "record.json").write_text(text)
    with pytest.warns(UserWarning, match=r"kept as record\.damaged-1\.json"):
        assert workspace.student == 0
    assert (workspace.robot / "record.damaged-1.json").read_text() == text
    assert workspace.in_use() == {"toy.double": 2}


def verdict_of(points: float):
    """A verdict on the toy exercise."""
    outcome = Outcome.PASSED if points else Outcome.WRONG
    return replace(judge.no_answer(TOY, ""), outcome=outcome, points=points)


def test_the_best_points_are_kept_and_nothing_else_unasked(workspace):
    for points in (0.0, 2.0, 1.0):
        workspace.note(verdict_of(points))
    assert workspace.record == {"points": {"toy.double": 2.0}}


def test_attempts_are_logged_only_where_a_student_asked_for_it(workspace):
    log = workspace.robot / "attempts.jsonl"
    workspace.note(verdict_of(0.0))
    assert not log.exists()
    workspace.remember(log=True)
    workspace.note(verdict_of(0.0))
    workspace.note(verdict_of(2.0))
    line = log.read_text().splitlines()[1]
    entry = json.loads(line)
    assert (entry["id"], entry["outcome"], entry["attempt"]) == ("toy.double", "passed", 2)
    assert set(entry) == {"id", "outcome", "mistake", "attempt", "time"}


def test_mine_reference_and_mixed_name_whose_parts_they_are(workspace):
    assert robot_parts("reference").label == robot_parts().label == "reference"
    with pytest.raises(WorkspaceError, match="not accepted yet: wrap_angle"):
        robot_parts("mine")
    workspace.accept("start.wrap_angle", version("wrap_angle", body="return 42"))
    assert robot_parts().wrap_angle(0) == 42
    assert robot_parts().label.startswith("mixed") and robot_parts().mine == ("wrap_angle",)
    assert robot_parts("reference").wrap_angle(0) == 0
    with pytest.raises(ValueError, match="which: expected"):
        robot_parts("yours")


# --- in a notebook ----------------------------------------------------------------------------


class Notebook:
    """A live kernel: ``run`` executes a cell and returns the text a student sees."""

    def __init__(self, client: NotebookClient) -> None:
        self.client = client
        self.outputs: list = []

    def run(self, code: str) -> str:
        """What the cell printed, displayed or raised."""
        cell = nbformat.v4.new_code_cell(textwrap.dedent(code))
        self.client.nb.cells.append(cell)
        self.client.execute_cell(cell, len(self.client.nb.cells) - 1)
        self.outputs = cell.outputs
        return "\n".join(map(self._text, cell.outputs))

    @staticmethod
    def _text(output) -> str:
        if output.output_type == "stream":
            return output.text
        if output.output_type == "error":
            return f"{output.ename}: {output.evalue}"
        return output.data.get("text/plain", "")


@pytest.fixture(scope="module")
def kernel():
    """One kernel for all tests of this file."""
    client = NotebookClient(nbformat.v4.new_notebook(), kernel_name="python3", allow_errors=True)
    with client.setup_kernel():
        yield Notebook(client)


HEAD = """
import math
import os
import numpy as np
from robocon_course import geometry, imu
from robocon_course.exercises import answer, begin, check, hint, notebook, robot_parts, status
notebook._last.clear()
"""
WRAP = "def wrap_angle(angle):\n    return (angle + math.pi) % (2 * math.pi) - math.pi"
CHECK = "wrap_angle = check('start.wrap_angle')"


@pytest.fixture
def lab(kernel, tmp_path) -> Notebook:
    """A notebook that has run nothing but its first cell."""
    kernel.run("get_ipython().reset(new_session=True)")
    kernel.run(f"{HEAD}os.environ['ROBOCON_WORKSPACE'] = {str(tmp_path)!r}")
    return kernel


def test_an_accepted_function_becomes_part_of_the_robot(lab, workspace):
    lab.run(WRAP)
    said = lab.run(CHECK)
    assert said.startswith("✔ passed: start.wrap_angle, 1 of 1 points")
    assert "my_robot/start.py, version 1" in said
    assert workspace.part("start.wrap_angle")(4.0) == pytest.approx(4.0 - 2 * math.pi)
    assert "__main__" in lab.run("wrap_angle.__module__")
    assert "wrap_angle" in lab.run("robot_parts().mine")


def test_a_wrong_function_is_told_its_mistake_and_the_notebook_goes_on(lab, workspace):
    lab.run("def wrap_angle(angle):\n    return angle % (2 * math.pi)")
    said = lab.run(CHECK)
    assert said.startswith("✘ wrong: start.wrap_angle, 0 of 1 points")
    assert "This counts from 0 to 2π" in said
    assert "robocon_course.geometry" in lab.run("wrap_angle.__module__")
    assert workspace.in_use() == {}


def test_a_counter_example_is_drawn_with_a_text_twin(lab):
    lab.run("def gravity_direction(quaternion):\n    return np.array([0.0, 0.0, -1.0])")
    said = lab.run("gravity_direction = check('imu.gravity_direction')")
    pictures = [o for o in lab.outputs if "image/png" in o.get("data", {})]
    [alt] = [o.metadata["image/png"]["alt"] for o in pictures]
    assert alt.startswith("What came beside what was expected, level: expected 1, got -1")
    assert alt in said


def test_a_verdict_is_a_box_with_words_and_not_colour_alone(lab):
    lab.run("def wrap_angle(angle):\n    return '<b>'")
    lab.run(CHECK)
    [html] = [o.data["text/html"] for o in lab.outputs if "text/html" in o.get("data", {})]
    assert "✘ wrong" in html and 'role="status"' in html


@pytest.mark.parametrize(
    "cell, said",
    [
        ("", "There is no function wrap_angle in this notebook yet."),
        ("wrap_angle = 3", "wrap_angle is not a function defined in a cell"),
        ("from math import sin as wrap_angle", "✘ wrong"),
        ("def wrap_angle(angle)\n    return angle", "has a SyntaxError in line 1: def wrap_angle("),
        ("def wrap_angle(angle):\n    return angle * factor", "wrap_angle uses factor, which it"),
        ("def wrap_angle(angle):\n    raise NotImplementedError", "– not attempted"),
        ("def wrap_angle(angle):\n    return 1 / 0", "It came from the line: return 1 / 0"),
        ("def wrap_angle(angle):\n    print('seen', angle)", "Your function printed: seen 1.57"),
        ("def wrap_angle(a):\n    return geometry.wrap_angle(a)", "This calls the course's own"),
        ("def wrap_angle(angle):\n    while True: pass", "stopped after 2 s. Does a loop never"),
        ("def wrap_angle(angle):\n    os._exit(0)", "the process that ran your code ended"),
    ],
)
def test_whatever_stands_in_the_cell_the_check_says_what_is_the_matter(lab, cell, said):
    lab.run(cell)
    shown = lab.run(CHECK)
    assert said in shown and "✔" not in shown
    assert "-3.1" in lab.run("wrap_angle(math.pi)"), "the course's function takes over"


def test_a_function_survives_a_syntax_error_in_a_later_version_of_its_cell(lab):
    lab.run(WRAP)
    lab.run("def wrap_angle(angle:\n    return angle")
    assert "has a SyntaxError" in lab.run(CHECK)
    lab.run(WRAP)
    assert "✔" in lab.run(CHECK)


def test_checking_again_judges_the_students_own_and_not_the_reference_in_its_place(lab):
    lab.run("def wrap_angle(angle):\n    return angle")
    assert "✘" in lab.run(CHECK)
    assert "✘" in lab.run(CHECK)


def test_a_compiled_function_is_found_with_its_decorator(lab):
    lab.run(f"from numba import njit\n@njit\n{WRAP}")
    text = lab.run("notebook.assemble('wrap_angle', notebook.from_namespace(globals())).text")
    assert "@njit" in text and "from numba" in text


def test_practice_shows_a_verdict_and_keeps_nothing(lab, workspace):
    lab.run(WRAP)
    said = lab.run("wrap_angle = check('start.wrap_angle', practice=True)")
    assert "✔ passed" in said and "Practice: nothing was noted." in said
    assert not workspace.robot.exists()
    assert "robocon_course.geometry" in lab.run("wrap_angle.__module__")


def test_a_changed_helper_is_not_written_over_the_one_in_use(lab, workspace):
    lab.run("def unit(q):\n    return q / np.linalg.norm(q)")
    lab.run(
        """
        def gravity_direction(quaternion):
            w, x, y, z = unit(quaternion)
            return np.array([2*(x*z - w*y), 2*(w*x + y*z), w*w - x*x - y*y + z*z])

        def euler_angles(quaternion):
            w, x, y, z = unit(quaternion)
            pitch = np.arcsin(np.clip(2*(w*y - x*z), -1, 1))
            roll = np.arctan2(2*(w*x + y*z), 1 - 2*(x*x + y*y))
            return np.array([roll, pitch, np.arctan2(2*(w*z + x*y), 1 - 2*(y*y + z*z))])
        """
    )
    assert "version 1" in lab.run("check('imu.gravity_direction');")
    lab.run("def unit(q):\n    return q / np.sqrt(q @ q)")
    said = lab.run("check('imu.euler_angles');")
    assert "✔ passed" in said and "your helper unit (also used by imu.gravity_direction)" in said
    assert workspace.in_use() == {"imu.gravity_direction": 1}


def test_hints_grow_and_end(lab):
    assert "Hint 1 of 3" in lab.run("hint('start.wrap_angle')")
    assert "Hint 3 of 3" in lab.run("hint('start.wrap_angle', 3)")
    assert "The last hint." in lab.run("hint('start.wrap_angle', 99)")


def test_a_number_of_ones_own_is_judged_in_ones_own_world(lab, workspace):
    assert "Student number 7. Log of attempts: off." in lab.run("student = begin('imu', 7)")
    truth = registry.exercise("imu.own_bias").truth
    assert "– not attempted" in lab.run("answer('imu.own_bias', ...)")
    assert "✘ wrong" in lab.run(f"answer('imu.own_bias', {truth(8)})")
    assert "✔ passed" in lab.run(f"answer('imu.own_bias', {truth(7)})")
    assert workspace.student == 7 and workspace.record["points"] == {"imu.own_bias": 1}


def test_begin_says_where_the_log_lies_and_the_number_is_remembered(lab):
    assert "kept in my_robot/attempts.jsonl" in lab.run("begin('imu', student=9, log=True);")
    assert "Student number 9." in lab.run("begin('start');")


def test_status_tells_the_points_the_parts_and_what_comes_next(lab):
    assert "Next: start.wrap_angle in 00_start.ipynb" in lab.run("status()")
    lab.run(f"{WRAP}\n{CHECK}")
    said = lab.run("status()")
    assert "00 Start here: 1 of 1 points" in said
    assert "Parts of your robot: start.wrap_angle (version 1)" in said
    assert "Next: imu.calibrate_gyro in 01_imu.ipynb" in said


@pytest.mark.parametrize(
    "call, said",
    [
        ("check('start.wrap')", "did you mean 'start.wrap_angle'?"),
        ("check('imu.own_bias')", 'hand it in with answer("imu.own_bias", …)'),
        ("answer('start.wrap_angle', 1)", 'judge it with check("start.wrap_angle")'),
        ("begin('imu', student='not me')", "student: expected a number such as"),
        ("begin('imu', student=-1)", "student: expected a number such as"),
        ("begin('rowing')", "there is no chapter 'rowing'"),
        ("hint('imu.mahony')", "did you mean 'imu.mahony_step'?"),
    ],
)
def test_a_call_that_cannot_be_meant_is_refused_with_what_to_do(lab, call, said):
    assert said in lab.run(call)


def test_under_nbgrader_a_verdict_without_full_points_raises(lab):
    lab.run("os.environ['NBGRADER_EXECUTION'] = 'autograde'")
    try:
        assert "AssertionError: ! error: start.wrap_angle" in lab.run(CHECK)
        assert "AssertionError" in lab.run("answer('imu.own_bias', ...)")
        lab.run(WRAP)
        assert "AssertionError" not in lab.run(CHECK)
    finally:
        lab.run("del os.environ['NBGRADER_EXECUTION']")
