"""`camtruth effects`: the catalogue of what a camera can do to light."""

from __future__ import annotations

import inspect
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
    part = ", a term of equation (1)" if entry["base"] else ""
    click.echo(f"{entry['name']} (stage: {entry['stage']}{part})\n")
    click.echo(inspect.cleandoc(text) + "\n")
    rows = [
        (p["name"], f"{p['default']:g}", f"{p['min']:g}", f"{p['max']:g}", p["unit"], p["doc"])
        for p in entry["parameters"]
    ]
    if rows:
        heads = ("parameter", "default", "least", "most", "unit", "")
        terminal.print_table(heads, rows)
        first = entry["parameters"][0]
        setting = f"{entry['name']}.{first['name']}={first['default']:g}"
        click.echo(f"Add it: camtruth capture --with {setting}")
    click.echo(f"Source: {entry['reference']}")
