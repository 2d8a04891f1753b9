"""The line of a push and the speed along it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from deformpush.cell.push import ToolPath
from deformpush.worlds.tool_motion import Line, ramp


@given(
    length=st.floats(1e-3, 0.1),
    speed=st.floats(0.02, 0.5),
    acceleration=st.floats(0.2, 5),
    dt=st.floats(5e-4, 5e-3),
)
def test_the_tool_runs_from_rest_to_rest_within_its_limits(length, speed, acceleration, dt):
    s, v = ramp(length, speed, acceleration, dt).T
    assert s[-1] == pytest.approx(length)
    np.testing.assert_allclose(
        np.cumsum(v) * dt, s, atol=1e-12
    )  # a step's speed is what carries it to its end
    assert v.min() >= -1e-12
    assert v.max() <= speed * (1 + 1e-9)
    assert np.abs(np.diff(v, prepend=0.0, append=0.0)).max() <= acceleration * dt * (1 + 1e-6)
    assert len(s) * dt >= length / speed


def test_the_executed_line_begins_before_the_touch_and_ends_with_the_push():
    path = ToolPath(np.array([0.5, 0.1]), np.array([0.6, 0.8]), 0.02, 0.03)
    way = Line(path, 0.006)
    np.testing.assert_allclose(way.at(0.006), path.contact)
    np.testing.assert_allclose(way.at(way.length), path.end)
    assert way.length == pytest.approx(0.036)
