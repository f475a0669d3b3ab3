"""Opens a report in headless Chromium as a reader would, through the DevTools protocol.

usage: page.py CHROMIUM PAGE.html [FOLDER_FOR_SCREENSHOTS]

Prints one JSON document: every request that left the page, every console error, the figures and whether they are drawn, what hovering over a
cell and clicking on a run show. Judging is the caller's.
"""

import base64
import json
import pathlib
import subprocess
import sys
import tempfile
import time
import urllib.request

import websocket

FIGURES = """
(() => [...document.querySelectorAll('figure svg')].map(svg => {
  const box = svg.getBoundingClientRect();
  const shapes = [...svg.querySelectorAll('path,rect,circle')].filter(n => { const b = n.getBBox(); return b.width + b.height > 1; }).length;
  return { id: svg.id || 'surface of ' + svg.dataset.of, width: box.width, height: box.height, shapes,
           bad: /NaN|undefined|Infinity/.test(svg.innerHTML) };
}))()
"""
# names and numbers in one figure that lie over each other by more than two pixels
OVERLAPS = """
(() => [...document.querySelectorAll('figure svg')].flatMap(svg => {
  const texts = [...svg.querySelectorAll('text')].map(n => [n.textContent, n.getBoundingClientRect()]);
  return texts.flatMap(([a, p], k) => texts.slice(k + 1)
    .filter(([b, q]) => Math.min(p.right, q.right) - Math.max(p.left, q.left) > 2 && Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top) > 4)
    .map(([b]) => `${svg.id || svg.dataset.of}: ${a} / ${b}`));
}))()
"""
# what sticks out of its figure, and is cut off
CLIPPED = """
(() => [...document.querySelectorAll('figure svg')].flatMap(svg => {
  const box = svg.getBoundingClientRect();
  return [...svg.querySelectorAll('text')].filter(n => { const b = n.getBoundingClientRect();
    return b.left < box.left - 1 || b.right > box.right + 1 || b.top < box.top - 1 || b.bottom > box.bottom + 1; })
    .map(n => `${svg.id || svg.dataset.of}: ${n.textContent}`);
}))()
"""
CENTRE = "(() => { const b = (%s).getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()"


class Browser:
    def __init__(self, program, profile):
        flags = ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run", "--disable-extensions",
                 "--disable-background-networking", "--disable-component-update", "--remote-debugging-port=0",
                 "--remote-allow-origins=*", "--window-size=1280,900", f"--user-data-dir={profile}", "about:blank"]
        self.process = subprocess.Popen([program, *flags], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        port_file = pathlib.Path(profile) / "DevToolsActivePort"
        for _ in range(600):
            if port_file.exists() and len(port_file.read_text().split()) > 1:
                break
            if self.process.poll() is not None:
                raise SystemExit("the browser did not start")
            time.sleep(0.1)
        port = port_file.read_text().split()[0]
        targets = json.load(urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list"))
        page = next(t for t in targets if t["type"] == "page")
        self.socket = websocket.create_connection(page["webSocketDebuggerUrl"], timeout=120)
        self.number = 0
        self.events = []

    def call(self, method, **params):
        self.number += 1
        self.socket.send(json.dumps({"id": self.number, "method": method, "params": params}))
        while True:
            message = json.loads(self.socket.recv())
            if message.get("id") == self.number:
                if "error" in message:
                    raise SystemExit(f"{method}: {message['error']}")
                return message["result"]
            self.events.append(message)

    def evaluate(self, expression):
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True)
        if "exceptionDetails" in result:
            raise SystemExit(f"{expression}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def click(self, x, y):
        self.mouse("mousePressed", x, y, button="left", clickCount=1)
        self.mouse("mouseReleased", x, y, button="left", clickCount=1)

    def open(self, url, scheme):
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        self.call("Page.navigate", url=url)
        for _ in range(600):
            if self.evaluate("document.readyState") == "complete" and self.evaluate("location.protocol") == "file:":
                return
            time.sleep(0.05)
        raise SystemExit("the page did not load")

    def shot(self, path, width=1280):
        self.evaluate("scrollTo(0, 0)")
        height = int(self.evaluate("document.documentElement.scrollHeight"))
        # a picture has no more than some 16000 rows
        for part, y in enumerate(range(0, height, 8000)):
            clip = {"x": 0, "y": y, "width": width, "height": min(8000, height - y), "scale": 1}
            data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)["data"]
            path.with_stem(f"{path.stem}_{part}" if part else path.stem).write_bytes(base64.b64decode(data))


def look(browser, url):
    found = {}
    browser.open(url, "light")
    found["background"] = browser.evaluate("getComputedStyle(document.body).backgroundColor")
    found["figures"] = browser.evaluate(FIGURES)
    found["sections"] = browser.evaluate("[...document.querySelectorAll('main section')].map(s => s.id)")
    found["verdict"] = browser.evaluate("document.querySelector('.verdict strong').textContent")
    found["overlaps"] = browser.evaluate(OVERLAPS)
    found["clipped"] = browser.evaluate(CLIPPED)
    found["overflow"] = browser.evaluate("document.documentElement.scrollWidth - innerWidth")

    # hover: the tip shows the cell's value
    cell = "document.querySelector('[data-heat=\"table1-forward\"] rect[data-c=\"4 12\"]')"
    if browser.evaluate(f"!!{cell}"):
        browser.evaluate(f"{cell}.scrollIntoView({{block: 'center'}})")
        x, y = browser.evaluate(CENTRE % cell)
        browser.mouse("mouseMoved", x, y)
        found["tip"] = browser.evaluate("document.getElementById('tip').hidden ? null : document.getElementById('tip').textContent")
        browser.mouse("mouseMoved", 5, 5)
        found["tip_gone"] = browser.evaluate("document.getElementById('tip').hidden")

    # a surface turns
    surface = "document.querySelector('svg.surface')"
    if browser.evaluate(f"!!{surface}"):
        browser.evaluate(f"{surface}.scrollIntoView({{block: 'center'}})")
        before = browser.evaluate(f"{surface}.innerHTML")
        x, y = browser.evaluate(CENTRE % surface)
        browser.mouse("mousePressed", x, y, button="left", clickCount=1)
        browser.mouse("mouseMoved", x + 60, y + 10, button="left", buttons=1)
        browser.mouse("mouseReleased", x + 60, y + 10, button="left", clickCount=1)
        found["turned"] = browser.evaluate(f"{surface}.innerHTML") != before

    # click: a run's traces open and close
    row = "document.querySelectorAll('tr.click:not(.unused)')[3]"
    if browser.evaluate(f"!!{row}"):
        browser.evaluate(f"{row}.scrollIntoView({{block: 'center'}})")
        x, y = browser.evaluate(CENTRE % f"{row}.cells[1]")
        browser.click(x, y)
        trace = f"{row}.nextElementSibling"
        found["trace"] = browser.evaluate(
            f"(() => {{ const t = {trace}; if (t.className !== 'traces') return null; const s = t.querySelector('svg');"
            " return { paths: s.querySelectorAll('path.l').length, dots: s.querySelectorAll('circle').length,"
            " bands: [...s.querySelectorAll('[data-verdict]')].map(n => n.dataset.verdict),"
            " titles: [...s.querySelectorAll('text.t')].map(n => n.textContent), bad: /NaN|undefined/.test(s.innerHTML) }; })()")
        found["shot_row"] = True
    return found


def main():
    program, page = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    folder = pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(program, profile)
        try:
            for domain in ["Page", "Runtime", "Network", "Log"]:
                browser.call(f"{domain}.enable")
            found = look(browser, page.as_uri())
            if folder:
                folder.mkdir(parents=True, exist_ok=True)
                browser.shot(folder / "light.png")
            if found.get("trace"):
                row = "document.querySelectorAll('tr.click:not(.unused)')[3]"
                browser.evaluate(f"{row}.scrollIntoView({{block: 'center'}})")
                x, y = browser.evaluate(CENTRE % f"{row}.cells[1]")
                browser.click(x, y)
                found["trace_closed"] = browser.evaluate("document.querySelectorAll('tr.traces').length === 0")
                browser.evaluate("document.querySelector('.runs th:nth-child(4)').click()")
                found["sorted"] = browser.evaluate("[...document.querySelectorAll('.runs tbody tr')].map(r => r.cells[3].textContent)")
            browser.call("Emulation.setDeviceMetricsOverride", width=420, height=900, deviceScaleFactor=1, mobile=False)
            found["narrow_overflow"] = browser.evaluate("document.documentElement.scrollWidth - innerWidth")
            if folder:
                browser.shot(folder / "narrow.png", 420)
            browser.call("Emulation.clearDeviceMetricsOverride")
            browser.open(page.as_uri(), "dark")
            found["dark_background"] = browser.evaluate("getComputedStyle(document.body).backgroundColor")
            if folder:
                browser.shot(folder / "dark.png")
            pdf = browser.call("Page.printToPDF", printBackground=True, preferCSSPageSize=True)["data"]
            found["pdf_bytes"] = len(base64.b64decode(pdf))
            if folder:
                (folder / "page.pdf").write_bytes(base64.b64decode(pdf))
            own = page.as_uri()
            requests = [e["params"]["request"]["url"] for e in browser.events if e.get("method") == "Network.requestWillBeSent"]
            found["requests"] = [u for u in requests if u.split("#")[0] != own and not u.startswith("data:")]
            found["loads"] = len([u for u in requests if u.split("#")[0] == own])
            errors = [e["params"] for e in browser.events if e.get("method") == "Runtime.exceptionThrown"]
            errors += [e["params"] for e in browser.events
                       if e.get("method") == "Runtime.consoleAPICalled" and e["params"]["type"] in ("error", "warning", "assert")]
            errors += [e["params"] for e in browser.events if e.get("method") == "Log.entryAdded"]
            found["errors"] = errors
        finally:
            browser.process.terminate()
            browser.process.wait()
    json.dump(found, sys.stdout)


main()
