# SPDX-License-Identifier: MIT
"""Small files that ask for much, or are wrong in one place."""

import random
import struct
import zlib


def png(path, width, height, bits, colour, row, compressed=9):
    """A PNG all of whose rows are the same; row: its bytes, or a function of its number."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    packer = zlib.compressobj(compressed)
    data = b"".join(packer.compress(b"\0" + (row(y) if callable(row) else row)) for y in range(height))
    data += packer.flush()
    head = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def tiled_tiff(path, width, height, tile, channels, bits, tile_bytes):
    """A TIFF of one tile that is deflated zeros; tile_bytes: how many of them are really there."""
    data = zlib.compress(bytes(tile_bytes), 9)
    entries = [(256, 4, 1, width), (257, 4, 1, height), (258, 3, 1, bits), (259, 3, 1, 8), (262, 3, 1, 1),
               (277, 3, 1, channels), (322, 4, 1, tile), (323, 4, 1, tile), (324, 4, 1, 0),
               (325, 4, 1, len(data)), (339, 3, 1, 1)]
    start = 8 + 2 + 12 * len(entries) + 4
    directory = struct.pack("<H", len(entries))
    for tag, kind, count, value in entries:
        value = start if tag == 324 else value
        directory += struct.pack("<HHI", tag, kind, count)
        directory += struct.pack("<HH", value, 0) if kind == 3 else struct.pack("<I", value)
    with open(path, "wb") as out:
        out.write(b"II*\0" + struct.pack("<I", 8) + directory + bytes(4) + data)


def envi(path, width, height, sample):
    """Heights of 16 bits with their header; sample(x, y) is one."""
    with open(f"{path}.bil", "wb") as out:
        for y in range(height):
            out.write(struct.pack(f"<{width}h", *(sample(x, y) for x in range(width))))
    with open(f"{path}.hdr", "w", encoding="ascii") as out:
        out.write(f"ENVI\nsamples = {width}\nlines = {height}\nbands = 1\ndata type = 2\nbyte order = 0\n"
                  "interleave = bsq\n")


def noise(most, seed=3):
    numbers = random.Random(seed)
    return lambda x, y: numbers.randint(-most, most)


TABLE = []
for byte in range(256):
    for _ in range(8):
        byte = (byte >> 1) ^ (0x82F63B78 if byte & 1 else 0)
    TABLE.append(byte)


def crc32c(data, crc=0):
    crc ^= 0xFFFFFFFF
    for byte in data:
        crc = TABLE[(crc ^ byte) & 255] ^ (crc >> 8)
    return crc ^ 0xFFFFFFFF


def crc32c_of_zeros(count):
    """By squaring the matrix of what one zero byte does."""
    def times(matrix, vector):
        result = 0
        for k in range(32):
            if vector >> k & 1:
                result ^= matrix[k]
        return result
    step = [TABLE[(1 << k) & 255] ^ (1 << k >> 8) for k in range(32)]
    crc = 0xFFFFFFFF
    while count:
        if count & 1:
            crc = times(step, crc)
        count >>= 1
        step = [times(step, column) for column in step]
    return crc ^ 0xFFFFFFFF


def zero_world(path, octets, patches, extra=()):
    """A world file with a right head, whose sections are holes: half a gigabyte that takes no room on a disk.
    extra: (letters, bytes) of sections behind those that every world has."""
    sizes = [(b"OCTR", 2 * octets + 1), (b"PKEY", 8 * patches), (b"HMSK", (patches + 7) // 8), (b"HGTS", 0),
             (b"HCRC", 0), (b"LERR", 0), (b"PBND", 12 * patches), (b"CONE", 4 * patches),
             (b"SCON", 4 * patches)]
    required = len(sizes)
    sizes += extra
    end = 192 + 32 * len(sizes)
    table = b""
    for number, (letters, size) in enumerate(sizes):
        start = (end + 63) // 64 * 64
        table += letters
        table += struct.pack("<IQQII", int(number < required), start, size, crc32c_of_zeros(size), 0)
        end = start + size
    head = bytearray(192)
    head[0:8] = b"KARST\x1a\r\n"
    struct.pack_into("<IIQI", head, 8, 5, 192 + len(table), end, len(sizes))
    struct.pack_into("<d", head, 32, 1.0)
    struct.pack_into("<3i", head, 64, 512, 511, 512)
    struct.pack_into("<iiIIII", head, 76, 9, 1, octets, patches // 2, patches, 0)
    whole = bytes(head) + table
    crc = crc32c(whole[32:], crc32c(whole[:28]))
    with open(path, "wb") as out:
        out.write(whole[:28] + struct.pack("<I", crc) + whole[32:])
        out.truncate(end)
