"""The rate image by tracing light paths through a scene of real geometry, with Mitsuba.

A ray leaves a pixel through a point of the aperture, refracted so that it is sharp at the focus
distance; where it meets the chart, it asks the lamp. So defocus, the 1/R^2 gradient and the cat's
eye that a barrel makes of the aperture come out of geometry. Mitsuba's thin lens returns radiance:
the solid angle of the aperture, cos^4 and the area of the pixel are applied per pixel, exactly.

Colour has two treatments (`wavelengths`), one code path, in Mitsuba's spectral variants:

``integrated``
    light meets the chart once, so lamp, reflectance and response enter a channel only as one
    integral. It is done beforehand, exactly: Mitsuba renders three bands in which every material
    has its mean reflectance as seen by that channel under that lamp. No noise from wavelengths.
``sampled``
    each path carries four wavelengths, drawn in proportion to lamp x response. Slower by orders of
    magnitude, needed as soon as light meets two coloured surfaces.

Noise is divided out, not averaged out: each batch is rendered a second time with the same random
numbers and nothing but a uniformly bright wall before the lens. What that witness should show is
known (`pupil.open_fraction`); what it shows differs by the luck of this batch, which paths the
barrel stops and which wavelengths are drawn, and the image of the chart shares that luck. The
rate is the ratio of the two times the known value (a ratio estimator: W. G. Cochran, Sampling
Techniques, 3rd ed., ch. 6), its variance that of the batches' residuals. See
docs/decisions/noise-of-the-render.md.

This file alone imports mitsuba.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from foundation.backend import backend
from render import camera, plugins, stage
from render.batches import BATCHES, Sums, batches_needed, relative_noise
from render.camera import Sampler
from render.errors import RenderError
from render.palette import QUANTILES, integrated, sampled, single
from render.pupil import open_fraction
from render.rate import RateHeader, RateImage, rate_image
from render.record import optics, versions
from render.spectral import channel_weights
from scenes.field import WAVELENGTHS_NM
from scenes.geometry import panels
from scenes.imaging import real_field, smooth
from scenes.lamp import Lamp
from scenes.scene import Scene
from scenes.spectra import CHANNELS, Spectrum, response

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
Wavelengths = Literal["integrated", "sampled"]

VARIANTS = {"scalar": "scalar_spectral", "llvm": "llvm_ad_spectral", "cuda": "cuda_ad_spectral"}
__all__ = ["BATCHES", "SAMPLES", "render", "traced_open_fraction"]

SAMPLES = 72
"""Light paths per pixel by default."""

DIRECT_LIGHT = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
"""A point lamp cannot be met by chance, so that asking it once is all there is to do."""
MOST_BOUNCES = 16


def render(
    scene: Scene,
    lamp: str | Lamp,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    noise: float | None = None,
    progress: Progress | None = None,
    response_curves: Mapping[str, Spectrum] | None = None,
    bounces: int = 0,
    wavelengths: Wavelengths | None = None,
    sampler: Sampler = "multijitter",
    witness: bool = True,
) -> RateImage:
    """The rate image of a scene under one of its lamps.

    Args:
        scene: what is photographed.
        lamp: one of its lamps, by name or by itself.
        samples: light paths per pixel, rounded up to 8 equal squares.
        seed: of the light paths; the same seed and backend give the same image.
        noise: keep adding batches until the relative standard error inside every panel and
            channel (root mean square over its pixels) is at most this.
        progress: called with (batches done, batches expected) after every batch.
        response_curves: R, G, B in place of the scene's, relative to the same peak efficiency.
        bounces: how often light may be thrown back by booth, wall or chart before it reaches the
            panel that the camera sees; 0 is direct light.
        wavelengths, sampler, witness: other ways to the same image, for comparison; without a
            witness a batch is taken as it comes. Wavelengths are drawn from the second bounce on,
            when light may meet two coloured panels.

    Raises:
        SceneError: for an unknown lamp.
        RenderError: for a number of samples or bounces, a seed or a noise that cannot be.
    """
    _refuse_numbers(samples, seed, noise, bounces)
    wavelengths = wavelengths or ("sampled" if bounces > 1 else "integrated")
    source = scene.named(lamp) if isinstance(lamp, str) else lamp
    if scene.lens.kind == "real" and not backend().jit:
        raise RenderError(
            "a real lens on the scalar backend",
            "expected LLVM or CUDA, which trace its surfaces a hundred times faster",
            "see 'camtruth doctor', or use a thin lens",
        )
    _use_backend()
    curves = response_curves or response(scene.detector.response, scene.detector.infrared_cut)
    points = len(stage.lamp_points(scene, source)[1])
    per_batch = _per_batch(samples, 1 if backend().jit and bounces == 0 else points)
    integrator = _integrator(bounces, points)
    passes = _passes(scene, source, curves, wavelengths, sampler, integrator, bounces, witness)
    scale = _scale(scene, source, curves, witness) * np.concatenate([p.white for p in passes])
    clear = panels(scene)

    sums, most = Sums(), BATCHES
    while sums.batches < most:
        word = _seed(seed, source.name, sums.batches)
        seen, known = (
            np.concatenate(parts, axis=-1)
            for parts in zip(*(one.batch(per_batch, word) for one in passes), strict=True)
        )
        sums.add(seen, known)
        if progress is not None:
            progress(sums.batches, most)
        if sums.batches == most and noise is not None:
            reached = relative_noise(*sums.estimate(scale), clear)
            most = batches_needed(sums.batches, max(reached), noise)
    rate, variance = sums.estimate(scale)
    reached = relative_noise(rate, variance, clear)
    header = RateHeader(
        scene=scene.name,
        lamp=source.name,
        optics={
            **optics(scene, f"mitsuba {mi.variant()}"),
            "wavelengths": wavelengths,
            "bounces": bounces,
        },
        samples=sums.batches * per_batch,
        seed=seed,
        versions=versions(),
        panels=clear,
        noise=dict(zip(CHANNELS, reached, strict=True)),
    )
    return rate_image(rate, variance, header)


@dataclass(frozen=True, kw_only=True, eq=False)
class Pass:
    """Channels that are rendered together: the chart, and what the witness sees or should see.

    Attributes:
        chart, witness: Mitsuba's scenes.
        area: what stands in for a witness that is not there, by channel.
        white: see `Palette`.
    """

    chart: Any
    witness: Any
    area: Array
    white: Array

    def batch(self, samples: int, word: int) -> tuple[Array, Array]:
        """One batch of the chart and of the witness, (H, W, C)."""
        seen = _image(self.chart, samples, word)
        if self.witness is None:
            return seen, np.broadcast_to(self.area, seen.shape)
        return seen, _image(self.witness, samples, word)


def _passes(
    scene: Scene,
    lamp: Lamp,
    curves: Mapping[str, Spectrum],
    wavelengths: Wavelengths,
    sampler: Sampler,
    integrator: dict[str, Any],
    bounces: int,
    witness: bool,
) -> list[Pass]:
    """All channels at once; a real lens with integrated colour, one after the other."""
    if wavelengths == "sampled":
        palette = sampled(scene, lamp, curves)
        film_nm = palette.film_nm
        colours = [(palette, np.linspace(film_nm[0], film_nm[-1], QUANTILES), True)]
    elif scene.lens.kind == "thin":
        colours = [(integrated(scene, lamp, curves), np.zeros(0), False)]
    else:
        colours = [(*single(scene, lamp, curves, channel), False) for channel in CHANNELS]
    result = []
    for palette, true_nm, one_wavelength in colours:
        if scene.lens.kind == "thin":
            sensor = camera.sensor(scene, palette, sampler)
        else:
            sensor = camera.real_sensor(scene, palette, sampler, true_nm, one_wavelength)
        chart = _load(camera.lit_chart(scene, lamp, palette, sensor, integrator, bounces))
        names = [channel for channel in CHANNELS if channel in palette.film]
        result.append(
            Pass(
                chart=chart,
                witness=_load(camera.witness(scene, sensor, integrator)) if witness else None,
                area=np.array([np.trapezoid(palette.film[c], palette.film_nm) for c in names]),
                white=palette.white,
            )
        )
    plugins.forget()
    return result


def _scale(scene: Scene, lamp: Lamp, curves: Mapping[str, Spectrum], witness: bool) -> Array:
    """From radiance to power on a pixel in m2 sr, (H, W, 1 or 3): what the witness should see."""
    if scene.lens.kind == "thin":
        seen_open = open_fraction(scene) if witness else np.ones(())
        return (camera.detector_factor(scene) * seen_open)[..., None]
    known = real_field(scene)
    assert known is not None
    pixel_m2 = (scene.detector.pitch_um * 1e-6) ** 2 * scene.lens.transmission
    if not witness:
        return np.asarray(pixel_m2 * known.etendue[0].mean())[None, None, None]
    radius_m = np.hypot(*camera.places_m(scene))
    weights = channel_weights(lamp, curves, WAVELENGTHS_NM)
    etendue = [smooth(known.radius_m, known.etendue @ w, radius_m, odd=False) for w in weights]
    return pixel_m2 * np.stack(etendue, axis=-1)


def traced_open_fraction(scene: Scene, *, samples: int, seed: int) -> tuple[Array, Array]:
    """What the traced barrel leaves open of the aperture, (H, W), and its variance.

    It is the witness by itself, to be held against `pupil.open_fraction`: the ratio above would
    hide a ring of the wrong size.
    """
    _refuse_numbers(samples, seed, None, 0)
    _use_backend()
    detector = scene.detector
    curves = response(detector.response, detector.infrared_cut)
    palette = integrated(scene, scene.lamp[0], curves)
    witness = _load(
        camera.witness(scene, camera.sensor(scene, palette, "multijitter"), DIRECT_LIGHT)
    )
    per_batch = _per_batch(samples, 1)
    area = sum(float(np.trapezoid(palette.film[c], palette.film_nm)) for c in CHANNELS)
    batches = [
        _image(witness, per_batch, _seed(seed, "barrel", number)).sum(axis=2) / area
        for number in range(BATCHES)
    ]
    return np.mean(batches, axis=0), np.var(batches, axis=0, ddof=1) / BATCHES


def _use_backend() -> None:
    """Mitsuba's variant of the backend, with our plugins where it compiles just in time."""
    mi.set_variant(VARIANTS[backend().name])
    if backend().jit:
        plugins.register(mi, mi.variant())


def _integrator(bounces: int, points: int) -> dict[str, Any]:
    """Direct light alone, or paths of so many bounces, none of them cut short at random.

    A lamp of many points is asked in full by every path, but by Mitsuba's scalar variant, in which
    a Python plugin would take minutes: there each path asks one of them.
    """
    if bounces == 0:
        if points > 1 and backend().jit:
            return {"type": plugins.EVERY_LAMP}
        return DIRECT_LIGHT
    return {"type": "path", "max_depth": 2 + bounces, "rr_depth": 1000}


def _per_batch(samples: int, points: int) -> int:
    """Light paths per pixel and batch: a square number, and a multiple of the lamp's points."""
    side = math.isqrt(points)
    return (side * math.ceil(math.sqrt(samples / BATCHES) / side)) ** 2


def _refuse_numbers(samples: int, seed: int, noise: float | None, bounces: int) -> None:
    if not 0 <= bounces <= MOST_BOUNCES:
        raise RenderError(f"{bounces} bounces", f"expected 0 to {MOST_BOUNCES}", "try 1")
    if not 1 <= samples <= 1_000_000:
        raise RenderError(f"{samples} samples", "expected 1 to 1000000 per pixel", f"try {SAMPLES}")
    if seed < 0:
        raise RenderError(f"seed {seed}", "expected 0 or more", "choose another seed")
    if noise is not None and not 0 < noise < 1:
        raise RenderError(
            f"noise {noise:g}", "expected a relative error between 0 and 1", "try 2e-4"
        )


def _seed(seed: int, lamp: str, batch: int) -> int:
    """A word of its own for every batch of every lamp."""
    key = (zlib.crc32(lamp.encode()), batch)
    return int(np.random.SeedSequence(seed, spawn_key=key).generate_state(1)[0])


def _image(scene: Any, samples: int, word: int) -> Array:
    """One batch, (H, W, 3)."""
    seen = np.array(mi.render(scene, spp=samples, seed=word), dtype=np.float64)
    return seen[..., : len(CHANNELS)]


def _load(description: Any) -> Any:
    """Mitsuba's scene from a description of `stage`."""
    return mi.load_dict(_made(description))


def _made(value: Any) -> Any:
    """A description with transformations, pictures and meshes made into Mitsuba's own."""
    if isinstance(value, dict):
        return {key: _made(part) for key, part in value.items()}
    if isinstance(value, np.ndarray):
        return mi.ScalarTransform4f(value)
    if isinstance(value, stage.Picture):
        return mi.Bitmap(value.values[..., None].astype(np.float32))
    if isinstance(value, stage.Mesh):
        return _mesh(value)
    return value


def _mesh(body: stage.Mesh) -> Any:
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(body.bsdf)
    mesh = mi.Mesh(body.name, len(body.vertices), len(body.faces), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = body.vertices.astype(np.float32).ravel()
    parameters["faces"] = body.faces.astype(np.uint32).ravel()
    parameters.update()
    return mesh
