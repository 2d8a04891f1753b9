"""Files appear whole or not at all, and damaged ones are refused."""

import errno
import os
import socket
from pathlib import Path

import pytest

from deformpush.record.files import (
    append,
    open_file,
    read_bytes,
    read_json,
    replacing,
    to_append,
    write_whole,
)


def test_a_write_that_fails_keeps_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "file"
    write_whole(path, b"old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_without_sync_the_disk_is_not_waited_for(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fsync", lambda _: pytest.fail("waited"))
    write_whole(tmp_path / "file", b"all", sync=False)
    assert (tmp_path / "file").read_bytes() == b"all"


def test_a_file_takes_its_place_when_its_maker_is_done(tmp_path):
    path = tmp_path / "film.mp4"
    with replacing(path) as temporary:
        temporary.write_text("new")
        assert (temporary.parent, temporary.suffix) == (tmp_path, ".mp4"), "makers go by the suffix"
        assert not path.exists()
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_a_maker_that_fails_leaves_the_old_file(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_text("old")

    def half() -> None:
        with replacing(path) as temporary:
            temporary.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        half()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_name_that_a_stranger_guessed_is_not_written_through(tmp_path, monkeypatch):
    """The temporary file is made anew: a link with its name leads nowhere."""
    monkeypatch.setattr("secrets.token_hex", lambda _: "00000000")
    (tmp_path / "elsewhere").write_text("mine")
    (tmp_path / ".file.00000000.tmp.txt").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(FileExistsError):
        write_whole(tmp_path / "file.txt", b"theirs")
    assert (tmp_path / "elsewhere").read_text() == "mine"


def test_a_new_file_has_the_permissions_that_the_user_wants(tmp_path):
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "file", b"")
    finally:
        os.umask(before)
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o640


def test_a_link_is_replaced_and_what_it_leads_to_stays(tmp_path):
    (tmp_path / "elsewhere").write_text("mine")
    (tmp_path / "file").symlink_to(tmp_path / "elsewhere")
    write_whole(tmp_path / "file", b"new")
    assert (tmp_path / "elsewhere").read_text() == "mine"
    assert not (tmp_path / "file").is_symlink()


def link(path: Path) -> None:
    path.with_name("elsewhere").write_text("mine")
    path.symlink_to("elsewhere")


STRANGE = {
    "pipe": (os.mkfifo, "no regular file"),
    "link": (link, "a symbolic link"),
    "device": (lambda path: path.symlink_to("/dev/zero"), "a symbolic link"),
    "folder": (Path.mkdir, "no regular file"),
    "socket": (lambda path: socket.socket(socket.AF_UNIX).bind(str(path)), "no regular file"),
}


@pytest.mark.filterwarnings("ignore:unclosed <socket:ResourceWarning")
@pytest.mark.timeout(10)
@pytest.mark.parametrize("kind", STRANGE)
def test_what_is_no_plain_file_is_neither_read_nor_written(kind, tmp_path):
    make, why = STRANGE[kind]
    make(path := tmp_path / "file")
    for attempt in (
        lambda: read_bytes(path, 100),
        lambda: open_file(path, 100),
        lambda: read_json(path),
        lambda: to_append(path),
    ):
        with pytest.raises(OSError, match=why) as caught:
            attempt()
        assert caught.value.strerror == why


def test_a_device_itself_is_not_opened(monkeypatch):
    monkeypatch.setattr(os, "open", lambda *_: pytest.fail("opened"))
    with pytest.raises(OSError, match="no regular file"):
        read_bytes(Path("/dev/zero"), 100)


def test_a_file_that_is_too_large_is_not_read(tmp_path):
    (tmp_path / "file").write_bytes(b"x" * 101)
    with pytest.raises(OSError, match=r"larger than 0\.0001 MB"):
        read_bytes(tmp_path / "file", 100)
    assert read_bytes(tmp_path / "file", 101) == b"x" * 101


@pytest.mark.parametrize(
    "text", ["", "{", "[" * 100_000, '{"a": NaN}', "1e", '{"a": ' + "9" * 5000 + "}", "\xff"]
)
def test_what_is_no_json_is_one_line(text, tmp_path):
    (tmp_path / "a.json").write_text(text, encoding="latin-1")
    with pytest.raises(ValueError, match=r"^a\.json is damaged: not JSON$"):
        read_json(tmp_path / "a.json")


class Full:
    """A file on a disk with room for two more bytes."""

    def __init__(self, file):
        self.file, self.room = file, 2

    def write(self, data):
        if not self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written = self.file.write(data[: self.room])
        self.room -= written
        return written

    def __getattr__(self, name):
        return getattr(self.file, name)


def test_an_addition_is_whole_or_not_at_all(tmp_path):
    (tmp_path / "file").write_bytes(b"old\n")
    file = to_append(tmp_path / "file")
    append(file, b"new\n", sync=True)

    with pytest.raises(OSError, match="No space left"):
        append(Full(file), b"more\n", sync=False)
    append(file, b"last\n", sync=False)
    file.close()
    assert (tmp_path / "file").read_bytes() == b"old\nnew\nlast\n"


def test_a_file_goes_on_behind_its_first_bytes(tmp_path):
    (tmp_path / "file").write_bytes(b"0123456789")
    with to_append(tmp_path / "file", 4) as file:
        file.write(b"x")
    assert (tmp_path / "file").read_bytes() == b"0123x"
    with pytest.raises(FileNotFoundError):
        to_append(tmp_path / "none")
