"""Opens report pages in a headless browser and tries what a reader does.

    python tests/browser/pages.py FOLDER_OR_PAGE ... [--shots FOLDER]

For each page: a verdict in one sentence on the first screen, above the first figure; a figure in the first section; no script error; nothing wider than the window at 400 px and at 1280 px, nor than the paper in print; a dark page where
the reader's system is dark; links to nothing outside; every drawing in space rotates when dragged and by the arrow keys, and its slider
changes the exaggeration, its buttons enlarge it; a click on a heading sorts its table; a chart shows the value under the pointer; a
drag across it enlarges that stretch and a double click shows all again; names of reversals in drawings in space cover no other text. Screenshots (wide, narrow, dark) and the printed page go to --shots.
Needs chromium, chromedriver and the package selenium. Exit code 1 where a page fails; the last line counts.
"""

import argparse
import base64
import concurrent.futures
import os
import pathlib
import queue
import sys

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

WIDE, NARROW = (1280, 900), (400, 800)
# width of A4 between margins of 12 mm, CSS pixels
PAPER = (703, 1000)
OUTSIDE = """
return [...document.querySelectorAll("[href], [src]")].map(e => e.getAttribute("href") ?? e.getAttribute("src"))
  .filter(a => !a.startsWith("#") && !a.startsWith("data:")).slice(0, 5);
"""
BRIGHTNESS = """
const m = getComputedStyle(document.body)[arguments[0]].match(/[0-9.]+/g).map(Number);
return (m[0] + m[1] + m[2]) / 3;
"""
VERDICT = """
const said = document.querySelector(".verdict p"), first = document.querySelector("figure svg");
if (!said) return "no verdict";
const text = said.textContent.trim();
if (text.length < 12 || !/[.!?]$/.test(text)) return "a verdict that is no sentence: " + text.slice(0, 60);
if (!/[a-z]/i.test(text) || /NaN|undefined|infinity/i.test(text)) return "a verdict with no value: " + text.slice(0, 60);
if (first && said.getBoundingClientRect().top > first.getBoundingClientRect().top) return "the verdict stands below the first figure";
const box = said.getBoundingClientRect();
return box.width > 0 && box.top + window.scrollY < window.innerHeight ? null : "the verdict is not on the first screen";
"""
SORTED = """
const out = [];
for (const table of document.querySelectorAll("main table")) {
  const heading = table.querySelector("th.sorts");
  if (!heading || table.closest("details")) continue;
  const column = () => [...table.tBodies[0].rows].map(r => r.cells[0].textContent.trim());
  const before = column();
  heading.click();
  const up = column();
  heading.click();
  const down = column();
  if ([...before].sort().join("|") !== [...up].sort().join("|")) out.push("sorting loses rows");
  if (new Set(before).size > 1 && up.join("|") === down.join("|")) out.push("a heading does not sort its table");
}
return out;
"""
HOVER = """
const plane = document.querySelector("figure svg [data-plane]");
if (!plane) return null;
const svg = plane.closest("svg");
svg.scrollIntoView({block: "center"});
const box = svg.getBoundingClientRect();
svg.dispatchEvent(new PointerEvent("pointermove", {clientX: box.left + 0.6 * box.width, clientY: box.top + 0.5 * box.height, bubbles: true}));
return svg.querySelector(".readout").textContent;
"""
ZOOM = """
const svg = arguments[0], plane = svg.querySelector("[data-plane]").dataset.plane.split(" ").map(Number);
const shown = [...svg.querySelectorAll("text.tick[text-anchor=middle]")].filter(t => t.style.display !== "none");
return {
  name: svg.getAttribute("aria-label"), labels: shown.map(t => t.textContent), button: !svg.parentNode.querySelector("button.whole").hidden,
  outside: shown.filter(t => t.getAttribute("x") < plane[2] - 1 || t.getAttribute("x") > plane[3] + 1).map(t => t.textContent),
};
"""
COVERED = """
const out = [];
for (const svg of document.querySelectorAll(".space figure svg")) {
  const names = [...svg.querySelectorAll("text.mark-name")];
  const section = svg.closest("section");
  const others = [...svg.querySelectorAll("text:not(.mark-name)"), ...section.querySelectorAll("h2, .caption, .legend li, figcaption")];
  const boxes = (all) => all.map(e => [e.textContent.trim().slice(0, 40), e.getBoundingClientRect()]).filter(([, r]) => r.width > 0);
  const meet = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 2 && b.top < a.bottom - 2;
  const named = boxes(names);
  named.forEach(([text, box], k) => {
    for (const [other, r] of [...boxes(others), ...named.slice(k + 1)]) if (meet(box, r)) out.push(text + " on " + other);
  });
}
return out.slice(0, 5);
"""
OVERFLOW = """
const w = document.documentElement.clientWidth, out = [];
if (document.documentElement.scrollWidth > w + 1) {
  for (const e of document.querySelectorAll("body *")) {
    const scrolls = (n) => n && (["auto", "scroll"].includes(getComputedStyle(n).overflowX) || scrolls(n.parentElement));
    if (e.getBoundingClientRect().right > w + 1 && !scrolls(e)) out.push(e.tagName + "." + (e.className.baseVal ?? e.className));
  }
}
return out.slice(0, 5);
"""


def browser():
    options = webdriver.ChromeOptions()
    for flag in (
        "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars",
    ):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    options.binary_location = "/usr/bin/chromium"
    return webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))


def resized(driver, size):
    """The window's inner size, which headless windows do not take from the outer one below 500 px."""
    driver.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False},
    )


def gestures(driver):
    """Gestures of a pointer that takes 20 ms for a movement, not a quarter of a second: a page must answer to either."""
    return ActionChains(driver, duration=20)


def drawing_answers(driver, box):
    """Faults of one drawing in space."""
    faults = []
    figure = box.find_element(By.CSS_SELECTOR, "figure svg")
    path = lambda: [p.get_attribute("d") for p in box.find_elements(By.CSS_SELECTOR, "figure svg [data-line]")]
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", figure)
    before = path()
    gestures(driver).move_to_element(figure).click_and_hold().move_by_offset(60, 25).release().perform()
    dragged = path()
    if dragged == before:
        faults.append("dragging does not rotate the drawing")
    driver.execute_script("arguments[0].focus()", figure)
    gestures(driver).send_keys(Keys.ARROW_LEFT).perform()
    if path() == dragged:
        faults.append("the arrow keys do not rotate the drawing")
    for slider in box.find_elements(By.CSS_SELECTOR, ".controls input"):
        shown = box.find_element(By.CSS_SELECTOR, ".controls output").text
        slider.send_keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
        if box.find_element(By.CSS_SELECTOR, ".controls output").text == shown:
            faults.append("the slider does not change the exaggeration")
    box.find_element(By.CSS_SELECTOR, ".controls .view").click()
    whole = path()
    box.find_element(By.CSS_SELECTOR, ".controls .nearer").click()
    if path() == whole:
        faults.append("the drawing in space does not come nearer")
    box.find_element(By.CSS_SELECTOR, ".controls .view").click()
    if path() != whole:
        faults.append("the isometric view does not come back")
    return faults


def zoom_answers(driver):
    """Faults of the zoom of all charts and other drawings."""
    faults = []
    for figure in driver.find_elements(By.CSS_SELECTOR, "main figure svg.zooms"):
        if not figure.is_displayed():
            continue
        state = lambda: driver.execute_script(ZOOM, figure)
        driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", figure)
        before = state()
        wide = figure.size["width"]
        gestures(driver).move_to_element_with_offset(figure, -0.1 * wide, 0).click_and_hold().move_by_offset(0.25 * wide, 0).release().perform()
        inside = state()
        if inside["labels"] == before["labels"] or not inside["button"]:
            faults.append(f"a drag does not enlarge the chart \"{before['name']}\"")
        if inside["outside"]:
            faults.append(f"labels outside of the enlarged chart \"{before['name']}\": {inside['outside']}")
        # slowly: right after a drag the browser would count a third click
        ActionChains(driver).double_click(figure).perform()
        after = state()
        if after["labels"] != before["labels"] or after["button"]:
            faults.append(f"a double click does not show all of the chart \"{before['name']}\"")
    for figure in driver.find_elements(By.CSS_SELECTOR, "main figure svg:not(.zooms):not(.turns)"):
        if not figure.is_displayed() or not figure.get_attribute("tabindex"):
            continue
        box = figure.get_dom_attribute("viewBox")
        driver.execute_script("arguments[0].scrollIntoView({block: 'center'}); arguments[0].focus()", figure)
        gestures(driver).send_keys("+").perform()
        if figure.get_dom_attribute("viewBox") == box:
            faults.append("the key + does not enlarge a drawing")
        gestures(driver).send_keys("0").perform()
        if figure.get_dom_attribute("viewBox") != box:
            faults.append("the key 0 does not show all of a drawing")
    return faults


def in_media(driver, media, scheme):
    driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"media": media, "features": [{"name": "prefers-color-scheme", "value": scheme}]}
    )


def other_media(driver, page, shots):
    """Faults in the dark and on paper."""
    faults = []
    resized(driver, WIDE)
    in_media(driver, "screen", "dark")
    driver.get(page.as_uri())
    ground, ink = (driver.execute_script(BRIGHTNESS, name) for name in ("backgroundColor", "color"))
    if not (ground < 60 and ink > 180):
        faults.append(f"in the dark the page has brightness {ground:.0f} and its text {ink:.0f}")
    if shots:
        driver.get_screenshot_as_file(str(shots / f"{page.stem}.dark.png"))
    resized(driver, PAPER)
    in_media(driver, "print", "dark")
    driver.get(page.as_uri())
    if driver.execute_script(BRIGHTNESS, "color") > 100:
        faults.append("light text on paper")
    wide = driver.execute_script(OVERFLOW)
    if wide:
        faults.append(f"wider than A4: {', '.join(wide)}")
    in_media(driver, "", "light")
    pdf = base64.b64decode(driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True, "preferCSSPageSize": True})["data"])
    if not pdf.startswith(b"%PDF") or len(pdf) < 5000:
        faults.append("does not print")
    if shots:
        (shots / f"{page.stem}.pdf").write_bytes(pdf)
    return faults


def faults_of(driver, page, shots):
    faults = other_media(driver, page, shots)
    for name, size in (("wide", WIDE), ("narrow", NARROW)):
        resized(driver, size)
        driver.get(page.as_uri())
        wide = driver.execute_script(OVERFLOW)
        if wide:
            faults.append(f"wider than the window at {size[0]} px: {', '.join(wide)}")
        covered = driver.execute_script(COVERED) if name == "wide" else []
        if covered:
            faults.append(f"names that cover others: {', '.join(covered)}")
        if shots:
            driver.get_screenshot_as_file(str(shots / f"{page.stem}.{name}.png"))
    resized(driver, WIDE)
    driver.get(page.as_uri())
    outside = driver.execute_script(OUTSIDE)
    if outside:
        faults.append(f"links outside: {', '.join(outside)}")
    if not driver.execute_script("return document.querySelector('main section').querySelector('figure svg') !== null"):
        faults.append("does not open with a figure")
    said = driver.execute_script(VERDICT)
    if said:
        faults.append(said)
    for box in driver.find_elements(By.CSS_SELECTOR, ".space"):
        faults += drawing_answers(driver, box)
    faults += zoom_answers(driver)
    faults += driver.execute_script(SORTED)
    shown = driver.execute_script(HOVER)
    if shown is not None and not any(c.isdigit() for c in shown):
        faults.append("a chart shows no value under the pointer")
    faults += [e["message"] for e in driver.get_log("browser") if e["level"] == "SEVERE"]
    return faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="+", type=pathlib.Path)
    parser.add_argument("--shots", type=pathlib.Path)
    args = parser.parse_args()
    pages = sorted(p for a in args.pages for p in (a.rglob("*.html") if a.is_dir() else [a]))
    if not pages:
        sys.exit("no page found")
    if args.shots:
        args.shots.mkdir(parents=True, exist_ok=True)
    failed = 0
    # a browser for each processor; the pages are told in their order
    drivers = queue.SimpleQueue()
    many = min(len(pages), os.cpu_count() or 1)
    for _ in range(many):
        drivers.put(browser())

    def faults_by_any(page):
        driver = drivers.get()
        try:
            return faults_of(driver, page.resolve(), args.shots)
        finally:
            drivers.put(driver)

    with concurrent.futures.ThreadPoolExecutor(many) as pool:
        for page, faults in zip(pages, pool.map(faults_by_any, pages)):
            failed += bool(faults)
            print(f"{page}: {'ok' if not faults else '; '.join(faults)}", flush=True)
    for _ in range(many):
        drivers.get().quit()
    print(f"{len(pages) - failed} passed, {failed} failed")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
