"""Renews the tables of docs/contact.md: python -m tests.studies.contact

Runs every controller in every case of scenarios/contact with the FMUs in dist/ (half a minute of processor time) and puts what
`dualarm compare` writes between the page's markers. To be repeated when a law, its default gains or the plant have changed.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

from ..support.paths import ROOT
from ..support.tool import dualarm

PAGE = ROOT / "docs" / "contact.md"
MARKED = re.compile(r"(<!-- contact[^>]*-->\n).*?(<!-- end of contact -->)", re.DOTALL)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        done = dualarm("compare", "--cases", "contact", "--no-package", "--quiet", "--out", folder)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        written = (Path(folder) / "matrix.md").read_text(encoding="utf-8")
    # What the first table means is said in docs/comparison.md.
    tables = written[written.index("| case") :]
    PAGE.write_text(MARKED.sub(lambda match: match[1] + tables + match[2], PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
