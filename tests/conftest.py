"""What tests of several rooms share."""

import os

# Before numpy and torch are imported: the workers of pytest-xdist share the cores.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from collections.abc import Callable
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir
from hydra.core.hydra_config import HydraConfig
from hypothesis import settings
from omegaconf import DictConfig, open_dict

from deformpush.config.build import OPTIONS
from deformpush.config.groups import conf_dir

# How long an example takes depends on what else the machine does; whether a change lands must not depend
# on chance.
settings.register_profile("deformpush", deadline=None, derandomize=bool(os.environ.get("CI")))
settings.load_profile("deformpush")

Composer = Callable[..., DictConfig]


@pytest.fixture
def composed() -> Composer:
    """Compose a configuration from overrides, the chosen options in it as in a run."""

    def composer(*overrides: str, folder: Path | None = None) -> DictConfig:
        with initialize_config_dir(str(folder or conf_dir()), version_base="1.3"):
            whole = compose("config", overrides=list(overrides), return_hydra_config=True)
        choices = whole.hydra.runtime.choices
        with open_dict(whole):
            del whole["hydra"], whole["sweep"]
            whole[OPTIONS] = {group: option for group, option in choices.items() if "/" not in group}
        return whole

    HydraConfig.instance().cfg = None
    return composer
