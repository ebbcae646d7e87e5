"""The matrix of controllers and cases: what docs/comparison.md and the README show of it, and what it has to show."""

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from .support.paths import ROOT
from .support.tool import dualarm

CONTACT = (ROOT / "docs" / "contact.md").read_text(encoding="utf-8")
PAGE = (ROOT / "docs" / "comparison.md").read_text(encoding="utf-8")

Cell = dict[str, Any]


@pytest.fixture(scope="module")
def compared(comparison: Path) -> dict[str, list[Cell]]:
    """Every cell of both matrices, row by row, as the tool writes it."""
    document = json.loads((comparison / "printed.json").read_text(encoding="utf-8"))
    for name in ("matrix", "contact"):
        assert json.loads((comparison / f"{name}.json").read_text(encoding="utf-8")) == document[name]
    return {name: document[name] for name in ("matrix", "contact")}


@pytest.fixture(scope="module")
def matrix(compared: dict[str, list[Cell]]) -> list[Cell]:
    return compared["matrix"]


@pytest.fixture(scope="module")
def contact(compared: dict[str, list[Cell]]) -> list[Cell]:
    return compared["contact"]


def rows(cells: list[Cell]) -> dict[str, dict[str, Cell]]:
    table: dict[str, dict[str, Cell]] = {}
    for cell in cells:
        table.setdefault(cell["case"], {})[cell["controller"]] = cell
    return table


def published() -> list[list[str]]:
    text = PAGE.split("<!-- matrix")[1].split("<!-- end")[0]
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def test_every_published_cell_is_what_the_tool_finds(matrix: list[Cell]) -> None:
    """Numbers are printed with two digits of a second, whole percent, tenths of a millinewton. They may be off by half of the
    last one, and by 2 % on another processor: its exponentials differ in the last bits, and a force that runs along the edge
    of its band crosses it a little earlier or later."""
    table = rows(matrix)
    shown = published()
    assert len(shown) == len(table)
    for line, cells in zip(shown, table.values()):
        assert len(line) == len(cells) + 2
        for text, cell in zip(line[1:-1], cells.values()):
            merit = cell["merit"]
            where = f"{cell['case']}, {cell['controller']}: {text}"
            first, _, second = text.partition(" (")
            if cell["judged"] == "error":
                assert close(number(first), 1e3 * merit["error_rms"], 0.05), where
            elif merit["settling"] is None:
                assert first == "never" and close(number(second), 1e3 * merit["error_rms"], 0.05), where
            else:
                assert close(number(first), merit["settling"], 0.005), where
                overshoot = number(second) if second else 0.0
                assert close(overshoot, merit["overshoot"], 0.5 if second else 2.0), where
        if line[-1] != "–":
            cell = next(iter(cells.values()))
            for text, limit in zip(line[-1].split(" / "), (cell["limit"], cell["own_limit"]), strict=True):
                assert close(number(text), limit, 0.005)


def number(text: str) -> float:
    match = re.search(r"[0-9.]+", text)
    assert match, text
    return float(match.group())


def close(one: float, other: float, half_digit: float) -> bool:
    return abs(one - other) <= half_digit + 0.02 * abs(other)


def test_led_from_a_small_preload_no_controller_loses_the_object(contact: list[Cell]) -> None:
    """What docs/contact.md says of references that rise within 0.1 s: whatever the gains, no tip leaves the object."""
    led = rows(contact)["led"]
    assert len(led) == 10
    for cell in led.values():
        assert (cell["impacts"], cell["merit"]["grip"]["lost"], cell["merit"]["grip"]["held_from"]) == (0, 0.0, 0.0), cell
        assert cell["merit"]["grip"]["peak"] < 0.52, cell


def test_rigid_faces_chatter_and_soft_ones_do_not(contact: list[Cell]) -> None:
    table = rows(contact)
    for controller, cell in table["gap"].items():
        soft = table["soft-object"][controller]
        assert cell["impacts"] > 20 > soft["impacts"] >= 2
        assert cell["merit"]["grip"]["held_from"] > 0.03
    assert all(cell["merit"]["grip"]["drops"] >= 1 for cell in table["jerk"].values())


def test_the_page_of_contacts_has_every_cell(contact: list[Cell]) -> None:
    text = CONTACT.split("<!-- contact")[1].split("<!-- end")[0]
    table = rows(contact)
    for part in text.split("\n\n**"):
        lines = [line for line in part.splitlines() if line.startswith("|")]
        assert len(lines) == 2 + len(table), part[:80]


def test_the_limit_is_one(matrix: list[Cell]) -> None:
    """No controller that keeps contact and overshoots by no more than 2 % is faster than the actuators allow. All start
    without contact force, so a little tension at the start is nobody's fault: the paper's PDS pulls with 0.05 N at most."""
    for cell in matrix:
        merit = cell["merit"]
        if merit["settling"] is not None and merit["overshoot"] <= 2.0 and merit["tension"] < 0.05:
            assert merit["settling"] >= cell["limit"], cell


def test_limits_follow_from_the_actuators(matrix: list[Cell]) -> None:
    """2 (√1.02 − √0.02) √(M d/F), F = 0.3 N + 1.02 · 0.5 N, for an object of 10 kg that has to move by 1.12 mm."""
    way = abs(0.2 * math.radians(3) - 0.2**3 * 0.5 / (3 * 0.115))
    share = 2 * (math.sqrt(1.02) - math.sqrt(0.02))
    cell = rows(matrix)["heavy-10"]["pd"]
    assert math.isclose(cell["limit"], share * math.sqrt(10 * way / 0.81), rel_tol=1e-9)
    # Alone, and with both tips of 0.1 kg.
    assert math.isclose(cell["own_limit"], share * math.sqrt(10.2 * way / 0.3), rel_tol=1e-9)


def test_one_cell_is_what_simulate_finds(matrix: list[Cell]) -> None:
    """The command that the page gives for a cell gives the cell's numbers."""
    case = ROOT / "scenarios" / "matrix" / "hub-torque.toml"
    done = dualarm("simulate", str(case), "--controller", "pid", "--json")
    assert done.returncode == 0, done.stderr
    metrics = json.loads(done.stdout)["metrics"]
    merit = rows(matrix)["hub-torque"]["pid"]["merit"]
    forces = [metrics["contact_force1"], metrics["contact_force2"]]
    # Both start without force, so 2 % of the target are 2 % of the travel.
    assert math.isclose(max(force["settling_2"] for force in forces), merit["settling_forces"], rel_tol=1e-9)
    assert math.isclose(max(force["overshoot"] for force in forces), merit["overshoot"], rel_tol=1e-9)


TUNE = ("tune", "--controller", "pd-tuned", "--cases", "undisturbed", "--parameter", "kp1+kp2=20..200")


def test_a_search_does_not_depend_on_workers_and_goes_on_after_an_interruption(tmp_path: Path) -> None:
    def search(name: str, *options: str) -> tuple[str, str]:
        out = tmp_path / f"{name}.toml"
        done = dualarm(*TUNE, "--parameter", "kv1+kv2=0.5..10", "--out", str(out), "--quiet", *options)
        assert done.returncode == 0, done.stderr
        return out.read_text(encoding="utf-8"), out.with_suffix(".jsonl").read_text(encoding="utf-8")

    whole = search("a", "--evaluations", "24", "--workers", "1")
    assert search("b", "--evaluations", "24", "--workers", "3") == whole
    search("c", "--evaluations", "9")
    # As if it had been killed while it wrote a line.
    state = tmp_path / "c.jsonl"
    state.write_text(state.read_text(encoding="utf-8")[:-7], encoding="utf-8")
    assert search("c", "--evaluations", "24") == whole
    other = dualarm(*TUNE, "--out", str(tmp_path / "c.toml"), "--evaluations", "3")
    assert (other.returncode, "belongs to another search: its parameters differs" in other.stderr) == (1, True), other.stderr


def test_what_a_search_finds_is_better_than_its_start_and_can_be_compared(tmp_path: Path) -> None:
    out = tmp_path / "found.toml"
    done = dualarm(*TUNE, "--goal", "undisturbed=0.1/2", "--set", "ki=0", "--set", "kp1=50", "--out", str(out), "--evaluations", "20", "--json")
    assert done.returncode == 0, done.stderr
    assert "--goal undisturbed=0.1/2" in out.read_text(encoding="utf-8")
    document = json.loads(done.stdout)
    assert document["cases"][0]["goal"] == 0.1
    first = json.loads((tmp_path / "found.jsonl").read_text(encoding="utf-8").splitlines()[1])
    assert document["cost"] <= float(first["cost"])
    done = dualarm("compare", "--no-package", "--controllers", str(out), "--cases", "undisturbed", "--json", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    (cell,) = json.loads(done.stdout)["matrix"]
    assert cell["merit"] == document["cases"][0]["merit"]
    parameters = {parameter["name"]: parameter["value"] for parameter in document["parameters"]}
    assert parameters["kp1"] == parameters["kp2"]
    # What was set and stays is part of the preset, as a number; what was set and varied is not.
    gains = tomllib.loads(out.read_text(encoding="utf-8"))["parameters"]
    assert gains["ki"] == 0.0 and gains["kp1"] == parameters["kp1"]
    written = out.with_suffix(".ssv").read_text(encoding="utf-8")
    assert written.count('name="kp1"') == written.count('name="ki"') == 1


def evaluated_once(controller: str, folder: Path, *options: str) -> tuple[Cell, dict[str, float]]:
    """The case *undisturbed* with the gains at which a search begins, and those that vary."""
    words = ("--cases", "undisturbed", "--evaluations", "1", "--out", str(folder / "once.toml"), "--json")
    done = dualarm("tune", "-c", controller, *words, "--state", str(folder / f"{len(list(folder.iterdir()))}.jsonl"), *options)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    return document["cases"][0], {parameter["name"]: parameter["value"] for parameter in document["parameters"]}


@pytest.mark.parametrize("controller", ["nabfc-fast", "nabfc-r-fast", "nabfc-r-certified", "pds-tuned", "pd-tuned", "pid"])
def test_a_search_begins_at_the_gains_of_the_named_controller(controller: str, tmp_path: Path) -> None:
    """The preset is a set of gains inside the FMU, which the search cannot vary: it must begin at the same values."""
    case, varied = evaluated_once(controller, tmp_path)
    done = dualarm("compare", "--no-package", "--controllers", controller, "--cases", "undisturbed", "--json", "--out", str(tmp_path))
    (cell,) = json.loads(done.stdout)["matrix"]
    # The search gives gains four digits; those of nabfc-r-certified have more.
    assert case["merit"]["settling"] == pytest.approx(cell["merit"]["settling"], rel=2e-3)
    assert case["merit"]["peak_torque"] == pytest.approx(cell["merit"]["peak_torque"], rel=2e-3)
    assert controller != "pid" or {"kp", "kv", "ki", "kp1", "kv1", "ki1", "ki2"} <= varied.keys()
    gains = tomllib.loads((tmp_path / "once.toml").read_text(encoding="utf-8"))["parameters"]
    assert "preset" not in gains, "it would leave the gains unused"


def test_ranges_are_around_the_gains_of_the_preset(tmp_path: Path) -> None:
    shipped = ROOT / "scenarios" / "tuned" / "pid.toml"
    by_name, by_file = evaluated_once("pid", tmp_path), evaluated_once(str(shipped), tmp_path)
    assert by_name == by_file
    gains = tomllib.loads(shipped.read_text(encoding="utf-8"))["parameters"]
    assert by_file[1] == pytest.approx(gains, rel=1e-12)
    _, varied = evaluated_once(str(shipped), tmp_path, "--parameter", "ki")
    assert varied == {"ki": gains["ki"]}
    # What is set to zero stays there.
    _, varied = evaluated_once("pid", tmp_path, "--set", "ki=0")
    assert "ki" not in varied and "ki1" in varied


def test_presets_of_one_controller_are_told_apart_and_run_in_any_scenario(tmp_path: Path) -> None:
    text = (ROOT / "scenarios" / "tuned" / "pid.toml").read_text(encoding="utf-8")
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text(text.replace('title = "PID"', 'title = "PID with gains from a search"'), encoding="utf-8")
    second.write_text(first.read_text(encoding="utf-8").replace("ki = 14980.0", "ki = 0.0"), encoding="utf-8")
    words = ("--cases", "hub-torque", "--out", str(tmp_path), "--json")
    done = dualarm("compare", "--no-package", "--controllers", f"{first},{second}", *words)
    assert done.returncode == 0, done.stderr
    header = (tmp_path / "matrix.md").read_text(encoding="utf-8")
    assert "| PID (first) | PID (second) |" in header

    def finals(*words: str) -> dict[str, float]:
        done = dualarm("simulate", *words, "--stop", "0.3", "--step", "1e-3", "--json")
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)["final"]

    # The file has the gains of the preset, which are those of the name; in the paper's case, and in another one.
    assert finals("-c", str(first)) == finals("-c", "pid")
    assert finals("friction", "-c", str(first)) == finals("friction", "-c", "pid") != finals("friction", "-c", str(second))
    # Its settings are the controller's, as in `compare`: the plant keeps its own stiffness.
    first.write_text(first.read_text(encoding="utf-8") + "EI1 = 0.2\n", encoding="utf-8")
    assert finals("-c", str(first)) == finals("-c", "pid", "--set", "PdController.EI1=0.2")
    done = dualarm("simulate", "-c", str(tmp_path / "none.toml"))
    assert (done.returncode, "cannot read" in done.stderr) == (1, True), done.stderr


def test_a_search_writes_what_other_commands_take(tmp_path: Path) -> None:
    """`--controllers` takes .toml: a search of an hour must not end in a file that it refuses."""
    done = dualarm("tune", "--controller", "pd", "--out", str(tmp_path / "gains"))
    assert done.returncode == 2 and "its name must end in .toml" in done.stderr, done.stderr
    assert not list(tmp_path.iterdir())


def test_misspelt_names_are_answered(tmp_path: Path) -> None:
    for arguments, text in (
        (("compare", "--no-package", "--cases", "heavy5"), "did you mean heavy-5"),
        (("compare", "--no-package", "--controllers", "pdd"), "did you mean pd"),
        (("tune", "--controller", "pd", "--parameter", "kpp1=1..2"), "did you mean kp1"),
        (("tune", "--controller", "pd", "--parameter", "kp1=2..1"), "the range is empty"),
        (("tune", "--controller", "pd", "--parameter", "ki"), "it begins at 0, which has no ratios, so it needs a range"),
        (("tune", "--controller", "pd", "--goal", "nois=0.01"), "did you mean noise"),
        (("tune", "--controller", "pd", "--goal", "noise"), "write CASE=VALUE"),
        (("tune", "--controller", "pd", "--goal", "noise=-1"), "a positive number is needed"),
        (("tune", "--controller", "pd", "--goal", "noise=1,noise=2"), "another goal already"),
    ):
        done = dualarm(*arguments, "--out", str(tmp_path / "none"))
        assert (done.returncode, text in done.stderr) == (2, True), done.stderr
