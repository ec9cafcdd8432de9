"""docs/light.md: every check of the light as a figure or a line, with what the code gives today."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy import constants, stats

from camtruth.report.plot import Axis, Marks, axis_over, plot
from camtruth.report.shading import shading_figure
from docs.sheet import sheet
from foundation.output import new_file
from render import closed_form, path_traced
from render.bounced import bounced_factor
from render.perturbed import changes
from render.rate import RateImage
from scenes.chart import Gloss
from scenes.field import WAVELENGTHS_NM
from scenes.imaging import real_field
from scenes.lamp import Lamp
from scenes.lens import Lens
from scenes.scene import Scene, load

HERE = Path(__file__).parent
FIGURES = HERE / "figures" / "light"
SIZE = (160, 120)
PLACE = (-0.06, 0.40, 0.45)
LENSES = {
    "speed-panchro": Lens(
        kind="real",
        prescription="speed-panchro",
        focal_length_mm=4.3,
        f_number=2.8,
        focus_distance_m=0.30,
    ),
    "flektagon": Lens(
        kind="real",
        prescription="flektagon",
        focal_length_mm=4.3,
        f_number=3.5,
        focus_distance_m=0.30,
    ),
}
"""The two lenses as this page photographs the chart with them."""


def write_light_page() -> None:
    """The page and its figures."""
    FIGURES.mkdir(parents=True, exist_ok=True)
    chart = load("chart")
    small = chart.with_size(*SIZE)
    parts = {
        "hand": hand_calculation(),
        "noise": _noise(chart),
        "lamps": _lamps(small),
        "lenses": _lenses(small),
        "surfaces": _surfaces(small),
        "response": _response(chart),
    }
    text = (HERE / "light_text.md").read_text(encoding="utf-8")
    for name, words in parts.items():
        text = text.replace(f"<!-- {name} -->", words)
    with new_file(HERE / "light.md") as scratch:
        scratch.write_text(text, encoding="utf-8")


def hand_calculation() -> str:
    """Lamp to electrons for the middle pixel of an even card, by arithmetic alone."""
    lamp_w_sr, lamp_m, rho, t, qe = 1.0, (0.0, 0.40, 0.45), 0.9, 0.9, 0.4
    r2 = sum(x * x for x in lamp_m)
    cosine = lamp_m[2] / math.sqrt(r2)
    lit = lamp_w_sr * cosine / r2
    radiance = rho * lit / math.pi
    v = 1 / (1 / 4.3e-3 - 1 / 0.18)
    solid = math.pi * (4.3e-3 / 2 / 2) ** 2 / v**2
    on_detector = radiance * t * solid
    power = on_detector * 5.6e-6**2
    photon = constants.h * constants.c / 550e-9
    rows = [
        ("lamp", "I", "1 W/sr, even from 400 to 700 nm: 1/300 W/(sr nm)", lamp_w_sr, "W/sr"),
        ("distance", "R² = 0.40² + 0.45²", "lamp at (0, 0.40, 0.45) m", r2, "m²"),
        ("slant", "cos θ = 0.45 / R", "", cosine, ""),
        ("irradiance", "E = I cos θ / R²", "", lit, "W/m²"),
        ("radiance", "L = ρ E / π", "card of ρ = 0.9", radiance, "W/(m² sr)"),
        ("image", "v = 1 / (1/f − 1/u)", "f = 4.3 mm, u = 0.18 m", v, "m"),
        ("aperture", "Ω = π (f / 2N)² / v²", "f/2", solid, "sr"),
        ("on the sensor", "H = L T Ω cos⁴ α", "T = 0.9, on the axis", on_detector, "W/m²"),
        ("pixel", "P = H p²", "p = 5.6 µm", power, "W"),
        ("photon", "h c / 550 nm", "mean wavelength of an even spectrum", photon, "J"),
        ("photons", "P / (h c / λ)", "", power / photon, "1/s"),
        ("electrons", "× 0.4", "quantum efficiency 0.4 throughout", qe * power / photon, "e⁻/s"),
    ]
    lines = ["| link | formula | with | value | unit |", "|---|---|---|---|---|"]
    lines += [f"| {a} | {b} | {c} | {value:.5g} | {unit} |" for a, b, c, value, unit in rows]
    return "\n".join(lines)


def _svg(name: str, drawing: str, alt: str) -> str:
    with new_file(FIGURES / f"{name}.svg") as scratch:
        scratch.write_text(drawing, encoding="utf-8")
    return f"![{alt}](figures/light/{name}.svg)"


def _inside(image: RateImage, truth: RateImage) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Errors of green pixels in standard errors; panel means' errors, relative; the largest."""
    scores, means, worst = [], [], []
    for panel in image.header.panels:
        rate, true = (i.rate_e_per_s[panel.window][..., 1].astype(float) for i in (image, truth))
        sigma = np.sqrt(image.variance[panel.window][..., 1].astype(float))
        scores.append(((rate - true) / sigma).ravel())
        means.append(rate.mean() / true.mean() - 1)
        worst.append(np.abs(rate / true - 1).max())
    return np.concatenate(scores), np.array(means), np.array(worst)


def _noise(chart: Scene) -> str:
    image = path_traced.render(chart, "fluorescent")
    truth = closed_form.render(chart, "fluorescent")
    scores, means, worst = _inside(image, truth)
    edges = np.linspace(-6, 6, 49)
    count, _ = np.histogram(scores, bins=edges, density=True)
    middle, fine = (edges[1:] + edges[:-1]) / 2, np.linspace(-6, 6, 121)
    student = plot(
        "Errors in units of the stated one",
        Axis(low=-6, high=6, label="z"),
        axis_over([*count.tolist(), 0.4], "density"),
        [
            Marks(x=middle.tolist(), y=count.tolist(), style="k"),
            Marks(x=fine.tolist(), y=stats.norm.pdf(fine).tolist(), style="r", kind="line"),
            Marks(x=fine.tolist(), y=stats.t(7).pdf(fine).tolist(), style="truth", kind="line"),
        ],
    )
    number = list(range(1, 25))
    panels = plot(
        "Panel means less the closed form",
        Axis(low=0, high=25, label="panel"),
        axis_over((means * 1e6).tolist(), "10⁻⁶ of the rate"),
        [Marks(x=number, y=(means * 1e6).tolist(), style="g")],
    )
    drawing = sheet(
        [student, panels],
        legend=[("dots k", "pixels"), ("line truth", "Student's t, 7"), ("line r", "normal")],
    )
    with new_file(FIGURES / "shading.svg") as scratch:
        scratch.write_text(shading_figure(chart, image), encoding="utf-8")
    words = (
        f"At {image.header.samples} light paths a pixel the noise is"
        f" {max(image.header.noise.values()):.1e} in the noisiest panel. Panel means are within"
        f" {np.abs(means).max():.0e} of the closed form, single pixels within {worst.max():.1e}."
    )
    return words + "\n\n" + _svg("noise", drawing, "Distribution of errors, and panel means")


def _lamps(small: Scene) -> str:
    lamps = {
        "disk, 0.1 m": Lamp(
            name="disk",
            kind="disk",
            spd="A",
            position_m=PLACE,
            intensity_w_per_sr=1,
            diameter_m=0.1,
        ),
        "disk, 0.3 m": Lamp(
            name="disk",
            kind="disk",
            spd="A",
            position_m=PLACE,
            intensity_w_per_sr=1,
            diameter_m=0.3,
        ),
        "tube, 0.3 m": Lamp(
            name="tube",
            kind="tube",
            spd="FL2",
            position_m=PLACE,
            intensity_w_per_sr=1,
            length_m=0.3,
        ),
    }
    lines = [
        "| lamp | panel means against the closed form, at most | noise | limit of the test |",
        "|---|---|---|---|",
    ]
    for name, lamp in lamps.items():
        scene = dataclasses.replace(small, lamp=(lamp,))
        image, truth = (how.render(scene, lamp) for how in (path_traced, closed_form))
        _, means, _ = _inside(image, truth)
        noise = max(image.header.noise.values())
        lines.append(f"| {name} | {np.abs(means).max():.0e} | {noise:.1e} | 1e-4 |")
    return "\n".join(lines)


def _lenses(small: Scene) -> str:
    plots, lines = [], ["| lens | panel means against the closed form, at most | noise |"]
    lines.append("|---|---|---|")
    for name, lens in LENSES.items():
        scene = dataclasses.replace(small, lens=lens)
        image, truth = (how.render(scene, "fluorescent") for how in (path_traced, closed_form))
        _, means, _ = _inside(image, truth)
        noise = max(image.header.noise.values())
        lines.append(f"| {name} | {np.abs(means).max():.0e} | {noise:.1e} |")
        known = real_field(scene)
        assert known is not None
        mm = known.radius_m * 1e3
        green = int(np.abs(WAVELENGTHS_NM - 550).argmin())
        light = known.etendue[:, green] / known.etendue[0, green]
        natural = (1 + known.slope**2) ** -2
        reach = (lens.focus_distance_m - known.crossing_m) * known.slope
        scale = lens.image_distance_m / lens.focus_distance_m
        distortion = 100 * (mm[1:] * 1e-3 / (reach[1:] * scale) - 1)
        along = Axis(low=0, high=float(mm[-1]), label="from the centre / mm")
        plots.append(
            plot(
                f"{name}: light",
                along,
                Axis(low=0, high=1.05, label="relative to the centre"),
                [
                    Marks(x=mm.tolist(), y=natural.tolist(), style="b", kind="line"),
                    Marks(x=mm.tolist(), y=light.tolist(), style="truth", kind="line"),
                ],
            )
        )
        plots.append(
            plot(
                f"{name}: distortion",
                along,
                axis_over(distortion.tolist(), "%"),
                [Marks(x=mm[1:].tolist(), y=distortion.tolist(), style="g", kind="line")],
            )
        )
    legend = [("line truth", "traced"), ("line b", "cos⁴ of the chief ray")]
    figure = _svg("lenses", sheet(plots, legend=legend), "Illumination and distortion of lenses")
    return "\n".join(lines) + "\n\n" + figure


def _surfaces(small: Scene) -> str:
    def coated(scene: Scene) -> Scene:
        return dataclasses.replace(
            scene, chart=dataclasses.replace(scene.chart, gloss=Gloss(roughness=0.3))
        )

    def tilted(scene: Scene) -> Scene:
        return dataclasses.replace(
            scene,
            chart=dataclasses.replace(scene.chart, tilt_deg=(10.0, 12.0)),
            camera_distance_m=0.42,
        )

    changed: dict[str, tuple[Callable[[Scene], Scene], str]] = {
        "gloss of roughness 0.3": (coated, "1e-3"),
        "tilt of 10 and 12 degrees": (tilted, "2e-4"),
    }
    lines = ["| what | panel means against the closed form, at most | limit |", "|---|---|---|"]
    for name, (change, limit) in changed.items():
        scene = change(small)
        image, truth = (how.render(scene, "fluorescent") for how in (path_traced, closed_form))
        lines.append(f"| {name} | {np.abs(_inside(image, truth)[1]).max():.0e} | {limit} |")
    lamp = small.named("fluorescent")
    even = dataclasses.replace(load("uniform").with_size(*SIZE), booth=small.booth)
    bounced = path_traced.render(even, lamp, bounces=1, samples=288)
    direct = closed_form.render(even, lamp).rate_e_per_s[..., 1].astype(float)
    seen = closed_form.sight(even)
    share = bounced_factor(even, lamp, seen.x_m, seen.y_m) / closed_form.irradiance_factor(
        lamp, seen.x_m, seen.y_m
    )
    found = (bounced.rate_e_per_s[..., 1] / direct - 1).mean()
    error = np.sqrt((bounced.variance[..., 1] / direct**2).sum()) / direct.size
    words = (
        f"One bounce in the booth adds {100 * found:.3f} ± {100 * error:.3f} % to the light on an"
        f" even card; the integral over table and walls is {100 * share.mean():.3f} %."
    )
    return "\n".join(lines) + "\n\n" + words


def _response(chart: Scene) -> str:
    lines = ["| size | kind | grey rates, at most | greys apart, at most | any panel, at most |"]
    lines.append("|---|---|---|---|---|")
    for size in (0.1, 0.2):
        rows = [row for lamp in chart.lamp for row in changes(chart, lamp, size)]
        for kind in dict.fromkeys(row.kind for row in rows):
            some = [row for row in rows if row.kind == kind]
            grey, spread, worst = (
                100 * max(abs(getattr(row, word)) for row in some)
                for word in ("grey", "spread", "worst")
            )
            lines.append(f"| {size:g} | {kind} | {grey:.1f} % | {spread:.2f} % | {worst:.1f} % |")
    return "\n".join(lines)
