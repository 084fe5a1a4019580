# SPDX-License-Identifier: MIT
"""An X server without a screen (Xvfb), its picture, and input as a keyboard and a mouse would send it (the
XTEST extension, X Test Extension Protocol 2.2), by the X11 protocol itself. Standard library only."""
import argparse, os, shutil, socket, struct, subprocess, sys, time

# Keys of a PC, by what is printed on them: X11's codes are the kernel's (linux/input-event-codes.h) and 8.
KEYS = {name: 8 + code for code, name in enumerate(
    "- esc 1 2 3 4 5 6 7 8 9 0 minus equal backspace tab q w e r t y u i o p [ ] enter ctrl a s d f g h j k "
    "l ; ' ` shift \\ z x c v b n m , . / rshift kp* alt space".split())}
KEYS.update(f5=8 + 63, up=8 + 103, left=8 + 105, right=8 + 106, down=8 + 108, home=8 + 102)
LEFT, MIDDLE, RIGHT = 1, 2, 3


def begin_test(usage):
    """Arguments of a test of windows, and its folder, empty; ends with 77 where there is no Xvfb."""
    ap = argparse.ArgumentParser(usage=usage)
    for name in ("--karst", "--bake", "--work"):
        ap.add_argument(name, required=True)
    args = ap.parse_args()
    if not shutil.which("Xvfb"):
        print("skipped: Xvfb is not installed")
        sys.exit(77)
    shutil.rmtree(args.work, ignore_errors=True)
    os.makedirs(args.work)
    return args


class XServer:
    """Of W x H pixels, in a folder that is there."""

    def __init__(self, width, height, folder):
        self.folder, self.socket = folder, None
        # A server that ends meanwhile may take the socket of its number away from the next one.
        for attempt in range(5):
            self.start(width, height)
            time.sleep(0.2)
            if self.display and os.path.exists(self.path()):
                return
            self.close()
        raise SystemExit("Xvfb does not start")

    def path(self):
        return os.path.join("/", "tmp", ".X11-unix", "X" + self.display)

    def start(self, width, height):
        read, write = os.pipe()
        self.process = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-fbdir", self.folder,
             "-nolisten", "tcp"], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        # The number and the line's end come apart, and it wants to be rid of both.
        line = b""
        while not line.endswith(b"\n"):
            piece = os.read(read, 16)
            if not piece:
                break
            line += piece
        self.display = line.decode().strip()
        os.close(read)

    def close(self):
        if self.socket:
            self.socket.close()
        self.process.terminate()  # it takes its lock away
        self.process.wait()

    def picture(self):
        """The framebuffer's file (XWD, version 7) as width, height, rows of RGB."""
        data = open(os.path.join(self.folder, "Xvfb_screen0"), "rb").read()
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

    # --- input

    def connect(self):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(10)
        self.socket.connect(self.path())
        self.socket.sendall(struct.pack("<BxHHHHxx", ord("l"), 11, 0, 0, 0))
        status, length = struct.unpack("<BxxxxxH", self.need(8))
        self.need(4 * length)
        if status != 1:
            raise SystemExit("the X server refuses the connection")
        name = b"XTEST"
        self.socket.sendall(struct.pack("<BxHHxx", 98, 2 + (len(name) + 3) // 4, len(name)) + name +
                            b"\0" * (-len(name) % 4))
        reply = self.need(32)
        if not reply[8]:
            raise SystemExit("the X server has no XTEST")
        self.xtest = reply[9]

    def need(self, count):
        data = b""
        while len(data) < count:
            part = self.socket.recv(count - len(data))
            if not part:
                raise SystemExit("the X server hangs up")
            data += part
        return data

    def fake(self, kind, detail, x=0, y=0):
        if not self.socket:
            self.connect()
        self.socket.sendall(struct.pack("<BBHBBxxII8xhh8x", self.xtest, 2, 9, kind, detail, 0, 0, x, y))

    def move(self, x, y):
        self.fake(6, 0, x, y)

    def press(self, name):
        self.fake(2, KEYS[name])

    def release(self, name):
        self.fake(3, KEYS[name])

    def key(self, *names, seconds=0.05):
        """Presses and releases one key after the other, each held for so long."""
        for name in names:
            self.press(name)
            time.sleep(seconds)
            self.release(name)
            time.sleep(0.02)

    def button(self, number, down):
        self.fake(4 if down else 5, number)
