"""`results/report.html` in a browser: whole, quick, alive, linked, accessible, and true to the data beside it."""

from __future__ import annotations

import csv
import io
import re
import shutil
import subprocess
import tarfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from .support.browser import HANGS, Browser, not_here, settle
from .support.paths import ROOT
from .support.tool import dualarm

RUNS = ("nabfc", "pds", "pd")
UPLOT = ROOT / "dualarm" / "assets" / "uplot"
MINUS = "\N{MINUS SIGN}"
#: Geometry of the default plant, in m.
ARM, OBJECT = 0.2, 0.1


@dataclass
class Report:
    """The page and the CSV files written with it."""

    html: Path
    runs: dict[str, dict[str, np.ndarray]]

    def at(self, run: str, signal: str, time: float) -> float:
        """A signal's value in the CSV file, at a time that has a row there."""
        row = int(np.argmin(np.abs(self.runs[run]["time"] - time)))
        assert abs(self.runs[run]["time"][row] - time) < 1e-9
        return float(self.runs[run][signal][row])


@pytest.fixture(scope="session")
def report(tmp_path_factory: pytest.TempPathFactory) -> Report:
    folder = tmp_path_factory.mktemp("results")
    done = dualarm("compare", "--no-package", "--quiet", "--out", str(folder))
    assert done.returncode == 0, done.stderr
    runs = {}
    for run in RUNS:
        with (folder / f"{run}.csv").open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        runs[run] = dict(zip(header, np.array(rows, dtype=float).T))
    return Report(folder / "report.html", runs)


def show(page: Any, time: float) -> None:
    """Moves the slider to a time in s, as a hand on it would."""
    start, stop = spans(page)[0][0]
    scrub(page, (time - start) / (stop - start))


def scrub(page: Any, share: float) -> None:
    """Moves it to a share of what is shown."""
    page.eval_on_selector(
        "#scrub", "(slider, share) => { slider.value = share; slider.dispatchEvent(new Event('input')); }", share
    )


def spans(page: Any) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Of every chart the span of time and of values that it shows, as it tells those who do not see it."""
    labels = page.eval_on_selector_all(".chart [role=img]", "all => all.map(one => one.getAttribute('aria-label'))")
    assert len(labels) == 9
    found = []
    for label in labels:
        match = re.search(r"from (\S+) to (\S+) s, between (\S+) and (\S+) ", label)
        assert match, label
        low, high, bottom, top = (float(text.replace(MINUS, "-")) for text in match.groups())
        found.append(((low, high), (bottom, top)))
    return found


def tips(page: Any) -> list[tuple[float, float]]:
    """Where the six tips are drawn, in mm, y upwards: NABFC's two, PDS's, PD's."""
    return page.eval_on_selector_all(
        "circle.tip", "all => all.map(one => [one.cx.baseVal.value, -one.cy.baseVal.value])"
    )


def arm_points(page: Any) -> list[list[tuple[float, float]]]:
    """The points that each drawn arm passes through, in mm, y upwards."""
    paths = page.eval_on_selector_all("path.arm[data-arm]", "all => all.map(one => one.getAttribute('d'))")
    curves = []
    for path in paths:
        numbers = [float(text) for text in re.findall(r"-?[0-9.]+(?:e-?\d+)?", path)]
        pairs = list(zip(numbers[::2], numbers[1::2]))
        curves.append([(x, -y) for x, y in [pairs[0], *pairs[3::3]]])
    return curves


def faces(page: Any) -> list[tuple[float, float]]:
    """The lowest and the highest point of each drawn object, in mm, y upwards."""
    return page.eval_on_selector_all(
        "path.object",
        """all => all.map(one => {
            const box = one.getBBox();
            const shift = one.parentElement.transform.baseVal.consolidate().matrix.f;
            return [-(box.y + box.height + shift), -(box.y + shift)];
        })""",
    )


def shown_time(page: Any) -> float:
    """The time that the page shows, in s."""
    number, unit = page.inner_text("#time").replace(MINUS, "-").split()
    return float(number) * {"s": 1.0, "ms": 1e-3}[unit]


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


def test_light_and_dark(report: Report, browser: Browser) -> None:
    """The system's choice at first, the button's from then on; curves change with it."""
    look = (
        "() => [getComputedStyle(document.body).backgroundColor, document.querySelector('.chart canvas').toDataURL()]"
    )
    with browser.open(report.html, color_scheme="light") as opened:
        light = opened.page.evaluate(look)
    with browser.open(report.html, color_scheme="dark") as opened:
        page = opened.page
        dark = page.evaluate(look)
        button = page.get_by_role("button", name="Dark")
        assert button.get_attribute("aria-pressed") == "true"
        button.click()
        settle(page)
        assert page.evaluate(look) == light
        button.click()
        settle(page)
        assert page.evaluate(look) == dark
    assert light[0] != dark[0]
    assert light[1] != dark[1]


def test_the_keyboard_is_enough(report: Report, browser: Browser) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        start = shown_time(page)
        page.keyboard.press("ArrowRight")
        assert shown_time(page) == pytest.approx(start + 8.0 / 200, abs=1e-3)
        page.keyboard.press("Shift+ArrowRight")
        page.keyboard.press("ArrowLeft")
        assert shown_time(page) == pytest.approx(start + 10 * 8.0 / 200, abs=1e-3)
        page.keyboard.press("+")
        settle(page)
        (low, high), _ = spans(page)[0]
        assert high - low == pytest.approx(4.0, abs=1e-3)
        page.keyboard.press("0")
        settle(page)
        assert spans(page)[0][0] == (0.0, 8.0)
        page.keyboard.press(" ")
        assert page.get_by_role("button", name="Pause").count() == 1
        page.keyboard.press(" ")
        assert page.get_by_role("button", name="Play").count() == 1
        # Tab reaches every control, each has a name and shows the focus.
        reached = []
        for _ in range(150):
            page.keyboard.press("Tab")
            one = page.evaluate(
                """() => {
                    const e = document.activeElement;
                    const name = e.getAttribute('aria-label') || e.labels?.[0]?.textContent || e.textContent;
                    return [e.id || e.textContent.trim(), name.trim(), getComputedStyle(e).outlineStyle, e.tagName];
                }"""
            )
            if one[3] == "BODY":
                break
            reached.append(one)
        assert all(name for _, name, _, _ in reached)
        assert all(outline != "none" for _, _, outline, _ in reached)
        wanted = {"theme", "play", "scrub", "speed", "exaggeration", "NABFC", "PDS", "PD"}
        wanted |= {"50 ms", "0.5 s", "2 s", "All", "+", MINUS}
        assert wanted <= {key for key, *_ in reached}


@pytest.mark.parametrize("focus", ["body", "#play", "#zoom button", ".take button", "summary", ".wide", "#scrub"])
def test_keys_work_wherever_the_focus_is(report: Report, browser: Browser, focus: str) -> None:
    with browser.open(report.html) as opened:
        page = opened.page
        page.locator(focus).first.focus()
        page.keyboard.press("End")
        assert shown_time(page) == 8.0
        page.keyboard.press("ArrowLeft")
        assert shown_time(page) == pytest.approx(8.0 - 8.0 / 200, abs=1e-3)
        page.keyboard.press("Home")
        assert shown_time(page) == 0.0


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


def test_print_has_its_charts_as_drawings(report: Report, browser: Browser) -> None:
    with browser.open(report.html, color_scheme="dark") as opened:
        page = opened.page
        assert len(page.pdf(format="A4")) > 50_000
        page.emulate_media(media="print")
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        drawn = page.locator(".printed svg")
        assert drawn.count() == 9
        page.set_viewport_size({"width": 700, "height": 1000})
        assert page.evaluate("document.documentElement.scrollWidth") <= 700, "nothing is cut off at the paper's edge"
        assert all(drawn.nth(index).bounding_box()["width"] > 200 for index in range(9))
        assert not page.locator("canvas").first.is_visible()
        background = page.evaluate("getComputedStyle(document.querySelector('.result li')).backgroundColor")
        assert background == "rgb(255, 255, 255)", "paper is light"


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


def test_a_page_of_another_system(browser: Browser, tmp_path: Path) -> None:
    """Without a grasp there are curves, under their names and with their units, and no word of arms."""
    file = tmp_path / "tank.csv"
    rows = "".join(f"{k / 10},{20 + k % 7},{k * 1e-9},{'on' if k % 2 else 'off'}\n" for k in range(200))
    file.write_text(f"Time,T [K],leak [m3/s],pump\n{rows}", encoding="utf-8")
    done = dualarm("report", str(file))
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(tmp_path / "tank.html")
    with browser.open(tmp_path / "tank.html") as opened:
        page = opened.page
        assert page.locator(".chart strong").all_inner_texts() == ["T (K)", "leak (m3/s)"]
        assert page.locator("#scenes, #exaggeration, .result, .metrics").count() == 0
        assert not re.search(r"\barms?\b", page.inner_text("main"))
        page.keyboard.press("End")
        assert shown_time(page) == pytest.approx(19.9)


def test_nothing_moves_for_those_who_want_no_motion(report: Report, browser: Browser) -> None:
    with browser.open(report.html, reduced_motion="reduce") as opened:
        moving = opened.page.evaluate(
            """() => [...document.querySelectorAll('*')].map(one => getComputedStyle(one)).filter(
                style => parseFloat(style.transitionDuration) > 0 || style.animationName !== 'none').length"""
        )
        assert moving == 0


@pytest.mark.parametrize("width", [320, 390])
def test_it_fits_a_phone(report: Report, browser: Browser, width: int) -> None:
    phone = {
        "viewport": {"width": width, "height": 800},
        "has_touch": True,
        "is_mobile": True,
        "device_scale_factor": 2,
    }
    with browser.open(report.html, **phone) as opened:
        page = opened.page
        page.eval_on_selector_all("details", "all => all.forEach(one => { one.open = true })")
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        # Buttons are large enough for a thumb, and playback leaves most of the screen to the page.
        heights = page.eval_on_selector_all(
            "button, select", "all => all.map(one => one.getBoundingClientRect().height)"
        )
        assert min(heights) >= 36
        assert page.locator("#transport").bounding_box()["height"] < 800 / 5


def test_fingers_move_through_time_and_zoom(report: Report, browser: Browser) -> None:
    phone = {"viewport": {"width": 390, "height": 800}, "has_touch": True, "is_mobile": True}
    with browser.open(report.html, **phone) as opened:
        page = opened.page
        plot = page.locator("[data-signal=theta1] .u-over")
        plot.scroll_into_view_if_needed()
        box = plot.bounding_box()
        session = page.context.new_cdp_session(page)

        def touch(kind: str, *shares: float) -> None:
            places = [box["x"] + share * box["width"] for share in shares]
            points = [{"x": x, "y": box["y"] + 40, "id": index} for index, x in enumerate(places)]
            session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})

        touch("touchStart", 0.2)
        for share in (0.3, 0.4, 0.5):
            touch("touchMove", share)
        touch("touchEnd")
        settle(page)
        assert shown_time(page) == pytest.approx(4.0, abs=0.1)
        # 3.2 s and 4.8 s are drawn apart to 20 % and 80 % of the width: 2.67 s in all.
        touch("touchStart", 0.4, 0.6)
        touch("touchMove", 0.3, 0.7)
        touch("touchMove", 0.2, 0.8)
        touch("touchEnd")
        settle(page)
        times = {time for time, _ in spans(page)}
        assert len(times) == 1
        low, high = times.pop()
        assert high - low == pytest.approx(1.6 / 0.6, abs=0.1)
        assert (low + high) / 2 == pytest.approx(4.0, abs=0.1)


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
