"""`camtruth effects`: the catalogue of what a camera can do to light."""

from __future__ import annotations

from typing import Any

import click

from camtruth import options, terminal


@click.command()
@click.argument("name", required=False)
@options.as_json
def command(name: str | None, as_json: bool) -> None:
    """The catalogue of effects; NAME for one alone.

    Each parameter NAME.PARAMETER can be set with 'camtruth capture --with NAME.PARAMETER=VALUE'.
    """
    from sensor.catalogue import effect, to_json

    document = to_json()
    if name is not None:
        chosen = effect(name)
        document["effects"] = [e for e in document["effects"] if e["name"] == chosen.name]
    if as_json:
        terminal.print_json(document)
    elif name is not None:
        _explain(document["effects"][0], effect(name).__doc__ or "")
    else:
        rows = [
            (e["name"], e["stage"], "equation (1)" if e["base"] else "", _names(e))
            for e in document["effects"]
        ]
        terminal.print_table(("effect", "stage", "", "parameters"), rows)


def _names(entry: dict[str, Any]) -> str:
    return ", ".join(p["name"] for p in entry["parameters"])


def _explain(entry: dict[str, Any], text: str) -> None:
    click.echo(f"{entry['name']} ({entry['stage']})\n")
    click.echo("\n".join(line.strip() for line in text.strip().splitlines()) + "\n")
    rows = [
        (p["name"], f"{p['default']:g}", f"{p['min']:g}", f"{p['max']:g}", p["unit"], p["doc"])
        for p in entry["parameters"]
    ]
    if rows:
        heads = ("parameter", "default", "least", "most", "unit", "")
        terminal.print_table(heads, rows)
    click.echo(f"Source: {entry['reference']}")
