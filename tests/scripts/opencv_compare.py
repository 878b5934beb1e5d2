#!/usr/bin/env python3
"""Sets Tetrad's pipeline, in both modes, beside OpenCV and AprilTag: errors and times on the same frames.

    python3 tests/scripts/opencv_compare.py [SCENE]...

OpenCV (one thread): the whole frame to HSV; for each of the four colours inRange and the largest
contour; then its centre in three ways: the contour's moments, its smallest enclosing circle, and
HoughCircles in a square around it. Each way gets the setting, of those listed below, that has the
least mean error on the first frames, judged by the truth; Tetrad gets its defaults and the balls'
places in the first frame. Times are judged against moments with one plain setting for all scenes.

AprilTag (pupil-apriltags, one thread): a 36h11 tag as wide as Tetrad's arms (80 mm), about 1 m away and
seen at angles, in a frame of the scene: detection and 6-DoF pose, beside Tetrad's whole step: two cameras
and the pose.

All take turns, round by round, so that whatever else the machine does slows all, and all have the
pictures in memory. OpenCV and AprilTag are timed by the processor time of their thread: on a busy machine
a pipeline of milliseconds is interrupted in most frames, a step of microseconds in few, and wall time
would flatter Tetrad. A line of its own tells what `tetrad track` takes, which reads and decodes a picture
before each step: that costs a step of microseconds half as much again, for caches and branch predictors
are cold each time, and one of milliseconds a tenth (no aim is judged by it). Errors are those of balls in
full sight. Prints tables; the same as target/compare.csv and target/compare.json.

Makes a virtual environment in target/opencv with opencv-python-headless, numpy and pupil-apriltags where
this Python has them not; where only pupil-apriltags cannot be installed, its line is left out. Exit
codes: 0 all aims are met, 1 one is not, 2 OpenCV cannot be installed.
"""

import csv
import importlib.util
import itertools
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
SCENES = ["linear-0.25-30fps", "circular-0.5-30fps", "static-side-16px"]
FRAMES = 120
TUNING_FRAMES = 15
ROUNDS = 5
CAMERAS = ["left", "right"]
BALLS = ["red", "green", "blue", "yellow"]
MODES = ["paper", "refined"]

# Aims: medians over the rounds. Microseconds are those of a frame and camera, all four balls.
AIM_PAPER_US = 60
AIM_PAPER_TO_OPENCV = 60
AIM_REFINED_TO_PAPER = 2.5
AIM_REFINED_TO_OPENCV = 40
AIM_POSE_US = 20

HUE = 12  # half the width of a hue range, of 180
LOWS = [0.3, 0.4, 0.5, 0.6, 0.7]  # the lowest saturation and value, of the ball's own
PLAIN, PLAIN_LOW = "OpenCV plain moments", 0.5
# HoughCircles: plane, factor by which the square is enlarged, method, sensitivity (param2)
HOUGH = list(itertools.product(["grey", "mask"], [1, 4], ["gradient", "alt"], ["low", "high"]))
HOUGH_PARAM2 = {"gradient": {"low": 8, "high": 15}, "alt": {"low": 0.5, "high": 0.85}}

TAG_M, TAG_FOCAL_PX = 0.08, 800.0


def in_environment() -> None:
    """Goes on in a Python that has OpenCV."""
    if importlib.util.find_spec("cv2") and importlib.util.find_spec("pupil_apriltags"):
        return
    environment = TARGET / "opencv"
    python = environment / "bin" / "python"
    if Path(sys.executable) == python:
        if importlib.util.find_spec("cv2"):
            return
        sys.exit(2)
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", environment], check=True)
    install = [python, "-m", "pip", "install", "--quiet"]
    if subprocess.run([*install, "opencv-python-headless", "numpy"]).returncode != 0:
        print("missing: Python packages opencv-python-headless and numpy", file=sys.stderr)
        sys.exit(2)
    if subprocess.run([*install, "pupil-apriltags"]).returncode != 0:
        print("missing: Python package pupil-apriltags; its line is left out", file=sys.stderr)
    os.execv(python, [python, *sys.argv])


def export(scene: str) -> Path:
    folder = TARGET / "opencv-frames" / scene
    arguments = ["--", scene, str(FRAMES), folder]
    cargo = ["cargo", "run", "--release", "--quiet", "--package", "tetrad-tests", "--example", "export_scene"]
    subprocess.run(cargo + arguments, cwd=REPOSITORY, check=True)
    return folder


class Clip:
    """The frames of a scene and where its balls are."""

    def __init__(self, scene: str):
        import cv2

        self.folder = export(scene)
        with open(self.folder / "truth.csv", newline="") as file:
            rows = {(int(r["frame"]), r["camera"], r["ball"]): r for r in csv.DictReader(file)}
        self.centres = {key: (float(r["u"]), float(r["v"])) for key, r in rows.items()}
        self.whole = {key for key, r in rows.items() if float(r["visible"]) > 0.999}
        self.count = 1 + max(frame for frame, _, _ in rows)
        self.frames = {
            camera: [cv2.imread(str(path)) for path in sorted((self.folder / camera).glob("*.png"))[: self.count]]
            for camera in CAMERAS
        }

    def error(self, frame: int, camera: str, ball: str, place: tuple) -> float:
        u, v = self.centres[frame, camera, ball]
        return math.hypot(place[0] - u, place[1] - v)


def run_tetrad(clip: Clip, mode: str) -> dict:
    """Medians in microseconds, and the errors in pixels."""
    out = clip.folder / f"observations-{mode}.csv"
    command = [TARGET / "release" / "examples" / "time_pipeline", clip.folder, mode, str(clip.count), out]
    times = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    errors = []
    with open(out, newline="") as file:
        for row in csv.DictReader(file):
            key = int(row["frame"]), row["camera"], row["ball"]
            if key in clip.whole:
                errors.append(clip.error(*key, (float(row["u"]), float(row["v"]))))
    return {"us": times["tracking_us"], "pose_us": times["pose_us"], "errors": errors}


def run_track(clip: Clip, mode: str) -> dict:
    """What the program says of itself: medians in microseconds."""
    out = clip.folder / f"out-{mode}"
    command = [TARGET / "release" / "tetrad", "track", "--left", clip.folder / "left", "--right", clip.folder / "right"]
    command += ["--scene", clip.folder / "scene.json", "--mode", mode, "--out", out]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    summary = json.loads((out / "summary.json").read_text())
    cameras = [summary["cameras"][camera]["tracking_us"]["p50"] for camera in CAMERAS]
    return {"us": statistics.mean(cameras), "pose_us": summary["pose_us"]["p50"], "errors": []}


class Colours:
    """Colour ranges of the four balls, from where they are in the first frame."""

    def __init__(self, clip: Clip, camera: str, low: float):
        import cv2
        import numpy

        hsv = cv2.cvtColor(clip.frames[camera][0], cv2.COLOR_BGR2HSV)
        self.ranges = {}
        for ball in BALLS:
            u, v = (round(x) for x in clip.centres[0, camera, ball])
            patch = hsv[v - 3 : v + 4, u - 3 : u + 4].reshape(-1, 3)
            hue, saturation, value = (int(numpy.median(patch[:, k])) for k in range(3))
            # Hue is a circle of 180: a range across its end is two ranges.
            spans = [(hue - HUE, hue + HUE)]
            if hue - HUE < 0:
                spans = [(0, hue + HUE), (180 + hue - HUE, 180)]
            elif hue + HUE > 180:
                spans = [(hue - HUE, 180), (0, hue + HUE - 180)]
            bound = lambda h, s, v: numpy.array([h, s, v], numpy.uint8)
            lows = int(low * saturation), int(low * value)
            self.ranges[ball] = [(bound(a, *lows), bound(b, 255, 255)) for a, b in spans]

    def find(self, frame, centre) -> dict:
        """The balls' centres; `centre` makes one of the largest contour, its mask and the frame."""
        import cv2

        hsv = cv2.cvtColor(frame, cv2.COLOR_BGR2HSV)
        found = {}
        for ball, ranges in self.ranges.items():
            mask = cv2.inRange(hsv, *ranges[0])
            for more in ranges[1:]:
                mask = cv2.bitwise_or(mask, cv2.inRange(hsv, *more))
            contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
            if contours:
                place = centre(max(contours, key=cv2.contourArea), mask, frame)
                if place:
                    found[ball] = place
        return found


def by_moments(contour, _mask, _frame):
    import cv2

    moments = cv2.moments(contour)
    if moments["m00"] > 0:
        return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
    return None


def by_enclosing_circle(contour, _mask, _frame):
    import cv2

    return cv2.minEnclosingCircle(contour)[0]


def by_hough(plane: str, factor: int, method: str, sensitivity: str):
    import cv2

    kind = cv2.HOUGH_GRADIENT_ALT if method == "alt" else cv2.HOUGH_GRADIENT
    param2 = HOUGH_PARAM2[method][sensitivity]

    def centre(contour, mask, frame):
        (u, v), radius = cv2.minEnclosingCircle(contour)
        reach = math.ceil(1.5 * radius) + 3
        x0, y0 = max(0, round(u) - reach), max(0, round(v) - reach)
        square = slice(y0, round(v) + reach + 1), slice(x0, round(u) + reach + 1)
        picture = mask[square] if plane == "mask" else cv2.cvtColor(frame[square], cv2.COLOR_BGR2GRAY)
        if factor > 1:
            picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        least, most = int(0.7 * radius * factor), math.ceil(1.3 * radius * factor)
        circles = cv2.HoughCircles(
            picture, kind, 1, 2 * most, param1=150, param2=param2, minRadius=least, maxRadius=most
        )
        if circles is None:
            return None
        # cv2.resize keeps the outer edges of the picture in place, not the centres of its pixels
        whole = lambda x, first: (x + 0.5) / factor - 0.5 + first
        places = [(whole(x, x0), whole(y, y0)) for x, y, *_ in circles.reshape(-1, circles.shape[-1])]
        return min(places, key=lambda place: math.hypot(place[0] - u, place[1] - v))

    return centre


def run_opencv(clip: Clip, low: float, centre, frames=None) -> dict:
    """The median in microseconds, and the errors in pixels."""
    times, errors = [], []
    for camera in CAMERAS:
        colours = Colours(clip, camera, low)
        for number, frame in enumerate(clip.frames[camera][:frames]):
            start = time.thread_time_ns()
            found = colours.find(frame, centre)
            times.append((time.thread_time_ns() - start) / 1000)
            for ball, place in found.items():
                if (number, camera, ball) in clip.whole:
                    errors.append(clip.error(number, camera, ball, place))
    return {"us": statistics.median(times), "errors": errors}


def tuned(clip: Clip, centres: dict) -> tuple:
    """The setting with the least mean error on the first frames, of those that find nearly all balls."""
    best, expected = None, len([key for key in clip.whole if key[0] < TUNING_FRAMES])
    for (name, centre), low in itertools.product(centres.items(), LOWS):
        errors = run_opencv(clip, low, centre, TUNING_FRAMES)["errors"]
        # what is not found counts as 3 px off, so that a setting cannot win by finding little
        score = (sum(errors) + 3.0 * (expected - len(errors))) / expected
        if best is None or score < best[0]:
            best = score, f"{name}{low} of saturation and value", low, centre
    return best[1:]


class Tag:
    """Frames with an AprilTag, and its poses."""

    DECIMATES = [1.0, 2.0]

    def __init__(self, background):
        import cv2
        import numpy
        from pupil_apriltags import Detector

        # Made once: the package crashes now and then when it frees one and makes another.
        self.detectors = {
            decimate: Detector(families="tag36h11", nthreads=1, quad_decimate=decimate)
            for decimate in self.DECIMATES
        }

        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
        side = 400  # of 8 cells, with two cells of white around
        tag = cv2.aruco.generateImageMarker(dictionary, 7, side)
        tag = cv2.copyMakeBorder(tag, 100, 100, 100, 100, cv2.BORDER_CONSTANT, value=255)
        grey = cv2.cvtColor(background, cv2.COLOR_BGR2GRAY)
        height, width = grey.shape
        # The detector counts from the corner of the first pixel, we from its centre.
        self.params = (TAG_FOCAL_PX, TAG_FOCAL_PX, width / 2, height / 2)
        # Four times as fine in both directions, averaged afterwards: no aliasing.
        finer = numpy.array([[4, 0, 1.5], [0, 4, 1.5], [0, 0, 1]])
        camera = numpy.array([[TAG_FOCAL_PX, 0, (width - 1) / 2], [0, TAG_FOCAL_PX, (height - 1) / 2], [0, 0, 1]])
        scale = TAG_M / side
        centred = numpy.array([[scale, 0, -299.5 * scale], [0, scale, -299.5 * scale], [0, 0, 1]])
        white = numpy.full_like(tag, 255)
        self.frames, self.places = [], []
        for k in range(30):
            turn, _ = cv2.Rodrigues(numpy.array([0.5 * math.sin(k), 0.5 * math.cos(k), 0.1 * k]))
            place = numpy.array([0.1 * math.sin(0.7 * k), 0.08 * math.cos(0.5 * k), 1.0])
            onto = finer @ camera @ numpy.column_stack([turn[:, 0], turn[:, 1], place]) @ centred
            fine = [cv2.warpPerspective(of, onto, (4 * width, 4 * height)) for of in (tag, white)]
            picture, inside = (cv2.resize(of, (width, height), interpolation=cv2.INTER_AREA) for of in fine)
            self.frames.append((picture + (1 - inside / 255) * grey).round().astype(numpy.uint8))
            self.places.append(place)

    def run(self, decimate: float) -> dict:
        """Median time in microseconds and the errors of the place in millimetres."""
        import numpy

        detector = self.detectors[decimate]
        times, errors = [], []
        for frame, place in zip(self.frames, self.places):
            start = time.thread_time_ns()
            tags = detector.detect(frame, estimate_tag_pose=True, camera_params=self.params, tag_size=TAG_M)
            times.append((time.thread_time_ns() - start) / 1000)
            errors += [1000 * float(numpy.linalg.norm(tag.pose_t.ravel() - place)) for tag in tags]
        return {"us": statistics.median(times), "errors": errors}


def spread(errors: list) -> dict:
    if not errors:
        return {"found": 0, "mean": None, "p95": None, "max": None}
    ordered = sorted(errors)
    p95 = ordered[max(0, math.ceil(0.95 * len(ordered)) - 1)]
    return {"found": len(errors), "mean": statistics.mean(errors), "p95": p95, "max": ordered[-1]}


def compare(clip: Clip, scene: str, tag) -> tuple:
    """Lines of the table, and the figures that have aims."""
    ways = {"OpenCV moments": {"": by_moments}, "OpenCV enclosing circle": {"": by_enclosing_circle}}
    ways["OpenCV Hough circles"] = {", ".join(map(str, setting)) + ", ": by_hough(*setting) for setting in HOUGH}
    # A setting that is tuned for accuracy may be slow: times are judged against the plain one.
    settings = {PLAIN: (f"{PLAIN_LOW} of saturation and value, not tuned", PLAIN_LOW, by_moments)}
    settings |= {name: tuned(clip, centres) for name, centres in ways.items()}

    rounds = {}
    for number in range(ROUNDS):
        for mode in MODES:
            rounds.setdefault(f"tetrad {mode}", []).append(run_tetrad(clip, mode))
            rounds.setdefault(f"tetrad track, {mode}", []).append(run_track(clip, mode))
        for name, (_, low, centre) in settings.items():
            rounds.setdefault(name, []).append(run_opencv(clip, low, centre))
        for decimate in Tag.DECIMATES if tag else ():
            rounds.setdefault(f"AprilTag decimate {decimate:.0f}", []).append(tag.run(decimate))
        print(f"{scene}: round {number + 1} of {ROUNDS}", file=sys.stderr)

    # The errors are the same in every round; ratios are medians of ratios, not of medians.
    lines = []
    for name, runs in rounds.items():
        setting = settings[name][0] if name in settings else ""
        line = {"scene": scene, "what": name, "us": statistics.median(run["us"] for run in runs)}
        unit = "mm" if name.startswith("AprilTag") else "px"
        lines.append(line | {"unit": unit} | spread(runs[0]["errors"]) | {"setting": setting})
    paper, refined = rounds["tetrad paper"], rounds["tetrad refined"]
    opencv = rounds[PLAIN]
    ratio = lambda above, below: statistics.median(a["us"] / b["us"] for a, b in zip(above, below))
    figures = {
        "paper_us": statistics.median(run["us"] for run in paper),
        "opencv_to_paper": ratio(opencv, paper),
        "refined_to_paper": ratio(refined, paper),
        "opencv_to_refined": ratio(opencv, refined),
        "pose_us": statistics.median(run["pose_us"] for run in refined),
        "track_pose_us": statistics.median(run["pose_us"] for run in rounds["tetrad track, refined"]),
        "whole_step_us": statistics.median(2 * run["us"] + run["pose_us"] for run in refined),
    }
    return lines, figures


def show(lines: list, figures: dict) -> None:
    print(f"\n{lines[0]['scene']}                time of a frame       error")
    print(f"{'':26}{'and camera, us':>15}    found   mean    p95     max")
    for line in lines:
        errors = "".join("       -" if line[k] is None else f"{line[k]:8.3f}" for k in ("mean", "p95", "max"))
        note = f"  ({line['setting']})" if line["setting"] else ""
        print(f"{line['what']:26}{line['us']:15.1f} {line['found']:8}{errors} {line['unit']}{note}")
    whole, pose = figures["whole_step_us"], figures["pose_us"]
    track = figures["track_pose_us"]
    print(f"tetrad refined, two cameras and the pose: {whole:.0f} us, the pose {pose:.1f} us ({track:.1f} in tetrad track)")


def judge(scene: str, figures: dict) -> bool:
    aims = [
        ("paper_us", "tetrad paper, us", AIM_PAPER_US, False),
        ("opencv_to_paper", "OpenCV plain / tetrad paper", AIM_PAPER_TO_OPENCV, True),
        ("refined_to_paper", "tetrad refined / paper", AIM_REFINED_TO_PAPER, False),
        ("opencv_to_refined", "OpenCV plain / tetrad refined", AIM_REFINED_TO_OPENCV, True),
        ("pose_us", "refined pose, us", AIM_POSE_US, False),
    ]
    met = True
    for key, what, aim, at_least in aims:
        good = figures[key] >= aim if at_least else figures[key] <= aim
        word = "at least" if at_least else "at most"
        print(f"{scene}: {what}: {figures[key]:.2f}, {word} {aim}: {'met' if good else 'MISSED'}")
        met = met and good
    return met


def main() -> int:
    in_environment()
    build = ["cargo", "build", "--release", "--quiet"]
    subprocess.run([*build, "--package", "tetrad"], cwd=REPOSITORY, check=True)
    subprocess.run([*build, "--package", "tetrad-tests", "--example", "time_pipeline"], cwd=REPOSITORY, check=True)
    import cv2

    cv2.setNumThreads(1)
    table, figures, tag = [], {}, None
    for scene in sys.argv[1:] or SCENES:
        clip = Clip(scene)
        if tag is None and importlib.util.find_spec("pupil_apriltags"):
            tag = Tag(clip.frames["left"][0])
        lines, figures[scene] = compare(clip, scene, tag)
        show(lines, figures[scene])
        table += lines
    with open(TARGET / "compare.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader()
        writer.writerows(table)
    (TARGET / "compare.json").write_text(json.dumps({"lines": table, "figures": figures}, indent=1) + "\n")
    print()
    met = [judge(scene, of) for scene, of in figures.items()]
    return 0 if all(met) else 1


if __name__ == "__main__":
    sys.exit(main())
