"""Builds the program of `judges/rust-fmi`, which runs plant and controller with the `fmi` crate of rust-fmi.

Its dependency fmi-sys generates bindings from the C headers of FMI, for which it needs libclang (here PyPI's, which
brings no headers of its own: those of the C compiler serve).
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


class UnavailableError(Exception):
    """Something that building the judge needs is not here."""


@cache
def program() -> Path:
    """The judge, built if need be (minutes at first, below a second when nothing has changed)."""
    crate = ROOT / "judges" / "rust-fmi"
    target = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "judges"
    command = ["cargo", "build", "--locked", "--quiet", "--manifest-path", str(crate / "Cargo.toml")]
    environment = os.environ | libclang() | {"CARGO_TARGET_DIR": str(target)}
    if shutil.which("cargo") is None:
        raise UnavailableError("cargo is not installed")
    subprocess.run(command, cwd=crate, env=environment, check=True, timeout=1800)
    return target / "debug" / ("rust-fmi-judge.exe" if platform.system() == "Windows" else "rust-fmi-judge")


def libclang() -> dict[str, str]:
    """What bindgen has to know of PyPI's libclang; nothing if the user has set it up."""
    if "LIBCLANG_PATH" in os.environ:
        return {}
    package = importlib.util.find_spec("clang")
    if package is None or not package.origin:
        raise UnavailableError("libclang is not installed (`pip install libclang`)")
    variables = {"LIBCLANG_PATH": str(Path(package.origin).parent / "native")}
    compiler = shutil.which("gcc")
    if compiler and "BINDGEN_EXTRA_CLANG_ARGS" not in os.environ:
        asked = subprocess.run([compiler, "-print-file-name=include"], capture_output=True, text=True, check=True)
        variables["BINDGEN_EXTRA_CLANG_ARGS"] = f"-I{asked.stdout.strip()}"
    return variables
