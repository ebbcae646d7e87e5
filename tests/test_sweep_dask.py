"""A study on Dask (`examples/sweep_dask.py`): the rows of `dualarm sweep`, to the bit, also when a worker is killed."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from types import ModuleType

import pytest

from .support.hostile import hostile
from .support.paths import DIST, ROOT
from .support.tool import tool

distributed = pytest.importorskip("distributed", reason="Dask is not installed (tests/requirements.txt)")
if sys.platform == "win32":
    pytest.skip("ends processes by signals", allow_module_level=True)

SCRIPT = ROOT / "examples" / "sweep_dask.py"
STUDY = """
title = "For a cluster"
system = "nabfc"
controllers = ["nabfc-r", "pid"]
method = "sobol"
draws = 64
[experiment]
stop = 0.5
step = 1e-4
[vary]
M = { low = 0.1, high = 2, scale = "log" }
l = { low = 0.15, high = 0.3 }
"""


@pytest.fixture
def study(tmp_path: Path) -> Path:
    """A study whose rows `dualarm sweep` has found."""
    path = tmp_path / "study.toml"
    path.write_text(STUDY, encoding="utf-8")
    native(path)
    return path


def native(study: Path, *options: str) -> None:
    words = [tool(), "--quiet", "sweep", study, "--fmus", DIST, "-o", study.with_name("native.parquet"), *options]
    subprocess.run(words, check=True)


def assert_equal(study: Path, output: Path) -> None:
    assert output.read_bytes() == study.with_name("native.parquet").read_bytes()


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The example as a module that workers find, too."""
    monkeypatch.syspath_prepend(SCRIPT.parent)
    monkeypatch.setenv("PYTHONPATH", str(SCRIPT.parent), prepend=os.pathsep)
    return importlib.import_module(SCRIPT.stem)


def test_a_worker_that_is_killed_costs_no_row(study: Path, script: ModuleType) -> None:
    """Three worker processes; one is killed when the first rows have come, and its batch goes to another one."""
    output = study.with_name("dask.parquet")
    arguments = argparse.Namespace(
        study=study, output=output, state=None, tool=tool(), fmus=DIST, batch=4, retries=5, timeout=60.0
    )
    with (
        distributed.LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        at_work = threading.Thread(target=script.sweep, args=(client, arguments))
        at_work.start()
        journal = output.with_suffix(".jsonl")
        while at_work.is_alive() and (not journal.exists() or journal.read_bytes().count(b"\n") < 5):
            time.sleep(0.01)
        os.kill(next(iter(cluster.workers.values())).process.pid, signal.SIGKILL)
        at_work.join()
    assert_equal(study, output)


def test_scheduler_and_workers_as_programs_of_their_own(study: Path) -> None:
    """As on a cluster: `dask scheduler`, two `dask worker`, and the script, which finds half of the rows done."""
    file = study.with_name("scheduler.json")
    output = study.with_name("dask.parquet")
    known = study.with_name("native.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
    output.with_suffix(".jsonl").write_text("".join(known[:65]) + known[65][:9], encoding="utf-8")
    dask = [sys.executable, "-m", "dask"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": study.parent}
    own = ["--no-dashboard", "--scheduler-file", str(file)]
    programs = [subprocess.Popen([*dask, "scheduler", "--host", "127.0.0.1", "--port", "0", *own], **quiet)]
    try:
        worker = [*dask, "worker", "--nthreads", "2", *own]
        programs += [subprocess.Popen(worker, **quiet) for _ in range(2)]
        while not file.exists() or not file.read_text(encoding="utf-8").endswith("}"):
            assert programs[0].poll() is None
            time.sleep(0.01)
        address = json.loads(file.read_text(encoding="utf-8"))["address"]
        words = [sys.executable, SCRIPT, study, "-o", output, "--scheduler", address, "--batch", "8"]
        subprocess.run([*words, "--tool", tool(), "--fmus", DIST], check=True, stdout=subprocess.DEVNULL)
    finally:
        for program in programs:
            program.terminate()
        for program in programs:
            program.wait()
    assert_equal(study, output)


def test_what_crashes_is_the_same_row(tmp_path: Path) -> None:
    """A run that takes its process with it, in a cluster of one worker."""
    hostile(tmp_path)
    study = tmp_path / "study.toml"
    study.write_text(
        'title = "x"\nsystem = ["Hostile.fmu"]\nmethod = "grid"\noutputs = ["y"]\n[vary]\nu = [0, 1, 0.1]\n'
    )
    environment = {**os.environ, "HOSTILE": "crash-far"}
    words = ["sweep", study, "-o", study.with_name("native.parquet"), "--isolated"]
    subprocess.run([tool(), "--quiet", *words], check=True, env=environment)
    output = tmp_path / "dask.parquet"
    words = [sys.executable, SCRIPT, study, "-o", output, "--workers", "1", "--tool", tool(), "--fmus", DIST]
    subprocess.run(words, check=True, env=environment, stdout=subprocess.DEVNULL)
    assert_equal(study, output)
