"""The synthetic camera: what it shows, and that its boxes are those of what it shows."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest

from robocon_course import field
from robocon_course.vision import film, paint, pictures, render, venue
from robocon_course.vision.camera import Camera, view_towards
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.scene import RADIUS, Lamp, Scene, stack


def bare_room() -> Scene:
    """White light, a grey floor, nothing else."""
    scene = Scene(lamps=[Lamp(np.array([0.0, 0.0, 1.0]), np.full(3, 0.7))])
    scene.add_rect((-9, -9, 0), (18, 0, 0), (0, 18, 0), (0.5, 0.5, 0.5))
    return scene


def photograph(scene: Scene, T_map_camera, kind: str = "ball", camera: Camera | None = None):
    rng = np.random.default_rng(0)
    return pictures.take(
        scene, camera or Camera(), T_map_camera, film.Film(noise=0.0), rng, kind=kind
    )


def outline(camera: Camera, T_map_camera, centre):
    """Left, top, right, bottom of a ball, from points all over it."""
    way = np.random.default_rng(1).normal(size=(200_000, 3))
    points = centre + RADIUS * way / np.linalg.norm(way, axis=1, keepdims=True)
    seen = camera.pixels((points - T_map_camera[:3, 3]) @ T_map_camera[:3, :3])
    return np.clip(np.r_[seen.min(axis=0), seen.max(axis=0)], 0, (320, 240, 320, 240))


@pytest.mark.parametrize("at", [(1.0, 0.0), (2.0, 0.9), (0.6, -0.2), (4.0, 1.5)])
def test_the_box_of_a_ball_is_its_outline_to_a_ray(at):
    scene, camera = bare_room(), Camera(distortion=-0.1)
    centre = np.array([*at, RADIUS])
    scene.add_ball(centre, paint.hsv(220, 0.8, 0.8), 0, np.eye(3))
    T = view_towards((0.0, 0.0, 0.5), (1.5, 0.0, 0.1), roll=0.1)
    taken = photograph(scene, T, camera=camera)
    np.testing.assert_allclose(
        taken.boxes, [outline(camera, T, centre)], atol=1.2 / pictures.FINENESS
    )
    assert taken.class_ids.tolist() == [0]


def test_a_half_hidden_ball_gets_the_box_of_its_visible_half():
    scene, T = bare_room(), view_towards((0.0, 0.0, 0.1), (1.0, 0.0, 0.1))
    scene.add_ball((1.5, 0.0, RADIUS), paint.hsv(220, 0.8, 0.8), 0, np.eye(3))
    whole = photograph(scene, T).boxes[0]
    scene.add_box((1.0, 0.0, 0.0), (1.1, 0.5, 0.5), (0.9, 0.9, 0.1))
    half = photograph(scene, T).boxes[0]
    # The box stands on the left, as the picture shows it.
    assert half[0] == pytest.approx((whole[0] + whole[2]) / 2, abs=1.0)
    np.testing.assert_array_equal(half[1:], whole[1:])


def test_a_ball_hidden_but_for_a_sliver_gets_no_box():
    scene, T = bare_room(), view_towards((0.0, 0.0, 0.1), (1.0, 0.0, 0.1))
    scene.add_ball((1.5, 0.0, RADIUS), paint.hsv(220, 0.8, 0.8), 0, np.eye(3))
    scene.add_box((1.0, -0.05, 0.0), (1.1, 0.5, 0.5), (0.9, 0.9, 0.1))
    taken = photograph(scene, T)
    assert taken.boxes.shape == (0, 4) and taken.boxes.dtype == np.float32
    assert taken.class_ids.shape == (0,) and taken.class_ids.dtype == np.int64
    # It is seen all the same: a box that is neither right nor wrong.
    assert taken.doubtful.shape == (1, 4) and taken.doubtful.dtype == np.float32
    assert 2.0 <= taken.doubtful[0, 2] - taken.doubtful[0, 0] < 8.0


def test_what_is_seen_well_or_not_at_all_is_not_doubtful():
    scene, T = bare_room(), view_towards((0.0, 0.0, 0.1), (1.0, 0.0, 0.1))
    scene.add_ball((1.5, 0.0, RADIUS), paint.hsv(220, 0.8, 0.8), 0, np.eye(3))
    assert photograph(scene, T).doubtful.shape == (0, 4)
    # Another sport's ball, and one behind a wall.
    scene.add_ball((1.5, 0.4, RADIUS), paint.hsv(60, 0.8, 0.8), -1, np.eye(3))
    scene.add_box((2.0, -0.5, 0.0), (2.1, 0.5, 0.5), (0.9, 0.9, 0.1))
    scene.add_ball((2.5, 0.0, RADIUS), paint.hsv(220, 0.8, 0.8), 0, np.eye(3))
    assert photograph(scene, T).doubtful.shape == (0, 4)


def test_rings_in_front_of_a_ball_leave_its_box_as_it_is():
    rng, T = np.random.default_rng(3), view_towards((0.0, 0.0, 0.4), (1.2, 0.0, 0.25))
    scene = bare_room()
    venue.add_silo(scene, rng, (1.2, 0.0, 0.0), SILOS.index("RBR"), venue.silo_make(rng))
    behind = photograph(scene, T)
    assert scene.cages
    scene.cages.clear()
    np.testing.assert_allclose(behind.boxes, photograph(scene, T).boxes, atol=4.0)
    assert behind.class_ids.tolist() == [2, 0, 2]


def test_the_box_of_a_silo_holds_the_boxes_of_its_balls():
    rng, T = np.random.default_rng(3), view_towards((0.0, 0.0, 0.4), (1.2, 0.0, 0.25))
    scene = bare_room()
    venue.add_silo(scene, rng, (1.2, 0.0, 0.0), SILOS.index("RBR"), venue.silo_make(rng))
    silo, balls = photograph(scene, T, "silo"), photograph(scene, T)
    assert silo.class_ids.tolist() == [SILOS.index("RBR")]
    assert (silo.boxes[0, :2] <= balls.boxes[:, :2]).all()
    assert (silo.boxes[0, 2:] >= balls.boxes[:, 2:]).all()


def test_a_silo_whose_top_the_border_cuts_off_is_not_named():
    rng, scene = np.random.default_rng(3), bare_room()
    venue.add_silo(scene, rng, (1.0, 0.0, 0.0), SILOS.index("RBR"), venue.silo_make(rng))
    T = view_towards((0.3, 0.0, 0.2), (1.0, 0.0, -0.25))
    taken = photograph(scene, T, "silo")
    assert len(taken.boxes) == 0 and taken.doubtful.shape == (1, 4)
    assert taken.doubtful[0, 1] == 0.0  # it reaches to the upper border


def test_a_silo_of_which_a_ball_is_hidden_is_doubtful_and_its_box_holds_what_is_seen():
    rng, scene = np.random.default_rng(3), bare_room()
    venue.add_silo(scene, rng, (1.2, 0.0, 0.0), SILOS.index("RBR"), venue.silo_make(rng))
    T = view_towards((0.0, 0.0, 0.4), (1.2, 0.0, 0.25))
    whole = photograph(scene, T, "silo")
    assert len(whole.boxes) == 1 and len(whole.doubtful) == 0
    scene.add_box((0.7, -0.5, 0.0), (0.75, 0.5, 0.27), (0.9, 0.9, 0.1))
    behind = photograph(scene, T, "silo")
    assert len(behind.boxes) == 0 and len(behind.doubtful) == 1
    np.testing.assert_allclose(behind.doubtful[0, :3], whole.boxes[0, :3], atol=4.0)
    assert behind.doubtful[0, 3] < whole.boxes[0, 3] - 20.0


@pytest.mark.parametrize(("wall", "named"), [(0.215, True), (0.23, False)])
def test_a_silo_is_named_while_a_quarter_of_each_ball_shows(wall, named):
    rng, scene, lone = np.random.default_rng(3), bare_room(), bare_room()
    venue.add_silo(scene, rng, (1.2, 0.0, 0.0), SILOS.index("RBR"), venue.silo_make(rng))
    scene.add_box((0.7, -0.5, 0.0), (0.75, 0.5, wall), (0.9, 0.9, 0.1))
    lowest = scene.balls[0]
    lone.add_ball(lowest.centre, lowest.colour, lowest.label, lowest.turn)
    T = view_towards((0.0, 0.0, 0.4), (1.2, 0.0, 0.25))
    shows, whole = (
        np.count_nonzero(render.seen(one.packed(), Camera().scaled(4.0), T)[2] == len(one.rects))
        for one in (scene, lone)
    )
    assert (0.27 < shows / whole < 0.35) if named else (0.12 < shows / whole < 0.22)
    taken = photograph(scene, T, "silo")
    assert (len(taken.boxes), len(taken.doubtful)) == ((1, 0) if named else (0, 1))


@pytest.mark.parametrize(
    ("filling", "lowest", "named"),
    [("RB", 0.46, True), ("RB", 0.4, False), ("empty", 0.2, True), ("empty", 0.02, False)],
)
def test_a_silo_is_named_while_the_place_of_its_next_ball_shows(filling, lowest, named):
    rng, scene = np.random.default_rng(3), bare_room()
    venue.add_silo(scene, rng, (1.2, 0.0, 0.0), SILOS.index(filling), venue.silo_make(rng))
    # A board hangs in front of the place, as wide as a ball: the cage's posts are seen beside it.
    T = view_towards((0.0, 0.0, 0.3), (1.2, 0.0, 0.3))
    scene.add_rect((1.0, -0.1, lowest), (0, 0.2, 0), (0, 0, 0.3), (0.9, 0.9, 0.1))
    taken = photograph(scene, T, "silo")
    assert (len(taken.boxes), len(taken.doubtful)) == ((1, 0) if named else (0, 1))


def test_a_full_silo_has_no_place_for_another_ball():
    rng, scene = np.random.default_rng(3), bare_room()
    make = venue.silo_make(rng)
    for filling, foot in (("RBR", (1.2, 0.0, 0.0)), ("BR", (0.0, 1.0, 0.2)), ("empty", (2, 2, 0))):
        venue.add_silo(scene, rng, foot, SILOS.index(filling), make)
    assert scene.next_place(0) is None
    one_more, first = scene.next_place(1), scene.next_place(2)
    top = scene.balls[scene.held(1)[-1]].centre
    np.testing.assert_allclose(one_more, (0.0, 1.0, top[2] + 2 * RADIUS))
    np.testing.assert_allclose(first, (2.0, 2.0, RADIUS))


@pytest.mark.parametrize("seed", range(5))
def test_the_share_seen_of_another_ball_is_that_of_a_ball_put_there(seed):
    rng = np.random.default_rng(seed)
    scene, T = bare_room(), view_towards((0.0, 0.0, 0.4), (1.2, 0.0, 0.25))
    for foot in ((1.2, 0.0, 0.0), (0.8, 0.3, 0.0)):
        venue.add_silo(scene, rng, foot, SILOS.index("RBR"), venue.silo_make(rng))
    middle = rng.uniform((0.9, -0.3, 0.1), (1.6, 0.3, 0.5))
    view = render.seen(scene.packed(), Camera(), T)
    as_it_was = [part.copy() for part in view]
    share = render.share_of_another(middle, view, Camera(), T)
    for part, was in zip(view, as_it_was, strict=True):
        np.testing.assert_array_equal(part, was)
    scene.add_ball(middle, np.ones(3), 0, np.eye(3))
    there = render.seen(scene.packed(), Camera(), T)[2] == len(scene.rects) + len(scene.balls) - 1
    assert share == np.count_nonzero(there) / render.whole_balls(middle, Camera(), T)


def test_balls_in_a_silo_touch_and_stay_inside_its_bore():
    for seed in range(200):
        middles = stack(np.random.default_rng(seed), 3)
        gaps = np.linalg.norm(np.diff(middles, axis=0), axis=1)
        np.testing.assert_allclose(gaps, 2 * RADIUS)
        out = np.hypot(*middles[:, :2].T) + RADIUS
        assert out.max() <= field.SILO_BORE / 2 + 1e-9
        assert 0.54 <= middles[2, 2] + RADIUS <= 0.5701


def test_the_depth_buffer_is_that_of_a_naive_twin():
    rng = np.random.default_rng(5)
    scene, camera = bare_room(), Camera(48, 36, 40.0)
    scene.add_rect((2.0, -1.0, 0.0), (0, 2, 0), (0.3, 0, 1.2), (1, 1, 1))
    for _ in range(6):
        scene.add_ball(rng.uniform((0.8, -0.8, 0.1), (1.9, 0.8, 0.6)), np.ones(3), 0, np.eye(3))
    T = view_towards((0.0, 0.1, 0.5), (1.5, 0.0, 0.2), roll=0.2)
    _, depth, what = render.seen(scene.packed(), camera, T)
    for row, col in rng.integers(0, (36, 48), (400, 2)):
        flat = (np.array([col, row]) + 0.5 - camera.centre) / camera.focal
        ray = T[:3, :3] @ np.r_[flat / (1 + camera.distortion * flat @ flat), 1.0]
        hits = [(far, k) for k, far in enumerate(naive_hits(scene, T[:3, 3], ray)) if far > 0]
        far, k = min(hits, default=(np.inf, -1))
        assert what[row, col] == k
        assert depth[row, col] == pytest.approx(far, rel=1e-4)


def naive_hits(scene: Scene, eye, ray):
    """How far away each rectangle and ball is along a ray; nan where it passes by."""
    for rect in scene.rects:
        o, u, v = rect[:3], rect[3:6], rect[6:9]
        t, a, b = np.linalg.solve(np.stack([ray, -u, -v], axis=1), o - eye)
        yield t if 0 <= a <= 1 and 0 <= b <= 1 else np.nan
    for ball in scene.balls:
        roots = np.roots([ray @ ray, -2 * ray @ (ball.centre - eye),
                          (ball.centre - eye) @ (ball.centre - eye) - RADIUS**2])  # fmt: skip
        yield roots.real.min() if np.isreal(roots).all() else np.nan


def test_same_arguments_same_bytes_and_another_index_another_picture():
    one, again = pictures.picture("silo", 7, 3), pictures.picture("silo", 7, 3)
    assert one.image_bgr.tobytes() == again.image_bgr.tobytes()
    np.testing.assert_array_equal(one.boxes, again.boxes)
    assert one.image_bgr.shape == (240, 320, 3) and one.image_bgr.dtype == np.uint8
    assert one.image_bgr.tobytes() != pictures.picture("silo", 7, 4).image_bgr.tobytes()
    assert one.image_bgr.tobytes() != pictures.picture("silo", 8, 3).image_bgr.tobytes()


@pytest.fixture(scope="module")
def many():
    return {kind: [pictures.picture(kind, 99, k) for k in range(150)] for kind in ("ball", "silo")}


@pytest.mark.parametrize("kind", ["ball", "silo"])
def test_boxes_lie_in_the_picture_and_are_not_too_small(many, kind):
    for taken in many[kind]:
        assert (taken.boxes[:, :2] >= 0).all() and (taken.boxes[:, 2:] <= (320, 240)).all()
        sides = taken.boxes[:, 2:] - taken.boxes[:, :2]
        assert (sides >= pictures.LEAST_SIDE[kind]).all()


def test_every_colour_and_every_filling_is_seen_and_sometimes_nothing(many):
    assert {k for taken in many["ball"] for k in taken.class_ids} == set(range(len(BALLS)))
    assert {k for taken in many["silo"] for k in taken.class_ids} == set(range(len(SILOS)))
    for taken in many.values():
        assert 0.01 < np.mean([len(one.boxes) == 0 for one in taken]) < 0.25


def test_balls_have_the_hues_that_cameras_saw(many):
    """Medians over photographs of the real balls: 217-225, 287-309 and 350-356 degrees."""
    hues = {name: [] for name in BALLS}
    for taken in many["ball"]:
        for (x0, y0, x1, y1), k in zip(taken.boxes.astype(int), taken.class_ids, strict=True):
            if x1 - x0 > 12 and y1 - y0 > 12:
                part = taken.image_bgr[(3 * y0 + y1) // 4 : (y0 + 3 * y1) // 4,
                                       (3 * x0 + x1) // 4 : (x0 + 3 * x1) // 4]  # fmt: skip
                b, g, r = np.median(part.reshape(-1, 3), axis=0) / 255
                hues[BALLS[k]].append((colorsys.rgb_to_hsv(r, g, b)[0] * 360 + 60) % 360 - 60)
    middle = {name: np.median(seen) for name, seen in hues.items()}
    assert 212 < middle["blue"] < 228
    assert 265 < middle["purple"] < 305
    assert -14 < middle["red"] < 4


def test_a_lamp_above_casts_the_balls_shadow_below_it():
    scene = bare_room()
    # Light comes down along -x: the shadow falls on the near side.
    scene.lamps = [Lamp(np.array([0.6, 0.0, 0.8]), np.full(3, 0.9))]
    scene.add_ball((1.5, 0.0, RADIUS), np.array([0.9, 0.1, 0.1]), 2, np.eye(3))
    taken = photograph(scene, view_towards((0.3, 0.0, 0.9), (1.4, 0.0, 0.0)))
    x0, _, x1, y1 = taken.boxes[0]
    below = taken.image_bgr[int(y1) + 3, int(x0 + x1) // 2].mean()
    aside = taken.image_bgr[int(y1) + 3, int(x1) + 60].mean()
    assert below < 0.75 * aside


def test_glare_exposure_and_white_balance_do_what_they_say():
    scene, T = bare_room(), view_towards((0.0, 0.0, 0.5), (1.5, 0.0, 0.0))

    def mean(**kwargs):
        rng = np.random.default_rng(0)
        taken = pictures.take(scene, Camera(), T, film.Film(noise=0.0, **kwargs), rng)
        return taken.image_bgr.reshape(-1, 3).mean(axis=0)

    assert mean(exposure=0.1).sum() < mean().sum() < mean(exposure=0.4).sum()
    assert mean(balance=(1.2, 1.0, 0.8))[2] > mean()[2] > mean(balance=(0.8, 1.0, 1.2))[2]
    assert mean(glare=(0.5, 0.5, 1.0)).sum() > mean().sum()


@pytest.mark.parametrize(
    ("kind", "size", "rule"), [("cube", (320, 240), "'ball' or 'silo'"), ("ball", (16, 16), "32")]
)
def test_what_cannot_be_drawn_is_refused(kind, size, rule):
    with pytest.raises(ValueError, match=rule):
        pictures.picture(kind, 1, 1, size)
