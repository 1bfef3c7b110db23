"""The command ``robocon``. Exit codes: 0 fine, 1 wrong answers or drift, 2 unusable input.

`terminal` is what all commands share; `course`, `robot`, `eyes` and `match` hold
them.
"""

from robocon_course.cli import course, eyes, match, robot
from robocon_course.cli.terminal import app

__all__ = ["app", "course", "eyes", "match", "robot"]
