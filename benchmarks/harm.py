"""The same push, harmful and harmless: `python -m benchmarks.harm` draws docs/pictures/harm.png.

A fish fillet, pushed 30 mm in the middle of its long side, once as fast as `world.motion.speed` says and once
as slowly as `acquisition=safe_lcb` begins.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from deformpush.cell.world import Moment
from deformpush.config.compose import compose
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import read
from deformpush.record import palette

SETTINGS = ["object=fish_fillet", "robot=tool", "record=off", "world.motion.frames=60"]
U = np.array([0.5, 0.03])
SPEEDS = (0.15, 0.03)
LINE = (0, 158, 115)
PATH = Path(__file__).parents[1] / "docs" / "pictures" / "harm.png"


def main() -> None:
    """Make the pushes and draw them."""
    figure = Figure(figsize=(11.0, 5.6), layout="constrained", dpi=120)
    maps, series = figure.subplots(2, 2, height_ratios=(1.5, 1.0))
    limit = None
    for column, speed in enumerate(SPEEDS):
        cell = build_cell(read(compose(SETTINGS)))
        view, _ = cell.look(None)
        path = replace(cell.layout.plan(U, view.seen, cell.part), speed=speed)
        outcome = cell.world.push(path)
        world, peak = cell.world, outcome.strain
        assert peak is not None
        limit = peak.limit
        p99 = [world.rest.aggregates(world.rest.strain(m.nodes)).p99 for m in outcome.motion]
        worst = outcome.motion[int(np.argmax(p99))]
        shade = _draw(maps[column], world.mesh.surface(), worst, cell.layout.tool_radius, limit)
        word = "harmful" if peak.exceeded else "harmless"
        maps[column].set_title(f"{word}: {speed:g} m/s, at its worst ({max(p99):.1%})")
        times = [m.time_s for m in outcome.motion]
        series[column].plot(times, 100 * np.array(p99), color=palette.unit(LINE), lw=2)
        series[column].axhline(100 * limit, color=palette.unit(palette.STOP), lw=1.2)
        series[column].set(ylim=(0, 14), xlabel="time since the push began (s)", xlim=(0, times[-1]))
        world.close()
    series[0].set_ylabel("p99 strain (%)")
    series[0].text(0.0, 100 * limit + 0.3, " limit", color=palette.unit(palette.STOP))
    figure.colorbar(shade, ax=list(maps), label="strain (%); red: beyond the limit", shrink=0.8, extend="max")
    figure.savefig(PATH)
    print(PATH)


def _draw(axes, triangles, moment: Moment, radius: float, limit: float):
    """The mesh from above, coloured by strain against the limit, and the tool."""
    nodes, strain = moment.nodes, moment.strain
    top = np.argsort(nodes[triangles][:, :, 2].mean(axis=1))
    colours = LinearSegmentedColormap.from_list("strain", np.array(palette.STRAIN) / 255)
    colours.set_over(palette.unit(palette.HARM))
    faces = PolyCollection(1e3 * nodes[triangles[top]][:, :, :2], cmap=colours, edgecolors="none")
    faces.set_array(100 * strain[triangles[top]].mean(axis=1))
    faces.set_clim(0, 100 * limit)
    axes.add_collection(faces)
    angle = np.linspace(0, 2 * np.pi, 60)
    ring = moment.tool[:2] + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    axes.plot(*(1e3 * ring).T, color=palette.unit(palette.NEXT_PUSH), lw=2)
    axes.set(aspect="equal", xlabel="x (mm)", ylabel="y (mm)")
    axes.autoscale_view()
    return faces


if __name__ == "__main__":
    main()
