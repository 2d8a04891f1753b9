"""forecasts.csv says what was foretold and what came; the share inside is the calibration."""

import numpy as np
import pytest

from deformpush.record.forecasts import Forecasts, actual, read
from tests.record.synthetic import foretold


def test_forecasts_come_back_with_what_came(tmp_path, run):
    path = tmp_path / "forecasts.csv"
    table, std = Forecasts(path), np.array([1e-3, 2e-3, 0.02, 0.01])
    rows = [foretold(row, std * (i % 3), std) for i, row in enumerate(run[1][1:7])]
    for row in [run[1][0], *rows]:
        table.append(row)
    table.close()
    k, mean, spread, came = read(path)
    assert k.tolist() == [row.k for row in rows]
    np.testing.assert_array_equal(came, [actual(row) for row in rows])
    np.testing.assert_array_equal(mean, [row.action.proposal.forecast.mean for row in rows])
    np.testing.assert_allclose(spread, np.tile(std, (6, 1)), rtol=1e-15)
    assert table.calibration == pytest.approx(2 / 3)  # two sigma off is outside 1.96


def test_without_forecasts_there_is_no_file(tmp_path, run):
    table = Forecasts(tmp_path / "forecasts.csv")
    for row in run[1]:
        table.append(row)
    table.close()
    assert table.calibration is None
    assert not (tmp_path / "forecasts.csv").exists()


def test_a_row_that_was_cut_is_left_out_and_other_files_are_refused(tmp_path, run):
    path = tmp_path / "forecasts.csv"
    table = Forecasts(path)
    for row in run[1][1:4]:
        table.append(foretold(row, 0.0, np.full(4, 0.01)))
    table.close()
    path.write_bytes(path.read_bytes()[:-5])
    assert len(read(path)[0]) == 2
    path.write_text("k,other\n1,2\n")
    with pytest.raises(ValueError, match="not a table of forecasts"):
        read(path)
