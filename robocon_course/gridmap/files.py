"""Maps on disk: a YAML text beside an image, as ROS keeps them; benchmark maps are read, too.

With v the mean of a pixel's channels, 0 to 255, a cell is occupied with

    p = (255 - v) / 255,    or p = v / 255 with ``negate``

and it is free where p < free_thresh. All else, unknown or occupied, is not free. The mode says
what a pixel holds:

===========  =====================================================================================
``trinary``  one of free, unknown, occupied; an alpha channel counts as one more channel of the mean
``scale``    p itself; where the image is transparent, the cell is unknown
``raw``      the occupancy in per cent; above 100 the cell is unknown
===========  =====================================================================================

The top row of the image is the largest y. A map whose origin has a yaw lies turned about it; it is
laid on rows along x again, and loses up to a cell of free room along its obstacles.

Source: map_server of ROS, section Map format, https://wiki.ros.org/map_server, and its image
loader for the alpha channel and for ``raw``.
"""

from __future__ import annotations

from math import cos, pi, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.gridmap.grid import BoolArray, GridMap
from robocon_course.gridmap.octile import load_octile
from robocon_course.gridmap.room import inflate

if TYPE_CHECKING:
    from PIL.Image import Image

REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
MODES = ("trinary", "scale", "raw")
WHITE, DEEP_WHITE = 255, 65535
ALIGNED = 0.05
"""So little may the far end of a turned map be off, and its angle counts as a right one [cells]."""
FREE, OCCUPIED = 254, 0
"""Grey values that `save_map` writes, those of ROS' map_saver."""


def load_map(path: str | Path) -> GridMap:
    """The map of a ROS YAML file and the image beside it, or a benchmark map.

    Parameters
    ----------
    path : str or Path
        The YAML file. Its ``image`` is looked for from the YAML file's folder. A file that ends
        in ``.map`` is one of the Moving AI Lab's, as `octile` describes them.

    Returns
    -------
    GridMap
        Free cells; unknown ones are not free, nor is what lies beside a map that was turned.

    Raises
    ------
    FileNotFoundError
        No such file, or no such image.
    ValueError
        A key is missing or makes no sense, or the image cannot be read. Or the ``.map`` file is
        broken; the message says where.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no map file {path}; give the YAML file of the map")
    if path.suffix.lower() == ".map":
        return load_octile(path)
    about = _read_yaml(path)
    resolution, (x, y, yaw), thresholds = _numbers(about, path)
    if thresholds[1] > thresholds[0]:
        raise ValueError(f"{path}: free_thresh must not be above occupied_thresh; mend the file")
    mode, negate = str(about.get("mode", "trinary")).lower(), about["negate"]
    if mode not in MODES:
        raise ValueError(f"{path}: mode must be one of {', '.join(MODES)}, got {about['mode']!r}")
    if negate not in (0, 1):
        raise ValueError(f"{path}: negate must be 0 or 1, got {negate!r}")
    pixels = _read_image(_image_of(about["image"], path))
    free, corner = _turned(_free(pixels, mode, bool(negate), thresholds[1])[::-1], yaw)
    return GridMap(free, resolution, (x + resolution * corner[0], y + resolution * corner[1]))


def save_map(grid: GridMap, path: str | Path, *, image: str = "png") -> None:
    """Write a map as ROS' YAML file, with its image beside it under the same name.

    Parameters
    ----------
    grid : GridMap
    path : str or Path
        The YAML file, ``"maps/hall.yaml"`` say; the folder must exist.
    image : {"png", "pgm"}, optional
        Kind of image.

    Raises
    ------
    ValueError
        Another ending than .yaml or .yml, or another kind of image.
    FileNotFoundError
        The folder does not exist.
    """
    import yaml
    from PIL import Image

    path = Path(path)
    if path.suffix not in (".yaml", ".yml"):
        raise ValueError(f"path: a map is written to a .yaml file, got {path.name!r}")
    if image not in ("png", "pgm"):
        raise ValueError(f"image: must be 'png' or 'pgm', got {image!r}")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"there is no folder {path.parent}; make it first")
    picture = path.with_suffix(f".{image}")
    pixels = np.where(grid.free, FREE, OCCUPIED).astype(np.uint8)
    Image.fromarray(pixels[::-1]).save(picture)
    about = {
        "image": picture.name,
        "mode": "trinary",
        "resolution": grid.resolution,
        "origin": [*grid.origin, 0.0],
        "negate": 0,
        "occupied_thresh": 0.65,
        "free_thresh": 0.196,
    }
    text = yaml.safe_dump(about, sort_keys=False, default_flow_style=None, allow_unicode=True)
    path.write_text(text, encoding="utf-8")


def _read_yaml(path: Path) -> dict[str, Any]:
    """The keys and values of a map's YAML file; all required keys are there."""
    import yaml

    try:
        about = yaml.safe_load(path.read_bytes())  # which finds out how the text is encoded
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        mark = getattr(error, "problem_mark", None)
        reason = getattr(error, "problem", None) or str(error).splitlines()[0]
        where = f"line {mark.line + 1}: {reason}" if mark else reason
        raise ValueError(f"{path}: is no YAML text ({where}); is it the image?") from None
    if not isinstance(about, dict):
        raise ValueError(f"{path}: holds no keys and values; a map file begins with 'image: ...'")
    missing = [key for key in REQUIRED if key not in about]
    if missing:
        raise ValueError(f"{path}: does not say {', '.join(missing)}; add the missing lines")
    return about


def _numbers(about: dict[str, Any], path: Path) -> tuple[float, list[float], FloatArray]:
    """Resolution, origin (x, y, yaw) and thresholds (occupied, free)."""
    try:
        resolution = float(as_floats(about["resolution"], "resolution"))
        origin = as_floats(about["origin"], "origin", 3).tolist()
        thresholds = as_floats([about["occupied_thresh"], about["free_thresh"]], "thresholds", 2)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not resolution > 0.0:
        raise ValueError(
            f"{path}: resolution must be a positive number of metres, got {resolution}"
        )
    return resolution, origin, thresholds


def _image_of(name: object, path: Path) -> Path:
    """The image that a map file names."""
    image = path.parent / str(name)
    if not image.is_file() and "\\" in str(name):  # written on Windows
        image = path.parent / str(name).replace("\\", "/")
    if not image.is_file():
        raise FileNotFoundError(
            f"there is no image {image}, which the map file {path.name} names; lay the image "
            "beside the map file and write 'image: ' with its name alone"
        )
    return image


def _read_image(path: Path) -> tuple[NDArray[np.integer[Any]], int]:
    """Pixels, shape (rows, cols, channels) with alpha as the fourth, and how much white is."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            return _pixels(image)
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as an image ({error})") from None
    except Image.DecompressionBombError as error:
        raise ValueError(f"{path}: is too large for a map ({error})") from None


def _pixels(image: Image) -> tuple[NDArray[np.integer[Any]], int]:
    """Pixels of an opened image, as `_read_image` gives them."""
    if image.mode.startswith("I"):  # 16 bits a pixel, no colour
        return np.asarray(image).clip(0, DEEP_WHITE).astype(np.uint16)[..., None], DEEP_WHITE
    if image.has_transparency_data:
        return np.asarray(image.convert("RGBA")), WHITE
    if image.mode in ("1", "L"):
        return np.asarray(image.convert("L"))[..., None], WHITE
    return np.asarray(image.convert("RGB")), WHITE


def _free(
    image: tuple[NDArray[np.integer[Any]], int], mode: str, negate: bool, free_thresh: float
) -> BoolArray:
    """Which pixels are free, the image's way up."""
    pixels, white = image
    averaged = pixels if mode == "trinary" else pixels[..., :3]
    total = averaged.sum(axis=-1, dtype=np.uint16)
    # Of every sum that can be: a map has millions of pixels, but few sums.
    value = WHITE * np.arange(averaged.shape[-1] * white + 1) / (averaged.shape[-1] * white)
    if negate:
        value = WHITE - value
    p = np.floor(value) / 100.0 if mode == "raw" else (WHITE - value) / WHITE
    free = (p < free_thresh)[total]
    return free & (pixels[..., 3:] == white).all(axis=-1) if mode == "scale" else free


def _turned(free: BoolArray, yaw: float) -> tuple[BoolArray, tuple[float, float]]:
    """A map turned about the corner of cell (0, 0), and its new corner from there [cells]."""
    if yaw == 0.0:
        return free, (0.0, 0.0)
    right = round(yaw / (pi / 2.0)) * pi / 2.0
    if abs(yaw - right) * max(free.shape) < ALIGNED:
        yaw = right
    else:
        # A new cell overlaps with the old one its middle lies in, and with some around that.
        free = inflate(GridMap(free, 1.0), 1e-3).free
    (rows, cols), c, s = free.shape, cos(yaw), sin(yaw)
    corners = np.array([(0, 0), (cols, 0), (0, rows), (cols, rows)]) @ [(c, s), (-s, c)]
    low, high = np.floor(corners.min(axis=0) + 1e-9), np.ceil(corners.max(axis=0) - 1e-9)
    x, y = np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1])[:, None] + 0.5
    col, row = np.floor(c * x + s * y).astype(int), np.floor(c * y - s * x).astype(int)
    inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    turned = inside & free[row.clip(0, rows - 1), col.clip(0, cols - 1)]
    return turned, (float(low[0]), float(low[1]))
