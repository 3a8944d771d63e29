"""Every benchmark runs, and the page holds what they hand over."""

from __future__ import annotations

import pkgutil
import platform
import re
from pathlib import Path

import pytest

import benchmarks
from benchmarks import memory, page
from benchmarks.__main__ import FOLDER, NAMES, README, ROOT, section
from benchmarks.effort import TRIAL
from benchmarks.section import Section

SUPPORT = {
    "__main__", "axis", "diagram", "effort", "gaps", "memory", "page", "processes", "section",
    "timing", "truth",
}  # fmt: skip
SERVED = ("http", "sweeps", "sweep_size")  # start a service: run in tests/service, beside these
LINK = re.compile(r"\]\(([^)#:]+)\)")


@pytest.fixture(scope="module")
def sections(coarse_conflicts: None) -> list[Section]:
    def run(prepare: str, measured: str) -> tuple[float, float]:
        """Both steps, in this process: one of their own takes a second to begin."""
        exec(f"{prepare}\n{measured}", {})
        return 0.0, 1.0

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(memory, "grown", run)
        return [section(name, TRIAL) for name in NAMES if name not in SERVED]


def test_every_benchmark_is_listed() -> None:
    """Gaps have a page of their own."""
    found = {module.name for module in pkgutil.iter_modules(benchmarks.__path__)}
    assert found - SUPPORT == set(NAMES)


def test_every_benchmark_measures_something(sections: list[Section]) -> None:
    for one in sections:
        assert one.parts, one.title
        assert re.search(r"\d (ms|s) \(", one.markdown()), one.title


def test_links_and_drawings_are_there(sections: list[Section], tmp_path: Path) -> None:
    readme = tmp_path / "README.md"
    readme.write_text(f"Before\n\n{page.BEGIN}\nold\n{page.END}\n\nafter\n", encoding="utf-8")
    folder = tmp_path / "docs" / "benchmarks"
    folder.mkdir(parents=True)
    (folder / "gone.svg").write_text("left over", encoding="utf-8")
    page.write(sections, folder, readme)
    assert not (folder / "gone.svg").exists()
    written = (folder / "README.md").read_text(encoding="utf-8")
    for link in LINK.findall(written):
        drawn = folder / link
        assert drawn.exists() or (FOLDER / link).exists(), link
    reported = readme.read_text(encoding="utf-8")
    assert reported.startswith("Before\n\n")
    assert reported.endswith("\n\nafter\n")
    assert page.quoted(reported) == page.front(sections)
    assert page.front(sections) in written


def test_the_committed_page_is_whole() -> None:
    written = (FOLDER / "README.md").read_text(encoding="utf-8")
    links = LINK.findall(written)
    for link in links:
        assert (FOLDER / link).exists(), link
    drawings = {path.name for path in FOLDER.glob("*.svg")}
    assert drawings == {link for link in links if link.endswith(".svg")}
    assert str(ROOT) not in written
    assert platform.node() not in page.machine()


def test_the_readme_quotes_the_page() -> None:
    quoted = page.quoted(README.read_text(encoding="utf-8"))
    assert quoted
    assert quoted in (FOLDER / "README.md").read_text(encoding="utf-8")


def test_a_readme_without_a_place_for_the_table_is_refused(tmp_path: Path) -> None:
    readme = tmp_path / "README.md"
    readme.write_text("nothing\n", encoding="utf-8")
    with pytest.raises(ValueError, match="no lines"):
        page.write([], tmp_path / "page", readme)
    assert not (tmp_path / "page").exists()
