"""The settings of recording refuse what makes no sense; the options of the group: `test_record_options`."""

import re

import pytest

from deformpush.record.settings import ADDRESS, SPAWNED, RecordSettings


@pytest.mark.parametrize(
    "address", ["127.0.0.1:9876", "http://127.0.0.1:9876/proxy", "rerun://host/proxy", ""]
)
def test_an_address_that_is_none_is_refused_by_name(address):
    with pytest.raises(ValueError, match=r"^connect: .* is no address of a viewer, such as rerun"):
        RecordSettings(connect=address)


@pytest.mark.parametrize("address", [SPAWNED, "rerun://host:1/proxy", "rerun+https://a.b:65535/proxy"])
def test_an_address_is_taken(address):
    assert RecordSettings(connect=address).connect == address
    assert re.fullmatch(ADDRESS, address)["port"].isdigit()


def test_a_stream_is_needed_to_record_or_to_watch():
    assert RecordSettings().streams
    assert not RecordSettings(rrd=False).streams
    assert RecordSettings(rrd=False, spawn=True).streams
    assert RecordSettings(rrd=False, connect=SPAWNED).streams
