"""Forecasts are drawn at two sigma, before the push they are of, and stand beside what came."""

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.record.forecasts import actual
from deformpush.viewer.forecast import ellipse
from tests.record.synthetic import CAMERA, SyntheticRun, foretold
from tests.viewer.recording import Contents, record


def metres(strip: list) -> np.ndarray:
    """Points of the picture back to the table."""
    return (np.array(strip) - CAMERA.pixels / 2) * (1, -1) / CAMERA.scale + CAMERA.centre


def test_the_ellipse_holds_two_sigma():
    cov = np.zeros((4, 4))
    cov[:2, :2] = [[4e-6, 1e-6], [1e-6, 1e-6]]
    outline = ellipse(np.array([0.5, 0.1, 0.0, 0.0]), cov) - (0.5, 0.1)
    mahalanobis = np.einsum("ni,ij,nj->n", outline, np.linalg.inv(cov[:2, :2]), outline)
    np.testing.assert_allclose(mahalanobis, 4.0, rtol=1e-9)


def test_ellipse_and_heading_are_drawn_at_the_state_the_push_is_chosen_in(full):
    ellipses = full.contents.at("/camera/forecast/centroid", "LineStrips2D:strips")
    headings = full.contents.at("/camera/forecast/angle", "LineStrips2D:strips")
    assert list(ellipses) == list(headings) == list(range(12))
    for row in full.rows[1:]:
        forecast = row.action.proposal.forecast
        off = metres(ellipses[row.k - 1][0]) - forecast.mean[:2]
        sigmas = np.sqrt((off**2 / np.diag(forecast.cov)[:2]).sum(1))
        np.testing.assert_allclose(sigmas, 2.0, rtol=0.02)
        tail, tip = metres(headings[row.k - 1][0])
        np.testing.assert_allclose((tail + tip) / 2, forecast.mean[:2], atol=1e-6)
        np.testing.assert_allclose(np.arctan2(*(tip - tail)[::-1]), forecast.mean[2], atol=1e-3)
    for name in ("centroid", "angle"):
        colours = full.contents.colours(f"/camera/forecast/{name}", "LineStrips2D:colors")
        assert colours == [palette.FORECAST]
    gone = full.contents.at("/camera/forecast", "Clear:is_recursive")
    assert gone == {k: [True] for k in range(13)}


def test_motion_stands_beside_its_forecast(full):
    """`moved` is measured along the way that was foretold."""
    states = [actual(row) for row in full.rows]
    for name, i in (("moved", 0), ("turned", 1)):
        came = full.contents.at(f"/motion/{name}/actual", "Scalars:scalars")
        told = full.contents.at(f"/motion/{name}/predicted", "Scalars:scalars")
        assert np.isnan(came[0][0])
        assert list(told) == list(range(1, 13))
        for row in full.rows[1:]:
            forecast, before, now = row.action.proposal.forecast, states[row.k - 1], states[row.k]
            way = forecast.mean[:2] - before[:2]
            length, std = np.linalg.norm(way), np.sqrt(np.diag(forecast.cov))
            along = way / length
            expected = [
                (1e3 * (now - before)[:2] @ along, 1e3 * length, 1e3 * np.linalg.norm(along * std[:2])),
                (np.degrees(now - before)[2], np.degrees(forecast.mean - before)[2], np.degrees(std[2])),
            ][i]
            np.testing.assert_allclose(came[row.k], expected[:1])
            mean, sigma = expected[1:]
            np.testing.assert_allclose(told[row.k], [mean, mean - 2 * sigma, mean + 2 * sigma])


def test_lines_say_what_they_are(full):
    assert full.contents.titles("/motion/moved/actual") == ["moved (mm)"]
    assert full.contents.titles("/motion/turned/actual") == ["turned (deg)"]
    for name in ("moved", "turned"):
        assert full.contents.titles(f"/motion/{name}/predicted") == ["predicted, 2 sigma"] * 3


def test_pushes_without_a_forecast_are_left_out(tmp_path):
    made = SyntheticRun(3, mesh=False)
    first, *pushes = made.records()
    made.info.options["model"] = "motion"
    rows = [first, pushes[0], foretold(pushes[1]), pushes[2]]
    contents = Contents(record(tmp_path / "run", made, rows, scene=False))
    assert list(contents.at("/camera/forecast/centroid", "LineStrips2D:strips")) == [1]
    assert list(contents.at("/motion/moved/predicted", "Scalars:scalars")) == [2]
    assert np.isfinite(contents.curves("/motion/moved/actual")[:, 0]).tolist() == [False, False, True, False]


@pytest.mark.parametrize("options", [{"maps": False}, {}])
def test_a_model_that_foretells_no_motion_has_no_such_entities(tmp_path, options):
    contents = Contents(record(tmp_path / "run", SyntheticRun(1, mesh=False), **options))
    assert not any(name.startswith(("/motion", "/camera/forecast")) for name in contents.entities)
