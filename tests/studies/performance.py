"""All figures of docs/performance.md, on the machine at hand: instruction counts, times beside the same in C, cost against order and number.

    cargo run --release -- package
    python -m tests.studies.performance

Writes docs/performance/time.csv, docs/performance/cost.csv and docs/figures/cost.svg, and the tables between the marks in the page. Takes
a minute or two; the machine should have nothing else to do. Needs matplotlib; counts need valgrind.
"""

from __future__ import annotations

import csv
import re
import subprocess
from pathlib import Path

from tests.studies import plot_cost

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PROGRAM = ["cargo", "run", "--quiet", "--release", "-p", "benchmarks", "--example", "step_cost", "--"]
ROUNDS = 5
#: What a step may cost [ns], issue by issue.
TARGETS = {"plant": 70, "nabfc": 200, "coupled": 300, "nabfc-r": 200, "coupled-r": 300}


def run(*command: str) -> str:
    return subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout


def times() -> dict[str, float]:
    """The lowest of each line over the rounds [ns]."""
    lowest: dict[str, float] = {}
    for _ in range(ROUNDS):
        for line in run(*PROGRAM, "time").splitlines():
            if found := re.match(r"(\S.*?)\s{2,}(\d+)(?:\s|$)", line):
                lowest[found[1]] = min(lowest.get(found[1], float("inf")), float(found[2]))
    return lowest


def counts() -> dict[str, int]:
    """Instructions per step by case; those that the gate compares."""
    found = re.findall(r"^(\S+) +(\d+) instructions per step", run("cargo", "xtask", "counts"), re.MULTILINE)
    return {case: int(count) for case, count in found}


def step_table(lowest: dict[str, float], instructions: dict[str, int]) -> list[str]:
    rows = ["| step | instructions | ns | in C, ns | ratio | in C without wide registers, ns | target, ns | |",
            "|---|---|---|---|---|---|---|---|"]
    cases = [name.removeprefix("step, ") for name in lowest if name.startswith("step, ")]
    for case in cases:
        ns = lowest[f"step, {case}"]
        peer = "coupled" if case in {"coupled", "get_first", "master"} else case
        in_c, narrow = lowest.get(f"in C, {peer}"), lowest.get(f"in C without wide registers, {peer}")
        target = TARGETS.get(case)
        verdict = "" if target is None else "met" if ns <= target else "missed"
        rows.append(
            f"| {case} | {instructions.get(case, '')} | {ns:.0f} | {'' if in_c is None else f'{in_c:.0f}'} "
            f"| {'' if in_c is None else f'{ns / in_c:.2f}'} | {'' if narrow is None else f'{narrow:.0f}'} "
            f"| {'' if target is None else target} | {verdict} |")
    return rows


def other_table(lowest: dict[str, float]) -> list[str]:
    rest = [name for name in lowest if not name.startswith(("step, ", "in C"))]
    return ["| other calls | ns |", "|---|---|", *(f"| {name} | {lowest[name]:.0f} |" for name in rest)]


def cost_table(rows: list[dict[str, str]]) -> list[str]:
    pairs, default = ([row for row in rows if row["what"] == what] for what in ("pair", "pair-r"))
    table = ["| pairs in one process | ns per pair and step | KiB per pair beyond the first | start, µs | default law: ns | start, µs |",
             "|---|---|---|---|---|---|"]
    return table + [
        f"| {paper['instances']} | {paper['step_ns']} | {paper['kib_each'] if paper['instances'] != '1' else ''} | {paper['start_us']} "
        f"| {row['step_ns']} | {row['start_us']} |" for paper, row in zip(pairs, default, strict=True)]


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "an unknown processor"


def main() -> None:
    instructions = counts()
    lowest = times()
    sizes = run(*PROGRAM, "sizes")
    (DOCS / "performance/cost.csv").write_text(sizes)
    with (DOCS / "performance/time.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([("what", "ns"), *((name, f"{ns:.0f}") for name, ns in lowest.items())])
    slopes = plot_cost.draw()
    block = [f"Measured on {processor()}; the lowest of {ROUNDS} runs, each the best of 60 batches.", "",
             *step_table(lowest, instructions), "", *other_table(lowest), "", *cost_table(list(csv.DictReader(sizes.splitlines()))), "",
             *slopes]
    page = DOCS / "performance.md"
    begin, end = "<!-- measured: python -m tests.studies.performance -->", "<!-- end -->"
    before, rest = page.read_text().split(begin)
    page.write_text(f"{before}{begin}\n" + "\n".join(block) + f"\n{end}" + rest.split(end, 1)[1])


if __name__ == "__main__":
    main()
