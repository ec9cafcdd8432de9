"""Options that several commands share, spelt and explained the same everywhere."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])


class _Path(click.Path):
    """A path; an empty one, which would be the current folder, is a slip."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path.

        Raises:
            click.BadParameter: for none.
        """
        if value == "":
            self.fail("it is empty", param, ctx)
        return super().convert(value, param, ctx)


class Between(click.FloatRange):
    """A number in a range; NaN is outside of every one."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The number.

        Raises:
            click.BadParameter: for one outside, or none.
        """
        number = super().convert(value, param, ctx)
        if math.isnan(number):
            self.fail(f"{value} is not a number", param, ctx)
        return number


PATH = _Path(path_type=Path)

OUTPUT_ROOT = Path("camtruth-out")
MAX_SEED = 2**63 - 1
SAMPLES = 128
"""Light paths per pixel: they leave a hundredth of the smallest PRNU that the paper prints."""


def out(command: str) -> Callable[[Command], Command]:
    """`--out DIR` and `--overwrite`, as arguments `out` and `overwrite`."""

    def decorate(function: Command) -> Command:
        function = click.option(
            "--overwrite", is_flag=True, help="Replace the output folder if it is not empty."
        )(function)
        return click.option(
            "--out",
            type=PATH,
            default=OUTPUT_ROOT / command,
            show_default=True,
            metavar="DIR",
            help="Folder to write.",
        )(function)

    return decorate


def seed(meaning: str) -> Callable[[Command], Command]:
    """`--seed N`, with what it decides."""
    return click.option(
        "--seed",
        type=click.IntRange(0, MAX_SEED),
        default=0,
        show_default=True,
        metavar="N",
        help=meaning,
    )


as_json = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON, and nothing else, on standard output."
)

camera = click.option(
    "--camera",
    default="i400",
    show_default=True,
    metavar="NAME|FILE",
    help="Camera: a preset or a TOML file.",
)

scene = click.option(
    "--scene",
    default="chart",
    show_default=True,
    metavar="NAME|FILE",
    help="Scene for the lamps that are rendered: a preset or a TOML file.",
)

rate = click.option(
    "--rate",
    "rates",
    multiple=True,
    metavar="LAMP=FILE",
    help="Rate image of a lamp, instead of rendering it. Repeat for several lamps.",
)

settings = click.option(
    "--with",
    "settings",
    multiple=True,
    metavar="EFFECT.PARAMETER=VALUE",
    help="Change an effect of the camera, or add one. Repeat for several.",
)

noise = click.option(
    "--noise",
    type=Between(1e-6, 1),
    metavar="REL",
    help="Relative Monte Carlo error to reach inside every panel, with more samples if needed.",
)

samples = click.option(
    "--samples",
    type=click.IntRange(1, 1_000_000),
    default=SAMPLES,
    show_default=True,
    metavar="N",
    help="Light paths per pixel.",
)

body_seed = click.option(
    "--body-seed",
    type=click.IntRange(0, MAX_SEED),
    default=0,
    show_default=True,
    metavar="N",
    help="Seed of the camera body: its fixed patterns.",
)

resume = click.option(
    "--resume", is_flag=True, help="Go on with a run that was stopped; redo only what is missing."
)


def _answering(_: click.Context, __: click.Parameter, address: str | None) -> str | None:
    """The scheduler, once it has answered: what comes before the jobs may take minutes."""
    if address is not None:
        from foundation.jobs import refuse_absent

        refuse_absent(address)
    return address


scheduler = click.option(
    "--scheduler",
    metavar="ADDRESS",
    callback=_answering,
    help="Dask scheduler, as in tcp://10.0.0.1:8786, or 'processes'; this process by default.",
)
