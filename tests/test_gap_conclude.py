"""Names are given strongest first, whatever the order in which a search came to them."""

from __future__ import annotations

import pytest

from analysis.gap.report import Named
from analysis.gap.verdict.conclude import strongest_first
from tests.candidates import candidate


def name(effect: str) -> Named:
    return Named(
        name=effect, probability=0.75, indistinguishable_from=(), absorbed=0.0, parameters={}
    )


@pytest.mark.parametrize(
    ("added", "given"),
    [
        (["column_fpn", "spatial_denoise"], ["spatial_denoise", "column_fpn"]),
        (["spatial_denoise", "column_fpn"], ["spatial_denoise", "column_fpn"]),
        # one that did not show before any effect was added
        (["row_noise", "column_fpn"], ["column_fpn", "row_noise"]),
        (["column_fpn"], ["column_fpn"]),
        ([], []),
    ],
)
def test_names_are_in_the_order_of_their_scores_before_any_effect_was_added(
    added: list[str], given: list[str]
) -> None:
    candidates = [candidate("spatial_denoise", 900.0), candidate("column_fpn", 400.0)]
    found = strongest_first([name(one) for one in added], candidates)
    assert [one.name for one in found] == given
