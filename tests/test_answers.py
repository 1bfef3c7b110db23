"""The process that runs a student's code: what passes, what is stopped, what cannot get out."""

from __future__ import annotations

import base64
import enum
import json
import os
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robocon_course import exercises, imu
from robocon_course.answers import process, rehearsal, wire
from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry

# --- wire: plain data and nothing else --------------------------------------------------------

KEYS = st.sampled_from(["array", "list", "tuple", "dict", "type", "fields", "foreign", "x"])
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text()
ARRAYS = hnp.arrays(
    st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_]),
    hnp.array_shapes(min_dims=0, max_dims=3, max_side=4),
)
PLAIN = st.recursive(
    SCALARS | ARRAYS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(KEYS | st.text(), inner, max_size=4)
    ),
    max_leaves=20,
)


def same(a, b) -> bool:
    """Equal in value and in kind, NaN equal to itself."""
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return list(a) == list(b) and all(same(a[key], b[key]) for key in a)
    return a == b or (a != a and b != b)


@settings(deadline=None)
@given(PLAIN)
def test_plain_data_arrives_as_it_was_sent(value):
    assert same(wire.loads(wire.dumps(value)), value)


@settings(deadline=None)
@given(st.binary() | st.text().map(str.encode))
def test_a_line_that_is_no_message_is_refused_and_nothing_else_happens(line):
    try:
        wire.loads(line)
    except ValueError:
        pass


def test_a_result_of_the_course_comes_back_as_what_it_was():
    state = imu.MahonyState(np.array([1.0, 0, 0, 0]), np.array([0.1, 0.2, 0.3]))
    back = wire.loads(wire.dumps([state, imu.MahonyGains(1.5, 0.3)]))
    assert type(back[0]) is imu.MahonyState
    np.testing.assert_array_equal(back[0].integral, state.integral)
    assert back[1] == imu.MahonyGains(1.5, 0.3)


class Colour(enum.IntEnum):
    RED = 3


class Sly:
    """Equal to everything, and loud when asked who it is."""

    def __eq__(self, other):
        return True

    def __repr__(self):
        raise OSError("nobody")


@pytest.mark.parametrize(
    "value, plain",
    [(np.float64(0.5), 0.5), (np.int32(7), 7), (np.bool_(True), True), (Colour.RED, 3)],
)
def test_a_number_with_a_type_of_its_own_arrives_as_a_plain_number(value, plain):
    assert same(wire.loads(wire.dumps(value)), plain)


@pytest.mark.parametrize("value", [Sly(), {1: 2}, b"12", 1j, np.array([None, "x"]), sys])
def test_anything_else_arrives_as_a_note_of_what_it_was(value):
    [came] = wire.loads(wire.dumps([value]))
    assert came.type_name == type(value).__name__
    assert came != 3.0


@pytest.mark.parametrize(
    "message",
    [
        '{"type": ["os", "system"], "fields": {"command": "true"}}',
        '{"type": ["robocon_course.answers.process", "AnswerProcess"], "fields": {}}',
        '{"type": ["robocon_course.files", "Path"], "fields": {}}',
        '{"type": ["robocon_course.imu.mahony", "MahonyGains"], "fields": {"nothing": 1}}',
        '{"type": "robocon_course", "fields": {}}',
        '{"array": ""}',
        '{"array": "UEsDBBQAAAAAAAAAAAA="}',
        '{"foreign": []}',
        "{}",
        "[" * 100_000,
    ],
)
def test_a_forged_message_makes_no_object(message):
    with pytest.raises(ValueError, match="not plain data"):
        wire.loads(message.encode())


# --- the process ------------------------------------------------------------------------------


def ask(source: str, *args, time_limit: float = 20.0) -> process.Reply:
    """What ``f(*args)`` of a source replies, or what loading it does."""
    with AnswerProcess(time_limit) as answer:
        loaded = answer.load(source)
        return loaded if loaded.error else answer.call("f", args)


def test_a_call_brings_the_value_and_what_was_printed():
    reply = ask("def f(a, b):\n    print('hello', a)\n    return a + b", 1, np.ones(2))
    np.testing.assert_array_equal(reply.value, [2.0, 2.0])
    assert (reply.error, reply.printed) == ("", "hello 1\n")


def test_an_exception_brings_its_kind_its_words_and_its_line():
    reply = ask("def f(a):\n    b = a - 1\n    return a / b", 1)
    assert (reply.error, reply.message) == ("ZeroDivisionError", "division by zero")
    assert reply.line == "return a / b"


def test_a_source_that_does_not_load_says_where():
    reply = ask("def f(a):\n    retrun a\n")
    assert (reply.error, reply.line) == ("SyntaxError", "retrun a")


STOPPED = {
    "an endless loop": "def f():\n    while True: pass",
    "a loop that catches whatever is thrown at it": """
def f():
    while True:
        try:
            while True: pass
        except BaseException:
            pass""",
    "a loop while loading": "while True: pass",
    "one long sleep": "import time\ndef f(): time.sleep(60)",
}


@pytest.mark.parametrize("source", STOPPED.values(), ids=STOPPED)
def test_what_never_ends_is_stopped(source):
    reply = ask(source, time_limit=0.5)
    assert (reply.error, reply.message) == ("TimeLimit", "stopped after 0.5 s")


def test_after_a_stop_every_further_call_says_so():
    with AnswerProcess(0.3) as answer:
        answer.load("def f():\n    while True: pass")
        assert answer.call("f").error == "TimeLimit"
        assert answer.call("f").error == "ProcessEnded"


def test_the_time_of_all_calls_together_counts():
    with AnswerProcess() as answer:
        answer.allow(1.0)
        answer.load("import time\ndef f(): time.sleep(0.4)")
        errors = [answer.call("f").error for _ in range(4)]
    assert "TimeLimit" in errors


ENDED = {
    "os._exit": ("import os\ndef f(): os._exit(0)", "ProcessEnded"),
    "a signal to itself": ("import os\ndef f(): os.kill(os.getpid(), 9)", "ProcessEnded"),
    "sys.exit": ("import sys\ndef f(): sys.exit(0)", "SystemExit"),
    "quit while loading": ("raise SystemExit", "SystemExit"),
    "KeyboardInterrupt": ("def f(): raise KeyboardInterrupt", "KeyboardInterrupt"),
    "endless recursion": ("def f(): return f()", "RecursionError"),
    "a list in itself": ("def f():\n    a = []\n    a.append(a)\n    return a", "RecursionError"),
    "standard input": ("def f(): return input()", "EOFError"),
    "a name that is not there": ("def g(): pass", "KeyError"),
}


@pytest.mark.parametrize("source, error", ENDED.values(), ids=ENDED)
def test_whatever_ends_the_code_is_named(source, error):
    assert ask(source).error == error


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux bounds the memory of a process")
def test_more_memory_than_the_limit_is_refused_to_the_code_alone():
    with AnswerProcess() as answer:
        answer.load("def f(n): return len(bytearray(n))")
        assert answer.call("f", (8 << 30,)).error == "MemoryError"
        assert answer.call("f", (8,)).value == 8


def test_a_flood_of_words_is_cut_and_the_value_still_comes():
    source = "def f():\n    for k in range(10**5): print('x' * 1000)\n    return 5"
    reply = ask(source)
    assert (reply.value, len(reply.printed)) == (5, 4000)


def test_a_reply_beyond_the_limit_is_named(monkeypatch):
    monkeypatch.setattr(process, "REPLY_LIMIT", 10_000)
    assert ask("def f(): return 'x' * 20_000").error == "TooLarge"


def test_writing_to_standard_output_does_not_disturb_the_protocol():
    source = "import os\ndef f():\n    os.write(1, b'junk\\n'); os.write(2, b'junk\\n'); return 5"
    assert ask(source).value == 5


def test_writing_to_every_open_file_forges_no_value_and_raises_nothing():
    source = """
import os
def f():
    for number in range(3, 30):
        try: os.write(number, b'{"type": ["os", "system"], "fields": {}}\\n')
        except OSError: pass
    return 5"""
    assert ask(source).error == "NotPlainData"


def alive(pid: int) -> bool:
    """Whether a process runs; one that ended and waits for its parent does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="looks at processes in /proc")
def test_processes_that_the_code_started_end_with_it():
    source = "import subprocess\ndef f(): return subprocess.Popen(['sleep', '60']).pid"
    with AnswerProcess() as answer:
        answer.load(source)
        pid = answer.call("f").value
        assert alive(pid)
    for _ in range(100):
        if not alive(pid):
            break
        time.sleep(0.05)
    assert not alive(pid)


def test_the_code_works_in_an_empty_folder_that_goes_away(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "numpy.py").write_text("raise ImportError('not numpy')")
    source = "import os, numpy\ndef f():\n    open('x', 'w').close()\n    return os.getcwd()"
    folder = ask(source).value
    assert folder != str(tmp_path) and not os.path.exists(folder)


def test_closing_twice_is_closing_once(monkeypatch):
    ended: list[int] = []
    answer = AnswerProcess()
    monkeypatch.setattr(os, "killpg", lambda number, signal: ended.append(number))
    answer.close()
    answer.close()
    assert len(ended) == 1, "after the first time the number may be another's"
    assert answer.call("f").error == "ProcessEnded"


# --- the course's own answer ------------------------------------------------------------------

WAYS = {
    "through the chapter": "from robocon_course import imu\ndef f(q): return imu.euler_angles(q)",
    "imported by name": "from robocon_course.imu import euler_angles\n"
    "def f(q): return euler_angles(q)",
    "from where it stands": "import robocon_course.imu.attitude as a\n"
    "def f(q): return a.euler_angles(q)",
    "as a part of the robot": "from robocon_course.autopilot import Parts\n"
    "def f(q): return Parts().euler_angles(q)",
    "caught and tried again": """
from robocon_course import imu
def f(q):
    try: return imu.euler_angles(q)
    except ValueError: return imu.euler_angles(q)""",
}


@pytest.mark.parametrize("source", WAYS.values(), ids=WAYS)
def test_an_answer_that_calls_the_courses_own_is_told_so(source):
    with AnswerProcess() as answer:
        loaded = answer.load(source, registry.exercise("imu.euler_angles").blocked)
        assert loaded.error == ""
        reply = answer.call("f", (np.array([1.0, 0, 0, 0]),))
    assert reply.error == "NotYourOwn"
    assert reply.message == "robocon_course.imu.attitude.euler_angles"


@pytest.mark.parametrize(
    "way",
    [
        "from robocon_course.exercises.planning import search",
        "import robocon_course.exercises as e",
        "import importlib; importlib.import_module('robocon_course.exercises.planning.search')",
    ],
)
def test_the_catalogue_of_answers_is_closed_to_answers(way):
    with AnswerProcess() as process:
        process.load("def f(x):\n    return x\n", ())
        assert process.load(f"{way}\ndef f(x):\n    return x\n", ()).error == "NotYourOwn"
        assert process.load(f"def f(x):\n    {way}\n    return x\n", ()).error == ""
        assert process.call("f", (1,)).error == "NotYourOwn"


def test_a_property_that_would_answer_in_its_place_can_be_blocked():
    text = (
        "from robocon_course.odometry import TrackingWheels\n"
        "wheels = TrackingWheels([[0, 0.2], [0, -0.2], [-0.2, 0]], [0, 0, 1.57], 0.03, 3200)\n"
        "def body_deltas():\n    return wheels.solver\n"
        "def size():\n    return wheels.matrix.shape\n"
    )
    with AnswerProcess() as process:
        process.load(text, ("robocon_course.odometry.wheels.TrackingWheels.solver",))
        assert process.call("body_deltas", ()).error == "NotYourOwn"
        assert process.call("size", ()).value == (3, 3)


def test_the_rest_of_the_course_stays_usable_beside_a_blocked_function():
    source = "from robocon_course import imu\ndef f(q): return imu.gravity_direction(q)"
    with AnswerProcess() as answer:
        answer.load(source, registry.exercise("imu.euler_angles").blocked)
        reply = answer.call("f", (np.array([1.0, 0, 0, 0]),))
    np.testing.assert_allclose(reply.value, [0, 0, 1])


# --- rehearsal: the numbers that a notebook hands in ------------------------------------------

HEAD = "from robocon_course.exercises import answer, begin, check, hint, robot_parts, status"


def rehearsed(*cells: str, references: dict[str, str] | None = None) -> list:
    """What a notebook hands in, run in a process of its own as the grader does."""
    with AnswerProcess(60.0) as runner:
        reply = runner.run([HEAD, *cells], 21, references or {})
    assert reply.error == ""
    return reply.value


def test_a_rehearsal_returns_what_was_handed_in_in_order():
    cells = ["s = begin('imu')", "answer('imu.a', s + 1)", "answer('imu.b', value=2.5)"]
    assert rehearsed(*cells) == [("imu.a", 22), ("imu.b", 2.5)]


def test_a_cell_that_raises_or_leaves_does_not_hide_the_answers_after_it():
    cells = ["1 / 0", "raise SystemExit", "def broken(", "status()", "answer('imu.a', 1)"]
    assert rehearsed(*cells) == [("imu.a", 1)]


def test_a_rehearsal_draws_nothing():
    cells = [
        "from robocon_course.view import canvas, explore, show, widgets",
        "show(None, '')\nexplore(None)\ncanvas.show(None, '')\nwidgets.explore(None)",
        "show(None, '')\nanswer('imu.a', 1)",
    ]
    assert rehearsed(*cells) == [("imu.a", 1)]


def test_what_was_not_accepted_is_the_courses_from_its_check_onwards():
    cells = [
        "def gravity_direction(q): raise NotImplementedError",
        "gravity_direction = check('imu.gravity_direction')",
        "answer('imu.a', float(gravity_direction([1, 0, 0, 0])[2]))",
    ]
    own = {"imu.gravity_direction": "robocon_course.imu.attitude.gravity_direction"}
    assert rehearsed(*cells) == []
    assert rehearsed(*cells, references=own) == [("imu.a", 1.0)]


def test_the_rehearsals_doubles_stand_for_every_name_a_notebook_imports(monkeypatch):
    monkeypatch.setitem(sys.modules, "robocon_course.exercises", exercises)
    monkeypatch.setattr(rehearsal, "_draw_nothing", lambda: None)
    monkeypatch.setattr(rehearsal, "_train_nothing", lambda: None)
    rehearsal.run([], 0, {})
    doubles = sys.modules["robocon_course.exercises"]
    assert set(exercises.__all__) <= set(vars(doubles))


@pytest.mark.parametrize(
    "header",
    [
        "{'descr': '|V0', 'fortran_order': False, 'shape': (10**18,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000000000,), }",
        "{'descr': '<c16', 'fortran_order': False, 'shape': (0,), }",
    ],
)
def test_a_forged_array_is_refused_before_it_is_made(header):
    header = header.replace("10**18", str(10**18)).ljust(117) + "\n"
    packed = b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header.encode()
    line = json.dumps({"array": base64.b64encode(packed).decode()}).encode()
    with pytest.raises(ValueError, match="plain"):
        wire.loads(line)
