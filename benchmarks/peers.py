"""The same frame by others: plain NumPy, and three simulators of cameras where they are installed.

The work is that of equation (1) up to 8-bit colour: a Poisson count of a mean that differs from
pixel to pixel, a fixed offset, normal read noise, gain and black, bilinear colours, rounding. What
stays the same from frame to frame is prepared beforehand. The simulators have no demosaicer of
their own and are given OpenCV's, the fastest there is, on whole codes. Each is called by the
functions that its own pipeline calls, without the pipeline.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

HEIGHT, WIDTH = 480, 640
ELECTRONS, EXPOSURE_S = 4000.0, 0.03268
GAIN_DN_PER_E, BLACK_DN = 0.01515, 3.0
PRNU, FPN_E, READ_E, DARK_E = 0.01, 10.0, 17.0, 2.0

Frame = Callable[[], NDArray[np.uint8]]


def patterns() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean electrons and offsets of a camera body."""
    rng = np.random.default_rng(0)
    mean = ELECTRONS * (1 + PRNU * rng.standard_normal((HEIGHT, WIDTH))) + DARK_E
    return mean, FPN_E * rng.standard_normal((HEIGHT, WIDTH))


def plain_numpy() -> Frame:
    """Float32 wherever NumPy lets one choose; colours by slices of a padded image."""
    mean, fpn = patterns()
    fpn32 = fpn.astype(np.float32)
    rng = np.random.default_rng(1)

    def frame() -> NDArray[np.uint8]:
        electrons = rng.poisson(mean).astype(np.float32)
        electrons += fpn32
        electrons += np.float32(READ_E) * rng.standard_normal(mean.shape, dtype=np.float32)
        electrons -= np.float32(DARK_E)
        electrons *= np.float32(GAIN_DN_PER_E)
        electrons += np.float32(BLACK_DN)
        colours = bilinear(electrons)
        np.rint(colours, out=colours)
        return np.clip(colours, 0, 255, out=colours).astype(np.uint8)

    return frame


def bilinear(mosaic: NDArray[np.float32]) -> NDArray[np.float32]:
    """Colours of an RGGB mosaic: means of the nearest samples."""
    height, width = mosaic.shape
    padded = np.pad(mosaic, 1, mode="reflect")
    across = padded[:, :-2] + padded[:, 2:]
    side, down = across[1:-1], padded[:-2, 1:-1] + padded[2:, 1:-1]
    corner = across[:-2] + across[2:]
    colours = np.empty((height, width, 3), np.float32)
    for colour, (y, x) in ((0, (0, 0)), (2, (1, 1))):
        own, beside, over, far = ((y, x), (y, 1 - x), (1 - y, x), (1 - y, 1 - x))
        for (a, b), source, weight in (
            (own, mosaic, 1.0),
            (beside, side, 0.5),
            (over, down, 0.5),
            (far, corner, 0.25),
        ):
            colours[a::2, b::2, colour] = np.float32(weight) * source[a::2, b::2]
        a, b = own
        colours[a::2, b::2, 1] = np.float32(0.25) * (side[a::2, b::2] + down[a::2, b::2])
        colours[a::2, 1 - b :: 2, 1] = mosaic[a::2, 1 - b :: 2]
    return colours


def galsim() -> Frame:
    """GalSim: PoissonNoise and GaussianNoise on an image."""
    import galsim as peer

    mean, fpn = patterns()
    image = peer.ImageF(mean.astype(np.float32))
    rng = peer.BaseDeviate(1)
    poisson, read = peer.PoissonNoise(rng), peer.GaussianNoise(rng, sigma=READ_E)
    offset = (fpn - DARK_E).astype(np.float32)

    def frame() -> NDArray[np.uint8]:
        noisy = image.copy()
        noisy.addNoise(poisson)
        noisy.array[:] += offset
        noisy.addNoise(read)
        return coloured(noisy.array * np.float32(GAIN_DN_PER_E) + np.float32(BLACK_DN))

    return frame


def emva1288() -> Frame:
    """The camera of the EMVA 1288 package, at one wavelength."""
    from emva1288.camera.camera import Camera
    from emva1288.camera.routines import Qe

    mean, fpn = patterns()
    wavelength = np.array([550.0])
    camera = Camera(
        bit_depth=8,
        width=WIDTH,
        height=HEIGHT,
        qe=Qe(qe=np.ones((HEIGHT, WIDTH, 1)), wavelength=wavelength, width=WIDTH, height=HEIGHT),
        K=GAIN_DN_PER_E,
        K_min=GAIN_DN_PER_E,
        K_max=GAIN_DN_PER_E,
        K_steps=1,
        blackoffset=BLACK_DN,
        dark_signal_0=0.0,
        sigma2_dark_0=READ_E**2,
        dsnu=fpn,
        prnu=mean / ELECTRONS,
        seed=1,
    )
    radiance = camera.get_radiance_for(mean=GAIN_DN_PER_E * ELECTRONS)

    def frame() -> NDArray[np.uint8]:
        return coloured(camera.grab(radiance))

    return frame


def pyxel() -> Frame:
    """Pyxel's models of a CCD, one after the other."""
    from pyxel.detectors import (
        CCD,
        CCDGeometry,
        Characteristics,
        ChargeToVoltSettings,
        Environment,
    )
    from pyxel.models.charge_collection import simple_collection
    from pyxel.models.charge_generation import simple_conversion
    from pyxel.models.charge_measurement import output_node_noise, simple_measurement
    from pyxel.models.photon_collection import shot_noise
    from pyxel.models.readout_electronics import simple_adc

    mean, fpn = patterns()
    volt_per_e = 1e-6
    top_v = 256 / GAIN_DN_PER_E * volt_per_e
    detector = CCD(
        geometry=CCDGeometry(row=HEIGHT, col=WIDTH, pixel_vert_size=5.6, pixel_horz_size=5.6),
        environment=Environment(temperature=300),
        characteristics=Characteristics(
            quantum_efficiency=1.0,
            charge_to_volt=ChargeToVoltSettings(value=volt_per_e),
            pre_amplification=1.0,
            full_well_capacity=100_000,
            adc_bit_resolution=8,
            adc_voltage_range=(0.0, top_v),
        ),
    )
    offset = fpn + BLACK_DN / GAIN_DN_PER_E

    def frame() -> NDArray[np.uint8]:
        detector.empty()
        detector.photon.array = mean
        shot_noise(detector)
        simple_conversion(detector, binomial_sampling=False)
        simple_collection(detector)
        detector.pixel.array = detector.pixel.array + offset
        simple_measurement(detector)
        output_node_noise(detector, std_deviation=READ_E * volt_per_e)
        simple_adc(detector)
        return coloured(detector.image.array)

    return frame


def coloured(dn: NDArray[np.generic]) -> NDArray[np.uint8]:
    """Whole codes of an RGGB mosaic, and OpenCV's bilinear colours of them."""
    import cv2

    whole = dn if dn.dtype == np.uint8 else np.clip(np.rint(dn), 0, 255).astype(np.uint8)
    return np.asarray(cv2.cvtColor(whole, cv2.COLOR_BayerRGGB2RGB), np.uint8)


PEERS: dict[str, Callable[[], Frame]] = {
    "GalSim": galsim,
    "emva1288": emva1288,
    "Pyxel": pyxel,
}


def missing(peer: Callable[[], Frame]) -> bool:
    """Whether the package of a peer is not installed."""
    return importlib.util.find_spec(peer.__name__) is None
