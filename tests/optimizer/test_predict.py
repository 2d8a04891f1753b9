"""Forecasts of xi for any pushes: what the decision is made on, with the noise of an outcome added."""

import numpy as np
import pytest

from deformpush.model.coordinates import to_model
from tests.setups import begun, setup

U = np.array([[0.2, 0.01], [0.55, 0.03], [0.9, 0.02]])


@pytest.fixture(params=["abo", "abo_motion"])
def episode(request):
    """After four pushes, asked for the fifth."""
    settings = ["optimizer.S0=2"] if request.param == "abo" else []
    made = begun(setup("world=toy", "robot=tool", f"optimizer={request.param}", "max_pushes=9", *settings))
    for _ in range(4):
        made.push()
    return made


def test_the_noise_is_added(episode):
    optimizer = episode.optimizer
    mean, std = optimizer.predict(U, episode.state)
    posterior = optimizer._know(None).posterior
    inside = to_model(U, optimizer.history.outer)
    for u, mu, sigma in zip(inside, mean, std, strict=True):
        known = posterior.expected(u)
        assert sigma > known[1]
        assert abs(mu - known[0]) < 0.3 * sigma
    if "noise" in posterior.info:
        noise = posterior.info["noise"] * posterior.info["scale"]
        np.testing.assert_allclose(std**2, [posterior.expected(u)[1] ** 2 + noise**2 for u in inside])


def test_it_changes_no_decision(episode):
    optimizer = episode.optimizer
    before = optimizer.state()
    optimizer.predict(U, episode.state)
    asked = optimizer.ask(episode.state)
    optimizer.predict(U, episode.state)
    assert optimizer.ask(episode.state) is asked
    optimizer.restore(before)
    np.testing.assert_array_equal(optimizer.ask(episode.state).u, asked.u)


@pytest.mark.parametrize(("name", "forecast"), [("abo", False), ("abo_motion", True), ("random", False)])
def test_before_the_first_push_only_a_model_with_a_prior_says_something(name, forecast):
    episode = begun(setup("world=toy", "robot=tool", f"optimizer={name}"))
    assert (episode.optimizer.predict(U, episode.state) is not None) == forecast
