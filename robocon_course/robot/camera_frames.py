"""A picture of the camera, and what was found in it, as JSON.

A picture becomes PNG, which loses nothing, or JPEG where a datagram is short. Detections have the
precision that `vision.reading.Detections` names: float32.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robocon_course.robot.hardware import Frame
from robocon_course.robot.text import Tree, field, number, rows, things, wholes

LARGEST_PICTURE = 16_000_000
"""A picture with more is not unpacked [pixels]."""


def encode_frame(frame: Frame, *, quality: int | None = None) -> Tree:
    """A frame of the camera as a JSON object.

    Parameters
    ----------
    frame : Frame
    quality : int, optional
        Of a JPEG, 1 to 100; left out, the picture becomes PNG and loses nothing.

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        A picture that is none.
    """
    tree: Tree = {"time": float(frame.time), "pan": float(frame.pan), "tilt": float(frame.tilt)}
    if frame.image_bgr is not None:
        name = "png" if quality is None else "jpeg"
        tree[name] = encode_picture(frame.image_bgr, quality)
    tree["found"] = [
        {"kind": str(kind), "boxes": _boxes(found)} for kind, found in frame.found.items()
    ]
    return tree


def _boxes(found: Any) -> list[Tree]:
    boxes = np.asarray(found.boxes, np.float32).reshape(-1, 4).tolist()
    scores = np.asarray(found.scores, np.float32).tolist()
    ids = np.asarray(found.class_ids).tolist()
    return [
        {"left": b[0], "top": b[1], "right": b[2], "bottom": b[3], "score": s, "class_id": int(c)}
        for b, s, c in zip(boxes, scores, ids, strict=True)
    ]


def decode_frame(tree: Tree) -> Frame:
    """The frame that a JSON object describes.

    Parameters
    ----------
    tree : dict

    Returns
    -------
    Frame

    Raises
    ------
    ValueError
        A field that is missing or of another type, bytes that are no picture, a network or a class
        that is not known.
    """
    data = [field(tree, name, str) for name in ("png", "jpeg") if name in tree]
    return Frame(
        number(tree, "time"),
        number(tree, "pan"),
        number(tree, "tilt"),
        decode_picture(data[0]) if data else None,
        {
            field(one, "kind", str): _detections(things(one, "boxes"), field(one, "kind", str))
            for one in things(tree, "found")
        },
    )


def _detections(items: list[Tree], kind: str) -> Any:
    from robocon_course.vision.classes import classes_of
    from robocon_course.vision.reading import Detections

    with np.errstate(over="ignore"):
        boxes = rows(items, "left", "top", "right", "bottom", "score").astype(np.float32)
    ids, known = wholes([item.get("class_id") for item in items], "class_id"), classes_of(kind)
    if not ((ids >= 0) & (ids < len(known))).all():
        raise ValueError(f"class_id: expected 0 to {len(known) - 1} of a {kind}, got {ids}")
    return Detections(boxes[:, :4].copy(), boxes[:, 4].copy(), ids)


def encode_picture(image_bgr: NDArray[np.uint8], quality: int | None = None) -> str:
    """Base64 of a picture's file.

    Parameters
    ----------
    image_bgr : ndarray of uint8, shape (h, w, 3)
    quality : int, optional
        Of a JPEG, 1 to 100; left out, it is PNG.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        No such picture.
    """
    import cv2

    image = np.asarray(image_bgr)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3 or not image.size:
        raise ValueError(f"image_bgr: expected bytes (h, w, 3), got {image.dtype} {image.shape}")
    options = [] if quality is None else [cv2.IMWRITE_JPEG_QUALITY, int(quality)]
    done, data = cv2.imencode(".png" if quality is None else ".jpg", image, options)
    if not done:
        raise ValueError("image_bgr: cannot be written as a picture")
    return b64encode(data).decode("ascii")


def decode_picture(text: str) -> NDArray[np.uint8]:
    """The picture whose file is given in base64.

    Parameters
    ----------
    text : str
        PNG or JPEG.

    Returns
    -------
    ndarray of uint8, shape (h, w, 3)
        Blue, green, red.

    Raises
    ------
    ValueError
        No picture, or one with more than `LARGEST_PICTURE` pixels.
    """
    import cv2
    from PIL import Image

    try:
        data = b64decode(text, validate=True)
        with Image.open(BytesIO(data), formats=("PNG", "JPEG")) as opened:
            width, height = opened.size
    except (ValueError, OSError, SyntaxError, Image.DecompressionBombError):
        raise ValueError("picture: expected PNG or JPEG in base64") from None
    if width * height > LARGEST_PICTURE:
        raise ValueError(f"picture: {width} x {height} pixels are too many")
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise ValueError("picture: its file is damaged")
    return image
