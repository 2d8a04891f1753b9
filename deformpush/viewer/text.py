"""Entities `about`, `config`, `now`: what is shown, with links, and what push k did, in words."""

import numpy as np
import rerun as rr

from deformpush.push_record import Action, PushRecord, RunInfo
from deformpush.state import Proposal
from deformpush.task import TERMS, TOTAL
from deformpush.viewer.panel import Panel
from deformpush.viewer.plots import BAND
from deformpush.viewer.scene import FULL_STRAIN

ABOUT = """\
# {title}

A robot pushes a soft object to a goal, one push at a time.

**What it sees.** The [camera](recording://camera/image) under the table shows the object with its
[contour](recording://camera/contour), the [goal](recording://camera/goal) and the
[trail](recording://camera/trail) of its centroid. The tool may start on the
[effective contour](recording://camera/effective), from kappa = 0 (blue) to kappa = 1 (orange); the next push
starts at the [red dot](recording://camera/next_push/start) and follows the
[arrow](recording://camera/next_push/arrow). {scene}

**How it goes.** The run ends when the errors of {errors} have reached their
stops, the grey lines. {strain}{force}The [phase](recording://phase) tells whether a push belongs to the
initial design, exploits what is known or explores.

**Why it pushes there.** {model}A push (kappa, d) changes the {total} by
[xi](recording://xi/actual); falling is good. [kappa](recording://actions/kappa) and
[d](recording://actions/d) stay inside their [bounds](recording://actions/kappa/bounds), which narrow around
what worked lately.

**Whether it was right.** [xi as it came](recording://xi/actual) against
[xi as predicted](recording://xi/predicted) with its band of two sigma.

Play the timeline `push` for the states between pushes{time}.
"""
SCENE = """The [scene](recording://scene/table) shows the same in 3D{colour}."""
PALE = """; the [object](recording://scene/object) turns pale where it is strained, in full at a change of
length by {full:.0%}"""
HARM = ", and dark red beyond that, its limit"
WHEN = "; after each push where it was strained most in that push"
STRAIN = """The [strain](recording://strain) is the largest relative change of length that 99 % of the
volume does not exceed, at its peak in each push{limit}. """
FORCE = """The [force](recording://force) is that between tool and object on the way forth. """
MODEL = """Before each push a Gaussian process predicts its effect: the
[mean](recording://model/mean/map) (blue: the error falls), how unsure it is
([sigma](recording://model/std/map)) and the [acquisition](recording://model/acq/map) that is minimised
(dark: promising, grey: not allowed). Dots are
[pushes made](recording://model/data), the box the [bounds](recording://model/bounds), the red dot the
[choice](recording://model/chosen). """
NOTES = {
    "harm_avoided": "\nThe best acquisition was expected to raise the error: the lowest error is taken.",
    "no_help_expected": "\n**No push is expected to help**: the most informative of those that may is made.",
    "held_back": "\nThe best push may strain too much: the best of those known to be gentle is made.",
    "no_safe_push": "\n**No push is known to be gentle enough**: the gentlest that may help is made.",
    "begun_elsewhere": "\nNo push known to be gentle is expected to help: a slow, short one elsewhere may.",
    "cheating": "\nFound by trying pushes in copies of the world, which no robot can do.",
}
"""What the notes of a proposal mean."""
TIME = """, `sim_time` for what happens inside a push: the tool (grey) and the outline of the
[object](recording://camera/inside/outline) it moves"""


class Text(Panel):
    """Documents: one for the whole run, one that changes with k."""

    def __init__(self, scene: bool, motion: bool, maps: bool, strain: bool) -> None:
        """Describe what is recorded and nothing else."""
        self._scene, self._strain = scene, strain
        self._parts = {
            "model": MODEL if maps else "",
            "time": TIME if motion else "",
        }

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log description and configuration."""
        self._info = info
        limit = "" if info.strain_limit is None else f"; beyond {info.strain_limit:.3g} the object is harmed"
        parts = self._parts | {
            "errors": _listed([f"[{t.name}](recording://errors/{t.name}) ({t.symbol})" for t in TERMS]),
            "total": f"[{TOTAL.name} error](recording://errors/{TOTAL.name})",
            "scene": SCENE.format(colour=_colour(info, self._strain)) if self._scene else "",
            "strain": STRAIN.format(limit=limit) if self._strain else "",
            "force": FORCE if "force" in info.offers else "",
        }
        rec.log("about", _markdown(ABOUT.format(title=info.title, **parts)), static=True)
        rec.log("config", _markdown(f"```yaml\n{info.config_yaml}\n```"), static=True)

    def decide(self, rec: rr.RecordingStream, action: Action) -> None:
        """Add the push that comes next to the text of the state it was chosen in."""
        rec.log("now", _markdown(f"{self._state}\n\n{chosen(action)}"))

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log push k in words."""
        self._state = outcome(self._info, record)
        rec.log("now", _markdown(self._state))


def outcome(info: RunInfo, record: PushRecord) -> str:
    """Say what push k did and how far the goal is, as Markdown."""
    rows = []
    for term in TERMS:
        stop = f"{info.stop.value(term) * term.scale:.3g} {term.unit}".removesuffix(" -")
        rows.append((term.name, term.show(record.errors.size(term)), stop))
    if (action := record.action) is None:
        lines = ["#### Before the first push"]
    else:
        expected = f", expected {_expectation(action.proposal)}" if np.isfinite(action.proposal.mean) else ""
        lines = [f"#### After push {record.k} of at most {info.max_pushes}"]
        lines.append(f"**{action.proposal.phase}**: xi {action.xi:+.3f}{expected}")
        if (strain := action.outcome.strain) is not None:
            limit = "-" if info.strain_limit is None else f"limit {info.strain_limit:.3g}"
            rows.append(("peak strain", f"{strain.p99_peak:.3f}", limit))
        if (force := action.outcome.tool_force_peak) is not None:
            limit = "-" if info.force_limit is None else f"limit {info.force_limit:.3g} N"
            rows.append(("peak force", f"{force:.2f} N", limit))
    lines += ["", "| error | now | stop |", "|---|---|---|"]
    lines += [f"| {name} | {now} | {stop} |" for name, now, stop in rows]
    return "\n".join(lines)


def chosen(action: Action) -> str:
    """Say which push comes next, and why, as Markdown."""
    made, (kappa, d) = action.proposal, action.u
    (kappa_low, kappa_high), (d_low, d_high) = made.bounds
    speed = "" if action.path.speed is None else f", at **{action.path.speed:.3f} m/s**"
    lines = [
        f"**Next, {made.phase}**: kappa **{kappa:.3f}** in {kappa_low:.2f} to {kappa_high:.2f}, "
        f"d **{d * 1e3:.1f} mm** in {d_low * 1e3:.0f} to {d_high * 1e3:.0f} mm{speed}",
    ]
    if np.isfinite(made.mean):
        lines += ["", f"expected xi {_expectation(made)}, acquisition {made.acq:+.3f}"]
    lines += [sentence for note, sentence in NOTES.items() if note in made.info]
    numbers = [
        f"{name} {value:.3g}" for name, value in made.info.items() if np.isfinite(value) and name not in NOTES
    ]
    if numbers:
        lines += ["", f"*{', '.join(numbers)}*"]
    return "\n".join(lines)


def _colour(info: RunInfo, strain: bool) -> str:
    """What the colour of the object says in the scene."""
    if not strain:
        return ""
    pale = PALE.format(full=info.strain_limit or FULL_STRAIN)
    return pale + ("" if info.strain_limit is None else HARM) + WHEN


def _expectation(made: Proposal) -> str:
    return f"{made.mean:+.3f} ± {BAND * made.std:.3f}"


def _listed(parts: list[str]) -> str:
    """Parts in a sentence."""
    return ", ".join(parts[:-1]) + " and " + parts[-1]


def _markdown(text: str) -> rr.TextDocument:
    return rr.TextDocument(text, media_type="text/markdown")
