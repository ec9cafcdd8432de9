"""`camtruth study`: factorial studies, each a page that people can explore."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import click

from camtruth import options, terminal

STUDIES = ("gradient-quantization",)
JOURNAL = "results.jsonl"


@click.command()
@click.argument("name", type=click.Choice(STUDIES))
@click.option(
    "--seeds",
    type=click.IntRange(2, 100_000),
    default=4,
    show_default=True,
    metavar="N",
    help="How many camera bodies in each cell.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="NAME",
    help="Estimator: a name, or FILE.py:function. Repeat for several; all of ours by default.",
)
@click.option(
    "--cells",
    type=click.IntRange(1),
    metavar="N",
    help="Only so many of the cells, drawn from all: for a first look.",
)
@options.resume
@options.scheduler
@options.out("study")
@options.as_json
def command(
    name: str,
    seeds: int,
    methods: tuple[str, ...],
    cells: int | None,
    resume: bool,
    scheduler: str | None,
    out: Path,
    overwrite: bool,
    as_json: bool,
) -> None:
    """A study NAME: bias of every estimator over all combinations of some factors.

    gradient-quantization: the gradient of the light, by moving the lamp, against bits, gain, noise
    per step, defocus and the lamp's spectrum. Writes a page to explore, study.html, the findings,
    study.json, and every figure as gradient-quantization.parquet.
    """
    from analysis.methods import method
    from analysis.study.design import cases
    from analysis.study.findings import document
    from analysis.study.run import METHODS, study
    from analysis.study.table import write_parquet
    from camtruth.report.study import page
    from foundation.output import new_file, refuse_taken, write_checksums

    chosen = methods or METHODS
    for wanted in chosen:
        method(wanted)
    refuse_taken(out, overwrite=overwrite or resume)
    if overwrite and not resume:
        shutil.rmtree(out, ignore_errors=True)
    total = min(cells or len(cases()), len(cases()))
    with terminal.progress(f"{total} cells of {seeds} bodies", total) as advance:
        rows = study(
            out / JOURNAL,
            seeds=seeds,
            methods=chosen,
            cells=cells,
            scheduler=scheduler,
            progress=advance,
        )
    found = document(rows, seeds)
    words = f"camtruth study {name} --seeds {seeds}" + (f" --cells {cells}" if cells else "")
    write_parquet(out / f"{name}.parquet", rows)
    for file, text in (
        ("study.json", json.dumps(found, indent=1, allow_nan=False) + "\n"),
        ("study.html", page(rows, found, words)),
    ):
        with new_file(out / file) as scratch:
            scratch.write_text(text, encoding="utf-8")
    write_checksums(out)
    if as_json:
        terminal.print_json(found)
    else:
        for sentence in found["findings"]:
            click.echo(sentence)
        click.echo(f"{out / 'study.html'}")
