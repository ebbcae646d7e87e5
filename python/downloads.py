"""What a release offers besides the FMUs: the tool with the FMUs as one archive, the Python wheel, notes, checksums.

    python downloads.py wheel --fmus dist --tool target/release/dualarm --platform linux64 --out FOLDER
    python downloads.py archive --fmus dist --tool target/release/dualarm --platform linux64 --out FOLDER
    python downloads.py glibc FOLDER
    python downloads.py tested RECORD FILE...
    python downloads.py notes FOLDER RECORD...
    python downloads.py checksums FOLDER

The wheel is made by hand, since nothing in it is compiled by Python's tools: a zip archive with a table of its files
(binary distribution format of the Python Packaging User Guide). The same files give the same bytes.
"""

from __future__ import annotations

import argparse
import base64
import hashlib
import re
import subprocess
import tempfile
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


#: What a platform's libraries and programs are run on where this machine is another one.
STAND_INS = {
    "linux64": "with the C library of Debian 11 (glibc 2.31)",
    "aarch64-linux": "under qemu",
    "win64": "under wine",
}

#: The glibc that libraries and programs for Linux are linked for.
OLDEST_GLIBC = (2, 17)


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


def programs(file: Path) -> dict[str, bytes]:
    """Libraries and programs by their names in an FMU, in an archive of the tool, or alone."""
    if file.suffix not in (".fmu", ".zip"):
        return {file.name: file.read_bytes()}
    with zipfile.ZipFile(file) as archive:
        names = [name for name in archive.namelist() if re.search(r"(^|/)binaries/|(^|/)dualarm(\.exe)?$", name)]
        return {name: archive.read(name) for name in names}


def released(folder: Path) -> Iterator[tuple[str, str, bytes]]:
    """What runs of a release: the platform, what it is, its bytes."""
    for fmu in sorted((folder / "fmus").glob("*.fmu")):
        for name, content in programs(fmu).items():
            yield name.split("/")[1], "library", content
    for packed in sorted(folder.glob("dualarm-*.zip")):
        platform = packed.stem.removeprefix(f"dualarm-{version()}-")
        for content in programs(packed).values():
            yield platform, "tool", content


def check_glibc(folder: Path) -> None:
    """Has `objdump` say which glibc the libraries and programs for Linux want, and holds the FMUs' own words to that."""
    oldest = ".".join(map(str, OLDEST_GLIBC))
    counted = 0
    for platform, what, content in released(folder):
        if not platform.endswith(("linux64", "-linux")):
            continue
        with tempfile.TemporaryDirectory() as place:
            file = Path(place) / "file"
            file.write_bytes(content)
            text = subprocess.run(["objdump", "-T", file], capture_output=True, text=True, check=True).stdout
        versions = {tuple(map(int, found.split("."))) for found in re.findall(r"GLIBC_([\d.]+)", text)}
        if not versions or max(versions) > OLDEST_GLIBC:
            newest = ".".join(map(str, max(versions, default=("?",))))
            raise SystemExit(f"a {what} for {platform} wants glibc {newest}, newer than {oldest}")
        counted += 1
    for fmu in sorted((folder / "fmus").glob("*.fmu")):
        with zipfile.ZipFile(fmu) as archive:
            text = archive.read("documentation/externalDependencies.txt").decode()
        for said in re.findall(r"glibc ([\d.]+) or newer", text):
            if tuple(map(int, said.split("."))) > OLDEST_GLIBC:
                raise SystemExit(f"{fmu.name} says that it needs glibc {said}")
    print(f"{counted} libraries and programs for Linux want glibc {oldest} or older")


def tested(record: Path, files: list[Path]) -> None:
    """Notes which libraries and programs of a platform, after which the record is named, have passed their tests."""
    of_platform = f"binaries/{record.stem}/"
    lines = {
        f"{hashlib.sha256(content).hexdigest()}  {Path(name).name}\n"
        for file in files
        for name, content in programs(file).items()
        if name == file.name or name.startswith(of_platform)
    }
    record.parent.mkdir(parents=True, exist_ok=True)
    record.write_text("".join(sorted(lines)), "utf-8", newline="\n")


def notes(folder: Path, records: list[Path]) -> None:
    """`NOTES.md`: what the changelog says of the newest version, and what was run of what is here."""
    _, _, rest = (ROOT / "CHANGELOG.md").read_text("utf-8").partition("\n## ")
    _, _, section = rest.split("\n## ")[0].partition("\n")
    passed = {
        (record.stem, line.split()[0]): "in its wheel" if record.parent.name == "wheel" else STAND_INS[record.stem]
        for record in records
        if record.is_file()
        for line in record.read_text("utf-8").splitlines()
    }
    kinds: dict[tuple[str, str], set[str]] = {}
    for platform, what, content in released(folder):
        how = passed.get((platform, hashlib.sha256(content).hexdigest()), "")
        kinds.setdefault((platform, what), set()).add(how)
    lines = [
        f"| `{platform}` | {'libraries in the FMUs' if what == 'library' else 'tool'} | "
        + ("built, run by nobody: **unverified**" if "" in ways else f"tested {' and '.join(sorted(ways))}")
        + " |\n"
        for (platform, what), ways in sorted(kinds.items())
    ]
    table = "| platform | what | |\n|:--|:--|:--|\n" + "".join(lines)
    needs = "What each library needs is in `documentation/externalDependencies.txt` of its FMU.\n"
    (folder / "NOTES.md").write_text(
        f"{section.strip()}\n\n### Platforms\n{table}\n{needs}", "utf-8", newline="\n"
    )
    print(folder / "NOTES.md")


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
    for name in ("glibc", "checksums"):
        commands.add_parser(name).add_argument("folder", type=Path)
    command = commands.add_parser("tested")
    command.add_argument("record", type=Path)
    command.add_argument("files", type=Path, nargs="+")
    command = commands.add_parser("notes")
    command.add_argument("folder", type=Path)
    command.add_argument("records", type=Path, nargs="*", help="what `tested` has written")
    options = vars(parser.parse_args())
    functions = {
        "wheel": wheel,
        "archive": archive,
        "glibc": check_glibc,
        "tested": tested,
        "notes": notes,
        "checksums": checksums,
    }
    functions[options.pop("command")](**options)


if __name__ == "__main__":
    main()
