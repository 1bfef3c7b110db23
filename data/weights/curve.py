"""How the silos' network grew with the pictures shown to it: python data/weights/curve.py

Measures the earlier networks, which the history of this repository keeps, and today's, all of
them on the same pictures and by the same labels. Needs a clone with its history. Then run make.py.
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path

import make

from robocon_course.vision import load_detector
from robocon_course.vision.pictures import picture

EARLIER = {"aae0ed7": 78_400, "d12a9b2": 113_400, "5764d8e": 171_800, "aa09b5e": 262_700}
"""Commits that brought a trained network, and the pictures shown to it until then.

Who ships a new network adds here the commit of the one before."""


def main() -> None:
    drawn = [picture("silo", make.SEEDS["synthetic"], k, None) for k in range(make.TEST_PICTURES)]
    images = [one.image_bgr for one in drawn]
    truths = [(one.boxes, one.class_ids) for one in drawn]
    networks = {passes: of_commit(commit) for commit, passes in EARLIER.items()}
    networks[shown_to_todays()] = (make.FOLDER / "silo.onnx").read_bytes()
    curve = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "silo.onnx"
        for passes, network in networks.items():
            path.write_bytes(network)
            found = make.figures("silo", make.found_in(images, truths, load_detector(path)))
            curve.append({"passes": passes, "map50": found["map50"]})
            print(curve[-1], flush=True)
    (make.FOLDER / "curve.json").write_text(json.dumps(curve, indent=1) + "\n", encoding="utf-8")


def of_commit(commit: str) -> bytes:
    """The file as it was then."""
    order = ["git", "show", f"{commit}:data/weights/silo.onnx"]
    return subprocess.run(order, cwd=make.FOLDER, stdout=subprocess.PIPE, check=True).stdout


def shown_to_todays() -> int:
    """The sum that `made.json` writes out."""
    parts = make.MADE["silo"]["picture passes"].replace(",", "").split("+")
    return sum(map(int, parts))


if __name__ == "__main__":
    main()
