#!/usr/bin/env python3
"""Times `tetrad track` beside a full-frame OpenCV pipeline on the same frames in the same run.

    python3 tests/scripts/opencv_compare.py [SCENE]...

OpenCV (one thread): convert the whole frame to HSV; for each of the four colours inRange, the largest
contour, its moments. Its colour ranges come from the balls in the first frame. Decoding is left out on
both sides. The two take turns, so that whatever else the machine does slows both: each round is one run
of either over all frames. Prints of each round the median time a frame and camera of both and their
ratio; then the medians over the rounds, and both centre errors.

Makes a virtual environment in target/opencv with opencv-python-headless and numpy where this Python
has them not. Exit codes: 0 both aims are met, 1 one is not, 2 OpenCV cannot be installed.
"""

import csv
import json
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

REPOSITORY = Path(__file__).resolve().parents[2]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", REPOSITORY / "target"))
SCENES = ["linear-0.25-30fps", "circular-0.5-30fps"]
FRAMES = 200
ROUNDS = 3
CAMERAS = ["left", "right"]
BALLS = ["red", "green", "blue", "yellow"]
AIM_US = 60  # median of tetrad, a frame and camera, all four balls
AIM_RATIO = 60  # OpenCV's median over tetrad's of the same round
HUE, LOW = 12, 0.5  # half the width of a hue range; the lowest saturation and value, of the ball's own


def in_environment() -> None:
    """Goes on in a Python that has OpenCV."""
    try:
        import cv2  # noqa: F401

        return
    except ImportError:
        pass
    environment = TARGET / "opencv"
    python = environment / "bin" / "python"
    if Path(sys.executable) == python:
        sys.exit(2)
    steps = [
        [sys.executable, "-m", "venv", environment],
        [python, "-m", "pip", "install", "--quiet", "opencv-python-headless", "numpy"],
    ]
    for step in steps if not python.exists() else steps[1:]:
        if subprocess.run(step).returncode != 0:
            print("missing: Python packages opencv-python-headless and numpy", file=sys.stderr)
            sys.exit(2)
    os.execv(python, [python, *sys.argv])


def export(scene: str) -> Path:
    folder = TARGET / "opencv-frames" / scene
    arguments = ["--", scene, str(FRAMES), folder]
    cargo = ["cargo", "run", "--release", "--quiet", "--package", "tetrad-tests", "--example", "export_scene"]
    subprocess.run(cargo + arguments, cwd=REPOSITORY, check=True)
    return folder


def read_truth(folder: Path) -> dict:
    with open(folder / "truth.csv", newline="") as file:
        rows = csv.DictReader(file)
        return {(int(r["frame"]), r["camera"], r["ball"]): (float(r["u"]), float(r["v"])) for r in rows}


def run_tetrad(folder: Path, truth: dict) -> tuple:
    """(median us, errors px) over both cameras."""
    out = folder / "out"
    command = [TARGET / "release" / "tetrad", "track", "--left", folder / "left", "--right", folder / "right"]
    subprocess.run(command + ["--scene", folder / "scene.json", "--out", out], check=True, stdout=subprocess.DEVNULL)
    summary = json.loads((out / "summary.json").read_text())
    median = statistics.mean(summary["cameras"][camera]["tracking_us"]["p50"] for camera in CAMERAS)
    errors = []
    with open(out / "observations.csv", newline="") as file:
        for row in csv.DictReader(file):
            if row["state"] == "visible":
                u, v = truth[int(row["frame"]), row["camera"], row["ball"]]
                errors.append(math.hypot(float(row["u"]) - u, float(row["v"]) - v))
    return median, errors


class FullFrame:
    """The usual way: every pixel of every frame, for every colour."""

    def __init__(self, first, centres: dict):
        import cv2
        import numpy

        hsv = cv2.cvtColor(first, cv2.COLOR_BGR2HSV)
        self.ranges = {}
        for ball, (u, v) in centres.items():
            u, v = round(u), round(v)
            patch = hsv[v - 3 : v + 4, u - 3 : u + 4].reshape(-1, 3)
            hue, saturation, value = (int(numpy.median(patch[:, k])) for k in range(3))
            low_s, low_v = int(LOW * saturation), int(LOW * value)
            # Hue is a circle of 180: a range across its end is two ranges.
            spans = [(hue - HUE, hue + HUE)]
            if hue - HUE < 0:
                spans = [(0, hue + HUE), (180 + hue - HUE, 180)]
            elif hue + HUE > 180:
                spans = [(hue - HUE, 180), (0, hue + HUE - 180)]
            self.ranges[ball] = [
                (numpy.array([a, low_s, low_v], numpy.uint8), numpy.array([b, 255, 255], numpy.uint8))
                for a, b in spans
            ]

    def find(self, frame) -> dict:
        import cv2

        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV)
        found = {}
        for ball, ranges in self.ranges.items():
            mask = cv2.inRange(hsv, *ranges[0])
            for more in ranges[1:]:
                mask = cv2.bitwise_or(mask, cv2.inRange(hsv, *more))
            contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            if contours:
                moments = cv2.moments(max(contours, key=cv2.contourArea))
                if moments["m00"] > 0:
                    found[ball] = (moments["m10"] / moments["m00"], moments["m01"] / moments["m00"])
        return found


def run_opencv(folder: Path, truth: dict) -> tuple:
    """(median us, errors px) over both cameras."""
    import cv2

    cv2.setNumThreads(1)
    times, errors = [], []
    for camera in CAMERAS:
        frames = [cv2.imread(str(path)) for path in sorted((folder / camera).glob("*.png"))]
        pipeline = FullFrame(frames[0], {ball: truth[0, camera, ball] for ball in BALLS})
        for number, frame in enumerate(frames):
            start = time.perf_counter_ns()
            found = pipeline.find(frame)
            times.append((time.perf_counter_ns() - start) / 1000)
            for ball, (x, y) in found.items():
                u, v = truth[number, camera, ball]
                errors.append(math.hypot(x - u, y - v))
    return statistics.median(times), errors


def main() -> int:
    in_environment()
    subprocess.run(["cargo", "build", "--release", "--quiet", "--package", "tetrad"], cwd=REPOSITORY, check=True)
    met = True
    for scene in sys.argv[1:] or SCENES:
        folder = export(scene)
        truth = read_truth(folder)
        rounds = []
        for number in range(1, ROUNDS + 1):
            tetrad, tetrad_errors = run_tetrad(folder, truth)
            opencv, opencv_errors = run_opencv(folder, truth)
            ratio = opencv / tetrad
            rounds.append((tetrad, opencv, ratio))
            print(f"{scene}, round {number}: tetrad {tetrad:.0f} us, OpenCV {opencv:.0f} us, ratio {ratio:.0f}")
        # The errors are the same in every round; the ratio is the median of ratios, not of medians.
        tetrad, opencv, ratio = (statistics.median(column) for column in zip(*rounds))
        met = met and tetrad <= AIM_US and ratio >= AIM_RATIO
        print(
            f"{scene}, median of {ROUNDS} rounds: tetrad {tetrad:.0f} us, OpenCV {opencv:.0f} us a frame and camera: "
            f"ratio {ratio:.0f} (median error {statistics.median(tetrad_errors):.2f} px of {len(tetrad_errors)} balls, "
            f"OpenCV {statistics.median(opencv_errors):.2f} px of {len(opencv_errors)})"
        )
    print(f"aims: tetrad at most {AIM_US} us, ratio at least {AIM_RATIO}: {'met' if met else 'missed'}")
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
