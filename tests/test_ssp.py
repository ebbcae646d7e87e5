"""The systems in dist/*.ssp: valid, consistent with their FMUs, and run by everybody who reads SSP 1.0.

`dualarm simulate --coupling jacobi` is what the others are compared with; that it makes the right calls is tested by
`test_native.py`.
"""

from __future__ import annotations

import importlib.util
import io
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from lxml import etree

from .judges import different, read_table
from .support.harness import Fmu, Result
from .support.paths import DIST, ROOT
from .support.tool import dualarm

# Step in s that bears one step of delay: README's table.
STEPS = {"NABFC": 1e-4, "PDS": 1e-4, "PD": 5e-5}
CONTROLLERS = {"NABFC": "NabfcController", "PDS": "PdsController", "PD": "PdController"}
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
NAMESPACES = {
    kind: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for kind, name in {"ssc": "Common", "ssd": "Description", "ssv": "ParameterValues"}.items()
}


def ssp(title: str) -> Path:
    path = DIST / f"DualArmGrasp-{title}.ssp"
    if not path.is_file():
        pytest.fail(f"{path.name} is missing: run `cargo run --release -- package`", pytrace=False)
    return path


def texts(title: str) -> dict[str, bytes]:
    """The XML documents of a package."""
    with zipfile.ZipFile(ssp(title)) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith(".fmu")}


def structures(title: str) -> dict[str, Any]:
    """The root elements of all system structures of a package."""
    return {name: etree.fromstring(text) for name, text in texts(title).items() if name.endswith(".ssd")}


def find(node: Any, path: str) -> list[Any]:
    return node.findall(path, NAMESPACES)


def run(*arguments: str | Path) -> Result:
    """A run of `dualarm simulate` with a row for each step."""
    done = dualarm("simulate", *map(str, arguments), "--interval", "0", "-o", "-", "--quiet")
    assert done.returncode == 0, done.stderr
    return read_table(done.stdout)


@pytest.mark.parametrize("title", STEPS)
def test_documents_are_valid(title: str) -> None:
    """Against the normative schemas of SSP 1.0, as fmpy ships them."""
    schemas = {
        suffix: etree.XMLSchema(etree.parse(SCHEMAS / f"SystemStructure{name}.xsd"))
        for suffix, name in {".ssd": "Description", ".ssv": "ParameterValues"}.items()
    }
    documents = texts(title)
    assert {"SystemStructure.ssd", "Driven.ssd", "Preload.ssd"} <= set(documents)
    for name, text in documents.items():
        schema = schemas[Path(name).suffix]
        assert schema.validate(etree.fromstring(text)), f"{name}: {schema.error_log}"


@pytest.mark.parametrize("title", STEPS)
def test_archive_keeps_to_the_standard_and_to_what_is_checked_in(title: str) -> None:
    """SSP 1.0.1, section 3; and modelDescription/ shows what is packaged."""
    with zipfile.ZipFile(ssp(title)) as archive:
        for entry in archive.infolist():
            assert entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
            assert entry.extract_version <= 20
            assert entry.flag_bits == 0
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            at_root = entry.filename.endswith(".ssd")
            assert at_root or entry.filename.startswith("resources/")
        for name in archive.namelist():
            if name.endswith(".fmu"):
                assert archive.read(name) == (DIST / Path(name).name).read_bytes()
    folder = ROOT / "modelDescription" / f"DualArmGrasp-{title}"
    checked_in = {str(path.relative_to(folder).as_posix()): path for path in folder.rglob("*") if path.is_file()}
    packaged = texts(title)
    assert set(checked_in) == set(packaged)
    for name, text in packaged.items():
        assert checked_in[name].read_bytes() == text, f"{name} is not current: run `cargo xtask describe`"


@pytest.mark.parametrize("title", STEPS)
def test_connectors_and_connections_are_those_of_the_fmus(title: str, fmus: dict[str, Fmu]) -> None:
    """Every pair of equal names is connected, kinds, types and units are the variables', all units are defined."""
    models = {"plant": fmus["DualArmPlant"], "controller": fmus[CONTROLLERS[title]]}
    between = {"instruments": fmus["GraspInstruments"], "actuators": fmus["GraspActuators"]}
    inputs, outputs = ({c: set(m.names(k)) for c, m in models.items()} for k in ("input", "output"))
    wanted = {
        (source, name, target, name)
        for source, target in (("plant", "controller"), ("controller", "plant"))
        for name in outputs[source] & inputs[target]
    }
    assert len(wanted) == 17  # fourteen measured signals, three commands
    ends = ("startElement", "startConnector", "endElement", "endConnector")
    for file, structure in structures(title).items():
        units = {unit.get("name"): unit[0].attrib for unit in find(structure, "ssd:Units/ssc:Unit")}
        connections = [tuple(map(c.get, ends)) for c in find(structure, "ssd:System/ssd:Connections/ssd:Connection")]
        inner = [c for c in connections if None not in c]
        if file == "Instruments.ssd":
            # Each of them through what is between plant and controller: `test_instruments.py`.
            assert len(inner) == 2 * len(wanted), file
        else:
            assert sorted(inner) == sorted(wanted), file
        for component in find(structure, "ssd:System/ssd:Elements/ssd:Component"):
            model = (models | between)[component.get("name")]
            assert component.get("source") == f"resources/{model.path.name}"
            for connector in find(component, "ssd:Connectors/ssd:Connector"):
                variable = model.variables[connector.get("name")]
                assert connector.get("kind") == variable.causality
                assert etree.QName(connector[0]).localname == variable.type
                assert connector[0].get("unit") == variable.unit
                base = model.description.unitDefinitions
                exponents = next(unit.baseUnit for unit in base if unit.name == variable.unit)
                assert {k: int(v) for k, v in units[variable.unit].items()} == {
                    k: int(getattr(exponents, k))
                    for k in ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
                    if int(getattr(exponents, k) or 0)
                }
        outer = {c for c in connections if None in c}
        if file != "Driven.ssd":
            assert outer == set()  # Ecos and libcosim stop at connections of the system itself
        else:
            free = {(None, n, c, n) for c, other in (("plant", "controller"), ("controller", "plant"))
                    for n in inputs[c] - outputs[other]}  # fmt: skip
            forces = {("plant", f"contact_force{i}", None, f"contact_force{i}") for i in (1, 2)}
            assert outer == free | forces


@pytest.mark.parametrize("title", STEPS)
def test_drawing_is_readable(title: str) -> None:
    """Boxes apart, connectors on their edges and apart, connections straight and without a crossing."""
    for file, structure in structures(title).items():
        system = find(structure, "ssd:System")[0]
        boxes, points = {}, {}
        for component in find(system, "ssd:Elements/ssd:Component"):
            boxes[component.get("name")] = corners(find(component, "ssd:ElementGeometry")[0])
        canvas = find(system, "ssd:SystemGeometry")
        boxes[None] = corners(canvas[0]) if canvas else np.array([[0, 0], [240, 170]])
        (a1, a2), (b1, b2) = boxes["controller"], boxes["plant"]
        assert a2[0] + 50 < b1[0], "room for the connections"
        for element in [system, *find(system, "ssd:Elements/ssd:Component")]:
            name = None if element is system else element.get("name")
            low, high = boxes[name]
            for connector in find(element, "ssd:Connectors/ssd:Connector"):
                geometry = find(connector, "ssd:ConnectorGeometry")[0]
                place = np.array([float(geometry.get("x")), float(geometry.get("y"))])
                assert np.any((place == 0) | (place == 1)), f"{file}: {connector.get('name')} is not on an edge"
                points[name, connector.get("name")] = low + place * (high - low)
        own = [(name, tuple(np.round(point, 9))) for (name, _), point in points.items()]
        assert len(set(own)) == len(own), f"{file}: two connectors at one place"
        lines = []
        for connection in find(system, "ssd:Connections/ssd:Connection"):
            start = points[connection.get("startElement"), connection.get("startConnector")]
            end = points[connection.get("endElement"), connection.get("endConnector")]
            assert np.min(np.abs(end - start)) < 1e-9, f"{file}: not straight"
            assert np.max(np.abs(end - start)) > 20, f"{file}: too short to see"
            lines.append((np.minimum(start, end), np.maximum(start, end)))
        for i, (low, high) in enumerate(lines):
            for other_low, other_high in lines[:i]:
                apart = np.any((high + 5 < other_low) | (other_high + 5 < low))
                assert apart, f"{file}: connections meet"


def corners(geometry: Any) -> np.ndarray:
    return np.array([[float(geometry.get(f"{axis}{i}")) for axis in "xy"] for i in (1, 2)])


@pytest.mark.parametrize("coupling", ["gauss-seidel", "jacobi"])
@pytest.mark.parametrize("title", STEPS)
def test_native_run_is_that_of_the_fmus(title: str, coupling: str) -> None:
    """Explicit connections and parameters of the package give what equal names and start values give: no tolerance."""
    times = ("--coupling", coupling, "--stop", "0.1")
    plain = run(DIST / "DualArmPlant.fmu", DIST / f"{CONTROLLERS[title]}.fmu", *times, "--step", repr(STEPS[title]))
    packaged = run(ssp(title), *times)
    assert len(packaged.time) == round(0.1 / STEPS[title]) + 1, "the step comes from the package"
    assert set(packaged.signals) == set(plain.signals)
    assert different(packaged, plain) == []


@pytest.mark.parametrize(
    ("title", "variant", "scenario"),
    [
        ("NABFC", "Preload", "preload"),
        ("NABFC", "Fast", "nabfc-r-fast"),
        ("NABFC", "Certified", "nabfc-r-certified"),
        ("NABFC", "Paper", "nabfc"),
        ("NABFC", "Driven", "nabfc-r"),
        ("PDS", "Tuned", "pds-tuned"),
        ("PD", "Tuned", "pd-tuned"),
        ("PD", "Integral", "pid"),
    ],
)
def test_variants_are_the_scenarios(title: str, variant: str, scenario: str) -> None:
    times = ("--stop", "0.05", "--step", "1e-4")
    packaged = run(f"{ssp(title)}#{variant}.ssd", *times)
    assert different(packaged, run(scenario, *times)) == []
    if variant != "Driven":
        assert different(packaged, run({"NABFC": "nabfc-r"}.get(title, title.lower()), *times)) != []


def test_driven_variant_takes_references_and_disturbances() -> None:
    """Half the force is wanted; a push on the object is felt by both arms with opposite signs."""
    driven = f"{ssp('NABFC')}#Driven.ssd"
    half = run(driven, "--stop", "1", "--step", "1e-3", "--set", "lambda1_ref=-0.25")
    assert half["contact_force1"][-1] == pytest.approx(0.25, rel=0.02)
    pushed, calm = (run(driven, "--stop", "0.02", "--set", f"delta_F={push}") for push in (0.1, 0))
    change = [pushed[f"contact_force{i}"][-1] - calm[f"contact_force{i}"][-1] for i in (1, 2)]
    assert change[0] * change[1] < 0
    assert min(map(abs, change)) > 1e-4


def judge(engine: str, title: str, *parameter_set: str, steps: int = 1000) -> Result:
    """The same package in a tool that reads it itself."""
    done = subprocess.run(
        [sys.executable, "-m", "tests.judges.ssp", engine, str(ssp(title)), repr(STEPS[title]), str(steps)]
        + list(parameter_set),
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return read_table(done.stdout[done.stdout.index("time,") :])


def native(title: str, steps: int = 1000) -> Result:
    """One step of delay between the FMUs."""
    return run(ssp(title), "--coupling", "jacobi", "--stop", repr(steps * STEPS[title]))


@pytest.mark.parametrize("parameter_set", [(), ("paper",)], ids=["start_values", "paper_set"])
@pytest.mark.parametrize("title", STEPS)
def test_ecos_runs_it_with_the_same_bits(title: str, parameter_set: tuple[str, ...]) -> None:
    loading = [sys.executable, "-c", "from tests.judges.ecos import load; load()"]
    if subprocess.run(loading, cwd=ROOT, capture_output=True, check=False).returncode != 0:
        pytest.skip("Ecos cannot be loaded: not checked that it runs the .ssp files")
    theirs, ours = judge("ecos", title, *parameter_set), native(title)
    assert np.ptp(ours["contact_force1"]) > 0.01
    assert [name for name in theirs.signals if not np.array_equal(theirs[name], ours[name])] == []


@pytest.mark.skipif(
    importlib.util.find_spec("libcosimpy") is None,
    reason="libcosimpy has no wheel for this platform: not checked that libcosim runs the .ssp files",
)
@pytest.mark.parametrize("title", STEPS)
def test_libcosim_runs_it(title: str) -> None:
    """It takes the step from the annotation; signals without feedthrough are equal up to its rounding of the time."""
    theirs, ours = judge("libcosim", title), native(title)
    for name in ("theta1", "tip_shear1"):
        assert np.max(np.abs(theirs[name] - ours[name][1:])) < 1e-10 * np.max(np.abs(ours[name])), name


def test_fmpy_reaches_the_wanted_force() -> None:
    """Fmpy ignores parameter bindings, sets every input with a connector (at first to zero) and delays by one step."""
    result = simulate_ssp(str(ssp("NABFC")), stop_time=1.0, step_size=1e-3)
    for i in (1, 2):
        force = result[f"plant.contact_force{i}"]
        settled = force[result["time"] > 0.5]
        assert np.all(np.abs(settled - 0.5) < 0.02 * 0.5)


@pytest.mark.parametrize("title", STEPS)
def test_fmpy_differs_by_its_first_step_only(title: str) -> None:
    """Zeros instead of the initial signals for one step; after that the same Jacobi exchange, so the difference is what
    that one wrong step did, and small beside the motion. An unstable exchange would blow it up.
    """
    theirs = simulate_ssp(str(ssp(title)), stop_time=0.1, step_size=STEPS[title])
    ours = native(title, steps=len(theirs))
    for name in ("theta1", "theta2"):
        motion = np.ptp(ours[name])
        assert motion > 1e-3
        assert np.max(np.abs(theirs[f"plant.{name}"] - ours[name][1:])) < 0.02 * motion, name


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((f"{DIST / 'DualArmGrasp-PD.ssp'}#Fast.ssd",), "no Fast.ssd"),
        ((str(DIST / "DualArmGrasp-PD.ssp"), str(DIST / "PdController.fmu")), "runs alone"),
        ((str(DIST / "DualArmGrasp-PD.ssp"), "--set", "controller.kpp=1"), "controller.kp"),
        ((str(DIST / "DualArmGrasp-PD.ssp"), "--controller", "pds"), "--controller"),
        (("no-such.ssp",), "no-such.ssp"),
    ],
)
def test_wrong_use_is_one_clear_error(arguments: tuple[str, ...], named: str) -> None:
    done = dualarm("simulate", *arguments)
    assert done.returncode in (1, 2)
    assert done.stderr.count("error:") == 1
    assert named in done.stderr
    assert "panicked" not in done.stderr


def test_package_without_an_fmu_names_it(tmp_path: Path) -> None:
    """The line of the component, the file it wants, and the closest there is."""
    broken = tmp_path / "broken.ssp"
    packed = io.BytesIO()
    with zipfile.ZipFile(ssp("PD")) as whole, zipfile.ZipFile(packed, "w") as rest:
        for name in whole.namelist():
            if name != "resources/PdController.fmu":
                rest.writestr(name, whole.read(name))
    broken.write_bytes(packed.getvalue())
    done = dualarm("simulate", str(broken))
    assert done.returncode == 1
    assert "broken.ssp, SystemStructure.ssd: line" in done.stderr
    assert "no file resources/PdController.fmu" in done.stderr
