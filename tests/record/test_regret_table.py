"""regret.csv and regret_trials.csv: read back as written, cut where a walk stopped, refused where damaged."""

import math

import numpy as np
import pytest

from deformpush.record.regret_table import COLUMNS, TRIAL_COLUMNS, RegretTable, read, read_trials


def row(k: int) -> dict:
    return dict.fromkeys(COLUMNS, 0.1 * k) | {"k": k, "phase": "explore", "rank": 1, "trials": 2, "failed": 0}


def trials(k: int) -> list[dict]:
    return [dict.fromkeys(TRIAL_COLUMNS, 1 / 3) | {"k": k, "xi": math.nan} for _ in range(2)]


@pytest.fixture
def folder(tmp_path):
    table = RegretTable(tmp_path, 2)
    table.open()
    for k in (1, 2):
        table.append(row(k), trials(k))
    table.close()
    return tmp_path


def test_what_is_written_is_read(folder):
    found, tried = read(folder / "regret.csv"), read_trials(folder / "regret_trials.csv")
    assert [dict(zip(found, values, strict=True)) for values in zip(*found.values(), strict=True)] == [
        row(1),
        row(2),
    ]
    assert tried["k"] == [1, 1, 2, 2]
    assert np.isnan(tried["xi"]).all()
    assert tried["xi_mean"] == [1 / 3] * 4


@pytest.mark.parametrize(("name", "cut"), [("regret.csv", 5), ("regret_trials.csv", 5)])
def test_a_push_that_one_file_lacks_is_not_there(name, cut, folder):
    whole = {file.name: file.read_bytes() for file in folder.iterdir()}
    (folder / name).write_bytes(whole[name][:-cut])
    table = RegretTable(folder, 2)
    assert [one["k"] for one in table.rows] == [1]
    assert (folder / name).read_bytes() == whole[name][:-cut]
    table.open()
    table.append(row(2), trials(2))
    table.close()
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == whole


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a,b\n1,2\n", "not a table of regret .its first line must name k, phase"),
        (",".join(COLUMNS) + "\n1,2\n", "not a table of regret .line 2 has 2 cells"),
        (",".join(COLUMNS) + "\n" + "x," * (len(COLUMNS) - 1) + "1\n", "not a table of regret .invalid"),
    ],
)
def test_what_is_no_table_is_refused(text, message, folder):
    (folder / "regret.csv").write_text(text)
    with pytest.raises(ValueError, match=message):
        RegretTable(folder, 2)


def test_a_link_is_not_followed(folder):
    (folder / "regret.csv").rename(folder / "elsewhere.csv")
    (folder / "regret.csv").symlink_to(folder / "elsewhere.csv")
    with pytest.raises(OSError, match="a symbolic link"):
        RegretTable(folder, 2)
