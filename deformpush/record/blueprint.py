"""How the viewer lays the recording out: what it sees, what it does, why, on a 16:9 screen."""

import rerun.blueprint as rrb

from deformpush.record.push_record import RunInfo


def blueprint(info: RunInfo, scene: bool, maps: bool) -> rrb.Blueprint:
    """Lay out the panels that are recorded; the `push` timeline leads."""
    sees: list[rrb.View | rrb.Container] = [
        rrb.Spatial2DView(origin="camera", name="Bottom view", background=(255, 255, 255))
    ]
    if scene:
        sees.append(_scene(info))
    numbers = rrb.Vertical(
        _plot("errors", "Errors and their stops"),
        _plot("xi", "xi: predicted and actual"),
    )
    actions = rrb.Vertical(
        _plot("actions/kappa", "kappa and its bounds"),
        _plot("actions/d", "d and its bounds (mm)"),
    )
    words = rrb.Tabs(
        rrb.TextDocumentView(origin="now", name="This push"),
        rrb.TextDocumentView(origin="about", name="About"),
        rrb.TextDocumentView(origin="config", name="Configuration"),
    )
    why: list[rrb.View | rrb.Container] = []
    if maps:
        why = [
            rrb.Spatial2DView(origin=f"model/{name}", name=title)
            for name, title in (("mean", "Mean of xi"), ("std", "Sigma of xi"), ("acq", "Acquisition"))
        ]
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(*sees, words, column_shares=[1.0] * len(sees) + [0.8]),
            rrb.Horizontal(numbers, actions, *why),
            rrb.StateTimelineView(origin="phase", name="Phase"),
            row_shares=[0.5, 0.42, 0.08],
        ),
        rrb.TimePanel(state="collapsed", timeline="push"),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
    )


def _plot(origin: str, name: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(origin=origin, name=name, plot_legend=rrb.Corner2D.RightTop)


def _scene(info: RunInfo) -> rrb.Spatial3DView:
    x, y, _ = info.table_centre
    eye = rrb.EyeControls3D(position=(x + 0.55, y - 0.75, 0.6), look_target=(x - 0.1, y, 0.1), eye_up=(0, 0, 1))
    return rrb.Spatial3DView(origin="scene", name="Scene", eye_controls=eye, line_grid=False)
