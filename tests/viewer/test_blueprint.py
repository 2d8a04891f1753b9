"""The layout shows each part of the recording, under its name, and nothing that is not recorded."""

import numpy as np
import pytest

from deformpush.viewer.legends import Legends
from tests.record.synthetic import GOAL, START, SyntheticRun
from tests.viewer.recording import Contents, record
from tests.viewer.test_bottom_view import px

SEES = {"Bottom view": "camera", "Scene": "scene"}
GOES = {
    "Position error (mm)": "errors/position",
    "Angle error (deg)": "errors/angle",
    "Shape error (-)": "errors/shape",
    "xi (-)": "xi",
    "kappa (-)": "actions/kappa",
    "d (mm)": "actions/d",
    "Strain (%)": "strain",
    "Force of the tool (N)": "force",
    "Moved (mm)": "motion/moved",
    "Turned (deg)": "motion/turned",
    "Phase": "phase",
}
UNKNOWN = ("Strain (%)", "Force of the tool (N)", "Moved (mm)", "Turned (deg)")
"""Strips of what only some runs know."""
TEXTS = {"This push": "now", "About": "about", "Configuration": "config"}
MAPS = {"Mean of xi (-)": "mean", "Sigma of xi (-)": "std", "Acquisition (-), minimised": "acq"}


def test_all_there_is_stands_in_three_columns(full):
    assert full.contents.columns() == [list(SEES), list(GOES), [*TEXTS, *MAPS]]
    shown = {view.name: view.origin for view in full.contents.views}
    assert shown == SEES | GOES | TEXTS | dict.fromkeys(MAPS, "model")
    kinds = {view.name: view.kind for view in full.contents.views}
    assert {kinds[name] for name in GOES if name != "Phase"} == {"TimeSeries"}
    assert (kinds["Scene"], kinds["Phase"], kinds["About"]) == ("3D", "StateTimeline", "TextDocument")


def test_every_view_has_something_to_show(full):
    for view in full.contents.views:
        paths = [path.removeprefix("+ ") for path in view.contents]
        assert all(path.startswith(("$origin", "/")) for path in paths)
        for path in (path.replace("$origin", f"/{view.origin}").removesuffix("/**") for path in paths):
            assert any(f"{entity}/".startswith(f"{path}/") for entity in full.contents.entities), path


@pytest.mark.parametrize("title", MAPS)
def test_a_map_is_shown_with_its_axes_and_marks(full, title):
    shown = [f"/model/{MAPS[title]}/**", "/model/axes/**", "/model/data", "/model/bounds", "/model/chosen"]
    assert full.contents.view(title).contents == tuple(f"+ {path}" for path in shown)
    bounds = full.contents.view(title).properties["VisualBounds2D:range"][0]
    assert bounds["x_range"][0] < 0 < 110 < bounds["x_range"][1], "scale and axes fit"
    assert bounds["y_range"][0] < 0 < 39 < bounds["y_range"][1]


@pytest.mark.parametrize(
    ("options", "columns"),
    [
        ({"scene": False}, [["Bottom view", *TEXTS], 2, list(MAPS)]),
        ({"maps": False}, [list(SEES), 2, list(TEXTS)]),
        ({"scene": False, "maps": False}, [["Bottom view", *TEXTS], 2]),
    ],
)
def test_what_is_not_recorded_has_no_view(tmp_path, options, columns):
    contents = Contents(record(tmp_path / "run", SyntheticRun(1, mesh=False), **options))
    strips = [name for name in GOES if name not in UNKNOWN]
    assert contents.columns() == [strips if column == 2 else column for column in columns]
    assert contents.entry.application_id == (
        "deformpush"
        + ("" if options.get("scene", True) else "-without-scene")
        + ("" if options.get("maps", True) else "-without-maps")
    )


def test_the_timeline_of_pushes_leads(full):
    assert full.contents.layout("/time_panel", "TimePanelBlueprint:timeline") == ["push"]
    for name in GOES:
        link = full.contents.view(name).properties["TimeAxis:link"]
        assert link == [2], "strips move together"


def test_object_and_goal_are_in_the_middle_of_what_is_seen_first(full):
    bounds = full.contents.view("Bottom view").properties["VisualBounds2D:range"][0]
    places = px(np.vstack([full.rows[0].view.seen.contour, full.info.target.outline]))
    for axis, name in enumerate(("x_range", "y_range")):
        low, high = bounds[name]
        assert low < places[:, axis].min() < places[:, axis].max() < high
    target = full.contents.view("Scene").properties["EyeControls3D:look_target"][0]
    np.testing.assert_allclose(target[:2], (START + GOAL)[:2] / 2, atol=0.03)


def test_legends_stand_where_least_of_what_was_recorded_is_drawn(full):
    """The corners are known at the end and stand in the file all the same."""
    legends, parts = Legends(), ("", "/bounds", "/actual", "/predicted")
    for strip in list(GOES.values())[:-1]:
        for part in (part for part in parts if f"/{strip}{part}" in full.contents.entities):
            for k, values in full.contents.at(f"/{strip}{part}", "Scalars:scalars").items():
                legends.add(strip, k, values, part)
    expected = {strip: [corner.value] for strip, corner in legends.free().items()}
    views = [full.contents.view(name) for name in GOES if name != "Phase"]
    assert {view.origin: view.properties["PlotLegend:corner"] for view in views} == expected
    assert len({corner for (corner,) in expected.values()}) > 2
