"""Maps on disk: a YAML text beside an image, as ROS keeps them.

With v the mean of a pixel's channels, 0 to 255, a cell is occupied with

    p = (255 - v) / 255,    or p = v / 255 with ``negate``

and it is free where p < free_thresh. All else, unknown or occupied, is not free. The mode says
what a pixel holds:

===========  =====================================================================================
``trinary``  one of free, unknown, occupied; an alpha channel counts as one more channel of the mean
``scale``    p itself; where the image is transparent, the cell is unknown
``raw``      the occupancy in per cent; above 100 the cell is unknown
===========  =====================================================================================

The top row of the image is the largest y.

Source: map_server of ROS, section Map format, https://wiki.ros.org/map_server, and its image
loader for the alpha channel and for ``raw``.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from robocon_course._arrays import FloatArray, as_floats
from robocon_course.gridmap.grid import BoolArray, GridMap

if TYPE_CHECKING:
    from PIL.Image import Image

REQUIRED = ("image", "resolution", "origin", "negate", "occupied_thresh", "free_thresh")
MODES = ("trinary", "scale", "raw")
FREE, OCCUPIED = 254, 0
"""Grey values that `save_map` writes, those of ROS' map_saver."""


def load_map(path: str | Path) -> GridMap:
    """The map of a ROS YAML file and the image beside it.

    Parameters
    ----------
    path : str or Path
        The YAML file. Its ``image`` is looked for from the YAML file's folder.

    Returns
    -------
    GridMap
        Free cells; unknown ones are not free.

    Raises
    ------
    FileNotFoundError
        No such file, or no such image.
    ValueError
        A key is missing or makes no sense, the map is turned (yaw other than 0), or the image
        cannot be read.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no map file {path}; give the YAML file of the map")
    about = _read_yaml(path)
    resolution, origin, thresholds = _numbers(about, path)
    if thresholds[1] > thresholds[0]:
        raise ValueError(f"{path}: free_thresh must not be above occupied_thresh; mend the file")
    mode, negate = about.get("mode", "trinary"), about["negate"]
    if mode not in MODES:
        raise ValueError(f"{path}: mode must be one of {', '.join(MODES)}, got {mode!r}")
    if negate not in (0, 1):
        raise ValueError(f"{path}: negate must be 0 or 1, got {negate!r}")
    pixels = _read_image(path.parent / str(about["image"]))
    free = _free(pixels, mode, bool(negate), thresholds[1])
    return GridMap(free[::-1], resolution, origin)


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
        about = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = str(error).splitlines()[0]
        raise ValueError(f"{path}: is no YAML text ({reason}); is it the image?") from None
    if not isinstance(about, dict):
        raise ValueError(f"{path}: holds no keys and values; a map file begins with 'image: ...'")
    missing = [key for key in REQUIRED if key not in about]
    if missing:
        raise ValueError(f"{path}: does not say {', '.join(missing)}; add the missing lines")
    return about


def _numbers(about: dict[str, Any], path: Path) -> tuple[float, tuple[float, float], FloatArray]:
    """Resolution, origin (x, y) and thresholds (occupied, free)."""
    try:
        resolution = float(as_floats(about["resolution"], "resolution"))
        x, y, yaw = as_floats(about["origin"], "origin", 3)
        thresholds = as_floats([about["occupied_thresh"], about["free_thresh"]], "thresholds", 2)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not resolution > 0.0:
        raise ValueError(
            f"{path}: resolution must be a positive number of metres, got {resolution}"
        )
    if yaw != 0.0:
        raise ValueError(
            f"{path}: the map is turned by {yaw} rad, but its rows must lie along x; "
            "turn the image instead and set the third number of origin to 0"
        )
    return resolution, (float(x), float(y)), thresholds


def _read_image(path: Path) -> FloatArray:
    """Channels of every pixel, 0 to 255, (rows, cols, 3) or with alpha (rows, cols, 4)."""
    from PIL import Image, UnidentifiedImageError

    if not path.is_file():
        raise FileNotFoundError(f"there is no image {path}, which the map file names")
    try:
        with Image.open(path) as image:
            return _channels(image)
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError) as error:
        raise ValueError(f"{path}: cannot be read as an image ({error})") from None


def _channels(image: Image) -> FloatArray:
    """Pixels of an opened image as `_read_image` gives them."""
    if image.mode.startswith("I"):  # 16 bits a pixel, no colour
        return np.repeat(np.asarray(image, dtype=np.float64)[..., None] / 257.0, 3, axis=-1)
    mode = "RGBA" if image.has_transparency_data else "RGB"
    return np.asarray(image.convert(mode), dtype=np.float64)


def _free(pixels: FloatArray, mode: str, negate: bool, free_thresh: float) -> BoolArray:
    """Which pixels are free, the image's way up."""
    alpha = pixels[..., 3] if pixels.shape[-1] == 4 else 255.0
    averaged = pixels if mode == "trinary" else pixels[..., :3]
    value = averaged.mean(axis=-1)
    if negate:
        value = 255.0 - value
    if mode == "raw":
        return np.floor(value) < 100.0 * free_thresh
    return ((255.0 - value) / 255.0 < free_thresh) & ((mode == "trinary") | (alpha == 255.0))
