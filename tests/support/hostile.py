"""The slave of `dualarm/tests/fixtures/hostile.c` as an FMU: it does to its process what HOSTILE says."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from .paths import ROOT

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Hostile" guid="hostile">
  <CoSimulation modelIdentifier="Hostile" canHandleVariableCommunicationStepSize="true"/>
  <DefaultExperiment stopTime="1" stepSize="0.1"/>
  <ModelVariables>
    <ScalarVariable name="y" valueReference="0" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="u" valueReference="2" causality="input"><Real start="0"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def hostile(folder: Path) -> Path:
    """The FMU, made in a folder with the system's compiler; skips where there is none."""
    compiler = shutil.which("cc")
    if compiler is None or sys.platform != "linux":
        pytest.skip("needs a C compiler named cc and Linux")
    library = folder / "Hostile.so"
    source = ROOT / "dualarm" / "tests" / "fixtures" / "hostile.c"
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", library, source, "-lm", "-ldl"], check=True)
    fmu = folder / "Hostile.fmu"
    with zipfile.ZipFile(fmu, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION)
        archive.write(library, "binaries/linux64/Hostile.so")
    return fmu
