"""What reaches a terminal, and what happens where nobody listens."""

import os
import subprocess
import sys

import pytest

from deformpush.cli.terminal import printable

COMMAND = [sys.executable, "-m", "deformpush", "--help"]


def shell(line: str, **environment: str) -> subprocess.CompletedProcess:
    command = f"{' '.join(COMMAND)} {line}"
    return subprocess.run(
        ["bash", "-c", command], capture_output=True, env={**os.environ, **environment}, timeout=60
    )


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("plain, \u00e9\u00e9\n", "plain, \u00e9\u00e9\n"),
        ("\x1b[2Jgone", "\ufffd[2Jgone"),
        ("a\x07b\x9bc\x7f", "a\ufffdb\ufffdc\ufffd"),
        ("right\u202eleft", "right\ufffdleft"),
        ("\rbar\tend", "\rbar\tend"),
    ],
)
def test_control_characters_do_not_reach_the_terminal(text, shown):
    assert printable(text) == shown


def test_names_from_a_folder_are_printed_without_them(tmp_path):
    (tmp_path / "run\x1b[31m").mkdir()
    done = subprocess.run(
        [*COMMAND[:3], "resume", str(tmp_path / "run\x1b[31m")], capture_output=True, timeout=60
    )
    assert done.returncode == 2
    assert b"\x1b" not in done.stderr
    assert "\ufffd[31m" in done.stderr.decode()


def test_a_reader_that_goes_away_is_no_trouble():
    done = shell("| head -1; exit ${PIPESTATUS[0]}")
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.count(b"\n") == 1


def test_a_full_disk_is_said_in_one_line():
    done = shell("> /dev/full")
    assert done.returncode == 1
    assert done.stderr == b"standard output: cannot be written (No space left on device)\n"


def test_a_closed_output_is_no_trouble():
    done = shell(">&-")
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_terminal_that_knows_ascii_alone_is_no_trouble():
    line = f"{' '.join(COMMAND[:3])} 'object=\u00e9\u00e9'"
    done = subprocess.run(
        ["bash", "-c", line], capture_output=True, env={**os.environ, "PYTHONIOENCODING": "ascii"}, timeout=60
    )
    assert done.returncode == 2
    assert b"object=\\xe9\\xe9: not KEY=VALUE" in done.stderr
