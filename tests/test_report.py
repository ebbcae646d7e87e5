"""`results/report.html` in a browser: whole, quick, alive, linked, and true to the data beside it."""

from __future__ import annotations

import csv
import io
import re
import shutil
import subprocess
import tarfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from .support.browser import HANGS, Browser, not_here, settle
from .support.paths import ROOT
from .support.report import RUNS, Report, arm_points, faces, show, shown_time, spans, tips

UPLOT = ROOT / "dualarm" / "assets" / "uplot"
#: Geometry of the default plant, in m.
ARM, OBJECT = 0.2, 0.1


def test_it_is_one_small_file_that_asks_for_nothing(report: Report, browser: Browser) -> None:
    assert report.html.stat().st_size < 3_000_000
    with browser.open(report.html) as opened:
        settle(opened.page, 20)
    assert opened.requests == [report.html.as_uri()]
    # Should a later change try: the page forbids itself to fetch.
    assert "default-src 'none'" in report.html.read_text(encoding="utf-8")


@pytest.mark.parametrize("exaggeration", [1, 10, 20])
@pytest.mark.parametrize("time", [0.0, 0.002, 0.305, 4.0])
def test_the_picture_is_the_data(report: Report, browser: Browser, time: float, exaggeration: int) -> None:
    """Tips at the object's faces, arms at x·θ − w. Values are packed to 1e-6 of their range, paths to 1e-3 mm."""
    tolerance = 2e-3 + 1e-6 * 20 * exaggeration
    with browser.open(report.html) as opened:
        page = opened.page
        page.select_option("#exaggeration", str(exaggeration))
        show(page, time)
        drawn_tips, drawn_faces, drawn_arms = tips(page), faces(page), arm_points(page)
    for index, run in enumerate(RUNS):
        shift = report.at(run, "y_object", time) - OBJECT / 2
        for arm in (1, 2):
            base = OBJECT * (arm - 1)
            x, y = drawn_tips[2 * index + arm - 1]
            assert x == pytest.approx(1e3 * ARM, abs=tolerance)
            # Contact in the picture, at any exaggeration.
            assert y == pytest.approx(drawn_faces[index][arm - 1], abs=tolerance)
            # The constraint (12): the tip moves as the object does.
            assert y == pytest.approx(1e3 * (base + exaggeration * shift), abs=tolerance)
            theta = report.at(run, f"theta{arm}", time)
            points = drawn_arms[2 * index + arm - 1]
            assert len(points) == 11
            for node, (x, y) in enumerate(points):
                position = ARM * node / 10
                deflection = report.at(run, f"deflection{arm}[{node + 1}]", time)
                assert x == pytest.approx(1e3 * position, abs=tolerance)
                wanted = base + exaggeration * (position * theta - deflection)
                assert y == pytest.approx(1e3 * wanted, abs=tolerance)


def test_forces_press_on_the_object_from_both_sides(report: Report, browser: Browser) -> None:
    """Settled, arrows point at each other; 2 ms after the start, where a force is negative, its arrow says so."""
    with browser.open(report.html) as opened:
        page = opened.page
        read = """all => all.map(one => ({ pulls: one.classList.contains('pulls'),
            ends: one.getAttribute('d').match(/^M\\S+ (\\S+) V(\\S+)/)?.slice(1).map(Number) }))"""
        show(page, 6.0)
        arrows = page.eval_on_selector_all("path.force[data-arm]", read)
        assert [arrow["pulls"] for arrow in arrows] == [False] * 6
        # Down the screen is negative y: arm 1's arrows go up, arm 2's down.
        assert all(end < begin for begin, end in (arrow["ends"] for arrow in arrows[::2]))
        assert all(end > begin for begin, end in (arrow["ends"] for arrow in arrows[1::2]))
        show(page, 0.002)
        arrows = page.eval_on_selector_all("path.force[data-arm]", read)
        forces = [report.at(run, f"contact_force{arm}", 0.002) for run in RUNS for arm in (1, 2)]
        assert any(force < 0 for force in forces)
        assert [arrow["pulls"] for arrow in arrows] == [force < 0 for force in forces]


def test_it_moves_when_it_plays_and_stands_when_it_does_not(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        before = tips(page)
        settle(page, 20)
        assert tips(page) == before, "nothing moves by itself"
        # So slow that no machine is still busy when it comes to the end.
        page.select_option("#speed", "0.1")
        page.get_by_role("button", name="Play").click()
        moved = "before => document.querySelectorAll('circle.tip')[2].cy.baseVal.value !== before"
        page.wait_for_function(moved, arg=-before[2][1])
        settle(page, 20)
        page.get_by_role("button", name="Pause").click()
        time, stopped = shown_time(page), tips(page)
        assert time > 0.306
        assert stopped != before
        settle(page, 20)
        assert (shown_time(page), tips(page)) == (time, stopped)
        # At the end it stops by itself, and begins again from the start of the span.
        page.get_by_role("button", name="50 ms").click()
        page.get_by_role("button", name="Play").click()
        page.wait_for_selector("#play[aria-label=Play]")
        assert shown_time(page) == pytest.approx(0.05)


def test_zoom_is_shared_by_all_charts(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        whole = spans(page)
        assert {time for time, _ in whole} == {(0.0, 8.0)}
        plot = page.locator("[data-signal=theta1] .u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        at = lambda share: box["x"] + share * box["width"]  # noqa: E731
        middle = box["y"] + box["height"] / 2
        page.mouse.move(at(0.25), middle)
        page.mouse.down()
        page.mouse.move(at(0.5), middle, steps=5)
        page.mouse.up()
        settle(page)
        zoomed = spans(page)
        assert len({time for time, _ in zoomed}) == 1
        # A pixel of the mouse is 0.025 s.
        assert zoomed[0][0] == pytest.approx((2.0, 4.0), abs=0.05)
        # Every vertical axis follows what is in view; the settled signals fill it again.
        assert all(
            high - low < bottom_top[1] - bottom_top[0] for (_, (low, high)), (_, bottom_top) in zip(zoomed, whole)
        )
        plot.dblclick()
        settle(page)
        assert spans(page) == whole
        page.get_by_role("button", name="50 ms").click()
        settle(page)
        # The kick of PD and PDS at the start: their motors are at the limit of 2 N·m.
        torque = spans(page)[6]
        assert torque[0] == (0.0, 0.05)
        assert torque[1][1] > 2.0


def test_the_cursor_is_linked_with_all_charts_and_the_animation(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        kept, stood = shown_time(page), tips(page)
        plot = page.locator("[data-signal=contact_force1] .u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
        settle(page)
        assert shown_time(page) == pytest.approx(4.0, abs=0.03)
        lines = page.eval_on_selector_all(".u-cursor-x", "all => all.map(one => one.style.transform)")
        assert len(lines) == 9
        assert len(set(lines)) == 1
        assert tips(page) != stood
        # The values above the charts are those of the data.
        time = round(shown_time(page), 3)
        shown = page.eval_on_selector_all(
            "[data-signal=contact_force2] figcaption span span",
            "all => all.map(one => Number(one.textContent.replace('\\u2212', '-')))",
        )
        assert shown == pytest.approx([report.at(run, "contact_force2", time) for run in RUNS], abs=1.5e-3)
        page.mouse.move(2, 2)
        settle(page)
        assert (shown_time(page), tips(page)) == (kept, stood), "pointing is a look, no more"
        plot.click(position={"x": box["width"] / 4, "y": 40})
        page.mouse.move(2, 2)
        assert shown_time(page) == pytest.approx(2.0, abs=0.03)
        # The playhead is in every chart at that time.
        heads = page.eval_on_selector_all(".playhead", "all => all.map(one => parseFloat(one.style.left))")
        assert heads == pytest.approx([25.0] * 9, abs=0.4)


def test_controllers_can_be_hidden(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        before = spans(page)
        button = page.get_by_role("button", name="PDS", exact=True)
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
        labels = ".chart figcaption > span:not(.take)"
        hidden = page.eval_on_selector_all(labels, "all => all.map(one => one.hidden)")
        assert hidden == [False, True, False] * 9
        button.click()
        settle(page)
        assert spans(page) == before


def test_the_clock_is_never_outside_of_what_is_shown(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        page.get_by_role("button", name="50 ms").click()
        assert shown_time(page) == pytest.approx(0.05), "0.305 s is out of view"
        page.keyboard.press("ArrowRight")
        assert shown_time(page) == pytest.approx(0.05)
        page.keyboard.press("Home")
        page.keyboard.press("Shift+ArrowLeft")
        assert shown_time(page) == 0.0


def test_the_result_is_on_the_first_screen(report: Report, browser: Browser) -> None:
    with (report.html.parent / "metrics.csv").open(newline="", encoding="utf-8") as file:
        metrics = list(csv.DictReader(file))
    for viewport in ({"width": 1280, "height": 720}, {"width": 390, "height": 844}):
        with browser.open(report.html, viewport=viewport) as opened:
            cards = opened.page.locator(".result li")
            assert cards.count() == 3
            for index, run in enumerate(metrics):
                longest = max(float(run[f"force{arm}_settling_2_s"]) for arm in (1, 2))
                shown = float(cards.nth(index).locator("b").inner_text().split()[0])
                assert shown == pytest.approx(longest, abs=5e-3)
                box = cards.nth(index).bounding_box()
                assert box["y"] + box["height"] <= viewport["height"]


def test_data_charts_and_figures_can_be_taken_away(report: Report, browser: Browser, tmp_path: Path) -> None:
    """CSV as exact as the page is; SVG and PNG of a chart and of each of the paper's figures."""

    def take(button: Any) -> Path:
        with page.expect_download() as caught:
            button.click()
        path = tmp_path / caught.value.suggested_filename
        caught.value.save_as(path)
        return path

    with browser.open(report.html, accept_downloads=True) as opened:
        page = opened.page
        file = take(page.get_by_role("button", name="Data of PDS as CSV"))
        assert file.name == "pds.csv"
        with file.open(newline="", encoding="utf-8") as text:
            header, *rows = csv.reader(text)
        data = dict(zip(header, np.array(rows, dtype=float).T))
        on_grid = np.isclose(data["time"] * 1e3, np.round(data["time"] * 1e3), atol=1e-6)
        for signal in ("contact_force1", "tau2", "deflection1[6]", "theta1_dot"):
            truth = np.interp(data["time"], report.runs["pds"]["time"], report.runs["pds"][signal])
            span = np.ptp(report.runs["pds"][signal])
            # Half a quantum of a millionth of the span, and seven digits.
            assert np.abs(data[signal] - truth)[on_grid].max() < 2e-6 * span
        for name in ("Contact force f₁", "Torque τ₁"):
            svg = take(page.get_by_role("button", name=f"{name} as SVG", exact=True))
            root = ElementTree.parse(svg).getroot()
            assert root.tag.endswith("svg")
            assert "PDS" in "".join(root.itertext())
            drawn = take(page.get_by_role("button", name=f"{name} as PNG", exact=True))
            assert drawn.read_bytes().startswith(b"\x89PNG")
            assert drawn.stat().st_size > 10_000
        page.locator(".figures summary").click()
        figures = page.locator(".drawn figure")
        names = figures.evaluate_all("all => all.map(one => one.dataset.name)")
        assert {f"fig{number:02}" for number in range(2, 19)} <= set(names)
        first = take(figures.nth(names.index("fig17")).get_by_role("button", name="SVG"))
        assert first.name == "fig17.svg"
        assert "Fig. 17" in "".join(ElementTree.parse(first).getroot().itertext())


def test_metrics_are_those_of_the_table(report: Report, browser: Browser) -> None:
    """Settling times as in metrics.csv; and the page works without JavaScript as far as tables go."""
    with (report.html.parent / "metrics.csv").open(newline="", encoding="utf-8") as file:
        metrics = list(csv.DictReader(file))
    context = browser.chrome.new_context(java_script_enabled=False)
    context.set_default_timeout(HANGS)
    page = context.new_page()
    page.goto(report.html.as_uri())
    rows = page.locator(".metrics tr", has_text="settling time, ±2 %")
    for arm in (1, 2):
        cells = rows.nth(arm - 1).locator("td").all_inner_texts()
        assert cells == [f"{float(run[f'force{arm}_settling_2_s']):.3f}" for run in metrics]
    assert page.locator(".parameters", has_text="rbf_nodes_posture").count() == 1
    context.close()


def test_the_library_is_that_of_npm(tmp_path: Path) -> None:
    """The vendored files are the package's, byte by byte, in the version that they and the README name."""
    header = (UPLOT / "uPlot.iife.min.js").read_text(encoding="utf-8").splitlines()[0]
    version = re.search(r"\(v([\d.]+)\)", header).group(1)
    assert version in (UPLOT / "README.md").read_text(encoding="utf-8").splitlines()[0]
    npm = shutil.which("npm")
    if npm is None:
        not_here("npm is not installed, so dualarm/assets/uplot was not compared with the npm package")
    done = subprocess.run([npm, "pack", f"uplot@{version}"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (package,) = tmp_path.glob("*.tgz")
    with tarfile.open(package) as archive:
        for name in ("LICENSE", "dist/uPlot.iife.min.js", "dist/uPlot.min.css"):
            content = archive.extractfile(f"package/{name}") or io.BytesIO()
            assert (UPLOT / Path(name).name).read_bytes() == content.read(), name
