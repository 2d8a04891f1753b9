"""The angle by registration of contours and by their principal axis: `python -m benchmarks.angles`.

Two pictures (1.5 mm a pixel) of each object, turned by any angle in between; and contours whose points are
0.5 mm off each.
"""

import argparse

from deformpush.mechanics.registration import ROUND
from tests.mechanics.test_registration import ORDERS, SHAPES, errors, rms, seen, with_noise


def main() -> None:
    """Print the table: root mean square errors in degrees."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--pairs", type=int, default=200, help="pictures before and after a turn, each object"
    )
    pairs = parser.parse_args().pairs
    print("| object | order | registration | principal axis | registration, noise | principal axis, noise |")
    print("|---|---|---|---|---|---|")
    for name in SHAPES:
        if ORDERS[name] != ROUND:
            cells = [rms(off) for look in (seen, with_noise) for off in errors(name, look, pairs)]
            print(f"| {name} | {ORDERS[name]} | " + " | ".join(f"{cell:.2f}" for cell in cells) + " |")


if __name__ == "__main__":
    main()
