"""The course's big pictures: the field, the robot, the robot's program, and a match as a film."""

from robocon_course import files
from robocon_course.view._plan import draw_plan
from robocon_course.view._robot import draw_robot
from robocon_course.view._system import draw_system
from robocon_course.view.canvas import Animation

__all__ = ["draw_plan", "draw_robot", "draw_system", "match_film"]


def match_film() -> tuple[Animation, str]:
    """A whole match of the course's own robot, six times as fast (`data/match`), and its twin.

    Returns
    -------
    Animation
    str
        What came out, as the match itself said it when the film was made.
    """
    gif, still, words = (
        files.data_file(f"match/match.{kind}").read_bytes() for kind in ("gif", "png", "txt")
    )
    return Animation(gif, still), words.decode().strip()
