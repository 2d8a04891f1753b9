"""A picture to check an outline by eye: over the photo it was taken from, with mesh and measures."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from deformpush.mechanics.meshing import MeshedSlab

Array = np.ndarray

OUTLINE, LOST, CELLS = "#d55e00", "#cc79a7", "#0072b2"
"""Colours that the colour-blind can tell apart."""


@dataclass(frozen=True)
class Overlay:
    """What is drawn, all in millimetres as the file has them, x to the right, y up."""

    title: str
    outline: Array
    """`(V, 2)`"""
    origin: Array
    """Its centroid `(2,)`."""
    slab: MeshedSlab
    """About its centroid, in metres."""
    lost: tuple[Array, ...] = ()
    """Parts that were cut off."""
    picture: Array | None = None
    """RGB `(H, W, 3)`; its lower left corner is the origin."""
    mm_per_px: float = 1.0


def draw(what: Overlay, path: Path) -> None:
    """Write a PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    every = np.concatenate([what.outline, *what.lost])
    lo, hi = every.min(axis=0), every.max(axis=0)
    room = 0.1 * float((hi - lo).max())
    width, height = hi - lo + 2 * room
    inch = 8.0 / float(max(width, height))
    figure = Figure(figsize=(max(5.0, width * inch) + 1, max(3.5, height * inch) + 1), layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    if what.picture is not None:
        height, width = what.picture.shape[:2]
        ax.imshow(what.picture, extent=(0, width * what.mm_per_px, 0, height * what.mm_per_px))
    for n, part in enumerate(what.lost):
        ax.fill(*part.T, facecolor=LOST, edgecolor=LOST, alpha=0.6, label="_" if n else "cut off")
    mesh = what.slab.mesh
    under = mesh.surface()
    under = under[np.all(mesh.nodes[under][:, :, 2] < 1e-9, axis=1)]
    edges = np.concatenate([under[:, [0, 1]], under[:, [1, 2]], under[:, [2, 0]]])
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    lines = mesh.nodes[edges][:, :, :2] * 1e3 + what.origin
    ax.add_collection(LineCollection(list(lines), colors=CELLS, linewidths=0.5, alpha=0.7, label="cells"))
    closed = np.concatenate([what.outline, what.outline[:1]])
    ax.plot(*closed.T, color=OUTLINE, linewidth=1.8, label="outline")
    ax.plot(*what.outline.T, ".", color=OUTLINE, markersize=4)
    ax.plot(*what.origin, "+", color=OUTLINE, markersize=12, markeredgewidth=2, label="centroid")
    ax.set(title=what.title, xlabel="x (mm)", ylabel="y (mm)", aspect="equal")
    ax.set(xlim=(lo[0] - room, hi[0] + room), ylim=(lo[1] - room, hi[1] + room))
    ax.legend(loc="upper right", framealpha=0.9)
    figure.savefig(path, dpi=100)
