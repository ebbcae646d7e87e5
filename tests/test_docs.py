"""Files, folders and places in other documents that a document names exist."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from .support.paths import ROOT

#: Made by builds and runs; a clone does not have them.
MADE = ("dist/", "results/", "target/", "fuzz/artifacts")
#: In every FMU, or in the repository of another project.
NOT_OURS = {
    "documentation/externalDependencies.txt",
    "documentation/index.html",
    "binaries/",
    "resources/",
    "docs/fmu_import.md",
}
#: Endings of files that documents name in backticks.
ENDINGS = "rs|py|md|toml|csv|json|svg|png|xml|ssd|ssv|ssp|c|js|css|html|yml|ipynb|txt|cff"


def documents() -> list[Path]:
    """All Markdown files that git knows, or, without git, that lie in the tree."""
    listed = subprocess.run(["git", "ls-files", "*.md"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode == 0 and listed.stdout:
        return [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]
    return [path for path in ROOT.rglob("*.md") if "target" not in path.parts]


def everything() -> str:
    """All paths of the repository, each between slashes, so that a search finds whole ends of them."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    paths = listed.stdout.splitlines() if listed.returncode == 0 else []
    files = [ROOT / name for name in paths] or [path for path in ROOT.rglob("*") if "target" not in path.parts]
    folders = {parent for file in files for parent in file.relative_to(ROOT).parents}
    return "\n".join(f"/{path}/" for path in [*(file.relative_to(ROOT).as_posix() for file in files), *folders])


DOCUMENTS = documents()
EVERYTHING = everything()
#: Written for a crate that does not exist yet.
ELSEWHERE = {path for path in DOCUMENTS if {"template", "uplot"} & set(path.parts)}
each_document = pytest.mark.parametrize(
    "document", [path for path in DOCUMENTS if path not in ELSEWHERE], ids=lambda path: str(path.relative_to(ROOT))
)


def prose(document: Path) -> str:
    """The text without blocks of code."""
    return re.sub(r"^```.*?^```", "", document.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(document: Path) -> set[str]:
    """Places that a link can name, as forges make them from headings."""
    headings = re.findall(r"^#+ +(.+)$", prose(document), flags=re.MULTILINE)
    plain = (re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower() for heading in headings)
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in plain}


@each_document
def test_links_lead_somewhere(document: Path) -> None:
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", prose(document)):
        if re.match(r"[a-z]+:", link):
            continue
        name, _, place = link.partition("#")
        target = (document.parent / name).resolve() if name else document
        is_there = target.exists() or name.startswith(MADE)
        if not is_there or (place and target.suffix == ".md" and place not in anchors(target)):
            broken.append(link)
    assert broken == []


@each_document
def test_named_files_exist(document: Path) -> None:
    """Paths in backticks, from the root or from a folder that the text speaks of: the end of a path that there is.

    A bare name counts if it is one of source code; tables and reports are made by runs.
    """
    names = re.findall(rf"`([\w./-]+(?:\.(?:{ENDINGS})|/))`", prose(document))
    looked_for = [name for name in names if "/" in name or name.endswith((".rs", ".py"))]
    ours = [name for name in looked_for if not name.startswith((*MADE, "/")) and name not in NOT_OURS]
    assert [name for name in ours if f"/{name.removeprefix('./').rstrip('/')}/" not in EVERYTHING] == []
