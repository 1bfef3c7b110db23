"""A match as film, figure and line: what is on them is what the match's record says."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from conftest import ROOT
from robocon_course import field, view
from robocon_course.mission import State
from robocon_course.simulator.match import Fault
from robocon_course.simulator.referee import Event
from robocon_course.view import _film, _record, missions, pictures
from robocon_course.worlds import MatchResult, play_match

FEED = [Event(t, "transfer", "own") for t in (12.0, 19.0)]
EVENTS = (
    Event(10.0, "taken", "own"),
    FEED[0],
    Event(15.0, "stored", "own", "silo 3: R"),
    Event(16.0, "stored", "theirs", "silo 3: RB"),
    Event(17.0, "taken", "own"),
    FEED[1],
    Event(20.0, "stored", "own", "silo 3: RBR"),
)


def short_match(ended=20.0, events=EVENTS, **changes) -> MatchResult:
    """A robot on its way up the field for 20 s; two balls lie at (1, 10) and (2, 10)."""
    time = np.arange(0.05, ended - 0.01, 0.05)
    share = time / 20.0
    poses = np.column_stack([0.55 + 3.0 * share, 0.35 + 9.0 * share, 1.5 * share])
    sent = np.searchsorted([12.0, 19.0], time, side="right")
    floor = 4 - np.searchsorted([10.0, 17.0], time, side="right") + sent
    place = np.array([(1.0 + k / 2, 10.0) for k in range(9)])
    names = ("red", "purple", "red", "purple", "red", "purple")
    points = {team: sum(_record.WORTH.get(e.what, 0) for e in events if e.team == team)
              for team in ("own", "theirs")}  # fmt: skip
    known = {
        "seed": 5, "parts": "reference", "winner": "own", "reason": "points", "ended": ended,
        "points": points["own"], "their_points": points["theirs"], "stored": 2, "fouls": 0,
        "retries": 0, "contacts": 0, "fillings": ("", "", "RBR", "", ""), "time": time,
        "poses": poses, "estimates": poses, "states": tuple(State.GO_TO_AREA_3 for _ in time),
        "error": 0.0, "reset_errors": np.zeros(0), "history": (), "events": tuple(events),
        "rejected": 0, "balls": tuple(place[:n] for n in floor),
        "colours": tuple(names[:n] for n in floor),
    }  # fmt: skip
    return MatchResult(**(known | changes))


def shown(gif: bytes) -> tuple[list[np.ndarray], list[int]]:
    """The pictures of a film, and how long each stays [ms]."""
    film, frames, pauses = Image.open(io.BytesIO(gif)), [], []
    for number in range(film.n_frames):
        film.seek(number)
        frames.append(np.asarray(film.convert("RGB")).astype(int))
        pauses.append(film.info["duration"])
    return frames, pauses


def near(picture, colour: str):
    """Which pixels have a colour, but for the film's few colours."""
    wanted = np.array(_film.rgb(colour))
    return np.abs(np.asarray(picture).astype(int) - wanted).max(axis=-1) < 14


def silo_at(picture, number: int, level: int) -> np.ndarray:
    """The colour where a silo's ball of a level (0, 1, 2) is shown beside the field."""
    y = field.SILOS[number - 1][1]
    row = _film.HEAD + (field.SIZE + field.FENCE_THICKNESS - y) * _film.PER_METRE
    return np.asarray(picture)[round(row + 15 - 15 * level), _film.WIDTH + 31].astype(int)


# The film


@pytest.fixture(scope="module")
def film():
    return view.animate_match(short_match())


def test_a_film_has_the_size_and_the_pace_that_were_asked_for(film):
    frames, pauses = shown(film.gif)
    assert len(film.gif) < 1_000_000
    assert frames[0].shape == (_film.HEAD + _film.HEIGHT + _film.FOOT, 480, 3)
    each = _film.PACES[0]
    assert len(frames) == len(np.arange(0.0, 20.0, 6.0 * each / 100)) + 1 == 35
    assert set(pauses[:-1]) == {10 * each}
    assert sum(pauses[:-1]) / 1000 == pytest.approx(20.0 / 6.0, abs=0.1)
    assert pauses[-1] == 1000 * _film.REST


def test_where_nothing_moves_four_pictures_stand_for_it(film):
    still = Image.open(io.BytesIO(film.still))
    assert still.format == "PNG" and still.width <= 910


def test_a_film_never_lasts_longer_than_half_a_minute():
    for speed in (0.01, 2.0):
        _, pauses = shown(view.animate_match(short_match(ended=60.0), speed=speed).gif)
        assert 27_000 < sum(pauses) <= 30_000


def test_a_film_that_is_too_large_gets_fewer_pictures(monkeypatch, film):
    monkeypatch.setattr(_film, "LARGEST_GIF", len(film.gif))
    smaller = view.animate_match(short_match())
    assert len(smaller.gif) < len(film.gif)
    assert len(shown(smaller.gif)[0]) < len(shown(film.gif)[0])
    monkeypatch.setattr(_film, "LARGEST_GIF", 1000)
    with pytest.raises(ValueError, match="bytes even with"):
        view.animate_match(short_match())


def test_a_ball_is_seen_in_its_silo_from_the_first_picture_after_it_was_stored(film):
    frames, _ = shown(film.gif)
    moments = _film._Film(short_match(), 6.0).moments(_film.PACES[0])
    for event in EVENTS:
        if event.what == "stored":
            number, filling = int(event.detail[5]), event.detail.split(": ")[1]
            after = next(k for k, now in enumerate(moments) if now >= event.time)
            paint, level = np.array(_film.rgb(missions.BALL[filling[-1]])), len(filling) - 1
            assert np.abs(silo_at(frames[after - 1], number, level) - 255).max() < 14
            assert np.abs(silo_at(frames[after], number, level) - paint).max() < 14


def test_the_last_picture_shows_how_the_match_ended():
    """The record's last row is older than the ball that ends a match."""
    picture = _film._Film(short_match(), 6.0).picture(20.0)
    for level, letter in enumerate("RBR"):
        colour = np.array(_film.rgb(missions.BALL[letter]))
        assert np.abs(silo_at(picture, 3, level) - colour).max() < 3


@pytest.mark.parametrize("own, rest", ["RB", "BR"])
def test_each_team_has_its_colour_whoever_plays(own, rest):
    swapped = str.maketrans("RB", own + rest)
    events = [event._replace(detail=event.detail.translate(swapped)) for event in EVENTS]
    film = _film._Film(short_match(events=events), 6.0)
    picture = film.picture(18.0)
    score = np.asarray(picture)[:30]
    middle = score.shape[1] // 2
    left, right = (
        near(score[:, :middle], missions.BALL[own]),
        near(score[:, middle:], missions.BALL[rest]),
    )
    assert left.sum() > 40 and right.sum() > 40
    assert near(score[:, :middle], missions.BALL[rest]).sum() == 0
    for level, letter in enumerate(own + rest):
        colour = np.array(_film.rgb(missions.BALL[letter]))
        assert np.abs(silo_at(picture, 3, level) - colour).max() < 3


def test_balls_lie_where_the_record_says_in_their_colours():
    film = _film._Film(short_match(), 6.0)
    picture = np.asarray(film.picture(18.0))

    def pixel(x, y):
        row = round(_film.HEAD + (12.05 - y) * _film.PER_METRE)
        return picture[row, round((x + 0.05) * _film.PER_METRE)]

    assert near(pixel(1.0, 10.0), missions.COLOURS["red"])
    assert near(pixel(1.5, 10.06), missions.COLOURS["purple"])
    assert near(pixel(1.5, 10.0), "#FFFFFF")


def test_the_view_goes_up_the_field_with_the_robot_and_stays_at_area_3():
    film = _film._Film(short_match(), 6.0)
    rows = [film._field(k, 0.0) for k in (0, 200, -1)]
    start = np.asarray(field.RED) * 0.6 + 255 * 0.4
    seen = [(np.abs(picture.astype(int) - start).max(axis=-1) < 3).sum() for picture in rows]
    assert seen[0] > 2000 and seen[2] == 0
    assert not np.array_equal(rows[1], rows[2])


def test_the_wheels_roll_along_the_motion_and_keep_their_angle_where_it_stands():
    """To the left at heading 90 degrees is along -x; then it stands."""
    time = np.arange(0.0, 4.0, 0.05)
    poses = np.column_stack([-np.minimum(time, 2.0), 0.0 * time, np.full(time.size, np.pi / 2)])
    angles = _film.wheel_angles(time, poses)
    assert np.cos(angles[[5, 60]] - np.pi / 2) == pytest.approx(1.0)


@pytest.mark.parametrize(
    "changes, speed, words",
    [
        ({"balls": (), "colours": ()}, 6.0, "with_balls=True"),
        ({"time": np.zeros(0)}, 6.0, "at least one row"),
        ({}, 0.0, "speed: expected a number above 0"),
        ({}, float("nan"), "speed: expected a number above 0"),
    ],
)
def test_what_cannot_be_filmed_is_refused_with_the_reason(changes, speed, words):
    with pytest.raises(ValueError, match=words):
        view.animate_match(short_match(**changes), speed=speed)


# What a record says


def test_a_ball_is_in_the_gripper_from_taken_to_stored():
    result = short_match()
    expected = ((result.time >= 10.0) & (result.time < 15.0)) | (result.time >= 17.0)
    assert np.array_equal(_record.holding(result), expected)


def test_a_ball_that_falls_on_the_floor_is_no_longer_in_the_gripper():
    result = short_match()
    falls = [xy if t < 13.0 else np.vstack([xy, [3.0, 9.0]])
             for t, xy in zip(result.time, result.balls, strict=True)]  # fmt: skip
    names = tuple(("purple",) * len(xy) for xy in falls)
    held = _record.holding(replace(result, balls=tuple(falls), colours=names))
    assert held[(result.time > 10.1) & (result.time < 12.9)].all()
    assert not held[(result.time > 13.0) & (result.time < 17.0)].any()


@pytest.mark.parametrize(
    "filling, whose", [("", ""), ("RR", ""), ("RRB", ""), ("BRR", "R"), ("RBB", "B"), ("RRR", "R")]
)
def test_a_silo_counts_for_whom_the_rules_say(filling, whose):
    assert _record.counts_for(filling) == whose


def test_every_state_of_the_mission_has_words_and_a_kind():
    assert set(_record.DOING) == set(map(str, State))
    kinds = [state for _, states in missions.KINDS.values() for state in states]
    assert sorted(kinds) == sorted(map(str, State))
    assert _record.in_words("dance_in_circles") == "dance in circles"


def test_a_match_in_which_nobody_stores_tells_its_team_by_the_balls():
    result = short_match(events=())
    assert _record.own_letter(result) == "R"
    blue = tuple(("blue", "purple")[:2] for _ in result.time)
    assert _record.own_letter(replace(result, colours=blue)) == "B"


# The figure and the line


def test_the_figure_fits_a_page_and_shows_every_ball_and_every_point():
    fig = view.plot_match(short_match())
    assert fig.get_figwidth() * 110 <= 910
    way, doing, silos, points = fig.axes
    stored = [line.get_xydata()[0] for line in silos.lines if line.get_marker() in ("o", "s")
              and line.get_markersize() == 8]  # fmt: skip
    assert np.allclose(stored, [(15.0, 3), (16.0, 3), (20.0, 3)])
    assert [text.get_text() for text in points.texts] == ["blue\n30", "red\n80"]
    assert [text.get_text() for text in doing.get_yticklabels()] == ["drives far"]
    assert way.get_ylim()[1] > 12.0


def test_the_figure_refuses_an_empty_record():
    with pytest.raises(ValueError, match="at least one row"):
        view.plot_match(short_match(time=np.zeros(0)))


def test_the_line_tells_the_match():
    assert view.match_twin(short_match()) == (
        "Match with seed 5, red: won by points after 20 s, 80 to 30 points; in Area 3 after 18 s, "
        "2 balls stored, the first after 15 s, 1 by the other team; silos 1 to 5 from bottom to "
        "top: –, –, RBR, –, –; 0 fouls, 0 retries."
    )


# A whole match, and the film that is shown


@pytest.fixture(scope="module")
def played():
    """A blue team, a strong one against it, and a ball knocked out of the gripper."""
    drop = (Fault("drop", 14.0),)
    return play_match(0, seed=3, team="blue", opponent="strong", faults=drop, with_balls=True)


def test_a_record_s_end_is_what_the_referee_said(played):
    assert _record.points_at(played, played.ended) == (played.points, played.their_points)
    assert played.fillings_at(played.ended) == played.fillings
    assert _record.own_letter(played) == "B"


def test_nothing_is_held_between_a_drop_and_the_next_ball_taken(played):
    drop = next(event.time for event in played.events if event.what == "fault")
    taken = [event.time for event in played.events if event.what == "taken"]
    before = max(t for t in taken if t < drop)
    after = min((t for t in taken if t > drop), default=played.ended)
    held, time = _record.holding(played), played.time
    assert held[(time > before + 0.1) & (time < drop)].all()
    assert not held[(time > drop + 0.1) & (time < after)].any()


def test_a_whole_match_is_a_small_film(played):
    film = view.animate_match(played)
    assert len(film.gif) < 1_000_000
    assert sum(shown(film.gif)[1]) <= 30_000


def test_the_film_that_is_shown_bears_the_words_of_its_match():
    film, twin = pictures.match_film()
    assert len(film.gif) < 1_000_000 and sum(shown(film.gif)[1]) <= 30_000
    assert f'<img src="data/match/match.gif" width="480" alt="{twin}">' in (
        ROOT / "README.md"
    ).read_text(encoding="utf-8")


@pytest.mark.campaign
def test_the_match_of_the_film_is_still_played_like_that():
    seed = int(pictures.match_film()[1].split("seed ")[1].split(",")[0])
    assert f"robocon match --seed {seed} --record" in (ROOT / "README.md").read_text("utf-8")
    played = play_match(0, seed=seed, with_balls=True)
    assert view.match_twin(played) == pictures.match_film()[1]
