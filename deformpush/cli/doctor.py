"""The verb `doctor`: run the gates of contract, physics and accuracy and print them as a table."""

import argparse
from collections.abc import Sequence

WIDTHS = (34, 42, 28)


def main(argv: Sequence[str]) -> int:
    """Check the world on this machine; exit code 0 when every gate holds, 1 otherwise.

    Raises:
        UserError: an override names something that does not exist.
    """
    parser = argparse.ArgumentParser(
        prog="python -m deformpush doctor",
        description="Put a world through its contract. For world=bullet and world=mujoco also check the "
        "physics against textbooks, repeatability and the guard, the camera against the mesh, and the arm "
        "against its path.",
        epilog="example: python -m deformpush doctor world=mine --config-dir conf_mine",
    )
    parser.add_argument("overrides", nargs="*", metavar="KEY=VALUE", help="settings, such as object=meat")
    parser.add_argument("--config-dir", help="folder of your own YAML files and classes")
    parser.add_argument(
        "--digest", action="store_true", help="only print the hash of a mesh after two pushes"
    )
    given = parser.parse_intermixed_args(argv)

    from deformpush.checks.by_world import build_bench, gates
    from deformpush.checks.physics import digest
    from deformpush.config.locate import use_config_dir

    overrides = list(given.overrides)
    if given.config_dir:
        overrides.append(use_config_dir(given.config_dir))
    if given.digest:
        print(digest(build_bench(overrides)))
        return 0
    passed = True
    print(
        "".join(
            f"{title:{width}}" for title, width in zip(("gate", "measured", "allowed"), WIDTHS, strict=True)
        )
    )
    for gate in gates(overrides):
        passed &= gate.passed
        cells = zip((gate.name, gate.measured, gate.allowed), WIDTHS, strict=True)
        row = "".join(f"{text:{width - 1}} " for text, width in cells)
        print(f"{row}{'ok' if gate.passed else 'FAILED'}", flush=True)
    print("all gates hold" if passed else "a gate fails: do not trust numbers from this world")
    return 0 if passed else 1
