"""Reads the channels of the EXR files that kagero writes: scan lines, ZIP compression."""
import struct
import zlib

import numpy as np

LINES_PER_BLOCK = 16


def read_exr(path):
    """Returns a dict of arrays (height, width) by channel name, float16 or float32 as in the file."""
    with open(path, "rb") as file:
        data = file.read()
    assert struct.unpack_from("<ii", data) == (20000630, 2)  # one part, scan lines
    attributes, at = {}, 8
    while data[at]:
        name, at = text_at(data, at)
        _, at = text_at(data, at)
        size, = struct.unpack_from("<i", data, at)
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    assert attributes["compression"] == b"\3"
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    channels, i = [], 0
    while attributes["channels"][i]:
        name, i = text_at(attributes["channels"], i)
        kind, = struct.unpack_from("<i", attributes["channels"], i)
        channels.append((name, np.dtype({1: "<f2", 2: "<f4"}[kind])))
        i += 16
    layers = {name: np.empty((height, width), kind) for name, kind in channels}
    blocks = -(-height // LINES_PER_BLOCK)
    for offset in struct.unpack_from(f"<{blocks}q", data, at + 1):
        first, size = struct.unpack_from("<ii", data, offset)
        lines = range(first - y0, min(first - y0 + LINES_PER_BLOCK, height))
        full = len(lines) * width * sum(kind.itemsize for _, kind in channels)
        block = data[offset + 8:offset + 8 + size]
        block = block if size == full else decompressed(block)
        at_line = 0
        for y in lines:
            for name, kind in channels:
                layers[name][y] = np.frombuffer(block, kind, width, at_line)
                at_line += width * kind.itemsize
    return layers


def text_at(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def decompressed(block):
    """Returns the bytes of a block: their differences are stored, those with even indices first."""
    steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    steps[1:] -= 128
    halves = np.cumsum(steps).astype(np.uint8)
    full = np.empty_like(halves)
    middle = (len(halves) + 1) // 2
    full[0::2], full[1::2] = halves[:middle], halves[middle:]
    return full.tobytes()
