"""A headless Chromium on the page as it lies on the disk, and what the tests do in it."""
import os
import pathlib
import shutil
import sys
import tempfile
import time

SKIPPED = 77  # ctest's


def missing():
    """What the tests need and is not here."""
    absent = [name for name in ("chromium", "chromedriver") if not shutil.which(name)]
    try:
        import selenium  # noqa: F401
    except ImportError:
        absent.append("python3-selenium")
    return absent


class Browser:
    """Chromium by chromedriver; downloads go to a folder of their own."""

    def __init__(self, page, width=1280, height=1000, dark=False):
        from selenium import webdriver
        from selenium.webdriver.chrome.options import Options
        from selenium.webdriver.chrome.service import Service

        self.page = pathlib.Path(page).resolve()
        self.downloads = pathlib.Path(tempfile.mkdtemp())
        options = Options()
        options.binary_location = shutil.which("chromium")
        for argument in ["--headless=new", "--disable-gpu", "--disable-dev-shm-usage", f"--window-size={width},{height}",
                         *(["--no-sandbox"] if os.geteuid() == 0 else [])]:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.set_script_timeout(60)
        self.cdp("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(self.downloads))
        self.look_like(width, height, dark)

    def cdp(self, command, **arguments):
        return self.driver.execute_cdp_cmd(command, arguments)

    def look_like(self, width, height=1000, dark=False, scale=1):
        self.cdp("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=scale, mobile=False)
        self.cdp("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def open(self, fragment=""):
        """Opens the page from the disk, and waits until the law has started."""
        self.driver.get("about:blank")
        self.driver.get(self.page.as_uri() + (f"#{fragment}" if fragment else ""))
        self.wait("return Boolean(window.myogrowth)")

    def js(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def wait(self, script, *arguments, seconds=30):
        """Waits until the script gives something true, and returns that."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            if found := self.js(script, *arguments):
                return found
            time.sleep(0.02)
        raise AssertionError(f"not within {seconds} s: {script}")

    def find(self, css):
        return self.driver.find_element("css selector", css)

    def button(self, text):
        return next(b for b in self.driver.find_elements("tag name", "button") if b.text == text and b.is_displayed())

    def type(self, css, text):
        """Replaces what stands in a field, key by key."""
        from selenium.webdriver.common.keys import Keys

        element = self.find(css) if isinstance(css, str) else css
        element.send_keys(Keys.CONTROL, "a")
        element.send_keys(text)
        return element

    def text(self, css):
        return self.find(css).text

    def table(self, css):
        """The cells of a table's body."""
        return self.js("return [...document.querySelectorAll(arguments[0] + ' tbody tr')]"
                       ".map(r => [...r.children].map(c => c.textContent))", css)

    def downloaded(self, name, seconds=30):
        """The file that a button has saved."""
        path, end = self.downloads / name, time.monotonic() + seconds
        while time.monotonic() < end:
            if path.is_file() and not list(self.downloads.glob("*.crdownload")):
                return path
            time.sleep(0.02)
        raise AssertionError(f"{name} was not saved; there are {list(self.downloads.iterdir())}")

    def console(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self):
        """The addresses that the page has asked for."""
        import json

        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        return [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]

    def close(self):
        self.driver.quit()
        shutil.rmtree(self.downloads, ignore_errors=True)


def skip_without_tools(page):
    """Ends with ctest's status for a test that is skipped, and says why."""
    absent = missing()
    if not pathlib.Path(page).is_file():
        absent.append(f"{page} (web/build.py needs clang, lld, esbuild and wasi-libc)")
    if absent:
        print(f"skipped, missing: {', '.join(absent)}")
        sys.exit(SKIPPED)
