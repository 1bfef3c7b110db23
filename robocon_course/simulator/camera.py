"""What the robot's camera sees: the synthetic camera, in one hall for a whole match."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from robocon_course import field
from robocon_course._arrays import FloatArray, as_floats
from robocon_course.field.standing import standing
from robocon_course.robot import MODULES
from robocon_course.vision import film, paint, pictures, venue
from robocon_course.vision.camera import Camera, camera_pose
from robocon_course.vision.classes import BALLS, SILOS
from robocon_course.vision.film import Film
from robocon_course.vision.pictures import Picture
from robocon_course.vision.scene import Scene

MOST_BALLS = 64
"""How many balls lie about at most; each keeps its pattern wherever it rolls."""


def view_from(pose: FloatArray, pan: float, tilt: float) -> FloatArray:
    """``T_map_camera`` of a robot's camera, tipped with the robot where the floor slopes.

    Parameters
    ----------
    pose : ndarray, shape (3,)  [m, m, rad; map]
    pan, tilt : float  [rad]

    Returns
    -------
    ndarray, shape (4, 4)
    """
    rise_x, rise_y, height = standing(pose, MODULES).tolist()
    return camera_pose(pose, height, pan=pan, tilt=tilt, rise=(rise_x, rise_y))


class FieldCamera:
    """A camera on a robot. Hall, light, paint and lens are drawn once, the noise anew each time.

    Parameters
    ----------
    seed : int
        Of the hall; the same seed is the same hall.
    camera : Camera
    on : Film, optional
        How light becomes numbers; drawn from the seed when left out, without glare and blur.

    Examples
    --------
    >>> eye = FieldCamera(seed=1)
    >>> taken = eye.look((2.6, 10.0, 3.14), balls=[((1.1, 10.0, 0.245), "red")], tilt=0.3)
    >>> taken.image_bgr.shape, taken.class_ids.tolist()
    ((240, 320, 3), [2])
    """

    def __init__(self, seed: int, camera: Camera = Camera(), on: Film | None = None) -> None:  # noqa: B008
        rng = np.random.default_rng([seed, 2024])
        self.camera = camera
        self._hall = venue.field_hall(rng)
        self._paints = {name: paint.ball_colour(name, rng) for name in BALLS}
        self._turns = [venue.rotation(rng) for _ in range(MOST_BALLS)]
        self._silos = int(rng.integers(2**31))
        self._make = venue.silo_make(rng)
        drawn = replace(film.Film.random(rng, camera.width), glare=(0.5, 0.0, 0.0), blur=0.4)
        self.film = on or replace(drawn, motion=(0.0, 0.0), exposure=0.2)
        self._rng = np.random.default_rng([seed, 80])

    def look(
        self,
        pose: ArrayLike,
        *,
        pan: float = 0.0,
        tilt: float = 0.0,
        balls: Iterable[tuple[Sequence[float], str]] = (),
        silos: Sequence[str] = (),
        kind: str = "ball",
    ) -> Picture:
        """What the camera sees.

        Parameters
        ----------
        pose : array_like, shape (3,)  [m, m, rad, map]
            Of the robot, which stands on the field's floor.
        pan, tilt : float  [rad]
            Of the camera servo: to the left, and down.
        balls : iterable of ((x, y, z) [m, map], colour)
            Middles of the balls outside the silos, and ``"blue"``, ``"purple"`` or ``"red"``.
        silos : sequence of str
            Fillings of silos 1 to 5 as `classes.SILOS` writes them; fewer leaves the rest away.
        kind : {"ball", "silo"}
            What the true boxes are drawn around.

        Returns
        -------
        Picture

        Raises
        ------
        ValueError
            A pose that is none, a colour or a filling that does not exist, too many balls or silos.
        """
        pose = as_floats(pose, "pose", 3)
        T_map_camera = view_from(pose, pan, tilt)
        scene = replace(self._hall, balls=list(self._hall.balls), cages=[])
        self._fill(scene, silos)
        for k, (centre, name) in enumerate(balls):
            if name not in BALLS or k >= MOST_BALLS:
                raise ValueError(
                    f"balls: expected at most {MOST_BALLS}, each {', '.join(BALLS)}; "
                    f"number {k} is {name!r}"
                )
            centre = as_floats(centre, "balls", 3)
            scene.add_ball(centre, self._paints[name], BALLS.index(name), self._turns[k])
        return pictures.take(scene, self.camera, T_map_camera, self.film, self._rng, kind=kind)

    def _fill(self, scene: Scene, silos: Sequence[str]) -> None:
        """The silos, each standing and filled in the same way whenever it holds the same balls."""
        if len(silos) > len(field.SILOS):
            raise ValueError(f"silos: the field has {len(field.SILOS)}, got {len(silos)}")
        make = self._make
        for number, ((x, y), filling) in enumerate(zip(field.SILOS, silos, strict=False)):
            if filling not in SILOS:
                known = ", ".join(SILOS[:5])
                raise ValueError(f"silos: expected fillings like {known}, got {filling!r}")
            rng = np.random.default_rng([self._silos, number])
            foot = (x, y, field.SILO_ZONE.height)
            venue.add_silo(scene, rng, foot, SILOS.index(filling), make)
