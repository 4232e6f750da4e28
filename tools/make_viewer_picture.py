"""Makes docs/images/viewer.png: `gonio view` in Chromium, with a converged comparison of two models.

python tools/make_viewer_picture.py        half an hour on two cores without a GPU, minutes with one

By WebGL2, which draws twice as fast as WebGPU where the processor has to do it; the pictures are the same.
"""

from __future__ import annotations

import argparse
import threading
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from gonio.view.server import Viewer

OUTPUT = Path(__file__).parent.parent / "docs" / "images" / "viewer.png"
SIZE = {"width": 1280, "height": 800}

# What shows both interfaces without a GPU; a busy machine may take long for one pass of a picture.
FLAGS = [
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
    "--disable-gpu-watchdog",
]

# A clear coat over a tinted one over a rough base, with two of the ways in which light is let through.
BELOW = (
    "base=weidlich_wilkie,base.eta=1.1,base.alpha=0.12,base.sigma_a=0.05/0.9/2.4,base.thickness=0.6,"
    "base.base=eon,base.base.rho=0.9/0.75/0.6,base.base.roughness=0.6"
)
A = f"weidlich_wilkie:alpha=0.02,transmission=both_ways,solid_angle=compressed,{BELOW}"
B = f"weidlich_wilkie:alpha=0.02,transmission=half_vector,{BELOW}"


def main() -> None:
    """Open the page, wait until the picture has all its samples, and save what is seen."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument(
        "--seconds", type=float, default=3600, help="after which it is saved as it is"
    )
    given = parser.parse_args()
    samples = given.spp
    viewer = Viewer([A, B])
    thread = threading.Thread(target=viewer.serve_forever)
    thread.start()
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
            page = browser.new_page(viewport=SIZE, color_scheme="dark")  # type: ignore[arg-type]
            address = viewer.url.replace("/#", "/?graphics=webgl2#")
            page.goto(f"{address}&cmp=wipe&layer=1&probe=0.45,0.5&ev=0.2")
            rest = "globalThis.gonio?.sides.every((side) => side.samples >= gonio.renderer.limit)"
            while not page.evaluate("() => Boolean(globalThis.gonio?.sides[0].program)"):
                page.wait_for_timeout(100)
            page.evaluate(f"() => {{ gonio.renderer.limit = {samples}; }}")
            start = time.monotonic()
            while not page.evaluate(f"() => {rest}") and time.monotonic() - start < given.seconds:
                page.wait_for_timeout(1000)
            page.wait_for_timeout(2000)
            page.screenshot(path=str(OUTPUT))
            reached = page.evaluate("() => Math.min(...gonio.sides.map((side) => side.samples))")
            print(f"{OUTPUT}: {reached} samples per pixel in {time.monotonic() - start:.0f} s")
            browser.close()
    finally:
        viewer.shutdown()
        viewer.server_close()
        thread.join()


if __name__ == "__main__":
    main()
