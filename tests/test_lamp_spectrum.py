"""A lamp of another colour temperature, by the spectra of a chart and by three colours alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import ndimage

from analysis.gap.diagnose import diagnose
from foundation.backend import backend
from render.rate import RateHeader, RateImage, rate_image
from scenes.lamps import planck
from scenes.spectra import lamp_spectrum, reflectances, response
from sensor.catalogue import catalogue
from sensor.colour_slopes import EFFECTIVE_NM, WIDTH_NM
from sensor.effect import Effect
from sensor.effects.lamp_spectrum_error import LampSpectrumError
from sensor.effects.spectral_response_error import SpectralResponseError
from sensor.protocol import Protocol, Shot
from sensor.record import record
from sensor.signal import Quantity
from sensor.simulation import exposed, lit
from tests.effects_bench import EXPOSURE_S, Array, bench_camera, rate_of
from tests.short import camera as short_camera

NM = np.arange(400.0, 701.0)
COOL_K, SHIFT_K = 2856.0, 150.0


def filters() -> Array:
    curves = response("surrogate")
    return np.array([curves[channel].at(NM) for channel in "RGB"])


def panels(lamp_k: float) -> Array:
    """Rates of the panels of a chart in three colours, (panels, 3), by their spectra."""
    surfaces = np.array([one.at(NM) for one in reflectances("BabelColor Average")])
    return np.asarray((surfaces * planck(lamp_k, NM)) @ filters().T)


def seen(rates: Array, effect: Effect, lamp: str = "lamp") -> Array:
    """Rates of panels, one a pixel, as the camera sees them."""
    scene = rates.reshape(4, 6, 3)
    camera = bench_camera(effect, height=4, width=6)
    shot = Shot(label="one", light=(lamp,), level=(1.0,), exposure_s=EXPOSURE_S, frames=1)
    light = lit(camera, shot, {lamp: rate_of(scene)}, backend())
    rate = exposed(camera, light, range(1), seed=1, until=Quantity.RATE)
    return np.asarray(rate.value.numpy()).reshape(24, 3) * EXPOSURE_S


def of_panels(rates: Array, before: Array) -> Array:
    """Logarithms of what panels gain beyond what all do: a lamp's level in each colour is free."""
    gain = np.log(rates / before)
    return np.asarray(gain - gain.mean(axis=0))


def test_the_filters_are_those_of_the_table() -> None:
    for channel, curve in zip("RGB", filters(), strict=True):
        mean = (NM * curve).sum() / curve.sum()
        sd = np.sqrt((np.square(NM - mean) * curve).sum() / curve.sum())
        assert NM[curve.argmax()] == EFFECTIVE_NM[channel]
        assert sd == pytest.approx(WIDTH_NM[channel], abs=1.0)


@pytest.mark.parametrize("shift_k", [SHIFT_K, -SHIFT_K])
def test_three_colours_tell_most_of_what_spectra_do_to_panels(shift_k: float) -> None:
    """Panels gain 1.5 % by their colours, root mean square; what three colours do not tell of it
    is less than a quarter of its square. A gain of each colour as a whole tells nothing of it."""
    before = panels(COOL_K)
    truth = of_panels(panels(COOL_K + shift_k), before)
    told = of_panels(seen(before, LampSpectrumError(shift_k=shift_k)), before)
    assert 0.012 < np.sqrt(np.square(truth).mean()) < 0.018
    assert np.square(truth - told).sum() < 0.25 * np.square(truth).sum()


def moved(curves: Array, shift_nm: float) -> Array:
    """Filters towards the red by so much."""
    return np.array([np.interp(NM - shift_nm, NM, curve) for curve in curves])


@pytest.mark.parametrize("shift_nm", [2.0, -2.0])
@pytest.mark.parametrize("illuminant", ["A", "FL2"])
def test_three_colours_tell_what_shifted_filters_do_to_panels(
    illuminant: str, shift_nm: float
) -> None:
    """Panels gain 0.9 to 1.5 % by their colours where a filter moves by 2 nm (their spread). What
    three colours do not tell of it is less than a quarter of its square."""
    surfaces = np.array([one.at(NM) for one in reflectances("BabelColor Average")])
    falls = surfaces * lamp_spectrum(illuminant).at(NM)
    before = np.asarray(falls @ filters().T)
    truth = of_panels(np.asarray(falls @ moved(filters(), shift_nm).T), before)
    effect = SpectralResponseError(leakage=0.0, shift_nm=shift_nm)
    told = of_panels(seen(before, effect), before)
    left = np.square(truth - told).sum(axis=0) / np.square(truth).sum(axis=0)
    assert truth.std(axis=0).min() > 0.008
    assert left.max() < 0.25


def test_a_lamp_is_one_with_a_filament_or_another() -> None:
    before = panels(COOL_K)

    def burns_so(lamps: float, lamp: str) -> bool:
        after = seen(before, LampSpectrumError(shift_k=SHIFT_K, lamps=lamps), lamp)
        return not np.allclose(after, before, rtol=1e-5)

    names = ("incandescent", "fluorescent")
    assert [[burns_so(lamps, name) for name in names] for lamps in (0.0, 1.0, 2.0)] == [
        [True, True],
        [True, False],
        [False, True],
    ]


def chart(lamp: str, lamp_k: float) -> RateImage:
    """Four by six panels with soft edges, each the mean of what its spectrum makes of the lamp."""
    soft = ndimage.gaussian_filter(
        np.kron(panels(lamp_k).reshape(4, 6, 3), np.ones((24, 22, 1)))[:, 2:-2], (2.0, 2.0, 0)
    )
    rate = (3.0e5 * soft / soft.max(axis=(0, 1))).astype(np.float32)
    return rate_image(rate, np.zeros_like(rate), RateHeader(scene="patches", lamp=lamp))


MISTAKEN_FOR_IT = "spectral_response_error", "color_matrix", "crosstalk", "large_scale_prnu"
"""What else changes panels by their colours, or what is left of them."""


@pytest.mark.whole
def test_a_hotter_lamp_is_named_by_what_its_spectrum_does_to_a_chart() -> None:
    """Light by the spectra of lamp, chart and filters, of which a diagnosis knows three colours.

    The shift comes out to the third of it that three colours leave open, or to 4.5 of the standard
    errors that the report states."""
    stated = {
        "incandescent": chart("incandescent", COOL_K),
        "fluorescent": chart("fluorescent", 4200.0),
    }
    rates = {name: image.rate_e_per_s for name, image in stated.items()}
    rates["incandescent"] = chart("incandescent", COOL_K + 100.0).rate_e_per_s
    lit_shots = [
        Shot(label=f"{name} {level}", light=(name,), level=(level,), exposure_s=0.02, frames=16)
        for name in stated
        for level in (0.4, 1.0)
    ]
    dark = Shot(label="dark", exposure_s=0.02, frames=16)
    protocol = Protocol(name="two lamps", shot=(dark, *lit_shots))
    taken = record(short_camera().with_body(5), protocol, rates, seed=7)
    kinds = [catalogue()[name] for name in ("lamp_spectrum_error", *MISTAKEN_FOR_IT)]
    report = diagnose(taken, stated=stated, suspects=kinds).report
    assert report.effects, report
    named = report.effects[0]
    assert named.name == "lamp_spectrum_error", report
    assert named.probability > 0.5
    assert named.parameters["lamps"].value == 1.0
    shift = named.parameters["shift_k"]
    assert shift.se is not None
    assert abs(shift.value - 100.0) < max(33.0, 4.5 * shift.se)
