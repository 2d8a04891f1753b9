"""Quasi-static pushing of a soft sheet by a frictionless disc, many pushes at once.

The tool goes forward in steps; in each the sheet comes to rest where elastic energy, friction from where it
was and contact have their least sum (an implicit step of dry friction: Moreau 1977). All pushes are solved
together: their matrices stand end to end in one banded system.
"""

import numpy as np
from scipy.linalg.lapack import dpbsv
from scipy.sparse import csr_matrix

from deformpush.mechanics.soft_sheet import Sheet

Array = np.ndarray

STEP = 5e-3
"""Longest step of the tool (m)."""
BACK = 2e-3
"""The tool goes back so far before it is lifted (m)."""
ROUNDS = 60
"""Of Newton's method in each step, at most."""
_HALVINGS = 10
_STILL = 1e-6  # m; a step of Newton's method below this ends it
_ENOUGH = 1e-4  # Armijo's share of the decrease that the slope promises


def pushed(
    sheet: Sheet, start: Array, contact: Array, direction: Array, radius: float, travel: Array
) -> Array:
    """Positions of the nodes at rest after pushes, the tool lifted.

    Args:
        sheet: its rest shape.
        start: positions `(N, 2)` before each push (m).
        contact: centre of the disc at first touch `(n, 2)` (m).
        direction: unit vectors `(n, 2)`.
        radius: of the disc (m).
        travel: distances from the touch, rising `(K,)` (m); pushes to all of them share one way forth.

    Returns:
        `(n, K, N, 2)`.
    """
    solver = _Solver(sheet)
    n, k, at = len(contact), len(travel), 0.0
    x = np.repeat(start[None], n, axis=0)
    after = np.empty((n, k, *start.shape))
    for i, end in enumerate(travel):
        for s in np.linspace(at, end, 1 + max(1, int(np.ceil((end - at) / STEP - 1e-9))))[1:]:
            x = solver.rest(x, contact + s * direction, radius)
        after[:, i], at = x, end
    x = after.reshape(n * k, *start.shape)
    ends = contact[:, None] + (travel - BACK)[:, None] * direction[:, None]
    x = solver.rest(x, ends.reshape(n * k, 2), radius)
    return solver.rest(x, None, radius).reshape(after.shape)


class _Solver:
    """Finds where sheets come to rest."""

    def __init__(self, sheet: Sheet) -> None:
        """Find out once where each entry of an energy's second derivative stands in the banded matrix."""
        self.sheet, self.size, self.bands = sheet, 2 * len(sheet.rest), sheet.bandwidth
        nodes = np.arange(len(sheet.rest))[:, None]
        self.elastic, self.contact, self.friction = map(self._places, (sheet.triangles, sheet.sides, nodes))

    def rest(self, was: Array, tool: Array | None, radius: float) -> Array:
        """Where sheets `(n, N, 2)` come to rest around discs at `tool` `(n, 2)`, or with none."""
        x, moving = was.copy(), np.arange(len(was))
        for _ in range(ROUNDS):
            here, before = x[moving], was[moving]
            at = None if tool is None else tool[moving]
            step, slope = self._newton(here, before, at, radius)
            x[moving], still = self._descend(here, step, slope, before, at, radius)
            moving = moving[~still]
            if not len(moving):
                break
        return x

    def energy(self, x: Array, was: Array, tool: Array | None, radius: float) -> Array:
        """Of sheets `(n, N, 2)` that slid from `was`: `(n,)`."""
        sheet = self.sheet
        total = sheet.elastic(x) + sheet.friction(x, was)
        return total if tool is None else total + sheet.contact(x, tool, radius)

    def _newton(self, x: Array, was: Array, tool: Array | None, radius: float) -> tuple[Array, Array]:
        """Newton's step `(n, N, 2)`, and how fast energy falls along it `(n,)`."""
        n = len(x)
        slope, second = self.sheet.elastic_forces(x)
        band = self.elastic @ second.reshape(n, -1).T
        more, second = self.sheet.friction_forces(x, was)
        slope, band = slope + more, band + self.friction @ second.reshape(n, -1).T
        if tool is not None:
            more, second = self.sheet.contact_forces(x, tool, radius)
            slope, band = slope + more, band + self.contact @ second.reshape(n, -1).T
        matrix = band.reshape(self.bands + 1, self.size, n).transpose(0, 2, 1).reshape(self.bands + 1, -1)
        _, step, info = dpbsv(matrix, -slope.reshape(-1), lower=1)
        if info:
            raise ArithmeticError("soft sheet: the banded system has no solution")
        step = step.reshape(x.shape)
        # Where all slides, friction hardly curves along its way, and the step would lead off the table.
        step *= np.minimum(1.0, STEP / np.maximum(np.abs(step).max(axis=(1, 2)), 1e-12))[:, None, None]
        return step, np.einsum("nai,nai->n", slope, step)

    def _descend(
        self, x: Array, step: Array, slope: Array, was: Array, tool: Array | None, radius: float
    ) -> tuple[Array, Array]:
        """Sheets after as much of a step as lowers their energy, and which of them are at rest."""
        share, energy = np.ones(len(x)), self.energy(x, was, tool, radius)
        for _ in range(_HALVINGS):
            there = x + share[:, None, None] * step
            worse = self.energy(there, was, tool, radius) > energy + _ENOUGH * share * slope
            if not worse.any():
                break
            share[worse] /= 2
        moved = share * np.abs(step).max(axis=(1, 2))
        return x + share[:, None, None] * step, moved < _STILL

    def _places(self, nodes: Array) -> csr_matrix:
        """The matrix that adds entries `(G, 2k, 2k)` over nodes `(G, k)` up into lower bands."""
        dofs = (2 * nodes[:, :, None] + np.arange(2)).reshape(len(nodes), -1)
        row, column = (
            np.broadcast_to(d, (len(dofs), dofs.shape[1], dofs.shape[1])).ravel()
            for d in (dofs[:, :, None], dofs[:, None, :])
        )
        lower = row >= column
        entries = np.flatnonzero(lower)
        at = (row - column)[lower] * self.size + column[lower]
        shape = ((self.bands + 1) * self.size, len(row))
        return csr_matrix((np.ones(len(entries)), (at, entries)), shape)
