"""Size, first paint and times of a page: measure.py REPORT"""

import pathlib
import statistics
import sys
import time

from browser import Browser, skip_without_chromium

LOADS = 9


def main(page):
    path = pathlib.Path(page).resolve()
    print(f"size {path.stat().st_size / 1e6:.1f} MB")
    browser = Browser()
    paints, loads, views = [], [], []
    for _ in range(LOADS):
        browser.open(path)
        paint, load = browser.js("""
            const entry = performance.getEntriesByName("first-contentful-paint")[0];
            return [entry.startTime, performance.getEntriesByType("navigation")[0].loadEventEnd]""")
        paints.append(paint)
        loads.append(load)
        start = time.monotonic()
        browser.go("page=compare")
        views.append(1e3 * (time.monotonic() - start))
    browser.close()
    for name, times in [("first contentful paint", paints), ("all data read", loads),
                        ("to the comparison view", views)]:
        print(f"{name}: median {statistics.median(times):.0f} ms, {min(times):.0f} to {max(times):.0f} ms")


if __name__ == "__main__":
    skip_without_chromium()
    main(sys.argv[1])
