"""From settings on the command line to what a run is made of, in one call."""

from deformpush.config.compose import compose
from deformpush.experiment.assemble import begin, build_cell, build_optimizer
from deformpush.experiment.setup import Setup, read
from deformpush.loop import Episode


def setup(*overrides: str) -> Setup:
    """The components that these settings describe."""
    return read(compose(overrides))


def begun(made: Setup) -> Episode:
    """A run before its first push, with nobody who writes it down."""
    return begin(made, build_cell(made), build_optimizer(made))
