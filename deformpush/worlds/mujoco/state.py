"""A saved state as bytes: what it is, of which scene, and its numbers."""

import hashlib

import mujoco
import numpy as np

from deformpush.cell.robot import Robot

Array = np.ndarray

_MAGIC = b"deformpush mujoco state 1\n"
_NUMBERS = np.dtype("<f8")


def fingerprint(model: mujoco.MjModel, robot: Robot) -> bytes:
    """Hash (32 bytes) of all that must be the same where a state is to be taken up again."""
    compiled = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, compiled)
    said = f"{mujoco.mj_versionString()} {robot!r}".encode()
    return hashlib.sha256(said + b"\0" + compiled.tobytes()).digest()


def pack(scene: bytes, numbers: Array) -> bytes:
    """A state of the scene with this fingerprint."""
    return _MAGIC + scene + numbers.astype(_NUMBERS).tobytes()


def unpack(state: bytes, scene: bytes, size: int) -> Array:
    """The numbers `(size,)` of a state of this scene.

    Raises:
        ValueError: it is no state, a damaged one, or that of another scene.
    """
    start = len(_MAGIC) + len(scene)
    if not state.startswith(_MAGIC):
        raise ValueError("no state of world=mujoco")
    if state[len(_MAGIC) : start] != scene:
        raise ValueError("a state of another world: other settings, object, robot or version of MuJoCo")
    if len(state) - start != size * _NUMBERS.itemsize:
        raise ValueError("a damaged state: it has not the length that it must have")
    return np.frombuffer(state, _NUMBERS, offset=start).astype(float)
