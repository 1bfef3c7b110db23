"""Draw the pictures of the README from the code that draws them in the lessons.

Run from the top of the checkout: python docs/make_pictures.py
"""

from pathlib import Path

from robocon_course import field, worlds
from robocon_course.view import animate, animate_match, match_twin, pictures, png

FOLDER = Path(__file__).parent / "pictures"
MATCH_SEED = 1
"""Of the match in the film: the README names it, and its alt text is data/match/match.txt."""

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

match = worlds.play_match(0, seed=MATCH_SEED, with_balls=True)
film = animate_match(match)
for name, content in {
    "match.gif": film.gif,
    "match.png": film.still,
    "match.txt": f"{match_twin(match)}\n".encode(),
}.items():
    (FOLDER.parents[1] / "data" / "match" / name).write_bytes(content)
