"""Arrays as .npz: written whole, also as a stream, and read only where the headers are what they should be.

What a file says of itself is checked before any array is made: a header of a few bytes may speak of
terabytes, and so may a compressed member.
"""

import io
import re
import struct
import zlib
from collections.abc import Iterable, Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple
from zipfile import ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.lib import format as npy

from deformpush.record.files import open_file, replacing, synced, write_whole

NPZ_BYTES = 1_000_000_000
"""Largest .npz that is read; its arrays are not compressed, so they hold no more."""
MEMBERS, DIRECTORY_BYTES = 64, 16_000
"""Arrays in a file at most, and the size of the list of them."""
BEGINS = struct.Struct("<8sH")
"""How an array begins: what it is, with the version of its format, and the length of the header."""
HEADER = re.compile(
    rb"\{'descr': '([<>|][biufU]\d{1,9})', 'fortran_order': (?:True|False), "
    rb"'shape': \(((?:\d{1,18}, ?){0,32}\d{0,18})\), \} *\n"
)
"""The header of an array of numbers or text as numpy writes it; numpy itself would read it as Python."""

DAMAGE = (BadZipFile, EOFError, KeyError, MemoryError, NotImplementedError, OSError, OverflowError,
          RuntimeError, TypeError, ValueError, struct.error, zlib.error)  # fmt: skip
"""What reading a damaged .npz file may raise, whichever of its bytes are not as they were."""

Array = np.ndarray


class Part(NamedTuple):
    """An array that is written piece by piece."""

    dtype: str
    shape: tuple[int, ...]
    pieces: Iterable[bytes]
    """Its bytes, in C order."""


class Like(NamedTuple):
    """What an array has to be like."""

    dtype: str
    shape: tuple[int | str, ...]
    """A name stands for the same length wherever it stands in the file."""


def write_npz(path: Path, arrays: Mapping[str, Any], sync: bool = True) -> None:
    """Replace an .npz file by arrays, or what makes arrays, by name; otherwise as `files.write_whole`."""
    buffer = io.BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    write_whole(path, buffer.getvalue(), sync)


def stream_npz(path: Path, parts: Mapping[str, Part]) -> None:
    """Replace an .npz file by arrays that are never in memory as a whole, and wait until the disk has it.

    Raises:
        OSError: no room or no permission; the old file is untouched.
    """
    with replacing(path) as temporary, temporary.open("wb") as file:
        with ZipFile(file, "w", ZIP_STORED, allowZip64=True) as archive:
            for name, part in parts.items():
                header = {"descr": part.dtype, "fortran_order": False, "shape": part.shape}
                with archive.open(ZipInfo(f"{name}.npy"), "w", force_zip64=True) as member:
                    npy.write_array_header_1_0(member, header)
                    for piece in part.pieces:
                        member.write(piece)
        synced(file)


def read_npz(path: Path, layout: Mapping[str, Like] | None = None) -> dict[str, Array]:
    """Read the arrays of an .npz file by name. Nothing in it is run.

    Args:
        path: the file.
        layout: the arrays to read; None: all there are, of numbers and texts.

    Raises:
        OSError: the file cannot be read.
        ValueError: it is damaged, another kind of file, or an array is missing or not like it should be.
    """
    with open_file(path, NPZ_BYTES) as file:
        try:
            _check_directory(file)
            with ZipFile(file) as archive:
                return _arrays(archive, layout)
        except DAMAGE as error:
            raise ValueError(f"{path}: damaged, or not written by a run ({_line(error)})") from error


def _arrays(archive: ZipFile, layout: Mapping[str, Like] | None) -> dict[str, Array]:
    """Check all headers, then read."""
    infos = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
    if len(infos) > MEMBERS or len(infos) < len(archive.infolist()):
        raise ValueError(f"{len(archive.infolist())} arrays, some of one name or more than {MEMBERS}")
    assert archive.fp is not None, "it is open"
    size = archive.fp.seek(0, io.SEEK_END)
    if sum(info.file_size for info in infos.values()) > size:
        raise ValueError("its arrays are larger than the file")
    names = list(infos) if layout is None else list(layout)
    if missing := [name for name in names if name not in infos]:
        raise ValueError(f"no array {missing[0]}")
    lengths: dict[str, int] = {}
    for name in names:
        _check(archive, infos[name], None if layout is None else layout[name], lengths)
    found = {}
    for name in names:
        with archive.open(infos[name]) as member:
            found[name] = npy.read_array(member, allow_pickle=False)
            if member.read(1):  # at its end the checksum is looked at
                raise ValueError(f"{name} is longer than it says")
    return found


def _check(archive: ZipFile, info: ZipInfo, like: Like | None, lengths: dict[str, int]) -> None:
    """Hold the header of an array against its size in the file, and against what it has to be like.

    Raises:
        ValueError: it differs.
    """
    if info.compress_type != ZIP_STORED or info.file_size != info.compress_size:
        raise ValueError(f"{info.filename} is compressed")
    with archive.open(info) as member:
        magic, length = BEGINS.unpack(member.read(BEGINS.size))
        header = HEADER.fullmatch(member.read(length))
    if magic != npy.magic(1, 0) or header is None:
        raise ValueError(f"{info.filename} is no array of numbers or text")
    dtype, shape = np.dtype(header[1].decode()), tuple(map(int, header[2].replace(b",", b" ").split()))
    if prod(shape) * dtype.itemsize != info.file_size - BEGINS.size - length:
        raise ValueError(f"{info.filename} says {shape}, which its {info.file_size} bytes are not")
    if like is not None:
        check_like(info.filename, dtype, shape, like, lengths)


def check_like(
    name: str, dtype: np.dtype[Any], shape: Sequence[int], like: Like, lengths: dict[str, int]
) -> None:
    """Hold type and shape of an array against what it has to be like.

    Args:
        name: of the array, for the message.
        dtype: its type.
        shape: its shape.
        like: what it has to be like.
        lengths: what the names in shapes stand for so far; this one's are added.

    Raises:
        ValueError: it is not like that.
    """
    fits = dtype == np.dtype(like.dtype) and len(shape) == len(like.shape)
    for length, want in zip(shape, like.shape, strict=False):
        fits = fits and length == (lengths.setdefault(want, length) if isinstance(want, str) else want)
    if not fits:
        told = ", ".join(str(lengths.get(str(length), length)) for length in like.shape)
        raise ValueError(f"{name} is {dtype} {tuple(shape)}, not {np.dtype(like.dtype)} ({told})")


def _check_directory(file: BinaryIO) -> None:
    """Make sure that the list of members at the end of the file is short, before all of it is read.

    Raises:
        ValueError: it is not, or there is none.
    """
    size = file.seek(0, io.SEEK_END)
    file.seek(max(0, size - 42))
    tail = file.read(42)
    if tail[-22:-18] != b"PK\x05\x06" or tail[-2:] != b"\0\0" or tail[:4] == b"PK\x06\x07":
        raise ValueError("no list of arrays at its end")
    (length,) = struct.unpack("<I", tail[-10:-6])
    if length > DIRECTORY_BYTES:
        raise ValueError(f"its list of arrays takes {length} bytes")
    file.seek(0)


def _line(error: BaseException) -> str:
    """An error's message in one short line."""
    return " ".join(str(error).split())[:120] or type(error).__name__
