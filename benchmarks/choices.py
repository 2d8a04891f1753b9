"""What the regret benchmark compares: every choice of the config groups, one change from the paper each."""

from collections.abc import Callable
from typing import Any

import numpy as np

from deformpush import optimizer as o
from deformpush.optimizer.base import Components, Optimizer

BOUNDS = {"kappa": (0.0, 1.0), "d": (1.0, 2.0)}
Build = Callable[[np.random.Generator], Optimizer]


def abo(**parts: Any) -> Build:
    """The paper's optimizer with w = 2 on fixed bounds, with these parts changed."""
    S0 = parts.pop("S0", 10)

    paper = {"bounds": o.Box(**BOUNDS), "acquisition": o.LCB(w=2.0)}

    def build(rng: np.random.Generator) -> Optimizer:
        return o.ABO(parts=Components(**(paper | {"rng": rng} | parts)), S0=S0)

    return build


def rival(kind: Callable[..., Optimizer], **settings: Any) -> Build:
    """Another optimizer on fixed bounds."""
    return lambda rng: kind(parts=Components(bounds=o.Box(**BOUNDS), rng=rng), **settings)


CHOICES: dict[str, Build] = {
    "abo (paper)": abo(),
    "abo_tuned": abo(kernel=o.Matern52(time="matern32"), mean=o.Constant(), acquisition=o.LCB(w=1.0)),
    "random": rival(o.RandomPush),
    "static_bo": abo(kernel=o.Matern52(time="none")),
    "tv_gp_ucb": abo(kernel=o.Matern52(time="tv"), acquisition=o.LCBSchedule()),
    "kernel.time=ou": abo(kernel=o.Matern52(time="ou")),
    "kernel.time=tv": abo(kernel=o.Matern52(time="tv")),
    "kernel.time=window": abo(kernel=o.Matern52(time="window")),
    "kernel=matern32": abo(kernel=o.Matern32()),
    "kernel=rbf": abo(kernel=o.SquaredExponential()),
    "kernel=matern52_sum": abo(kernel=o.Matern52Sum()),
    "mean=constant": abo(mean=o.Constant()),
    "fit=fixed": abo(fit=o.Fixed()),
    "acq.w=1": abo(acquisition=o.LCB(w=1.0)),
    "acquisition=lcb_schedule": abo(acquisition=o.LCBSchedule()),
    "acquisition=ei": abo(acquisition=o.EI()),
    "acquisition=pi": abo(acquisition=o.PI()),
    "acquisition=thompson": abo(acquisition=o.Thompson()),
    "bounds=adaptive": abo(bounds=o.Adaptive(**BOUNDS)),
    "bounds=trust_region": abo(bounds=o.TrustRegion(**BOUNDS)),
    "design=sobol": abo(design=o.Sobol()),
    "design=random": abo(design=o.Random()),
    "minimiser=bfgs": abo(minimiser=o.BFGS()),
    "minimiser=adam_torch": abo(minimiser=o.TorchAdam()),
    "minimiser=adam_single": abo(
        minimiser=o.Adam(screened=1, starts=1, steps=100, polish=False, incumbents=False)
    ),
    "abo_tuned acq.w=1.5 kernel.time=ou": abo(
        mean=o.Constant(), acquisition=o.LCB(w=1.5), kernel=o.Matern52(time="ou")
    ),
    "abo_tuned kernel.time=ou": abo(
        mean=o.Constant(), acquisition=o.LCB(w=1.0), kernel=o.Matern52(time="ou")
    ),
    "abo_tuned kernel.time=matern52": abo(mean=o.Constant(), acquisition=o.LCB(w=1.0)),
    "abo_tuned acq.w=1.5": abo(
        kernel=o.Matern52(time="matern32"), mean=o.Constant(), acquisition=o.LCB(w=1.5)
    ),
    "abo_tuned acquisition=ei": abo(
        mean=o.Constant(), acquisition=o.EI(), kernel=o.Matern52(time="matern32")
    ),
    "static_bo mean=constant": abo(kernel=o.Matern52(time="none"), mean=o.Constant()),
    "cmaes": rival(o.CMAES),
    "optuna_gp": rival(o.OptunaGP),
    "botorch": rival(o.BoTorch),
    "botorch w=1": rival(o.BoTorch, w=1.0),
    "botorch_default": rival(o.BoTorch, kernel="default"),
}
