"""The own world of chapter 06, and the challenge that is handed in as a file."""

from __future__ import annotations

import hashlib
import json
import os

import nbformat
import numpy as np
import pytest

from robocon_course import vision, worlds
from robocon_course.answers.process import AnswerProcess
from robocon_course.exercises import registry
from robocon_course.exercises.judge import ask_function, judge, judge_answer, judge_number
from robocon_course.exercises.model import Outcome
from robocon_course.exercises.source import Answer
from robocon_course.exercises.vision import challenge, symptoms
from robocon_course.files import LARGEST_WEIGHTS, data_file
from robocon_course.grading.batch import grade_one
from robocon_course.vision import Detections

STUDENTS = [*range(0, 60, 7), "H1D021001"]
FIND_BALLS = registry.exercise("vision.find_balls")
OWN_THRESHOLD = registry.exercise("vision.own_threshold")

# --- what the own detector reported -----------------------------------------------------------


def test_a_log_is_the_same_to_the_bit_on_every_machine():
    world = worlds.eye_world(21306141022)
    logs = world.scores.astype("<f8").tobytes() + world.hits.tobytes()
    assert hashlib.sha256(logs).hexdigest()[:16] == "08d8768d88e82e16"


@pytest.mark.parametrize("student", STUDENTS)
def test_a_log_holds_hits_that_are_surer_than_the_rest_and_balls_never_found(student):
    world = worlds.eye_world(student)
    assert world.hits.sum() < world.truths and (~world.hits).sum() > 50
    assert np.median(world.scores[world.hits]) > np.median(world.scores[~world.hits]) + 0.2
    np.testing.assert_array_equal(world.scores, world.scores.round(2))


def naive_f1(world, threshold: float) -> float:
    """The harmonic mean of precision and recall, one report after the other."""
    right = said = 0
    for score, hit in zip(world.scores, world.hits, strict=True):
        if score >= threshold - 1e-9:
            said += 1
            right += bool(hit)
    precision, recall = right / said if said else 0.0, right / world.truths
    return 2 * precision * recall / (precision + recall) if right else 0.0


@pytest.mark.parametrize("student", STUDENTS)
def test_the_best_threshold_is_the_naive_one_and_its_neighbours_are_wrong(student):
    world = worlds.eye_world(student)
    levels = [k / 100 for k in range(1, 100)]
    marks = [naive_f1(world, level) for level in levels]
    best = levels[int(np.argmax(marks))]
    assert judge_number(OWN_THRESHOLD, best, student).accepted
    for other in (best - 0.01, best + 0.01):
        assert not judge_number(OWN_THRESHOLD, other, student).accepted
    assert np.sum(np.array(marks) > max(marks) - 1e-9) == 1, "of equals none could be right"


def test_a_number_without_a_unit_is_told_without_a_gap():
    said = judge_number(OWN_THRESHOLD, 0.123, 7).message
    assert said.startswith("0.123: not within 0.0051 of the truth")
    assert judge_number(OWN_THRESHOLD, "x", 7).message == "Expected one number, got a str."


def test_boxes_to_try_lie_in_the_picture_and_have_a_size():
    boxes = worlds.some_boxes(np.random.default_rng(1), 500)
    assert (boxes >= 0).all() and (boxes <= 320).all()
    assert (boxes[:, 2:] - boxes[:, :2] >= 7.9).all()
    np.testing.assert_array_equal(boxes, boxes.round(1))


# --- the challenge: what an answer shows ------------------------------------------------------


def seen_through(student: int, rough: float, change=lambda found: found):
    """An answer that finds what is there as a network does: not all, not exactly, and more."""
    rng = np.random.default_rng(student)

    def find(boxes, ids):
        sides = np.tile(boxes[:, 2:] - boxes[:, :2], 2)
        there = rng.random(len(ids)) > rough
        near = (boxes + rng.normal(0.0, 0.2 * rough, boxes.shape) * sides)[there]
        wrong = worlds.some_boxes(rng, 3, 120.0)
        scores = np.r_[rng.uniform(0.3, 0.95, there.sum()), rng.uniform(0.05, 0.4, 3)]
        order = np.argsort(-scores)
        ids = np.r_[ids[there], rng.integers(0, 3, 3)]
        return Detections(np.vstack([near, wrong])[order], scores[order], ids[order])

    def function(images):
        rows = challenge._truths[challenge._digest(images)]
        return [change(find(boxes.astype(float), ids)) for boxes, ids in rows]

    return function


@pytest.mark.parametrize("student", [7, 21306141022])
def test_a_network_that_sees_well_earns_all_and_a_poor_one_half_or_nothing(student):
    points = [
        judge(FIND_BALLS, ask_function(seen_through(student, rough)), student).points
        for rough in (0.1, 0.35, 0.8)
    ]
    assert points == [4.0, 2.0, 0.0]


@pytest.mark.parametrize("fault", symptoms.FAULTS, ids=lambda fault: fault.name)
def test_a_fault_is_told_on_a_network_that_is_far_from_perfect(fault):
    for student in (7, 8, 9):
        answer = seen_through(student, 0.25, fault.make)
        verdict = judge(FIND_BALLS, ask_function(answer), student)
        assert verdict.mistake == fault.name, (student, verdict.message)


def test_a_network_that_is_only_poor_is_told_no_fault():
    for student in (7, 8, 9):
        verdict = judge(FIND_BALLS, ask_function(seen_through(student, 0.45)), student)
        assert (verdict.mistake, verdict.points < 4) == ("", True)
        cases = FIND_BALLS.cases(student, worlds.generator(student, FIND_BALLS.id, "public"))
        poor = seen_through(student, 0.45)
        assert [case.traits(poor(*case.args)) for case in cases] == ["", "", ""]


@pytest.mark.parametrize("fault", symptoms.FAULTS, ids=lambda fault: fault.name)
def test_a_fault_that_is_mended_is_none(fault):
    boxes = worlds.some_boxes(np.random.default_rng(2), 9, 120.0)
    found = Detections(boxes, np.linspace(0.9, 0.5, 9), np.arange(9) % 3)
    for one, other in zip(fault.mend(fault.make(found)), found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-9)


WHOLE = Detections(np.zeros((1, 4)), np.ones(1), np.zeros(1, int))
FORMS = {
    "nothing": (None, "the function returned nothing (None)"),
    "one Detections for all": (WHOLE, "expected a list of 16 Detections, one a picture"),
    "too few": ([WHOLE] * 15, "one result for each of 16 pictures, got 15"),
    "boxes only": ([np.zeros((2, 4))] * 16, "expected Detections for each picture"),
    "more scores than boxes": (
        [WHOLE._replace(scores=np.ones(2))] * 16,
        "as many scores and class numbers as boxes",
    ),
    "not a number": ([WHOLE._replace(boxes=np.full((1, 4), np.nan))] * 16, "finite numbers"),
    "endless boxes": (
        [Detections(np.zeros((301, 4)), np.ones(301), np.zeros(301))] * 16,
        "at most 300 boxes a picture, got 301",
    ),
    "a class below 0": ([WHOLE._replace(class_ids=np.array([-1]))] * 16, "class numbers are 0"),
    "a class beyond reason": ([WHOLE._replace(class_ids=np.array([1e300]))] * 16, "80 things"),
}


@pytest.mark.parametrize("value, said", FORMS.values(), ids=FORMS)
def test_an_answer_that_cannot_be_measured_is_told_why(value, said):
    verdict = judge(FIND_BALLS, ask_function(lambda images: value), 7)
    assert verdict.points == 0.0 and said in verdict.message


def test_lists_instead_of_arrays_are_measured_too():
    def answer(images):
        return [tuple(part.tolist() for part in found) for found in right(images)]

    right = seen_through(7, 0.0)
    assert judge(FIND_BALLS, ask_function(answer), 7).points == 4.0


# --- the file ---------------------------------------------------------------------------------

OPENS = """from robocon_course import vision
def find_balls(images):
    detector = vision.load_detector("ball.onnx")
    return [detector.detect(image) for image in images]
"""
WRAP = "import math\ndef wrap_angle(angle):\n    return (angle + math.pi) % (2 * math.pi) - math.pi"


def handed_in(path) -> object:
    """The verdict on the plainest answer with a file beside it."""
    with AnswerProcess() as process:
        return judge_answer(process, FIND_BALLS, Answer("find_balls", OPENS), 7, file=path)


NO_NETWORKS = {
    "an empty file": (b"", "the file is empty"),
    "a text": (b"my weights are at home\n", "not a network that can be opened"),
    "a checkpoint": (b"PK\x03\x04" + bytes(200), "not a network that can be opened"),
    "too large a file": (bytes(LARGEST_WEIGHTS + 1), "has 13.0 MB, and 13 MB are allowed"),
}


@pytest.mark.parametrize("content, said", NO_NETWORKS.values(), ids=NO_NETWORKS)
def test_a_file_that_is_no_network_earns_nothing_and_is_told_why(content, said, tmp_path):
    (tmp_path / "ball.onnx").write_bytes(content)
    verdict = handed_in(tmp_path / "ball.onnx")
    assert (verdict.outcome, verdict.points) == (Outcome.ERROR, 0.0)
    assert "ball.onnx" in verdict.message and said in verdict.message


@pytest.mark.parametrize("name", ["ball", "silo"])
def test_the_courses_own_network_under_another_name_is_not_ones_own(name, tmp_path):
    (tmp_path / "ball.onnx").write_bytes(data_file(f"weights/{name}.onnx").read_bytes())
    verdict = handed_in(tmp_path / "ball.onnx")
    assert verdict.points == 0.0 and "the course came with" in verdict.message


def test_a_missing_file_a_link_a_folder_and_a_pipe_are_told(tmp_path):
    assert "ball.onnx: cannot be read" in handed_in(tmp_path / "gone.onnx").message
    (tmp_path / "real.onnx").write_bytes(b"x")
    (tmp_path / "link.onnx").symlink_to(tmp_path / "real.onnx")
    assert "link.onnx is a link" in handed_in(tmp_path / "link.onnx").message
    (tmp_path / "folder.onnx").mkdir()
    assert "folder.onnx is not a file" in handed_in(tmp_path / "folder.onnx").message
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.onnx")
        assert "pipe.onnx is not a file" in handed_in(tmp_path / "pipe.onnx").message


def network(path, classes: int, column, names: dict[int, str] | None = None) -> None:
    """An .onnx file that gives the same column for every picture."""
    onnx = pytest.importorskip("onnx", reason='needs pip install -e ".[vision]"')
    from onnx import TensorProto, helper, numpy_helper

    output = np.zeros((1, 4 + classes, 8), np.float32)
    output[0, :, 0] = column
    floats = TensorProto.FLOAT
    graph = helper.make_graph(
        [helper.make_node("Identity", ["table"], ["output0"])],
        "constant",
        [helper.make_tensor_value_info("images", floats, [1, 3, 64, 64])],
        [helper.make_tensor_value_info("output0", floats, list(output.shape))],
        [numpy_helper.from_array(output, "table")],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    words = names if names is not None else dict(enumerate(map(str, range(classes))))
    helper.set_model_props(model, {"names": str(words)})
    onnx.save(model, path)


OTHERS = {
    "the silos' network": (15, [32, 32, 20, 20, *[0.0] * 10, 0.9, *[0.0] * 4]),
    "a network of 80 classes": (80, [32, 32, 20, 20, *[0.0] * 32, 0.9, *[0.0] * 47]),
    "nothing found": (3, [32, 32, 20, 20, 0.01, 0.02, 0.01]),
}


@pytest.mark.parametrize("name", OTHERS)
def test_another_network_handed_in_is_told_by_name(name, tmp_path):
    network(tmp_path / "ball.onnx", *OTHERS[name])
    verdict = handed_in(tmp_path / "ball.onnx")
    assert (verdict.points, verdict.mistake) == (0.0, name), verdict.message


def test_a_network_whose_output_does_not_fit_its_classes_is_refused_with_both(tmp_path):
    network(tmp_path / "ball.onnx", 3, [0.0] * 7, {0: "ball"})
    assert "for 1 classes" in handed_in(tmp_path / "ball.onnx").message


def notebook(path, *cells: str):
    """A notebook file with these code cells."""
    made = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    path.write_text(json.dumps(made), encoding="utf-8")
    return path


def test_a_broken_file_costs_only_its_own_exercise(tmp_path):
    notebook(tmp_path / "all.ipynb", WRAP, OPENS)
    (tmp_path / "ball.onnx").write_bytes(b"PK\x03\x04")
    row = grade_one(tmp_path)
    points = {verdict.id: verdict.points for verdict in row.verdicts}
    assert row.reason == "" and points["start.wrap_angle"] == 1 and points[FIND_BALLS.id] == 0


def told_in(path) -> str:
    """What grading says about the challenge of one submission."""
    return {v.id: v.message for v in grade_one(path).verdicts}[FIND_BALLS.id]


def test_the_file_is_found_in_the_folder_or_beside_the_notebook_by_its_name(tmp_path):
    (tmp_path / "ann" / "deep").mkdir(parents=True)
    (tmp_path / "ann" / "deep" / "ball.onnx").write_bytes(b"")
    notebook(tmp_path / "ann" / "06_vision.ipynb", OPENS)
    ben = notebook(tmp_path / "ben.ipynb", OPENS)
    (tmp_path / "ben.onnx").write_bytes(b"")
    assert "the file is empty" in told_in(tmp_path / "ann")
    assert "the file is empty" in told_in(ben)
    assert "cannot be read" in told_in(notebook(tmp_path / "cy.ipynb", OPENS))


def test_working_out_a_number_trains_nothing(tmp_path):
    right = OWN_THRESHOLD.truth(7)
    cells = [
        "from robocon_course import worlds\nfrom robocon_course.exercises import *",
        "student = begin('vision', student=7)\nworld = worlds.eye_world(student)",
        "from robocon_course.vision import training\nwhile True: pass",
        f"answer('vision.own_threshold', {right} + 0 * len(world.scores))",
    ]
    row = grade_one(notebook(tmp_path / "one.ipynb", *cells), time_limit=30.0)
    assert {v.id: v.points for v in row.verdicts}["vision.own_threshold"] == 1, row


def test_the_courses_own_network_is_no_answer(tmp_path):
    ways = (
        'vision.load_detector("ball")',
        'vision.load_detector(files.data_file("weights/ball.onnx"))',
    )
    for way in ways:
        text = f"from robocon_course import files, vision\ndef find_balls(images):\n    {way}\n"
        with AnswerProcess() as process:
            verdict = judge_answer(process, FIND_BALLS, Answer("find_balls", text), 7)
        assert verdict.points == 0.0 and "the course's own" in verdict.message
    assert vision.find_balls.__name__ == FIND_BALLS.function_name
