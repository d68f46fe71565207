"""A real headless Chromium for tests of pages, and for pictures of them."""

import shutil
import socket
import sys
import tempfile
import time

CHROMIUM = shutil.which("chromium")
SKIPPED = 77  # what ctest takes for a skipped test


def skip_without_chromium():
    if CHROMIUM is None:
        print("skipped: chromium is not installed (Debian packages chromium and chromium-driver)")
        sys.exit(SKIPPED)
    try:
        socket.gethostbyname("localhost")
    except socket.gaierror:
        print("skipped: nothing here knows `localhost`, by which chromedriver finds Chromium (as in a bare chroot "
              "without /etc/hosts)")
        sys.exit(SKIPPED)


class Browser:
    """One window on one profile, which is thrown away."""

    def __init__(self, width=1280, height=900, dark=False, scale=1):
        from selenium import webdriver
        from selenium.webdriver.chrome.service import Service

        self.profile = tempfile.mkdtemp(prefix="penumbra-browser-")
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for flag in [
            "headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run",
            "disable-background-networking", "disable-component-update", "disable-sync",
            "disable-dev-shm-usage", "hide-scrollbars",
            f"user-data-dir={self.profile}", f"force-device-scale-factor={scale}",
        ]:
            options.add_argument(f"--{flag}")
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(60)
        self.resize(width, height)
        self.emulate("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def close(self):
        self.driver.quit()
        shutil.rmtree(self.profile, ignore_errors=True)

    def emulate(self, command, **arguments):
        return self.driver.execute_cdp_cmd(command, arguments)

    def resize(self, width, height):
        # A headless window has a least width; the emulated screen has none.
        self.emulate("Emulation.setDeviceMetricsOverride", width=width, height=height,
                     deviceScaleFactor=0, mobile=width < 600)

    def open(self, path, view=""):
        """Loads the file anew, with `view` as its hash, and waits until the page is drawn."""
        self.driver.get("about:blank")
        self.driver.get(f"file://{path}{view and '#' + view}")
        self.drawn()

    def go(self, view):
        """A step inside the page that is open."""
        self.js("""document.querySelector("#page").dataset.drawn = "0";
                   location.hash = arguments[0];""", view)
        self.drawn()

    def drawn(self):
        self.wait("return document.readyState === 'complete' && "
                  "document.querySelector('#page')?.dataset.drawn === '1'")

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait(self, script, *arguments, seconds=30):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.js(script, *arguments)
            if value:
                return value
            time.sleep(0.05)
        raise AssertionError(f"never became true: {script}")

    def press(self, key, shift=False):
        for kind in ["keyDown", "keyUp"]:
            self.emulate("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 if shift else 0)

    def find(self, selector):
        return self.driver.find_element("css selector", selector)

    def all(self, selector):
        return self.driver.find_elements("css selector", selector)

    def texts(self, selector):
        return self.js("return [...document.querySelectorAll(arguments[0])].map((e) => e.textContent)",
                       selector)

    def complaints(self):
        """What the console has had to say since the last call."""
        return [entry["message"] for entry in self.driver.get_log("browser")
                if entry["level"] in ("SEVERE", "WARNING")]
