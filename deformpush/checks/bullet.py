"""The gates of `world=bullet`: what every engine is held to, the explosion guard, camera and arm."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from deformpush.cell.object import SoftObject
from deformpush.cell.world import WorldError
from deformpush.checks import accuracy
from deformpush.checks.bench import Bench, Limits, LoneBody
from deformpush.checks.gate import Gate
from deformpush.checks.physics import SHARED, examine
from deformpush.worlds.bullet.engine import SoftBody, connect
from deformpush.worlds.bullet.world import BulletWorld

Array = np.ndarray


class BulletBench(Bench):
    """Bullet with the bare tool."""

    limits = Limits(
        stiffness=0.05, pose_dt=(2e-3, 2e-3), pose_mesh=(2e-3, 3e-3), strain_dt=0.1, strain_mesh=0.1
    )

    def gates(self) -> Iterator[Gate]:
        """What every engine is held to, then what this one is, then camera and arm."""
        yield from examine(self, (*SHARED, explosion))
        yield from accuracy.gates(self.overrides)

    def on_table(self, sheet: SoftObject) -> LoneBody:
        """An object on a table too long to slide off."""
        body = _Lone(self, sheet)
        shape = body.client.createCollisionShape(body.client.GEOM_BOX, halfExtents=[4, 4, 0.025])
        table = body.client.createMultiBody(0, shape, -1, [0, 0, -0.025])
        body.client.changeDynamics(table, -1, lateralFriction=1.0)
        return body

    def hung(self, sheet: SoftObject, pull: float) -> LoneBody:
        """An object whose left end is anchored."""
        body = _Lone(self, sheet)
        body.client.setGravity(pull, 0, 0)
        x = body.nodes()[:, 0]
        for node in np.flatnonzero(np.isclose(x, x.min())):
            body.client.createSoftBodyAnchor(body.slab.id, int(node), -1, -1)
        return body


@dataclass
class _Lone:
    """See `LoneBody`."""

    client: Any
    slab: SoftBody
    masses: Array

    def __init__(self, bench: Bench, sheet: SoftObject) -> None:
        self.client = connect(bench.spec.engine)
        mesh = sheet.slab.mesh
        self.slab = SoftBody(self.client, bench.spec.engine, bench.spec.margin, mesh, sheet)
        total, count = sheet.material.total_mass(float(mesh.volumes.sum())), len(mesh.nodes)
        self.masses = np.full(count, total / count)  # Bullet gives every node the same

    def nodes(self) -> Array:
        return self.slab.nodes()

    def launch(self, speed: float) -> None:
        self.client.resetBaseVelocity(self.slab.id, [speed, 0, 0])

    def step(self, seconds: float) -> None:
        for _ in range(round(seconds / self.slab.dt)):
            self.slab.step()

    def close(self) -> None:
        self.client.disconnect()


def explosion(bench: Bench) -> Gate:
    """A time step beyond stability is noticed, though the engine reports nothing."""
    world = bench.world()
    assert isinstance(world, BulletWorld)
    world.client.setTimeStep(5 * bench.spec.engine.damping)  # stable up to twice the damping
    try:
        world.push(bench.path(0.03))
        noticed = "nothing"
    except WorldError as problem:
        noticed = str(problem).split(":")[0]
    world.close()
    return Gate("provoked explosion", f"guard said: {noticed}", "the guard trips", "exploded" in noticed)
