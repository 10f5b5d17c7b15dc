"""Bytes that are damaged: anywhere, or where a format has its sizes."""

from __future__ import annotations

import math
import random
import re
import struct
import zlib

EXTREMES = (0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF)
_TEXT_BITS: tuple[bytes, ...] = (
    b"\x00",
    b"\xff",
    b"\xef\xbb\xbf",
    b"\x1b[31m",
    "é٣\u202e\u2028".encode(),
    b"\r",
    b"\n",
    b"\t",
    b'"',
    b"'",
    b"#",
)
_TEXT_BITS += (
    b",",
    b";",
    b":",
    b"-",
    b"nan",
    b"inf",
    b"1e400",
    b"-1",
    b"9" * 5000,
    b"\xed\xa0\x80",
    b"<!DOCTYPE x>",
    b"&x;",
)


def damaged_bytes(rng: random.Random, content: bytes) -> bytes:
    """Bytes that are cut off, flipped, repeated, or replaced."""
    for _ in range(1 + (rng.random() < 0.3)):
        content = _once(rng, content)
    return content


def _once(rng: random.Random, content: bytes) -> bytes:  # noqa: PLR0911  # one for each way
    at = rng.randrange(len(content) + 1)
    near = rng.randrange(min(64, len(content)) + 1)
    match rng.randrange(8):
        case 0:
            return content[:at]
        case 1:
            return content[:near]
        case 2:
            at = rng.choice((at, near))
            return content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]
        case 3:
            return content[:at] + content[at + rng.randrange(1, 50) :]
        case 4:
            return content[:at] + content[max(0, at - rng.randrange(1, 50)) :]
        case 5:
            number = _binary_number(rng)
            at = rng.choice((at, near))
            at -= rng.choice((0, at % 4))
            return content[:at] + number + content[at + len(number) :]
        case 6:
            return content[at:]
    return rng.choice((b"", b"\x00" * 100, content * 2, content[::-1], rng.randbytes(100)))


def _binary_number(rng: random.Random) -> bytes:
    order = rng.choice("<>")
    if rng.random() < 0.5:
        form = rng.choice("HI")
        return struct.pack(order + form, rng.choice(EXTREMES) & (0xFFFF if form == "H" else 0xFFFFFFFF))
    form = rng.choice("fd")
    numbers = [0.0, -0.0, 1e-40, 1e30, 1e37, -1e37, math.nan, math.inf, -math.inf, 1000.0]
    return struct.pack(order + form, rng.choice(numbers + [1e200, 5e-324] * (form == "d")))


def damaged_headed(rng: random.Random, content: bytes, header: bytes) -> bytes:
    """A file of which the text up to the end of `header` is damaged, or the bytes after it."""
    start, end, body = content.partition(header)
    if rng.random() < 0.5:
        return damaged_text(rng, start + end) + body
    return start + end + damaged_bytes(rng, body)


def damaged_text(rng: random.Random, content: bytes) -> bytes:  # noqa: PLR0911  # one for each way
    """Text with letters, numbers or lines that do not belong there, in another encoding, or damaged as any bytes."""
    at = rng.randrange(len(content) + 1)
    lines = content.split(b"\n")
    match rng.randrange(9):
        case 0 | 1:
            return content[:at] + rng.choice(_TEXT_BITS) + content[at:]
        case 2 | 3:
            return _other_number(rng, content)
        case 4:
            return content.decode("utf-8", "replace").encode(
                rng.choice(("utf-16", "utf-32", "utf-7", "latin-1", "utf-8-sig")), "replace"
            )
        case 5:
            del lines[rng.randrange(len(lines))]
            return b"\n".join(lines)
        case 6:
            lines.insert(rng.randrange(len(lines)), rng.choice(lines))
            return b"\n".join(lines)
        case 7:
            return content.replace(b"\n", rng.choice((b"\r\n", b"\r", b"\n\n", b"\x0b", b"")))
    return damaged_bytes(rng, content)


_NUMBER = re.compile(rb"[-+]?[0-9][0-9.]*(?:[eE][-+]?[0-9]+)?")


def _thousandfold(number: re.Match[bytes]) -> bytes:
    """The number of millimetres for one of metres."""
    try:
        return b"%g" % (1000 * float(number[0]))
    except ValueError:  # 1.2.3
        return number[0]


def _other_number(rng: random.Random, content: bytes) -> bytes:
    found = list(_NUMBER.finditer(content))
    if not found:
        return content + b"1"
    if rng.random() < 0.1:
        return _NUMBER.sub(_thousandfold, content)
    one = rng.choice(found)
    if rng.random() < 0.1:
        return content[: one.start()] + _thousandfold(one) + content[one.end() :]
    numbers = (
        b"1e",
        b"1e37",
        b"-1e37",
        b"1e-320",
        b"-0",
        b"0x1p3",
        b"0x10",
        b"inf",
        b"1.2.3",
        b"1_0",
        b"1,5",
        "٣".encode(),
        b"0",
        b"-1",
        b"1e400",
        b"nan",
        b"99999999999999999999",
        b"9" * 5000,
        b"0.1",
        b"x",
        b"",
        b"4294967296",
        b"5",
        b"32767",
    )
    return content[: one.start()] + rng.choice(numbers) + content[one.end() :]


def damaged_png(rng: random.Random, content: bytes) -> bytes:
    """A PNG with another header, or with chunks lost, repeated, moved or too long, all with the right checksums."""
    chunks, at = [], 8
    while at + 12 <= len(content):
        (size,) = struct.unpack(">I", content[at : at + 4])
        chunks.append((content[at + 4 : at + 8], content[at + 8 : at + 8 + size]))
        at += 12 + size
    number = rng.randrange(len(chunks))
    name, data = chunks[number]
    match rng.randrange(6):
        case 0 | 1:
            header = bytearray(chunks[0][1])
            place = rng.choice((0, 4))
            header[place : place + 4] = struct.pack(">I", rng.choice(EXTREMES)) if rng.random() < 0.6 else bytes(4)
            if rng.random() < 0.5:
                header[rng.randrange(8, 13)] = rng.choice((0, 1, 2, 3, 4, 6, 7, 8, 16, 255))
            chunks[0] = (chunks[0][0], bytes(header))
        case 2:
            del chunks[number]
        case 3:
            chunks.insert(number, rng.choice(chunks))
        case 4:
            name = rng.choice((b"tRNS", b"PLTE", b"iCCP", b"zTXt", b"iTXt", b"acTL", b"fdAT", b"eXIf", b"gAMA", name))
            chunks.insert(
                number,
                (name, rng.choice((b"", data[:7], rng.randbytes(30), b"x\0\0" + zlib.compress(bytes(9_000_000))))),
            )
        case _:
            chunks[number] = (name, damaged_bytes(rng, data))
    return content[:8] + b"".join(_chunk(rng, *chunk) for chunk in chunks)


def _chunk(rng: random.Random, name: bytes, data: bytes) -> bytes:
    size = rng.choice(EXTREMES) if rng.random() < 0.02 else len(data)
    return struct.pack(">I", size) + name + data + struct.pack(">I", zlib.crc32(name + data))


def damaged_tiff(rng: random.Random, content: bytes) -> bytes:
    """A TIFF with another value, type, count or name of a tag."""
    order = "<" if content[:2] == b"II" else ">"
    (at,) = struct.unpack(order + "I", content[4:8])
    (tags,) = struct.unpack(order + "H", content[at : at + 2])
    place = at + 2 + 12 * rng.randrange(max(tags, 1))
    offset, form = rng.choice(((0, "H"), (2, "H"), (4, "I"), (8, "I")))
    number = struct.pack(
        order + form, rng.choice((*EXTREMES, 3, 4, 5, 8, 16, 17, 32)) & (0xFFFF if form == "H" else 0xFFFFFFFF)
    )
    place += offset
    return content[:place] + number + content[place + len(number) :]


def damaged_npy(rng: random.Random, content: bytes) -> bytes:
    """A NPY with another header: type, shape, order, or its length."""
    (size,) = struct.unpack("<H", content[8:10])
    header = content[10 : 10 + size].decode("latin-1")
    shapes = (
        "(2,)",
        "()",
        "(-1, 4)",
        "(4, -1)",
        "(10**9, 10**9)",
        "(1000000000, 1000000000)",
        "(4, 4, 1)",
        "(0, 4)",
        "4",
        "(4.0, 4)",
        "(True, 4)",
        "(99999999999999999999999, 1)",
        "(4096, 4097)",
        "(4, 5)",
        "[4, 4]",
    )
    types = (
        "|O",
        "<f2",
        "<f4",
        ">f8",
        "<i1",
        "<u8",
        "|b1",
        "<c16",
        "|S8",
        "<U4",
        "<M8[s]",
        "|V8",
        "[('a', '<f8')]",
        "<f16",
        "x",
        "<i99",
        "é",
    )
    match rng.randrange(6):
        case 0 | 1:
            header = re.sub(r"'shape': \([^)]*\)", lambda _: f"'shape': {rng.choice(shapes)}", header)
        case 2:
            header = re.sub(
                r"'descr': '[^']*'",
                lambda _: f"'descr': {rng.choice(types)!r}".replace('"[', "[").replace(']"', "]"),
                header,
            )
        case 3:
            header = header.replace("False", rng.choice(("True", "1", "None", "__import__('os')", "[]*9**9")))
        case 4:
            header = rng.choice(
                (
                    "",
                    "{}",
                    "[" * 3000,
                    "{'shape': (4, 4)}",
                    header * 30,
                    "(" * 90 + ")" * 90,
                    "1" * 5000,
                    header[:-3],
                    "\0" * 80,
                )
            )
        case _:
            return content[:6] + bytes([rng.randrange(5), rng.randrange(3)]) + damaged_bytes(rng, content[8:])
    header = header.rstrip() + " " * (-(len(header.rstrip()) + 11) % 64) + "\n"
    size = rng.choice(EXTREMES) & 0xFFFF if rng.random() < 0.1 else len(header) & 0xFFFF
    return (
        content[:8]
        + struct.pack("<H", size)
        + header.encode("utf-8")
        + content[10 + struct.unpack("<H", content[8:10])[0] :]
    )
