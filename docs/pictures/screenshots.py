"""Take the pictures of the page that the README shows: `make screenshots`.

The page of real recordings, shipped with pyport, and the page of a simulated
case, both from the command that a user calls, in a headless Chromium.
"""

import io
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Page, sync_playwright

HERE = Path(__file__).parent
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def main() -> None:
    """Make both pages and take the pictures."""
    chromium = next(filter(None, map(shutil.which, NAMES)), None)
    if chromium is None:
        sys.exit("screenshots: no Chromium here, sh .ci/install chromium installs it")
    with TemporaryDirectory() as folder, sync_playwright() as play:
        real = diagnosed("gmrt-2003-06-01", "gmrt-paper", Path(folder))
        simulated = diagnosed(str(made(Path(folder))), "altaz", Path(folder))
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])

        def opened(path: Path, width: int, scheme: str) -> Page:
            size = {"width": width, "height": 900}
            tab = browser.new_page(viewport=size, color_scheme=scheme)
            tab.goto(path.as_uri())
            tab.wait_for_selector("html[data-ready]", state="attached")
            return tab

        take(opened(real, 1180, "light"), "page-verdict.png", "header", "#findings")
        take(opened(simulated, 1180, "dark"), "page-panels.png", "#bar", "#against-panels")
        take(opened(real, 390, "light"), "page-phone.png", "header", "#findings", tall=1400)
        browser.close()


def made(folder: Path) -> Path:
    """Return a simulated campaign with refraction left out."""
    words = "trials make --kind one --effect refraction --rho 3 --rows 900 --seed 3 -o"
    pyport(*words.split(), folder / "made")
    return next((folder / "made" / "recordings").glob("*.csv"))


def diagnosed(recordings: str, model: str, folder: Path) -> Path:
    """Return the page of a diagnosis."""
    pyport("diagnose", recordings, "--model", model, "--out", folder, "--quiet")
    return folder / Path(recordings).stem / "report.html"


def pyport(*words: object) -> None:
    """Call the command."""
    subprocess.run([sys.executable, "-m", "pyport", *map(str, words)], check=True)  # noqa: S603


def take(tab: Page, name: str, first: str, last: str, tall: int = 1500) -> None:
    """Write a picture from the top of one element to the bottom of another."""
    top = tab.locator(first).bounding_box()["y"]
    box = tab.locator(last).bounding_box()
    height = min(tall, box["y"] + box["height"] - top)
    clip = {"x": 0, "y": max(top, 0), "width": tab.viewport_size["width"], "height": height}
    shot = tab.screenshot(full_page=True, clip=clip)
    # Few colours do for flat paper, thin lines and dots, and a README loads sooner.
    with Image.open(io.BytesIO(shot)) as image:
        few = image.convert("RGB").quantize(128, dither=Image.Dither.NONE)
        few.save(HERE / name, optimize=True)


if __name__ == "__main__":
    main()
