"""Entities `about`, `config`, `now`: what is shown, with links, and what push k did, in words."""

import numpy as np
import rerun as rr

from deformpush.record.push_record import Decision, PushRecord, RunInfo

ABOUT = """\
# {title}

A robot pushes a soft object to a goal, one push at a time.

**What it sees.** The [camera](recording://camera/image) under the table shows the object with its
[contour](recording://camera/contour), the [goal](recording://camera/goal) and the
[trail](recording://camera/trail) of its centroid. The tool may start on the
[effective contour](recording://camera/effective), from kappa = 0 (blue) to kappa = 1 (orange); the next push
starts at the [red dot](recording://camera/next_push/start) and follows the
[arrow](recording://camera/next_push/arrow). {scene}

**How it goes.** The run ends when the errors of [position](recording://errors/position) (e_c),
[angle](recording://errors/angle) (e_theta) and [shape](recording://errors/shape) (e_gamma) have reached their
stops, the grey lines. The [phase](recording://phase) tells whether a push belongs to the initial design,
exploits what is known or explores.

**Why it pushes there.** {model}A push (kappa, d) changes the [total error](recording://errors/total) by
[xi](recording://xi/actual); falling is good. [kappa](recording://actions/kappa) and
[d](recording://actions/d) stay inside their [bounds](recording://actions/kappa/bounds), which narrow around
what worked lately.

**Whether it was right.** [xi as it came](recording://xi/actual) against
[xi as predicted](recording://xi/predicted) with its band of two sigma.

Play the timeline `push` for the states between pushes{time}.
"""
SCENE = """The [scene](recording://scene/table) shows the same in 3D; the [object](recording://scene/object)
turns pale where it is stretched."""
MODEL = """Before each push a Gaussian process predicts its effect: the
[mean](recording://model/mean/map) (blue: the error falls), how unsure it is
([sigma](recording://model/std/map)) and the [acquisition](recording://model/acq/map) that is minimised
(dark: promising). Dots are
[pushes made](recording://model/data), the box the [bounds](recording://model/bounds), the red dot the
[choice](recording://model/chosen). """
TIME = ", `sim_time` for the motion inside them"


class Words:
    """Documents: one for the whole run, one that changes with k."""

    def __init__(self, scene: bool, motion: bool, maps: bool) -> None:
        """Describe what is recorded and nothing else."""
        self._parts = {
            "scene": SCENE if scene else "",
            "model": MODEL if maps else "",
            "time": TIME if motion else "",
        }

    def begin(self, rec: rr.RecordingStream, info: RunInfo, first: PushRecord) -> None:
        """Log description and configuration."""
        self._info = info
        rec.log("about", _markdown(ABOUT.format(title=info.title, **self._parts)), static=True)
        rec.log("config", _markdown(f"```yaml\n{info.config_yaml}\n```"), static=True)

    def decide(self, rec: rr.RecordingStream, decision: Decision) -> None:
        """Keep the choice for the text of its outcome."""

    def arrive(self, rec: rr.RecordingStream, record: PushRecord) -> None:
        """Log push k in words."""
        rec.log("now", _markdown(sentence(self._info, record)))


def sentence(info: RunInfo, record: PushRecord) -> str:
    """Describe push k and the state after it as Markdown."""
    rows = [
        ("position", f"{record.position_error_m * 1e3:.1f} mm", f"{info.stop_position_m * 1e3:.0f} mm"),
        (
            "angle",
            f"{abs(np.degrees(record.angle_error_rad)):.1f} deg",
            f"{np.degrees(info.stop_angle_rad):.0f} deg",
        ),
        ("shape e_gamma", f"{record.e_gamma:.3f}", f"{info.stop_e_gamma:.3f}"),
    ]
    lines = [
        f"### After push {record.k} of at most {info.max_pushes}" if record.k else "### Before the first push"
    ]
    if (u := record.decision) is not None:
        lines.append(f"**{u.phase}**: kappa {u.kappa:.3f}, d {u.d * 1e3:.1f} mm, xi **{record.xi:+.3f}**")
        if np.isfinite(u.xi_mean):
            lines[-1] += f", predicted {u.xi_mean:+.3f} ± {2 * u.xi_std:.3f}"
    lines += ["", "| error | now | stop |", "|---|---|---|"]
    lines += [f"| {name} | {now} | {stop} |" for name, now, stop in rows]
    return "\n".join(lines)


def _markdown(text: str) -> rr.TextDocument:
    return rr.TextDocument(text, media_type="text/markdown")
