"""MuJoCo's model of the scene: a flex of stable neo-Hookean tetrahedra on a plane, and a tool on two axes.

Built through `MjSpec`, since the law exists there only. With mu and lambda Lame's, I_C = tr(F'F), J = det F,
its energy per undeformed volume is

    Psi = mu/2 (I_C - 3) - mu (J - 1) + (lambda + mu)/2 (J - 1)^2:

that of Smith, de Goes and Kim 2018 without the logarithm that Bullet keeps
(`deformpush.mechanics.neo_hookean`); at small strain they are one. Every number that is not a setting stands
here, with what happens otherwise.
"""

from collections.abc import Collection
from dataclasses import dataclass

import mujoco
import numpy as np

from deformpush.cell.object import SoftObject
from deformpush.mechanics.geometry import rotation
from deformpush.mechanics.mesh import TetMesh
from deformpush.worlds.mujoco.settings import Engine

Array = np.ndarray

NEO_HOOKEAN = 1  # mjsFlex.elastic3d; 0 is Saint Venant-Kirchhoff, 8.5 % too stiff at a strain of 0.1
ITERATIONS, TOLERANCE = 200, 1e-6  # of the solver; after 50 it has not solved the stiffest objects
SOLREF, SOLIMP = (0.005, 1.0), (0.9, 0.95, 0.001, 0.5, 2.0)  # of every contact; 0.02 s moves a pose by 1 mm
TOOL_MASS = 1000.0  # kg; it is carried: no contact may slow it within a step
OBJECT, TOOL = 1, 2  # bits of what collides
TOOL_NAME, TOOL_AXES = "tool", ("tool_x", "tool_y")


@dataclass(frozen=True)
class ToolShape:
    """A vertical capsule (m)."""

    radius: float
    top: float
    """Height of its upper end above the table."""
    friction: float
    """Coulomb coefficient against the object."""


def rest_nodes(mesh: TetMesh, sheet: SoftObject, margin: float) -> Array:
    """Where the nodes `(N, 3)` (m) are before anything acts: as high above the table as the margin."""
    plan = mesh.nodes[:, :2] @ rotation(np.radians(sheet.start_deg)).T + sheet.start
    return np.column_stack([plan, mesh.nodes[:, 2] + margin])


def node_masses(mesh: TetMesh, total: float, by_volume: bool) -> Array:
    """Mass of each node `(N,)` (kg): all alike, or a quarter of each tetrahedron's for its corners."""
    count, volumes = len(mesh.nodes), mesh.volumes
    if not by_volume:
        return np.full(count, total / count)
    around = np.bincount(mesh.tetrahedra.ravel(), np.repeat(volumes, 4), count)
    return np.asarray(total * around / around.sum())


def build_model(
    mesh: TetMesh,
    sheet: SoftObject,
    engine: Engine,
    margin: float,
    tool: ToolShape,
    held: Collection[int] = (),
) -> mujoco.MjModel:
    """Compile the scene.

    Args:
        mesh: of the object.
        sheet: its data sheet.
        engine: numbers of the simulation.
        margin: radius of the flex (m).
        tool: what pushes.
        held: nodes that stay where they are, for hanging the object up.
    """
    spec = mujoco.MjSpec()
    _set_options(spec.option, engine)
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[1, 1, 0.1],
        # Of two surfaces the larger coefficient acts: the object's alone says what it is.
        **_contact(friction=0.0, collides=OBJECT, sees=OBJECT),
    )
    rest = rest_nodes(mesh, sheet, margin)
    total = sheet.material.total_mass(float(mesh.volumes.sum()))
    for i, mass in enumerate(node_masses(mesh, total, engine.masses == "volume")):
        node = _add_point(spec, f"node_{i}", rest[i], mass)
        if i not in held:
            _add_axes(node, [f"node_{i}_{axis}" for axis in "xyz"])
    spec.add_flex(
        name="object",
        dim=3,
        vertbody=[f"node_{i}" for i in range(len(rest))],
        vert=np.zeros(rest.size).tolist(),
        elem=mesh.tetrahedra.ravel().tolist(),
        young=sheet.material.youngs_modulus,
        poisson=sheet.material.poisson_ratio,
        elastic3d=NEO_HOOKEAN,
        damping=engine.damping,
        radius=margin,
        margin=0.0,
        activelayers=1,
        selfcollide=mujoco.mjtFlexSelf.mjFLEXSELF_NONE,
        **_contact(friction=sheet.material.friction, collides=OBJECT, sees=OBJECT | TOOL),
    )
    carrier = _add_point(spec, TOOL_NAME, np.zeros(3), TOOL_MASS)
    carrier.gravcomp = 1.0
    _add_axes(carrier, TOOL_AXES)
    carrier.add_geom(
        name=TOOL_NAME,
        type=mujoco.mjtGeom.mjGEOM_CAPSULE,
        # Its round end lies below the table: what touches the object is straight.
        fromto=[0, 0, -2 * tool.radius, 0, 0, tool.top - tool.radius],
        size=[tool.radius, 0, 0],
        priority=1,  # against it, its own coefficient acts
        **_contact(friction=tool.friction, collides=TOOL, sees=0),
    )
    return spec.compile()


def _set_options(option: mujoco.MjOption, engine: Engine) -> None:
    option.timestep = engine.step
    option.gravity = [0, 0, -engine.gravity]
    option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE  # the only one that knows the law
    option.solver = mujoco.mjtSolver.mjSOL_CG
    option.iterations, option.tolerance = ITERATIONS, TOLERANCE
    # The pyramid is no friction cone: it moves an off-centre push by 3.5 mm.
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, engine.impratio


def _contact(friction: float, collides: int, sees: int) -> dict[str, object]:
    """Contact without spin or roll; `collides` and `sees` are MuJoCo's contype and conaffinity."""
    return {
        "contype": collides,
        "conaffinity": sees,
        "condim": 3,
        "friction": [friction, 0, 0],
        "solref": list(SOLREF),
        "solimp": list(SOLIMP),
    }


def _add_point(spec: mujoco.MjSpec, name: str, place: Array, mass: float) -> mujoco.MjsBody:
    # The inertia is a formality: a body that only slides does not turn.
    return spec.worldbody.add_body(
        name=name, pos=place, mass=mass, inertia=[1e-6 * mass] * 3, explicitinertial=True
    )


def _add_axes(body: mujoco.MjsBody, names: Collection[str]) -> None:
    """Let a body slide along x, y and so on, as many axes as names."""
    for name, axis in zip(names, np.eye(3), strict=False):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
