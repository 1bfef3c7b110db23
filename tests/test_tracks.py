"""Balls remembered from picture to picture: who belongs to whom, and who is gone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robocon_course.autopilot.tracks import APART, MISSES, Spot, Track, matched

BLUE, PURPLE, RED = range(3)


def spot(x, y=0.0, colour=RED, variance=1e-4, score=1.0):
    return Spot(x, y, variance, colour, score)


def seen(*pictures, expected=lambda track: True):
    """Tracks after these pictures."""
    tracks = []
    for spots in pictures:
        tracks = matched(tracks, spots, expected)
    return tracks


def test_the_middle_of_two_sightings_lies_by_their_variances():
    (track,) = seen([spot(0.0)], [spot(0.07)])
    before = 1e-4 + 0.02**2  # it may have rolled
    assert track.x == pytest.approx(0.07 * before / (before + 1e-4))
    assert track.variance == pytest.approx(1.0 / (1.0 / before + 1.0 / 1e-4))
    assert (track.hits, track.misses) == (2, 0)


def test_the_nearest_sighting_goes_to_each_and_the_rest_are_new():
    tracks = seen([spot(0.0), spot(0.3)], [spot(0.05), spot(0.24), spot(0.9)])
    assert [round(track.x, 2) for track in tracks] == [0.04, 0.25, 0.9]
    assert [track.hits for track in tracks] == [2, 2, 1]


def test_of_two_sightings_near_one_track_the_nearer_is_its_own():
    tracks = seen([spot(0.0)], [spot(0.02), spot(0.12)])
    assert [(round(track.x, 3), track.hits) for track in tracks] == [(0.017, 2), (0.12, 1)]


def test_between_two_balls_as_near_the_colour_decides():
    tracks = seen([spot(-0.08, colour=RED), spot(0.08, colour=BLUE)], [spot(0.0, colour=BLUE)])
    assert {track.colour: track.hits for track in tracks} == {BLUE: 2, RED: 1}


def test_far_away_where_places_spread_more_is_one_ball_still():
    assert len(seen([spot(0.0)], [spot(0.15)])) == 2
    assert len(seen([spot(0.0)], [spot(0.15, variance=0.02**2)])) == 1


@pytest.mark.parametrize("expected", [True, False])
def test_what_should_be_seen_and_is_not_is_gone_after_some_pictures(expected):
    pictures = [[spot(0.0)]] + [[]] * (MISSES - 1)
    assert len(seen(*pictures, expected=lambda track: expected)) == 1
    assert len(seen(*pictures, [], expected=lambda track: expected)) == (0 if expected else 1)
    (track,) = seen(*pictures, [spot(0.0)], expected=lambda track: expected)
    assert track.misses == 0, "found again"


def test_a_name_said_wrongly_once_is_outvoted():
    colours = [RED, RED, PURPLE, RED]
    (track,) = seen(*[[spot(0.0, colour=colour)] for colour in colours])
    assert track.colour == RED
    assert track.votes == pytest.approx((0.0, 0.5, 1.0 + 0.25 + 0.125))
    assert (track.ball.x, track.ball.colour) == (0.0, "red")


def test_two_tracks_of_one_ball_become_the_one_that_was_seen_oftener():
    oftener = Track(0.0, 0.0, 1e-4, (0.0, 0.0, 2.0), 5, 0)
    seldom = Track(0.05, 0.0, 1e-4, (3.0, 0.0, 0.0), 2, 0)
    (track,) = matched([seldom, oftener], [], lambda track: False)
    assert (track.x, track.hits, track.votes) == (0.0, 5, (3.0, 0.0, 2.0))


places = st.floats(-1.0, 1.0).map(lambda x: round(x, 3))
pictures = st.lists(st.lists(st.builds(spot, places, places, st.integers(0, 2)), max_size=5))


@given(pictures)
def test_whatever_is_seen_no_two_tracks_are_of_one_ball_and_nothing_seen_is_lost(pictures):
    tracks = seen(*pictures)
    xy = np.array([(track.x, track.y) for track in tracks]).reshape(-1, 2)
    gaps = np.hypot(*(xy[:, None] - xy).T)[~np.eye(len(xy), dtype=bool)]
    assert gaps.min(initial=np.inf) >= APART
    for one in pictures[-1] if pictures else []:
        assert np.hypot(*(xy - (one.x, one.y)).T).min() < 0.13 + 2 * 0.01 + APART
    assert [t.hits for t in tracks] == sorted((t.hits for t in tracks), reverse=True)
