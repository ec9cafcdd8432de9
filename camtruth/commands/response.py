"""`camtruth response`: how much the results hang on a camera response that nobody measured."""

from __future__ import annotations

import dataclasses

import click

from camtruth import options, terminal


@click.command()
@click.argument("scene", default="chart")
@click.option(
    "--size",
    "sizes",
    type=options.Between(1e-3, 0.5),
    multiple=True,
    default=(0.1, 0.2),
    show_default=True,
    metavar="E",
    help="Perturbation of one channel, relative. Repeatable.",
)
@click.option("--response", metavar="FILE", help="Another camera response: a CSV file nm,R,G,B.")
@options.as_json
def command(scene: str, sizes: tuple[float, ...], response: str | None, as_json: bool) -> None:
    """What a perturbed camera response does to the light of SCENE, channel by channel.

    Each channel is changed by itself, in level, in tilt, by a hump in the middle of the spectrum
    and by a leak of a tenth of that. Rates change by one factor in a panel; the shot noise by its
    square root; PRNU and the shot noise coefficient, which are ratios, do not.
    """
    from render.perturbed import changes
    from scenes.scene import load
    from scenes.spectra import response as known_response

    known = load(scene)
    if response is not None:
        detector = dataclasses.replace(known.detector, response=response)
        known = dataclasses.replace(known, detector=detector)
        known_response(response, detector.infrared_cut)
    rows = [x for size in sizes for lamp in known.lamp for x in changes(known, lamp, size)]
    if as_json:
        terminal.print_json(
            {
                "format": "camtruth-response/1",
                "scene": known.name,
                "response": known.detector.response,
                "changes": [dataclasses.asdict(row) for row in rows],
            }
        )
        return
    click.echo(f"response '{known.detector.response}' of scene '{known.name}', changes in %")
    heads = ["lamp", "channel", "kind", "size", "grey rate", "grey spread", "shot noise", "worst"]
    terminal.print_table(
        [*heads, "panel"],
        [
            [
                row.lamp,
                row.channel,
                row.kind,
                f"{100 * row.size:g}",
                f"{100 * row.grey:+.2f}",
                f"{100 * row.spread:.2f}",
                f"{100 * row.shot_noise:+.2f}",
                f"{100 * row.worst:+.2f}",
                row.panel,
            ]
            for row in rows
        ],
    )
