"""The documentation inside each FMU: complete, true of the model description, self-contained, and repeatable."""

from __future__ import annotations

import csv
import re
import shlex
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from lxml import etree

from .support.contract import CONTROLLERS, FMUS, PLANT
from .support.harness import CoSimulation, Fmu
from .support.paths import ROOT, description, fmu_path

XHTML = "{http://www.w3.org/1999/xhtml}"
INDEX = "documentation/index.html"
# What makes a browser fetch something, besides <a href>, which a person has to click.
LOADING = ("script", "link", "iframe", "object", "embed", "video", "audio", "source", "base")

each_fmu = pytest.mark.parametrize("name", FMUS)


def files(name: str) -> dict[str, bytes]:
    """The archive's files by path."""
    with zipfile.ZipFile(fmu_path(name)) as archive:
        return {entry: archive.read(entry) for entry in archive.namelist()}


def page(name: str) -> etree._Element:
    """The page as a strict XML parser reads it: it is well-formed, and nothing in a text has become markup."""
    return etree.fromstring(files(name)[INDEX])


def text(element: etree._Element) -> str:
    """All text in an element, blanks folded."""
    return " ".join("".join(element.itertext()).split())


@each_fmu
def test_files_are_where_the_standard_wants_them(name: str) -> None:
    """FMI 2.0.4, section 2.3: the icon, the entry points of the documentation and of the licences."""
    content = files(name)
    assert content["model.png"].startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", content["model.png"][16:24])
    assert 100 <= width <= 512
    assert 100 <= height <= 512
    assert content["documentation/licenses/license.txt"] == (ROOT / "LICENSE").read_bytes()
    assert content[INDEX].lower().startswith(b"<!doctype html>")
    # NABFC, the largest, holds two laws behind two interfaces: 0.63 MB with the library for linux64.
    assert fmu_path(name).stat().st_size < 680_000


@each_fmu
def test_every_variable_stands_in_the_table_as_in_the_xml(name: str) -> None:
    rows = {text(row.find("th")): row for row in page(name).iterfind(".//table[@class='variables']/tbody/tr")}
    variables = description(name).findall("ModelVariables/ScalarVariable")
    types = description(name).iterfind("TypeDefinitions/SimpleType")
    items = {kind.get("name"): kind.findall("Enumeration/Item") for kind in types}
    assert set(rows) == {variable.get("name") for variable in variables}
    for variable in variables:
        row, kind = rows[variable.get("name")], variable[0]
        cells = {cell.get("class"): text(cell) for cell in row.iterfind("td")}
        assert cells["description"].startswith(" ".join(variable.get("description").split()))
        if kind.tag == "Real":
            assert cells["unit"] == kind.get("unit", "1")
        else:
            assert cells["unit"] == kind.get("declaredType", kind.tag)
        bounds = [float(kind.get(bound)) for bound in ("min", "max") if kind.get(bound) is not None]
        if kind.tag == "Enumeration":
            bounds = [1, len(items[kind.get("declaredType")])]
        shown = re.findall(r"[-+.\de]+", cells.get("range", ""))
        assert [float(bound) for bound in shown] == bounds  # exactly the same doubles
        start = row.find("td[@class='start']/code")
        if kind.get("start") is None:
            assert start is None
        elif kind.tag == "Real":
            assert float(start.text) == float(kind.get("start"))
        else:
            assert start.text == kind.get("start")
        heading = text(row.getparent().getparent().getprevious().getprevious())
        assert variable.get("causality") in heading.lower()
        assert ("Tunable" in heading) == (variable.get("variability") == "tunable")


@each_fmu
def test_direct_dependencies_are_those_of_the_model_structure(name: str) -> None:
    root = description(name)
    variables = root.findall("ModelVariables/ScalarVariable")
    names = [variable.get("name") for variable in variables]
    inputs = {variable.get("name") for variable in variables if variable.get("causality") == "input"}
    rows = {text(row.find("th")): row for row in page(name).iterfind(".//table[@class='variables']/tbody/tr")}
    for unknown in root.findall("ModelStructure/Outputs/Unknown"):
        shown = rows[names[int(unknown.get("index")) - 1]].find("td/span[@class='direct']/code")
        expected = {names[int(index) - 1] for index in unknown.get("dependencies").split()} & inputs
        assert (set() if shown is None else set(shown.text.split(", "))) == expected


@each_fmu
def test_page_tells_what_the_fmu_is(name: str) -> None:
    root, html = description(name), page(name)
    assert text(html.find(".//h1")) == name
    everything = text(html.find("body"))
    for attribute in ("description", "version", "license", "generationTool", "guid"):
        assert root.get(attribute) in everything, attribute
    assert f"communication step {root.find('DefaultExperiment').get('stepSize')} s" in everything
    for item in root.iterfind("TypeDefinitions/SimpleType/Enumeration/Item"):
        rows = {text(row[1]): row for row in html.iterfind(".//table[@class='items']/tbody/tr")}
        value, _, meaning = map(text, rows[item.get("name")])
        assert (value, meaning) == (item.get("value"), item.get("description"))
    units = {text(row[0]) for row in html.iterfind(".//table[@class='units']/tbody/tr")}
    assert units == {unit.get("name") for unit in root.iterfind("UnitDefinitions/Unit")}
    links = {anchor.get("href")[1:] for anchor in html.iterfind(".//nav//a")}
    assert links
    assert links <= {element.get("id") for element in html.iter() if element.get("id")}


@pytest.mark.parametrize("name", CONTROLLERS)
def test_page_names_the_longest_stable_steps_of_the_readme(name: str) -> None:
    """The README's are measured by `test_steps.py`."""
    table = (ROOT / "README.md").read_text(encoding="utf-8").split("<!-- steps")[1].split("<!-- end")[0]
    row = next(row for row in table.splitlines() if row.startswith(f"| {name.removesuffix('Controller').upper()} |"))
    said = text(page(name).find("body"))
    for step in re.findall(r"(more than [\d.]+ ms|[\d.]+ ms)", row):
        assert step in said


@each_fmu
def test_equations_are_rendered(name: str) -> None:
    html = page(name)
    formulas = [element for element in html.iter() if etree.QName(element).localname == "math"]
    assert sum(formula.get("display") == "block" for formula in formulas) >= 2
    assert not [element for element in html.iter() if etree.QName(element).localname == "merror"]
    for paragraph in html.iterfind(".//p"):
        assert "$" not in text(paragraph)
        assert "\\" not in text(paragraph)


@each_fmu
def test_page_needs_nothing_from_outside(name: str) -> None:
    content, html = files(name), page(name)
    for element in html.iter():
        assert etree.QName(element).localname not in LOADING
        assert not [attribute for attribute in element.attrib if attribute.startswith("on")]
        source = element.get("src")
        if source is not None:
            assert str(Path("documentation", source)).replace("documentation/../", "") in content
        target = element.get("href")
        if target is not None:
            assert element.tag == "a"
            assert target.startswith(("#", "https://")) or f"documentation/{target}" in content
    style = html.find("head/style").text
    assert "url(" not in style
    assert "@import" not in style


@each_fmu
def test_no_link_is_dead(name: str) -> None:
    """On every page of the archive: a place of the page, a file beside it, or an address."""
    content = files(name)
    pages = [path for path in content if path.endswith(".html")]
    assert INDEX in pages
    if name in [PLANT, *CONTROLLERS]:
        assert "documentation/errata.html" in pages
    for path in pages:
        html = etree.fromstring(content[path])
        places = {element.get("id") for element in html.iter() if element.get("id")}
        for anchor in html.iter("a"):
            file, _, place = anchor.get("href").partition("#")
            assert file.startswith("https://") or not file or f"documentation/{file}" in content, (path, file)
            assert file or place in places, (path, place)


def table(path: Path) -> dict[str, list[float]]:
    """The columns of a CSV file."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: [float(row[i]) for row in rows] for i, name in enumerate(header)}


@each_fmu
def test_the_command_on_the_page_repeats_the_figure(name: str, tmp_path: Path) -> None:
    """The packaging program ran the model natively; FMPy runs the FMU through the C interface."""
    with zipfile.ZipFile(shutil.copy(fmu_path(name), tmp_path)) as archive:
        archive.extractall(tmp_path)
    command = page(name).find(".//pre[@class='command']/code").text
    words = shlex.split(command)
    assert words[:3] == ["fmpy", "simulate", f"{name}.fmu"]
    assert words[-1] == "--show-plot"
    arguments = [*words[1:-1], "--output-file", "repeated.csv"]
    subprocess.run([sys.executable, "-m", "fmpy", *arguments], cwd=tmp_path, check=True, capture_output=True)
    shown, repeated = table(tmp_path / "documentation/response.csv"), table(tmp_path / "repeated.csv")
    assert set(shown) == set(repeated)
    for column, values in shown.items():
        size = max(map(abs, values))
        # FMPy interpolates inputs from a file at times that differ by some units in the last place.
        assert repeated[column] == pytest.approx(values, rel=0, abs=1e-12 * max(size, 1e-3)), column


@each_fmu
def test_figure_shows_the_results(name: str, tmp_path: Path) -> None:
    """Each curve of the page has a point for each row of the CSV, between the same extremes."""
    with zipfile.ZipFile(fmu_path(name)) as archive:
        tables = [path for path in archive.namelist() if re.fullmatch(r"documentation/response(_beside)?\.csv", path)]
        archive.extractall(tmp_path, tables)
    columns = {key: values for path in tables for key, values in table(tmp_path / path).items()}
    times = columns.pop("time")
    panels = page(name).findall(".//div[@class='panels']/div")
    shown = set()
    for panel in panels:
        names = [text(entry) for entry in panel.iterfind("p/span")]
        curves = [path.get("d") for path in panel.iterfind("svg/path") if path.get("class").startswith("curve")]
        assert len(names) == len(curves)
        shown |= set(names)
        for variable, curve in zip(names, curves):
            points = [tuple(map(float, point.split())) for point in re.split("[ML]", curve)[1:]]
            assert len(points) == len(times)
            heights, values = [-point[1] for point in points], columns[variable]
            span = max(values) - min(values)
            if span > 1e-6:
                # Straight and upright: the place on the drawing is a linear, rising function of the value. Places are
                # rounded to a tenth of 190 px.
                scale = (max(heights) - min(heights)) / span
                for height, value in zip(heights, values):
                    assert height - min(heights) == pytest.approx(scale * (value - min(values)), abs=0.2)
    assert shown == set(columns)


def test_plant_settles_at_the_static_grasp(tmp_path: Path) -> None:
    """At rest a hub's torque is the moment of the contact force, tau = f l, and the tip deflects by f l^3/(3 EI)."""
    with zipfile.ZipFile(fmu_path(PLANT)) as archive:
        archive.extract("documentation/response.csv", tmp_path)
    results = table(tmp_path / "documentation/response.csv")
    # The slowest pole of the vibration, -11.8 1/s, leaves 0.3 % after 0.5 s.
    for arm in (1, 2):
        assert results[f"contact_force{arm}"][-1] == pytest.approx(0.1 / 0.2, rel=0.01)
        assert abs(results[f"tip_deflection{arm}"][-1]) == pytest.approx(0.5 * 0.2**3 / (3 * 0.115), rel=0.01)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_the_figure_of_a_controller_is_the_grasp(name: str, tmp_path: Path) -> None:
    """The packaging program closed the loop natively, with the controller first; here the two FMUs do it."""
    with zipfile.ZipFile(fmu_path(name)) as archive:
        archive.extractall(tmp_path, ["documentation/response.csv", "documentation/response_beside.csv"])
    commands, forces = (table(tmp_path / f"documentation/response{part}.csv") for part in ("", "_beside"))
    times = forces["time"]
    # PD and PDS are unstable with steps of 2 ms; their rows are every twentieth of 0.1 ms.
    step = 1e-3 if name == "NabfcController" else 1e-4
    every = round((times[1] - times[0]) / step)
    shown = [*forces, *commands]
    shown = [column for column in shown if column != "time"]
    with CoSimulation([Fmu(fmu_path(name)), Fmu(fmu_path(PLANT))]) as grasp:
        found = grasp.run(stop=times[-1], step=step, record=shown, every=every)
    assert found.time == pytest.approx(times, abs=1e-9)
    for column in ("contact_force1", "contact_force2"):
        # The same equations in the same order, compiled twice.
        assert found[column] == pytest.approx(forces[column], rel=0, abs=1e-9), column
    if name == "NabfcController":
        # A state: what depends on inputs at once is shown with those of the step before, as FMPy records it.
        assert found["m_hat"][1:] == pytest.approx(commands["m_hat"][1:], rel=0, abs=1e-9)
    # In the end both tips press with 0.5 N. PD, which takes four seconds, is only on its way there.
    for arm in (1, 2):
        force = forces[f"contact_force{arm}"][-1]
        assert 0.25 < force < 0.5 if name == "PdController" else force == pytest.approx(0.5, rel=0.05)
