"""`results/report.html` for everyone: keyboard, fingers, phone, paper, light and dark, and no motion for those who want none."""

from __future__ import annotations

import pytest

from .support.browser import Browser, settle
from .support.report import MINUS, Report, shown_time, spans


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
