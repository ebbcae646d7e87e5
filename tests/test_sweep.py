"""`dualarm sweep`: the same rows whoever makes them and however often it was ended; what fails is a row."""

from __future__ import annotations

import csv
import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from .support.browser import Browser, settle
from .support.hostile import hostile
from .support.paths import DIST, ROOT
from .support.tool import dualarm, tool

STUDY = """
title = "Small"
system = "nabfc"
controllers = ["nabfc-r", { name = "pd", title = "PD", step = 2e-4 }]
method = "latin-hypercube"
draws = 8
seed = 3
outputs = ["theta1"]
[experiment]
stop = 0.2
step = 1e-3
[vary]
M = { low = 0.1, high = 2, scale = "log" }
EI = { mean = 0.115, sd = 0.01, low = 0.05, names = ["EI1", "EI2"] }
zone = { low = 0, high = 0.1, names = ["m_r1", "-m_l1"] }
actuator_model = ["compensated", "raw"]
[success]
overshoot = 5
"""


def write(folder: Path, text: str = STUDY, name: str = "study.toml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def sweep(study: Path, *arguments: str, code: int = 0, **environment: str) -> dict[str, Any]:
    """Runs a study beside its file; the document of `--json`."""
    words = [tool(), "sweep", study, "--fmus", DIST, "--json", *arguments]
    environment = {**os.environ, **environment}
    done = subprocess.run(words, cwd=study.parent, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stderr
    return json.loads(done.stdout) if code == 0 else {"error": done.stderr}


def rows(file: Path) -> list[dict[str, Any]]:
    return pq.read_table(file).to_pylist()


def test_rows_do_not_depend_on_who_makes_them(tmp_path: Path) -> None:
    """One thread, three threads, processes: Parquet and CSV are equal byte by byte."""
    study = write(tmp_path)
    for name, options in {"one": ["--workers", "1"], "three": ["--workers", "3"], "apart": ["--isolated"]}.items():
        for suffix in ("parquet", "csv"):
            sweep(study, "-o", f"{name}.{suffix}", "--state", f"{name}.jsonl", *options)
    for suffix in ("parquet", "csv"):
        one, three, apart = ((tmp_path / f"{name}.{suffix}").read_bytes() for name in ("one", "three", "apart"))
        assert one == three == apart
    table = rows(tmp_path / "one.parquet")
    assert [row["run"] for row in table] == list(range(16))
    assert [row["draw"] for row in table] == [run // 2 for run in range(16)]
    assert {row["status"] for row in table} == {"ok"}
    assert [row["controller"] for row in table[:2]] == ["NABFC-R", "PD"]
    for row in table:
        assert row["success"] == (row["overshoot"] <= 5)
        assert row["theta1_min"] <= row["theta1_mean"] <= row["theta1_max"]
    # Every digit is in the CSV, too.
    with (tmp_path / "one.csv").open(encoding="utf-8", newline="") as file:
        for text, row in zip(csv.DictReader(file), table):
            assert float(text["theta1_rms"]) == row["theta1_rms"]
            assert float(text["M"]) == row["M"]


def test_draws_are_what_the_study_says(tmp_path: Path) -> None:
    """Strata of the Latin hypercube, and the same draw for each controller."""
    sweep(write(tmp_path), "-o", "a.parquet")
    table = rows(tmp_path / "a.parquet")
    for draw in range(8):
        first, second = (row for row in table if row["draw"] == draw)
        assert all(first[name] == second[name] for name in ("M", "EI", "zone", "actuator_model"))
    of_zone = sorted(row["zone"] for row in table[::2])
    assert [int(value / 0.1 * 8) for value in of_zone] == list(range(8))
    of_mass = sorted(row["M"] for row in table[::2])
    assert [int(np.log(value / 0.1) / np.log(20) * 8) for value in of_mass] == list(range(8))
    assert sorted(row["actuator_model"] for row in table[::2]) == ["compensated"] * 4 + ["raw"] * 4


def test_a_row_is_what_simulate_finds(tmp_path: Path) -> None:
    """The drawn values given to `simulate` by hand lead to the same last outputs; so does `--run`, with its trajectory."""
    study = write(tmp_path)
    sweep(study, "-o", "a.parquet")
    row = rows(tmp_path / "a.parquet")[6]
    again = sweep(study, "--run", "6", "-o", "run.parquet")["row"]
    assert again == row
    trajectory = pq.read_table(tmp_path / "run.parquet")
    assert trajectory["theta1"][-1].as_py() == row["theta1_last"]
    settings = [f"M={row['M']!r}", f"EI1={row['EI']!r}", f"EI2={row['EI']!r}", f"m_r1={row['zone']!r}"]
    settings += [f"m_l1={-row['zone']!r}", f"actuator_model={row['actuator_model']}"]
    words = [word for setting in settings for word in ("--set", setting)]
    done = dualarm("simulate", "--controller", "nabfc-r", "--stop", "0.2", "--step", "1e-3", "--json", *words)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["final"]["theta1"] == row["theta1_last"]


@pytest.mark.skipif(sys.platform == "win32", reason="ends a process by a signal")
def test_killed_and_started_again_it_goes_on(tmp_path: Path) -> None:
    """A process that is killed in the middle, its last line torn: what is done is not done again, the result is the same."""
    study = write(tmp_path, STUDY.replace("stop = 0.2", "stop = 2").replace("step = 1e-3", "step = 1e-4"))
    sweep(study, "-o", "whole.parquet")
    words = [tool(), "sweep", study, "--fmus", DIST, "-o", "a.parquet", "--workers", "1"]
    process = subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.DEVNULL, start_new_session=True)
    journal = tmp_path / "a.jsonl"
    while process.poll() is None and (not journal.exists() or journal.read_bytes().count(b"\n") < 5):
        time.sleep(0.001)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    content = journal.read_bytes()
    journal.write_bytes(content[:-7])
    known = content[:-7].count(b"\n") - 1
    assert not (tmp_path / "a.parquet").exists() or known == 15
    assert sweep(study, "-o", "a.parquet")["simulated"] == 16 - known
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "whole.parquet").read_bytes()
    assert sweep(study, "-o", "a.parquet")["simulated"] == 0
    refused = sweep(write(tmp_path, STUDY), "-o", "a.parquet", code=1)
    assert "a.jsonl belongs to another study: its systems differs; delete it" in refused["error"]


def test_what_fails_crashes_or_hangs_is_a_row(tmp_path: Path) -> None:
    """An FMU that misbehaves for some values only; the rows around it are whole, and the study's exit code is 0."""
    hostile(tmp_path)
    study = write(
        tmp_path,
        'title = "x"\nsystem = ["Hostile.fmu"]\nmethod = "grid"\noutputs = ["y"]\n[vary]\nu = [0, 1, 0.1, 2, 0.2]\n',
    )
    # The time limit is far above what a run takes, and no run of the others comes near it.
    for word, status, said in [
        ("crash-far", "crashed", "an FMU crashed the process"),
        ("_exit-far", "crashed", "an FMU ended the process"),
        ("exit-far", "crashed", "an FMU ended the process"),
        ("hang-far", "timeout", "not done after 3 s"),
    ]:
        document = sweep(study, "-o", f"{word}.parquet", "--timeout", "3", HOSTILE=word)
        table = rows(tmp_path / f"{word}.parquet")
        assert [row["status"] for row in table] == ["ok", status, "ok", status, "ok"], table
        assert all(said in row["error"] for row in table if row["status"] == status), table
        assert [row["y_last"] for row in table if row["status"] == "ok"] == [1.0, 1.0, 1.0]
        assert document["groups"][0]["failed"] == 2
    sweep(study, "-o", "end.parquet", HOSTILE="end")
    assert {row["status"] for row in rows(tmp_path / "end.parquet")} == {"ended"}


def test_a_value_that_an_fmu_refuses_is_a_row(tmp_path: Path) -> None:
    """A dead zone beyond the limit of the torque: each is in its own range, and only the plant knows that they do not go together."""
    study = write(tmp_path, STUDY.replace("zone = { low = 0, high = 0.1, ", "zone = { values = [0.05, 3], "))
    sweep(study, "-o", "a.parquet")
    table = rows(tmp_path / "a.parquet")
    assert {row["zone"] for row in table} == {0.05, 3}
    for row in table:
        assert row["status"] == ("ok" if row["zone"] < 2 else "failed")
        assert row["zone"] < 2 or ("greater than m_r1 = 3" in row["error"] and row["overshoot"] is None)


def test_few_draws_beyond_what_an_fmu_allows_are_rows(tmp_path: Path) -> None:
    """Tails of a normal distribution, and an end of a range that no draw reaches: a mass is positive."""
    study = STUDY.replace("draws = 8", "draws = 40").replace("sd = 0.01, low = 0.05", "sd = 0.06")
    study = study.replace('low = 0.1, high = 2, scale = "log"', "low = 0, high = 2").replace("stop = 0.2", "stop = 0.01")
    sweep(write(tmp_path, study), "-o", "a.parquet")
    table = rows(tmp_path / "a.parquet")
    failed = [row for row in table if row["EI"] <= 0]
    # 2.8 % of the distribution, of 40 strata the lowest or also the next one, for two controllers each.
    assert len(failed) in (2, 4)
    assert all("EI1 must be from" in row["error"] for row in failed)
    assert all((row["status"] == "failed") == (row["EI"] <= 0) for row in table)


def test_a_bad_cell_of_a_table_is_named(tmp_path: Path) -> None:
    (tmp_path / "p.csv").write_text("M,actuator_model\n0.3,raw\n-1,ideal\n", encoding="utf-8")
    study = tmp_path / "study.toml"
    study.write_text('title = "x"\nsystem = "pd-tuned"\nmethod = "table"\npoints = "p.csv"\n', encoding="utf-8")
    error = sweep(study, "-o", "a.parquet", code=2)["error"]
    assert 'p.csv, row 2, column "M": DualArmPlant.M must be from 1e-9 to 1000000000 kg, not -1' in error


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("M = {", "MM = {", 'study.toml:13: there is no variable "MM"'),
        ("M = {", '"Plant.M" = {', 'there is no component "Plant"'),
        ('"-m_l1"', '"theta1"', "study.toml:15: DualArmPlant.theta1 cannot be set: it is an output"),
        ('"raw"]', '"rw"]', "study.toml:16: DualArmPlant.actuator_model needs one of ideal, compensated, raw"),
        ("{ low = 0.1, high = 2,", "{ low = 0.1, high = 1e12,", "study.toml:13: DualArmPlant.M must be from 1e-9 to 1000000000 kg, not 1000000000000"),
        ('{ low = 0.1, high = 2, scale = "log" }', "[0.3, -1]", "study.toml:13: DualArmPlant.M must be from"),
        ("sd = 0.01, low = 0.05", "sd = 1.0", "study.toml:14: DualArmPlant.EI1 must be from"),
        ("draws = 8", "draw = 8", "study.toml:6:1: unknown field `draw`"),
        ('"latin-hypercube"', '"latin"', "study.toml:5:10: unknown variant `latin`"),
        ('"nabfc"', '"nabcf"', 'there is no scenario "nabcf"; did you mean nabfc'),
        ('"nabfc-r"', '"nabfcr"', 'there is no controller "nabfcr"; did you mean'),
        ('["theta1"]', '["theta"]', 'no FMU has an output "theta" that is a number; did you mean theta1'),
        ("overshoot = 5", "overshot = 5", 'study.toml:18: there is no figure "overshot"; did you mean overshoot?'),
        ("stop = 0.2", "stop = -1", "the stop time (-1 s) must be later than the start time"),
    ],
)
def test_what_cannot_be_is_said_before_the_first_run(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in STUDY
    study = write(tmp_path, STUDY.replace(old, new, 1))
    assert said in sweep(study, "-o", "a.parquet", code=2)["error"]
    assert not list(tmp_path.glob("*.jsonl"))


def test_points_of_a_table(tmp_path: Path) -> None:
    """CSV and Parquet, values and coordinates, in the file and from the command line."""
    points = {"M": [0.25, 0.5], "EI": [0.1, 0.2], "zone": [0.0, 0.05], "actuator_model": ["raw", "raw"]}
    pq.write_table(pa.table(points), tmp_path / "points.parquet")
    with (tmp_path / "points.csv").open("w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows([points, *zip(*points.values())])
    study = write(tmp_path)
    for suffix in ("csv", "parquet"):
        sweep(study, "-o", f"by-{suffix}.parquet", "--points", f"points.{suffix}")
    by_csv, by_parquet = (rows(tmp_path / f"by-{suffix}.parquet") for suffix in ("csv", "parquet"))
    assert by_csv == by_parquet
    assert [(row["M"], row["EI"], row["actuator_model"]) for row in by_csv[::2]] == [
        (0.25, 0.1, "raw"),
        (0.5, 0.2, "raw"),
    ]
    (tmp_path / "unit.csv").write_text("M,EI,zone,actuator_model\n0,0.5,0.5,0.9\n1,0.5,1,0\n", encoding="utf-8")
    sweep(study, "-o", "unit.parquet", "--points", "unit.csv", "--unit")
    first, second = rows(tmp_path / "unit.parquet")[::2]
    assert (first["M"], first["zone"], first["actuator_model"]) == (0.1, 0.05, "raw")
    # The middle of a normal distribution that is cut off far from it; exp(log(20)) may miss 20 by its rounding.
    assert second["M"] == pytest.approx(2, rel=1e-15)
    assert second["EI"] == pytest.approx(0.115, rel=1e-9)
    refused = sweep(study, "-o", "b.parquet", "--points", "points.csv", "--unit", code=2)
    assert "a number from 0 to 1 is needed, not raw" in refused["error"]


def test_parts_of_a_study_and_trajectories(tmp_path: Path) -> None:
    study = write(tmp_path)
    sweep(study, "-o", "a.parquet", "--runs", "3..5", "--trajectories", "all")
    assert [row["run"] for row in rows(tmp_path / "a.parquet")] == [3, 4]
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == ["run-0000003.parquet", "run-0000004.parquet"]
    # Those that are done and have their file are not made again; one whose file has gone is.
    (tmp_path / "all" / "run-0000004.parquet").unlink()
    assert sweep(study, "-o", "a.parquet", "--runs", "3..6", "--trajectories", "all")["simulated"] == 2
    assert "the study has the runs 0..16" in sweep(study, "--runs", "3..17", code=2)["error"]
    assert "the study has the runs 0 to 15" in sweep(study, "--run", "16", code=2)["error"]


def test_a_controller_without_a_run_in_a_part_has_a_row_of_dashes(tmp_path: Path) -> None:
    """In the table for people: all columns are there for it, and nothing is said of what did not run."""
    words = [tool(), "sweep", write(tmp_path), "--fmus", DIST, "--runs", "0..1", "-o", "a.csv"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    row = next(line.split()[1:] for line in done.stdout.splitlines() if line.startswith("PD "))
    assert row[:3] == ["0", "0", "–"]
    assert set(row[3:]) == {"–"}


def test_an_ssp_can_be_swept(tmp_path: Path) -> None:
    text = f'title = "x"\nsystem = "{(DIST / "DualArmGrasp-NABFC.ssp").as_posix()}"\nmethod = "random"\ndraws = 2\n'
    study = write(tmp_path, text + "[experiment]\nstop = 0.1\nstep = 1e-3\n[vary]\nM = { low = 0.2, high = 0.4 }\n")
    sweep(study, "-o", "a.csv")
    with (tmp_path / "a.csv").open(encoding="utf-8") as file:
        assert [row["status"] for row in csv.DictReader(file)] == ["ok", "ok"]


def test_the_robustness_study_runs(tmp_path: Path) -> None:
    """Twenty of its two thousand draws with all eight controllers: every name means something, and nothing fails."""
    study = ROOT / "scenarios" / "studies" / "robustness.toml"
    document = sweep(study, "-o", str(tmp_path / "a.parquet"), "--runs", "0..160")
    assert [(group["runs"], group["ok"]) for group in document["groups"]] == [(20, 20)] * 8
    assert all(0 <= group["success_rate"]["low"] <= group["success_rate"]["high"] <= 1 for group in document["groups"])


def test_the_page_leads_from_a_point_to_its_run(tmp_path: Path, browser: Browser) -> None:
    study = write(tmp_path, STUDY.replace('"Small"', '"Small <b>"').replace("stop = 0.2", "stop = 1"))
    sweep(study, "-o", "a.parquet", "--report", "page.html")
    table = rows(tmp_path / "a.parquet")
    with browser.open(tmp_path / "page.html") as opened:
        page = opened.page
        scatter = page.locator("#scatter")

        def chosen() -> int:
            settle(page)
            command = page.locator("#command").text_content()
            assert command.startswith("dualarm sweep ")
            assert "study.toml" in command
            return int(command.split("--run ")[1].split()[0])

        assert page.title() == "Small <b>"
        scatter.focus()
        page.keyboard.press("ArrowRight")
        run = chosen()
        shown = dict(
            page.eval_on_selector_all("#row div", "all => all.map(d => [...d.children].map(c => c.textContent))")
        )
        assert shown["run"] == str(run)
        assert shown["controller"] == table[run]["controller"]
        assert float(shown["M"]) == pytest.approx(table[run]["M"], rel=1e-3)  # four digits
        # A click on the point that is marked chooses its run again, after another one was.
        x, y = map(float, scatter.get_attribute("data-chosen").split())
        for _ in range(3):
            page.keyboard.press("ArrowRight")
        assert chosen() != run
        scatter.click(position={"x": x, "y": y})
        assert chosen() == run
        # What was drawn by its logarithm has an axis of it, though it spans little more than a decade.
        page.select_option("#x", "M")
        places = {}
        for _ in range(6):
            scatter.focus()
            page.keyboard.press("ArrowRight")
            mass = table[chosen()]["M"]
            places[mass] = float(scatter.get_attribute("data-chosen").split()[0])
        low, middle, *_, high = sorted(places)
        share = math.log(middle / low) / math.log(high / low)
        assert places[middle] == pytest.approx(places[low] + share * (places[high] - places[low]), abs=0.1)
        # Who hides a controller sees no more of it.
        for button in page.locator("#legend button").all():
            button.click()
        page.keyboard.press("Escape")
        settle(page)
        assert scatter.get_attribute("data-chosen") == ""
    assert all(url.startswith(("file:", "data:")) for url in opened.requests)
