"""Measure the weights of this folder and write their model card: python data/weights/make.py

Writes card.json (figures), README.md (the card in words) and SHA256SUMS. The networks themselves
come from `robocon train`; how each was made stands in made.json.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np

from robocon_course.vision import (
    CLASSES,
    Detector,
    average_precisions,
    load_detector,
    score_pictures,
)
from robocon_course.vision.evaluation import LOWEST
from robocon_course.vision.metrics import xyxy_from_yolo
from robocon_course.vision.pictures import picture

FOLDER = Path(__file__).resolve().parent
PHOTOGRAPHS = FOLDER.parents[2] / "shared" / "data" / "balls_robocon2024"
PILE = "8b83b73e"
"""How the name of the photograph begins whose boxes were drawn well inside the balls' rims."""
FAST = 320
"""Longer side of the pictures for whom time is short [pixels]; the ball network's own is 480."""
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
    drawn = [picture(kind, seed, index, None) for index in range(TEST_PICTURES)]
    truths = [(one.boxes, one.class_ids, one.doubtful) for one in drawn]
    images = [one.image_bgr for one in drawn]
    rows = found_in(images, truths, detector)
    fast = found_in(images, truths, detector.with_size(FAST))
    return {
        **figures(kind, [row[:3] for row in rows]),
        "doubtful_set_aside": figures(kind, rows),
        "fast": figures(kind, [row[:3] for row in fast]),
        "pictures": TEST_PICTURES,
        "seed": seed,
    }


def photographs() -> dict:
    """Average precision of the ball network on other people's photographs."""
    detector, images, truths = load_detector(FOLDER / "ball.onnx"), [], []
    names = (PHOTOGRAPHS / "classes.txt").read_text().split()
    paths = sorted(PHOTOGRAPHS.glob("*.[jp][pn]g"))
    for path in paths:
        images.append(cv2.imread(str(path)))
        lines = np.loadtxt(path.with_suffix(".txt"), ndmin=2)
        boxes = xyxy_from_yolo(lines, *images[-1].shape[1::-1])
        truths.append(
            (boxes, np.array([CLASSES["ball"].index(names[int(k)]) for k in lines[:, 0]]))
        )
    rows = found_in(images, truths, detector)
    fast = found_in(images, truths, detector.with_size(FAST))
    others = [row for path, row in zip(paths, rows, strict=True) if not path.stem.startswith(PILE)]
    return {
        **figures("ball", rows),
        "without_pile": figures("ball", others)["map50"],
        "map_loose": figures("ball", rows, LOOSE)["map50"],
        "fast": figures("ball", fast)["map50"],
        "pictures": len(rows),
    }


def found_in(images: list, truths: list, detector: Detector) -> list:
    """What is found in pictures, each with its truths: rows for `score_pictures`."""
    return [
        (detector.detect(image, min_score=LOWEST), *truth)
        for image, truth in zip(images, truths, strict=True)
    ]


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
            (f"{test}, at {FAST} pixels", [one["fast"] for one in drawn]),
        ):
            ball, silo = (one["map50"] for one in found)
            table.append(f"| {what} | {ball:.3f} | {silo:.3f} |")
    table.append("| published for the source's robot, on its own photographs | 0.968 | 0.994 |")
    seen = card["ball"].get("photographs")
    if seen:
        table.append(
            f"| mAP@0.5, {seen['pictures']} photographs of the real balls | {seen['map50']:.3f} | |"
        )
        table.append(
            f"| {seen['pictures'] - 1} of them, without the pile from afar "
            f"| {seen['without_pile']:.3f} | |"
        )
        table.append(f"| all, at an overlap of {LOOSE} | {seen['map_loose']:.3f} | |")
        table.append(f"| all, at {FAST} pixels | {seen['fast']:.3f} | |")
    each = []
    for kind in ("ball", "silo"):
        found = card[kind]["synthetic"]["classes"]  # every report judged
        each.append(f"{kind}: " + ", ".join(f"{name} {ap:.3f}" for name, ap in found.items()))
    curve = json.loads((FOLDER / "curve.json").read_text(encoding="utf-8"))
    grown = ["| pictures shown to the silos' network | mAP@0.5 |", "|---|---|"]
    grown += [f"| {point['passes']:,} | {point['map50']:.4f} |" for point in curve]
    parts = {"(table)": table, "(classes)": [f"- {line}" for line in each], "(curve)": grown}
    lines = [line for given in lines for line in parts.get(given, [given])]
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
