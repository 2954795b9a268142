"""Checks the built site, offline: check_site.py FOLDER [--browser]

Every link, picture, script and anchor of every page must be there. With --browser every page is opened in a headless
Chromium (by chromedriver): it must load without an error on the console, show its pictures and draw its formulas.
"""
import argparse
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import urllib.parse
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/common"))
import files  # noqa: E402  shared by all Python programs

SKIPPED = 77  # ctest's, where there is no Chromium


class Page(html.parser.HTMLParser):
    """What a page links to, and the anchors it has."""

    def __init__(self, text):
        super().__init__()
        self.links, self.anchors, self.title = [], {"", "top"}, ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.anchors.update(given[name] for name in ("id", "name") if given.get(name))
        for name in ("href", "src"):
            if given.get(name):
                self.links.append(given[name])


def broken_links(folder):
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.html"))
             if "_static" not in path.parts}
    faults, n = [], 0
    for path, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            n += 1
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            anchor = urllib.parse.unquote(parts.fragment)
            if not target.is_file():
                faults.append(f"{path.relative_to(folder)}: {link}: no such file")
            elif target in pages and anchor not in pages[target].anchors:
                faults.append(f"{path.relative_to(folder)}: {link}: no such place in the page")
    print(f"{len(pages)} pages, {n} links within the site, {len(faults)} broken")
    return pages, faults


IN_PAGE = """
const done = arguments[0];
const report = () => {
  const jax = window.MathJax ? MathJax.Hub.getAllJax() : [];
  done({
    title: document.title,
    pictures: document.images.length,
    missing: [...document.images].filter(i => !(i.complete && i.naturalWidth > 0)).map(i => i.src),
    formulas: document.querySelectorAll(".math").length,
    drawn: document.querySelectorAll(".math svg").length,
    wrong: jax.filter(j => j.texError).map(j => j.originalText),
    heading: (document.querySelector("h1") || {}).innerText || "",
  });
};
if (document.querySelector(".math")) {
  const wait = () => window.MathJax && MathJax.isReady ? MathJax.Hub.Queue(report) : setTimeout(wait, 20);
  wait();
} else {
  report();
}
"""


class Browser:
    """A headless Chromium, controlled through chromedriver's web protocol."""

    def __init__(self, driver):
        self.process = subprocess.Popen([driver, "--port=0"], stdout=subprocess.PIPE, text=True)
        for line in self.process.stdout:
            if found := re.search(r"started successfully on port (\d+)", line):
                self.address = f"http://127.0.0.1:{found.group(1)}"
                break
        options = {"args": ["--headless", "--disable-gpu", "--disable-dev-shm-usage"]
                   + (["--no-sandbox"] if os.geteuid() == 0 else [])}
        made = self.call("/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}, "timeouts": {"script": 30000}}}})
        self.session = f"/session/{made['sessionId']}"

    def call(self, path, body, method="POST"):
        request = urllib.request.Request(self.address + path, json.dumps(body).encode(), method=method,
                                         headers={"Content-Type": "application/json"})
        opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # on this machine: never through a proxy
        with opener.open(request, timeout=60) as answer:
            return json.load(answer)["value"]

    def look(self, path):
        self.call(f"{self.session}/url", {"url": path.as_uri()})
        seen = self.call(f"{self.session}/execute/async", {"script": IN_PAGE, "args": []})
        seen["console"] = [entry["message"] for entry in self.call(f"{self.session}/se/log", {"type": "browser"})
                           if entry["level"] == "SEVERE"]
        return seen

    def close(self):
        try:
            self.call(self.session, {}, method="DELETE")
        finally:
            self.process.terminate()
            self.process.wait()


def faults_in_browser(folder, pages):
    driver = shutil.which("chromedriver")
    if not driver or not (shutil.which("chromium") or shutil.which("google-chrome")):
        print("no Chromium here: not checked in a browser")
        sys.exit(SKIPPED)
    browser, faults, pictures, formulas = Browser(driver), [], 0, 0
    start = time.monotonic()
    try:
        for path in pages:
            seen, name = browser.look(path), path.relative_to(folder)
            pictures += seen["pictures"]
            formulas += seen["formulas"]
            faults += [f"{name}: picture {src} does not show" for src in seen["missing"]]
            faults += [f"{name}: formula {text} is wrong" for text in seen["wrong"]]
            faults += [f"{name}: {text}" for text in seen["console"]]
            if seen["drawn"] < seen["formulas"]:
                faults.append(f"{name}: {seen['drawn']} of {seen['formulas']} formulas are drawn")
            if not seen["heading"] and path.name != "search.html":
                faults.append(f"{name}: no heading")
    finally:
        browser.close()
    print(f"in Chromium: {len(pages)} pages, {pictures} pictures, {formulas} formulas, {len(faults)} faults, "
          f"{time.monotonic() - start:.0f} s")
    return faults


def main():
    p = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    p.add_argument("folder", type=pathlib.Path)
    p.add_argument("--browser", action="store_true")
    a = p.parse_args()
    folder = a.folder.resolve()
    pages, faults = broken_links(folder)
    if not pages:
        sys.exit(f"{folder}: no pages there")
    if a.browser:
        faults += faults_in_browser(folder, pages)
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    with files.faults_in_one_line("check_site.py"):
        main()
