"""Views of a page as one picture, side by side: picture.py REPORT OUT VIEW...

Views are what stands behind the # in the page's address; '' is its first one. The README's picture:
picture.py RUN/report.html docs/images/report.png '' 'page=compare&scene=fence&frame=2&b=vsm'
"""

import pathlib
import sys
import tempfile
import time

from browser import Browser, skip_without_chromium

WIDTH, HEIGHT, GAP = 1000, 1080, 12


def main(page, out, *views):
    from OpenImageIO import ImageBuf, ImageBufAlgo, ImageSpec

    browser = Browser(WIDTH, HEIGHT)
    picture = ImageBuf(ImageSpec(len(views) * (WIDTH + GAP) - GAP, HEIGHT, 3, "uint8"))
    ImageBufAlgo.fill(picture, [1.0, 1.0, 1.0])
    with tempfile.TemporaryDirectory() as folder:
        for i, view in enumerate(views):
            browser.open(pathlib.Path(page).resolve(), view)
            time.sleep(2)  # thumbnails are drawn when they have been seen
            shot = pathlib.Path(folder) / f"{i}.png"
            browser.driver.save_screenshot(str(shot))
            one = ImageBufAlgo.channels(ImageBuf(str(shot)), (0, 1, 2))
            ImageBufAlgo.paste(picture, i * (WIDTH + GAP), 0, 0, 0, one)
    browser.close()
    if not picture.write(out):
        raise SystemExit(picture.geterror())


if __name__ == "__main__":
    skip_without_chromium()
    main(*sys.argv[1:])
