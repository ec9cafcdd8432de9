"""How a capture is looked at: its colours, its groups of frames, and nothing twice."""

from __future__ import annotations

import numpy as np
import pytest

from analysis.gap.look import observe as looking
from analysis.gap.look.lattices import Lattice
from analysis.gap.look.observation import Stack, View
from analysis.gap.look.observe import observe
from analysis.gap.look.statistics.codes import codes
from analysis.gap.look.statistics.group import Group

HEIGHT, WIDTH = 96, 128


@pytest.mark.parametrize("cfa", ["GBRG", "BGGR"])
def test_colours_come_red_first_whatever_the_mosaic_begins_with(cfa: str) -> None:
    """A frame of one value for each colour: the means of the channels are those of R, G and B."""
    dn = np.zeros((4, HEIGHT, WIDTH), dtype=np.uint8)
    for place, colour in enumerate(cfa):
        dn[:, place // 2 :: 2, place % 2 :: 2] = {"R": 10, "G": 20, "B": 30}[colour]
    sites = [
        Lattice(name=f"{c}{k}", channel=c, dy=k // 2, dx=k % 2, step=2) for k, c in enumerate(cfa)
    ]
    view = View(lattices=tuple(sites), frames=4, side=4, top_dn=255)
    seen = observe([Stack(label="lit", lit=True, groups=[dn], counted=len(dn), repeated=0)], view)
    assert seen.channels == ("R", "G", "B")
    assert np.allclose(seen.means[0, 0].mean(axis=1), (10, 20, 30))


def test_a_stray_code_at_the_end_of_a_dark_changes_nothing() -> None:
    """Darks of few codes: one sample of ten thousand that is a code further says nothing of the
    converter's codes, and the figure stays as it was to a hundredth."""
    rng = np.random.default_rng(3)
    dark = np.round(2.1 + 0.3 * rng.standard_normal((4, 50, 50))).astype(np.uint8)
    stray = dark.copy()
    stray[0, 0, 0] = dark.max() + 1
    for name, (plain, other) in codes(
        Group(codes=np.array([dark, stray]), top_dn=255, lit=False)
    ).items():
        assert other == pytest.approx(plain, abs=0.01), name


@pytest.mark.parametrize("size", [(48, 64), (49, 67)])
def test_what_is_looked_at_together_is_what_is_looked_at_alone(size: tuple[int, int]) -> None:
    """Four lattices of three shots in two calls, dark and lit, or shot by shot: the same figures,
    however many rows and columns the mosaic has."""
    rng = np.random.default_rng(32)
    lattices = tuple(
        Lattice(name=name, channel=name[0], dy=dy, dx=dx, step=2)
        for name, dy, dx in (("R", 0, 0), ("G1", 0, 1), ("G2", 1, 0), ("B", 1, 1))
    )
    view = View(lattices=lattices, frames=4, side=8, top_dn=255)
    stacks = [
        Stack(
            label=label,
            lit=lit,
            groups=[rng.poisson(level, (4, *size, 3)).astype(np.uint8)],
            counted=4,
            repeated=0,
        )
        for label, lit, level in (("dark", False, 9), ("dim", True, 40), ("bright", True, 90))
    ]
    together = observe(stacks, view)
    looking._kept.clear()
    for stack in stacks:
        alone = observe([stack], view)
        own = [k for k, key in enumerate(together.keys) if key.shot == stack.label]
        assert [together.keys[k] for k in own] == list(alone.keys[:-2])
        assert together.figures[0, own] == pytest.approx(alone.figures[0, :-2], rel=1e-5, abs=1e-6)
        place = together.shots.index(stack.label)
        assert np.array_equal(together.means[:, place], alone.means[:, 0])


def test_frames_that_were_looked_at_are_not_looked_at_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The same codes under the same label give the same figures without a second look; one other
    code, or a lamp, does not."""
    looks = []
    on_lattices = looking.on_lattices
    monkeypatch.setattr(
        looking, "on_lattices", lambda *known: looks.append(known) or on_lattices(*known)
    )
    lattices = (Lattice(name="Y", channel="Y", dy=0, dx=0, step=1),)
    view = View(lattices=lattices, frames=4, side=8, top_dn=255)
    dn = np.random.default_rng(31).integers(90, 110, (4, 48, 64), dtype=np.uint8)

    def seen(frames: np.ndarray, *, lit: bool) -> np.ndarray:
        stack = Stack(label="one", lit=lit, groups=[frames], counted=len(frames), repeated=0)
        return observe([stack], view).figures

    first = seen(dn, lit=False)
    assert np.array_equal(seen(dn.copy(), lit=False), first)
    assert len(looks) == 1
    dn[2, 20, 30] += 1
    assert not np.array_equal(seen(dn, lit=False), first)
    seen(dn, lit=True)
    assert len(looks) == 3
