"""Damage that a stranger may do to the files of a run."""

import io
import json
import os
import random
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

NUMBERS = [
    "nan",
    "inf",
    "-inf",
    "-1",
    "0",
    "1e308",
    "1e999",
    "99999999999999999999",
    "true",
    "null",
    "",
    "'x'",
    "0x1F",
]
VALUES: list[Any] = [
    None,
    True,
    -1,
    0,
    10**30,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "x" * 10_000,
    "\x1b[31m\n",
    [],
    {},
    [1, [2]],
    {"a": {"b": 1}},
    "${oc.env:HOME}",
    "<script>alert(1)</script>",
]


def damage(folder: Path, rng: random.Random, outside: Path, canary: str) -> str:
    """Harm one file of a folder; what was done.

    Args:
        folder: of a run, or of a sweep.
        rng: decides what is done.
        outside: a file elsewhere, which links may point to.
        canary: a module that nobody may import.
    """
    file = rng.choice(sorted(path for path in folder.iterdir() if path.is_file() and path.suffix != ".py"))
    kinds: list[Callable[..., object]] = [_bytes, _bytes, _truncate, _number, _strange, _swap]
    kinds += [_values] * 4 if file.suffix in (".json", ".yaml") else []
    kinds += [_archive] * 3 if file.suffix == ".npz" else []
    kinds += [_cells] * 3 if file.suffix == ".csv" else []
    kind = rng.choice(kinds)
    if kind is _values:
        return f"{file.name} {_values(file, rng, canary)}"
    detail = _strange(file, rng, outside) if kind is _strange else kind(file, rng)
    return f"{file.name}{kind.__name__} {detail or ''}"


def _bytes(file: Path, rng: random.Random) -> None:
    data = bytearray(file.read_bytes() or b"\x00")
    for _ in range(rng.choice([1, 1, 3, 30])):
        at, n = rng.randrange(len(data)), rng.choice([1, 4, 64])
        part = rng.choice(
            [rng.randbytes(n), b"", bytes(data[at : at + n]) * 2, b"\xff" * n, b"\n", b"\x00" * n]
        )
        data[at : at + n] = part
        data = data or bytearray(b"\x00")
    file.write_bytes(data)


def _truncate(file: Path, rng: random.Random) -> None:
    data = file.read_bytes()
    file.write_bytes(data[: rng.randrange(len(data) + 1)] if rng.random() < 0.7 else data * 2)


def _number(file: Path, rng: random.Random) -> str:
    """One number in the text becomes another, or what is none."""
    text = file.read_bytes().decode("latin-1")
    found = list(re.finditer(r"-?\d+(\.\d+)?(e-?\d+)?", text))
    if not found:
        return "none"
    match, new = rng.choice(found), rng.choice(NUMBERS)
    file.write_bytes((text[: match.start()] + new + text[match.end() :]).encode("latin-1"))
    return new


def _swap(file: Path, rng: random.Random) -> str:
    """What stands in another file of the folder."""
    other = rng.choice(sorted(path for path in file.parent.iterdir() if path.is_file()))
    file.write_bytes(other.read_bytes())
    return other.name


def _strange(file: Path, rng: random.Random, outside: Path) -> str:
    kind = rng.choice(
        ["gone", "folder", "pipe", "link", "dangling", "loop", "sparse", "to a device", "to a folder"]
    )
    file.unlink()
    if kind == "folder":
        file.mkdir()
    elif kind == "pipe":
        os.mkfifo(file)
    elif kind == "sparse":
        with file.open("wb") as handle:
            handle.truncate(1_500_000_000)
    elif kind != "gone":
        targets = {
            "link": outside,
            "loop": file,
            "to a device": Path("/dev/zero"),
            "to a folder": outside.parent,
        }
        file.symlink_to(targets.get(kind, outside.with_name("nothing")))
    return kind


def _values(file: Path, rng: random.Random, canary: str) -> str:
    """A value of another type, a key more or less, a class that is none of ours."""
    text = file.read_text()
    loaded = json.loads(text) if file.suffix == ".json" else yaml.safe_load(text)
    kind = rng.choice(["value", "value", "value", "gone", "more", "class", "alias", "deep", "tag", "wide"])
    places = list(_places(loaded))
    node, key = rng.choice(places)
    new = rng.choice([*VALUES, f"{canary}.Canary", "this.Zen", "os.system"])
    if kind == "value":
        node[key] = new
    elif kind == "gone":
        del node[key]
    elif kind == "more" and isinstance(node, dict):
        node[rng.choice(["new", "_target_", "sim", "", "1", "<<"])] = new
    elif kind == "class":
        node[key] = {
            "_target_": rng.choice(
                [f"{canary}.Canary", "this.Zen", "subprocess.Popen", "deformpush.errors.UserError"]
            )
        }
    if kind == "alias" and file.suffix == ".yaml":
        bomb = "\n".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}' if i else 'x'] * 10)}]" for i in range(10))
        file.write_text(bomb + "\n" + text)
    elif kind == "tag" and file.suffix == ".yaml":
        file.write_text(text + "\nmore: !!python/object/apply:os.getcwd []\n")
    elif kind in ("deep", "wide"):
        large = "[" * 5000 + "]" * 5000 if kind == "deep" else "[" + "1," * 300_000 + "1]"
        file.write_text(f'{{"more": {large}}}' if file.suffix == ".json" else f"more: {large}\n{text}")
    else:
        file.write_text(json.dumps(loaded) if file.suffix == ".json" else yaml.safe_dump(loaded))
    return f"{kind} {key} = {str(new)[:40]!r}"


def _places(node: Any) -> list[tuple[Any, Any]]:
    """Every place of a tree of mappings and lists, as a container and a key."""
    keys = list(node) if isinstance(node, dict) else list(range(len(node))) if isinstance(node, list) else []
    return [place for key in keys for place in [(node, key), *_places(node[key])]]


def _cells(file: Path, rng: random.Random) -> str:
    """One cell of a table, a row, or a column."""
    rows = [line.split(",") for line in file.read_text().splitlines()]
    row = rng.randrange(len(rows))
    kind = rng.choice(["cell", "cell", "cell", "row twice", "row gone", "column gone", "wide"])
    if kind == "cell":
        rows[row][rng.randrange(len(rows[row]))] = new = rng.choice(
            [*NUMBERS, "x" * 5000, '"', "\x1b[2J", "<b>"]
        )
        kind = f"cell {new[:20]!r}"
    elif kind == "row twice":
        rows.insert(row, rows[row])
    elif kind == "row gone":
        del rows[row]
    elif kind == "wide":
        rows[row] *= 500
    else:
        column = rng.randrange(len(rows[0]))
        rows = [cells[:column] + cells[column + 1 :] for cells in rows]
    file.write_text("\n".join(map(",".join, rows)) + "\n")
    return kind


def _archive(file: Path, rng: random.Random) -> str:
    """An npz whose members say something else than they hold."""
    try:
        with zipfile.ZipFile(file) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
    except (OSError, zipfile.BadZipFile):
        return "none"
    name = rng.choice(sorted(members))
    kind = rng.choice(["shape", "dtype", "gone", "more", "bomb", "path", "twice", "empty"])
    shape = rng.choice(["(20000000, 10000000)", "(-1, 3)", "()", "(0,)", "(1, 2, 3)", "(10**9,)", "(3,)"])
    dtype = (
        rng.choice(["|O", "<f4", "<U9", "|S3", "<i8", "<c16", "|V8", "<M8[s]"]) if kind == "dtype" else "<f8"
    )
    header = f"{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117).encode() + b"\n"
    body = bytes(50_000_000) if kind == "bomb" else members[name][128:]
    if kind in ("shape", "dtype", "bomb"):
        members[name] = b"\x93NUMPY\x01\x00" + struct.pack("<H", 118) + header + body
    elif kind == "gone":
        del members[name]
    elif kind == "empty":
        members[name] = b""
    elif kind in ("more", "path"):
        members["more.npy" if kind == "more" else "../../more.npy"] = members[name]
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
        if kind == "twice":
            archive.writestr(zipfile.ZipInfo(name), members[name])
    file.write_bytes(out.getvalue())
    return f"{name} {kind} {dtype} {shape}"
