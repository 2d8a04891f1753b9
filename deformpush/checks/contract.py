"""What every world must do, whoever wrote it: for `doctor`, and for the tests."""

from collections.abc import Iterator, Sequence

import numpy as np

from deformpush.cell.cell import Cell
from deformpush.cell.perception import PerceptionError
from deformpush.cell.world import Outcome, Scenery, WorldError
from deformpush.checks.gate import Gate
from deformpush.config.compose import compose
from deformpush.errors import UserError
from deformpush.experiment.assemble import build_cell
from deformpush.experiment.setup import Setup, read


def contract(overrides: Sequence[str]) -> Iterator[Gate]:
    """Put the world that these settings describe through its contract, one gate after the other.

    Raises:
        UserError: a setting is wrong, or the object cannot be seen in the first picture.
    """
    setup = read(compose(overrides))
    cell = build_cell(setup)
    try:
        yield picture(cell)
        try:
            cell.look(None)
        except PerceptionError as problem:
            raise UserError(f"world={setup.options['world']}: {problem}") from problem
        yield reach(cell)
        yield mesh(cell)
        if "branches" in cell.world.offers:
            yield branches(cell, setup)
        yield push(cell, setup)
        if "states" in cell.world.offers:
            yield states(cell, setup)
        yield beyond_reach(cell)
    finally:
        cell.world.close()


def picture(cell: Cell) -> Gate:
    """The picture is RGB of the size that the camera states."""
    found, side = cell.world.picture(), cell.camera.pixels
    right = isinstance(found, np.ndarray) and found.dtype == np.uint8 and found.shape == (side, side, 3)
    told = f"{found.dtype} {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__
    return Gate("picture", told, f"uint8 ({side}, {side}, 3)", right)


def reach(cell: Cell) -> Gate:
    """`can_reach` answers for each point, and the tool can go where the object is."""
    seen = cell.look(None)[0].seen
    answer = np.asarray(cell.world.can_reach(np.vstack([seen.contour, seen.c])))
    right = answer.dtype == np.bool_ and answer.shape == (len(seen.contour) + 1,)
    share = f", {answer.mean():.0%} of the contour" if right else ""
    return Gate("can_reach", f"{answer.dtype} {answer.shape}{share}", "a bool a point", bool(right))


def mesh(cell: Cell) -> Gate:
    """Nodes, triangles and strain belong to one mesh, or there is none."""
    world, scenery = cell.world, cell.world.scenery()
    nodes, strain, triangles = world.nodes(), world.strain(), scenery.mesh_triangles
    right = isinstance(scenery, Scenery)
    if nodes is not None:
        right &= nodes.ndim == 2 and nodes.shape[1] == 3 and bool(np.isfinite(nodes).all())
    if triangles is not None:
        right &= nodes is not None and int(triangles.max()) < len(nodes)
    if strain is not None:
        right &= nodes is not None and strain.shape == (len(nodes),)
    right &= (strain is not None) == ("strain" in world.offers)
    told = "no mesh" if nodes is None else f"{len(nodes)} nodes"
    return Gate("nodes, strain, scenery", told, "of one mesh", bool(right))


def branches(cell: Cell, setup: Setup) -> Gate:
    """Pushes tried in copies of the world leave the world itself as it was."""
    before, seen = cell.world.picture(), cell.look(None)[0].seen
    pushes = np.array([[0.3, setup.object.d[0]], [0.7, setup.object.d[1]]])
    looks = cell.seen_after(pushes, seen)
    same = bool(np.array_equal(before, cell.world.picture()))
    made = sum(look is not None for look in looks)
    return Gate(
        "branches", f"{made} of {len(pushes)} pushes tried", "the world stays as it was", same and made > 0
    )


def push(cell: Cell, setup: Setup) -> Gate:
    """A push moves the object the way the tool goes, and tells what the world says it offers."""
    before = cell.look(None)[0].seen
    _, path = cell.reachable(np.array([0.5, setup.object.d[1]]), before)
    outcome = cell.world.push(path)
    after = cell.look(before)[0].seen
    forward = float((after.c - before.c) @ path.direction)
    offers = cell.world.offers
    right = isinstance(outcome, Outcome) and 0.1 * path.d < forward < 1.5 * path.d
    right &= (outcome.strain is not None) == ("strain" in offers)
    right &= "film" not in offers or len(outcome.film) > 0
    right &= (outcome.tool_force_peak is not None) == ("force" in offers)
    return Gate(
        "push", f"{forward * 1e3:.1f} mm forward for {path.d * 1e3:.0f} mm", "0.1 to 1.5 times d", bool(right)
    )


def states(cell: Cell, setup: Setup) -> Gate:
    """A saved state is returned to: it looks the same and answers a push the same; others are refused."""
    world, seen = cell.world, cell.look(None)[0].seen
    _, path = cell.reachable(np.array([0.25, setup.object.d[1]]), seen)
    state = world.save()
    looks = []
    for _ in range(2):
        world.restore(state)
        before = world.picture()
        world.push(path)
        looks.append(np.stack([before, world.picture()]))
    world.restore(state)
    try:
        world.restore(b"no state of this world")
        said = "took up what is no state"
    except ValueError:
        said = f"{len(state) / 1e3:.0f} kB, returned to"
    same = bool(np.array_equal(looks[0], looks[1])) and np.array_equal(looks[0][0], world.picture())
    return Gate("states", said if same else "different", "the same, to the bit", same and "kB" in said)


def beyond_reach(cell: Cell) -> Gate:
    """A push out of reach is refused and moves nothing; a world that reaches everywhere has none."""
    seen = cell.look(None)[0].seen
    path = cell.layout.plan(np.array([0.5, 0.01]), seen, cell.part)
    far = type(path)(path.start + 100.0, path.direction, path.approach, path.d)
    if cell.world.can_reach(np.stack([far.start, far.end])).all():
        return Gate("push out of reach", "reaches everywhere", "WorldError, nothing moves", True)
    try:
        cell.world.push(far)
        said = "made"
    except WorldError:
        said = "refused"
    moved = float(np.linalg.norm(cell.look(seen)[0].seen.c - seen.c))
    return Gate("push out of reach", said, "WorldError, nothing moves", said == "refused" and moved < 1e-3)
