#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs targets of libFuzzer that `cmake --preset fuzz` built, as many at a time as there are processors, and
prints their runs and findings as a table. Exit code 1 where there is a finding.

What libFuzzer has learned stays in WORK/corpus; inputs that end a target, and reports of sanitizers, also in
its children, are in WORK/findings. A finding is run again by `karst_fuzz_TARGET FILE`."""

import argparse
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

# Of each target: its share of all runs, in ten-thousandths (fast ones have more), and the longest input.
TARGETS = {
    "world": (300, 8192),
    "sections": (195, 4096),
    "tile": (5, 30000),
    "camera_path": (2000, 512),
    "poses": (2000, 512),
    "board": (2000, 2048),
    "cigi": (2000, 1024),
    "carve": (248, 1024),
    "material_file": (250, 1536),
    "png": (1000, 1024),
    "elevation": (1, 4096),
    "material_image": (1, 4096),
}
MOST_MIB = 2048


def run(options, name, jobs):
    _, longest = TARGETS[name]
    corpus = options.work / "corpus" / name
    corpus.mkdir(parents=True, exist_ok=True)
    findings = options.work / "findings"
    command = [options.build / "tests" / f"karst_fuzz_{name}", corpus, options.work / "seeds" / name,
               f"-max_len={longest}", "-timeout=25", f"-rss_limit_mb={MOST_MIB}", "-print_final_stats=1",
               "-verbosity=0", f"-artifact_prefix={findings}/{name}-"]
    if options.runs:
        total = sum(TARGETS[target][0] for target in options.targets)
        command.append(f"-runs={max(1, options.runs * TARGETS[name][0] // total)}")
    else:
        command.append(f"-max_total_time={max(1, options.seconds * jobs // len(options.targets))}")
    reports = f"log_path={findings}/{name}-report:detect_leaks=0"
    environment = dict(os.environ, ASAN_OPTIONS=reports, UBSAN_OPTIONS=f"{reports}:print_stacktrace=1")
    environment["TMPDIR"] = str(options.work / "temporary")
    log = options.work / f"{name}.log"
    start = time.monotonic()
    with open(log, "wb") as out:
        code = subprocess.run(command, stdout=out, stderr=out, env=environment, check=False).returncode
    seconds = time.monotonic() - start
    text = log.read_text(errors="replace")
    count = re.findall(r"stat::number_of_executed_units:\s*(\d+)", text)
    runs = int(count[-1]) if count else 0
    # A report and the input that it is about are one finding; children have reports alone.
    reports = len(list(findings.glob(f"{name}-report.*")))
    inputs = len(list(findings.glob(f"{name}-*"))) - reports
    return name, runs, seconds, max(reports, inputs, int(code != 0))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, required=True)
    parser.add_argument("--runs", type=int, help="of all targets together, instead of a time")
    parser.add_argument("seconds", nargs="?", type=int, default=60, help="of all targets together")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    options = parser.parse_args()
    options.targets = options.targets or list(TARGETS)
    for name in options.targets:
        if name not in TARGETS:
            parser.error(f"there is no target {name}; there are {', '.join(TARGETS)}")
    options.build = options.build.resolve()
    options.work = options.build / "fuzz"
    for folder in ("findings", "temporary", "seeds"):
        shutil.rmtree(options.work / folder, ignore_errors=True)
        (options.work / folder).mkdir(parents=True)
    subprocess.run([options.build / "tests" / "karst_make_seeds", options.work / "seeds"], check=True)

    jobs = min(os.cpu_count() or 1, len(options.targets))
    # The longest first, so that all processors end together.
    order = sorted(options.targets, key=lambda name: TARGETS[name][0], reverse=True)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        results = {r[0]: r for r in pool.map(lambda name: run(options, name, jobs), order)}
    shutil.rmtree(options.work / "temporary", ignore_errors=True)
    print("| target | runs | runs a second | findings |\n|---|---|---|---|")
    for name in options.targets:
        _, runs, seconds, found = results[name]
        print(f"| {name} | {runs:,} | {runs / max(seconds, 0.001):,.0f} | {found} |")
    found = sum(r[3] for r in results.values())
    print(f"| all | {sum(r[1] for r in results.values()):,} | | {found} |")
    if found:
        print(f"findings are in {options.work}/findings, what targets printed in {options.work}/TARGET.log",
              file=sys.stderr)
    return int(found > 0)


if __name__ == "__main__":
    sys.exit(main())
