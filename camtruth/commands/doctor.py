"""`camtruth doctor`: which backends work here, and what to install for the faster ones."""

from __future__ import annotations

import platform
from typing import Any

import click

from camtruth import options, terminal


@click.command()
@options.as_json
def command(as_json: bool) -> None:
    """Which backends work here, what to install.

    CUDA is used before LLVM, LLVM before the scalar backend, which always works. All give equal
    results within Monte Carlo error; LLVM is about ten times faster than scalar. CAMTRUTH_BACKEND
    chooses one by name, DRJIT_LIBLLVM_PATH names an LLVM library.
    """
    with terminal.progress("trying the backends"):
        found = report()
    if as_json:
        terminal.print_json(found)
        return
    for entry in found["backends"]:
        state = "works" if entry["works"] else "does not work"
        click.echo(f"{entry['name']:<7} {state}: {entry['found']}")
        if not entry["works"]:
            click.echo(f"{'':<7} {entry['remedy']}")
    click.echo(f"\nused    {found['used']}: {found['advice']}")
    click.echo("\n" + "\n".join(f"{name:<15} {v}" for name, v in found["versions"].items()))


def report() -> dict[str, Any]:
    """What was found, as plain data."""
    from foundation.backend import NAMES, backend, probe
    from sensor.truth import versions

    probes = [probe(name) for name in NAMES]
    used = backend().name
    faster = [p for p in probes[: NAMES.index(used)] if p.name == "llvm"]
    advice = faster[0].remedy + " for ten times the speed" if faster else "nothing to install"
    return {
        "backends": [
            {"name": p.name, "works": p.works, "found": p.found, "remedy": p.remedy} for p in probes
        ],
        "used": used,
        "advice": advice,
        "versions": {"python": platform.python_version(), **versions()},
    }
