"""What people write after the options of `camtruth blind`."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

from camtruth.blind.errors import BlindError
from camtruth.blind.scoring import MAIN
from sensor import camera_file
from sensor import protocol as protocols
from sensor.camera import Camera
from sensor.protocol import Protocol


def kind_and_number(text: str) -> tuple[str, int]:
    """A kind of case and how many, from KIND=N."""
    kind, equals, number = text.partition("=")
    if not (equals and kind and number.isdecimal() and len(number) < 7):
        raise BlindError(f"--cases {text}", "expected KIND=N", "as in --cases null=40")
    return kind, int(number)


def name_and_folder(text: str) -> tuple[str, Path]:
    """Who answered and where, from NAME=DIR."""
    name, equals, folder = text.partition("=")
    if not (equals and name and folder) or name == MAIN:
        raise BlindError(
            f"--beside {text}", "expected NAME=DIR", "as in --beside histogram=SET.histogram"
        )
    return name, Path(folder)


def width_and_height(text: str) -> tuple[int, int]:
    """From WIDTHxHEIGHT."""
    width, x, height = text.partition("x")
    if not (x and width.isdecimal() and height.isdecimal() and len(text) < 12):
        raise BlindError(f"--size {text}", "expected WIDTHxHEIGHT", "as in --size 160x120")
    if min(int(width), int(height)) < 32:
        raise BlindError(f"--size {text}", "expected at least 32 x 32 pixels", "make it larger")
    return int(width), int(height)


def safe(name: str) -> str:
    """A name that can be that of a folder."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,60}", name):
        raise BlindError(
            f"the name '{name}'", "expected letters, digits, - and _", "name the folder by --out"
        )
    return name


def sized(camera: str, height: int, width: int) -> Camera:
    """A camera by name or file, with so many pixels."""
    return camera_file.load(camera).resized(height, width)


def with_frames(protocol: str, frames: int) -> Protocol:
    """A protocol by name or file, with so many frames of each shot."""
    loaded = protocols.load(protocol)
    shots = tuple(dataclasses.replace(shot, frames=frames) for shot in loaded.shot)
    return dataclasses.replace(loaded, shot=shots)
