"""Quasi-static pushing of a rigid body by a frictionless disc, for many bodies or pushes at once.

A force f through contact point p moves a body on a table by v = a f, omega = a (r x f) / l^2, r from the
centroid to p, with the pressure radius l: the ellipsoidal limit surface of Goyal, Ruina and Papadopoulos
1991. The factor a follows from the tool not entering the body (Lynch & Mason 1996). Inertia plays no part.
"""

from typing import Any

import numpy as np

Array = np.ndarray


def make_way(
    body: Array, pose: Array, tool: Array, reach: float, pressure: Any, within: float = 1e-6, rounds: int = 50
) -> Array:
    """Move bodies out of the tool's way; those that the tool does not touch stay.

    Args:
        body: outline about the centroid, body frame `(n, M, 2)` or `(M, 2)` for all (m), closed by itself.
        pose: x, y (m) and angle (rad) `(n, 3)`.
        tool: centres of the disc `(n, 2)`, outside the outlines (m).
        reach: radius of the disc (m).
        pressure: pressure radius l `(n,)` or one for all (m).
        within: overlap that may stay (m).
        rounds: the contact is solved at most this many times.

    Returns:
        Poses `(n, 3)`.
    """
    sides, rows = _sides(body), np.arange(len(pose))
    pose = pose.copy()
    for _ in range(rounds):
        (seen_x, seen_y), gx, gy = _gaps(sides, pose, tool)
        touched = np.argmin(gx * gx + gy * gy, axis=1)
        gx, gy = gx[rows, touched], gy[rows, touched]
        distance = np.maximum(np.hypot(gx, gy), 1e-12)
        deep = reach - distance
        if np.all(deep <= within):
            break
        nx, ny = -gx / distance, -gy / distance
        lever = ((seen_x - gx) * ny - (seen_y - gy) * nx) / pressure
        move = np.maximum(deep, 0.0) / (1.0 + lever**2)
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        pose[:, 0] += move * (c * nx - s * ny)
        pose[:, 1] += move * (s * nx + c * ny)
        pose[:, 2] += move * lever / pressure
    return pose


def overlap(body: Array, pose: Array, tool: Array, reach: float) -> float:
    """How deep a disc reaches into one body (m); negative: how far it stays away."""
    _, gx, gy = _gaps(_sides(body), pose[None], tool[None])
    return reach - float(np.hypot(gx, gy).min())


def pushed(
    body: Array, contact: Array, direction: Array, reach: float, pressure: Any, travel: Array
) -> Array:
    """Poses of bodies that start at the origin while discs travel straight on from their contacts.

    Args:
        body: `(n, M, 2)` or `(M, 2)`; see `make_way`.
        contact: centres of the discs at touch, body frame at the start `(n, 2)` (m).
        direction: unit vectors `(n, 2)`.
        reach: radius of the discs (m).
        pressure: pressure radius `(n,)` or one for all (m).
        travel: distances from the touch, rising (m) `(T,)`.

    Returns:
        x, y (m) and angle (rad) in the frame of the start `(n, T, 3)`.
    """
    pose = np.zeros((len(contact), 3))
    poses = np.empty((len(contact), len(travel), 3))
    for i, s in enumerate(travel):
        pose = make_way(body, pose, contact + s * direction, reach, pressure, within=1e-5, rounds=8)
        poses[:, i] = pose
    return poses


def _sides(body: Array) -> tuple[Array, ...]:
    """Corners x, y and sides x, y, squared length of an outline, each `(n, M)` or `(M,)`."""
    px, py = body[..., 0], body[..., 1]
    sx, sy = np.roll(px, -1, axis=-1) - px, np.roll(py, -1, axis=-1) - py
    return px, py, sx, sy, sx * sx + sy * sy


def _gaps(sides: tuple[Array, ...], pose: Array, tool: Array) -> tuple[tuple[Array, Array], Array, Array]:
    """The tool in the bodies' frames, x and y `(n,)`, and what separates it from every side `(n, M)`."""
    px, py, sx, sy, square = sides
    c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
    dx, dy = (tool - pose[:, :2]).T
    seen_x, seen_y = c * dx + s * dy, c * dy - s * dx
    gx, gy = seen_x[:, None] - px, seen_y[:, None] - py
    share = np.clip((gx * sx + gy * sy) / square, 0.0, 1.0)
    gx -= share * sx
    gy -= share * sy
    return (seen_x, seen_y), gx, gy
