"""From light to the file a camera writes: exposure, white balance, blur, noise, tone, JPEG."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Film:
    """How one camera, at one moment, turns light into numbers.

    Attributes
    ----------
    exposure : float
        Mean brightness that the automatic exposure aims at, of 1.
    balance : (float, float, float)
        Gain of red, green and blue.
    saturation : float
        1 keeps the colours.
    blur : float  [pixels of the picture]
        Standard deviation of the defocus.
    motion : (float, float)  [pixels of the picture]
        How far the picture moved while the shutter was open.
    noise : float
        Standard deviation at full brightness, of 1; shot noise: it falls with the light's root.
    contrast : float
        Steepness of the tone curve's middle; 1 is none.
    vignette : float
        Loss of light in the corners, of 1.
    glare : (float, float, float)
        Middle of a veil of light (0 to 1 across, 0 to 1 down) and its strength.
    sharpen : float
    quality : int
        Of the JPEG, 0 to 100.
    """

    exposure: float = 0.2
    balance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    saturation: float = 1.0
    blur: float = 0.4
    motion: tuple[float, float] = (0.0, 0.0)
    noise: float = 0.02
    contrast: float = 1.0
    vignette: float = 0.15
    glare: tuple[float, float, float] = (0.5, 0.0, 0.0)
    sharpen: float = 0.0
    quality: int = 85

    @classmethod
    def random(cls, rng: np.random.Generator, width: int) -> Film:
        """One of the many cameras and moments that a network has to bear."""
        share = width / 320
        tint = rng.normal(0.0, 0.06)
        moving = rng.exponential(2.0) if rng.uniform() < 0.35 else 0.0
        way = rng.uniform(0, 2 * np.pi)
        return cls(
            exposure=float(np.exp(rng.normal(np.log(0.2), 0.4))),
            balance=(1 + tint, 1.0 + rng.normal(0, 0.025), 1 - tint + rng.normal(0, 0.03)),
            saturation=rng.uniform(0.7, 1.3),
            blur=share * abs(rng.normal(0.0, 0.7)) * (rng.uniform() < 0.7),
            motion=(share * moving * np.cos(way), share * moving * np.sin(way)),
            noise=rng.exponential(0.02),
            contrast=rng.uniform(0.9, 1.35),
            vignette=rng.uniform(0.0, 0.35),
            glare=(rng.uniform(), rng.uniform(), rng.exponential(0.3) * (rng.uniform() < 0.12)),
            sharpen=rng.uniform(0.0, 1.2) * (rng.uniform() < 0.4),
            quality=int(rng.integers(35, 97)),
        )


def develop(
    light: NDArray[np.float32], size: tuple[int, int], film: Film, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """The picture, BGR, of a given size.

    Parameters
    ----------
    light : ndarray of float32, shape (h, w, 3)
        Linear RGB, with more pixels than the picture.
    size : (int, int)
        Width and height of the picture.
    film : Film
    rng : numpy.random.Generator

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
    """
    factor = light.shape[1] / size[0]
    light = _blurred(light, film, factor)
    light = cv2.resize(light, size, interpolation=cv2.INTER_AREA)
    light *= film.exposure / max(1e-6, float(light.mean()))
    light = cv2.transform(light, _colours(film))
    light *= _veil(size, film)[..., None]
    if film.glare[2] > 0.0:
        light += _glare(size, film)[..., None]
    np.maximum(light, 0.0, out=light)
    noise = rng.standard_normal(light.shape, np.float32)
    light += noise * (np.float32(film.noise) * cv2.sqrt(light + np.float32(0.02)))
    picture = _tone(light, film.contrast)
    if film.sharpen > 0.0:
        picture += film.sharpen * (picture - cv2.GaussianBlur(picture, (0, 0), 1.0))
    numbers = np.clip(picture * 255.0 + 0.5, 0, 255).astype(np.uint8)
    _, data = cv2.imencode(".jpg", numbers[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, film.quality])
    return cv2.imdecode(data, cv2.IMREAD_COLOR)


def _blurred(light: NDArray[np.float32], film: Film, factor: float) -> NDArray[np.float32]:
    """Defocus, and the smear of a moving camera."""
    if film.blur > 0.05:
        light = cv2.GaussianBlur(light, (0, 0), film.blur * factor)
    dx, dy = film.motion[0] * factor, film.motion[1] * factor
    reach = int(np.ceil(max(abs(dx), abs(dy)) / 2))
    if reach > 0:
        smear = np.zeros((2 * reach + 1, 2 * reach + 1), np.float32)
        ends = [
            (round(16 * (reach + s * dx / 2)), round(16 * (reach + s * dy / 2))) for s in (-1, 1)
        ]
        cv2.line(smear, *ends, 1.0, 1, cv2.LINE_8, 4)
        light = cv2.filter2D(light, -1, smear / smear.sum(), borderType=cv2.BORDER_REPLICATE)
    return light


def _colours(film: Film) -> NDArray[np.float32]:
    """White balance, then saturation, as one matrix."""
    grey = np.tile([0.3, 0.59, 0.11], (3, 1))
    return ((grey + film.saturation * (np.eye(3) - grey)) * film.balance).astype(np.float32)


def _veil(size: tuple[int, int], film: Film) -> NDArray[np.float32]:
    """Light that the lens lets through, less in the corners."""
    x = np.linspace(-1, 1, size[0], dtype=np.float32)
    y = np.linspace(-1, 1, size[1], dtype=np.float32)
    return 1.0 - np.float32(film.vignette / 2) * (x * x + (y * y)[:, None])


def _glare(size: tuple[int, int], film: Film) -> NDArray[np.float32]:
    """A lamp that shines into the lens: a bright spot in a wide veil."""
    across, down, strength = film.glare
    x = np.linspace(0, 1, size[0], dtype=np.float32) - np.float32(across)
    y = np.linspace(0, 1, size[1], dtype=np.float32) - np.float32(down)
    far = x * x + (y * y)[:, None]
    return np.float32(strength) * (0.3 / (1 + 20 * far) + np.exp(-60 * far))


def _tone(light: NDArray[np.float32], contrast: float) -> NDArray[np.float32]:
    """sRGB's power, a soft shoulder towards white, and a steeper middle."""
    light = np.maximum(light, 0.0)
    soft = light * (1.25 + light * np.float32(1.25 / 6.0)) / (1.0 + light)
    picture = cv2.pow(soft, 1 / 2.2)
    return np.clip(0.5 + (picture - 0.5) * np.float32(contrast), 0.0, 1.0)


_LIGHT = (np.arange(256) / 255.0).astype(np.float32) ** np.float32(2.2)


def to_linear(picture: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Light of an sRGB picture."""
    return _LIGHT[picture]
