"""Arrays come back as they were; what a header says is held against the file before any array is made."""

import io
import struct
import tracemalloc
import warnings
import zipfile

import numpy as np
import pytest

from deformpush.record import npz
from deformpush.record.npz import Like, Part, read_npz, stream_npz, write_npz

REFUSED = "damaged, or not written by a run"


def test_arrays_come_back_by_name(tmp_path):
    path = tmp_path / "a.npz"
    write_npz(path, {"a": [[1.0, np.nan]], "b": np.arange(3), "c": 0.5, "d": np.array("text")})
    found = read_npz(path)
    assert set(found) == {"a", "b", "c", "d"}
    np.testing.assert_array_equal(found["a"], [[1.0, np.nan]])
    assert str(found["d"]) == "text"
    assert set(read_npz(path, {"b": Like("<i8", ("n",))})) == {"b"}
    with pytest.raises(ValueError, match=f"{REFUSED} .*no array e"):
        read_npz(path, {"e": Like("<i8", ())})
    with pytest.raises(ValueError, match="allow_pickle"):
        write_npz(path, {"a": np.array([object()])})


def test_a_stream_writes_what_numpy_would(tmp_path):
    arrays = {
        "a": np.random.default_rng(0).random((4, 3, 2)),
        "b": np.array(0.5),
        "c": np.arange(5, dtype="u1"),
    }
    parts = {
        name: Part(one.dtype.str, one.shape, [row.tobytes() for row in one] if one.ndim else [one.tobytes()])
        for name, one in arrays.items()
    }
    stream_npz(tmp_path / "a.npz", parts)
    np.savez(tmp_path / "b.npz", **arrays)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


@pytest.mark.parametrize("damage", [b"", b"hello", "cut"])
def test_a_damaged_file_is_refused_in_one_line(tmp_path, damage):
    path = tmp_path / "a.npz"
    write_npz(path, {"a": np.arange(100)})
    path.write_bytes(path.read_bytes()[:-50] if damage == "cut" else damage)
    with pytest.raises(ValueError, match=REFUSED) as caught:
        read_npz(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(FileNotFoundError):
        read_npz(tmp_path / "none.npz")


def test_a_flipped_bit_anywhere_is_noticed_or_changes_nothing(tmp_path):
    path, array = tmp_path / "a.npz", np.arange(9.0)
    write_npz(path, {"a": array})
    data = path.read_bytes()
    for at in range(len(data)):
        path.write_bytes(data[:at] + bytes([data[at] ^ 16]) + data[at + 1 :])
        try:
            found = read_npz(path)
        except ValueError:
            continue
        (name,) = found
        assert name != "a" or np.array_equal(found[name], array)


@pytest.mark.parametrize(
    "like",
    [
        Like("<f4", (3, 2)),
        Like("<i8", (3, 2)),
        Like("<f8", (3,)),
        Like("<f8", (3, 3)),
        Like("<f8", ("n", "n")),
    ],
)
def test_an_array_of_another_type_or_shape_is_refused(tmp_path, like):
    write_npz(tmp_path / "a.npz", {"a": np.zeros((3, 2))})
    assert read_npz(tmp_path / "a.npz", {"a": Like("<f8", ("n", 2))})["a"].shape == (3, 2)
    with pytest.raises(ValueError, match=r"a\.npy is float64 \(3, 2\), not "):
        read_npz(tmp_path / "a.npz", {"a": like})


def test_a_length_is_the_same_wherever_it_stands(tmp_path):
    write_npz(tmp_path / "a.npz", {"a": np.zeros(3), "b": np.zeros(4)})
    with pytest.raises(ValueError, match=r"b\.npy is float64 \(4,\), not float64 \(3\)"):
        read_npz(tmp_path / "a.npz", {"a": Like("<f8", ("n",)), "b": Like("<f8", ("n",))})


def member(shape: str, data: bytes = b"", descr: str = "'<f8'") -> bytes:
    """An array with any header."""
    header = f"{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + data


def archive(*members: tuple[str, bytes], how: int = zipfile.ZIP_STORED) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", how) as file, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for name, data in members:
            file.writestr(name, data)
    return buffer.getvalue()


def lying(data: bytes, size: int) -> bytes:
    """An archive whose list says another size of its first member."""
    at = data.index(b"PK\x01\x02")
    return data[: at + 20] + struct.pack("<II", size, size) + data[at + 28 :]


def many(count: int) -> bytes:
    """An archive with a long list of members that all lie in the same place."""
    whole = archive(("a.npy", member("(0,)")))
    at = whole.index(b"PK\x01\x02")
    entry = whole[at : whole.index(b"PK\x05\x06")]
    end = struct.pack(
        "<4sHHHHIIH", b"PK\x05\x06", 0, 0, count & 65535, count & 65535, count * len(entry), at, 0
    )
    return whole[:at] + entry * count + end


HOSTILE = {
    "146 TiB": archive(("a.npy", member("(20000000, 1000000)"))),
    "more dimensions than numbers": archive(("a.npy", member(f"({'99999999, ' * 30})"))),
    "negative": archive(("a.npy", member("(-1,)"))),
    "negative twice": archive(("a.npy", member("(-2, -4)", bytes(64)))),
    "a bomb": archive(("a.npy", member("(5000000,)", bytes(40_000_000))), how=zipfile.ZIP_DEFLATED),
    "objects": archive(("a.npy", member("(1,)", bytes(8), "'|O'"))),
    "records": archive(("a.npy", member("(1,)", bytes(8), "[('x', '<f8')]"))),
    "times": archive(("a.npy", member("(1,)", bytes(8), "'<M8[s]'"))),
    "code": archive(("a.npy", member("__import__('os').getpid()"))),
    "deep": archive(("a.npy", member("(" * 4000))),
    "of Python 2": archive(("a.npy", member("(1L,)", bytes(8)))),
    "one name twice": archive(("a.npy", member("(1,)", bytes(8))), ("a.npy", member("(1,)", bytes(8)))),
    "too many": archive(*[(f"{i}.npy", member("(0,)")) for i in range(npz.MEMBERS + 1)]),
    "a long list": many(400),
    "larger than the file": lying(archive(("a.npy", member("(99999,)"))), 128 + 8 * 99999),
    "all of the file": lying(archive(("a.npy", member("(9,)", bytes(72)))), 2**32 - 2),
    "no header": archive(("a.npy", b"")),
    "a version to come": archive(("a.npy", member("(1,)", bytes(8)).replace(b"\x01\x00", b"\x03\x00", 1))),
}


@pytest.mark.timeout(20)
@pytest.mark.parametrize("name", HOSTILE)
@pytest.mark.parametrize("layout", [None, {"a": Like("<f8", ("n",))}], ids=["any", "known"])
def test_what_a_header_claims_takes_no_memory(name, layout, tmp_path):
    (tmp_path / "a.npz").write_bytes(HOSTILE[name])
    tracemalloc.start()
    with pytest.raises(ValueError, match=REFUSED) as caught:
        read_npz(tmp_path / "a.npz", layout)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 300 + len(str(tmp_path))
    assert peak < 3e6


def test_a_file_that_is_too_large_is_not_read(tmp_path, monkeypatch):
    monkeypatch.setattr(npz, "NPZ_BYTES", 1000)
    write_npz(tmp_path / "a.npz", {"a": np.zeros(1000)})
    with pytest.raises(OSError, match="larger than"):
        read_npz(tmp_path / "a.npz")
