"""What the fuzzers have in common: cases by number, for some minutes."""

import argparse
import time
from collections import Counter
from collections.abc import Callable
from contextlib import AbstractContextManager

Case = Callable[[int], tuple[str, str]]
"""From a number to what became of its case (`wrong`, or another word), and what to print of it."""


def fuzz(description: str | None, cases: AbstractContextManager[Case]) -> int:
    """Try, count, and say what went wrong; 1 if anything did."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--minutes", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0, help="number of the first case")
    parser.add_argument("--show", action="store_true", help="print every case and what is said")
    asked = parser.parse_args()
    end, count, number = time.monotonic() + 60 * asked.minutes, Counter[str](), asked.seed
    with cases as case:
        while time.monotonic() < end:
            became, said = case(number)
            count[became] += 1
            if became == "wrong" or asked.show:
                print(f"{became}: {said}", flush=True)
            number += 1
    print(f"{count.total()} tried: {dict(sorted(count.items()))}")
    return int(count["wrong"] > 0)
