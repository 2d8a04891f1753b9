"""A value of the wrong type in a JSON file is one line that names it."""

import pytest
from pydantic import BaseModel, ConfigDict

from deformpush.record.checked import checked


class Known(BaseModel):
    """A file with two keys."""

    model_config = ConfigDict(strict=True)
    count: int
    inner: dict[str, float] = {}


def test_what_is_as_it_should_be_is_given_back():
    found = {"count": 3, "inner": {"a": 1.5}, "more": [1]}
    assert checked(found, Known, "a.json") is found


@pytest.mark.parametrize(
    ("found", "message"),
    [
        ({"count": "3"}, r'^a\.json is damaged: count = "3": input should be a valid integer$'),
        ({"count": True}, r"^a\.json is damaged: count = true: input should be a valid integer$"),
        (
            {"count": 1, "inner": {"a": "x" * 500}},
            r'^a\.json is damaged: inner\.a = "x{56}\.\.\.: input should',
        ),
        ({}, r"^a\.json is damaged: count = \{\}: field required$"),
        ([], r"^a\.json is damaged: no keys in it$"),
        (None, r"^a\.json is damaged: no keys in it$"),
    ],
)
def test_what_is_not_is_one_line(found, message):
    with pytest.raises(ValueError, match=message) as caught:
        checked(found, Known, "a.json")
    assert "\n" not in str(caught.value)
