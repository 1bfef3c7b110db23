"""Measure the weights of this folder and write their model card: python data/weights/make.py

Writes card.json (figures), README.md (the card in words) and SHA256SUMS. The networks themselves
come from `robocon train`; how each was made stands in `MADE` below.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np

from robocon_course.vision import CLASSES, average_precisions, load_detector, score_pictures
from robocon_course.vision.evaluation import LOWEST
from robocon_course.vision.metrics import xyxy_from_yolo
from robocon_course.vision.pictures import picture

FOLDER = Path(__file__).resolve().parent
PHOTOGRAPHS = FOLDER.parents[2] / "shared" / "data" / "balls_robocon2024"
LARGER = 480
"""Pixels of the longer side, where time is not short; else 320."""
TEST_PICTURES = 600
SEEDS = {"synthetic": 777_000, "again": 888_000}
"""Of the test pictures, and of others by which nothing was ever chosen."""
LOOSE = 0.3
"""An overlap at which hand-drawn boxes that leave out a ball's rim still count as boxes of it."""
MADE = json.loads((FOLDER / "made.json").read_text(encoding="utf-8"))
"""How each network was trained: filled in by whoever trains it."""


def synthetic(kind: str, seed: int) -> dict:
    """Average precision on drawn pictures of a seed that no training uses."""
    detector = load_detector(FOLDER / f"{kind}.onnx")
    larger, enlarged = detector.with_size(LARGER), []
    rows = []
    for index in range(TEST_PICTURES):
        taken = picture(kind, seed, index, None)
        found = detector.detect(taken.image_bgr, min_score=LOWEST)
        rows.append((found, taken.boxes, taken.class_ids, taken.doubtful))
        found = larger.detect(taken.image_bgr, min_score=LOWEST)
        enlarged.append((found, taken.boxes, taken.class_ids))
    return {
        **figures(kind, [row[:3] for row in rows]),
        "doubtful_set_aside": figures(kind, rows),
        "larger": figures(kind, enlarged),
        "pictures": TEST_PICTURES,
        "seed": seed,
    }


def photographs() -> dict:
    """Average precision of the ball network on other people's photographs."""
    detector, rows = load_detector(FOLDER / "ball.onnx"), []
    names = (PHOTOGRAPHS / "classes.txt").read_text().split()
    for path in sorted(PHOTOGRAPHS.glob("*.[jp][pn]g")):
        image = cv2.imread(str(path))
        lines = np.loadtxt(path.with_suffix(".txt"), ndmin=2)
        boxes = xyxy_from_yolo(lines, *image.shape[1::-1])
        ids = np.array([CLASSES["ball"].index(names[int(k)]) for k in lines[:, 0]])
        rows.append((detector.detect(image, min_score=LOWEST), boxes, ids))
    loose = figures("ball", rows, LOOSE)["map50"]
    return figures("ball", rows) | {"map_loose": loose, "pictures": len(rows)}


def figures(kind: str, rows: list, min_iou: float = 0.5) -> dict:
    """mAP at an overlap, and of each class."""
    each = average_precisions(score_pictures(rows, len(CLASSES[kind]), min_iou))
    classes = dict(zip(CLASSES[kind], np.round(each, 4).tolist(), strict=True))
    return {"map50": round(float(np.nanmean(each)), 4), "classes": classes}


def in_words(card: dict) -> str:
    """The model card."""
    lines = (FOLDER / "card.md").read_text(encoding="utf-8").splitlines()
    table = ["| | ball | silo |", "|---|---|---|"]
    for what in MADE["ball"]:
        table.append(f"| {what} | {MADE['ball'][what]} | {MADE['silo'][what]} |")
    for part, seed in SEEDS.items():
        drawn = [card[kind][part] for kind in ("ball", "silo")]
        test = f"mAP@0.5, {TEST_PICTURES} drawn pictures, seed {seed}"
        for what, found in (
            (f"{test}, every report judged", drawn),
            (f"{test}, doubtful things set aside", [one["doubtful_set_aside"] for one in drawn]),
            (f"{test}, enlarged to {LARGER} pixels", [one["larger"] for one in drawn]),
        ):
            ball, silo = (one["map50"] for one in found)
            table.append(f"| {what} | {ball:.3f} | {silo:.3f} |")
    table.append("| published for the source's robot, on its own photographs | 0.968 | 0.994 |")
    seen = card["ball"].get("photographs")
    if seen:
        table.append(
            f"| mAP@0.5, {seen['pictures']} photographs of the real balls | {seen['map50']:.3f} | |"
        )
        table.append(f"| the same at an overlap of {LOOSE} | {seen['map_loose']:.3f} | |")
    each = []
    for kind in ("ball", "silo"):
        found = card[kind]["synthetic"]["classes"]  # every report judged
        each.append(f"{kind}: " + ", ".join(f"{name} {ap:.3f}" for name, ap in found.items()))
    at, by = lines.index("(table)"), lines.index("(classes)")
    lines[by : by + 1] = [f"- {line}" for line in each]
    lines[at : at + 1] = table
    return "\n".join(lines) + "\n"


def main() -> None:
    old = json.loads((FOLDER / "card.json").read_text()) if (FOLDER / "card.json").is_file() else {}
    card = {
        kind: {part: synthetic(kind, seed) for part, seed in SEEDS.items()}
        for kind in ("ball", "silo")
    }
    if PHOTOGRAPHS.is_dir():
        card["ball"]["photographs"] = photographs()
    elif "photographs" in old.get("ball", {}):
        card["ball"]["photographs"] = old["ball"]["photographs"]
    (FOLDER / "card.json").write_text(json.dumps(card, indent=1) + "\n", encoding="utf-8")
    (FOLDER / "README.md").write_text(in_words(card), encoding="utf-8")
    sums = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in sorted(FOLDER.glob("*.onnx"))
    ]
    (FOLDER / "SHA256SUMS").write_text("".join(sums), encoding="ascii")
    print(json.dumps({kind: card[kind]["synthetic"]["map50"] for kind in card}))


if __name__ == "__main__":
    main()
