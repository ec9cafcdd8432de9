"""`make bench`: speeds as ratios, both sides in one run on one machine.

Each file of this folder that has a `ratios` is run; it yields what was compared, the ratio, and
the least ratio that the project promises.
"""

from __future__ import annotations

import importlib
import pkgutil
import sys
from pathlib import Path

from foundation.backend import backend


def main() -> int:
    print(f"backend: {backend().name}")
    missed = 0
    for found in sorted(pkgutil.iter_modules([str(Path(__file__).parent)]), key=lambda m: m.name):
        module = importlib.import_module(f"benchmarks.{found.name}")
        for what, ratio, promised in getattr(module, "ratios", tuple)():
            verdict = "" if promised is None else f"(promised: {promised:g})"
            if promised is not None and ratio < promised:
                verdict += "  MISSED"
                missed += 1
            print(f"{ratio:10.1f} x  {what} {verdict}", flush=True)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
