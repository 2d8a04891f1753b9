"""The options of the group `record` are the settings they promise."""

import pytest
from omegaconf import OmegaConf

from deformpush.config import build as config
from deformpush.config.groups import conf_dir
from deformpush.record.settings import RecordSettings


@pytest.mark.parametrize(
    ("option", "differing"),
    [
        ("full", {}),
        ("light", {"scene": False, "motion": False, "image_px": 240, "jpeg_quality": 75}),
        ("off", dict.fromkeys(("rrd", "scene", "motion", "maps", "figures", "world_states"), False)),
    ],
)
def test_option(option, differing):
    node = OmegaConf.load(conf_dir() / "record" / f"{option}.yaml")
    assert config.build(node) == RecordSettings(**differing)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("connect", "nowhere", r"connect.*nowhere"),
        ("image_px", 20, r"image_px.*64"),
        ("jpeg_quality", 200, r"jpeg_quality.*100"),
    ],
)
def test_a_wrong_value_names_its_key(key, value, message):
    node = OmegaConf.load(conf_dir() / "record" / "full.yaml")
    node[key] = value
    with pytest.raises(ValueError, match=message):
        config.build(node)
