"""`camtruth blind`: captures with a withheld effect, answers, their score, a fair split."""

from __future__ import annotations

import json
from pathlib import Path

import click

from camtruth import options, terminal

FOLDER = options.OUTPUT_ROOT / "blind"
FRAMES = 24
SIZE = "160x120"
CAMERAS = ("i400", "icx098")


@click.group()
def command() -> None:
    """Examine a diagnosis with effects that it cannot know.

    make draws captures and seals their truth; solve answers them; score opens the seal when all
    answers are written and hashed; split divides a real capture. See docs/withheld.md.
    """


@command.command()
@click.option("--set", "name", required=True, metavar="NAME", help="What to call the set.")
@click.option(
    "--cases",
    multiple=True,
    metavar="KIND=N",
    help="Cases of a kind: null, own, pair, left-out, decoy, put-back, others, strange. Repeat"
    " for several; once one is given, the others are 0.",
)
@click.option(
    "--camera",
    "cameras",
    multiple=True,
    default=CAMERAS,
    show_default=True,
    metavar="NAME|FILE",
    help="Camera that the bodies are like. Repeat for several.",
)
@click.option(
    "--protocol",
    default="paper",
    show_default=True,
    metavar="NAME|FILE",
    help="Shots: a preset or a TOML file.",
)
@click.option(
    "--frames",
    type=click.IntRange(2, 100_000),
    default=FRAMES,
    show_default=True,
    metavar="N",
    help="Frames of every shot.",
)
@click.option("--size", default=SIZE, show_default=True, metavar="WxH", help="Pixels of a frame.")
@options.scene
@options.samples
@options.seed("Decides the set, together with a secret that is drawn and sealed.")
@options.resume
@options.scheduler
@click.option(
    "--out",
    type=options.PATH,
    metavar="DIR",
    help=f"Folder to write; DIR.seal takes the truth.  [default: {FOLDER}/NAME]",
)
@click.option("--overwrite", is_flag=True, help="Replace the output folders if not empty.")
def make(
    name: str,
    cases: tuple[str, ...],
    cameras: tuple[str, ...],
    protocol: str,
    frames: int,
    size: str,
    scene: str,
    samples: int,
    seed: int,
    resume: bool,
    scheduler: str | None,
    out: Path | None,
    overwrite: bool,
) -> None:
    """A set of captures with opaque names, and its truth under seal.

    The set holds the SHA-256 of the truth, salted; no seed in it makes the truth again. Effects
    are given strengths of 1 to 16 detection limits. Other people's code that is not installed is
    left out, and the set says so.
    """
    from camtruth.blind import arguments
    from camtruth.blind.design import counts
    from camtruth.blind.foreign.library import missing
    from camtruth.blind.format import beside
    from camtruth.blind.making import make as make_set
    from camtruth.rendering import render
    from scenes import scene as scenes

    asked = counts(dict(arguments.kind_and_number(text) for text in cases))
    width, height = arguments.width_and_height(size)
    bases = {camera: arguments.sized(camera, height, width) for camera in cameras}
    shots = arguments.with_frames(protocol, frames)
    place = out or FOLDER / arguments.safe(name)
    where = scenes.load(scene).with_size(width, height)
    for lamp in shots.lamps:
        where.named(lamp)
    _refuse_early(place, beside(place, "seal"), resume=resume, overwrite=overwrite)
    images = render(where, shots.lamps, samples=samples, watch=terminal.progress)
    total = sum(asked.values())
    with terminal.progress(f"making {total} cases", total) as advance:
        made = make_set(
            place,
            name,
            asked=asked,
            bases=bases,
            protocol=shots,
            images=images,
            scene=where.name,
            seed=seed,
            resume=resume,
            overwrite=overwrite,
            scheduler=scheduler,
            progress=advance,
        )
    click.echo(f"{place}: {total} cases; their truth is in {beside(place, 'seal')}")
    click.echo(f"Commitment: {made.commitment}")
    if missing():
        click.echo(f"Not installed, so not in it: {', '.join(missing())}")
    click.echo(f"Next: camtruth blind solve {place}")


@command.command()
@click.argument("folder", metavar="SET", type=options.PATH)
@click.option(
    "--solver",
    default="diagnose",
    show_default=True,
    metavar="NAME",
    help="diagnose, histogram, refit-free, or FILE.py:function(folder, without).",
)
@click.option(
    "--out",
    type=options.PATH,
    metavar="DIR",
    help="Folder to write.  [default: SET.answers, or SET.NAME for another solver]",
)
@click.option("--overwrite", is_flag=True, help="Replace the output folder if it is not empty.")
@options.resume
@options.scheduler
def solve(
    folder: Path,
    solver: str,
    out: Path | None,
    overwrite: bool,
    resume: bool,
    scheduler: str | None,
) -> None:
    """Answer every case of SET with a gap report, then hash the answers.

    A run that was stopped goes on by --resume. The seal is not read.
    """
    from camtruth.blind import arguments
    from camtruth.blind.answering import OURS
    from camtruth.blind.answering import solve as answer_all
    from camtruth.blind.format import beside, read_set
    from foundation.jobs import PROCESSES
    from foundation.output import CHECKSUMS, sha256

    total = len(read_set(folder).case)
    # two diagnoses in one process wait for each other; what a user's solver prints is held here
    apart = None if ":" in solver else PROCESSES
    ending = (
        "answers"
        if solver == OURS
        else arguments.safe(Path(solver.rpartition(":")[2] or solver).name)
    )
    place = out or beside(folder, ending)
    with terminal.progress(f"answering {total} cases", total) as advance:
        answer_all(
            folder,
            place,
            solver=solver,
            resume=resume,
            overwrite=overwrite,
            scheduler=scheduler or apart,
            progress=advance,
        )
    click.echo(f"{place}: {total} answers, sealed by {sha256(place / CHECKSUMS)}")
    click.echo(f"Next: camtruth blind score {folder}")


@command.command()
@click.argument("folder", metavar="SET", type=options.PATH)
@click.option(
    "--answers",
    type=options.PATH,
    metavar="DIR",
    help="Folder of the answers.  [default: SET.answers]",
)
@click.option(
    "--beside",
    "others",
    multiple=True,
    metavar="NAME=DIR",
    help="Other answers to show beside them. Repeat for several.",
)
@click.option(
    "--seal",
    type=options.PATH,
    metavar="DIR",
    help="Folder of the truth.  [default: SET.seal]",
)
@click.option(
    "--out",
    type=options.PATH,
    metavar="DIR",
    help="Folder to write.  [default: SET.score]",
)
@click.option("--overwrite", is_flag=True, help="Replace the output folder if it is not empty.")
@options.as_json
def score(
    folder: Path,
    answers: Path | None,
    others: tuple[str, ...],
    seal: Path | None,
    out: Path | None,
    overwrite: bool,
    as_json: bool,
) -> None:
    """Open the seal of SET and mark its answers, by severity, with 95 % intervals.

    Refused until every answer is written and their hashes stand in SHA256SUMS. Writes score.json
    and table.md.
    """
    from camtruth.blind import arguments
    from camtruth.blind.format import beside as neighbour
    from camtruth.blind.scoring import markdown, percent, rows_of, tables_of
    from camtruth.blind.scoring import score as mark_all
    from foundation.output import new_folder

    named = dict(arguments.name_and_folder(text) for text in others)
    document = mark_all(folder, answers=answers, others=named, seal=seal)
    place = out or neighbour(folder, "score")
    with new_folder(place, overwrite=overwrite) as made:
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
        (made / "score.json").write_text(text, encoding="utf-8")
        (made / "table.md").write_text(markdown(tables_of(document)), encoding="utf-8")
    if as_json:
        terminal.print_json(document)
        return
    terminal.print_table(
        ("figure", "cases", "limits", "to reach", "score"),
        [
            (row.figure, row.group, row.band, row.goal, percent(row))
            for row in rows_of(document)
            if row.value is not None
        ],
    )
    click.echo(f"{place / 'table.md'}")


@command.command()
@click.argument("capture", type=options.PATH)
@click.option(
    "--by",
    type=click.Choice(["frames", "exposures"]),
    default="frames",
    show_default=True,
    help="What is divided: the frames of every shot, or the shots.",
)
@click.option(
    "--run",
    type=click.IntRange(1, 100_000),
    default=8,
    show_default=True,
    metavar="N",
    help="Frames that stay together.",
)
@options.out("split")
@options.as_json
def split(capture: Path, by: str, run: int, out: Path, overwrite: bool, as_json: bool) -> None:
    """Divide CAPTURE into two fair halves, DIR/a and DIR/b, each a capture folder.

    Diagnose one half and hold the camera that comes of it against the other.
    """
    from camtruth.blind.splitting import split as divide

    halves = divide(capture, out, by=by, run=run, overwrite=overwrite)  # type: ignore[arg-type]
    if as_json:
        terminal.print_json({"format": "camtruth-split/1", "out": str(out), "halves": halves})
        return
    for name, half in halves.items():
        click.echo(f"{out / name}: {sum(half.values())} frames in {len(half)} shots")
    first, second = (out / name for name in halves)
    click.echo(f"Next: camtruth diagnose {first} --out half, then")
    click.echo(f"      camtruth diagnose {second} --model half/camera.toml")


def _refuse_early(*places: Path, resume: bool, overwrite: bool) -> None:
    """What would be refused after minutes of rendering is refused at once."""
    from foundation.output import refuse_taken
    from foundation.resumable import unfinished

    for place in places:
        refuse_taken(place, overwrite=overwrite)
        if not resume:
            refuse_taken(unfinished(place), overwrite=overwrite)
