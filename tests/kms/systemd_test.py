#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The kiosk's unit run by a real systemd: a small Debian on a disk, in QEMU, set up by the very commands of
docs/kiosk.md from what `cmake --install` lays down for the package `karst`.

  systemd_test.py --build DIR --component NAME --bake PROGRAM --console-mode PROGRAM --work DIR
                  [--kills N] [--seconds S]

Packages of the guest are fetched once and kept under DIR. Exit status 77: skipped, with the reason, where the
packages or a tool are not to be had. Standard library only.
"""
import argparse
import glob
import os
import re
import shutil
import subprocess
import sys

import kms_test

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PAGE = os.path.join(ROOT, "docs", "kiosk.md")
# A Debian that boots; what karst needs is named by the page.
SYSTEM = ("linux-image-amd64 busybox-static systemd systemd-sysv udev dbus libpam-systemd libpam-modules "
          "libpam-runtime login passwd adduser perl-base bash dash coreutils util-linux mount kmod "
          "base-files base-passwd libc-bin grep sed procps findutils").split()
TOOLS = kms_test.TOOLS + ["mke2fs", "tar"]
MERGED = ("bin", "sbin", "lib", "lib64")
LEFT_OUT = ("boot", "usr/lib/modules", "usr/share/doc", "usr/share/locale", "usr/share/man", "usr/share/info")
# What Debian's pam-auth-update would write.
PAM = {
    "auth": "[success=1 default=ignore] pam_unix.so nullok",
    "account": "[success=1 new_authtok_reqd=done default=ignore] pam_unix.so",
    "password": "[success=1 default=ignore] pam_unix.so obscure yescrypt",
    "session": "[default=1] pam_permit.so",
}
# What the packages' own scripts would add.
GROUPS = "".join(f"{name}:x:{101 + n}:\n" for n, name in enumerate(("messagebus", "input", "kvm", "render")))
TEST_UNIT = """[Unit]
After=dbus.service systemd-logind.service
[Service]
ExecStart=/bin/bash /run.sh
StandardOutput=file:/dev/ttyS0
StandardError=inherit
[Install]
WantedBy=multi-user.target
"""
SETUP = """export PATH=/usr/sbin:/usr/bin HOME=/
set -ex
systemd-sysusers
pwconv
passwd -d root
systemctl enable getty@tty1 karst-test
systemctl mask serial-getty@ttyS0
cd /setup
"""


def documented():
    """The commands of the page's first block: names of packages, and the lines after apt-get."""
    block = re.search(r"## Setting it up\n(?:[^ \n].*\n|\n)*((?:    .*\n)+)", open(PAGE).read()).group(1)
    lines = [line.strip() for line in block.splitlines()]
    packages = lines[0].split()
    if packages[:2] != ["apt-get", "install"]:
        sys.exit(f"{PAGE}: the first command is not apt-get install")
    # No systemd runs yet when the guest is set up: what is enabled starts at boot.
    return packages[2:], [line.replace("enable --now", "enable") for line in lines[1:]]


def write(path, text):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        out.write(text)


def merge_usr(tree):
    """/bin, /sbin and /lib become links into /usr, as on every Debian."""
    for name in MERGED:
        place = os.path.join(tree, name)
        if os.path.isdir(place) and not os.path.islink(place):
            kms_test.run("cp", "-a", place + "/.", os.path.join(tree, "usr", name))
            shutil.rmtree(place)
        os.makedirs(os.path.join(tree, "usr", name), exist_ok=True)
        if not os.path.islink(place):
            os.symlink("usr/" + name, place)


def make_disk(args, root, commands):
    """A disk with Debian, what the page's commands are about in /setup, and the test."""
    disk_tree = os.path.join(args.work, "disk")
    shutil.rmtree(disk_tree, ignore_errors=True)
    os.makedirs(disk_tree)
    leave = [f"--exclude=./{path}" for path in LEFT_OUT]
    packed = subprocess.Popen(["tar", "-C", root, "-c", *leave, "."], stdout=subprocess.PIPE)
    kms_test.run("tar", "-C", disk_tree, "-xp", stdin=packed.stdout)
    if packed.wait() != 0:
        sys.exit("the guest's files cannot be copied")
    inside = lambda path: os.path.join(disk_tree, path)
    for name, more in (("passwd", ""), ("group", GROUPS)):
        master = open(inside(f"usr/share/base-passwd/{name}.master")).read()
        write(inside("etc/" + name), master + more)
    with open(inside("etc/passwd"), "a") as out:
        out.write("messagebus:x:101:101::/nonexistent:/usr/sbin/nologin\n")
    for kind, first in PAM.items():
        text = f"{kind} {first}\n{kind} requisite pam_deny.so\n{kind} required pam_permit.so\n"
        if kind == "session":
            text += "session required pam_unix.so\nsession optional pam_systemd.so\n"
        write(inside("etc/pam.d/common-" + kind), text)
        if kind == "session":
            write(inside("etc/pam.d/common-session-noninteractive"), text)
    write(inside("etc/machine-id"), "0123456789abcdef0123456789abcdef\n")
    write(inside("etc/hostname"), "kiosk\n")
    write(inside("etc/systemd/system/karst-test.service"), TEST_UNIT)
    shutil.copy(os.path.join(HERE, "guest/systemd.sh"), inside("systemd.sh"))
    shutil.copy(args.console_mode, inside("usr/bin/console_mode"))

    installed = os.path.join(args.work, "installed")
    shutil.rmtree(installed, ignore_errors=True)
    kms_test.run("cmake", "--install", args.build, "--component", args.component, "--prefix", "/usr",
                 "--strip", env={**os.environ, "DESTDIR": installed}, stdout=subprocess.DEVNULL)
    setup = inside("setup")
    os.makedirs(os.path.join(setup, "boards/kiosk"))
    shutil.copy(os.path.join(installed, "usr/bin/karst"), setup)
    shutil.copy(os.path.join(installed, "usr/share/doc/karst/examples/karst-kiosk.service"),
                os.path.join(setup, "boards/kiosk"))
    kms_test.run(args.bake, "--sample", "canyon", "--no-ground", "--voxel", "40", "--levels", "1", "-o",
                 os.path.join(setup, "canyon.karst"), stdout=subprocess.DEVNULL)
    write(inside("srv/karst/flight.txt"), "60 70 60 85 5\n60 70 60 95 5\n")
    write(inside("setup.sh"), SETUP + "\n".join(commands) + "\n")
    image = os.path.join(args.work, "disk.img")
    if os.path.exists(image):
        os.remove(image)
    mke2fs = shutil.which("mke2fs", path=os.environ["PATH"] + ":/usr/sbin:/sbin")
    kms_test.run(mke2fs, "-q", "-t", "ext4", "-E", "root_owner=0:0", "-d", disk_tree, image, "1G")
    shutil.rmtree(disk_tree)
    return image


def prepare(args):
    """The kernel, an image that hands over to a disk, and the disk."""
    for tool in TOOLS:
        if not shutil.which(tool, path=os.environ["PATH"] + ":/usr/sbin:/sbin"):
            raise kms_test.Skip(f"{tool} is not installed")
    needed, commands = documented()
    root = kms_test.fetch(args.work, SYSTEM + needed)
    merge_usr(root)
    modules = glob.glob(os.path.join(root, "usr/lib/modules/*"))[0]
    image = os.path.join(args.work, "initramfs.img")
    kms_test.run(os.path.join(HERE, "make_initramfs.sh"), "-n", "-k", modules, "-o", image, "-s", root, "-m",
                 "virtio_pci virtio_console virtio-gpu virtio_input evdev virtio_blk crc32c_generic ext4")
    return glob.glob(os.path.join(root, "boot/vmlinuz-*"))[0], image, make_disk(args, root, commands)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--build", required=True)
    parser.add_argument("--component", required=True)
    parser.add_argument("--bake", required=True)
    parser.add_argument("--console-mode", required=True, help="the helper that looks at the terminal")
    parser.add_argument("--work", required=True)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seconds", type=int, default=900)
    args = parser.parse_args()
    args.case = "systemd"
    prepared = kms_test.run_alone(args, lambda: prepare(args))
    if prepared is None:
        return kms_test.SKIPPED
    kernel, image, disk = prepared
    out = kms_test.boot(args, kernel, image, f"set -- {args.kills}; . /systemd.sh", args.seconds, (
        "--append=kmsvm.root=/dev/vda rw", "--mem=1G", "--qemu-arg=-drive",
        f"--qemu-arg=file={disk},format=raw,if=virtio,cache=unsafe"))
    picture = kms_test.load_png(os.path.join(out, "unit.png"))
    colours = {row[x:x + 3] for row in picture[2] for x in range(0, 3 * picture[0], 3)}
    black = kms_test.black_share(picture)
    print(f"== the unit's picture: {len(colours)} colours, {100 * black:.0f} % black")
    if len(colours) < 100 or black > 0.1:
        sys.exit("the screen shows no terrain")
    kms_test.expect_console("after the unit", os.path.join(out, "console.png"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
