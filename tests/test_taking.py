"""How a ball is come at and followed, what is believed of it, and how fast the robot gets there."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from robocon_course.autopilot import Autopilot, Parts
from robocon_course.autopilot.driver import Driver
from robocon_course.autopilot.plays import PLAYS
from robocon_course.autopilot.route import DriveLimits
from robocon_course.autopilot.sight import Sight
from robocon_course.autopilot.taking import approach_to_ball, end_of, may_pull
from robocon_course.autopilot.tracks import Track
from robocon_course.mission import SeenBall, State, approach_from
from robocon_course.robot import Frame
from robocon_course.vision import Detections

RED, PURPLE = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)


def taking(*tracks: Track, pose=(2.0, 10.0, pi), straight=True) -> Autopilot:
    """An autopilot that takes the ball at (1.3, 10)."""
    pilot = Autopilot(start=pose)
    pilot.history = pilot.table.begin(0.0)._replace(state=State.TAKE_BALL)
    pilot.sight.tracks = list(tracks)
    way = approach_from(SeenBall(1.3, 10.0, "red"), pi)
    pilot.notes = {"approach": way, "straight": straight, "seen": pilot.now}
    return pilot


def track(x, y, votes=RED, hits=5, misses=0) -> Track:
    return Track(x, y, 1e-4, votes, hits, misses)


# --- the way to a ball -----------------------------------------------------------------------


def test_the_way_moves_with_a_ball_that_rolls():
    pilot = taking(track(1.24, 10.05))
    way = approach_to_ball(pilot)
    assert (way.ball.x, way.ball.y) == (1.24, 10.05) and way.heading == pi
    np.testing.assert_allclose(way.take, (1.24 + 0.42, 10.05), atol=1e-12)


def test_a_ball_out_of_sight_is_driven_to_for_a_moment_and_then_given_up():
    pilot = taking()
    assert approach_to_ball(pilot) is pilot.notes["approach"]
    pilot.now += 0.5
    assert approach_to_ball(pilot) is None and not pilot.notes["straight"]


def test_where_another_ball_comes_between_the_same_ball_is_come_at_from_elsewhere():
    pilot = taking(track(1.3, 10.0), track(1.55, 10.02, PURPLE))
    way = approach_to_ball(pilot)
    assert way.ball.x == 1.3 and abs(way.heading - pi) > 0.3
    assert pilot.state is State.TAKE_BALL and not pilot.notes["straight"]


def test_where_a_ball_was_lost_another_one_is_taken_at_once():
    pilot = taking(track(1.5, 9.0))
    pilot.now += 0.5
    assert approach_to_ball(pilot).ball.y == 9.0


def test_beside_a_wall_the_way_goes_on_no_farther_than_there_is_room():
    free, wall = (approach_from(SeenBall(x, 10.0, "red"), pi) for x in (1.3, 0.12))
    assert wall.take[0] - end_of(wall)[0] < free.take[0] - end_of(free)[0]


# --- the rollers -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("tracks", "motion", "pulls"),
    [
        ([track(1.3, 10.0)], (-0.5, 0.0), True),
        ([track(1.3, 10.0, misses=1)], (-0.5, 0.0), False),
        ([track(1.3, 10.0)], (-0.5, 0.2), False),
        ([track(1.3, 10.0), track(1.4, 10.13, PURPLE)], (-0.5, 0.0), False),
        ([track(1.3, 10.0), track(1.4, 10.13, PURPLE, hits=1)], (-0.5, 0.0), False),
        ([track(1.3, 10.0), track(1.1, 10.05, PURPLE)], (-0.5, 0.0), True),
        ([track(1.3, 10.0), track(1.3, 10.25, PURPLE)], (-0.5, 0.0), True),
        ([], (-0.5, 0.0), False),
    ],
)
def test_the_rollers_turn_only_for_a_ball_that_is_seen_alone_and_straight_ahead(
    tracks, motion, pulls
):
    pilot = taking(*tracks, pose=(1.72, 10.0, pi))
    pilot.motion = motion
    assert may_pull(pilot.notes["approach"], pilot) is pulls


def test_far_from_a_ball_the_rollers_stand():
    near, far = taking(track(1.3, 10.0), pose=(1.75, 10.0, pi)), taking(track(1.3, 10.0))
    assert PLAYS[State.TAKE_BALL](near).intake == 1.0
    assert PLAYS[State.TAKE_BALL](far).intake == 0.0


# --- what is believed of balls ---------------------------------------------------------------


def seen_again(tracks: list[Track], pose=(4.0, 9.0, 0.0)) -> list[Track]:
    """Tracks after a picture, taken by a robot that looks elsewhere, in which nothing is."""
    sight = Sight(Parts())
    sight.tracks = tracks
    sight.remember(1.0, np.array(pose))
    sight.look(Frame(1.0, 0.0, 0.4, None, {}), "ball")
    return sight.tracks


def test_two_colours_in_one_place_are_one_ball_by_the_vote():
    (only,) = seen_again([track(1.0, 10.0, (0.0, 0.9, 0.0), hits=2), track(1.03, 10.0, hits=9)])
    assert only.ball == SeenBall(1.03, 10.0, "red") and only.votes == (0.0, 0.9, 1.0)


def test_two_balls_that_touch_stay_two():
    assert len(seen_again([track(1.0, 10.0), track(1.19, 10.0, PURPLE)])) == 2


def test_no_ball_lies_where_the_robot_stands():
    tracks = [track(1.3, 10.0), track(1.0, 10.3), track(1.0, 10.5), track(0.55, 10.0)]
    left = seen_again(tracks, pose=(1.0, 10.0, 0.0))
    assert [(t.x, t.y) for t in left] == [(1.0, 10.5), (0.55, 10.0)]


def test_a_ball_is_seen_where_its_colour_was_found_in_the_last_picture():
    sight = Sight(Parts())
    sight.tracks = [track(1.0, 10.0), track(2.0, 10.0, misses=1)]
    assert sight.sees(SeenBall(1.05, 10.0, "red"))
    assert not sight.sees(SeenBall(1.05, 10.0, "purple"))
    assert not sight.sees(SeenBall(2.0, 10.0, "red"))


@pytest.mark.parametrize("number", [-1, 3, 99])
def test_a_class_that_no_network_has_is_no_ball(number):
    sight = Sight(Parts())
    sight.remember(1.0, np.array((2.0, 10.0, pi)))
    box = np.array([[150.0, 100.0, 180.0, 130.0]], np.float32)
    found = {k: Detections(box, np.array([0.9], np.float32), np.array([k])) for k in (2, number)}
    for said in found.values():
        sight.look(Frame(1.0, 0.0, 0.4, None, {"ball": said}), "ball")
    assert len(sight.tracks) == 1 and sight.found[1].class_ids.tolist() == []


# --- how fast --------------------------------------------------------------------------------


def speeds(ordered=(0.0, 0.0), **limits) -> np.ndarray:
    driver = Driver(Parts(), 0.0)
    driver.ordered = ordered
    xy = np.column_stack([np.linspace(0.0, 2.0, 21), np.zeros(21)])
    return driver._speeds(xy, DriveLimits(3.0, 2.0, 1.5, 2.5, **limits))


def test_from_rest_to_rest_the_profile_is_the_plain_one():
    plain = Parts().speed_profile(np.column_stack([np.linspace(0, 2, 21), np.zeros(21)]), 3, 2, 1.5)
    assert speeds().tolist() == plain.tolist()
    assert speeds(ordered=(-1.0, 2.0)).tolist() == plain.tolist()  # it has to turn back first


def test_who_moves_already_goes_on_from_there_and_brakes_as_before():
    moving, rest = speeds(ordered=(1.2, 0.7)), speeds()
    assert moving[0] == pytest.approx(1.2) and moving[1] == pytest.approx(np.sqrt(1.44 + 0.4))
    np.testing.assert_allclose(moving[12:], rest[12:], atol=1e-12)


def test_who_may_arrive_at_a_speed_is_so_fast_at_the_end():
    rolling = speeds(arrive=0.8)
    assert rolling[-1] == pytest.approx(0.8) and rolling[-2] == pytest.approx(np.sqrt(0.64 + 0.4))
    assert rolling[0] == 0.0


def test_nobody_is_faster_than_the_limit_even_if_he_is():
    assert speeds(ordered=(5.0, 0.0), arrive=2.9).max() == pytest.approx(3.0)
