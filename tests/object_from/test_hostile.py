"""A stranger's file does no harm: it is refused in one line and in seconds, and nothing in it is followed."""

from time import process_time

import pytest

from deformpush.errors import UserError
from deformpush.outlines.picture import Scale
from tests.object_from.hostile import HOSTILE
from tests.object_from.making import made, preset


@pytest.mark.parametrize("name", HOSTILE)
def test_it_is_refused_in_a_line(name, tmp_path, capfd):
    file, content, message = HOSTILE[name]
    preset()
    (tmp_path / file).write_bytes(content())
    began = process_time()
    with pytest.raises(ValueError, match=message) as refused:
        made(tmp_path / file, scale=Scale(1.0))
    assert process_time() - began < 5.0
    line = refused.value.line if isinstance(refused.value, UserError) else str(refused.value)
    assert "\n" not in line
    assert len(line) < 400 + len(str(tmp_path))
    assert capfd.readouterr() == ("", "")
