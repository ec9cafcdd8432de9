"""A gap with a known cause: frames that another program has processed with one setting on.

    python docs/examples/outside_program.py CAPTURE OUT --setting repeat

exports a capture as PNG, as any team would hand it on; lets FFmpeg (through PyAV) process every
frame with one setting; and imports the result as if it came from a real camera. The cause of the
gap is known, because it is the setting. Then

    camtruth diagnose OUT/real

has to name it: the effect in the table below. docs/outside-program.md shows what it says.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import av
import numpy as np
from numpy.typing import NDArray

from camtruth.command import main as camtruth


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What FFmpeg is told to do, and what the catalogue calls it.

    Attributes:
        effect: the name in the catalogue; None where nothing is done.
        filters: FFmpeg's filters.
        codec, pixels, options: of the video that comes back; lossless where that is not the point.
    """

    effect: str | None
    filters: str = "null"
    codec: str = "ffv1"
    pixels: str = "bgr0"
    options: Mapping[str, str] = field(default_factory=dict)


SETTINGS = {
    "nothing": Setting(effect=None),
    # of every 8 frames the seventh is lost, and the sixth stands twice
    "repeat": Setting(effect="dropped_frames", filters="shuffleframes=0 1 2 3 4 5 5 7"),
    "chroma": Setting(effect="chroma_subsampling", filters="format=yuv422p", pixels="yuv422p"),
    "mjpeg": Setting(
        effect="jpeg",
        filters="format=yuvj422p",
        codec="mjpeg",
        pixels="yuvj422p",
        options={"qmin": "3", "qmax": "3"},
    ),
    "unsharp": Setting(
        effect="sharpening", filters="format=gbrp,unsharp=5:5:1.0:5:5:1.0,format=gbrp"
    ),
    "denoise": Setting(effect="spatial_denoise", filters="format=gbrp,gblur=sigma=0.6,format=gbrp"),
    "average": Setting(effect="temporal_filter", filters="tmix=frames=2:weights='1 1'"),
}


def main() -> int:
    words = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    words.add_argument("capture", type=Path, help="a capture folder of rgb8 frames")
    words.add_argument("out", type=Path, help="where to work; must not exist")
    words.add_argument("--setting", choices=sorted(SETTINGS), default="repeat")
    words.add_argument("--hide-light", action="store_true", help="hand on no rate images")
    given = words.parse_args()
    setting = SETTINGS[given.setting]
    handed_on, processed = given.out / "handed-on", given.out / "processed"
    if camtruth(["export", str(given.capture), "--format", "png", "--out", str(handed_on)]):
        return 2
    processed.mkdir()
    manifest = (handed_on / "capture.toml").read_text(encoding="utf-8")
    for shot in tomllib.loads(manifest)["shot"]:
        files = sorted(handed_on.glob(shot["frames"]))
        filtered(processed / f"{shot['label']}.mkv", files, setting)
        manifest = manifest.replace(shot["frames"], f"{shot['label']}.mkv")
    for light in handed_on.glob("*.exr"):
        shutil.copy(light, processed)
    if given.hide_light:
        lines = manifest.splitlines(keepends=True)
        manifest = "".join(line for line in lines if not line.startswith("rate = "))
    (processed / "shots.toml").write_text(manifest, encoding="utf-8")
    if camtruth(["import", str(processed), "--out", str(given.out / "real")]):
        return 2
    cause = f"The cause of the gap is '{setting.effect}'" if setting.effect else "There is no gap"
    print(f"{cause}. Find it with: camtruth diagnose {given.out}/real")
    return 0


def filtered(path: Path, files: list[Path], setting: Setting) -> None:
    """Send frames through FFmpeg's filters into a video."""
    first = picture(files[0])
    graph = av.filter.Graph()
    source = graph.add_buffer(
        width=first.shape[1], height=first.shape[0], format="rgb24", time_base="1/15"
    )
    links = [source]
    for text in setting.filters.split(","):
        name, _, options = text.partition("=")
        links.append(graph.add(name, options or None))
    links.append(graph.add("buffersink"))
    graph.link_nodes(*links).configure()
    with av.open(str(path), "w") as file:
        stream = file.add_stream(setting.codec, rate=15, options=dict(setting.options))
        stream.width, stream.height = first.shape[1], first.shape[0]
        stream.pix_fmt = setting.pixels
        for number, each in enumerate(files):
            frame = av.VideoFrame.from_ndarray(picture(each), format="rgb24")
            frame.pts = number
            graph.push(frame)
            for done in pulled(graph):
                file.mux(stream.encode(done.reformat(format=setting.pixels)))
        graph.push(None)
        for done in pulled(graph):
            file.mux(stream.encode(done.reformat(format=setting.pixels)))
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
