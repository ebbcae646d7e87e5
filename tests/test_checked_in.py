"""The descriptions in /modelDescription are the packaged ones: a change of interface shows in review."""

from __future__ import annotations

import zipfile

import pytest

from .support.contract import FMUS
from .support.paths import ROOT, fmu_path


@pytest.mark.parametrize("name", FMUS)
def test_checked_in_description_is_current(name: str) -> None:
    with zipfile.ZipFile(fmu_path(name)) as archive:
        packaged = archive.read("modelDescription.xml")
    checked_in = ROOT / "modelDescription" / f"{name}.xml"
    assert checked_in.is_file(), f"modelDescription/{name}.xml is missing"
    assert checked_in.read_bytes() == packaged, f"modelDescription/{name}.xml is not current"


def test_nothing_else_is_checked_in_as_a_description() -> None:
    assert {path.stem for path in (ROOT / "modelDescription").glob("*.xml")} == set(FMUS)
