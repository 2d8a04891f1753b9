"""A kernel of one's own behind ask and tell: every acquisition, both models, the limit, the configuration."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from deformpush.config.build import build
from deformpush.config.schema import ConfigError
from deformpush.gp import FormulaKernel, Matern52
from deformpush.model.motion import MotionModel
from deformpush.optimizer import ABO, EI, LCB, PI, Box, Components, Safe, Thompson
from deformpush.optimizer.acquisition import Context
from tests.own_kernel import RationalQuadratic
from tests.states import seen

OWN = {
    "space": FormulaKernel(space=RationalQuadratic()),
    "time": Matern52(time=RationalQuadratic()),
    "both": FormulaKernel(space=RationalQuadratic(), time=RationalQuadratic(2.0)),
}
ACQUISITIONS = [LCB(), EI(), PI(), Thompson(features=100), Safe(0.1, EI())]


def optimizer(kernel, acquisition=None, seed=0, **parts):
    rng = np.random.default_rng(seed)
    made_of = {"kernel": kernel, "acquisition": acquisition or LCB(), "closed": True} | parts
    return ABO(S0=4, parts=Components(bounds=Box(d=(0.01, 0.03)), rng=rng, **made_of))


def play(opt, pushes):
    asked = []
    for _ in range(pushes):
        proposal = opt.ask(seen())
        asked.append(proposal)
        kappa, d = proposal.u
        opt.tell(proposal.u, -10.0 * d * np.cos(2 * np.pi * (kappa - 0.3)), seen(), seen(y=0.4 * d))
    return asked


@pytest.mark.parametrize("acquisition", ACQUISITIONS, ids=lambda a: type(a).__name__)
@pytest.mark.parametrize("name", OWN)
def test_it_finds_what_works_and_learns_its_number(name, acquisition):
    asked = play(optimizer(OWN[name], acquisition), 10)
    assert abs(asked[-1].u[0] - 0.3) < 0.15 or isinstance(acquisition, Safe)
    assert np.isfinite([p.acq for p in asked[4:]]).all()
    alphas = [key for key in asked[-1].info if key.endswith("_alpha")]
    assert alphas == {"space": ["space_alpha"], "time": ["time_alpha"]}.get(
        name, ["space_alpha", "time_alpha"]
    )
    assert asked[-1].info[alphas[0]] != asked[-2].info[alphas[0]] != 1.0


@pytest.mark.parametrize("acquisition", [LCB(), EI(), PI(), Thompson(features=100)], ids=str)
@pytest.mark.parametrize("name", OWN)
def test_the_slope_of_an_acquisition_is_that_of_its_value(name, acquisition):
    opt = optimizer(OWN[name])
    play(opt, 8)
    posterior = opt._learner.posterior(opt._tried, opt.history.xi, None)
    objective = acquisition.objective(Context(posterior.surface, opt._tried, 8, np.random.default_rng(1)))
    U = np.random.default_rng(2).uniform(0.05, 0.95, (10, 2))
    value, slope = objective.gradient(U)
    np.testing.assert_allclose(value, objective.value(U), rtol=1e-9, atol=1e-12)
    for axis, step in enumerate(1e-6 * np.eye(2)):
        numeric = (objective.value(U + step) - objective.value(U - step)) / 2e-6
        np.testing.assert_allclose(slope[:, axis], numeric, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize(
    "parts", [{}, {"model": MotionModel(samples=16)}, {"acquisition": Safe(0.1)}], ids=str
)
def test_saved_and_restored(parts):
    one, other = optimizer(OWN["both"], seed=1, **parts), optimizer(OWN["both"], seed=9, **parts)
    play(one, 5)
    other.restore(one.state())
    for mine, theirs in zip(play(one, 2), play(other, 2), strict=True):
        np.testing.assert_array_equal(mine.u, theirs.u)
        assert mine.info == theirs.info


@pytest.fixture
def mine(tmp_path, monkeypatch):
    """Settings of the same kernel, from a file in a folder that the user named."""
    shutil.copy(Path(__file__).parents[1] / "own_kernel.py", tmp_path / "my_kernels.py")
    monkeypatch.setattr("deformpush.config.locate._trusted", [tmp_path])
    monkeypatch.syspath_prepend(tmp_path)
    yield {"_target_": "my_kernels.RationalQuadratic", "alpha": 2.0}
    sys.modules.pop("my_kernels", None)


def test_a_configuration_builds_it(mine):
    target = "deformpush.gp.kernels.FormulaKernel"
    kernel = build({"_target_": target, "space": mine, "time": mine, "rho_d": 0.4}, "kernel")
    expected = FormulaKernel(space=RationalQuadratic(2.0), time=RationalQuadratic(2.0), rho_d=0.4)
    np.testing.assert_array_equal(kernel.theta(), expected.theta())
    assert kernel.names == expected.names
    assert build({"_target_": target, "space": mine, "time": "ou"}, "kernel").time == "ou"


@pytest.mark.parametrize(
    ("time", "message"),
    [
        ("never", r"^kernel.time = \"never\": must be matern52 or matern32 or .* or Correlation$"),
        ({"_target_": "my_kernels.RationalQuadratic", "alpha": -1.0}, "^kernel.time.alpha = -1.0: must be a"),
        ({}, r"^kernel.time: Correlation must define __call__\(self, r\)$"),
        ({"_target_": "deformpush.gp.fit.MAP"}, r"^kernel.time._target_ = .*: must be a Correlation$"),
    ],
)
@pytest.mark.usefixtures("mine")
def test_what_is_wrong_in_a_configuration_is_said_in_a_line(time, message):
    with pytest.raises(ConfigError, match=message):
        build({"_target_": "deformpush.gp.kernels.Matern52", "time": time}, "kernel")
