"""How the viewer lays the recording out on a 16:9 screen: what it sees, how it goes, why it pushes there."""

from collections.abc import Mapping

import rerun.blueprint as rrb

from deformpush.push_record import RunInfo
from deformpush.task import TERMS

Part = rrb.View | rrb.Container

STRIPS = {
    **{f"errors/{term.name}": term.label[0].upper() + term.label[1:] for term in TERMS},
    "xi": "xi (-)",
    "actions/kappa": "kappa (-)",
    "actions/d": "d (mm)",
}
FREE = {f"errors/{TERMS[0].name}": rrb.Corner2D.RightTop}
"""Where a legend hides little while nothing else is known: the first error falls."""
STRAIN, FORCE = {"strain": "Strain (%)"}, {"force": "Force of the tool (N)"}
"""Strips of worlds that measure it; both share one place."""
MOTION = {"motion/moved": "Moved (mm)", "motion/turned": "Turned (deg)"}
"""Strips of runs that foretell the motion."""
MAPS = {"mean": "Mean of xi (-)", "std": "Sigma of xi (-)", "acq": "Acquisition (-), minimised"}


def blueprint(
    info: RunInfo,
    scene: bool,
    maps: bool,
    seen: rrb.VisualBounds2D | None = None,
    focus: tuple[float, float] | None = None,
    legends: Mapping[str, rrb.Corner2D] = FREE,
    strain: bool = False,
) -> rrb.Blueprint:
    """Lay out the panels that are recorded; the `push` timeline leads.

    Args:
        info: about the run.
        scene: whether there is a 3D scene.
        maps: whether there are maps of the model.
        seen: part of the bottom view to show at first (px); all of it by default.
        focus: place on the table the scene is looked at (m); its middle by default.
        legends: where the legends of the strips stand; left above by default.
        strain: whether the world measures the strain.
    """
    text: Part = rrb.Tabs(
        rrb.TextDocumentView(origin="now", name="This push"),
        rrb.TextDocumentView(origin="about", name="About"),
        rrb.TextDocumentView(origin="config", name="Configuration"),
    )
    bottom = rrb.Spatial2DView(
        origin="camera",
        name="Bottom view",
        background=(255, 255, 255),
        visual_bounds=seen,
    )
    sees: list[Part] = [bottom, _scene(focus or info.scenery.table_centre[:2]) if scene else text]
    why: list[Part] = ([text] if scene else []) + ([_map(*item) for item in MAPS.items()] if maps else [])
    motion = info.options["model"] == "motion"
    shown: list[Part] = [_strip(*item, legends) for item in STRIPS.items()]
    if harm := (STRAIN if strain else {}) | (FORCE if "force" in info.offers else {}):
        strips = [_strip(*item, legends) for item in harm.items()]
        shown.append(strips[0] if len(strips) == 1 else rrb.Tabs(*strips))
    shown += [_strip(*item, legends) for item in MOTION.items()] if motion else []
    phase = rrb.StateTimelineView(
        origin="phase", name="Phase", titlebar=False, time_view=rrb.TimeAxis(link="LinkToGlobal")
    )
    columns: list[Part] = [
        rrb.Vertical(*sees, row_shares=[0.55, 0.45]),
        rrb.Vertical(*shown, phase, row_shares=[1.3 if _leads(part) else 1.0 for part in shown] + [0.75]),
    ]
    if why:
        columns.append(
            rrb.Vertical(*why, row_shares=([0.44] if scene else []) + [0.187] * (3 if maps else 0))
        )
    return rrb.Blueprint(
        rrb.Horizontal(*columns, column_shares=[0.31, 0.38, 0.31][: len(columns)]),
        rrb.TimePanel(state="collapsed", timeline="push"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _strip(origin: str, name: str, legends: Mapping[str, rrb.Corner2D]) -> rrb.View:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        titlebar=False,
        plot_legend=legends.get(origin, rrb.Corner2D.LeftTop),
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
    )


def _leads(part: Part) -> bool:
    """Whether it is the strip of xi, whose band wants room."""
    return isinstance(part, rrb.View) and part.origin == "xi"


def _map(name: str, title: str) -> rrb.Spatial2DView:
    shown = [f"model/{name}/**", "model/axes/**", "model/data", "model/bounds", "model/chosen"]
    return rrb.Spatial2DView(
        origin="model",
        contents=[f"+ /{path}" for path in shown],
        name=title,
        visual_bounds=rrb.VisualBounds2D(x_range=(-17, 120), y_range=(-3, 48)),
    )


def _scene(focus: tuple[float, float]) -> rrb.Spatial3DView:
    """Near enough to see the object stretch, from the side that the arm does not hide."""
    x, y = focus
    eye = rrb.EyeControls3D(
        position=(x + 0.28, y - 0.40, 0.38), look_target=(x - 0.02, y - 0.01, 0.05), eye_up=(0, 0, 1)
    )
    return rrb.Spatial3DView(origin="scene", name="Scene", eye_controls=eye, line_grid=False)
