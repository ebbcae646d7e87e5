"""Headless Chromium for the tests of pages: where it comes from, and a page that remembers what went wrong in it."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

IS_CI = os.environ.get("CI") == "true"
#: Guards against a browser that hangs, in ms: far above what the slowest machine needs.
HANGS = 1_800_000
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = [
    *("--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
]


def not_here(reason: str) -> None:
    """Skips and says what was not looked at; continuous integration looks at everything, so there it is a failure."""
    if IS_CI:
        pytest.fail(reason, pytrace=False)
    pytest.skip(f"not checked: {reason}")


def chromium() -> str:
    """The browser's program. Continuous integration installs it; elsewhere the test is skipped without it."""
    found = next(filter(None, map(shutil.which, NAMES)), None)
    if found is None and IS_CI and shutil.which("apt-get"):
        install("chromium")
        found = shutil.which("chromium")
    if found is None:
        not_here("Chromium is not installed, so report.html was not opened in a browser (Debian: package chromium)")
    return str(found)


def install(package: str) -> None:
    """Installs a Debian package; waits while another process holds apt's locks."""
    commands = (["apt-get", "update"], ["apt-get", "install", "-y", "--no-install-recommends", package])
    for command in commands:
        for attempt in range(120):
            environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
            done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
            if done.returncode == 0:
                break
            if "lock" not in done.stderr or attempt == 119:
                pytest.fail(f"`{' '.join(command)}` failed:\n{done.stderr}", pytrace=False)
            time.sleep(15)


@dataclass
class Opened:
    """A page in the browser."""

    page: Any
    requests: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)


def settle(page: Any, frames: int = 2) -> None:
    """Waits until the page has drawn what the last input asked for: so many frames, however long the machine takes."""
    page.evaluate(
        """async count => {
            for (let i = 0; i < count; i++) await new Promise(requestAnimationFrame);
        }""",
        frames,
    )


class Browser:
    """Opens files, each in a profile of its own."""

    def __init__(self, chrome: Any) -> None:
        self.chrome = chrome

    @contextmanager
    def open(self, path: Path, **options: Any) -> Iterator[Opened]:
        """The page of a file once it is ready; afterwards nothing may have gone wrong in it."""
        context = self.chrome.new_context(**{"viewport": {"width": 1360, "height": 900}, **options})
        context.set_default_timeout(HANGS)
        opened = Opened(context.new_page())
        page = opened.page
        page.on("request", lambda request: opened.requests.append(request.url))
        page.on("pageerror", lambda error: opened.problems.append(str(error)))
        page.on(
            "console", lambda line: opened.problems.append(line.text) if line.type in ("error", "warning") else None
        )
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready]")
        yield opened
        context.close()
        assert opened.problems == []


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Headless Chromium, driven by Playwright."""
    program = chromium()
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        not_here("Playwright has no package for this platform, so report.html was not opened in a browser")
    with sync_playwright() as playwright:
        chrome = playwright.chromium.launch(executable_path=program, args=FLAGS, headless=True, timeout=HANGS)
        yield Browser(chrome)
        chrome.close()
