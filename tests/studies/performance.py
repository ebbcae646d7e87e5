"""All figures of docs/performance.md, on the machine at hand: instruction counts, times beside the same in C, cost against order and number.

    cargo run --release -- package
    python -m tests.studies.performance
    python -m tests.studies.performance --before FOLDER     # beside FMUs of an earlier version, measured in turns

Writes docs/performance/time.csv, docs/performance/cost.csv and docs/figures/cost.svg, and the tables between the marks in the page. Takes
five minutes; the machine should have nothing else to do. Needs matplotlib; counts need valgrind.
"""

from __future__ import annotations

import argparse
import csv
import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PROGRAM = ["cargo", "run", "--quiet", "--release", "-p", "benchmarks", "--example", "step_cost", "--"]
ROUNDS = 5
#: What a step may cost [ns], issue by issue.
TARGETS = {"plant": 70, "nabfc": 200, "coupled": 300, "nabfc-r": 200, "coupled-r": 300}


def run(*command: str) -> str:
    return subprocess.run(command, check=True, cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout


def times(folders: list[Path]) -> list[dict[str, float]]:
    """For each folder of FMUs the lowest of each line over the rounds [ns]; the folders in turns."""
    lowest: list[dict[str, float]] = [{} for _ in folders]
    for _ in range(ROUNDS):
        for folder, least in zip(folders, lowest, strict=True):
            for line in run(*PROGRAM, "time", str(folder)).splitlines():
                if found := re.match(r"(\S.*?)\s{2,}(\d+)(?:\s|$)", line):
                    least[found[1]] = min(least.get(found[1], float("inf")), float(found[2]))
    return lowest


def counts() -> dict[str, int]:
    """Instructions per step by case; those that the gate compares."""
    found = re.findall(r"^(\S+) +(\d+) instructions per step", run("cargo", "xtask", "counts"), re.MULTILINE)
    return {case: int(count) for case, count in found}


def table(names: list[str], rows: list[list[object]]) -> list[str]:
    """Columns in which nothing stands are left out."""
    used = [i for i in range(len(names)) if any(row[i] != "" for row in rows)]
    lines = [[names[i] for i in used], ["---"] * len(used), *([str(row[i]) for i in used] for row in rows)]
    return ["| " + " | ".join(line) + " |" for line in lines]


def of(lowest: dict[str, float], name: str) -> str:
    return f"{lowest[name]:.0f}" if name in lowest else ""


def step_table(lowest: dict[str, float], before: dict[str, float], instructions: dict[str, int]) -> list[str]:
    rows = []
    for name in (name for name in lowest if name.startswith("step, ")):
        case = name.removeprefix("step, ")
        ns, in_c = lowest[name], f"in C, {'coupled' if case in {'get_first', 'master'} else case}"
        target = TARGETS.get(case, "")
        rows.append([case, instructions.get(case, ""), f"{ns:.0f}", of(before, name), of(lowest, in_c),
                     f"{ns / lowest[in_c]:.2f}" if in_c in lowest else "", of(lowest, in_c.replace("C,", "C without wide registers,")),
                     target, "" if target == "" else "met" if ns <= target else "missed"])
    return table(["step", "instructions", "ns", "before, ns", "in C, ns", "ratio to C", "in C without wide registers, ns", "target, ns", ""], rows)


def other_table(lowest: dict[str, float], before: dict[str, float]) -> list[str]:
    rest = [name for name in lowest if not name.startswith(("step, ", "in C"))]
    return table(["other calls", "ns", "before, ns"], [[name, of(lowest, name), of(before, name)] for name in rest])


def cost_table(rows: list[dict[str, str]], before: list[dict[str, str]]) -> list[str]:
    def of_pairs(rows: list[dict[str, str]], what: str) -> list[dict[str, str]]:
        return [row for row in rows if row["what"] == what]

    earlier = {(row["what"], row["instances"]): row["step_ns"] for row in before}
    lines = []
    for paper, default in zip(of_pairs(rows, "pair"), of_pairs(rows, "pair-r"), strict=True):
        count = paper["instances"]
        lines.append([count, paper["step_ns"], earlier.get(("pair", count), ""), paper["kib_each"] if count != "1" else "", paper["start_us"],
                      default["step_ns"], earlier.get(("pair-r", count), ""), default["start_us"]])
    return table(["pairs in one process", "ns per pair and step", "before", "KiB per pair beyond the first", "start, µs", "default law: ns",
                  "before", "start, µs"], lines)


def processor() -> str:
    for line in Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else ():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return "an unknown processor"


def write(begin: str, end: str, lines: list[str]) -> None:
    """Puts lines between two marks of the page."""
    page = DOCS / "performance.md"
    before, rest = page.read_text().split(begin)
    page.write_text(f"{before}{begin}\n" + "\n".join(lines) + f"\n{end}" + rest.split(end, 1)[1])


def main() -> None:
    parser = argparse.ArgumentParser(description="Measures all figures of docs/performance.md and writes them into the page.")
    parser.add_argument("--before", type=Path, metavar="FOLDER", help="FMUs of an earlier version, to measure in turns with those of dist/")
    earlier = parser.parse_args().before
    folders = [ROOT / "dist", *([] if earlier is None else [earlier.resolve(strict=True)])]
    instructions = counts()
    lowest, before = (*times(folders), {})[:2]
    sizes, sizes_before = (*(run(*PROGRAM, "sizes", str(folder)) for folder in folders), "")[:2]
    (DOCS / "performance/cost.csv").write_text(sizes)
    with (DOCS / "performance/time.csv").open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([("what", "ns"), *((name, f"{ns:.0f}") for name, ns in lowest.items())])
    # Only here: `tool_cost` measures the memory of children, in which that of this process counts.
    from tests.studies import plot_cost

    slopes = plot_cost.draw()
    block = [f"Measured on {processor()}; the lowest of {ROUNDS} runs, each the best of 60 batches.", "",
             *step_table(lowest, before, instructions), "", *other_table(lowest, before), "",
             *cost_table(*(list(csv.DictReader(text.splitlines())) for text in (sizes, sizes_before))), "",
             *slopes]
    write("<!-- measured: python -m tests.studies.performance -->", "<!-- end -->", block)


if __name__ == "__main__":
    main()
