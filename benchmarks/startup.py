"""How long the command line takes to answer: `python -m benchmarks.startup`."""

import subprocess
import sys
from time import perf_counter

QUESTIONS = (["--help"], ["--cfg", "job"], ["object=fish"])
REPEATS = 7
TARGET_S = 0.8


def seconds(argv: list[str]) -> list[float]:
    """Wall times of the command, sorted, each in a fresh process."""
    times = []
    for _ in range(REPEATS):
        start = perf_counter()
        subprocess.run([sys.executable, "-m", "deformpush", *argv], capture_output=True, check=False)
        times.append(perf_counter() - start)
    return sorted(times)


def main() -> None:
    """Print a table."""
    print(f"{'command':<24}{'best':>8}{'median':>8}{'target':>8}  (s)")
    for argv in QUESTIONS:
        times = seconds(argv)
        print(f"{' '.join(argv):<24}{times[0]:8.2f}{times[REPEATS // 2]:8.2f}{TARGET_S:8.2f}")


if __name__ == "__main__":
    main()
