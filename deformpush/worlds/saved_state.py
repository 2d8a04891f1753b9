"""A saved state of a world as bytes: whose it is, of which scene, and its numbers."""

import hashlib

import numpy as np

Array = np.ndarray

_NUMBERS = np.dtype("<f8")


class Scene:
    """What must be the same where a state is to be taken up again."""

    def __init__(self, world: str, *parts: bytes) -> None:
        """`world` is the name of its option; `parts` are hashed."""
        digest = hashlib.sha256()
        for part in parts:
            digest.update(len(part).to_bytes(8, "little") + part)
        self._world = world
        self._kind = f"deformpush {world} state 2\n".encode()
        self._head = self._kind + digest.digest()

    def pack(self, numbers: Array) -> bytes:
        """A state of this scene."""
        return self._head + numbers.astype(_NUMBERS).tobytes()

    def unpack(self, state: bytes, size: int) -> Array:
        """The numbers `(size,)` of a state of this scene.

        Raises:
            ValueError: it is no state, a damaged one, or that of another scene.
        """
        if not state.startswith(self._kind):
            raise ValueError(f"no state of world={self._world}")
        if not state.startswith(self._head):
            raise ValueError("a state of another world: other settings, object, robot or version")
        if len(state) - len(self._head) != size * _NUMBERS.itemsize:
            raise ValueError("a damaged state: it has not the length that it must have")
        numbers = np.frombuffer(state, _NUMBERS, offset=len(self._head)).astype(float)
        if not np.isfinite(numbers).all():
            raise ValueError("a damaged state: not all of its numbers are finite")
        return numbers
