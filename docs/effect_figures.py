"""One figure for each effect: a frame without it, with it, their difference, and a statistic.

Adding an effect leaves the draws of all others alone, so that the difference of two frames is the
effect and nothing else. The statistic is what the effect is known by; an effect without an entry in
`STATISTIC` shows the photon-transfer curve.
"""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camtruth.report.pictures import magnified_change
from render.closed_form import render
from scenes.scene import load
from sensor.camera import Camera
from sensor.camera_file import load as load_camera
from sensor.catalogue import catalogue
from sensor.effect import Effect
from sensor.protocol import Shot
from sensor.signal import Quantity
from sensor.simulation import pixels_of, simulate

WIDTH, HEIGHT, FRAMES = 128, 96, 48
EXPOSURE_S, INTERVAL_S = 0.03268, 0.0667

Array = NDArray[np.float64]

STRONGER: dict[str, dict[str, float]] = {
    "brighter_fatter": {"horizontal_per_e": 1e-5, "vertical_per_e": 1e-5},
    "charge_transfer_inefficiency": {
        "horizontal_per_transfer": 1e-3,
        "vertical_per_transfer": 5e-4,
    },
    "dark_shot": {"current_e_per_s": 1e5},
    "fpn": {"sigma_e": 60.0},
    "read_noise": {"thermal_e": 60.0},
    "row_noise": {"sigma_e": 60.0},
    "column_fpn": {"sigma_e": 60.0},
    "flicker_noise": {"sigma_e": 100.0},
    "interference": {"amplitude_e": 100.0},
    "black_level_drift": {"row_sigma_e": 60.0, "frame_sigma_e": 60.0},
    "black_level_offset": {"offset_e": 300.0},
    "hot_pixels": {"density": 0.01, "rate_e_per_s": 100_000.0},
    "random_telegraph_noise": {"fraction": 0.05, "amplitude_e": 600.0},
    "prnu": {"ratio": 0.03},
    "image_lag": {"fraction": 0.1},
    "smear": {"leak_ratio": 0.02},
    "blooming": {"full_well_e": 6000.0, "drained": 0.5},
    "adc_dnl": {"unit_mismatch": 0.2},
    "jpeg": {"quality": 60.0},
    "nonlinearity": {"quadratic_ratio": 0.1, "cubic_ratio": 0.1},
    "vibration": {"shift_px": 0.5},
    "ambient_light": {"rate_e_per_s": 20_000.0},
    "dropped_frames": {"probability": 0.4},
}
"""Parameters of the figures, where the default would hardly be seen at 8 bits."""

STATISTIC = {
    "time": "lamp_flicker lamp_drift black_level_drift",
    "pixel": "random_telegraph_noise",
    "memory": "image_lag temporal_filter dropped_frames",
    "transfer": "ambient_light nonlinearity blooming gamma lamp_spectrum_error black_level_offset "
    "white_balance",
    "codes": "adc_dnl bit_truncation quantization",
    "rows": "smear specular_glare veiling_glare vignetting_excess lamp_displacement dust_shadow "
    "lens_distortion defocus_error lateral_chromatic_aberration sharpening large_scale_prnu "
    "charge_transfer_inefficiency prnu hot_pixels fpn defect_correction crosstalk color_matrix "
    "spectral_response_error dark_current",
    "columns": "column_fpn",
    "spectrum": "flicker_noise row_noise interference jpeg chroma_subsampling demosaic_other "
    "spatial_denoise demosaic",
    "covariance": "brighter_fatter",
}
CHOICE = {name: kind for kind, names in STATISTIC.items() for name in names.split()}


def light() -> NDArray[np.float32]:
    """Photo-electrons per second: the chart, by the closed form, (H, W, 3)."""
    scene = load("chart")
    rate = render(scene.with_size(WIDTH, HEIGHT), "incandescent").rate_e_per_s
    # the pixels of the small picture are larger than the camera's; 1.3 fills its range
    return np.asarray(1.3 * (WIDTH / scene.detector.width_px) ** 2 * rate, np.float32)


def pair_of(kind: type[Effect]) -> tuple[Camera, Camera]:
    """The camera of the figures without an effect and with it."""
    base = load_camera("icx098").resized(HEIGHT, WIDTH)
    with_it = base.plus(kind(**STRONGER.get(kind.name, {})))
    return with_it.without(kind), with_it


def frames_of(camera: Camera, rate: NDArray[np.float32], frames: int = FRAMES) -> Array:
    """Frames (N, H, W, 3) or, of a camera without a demosaicer, (N, H, W)."""
    shot = Shot(
        label="figure",
        light=("lamp",),
        exposure_s=EXPOSURE_S,
        frames=frames,
        interval_s=INTERVAL_S,
        temperature_c=29.0,
    )
    signal = simulate(camera, shot, {"lamp": rate}, seed=1, until=Quantity.CODE)
    if camera.bits == 8 and len(signal.shape) == 4 and "quantization" in _names(camera):
        return pixels_of(camera, signal).astype(float)
    return signal.numpy().astype(float)


def _names(camera: Camera) -> list[str]:
    return [effect.name for effect in camera.effects]


def green(frames: Array) -> Array:
    """One number a pixel."""
    return frames[..., 1] if frames.ndim == 4 else frames


def draw(kind: type[Effect]) -> bytes:
    """The figure as a PNG."""
    from matplotlib.figure import Figure

    rate = light()
    cameras = pair_of(kind)
    before, after = (frames_of(camera, rate) for camera in cameras)
    changes = after - (before if before.ndim == after.ndim else before[..., None])
    k = int(np.abs(changes).mean((1, 2, 3)).argmax())
    change = changes[k]
    magnified, scale = magnified_change(change)

    figure = Figure(figsize=(10.4, 2.4), dpi=90, layout="constrained")
    axes = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.15))
    pictures = [
        ("without", before[k]),
        ("with", after[k]),
        (f"difference x {scale}", magnified),
    ]
    for axis, (title, picture) in zip(axes, pictures, strict=False):
        shown = np.clip(picture, 0, 255).astype(np.uint8)
        axis.imshow(shown, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        axis.set_title(title, fontsize=9)
        axis.set_axis_off()
    PLOTS[CHOICE.get(kind.name, "noise")](axes[3], cameras, rate, (before, after))
    axes[3].tick_params(labelsize=7)
    axes[3].legend(fontsize=7, frameon=False)
    axes[3].spines[["top", "right"]].set_visible(False)
    figures = ", ".join(
        f"{name} = {value:g}" for name, value in STRONGER.get(kind.name, {}).items()
    )
    figure.suptitle(
        f"{kind.name}{':  ' if figures else ''}{figures}", fontsize=9, x=0.01, ha="left"
    )
    stream = io.BytesIO()
    figure.savefig(stream, format="png")
    return _small(stream)


def _small(stream: io.BytesIO) -> bytes:
    """A picture as a PNG of 200 colours, which has a third of the bytes."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(stream) as image:
        image.convert("RGB").quantize(200, dither=Image.Dither.NONE).save(out, "PNG", optimize=True)
    return out.getvalue()


Pair = tuple[Array, Array]
LABELS = ("without", "with")
STYLES: tuple[dict[str, Any], ...] = (
    {"color": "0.55", "lw": 1.4},
    {"color": "#1f5fa8", "lw": 1.1},
)


def _lines(axis: Any, curves: list[tuple[Array, Array]], x: str, y: str, **more: Any) -> None:
    for (across, up), label, style in zip(curves, LABELS, STYLES, strict=True):
        axis.plot(across, up, label=label, **style, **more)
    axis.set_xlabel(x, fontsize=7)
    axis.set_title(y, fontsize=9)


def _time(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    curves = [(np.arange(FRAMES), green(f).mean((1, 2))) for f in frames]
    _lines(axis, curves, "frame", "mean of green in DN")


def _pixel(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    with_it = green(frames[1])
    jumps = with_it.var(0) - green(frames[0]).var(0)
    place = np.unravel_index(jumps[8:-8, 8:-8].argmax(), (HEIGHT - 16, WIDTH - 16))
    y, x = place[0] + 8, place[1] + 8
    curves = [(np.arange(FRAMES), green(f)[:, y, x]) for f in frames]
    _lines(axis, curves, "frame", f"green of pixel ({y}, {x}) in DN", drawstyle="steps-mid")


def _ramp() -> tuple[NDArray[np.float32], Array]:
    electrons = np.linspace(0, 16_000, 32)
    across = np.repeat(electrons, WIDTH // 32)
    rate = np.broadcast_to((across / EXPOSURE_S)[None, :, None], (HEIGHT, WIDTH, 3))
    return np.ascontiguousarray(rate, np.float32), electrons


def _by_level(frames: Array) -> Array:
    return green(frames).reshape(len(frames), HEIGHT, 32, WIDTH // 32)


def _transfer(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    ramp, electrons = _ramp()
    curves = []
    for camera in cameras:
        levels = frames_of(camera, ramp, 8)
        shown = levels[..., 0] if levels.ndim == 4 else levels
        level = shown.reshape(8, HEIGHT, 32, -1).mean((0, 1, 3))
        curves.append((electrons / 1e3, level))
    _lines(axis, curves, "light in ke- per exposure", "mean of red in DN")


def _noise(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    ramp, electrons = _ramp()
    curves = []
    for camera in cameras:
        variance = _by_level(frames_of(camera, ramp)).var(0, ddof=1).mean((0, 2))
        curves.append((electrons[1:-4] / 1e3, variance[1:-4]))
    _lines(axis, curves, "light in ke- per exposure", "temporal variance of green in DN$^2$")


def _covariance(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    """Of neighbours in the column, before the demosaicer, which would bring its own."""
    ramp, electrons = _ramp()
    curves = []
    for camera in cameras:
        bare = dataclasses.replace(
            camera,
            effects=tuple(e for e in camera.effects if e.place() < catalogue()["fpn"].place()),
        )
        shot = Shot(label="figure", light=("lamp",), exposure_s=EXPOSURE_S, frames=400)
        signal = simulate(bare, shot, {"lamp": ramp}, seed=1, until=Quantity.ELECTRONS)
        left = signal.numpy().astype(float)
        left -= left.mean(0)
        product = (left[:, 1:] * left[:, :-1]).mean((0, 1)).reshape(32, -1).mean(1)
        curves.append((electrons / 1e3, product))
    _lines(axis, curves, "light in ke- per exposure", "covariance down the column in e$^2$")


def _codes(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    """Of light that rises by a fraction of a code from column to column."""
    low, high = 60, 92
    gain = cameras[0].gain_dn_per_e.G
    electrons = (np.linspace(low - 8, high + 8, WIDTH) - cameras[0].black_dn) / gain
    rate = np.broadcast_to((electrons / EXPOSURE_S)[None, :, None], (HEIGHT, WIDTH, 3))
    curves = []
    for camera in cameras:
        values = green(frames_of(camera, np.ascontiguousarray(rate, np.float32))).ravel()
        step = 1.0 if np.array_equal(values, np.rint(values)) else 0.25
        edges = np.arange(low - step / 2, high, step)
        count = np.histogram(values, edges)[0] / step
        curves.append((edges[:-1] + step / 2, count / count.mean()))
    _lines(axis, curves, "code", "how often, relative", drawstyle="steps-mid")


def _rows(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    """The row and the colour that change most."""
    means = [f.mean(0) for f in frames]
    change = np.abs(means[1] - means[0]).mean(1)
    y, colour = np.unravel_index(change.argmax(), change.shape)
    curves = [(np.arange(WIDTH), mean[y, :, colour]) for mean in means]
    name = ("red", "green", "blue")[int(colour)]
    _lines(axis, curves, "column", f"{name} of row {y} in DN, mean of {FRAMES} frames")


def _memory(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    flat = np.full_like(rate, 4000 / EXPOSURE_S)
    curves = []
    for camera in cameras:
        left = green(frames_of(camera, flat))
        left = left - left.mean(0)
        later = [(left[: FRAMES - k] * left[k:]).mean() for k in range(7)]
        curves.append((np.arange(7), np.array(later) / later[0]))
    _lines(axis, curves, "frames later", "correlation of a pixel with itself", marker=".")


def _columns(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    base = green(frames[0]).mean((0, 1))
    curves = [(np.arange(WIDTH), green(f).mean((0, 1)) - base) for f in frames]
    _lines(axis, curves, "column", "mean of the columns in DN, chart taken off")


def _spectrum(axis: Any, cameras: Any, rate: Any, frames: Pair) -> None:
    """Of what differs between frames: along the rows, or down the columns if more is there."""
    flat = np.full_like(rate, 4000 / EXPOSURE_S)
    stacks = [green(frames_of(camera, flat)) for camera in cameras]
    powers = []
    for axis_of in (2, 1):
        pair = []
        for stack in stacks:
            left = stack - stack.mean(0)
            power = np.abs(np.fft.rfft(left, axis=axis_of)) ** 2 / left.shape[axis_of]
            pair.append(power.mean((0, 3 - axis_of)))
        powers.append(pair)
    change = [np.abs(np.log(pair[1] / pair[0] + 1e-6)).max() for pair in powers]
    chosen = int(np.argmax(change))
    n = (WIDTH, HEIGHT)[chosen]
    cycles = np.arange(n // 2 + 1) / n
    where = ("along the rows", "down the columns")[chosen]
    _lines(axis, [(cycles, p) for p in powers[chosen]], "cycles/px", f"power {where} in DN$^2$")
    axis.set_yscale("log")
    axis.set_ylim(bottom=powers[chosen][0].min() / 30)


PLOTS: dict[str, Callable[..., None]] = {
    "time": _time,
    "pixel": _pixel,
    "transfer": _transfer,
    "codes": _codes,
    "rows": _rows,
    "memory": _memory,
    "columns": _columns,
    "spectrum": _spectrum,
    "covariance": _covariance,
    "noise": _noise,
}


def write_figures(folder: Path) -> None:
    """A figure for each effect of the catalogue, and none besides."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("*.png"):
        if old.stem not in catalogue():
            old.unlink()
    for name, kind in catalogue().items():
        (folder / f"{name}.png").write_bytes(draw(kind))
