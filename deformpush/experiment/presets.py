"""The optimizers of the command line as functions, one for each option of conf/optimizer.

    import numpy as np
    from deformpush import presets

    optimizer = presets.abo(d=(0.01, 0.03), rng=np.random.default_rng(0), closed=True)
    proposal = optimizer.ask()
    optimizer.tell(proposal.u, xi)

The arguments are the same for all:
    *settings: more settings, as on the command line: "acq.w=1.0", "acquisition=ei".
    d: shortest and longest push (m).
    rng: every random number of the optimizer comes from it.
    closed: whether kappa = 0 and kappa = 1 are the same point of the effective contour.
    kappa: where on the effective contour it may push; None: everywhere.

Every number stands in conf/ alone. A wrong setting raises `UserError`.
"""

from collections.abc import Sequence
from dataclasses import replace

from numpy.random import Generator

from deformpush.experiment.api import compose
from deformpush.experiment.assemble import build_optimizer
from deformpush.optimizer.base import Components, Optimizer

Range = tuple[float, float]
Part = Range | None


def abo(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """The paper's: an initial design, then a time-varying process on xi, adaptive bounds and LCB."""
    return _build("abo", settings, d, rng, closed, kappa)


def abo_motion(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """The best for pushing: learns how the object moves, from what a rigid body would do. It needs states."""
    return _build("abo_motion", settings, d, rng, closed, kappa)


def abo_tuned(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """The lowest regret on moving problems that are no pushing: learnt mean, less exploration."""
    return _build("abo_tuned", settings, d, rng, closed, kappa)


def safe(
    *settings: str, limit: float, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """`abo_motion` among the pushes that strain the object less than `limit` (-), with `safe_lcb`.

    It learns from the strain in the states; with "acq.signal=contour" from the contours pressed instead.
    """
    safety = ("acquisition=safe_lcb", f"object.strain_limit={limit!r}")
    return _build("abo_motion", (*safety, *settings), d, rng, closed, kappa)


def static_bo(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """Bayesian optimization that knows no time."""
    return _build("static_bo", settings, d, rng, closed, kappa)


def tv_gp_ucb(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """TV-GP-UCB (Bogunovic et al. 2016): forgets at a fixed rate."""
    return _build("tv_gp_ucb", settings, d, rng, closed, kappa)


def random(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """The floor: any push, any time."""
    return _build("random", settings, d, rng, closed, kappa)


def greedy(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """What a person would do: push towards the goal, off-centre to turn. It needs states."""
    return _build("greedy", settings, d, rng, closed, kappa)


def oracle(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """The limit, by cheating: tries pushes in the branches of the world that it is given by `attach`."""
    return _build("oracle", settings, d, rng, closed, kappa)


def cmaes(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """CMA-ES over (kappa, d). Needs the extra `rivals`."""
    return _build("cmaes", settings, d, rng, closed, kappa)


def botorch(*settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None) -> Optimizer:
    """BoTorch with the kernel of the paper. Needs the extra `rivals`."""
    return _build("botorch", settings, d, rng, closed, kappa)


def botorch_default(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """BoTorch as it comes. Needs the extra `rivals`."""
    return _build("botorch_default", settings, d, rng, closed, kappa)


def optuna_gp(
    *settings: str, d: Range, rng: Generator, closed: bool = False, kappa: Part = None
) -> Optimizer:
    """Optuna's GP sampler. Needs the extra `rivals`."""
    return _build("optuna_gp", settings, d, rng, closed, kappa)


def _build(
    option: str, settings: Sequence[str], d: Range, rng: Generator, closed: bool, kappa: Part
) -> Optimizer:
    """The optimizer as a run would build it, but for its random numbers and the contour.

    Raises:
        UserError: a setting is wrong.
    """
    limits = {"d": d} if kappa is None else {"d": d, "kappa": kappa}
    bounds = [f"bounds.{name}=[{float(low)!r},{float(high)!r}]" for name, (low, high) in limits.items()]
    setup = compose(f"optimizer={option}", *settings, *bounds)

    def make(parts: Components) -> Optimizer:
        return setup.optimizer(parts=replace(parts, rng=rng, closed=closed))

    return build_optimizer(replace(setup, optimizer=make))
