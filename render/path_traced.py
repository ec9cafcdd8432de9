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
from typing import Any, Literal

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from foundation.backend import backend
from render.batches import BATCHES, Sums, batches_needed, relative_noise
from render.errors import RenderError
from render.palette import CARD, WALL, Palette, integrated, sampled
from render.pupil import open_fraction, ring_mesh
from render.rate import RateHeader, RateImage, rate_image
from render.record import optics, versions
from scenes.geometry import Rectangle, blur_diameter_px, panel_rectangles, panels
from scenes.scene import Lamp, Scene
from scenes.spectra import BAND_NM, CHANNELS, Spectrum, response, spectrum

Array = NDArray[np.float64]
Progress = Callable[[int, int], None]
Wavelengths = Literal["integrated", "sampled"]
Sampler = Literal["multijitter", "independent"]

VARIANTS = {"scalar": "scalar_spectral", "llvm": "llvm_ad_spectral", "cuda": "cuda_ad_spectral"}
__all__ = ["BATCHES", "SAMPLES", "render", "traced_open_fraction"]

SAMPLES = 72
"""Light paths per pixel by default."""

MM_PER_M = 1e3
"""Mitsuba is given millimetres: its ray offsets scale with the size of coordinates above 1."""
CARD_BEHIND_M, WALL_BEHIND_M = 0.3e-3, 2e-3
"""The panels are glued on the card, and the card hangs on the wall."""
BLACK = spectrum(BAND_NM, (0.0, 0.0))

DIRECT_LIGHT = {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0}
"""A point lamp cannot be met by chance, so that asking it once is all there is to do."""


def render(
    scene: Scene,
    lamp: str | Lamp,
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    noise: float | None = None,
    progress: Progress | None = None,
    response_curves: Mapping[str, Spectrum] | None = None,
    wavelengths: Wavelengths = "integrated",
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
        wavelengths, sampler, witness: other ways to the same image, for comparison; without a
            witness a batch is taken as it comes.

    Raises:
        SceneError: for an unknown lamp.
        RenderError: for a number of samples, a seed or a noise that cannot be.
    """
    _refuse_numbers(samples, seed, noise)
    source = scene.named(lamp) if isinstance(lamp, str) else lamp
    mi.set_variant(VARIANTS[backend().name])
    curves = dict(response_curves or response(scene.detector.response))
    palette = (integrated if wavelengths == "integrated" else sampled)(scene, source, curves)

    per_batch = math.ceil(math.sqrt(samples / BATCHES)) ** 2
    sensor = _sensor(scene, palette, sampler)
    chart = mi.load_dict(_chart(scene, source, palette, sensor))
    witnessed = mi.load_dict(_witness(scene, sensor)) if witness else None
    area = np.array([np.trapezoid(palette.film[c], palette.film_nm) for c in CHANNELS])
    seen_open = open_fraction(scene) if witness else np.ones(())
    scale = (_detector_factor(scene) * seen_open)[..., None] * palette.white
    clear = panels(scene)

    sums, most = Sums(), BATCHES
    while sums.batches < most:
        word = _seed(seed, source.name, sums.batches)
        seen = _image(chart, per_batch, word)
        sums.add(seen, _image(witnessed, per_batch, word) if witness else area)
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
        optics={**optics(scene, f"mitsuba {mi.variant()}"), "wavelengths": wavelengths},
        samples=sums.batches * per_batch,
        seed=seed,
        versions=versions(),
        panels=clear,
        noise=dict(zip(CHANNELS, reached, strict=True)),
    )
    return rate_image(rate, variance, header)


def traced_open_fraction(scene: Scene, *, samples: int, seed: int) -> tuple[Array, Array]:
    """What the traced barrel leaves open of the aperture, (H, W), and its variance.

    It is the witness by itself, to be held against `pupil.open_fraction`: the ratio above would
    hide a ring of the wrong size.
    """
    _refuse_numbers(samples, seed, None)
    mi.set_variant(VARIANTS[backend().name])
    palette = integrated(scene, scene.lamp[0], response(scene.detector.response))
    witness = mi.load_dict(_witness(scene, _sensor(scene, palette, "multijitter")))
    per_batch = math.ceil(math.sqrt(samples / BATCHES)) ** 2
    area = sum(float(np.trapezoid(palette.film[c], palette.film_nm)) for c in CHANNELS)
    batches = [
        _image(witness, per_batch, _seed(seed, "barrel", number)).sum(axis=2) / area
        for number in range(BATCHES)
    ]
    return np.mean(batches, axis=0), np.var(batches, axis=0, ddof=1) / BATCHES


def _refuse_numbers(samples: int, seed: int, noise: float | None) -> None:
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
    return np.array(mi.render(scene, spp=samples, seed=word), dtype=np.float64)


def _detector_factor(scene: Scene) -> Array:
    """From radiance to power on a pixel in m2 sr, (H, W): aperture / v^2, cos^4, pixel area."""
    detector, lens = scene.detector, scene.lens
    pitch_m, image_m = detector.pitch_um * 1e-6, lens.image_distance_m
    columns = (np.arange(detector.width_px) - (detector.width_px - 1) / 2) * pitch_m
    rows = (np.arange(detector.height_px) - (detector.height_px - 1) / 2) * pitch_m
    slant2 = 1 + (columns[None, :] ** 2 + rows[:, None] ** 2) / image_m**2
    on_axis = math.pi * (lens.aperture_radius_m / image_m) ** 2 * pitch_m**2 * lens.transmission
    return np.asarray(on_axis / slant2**2)


def _curve(curve: Spectrum) -> dict[str, Any]:
    """A spectrum in Mitsuba's words: linear between samples."""
    if np.ptp(curve.value) == 0:  # Mitsuba refuses a table of zeros
        return {"type": "uniform", "value": float(curve.value[0])}
    return {
        "type": "irregular",
        "wavelengths": ", ".join(repr(float(x)) for x in curve.nm),
        "values": ", ".join(repr(float(x)) for x in curve.value),
    }


def _even_curve(nm: Array, value: Array) -> dict[str, Any]:
    """The same for evenly spaced samples, as a film response has to be."""
    return {
        "type": "regular",
        "wavelength_min": float(nm[0]),
        "wavelength_max": float(nm[-1]),
        "values": ", ".join(repr(float(x)) for x in value),
    }


def _sensor(scene: Scene, palette: Palette, sampler: Sampler) -> dict[str, Any]:
    """The camera: looking down the z axis, image upright, its film the palette's channels."""
    lens, detector = scene.lens, scene.detector
    half_width_m = detector.width_px * detector.pitch_um * 1e-6 / 2
    nearest_mm = lens.barrel.distance_mm if lens.barrel else 1.0
    film: dict[str, Any] = {
        "type": "specfilm",
        "width": detector.width_px,
        "height": detector.height_px,
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    for channel in CHANNELS:
        film[f"srf_{channel}"] = _even_curve(palette.film_nm, palette.film[channel])
    return {
        "type": "thinlens",
        "fov": 2 * math.degrees(math.atan(half_width_m / lens.image_distance_m)),
        "fov_axis": "x",
        "aperture_radius": lens.aperture_radius_m * MM_PER_M,
        "focus_distance": lens.focus_distance_m * MM_PER_M,
        "near_clip": nearest_mm / 10,
        "far_clip": 1e6,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=[0, 0, scene.camera_distance_m * MM_PER_M], target=[0, 0, 0], up=[0, 1, 0]
        ),
        "film": film,
        "sampler": {"type": sampler},
    }


def _witness(scene: Scene, sensor: dict[str, Any]) -> dict[str, Any]:
    """Nothing but the lens, its barrel and a black wall that glows with radiance 1 at all
    wavelengths.

    Each path meets barrel or wall and asks a lamp once, as in the chart's scene: the scalar
    backend draws one random number after the other, and the two have to draw equally many.
    """
    glow = {"type": "area", "radiance": {"type": "uniform", "value": 1.0}}
    result: dict[str, Any] = {
        "type": "scene",
        "integrator": DIRECT_LIGHT,
        "sensor": sensor,
        "wall": {**_plate(_wall(scene), -WALL_BEHIND_M, BLACK), "emitter": glow},
    }
    if scene.lens.barrel is not None:
        result["barrel"] = _ring(scene)
    return result


def _chart(scene: Scene, lamp: Lamp, palette: Palette, sensor: dict[str, Any]) -> dict[str, Any]:
    """Panels on a card on a wall, a point lamp of 1 W/sr per unit of film, and the barrel."""
    result: dict[str, Any] = {
        "type": "scene",
        "integrator": DIRECT_LIGHT,
        "sensor": sensor,
        "lamp": {
            "type": "point",
            "position": [metres * MM_PER_M for metres in lamp.position_m],
            "intensity": {"type": "uniform", "value": MM_PER_M**2},
        },
    }
    for name, where in panel_rectangles(scene).items():
        result[f"panel_{name}"] = _plate(where, 0.0, palette.materials[name])
    half_width_m, half_height_m = scene.chart.width_m / 2, scene.chart.height_m / 2
    card = Rectangle(
        left_m=-half_width_m, bottom_m=-half_height_m, right_m=half_width_m, top_m=half_height_m
    )
    result["card"] = _plate(card, -CARD_BEHIND_M, palette.materials[CARD])
    result["wall"] = _plate(_wall(scene), -WALL_BEHIND_M, palette.materials[WALL])
    if scene.lens.barrel is not None:
        result["barrel"] = _ring(scene)
    return result


def _wall(scene: Scene) -> Rectangle:
    """A wall that fills the image, its blur, and whatever the card leaves."""
    detector, lens = scene.detector, scene.lens
    pixel_m = detector.pitch_um * 1e-6 * scene.camera_distance_m / lens.image_distance_m
    span_px = max(detector.width_px, detector.height_px) + 2 * blur_diameter_px(scene)
    half_m = max(span_px * pixel_m, scene.chart.width_m, scene.chart.height_m)
    return Rectangle(left_m=-half_m, bottom_m=-half_m, right_m=half_m, top_m=half_m)


def _plate(where: Rectangle, z_m: float, reflectance: Spectrum) -> dict[str, Any]:
    """A matt rectangle that faces the camera."""
    middle = [(where.left_m + where.right_m) / 2, (where.bottom_m + where.top_m) / 2, z_m]
    half = [(where.right_m - where.left_m) / 2, (where.top_m - where.bottom_m) / 2, 1 / MM_PER_M]
    place = mi.ScalarTransform4f().translate([m * MM_PER_M for m in middle])
    return {
        "type": "rectangle",
        "to_world": place.scale([m * MM_PER_M for m in half]),
        "bsdf": {"type": "diffuse", "reflectance": _curve(reflectance)},
    }


def _ring(scene: Scene) -> Any:
    """The black ring of the barrel."""
    vertices_m, faces = ring_mesh(scene)
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": _curve(BLACK)})
    mesh = mi.Mesh("barrel", len(vertices_m), len(faces), props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = (vertices_m * MM_PER_M).astype(np.float32).ravel()
    parameters["faces"] = faces.astype(np.uint32).ravel()
    parameters.update()
    return mesh
