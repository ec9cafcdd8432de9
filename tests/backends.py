"""Backends that work on this machine."""

from __future__ import annotations

from foundation.backend import probe

BACKENDS = [name for name in ("llvm", "scalar") if probe(name).works]
