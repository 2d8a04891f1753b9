"""Which kernels the numerical libraries of this process compute with: what may differ in a last bit."""

import sys
from typing import Any


def kernels() -> dict[str, Any]:
    """Name the kernels that have been chosen for this processor, for those libraries that are loaded.

    Returns:
        `blas`: of each library its file's name, version, kernel and threads; `numpy`: optional instructions
        in use; `torch` and `opencv`: theirs, where they are loaded. Loading them to ask would cost seconds.
    """
    from threadpoolctl import threadpool_info  # type: ignore[import-untyped]

    found: dict[str, Any] = {
        "blas": [
            {
                "library": pool["filepath"].rsplit("/", 1)[-1],
                "version": pool["version"],
                "kernel": pool.get("architecture"),
                "threads": pool["num_threads"],
            }
            for pool in threadpool_info()
            if pool["user_api"] == "blas"
        ],
        "numpy": _numpy_features(),
    }
    if torch := sys.modules.get("torch"):
        found["torch"] = torch.backends.cpu.get_cpu_capability()
    if cv2 := sys.modules.get("cv2"):
        found["opencv"] = cv2.getCPUFeaturesLine() if cv2.useOptimized() else "plain"
    return found


def _numpy_features() -> list[str]:
    """Optional instructions that this process lets numpy use."""
    import numpy as np

    simd: dict[str, list[str]] = np.show_config(mode="dicts")["SIMD Extensions"]  # type: ignore[assignment]
    return simd.get("found", [])
