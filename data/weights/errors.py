"""Where the networks lose what they lack to a perfect score: python data/weights/errors.py

Sorts their wrong reports on drawn pictures, and the things they never saw, into kinds, and tells
what the mAP would gain without each kind.

Source of the kinds: Bolya, Foley, Hays, Hoffman: TIDE (2020), section 2.2. There a wrong box or
class is put right; here the report is only left out, which is simpler and gives less.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from robocon_course.vision import CLASSES, Detections, Detector, average_precisions, load_detector
from robocon_course.vision.evaluation import LOWEST
from robocon_course.vision.metrics import box_iou, match_detections, score_pictures
from robocon_course.vision.pictures import Picture, picture

ENOUGH, LITTLE = 0.5, 0.1
"""Overlaps that make a report one of a thing, and one that has to do with it."""
KINDS = ("class", "place", "class and place", "duplicate", "doubtful", "nothing there")
SIDES = (0, 8, 12, 20, 1000)
"""Missed things are counted by the smaller side of their box, between these [pixels]."""
COUNTED = 0.25
"""Reports are counted from this score, and things as missed below it."""


def kinds_of(found: Detections, taken: Picture) -> list[str]:
    """What is wrong with each report of a picture; nothing with a "hit"."""
    hits = match_detections(found.boxes, found.class_ids, taken.boxes, taken.class_ids, ENOUGH)
    over = box_iou(found.boxes, taken.boxes)
    same = over * (found.class_ids[:, None] == taken.class_ids[None, :])
    best, best_same = over.max(axis=1, initial=0.0), same.max(axis=1, initial=0.0)
    doubtful = box_iou(found.boxes, taken.doubtful).max(axis=1, initial=0.0)
    rules = (
        (hits, "hit"),
        ((doubtful >= ENOUGH) & (doubtful > best), "doubtful"),
        (best_same >= ENOUGH, "duplicate"),
        (best >= ENOUGH, "class"),
        (best_same >= LITTLE, "place"),
        (best >= LITTLE, "class and place"),
    )
    return [next((name for rule, name in rules if rule[k]), KINDS[-1]) for k in range(len(hits))]


def surest(found: Detections, taken: Picture) -> np.ndarray:
    """The best score with which each thing of a picture was reported rightly; 0 for none."""
    right = box_iou(taken.boxes, found.boxes) >= ENOUGH
    right &= taken.class_ids[:, None] == found.class_ids[None, :]
    return (right * found.scores).max(axis=1, initial=0.0)


def mean_ap(kind: str, rows: Iterable[tuple]) -> float:
    """The mAP of rows for `score_pictures`."""
    return float(np.nanmean(average_precisions(score_pictures(list(rows), len(CLASSES[kind])))))


def told(kind: str, detector: Detector, drawn: list[Picture]) -> list[str]:
    """The lines of a table."""
    seen = [detector.detect(one.image_bgr, min_score=LOWEST) for one in drawn]
    wrong = [np.array(kinds_of(*pair), object) for pair in zip(seen, drawn, strict=True)]
    sure = [surest(*pair) for pair in zip(seen, drawn, strict=True)]
    base = mean_ap(
        kind, ((s, one.boxes, one.class_ids) for s, one in zip(seen, drawn, strict=True))
    )
    counts = Counter(
        name
        for found, names in zip(seen, wrong, strict=True)
        for name in names[found.scores >= COUNTED]
    )
    lines = [
        f"{kind} at {detector.size} pixels: mAP {base:.3f}",
        f"  {'without':16s} reports   mAP",
    ]
    for name in KINDS:
        kept = (
            (Detections(*(part[names != name] for part in found)), one.boxes, one.class_ids)
            for found, names, one in zip(seen, wrong, drawn, strict=True)
        )
        lines.append(f"  {name:16s} {counts[name]:7d}  {mean_ap(kind, kept) - base:+.4f}")
    kept = (
        (found, one.boxes[best >= LOWEST], one.class_ids[best >= LOWEST])
        for found, best, one in zip(seen, sure, drawn, strict=True)
    )
    never = sum(np.count_nonzero(best < LOWEST) for best in sure)
    lines.append(f"  {'never reported':16s} {never:7d}  {mean_ap(kind, kept) - base:+.4f}")
    sides = np.concatenate([(one.boxes[:, 2:] - one.boxes[:, :2]).min(axis=1) for one in drawn])
    missed = np.concatenate(sure) < COUNTED
    for low, high in pairwise(SIDES):
        among = (low <= sides) & (sides < high)
        lines.append(
            f"  {low} to {high} pixels: {np.count_nonzero(missed & among)} missed "
            f"of {np.count_nonzero(among)}"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=777_000)
    parser.add_argument("--pictures", type=int, default=600)
    asked = parser.parse_args()
    for kind, sizes in (("ball", (320, 480)), ("silo", (320,))):
        drawn = [picture(kind, asked.seed, index, None) for index in range(asked.pictures)]
        for size in sizes:
            print("\n".join(told(kind, load_detector(kind).with_size(size), drawn)), flush=True)


if __name__ == "__main__":
    main()
