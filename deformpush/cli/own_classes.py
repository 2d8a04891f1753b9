"""The flag `--config-dir` of verbs that build the components of a run again."""

import argparse


def add(parser: argparse.ArgumentParser) -> None:
    """Give a verb the flag."""
    parser.add_argument("--config-dir", help="folder of your own classes, if the run used any")


def use(given: argparse.Namespace) -> None:
    """Let classes come from the folder, if one is given.

    Raises:
        UserError: there is no such folder.
    """
    from deformpush.config.locate import use_config_dir

    if given.config_dir:
        use_config_dir(given.config_dir)
