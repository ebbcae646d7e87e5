"""Which description a library belongs to is decided when it is packaged, not by what the host's processor computes."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from fmpy import read_model_description

from .support.paths import DIST

FMUS = sorted(DIST.glob("*.fmu"))

# Instances under each rounding mode of x86-64 and of 64-bit ARM; a process of its own, since the first instance counts.
PROGRAM = """
import ctypes, ctypes.util, platform, sys
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

libm = ctypes.CDLL(ctypes.util.find_library("m"))
upward = {"x86_64": 0x800, "aarch64": 0x400000}[platform.machine()]
folder = extract(sys.argv[1])
description = read_model_description(folder)
starts = [v for v in description.modelVariables if v.type == "Real" and v.start is not None]
declared = [float(v.start) for v in starts]
assert libm.fesetround(upward) == 0
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder,
                modelIdentifier=description.coSimulation.modelIdentifier, instanceName="rounded")
fmu.instantiate()
fmu.setupExperiment()
fmu.enterInitializationMode()
libm.fesetround(0)
found = fmu.getReal([v.valueReference for v in starts])
differ = [v.name for v, a, b in zip(starts, declared, found) if a != b]
assert not differ, f"start values are not those of the description: {differ}"
fmu.freeInstance()
"""


@pytest.mark.parametrize("fmu", FMUS, ids=lambda path: path.stem)
@pytest.mark.skipif(sys.platform != "linux", reason="the numbers of the rounding modes are those of Linux")
def test_rounding_mode_of_the_host_does_not_matter(fmu: Path) -> None:
    """Neither to who it is nor to its start values: those are constants of the build, to the bit what the XML says."""
    done = subprocess.run([sys.executable, "-c", PROGRAM, str(fmu)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("fmu", FMUS, ids=lambda path: path.stem)
def test_every_library_has_its_guid_compiled_in(fmu: Path) -> None:
    guid = read_model_description(str(fmu)).guid
    with zipfile.ZipFile(fmu) as archive:
        libraries = [name for name in archive.namelist() if name.startswith("binaries/")]
        assert libraries
        assert [name for name in libraries if guid.encode() not in archive.read(name)] == []


@pytest.mark.parametrize("fmu", FMUS, ids=lambda path: path.stem)
def test_licences_of_linked_crates_are_in_the_archive(fmu: Path) -> None:
    with zipfile.ZipFile(fmu) as archive:
        text = archive.read("documentation/licenses/linked-crates.txt").decode()
    assert "\nserde 1." in text
    # This one is under BSD-3-Clause: whoever passes the binary on has to pass its text on.
    assert "\nsha1_smol 1." in text
    assert "Redistributions in binary form must reproduce the above" in text
    # Needed for packaging, not by the library.
    assert "pulldown" not in text
    assert "\nzip " not in text
