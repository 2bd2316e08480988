# SPDX-License-Identifier: Apache-2.0
"""Renders by the program, and their means over regions."""

import json
import os
import struct
import subprocess
import tempfile
import zlib

import numpy

REGION = (8, 9)  # pixels, width and height


class Refused(Exception):
    """The program ended with an error; its message."""


def run(nephos, *arguments):
    """Output of a command, its CPU seconds, and its messages."""
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as messages:
        done = subprocess.Popen([nephos, *map(str, arguments)], stdout=out, stderr=messages)
        _, status, used = os.wait4(done.pid, 0)
        done.returncode = os.waitstatus_to_exitcode(status)
        out.seek(0)
        messages.seek(0)
        text, said = out.read(), messages.read()
    if done.returncode != 0:
        raise Refused(said.strip().splitlines()[-1] if said.strip() else f"exit {done.returncode}")
    return text, used.ru_utime + used.ru_stime, said


def calibrate(nephos, machine):
    """Measures this machine into a file of factors on predicted seconds; the messages."""
    return run(nephos, "report", "--calibrate", "-o", machine, "-v", "-v")[2]


LINES = {0: 1, 2: 1, 3: 16}  # scan lines of a chunk by compression: none, ZIPS, ZIP


def read_header(data):
    """Attributes of an OpenEXR file by name, and where its table of chunks begins."""
    at, attributes = 8, {}
    while data[at]:
        end = data.index(0, at)
        name, at = data[at:end].decode(), data.index(0, end + 1) + 1
        size = struct.unpack_from("<i", data, at)[0]
        attributes[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return attributes, at + 1


def unpack(chunk, size):
    """Bytes of a chunk: inflated, summed up, and its two halves interleaved."""
    if len(chunk) == size:
        return chunk
    deltas = numpy.frombuffer(zlib.decompress(chunk), numpy.uint8).astype(numpy.int64)
    deltas[1:] -= 128
    sums = numpy.cumsum(deltas).astype(numpy.uint8)
    out = numpy.empty(size, numpy.uint8)
    out[0::2], out[1::2] = sums[:(size + 1) // 2], sums[(size + 1) // 2:]
    return out.tobytes()


def read_exr(path):
    """Channels of a scan-line OpenEXR picture of floats and halves as float32 arrays, by name."""
    with open(path, "rb") as file:
        data = file.read()
    attributes, table = read_header(data)
    channels, names, place = attributes["channels"], [], 0
    while channels[place]:
        end = channels.index(0, place)
        names.append((channels[place:end].decode(), "<f2" if channels[end + 1] == 1 else "<f4"))
        place = end + 17
    x0, y0, x1, y1 = struct.unpack("<4i", attributes["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = LINES[attributes["compression"][0]]
    line_bytes = width * sum(int(kind[-1]) for _, kind in names)
    out = {name: numpy.empty((height, width), numpy.float32) for name, _ in names}
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, table):
        first, size = struct.unpack_from("<ii", data, offset)
        count = min(lines, y1 + 1 - first)
        pixels, place = unpack(data[offset + 8:offset + 8 + size], count * line_bytes), 0
        for row in range(first - y0, first - y0 + count):
            for name, kind in names:
                out[name][row] = numpy.frombuffer(pixels, kind, width, place)
                place += width * int(kind[-1])
    return out


def render(nephos, scene, image, *arguments):
    """R, G, B and A of a picture, its facts, and CPU seconds. A picture that is there is read again."""
    facts = image + ".json"
    if not (os.path.exists(image) and os.path.exists(facts)):
        text, seconds, messages = run(nephos, "render", scene, "-o", image, "--json", "--progress", "none", "-q",
                            "--set", "output.alpha=clouds", *arguments)
        with open(facts, "w") as file:
            json.dump({**json.loads(text), "cpu_seconds": seconds, "messages": messages}, file)
    with open(facts) as file:
        known = json.load(file)
    channels = read_exr(image)
    return numpy.stack([channels[c] for c in "RGB"], -1), channels["A"], known


def compute_regions(picture):
    """Means over regions, one row each."""
    width, height = REGION
    rows, columns = picture.shape[0] // height, picture.shape[1] // width
    picture = picture[:rows * height, :columns * width]
    shape = (rows, height, columns, width) + picture.shape[2:]
    means = picture.astype(numpy.float64).reshape(shape).mean((1, 3))
    return means.reshape((rows * columns,) + picture.shape[2:])
