"""A file that grows block by block: whatever ends a run, at whichever byte, whole blocks are read.

A block is the number of its bytes and their CRC-32, two unsigned 32-bit numbers, little-endian, then the
bytes.
"""

import struct
import zlib
from collections.abc import Iterator
from typing import BinaryIO

HEAD = struct.Struct("<II")
BLOCK_BYTES = 64_000_000
"""Largest block that is read: a picture of any camera, a state of any world."""
FILE_BYTES = 1_000_000_000
"""Largest file that is read."""


def block(data: bytes) -> bytes:
    """The bytes of a file that hold `data`."""
    return HEAD.pack(len(data), zlib.crc32(data)) + data


def blocks(file: BinaryIO) -> Iterator[bytes]:
    """The data of each block from here on, up to the first that is not whole."""
    while len(head := file.read(HEAD.size)) == HEAD.size:
        length, checksum = HEAD.unpack(head)
        if length > BLOCK_BYTES or len(data := file.read(length)) < length or zlib.crc32(data) != checksum:
            return
        yield data
