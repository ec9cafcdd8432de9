"""A gap with a known cause: frames that another program has processed with one setting on.

    python docs/examples/outside_program.py CAPTURE OUT --setting unsharp

exports a capture as PNG, as any team would hand it on; lets FFmpeg (through PyAV) process every
frame with one setting; and imports the result as if it came from a real camera. The cause of the
gap is known, because it is the setting. Then

    camtruth diagnose OUT/real

has to name it: the effect in the table below.
"""

from __future__ import annotations

import argparse
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from camtruth.command import main as camtruth

SETTINGS = {
    "chroma": ("chroma_subsampling", "format=yuv420p", "yuv420p"),
    "unsharp": ("sharpening", "format=gbrp,unsharp=5:5:1.0:5:5:1.0,format=gbrp", "bgr0"),
    "denoise": ("spatial_denoise", "format=gbrp,gblur=sigma=0.6,format=gbrp", "bgr0"),
    "average": ("temporal_filter", "tmix=frames=2:weights='1 1'", "bgr0"),
}
"""By setting: the effect that it is, FFmpeg's filters, and the pixels of the lossless video."""


def main() -> int:
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("capture", type=Path, help="a capture folder of rgb8 frames")
    words.add_argument("out", type=Path, help="where to work; must not exist")
    words.add_argument("--setting", choices=sorted(SETTINGS), default="unsharp")
    given = words.parse_args()
    effect, filters, pixels = SETTINGS[given.setting]
    handed_on, processed = given.out / "handed-on", given.out / "processed"
    if camtruth(["export", str(given.capture), "--format", "png", "--out", str(handed_on)]):
        return 2
    processed.mkdir()
    manifest = (handed_on / "capture.toml").read_text(encoding="utf-8")
    for shot in tomllib.loads(manifest)["shot"]:
        files = sorted(handed_on.glob(shot["frames"]))
        filtered(processed / f"{shot['label']}.mkv", files, filters, pixels)
        manifest = manifest.replace(shot["frames"], f"{shot['label']}.mkv")
    without_truth = "\n".join(
        line for line in manifest.splitlines() if not line.startswith("rate = ")
    )
    (processed / "shots.toml").write_text(without_truth + "\n", encoding="utf-8")
    if camtruth(["import", str(processed), "--out", str(given.out / "real")]):
        return 2
    print(f"The cause of the gap is '{effect}'. Find it with: camtruth diagnose {given.out}/real")
    return 0


def filtered(path: Path, files: list[Path], filters: str, pixels: str) -> None:
    """Send frames through FFmpeg's filters into a lossless video."""
    first = picture(files[0])
    graph = av.filter.Graph()
    source = graph.add_buffer(
        width=first.shape[1], height=first.shape[0], format="rgb24", time_base="1/15"
    )
    links = [source]
    for text in filters.split(","):
        name, _, options = text.partition("=")
        links.append(graph.add(name, options or None))
    links.append(graph.add("buffersink"))
    graph.link_nodes(*links).configure()
    with av.open(str(path), "w") as file:
        stream = file.add_stream("ffv1", rate=15)
        stream.width, stream.height, stream.pix_fmt = first.shape[1], first.shape[0], pixels
        for number, name in enumerate(files):
            frame = av.VideoFrame.from_ndarray(picture(name), format="rgb24")
            frame.pts = number
            graph.push(frame)
            for done in pulled(graph):
                file.mux(stream.encode(done.reformat(format=pixels)))
        graph.push(None)
        for done in pulled(graph):
            file.mux(stream.encode(done.reformat(format=pixels)))
        file.mux(stream.encode(None))


def pulled(graph: Any) -> Iterator[Any]:
    """The frames that have come through so far."""
    while True:
        try:
            yield graph.pull()
        except (av.BlockingIOError, av.EOFError):
            return


def picture(path: Path) -> NDArray[np.uint8]:
    """A frame as another team reads it: by its own library, here FFmpeg's."""
    with av.open(str(path)) as file:
        return np.asarray(next(file.decode(video=0)).to_ndarray(format="rgb24"))


if __name__ == "__main__":
    sys.exit(main())
