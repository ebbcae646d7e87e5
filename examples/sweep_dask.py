"""Runs a study of `dualarm sweep` on a Dask cluster: the same rows, to the bit, as `dualarm sweep` itself.

    python examples/sweep_dask.py study.toml                             # a cluster on this machine
    python examples/sweep_dask.py study.toml --scheduler tcp://head:8786  # one that is there

Each thread of a Dask worker keeps one `dualarm sweep --worker` process, which opens and unpacks the FMUs once and answers
numbers of runs with rows. A task is a batch of runs, for a short run costs less than a task. Rows go to the journal that
`dualarm sweep` has, too: interrupted, the same command goes on, here or there; and it is `dualarm sweep` that writes the
result from it. The tool, the study and the FMUs must be at the same paths on all machines.
"""

from __future__ import annotations

import argparse
import json
import queue
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from distributed import Client, LocalCluster, WorkerPlugin, as_completed, get_worker

NAME = "dualarm-sweep"


class Runner:
    """A `dualarm sweep --worker` process, started when it is needed, again after it has died.

    It gives runs a process of their own (`--isolated`), so a run that crashes or hangs is a row as any other.
    """

    def __init__(self, command: list[str]) -> None:
        self.command = command
        self.process: subprocess.Popen[str] | None = None

    def start(self) -> dict:
        """Starts the process; returns what it knows of the study."""
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        greeting = json.loads(self.process.stdout.readline() or '{"failure": {"message": "it does not start"}}')
        if "failure" in greeting:
            raise RuntimeError(f"{' '.join(self.command)}: {greeting['failure']['message']}")
        return greeting["ready"]

    def row(self, run: int) -> str:
        """The row of a run, as the journal has it."""
        if self.process is None:
            self.start()
        try:
            self.process.stdin.write(f"{run}\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline().strip()
        except OSError:
            line = ""
        if not line:
            self.stop()
            raise RuntimeError("the sweep's worker process was ended")  # for Dask to retry
        return line

    def stop(self) -> None:
        """Ends the process: it goes when its standard input ends."""
        process, self.process = self.process, None
        if process is not None:
            process.stdin.close()
            process.stdout.close()
            process.wait()


class Sweep(WorkerPlugin):
    """What a Dask worker keeps: a runner for each of its threads."""

    name = NAME

    def __init__(self, command: list[str]) -> None:
        self.command = command

    def setup(self, worker: object) -> None:
        """On the worker, before its first task."""
        self.idle: queue.LifoQueue[Runner] = queue.LifoQueue()

    def teardown(self, worker: object) -> None:
        """On the worker, at its end."""
        while not self.idle.empty():
            self.idle.get().stop()

    @contextmanager
    def runner(self) -> Iterator[Runner]:
        """A runner for a task."""
        try:
            runner = self.idle.get_nowait()
        except queue.Empty:
            runner = Runner(self.command)
        try:
            yield runner
        finally:
            self.idle.put(runner)


def rows(runs: list[int]) -> list[str]:
    """The task: the rows of a batch of runs."""
    with get_worker().plugins[NAME].runner() as runner:
        return [runner.row(run) for run in runs]


def done(journal: Path, fingerprint: str) -> set[int]:
    """The runs that the journal has; begins one if there is none, and cuts off a line that was not finished."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    text = journal.read_text(encoding="utf-8") if journal.exists() else ""
    whole = text[: text.rfind("\n") + 1] or fingerprint + "\n"
    header, *lines = whole.splitlines()
    if json.loads(header) != json.loads(fingerprint):
        sys.exit(f"{journal} belongs to another study: delete it to begin anew, or name another one with --state")
    if whole != text:
        journal.write_text(whole, encoding="utf-8")
    return {json.loads(line)["run"] for line in lines}


def sweep(client: Client, arguments: argparse.Namespace) -> None:
    """Has all runs made that the journal lacks, and writes the result."""
    command = [str(arguments.tool), "sweep", str(arguments.study), "--fmus", str(arguments.fmus)]
    worker = [*command, "--worker", "--isolated", "--timeout", str(arguments.timeout)]
    here = Runner(worker)
    ready = here.start()
    here.stop()
    journal = arguments.state or arguments.output.with_suffix(".jsonl")
    known = done(journal, ready["fingerprint"])
    todo = [run for run in range(ready["runs"]) if run not in known]
    client.register_plugin(Sweep(worker))
    batches = [todo[at : at + arguments.batch] for at in range(0, len(todo), arguments.batch)]
    futures = client.map(rows, batches, pure=False, retries=arguments.retries)
    count = 0
    with journal.open("a", encoding="utf-8") as file:
        for future in as_completed(futures):
            lines = future.result()
            file.writelines(f"{line}\n" for line in lines)
            file.flush()
            future.release()
            count += len(lines)
            if sys.stderr.isatty():
                print(f"\r{count} of {len(todo)} runs", end="", file=sys.stderr)
    subprocess.run([*command, "-o", str(arguments.output), "--state", str(journal)], check=True)


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("-o", "--output", type=Path, help="Parquet or CSV [default: results/STUDY.parquet]")
    parser.add_argument("--state", type=Path, help="journal [default: beside the output]")
    parser.add_argument("--scheduler", help="address of a Dask scheduler [default: a cluster on this machine]")
    parser.add_argument("--workers", type=int, help="worker processes on this machine [default: one per processor]")
    parser.add_argument("--batch", type=int, default=50, help="runs per task; a task should take about a second")
    parser.add_argument("--retries", type=int, default=3, help="how often a batch is given to another worker")
    parser.add_argument("--timeout", type=float, default=60, help="how long a run may take, in s")
    parser.add_argument("--tool", type=Path, default=Path("target/release/dualarm"))
    parser.add_argument("--fmus", type=Path, default=Path("dist"))
    arguments = parser.parse_args()
    arguments.output = arguments.output or Path("results") / f"{arguments.study.stem}.parquet"
    for name in ("study", "tool", "fmus"):  # workers have folders of their own
        setattr(arguments, name, getattr(arguments, name).resolve())
    if arguments.scheduler:
        with Client(arguments.scheduler) as client:
            sweep(client, arguments)
    else:
        local = LocalCluster(n_workers=arguments.workers, threads_per_worker=1, dashboard_address=None)
        with local as cluster, Client(cluster) as client:
            sweep(client, arguments)


if __name__ == "__main__":
    main()
