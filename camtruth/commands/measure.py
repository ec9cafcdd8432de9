"""`camtruth measure`: what an estimator reads out of frames alone."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from camtruth import options, terminal

if TYPE_CHECKING:
    from analysis.parameters import NoiseParameters


@click.command()
@click.argument("capture", type=options.PATH)
@click.option(
    "--method",
    default="irie",
    show_default=True,
    metavar="NAME",
    help="Estimator: a name, or FILE.py:function for your own.",
)
@options.as_json
def command(capture: Path, method: str, as_json: bool) -> None:
    """Noise parameters from the frames in CAPTURE.

    CAPTURE is a folder with a capture.toml, real or simulated. The estimator sees frames and
    protocol, never the truth beside them.
    """
    from camtruth.measuring import measure

    with terminal.progress("measuring"):
        found = measure(capture, method)
    if as_json:
        terminal.print_json(found.to_json())
        return
    for warning in found.warnings:
        click.echo(f"Note: {warning}.", err=True)
    _print(found)


def _print(found: NoiseParameters) -> None:
    from analysis.parameters import UNITS, Estimate

    reasons: dict[str, list[str]] = {}
    keys = dict.fromkeys(key for table in found.channels.values() for key in table)
    rows = []
    for key in keys:
        cells = []
        for channel, table in found.channels.items():
            finding = table.get(key)
            if isinstance(finding, Estimate):
                cells.append(terminal.with_error(finding.value, finding.se))
            else:
                cells.append("–")
                if finding is not None:
                    reasons.setdefault(finding.reason, []).append(f"{key} {channel}")
        rows.append((key, *cells, UNITS.get(key, "")))
    terminal.print_table((found.method, *found.channels, "unit"), rows)
    for reason, cells in reasons.items():
        click.echo(f"No figure for {', '.join(cells)}: {reason}.")
