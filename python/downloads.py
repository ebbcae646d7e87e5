"""What a release offers besides the FMUs: the tool with the FMUs as one archive, the Python wheel, checksums.

    python downloads.py wheel --fmus dist --tool target/release/dualarm --platform linux64 --out FOLDER
    python downloads.py archive --fmus dist --tool target/release/dualarm --platform linux64 --out FOLDER
    python downloads.py checksums FOLDER

The wheel is made by hand, since nothing in it is compiled by Python's tools: a zip archive with a table of its files
(binary distribution format of the Python Packaging User Guide). The same files give the same bytes.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path(__file__).resolve().parent / "dualarm"

#: Where programs of a platform run, as wheels say it. `linux64` is with the glibc that the tool was linked for.
TAGS = {
    "linux64": "manylinux_2_{glibc}_x86_64",
    "aarch64-linux": "manylinux_2_{glibc}_aarch64",
    "win64": "win_amd64",
    "darwin64": "macosx_10_12_x86_64",
    "aarch64-darwin": "macosx_11_0_arm64",
}


def version() -> str:
    """The version that all crates have."""
    (found,) = re.findall(r'\[workspace\.package\]\nversion = "([^"]+)"', (ROOT / "Cargo.toml").read_text("utf-8"))
    return found


def shipped(fmus: Path, tool: Path) -> Iterator[tuple[str, bytes]]:
    """The tool and what it looks for beside itself."""
    yield "dualarm.exe" if tool.suffix == ".exe" else "dualarm", tool.read_bytes()
    files = sorted([*fmus.glob("*.fmu"), *fmus.glob("*.ssp")])
    if not files:
        raise SystemExit(f"there are no FMUs in {fmus}: run `cargo run --release -- package`")
    for file in files:
        yield f"fmus/{file.name}", file.read_bytes()


def write(path: Path, files: list[tuple[str, bytes]]) -> None:
    """A zip archive without times. Programs are executable; what is compressed already is stored."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in files:
            entry = zipfile.ZipInfo(name)
            program = Path(name).name in ("dualarm", "dualarm.exe")
            entry.external_attr = (0o100755 if program else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_STORED if name.endswith((".fmu", ".ssp")) else zipfile.ZIP_DEFLATED
            archive.writestr(entry, content)
    print(path)


def glibc(tool: Path) -> int:
    """The newest version 2.x of glibc that an ELF file asks for."""
    return max((int(minor) for minor in re.findall(rb"GLIBC_2\.(\d+)", tool.read_bytes())), default=17)


def wheel(fmus: Path, tool: Path, platform: str, out: Path) -> Path:
    """The wheel `dualarm` for a platform."""
    tag = TAGS[platform].format(glibc=max(glibc(tool), 17))
    files = [
        (f"dualarm/{file.name}", file.read_text("utf-8").replace("@VERSION@", version()).encode())
        for file in sorted(PACKAGE.glob("*.py"))
    ]
    files += [(f"dualarm/bin/{name}", content) for name, content in shipped(fmus, tool)]
    info = f"dualarm-{version()}.dist-info"
    readme = (PACKAGE.parent / "README.md").read_text("utf-8")
    files += [
        (
            f"{info}/METADATA",
            "Metadata-Version: 2.1\nName: dualarm\n"
            f"Version: {version()}\n"
            "Summary: FMI 2.0 FMUs of the grasp of two flexible arms, and the tool that runs them\n"
            "License: MIT\nRequires-Python: >=3.9\nDescription-Content-Type: text/markdown\n\n"
            f"{readme}".encode(),
        ),
        (
            f"{info}/WHEEL",
            f"Wheel-Version: 1.0\nGenerator: dualarm\nRoot-Is-Purelib: false\nTag: py3-none-{tag}\n".encode(),
        ),
        (f"{info}/entry_points.txt", b"[console_scripts]\ndualarm = dualarm:main\n"),
        (f"{info}/licenses/LICENSE", (ROOT / "LICENSE").read_bytes()),
    ]
    table = "".join(f"{name},sha256={digest(content)},{len(content)}\n" for name, content in files)
    files.append((f"{info}/RECORD", f"{table}{info}/RECORD,,\n".encode()))
    path = out / f"dualarm-{version()}-py3-none-{tag}.whl"
    write(path, files)
    return path


def digest(content: bytes) -> str:
    """A hash as the table of a wheel has it."""
    return base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()


def archive(fmus: Path, tool: Path, platform: str, out: Path) -> Path:
    """The tool with the FMUs beside it, to be unpacked and started."""
    name = f"dualarm-{version()}-{platform}"
    files = [*shipped(fmus, tool), ("LICENSE", (ROOT / "LICENSE").read_bytes())]
    path = out / f"{name}.zip"
    write(path, [(f"{name}/{inside}", content) for inside, content in files])
    return path


def checksums(folder: Path) -> None:
    """`SHA256SUMS`, which `sha256sum --check` reads."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != "SHA256SUMS")
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(folder).as_posix()}\n" for path in files
    ]
    (folder / "SHA256SUMS").write_text("".join(lines), "utf-8", newline="\n")
    print(folder / "SHA256SUMS")


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description="What a release offers besides the FMUs.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ("wheel", "archive"):
        command = commands.add_parser(name)
        command.add_argument("--fmus", type=Path, required=True, help="folder of .fmu and .ssp files")
        command.add_argument("--tool", type=Path, required=True, help="the program dualarm for the platform")
        command.add_argument("--platform", choices=TAGS, required=True)
        command.add_argument("--out", type=Path, required=True)
    commands.add_parser("checksums").add_argument("folder", type=Path)
    options = vars(parser.parse_args())
    {"wheel": wheel, "archive": archive, "checksums": checksums}[options.pop("command")](**options)


if __name__ == "__main__":
    main()
