"""The documents say what is recorded, what a push did and which comes next, and why."""

import re
from dataclasses import replace

import numpy as np
import pytest

from deformpush.task import TERMS
from deformpush.viewer.text import NOTES, chosen, outcome
from tests.record.synthetic import CONFIG, SyntheticRun
from tests.viewer.recording import Contents, record


@pytest.fixture(scope="module")
def made():
    return SyntheticRun(11)


@pytest.fixture(scope="module")
def rows(made):
    return made.records()


def about(contents: Contents) -> str:
    return contents.fixed("/about", "TextDocument:text")[0]


def test_each_link_of_the_description_leads_to_something(full):
    links = re.findall(r"recording:/(/[^)]+)\)", about(full.contents))
    assert len(links) > 15
    assert set(links) <= full.contents.entities


def test_the_description_names_every_part(full):
    told = about(full.contents)
    assert told.startswith(f"# {full.info.title}\n")
    for term in TERMS:
        assert f"[{term.name}](recording://errors/{term.name}) ({term.symbol})" in told
    for entity in ("/model/mean/map", "/model/std/map", "/model/acq/map", "/xi/predicted", "/strain"):
        assert f"recording:/{entity})" in told
    assert "beyond 0.1 the object is harmed" in told
    assert "turns pale where it is strained, in full at a change of\nlength by 10%" in told
    assert "dark red beyond that" in told
    assert "`sim_time` for what happens inside a push" in told


def test_the_description_leaves_out_what_is_not_recorded(tmp_path, made, plain):
    least = Contents(
        record(tmp_path / "run", SyntheticRun(1, mesh=False), scene=False, motion=False, maps=False)
    )
    for contents in (least, plain.contents):
        links = set(re.findall(r"recording:/(/[^)]+)\)", about(contents)))
        assert not any(link.startswith(("/strain", "/model")) for link in links)
        assert links <= contents.entities
    assert "scene" not in about(least)
    assert "sim_time" not in about(least)


def test_the_configuration_is_shown_as_it_is(full):
    assert full.contents.fixed("/config", "TextDocument:text") == [f"```yaml\n{CONFIG}\n```"]
    assert full.contents.fixed("/config", "TextDocument:media_type") == ["text/markdown"]


def test_the_text_of_a_state_tells_what_came_and_what_comes_next(full):
    told = full.contents.at("/now", "TextDocument:text")
    assert list(told) == list(range(13))
    for row, following in zip(full.rows, full.rows[1:], strict=False):
        assert told[row.k] == [f"{outcome(full.info, row)}\n\n{chosen(following.action)}"]
    assert told[12] == [outcome(full.info, full.rows[-1])]


def test_an_outcome_stands_beside_what_was_expected_and_the_stops(made, rows):
    first, last = rows[0], rows[-1]
    assert outcome(made.info, first).startswith("#### Before the first push\n")
    proposal, errors = last.action.proposal, last.errors
    position, angle = errors["position_error_m"] * 1e3, np.degrees(abs(errors["angle_error_rad"]))
    lines = outcome(made.info, last).splitlines()
    assert lines[:2] == [
        "#### After push 11 of at most 80",
        f"**{proposal.phase}**: xi {last.action.xi:+.3f}, "
        f"expected {proposal.mean:+.3f} ± {2 * proposal.std:.3f}",
    ]
    assert lines[3:] == [
        "| error | now | stop |",
        "|---|---|---|",
        f"| position | {position:.1f} mm | 20 mm |",
        f"| angle | {angle:.1f} deg | 7 deg |",
        f"| shape | {errors['e_gamma']:.3f} | 0.15 |",
        f"| peak strain | {last.action.outcome.strain.p99_peak:.3f} | limit 0.1 |",
    ]


def test_a_choice_tells_its_bounds_its_reasons_and_its_numbers(rows):
    action = rows[-1].action
    (kappa_low, kappa_high), _ = action.proposal.bounds
    kappa, d = action.u
    assert chosen(action).splitlines() == [
        f"**Next, {action.proposal.phase}**: kappa **{kappa:.3f}** in {kappa_low:.2f} to {kappa_high:.2f}, "
        f"d **{d * 1e3:.1f} mm** in 10 to 30 mm",
        "",
        f"expected xi {action.proposal.mean:+.3f} ± {2 * action.proposal.std:.3f}, "
        f"acquisition {action.proposal.acq:+.3f}",
        "",
        "*length_kappa 0.2, length_d 0.01, length_t 15, noise 0.001*",
    ]
    assert len(chosen(rows[1].action).splitlines()) == 1, "the initial design has no reasons"


def test_the_speed_of_a_push_is_said_where_it_is_chosen(rows):
    action = rows[1].action
    assert "m/s" not in chosen(action)
    faster = replace(action, path=replace(action.path, speed=0.0522))
    assert ", at **0.052 m/s**" in chosen(faster)


@pytest.mark.parametrize("note", NOTES)
def test_what_a_note_means_is_said_in_a_sentence(rows, note):
    action = rows[-1].action
    noted = replace(action, proposal=replace(action.proposal, info={note: 1.0}))
    assert NOTES[note] in chosen(noted)
    assert note not in chosen(noted)
