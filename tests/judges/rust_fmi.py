"""Builds the program of `tests/judges/rust-fmi`, which runs plant and controller with the `fmi` crate of rust-fmi.

Its dependency fmi-sys generates bindings from the C headers of FMI, for which it needs libclang (here PyPI's, which
brings no headers of its own: those of the C compiler serve).
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
from pathlib import Path

from ..support.paths import ROOT, TARGET

BUILD = TARGET / "judges"


class UnavailableError(Exception):
    """Something that building the judge needs is not here."""


def program() -> Path:
    """The judge, which `cargo xtask test` has built before the tests."""
    name = "rust-fmi-judge.exe" if platform.system() == "Windows" else "rust-fmi-judge"
    path = BUILD / "debug" / name
    libclang()
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not built: `cargo xtask test --python` does it")
    return path


def build() -> None:
    """Builds the judge if need be: minutes at first, below a second when nothing has changed."""
    crate = ROOT / "tests" / "judges" / "rust-fmi"
    command = ["cargo", "build", "--locked", "--manifest-path", str(crate / "Cargo.toml")]
    environment = os.environ | libclang() | {"CARGO_TARGET_DIR": str(BUILD)}
    subprocess.run(command, cwd=crate, env=environment, check=True)


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


if __name__ == "__main__":
    try:
        build()
    except UnavailableError as reason:
        print(f"the judge of rust-fmi is not built, {reason}: what it judges is not checked")
