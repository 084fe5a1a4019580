#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""window_edit_test.py --karst KARST_WINDOW --bake BAKE --work DIR

karst view --window --edit on an X server without a screen (Xvfb), used by mouse and keys: digs a tunnel,
takes a stroke back, is killed, goes on, saves, and opens what was saved. Exit status 77: skipped, where there
is no Xvfb. Standard library only.
"""
import json, math, os, signal, struct, subprocess, sys, time

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path += [HERE, os.path.join(HERE, "..", "..", "kms")]
from kms_test import difference, load_png
from x_server import LEFT, XServer, begin_test

W, H = 400, 240
CAMERA = "0,~12,120,0,-6"


class View:
    """karst view of the world, on the server."""

    def __init__(self, args, server, world, *more):
        self.server, self.stats = server, os.path.join(args.work, "stats.json")
        if os.path.exists(self.stats):
            os.remove(self.stats)
        self.log = os.path.join(args.work, "view.log")
        with open(self.log, "w") as log:
            self.process = subprocess.Popen(
                [args.karst, "view", world, "--window", "--size", f"{W}x{H}", "--camera", CAMERA, "--stats",
                 self.stats, *more], stderr=log, env=dict(os.environ, DISPLAY=":" + server.display))

        # SIGHUP would end it before it is ready for that.
        blocked = 0
        while not blocked & 1:
            time.sleep(0.05)
            if self.process.poll() is not None:
                sys.exit("karst view ended: " + open(self.log).read())
            status = open(f"/proc/{self.process.pid}/status").read()
            blocked = int(status.split("SigBlk:")[1].split()[0], 16)

    def frames(self):
        """How many were drawn; it waits for the answer."""
        if os.path.exists(self.stats):
            os.remove(self.stats)
        self.process.send_signal(signal.SIGHUP)
        end = time.monotonic() + 30
        while time.monotonic() < end:
            if self.process.poll() is not None:
                sys.exit("karst view ended: " + open(self.log).read())
            try:
                return json.load(open(self.stats))["frames"]
            except (OSError, ValueError):
                time.sleep(0.05)
        sys.exit("karst view does not answer")

    def statistics(self):
        self.frames()
        return json.load(open(self.stats))

    def settled(self):
        """The picture, when no more frames are drawn."""
        before = -1
        while before != (now := self.frames()) or now == 0:
            before = now
            time.sleep(0.4)
        return self.server.picture()

    def end(self):
        self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(20)
        if code != 0:
            sys.exit(f"karst view ends with {code}: " + open(self.log).read())
        return open(self.log).read()


def main():
    args = begin_test(__doc__)
    path = lambda name: os.path.join(args.work, name)
    world, journal = path("hills.karst"), path("hills.karst.journal")
    subprocess.run([args.bake, "--sample", "hills", "--no-ground", "--levels", "2", "-o", world], check=True,
                   stdout=subprocess.DEVNULL)
    old = open(world, "rb").read()
    failures = []

    def expect(what, good):
        print(f"== {what}: {'ok' if good else 'FAILED'}")
        if not good:
            failures.append(what)

    # Share of pixels that differ, without the lines at top and bottom.
    def apart(a, b):
        inner = lambda p: (p[0], p[1] - 90, p[2][60:-30])
        return difference(inner(a), inner(b))[1]

    def render(picture, of=world):
        subprocess.run([args.karst, "render", of, "-o", picture, "--size", f"{W}x{H}", "--camera", CAMERA],
                       check=True)

    def same(what, a, b, most):
        share = apart(a, b)
        expect(f"{what} ({100 * share:.3f} % differ)", share <= most)

    server = XServer(W, H, args.work)
    view = None
    try:
        view = View(args, server, world, "--edit")
        view.settled()
        server.move(W // 2, H // 2)
        still = view.settled()
        # The same picture without the editor.
        render(path("plain.png"))
        share = apart(still, load_png(path("plain.png")))
        expect(f"a ring is drawn over the terrain alone ({100 * share:.2f} %)", 0.0005 < share < 0.05)
        server.move(W // 2 + 60, H // 2)
        expect("the ring follows the mouse", apart(view.settled(), still) > 0.0005)
        server.move(W // 2, H // 2)
        again = view.settled()
        expect("and comes back", difference(again, still)[0] <= 1)
        # Dig: held, it goes on.
        server.button(LEFT, True)
        time.sleep(1.5)
        server.button(LEFT, False)
        dug = view.settled()
        expect("a stroke digs", apart(dug, still) > 0.01)
        lines = open(journal).read().splitlines()
        expect(f"the journal has it ({len(lines) - 1} edits)", len(lines) >= 3 and '"clear"' in lines[1])
        second = subprocess.run([args.karst, "view", world, "--headless", "--edit", "--frames", "1"],
                                capture_output=True, text=True)
        expect("a second editor is told", second.returncode == 1 and "another karst" in second.stderr)
        server.key("z")
        same("z takes it back", view.settled(), still, 1e-4)
        server.key("y")
        same("y does it again", view.settled(), dug, 1e-4)
        # A voxel, eight metres a side or so, at the chosen level.
        server.key("b", "b", ",", ",")
        cube = view.settled()
        expect("a cube shows the voxel", apart(cube, dug) > 0.0005)
        server.key("space")
        expect("space digs, too", apart(view.settled(), cube) > 0.001)
        server.key("z")
        view.settled()
        statistics = view.statistics()
        edits, milliseconds = statistics["edits"], statistics["edit_ms"]["median"]
        print(f"== edits take {milliseconds:.1f} ms a frame, median of {edits}")
        expect("statistics count them", edits >= 6 and milliseconds > 0)
        # Killed: the next one goes on.
        view.process.kill()
        view.process.wait()
        expect("the world is what it was", open(world, "rb").read() == old)
        view = View(args, server, world, "--edit")
        view.settled()
        server.key("h", "h")
        same("after a kill all is there again", view.settled(), dug, 0.01)
        server.key("f5")
        view.settled()
        expect("F5 saves", open(world, "rb").read() != old)
        said = view.end()
        expect("it says what it found", "were not saved: done again" in said)
        expect("nothing is left of the journal", not os.path.exists(journal))
        view = View(args, server, world)
        reopened = view.settled()
        view.end()
        render(path("saved.png"))
        expect("what was saved is what is seen", difference(reopened, load_png(path("saved.png")))[0] <= 1)
        same("and has the hole", reopened, dug, 0.03)

        # Heights of a ground.
        ground = path("ground.karst")
        heights = [int(60 * math.sin(x / 9) * math.cos(z / 7)) for z in range(129) for x in range(129)]
        with open(path("dem.bil"), "wb") as dem:
            dem.write(struct.pack(f"<{len(heights)}h", *heights))
        with open(path("dem.hdr"), "w") as header:
            header.write("ncols 129\nnrows 129\nnbits 16\npixeltype signedint\nbyteorder I\n")
        subprocess.run([args.bake, path("dem.bil"), "--pixel-size", "10", "-o", ground], check=True,
                       stdout=subprocess.DEVNULL)
        view = View(args, server, ground, "--edit")
        still = view.settled()
        server.button(LEFT, True)
        time.sleep(1)
        server.button(LEFT, False)
        raised = view.settled()
        expect("a stroke raises the ground", apart(raised, still) > 0.02)
        server.key("z")
        same("z takes it back", view.settled(), still, 1e-4)
        server.key("y", "f5")
        view.settled()
        said = view.end()
        expect("it is saved" + said, not os.path.exists(ground + ".journal"))
        render(path("ground.png"), ground)
        same("and reopened has the hill", load_png(path("ground.png")), raised, 0.03)
        return 1 if failures else 0
    finally:
        if view and view.process.poll() is None:
            view.process.kill()
        server.close()


if __name__ == "__main__":
    sys.exit(main())
