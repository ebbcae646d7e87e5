"""The packaged FMUs as files: model description, contract, layout, exported symbols."""

from __future__ import annotations

import platform
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from .support.contract import (
    COMMANDS,
    CONTRACT,
    CONTROLLERS,
    DIRECT,
    EXPORTS,
    FMUS,
    MEASURED,
    MOMENT_RATES,
    PLANT,
    Variable,
)
from .support.harness import Fmu
from .support.paths import description, fmu_path
from .support.units import base_units

LIBRARY = {
    "Linux": "binaries/linux64/{}.so",
    "Darwin": f"binaries/{'aarch64-darwin' if platform.machine() == 'arm64' else 'darwin64'}/{{}}.dylib",
    "Windows": "binaries/win64/{}.dll",
}

# Functions of the system's mathematics library that are not exact. (sqrt, floor and the like are.)
MATHEMATICS = set(
    ["exp", "exp2", "expm1", "log", "log2", "log10", "log1p", "pow", "sin", "cos", "sincos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "cbrt", "hypot"]
)
PLANT_OUTPUTS = {row.name for row in CONTRACT[PLANT] if row.causality == "output"}

each_fmu = pytest.mark.parametrize("name", FMUS)
each_row = pytest.mark.parametrize(
    ("name", "row"), [pytest.param(name, row, id=f"{name}-{row.name}") for name in FMUS for row in CONTRACT[name]]
)


@each_fmu
def test_fmpy_finds_no_problem(name: str) -> None:
    assert validate_fmu(str(fmu_path(name))) == []


@each_fmu
def test_description_is_valid_against_the_schema_of_fmi_2(name: str) -> None:
    schema = Path(fmpy.__file__).parent / "schema" / "fmi2" / "fmi2ModelDescription.xsd"
    etree.XMLSchema(file=str(schema)).assertValid(description(name))


@each_row
def test_contract(name: str, row: Variable, fmus: dict[str, Fmu]) -> None:
    fmu = fmus[name]
    assert row.name in fmu.variables
    variable = fmu.variables[row.name]
    assert (variable.type, variable.causality) == (row.type, row.causality)
    if row.causality == "parameter":
        # Only controller gains may be tunable: the plant's state depends on its parameters.
        assert variable.variability in (("fixed",) if name == PLANT else ("fixed", "tunable"))
    else:
        assert variable.variability == ("continuous" if row.type == "Real" else "discrete")
    if row.causality != "output":
        assert variable.start is not None
    if row.start is not None:
        assert float(variable.start) == row.start  # shortest decimal: exactly the same double
    if row.items:
        assert tuple(item.name for item in variable.declaredType.items) == row.items
    assert variable.description


@pytest.mark.parametrize(
    ("name", "row"),
    [
        pytest.param(name, row, id=f"{name}-{row.name}")
        for name in FMUS
        for row in CONTRACT[name]
        if row.unit is not None and row.type == "Real"
    ],
)
def test_units(name: str, row: Variable, fmus: dict[str, Fmu]) -> None:
    fmu = fmus[name]
    variable = fmu.variables[row.name]
    unit = variable.unit or (variable.declaredType.unit if variable.declaredType else None)
    defined = {unit.name: unit for unit in fmu.description.unitDefinitions}
    if not row.unit and unit is None:
        return
    assert unit in defined
    base = defined[unit].baseUnit
    exponents = {
        key: getattr(base, key) for key in ("kg", "m", "s", "A", "K", "mol", "cd", "rad") if getattr(base, key)
    }
    expected = base_units(row.unit)
    if not row.unit.startswith("rad"):
        # A torque per angle may carry rad or not; an angle must.
        exponents.pop("rad", None)
        expected.pop("rad", None)
    assert exponents == expected
    assert (base.factor, base.offset) == (1.0, 0.0)
    if row.is_angle:
        assert unit == "rad"
        display = variable.displayUnit or variable.declaredType.displayUnit
        assert display == "deg"
        factor = {d.name: d.factor for d in defined["rad"].displayUnits}["deg"]
        assert factor == pytest.approx(57.29577951308232, rel=1e-15)


@each_fmu
def test_names_agree_and_capabilities_are_declared(name: str) -> None:
    root = description(name)
    interface = root.find("CoSimulation")
    assert root.get("fmiVersion") == "2.0"
    assert root.get("modelName") == name
    assert interface.get("modelIdentifier") == name
    assert root.get("variableNamingConvention") == "structured"
    for capability in (
        "canHandleVariableCommunicationStepSize",
        "canInterpolateInputs",
        "canGetAndSetFMUstate",
        "canSerializeFMUstate",
        "providesDirectionalDerivative",
    ):
        assert interface.get(capability) == "true", capability
    assert interface.get("maxOutputDerivativeOrder") == "1"
    for limit in ("needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess", "canRunAsynchronuously"):
        assert interface.get(limit, "false") == "false", limit
    # The design: plant and laws are differential equations, sensors and actuators with delays are none.
    assert (root.find("ModelExchange") is not None) == (name == PLANT or name in CONTROLLERS)
    # The design: default step size of every FMU 0.1 ms, because the PD loop is unstable above 0.27 ms.
    assert float(root.find("DefaultExperiment").get("stepSize")) == 1e-4
    assert root.findall("LogCategories/Category")


def test_guids_differ() -> None:
    assert len({description(name).get("guid") for name in FMUS}) == len(FMUS)


@each_fmu
def test_model_structure(name: str) -> None:
    """Outputs complete and in order; dependencies name inputs and states, and the inputs are those of the contract."""
    root = description(name)
    variables = root.findall("ModelVariables/ScalarVariable")
    names = [variable.get("name") for variable in variables]
    outputs = [index for index, v in enumerate(variables, start=1) if v.get("causality") == "output"]
    listed = root.findall("ModelStructure/Outputs/Unknown")
    assert [int(unknown.get("index")) for unknown in listed] == outputs
    initial = {int(unknown.get("index")) for unknown in root.findall("ModelStructure/InitialUnknowns/Unknown")}
    assert set(outputs) <= initial
    inputs = {v.get("name") for v in variables if v.get("causality") == "input"}
    states = {names[int(real.get("derivative")) - 1] for real in root.findall(".//Real[@derivative]")}
    for unknown in listed:
        output = names[int(unknown.get("index")) - 1]
        assert unknown.get("dependencies") is not None, f"{output} would depend on everything"
        dependencies = {names[int(index) - 1] for index in unknown.get("dependencies").split()}
        assert dependencies <= inputs | states
        dependencies &= inputs
        if name == PLANT and output in PLANT_OUTPUTS:
            assert dependencies == DIRECT[PLANT].get(output, set()), output
        elif output in DIRECT[name]:
            assert dependencies == DIRECT[name][output], output
        elif output in COMMANDS:
            assert dependencies, f"{output} is a direct function of the measurements"


def test_every_signal_a_controller_needs_has_one_name(fmus: dict[str, Fmu]) -> None:
    outputs = set(fmus[PLANT].names("output"))
    references = {"lambda1_ref", "theta1_ref"}
    for controller in CONTROLLERS:
        assert set(fmus[controller].names("input")) == set(MEASURED) | references | set(MOMENT_RATES)
        assert set(MEASURED) | set(MOMENT_RATES) <= outputs
        assert set(COMMANDS) <= set(fmus[controller].names("output"))
        assert not outputs & set(fmus[controller].names("output"))  # nothing ambiguous when wired by name


@each_fmu
def test_archive(name: str) -> None:
    path = fmu_path(name)
    assert path.stat().st_size < 2_000_000
    with zipfile.ZipFile(path) as archive:
        assert archive.testzip() is None
        entries = archive.namelist()
    assert len(set(entries)) == len(entries)
    for entry in entries:
        assert not entry.startswith(("./", "/")), entry
        assert "\\" not in entry, entry
        assert ".." not in entry.split("/"), entry
    assert "modelDescription.xml" in entries
    assert LIBRARY[platform.system()].format(name) in entries
    assert any(entry.startswith("documentation/") for entry in entries)


def symbols(name: str, kind: str, folder: Path) -> set[str]:
    """The dynamic symbols of an FMU's library: `defined` or `undefined` ones."""
    nm = shutil.which("nm")
    if platform.system() != "Linux" or nm is None:
        pytest.skip("needs nm and an ELF library")
    with zipfile.ZipFile(fmu_path(name)) as archive:
        library = archive.extract(LIBRARY["Linux"].format(name), folder)
    listing = subprocess.run([nm, "-D", f"--{kind}-only", library], capture_output=True, text=True, check=True).stdout
    return {line.split()[-1].partition("@")[0] for line in listing.splitlines()}


@each_fmu
def test_exported_symbols_are_those_of_fmi(name: str, tmp_path: Path) -> None:
    assert symbols(name, "defined", tmp_path) == EXPORTS


@each_fmu
def test_no_mathematics_of_the_system_is_used(name: str, tmp_path: Path) -> None:
    """Its exponentials, sines and the like differ in the last bit from machine to machine."""
    assert not symbols(name, "undefined", tmp_path) & MATHEMATICS
