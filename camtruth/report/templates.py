"""The pages' templates, and what they may say of figures."""

from __future__ import annotations

import functools

import jinja2


@functools.cache
def template(name: str) -> jinja2.Template:
    """A template of this folder; unknown names in it are errors."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("camtruth.report", package_path="."),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["spelt"] = spelt
    environment.filters["sentence"] = lambda text: text[:1].upper() + text[1:]
    return environment.get_template(name)


def spelt(value: float | dict[str, float]) -> str:
    """A figure, or one for each colour, as R / G / B."""
    if isinstance(value, dict):
        return " / ".join(f"{v:.4g}" for v in value.values())
    return f"{value:.4g}"
