"""The physics gates, and the verb that prints them."""

import pytest

from deformpush import doctor
from deformpush.assemble import build_bench
from deformpush.sim import gates
from deformpush.sim.gates import Gate

GATES = [
    gates.friction,
    gates.stiffness,
    gates.material_of_second_scene,
    gates.time_step,
    gates.mesh_size,
    gates.area_at_rest,
    gates.repeatable,
    gates.explosion,
]


@pytest.fixture
def pretend(monkeypatch):
    """Gates that cost nothing, in place of those that are measured."""

    def pretend(*passed: bool) -> None:
        made = [Gate(f"gate {i}", "5 mm", "under 6 mm", p) for i, p in enumerate(passed)]
        monkeypatch.setattr(gates, "all_gates", lambda bench: iter(made))

    return pretend


def test_doctor_prints_one_line_a_gate(pretend, capsys):
    pretend(True, True)
    assert doctor.main([]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].split() == ["gate", "0", "5", "mm", "under", "6", "mm", "ok"]
    assert lines[-1] == "all gates hold"


def test_doctor_fails_with_one_gate(pretend, capsys):
    pretend(True, False, True)
    assert doctor.main(["object=meat"]) == 1
    out = capsys.readouterr().out
    assert out.count("FAILED") == 1
    assert out.endswith("a gate fails: do not trust numbers from this machine\n")


def test_every_gate_is_run(monkeypatch):
    for gate in GATES:
        monkeypatch.setattr(gates, gate.__name__, lambda bench, name=gate.__name__: name)
    assert list(gates.all_gates(None)) == [gate.__name__ for gate in GATES]


@pytest.mark.slow
@pytest.mark.parametrize("gate", GATES, ids=lambda gate: gate.__name__)
def test_every_gate_holds_for_rect(gate):
    result = gate(build_bench([]))
    assert result.passed, result


@pytest.mark.slow
@pytest.mark.parametrize("gate", [*GATES[:4], *GATES[5:]], ids=lambda gate: gate.__name__)
def test_gates_for_meat(gate):
    result = gate(build_bench(["object=meat"]))
    assert result.passed, result
