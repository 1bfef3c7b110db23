"""``python -m robocon_course.cli`` is ``robocon``."""

from robocon_course.cli import app

if __name__ == "__main__":
    app()
