"""Where things are: the repository, the packaged FMUs, what cargo has built."""

from __future__ import annotations

import os
import zipfile
from pathlib import Path

import pytest
from lxml import etree

ROOT = Path(__file__).resolve().parents[2]
DIST = ROOT / "dist"
TARGET = ROOT / os.environ.get("CARGO_TARGET_DIR", "target")


def helper(name: str) -> Path:
    """A file that `cargo xtask test` builds before the Python tests, or a failure that says how to build it."""
    path = TARGET / "helpers" / name
    if not path.exists():
        pytest.fail(f"{path} does not exist: run `cargo xtask test --python`", pytrace=False)
    return path


def fmu_path(name: str) -> Path:
    """The packaged FMU, or a failure that says how to make it."""
    path = DIST / f"{name}.fmu"
    if not path.is_file():
        pytest.fail(f"dist/{name}.fmu does not exist: run `cargo run --release -- package`", pytrace=False)
    return path


def description(name: str) -> etree._Element:
    """The root of a packaged modelDescription.xml."""
    with zipfile.ZipFile(fmu_path(name)) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))
