#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""karst view in a real kernel: Debian's, booted in QEMU with virtio-gpu, photographed from outside.

  kms_test.py CASE --karst PROGRAM --bake PROGRAM --console-mode PROGRAM --work DIR
              [--cycles N] [--seconds S] [--seed N]

CASE: picture, recovery, kill, input or edit (see guest/). Packages of the guest are fetched once and kept
under DIR. Exit status 77: skipped, with the reason, where the packages or QEMU are not to be had. Standard
library only.
"""
import argparse, fcntl, glob, os, shutil, struct, subprocess, sys, zlib

HERE = os.path.dirname(os.path.abspath(__file__))
PACKAGES = ("linux-image-amd64 busybox-static libgles2 libegl1 libgbm1 libgl1-mesa-dri libstdc++6 libdrm2 "
            "libinput10 libinput-bin libseat1 libudev1 libpng16-16 seatd").split()
TOOLS = "qemu-system-x86_64 apt-get dpkg-deb cpio zstd modinfo readelf".split()
SKIPPED = 77
SIZE = (320, 240)


class Skip(Exception):
    pass


def load_png(path):
    """Width, height, rows of RGB bytes of an 8-bit RGB or RGBA PNG."""
    data = open(path, "rb").read()
    pos, idat = 8, b""
    while pos < len(data):
        n, kind = struct.unpack_from(">I4s", data, pos)
        body = data[pos + 8:pos + 8 + n]
        if kind == b"IHDR":
            w, h, depth, color, _, _, lace = struct.unpack(">IIBBBBB", body)
            assert depth == 8 and color in (2, 6) and lace == 0, "unsupported PNG"
        elif kind == b"IDAT":
            idat += body
        pos += 12 + n
    bpp = 3 if color == 2 else 4
    raw, stride = zlib.decompress(idat), w * bpp
    rows, prev = [], bytearray(stride)
    for y in range(h):
        f = raw[y * (stride + 1)]
        row = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for i in range(stride):
            a = row[i - bpp] if i >= bpp else 0
            b, c = prev[i], prev[i - bpp] if i >= bpp else 0
            if f == 1:
                p = a
            elif f == 2:
                p = b
            elif f == 3:
                p = (a + b) // 2
            elif f == 4:
                pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                p = a if pa <= pb and pa <= pc else b if pb <= pc else c
            else:
                break
            row[i] = (row[i] + p) & 255
        prev = row
        rows.append(b"".join(bytes(row[x:x + 3]) for x in range(0, stride, bpp)))
    return w, h, rows


def difference(a, b):
    """Largest difference of a channel, and the share of pixels that differ at all."""
    (w, h, rows), (w2, h2, rows2) = a, b
    if (w, h) != (w2, h2):
        return 256, 1.0
    most, apart = 0, 0
    for p, q in zip(rows, rows2):
        if p == q:
            continue
        for x in range(0, 3 * w, 3):
            d = max(abs(p[x + i] - q[x + i]) for i in range(3))
            most = max(most, d)
            apart += d > 0
    return most, apart / (w * h)


def run(*words, **more):
    return subprocess.run(words, check=True, **more)


def fetch(work, packages):
    """The packages' files in a folder of work, where they are kept."""
    root = os.path.join(work, "guest", "tree")
    done = os.path.join(work, "guest", "packages")
    if not os.path.exists(done) or open(done).read().split() != packages:
        shutil.rmtree(os.path.join(work, "guest"), ignore_errors=True)
        log = os.path.join(work, "fetch.log")
        with open(log, "w") as out:
            code = subprocess.call([os.path.join(HERE, "fetch_guest.sh"), "amd64",
                                    os.path.join(work, "guest"), *packages], stdout=out, stderr=out)
        if code != 0:
            last = (open(log).read().strip().splitlines() or ["no output"])[-1]
            raise Skip(f"the guest's packages cannot be fetched: {last}")
        with open(done, "w") as out:
            out.write(" ".join(packages))
    return root


def prepare(args):
    """The kernel, the image with karst in it, and the world. Kept in args.work, made again when older."""
    for tool in TOOLS:
        if not shutil.which(tool, path=os.environ["PATH"] + ":/usr/sbin:/sbin"):
            raise Skip(f"{tool} is not installed")
    root = fetch(args.work, PACKAGES)
    world = os.path.join(args.work, "canyon.karst")
    run(args.bake, "--sample", "canyon", "--no-ground", "--levels", "3", "-o", world,
        stdout=subprocess.DEVNULL)
    # A world that is there soon, where only starting and ending counts.
    small = os.path.join(args.work, "small.karst")
    run(args.bake, "--sample", "canyon", "--no-ground", "--voxel", "40", "--levels", "1", "-o", small,
        stdout=subprocess.DEVNULL)
    program = os.path.join(args.work, "karst")
    run("strip", "-o", program, args.karst)
    image = os.path.join(args.work, "initramfs.img")
    stamp = os.path.join(args.work, "image.inputs")
    inputs = run("sha256sum", program, world, small, args.console_mode,
                 os.path.join(HERE, "make_initramfs.sh"),
                 *sorted(glob.glob(os.path.join(HERE, "guest", "*.sh"))), capture_output=True,
                 text=True).stdout
    if not os.path.exists(image) or not os.path.exists(stamp) or open(stamp).read() != inputs:
        modules = glob.glob(os.path.join(root, "lib/modules/*"))[0]
        files = [program, args.console_mode + ":/usr/bin/console_mode", world + ":/canyon.karst",
                 small + ":/small.karst",
                 os.path.join(root, "usr/sbin/seatd")]
        for pattern, where in ((os.path.join(HERE, "guest/*.sh"), ""),
                               (os.path.join(root, "usr/share/libinput/*"), "/usr/share/libinput")):
            files += [f"{path}:{where}/{os.path.basename(path)}" for path in glob.glob(pattern)]
        run(os.path.join(HERE, "make_initramfs.sh"), "-k", modules, "-o", image, "-s", root, *files)
        with open(stamp, "w") as out:
            out.write(inputs)
    kernel = glob.glob(os.path.join(root, "boot/vmlinuz-*"))[0]
    return kernel, image, world


def boot(args, kernel, image, script, seconds, more=()):
    out = os.path.join(args.work, args.case)
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    code = subprocess.call(["nice", "-n", "10", sys.executable, os.path.join(HERE, "run_vm.py"), "-k", kernel,
                            "-i", image, "-o", out, "-t", str(seconds), "--boot-timeout", "240", "--gpu",
                            "virtio-gpu-pci,xres=%d,yres=%d" % SIZE, *more, "--", script])
    console = open(os.path.join(out, "console.log"), errors="replace").read()
    print(console[-6000:])
    for line in console.splitlines():
        if line.startswith("FIGURE"):
            print("==", line[7:])
    if code != 0:
        sys.exit(f"the guest ends with {code} (124: out of time, 125: died)")
    return out


def rendered(args, world, size=SIZE, more=()):
    path = os.path.join(args.work, "rendered.png")
    # 32 bits on both sides: whether 16 are 16 depends on the processor.
    run(args.karst, "render", world, "-o", path, "--size", "%dx%d" % size, "--precision", "high", *more)
    return load_png(path)


failed = False


def expect(name, shot, golden, most, share=1.0):
    """The shot differs from the golden by so much at most, on so many of the pixels."""
    global failed
    d, apart = difference(load_png(shot), golden)
    good = d <= most or (share < 1 and apart <= share)
    failed = failed or not good
    verdict = "ok" if good else "FAILED"
    print(f"== {name}: differs by {d}/255 at most, on {100 * apart:.2f} % of the pixels: {verdict}")


def black_share(picture):
    w, h, rows = picture
    return sum(row[x:x + 3] == b"\0\0\0" for row in rows for x in range(0, 3 * w, 3)) / (w * h)


def expect_console(name, shot):
    """The shot is of a console with text on it."""
    picture = load_png(shot)
    black = black_share(picture)
    print(f"== {name}: a console, {100 * black:.0f} % black")
    if black < 0.5 or not any(any(row) for row in picture[2]):
        sys.exit(f"{name}: this is no console with text")


def run_alone(args, prepared):
    """What prepared() gives, once no other test uses WORK: machines take all processors. None: skipped."""
    os.makedirs(args.work, exist_ok=True)
    args.lock = open(os.path.join(args.work, "lock"), "w")  # held until the program ends
    fcntl.flock(args.lock, fcntl.LOCK_EX)
    try:
        return prepared()
    except Skip as reason:
        print(f"skipped: {reason}")
        return None


def main():
    global failed
    ap = argparse.ArgumentParser(usage=__doc__)
    ap.add_argument("case", choices=("picture", "recovery", "kill", "input", "edit"))
    ap.add_argument("--karst", required=True)
    ap.add_argument("--bake", required=True)
    ap.add_argument("--console-mode", required=True, help="the helper that looks at the terminal")
    ap.add_argument("--work", required=True)
    ap.add_argument("--cycles", type=int, default=5)
    ap.add_argument("--seconds", type=int, default=240)
    ap.add_argument("--seed", type=int, default=1)
    args = ap.parse_args()
    prepared = run_alone(args, lambda: prepare(args))
    if prepared is None:
        return SKIPPED
    kernel, image, world = prepared
    script = {"picture": ". /picture.sh", "input": ". /input.sh", "edit": ". /edit.sh",
              "kill": f"set -- {args.cycles}; . /kill.sh",
              "recovery": f"set -- {args.cycles} {args.seed}; . /recovery.sh"}[args.case]
    out = boot(args, kernel, image, script, args.seconds)
    shot = lambda name: os.path.join(out, name + ".png")
    golden = rendered(args, world)
    if args.case == "picture":
        expect("scan-out of canyon, atomic", shot("atomic"), golden, 1)
        expect("scan-out of canyon, legacy", shot("legacy"), golden, 1)
        # Both mips: which one a pixel of --detail medium takes depends on its place on the screen.
        w, h, rows = rendered(args, world, more=("--detail", "high"))
        mirrored = lambda row: b"".join(row[x:x + 3] for x in range(3 * w - 3, -1, -3))
        upside_down = (w, h, [mirrored(row) for row in reversed(rows)])
        expect("turned by 180 degrees", shot("rotated"), upside_down, 8, 0.02)
        for name in ("after_term", "after_kill"):
            expect_console(name, shot(name))
    elif args.case == "recovery":
        for name in ("before", "after"):
            expect(name, shot(name), golden, 1)
        for path in glob.glob(os.path.join(out, "cycle*.png")):
            expect(os.path.basename(path), path, golden, 1)
        expect("in another mode", shot("other_mode"), rendered(args, world, (400, 300)), 2)
    elif args.case == "input":
        expect("before keys", shot("still"), golden, 1)
        if difference(load_png(shot("turned")), golden)[1] < 0.2:
            sys.exit("an arrow key does not turn the camera")
        expect("a pose from standard input", shot("posed"), rendered(args, world, SIZE,
               ("--camera", "60,70,60,85,5")), 1)
        expect("through libseat, without root", shot("libseat"), golden, 1)
    elif args.case == "edit":
        # Between the lines at top and bottom.
        inner = lambda name: (lambda w, h, rows: (w, h - 140, rows[80:-60]))(*load_png(shot(name)))
        pairs = (("still", "dug", 0.1, 0.9), ("still", "undone", 0, 0.0005),
                 ("undone", "clicked", 0.1, 0.9), ("dug", "clicked", 0.1, 0.9),
                 ("clicked", "again", 0, 0.08))
        for before, after, least, most in pairs:
            apart = difference(inner(before), inner(after))[1]
            good = least <= apart <= most
            failed = failed or not good
            print(f"== {after} differs from {before} on {100 * apart:.2f} %: {'ok' if good else 'FAILED'}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
