"""How a finite element engine makes a push: forth, back until clear, rest; and what is measured meanwhile."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from deformpush.cell.push import ToolPath
from deformpush.cell.world import Moment, Outcome, Strain, WorldError
from deformpush.mechanics.mesh import TetMesh
from deformpush.mechanics.rounding import NEWTONS, rounded
from deformpush.mechanics.strain import Gauge, RestShape
from deformpush.worlds.drive import Drive
from deformpush.worlds.explosion import ExplosionGuard
from deformpush.worlds.tool_motion import Line, Motion, ramp

Array = np.ndarray

SAMPLE_S = 0.01
"""The strain during a push is measured this often, as near as whole steps come (s)."""


class Simulation(Protocol):
    """An engine with the object, the table and the tool in it."""

    @property
    def dt(self) -> float:
        """Time step (s)."""

    @property
    def check_every(self) -> int:
        """Steps between looks at the mesh: explosion guard, rest, clearance."""

    def step(self) -> None:
        """Advance by one time step.

        Raises:
            WorldError: the engine reports that the step cannot be trusted.
        """

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m)."""

    def tool_force(self) -> float | None:
        """Force between tool and object in the last step (N); None where the engine cannot tell."""


class PushExecution:
    """Pushes of one tool against one object, in one engine."""

    def __init__(
        self, simulation: Simulation, tool: Drive, mesh: TetMesh, motion: Motion, tool_radius: float
    ) -> None:
        self._simulation, self._tool, self._motion, self._radius = simulation, tool, motion, tool_radius
        self.rest, self.guard = RestShape(mesh), ExplosionGuard(mesh)
        self.sample_every = max(1, round(SAMPLE_S / simulation.dt))
        self._gauge: Gauge | None = None

    def push(self, path: ToolPath, pictures_a_second: float, strain_limit: float | None) -> Outcome:
        """Push along the path, come back, and let the object come to rest; measure the strain.

        Raises:
            WorldError: the path is out of reach (nothing has moved), or what came of it cannot be trusted.
        """
        gauge = self._gauge = Gauge(self.rest)
        outcome, samples = self._move(path)
        between = 1 / (pictures_a_second * self.sample_every * self._simulation.dt)
        outcome.film = samples[:: max(1, round(between))]
        self._measure(gauge, outcome, strain_limit)
        return outcome

    def push_unmeasured(self, path: ToolPath) -> None:
        """The same push, to the bit, when only its end is of interest; errors as `push`."""
        self._gauge = None
        self._move(path)

    def settle(self, outcome: Outcome, at_least: float = 0.0) -> None:
        """Step until no node moves faster than the settling speed."""
        motion, checks = self._motion, self._simulation.check_every
        between = checks * self._simulation.dt
        waited, before = 0.0, self._simulation.nodes()
        while waited < max(motion.settle_s, at_least):
            for _ in range(checks):
                self._step(outcome)
            waited += between
            nodes = self._simulation.nodes()
            self.guard.check(nodes)
            fastest = np.linalg.norm(nodes - before, axis=1).max() / between
            if fastest < motion.settle_speed and waited >= at_least:
                return
            before = nodes

    def _move(self, path: ToolPath) -> tuple[Outcome, list[Array]]:
        """Make a push; also the nodes `(N, 3)` at each look at the strain on the way forth."""
        motion, dt, outcome = self._motion, self._simulation.dt, Outcome()
        way = Line(path, min(path.approach, motion.lead))
        back = way.length + 4 * motion.clear  # room to come clear, should the object follow
        points = np.linspace(-4 * motion.clear, way.length, max(3, int(back / 0.003)))
        self._tool.prepare(way.at(points))
        self._tool.place(way.at(0.0))
        forth = ramp(way.length, path.speed or motion.speed, motion.acceleration, dt)
        home = ramp(back, motion.speed, motion.acceleration, dt)
        samples = self._forth(way, forth, outcome)
        self._home(way, np.array([way.length, 0.0]) - home, outcome)
        self._tool.park()
        self.settle(outcome)
        return outcome, samples

    def _forth(self, way: Line, profile: Array, outcome: Outcome) -> list[Array]:
        """Carry the tool to the end of the push; returns the nodes at each look at the strain."""
        keep = np.unique(np.linspace(0, len(profile), self._motion.frames + 1, dtype=int)[1:])
        samples: list[Array] = []
        forces: list[float | None] = []
        for n, (s, v) in enumerate(profile, start=1):
            samples += self._carry(way, s, v, outcome)
            forces.append(self._simulation.tool_force())
            if n % self._simulation.check_every == 0 or n in keep:
                nodes, tip = self._simulation.nodes(), self._tool.tip()
                self.guard.check(nodes)
                outcome.tip_error = max(outcome.tip_error, float(np.linalg.norm(tip[:2] - way.at(s))))
                if n in keep:
                    outcome.motion.append(Moment(outcome.sim_s, tip, nodes, self._tool.joints()))
        outcome.tool_force_peak, outcome.tool_force_mean = sum_up(forces, self.sample_every)
        return samples

    def _home(self, way: Line, profile: Array, outcome: Outcome) -> None:
        """Carry the tool back until the object is clear of it."""
        for n, (s, v) in enumerate(profile, start=1):
            self._carry(way, s, v, outcome)
            if n % self._simulation.check_every == 0:
                nodes = self._simulation.nodes()
                self.guard.check(nodes)
                if s < way.length / 2 and self._gap(nodes) > self._motion.clear:
                    return
        if self._gap(self._simulation.nodes()) < 0:
            raise WorldError("the object sticks to the tool: the tool could not come clear on its way back")

    def _carry(self, way: Line, s: float, v: float, outcome: Outcome) -> list[Array]:
        """One physics step that ends at distance s (m) with the tool at speed v (m/s)."""
        # The drive is given where the step begins and how fast it goes: it ends where the profile says.
        self._tool.follow(way.at(s - v * self._simulation.dt), v * way.direction)
        return self._step(outcome)

    def _step(self, outcome: Outcome) -> list[Array]:
        """One physics step, and every so often a look at the strain: the nodes it was taken of, if it was."""
        with outcome.stepping(1, self._simulation.dt):
            self._simulation.step()
        if self._gauge is None or outcome.steps % self.sample_every:
            return []
        nodes = self._simulation.nodes()
        self._gauge.look(nodes)
        return [nodes]

    def _gap(self, nodes: Array) -> float:
        """From the tool's surface to the nearest node, in the plane (m)."""
        return float(np.linalg.norm(nodes[:, :2] - self._tool.tip()[:2], axis=1).min()) - self._radius

    def _measure(self, gauge: Gauge, outcome: Outcome, limit: float | None) -> None:
        """Add the strain of the push that has just ended, and that of its moments."""
        peak = gauge.peak()
        looks = [moment.nodes for moment in outcome.motion if moment.nodes is not None]
        *moments, now = self.rest.strain(np.stack([*looks, self._simulation.nodes()]))
        residual = self.rest.aggregates(now).p99
        field = self.rest.at_nodes(gauge.field())
        outcome.strain = Strain(peak.p99, peak.top10, peak.maximum, residual, limit, field)
        outcome.motion = [
            replace(moment, strain=self.rest.at_nodes(strain))
            for moment, strain in zip(outcome.motion, moments, strict=True)
        ]


def sum_up(forces: Sequence[float | None], window: int) -> tuple[float | None, float | None]:
    """Peak and mean of the tool's force over a push (N), from its force in each step; None where unknown.

    Both are taken over the steps from the first touch on. The peak is that of a running mean over `window`
    steps, as long as two looks at the strain lie apart: a node that slips lets the force of a single step
    jump by a tenth.
    """
    known = np.array([force for force in forces if force is not None])
    if len(known) < len(forces) or not len(known):
        return None, None
    touched = np.flatnonzero(known > 0)
    if not len(touched):
        return 0.0, 0.0
    pressed = known[touched[0] :]
    width = min(window, len(pressed))
    smooth = np.convolve(pressed, np.full(width, 1 / width), mode="valid")
    peak, mean = rounded(np.array([smooth.max(), pressed.mean()]), NEWTONS).tolist()
    return peak, mean
