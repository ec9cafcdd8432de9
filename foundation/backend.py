"""Where the arithmetic runs: Dr.Jit on CUDA, on LLVM, or scalar, whichever works here.

LLVM before version 16 loads and then aborts the whole process on Dr.Jit's float kernels, so a
library is trusted only after its version was read and a throw-away child process has run a kernel
with it. What was proved is remembered in the user's cache folder.

Import this module before Dr.Jit: Dr.Jit looks up the LLVM library once, at its first use.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import importlib.metadata
import json
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

from foundation.errors import InputError, unknown

BackendName = Literal["scalar", "llvm", "cuda"]
NAMES: tuple[BackendName, ...] = ("cuda", "llvm", "scalar")
CHOICE_VARIABLE = "CAMTRUTH_BACKEND"
LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"
OLDEST_LLVM = 16

LIBRARY_PLACES = (
    "/usr/lib/*/libLLVM*.so*",
    "/usr/lib64/libLLVM*.so*",
    "/usr/lib/llvm-*/lib/libLLVM*.so*",
    "/opt/homebrew/opt/llvm*/lib/libLLVM*.dylib",
    "/usr/local/opt/llvm*/lib/libLLVM*.dylib",
)

_KERNEL = """
import drjit as dr
import drjit.{name} as arrays
x = dr.maximum(dr.arange(arrays.Float, 64) - 3, 0)
assert dr.sum(x)[0] == sum(max(i - 3, 0) for i in range(64))
"""


@dataclass(frozen=True, kw_only=True)
class Probe:
    """What was found of one backend: whether it works, and what to do if it does not."""

    name: BackendName
    works: bool
    found: str
    remedy: str = ""
    library: str | None = None


@dataclass(frozen=True, kw_only=True)
class Backend:
    """A working backend: its name and the Dr.Jit module with its array types."""

    name: BackendName
    arrays: ModuleType

    @property
    def jit(self) -> bool:
        """Whether operations are fused into compiled kernels."""
        return self.name != "scalar"

    def tensor(self, values: Any) -> Any:
        """A float32 tensor from anything NumPy can read."""
        import numpy as np

        return self.arrays.TensorXf(np.ascontiguousarray(values, dtype=np.float32))


def llvm_version(path: str) -> int | None:
    """The major version in the name of an LLVM library, or None where it has none."""
    match = re.search(r"libLLVM(?:[-.]|\.so\.|\.dylib\.)*(\d+)", Path(path).name)
    return int(match[1]) if match else None


def llvm_libraries() -> list[str]:
    """The LLVM libraries on this machine, newest first; the one named by the user alone."""
    named = os.environ.get(LIBRARY_VARIABLE)
    if named:
        return [named]
    found = {
        str(path.resolve())
        for place in LIBRARY_PLACES
        for path in Path("/").glob(place.lstrip("/"))
        if path.is_file()
    }
    return sorted(found, key=lambda path: llvm_version(path) or 0, reverse=True)


def _cache_file(key: str) -> Path:
    default = Path.home() / ".cache"
    folder = Path(os.environ.get("XDG_CACHE_HOME", default)) / "camtruth"
    return folder / f"backend-{hashlib.sha256(key.encode()).hexdigest()[:16]}.json"


def _kernel_runs(name: BackendName, library: str | None) -> bool:
    """Whether a kernel runs in a child process, remembered per library and Dr.Jit version."""
    stamp = Path(library).stat().st_mtime_ns if library and Path(library).exists() else 0
    key = f"{name}|{library}|{stamp}|{importlib.metadata.version('drjit')}|{sys.version}"
    cache = _cache_file(key)
    try:
        if name == "llvm":
            return bool(json.loads(cache.read_text())["works"])
    except (OSError, ValueError, KeyError):
        pass  # nothing remembered: try it
    environment = {**os.environ, **({LIBRARY_VARIABLE: library} if library else {})}
    try:
        result = subprocess.run(
            [sys.executable, "-c", _KERNEL.format(name=name)],
            env=environment,
            capture_output=True,
            timeout=60,
            check=False,
        )
        works = result.returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        works = False
    try:
        cache.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=cache.parent, delete=False) as scratch:
            json.dump({"works": works}, scratch)
        Path(scratch.name).replace(cache)
    except OSError:
        pass  # a cache that cannot be written costs half a second, no more
    return works


def _probe_llvm() -> Probe:
    install = f"install LLVM {OLDEST_LLVM} or newer (Debian: apt install libllvm19)"
    libraries = llvm_libraries()
    if not libraries:
        return Probe(name="llvm", works=False, found="no LLVM library found", remedy=install)
    too_old = []
    for library in libraries:
        version = llvm_version(library)
        if version is not None and version < OLDEST_LLVM:
            too_old.append(f"{library} (version {version})")
        elif _kernel_runs("llvm", library):
            return Probe(name="llvm", works=True, found=library, library=library)
    if too_old:
        found = f"only LLVM libraries older than {OLDEST_LLVM}: {', '.join(too_old)}"
        return Probe(name="llvm", works=False, found=found, remedy=install)
    found = f"{', '.join(libraries)} did not run a test kernel"
    return Probe(
        name="llvm",
        works=False,
        found=found,
        remedy=f"{install}, or name one in {LIBRARY_VARIABLE}",
    )


def _probe_cuda() -> Probe:
    if not Path("/dev/nvidiactl").exists():
        return Probe(name="cuda", works=False, found="no NVIDIA device", remedy="optional")
    if _kernel_runs("cuda", None):
        return Probe(name="cuda", works=True, found="an NVIDIA device that runs kernels")
    return Probe(
        name="cuda",
        works=False,
        found="an NVIDIA device that did not run a test kernel",
        remedy="update the NVIDIA driver to version 535 or newer",
    )


@functools.cache
def probe(name: BackendName) -> Probe:
    """Find out whether a backend works here; the answer is kept for this process."""
    if name == "llvm":
        return _probe_llvm()
    if name == "cuda":
        return _probe_cuda()
    return Probe(name="scalar", works=True, found="always there")


@functools.cache
def _load(name: BackendName) -> Backend:
    found = probe(name)
    if not found.works:
        raise InputError(f"backend '{name}': {found.found}", "expected it to work", found.remedy)
    if found.library:
        os.environ[LIBRARY_VARIABLE] = found.library
    return Backend(name=name, arrays=importlib.import_module(f"drjit.{name}"))


def backend(name: str | None = None) -> Backend:
    """The named backend, that of CAMTRUTH_BACKEND, or the fastest that works here.

    Raises:
        InputError: for an unknown name, or a named backend that does not work here.
    """
    name = name or os.environ.get(CHOICE_VARIABLE) or None
    if name is None:
        return next(_load(known) for known in NAMES if probe(known).works)
    if name not in NAMES:
        raise unknown("backend", name, NAMES, InputError)
    return _load(name)
