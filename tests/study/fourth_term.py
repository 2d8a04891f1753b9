"""A fourth error term shows up wherever errors are shown: run by `test_fourth_term`, in its own process.

Constants are derived from `TERMS` when modules are imported, so the term has to be there before.
"""

import sys
from dataclasses import replace
from pathlib import Path

from deformpush import task

DENT = replace(
    task.TERMS[2],
    name="dent",
    symbol="e_dent",
    tex="$e_d$",
    unit="mm",
    column="dent_m",
    scale=1e3,
    digits=2,
    colour=(1, 2, 3),
)
"""Weighed and stopped on as the shape; the made-up runs say 0.25 of every term they do not know."""


def main(folder: Path) -> None:
    """Make two runs and look at all that is made of them."""
    from deformpush.experiment.console import closing_lines
    from deformpush.record.finished import read
    from deformpush.record.folder import RunFolder
    from deformpush.study import (
        compare_figure,
        compare_recording,
        film,
        run_data,
        run_figure,
        run_page,
        sweep_page,
    )
    from deformpush.study.find_runs import find_runs
    from deformpush.study.tables import run_rows, table_csv, variant_rows
    from deformpush.study.variants import differing, titles, variants
    from tests.study import drawn
    from tests.study.folders import finished

    for seed in (0, 1):
        finished(folder / f"seed={seed}", 3 + seed, seed=seed)
    runs = find_runs([folder]).runs
    run, data = runs[0], run_data.read(RunFolder(folder / "seed=0"))
    groups = variants(runs, differing(runs))

    errors = run_figure.figure(data).axes[4]
    assert drawn.legend(errors)["$e_d$, stop 150 mm"] == DENT.colour
    assert drawn.data(drawn.curves(errors)[3])[:, 1].tolist() == [0.25] * 4
    assert drawn.levels(errors)[3] == (0.15, DENT.colour)

    frame = film.Frame(run, data)
    frame.show(2)
    assert frame.panels[3].get_ylabel() == "dent error (mm)"
    assert frame.panels[3].lines[0].get_ydata().tolist() == [250.0] * 3

    panels = compare_figure.figure(groups).axes
    assert [axis.get_ylabel() for axis in panels[3:]] == ["dent error (mm)", "runs at the goal (%)"]
    (line,) = compare_recording.lines(groups, titles(runs, {}))[:1]
    assert line.errors["dent"].tolist() == [250.0] * 4

    for chart in (run_page.charts(run, 3)[3], sweep_page.charts(groups, runs)[3]):
        assert (chart.title, chart.marks[-1].key) == ("dent error (mm)", "stop 150")
    for header, row, *_ in (run_rows(runs, {}), variant_rows(groups), run_page.push_rows(run)):
        assert dict(zip(header, row, strict=True))["dent (mm)"] == "250.00"
    assert "dent 250.00 mm" in run_page.state_text(run, 1)
    assert {"e_dent", "dent_m"} < set(table_csv(runs, {}).splitlines()[0].split(","))
    assert "dent 250.00 mm" in closing_lines(read(RunFolder(folder / "seed=0"), "x").summary, folder)


if __name__ == "__main__":
    task.TERMS = (*task.TERMS, DENT)
    symbols = [term.symbol for term in task.TERMS]
    measured = [term.column for term in task.TERMS if term.column != term.symbol]
    task.ERROR_COLUMNS = (*symbols, task.TOTAL.symbol, *measured)
    main(Path(sys.argv[1]))
