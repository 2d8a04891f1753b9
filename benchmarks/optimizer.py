"""Time and quality of one decision, side by side with libraries: `python -m benchmarks.optimizer [SECTION]`.

Sections: `decision` (tell, fit, acquisition; S = 10 to 200), `minimum` (the LCB found against a dense grid),
`thousand` (the rule for many samples), `loop` (60 decisions), `import`. Processor time of one thread.
"""

import argparse
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable

import numpy as np

from deformpush.gp import MAP, Matern52, Regressor, Zero
from deformpush.gp.regression import Posterior
from deformpush.optimizer import ABO, LCB, Adam, BoTorch, Box, Components, Optimizer, OptunaGP
from deformpush.optimizer.acquisition import Context
from deformpush.optimizer.minimiser import polished

OUTER = Box(kappa=(0.0, 1.0), d=(1.0, 2.0))
SIZES = (10, 30, 60, 100, 200)


def moving_bumps(U: np.ndarray, t: float) -> np.ndarray:
    """Two bumps that drift; U `(n, 2)` in the unit square."""
    k, d = U.T
    c0, c1 = 0.5 + 0.35 * np.sin(2 * np.pi * t / 60), 0.5 + 0.3 * np.cos(2 * np.pi * t / 45)
    first = np.exp(-(((k - c0) / 0.22) ** 2) - ((d - c1) / 0.3) ** 2)
    second = np.exp(-(((k - 1 + c0) / 0.15) ** 2) - ((d - 0.2) / 0.25) ** 2)
    return -first - 0.6 * second + 0.25 * d


def samples(S: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """S pushes, ten spread out and then mostly good ones, with noise: unit U `(S, 2)` and xi `(S,)`."""
    rng = np.random.default_rng(seed)
    U, xi = rng.random((S, 2)), np.empty(S)
    for t in range(S):
        if t >= 10 and rng.random() < 0.7:
            candidates = rng.random((200, 2))
            U[t] = candidates[np.argmin(moving_bumps(candidates, t))]
        xi[t] = moving_bumps(U[t : t + 1], t)[0] + 0.03 * rng.normal()
    return U, xi


def abo(seed: int) -> ABO:
    """The paper's optimizer on fixed bounds."""
    return ABO(parts=abo_parts(seed), S0=5)


def ours_and_libraries() -> dict[str, Callable[[int], Optimizer]]:
    """Constructors by name; libraries that are not installed are left out, by name."""
    found: dict[str, Callable[[int], Optimizer]] = {"deformpush": abo}
    for name, build in {
        "BoTorch, separable kernel": lambda seed: BoTorch(parts=abo_parts(seed), S0=5),
        "BoTorch, default kernel": lambda seed: BoTorch(parts=abo_parts(seed), S0=5, kernel="default"),
        "Optuna GPSampler": lambda seed: OptunaGP(parts=abo_parts(seed), S0=5),
    }.items():
        try:
            build(0)
            found[name] = build
        except ValueError as error:
            print(f"left out: {error}")
    return found


def abo_parts(seed: int) -> Components:
    """Fixed bounds, w = 2 and a generator."""
    return Components(bounds=OUTER, acquisition=LCB(w=2.0), rng=np.random.default_rng(seed))


def one_decision(build: Callable[[int], Optimizer], S: int, seed: int) -> float:
    """Seconds for tell and ask at S samples, a decision having been made just before."""
    U, xi = samples(S, seed)
    optimizer = build(seed)
    for u, value in zip(U[:-1] + np.array([0.0, 1.0]), xi[:-1], strict=True):
        optimizer.tell(u, value)
    optimizer.ask()
    began = time.process_time()
    optimizer.tell(U[-1] + np.array([0.0, 1.0]), xi[-1])
    optimizer.ask()
    return time.process_time() - began


def scikit_optimize_decision(S: int, seed: int) -> float:
    """Seconds for tell and ask of scikit-optimize's GP and LCB (it cannot pin the time, so it has none)."""
    import skopt

    U, xi = samples(S, seed)
    optimizer = skopt.Optimizer(
        [(0.0, 1.0), (0.0, 1.0)], "GP", acq_func="LCB", n_initial_points=5, random_state=seed
    )
    optimizer.tell(U[:-1].tolist(), xi[:-1].tolist())
    optimizer.ask()
    began = time.process_time()
    optimizer.tell(U[-1].tolist(), float(xi[-1]))
    optimizer.ask()
    return time.process_time() - began


def decision(repeats: int) -> None:
    """Median milliseconds of one whole decision."""
    timers = {
        name: (lambda S, seed, build=build: one_decision(build, S, seed))
        for name, build in ours_and_libraries().items()
    }
    try:
        import skopt  # noqa: F401

        timers["scikit-optimize"] = scikit_optimize_decision
    except ModuleNotFoundError:
        print("left out: scikit-optimize is not installed; pip install 'deformpush[rivals]' brings it")
    print(f"| one decision, ms | {' | '.join(f'S = {S}' for S in SIZES)} |\n|---|{'---|' * len(SIZES)}")
    first: list[float] = []
    for name, timer in timers.items():
        timer(SIZES[0], 99)
        medians = [float(np.median([timer(S, seed) for seed in range(repeats)])) for S in SIZES]
        cells = [f"{1e3 * m:.1f}" for m in medians]
        if first:
            cells = [f"{c} ({m / f:.0f}x)" for c, m, f in zip(cells, medians, first, strict=True)]
        first = first or medians
        print(f"| {name} | {' | '.join(cells)} |", flush=True)


def random_context(seed: int, S: int) -> Context:
    """A posterior of a function drawn from the prior, length scales 0.1 to 1, xi standardised."""
    rng = np.random.default_rng(seed)
    kernel = Matern52(kappa=("open", "periodic")[seed % 2])
    theta = np.log([*np.exp(rng.uniform(np.log(0.1), 0.0, 2)), 20.0, 1.0, 0.1])
    tried = rng.random((S, 2))
    X = np.column_stack([tried, np.arange(S)])
    K = np.zeros((S, S))
    K[np.tril_indices(S, -1)] = kernel.gram(theta, kernel.distances(X))
    y = np.linalg.cholesky(K + K.T + 1.01 * np.eye(S)) @ rng.normal(size=S)
    return Context(Posterior.of(kernel, theta, Zero(), X, y, 1.0).at(S), tried, S, rng)


def minimum(posteriors: int) -> None:
    """How far the LCB found lies above the best of a 200 x 200 grid after polishing."""
    square, ticks = np.array([[0.0, 1.0]] * 2), np.linspace(0.0, 1.0, 200)
    grid = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
    gaps, single = [], []
    literal = Adam(screened=1, starts=1, steps=100, polish=False, incumbents=False)
    for seed in range(posteriors):
        objective = LCB(w=2.0).objective(random_context(seed, SIZES[seed % len(SIZES)]))
        values = objective.value(grid)
        lowest = int(np.argmin(values))
        _, target, _ = polished(objective, square, grid[lowest], float(values[lowest]))
        for search, found in ((Adam(), gaps), (literal, single)):
            rng = np.random.default_rng(seed)
            found.append(search(objective, square, np.empty((0, 2)), rng).value - target)
    for name, found in (("screened batch (default)", gaps), ("one start, 100 steps (literal)", single)):
        missed = np.mean(np.array(found) > 1e-6)
        print(f"| {name} | {np.median(found):.1e} | {max(found):.1e} | {100 * missed:.1f} % |", flush=True)


def thousand(_: int) -> None:
    """One decision at S = 1000, and what learning from the newest samples only costs in accuracy."""
    S = 1000
    U, xi = samples(S, 0)
    X, near = np.column_stack([U, np.arange(S)]), U[-100:]
    kernel = Matern52(kappa="open")
    truth = moving_bumps(near, S)
    for newest in (50, 100, 200, 400, S):
        gp = Regressor(kernel, Zero(), MAP(), newest)
        began = time.process_time()
        posterior, _ = gp.condition(X, xi, 0.0, S)
        spent = time.process_time() - began
        mean, std = posterior.at(S).predict(near)
        error = np.sqrt(np.mean((mean - truth) ** 2))
        z = np.sqrt(np.mean(((mean - truth) / std) ** 2))
        print(f"| {newest} | {spent:.2f} s | {error:.4f} | {z:.2f} |", flush=True)
    print(f"whole decision at S = {S}: {np.median([one_decision(abo, S, s) for s in range(3)]):.2f} s")


def loop(repeats: int) -> None:
    """Seconds for 60 pushes without a simulator."""
    spent = []
    for seed in range(repeats):
        optimizer = abo(seed)
        began = time.process_time()
        for t in range(60):
            u = optimizer.ask().u
            optimizer.tell(u, float(moving_bumps(u[None] - np.array([0.0, 1.0]), t)[0]))
        spent.append(time.process_time() - began)
    print(f"60 asks and tells: {np.median(spent):.2f} s")


def imports(repeats: int) -> None:
    """Seconds to import the optimizer in a fresh interpreter, start of Python subtracted."""
    code = "import time; t = time.process_time(); import deformpush.optimizer; print(time.process_time() - t)"
    runs = [
        subprocess.run([sys.executable, "-c", code], capture_output=True, text=True) for _ in range(repeats)
    ]
    print(f"import deformpush.optimizer: {np.median([float(r.stdout) for r in runs]):.2f} s")


def main() -> None:
    """Run the sections asked for."""
    sections = {
        "decision": decision,
        "minimum": minimum,
        "thousand": thousand,
        "loop": loop,
        "import": imports,
    }
    counts = {"decision": 7, "minimum": 200, "thousand": 1, "loop": 5, "import": 5}
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("sections", nargs="*", choices=[[], *sections], default=[])
    parser.add_argument("--repeats", type=int, help="repeats per figure")
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    if any(os.environ.get(v) != "1" for v in threads):
        # Thread pools are sized when the libraries load, so a fresh interpreter has to do it.
        os.execve(
            sys.executable,
            [sys.executable, "-m", "benchmarks.optimizer", *sys.argv[1:]],
            os.environ | threads,
        )
    for name in arguments.sections or sections:
        sections[name](arguments.repeats or counts[name])


if __name__ == "__main__":
    main()
