"""Regret and calibration of one push, worked out by hand."""

import numpy as np
import pytest

from deformpush.study.push_regret import Trials, kendall_tau

NAN = np.nan
U = np.array([[0.1, 0.01], [0.4, 0.02], [0.6, 0.03], [0.9, 0.03], [0.5, 0.02]])


def numbers(xi, mean=(NAN,) * 5, std=(NAN,) * 5):
    return Trials(U, np.array(xi, float), np.array(mean, float), np.array(std, float)).numbers()


def test_the_push_made_counts_too():
    found = numbers([0.1, -0.1, NAN, 0.3, -0.2])
    assert (found["xi_best"], found["kappa_best"], found["d_best"]) == (-0.2, 0.5, 0.02)
    assert (found["regret"], found["rank"], found["trials"], found["failed"]) == (0.0, 1, 4, 1)
    assert found["xi_tried"] == pytest.approx(0.1)


def test_regret_by_hand():
    found = numbers([0.1, -0.1, NAN, -0.3, 0.0], [0.0, -0.2, -9.0, -0.1, 0.3], [0.1, 0.1, 0.1, 0.1, 0.2])
    assert (found["xi_best"], found["kappa_best"], found["rank"]) == (-0.3, 0.9, 3)
    assert found["regret"] == pytest.approx(0.3)
    assert (found["best_mean"], found["best_std"]) == (-0.1, 0.1)
    assert (found["xi_mean"], found["xi_std"]) == (0.3, 0.2)
    assert found["inference_regret"] == pytest.approx(
        -0.1 - -0.3
    )  # what failed cannot be the best by forecast
    z = np.array([1.0, 1.0, -2.0])
    assert found["z_mean"] == pytest.approx(z.mean(), abs=1e-12)
    assert found["z_rms"] == pytest.approx(np.sqrt(2.0))
    assert found["inside_95"] == pytest.approx(2 / 3)
    assert found["rmse"] == pytest.approx(np.sqrt(0.02))
    assert found["kendall_tau"] == pytest.approx(1 / 3)


def test_where_everything_fails_the_push_made_is_the_best():
    found = numbers([NAN] * 4 + [0.4], [0.0] * 5, [0.1] * 5)
    assert (found["regret"], found["rank"], found["failed"]) == (0.0, 1, 4)
    assert np.isnan([found["xi_tried"], found["inside_95"], found["kendall_tau"]]).all()


def test_kendalls_tau_is_that_of_scipy():
    from scipy.stats import kendalltau

    rng = np.random.default_rng(0)
    a, b = rng.integers(0, 6, (2, 30)).astype(float)
    assert kendall_tau(a, b) == pytest.approx(kendalltau(a, b).statistic)
    assert np.isnan(kendall_tau(a, np.zeros(30)))
