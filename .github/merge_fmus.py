"""Puts the libraries of several platforms into one FMU each, and the merged FMUs into the SSPs that hold them.

    python merge_fmus.py FOLDER... --out FOLDER

Every folder holds the same .fmu and .ssp files, built on another platform. The first folder gives everything but the
libraries. A description that differs between platforms is an error: then a library would not belong to it.
"""

from __future__ import annotations

import argparse
import io
import sys
import zipfile
from pathlib import Path

DESCRIPTION = "modelDescription.xml"
LIBRARIES = "binaries/"
RESOURCES = "resources/"


class MergeError(Exception):
    """Files that do not fit together."""


def merged(files: list[Path]) -> bytes:
    """One FMU with the libraries of all of them."""
    archives = [zipfile.ZipFile(file) for file in files]
    first = archives[0]
    result = io.BytesIO()
    with zipfile.ZipFile(result, "w") as target:
        for entry in first.infolist():
            target.writestr(entry, first.read(entry), zipfile.ZIP_DEFLATED)
        taken = set(first.namelist())
        for file, archive in zip(files[1:], archives[1:]):
            if archive.read(DESCRIPTION) != first.read(DESCRIPTION):
                raise MergeError(f"{file} and {files[0]} have different descriptions: build both from the same sources")
            new = [entry for entry in archive.infolist() if entry.filename.startswith(LIBRARIES)]
            for entry in new:
                if entry.filename in taken:
                    raise MergeError(f"{file} and {files[0]} both have {entry.filename}")
                taken.add(entry.filename)
                target.writestr(entry, archive.read(entry), zipfile.ZIP_DEFLATED)
    for archive in archives:
        archive.close()
    return result.getvalue()


def with_fmus(system: Path, fmus: dict[str, bytes]) -> bytes:
    """An SSP whose FMUs are replaced by those of the same name."""
    result = io.BytesIO()
    with zipfile.ZipFile(system) as source, zipfile.ZipFile(result, "w") as target:
        for entry in source.infolist():
            content = source.read(entry)
            if entry.filename.startswith(RESOURCES):
                content = fmus.get(entry.filename[len(RESOURCES) :], content)
            target.writestr(entry, content, zipfile.ZIP_DEFLATED)
    return result.getvalue()


def merge(folders: list[Path], out: Path) -> None:
    """Writes all merged files to `out`; none if something does not fit."""
    names = [{path.name for path in folder.glob("*.fmu")} for folder in folders]
    if not names[0] or any(other != names[0] for other in names):
        raise MergeError("the folders do not hold the same .fmu files: " + "; ".join(str(sorted(n)) for n in names))
    fmus = {name: merged([folder / name for folder in folders]) for name in sorted(names[0])}
    systems = {path.name: with_fmus(path, fmus) for path in sorted(folders[0].glob("*.ssp"))}
    out.mkdir(parents=True, exist_ok=True)
    for name, content in {**fmus, **systems}.items():
        (out / name).write_bytes(content)
        print(out / name)


def main() -> int:
    """The command line."""
    parser = argparse.ArgumentParser(description="Puts the libraries of several platforms into one FMU each.")
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    options = parser.parse_args()
    try:
        merge(options.folders, options.out)
    except (MergeError, OSError, zipfile.BadZipFile) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
