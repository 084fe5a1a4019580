#!/bin/bash
# SPDX-License-Identifier: MIT
# Build a self-contained initramfs for KMS tests: busybox, kernel modules,
# Mesa (software) and the given programs with every library they need.
#
#   make_initramfs.sh -k MODDIR -o OUT [-m "mod ..."] [-s SYSROOT] [-t TRIPLET]
#                     [-b BUSYBOX] [-n] FILE[:DEST] ...
#
#   -k MODDIR   lib/modules/VERSION of the guest kernel
#   -o OUT      image to write (zstd-compressed cpio)
#   -m MODULES  modules to load, in order (dependencies are added)
#   -s SYSROOT  take libraries from here (another architecture, or an unpacked tree)
#   -t TRIPLET  multiarch triplet (default: the compiler's / x86_64-linux-gnu)
#   -b BUSYBOX  static busybox of the guest architecture
#   -n          no Mesa
#   FILE        a program, library or data file; DEST defaults to /usr/bin/NAME
#
# Needs: binutils (readelf), cpio, zstd, kmod (modinfo), busybox-static.
set -euo pipefail

mods="virtio_pci virtio_mmio virtio_console virtio-gpu bochs virtio_input evdev"
sysroot="" triplet="" busybox="" mesa=1 moddir="" out=""
while getopts k:o:m:s:t:b:n opt; do
  case $opt in
    k) moddir=$OPTARG;; o) out=$OPTARG;; m) mods=$OPTARG;; s) sysroot=${OPTARG%/};;
    t) triplet=$OPTARG;; b) busybox=$OPTARG;; n) mesa=0;;
    *) sed -n '3,18p' "$0" >&2; exit 2;;
  esac
done
shift $((OPTIND - 1))
[ -n "$moddir" ] && [ -n "$out" ] || { sed -n '3,18p' "$0" >&2; exit 2; }
: "${triplet:=$(gcc -print-multiarch 2>/dev/null || echo x86_64-linux-gnu)}"
if [ -z "$busybox" ]; then
  for b in "$sysroot"/bin/busybox "$sysroot"/usr/bin/busybox; do
    [ -x "$b" ] && busybox=$b && break
  done
fi
[ -x "$busybox" ] || { echo "no busybox (package busybox-static)" >&2; exit 1; }

root=$(mktemp -d)
chmod 755 "$root"                # it becomes / of the guest
trap 'rm -rf "$root"' EXIT
mkdir -p "$root"/{usr/{bin,lib,lib64,share},dev,proc,sys,run,etc,modules}
for d in bin lib lib64; do ln -s usr/$d "$root/$d"; done
ln -s usr/bin "$root/sbin"; ln -s bin "$root/usr/sbin"

# --- shared libraries -------------------------------------------------------
libdirs=("$sysroot/usr/lib/$triplet" "$sysroot/lib/$triplet" "$sysroot/usr/lib" "$sysroot/lib")
declare -A seen=()
find_lib() {
  local d
  for d in "${libdirs[@]}"; do [ -e "$d/$1" ] && { echo "$d/$1"; return 0; }; done
  return 1
}
add_deps() {                     # every DT_NEEDED of an ELF file, recursively
  local so path interp
  case $(head -c4 "$1" | tr -d '\0') in $'\x7fELF') ;; *) return 0;; esac
  interp=$(readelf -lW "$1" 2>/dev/null | sed -n 's/.*interpreter: \(.*\)\]/\1/p')
  if [ -n "$interp" ] && [ -z "${seen[$interp]:-}" ]; then
    seen[$interp]=1
    path=$sysroot$interp
    [ -e "$path" ] || path=$(find_lib "${interp##*/}")
    mkdir -p "$root/usr${interp%/*}"
    cp -L "$path" "$root/usr$interp"
  fi
  for so in $(readelf -dW "$1" 2>/dev/null | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p'); do
    [ -n "${seen[$so]:-}" ] && continue
    seen[$so]=1
    case $so in ld-linux*) continue;; esac
    path=$(find_lib "$so") || { echo "missing library $so (needed by $1)" >&2; exit 1; }
    mkdir -p "$root/usr/lib/$triplet"
    cp -L "$path" "$root/usr/lib/$triplet/$so"
    add_deps "$path"
  done
}
add_file() {                     # SRC DEST
  mkdir -p "$root$(dirname "$2")"
  cp -L "$1" "$root$2"
  add_deps "$1"
}

if [ $mesa = 1 ]; then
  # What EGL/GBM load with dlopen, so that DT_NEEDED does not show it.
  for so in libEGL.so.1 libGLESv2.so.2 libgbm.so.1 libEGL_mesa.so.0; do
    path=$(find_lib $so) || { echo "missing $so" >&2; exit 1; }
    add_file "$path" "/usr/lib/$triplet/$so"
  done
  add_file "$sysroot/usr/share/glvnd/egl_vendor.d/50_mesa.json" \
           /usr/share/glvnd/egl_vendor.d/50_mesa.json
  mkdir -p "$root/usr/lib/$triplet/dri"
  first=""
  for drv in kms_swrast swrast virtio_gpu; do    # one file under several names
    src=$sysroot/usr/lib/$triplet/dri/${drv}_dri.so
    [ -e "$src" ] || continue
    if [ -n "$first" ] && cmp -s "$src" "$first"; then
      ln "$root/usr/lib/$triplet/dri/${first##*/}" "$root/usr/lib/$triplet/dri/${drv}_dri.so"
    else
      add_file "$src" "/usr/lib/$triplet/dri/${drv}_dri.so"; first=$src
    fi
  done
  for src in "$sysroot/usr/lib/$triplet"/gbm/*.so; do     # Mesa 24.3 and later
    [ -e "$src" ] && add_file "$src" "/usr/lib/$triplet/gbm/${src##*/}"
  done
fi
libgcc=$(find_lib libgcc_s.so.1) && add_file "$libgcc" "/usr/lib/$triplet/libgcc_s.so.1"

# --- programs and data ------------------------------------------------------
for f in "$@"; do
  src=${f%%:*} dest=${f#*:}
  [ "$dest" = "$f" ] && dest=/usr/bin/${src##*/}
  add_file "$src" "$dest"
done

# --- kernel modules, in load order ------------------------------------------
add_module() {
  local name=${1//-/_} file dep
  [ -n "${seen[mod:$name]:-}" ] && return 0
  seen[mod:$name]=1
  file=$(find "$moddir" -name "${name//_/[-_]}.ko*" | head -n1)
  [ -n "$file" ] || { echo "note: no module $name (built in?)" >&2; return 0; }
  for dep in $(modinfo -F depends "$file" | tr ',' ' '); do add_module "$dep"; done
  case $file in
    *.zst) zstd -dcq "$file" > "$root/modules/$name.ko";;
    *.xz)  xz -dc "$file" > "$root/modules/$name.ko";;
    *.gz)  gzip -dc "$file" > "$root/modules/$name.ko";;
    *)     cp "$file" "$root/modules/$name.ko";;
  esac
  echo "$name" >> "$root/modules/order"
}
touch "$root/modules/order"
for m in $mods; do add_module "$m"; done

# --- /init ------------------------------------------------------------------
cp "$busybox" "$root/usr/bin/busybox"
printf 'root:x:0:0::/run:/bin/sh\nkiosk:x:1000:1000::/run:/bin/sh\n' > "$root/etc/passwd"
printf 'root:x:0:\nvideo:x:44:\nkiosk:x:1000:\n' > "$root/etc/group"
cat > "$root/init" <<'INIT'
#!/bin/busybox sh
# PID 1 of the test guest. Runs /run.sh (appended by the runner), reports its
# status on the control port, powers off. With kmsvm.root=DEVICE: hands over to
# the system on that disk, after its /setup.sh; that system runs /run.sh itself.
/bin/busybox --install -s /bin
export PATH=/usr/bin HOME=/run XDG_RUNTIME_DIR=/run
mount -t devtmpfs dev /dev; mount -t proc proc /proc; mount -t sysfs sys /sys
mkdir -p /dev/pts /dev/shm; mount -t devpts pts /dev/pts
chmod 1777 /run /dev/shm
ln -s /proc/self/fd /dev/fd
exec </dev/console >/dev/console 2>&1
skip=" $(sed -n 's/.*kmsvm.skip=\([^ ]*\).*/\1/p' /proc/cmdline | tr , ' ') "
while read -r m; do
  case $skip in *" $m "*) continue;; esac
  # insmod does not read MODULE.PARAM=VALUE from the kernel command line.
  insmod /modules/$m.ko $(tr ' ' '\n' </proc/cmdline | sed -n "s/^$m\.//p")
done < /modules/order
i=0; while [ ! -e /dev/dri/card0 ] && [ $i -lt 50 ]; do sleep 0.1; i=$((i+1)); done
i=0; while ! ls /dev/vport* >/dev/null 2>&1 && [ $i -lt 20 ]; do sleep 0.1; i=$((i+1)); done
disk=$(sed -n 's/.*kmsvm.root=\([^ ]*\).*/\1/p' /proc/cmdline)
if [ -n "$disk" ]; then
  mkdir /disk; mount -t ext4 "$disk" /disk || poweroff -f
  # An image that was made without root has the files of whoever made it.
  [ "$(stat -c %u /disk/etc)" = 0 ] || chown -hR 0:0 /disk
  cp /run.sh /disk/
  umount /dev/pts
  for d in dev proc sys; do mount --move /$d /disk/$d; done
  chroot /disk /bin/sh /setup.sh || { echo "setup fails"; poweroff -f; }
  exec switch_root /disk /sbin/init
fi
ctl=$(ls /dev/vport* 2>/dev/null | head -n1)
exec 3<>"${ctl:-/dev/console}"
echo "BOOT $(cut -d' ' -f1 /proc/uptime)" >&3
status=126                               # no script: too little memory to unpack
if [ -f /run.sh ]; then sh /run.sh; status=$?; fi
echo "EXIT $status" >&3
echo "kmsvm exit $status"
i=0; read -r -t 2 _ <&3                 # let the host read the line
poweroff -f
INIT
# Guest helpers: each asks the host over fd 3 and waits for its answer.
cat > "$root/usr/bin/host" <<'HOST'
#!/bin/busybox sh
# host shot NAME [HEAD] | host resize HEAD WIDTH HEIGHT | host mark TEXT
echo "$*" >&3
read -r reply <&3
[ "$reply" = ok ] || { echo "host: $* -> $reply" >&2; exit 1; }
HOST
cat > "$root/usr/bin/waitfor" <<'WAITFOR'
#!/bin/busybox sh
# waitfor FILE REGEX [SECONDS]: until a line of FILE matches. Never sleep a fixed
# time before a screenshot: an emulated guest may be 20 times slower.
i=0
while ! grep -qE "$2" "$1" 2>/dev/null; do
  i=$((i+1)); [ $i -gt $((${3:-60} * 10)) ] && { echo "waitfor: no '$2' in $1" >&2; exit 1; }
  sleep 0.1
done
WAITFOR
chmod 755 "$root/init" "$root/usr/bin/host" "$root/usr/bin/waitfor"

mkdir -p "$(dirname "$out")"
(cd "$root" && find . | LC_ALL=C sort | cpio --quiet -o -H newc -R 0:0) |
  zstd -q -T0 -"${ZSTD_LEVEL:-6}" -f -o "$out"
echo "$out: $(($(stat -c %s "$out") / 1024)) KiB, unpacked $(du -sk "$root" | cut -f1) KiB"
