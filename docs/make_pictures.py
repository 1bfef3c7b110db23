"""Draw the pictures of the README from the code that draws them in the lessons.

Run from the top of the checkout: python docs/make_pictures.py
"""

from pathlib import Path

from robocon_course.view import pictures, png

FOLDER = Path(__file__).parent / "pictures"

for name, figure in {
    "field": pictures.draw_plan(),
    "robot": pictures.draw_robot(),
    "system": pictures.draw_system(done=("01",)),
}.items():
    (FOLDER / f"{name}.png").write_bytes(png(figure))
