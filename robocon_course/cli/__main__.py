"""``python -m robocon_course.cli`` is ``robocon``."""

from robocon_course.cli import app

app()
