"""Modelled detections beside pictures that were really drawn."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from robocon_course import field
from robocon_course.simulator.camera import FieldCamera, view_from
from robocon_course.simulator.glimpse import LEAST_SEEN, Mistakes, balls_seen, silos_seen
from robocon_course.vision import BALLS, SILOS, Camera

EXACT = Mistakes(edge=0.0, miss=0.0, other=0.0, small=1e-6)
"""A detector without mistakes."""
CAMERA = Camera()
POST = np.array([3.0, 10.0, pi])
TILT = 0.35
FILLINGS = ["R", "empty", "RB", "BBR", "B"]


def told(balls, *, pose=POST, pan=0.0, tilt=TILT, seed=0, mistakes=EXACT):
    """What is said of balls ((x, y), colour)."""
    xy = np.array([xy for xy, _ in balls], float).reshape(-1, 2)
    centres = np.column_stack([xy, field.floor_height(xy[:, 0], xy[:, 1]) + 0.095])
    colours, rng = [name for _, name in balls], np.random.default_rng(seed)
    return balls_seen(CAMERA, view_from(pose, pan, tilt), centres, colours, rng, mistakes)


def drawn(balls, *, pose=POST, pan=0.0, tilt=TILT):
    """The same, in a picture."""
    placed = [((*xy, float(field.floor_height(*xy)) + 0.095), name) for xy, name in balls]
    return FieldCamera(5).look(pose, pan=pan, tilt=tilt, balls=placed)


def strewn(rng, count=9) -> list:
    """Balls that do not touch each other, in the Storage Zone."""
    places: list = []
    while len(places) < count:
        xy = rng.uniform((0.2, 9.0), (2.1, 11.0))
        if all(np.hypot(*(xy - other)) > 0.2 for other in places):
            places.append(xy)
    return [
        (tuple(xy), str(name)) for xy, name in zip(places, rng.choice(BALLS, count), strict=True)
    ]


def nearest(box, label, found) -> float:
    """How far the sides of the best box of that label are off [pixels]; infinite without one."""
    same = found.boxes[found.class_ids == label]
    return float(np.abs(same - box).max(axis=1).min(initial=np.inf))


# --- boxes -------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_boxes_of_balls_are_those_around_drawn_balls(seed):
    rng = np.random.default_rng(seed)
    pose = rng.uniform((2.6, 9.5, pi - 0.2), (3.6, 10.5, pi + 0.2))
    view = {"pose": pose, "pan": rng.uniform(-0.2, 0.2), "tilt": rng.uniform(0.25, 0.4)}
    balls = strewn(rng)
    picture, found = drawn(balls, **view), told(balls, **view)
    gaps = np.array([
        nearest(box, label, found)
        for box, label in zip(picture.boxes, picture.class_ids, strict=True)
    ])  # fmt: skip
    # A ball that another one half hides is framed by points on its rim, 15 degrees apart.
    assert len(gaps) >= 4 and np.median(gaps) < 1.0 and np.mean(gaps < 2.0) >= 0.7


@pytest.mark.parametrize("where", [(1.8, 10.0), (1.0, 10.3), (0.4, 9.7), (2.05, 10.2)])
def test_the_box_of_a_single_ball_is_exact_to_half_a_pixel(where):
    picture, found = drawn([(where, "red")]), told([(where, "red")])
    assert len(found.scores) == len(picture.boxes) == 1
    np.testing.assert_allclose(found.boxes, picture.boxes, atol=0.6)
    assert BALLS[found.class_ids[0]] == "red"


def test_a_ball_at_the_picture_s_border_is_framed_as_far_as_it_is_seen():
    cut = [((1.5, 9.28), "blue")]
    picture, found = drawn(cut), told(cut)
    assert (len(picture.boxes) == 1 and picture.boxes[0, 0] < 1.0) or picture.boxes[0, 2] > 319.0
    np.testing.assert_allclose(found.boxes, picture.boxes, atol=6.0)  # rim points lie 15 deg apart


@pytest.mark.parametrize("x", [3.6, 4.2, 4.8])
def test_boxes_of_silos_are_those_around_drawn_silos(x):
    pose = np.array([x, 10.1, 0.1])
    picture = FieldCamera(5).look(pose, tilt=0.05, silos=FILLINGS, kind="silo")
    rng = np.random.default_rng(0)
    found = silos_seen(CAMERA, view_from(pose, 0.0, 0.05), FILLINGS, rng, EXACT)
    order, other = np.argsort(picture.boxes[:, 0]), np.argsort(found.boxes[:, 0])
    assert len(order) >= 2
    np.testing.assert_array_equal(picture.class_ids[order], found.class_ids[other])
    off = np.abs(picture.boxes[order] - found.boxes[other])
    # How high the topmost ball lies depends on how it fell in: the rest is the cage's.
    assert off[:, [0, 2, 3]].max() < 2.5 and off[:, 1].max() < 7.0


# --- what is hidden ----------------------------------------------------------------------------


def test_a_ball_right_behind_another_is_not_seen_and_one_beside_it_is():
    front, behind, beside = ((1.8, 10.0), "red"), ((1.6, 10.0), "blue"), ((1.6, 10.35), "purple")
    low = {"pose": np.array([2.6, 10.0, pi]), "tilt": 0.2}
    labels = {BALLS[k] for k in told([front, behind, beside], **low).class_ids}
    assert "red" in labels and "purple" in labels
    alone = told([behind], **low).boxes[0]
    found = told([front, behind], **low)
    hidden = found.boxes[found.class_ids == BALLS.index("blue")]
    assert not len(hidden) or (hidden[0, 3] - hidden[0, 1]) < 0.75 * (alone[3] - alone[1])


def test_of_a_ball_that_is_hardly_seen_nothing_is_said():
    front, behind = ((0.5, 10.0), "red"), ((0.30, 10.0), "blue")
    assert [BALLS[k] for k in told([front, behind], tilt=0.1).class_ids] == ["red"]
    assert [BALLS[k] for k in told([behind], tilt=0.1).class_ids] == ["blue"]
    assert 0.0 < LEAST_SEEN < 0.5


@pytest.mark.parametrize("x", [3.4, 5.0])
def test_what_lies_behind_the_camera_is_not_seen(x):
    assert not len(told([((x, 10.0), "red")]).scores)


def test_a_silo_that_is_half_out_of_the_picture_is_not_told():
    # From so near, only the silo straight ahead is whole.
    pose, rng = np.array([4.9, 10.0, 0.0]), np.random.default_rng(0)
    found = silos_seen(CAMERA, view_from(pose, 0.0, 0.05), FILLINGS, rng, EXACT)
    assert [SILOS[k] for k in found.class_ids] == ["RB"]


def test_a_silo_is_told_while_six_tenths_of_it_lie_inside_the_picture():
    rng, widths = np.random.default_rng(0), []
    for pan in np.arange(0.0, 0.8, 0.002):
        view = view_from(np.array([3.0, 10.0, 0.0]), pan, 0.05)
        found = silos_seen(CAMERA, view, ["empty"] * 2 + ["RB"] + ["empty"] * 2, rng, EXACT)
        mine = found.boxes[found.class_ids == SILOS.index("RB")]
        widths += (mine[:, 2] - mine[:, 0]).tolist()
    assert 0.58 < widths[-1] / max(widths) < 0.64


@pytest.mark.parametrize(("ahead", "seen"), [(0.25, 0), (0.35, 1), (-0.35, 0)])
def test_what_is_too_near_before_the_lens_is_not_seen(ahead, seen):
    rng = np.random.default_rng(0)
    found = balls_seen(CAMERA, np.eye(4), np.array([(0.0, 0.0, ahead)]), ["red"], rng, EXACT)
    assert len(found.scores) == seen


def test_nothing_to_see_is_no_error():
    assert told([]).boxes.shape == (0, 4)


# --- mistakes ----------------------------------------------------------------------------------


def test_the_same_seed_makes_the_same_mistakes():
    balls = strewn(np.random.default_rng(2))
    one, same, other = (told(balls, seed=seed, mistakes=Mistakes()) for seed in (3, 3, 4))
    for a, b in zip(one, same, strict=True):
        np.testing.assert_array_equal(a, b)
    assert one.boxes.shape != other.boxes.shape or (one.boxes != other.boxes).any()


def test_mistakes_are_as_frequent_as_they_are_said_to_be():
    near = [((1.9, 10.0), "red")]
    box = told(near).boxes[0]
    often = [told(near, seed=seed, mistakes=Mistakes(miss=0.2, other=0.1)) for seed in range(1500)]
    found = [one for one in often if len(one.scores)]
    assert abs(len(found) / 1500 - 0.8) < 0.05
    labels = np.array([one.class_ids[0] for one in found])
    assert abs((labels != BALLS.index("red")).mean() - 0.1) < 0.035
    edges = np.array([one.boxes[0] - box for one in found])
    assert abs(edges.std() - Mistakes().edge) < 0.05 and np.abs(edges.mean(axis=0)).max() < 0.1


def test_a_small_thing_is_missed_more_often():
    found = [
        np.mean([
            len(told([(where, "red")], seed=seed, mistakes=Mistakes(small=20.0)).scores)
            for seed in range(300)
        ])
        for where in ((1.9, 10.0), (0.3, 10.0))
    ]  # fmt: skip
    assert found[0] > found[1] + 0.1


def test_boxes_stay_inside_the_picture_and_scores_fall():
    balls = strewn(np.random.default_rng(8), 14)
    for seed in range(20):
        found = told(balls, seed=seed, mistakes=Mistakes(edge=5.0))
        assert found.boxes.min() >= 0 and (found.boxes[:, 2:] <= (320, 240)).all()
        assert (np.diff(found.scores) <= 0).all() and (found.scores <= 1).all()
        assert (found.boxes[:, 2:] > found.boxes[:, :2]).all()
