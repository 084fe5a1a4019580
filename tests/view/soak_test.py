#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""karst view for a long time under poses, floods of junk and SIGHUP: memory, descriptors and GL objects do
not grow, and SIGTERM is answered in half a second at the end.

llvmpipe draws in the same process. It keeps the triangles of a frame in blocks of 64 KiB, 1 to 37 MiB of
them with what is in sight, until it draws into the same scene again; with threads it has several scenes, and
which of them the last frame took is chance. So here it has no threads, blocks come from mmap and go back,
and memory is compared where the camera is at one place and nothing is drawn.

    soak_test.py --karst PROGRAM --bake PROGRAM --work DIR --seconds 3600
"""
import argparse
import json
import math
import os
import pathlib
import random
import signal
import socket
import subprocess
import sys
import time

WARM_UP = 0.3  # of the time, 180 s at most: caches fill
EVERY_S = 15  # between two looks at memory
PLACE = "0 ~20 0 0 -20\n"  # where the camera is then
RSS_SLACK = 2 << 20  # bytes by which the least of the later looks may be above the least of the earlier ones
HEAP = {"MALLOC_MMAP_THRESHOLD_": "65536", "MALLOC_TRIM_THRESHOLD_": "131072", "LP_NUM_THREADS": "0"}
LEAST_S = 60  # shorter runs are over before caches are full: their memory says nothing
ANSWER_S = 0.5


def rss(pid):
    return int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


class Viewer:
    def __init__(self, arguments, world):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.stats = arguments.work / "stats.json"
        self.stats.unlink(missing_ok=True)
        self.messages = open(arguments.work / "messages", "w+")
        self.process = subprocess.Popen(
            [arguments.karst, "view", world, "--headless", "--size", "160x90", "--stats", self.stats,
             "--poses", f"udp:{self.port}"], stderr=self.messages, env={**os.environ, **HEAP})
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        time.sleep(2)

    def send(self, data):
        try:
            self.socket.sendto(data, ("127.0.0.1", self.port))
        except OSError:
            pass

    def used_s(self):
        """Processor time so far."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def memory(self):
        """Bytes that are resident when the picture of PLACE is there and nothing is drawn."""
        idle = 0
        for _ in range(600):
            if idle == 0:
                self.send(PLACE.encode())
            before = self.used_s()
            time.sleep(0.1)
            idle = idle + 1 if self.used_s() == before else 0
            if idle == 5:
                return rss(self.process.pid)
        sys.exit("draws for 60 s though nothing changes")

    def statistics(self):
        self.stats.unlink(missing_ok=True)
        self.process.send_signal(signal.SIGHUP)
        end = time.monotonic() + 10
        while time.monotonic() < end:
            if self.stats.exists():
                return json.loads(self.stats.read_text())
            time.sleep(0.01)
        sys.exit("SIGHUP was not answered in 10 s")


def fly(viewer, size_m, until):
    """Poses all over the world, with a second of junk and of SIGHUPs now and then. Yields once a second."""
    chance = random.Random(1)
    junk = [b"a\n" * 30000, os.urandom(60000), b"", b"1e9 0 0 0 0\n", b"0 ~2 0 1\n"]
    while time.monotonic() < until:
        second = time.monotonic() + 1
        kind = chance.random()
        turn = chance.random() * 360
        while time.monotonic() < second:
            if kind < 0.2:
                viewer.send(chance.choice(junk))
            elif kind < 0.3:
                viewer.process.send_signal(signal.SIGHUP)
            else:
                turn += 1
                away = chance.random() * size_m / 2
                x, z = away * math.cos(turn), away * math.sin(turn)
                viewer.send(f"{x:.2f} ~{2 + away:.2f} {z:.2f} {turn:.1f} -20\n".encode())
                time.sleep(0.01)
        yield


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--karst", required=True)
    parser.add_argument("--bake", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--seconds", type=float, default=3600)
    arguments = parser.parse_args()
    arguments.work.mkdir(parents=True, exist_ok=True)
    world = arguments.work / "canyon.karst"
    subprocess.run([arguments.bake, "--sample", "canyon", "--no-ground", "-o", world], check=True,
                   capture_output=True)

    viewer = Viewer(arguments, world)
    try:
        began = time.monotonic()
        warm_at = began + min(WARM_UP * arguments.seconds, 180)
        before = None
        looks = []
        for _ in fly(viewer, 100, began + arguments.seconds):
            if viewer.process.poll() is not None:
                viewer.messages.seek(0)
                sys.exit(f"karst ended: {viewer.process.returncode}\n{viewer.messages.read()[-2000:]}")
            if before is None and time.monotonic() >= warm_at:
                looks.append(viewer.memory())
                before = viewer.statistics()
                looked = time.monotonic()
            elif before is not None and time.monotonic() >= looked + EVERY_S:
                looks.append(viewer.memory())
                looked = time.monotonic()
        looks.append(viewer.memory())
        after = viewer.statistics()
        asked = time.monotonic()
        viewer.process.send_signal(signal.SIGTERM)
        code = viewer.process.wait(10)
        answer_s = time.monotonic() - asked
    finally:
        viewer.process.kill()
    print(f"FIGURE {arguments.seconds:.0f} s, {after['frames']} frames, poses {after['poses']}")
    half = len(looks) // 2
    earlier, later = min(looks[:half]), min(looks[half:])
    sizes = [f"{size / 2**20:.1f}" for size in (earlier, later, min(looks), max(looks))]
    print(f"FIGURE memory {sizes[0]} MiB at least in the first half of {len(looks)} looks, {sizes[1]} in the "
          f"second; {sizes[2]} to {sizes[3]} in all")
    failed = []
    for name in ("descriptors", "gl_objects"):
        print(f"FIGURE {name} {before[name]}, {after[name]} at the end")
        if before[name] != after[name] or after[name] < 1:
            failed.append(name)
    print(f"FIGURE SIGTERM answered after {answer_s:.3f} s with {code}, "
          f"messages {os.path.getsize(viewer.messages.name)} bytes")
    if arguments.seconds >= LEAST_S and later > earlier + RSS_SLACK:
        failed.append("memory")
    if code != 0 or answer_s > ANSWER_S:
        failed.append("SIGTERM")
    if after["frames"] <= before["frames"]:
        failed.append("frames")
    if failed:
        sys.exit("FAILED: " + ", ".join(failed))


if __name__ == "__main__":
    main()
