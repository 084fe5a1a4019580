#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Small inputs that ask for much or are wrong in one place: each ends with the exit code it should, never by
a signal, and within 256 MiB; prints the seconds and the memory that each took.
--karst PROGRAM --bake PROGRAM --work FOLDER [--cases FOLDER: more of the same, for their memory and end]"""

import argparse
import gzip
import json
import os
import shutil
import subprocess
import sys
import threading

sys.dont_write_bytecode = True
from make_inputs import envi, noise, png, tiled_tiff, zero_world

MOST_MIB = 256
WITH_MATERIALS = ["karst-bake", "--sample", "hills", "--no-ground", "--voxel", "200", "-o", "x.karst",
                  "--materials"]
HANGS_S = 120  # slower than anything on any machine; speed is printed and not judged


class Inputs:
    def __init__(self, options):
        self.programs = {"karst": options.karst, "karst-bake": options.bake}
        self.failures = []
        self.sanitized = options.sanitized
        print("| input | exit code | CPU s | MiB | what it says |\n|---|---|---|---|---|")

    def run(self, name, code, words, says="", most_mib=MOST_MIB):
        """One command: it must end with the exit code and, on standard error, say `says`."""
        with open("err.txt", "w+b") as err:
            process = subprocess.Popen([self.programs[words[0]]] + words[1:], stdout=subprocess.DEVNULL,
                                       stderr=err)
            timer = threading.Timer(HANGS_S, process.kill)
            timer.start()
            _, status, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
            err.seek(0)
            text = err.read().decode(errors="replace").strip()
        mib = usage.ru_maxrss / 1024
        seconds = usage.ru_utime + usage.ru_stime
        last = text.splitlines()[-1] if text else ""
        print(f"| {name} | {process.returncode} | {seconds:.2f} | {mib:.0f} | {last[:90]} |", flush=True)
        codes = code if isinstance(code, tuple) else (code,)
        if process.returncode not in codes:
            self.failures.append(f"{name}: exit code {process.returncode}, not {code}: {text}")
        if says not in text:
            self.failures.append(f"{name}: does not say '{says}': {text}")
        if mib > most_mib and not self.sanitized:
            self.failures.append(f"{name}: {mib:.0f} MiB, more than {most_mib}")


def write(path, text):
    with open(path, "wb") as out:
        out.write(text if isinstance(text, bytes) else text.encode())


def materials(image, side=None):
    size = {} if side is None else {"side": side}
    write("materials.json", json.dumps({**size, "materials": [{"name": "a", "albedo": image}]}))
    return WITH_MATERIALS + ["materials.json"]


def write_materials(listed, **more):
    write("materials.json", json.dumps({**more, "materials": listed}))
    return WITH_MATERIALS + ["materials.json"]


def many_images(image, count, side=256):
    """All four images of each material, and a blend map."""
    kinds = ("albedo", "height", "normal", "roughness")
    listed = [{"name": f"m{k}", **{kind: image for kind in kinds}} for k in range(count)]
    return write_materials(listed, side=side, blend_map={"image": image, "materials": ["m0"]})


def samples(sample, count):
    return write_materials([{"name": f"m{k}", "sample": sample} for k in range(count)])


def own_materials(side):
    write("materials.json", json.dumps({"side": side}))
    return WITH_MATERIALS + ["materials.json"]


def elevation(path, *more):
    return ["karst-bake", path, "-o", "x.karst", "--pixel-size", "1", *more]


def resources(inputs):
    tiled_tiff("mat16.tif", 64, 64, 16384, 16, 8, 1 << 16)
    inputs.run("material, a tile of 16 channels", 1, materials("mat16.tif"), "mat16.tif")
    tiled_tiff("bomb.tif", 64, 64, 16384, 1, 16, 1 << 16)
    inputs.run("elevation, a tile of 16384 a side", 1, elevation("bomb.tif"), "bomb.tif")
    png("sea.png", 1024, 1024, 16, 0, b"\x10\x00" * 1024)
    inputs.run("elevation of one height, 1024 a side", 1, elevation("sea.png"), "--max-samples 1048576")
    part = elevation("sea.png", "--crop", "0,0,512,512", "--materials", "none")
    inputs.run("a part of it", 0, part)
    inputs.run("a part of it, of voxels", 0, part + ["--no-ground"])
    ground = ["--ground", "--materials", "none"]
    inputs.run("a ground of one height", 1, elevation("sea.png", *ground), "--max-samples 1048576")
    png("wide.png", 262_000, 2, 16, 0, b"\x10\x00" * 262_000)
    inputs.run("a ground of 262000 x 2", 0, elevation("wide.png", *ground))
    png("long.png", 40_000, 96, 16, 0, b"\x10\x00" * 40_000)
    with open("long.png", "ab") as out:
        out.write(bytes(850_000))
    inputs.run("a ground of 40000 x 96", 1, elevation("long.png", *ground), "--max-samples 3840000")
    inputs.run("the same, allowed", 0, elevation("long.png", *ground, "--max-samples", "3840000"),
               most_mib=400)
    png("mat8k.png", 8192, 8192, 1, 0, bytes(1024))
    inputs.run("material of 8192 a side in 8 KB", 1, materials("mat8k.png"), "--max-texels 67108864")
    png("flat16.png", 4096, 4096, 16, 2, b"\x80\x10" * 3 * 4096)
    inputs.run("material of one colour, 4096 a side", 1, materials("flat16.png"), "--max-texels 16777216")
    png("flat1.png", 2048, 2048, 1, 0, bytes(256))
    inputs.run("material of one colour, 2048 a side", 0, materials("flat1.png"))
    inputs.run("33 images of one colour, 2048 a side", 1, many_images("flat1.png", 8),
               "--max-texels 138412032")
    inputs.run("textures of 1024 a side", 1, materials("flat1.png", 1024), "--material-side 1024")
    inputs.run("own materials of 1024 a side", 1, own_materials(1024), "--material-side 1024")
    inputs.run("two textures of 512 a side", 0, many_images("nine.png", 2, 512))
    inputs.run("eight of 256 a side that are rock", 0, samples("rock", 8))
    # What the messages say allows it.
    inputs.run("one colour, 4096 a side, allowed", 0, materials("flat16.png") + ["--max-texels", "16777216"])
    inputs.run("a texture of 1024 a side, allowed", 0, materials("flat1.png") + ["--material-side", "1024"],
               most_mib=300)
    png("drape16k.png", 16384, 16384, 8, 2, bytes(3 * 16384), 1)
    inputs.run("drape of 16384 a side", 1, ["karst", "render", "w.karst", "-o", "w.png", "--drape",
                                            "drape16k.png", "--max-memory", "64"], "--max-memory")
    png("drape8k.png", 8192, 8192, 1, 0, bytes(1024))
    drape = ["karst", "render", "w.karst", "-o", "w.png", "--size", "64x64", "--drape"]
    inputs.run("drape of 8192 a side in 8 KB", 1, drape + ["drape8k.png"], "--max-memory")
    png("drape6k.png", 6000, 6000, 8, 0, bytes(6000))
    inputs.run("drape of 6000 a side in 35 KB", 1, drape + ["drape6k.png"], "--max-memory above 512")
    inputs.run("the same, allowed", 0, drape + ["drape6k.png", "--max-memory", "600"], most_mib=500)
    png("drape2k.png", 2048, 2048, 1, 0, bytes(256))
    inputs.run("drape of 2048 a side in 1 KB", 0, drape + ["drape2k.png"])
    write("shapes.json", "[" + ",".join(["{}"] * 400_000) + "]")
    inputs.run("400,000 shapes of nothing", 1, elevation("nine.bil", "--carve", "shapes.json"), "shapes.json")
    write("over.json", json.dumps([{"shape": "sphere", "op": "empty", "center": [0, 0, 0], "radius": 90}] *
                                  9999))
    for more in ([], ["--no-ground"]):
        inputs.run(f"9999 shapes over all of a world {more}", 1,
                   elevation("hills.bil", "--carve", "over.json", *more),
                   "--max-carve" if more else "--carve")
    write("deep.json", "[" * (8 << 20))
    inputs.run("8 MiB of [", 1, elevation("nine.bil", "--carve", "deep.json"), "nested too deeply")
    write("many.json", "[" + "0," * 4_000_000 + "0]")
    inputs.run("8 MiB of 0,", 1, elevation("nine.bil", "--carve", "many.json"), "many.json")
    write("far.txt", "1e300 0 0 0 0")
    inputs.run("a camera that is far away", 1, ["karst", "view", "w.karst", "--headless", "--path", "far.txt",
                                                "--frames", "5"], "far.txt")
    write("long.txt", "0 ~2 0 0 0\n" * 1_000_001)
    inputs.run("a path of a million lines and one", 1, ["karst", "view", "w.karst", "--headless", "--path",
                                                       "long.txt"], "more than 1000000 frames")
    zero_world("zeros.karst", 1 << 20, (1 << 22) - 2)
    inputs.run("a world of holes", 1, ["karst", "info", "zeros.karst"], "patch keys")
    zero_world("unknown.karst", 100, 100, [(b"HUGE", 1 << 40)])
    inputs.run("a section of 1 TiB that nobody knows", 1, ["karst", "info", "unknown.karst"], "16 MiB")
    envi("steep", 64, 64, noise(20_000))
    # Which folds everywhere, and is repaired without a list of all that every pass touches.
    inputs.run("noise of 20 km", 1, ["karst-bake", "steep.bil", "-o", "x.karst", "--pixel-size", "30",
                                       "--no-ground"], "--accept-fit", most_mib=192)


def wrong(inputs):
    keys = ("title = x\ndriver = y\ncpu_mib = 4096 # r\ngpu_mib = 4096 # r\nsize = 64x64 # r\n"
            "colour = xrgb8888 # r\nbuffers = 2 # r\nlevel = 6 # r\nerror_px = 1 # r\ndrape = 0 # r\n"
            "detail = low # r\nshading = forward # r\nantialias = none # r\n")
    # What a budget says fits, view shows; what one refuses, so does the other.
    boards = (("1x256", "0.25", False), ("1x520", "1", False), ("0x512", "1", False), ("1x512", "0.1", False),
              ("1x512", "0.25", True), ("3x2048", "256", True), ("1x528", "1", True), ("0", "1", True))
    for cascades, vertices, good in boards:
        write("some.board", f"{keys}cascades = {cascades} # r\nvertex_mib = {vertices} # r\n")
        name = f"board with cascades {cascades}, vertex_mib {vertices}"
        board = ["w.karst", "--board", "some.board"]
        inputs.run(f"budget, {name}", 0 if good else (1, 2), ["karst", "budget", *board])
        inputs.run(f"view, {name}", 0 if good else (1, 2), ["karst", "view", *board, "--headless", "--frames",
                                                           "2"])
    inputs.run("elevation of 2 x 2", 0, elevation("nine.bil", "--crop", "0,0,2,2", "--levels", "2", "--voxel",
                                                  "1", "--materials", "none"))
    inputs.run("level 1 alone", 0, elevation("nine.bil", "--levels", "1", "--voxel", "4", "--materials",
                                             "none"))
    write("bom.txt", b"\xef\xbb\xbf0 ~2 0 0 0\r\n")
    inputs.run("a path with a byte order mark", 0, ["karst", "view", "w.karst", "--headless", "--path",
                                                    "bom.txt", "--frames", "1", "--size", "64x64"])
    write("c1.json", '[{"op": "\u009b31m", "\u202eelif": 1}]')
    inputs.run("control characters in JSON", 1, elevation("nine.bil", "--carve", "c1.json"))
    render = ["karst", "render", "w.karst", "-o"]
    inputs.run("a picture of 1 x 4096", 2, render + ["w.png", "--size", "1x4096"], "--size")
    inputs.run("a name of 251 characters", 0, render + ["n" * 247 + ".png", "--size", "64x64"])
    inputs.run("output is input", 1, render + ["w.karst"], "w.karst")
    inputs.run("output is output", 1, render + ["w.png", "--stats", "w.png"], "w.png")
    inputs.run("a camera a level below the ground's cell", 0,
               ["karst", "view", "w.karst", "--headless", "--size", "64x64", "--frames", "4", "--camera",
                "0,36,0,0,0"])


# The same kinds, as they were found. Their right results are judged above, by files alike.
FOUND = {
    "mat_tile16ch.json": WITH_MATERIALS,
    "mat8k.json": WITH_MATERIALS,
    "c1_escape.json": elevation("nine.bil", "--carve"),
    "json_quadratic_400k.json": elevation("nine.bil", "--carve"),
    "bom_path.txt": ["karst", "view", "w.karst", "--headless", "--frames", "2", "--size", "64x64", "--path"],
    "far.txt": ["karst", "view", "w.karst", "--headless", "--frames", "5", "--path"],
    "cascade_range.board": ["karst", "view", "w.karst", "--headless", "--frames", "2", "--board"],
    "drape16k.png": ["karst", "render", "w.karst", "-o", "w.png", "--max-memory", "64", "--drape"],
    "level_at_overflow.karst": ["karst", "view", "--headless", "--size", "64x64", "--frames", "4", "--camera",
                                "0,36,0,0,0"],
    "tile_bomb64.tif": ["karst-bake", "-o", "x.karst", "--pixel-size", "1"],
    "d9.png": ["karst-bake", "-o", "x.karst", "--pixel-size", "1", "--levels", "1", "--voxel", "4",
               "--materials", "none"],
}


def found(inputs, cases):
    for name, words in FOUND.items():
        path = os.path.join(cases, name)
        packed = f"{path}.gz"
        if os.path.exists(packed):
            with gzip.open(packed) as source:
                write(name, source.read())
            path = name
        if os.path.exists(path):
            inputs.run(name, (0, 1, 2), words + [path])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for option in ("--karst", "--bake", "--work"):
        parser.add_argument(option, required=True)
    parser.add_argument("--cases")
    parser.add_argument("--sanitized", action="store_true", help="memory is not judged")
    options = parser.parse_args()
    shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work)
    os.chdir(options.work)
    inputs = Inputs(options)
    envi("nine", 9, 9, lambda x, y: 3 * x + 5 * y % 7)
    envi("hills", 48, 48, lambda x, y: 8 + (3 * x + 5 * y) // 40)
    png("nine.png", 9, 9, 8, 0, bytes(9))
    inputs.run("the least world", 0, ["karst-bake", "--sample", "hills", "--no-ground",
                                        "--voxel", "100", "--levels", "2",
                                      "--material-side", "16", "-o", "w.karst"])
    resources(inputs)
    wrong(inputs)
    if options.cases and os.path.isdir(options.cases):
        found(inputs, options.cases)
    print("\n".join(f"FAILED: {failure}" for failure in inputs.failures) or "all right")
    os.chdir("/")
    shutil.rmtree(options.work, ignore_errors=True)
    return int(bool(inputs.failures))


if __name__ == "__main__":
    sys.exit(main())
