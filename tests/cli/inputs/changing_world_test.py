#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""karst info on a world file that somebody changes or cuts while it is read: a line and exit code 1, never a
signal. --karst PROGRAM --work FOLDER"""

import argparse
import os
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from make_inputs import zero_world


def info(karst, path, meddle):
    """Exit code and standard error of karst info, with meddle(n) called again and again beside it."""
    with subprocess.Popen([karst, "info", path], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                          text=True) as process:
        turns = 0
        while process.poll() is None:
            meddle(turns)
            turns += 1
            time.sleep(0.002)
        return process.returncode, process.stderr.read(), turns


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--karst", required=True)
    parser.add_argument("--work", required=True)
    options = parser.parse_args()
    os.makedirs(options.work, exist_ok=True)
    path = os.path.join(options.work, "zeros.karst")
    zero_world(path, octets=1 << 20, patches=(1 << 22) - 2)
    bytes_there = os.path.getsize(path)
    failures = []

    def expect(what, result, *allowed):
        code, text, turns = result
        print(f"{what}: exit code {code}, {turns} turns: {text.strip()}")
        one_line = text.count("\n") == 1 and text.startswith("karst info: ")
        if code != 1 or not one_line or not any(word in text for word in allowed):
            failures.append(what)

    # Zeros pass all checksums, so all of the file is read before its keys are seen not to ascend.
    expect("as it is", info(options.karst, path, lambda turn: None), "patch keys")
    with open(path, "r+b") as file:
        def flip(offset):
            def change(turn):
                os.pwrite(file.fileno(), bytes([turn & 1]), offset)
            return change
        # One of each kind: a count, an offset of the table, a reserved byte, a byte of a section.
        for offset in (92, 192 + 8, 100, 192 + 9 * 32 + 64):
            kept = os.pread(file.fileno(), 1, offset)
            expect(f"byte {offset} changes", info(options.karst, path, flip(offset)), "patch keys",
                   "checksum")
            os.pwrite(file.fileno(), kept, offset)
        for size in (bytes_there // 2, 100, 0):
            for delay in (0, 4, 16):
                def cut(turn, size=size, delay=delay):
                    if turn == delay:
                        os.ftruncate(file.fileno(), size)
                expect(f"cut to {size} after {delay}", info(options.karst, path, cut),
                       "cannot be read", "shorter", "ends inside", "patch keys", "empty", "not a karst world")
                zero_world(path, octets=1 << 20, patches=(1 << 22) - 2)
    os.remove(path)
    print("\n".join(f"FAILED: {what}" for what in failures) or "all right")
    return int(bool(failures))


if __name__ == "__main__":
    sys.exit(main())
