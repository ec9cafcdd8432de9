"""The EMVA 1288 descriptor with its images: what the emva1288 package and others measure from.

One descriptor for each lattice of photosites that see one colour: `Y` of a camera without colours,
`R`, `G1`, `G2`, `B` of a mosaic. Of demosaiced frames only the samples at their own sites are
taken, which a demosaicer leaves alone where it is the paper's. "Photons" are mean photo-electrons,
so the quantum efficiency that a reader finds is 1. Each panel of each lit shot is a point of the
temporal series; the one nearest to half of full scale, with the dark shot of the same exposure,
is the spatial one.

Reference: EMVA Standard 1288, release 3.1; the file format is that of the emva1288 package 1.0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from camtruth.exchange.errors import ExchangeError
from camtruth.exchange.format import EVERY_KIND, Format, FrameFile, once
from camtruth.exchange.source import Source
from foundation.panel import Panel
from sensor.frames import Frames

DESCRIPTOR = "emva1288.txt"
TEMPORAL_FRAMES = 2
LEAST_FRAMES = 3
"""More than two images make a point a spatial one, to the readers of the format."""

NS_PER_S = 1e9


@dataclass(frozen=True, kw_only=True)
class Lattice:
    """Photosites of one colour: every second pixel from (row, column), or all with `step` 1."""

    name: str
    colour: int
    row: int = 0
    column: int = 0
    step: int = 1

    def of(self, stack: NDArray[Any]) -> NDArray[Any]:
        """Its samples of a stack (N, H, W), or (N, H, W, 3) of which only its colour is taken."""
        if stack.ndim == 4:
            stack = stack[..., self.colour]
        return stack[:, self.row :: self.step, self.column :: self.step]


@dataclass(frozen=True, kw_only=True)
class Point:
    """A shot seen in one area: exposure, mean photo-electrons, mean code."""

    frames: Frames
    area: Panel
    electrons: float
    mean_dn: float


def write(folder: Path, source: Source) -> Iterator[FrameFile]:
    """Write a descriptor and its images for every lattice."""
    areas = _areas(source)
    for lattice in _lattices(source):
        points = _points(source, lattice, areas)
        lit = [point for point in points if not point.frames.shot.dark]
        middle = min(lit, key=lambda point: abs(point.mean_dn - source.top_dn / 2))
        home = folder / lattice.name
        home.mkdir(exist_ok=True)
        lines = _head(source, lattice, middle)
        for point in points:
            if point.frames.shot.dark and point.area != middle.area:
                continue
            alike = point.frames.shot.exposure_s == middle.frames.shot.exposure_s
            spatial = point is middle or (point.frames.shot.dark and alike)
            names = []
            count = point.frames.count if spatial else TEMPORAL_FRAMES
            for index in range(count):
                name = f"{point.area.name}/{point.frames.shot.label}-{index:05d}.png"
                kept = _save(home / name, point.frames.dn[index : index + 1], lattice, point.area)
                names.append(name)
                yield FrameFile(
                    name=f"{lattice.name}/{name}",
                    shot=point.frames.shot.label,
                    first=index,
                    count=1,
                    kept=kept,
                )
            lines += _lines(point, names[:TEMPORAL_FRAMES])
            lines += _lines(point, names) if spatial else []
        (home / DESCRIPTOR).write_text("\n".join(lines) + "\n", encoding="ascii", errors="replace")


def _save(path: Path, frame: NDArray[Any], lattice: Lattice, area: Panel) -> bool:
    path.parent.mkdir(exist_ok=True)

    def make(beside: Path) -> None:
        rows, columns = area.window
        crop = np.ascontiguousarray(lattice.of(frame[:, rows, columns])[0])
        Image.fromarray(crop).save(beside, format="PNG")

    return once(path, make)


def _head(source: Source, lattice: Lattice, middle: Point) -> list[str]:
    rows, columns = middle.area.window
    height, width = lattice.of(middle.frames.dn[:1, rows, columns]).shape[1:]
    return [
        f"# camera {source.document.camera}, photosites {lattice.name}",
        "# photons are mean photo-electrons in a photosite: the quantum efficiency is 1",
        "v 3.1",
        f"n {source.document.bits} {width} {height}",
    ]


def _lines(point: Point, names: list[str]) -> list[str]:
    exposure_ns = point.frames.shot.exposure_s * NS_PER_S
    first = (
        f"d {exposure_ns:.3f}"
        if point.frames.shot.dark
        else f"b {exposure_ns:.3f} {point.electrons:.6f}"
    )
    return [first, *(f"i {name}".replace("/", "\\") for name in names)]


def _areas(source: Source) -> tuple[Panel, ...]:
    """The panels, cut to one even size at even places; the whole frame where there are none."""
    frames = source.capture.frames[0]
    panels = source.capture.panels or (
        Panel(name="frame", x=0, y=0, w=frames.width, h=frames.height),
    )
    left, top = [p.x + p.x % 2 for p in panels], [p.y + p.y % 2 for p in panels]
    w = min(p.x + p.w - x for p, x in zip(panels, left, strict=True)) // 2 * 2
    h = min(p.y + p.h - y for p, y in zip(panels, top, strict=True)) // 2 * 2
    if min(w, h) < 4:
        raise ExchangeError(
            f"panels of which the smallest has {w} x {h} pixels at even places",
            "expected at least 4 x 4",
            "correct the panels of the capture",
        )
    names = [f"panel-{p.name}" if source.capture.panels else p.name for p in panels]
    return tuple(
        Panel(name="".join(c if c.isalnum() else "-" for c in name), x=x, y=y, w=w, h=h)
        for name, x, y in zip(names, left, top, strict=True)
    )


def _lattices(source: Source) -> tuple[Lattice, ...]:
    frames = source.capture.frames[0]
    if frames.channels == ("Y",):
        return (Lattice(name="Y", colour=1),)
    if frames.cfa is None:
        raise ExchangeError(
            "demosaiced frames whose colour filter array is not known",
            "expected 'cfa' in the manifest: interpolated samples share their neighbours' noise",
            "add it, or export raw or grey frames",
        )
    greens = iter(("G1", "G2") if frames.cfa.count("G") == 2 else "GGGG")
    return tuple(
        Lattice(
            name=next(greens) if colour == "G" else colour,
            colour="RGB".index(colour),
            row=k // 2,
            column=k % 2,
            step=2,
        )
        for k, colour in enumerate(frames.cfa)
    )


def _points(source: Source, lattice: Lattice, areas: tuple[Panel, ...]) -> list[Point]:
    exposures = [
        {f.shot.exposure_s for f in stacks} for stacks in (source.capture.darks, source.capture.lit)
    ]
    both = exposures[0] & exposures[1]
    points: list[Point] = []
    for frames in source.capture.frames:
        if frames.shot.exposure_s not in both or frames.count < LEAST_FRAMES:
            continue
        electrons = source.electrons(frames.shot)
        if electrons is None:
            raise ExchangeError(
                f"no light is known for shot '{frames.shot.label}'",
                "expected a rate image: a descriptor states the photons of every point",
                "name it as 'rate' in the manifest, or choose another --format",
            )
        for area in areas:
            rows, columns = area.window
            light = lattice.of(electrons[None, rows, columns])
            seen = lattice.of(frames.dn[:TEMPORAL_FRAMES, rows, columns])
            points.append(
                Point(
                    frames=frames,
                    area=area,
                    electrons=float(light.mean(dtype=np.float64)),
                    mean_dn=float(seen.mean(dtype=np.float64)),
                )
            )
    if not any(not point.frames.shot.dark for point in points):
        raise ExchangeError(
            "no exposure with both a dark and a lit shot of three frames or more",
            "expected one, for the spatial points",
            "capture such shots, or choose another --format",
        )
    return _once_each(points)


def _once_each(points: list[Point]) -> list[Point]:
    """One point for each dark exposure and area, and for each exposure and number of photons."""
    kept: dict[tuple[object, ...], Point] = {}
    for point in points:
        shot = point.frames.shot
        where = point.area.name if shot.dark else f"{point.electrons:.6f}"
        kept.setdefault((shot.dark, shot.exposure_s, where), point)
    return list(kept.values())


FORMAT = Format(
    name="emva1288",
    says="EMVA 1288 descriptors with their images, one for each colour of photosite",
    media_type="image/png",
    reading="from emva1288.process import Emva1288; Emva1288('frames/Y/emva1288.txt').results()",
    pixels=EVERY_KIND,
    write=write,
)
