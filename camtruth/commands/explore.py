"""`camtruth explore`: every effect to play with, on one page."""

from __future__ import annotations

from pathlib import Path

import click

from camtruth import options, terminal


@click.command()
@click.option(
    "--camera",
    default="icx098",
    show_default=True,
    metavar="NAME|FILE",
    help="Camera: a preset or a TOML file.",
)
@options.scene
@click.option(
    "--lamp", default="incandescent", show_default=True, metavar="NAME", help="Its light."
)
@click.option(
    "--effect", "names", multiple=True, metavar="NAME", help="This effect alone. Repeatable."
)
@options.seed("Seed of everything random.")
@options.out("explore")
def command(
    camera: str,
    scene: str,
    lamp: str,
    names: tuple[str, ...],
    seed: int,
    out: Path,
    overwrite: bool,
) -> None:
    """A page on which every effect can be turned up and down.

    Writes explore.html: frames of a camera without an effect and with it, their difference, noise
    over signal, columns and spectrum, for each effect beyond equation (1) and several strengths. It
    needs no network and no other file.
    """
    from camtruth.exploring import states, strengths_of
    from camtruth.report.explore import page
    from foundation.errors import InputError
    from foundation.output import new_folder, refuse_taken
    from scenes.scene import load as load_scene
    from sensor.camera_file import load as load_camera
    from sensor.catalogue import catalogue, effect

    made, seen = load_camera(camera), load_scene(scene)
    seen.named(lamp)
    refuse_taken(out, overwrite=overwrite)
    words = f"camtruth explore --camera {camera} --scene {scene} --lamp {lamp} --seed {seed}"
    words += "".join(f" --effect {name}" for name in names)
    wanted = [effect(name) for name in names]
    kinds = wanted or [kind for kind in catalogue().values() if not kind.base]
    shown = []
    total = sum(len(strengths_of(kind)) for kind in kinds)
    with terminal.progress("effects at all their strengths", total) as advance:
        for state in states(made, seen, lamp, kinds, seed):
            shown.append(state)
            advance(1)
    if not shown:
        raise InputError(
            f"camera '{camera}' can have none of {', '.join(names)}",
            "expected one that goes with its pixels",
            "leave out --effect, or give a camera of another kind",
        )
    with new_folder(out, overwrite=overwrite) as folder:
        (folder / "explore.html").write_text(page(made, shown, words), encoding="utf-8")
    click.echo(f"{out / 'explore.html'}")
