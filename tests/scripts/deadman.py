#!/usr/bin/env python3
"""Measures how soon the arm begins its stop when the operator's finger leaves the space bar.

    python3 tests/scripts/deadman.py [--program FILE] [--times N]

A slave with a simulated arm and an operator at a pseudo-terminal, two processes on loopback. The terminal is
one that repeats keys (30, 25 or 10.9 times a second, after 0.5 s) and tells nothing when they are let go, or
one that tells (kitty's keyboard protocol). N times for each the bar is held for 1.5 s, then let go at a
random moment between two repeats.

The times are by the slave's own clock, from its arm.csv: when it left `engaged`. What lies between that clock
and this script's is told from the stop key, which is struck N times: each time the arm stopped a little
after the key was struck, and the least of these differences is at most a cycle or two of the loops more than
the clocks' difference. So figures are short by at most that, some milliseconds.

Prints, for each terminal: from the last repeat, and from the finger's leaving, to the stop's beginning, p50
and most; the age of the newest command then, which is the slave's own rule; and how often the arm stopped
though the bar was held. Needs Linux and nothing but
Python. Exit codes: 0 measured, 1 something did not happen.
"""

import argparse
import csv
import os
import pty
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 30.0
DELAY_S = 0.5
HELD_S = 1.5

# name, repeats a second, whether releases are told
TERMINALS = [
    ("30 repeats a second", 30.0, False),
    ("25 repeats a second", 25.0, False),
    ("10.9 repeats a second", 10.9, False),
    ("tells of releases", 30.0, True),
]


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def files(folder, port):
    (folder / "slave.toml").write_text(
        f'[station]\nname = "slave"\nkeys = "keys"\nlisten = "127.0.0.1:{port}"\n'
        '[[peer]]\nname = "operator"\n'
        '[slave]\nport = "sim:?cycle_ms=1&watchdog_ms=2000"\noperator = "operator"\n[governor]\ncycle_ms = 1\n'
    )
    (folder / "operator.toml").write_text(
        f'[station]\nname = "operator"\nkeys = "keys"\n[[peer]]\nname = "slave"\naddress = "127.0.0.1:{port}"\n'
        '[operator]\narm_mm = 80\nslave = "slave"\n'
        '[[operator.camera]]\nsource = "sim:still"\n[[operator.camera]]\nsource = "sim:still"\nview = "right"\n'
    )


class Terminal:
    """The operator's program, and somebody at its keys."""

    def __init__(self, program, folder, tells):
        self.tells = tells
        self.said = b""
        self.pid, self.fd = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.execv(program, [str(program), "operator", "--config", "operator.toml"])
        self.thread = threading.Thread(target=self.listen, daemon=True)
        self.thread.start()

    def listen(self):
        asked = b""
        while True:
            try:
                heard = os.read(self.fd, 4096)
            except OSError:
                return
            if not heard:
                return
            self.said += heard
            asked += heard
            if b"\x1b[c" in asked:
                os.write(self.fd, (b"\x1b[?0u" if self.tells and b"\x1b[?u" in asked else b"") + b"\x1b[?62c")
                asked = b""
            asked = asked[-8:]

    def strike(self, keys):
        at = time.monotonic()
        os.write(self.fd, keys)
        return at

    def until(self, what, since=0, again=None):
        end = time.monotonic() + PATIENCE_S
        while what not in self.said[since:]:
            if time.monotonic() > end:
                sys.exit(f"never {what!r}: {self.said[since:].decode(errors='replace')}")
            if again:
                again()
            time.sleep(0.02)

    def mark(self):
        return len(self.said)

    def armed(self):
        """Resets the arm, which is stopped: then it is ready for the bar."""
        since, struck = self.mark(), [0.0]

        def reset():
            if time.monotonic() - struck[0] > 1.0:
                struck[0] = self.strike(b"r")

        self.until(b"arm armed", since, reset)

    def hold(self, rate):
        """Holds the bar and lets go; the last repeat, and the moment of letting go."""
        since = self.mark()
        down, repeat, up = (b"\x1b[32;1:1u", b"\x1b[32;1:2u", b"\x1b[32;1:3u") if self.tells else (b" ", b" ", b"")
        period = 1.0 / rate
        began = last = self.strike(down)
        time.sleep(DELAY_S)
        while time.monotonic() - began < HELD_S:
            last = self.strike(repeat)
            time.sleep(period)
        if b"arm engaged" not in self.said[since:]:
            sys.exit(f"the arm did not engage: {self.said[since:].decode(errors='replace')}")
        last = self.strike(repeat)
        time.sleep(random.uniform(0.0, period))
        gone = self.strike(up) if up else time.monotonic()
        time.sleep(0.6)
        return last, gone

    def end(self):
        self.strike(b"q")
        os.waitpid(self.pid, 0)


def states(file):
    """When the arm's state changed, by the slave's clock: (seconds, state, age of the command in ms)."""
    changes, before = [], None
    with open(file, newline="") as text:
        for row in csv.DictReader(text):
            if row["state"] != before:
                before = row["state"]
                changes.append((float(row["t"]), before, row["age_ms"]))
    return changes


def measured(program, name, rate, tells, times):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        files(folder, free_port())
        for arguments in (["authority"], ["station", "slave"], ["station", "operator"]):
            subprocess.run([program, "keys", "--out", folder / "keys", *arguments], check=True, capture_output=True)
        slave = subprocess.Popen(
            [program, "slave", "--config", "slave.toml", "--out", "out"],
            cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        try:
            terminal = Terminal(program, folder, tells)
            terminal.until(b"arm stopped")
            terminal.until(b"hand both")
            stops, holds = [], []
            for _ in range(times):
                terminal.armed()
                holds.append(terminal.hold(rate))
                # for the clocks
                stops.append(terminal.strike(b"x"))
                time.sleep(0.2)
            terminal.end()
        finally:
            slave.terminate()
            slave.wait()
        changes = states(folder / "out" / "arm.csv")
    stopped = [t for t, state, _ in changes if state == "stopped"]
    # the first is the start, before any key
    if len(stopped) < len(stops) + 1:
        sys.exit(f"{name}: {len(stops)} stops, {len(stopped) - 1} of them seen")
    offset = min(t - at for at, t in zip(stops, stopped[1:]))
    left = [(b[0], b[2]) for a, b in zip(changes, changes[1:]) if a[1] == "engaged"]
    repeat, finger, ages, early = [], [], [], len(left)
    for last, gone in holds:
        # what it left before that, it left for want of a repeat or of a command, and engaged again
        at, age = next(((t - offset, age) for t, age in left if t - offset >= last), (None, None))
        if at is None:
            sys.exit(f"{name}: the arm was not moving any more when the bar was let go")
        early -= 1
        repeat.append((at - last) * 1e3)
        finger.append((at - gone) * 1e3)
        ages.append(float(age) if age else 0.0)
    cells = [f"{statistics.median(x):8.0f} {max(x):8.0f}" for x in (repeat, finger)]
    print(f"{name:24} {cells[0]}    {cells[1]}    {max(ages):8.1f}            {early:4}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=Path, default=ROOT / "target" / "release" / "tetrad")
    parser.add_argument("--times", type=int, default=10)
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    print("                         from the last repeat  from the finger      age of the           stops while")
    print("terminal                   p50 ms  most ms      p50 ms  most ms     command, most ms     it was held")
    for name, rate, tells in TERMINALS:
        measured(program, name, rate, tells, arguments.times)


if __name__ == "__main__":
    main()
