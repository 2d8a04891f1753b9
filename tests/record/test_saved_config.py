"""A saved configuration is read as OmegaConf reads it, and whatever is more than settings is refused."""

import os
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from omegaconf import OmegaConf

from deformpush.config.build import dump
from deformpush.record.saved_config import SavedConfigError, read_config, read_settings, read_text

ROOT = Path(__file__).parents[2]
LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{name}: &{name} [{', '.join([f'*{before}'] * 9)}]\n"
    for before, name in zip("abcdefgh", "bcdefghi", strict=True)
)
"""Nine lines that stand for 400 million texts."""


CONF = sorted(file for file in (ROOT / "conf").rglob("*.yaml") if "defaults:" not in file.read_text())


@pytest.mark.parametrize("file", CONF, ids=lambda file: f"{file.parent.name}-{file.stem}")
def test_numbers_and_texts_are_those_of_omegaconf(file):
    text = "\n".join(line for line in file.read_text().splitlines() if "${" not in line) + "\n"
    assert read_settings(text) == OmegaConf.to_container(OmegaConf.create(text))


PLAIN = "1 1e3 1e-9 1. .5 -2.5e-3 1_000 0x1f 017 1:30 .inf yes no ~ null true off 2024-01-01 '1' none 1e e1"


@pytest.mark.parametrize("value", ["", "a b", '"a"', "+1", *PLAIN.split()])
def test_plain_text_means_what_it_means_to_omegaconf(value):
    text = f"a: {value}\nb: [{value or 1}]\n"
    found, wanted = read_settings(text), OmegaConf.to_container(OmegaConf.create(text))
    assert found == wanted
    assert type(found["a"]) is type(wanted["a"])


NAMES = st.text("abcdefg_", min_size=1, max_size=8)
SETTINGS = st.dictionaries(
    NAMES,
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers()
        | st.floats(allow_nan=False)
        | st.text("ab1e-: #'é", max_size=9),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
        max_leaves=9,
    ),
    min_size=1,
    max_size=6,
)


@given(SETTINGS)
def test_what_a_run_writes_comes_back(values):
    assert read_settings(dump(values)) == values


def test_settings_are_read_part_by_part():
    assert read_settings("a: 1\nb:\n  c: 2\n") == {"a": 1, "b": {"c": 2}}
    assert read_settings("a:\n  b: 1\n# a comment\nc: 2\n") == {"a": {"b": 1}, "c": 2}
    assert read_settings("a: 1\n\n\nb:\n\n  c:\n  - 2\n") == {"a": 1, "b": {"c": [2]}}
    assert read_settings("{a: 1, b: 2}") == {"a": 1, "b": 2}
    assert read_settings("a:\n- 1\n- 2\n") == {"a": [1, 2]}


REFUSED = {
    "a: &x 1\n": "line 1: an alias or anchor",
    "a: 1\nb: *x\n": "line 2: an alias or anchor",
    LAUGHS: "line 1: an alias or anchor",
    "seed: 1\nobject:\n  _target_: x\n  a: !!python/object/apply:os.system [ls]\n": (
        "line 4: the tag tag:yaml.org,2002:python/object/apply:os.system"
    ),
    "a: !!str 5\n": "line 1: the tag",
    "a: !mine {b: 1}\n": "line 1: the tag !mine",
    "!!map {a: 1}\n": "line 1: the tag",
    "a: ${oc.env:HOME}\n": r"line 1: the interpolation \$\{oc\.env:HOME\}",
    "b: 1\na:\n  c: 'x ${seed}'\n": "line 3: the interpolation",
    "a: {'${x}': 1}\n": "line 1: the interpolation",
    "a: 1\nb: 2\na: 3\n": "line 3: a stands twice",
    "a:\n  b: 1\n  b: 2\n": "line 3: b stands twice",
    "<<: {a: 1}\n": "line 1: a key that is no name",
    "a: {<<: {b: 1}}\n": "line 1: a key that is no name",
    "? [1]\n: 2\n": "line 1: a key that is no name",
    "1: 2\n": "line 1: a key that is no name",
    "a: {1: 2}\n": "line 1: a key that is no name",
    "a: {null: 2}\n": "line 1: a key that is no name",
    "a: " + "[" * 50 + "]" * 50: "line 1: more than 20 levels",
    "a: " + "{a: " * 50 + "1" + "}" * 50: "line 1: more than 20 levels",
    "a: [" + "1, " * 30_000 + "]": "line 1: more than 20000 values",
    "a: 1\n---\nb: 2\n": "line 2: another document",
    "": "no mapping of settings",
    "# nothing\n": "no mapping of settings",
    "- 1\n": "no mapping of settings",
    "text": "no mapping of settings",
    "a: [": "line [12]: ",
    "a: 1\nb: 2\n\tc": "line 3: ",
    "a: 1\n b: 2": "line 2: ",
    "a: \x00": "unacceptable character",
    "a: " + "9" * 5000: "Exceeds the limit",
}


@pytest.mark.timeout(20)
@pytest.mark.parametrize("text", REFUSED, ids=range(len(REFUSED)))
def test_whatever_is_more_than_settings_is_one_line(text):
    with pytest.raises(SavedConfigError, match=f"^{REFUSED[text]}") as caught:
        read_settings(text)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 200


LONG = {
    "\n": 999_999,
    "a\n": 499_999,
    "a: 1\n": 199_999,
    "a:\n b\n": 150_000,
    " b\n": 300_000,
    "a:": 400_000,
    "- ": 400_000,
    "a: {": 200_000,
    " ": 999_999,
    "a: b\n\n\n": 100_000,
    "[": 999_999,
}


@pytest.mark.parametrize("piece", LONG)
def test_a_million_letters_take_no_time(piece):
    began = time.process_time()
    with pytest.raises(SavedConfigError) as caught:
        read_settings(piece * LONG[piece])
    assert len(str(caught.value)) < 200
    assert time.process_time() - began < 5


def test_a_file_that_is_none_is_refused(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_bytes(b"a: \xff\n")
    with pytest.raises(SavedConfigError, match="no text"):
        read_config(path)
    path.write_bytes(b"a: 1\n" + b"#" * 1_000_000)
    with pytest.raises(OSError, match="larger than 1 MB"):
        read_text(path)
    path.unlink()
    with pytest.raises(FileNotFoundError):
        read_config(path)
    os.mkfifo(path)
    with pytest.raises(OSError, match="no regular file"):
        read_config(path)
