#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""window_test.py --karst KARST_WINDOW --bake BAKE --work DIR

karst view --window on an X server without a screen (Xvfb): the window holds what karst render draws. Exit
status 77: skipped, where there is no Xvfb. Standard library only.
"""
import os, signal, subprocess, sys, time

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path += [HERE, os.path.join(HERE, "..", "..", "kms")]
from kms_test import difference, load_png
from x_server import XServer, begin_test

W, H = 320, 240


def main():
    args = begin_test(__doc__)
    path = lambda name: os.path.join(args.work, name)
    subprocess.run([args.bake, "--sample", "canyon", "--no-ground", "--levels", "2", "-o", path("world")],
                   check=True)
    size = f"{W}x{H}"
    golden = path("golden.png")
    subprocess.run([args.karst, "render", path("world"), "-o", golden, "--size", size], check=True)
    server = XServer(W, H, args.work)
    view = None
    try:
        # No window manager: a window of the screen's size covers it.
        view = subprocess.Popen([args.karst, "view", path("world"), "--window", "--size", size,
                                 "--navigate", "none"],
                                env=dict(os.environ, DISPLAY=":" + server.display))
        most, apart = 256, 1
        end = time.monotonic() + 30
        while most > 1 and time.monotonic() < end:
            time.sleep(0.2)
            most, apart = difference(server.picture(), load_png(golden))
        view.send_signal(signal.SIGTERM)
        code = view.wait(10)
        print(f"differs by {most}/255 at most, on {100 * apart:.2f} % of the pixels; exit {code}")
        return 0 if most <= 1 and code == 0 else 1
    finally:
        if view and view.poll() is None:
            view.kill()
        server.close()


if __name__ == "__main__":
    sys.exit(main())
