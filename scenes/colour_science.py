"""The colour-science library, read without its warning that there is no Matplotlib.

Nothing here draws with Matplotlib, so it is not installed, and nobody needs to be told.
"""

from __future__ import annotations

import warnings

with warnings.catch_warnings():
    warnings.filterwarnings("ignore", message='"Matplotlib" related API')
    import colour

__all__ = ["colour"]
