"""States are appended, and what is whole is read whatever became of the rest."""

import json
import struct
import zlib

import numpy as np
import pytest

from deformpush.record import states as module
from deformpush.record.blocks import HEAD
from deformpush.record.states import State, States, StatesWriter, state_of
from tests.record.test_files import Full

FIXED = {"a": np.arange(3.0), "b": 0.1, "c": np.eye(2)}


def state(k: int, points: int = 4) -> State:
    return State(np.arange(7.0 + 2 * points) + k / 3, bytes([k]) * k)


@pytest.fixture
def path(tmp_path):
    """A file of six states, the first two written at once."""
    writer = StatesWriter(tmp_path / "states.bin", FIXED, [state(0), state(1)])
    for k in range(2, 6):
        writer.append(state(k))
    writer.close()
    return tmp_path / "states.bin"


def same(found: States, count: int) -> None:
    read = list(found)
    assert len(read) == count
    for k, one in enumerate(read):
        np.testing.assert_array_equal(one.numbers, state(k).numbers)
        assert one.picture == state(k).picture


def test_states_come_back_to_the_bit(path):
    found = States(path)
    assert found.points == 4
    for name, value in FIXED.items():
        np.testing.assert_array_equal(found.fixed[name], value)
        assert found.fixed[name].shape == np.shape(value)
    same(found, 6)
    same(found, 6)  # as often as is asked


def test_a_state_is_what_was_seen_and_where_the_tool_went(run):
    for row in run[1]:
        numbers, picture = state_of(row, b"picture")
        seen = row.view.seen
        np.testing.assert_array_equal(numbers[:3], [*seen.c, seen.theta])
        np.testing.assert_array_equal(numbers[7:].reshape(-1, 2), seen.contour)
        if row.action is None:
            assert np.isnan(numbers[3:7]).all()
        else:
            np.testing.assert_array_equal(numbers[3:7], [*row.action.path.start, *row.action.path.end])
        assert picture == b"picture"


def test_the_file_is_as_it_is_documented(path):
    """Read without the project, as docs/data.md tells."""
    data, blocks = path.read_bytes(), []
    while data:
        length, checksum = struct.unpack("<II", data[:8])
        assert zlib.crc32(data[8 : 8 + length]) == checksum
        blocks.append(data[8 : 8 + length])
        data = data[8 + length :]
    assert json.loads(blocks[0]) == {"M": 4, "fixed": {"a": [0, 1, 2], "b": 0.1, "c": [[1, 0], [0, 1]]}}
    numbers = np.frombuffer(blocks[3][: 8 * 15], "<f8")
    np.testing.assert_array_equal(numbers, state(2).numbers)
    assert blocks[3][8 * 15 :] == b"\2\2"


def test_a_file_that_ends_at_any_byte_is_read_as_far_as_it_is_whole(path):
    data, ends = path.read_bytes(), []
    at = 0
    while at < len(data):
        at += HEAD.size + HEAD.unpack(data[at : at + HEAD.size])[0]
        ends.append(at)
    for size in range(len(data)):
        path.write_bytes(data[:size])
        if size < ends[0]:
            with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
                States(path)
            assert "\n" not in str(caught.value)
        else:
            same(States(path), sum(end <= size for end in ends[1:]))


@pytest.mark.parametrize("bit", [1, 128])
def test_a_flipped_bit_ends_what_is_read(path, bit):
    data = path.read_bytes()
    for at in range(0, len(data), 3):
        path.write_bytes(data[:at] + bytes([data[at] ^ bit]) + data[at + 1 :])
        try:
            found = States(path)
        except ValueError:
            continue
        count = len(list(found))
        assert count < 6
        same(found, count)


def test_zeros_at_the_end_are_what_a_power_cut_leaves(path):
    path.write_bytes(path.read_bytes()[:-30] + bytes(5000))
    same(States(path), 5)


def test_a_full_disk_leaves_whole_states(path):
    writer = StatesWriter(path, FIXED, [state(0)])

    whole = writer._file
    writer._file = Full(whole)
    with pytest.raises(OSError, match="No space left"):
        writer.append(state(1))
    writer._file = whole
    writer.append(state(1))
    writer.close()
    same(States(path), 2)


def head(values: object) -> bytes:
    text = values if isinstance(values, bytes) else json.dumps(values).encode()
    return HEAD.pack(len(text), zlib.crc32(text)) + text


@pytest.mark.parametrize(
    "content",
    [
        b"",
        bytes(100),
        HEAD.pack(2**32 - 1, 0) + b"x" * 50,
        head(b"no JSON"),
        head(b"[" * 100_000),
        head([]),
        head({"M": 4}),
        head({"M": "four", "fixed": {}}),
        head({"M": 4, "fixed": []}),
        head({"M": 4, "fixed": {"a": [[1], [2, 3]]}}),
        head({"M": 4, "fixed": {"a": "text"}}),
        head({"M": 4, "fixed": {"a": {"b": 1}}}),
        head({"M": 2, "fixed": {}}),
        head({"M": -4, "fixed": {}}),
        head({"M": 10**12, "fixed": {}}),
        head(b'{"M": Infinity, "fixed": {}}'),
    ],
)
def test_a_head_that_is_none_is_one_line(content, tmp_path):
    (tmp_path / "states.bin").write_bytes(content)
    with pytest.raises(ValueError, match="damaged, or not written by a run") as caught:
        States(tmp_path / "states.bin")
    assert "\n" not in str(caught.value)


def test_a_state_that_is_too_short_ends_what_is_read(path):
    with path.open("ab") as file:
        file.write(head(b"short"))
        file.write(head(bytes(500)))
    same(States(path), 6)


def test_a_file_that_is_too_large_is_not_read(path, monkeypatch):
    monkeypatch.setattr(module, "COUNT", 3)
    same(States(path), 3)
    monkeypatch.setattr(module, "FILE_BYTES", 100)
    with pytest.raises(OSError, match="larger than"):
        States(path)


def test_a_new_file_takes_the_place_of_the_old_one(path):
    StatesWriter(path, FIXED, [state(0)]).close()
    same(States(path), 1)
