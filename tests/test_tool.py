"""The command line tool as its users meet it: scenarios, files that others read, FMUs that others made."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from pythonfmu.builder import FmuBuilder

from .support.paths import ROOT
from .support.tool import dualarm


# --- Files for others ------------------------------------------------------------------------------------------------


def test_parquet_and_csv_say_the_same(tmp_path: Path) -> None:
    """Every value bit by bit, types and units."""
    both = [tmp_path / "run.csv", tmp_path / "run.parquet"]
    for file in both:
        done = dualarm("simulate", "preload", "--stop", "0.1", "-o", str(file))
        assert done.returncode == 0, done.stderr
    with both[0].open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    table = pq.read_table(both[1])
    assert table.column_names == header
    assert table.num_rows == len(rows) == 101
    assert [row[0] for row in rows[:4]] == ["0", "0.001", "0.002", "0.003"]
    for name, values in zip(header, zip(*rows)):
        assert np.array_equal(table[name].to_numpy().astype(float), np.array(values, dtype=float)), name
    assert str(table.schema.field("in_contact").type) == "bool"
    units = json.loads(table.schema.metadata[b"units"])
    assert {name: units[name] for name in ("time", "theta1", "tau1", "energy")} == {
        "time": "s",
        "theta1": "rad",
        "tau1": "N.m",
        "energy": "J",
    }
    assert "in_contact" not in units


def test_no_time_has_digits_that_only_rounding_puts_there(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    assert dualarm("simulate", "--stop", "1", "--interval", "0", "-o", str(file)).returncode == 0
    with file.open(encoding="utf-8") as lines:
        next(lines)
        rows = [line.rstrip("\n").split(",") for line in lines]
    assert max(len(row[0]) for row in rows) <= len("0.0001")
    assert not any(value == "-0" for row in rows for value in row)


def test_an_input_among_parameters_is_refused_wherever_a_scenario_is_read(tmp_path: Path) -> None:
    file = tmp_path / "wrong.toml"
    head = 'title = "wrong"\nfmus = ["DualArmPlant.fmu", "PdController.fmu"]\n[experiment]\nstop = 0.01\n'
    file.write_text(head + "[parameters]\ndelta_f1 = 0.1\n", encoding="utf-8")
    study = tmp_path / "study.toml"
    head = 'title = "s"\nsystem = "wrong.toml"\ncontrollers = ["pd"]\nmethod = "grid"\n'
    study.write_text(head + "[vary]\nEI1 = [0.1, 0.2]\n", encoding="utf-8")
    for command in (
        ["simulate", str(file)],
        ["compare", "--no-package", "--cases", str(file), "--out", str(tmp_path / "results")],
        ["sweep", str(study)],
    ):
        done = dualarm(*command)
        assert done.returncode == 2, (command, done.stderr)
        assert f"{file}:6: delta_f1 is an input: it belongs under [inputs]" in done.stderr


def test_pure_numbers_have_no_unit_in_sentences() -> None:
    """Their unit is 1, which tables say and sentences do not."""
    for value, reason in (("30", "NabfcController.r_brake must be from 0 to 20, not 30"), ("much", 'r_brake needs a number, not "much"')):
        done = dualarm("simulate", "nabfc-fast", "--set", f"r_brake={value}")
        assert (done.returncode, reason in done.stderr) == (2, True), done.stderr
    assert "needs a number in rad/s" in dualarm("simulate", "nabfc-fast", "--set", "r_observer=much").stderr


# --- Any FMU ---------------------------------------------------------------------------------------------------------


def test_gains_beside_a_preset_are_said_to_be_unused() -> None:
    done = dualarm("simulate", "nabfc-fast", "--stop", "0.1", "--set", "c1=3", "--set", "M=0.4", "--json")
    unused = [warning for warning in json.loads(done.stdout)["warnings"] if "is not used" in warning]
    assert len(unused) == 1
    assert "NabfcController.c1" in unused[0]


def first_column(*fmus: str) -> list[str]:
    """The names in the metrics' tables of a run of these FMUs."""
    done = dualarm("simulate", *(str(ROOT / "dist" / f"{name}.fmu") for name in fmus), "--stop", "0.1")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    return [lines[at + 2].split()[0] for at, line in enumerate(lines) if line.startswith("controller")]


def test_tables_name_what_drives_the_motors() -> None:
    """In whatever order the FMUs come."""
    for fmus in (("DualArmPlant", "PdsController"), ("PdsController", "DualArmPlant")):
        assert first_column(*fmus) == ["PdsController"] * 2


def test_a_plant_without_target_says_why_it_has_no_metrics() -> None:
    plant = str(ROOT / "dist" / "DualArmPlant.fmu")
    done = dualarm("simulate", plant, "--stop", "0.1")
    assert "No metrics: no single FMU has the output lambda2_d (the force in N" in done.stdout
    document = json.loads(dualarm("simulate", plant, "--stop", "0.1", "--json").stdout)
    assert document["metrics"] is None
    assert "lambda2_d" in document["metrics_obstacle"]
    document = json.loads(dualarm("simulate", "nabfc", "--stop", "0.1", "--json").stdout)
    assert document["metrics_obstacle"] is None


def test_actuators_that_stay_at_their_limits_are_warned_about() -> None:
    """PD is unstable beyond steps of 0.26 ms: then both motors go from limit to limit, which the plant says once."""

    def saturated(*options: str) -> list[str]:
        done = dualarm("simulate", "pd", "--json", *options)
        warnings = json.loads(done.stdout)["warnings"]
        return [line for line in warnings if "The loop may be unstable" in line]

    (said,) = saturated("--step", "1e-3")
    assert said.startswith("DualArmPlant: at t = ")
    assert "tau1" in said
    assert saturated("--step", "1e-4") == []


def test_a_scenario_is_printed_and_runs_as_it_was_printed(tmp_path: Path) -> None:
    """`dualarm scenario`: the file, and on standard error where it is; a copy of it is a scenario of one's own."""
    done = dualarm("scenario", "preload")
    file = ROOT / "scenarios" / "preload.toml"
    assert done.stdout == file.read_text(encoding="utf-8")
    assert str(file) in done.stderr
    elsewhere = dualarm("scenario", "preload", cwd=tmp_path)
    assert "scenarios/preload.toml of the repository" in elsewhere.stderr
    mine = tmp_path / "mine.toml"
    mine.write_text(done.stdout, encoding="utf-8")
    runs = [json.loads(dualarm("simulate", what, "--json").stdout)["metrics"] for what in ("preload", str(mine))]
    assert runs[0] == runs[1]
    names = dualarm("scenario").stdout.split()
    assert {"nabfc", "matrix/delay-5"} <= set(names)
    wrong = dualarm("scenario", "matrix/dealy-5")
    assert wrong.returncode == 2
    assert "did you mean matrix/delay-5" in wrong.stderr


def test_several_scenarios_at_once_are_explained() -> None:
    done = dualarm("simulate", "nabfc", "pds")
    assert done.returncode == 2
    assert "nabfc is a scenario; one runs at a time" in done.stderr
    assert "dualarm report" in done.stderr


def test_a_word_that_is_no_name_leads_to_the_variable_it_describes() -> None:
    for word in ("mass", "Mass"):
        done = dualarm("simulate", "--set", f"{word}=1")
        assert done.returncode == 2
        # "Mass of the object" comes before "Point mass at the tip of arm 1".
        assert re.search(r"did you mean M, .*\bm1\b", done.stderr), done.stderr


def test_a_unit_that_no_fmu_defines_is_said_to_be_unknown() -> None:
    done = dualarm("simulate", "--set", "M=500g")
    assert 'M needs a number in kg (the FMU defines no unit "g"), not "500g"' in done.stderr


def test_a_table_of_something_else_is_no_result_of_a_run(tmp_path: Path) -> None:
    """Rows of a study by their texts, a table of numbers with a warning that says which column counts as time."""
    study = tmp_path / "study.toml"
    study.write_text(
        'title = "x"\nsystem = "pd-tuned"\nmethod = "grid"\n[experiment]\nstop = 0.1\n[vary]\nM = [0.3, 0.4]\n', encoding="utf-8"
    )
    for name in ("rows.csv", "rows.parquet"):
        rows = tmp_path / name
        assert dualarm("sweep", str(study), "-o", str(rows)).returncode == 0
        refused = dualarm("report", str(rows), "-o", str(tmp_path / "rows.html"))
        assert refused.returncode == 2
        assert f'{name}: no column is called time, and the column "status" holds texts' in refused.stderr
    (tmp_path / "numbers.csv").write_text("M,u\n0.1,1\n0.2,2\n", encoding="utf-8")
    done = dualarm("report", str(tmp_path / "numbers.csv"))
    assert done.returncode == 0
    assert 'no column is called time; the first one of numbers, "M", is taken for the times in s' in done.stderr


@pytest.mark.parametrize("kind", [pa.uint8(), pa.uint16(), pa.uint32(), pa.uint64()])
def test_whole_numbers_without_a_sign_are_numbers(tmp_path: Path, kind: pa.DataType) -> None:
    pq.write_table(pa.table({"time": pa.array([0, 100, 200], kind), "x": [1.0, 2.0, 3.0]}), tmp_path / "a.parquet")
    done = dualarm("report", str(tmp_path / "a.parquet"), "-o", str(tmp_path / "a.html"))
    assert (done.returncode, done.stderr) == (0, "")


def test_info_tells_what_is_in_an_ssp() -> None:
    file = str(ROOT / "dist" / "DualArmGrasp-PD.ssp")
    document = json.loads(dualarm("info", file, "--json").stdout)
    assert {component["model"] for component in document["components"]} == {"DualArmPlant", "PdController"}
    links = {(link["from"].split(".")[1], link["to"].split(".")[1]) for link in document["connections"]}
    assert ("tau1_cmd", "tau1_cmd") in links
    assert any(name.endswith(".delta_F") for name in document["open_inputs"])
    assert document["default_experiment"]["step"] == 5e-5
    text = dualarm("info", file).stdout
    assert all(heading in text for heading in ("Components", "Connections", "Inputs that nothing leads to"))


def test_without_a_repository_nothing_is_built_and_the_remedy_is_said(tmp_path: Path) -> None:
    """Never from where the tool was once compiled: that may be another version, or gone."""
    done = dualarm("package", cwd=tmp_path)
    assert done.returncode == 1
    assert "not around this folder" in done.stderr
    assert "--no-package" in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", [("simulate", "pds"), ("compare", "--no-package", "--no-matrix"), ("verify", "--help")])
def test_tables_fit_a_terminal_of_80_columns(command: tuple[str, ...], tmp_path: Path) -> None:
    option = ["--out", str(tmp_path)] if command[0] == "compare" else []
    lines = dualarm(*command, *option).stdout.splitlines()
    tables = [line for line in lines if not line.endswith("s") or "─" in line]
    assert max(map(len, tables)) <= 80, max(lines, key=len)


@pytest.mark.parametrize("shell", ["bash", "fish", "zsh", "powershell", "elvish"])
def test_completions_know_the_scenarios(shell: str) -> None:
    script = dualarm("completions", shell).stdout
    # Of `simulate` and of `scenario`; zsh has one list for both.
    assert script.count("change-of-reference") >= (1 if shell == "zsh" else 2)
    assert "raw-dead-zone" in script
    if shell == "zsh":
        assert script.count(":_dualarm_scenarios'") == 2


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_understand_their_completions(shell: str, tmp_path: Path) -> None:
    program = shutil.which(shell)
    if program is None:
        pytest.skip(f"{shell} is not installed")
    script = tmp_path / "dualarm"
    script.write_text(dualarm("completions", shell).stdout, encoding="utf-8")
    subprocess.run([program, "-n", script], check=True)
    if shell == "fish":
        line = f"source {script}; complete --do-complete 'dualarm simulate fri'"
        assert "friction" in subprocess.run([program, "-c", line], check=True, capture_output=True, text=True).stdout


def test_a_summary_lists_every_wire_within_80_columns() -> None:
    said = dualarm("simulate", "nabfc", "--stop", "0.01").stdout
    for name in ("tip_shear2_dot", "root_moment2_dot", "delta_F", "NabfcController.theta1_ref"):
        assert name in said
    assert max(map(len, said.splitlines())) <= 80


def test_a_page_of_a_search(tmp_path: Path) -> None:
    page, preset = tmp_path / "page.html", tmp_path / "preset.toml"
    # All gains it has, as nothing names some.
    options = ["--evaluations", "8", "--cases", "undisturbed,light", "--set", "kp=500"]
    done = dualarm("tune", "-c", "pd-tuned", *options, "--out", str(preset), "--report", str(page), "--workers", "1")
    assert done.returncode == 0, done.stderr
    text = page.read_text(encoding="utf-8")
    for part in ("Gains", "Cases, after the search", "The way of the search", "after the search", "--evaluations 8"):
        assert part in text
    gains = preset.read_text(encoding="utf-8")
    assert all(f"{gain} =" in gains for gain in ("kp", "kv", "kp1", "kv1", "kp2", "kv2"))
    assert "--parameter kp=50..5000" in gains, "within a decade of where the search begins"
    command = text.split('<pre class="command">')[1].split("</pre>")[0].splitlines()
    assert "  --parameter kp=50..5000 \\" in command
    assert max(map(len, command)) < 80


TANK = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Tank(Fmi2Slave):
    author = "A Plumber"
    description = "A tank with an inflow"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.inflow, self.level, self.area = 0.0, 1.0, 2.0
        self.register_variable(Real("inflow", causality=Fmi2Causality.input))
        self.register_variable(Real("level", causality=Fmi2Causality.output))
        self.register_variable(Real("area", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable))

    def do_step(self, current_time, step_size):
        self.level += step_size * self.inflow / self.area
        return True
'''


def test_info_reads_an_fmu_of_another_tool(tmp_path: Path) -> None:
    """PythonFMU's library needs a Python process around it; that it does not run here must be said, with the reason."""
    script = tmp_path / "tank.py"
    script.write_text(TANK, encoding="utf-8")
    file = FmuBuilder.build_FMU(script, dest=tmp_path)
    done = dualarm("info", str(file))
    assert done.returncode == 0, done.stderr
    for expected in ("A tank with an inflow", "PythonFMU", "A Plumber", "1 input, 1 output, 1 parameter", "runs here"):
        assert expected in done.stdout
    document = json.loads(dualarm("info", str(file), "--json").stdout)
    assert document["capabilities"]["needsExecutionTool"] is True
    assert "linux64" in document["platforms"]
    assert [v["name"] for v in document["variables"] if v["causality"] == "input"] == ["inflow"]
    assert document["runs_here"] or "Py" in document["obstacle"]


def test_verify_speaks_json(verification: Path) -> None:
    document = json.loads((verification / "printed.json").read_text(encoding="utf-8"))
    assert document["failures"] == 0
    assert len(document["checks"]) > 50
    assert all(check["error"] <= check["bound"] and check["passes"] for check in document["checks"])


def test_compare_speaks_json_and_runs_the_same_scenarios(tmp_path: Path, run: Any) -> None:
    done = dualarm("compare", "--no-package", "--no-matrix", "--out", str(tmp_path), "--stop", "2", "--json")
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    assert [case["name"] for case in document["cases"]] == ["nabfc", "pds", "pd"]
    assert document["cases"][0]["metrics"] == run("nabfc").document["metrics"]
    assert Path(document["report"]).is_file()


def test_another_controller_brings_its_own_law() -> None:
    """The scenario *nabfc* says that its law is the paper's. Another controller in its place is itself, not that law or an error."""
    finals = [
        json.loads(dualarm("simulate", *words, "--json", "--stop", "0.2", "--step", "1e-3").stdout)["final"]
        for words in (["nabfc", "-c", "nabfc-r"], ["-c", "nabfc-r"], ["nabfc"], ["nabfc", "-c", "pd-tuned"], ["-c", "pd-tuned"])
    ]
    assert finals[0] == finals[1] != finals[2]
    assert finals[3] == finals[4]
