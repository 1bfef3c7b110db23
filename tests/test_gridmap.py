"""Grid maps: points and cells, room for a robot, and ROS map files."""

from __future__ import annotations

import struct
import warnings
import zlib
from math import hypot, inf, nan

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from PIL import Image
from scipy.ndimage import minimum_filter

from robocon_course.gridmap import (
    GridMap,
    inflate,
    inflate_square,
    load_map,
    load_scenarios,
    put_boxes,
    save_map,
)

bitmaps = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, max_side=12))
resolutions = st.sampled_from([0.01, 0.05, 0.1, 0.3, 1.0, 7.0])
metres = st.floats(-50.0, 50.0).map(lambda v: round(v, 4))
grids = st.builds(GridMap, bitmaps, resolutions, st.tuples(metres, metres))


# --- points and cells -------------------------------------------------------------------------


def test_cells_counts_rows_from_the_smallest_y_and_columns_from_the_smallest_x():
    grid = GridMap(np.ones((4, 6), dtype=bool), 0.5, (-1.0, 2.0))
    assert grid.cells([-0.9, 2.1]).tolist() == [0, 0]
    assert grid.cells([[1.9, 2.1], [-0.9, 3.9]]).tolist() == [[0, 5], [3, 0]]
    assert grid.centres([3, 0]).tolist() == [-0.75, 3.75]
    assert grid.shape == (4, 6) and grid.extent == (-1.0, 2.0, 2.0, 4.0)


def test_a_point_on_a_shared_edge_belongs_to_the_cell_further_up_and_right():
    grid = GridMap(np.ones((2, 2), dtype=bool), 0.5)
    assert grid.cells([0.5, 0.5]).tolist() == [1, 1]
    # (0.35 + 0.05) / 0.05 is 7.999999999999999 in floating point.
    fine = GridMap(np.ones((20, 20), dtype=bool), 0.05, (-0.05, -0.05))
    edges = np.round(np.arange(20) * 0.05 - 0.05, 2)
    assert fine.cells(np.stack([edges, edges], axis=-1))[:, 0].tolist() == list(range(20))


def test_points_are_counted_in_cells_rows_first():
    grid = GridMap(np.ones((4, 6), dtype=bool), 0.5, (-1.0, 2.0))
    assert grid.to_cells([[-1.0, 2.0], [0.25, 3.1]]).round(9).tolist() == [[0.0, 0.0], [2.2, 2.5]]
    assert grid.to_cells(np.empty((0, 3, 2))).shape == (0, 3, 2)
    assert grid.to_cells([-inf, nan]).tolist()[1] == -inf


def test_a_point_within_rounding_of_an_edge_is_on_the_edge_and_no_other_is_moved():
    grid = GridMap(np.ones((2, 20), dtype=bool), 0.05)
    edges = np.round(np.arange(20) * 0.05, 2)
    points = np.stack([edges, np.full(20, 0.02)], axis=-1)
    assert (points[:, 0] / 0.05 != np.arange(20)).any()
    assert grid.to_cells(points)[:, 1].tolist() == list(range(20))
    for off in (-1e-6, 1e-6):
        moved = grid.to_cells(points + np.array([off, 0.0]))[:, 1]
        assert moved == pytest.approx(np.arange(20) + off / 0.05, abs=1e-9)


@given(grids, st.tuples(metres, metres))
def test_a_point_lies_in_the_cell_that_counting_says(grid, point):
    counted = grid.to_cells(point)
    assert grid.cells(point).tolist() == np.floor(counted).tolist()
    there = grid.centres(counted - 0.5)
    assert there == pytest.approx(point, abs=1e-9)


@pytest.mark.parametrize("far", [1e300, 1e308, 1e19])
def test_a_point_far_off_has_a_cell_far_off_on_the_same_side(far):
    grid = GridMap(np.ones((2, 2), dtype=bool), 0.05)
    with np.errstate(all="raise"):
        assert grid.cells([[far, 0.0], [0.0, -far]]).tolist() == [[0, 2**62], [-(2**62), 0]]
        assert not grid.contains([far, 0.0]) and not grid.is_free([0.0, far])


@given(grids, st.data())
def test_the_middle_of_a_cell_lies_in_that_cell(grid, data):
    rows, cols = grid.shape
    cell = [data.draw(st.integers(-2, rows + 1)), data.draw(st.integers(-2, cols + 1))]
    middle = grid.centres(cell)
    assert grid.cells(middle).tolist() == cell
    inside = 0 <= cell[0] < rows and 0 <= cell[1] < cols
    assert grid.contains(middle) == inside
    assert grid.is_free(middle) == (inside and grid.free[tuple(cell)])


def test_shapes_of_many_points_are_kept():
    grid = GridMap(np.eye(3, dtype=bool), 1.0)
    points = grid.centres(np.argwhere(np.ones((3, 3), dtype=bool)).reshape(3, 3, 2))
    assert grid.cells(points).shape == points.shape == (3, 3, 2)
    assert grid.is_free(points).tolist() == np.eye(3, dtype=bool).tolist()
    assert grid.is_free(np.empty((0, 2))).shape == (0,)


def test_nothing_outside_the_map_is_free_and_neither_is_nowhere():
    grid = GridMap(np.ones((2, 2), dtype=bool), 1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        outside = [[-0.1, 0.5], [0.5, 2.1], [nan, 0.5], [0.5, inf], [1e300, 0.5]]
        assert not grid.contains(outside).any()
        assert not grid.is_free(outside).any()


def test_a_map_keeps_its_own_copy_that_nobody_can_change():
    free = np.ones((2, 2), dtype=bool)
    grid = GridMap(free, 1.0)
    free[0, 0] = False
    assert grid.free.all()
    with pytest.raises(ValueError, match="read-only"):
        grid.free[0, 0] = False


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((np.ones((2, 2)), 1.0), "free: .*bool.* got float64"),
        ((np.ones(4, dtype=bool), 1.0), r"free: .*shape \(4,\)"),
        ((np.ones((0, 3), dtype=bool), 1.0), "free: "),
        ((np.ones((2, 2), dtype=bool), 0.0), "resolution: must be a positive"),
        ((np.ones((2, 2), dtype=bool), -1.0), "resolution: must be a positive"),
        ((np.ones((2, 2), dtype=bool), nan), "resolution: .*not a finite number"),
        ((np.ones((2, 2), dtype=bool), 1.0, (nan, 0.0)), "origin: .*not a finite number"),
        ((np.ones((2, 2), dtype=bool), 1.0, (0.0,)), "origin: expected shape"),
    ],
)
def test_a_map_that_makes_no_sense_is_refused(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        GridMap(*arguments)


@pytest.mark.parametrize("points", [[nan, 0.0], [0.0, inf]])
def test_a_point_that_is_not_finite_has_no_cell(points):
    with pytest.raises(ValueError, match=r"xy: .*not finite"):
        GridMap(np.ones((2, 2), dtype=bool), 1.0).cells(points)


@pytest.mark.parametrize("method", ["cells", "to_cells", "contains", "is_free", "centres"])
def test_points_of_another_dimension_are_refused(method):
    with pytest.raises(ValueError, match="expected shape"):
        getattr(GridMap(np.ones((2, 2), dtype=bool), 1.0), method)([1.0, 2.0, 3.0])


# --- inflate ----------------------------------------------------------------------------------


def naive_inflate(grid: GridMap, radius: float) -> np.ndarray:
    """By definition: look at the gap to every cell that is not free, the rim outside included."""
    rows, cols = grid.shape
    padded = np.pad(grid.free, 1, constant_values=False)
    blocked = np.argwhere(~padded) - 1
    limit = radius * (1.0 - 1e-9)
    free = grid.free.copy()
    for row in range(rows):
        for col in range(cols):
            for other in blocked:
                up, across = (max(abs(k) - 1, 0) for k in other - (row, col))
                if radius > 0.0 and hypot(up, across) * grid.resolution < limit:
                    free[row, col] = False
    return free


@settings(deadline=None)
@given(grids, st.floats(0.0, 8.0))
def test_inflate_agrees_with_its_definition(grid, cells):
    radius = cells * grid.resolution
    # The limit is a matter of rounding where a whole number of squares meets it exactly.
    assume(cells == 0.0 or abs(cells**2 - round(cells**2)) > 1e-6 or cells == round(cells))
    grown = inflate(grid, radius)
    assert grown.free.tolist() == naive_inflate(grid, radius).tolist()
    assert grown.origin == grid.origin and grown.resolution == grid.resolution


def test_a_robot_anywhere_in_a_free_cell_keeps_clear_of_every_point_of_every_obstacle():
    rng = np.random.default_rng(5)
    grid = GridMap(rng.random((40, 40)) > 0.01, 0.05)
    radius = 0.325
    cells = np.argwhere(inflate(grid, radius).free)
    assert len(cells) > 20
    corners = np.array([(0, 0), (0, 1), (1, 0), (1, 1)])
    edges = (cells[:, None] + corners).reshape(-1, 2) * 0.05  # (y, x) of the free cells' corners
    low = np.argwhere(~grid.free) * 0.05
    nearest = np.clip(edges[:, None], low, low + 0.05)  # on each obstacle's square
    gaps = np.linalg.norm(edges[:, None] - nearest, axis=-1)
    assert gaps.min() >= radius - 1e-9


def test_far_from_an_obstacle_the_distance_is_still_exact():
    free = np.ones((601, 601), dtype=bool)
    free[300, 300] = False
    up, across = np.abs(np.indices(free.shape) - 300)
    gap = np.hypot(np.maximum(up - 1, 0), np.maximum(across - 1, 0))
    for radius in (50.0, 130.0, 261.7):  # of which 50 = |(30, 40)| and 130 = |(50, 120)|
        grown = inflate(GridMap(free, 1.0), radius).free
        rim = np.minimum(300 - up, 300 - across)  # gap to the outside
        assert (grown == (np.minimum(gap, rim) >= radius)).all()


def test_a_robot_as_wide_as_the_gap_just_fits_through_it():
    free = np.zeros((5, 9), dtype=bool)
    free[:, 2:7] = True  # 5 cells of 0.1 m, and the ends of the map are no way out
    assert (
        inflate(GridMap(free, 0.1), 0.2).free.any(axis=0).tolist()
        == [False] * 4 + [True] + [False] * 4
    )
    assert not inflate(GridMap(free, 0.1), 0.21).free.any()


def test_a_map_without_obstacles_ends_at_its_edge():
    grown = inflate(GridMap(np.ones((7, 7), dtype=bool), 1.0), 2.0)
    assert np.argwhere(grown.free).min() == 2 and np.argwhere(grown.free).max() == 4
    assert grown.free.sum() == 9


@pytest.mark.parametrize("radius", [-0.1, nan, inf])
def test_inflate_refuses_a_radius_that_is_none(radius):
    with pytest.raises(ValueError, match="radius: "):
        inflate(GridMap(np.ones((2, 2), dtype=bool), 1.0), radius)


# --- ROS map files ----------------------------------------------------------------------------

ABOUT = {
    "image": "map.png",
    "resolution": "0.1",
    "origin": "[1.0, -2.0, 0.0]",
    "negate": "0",
    "occupied_thresh": "0.65",
    "free_thresh": "0.196",
}


def written(folder, pixels, image="map.png", **changes):
    """A map file with an image of these pixels; a key changed to None is left out."""
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / image)
    about = {**ABOUT, "image": image, **changes}
    path = folder / "map.yaml"
    lines = [f"{key}: {value}" for key, value in about.items() if value is not None]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@settings(deadline=None)
@given(grid=grids, kind=st.sampled_from(["png", "pgm"]))
def test_a_saved_map_is_loaded_as_it_was(grid, kind, tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "hall.yaml"
    save_map(grid, path, image=kind)
    again = load_map(path)
    assert again.free.tolist() == grid.free.tolist()
    assert again.origin == grid.origin and again.resolution == grid.resolution


def test_the_top_row_of_the_image_is_the_largest_y(tmp_path):
    grid = load_map(written(tmp_path, [[0, 0], [0, 0], [255, 0]]))
    assert grid.free.tolist() == [[True, False], [False, False], [False, False]]
    assert grid.is_free([1.05, -1.95]) and grid.origin == (1.0, -2.0)


def test_ros_grey_values_mean_free_unknown_and_occupied(tmp_path):
    # map_saver writes 254, 205 and 0; p(205) = 50/255 = 0.19608 lies just above 0.196
    assert load_map(written(tmp_path, [[254, 205, 0]])).free.tolist() == [[True, False, False]]


def test_the_threshold_itself_is_not_free(tmp_path):
    # p = (255 - 204)/255 = 0.2
    path = written(tmp_path, [[205, 204, 203]], free_thresh="0.2")
    assert load_map(path).free.tolist() == [[True, False, False]]


def test_negate_makes_black_free(tmp_path):
    path = written(tmp_path, [[0, 49, 50, 255]], negate="1")  # 50/255 = 0.19608
    assert load_map(path).free.tolist() == [[True, True, False, False]]
    path = written(tmp_path, [[0, 255]], negate="true")
    assert load_map(path).free.tolist() == [[True, False]]


def test_colours_are_averaged(tmp_path):
    # Means 206, 204 and 85: only the first has p < 0.196, whatever the single channels say.
    pixels = [[(255, 255, 108), (255, 255, 102), (0, 255, 0)]]
    assert load_map(written(tmp_path, pixels)).free.tolist() == [[True, False, False]]


def test_alpha_counts_as_a_channel_in_trinary_and_means_unknown_in_scale(tmp_path):
    # white opaque, white transparent (mean of four 191), grey 190 opaque (mean of four 206)
    pixels = [[(255, 255, 255, 255), (255, 255, 255, 0), (190, 190, 190, 255)]]
    assert load_map(written(tmp_path, pixels)).free.tolist() == [[True, False, True]]
    path = written(tmp_path, pixels, mode="scale")
    assert load_map(path).free.tolist() == [[True, False, False]]


def test_raw_pixels_are_per_cent_of_occupancy(tmp_path):
    path = written(tmp_path, [[0, 19, 20, 100, 255]], mode="raw", free_thresh="0.2")
    assert load_map(path).free.tolist() == [[True, True, False, False, False]]


def test_raw_pixels_are_turned_round_by_negate(tmp_path):
    pixels = [[255, 236, 235, 155, 0]]  # 0, 19, 20 and 100 per cent, and unknown
    path = written(tmp_path, pixels, mode="raw", negate="1", free_thresh="0.2")
    assert load_map(path).free.tolist() == [[True, True, False, False, False]]


def test_images_of_two_colours_of_a_palette_and_of_16_bits_are_read(tmp_path):
    path = written(tmp_path, [[255, 0]])
    grey = Image.fromarray(np.array([[255, 0]], dtype=np.uint8))
    for image in (grey.convert("1"), grey.convert("P"), grey.convert("LA")):
        image.save(tmp_path / "map.png")
        assert load_map(path).free.tolist() == [[True, False]], image.mode
    # 206 and 204 of 255, in 65535ths: p = 0.192 and 0.2
    deep = np.array([[65535, 206 * 257, 204 * 257, 0]], dtype=np.uint16)
    Image.fromarray(deep).save(tmp_path / "map.png")
    assert load_map(path).free.tolist() == [[True, True, False, False]]


def test_a_text_pgm_is_read_and_the_image_may_lie_elsewhere(tmp_path):
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a b.pgm").write_text("P2\n# a comment\n2 1\n255\n255 0\n")
    for image in ("images/a b.pgm", str(tmp_path / "images" / "a b.pgm")):
        path = written(tmp_path, [[0]])
        text = path.read_text(encoding="utf-8").replace("map.png", f'"{image}"')
        path.write_text(text, encoding="utf-8")
        assert load_map(path).free.tolist() == [[True, False]]


def test_numbers_without_a_point_are_numbers_too(tmp_path):
    path = written(tmp_path, [[255]], resolution="5e-2", origin="[1, 2, 0]")
    assert load_map(path).resolution == 0.05  # YAML alone would read 5e-2 as a word


def test_a_saved_map_follows_the_format_by_the_letter(tmp_path):
    import yaml

    save_map(GridMap(np.array([[True, False]]), 0.05, (-1.5, 2.0)), tmp_path / "hall.yaml")
    about = yaml.safe_load((tmp_path / "hall.yaml").read_text(encoding="utf-8"))
    assert about["image"] == "hall.png" and about["origin"] == [-1.5, 2.0, 0.0]
    assert set(about) == {*ABOUT, "mode"}
    assert np.asarray(Image.open(tmp_path / "hall.png")).tolist() == [[254, 0]]


@pytest.mark.parametrize("key", ABOUT)
def test_a_file_that_lacks_a_key_is_refused_by_name(tmp_path, key):
    path = written(tmp_path, [[255]])
    lines = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join(line for line in lines if not line.startswith(f"{key}:")))
    with pytest.raises(ValueError, match=f"does not say {key}"):
        load_map(path)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"resolution": "0"}, "resolution must be a positive"),
        ({"resolution": "wide"}, "resolution: expected numbers"),
        ({"resolution": ".nan"}, "resolution: .*not a finite number"),
        ({"origin": "[0.0, 0.0, .inf]"}, "origin: .*not a finite number"),
        ({"origin": "[0.0, .nan, 0.0]"}, "origin: .*not a finite number"),
        ({"origin": "[0.0, 0.0]"}, "origin: expected shape"),
        ({"negate": "2"}, "negate must be 0 or 1"),
        ({"mode": "grey"}, "mode must be one of trinary, scale, raw"),
        ({"free_thresh": "0.7"}, "free_thresh must not be above occupied_thresh"),
        ({"occupied_thresh": "much"}, "thresholds: expected numbers"),
    ],
)
def test_a_file_that_makes_no_sense_is_refused_with_its_name(tmp_path, changes, sentence):
    with pytest.raises(ValueError, match=f"map.yaml: .*{sentence}"):
        load_map(written(tmp_path, [[255]], **changes))


def test_missing_files_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no map file .*hall\.yaml"):
        load_map(tmp_path / "hall.yaml")
    path = written(tmp_path, [[255]])
    (tmp_path / "map.png").unlink()
    with pytest.raises(FileNotFoundError, match=r"no image .*map\.png"):
        load_map(path)


@pytest.mark.parametrize("content", [b"", b"no image", b"\x89PNG\r\n\x1a\nbroken"])
def test_an_image_that_cannot_be_read_is_refused(tmp_path, content):
    path = written(tmp_path, [[255]])
    (tmp_path / "map.png").write_bytes(content)
    with pytest.raises(ValueError, match=r"map\.png: cannot be read as an image"):
        load_map(path)


def test_an_image_cut_short_is_refused(tmp_path):
    rng = np.random.default_rng(1)
    path = written(tmp_path, rng.integers(0, 255, (60, 60)))
    whole = (tmp_path / "map.png").read_bytes()
    (tmp_path / "map.png").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=r"map\.png: cannot be read as an image"):
        load_map(path)


@pytest.mark.parametrize("text", ["image: [", "just words", "", "\x00\x01"])
def test_a_file_that_is_no_map_text_is_refused(tmp_path, text):
    path = tmp_path / "map.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"map\.yaml: (is no YAML|holds no keys)"):
        load_map(path)


def test_the_image_given_for_the_map_file_is_refused(tmp_path):
    written(tmp_path, [[255]])
    with pytest.raises(ValueError, match=r"map\.png: .*is it the image\?"):
        load_map(tmp_path / "map.png")


def test_save_map_refuses_other_kinds_of_files(tmp_path):
    grid = GridMap(np.ones((1, 1), dtype=bool), 1.0)
    with pytest.raises(ValueError, match=r"path: .*\.yaml"):
        save_map(grid, tmp_path / "hall.png")
    with pytest.raises(ValueError, match="image: must be 'png' or 'pgm'"):
        save_map(grid, tmp_path / "hall.yaml", image="jpg")
    with pytest.raises(FileNotFoundError, match="no folder"):
        save_map(grid, tmp_path / "nowhere" / "hall.yaml")


def chunk(kind: bytes, body: bytes) -> bytes:
    """A part of a PNG file."""
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def test_grey_with_alpha_in_16_bits_each_is_read(tmp_path):
    pixels = [(65535, 65535), (65535, 0), (0, 65535)]  # white opaque, white transparent, black
    row = b"\0" + b"".join(struct.pack(">HH", *pixel) for pixel in pixels)
    png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 3, 1, 16, 4, 0, 0, 0))
    path = written(tmp_path, [[0]])
    (tmp_path / "map.png").write_bytes(
        png + chunk(b"IDAT", zlib.compress(row)) + chunk(b"IEND", b"")
    )
    assert load_map(path).free.tolist() == [[True, False, False]]  # mean of four 191 is 0.25


@pytest.mark.parametrize(
    ("content", "free"),
    [
        (b"P5\n# CREATOR: map_saver 0.050 m/pix\n3 1\n255\n\xfe\xcd\x00", [True, False, False]),
        (b"P5\n#one\n#two\n3 # columns\n1\n# white\n255\n\xfe\xcd\x00", [True, False, False]),
        (b"P5 3 1 255 \xfe\xcd\x00", [True, False, False]),
        (b"P2\n3 1\n# white is 100\n100\n100 81\n0\n", [True, True, False]),  # p = 0.19
        (b"P2\r\n3 1\r\n100\r\n100 80\r\n0\r\n", [True, False, False]),  # p = 0.2
        (b"P5\n3 1\n65535\n\xff\xff\xcc\xcc\x00\x00", [True, False, False]),  # p = 0.2
        (b"P2\n3 1\n1000\n1000 810 800\n", [True, True, False]),
        (b"P1\n3 1\n0 1 0\n", [True, False, True]),  # 1 is black
        (b"P4\n3 1\n\x40", [True, False, True]),
    ],
    ids=lambda value: value[:2].decode() if isinstance(value, bytes) else "",
)
def test_every_kind_of_pgm_is_read_with_its_comments_and_its_white(tmp_path, content, free):
    path = written(tmp_path, [[0]], image="map.pgm")
    (tmp_path / "map.pgm").write_bytes(content)
    assert load_map(path).free.tolist() == [free]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-8"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_map_file_written_on_windows_is_read(tmp_path, encoding, end):
    path = written(tmp_path, [[255, 0]])
    text = path.read_text(encoding="utf-8") + "\nmode: Trinary\nmade: in der Küche\n"
    path.write_bytes(text.replace("\n", end).encode(encoding))
    assert load_map(path).free.tolist() == [[True, False]]


def test_an_image_named_as_on_windows_is_found_beside_the_map_file(tmp_path):
    (tmp_path / "images").mkdir()
    path = written(tmp_path, [[255, 0]])
    (tmp_path / "map.png").rename(tmp_path / "images" / "map.png")
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("map.png", ".\\images\\map.png"), encoding="utf-8")
    assert load_map(path).free.tolist() == [[True, False]]
    path.write_text(text.replace("map.png", "C:\\maps\\map.png"), encoding="utf-8")
    with pytest.raises(FileNotFoundError, match="lay the image beside the map file"):
        load_map(path)


@pytest.mark.parametrize(
    ("word", "metres"),
    [("0.05", 0.05), (".05", 0.05), ("5.0e-2", 0.05), ("5E-2", 0.05), ("+0.05", 0.05), ("1", 1.0),
     ("0.050000 # metres", 0.05), ("'0.05'", 0.05)],
)  # fmt: skip
def test_numbers_are_read_however_they_are_written(tmp_path, word, metres):
    grid = load_map(written(tmp_path, [[255]], resolution=word, origin="\n- -1e1\n- -0\n- -0.0"))
    assert grid.resolution == metres and grid.origin == (-10.0, 0.0)


@pytest.mark.parametrize("quarters", [-3, -2, -1, 0, 1, 2, 5])
@pytest.mark.parametrize("off", [0.0, 4e-5])
def test_a_map_turned_by_right_angles_keeps_every_cell(tmp_path, quarters, off):
    pixels = np.array([[255, 0, 0, 0], [255, 255, 0, 0], [0, 0, 0, 255]])
    yaw = quarters * np.pi / 2.0 + off
    grid = load_map(written(tmp_path, pixels, origin=f"[1.0, -2.0, {yaw}]"))
    assert grid.free.tolist() == np.rot90(pixels[::-1] > 0, -quarters).tolist()
    # The corner about which it turned is still a corner, and the map lies on the side it should.
    inner = np.array([[0.05, 0.05], [-0.05, 0.05], [-0.05, -0.05], [0.05, -0.05]])[quarters % 4]
    pivot = np.array([1.0, -2.0])
    assert grid.contains(pivot + inner) and not grid.contains(pivot - inner)


@settings(deadline=None, max_examples=60)
@given(free=bitmaps, yaw=st.floats(-7.0, 7.0), data=st.data())
def test_a_turned_map_is_free_only_where_it_was_free_and_loses_a_cell_at_most(
    free, yaw, data, tmp_path_factory
):
    folder = tmp_path_factory.mktemp("turned")
    plain = GridMap(free, 0.1)
    turned = load_map(written(folder, 255 * free[::-1].astype(int), origin=f"[0, 0, {yaw:.6f}]"))
    c, s = np.cos(round(yaw, 6)), np.sin(round(yaw, 6))
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    cells = np.argwhere(turned.free)
    # What lies nearer to a cell's edge than a twentieth of a cell may have been aligned away.
    points = turned.centres(cells)[:, None] + rng.uniform(-0.042, 0.042, (len(cells), 50, 2))
    assert plain.is_free(points @ [[c, -s], [s, c]]).all()
    # In the middle of five by five free cells something is left.
    wide = minimum_filter(free, 5, mode="constant") if min(free.shape) > 4 else np.zeros((0, 2))
    middles = plain.centres(np.argwhere(wide))
    assert turned.is_free(middles @ [[c, s], [-s, c]]).all()


def test_a_text_that_is_no_yaml_is_refused_with_the_line(tmp_path):
    path = tmp_path / "map.yaml"
    path.write_text('resolution: 0.1\nimage: "C:\\maps\\hall.pgm"\n', encoding="utf-8")
    with pytest.raises(ValueError, match=r"map\.yaml: is no YAML text \(line 2: .*escape"):
        load_map(path)


def test_an_image_larger_than_memory_may_be_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 9)
    with pytest.raises(ValueError, match=r"map\.png: is too large for a map"):
        load_map(written(tmp_path, np.zeros((5, 5))))


# --- benchmark maps ---------------------------------------------------------------------------

LETTERS = "type octile\nheight 2\nwidth 4\nmap\n.GS@\nOTW.\n"
PAIRS = "version 1\n0\tthis.map\t4\t2\t0\t0\t2\t0\t2\n7\tmaps/a b.map 4 2 1 0 1 0 0.0\n"


def text_file(path, text: str, end: str = "\n"):
    """A file with these lines."""
    path.write_bytes(text.replace("\n", end).encode("utf-8"))
    return path


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("text", [LETTERS, LETTERS[:-1], LETTERS + "\n \n", "\ufeff" + LETTERS])
def test_a_benchmark_map_is_read_its_first_line_being_the_largest_y(tmp_path, text, end):
    grid = load_map(text_file(tmp_path / "this.map", text, end))
    assert grid.free.tolist() == [[False, False, False, True], [True, True, True, False]]
    assert (grid.resolution, grid.origin) == (1.0, (0.0, 0.0))


def test_a_header_in_another_order_or_with_more_blanks_is_read(tmp_path):
    text = LETTERS.replace("height 2\nwidth 4", "width  4 \nheight\t2")
    assert load_map(text_file(tmp_path / "THIS.MAP", text)).shape == (2, 4)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("type octile", "type tile", "its first lines must be 'type octile'"),
        ("map\n", "", "its first lines must be 'type octile'"),
        ("height 2", "height two", "height must be a positive whole number, got 'two'"),
        ("width 4", "width 0", "width must be a positive whole number, got '0'"),
        ("width 4", "depth 4", "width must be a positive whole number, got ''"),
        ("OTW.\n", "", "holds 1 rows, but says height 2; is it whole"),
        ("OTW.", "OTW", "line 6 holds 3 cells, but the file says width 4"),
        (".GS@", "", "line 5 holds 0 cells"),
        ("OTW.", "OTW#", "'#' is no letter for a cell"),
        ("OTW.", "OTWé", "'é' is no letter for a cell"),
    ],
)
def test_a_benchmark_map_that_is_broken_is_refused_with_what_is_wrong(tmp_path, old, new, sentence):
    path = text_file(tmp_path / "this.map", LETTERS.replace(old, new))
    with pytest.raises(ValueError, match=f"this.map: .*{sentence}"):
        load_map(path)


@pytest.mark.parametrize("content", [b"", b"\xff\xfe\x00", b"\x89PNG"])
def test_what_is_no_text_is_no_benchmark_map(tmp_path, content):
    (tmp_path / "this.map").write_bytes(content)
    with pytest.raises(ValueError, match=r"this\.map: is no"):
        load_map(tmp_path / "this.map")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("version", ["version 1", "version 1.0", "version 1 "])
def test_pairs_are_points_in_metres_with_the_length_of_the_way(tmp_path, end, version):
    path = text_file(tmp_path / "this.scen", PAIRS.replace("version 1", version), end)
    plain = load_map(text_file(tmp_path / "this.map", LETTERS))
    first, second = load_scenarios(path, plain)
    assert first == ((0.5, 1.5), (2.5, 1.5), 2.0)
    assert second.start == second.goal == (1.5, 1.5) and second.length == 0.0
    there = GridMap(plain.free, 0.05, (-1.0, 7.0))
    start, goal, length = load_scenarios(path, there)[0]
    assert (*start, *goal, length) == pytest.approx((-0.975, 7.075, -0.875, 7.075, 0.1))


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("version 1", "0\tthis.map", "must begin with a line 'version 1'"),
        ("\t4\t2\t0", "\t4\t3\t0", "line 2 belongs to a map of 3 x 4 cells, .* has 2 x 4"),
        ("4 2 1 0 1 0 0.0", "4 2 1 0 1 2 0.0", "line 3 names a cell outside the map"),
        ("4 2 1 0 1 0 0.0", "4 2 1 0 1 -1 0.0", "line 3 names a cell outside the map"),
        ("4 2 1 0 1 0 0.0", "4 2 1 0 0.0", "line 3 is no pair of points"),
        ("0.0", "nan", "line 3 is no pair of points"),
        ("0.0", "far", "line 3 is no pair of points"),
    ],
)
def test_pairs_that_make_no_sense_are_refused_with_their_line(tmp_path, old, new, sentence):
    path = text_file(tmp_path / "this.scen", PAIRS.replace(old, new))
    grid = load_map(text_file(tmp_path / "this.map", LETTERS))
    with pytest.raises(ValueError, match=f"this.scen: {sentence}"):
        load_scenarios(path, grid)


def test_pairs_that_are_not_there_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no file .*hall\.scen"):
        load_scenarios(tmp_path / "hall.scen", GridMap(np.ones((1, 1), dtype=bool), 1.0))


# --- room for a square, boxes -----------------------------------------------------------------


def naive_square(grid: GridMap, half: float) -> np.ndarray:
    """Room by its definition: corners of every pair of cells, x and y each for itself."""
    rows, cols = grid.shape
    free = np.zeros(grid.shape, dtype=bool)
    blocked = [(r, c) for r in range(-1, rows + 1) for c in range(-1, cols + 1)]
    blocked = [
        (r, c) for r, c in blocked if not (0 <= r < rows and 0 <= c < cols) or not grid.free[r, c]
    ]
    for row, col in np.ndindex(rows, cols):
        gaps = [max(abs(r - row), abs(c - col)) - 1 for r, c in blocked]
        free[row, col] = min(gaps) * grid.resolution >= half - 1e-9 and grid.free[row, col]
    return free


@settings(max_examples=60, deadline=None)
@given(
    arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=9)),
    st.sampled_from([0.0, 0.05, 0.1, 0.11, 0.2, 0.325, 5.0]),
)
def test_room_for_a_square_agrees_with_its_definition(free, half):
    grid = GridMap(free, 0.1, (-1.0, 2.0))
    room = inflate_square(grid, half)
    np.testing.assert_array_equal(room.free, naive_square(grid, half))
    assert (room.resolution, room.origin) == (0.1, (-1.0, 2.0))


def test_one_obstacle_blocks_a_square_of_cells():
    free = np.ones((15, 15), dtype=bool)
    free[7, 6] = False
    room = inflate_square(GridMap(free, 0.05), 0.12)  # 2.4 cells
    assert not room.free[4:11, 3:10].any()
    assert room.free[11, 3:12].all() and room.free[3:12, 10].all()


def test_a_square_that_a_disc_has_room_for_hits_the_corner():
    box = GridMap(np.ones((200, 200), dtype=bool), 0.01)
    box = put_boxes(box, [(0.0, 0.0, 1.0, 1.0)])
    middle = np.array([1.0, 1.0]) + 0.34 / np.sqrt(2.0)
    assert inflate(box, 0.325).is_free(middle)
    assert (middle - 0.325 < 1.0).all(), "the body's corner stands in the box"
    assert not inflate_square(box, 0.325).is_free(middle)
    assert not (inflate_square(box, 0.325).free & ~inflate(box, 0.325).free).any()


@pytest.mark.parametrize("half", [-0.1, np.nan, np.inf, "wide"])
def test_a_half_side_that_is_none_is_refused(half):
    with pytest.raises(ValueError, match="half:"):
        inflate_square(GridMap(np.ones((3, 3), dtype=bool), 1.0), half)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(
        st.tuples(*[st.integers(-30, 80)] * 2, *[st.integers(1, 30)] * 2), min_size=0, max_size=4
    )
)
def test_a_box_blocks_the_cells_that_it_overlaps_and_no_others(boxes):
    grid = GridMap(np.ones((12, 15), dtype=bool), 0.05, (-0.1, 0.2))
    corners = [(x / 100, y / 100, (x + w) / 100, (y + h) / 100) for x, y, w, h in boxes]
    free = put_boxes(grid, np.reshape(corners, (-1, 4))).free
    for row, col in np.ndindex(grid.shape):
        x, y = -10 + 5 * col, 20 + 5 * row  # of the cell's lower left corner [cm]
        hit = any(bx < x + 5 and x < bx + w and by < y + 5 and y < by + h for bx, by, w, h in boxes)
        assert free[row, col] == (not hit)


def test_boxes_that_are_none_are_refused():
    grid = GridMap(np.ones((3, 3), dtype=bool), 1.0)
    with pytest.raises(ValueError, match="boxes: expected corners"):
        put_boxes(grid, [(1.0, 0.0, 0.0, 1.0)])
    with pytest.raises(ValueError, match="boxes: expected shape"):
        put_boxes(grid, [1.0, 2.0])
