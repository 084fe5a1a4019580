#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""window_test.py --karst KARST_WINDOW --bake BAKE --work DIR

karst view --window on an X server without a screen (Xvfb): the window holds what karst render draws. Exit
status 77: skipped, where there is no Xvfb. Standard library only.
"""
import argparse, os, shutil, signal, struct, subprocess, sys, time

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "kms"))
from kms_test import difference, load_png

W, H = 320, 240


def screen(path):
    """The X server's framebuffer file (XWD, version 7) as width, height, rows of RGB."""
    data = open(path, "rb").read()
    header = struct.unpack(">25I", data[:100])
    w, h, bytes_per_line, colours = header[4], header[5], header[12], header[19]
    start = header[0] + colours * 12
    rows = []
    for y in range(h):
        line = data[start + y * bytes_per_line:][:4 * w]
        rgb = bytearray(3 * w)
        rgb[0::3], rgb[1::3], rgb[2::3] = line[2::4], line[1::4], line[0::4]
        rows.append(bytes(rgb))
    return w, h, rows


def main():
    ap = argparse.ArgumentParser(usage=__doc__)
    ap.add_argument("--karst", required=True)
    ap.add_argument("--bake", required=True)
    ap.add_argument("--work", required=True)
    args = ap.parse_args()
    if not shutil.which("Xvfb"):
        print("skipped: Xvfb is not installed")
        return 77
    shutil.rmtree(args.work, ignore_errors=True)
    os.makedirs(args.work)
    path = lambda name: os.path.join(args.work, name)
    subprocess.run([args.bake, "--sample", "canyon", "--no-ground", "--levels", "2", "-o", path("world")],
                   check=True)
    size = f"{W}x{H}"
    golden = path("golden.png")
    subprocess.run([args.karst, "render", path("world"), "-o", golden, "--size", size], check=True)
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", size + "x24", "-fbdir",
                               args.work, "-nolisten", "tcp"], pass_fds=[write], stderr=subprocess.DEVNULL)
    view = None
    try:
        os.close(write)
        display = os.read(read, 16).decode().strip()
        if not display:
            sys.exit("Xvfb does not start")
        # No window manager: a window of the screen's size covers it.
        view = subprocess.Popen([args.karst, "view", path("world"), "--window", "--size", size,
                                 "--navigate", "none"],
                                env=dict(os.environ, DISPLAY=":" + display))
        most, apart = 256, 1
        end = time.monotonic() + 30
        while most > 1 and time.monotonic() < end:
            time.sleep(0.2)
            most, apart = difference(screen(path("Xvfb_screen0")), load_png(golden))
        view.send_signal(signal.SIGTERM)
        code = view.wait(10)
        print(f"differs by {most}/255 at most, on {100 * apart:.2f} % of the pixels; exit {code}")
        return 0 if most <= 1 and code == 0 else 1
    finally:
        for process in (view, server):
            if process and process.poll() is None:
                process.kill()


if __name__ == "__main__":
    sys.exit(main())
