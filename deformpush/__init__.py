"""deformpush: pushing thin, fragile, deformable objects to a pose with very few trial pushes.

    import deformpush

    run = deformpush.run("object=meat", "acq.w=2.0", seed=3)
    print(run.summary.pushes, run.pushes)

docs/api.md tells what there is. Names are loaded when they are first used, so that importing takes no time.
"""

from importlib import import_module

TYPE_CHECKING = False  # not from typing: __main__ has yet to see to it that no file of the folder is imported
__version__ = "0.2.0"
__all__ = [
    "Branch",
    "Optimizer",
    "Outcome",
    "Proposal",
    "Run",
    "Setup",
    "State",
    "Sweep",
    "ToolPath",
    "UserError",
    "World",
    "WorldError",
    "compose",
    "load",
    "presets",
    "run",
]

if TYPE_CHECKING:
    from deformpush.cell.push import ToolPath
    from deformpush.cell.world import Outcome, World, WorldError
    from deformpush.errors import UserError
    from deformpush.experiment import presets
    from deformpush.experiment.api import Run, Sweep, compose, load, run
    from deformpush.experiment.branch import Branch
    from deformpush.experiment.setup import Setup
    from deformpush.optimizer.base import Optimizer
    from deformpush.state import Proposal, State
else:
    _NAMES = {
        "cell.push": ("ToolPath",),
        "cell.world": ("Outcome", "World", "WorldError"),
        "errors": ("UserError",),
        "experiment.api": ("Run", "Sweep", "compose", "load", "run"),
        "experiment.branch": ("Branch",),
        "experiment.presets": ("presets",),
        "experiment.setup": ("Setup",),
        "optimizer.base": ("Optimizer",),
        "state": ("Proposal", "State"),
    }
    """By the module that has them; one named like its module is the module itself."""
    _HOME = {name: module for module, names in _NAMES.items() for name in names}

    def __getattr__(name: str) -> object:
        """Load a name of `__all__` when it is first used."""
        if name not in _HOME:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        module = import_module(f"{__name__}.{_HOME[name]}")
        globals()[name] = module if _HOME[name].endswith(f".{name}") else getattr(module, name)
        return globals()[name]

    def __dir__() -> list[str]:
        """What is loaded and what can be."""
        return sorted({*globals(), *__all__})
