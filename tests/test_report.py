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
    page.eval_on_selector(
        "#scrub",
        "(slider, share) => { slider.value = share; slider.dispatchEvent(new Event('input')); }",
        (time - start) / (stop - start),
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
        hidden = page.eval_on_selector_all(".chart figcaption > span", "all => all.map(one => one.hidden)")
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
        for _ in range(60):
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
