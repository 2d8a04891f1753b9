"""The maps show mean, sigma and acquisition, each under its name, with the pushes made on them."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.record import palette
from tests.record.synthetic import GRID, OUTER, SyntheticRun
from tests.viewer.recording import Contents, record


def picture(contents: Contents, name: str, k: int) -> np.ndarray:
    """A map `(n_d, n_kappa, 3)` with d upwards."""
    buffer = contents.at(f"/model/{name}/map", "Image:buffer")[k][0]
    return np.array(buffer, np.uint8).reshape(GRID, GRID, 3)[::-1]


def place(u: np.ndarray) -> np.ndarray:
    """Where a map 100 wide and 36 high shows pushes `(n, 2)`."""
    share = (u - OUTER[:, 0]) / (OUTER[:, 1] - OUTER[:, 0])
    return np.stack([100 * share[:, 0], 36 * (1 - share[:, 1])], 1)


@pytest.mark.parametrize(
    ("name", "least", "most"),
    [("std", palette.RAMP[0], palette.RAMP[-1]), ("acq", palette.RAMP[-1], palette.RAMP[0])],
)
def test_sigma_is_dark_where_it_is_large_and_the_acquisition_where_it_is_low(full, name, least, most):
    for row in full.rows[11:]:
        values, image = row.action.maps[name], picture(full.contents, name, row.k - 1)
        assert tuple(image[np.unravel_index(values.argmin(), values.shape)]) == least
        assert tuple(image[np.unravel_index(values.argmax(), values.shape)]) == most


def test_the_mean_is_balanced_about_zero(full):
    for row in full.rows[11:]:
        values, image = row.action.maps["mean"], picture(full.contents, "mean", row.k - 1)
        share = 0.5 + values / (2 * np.abs(values).max())
        np.testing.assert_allclose(image.astype(int), palette.ramp(share, palette.BALANCE), atol=1)


def test_a_scale_names_the_values_of_each_map(full):
    for row in full.rows[11:]:
        for name in ("std", "acq"):
            values = row.action.maps[name]
            low, high = values.min(), values.max()
            told = full.contents.at(f"/model/{name}/scale/labels", "Points2D:labels")[row.k - 1]
            assert told == [f"{value:.2g}" for value in (high, (low + high) / 2, low)]
        most = np.abs(row.action.maps["mean"]).max()
        told = full.contents.at("/model/mean/scale/labels", "Points2D:labels")[row.k - 1]
        assert told == [f"{most:+.2g}", "+0", f"{-most:+.2g}"]
    for name, top in (("mean", palette.BALANCE[-1]), ("std", palette.RAMP[-1]), ("acq", palette.RAMP[0])):
        assert full.contents.colours(f"/model/{name}/scale", "Points2D:colors")[0] == top
        assert full.contents.fixed(f"/model/{name}/scale/labels", "Points2D:show_labels") == [True]


def test_axes_name_kappa_and_d(full):
    labels = full.contents.fixed("/model/axes/labels", "Points2D:labels")
    assert labels == ["0", "kappa 0.5", "1", "d 30 mm", "10 mm"]
    strip = full.contents.colours("/model/axes/strip", "Points2D:colors")
    assert (strip[0], strip[-1]) == (palette.ALONG[0], palette.ALONG[-1])


def test_pushes_made_bounds_and_choice_stand_on_the_maps(full):
    data = full.contents.at("/model/data", "Points2D:positions")
    chosen = full.contents.at("/model/chosen", "Points2D:positions")
    centres = full.contents.at("/model/bounds", "Boxes2D:centers")
    halves = full.contents.at("/model/bounds", "Boxes2D:half_sizes")
    assert list(data) == list(chosen) == list(centres) == [10, 11], "there is no model before"
    made = np.array([row.action.u for row in full.rows[1:]])
    for row in full.rows[11:]:
        k = row.k - 1
        np.testing.assert_allclose(data[k], place(made[:k]), atol=1e-4)
        np.testing.assert_allclose(chosen[k], place(row.action.u[None]), atol=1e-4)
        corners = place(row.action.proposal.bounds.T)
        np.testing.assert_allclose(centres[k][0], corners.mean(0), atol=1e-4)
        np.testing.assert_allclose(halves[k][0], np.abs(corners[1] - corners[0]) / 2, atol=1e-4)
    assert full.contents.colours("/model/chosen", "Points2D:colors") == [palette.NEXT_PUSH]


def test_where_nothing_is_allowed_a_map_is_grey(tmp_path):
    made = SyntheticRun(11, mesh=False)
    rows = made.records()
    last = rows[-1].action
    partly, nowhere = last.maps["acq"].copy(), np.full((GRID, GRID), np.nan)
    partly[: GRID // 2] = np.nan
    maps = [{**last.maps, "acq": partly}, {**last.maps, "acq": nowhere}]
    more = [replace(rows[-1], k=11 + i, action=replace(last, maps=map_)) for i, map_ in enumerate(maps)]
    contents = Contents(record(tmp_path / "run", made, [*rows[:-1], *more], scene=False))
    half, none = (picture(contents, "acq", k) for k in (10, 11))
    grey = (half == palette.CLOSED).all(-1)
    assert grey[: GRID // 2].all()
    assert not grey[GRID // 2 :].any()
    assert (none == palette.CLOSED).all()
    assert contents.at("/model/acq/scale/labels", "Points2D:labels")[11] == ["-"] * 3
