"""The public face is complete, and what the documentation shows runs."""

from __future__ import annotations

import ast
import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import camtruth
from tests.conftest import Run, Small

ROOT = Path(__file__).parents[1]


def blocks(page: str, language: str) -> list[str]:
    """The code blocks of a page in a language."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"^```(\w*)\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [block for named, block in found if named == language]


def test_every_public_name_is_there() -> None:
    assert camtruth.__all__ == sorted(camtruth.__all__)
    for name in camtruth.__all__:
        assert getattr(camtruth, name) is not None
    assert dir(camtruth) == camtruth.__all__
    with pytest.raises(AttributeError, match="nothing"):
        _ = camtruth.nothing


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse(Path(inspect.getfile(camtruth)).read_text(encoding="utf-8"))
    (seen,) = [n for n in tree.body if isinstance(n, ast.If)]
    aliases = [a for n in seen.body if isinstance(n, ast.ImportFrom) for a in n.names]
    assert sorted(a.asname or a.name for a in aliases) == camtruth.__all__


def test_whatever_a_public_function_takes_or_gives_is_public() -> None:
    """A type of ours in the signature of a public function has a public name."""
    public = {getattr(camtruth, name) for name in camtruth.__all__}
    functions = [f for f in public if inspect.isfunction(f)]
    assert len(functions) >= 10
    for function in functions:
        words = set(re.findall(r"\b[A-Z]\w+", str(inspect.signature(function))))
        module = sys.modules[function.__module__]
        for word in words:
            kind = getattr(module, word, None)
            ours = inspect.isclass(kind) and kind.__module__.split(".")[0] in {
                "scenes",
                "render",
                "sensor",
                "analysis",
                "camtruth",
            }
            internal = word in ("Backend",)
            assert not ours or kind in public or internal, f"{function.__name__} names {word}"


def test_the_readme_runs(tmp_path: Path) -> None:
    """The Python block of the README, on few frames and light paths."""
    (block,) = blocks("README.md", "python")
    assert sum(bool(line) for line in block.splitlines()) <= 12
    fewer = block.replace('"paper")', f'"{tmp_path}/few.toml")').replace(
        "protocol.lamps)", "protocol.lamps, samples=8)"
    )
    assert fewer.count(str(tmp_path)) == 1
    assert "samples=8" in fewer
    paper = (ROOT / "sensor/protocols/paper.toml").read_text(encoding="utf-8")
    few = paper.replace("frames = 100", "frames = 4")
    (tmp_path / "few.toml").write_text(few, encoding="utf-8")
    result = subprocess.run(
        [sys.executable, "-c", fewer], cwd=ROOT, capture_output=True, text=True, check=True
    )
    lines = result.stdout.splitlines()
    assert [line.split()[0] for line in lines] == ["R", "G", "B"]
    assert all("truth:" in line for line in lines)


def test_the_commands_of_the_readme_exist(run: Run) -> None:
    """Every word that the README shows is one that the commands know."""
    shown = [b for b in blocks("README.md", "") if b.startswith("camtruth ")]
    lines = "".join(shown).splitlines()
    assert len(lines) >= 5
    for line in lines:
        _, name, *words = line.split()
        text = run(name, "--help").out
        for word in words:
            assert not word.startswith("--") or word in text, line


def test_the_estimator_of_the_guide_runs(
    run: Run, small: Small, small_capture: Path, tmp_path: Path
) -> None:
    (block,) = [b for b in blocks("docs/extending.md", "python") if "def darkest" in b]
    (tmp_path / "mine.py").write_text(block, encoding="utf-8")
    answer = run("measure", small_capture, "--method", "mine.py:darkest", "--json")
    assert answer.code == 0, answer
    assert '"method": "darkest"' in answer.out


def test_the_lamp_of_the_guide_is_adjusted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The scene of the page, and its program that finds a gel and an intensity for the lamp."""
    (lamp,) = [b for b in blocks("docs/extending.md", "toml") if "tungsten" in b]
    (program,) = [b for b in blocks("docs/extending.md", "python") if "adjusted" in b]
    chart = (ROOT / "scenes/presets/chart.toml").read_text(encoding="utf-8")
    (tmp_path / "my.toml").write_text(f"{chart}\n{lamp}", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    exec(program, {})
    intensity, gel = capsys.readouterr().out.split(maxsplit=1)
    assert float(intensity) != 2.0
    assert "green_density" in gel


def test_links_of_the_documents_lead_somewhere() -> None:
    pages = [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")]
    assert len(pages) >= 6
    for page in pages:
        for target in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
            if not target.startswith("http"):
                assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_catalogue_page_is_that_of_the_code() -> None:
    from sensor.catalogue import catalogue

    text = (ROOT / "docs/effects.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `(\w+)`", text, re.MULTILINE)) == set(catalogue())


def test_make_help_lists_the_habits() -> None:
    shown = subprocess.run(
        ["make", "--no-print-directory"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for habit in ("help", "setup", "demo", "check", "test", "bench", "docs"):
        assert re.search(rf"^  make {habit} +\S", shown, re.MULTILINE), habit
