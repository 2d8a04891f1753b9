"""Numbers over k are those of the run, with their stops, bounds and bands, and say what they are."""

from dataclasses import replace

import numpy as np
import pytest

from deformpush.record import palette
from deformpush.task import TERMS, TOTAL
from tests.record.synthetic import FORCE_LIMIT, LIMIT, SyntheticRun
from tests.viewer.recording import Contents, record, rgb

STOPS = {"position": 20.0, "angle": 7.0, "shape": 0.15}
SCALES = {"position": 1e3, "angle": 180 / np.pi, "shape": 1.0}


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_an_error_stands_beside_its_stop(full, term):
    path = f"/errors/{term.name}"
    sizes = [abs(row.errors[term.column]) * SCALES[term.name] for row in full.rows]
    np.testing.assert_allclose(full.contents.curves(path), [[size, STOPS[term.name]] for size in sizes])
    assert full.contents.titles(path) == [f"{term.name} ({term.unit})", "stop"]
    assert full.contents.colours(path, "SeriesLines:colors") == [term.colour, palette.STOP]


def test_the_total_error_is_plotted(full):
    assert full.contents.curves("/errors/total")[:, 0].tolist() == [row.errors.e_T for row in full.rows]
    assert full.contents.titles("/errors/total") == ["e_T (-)"]
    assert full.contents.colours("/errors/total", "SeriesLines:colors") == [TOTAL.colour]


def test_strain_is_plotted_in_percent_beside_its_limit(full):
    curves = full.contents.curves("/strain")
    strains = [row.action.outcome.strain for row in full.rows[1:]]
    assert np.isnan(curves[0, :2]).all()
    np.testing.assert_allclose(curves[1:, 0], [100 * strain.p99_peak for strain in strains])
    np.testing.assert_allclose(curves[1:, 1], [100 * strain.residual for strain in strains])
    assert curves[:, 2].tolist() == [100 * LIMIT] * 13
    assert full.contents.titles("/strain") == ["peak strain (%)", "at rest", "limit"]
    assert full.contents.colours("/strain", "SeriesLines:colors")[::2] == [palette.PEAK, palette.STOP]


def test_without_a_limit_or_without_strain_no_line_is_made_up(tmp_path, plain):
    made = SyntheticRun(2)
    made.info = replace(made.info, strain_limit=None)
    unlimited = Contents(record(tmp_path / "run", made))
    assert unlimited.titles("/strain") == ["peak strain (%)", "at rest"]
    assert unlimited.curves("/strain").shape == (3, 2)
    assert "/strain" not in plain.contents.entities


def test_force_is_plotted_beside_its_limit(full, plain):
    curves = full.contents.curves("/force")
    pushes = [row.action.outcome for row in full.rows[1:]]
    assert np.isnan(curves[0, :2]).all()
    assert curves[1:, 0].tolist() == [push.tool_force_peak for push in pushes]
    assert curves[1:, 1].tolist() == [push.tool_force_mean for push in pushes]
    assert curves[:, 2].tolist() == [FORCE_LIMIT] * 13
    assert full.contents.titles("/force") == ["peak force (N)", "mean", "limit"]
    assert "/force" not in plain.contents.entities


@pytest.mark.parametrize(
    ("i", "name", "title", "scale", "colour"),
    [(0, "kappa", "kappa (-)", 1.0, palette.KAPPA), (1, "d", "d (mm)", 1e3, palette.D)],
)
def test_an_action_stands_inside_its_bounds(full, i, name, title, scale, colour):
    path, pushes = f"/actions/{name}", full.rows[1:]
    assert np.isnan(full.contents.curves(path)[0, 0]), "all plots begin at k = 0"
    np.testing.assert_allclose(full.contents.curves(path)[1:, 0], [row.action.u[i] * scale for row in pushes])
    bounds = [row.action.proposal.bounds[i] * scale for row in pushes]
    np.testing.assert_allclose(full.contents.curves(f"{path}/bounds"), bounds)
    assert full.contents.titles(path) == [title]
    assert full.contents.titles(f"{path}/bounds") == ["bounds"] * 2
    assert rgb(full.contents.fixed(path, "SeriesPoints:colors")[0]) == colour, "pushes are marked"


def test_xi_stands_beside_the_band_of_two_sigma_that_was_predicted(full):
    came = full.contents.curves("/xi/actual")[:, 0]
    assert np.isnan(came[0])
    assert came[1:].tolist() == [row.action.xi for row in full.rows[1:]]
    told = {row.k: row.action.proposal for row in full.rows[1:] if np.isfinite(row.action.proposal.mean)}
    found = full.contents.at("/xi/predicted", "Scalars:scalars")
    assert list(found) == list(told) == [11, 12], "nothing is predicted for the initial design"
    for k, proposal in told.items():
        mean, std = proposal.mean, proposal.std
        np.testing.assert_allclose(found[k], [mean, mean - 2 * std, mean + 2 * std])
    assert full.contents.titles("/xi/actual") == ["xi (-)"]
    assert full.contents.titles("/xi/predicted") == ["predicted, 2 sigma"] * 3
    assert full.contents.fixed("/xi/predicted", "SeriesLines:widths") == [1.5, 0.75, 0.75]


def test_the_phase_of_push_k_stands_at_the_state_it_was_chosen_in(full):
    found = full.contents.at("/phase", "StateChange:state")
    assert found == {row.k - 1: [row.action.proposal.phase] for row in full.rows[1:]}
    assert full.contents.fixed("/phase", "StateConfiguration:labels") == list(palette.PHASES)
    colours = full.contents.colours("/phase", "StateConfiguration:colors")
    assert colours == list(palette.PHASES.values())
