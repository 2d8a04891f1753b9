"""The gates of physics and accuracy, and the verb that prints them."""

import numpy as np
import pytest

from deformpush.cell.world import Outcome, WorldError
from deformpush.checks import accuracy, bullet, by_world, mujoco
from deformpush.checks import physics as gates
from deformpush.checks.bench import Bench
from deformpush.checks.by_world import build_bench
from deformpush.checks.gate import Gate
from deformpush.cli import doctor
from deformpush.errors import UserError
from deformpush.worlds.bullet.world import BulletWorld
from tests import pictures

OWN = {
    "bullet": (bullet.explosion,),
    "mujoco": (mujoco.weight, mujoco.chain, mujoco.explosion, mujoco.states),
}
GATES = [(world, gate) for world, own in OWN.items() for gate in (*gates.SHARED, *own)]


@pytest.fixture
def pretend(monkeypatch):
    """Gates that cost nothing, in place of those that are measured."""

    def pretend(*passed: bool) -> None:
        made = [Gate(f"gate {i}", "5 mm", "under 6 mm", p) for i, p in enumerate(passed)]
        monkeypatch.setattr(by_world, "contract", lambda overrides: iter(made[:1]))
        for module in (bullet, mujoco):
            monkeypatch.setattr(module, "examine", lambda bench, gates: iter(made[1:2]))
        monkeypatch.setattr(accuracy, "gates", lambda overrides: iter(made[2:]))

    return pretend


def test_doctor_prints_one_line_a_gate(pretend, capsys):
    pretend(True, True, True)
    assert doctor.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    for number in range(3):
        assert lines[1 + number].split() == ["gate", str(number), "5", "mm", "under", "6", "mm", "ok"]
    assert lines[-1] == "all gates hold"


def test_doctor_fails_with_one_gate(pretend, capsys):
    for fails, world in enumerate(("bullet", "mujoco", "bullet")):
        pretend(*(number != fails for number in range(3)))
        assert doctor.main(["object=meat", f"world={world}"]) == 1
        out = capsys.readouterr().out
        assert out.count("FAILED") == 1
        assert out.endswith("a gate fails: do not trust numbers from this world\n")


def test_only_engines_have_physics_to_be_checked(monkeypatch, capsys):
    monkeypatch.setattr(Bench, "world", lambda bench: pytest.fail("there is no engine to examine"))
    monkeypatch.setattr(accuracy, "gates", lambda overrides: pytest.fail("there is no arm to examine"))
    assert doctor.main(["world=toy", "robot=tool"]) == 0
    assert capsys.readouterr().out.endswith("all gates hold\n")


def test_a_cell_of_the_table_never_runs_into_the_next(monkeypatch, capsys):
    """A second machine's widest row did."""
    wide = [letter * width for letter, width in zip("xyz", doctor.WIDTHS, strict=True)]
    monkeypatch.setattr(by_world, "contract", lambda overrides: iter([Gate(*wide, True)]))
    assert doctor.main(["world=toy"]) == 0
    assert capsys.readouterr().out.splitlines()[1].split() == [*wide, "ok"]


@pytest.mark.parametrize("world", OWN)
def test_every_gate_is_run(world, monkeypatch):
    ran = []
    monkeypatch.setattr({"bullet": bullet, "mujoco": mujoco}[world], "examine", lambda bench, gates: gates)
    monkeypatch.setattr(accuracy, "gates", lambda overrides: iter(["camera", "arm"]))
    ran = list(build_bench([f"world={world}"]).gates())
    assert ran == [*gates.SHARED, *OWN[world], "camera", "arm"]


def test_a_gate_whose_simulation_explodes_has_failed():
    def time_step(bench):
        raise WorldError("the simulation exploded: everywhere")

    (gate,) = gates.examine(build_bench([]), [time_step])
    assert (gate.name, gate.passed) == ("time step", False)
    assert gate.measured == "none: the simulation exploded: everywhere"


@pytest.mark.slow
@pytest.mark.parametrize(("world", "gate"), GATES, ids=lambda part: getattr(part, "__name__", part))
@pytest.mark.parametrize("name", ["rect", "meat"])
def test_every_gate_holds(name, world, gate):
    result = gate(build_bench([f"world={world}", f"object={name}"]))
    assert result.passed, result


@pytest.mark.parametrize(
    ("apart", "passes", "measured"),
    [
        ([(0.0, 0.0), (0.4, 0.0)], True, "0.00 mm 0.0 deg; 0.40 mm 0.0 deg"),
        ([(0.6, 0.0), (0.0, 0.0)], False, "0.60 mm 0.0 deg; 0.00 mm 0.0 deg"),
        ([(0.0, 0.0), (0.6, 0.0)], False, "0.00 mm 0.0 deg; 0.60 mm 0.0 deg"),
        ([(0.0, 2.0), (0.1, -3.0)], True, "0.00 mm 2.0 deg; 0.10 mm 3.0 deg"),
    ],
)
def test_the_pose_gates_hold_every_place(apart, passes, measured, monkeypatch):
    """How far the plans lie apart in mm, and how far they are turned in degrees."""
    plans = [
        [pictures.RECT, pictures.RECT],
        [pictures.placed(pictures.RECT, x / 1e3, 0, t) for x, t in apart],
    ]
    monkeypatch.setattr(gates, "plans", lambda bench, **engine: plans.pop(0))
    result = gates.time_step(build_bench(["world=mujoco"]))
    assert (result.passed, result.measured) == (passes, measured)


def pretended_strains(monkeypatch, *of: list[float]) -> None:
    """Let the benches asked one after the other have these peak strains."""
    found = iter(of)
    monkeypatch.setattr(gates, "peak_strains", lambda bench, **engine: np.array(next(found)))


@pytest.mark.parametrize(
    ("before", "after", "passes", "measured"),
    [
        ([0.1, 0.2, 0.3], [0.12, 0.2, 0.28], True, "p99 +0.0% (one place +20%)"),
        ([0.1, 0.1, 0.1], [0.1, 0.12, 0.12], False, "p99 +13.3% (one place +20%)"),
        ([0.1, 0.1, 0.1], [0.08, 0.09, 0.09], False, "p99 -13.3% (one place -20%)"),
    ],
)
@pytest.mark.parametrize("gate", [gates.strain_time_step, gates.strain_mesh_size])
def test_the_strain_gates_hold_the_mean_of_several_places(before, after, passes, measured, gate, monkeypatch):
    pretended_strains(monkeypatch, before, after)
    result = gate(build_bench([]))
    assert (result.passed, result.measured) == (passes, measured)


def test_the_gates_take_the_parts_of_the_configuration():
    bench = build_bench(["object=meat", "world.margin=0.001"])
    assert bench.sheet.thickness == 0.01
    assert bench.spec.margin == 0.001
    assert type(bench.tool).__name__ == "BareTool"
    assert bench.overrides == ("object=meat", "world.margin=0.001")


@pytest.mark.parametrize("overrides", [["world=toy"], ["robot=kuka_iiwa"]])
def test_the_gates_need_the_real_engine_and_the_bare_tool(overrides):
    needed = r"^world=.*: the physics gates need world=bullet or world=mujoco with robot=tool$"
    with pytest.raises(UserError, match=needed):
        build_bench(overrides)


def test_the_strain_gates_fail_when_the_changed_simulation_explodes(monkeypatch):
    def explodes(bench, **engine):
        if engine:
            raise WorldError("the simulation exploded: everywhere")
        return np.array([0.1])

    monkeypatch.setattr(gates, "peak_strains", explodes)
    result = gates.strain_mesh_size(build_bench([]))
    assert (result.passed, result.measured) == (False, "none: the simulation exploded")


@pytest.mark.parametrize(
    ("truth", "passes"), [(lambda p: p, True), (lambda p: 1.02 * p, False), (lambda p: p + 1e-3, False)]
)
def test_the_camera_gate_fails_when_area_or_centroid_is_off(truth, passes, monkeypatch):
    """The mesh's plan as it is, 4 % larger, and moved by 1.4 mm."""
    monkeypatch.setattr(accuracy, "rim", lambda mesh, nodes: about(gates.rim(mesh, nodes), truth))
    assert accuracy.seen([], accuracy.POSES[:1]).passed == passes


def about(plan, change):
    """Change a plan about its own centroid."""
    middle = gates.centroid(plan)
    return change(plan - middle) + middle


@pytest.mark.parametrize(("error_m", "passes"), [(1.9e-3, True), (2.1e-3, False)])
def test_the_arm_gate_takes_the_worst_push(error_m, passes, monkeypatch):
    errors = iter([1e-4, error_m, 2e-4])
    monkeypatch.setattr(BulletWorld, "push", lambda world, path: Outcome(tip_error=next(errors)))
    gate = accuracy.tip([], (0.1, 0.5, 0.9))
    assert (gate.measured, gate.passed) == (f"{error_m * 1e3:.2f} mm", passes)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rect", "meat"])
@pytest.mark.parametrize("world", OWN)
def test_camera_and_arm_are_accurate(world, name):
    for gate in accuracy.gates([f"object={name}", "robot=tool", f"world={world}"]):
        assert gate.passed, gate
