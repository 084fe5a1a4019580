#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Run a shell script in a KMS guest and take screenshots of its scanout.

  run_vm.py -k VMLINUZ -i INITRAMFS [options] -- 'guest shell commands'

In the guest, these ask the host for something and wait for it:
  host shot NAME [HEAD]     screenshot of a head to OUTDIR/NAME.png (or .ppm)
  host resize HEAD W H      resize a head (hotplug event); 0 0 unplugs it
  host key QCODE [MS]       press and release a key
  host click X Y            move the tablet there, 0..32767, and press and release its left button
  host mark TEXT            print a time stamp
Exit status: that of the guest commands; 124 on timeout, 125 if the guest died or
did not boot, 126 if it has no script (memory too small for the initramfs), 2 on
wrong use.  Standard library only; uses zstd where it is installed.
"""
import argparse, json, lzma, os, select, shutil, socket, struct, subprocess, sys, tempfile, time, zlib

ARCH = {
    "x86_64": dict(qemu="qemu-system-x86_64", machine="q35", tcg_cpu="Nehalem",
                   console="ttyS0", kvm_host="x86_64"),
    "aarch64": dict(qemu="qemu-system-aarch64", machine="virt", tcg_cpu="cortex-a72",
                    console="ttyAMA0", kvm_host="aarch64"),
}


def cpio_entry(name, data, mode):
    """One newc record, padded to 4 bytes."""
    n = name.encode() + b"\0"
    fields = (0, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(n), 0)
    head = b"070701" + b"".join(b"%08X" % f for f in fields) + n
    head += b"\0" * (-len(head) % 4)
    return head + data + b"\0" * (-len(data) % 4)


def kvm_usable(arch):
    if os.uname().machine != ARCH[arch]["kvm_host"]:
        return False
    # An openable /dev/kvm is not enough: inside some cloud VMs it emulates every
    # instruction of a stock kernel, and nothing ever boots.
    if arch == "x86_64":
        with open("/proc/cpuinfo") as f:
            flags = next((l for l in f if l.startswith("flags")), "").split()
        if not {"vmx", "svm"} & set(flags):
            return False
    try:
        os.close(os.open("/dev/kvm", os.O_RDWR))
        return True
    except OSError:
        return False


def host_copy_initramfs(src, dest):
    """Unpack on the host: doing it in an emulated guest costs seconds."""
    with open(src, "rb") as f:
        zstd = f.read(4) == b"\x28\xb5\x2f\xfd"
    if zstd and shutil.which("zstd"):
        subprocess.run(["zstd", "-dqf", src, "-o", dest], check=True)
    else:
        shutil.copyfile(src, dest)


def host_unpack_kernel(src, dest):
    """The ELF kernel inside an x86 bzImage, which QEMU can start directly (PVH)."""
    with open(src, "rb") as f:
        data = f.read()
    if data[0x202:0x206] != b"HdrS":
        return src
    offset, length = struct.unpack_from("<II", data, 0x248)
    start = (data[0x1F1] + 1) * 512 + offset
    payload = data[start:start + length]
    try:
        if payload[:6] == b"\xfd7zXZ\0":
            out = lzma.LZMADecompressor().decompress(payload)
        elif payload[:3] == b"\x1f\x8b\x08":
            out = zlib.decompressobj(31).decompress(payload)
        elif payload[:4] == b"\x28\xb5\x2f\xfd":
            out = subprocess.run(["zstd", "-dcq"], input=payload[:-4], check=True,
                                 stdout=subprocess.PIPE).stdout
        else:
            return src
    except (lzma.LZMAError, zlib.error, OSError, subprocess.CalledProcessError):
        return src
    if out[:4] != b"\x7fELF":
        return src
    with open(dest, "wb") as f:
        f.write(out)
    return dest


class Qmp:
    def __init__(self, path):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(20)
        self.sock.connect(path)
        self.file = self.sock.makefile("rw")
        self.file.readline()
        self.cmd("qmp_capabilities")

    def cmd(self, name, **args):
        self.file.write(json.dumps({"execute": name, "arguments": args}) + "\n")
        self.file.flush()
        while True:
            reply = json.loads(self.file.readline())
            if "return" in reply:
                return reply["return"]
            if "error" in reply:
                raise RuntimeError(reply["error"]["desc"])


class Vnc:
    """Just enough RFB to send SetDesktopSize, which QEMU passes to the display
    device as a hotplug event with a new preferred mode."""

    def __init__(self, path):
        self.sock = s = socket.socket(socket.AF_UNIX)
        s.settimeout(5)
        s.connect(path)
        self.need(12); s.sendall(b"RFB 003.008\n")
        self.need(self.need(1)[0]); s.sendall(b"\x01")          # no authentication
        self.need(4); s.sendall(b"\x01")                        # shared
        init = self.need(24); self.need(struct.unpack(">I", init[20:])[0])
        encodings = (0, -223, -308)                             # raw, size, extended size
        s.sendall(struct.pack(">BxH3i", 2, 3, *encodings))

    def need(self, n):
        data = b""
        while len(data) < n:
            part = self.sock.recv(n - len(data))
            if not part:
                raise RuntimeError("VNC connection closed")
            data += part
        return data

    def resize(self, w, h):
        self.sock.sendall(struct.pack(">BxHHBxIHHHHI", 251, w, h, 1, 0, 0, 0, w, h, 0))
        end = time.time() + 0.5                                 # drain the answers
        while time.time() < end:
            if select.select([self.sock], [], [], 0.1)[0] and not self.sock.recv(65536):
                break


def main():
    ap = argparse.ArgumentParser(usage=__doc__)
    ap.add_argument("-k", "--kernel", required=True)
    ap.add_argument("-i", "--initramfs", required=True)
    ap.add_argument("-o", "--outdir", default=".")
    ap.add_argument("-a", "--arch", default="x86_64", choices=ARCH)
    ap.add_argument("-t", "--timeout", type=float, default=120)
    ap.add_argument("--boot-timeout", type=float, default=60)
    ap.add_argument("-f", "--file", action="append", default=[], metavar="SRC[:DEST]",
                    help="add a file to the guest (no library lookup)")
    ap.add_argument("--accel", default="auto", choices=("auto", "kvm", "tcg"))
    ap.add_argument("--gpu", action="append", default=[],
                    help="-device text of a display (default: virtio-gpu-pci)")
    ap.add_argument("--heads", type=int, default=1, help="heads that 'host resize' can reach")
    ap.add_argument("--smp", type=int, default=min(4, os.cpu_count() or 1))
    ap.add_argument("--mem", default="1G")
    ap.add_argument("--append", default="", help="more kernel arguments")
    ap.add_argument("--qemu-arg", action="append", default=[])
    ap.add_argument("--log", help="guest console (default: OUTDIR/console.log)")
    ap.add_argument("-v", "--verbose", action="store_true")
    ap.add_argument("script", nargs="+", help="guest shell commands")
    a = ap.parse_args()
    spec = ARCH[a.arch]
    qemu = shutil.which(spec["qemu"])
    if not qemu:
        print(f"{spec['qemu']} is not installed", file=sys.stderr)
        return 2
    os.makedirs(a.outdir, exist_ok=True)
    accel = a.accel
    if accel == "auto":
        accel = "kvm" if kvm_usable(a.arch) else "tcg"
    status = run_vm(a, spec, qemu, accel)
    if status is NOT_BOOTED:
        if accel == "kvm" and a.accel == "auto":
            print("no boot with KVM, trying TCG", flush=True)
            status = run_vm(a, spec, qemu, "tcg")
        if status is NOT_BOOTED:
            status = 125
    return status


NOT_BOOTED = object()


def run_vm(a, spec, qemu, accel):
    log = a.log or os.path.join(a.outdir, "console.log")
    t0 = time.time()
    booted = False

    def note(text):
        print(f"[{time.time() - t0:7.2f}] {text}", flush=True)

    with tempfile.TemporaryDirectory() as tmp:
        # The kernel unpacks concatenated archives: the image stays as built, the
        # script and the files of this run follow it, uncompressed.
        initrd = os.path.join(tmp, "initrd")
        kernel = a.kernel
        if accel == "tcg":
            host_copy_initramfs(a.initramfs, initrd)
            if a.arch == "x86_64":
                kernel = host_unpack_kernel(a.kernel, os.path.join(tmp, "vmlinux"))
        else:
            shutil.copyfile(a.initramfs, initrd)
        with open(initrd, "ab") as f:
            f.write(b"\0" * (-f.tell() % 4))
            f.write(cpio_entry("run.sh", ("\n".join(a.script) + "\n").encode(), 0o100644))
            for item in a.file:
                src, _, dest = item.partition(":")
                dest = (dest or "/usr/bin/" + os.path.basename(src)).lstrip("/")
                mode = 0o100755 if os.access(src, os.X_OK) else 0o100644
                with open(src, "rb") as g:
                    f.write(cpio_entry(dest, g.read(), mode))
            f.write(cpio_entry("TRAILER!!!", b"", 0))
        gpus = a.gpu or ["virtio-gpu-pci"]
        cmd = [qemu, "-nodefaults", "-no-user-config", "-no-reboot",
               "-machine", spec["machine"], "-m", a.mem, "-smp", str(a.smp),
               "-kernel", kernel, "-initrd", initrd,
               # Without the kernel's test of the timer, which a busy machine's emulation fails.
               # The kernel's tests of its ciphers take long under emulation, and hung once.
               "-append", f"console={spec['console']} loglevel=5 panic=-1 no_timer_check cryptomgr.notests "
                          f"consoleblank=0 vt.global_cursor_default=0 {a.append}",
               "-serial", "file:" + log,
               "-qmp", f"unix:{tmp}/qmp,server=on,wait=off",
               "-device", "virtio-serial-pci",
               "-chardev", f"socket,id=ctl,path={tmp}/ctl,server=on,wait=off",
               "-device", "virtserialport,chardev=ctl,name=kmsvm",
               "-device", "virtio-keyboard-pci", "-device", "virtio-tablet-pci"]
        if accel == "kvm":
            cmd += ["-accel", "kvm", "-cpu", "host"]
        else:
            cmd += ["-accel", "tcg,thread=multi", "-cpu", spec["tcg_cpu"]]
        for i, gpu in enumerate(gpus):
            cmd += ["-device", f"{gpu},id=gpu{i}"]
        # A VNC server per head on a private socket; nobody else connects to it.
        for head in range(a.heads):
            cmd += ["-vnc", f"unix:{tmp}/vnc{head},display=gpu0,head={head}"]
        cmd += a.qemu_arg
        if a.verbose:
            note(" ".join(cmd))
        proc = subprocess.Popen(cmd, stdin=subprocess.DEVNULL)
        status = None
        vnc = {}
        try:
            for path in ("qmp", "ctl"):
                while not os.path.exists(f"{tmp}/{path}"):
                    if proc.poll() is not None:
                        return NOT_BOOTED
                    time.sleep(0.02)
            qmp = Qmp(f"{tmp}/qmp")
            ctl = socket.socket(socket.AF_UNIX)
            ctl.connect(f"{tmp}/ctl")
            note(f"qemu started, accel={accel}")
            buf = b""
            while status is None:
                left = t0 + a.timeout - time.time()
                if not booted and time.time() - t0 > a.boot_timeout:
                    note("no sign of life; see " + log)
                    return NOT_BOOTED
                if left <= 0:
                    note("timeout")
                    return 124
                if not select.select([ctl], [], [], min(left, 0.5))[0]:
                    if proc.poll() is not None:
                        break
                    continue
                data = ctl.recv(4096)
                if not data:
                    break
                buf += data
                while b"\n" in buf:
                    line, buf = buf.split(b"\n", 1)
                    word = line.decode(errors="replace").split()
                    note("guest: " + " ".join(word))
                    reply = b"ok\n"
                    try:
                        if word[:1] == ["BOOT"]:
                            booted = True
                            continue
                        if word[:1] == ["EXIT"]:
                            status = int(word[1])
                        elif word[:1] == ["shot"]:
                            head = int(word[2]) if len(word) > 2 else 0
                            shoot(qmp, os.path.join(a.outdir, word[1]), head)
                        elif word[:1] == ["resize"]:
                            head = int(word[1])
                            if head not in vnc:
                                vnc[head] = Vnc(f"{tmp}/vnc{head}")
                            vnc[head].resize(int(word[2]), int(word[3]))
                        elif word[:1] == ["click"]:
                            for axis, value in (("x", word[1]), ("y", word[2])):
                                qmp.cmd("input-send-event", events=[
                                    {"type": "abs", "data": {"axis": axis, "value": int(value)}}])
                            for down in (True, False):
                                qmp.cmd("input-send-event", events=[
                                    {"type": "btn", "data": {"button": "left", "down": down}}])
                                time.sleep(0.1)
                        elif word[:1] == ["key"]:
                            hold = {"hold-time": int(word[2])} if len(word) > 2 else {}
                            qmp.cmd("send-key", keys=[{"type": "qcode", "data": word[1]}], **hold)
                    except (RuntimeError, OSError, ValueError) as e:
                        note(f"host error: {e}")
                        reply = f"error {e}\n".encode()
                    ctl.sendall(reply)
        finally:
            if status is not None:
                try:
                    proc.wait(5)
                except subprocess.TimeoutExpired:
                    pass
            if proc.poll() is None:
                proc.kill()
            proc.wait()
        if status is None:
            note("the guest ended without a status; see " + log)
            return 125 if booted else NOT_BOOTED
        note(f"exit {status}")
        return status


def shoot(qmp, base, head):
    try:
        qmp.cmd("screendump", filename=os.path.abspath(base + ".png"), device="gpu0",
                head=head, format="png")
    except RuntimeError:                      # QEMU before 7.1, or built without libpng
        qmp.cmd("screendump", filename=os.path.abspath(base + ".ppm"), device="gpu0", head=head)


if __name__ == "__main__":
    sys.exit(main())
