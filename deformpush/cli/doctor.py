"""The verb `doctor`: run the gates of physics and accuracy and print them as a table."""

import argparse
from collections.abc import Sequence
from itertools import chain


def main(argv: Sequence[str]) -> int:
    """Check the simulator on this machine; exit code 0 when every gate holds, 1 otherwise.

    Raises:
        UserError: an override names something that does not exist.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush doctor",
        description="Check the simulator against textbook physics, repeatability and its own guard, the "
        "camera against the mesh, and the arm against its path.",
    )
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help="settings, such as object=meat")
    parser.add_argument(
        "--digest", action="store_true", help="only print the hash of a mesh after two pushes"
    )
    given = parser.parse_args(argv)

    from deformpush.checks import accuracy
    from deformpush.checks.physics import all_gates, digest
    from deformpush.experiment.assemble import build_bench

    bench = build_bench(given.overrides)
    if given.digest:
        print(digest(bench))
        return 0
    passed = True
    print(f"{'gate':34}{'measured':40}{'allowed':30}")
    for gate in chain(all_gates(bench), accuracy.gates(given.overrides)):
        passed &= gate.passed
        print(
            f"{gate.name:34}{gate.measured:40}{gate.allowed:30}{'ok' if gate.passed else 'FAILED'}",
            flush=True,
        )
    print("all gates hold" if passed else "a gate fails: do not trust numbers from this machine")
    return 0 if passed else 1
