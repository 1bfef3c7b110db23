"""Draw the pictures of the README from the code that draws them in the lessons.

Run from the top of the checkout: python docs/make_pictures.py
"""

from pathlib import Path

from robocon_course import field, worlds
from robocon_course.view import animate, animate_match, pictures, png

FOLDER = Path(__file__).parent / "pictures"

for name, figure in {
    "field": pictures.draw_plan(),
    "robot": pictures.draw_robot(),
    "system": pictures.draw_system(done=("01",)),
}.items():
    (FOLDER / f"{name}.png").write_bytes(png(figure))

drive = worlds.field_drive(0)
film = animate(
    drive.time,
    {"reference": drive.poses},
    angles=drive.module_angles,
    speeds=drive.module_speeds,
    markers={"goal": field.AREA_3_GOAL},
)
(FOLDER / "drive.gif").write_bytes(film.gif)

match = animate_match(worlds.play_match(0, seed=7, with_balls=True))
(FOLDER.parents[1] / "data" / "match" / "match.gif").write_bytes(match.gif)
(FOLDER.parents[1] / "data" / "match" / "match.png").write_bytes(match.still)
