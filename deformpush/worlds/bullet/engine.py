"""One quiet PyBullet client, and the slab as a soft body in it."""

import ctypes
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from annotated_types import Interval

from deformpush.cell.object import SoftObject
from deformpush.mechanics.mesh import TetMesh, write_vtk

Array = np.ndarray


@dataclass(frozen=True)
class Engine:
    """Numbers of the finite element simulation."""

    dt: Annotated[float, Interval(ge=1e-5, le=0.05)]
    """Time step (s)."""
    damping: Annotated[float, Interval(ge=1e-6, le=1)]
    """Stiffness-proportional Rayleigh damping time beta (s). The elastic force is explicit: dt <= 2 beta."""
    gravity: Annotated[float, Interval(gt=0, le=100)]
    """m/s^2."""

    def __post_init__(self) -> None:
        if self.dt > 2 * self.damping:
            raise ValueError(
                f"dt: {self.dt:g} s is unstable; it must not exceed twice damping = {2 * self.damping:g} s"
            )


@contextmanager
def quiet() -> Iterator[None]:
    """Keep the engine's own C++ chatter off the terminal."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = os.dup(1), os.dup(2)
    try:
        with open(os.devnull, "w") as sink:
            for terminal in (1, 2):
                os.dup2(sink.fileno(), terminal)
        yield
    finally:
        # What C has printed waits in its buffer where standard output is a pipe or a file.
        ctypes.CDLL(None).fflush(None)
        for terminal, copy in zip((1, 2), saved, strict=True):
            os.dup2(copy, terminal)
            os.close(copy)


def connect(engine: Engine | None = None) -> Any:
    """A fresh client without a window: a deformable world if `engine` is given, otherwise a rigid one.

    Raises:
        ValueError: there is no PyBullet here.
    """
    with quiet():
        try:
            import pybullet
            from pybullet_utils.bullet_client import BulletClient
        except ModuleNotFoundError as error:
            raise ValueError(
                "PyBullet is not installed; it runs on CPython 3.11 for Linux on x86_64 only, world=mujoco "
                "on others too"
            ) from error
        client = BulletClient(pybullet.DIRECT)
    if engine is not None:
        # One soft body per world, in a world reset for it: Bullet keeps the first body's material for all.
        client.resetSimulation(client.RESET_USE_DEFORMABLE_WORLD)
        client.setGravity(0, 0, -engine.gravity)
        client.setTimeStep(engine.dt)
        client.setPhysicsEngineParameter(deterministicOverlappingPairs=1)
    return client


class SoftBody:
    """The slab in the engine: a step of the engine, and the nodes after it."""

    check_every = 8

    def __init__(self, client: Any, engine: Engine, margin: float, mesh: TetMesh, sheet: SoftObject) -> None:
        self.client, self.mesh, self.dt = client, mesh, engine.dt
        mu, lam = sheet.material.bullet
        with tempfile.TemporaryDirectory() as folder, quiet():
            path = Path(folder) / "slab.vtk"
            write_vtk(mesh, path)
            self.id = client.loadSoftBody(
                str(path),
                basePosition=[*sheet.start, margin],
                baseOrientation=client.getQuaternionFromEuler([0, 0, np.radians(sheet.start_deg)]),
                mass=sheet.material.total_mass(float(mesh.volumes.sum())),
                useNeoHookean=1,
                NeoHookeanMu=mu,
                NeoHookeanLambda=lam,
                NeoHookeanDamping=engine.damping,
                collisionMargin=margin,
                frictionCoeff=sheet.material.friction,  # the product with the table's 1.0 acts
                useSelfCollision=0,
            )
        client.changeVisualShape(self.id, -1, rgbaColor=[*sheet.rgb, 1.0])
        client.changeDynamics(self.id, -1, activationState=client.ACTIVATION_STATE_DISABLE_SLEEPING)

    def step(self) -> None:
        """Advance everything in this client by one time step."""
        self.client.stepSimulation()

    def nodes(self) -> Array:
        """Nodes `(N, 3)` (m) in the mesh's own order."""
        _, nodes = self.client.getMeshData(self.id, -1, flags=self.client.MESH_DATA_SIMULATION_MESH)
        return np.fromiter(chain.from_iterable(nodes), float).reshape(-1, 3)

    def tool_force(self) -> None:
        """Not known: contact points are listed for faces only."""
        return None
