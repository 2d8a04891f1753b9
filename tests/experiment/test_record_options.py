"""The options of the group `record` build the recorder they promise."""

import pytest
from omegaconf import OmegaConf

from deformpush.config import build as config
from deformpush.config.groups import conf_dir
from deformpush.record.folder import RunFolder


@pytest.mark.parametrize(
    ("option", "rrd", "scene"), [("full", True, True), ("light", True, False), ("off", False, False)]
)
def test_option(tmp_path, option, rrd, scene):
    node = OmegaConf.load(conf_dir() / "record" / f"{option}.yaml")
    recorder = config.build(node, folder=RunFolder(tmp_path))
    assert (recorder.rrd, recorder.scene, recorder.spawn, recorder.connect) == (rrd, scene, False, None)


def test_a_wrong_address_names_its_key(tmp_path):
    node = OmegaConf.load(conf_dir() / "record" / "full.yaml")
    node.connect = "nowhere"
    with pytest.raises(ValueError, match=r"connect.*nowhere"):
        config.build(node, folder=RunFolder(tmp_path))
