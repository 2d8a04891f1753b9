"""A run as lines of text, and the same in processes whose libraries compute in other ways.

    python -m tests.same_seed 12 object=rect seed=0

prints one line for each of 12 pushes: what stands in pushes.csv but for the times, and digests of what the
world and the camera gave. `lines_under` does that in a child process with other kernels, and

    python -m tests.same_seed --compare 12 object=rect seed=0

says for each of them whether the run is the same.
"""

import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
USUAL = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
SETTINGS: dict[str, dict[str, str]] = {
    "as it is": {},
    "Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
    "Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "SkylakeX": {"OPENBLAS_CORETYPE": "SkylakeX"},
    "generic": {"OPENBLAS_CORETYPE": "Prescott"},
    "two threads": {"OPENBLAS_NUM_THREADS": "2", "OMP_NUM_THREADS": "2"},
    "numpy plain": {"NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL"},
    "torch plain": {"ATEN_CPU_CAPABILITY": "default"},
    "torch avx2": {"ATEN_CPU_CAPABILITY": "avx2"},
    "OpenCV plain": {"OPENCV_CPU_DISABLE": "SSE4.1,SSE4.2,AVX,FP16,AVX2,FMA3,AVX512-SKX"},
    "libm plain": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-FMA4"},
    "all plain": {
        "OPENBLAS_CORETYPE": "Prescott",
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL",
        "ATEN_CPU_CAPABILITY": "default",
        "OPENCV_CPU_DISABLE": "SSE4.1,SSE4.2,AVX,FP16,AVX2,FMA3,AVX512-SKX",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-FMA4",
    },
}
"""By name: environment of a child process. Prescott's kernels are the plainest that OpenBLAS has here."""


def environment(setting: str) -> dict[str, str]:
    """Of a child process with these kernels."""
    return {**os.environ, **USUAL, **SETTINGS[setting], "PYTHONPATH": str(ROOT)}


def lines_under(setting: str, pushes: int, overrides: Sequence[str]) -> list[str]:
    """The lines of a run in a child process with these kernels."""
    command = [sys.executable, "-m", "tests.same_seed", str(pushes), *overrides]
    done = subprocess.run(command, env=environment(setting), cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout.splitlines()


def run(pushes: int, overrides: Sequence[str]) -> Iterator[str]:
    """The lines of a run in this process."""
    from deformpush.loop import Episode
    from deformpush.record.table import TIMES, cells
    from tests.setups import begun, setup

    def line(episode: Episode) -> str:
        view = episode.record.view
        seen = [
            view.picture,
            view.seen.contour,
            view.seen.gamma,
            *(() if view.nodes is None else [view.nodes]),
        ]
        digests = [hashlib.sha1(np.ascontiguousarray(x).tobytes()).hexdigest()[:8] for x in seen]
        row = {name: x for name, x in cells(episode.record, 0.0).items() if name not in TIMES}
        pose = [*view.seen.c.tolist(), view.seen.theta, *view.joints.values()]
        return " ".join([*(f"{name}={x!r}" for name, x in row.items()), f"pose={pose}", *digests])

    episode = begun(setup(*overrides))
    yield line(episode)
    for _ in range(pushes):
        episode.push()
        yield line(episode)
        if episode.ending is not None:
            return


def first_difference(one: Sequence[str], other: Sequence[str]) -> str | None:
    """The first push in which two runs differ, and in what; None where they are the same."""
    for k, (a, b) in enumerate(zip(one, other, strict=False)):
        if a != b:
            apart = [f"{x} | {y}" for x, y in zip(a.split(" "), b.split(" "), strict=False) if x != y]
            return f"push {k}: " + "; ".join(apart[:12])
    return None if len(one) == len(other) else f"{len(one)} and {len(other)} lines"


def compare(pushes: int, overrides: Sequence[str]) -> None:
    """Say for each of `SETTINGS` whether a run under it is the usual one."""
    usual, *others = SETTINGS
    lines = lines_under(usual, pushes, overrides)
    print(f"{len(lines) - 1} pushes: {' '.join(overrides)}", flush=True)
    for name in others:
        other = first_difference(lines, lines_under(name, pushes, overrides))
        print(f"  {name:<14}{other or 'the same'}"[:300], flush=True)


if __name__ == "__main__":
    if sys.argv[1] == "--compare":
        compare(int(sys.argv[2]), sys.argv[3:])
    else:
        for text in run(int(sys.argv[1]), sys.argv[2:]):
            print(text, flush=True)
