"""MuJoCo at work on one scene: steps, the nodes after them, the tool, the force on it, and its state."""

import mujoco
import numpy as np

from deformpush.cell.world import WorldError
from deformpush.worlds.mujoco.model import TOOL_AXES, TOOL_NAME

Array = np.ndarray

_STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS | mujoco.mjtState.mjSTATE_WARMSTART
"""All that changes: without the warm start a state does not repeat. Nothing here is applied from outside."""


class MujocoSimulation:
    """One object and one tool; several may share a model, each with its own data."""

    def __init__(self, model: mujoco.MjModel, rest: Array, check_every: int) -> None:
        """Begin with the nodes at `rest` `(N, 3)` (m)."""
        _keep_quiet()
        self.model, self.data, self._rest = model, mujoco.MjData(model), rest
        self.dt, self.check_every = float(model.opt.timestep), check_every
        self._free = np.flatnonzero(model.body_dofnum[model.flex_vertbodyid])
        self._tool_geom = model.geom(TOOL_NAME).id
        # Nodes come first, the tool last; of slide joints, place and speed have the same number.
        (first,), _ = (model.joint(name).qposadr for name in TOOL_AXES)
        self._tool = slice(int(first), int(first) + len(TOOL_AXES))

    def step(self) -> None:
        """Advance by one time step.

        Raises:
            WorldError: MuJoCo gave up or warned: of what is not a number, of a solver that did not converge.
        """
        try:
            mujoco.mj_step(self.model, self.data)
        except mujoco.FatalError as error:
            raise WorldError(f"the simulation exploded: MuJoCo gave up: {error}") from error
        number = self.data.warning.number
        if number.any():
            kind = int(np.flatnonzero(number)[0])
            text = mujoco.mju_warningText(kind, self.data.warning[kind].lastinfo)
            raise WorldError(f"the simulation cannot be trusted: MuJoCo warns: {text}")

    def nodes(self) -> Array:
        """Mesh nodes `(N, 3)` (m)."""
        nodes = self._rest.copy()
        nodes[self._free] += self.data.qpos[: self._tool.start].reshape(-1, 3)
        return nodes

    def move_tool(self, xy: Array, velocity: Array) -> None:
        """For the coming step: the tool is at `xy` (m) and moves at `velocity` (m/s)."""
        self.data.qpos[self._tool] = xy
        self.data.qvel[self._tool] = velocity

    def tool_at(self) -> Array:
        """Where the tool is `(2,)` (m)."""
        return np.array(self.data.qpos[self._tool])

    def tool_force(self) -> float:
        """Size of the sum of all contact forces between tool and object in the last step (N)."""
        contact = self.data.contact
        touching = (contact.geom == self._tool_geom).any(axis=1) & (contact.efc_address >= 0)
        if not touching.any():
            return 0.0
        # In the elliptic cone a contact's three rows are its force along the three axes of its frame.
        along = self.data.efc_force[contact.efc_address[touching, None] + np.arange(3)]
        force = np.einsum("ca,cax->x", along, contact.frame[touching].reshape(-1, 3, 3))
        return float(np.linalg.norm(force))

    def state(self) -> Array:
        """Everything that the coming steps depend on `(S,)`."""
        state = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(self.model, self.data, state, _STATE)
        return state

    def set_state(self, state: Array) -> None:
        """Return to a state `(S,)` of this model."""
        # Fresh data: nothing stays of a step that went wrong.
        self.data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, self.data, state, _STATE)

    def description(self) -> tuple[bytes, bytes]:
        """All that a state depends on but does not hold: version of MuJoCo, compiled model."""
        compiled = np.empty(mujoco.mj_sizeModel(self.model), np.uint8)
        mujoco.mj_saveModel(self.model, None, compiled)
        return mujoco.mj_versionString().encode(), compiled.tobytes()

    def branch(self) -> "MujocoSimulation":
        """Another one in the same state, whose steps leave this one alone."""
        other = MujocoSimulation(self.model, self._rest, self.check_every)
        mujoco.mj_setState(other.model, other.data, self.state(), _STATE)
        return other


def _keep_quiet() -> None:
    """Neither print warnings nor leave a log in the working folder: they are raised."""
    log = mujoco.MjLogConfig.get()
    log.logto_console = log.logto_file = False
    log.set()
