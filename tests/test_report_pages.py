"""Pages of other runs than the paper's: any scenario, saved results, a system that is not ours."""

from __future__ import annotations

import csv
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from .support.browser import Browser, settle
from .support.paths import ROOT
from .support.report import MINUS, scrub, show, shown_time, spans
from .support.tool import dualarm


def test_a_page_of_any_run(browser: Browser, tmp_path: Path) -> None:
    """`simulate --report`: a grasp moves; what differs from the defaults is said; the estimates have charts."""
    path = tmp_path / "heavy.html"
    done = dualarm("simulate", "unknown-mass", "--set", "delta_F=0.01", "--stop", "1", "--report", str(path))
    assert done.returncode == 0, done.stderr
    assert str(path) in done.stdout
    with browser.open(path) as opened:
        page = opened.page
        assert page.locator("circle.tip").count() == 2
        assert "An object five times as heavy" in page.inner_text("h1")
        changed = page.locator(".changed tr", has_text="DualArmPlant")
        assert changed.first.locator("th, td").all_inner_texts()[:4] == ["M DualArmPlant", "0.3", "1.5", "kg"]
        assert "DualArmPlant.delta_F = 0.01 N" in page.inner_text("[aria-labelledby=parameters-title]")
        page.get_by_text("What the controller estimates").click()
        page.wait_for_selector("[data-signal=m_hat] canvas")
        # Any other signal has a chart when asked for.
        page.select_option("#signal", "root_moment1")
        assert "root_moment1 (N·m)" in page.inner_text("[data-signal=root_moment1]")


def test_a_page_of_a_grasp_that_opens(browser: Browser, tmp_path: Path) -> None:
    """Gaps and impacts have charts, the panel says which tip is off; where nothing opens there are no such charts."""
    pages = {}
    for scenario in ("approach", "nabfc"):
        pages[scenario] = tmp_path / f"{scenario}.html"
        done = dualarm("simulate", scenario, "--stop", "0.3", "--report", str(pages[scenario]))
        assert done.returncode == 0, done.stderr
    with browser.open(pages["approach"]) as opened:
        page = opened.page
        for signal in ("gap1", "in_contact", "impacts1", "impact_loss"):
            page.wait_for_selector(f"[data-signal={signal}] canvas")
        scrub(page, 0.01 / 0.3)
        assert "no tip touches the object" in page.inner_text(".run .status")
        scrub(page, 0.29 / 0.3)
        assert "touch" not in page.inner_text(".run .status")
    with browser.open(pages["nabfc"]) as opened:
        assert opened.page.locator("[data-signal=gap1]").count() == 0


@pytest.mark.parametrize(
    ("scenario", "controller", "begins"),
    [("nabfc", "nabfc", "10"), ("stiff-arms", "nabfc", "10"), ("matrix/longest.toml", "nabfc-r", "2")],
)
def test_nothing_leaves_the_frame(
    browser: Browser, tmp_path: Path, scenario: str, controller: str, begins: str
) -> None:
    """Arms, object, arrows and targets are inside the picture at all times; a calm run has the frame of always."""
    path = tmp_path / "page.html"
    name = str(ROOT / "scenarios" / scenario) if scenario.endswith(".toml") else scenario
    done = dualarm("simulate", name, "--controller", controller, "--stop", "2", "--report", str(path))
    assert done.returncode == 0, done.stderr
    outside = """() => {
        const frame = document.querySelector("svg.scene").getBoundingClientRect();
        return [...document.querySelectorAll(".scene :is(path, circle, rect)")].filter((shape) => {
            const box = shape.getBoundingClientRect();
            const drawn = box.width > 0 || box.height > 0;
            return drawn && !(box.left >= frame.left && box.right <= frame.right
                && box.top >= frame.top && box.bottom <= frame.bottom);
        }).map((shape) => shape.outerHTML);
    }"""
    with browser.open(path) as opened:
        page = opened.page
        exaggeration = page.locator("#exaggeration")
        assert exaggeration.input_value() == begins, "it is said what one sees"
        if scenario == "nabfc":
            assert page.get_attribute("svg.scene", "viewBox") == "-34 -154 294 208"
        for times in ("1", "10", "20"):
            exaggeration.select_option(times)
            for share in (0.0, 5e-4, 0.005, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0):
                scrub(page, share)
                assert page.evaluate(outside) == [], (times, share)


def test_a_page_of_saved_results(browser: Browser, tmp_path: Path) -> None:
    """`dualarm report`: files of this tool and of another one overlaid, with another length and another end."""
    for name, stop in (("a.parquet", "1"), ("b.csv", "2")):
        done = dualarm("simulate", "pds", "--stop", stop, "-o", str(tmp_path / name))
        assert done.returncode == 0, done.stderr
    with (tmp_path / "b.csv").open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    # As OMSimulator names them; a controller of one's own has no target, so nothing is judged.
    kept = [index for index, name in enumerate(header) if name != "lambda2_d"]
    with (tmp_path / "c.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([header[index] if index == 0 else f"model.root.plant.{header[index]}" for index in kept])
        writer.writerows([row[index] for index in kept] for row in rows)
    page_file = tmp_path / "page.html"
    files = [str(tmp_path / name) for name in ("a.parquet", "c.csv")]
    done = dualarm("report", *files, "--names", "ours,mine", "-o", str(page_file))
    assert done.returncode == 0, done.stderr
    with browser.open(page_file) as opened:
        page = opened.page
        assert page.locator(".run").count() == 2, "both move: lengths follow from the constraint (12)"
        assert page.locator(".result li").count() == 1
        assert spans(page)[0][0] == (0.0, 2.0)
        show(page, 1.5)
        values = page.locator("[data-signal=theta1] figcaption > span:not(.take)").all_inner_texts()
        theta = float(rows[1500][header.index("theta1")])
        assert float(values[1]) == pytest.approx(np.degrees(theta), abs=1e-3)
        assert page.get_by_role("button", name="mine", exact=True).count() == 1


def reported(file: Path, text: str) -> subprocess.CompletedProcess[str]:
    """The command that made the page of a CSV file with this text."""
    file.write_text(text, encoding="utf-8")
    done = dualarm("report", str(file))
    assert done.returncode == 0, done.stderr
    return done


def test_commands_beyond_what_is_delivered(browser: Browser, tmp_path: Path) -> None:
    """The axis of an actuator's chart follows what it delivers; that its limits are not in the file is said."""
    names = "contact_force1,contact_force2,lambda2_d,tau1,tau2,u,u_cmd"
    rows = "".join(f"{k / 100},0.5,0.5,0.5,0.1,0.1,{0.3 * (-1) ** (k // 20)},{40 * (-1) ** (k // 20)}\n" for k in range(200))
    reported(tmp_path / "limited.csv", f"time,{names}\n{rows}")
    with browser.open(tmp_path / "limited.html") as opened:
        page = opened.page
        said = page.get_attribute("[data-signal=u] [role=img]", "aria-label")
        low, high = (float(number.replace(MINUS, "-")) for number in re.search(r"between (\S+) and (\S+) N", said).groups())
        # A quarter of 0.6 N beyond ±0.3 N, and seven per cent of all that as air.
        assert (low, high) == pytest.approx((-0.513, 0.513), abs=0.01)
        assert "commands far beyond that are cut off" in page.inner_text("[aria-labelledby=signals-title]")
        assert "where the limits of the actuator are not known" in page.inner_text("[aria-labelledby=metrics-title]")


def test_a_dead_zone_stays_in_the_picture(browser: Browser, tmp_path: Path) -> None:
    """Where what an actuator delivers is constant, the command beside it is still in its chart."""
    names = "contact_force1,contact_force2,lambda2_d,tau1,tau2,u,u_cmd"
    force = [0.5 if k < 20 else 0.1 for k in range(200)]
    rows = "".join(f"{k / 100},0.5,0.5,0.5,0.1,0.1,{u},{u + 0.1}\n" for k, u in enumerate(force))
    reported(tmp_path / "zone.csv", f"time,{names}\n{rows}")
    with browser.open(tmp_path / "zone.html") as opened:
        page = opened.page
        plot = page.locator("[data-signal=u] .u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        middle = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.5 * box["width"], middle)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.75 * box["width"], middle, steps=5)
        page.mouse.up()
        settle(page)
        said = page.get_attribute("[data-signal=u] [role=img]", "aria-label")
        begin, low, high = (
            float(number.replace(MINUS, "-"))
            for number in re.search(r"from (\S+) to \S+ s, between (\S+) and (\S+) N", said).groups()
        )
        assert begin > 0.9, "the step at the beginning is not in view"
        assert low < 0.1 and high > 0.2


def test_a_page_of_another_system(browser: Browser, tmp_path: Path) -> None:
    """Without a grasp there are curves, under their names and with their units, and no word of arms."""
    file = tmp_path / "tank.csv"
    rows = "".join(f"{k / 10},{20 + k % 7},{k * 1e-9},{'on' if k % 2 else 'off'}\n" for k in range(200))
    done = reported(file, f"Time,T [K],leak [m3/s],pump\n{rows}")
    assert done.stdout.strip() == str(tmp_path / "tank.html")
    with browser.open(tmp_path / "tank.html") as opened:
        page = opened.page
        assert page.locator(".chart strong").all_inner_texts() == ["T (K)", "leak (m3/s)"]
        assert page.locator("#scenes, #exaggeration, .result, .metrics").count() == 0
        assert not re.search(r"\barms?\b", page.inner_text("main"))
        page.keyboard.press("End")
        assert shown_time(page) == pytest.approx(19.9)


def test_a_page_of_extreme_values(browser: Browser, tmp_path: Path) -> None:
    """Last digits that change, and both ends of all numbers: a picture with ticks, and no page that hangs."""
    file = tmp_path / "extreme.csv"
    rows = "".join(f"{k / 10},{10**16 + 2 * (k % 3)}.0,{(-1) ** k * 1e308!r},{k % 2}\n" for k in range(50))
    reported(file, f"time,digits,ends,usual\n{rows}")
    with browser.open(tmp_path / "extreme.html") as opened:
        opened.page.wait_for_selector("[data-signal=digits] canvas")
        assert opened.page.locator(".chart canvas").count() == 3
