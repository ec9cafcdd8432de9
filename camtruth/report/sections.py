"""A plain page of sections: text, figures, tables. It needs no network and no other file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from camtruth.report.templates import template
from sensor.truth import versions


@dataclass(frozen=True, kw_only=True)
class Table:
    """Heads over rows of cells."""

    heads: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, kw_only=True)
class Section:
    """A heading with what stands below it.

    Attributes:
        title: the heading.
        text: paragraphs.
        svgs: plots of `camtruth.report.plot`, with their caption.
        caption: what the plots show.
        interactive: HTML of a figure that people explore.
        tables: tables.
    """

    title: str
    text: Sequence[str] = ()
    svgs: Sequence[str] = ()
    caption: str = ""
    interactive: str = ""
    tables: Sequence[Table] = field(default=())


def sections_page(*, title: str, lead: str, command: str, sections: Sequence[Section]) -> str:
    """The page as HTML; `command` is the command line that makes it again."""
    return template("sections.html.j2").render(
        title=title, lead=lead, command=command, sections=sections, versions=versions()
    )
