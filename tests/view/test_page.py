# SPDX-License-Identifier: Apache-2.0
"""The page of `nephos view` in a headless Chromium: test_page.py PROGRAM [RUNS]

Every wait is for a state of the page, and has an end. Exit code 77 where Selenium or Chromium is missing."""
import hashlib
import os
import shutil
import sys
import tempfile

from view_server import SCENE, Checks, View

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError:
    webdriver = None

check = Checks()
PAGE_SCENE = SCENE + "render: {target_error: 0.5}\n" # done with few samples: more of them are not tested here
FLAGS = ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--no-first-run",
         "--disable-extensions", "--disable-background-networking", "--force-device-scale-factor=1")


# Looks every 20 ms; a fault of the expression is the answer.
WAIT = """
const [limit, answer] = arguments, end = performance.now() + limit;
const look = () => {
  let holds;
  try { holds = !!(%s); } catch (fault) { return answer(String(fault)); }
  if (holds || performance.now() > end) answer(holds); else setTimeout(look, 20);
};
look();
"""


class Page:
    """The page in a browser."""

    def __init__(self, size=(1280, 720)):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for flag in FLAGS:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(shutil.which("chromedriver")), options=options)
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                                    {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False})

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def get(self, id):
        return self.driver.find_element(By.ID, id)

    def holds(self, expression, limit=20):
        """Whether an expression of the page becomes true. The page itself looks: a request of the driver for each look
        takes more time than the picture."""
        self.driver.set_script_timeout(limit + 10)
        held = self.driver.execute_async_script(WAIT % expression, 1e3 * limit)
        assert isinstance(held, bool), (expression, held)
        return held

    def settles(self):
        """Whether the picture of the last edit becomes complete."""
        return self.holds("nephos.state && nephos.state.stage === 'done' && nephos.state.generation === nephos.state.wanted"
                          " && nephos.edits.every(e => e.refusal || e.wanted <= nephos.state.wanted)")

    def pixels(self):
        return self.run("const c = document.getElementById('picture');"
                        "return Array.from(c.getContext('2d').getImageData(0, 0, c.width, c.height).data)")

    def digest(self):
        return hashlib.sha1(bytes(self.pixels())).hexdigest()

    def write(self, id, text):
        field = self.get(id)
        self.run("arguments[0].closest('details').open = true; arguments[0].select()", field)
        field.send_keys(text + Keys.TAB)

    def drag(self, steps, key=None):
        chain = ActionChains(self.driver, duration=20).move_to_element(self.get("picture"))
        if key:
            chain.key_down(key)
        chain.click_and_hold()
        for x, y in steps:
            chain.move_by_offset(x, y)
        chain.release()
        if key:
            chain.key_up(key)
        chain.perform()


def check_start(view, page):
    check("the page starts", page.holds("window.nephos && nephos.ready"))
    check("the token is not in the address bar", view.token not in page.driver.current_url)
    check("a picture appears", page.settles())
    pixels = page.pixels()
    check("it has the scene's pixels", len(pixels) == 4 * 64 * 36)
    red = pixels[::4] # a mean has no upper bound: sunlit ground is bright, and how bright depends on the view
    check("it is lit", sum(red) / (64 * 36) > 20, sum(red) / (64 * 36))
    check("no pixel is white, and the relief shows", max(red) < 255 and max(red) - min(red) > 40, (min(red), max(red)))
    text = page.get("error").text
    check("error, noise and bias are stated", all(word in text for word in ("error", "noise", "bias", "%")), text)
    check("samples and seconds are stated", " s" in page.get("level").text and "samples" in page.get("level").text)


def check_fields(page):
    before = page.digest()
    page.write("key-terrain-albedo", "0.6")
    check("an edit is taken", page.holds("nephos.edits.length === 1 && !nephos.edits[0].refusal"))
    check("its picture comes", page.settles() and page.digest() != before)
    generation = page.run("return nephos.state.generation")
    before = page.digest()
    page.write("key-output-exposure", "4")
    check("exposure changes the pixels", page.holds("nephos.edits.length === 2 && nephos.draws.at(-1).preview >= nephos.edits[1].edit - 1")
          and page.holds("nephos.state.edit >= nephos.edits[1].edit") and page.digest() != before)
    check("without a render", page.run("return nephos.state.generation") == generation)
    page.write("key-output-exposure", "99")
    check("a refusal is shown", page.holds("document.getElementById('refusal').textContent.includes('must be')"))
    row = "document.getElementById('key-output-exposure').closest('.row')"
    check("at its field too", page.holds(f"{row}.classList.contains('bad') && {row}.textContent.includes('must be')"))
    check("for a screen reader too", page.get("key-output-exposure").get_attribute("aria-invalid") == "true")
    page.get("undo").click()
    check("undo brings the field back", page.holds("document.getElementById('key-output-exposure').value === 'auto'"))
    page.get("redo").click()
    check("redo as well", page.holds("document.getElementById('key-output-exposure').value === '4 EV'"))
    page.get("undo").click()
    page.holds("document.getElementById('key-output-exposure').value === 'auto'")


def check_hand(page):
    edits, draws = page.run("return [nephos.edits.length, nephos.draws.length]")
    page.drag([(20, 4)] * 6)
    check("a drag moves the camera", page.holds(f"nephos.edits.length > {edits} && nephos.edits.at(-1).keys.includes('camera.position')"))
    check("and shows pictures", page.holds(f"nephos.draws.length > {draws}"))
    check("up to that of the last edit", page.settles())
    position = "document.getElementById('key-camera-position').value"
    moved = page.run(f"return {position}")
    page.get("mark").click()
    page.get("undo").click()
    check("one undo takes the whole drag back", page.holds(f"{position} === '[0 m, -6 km, 400 m]' || {position} === '[0 m, -6 km, 2.5 km]'"), moved)
    page.driver.find_element(By.CSS_SELECTOR, "#bookmarks button").click()
    check("a bookmark brings the camera back", page.holds(f"{position} === {moved!r}"), moved)
    edits = page.run("return nephos.edits.length")
    page.drag([(10, -20)] * 3, Keys.CONTROL)
    check("Ctrl and a drag move the sun", page.holds(f"nephos.edits.length > {edits} && nephos.edits.at(-1).keys.includes('sun.elevation')"))
    page.get("picture").send_keys("w")
    check("W flies", page.holds("nephos.edits.at(-1).keys.includes('camera.look_at')"))
    ActionChains(page.driver).move_to_element(page.get("picture")).perform()
    check("the pixel under the pointer is read out", page.holds("['W/m²', 'τ', 'deep', 'at '].every(word => document.getElementById('pixel').textContent.includes(word))"))


def check_panel(page):
    page.get("find").send_keys("ridges relief")
    rows = "[...document.querySelectorAll('.row')].filter(r => r.offsetParent)"
    check("search shows the keys that match", page.holds(f"{rows}.length >= 1 && {rows}.every(r => r.dataset.key.startsWith('terrain.ridges'))"))
    page.run("arguments[0].value = ''; arguments[0].dispatchEvent(new Event('input'))", page.get("find"))
    check("each field has a label", page.run("return [...document.querySelectorAll('.row input, .row select')].every(f => f.labels.length || f.ariaLabel)"))
    check("no two parts have one name", page.run("const ids = [...document.querySelectorAll('#stage [id], #tools [id], #views [id], #sky [id], #plan-part [id], #bar [id]')].map(e => e.id); return new Set(ids).size === ids.length"))
    check("no file can be named", page.run("return [...document.querySelectorAll('.row')].every(r => !r.dataset.key.startsWith('output.image') || r.querySelector('input').readOnly)"))
    page.get("pin").click()
    check("a pinned picture lies beside the picture", page.holds("!document.getElementById('pinned').hidden && !document.getElementById('wipe').hidden"))
    page.run("const c = document.getElementById('channel'); c.value = 'Z'; c.dispatchEvent(new Event('change'))")
    check("a channel is shown, with its range", page.holds("document.getElementById('range').textContent.startsWith('Z:')"))
    page.run("const c = document.getElementById('channel'); c.value = '+relative_error'; c.dispatchEvent(new Event('change'))")
    check("a channel that the picture lacks is rendered", page.holds("document.getElementById('range').textContent.startsWith('relative_error:')")
          and page.holds("document.getElementById('channel').value === 'relative_error'"))
    page.run("const c = document.getElementById('channel'); c.value = ''; c.dispatchEvent(new Event('change'))")
    check("an edited key has a way back", page.holds("document.querySelector(\".row[data-key='terrain.albedo'] .reset\")?.checkVisibility()"))
    page.get("copy").click()
    check("edits can be copied for the command line", page.holds("document.querySelector('#text textarea').value.includes(\"--set 'terrain.albedo=\")"))
    page.get("text").find_element(By.TAG_NAME, "button").click()


def press(page, id, steps):
    """Drags over a canvas from its middle."""
    chain = ActionChains(page.driver, duration=20).move_to_element(page.get(id)).click_and_hold()
    for x, y in steps:
        chain.move_by_offset(x, y)
    chain.release().perform()


def check_sky(page):
    edits = page.run("return nephos.edits.length")
    press(page, "dome", [(8, 8)] * 3)
    check("the sun is dragged over the dome", page.holds(f"nephos.edits.length > {edits} && nephos.edits.at(-1).keys.includes('sun.elevation') && !nephos.edits.at(-1).refusal"))
    page.get("dome").send_keys(Keys.ARROW_UP)
    check("arrow keys raise it", page.holds("document.getElementById('dome').ariaValueText.includes('high')"))
    page.get("sun-by-time").click()
    check("a date and a time place it", page.holds("!document.getElementById('sun-date').disabled && document.getElementById('sun-clock').value === '12:00'"))
    page.get("undo").click()
    check("or its angles", page.holds("document.getElementById('sun-date').disabled"))


def check_aim(page):
    """Sun and focus by a place in the picture."""
    before = page.run("return nephos.edits.length")
    for key, text in (("camera-roll", "20 deg"), ("sun-angular-radius", "3 deg"), ("camera-look-at", "[0, 0, 3 km]")):
        page.write("key-" + key, text)
    page.get("aim-sun").click()
    press(page, "picture", [(60, -40), (60, -40)])
    page.get("aim-sun").click()
    check("the sun is placed in the picture", page.holds("nephos.edits.at(-1).keys.join() === 'sun.azimuth,sun.elevation'") and page.settles())
    pixels = page.pixels()
    place = page.run("const b = document.getElementById('picture').getBoundingClientRect(); return [120 / b.width, -80 / b.height]")
    at = [round((0.5 + share) * size - 0.5) for share, size in zip(place, (64, 36))]
    light = lambda x, y: sum(pixels[4 * (64 * y + x):][:3])
    check("it stands under the pointer", light(*at) == max(map(sum, zip(pixels[::4], pixels[1::4], pixels[2::4]))), (at, light(*at)))
    page.get("picture").send_keys("l")
    check("L puts it under the pointer, or in the middle", page.holds("nephos.edits.at(-1).keys.includes('sun.azimuth')"))
    page.get("aim-focus").click()
    ActionChains(page.driver, duration=20).move_to_element_with_offset(page.get("picture"), 0, 230).click().perform()
    page.get("aim-focus").click()
    check("a click focuses", page.holds("nephos.edits.at(-1).keys.includes('camera.focus_distance')"), page.get("refusal").text)
    check("a camera without an aperture has one then", page.holds("document.getElementById('key-camera-f-stop')?.value === '2.8'"))
    check("each is an edit that is undone alone", page.run("return nephos.edits.length") >= before + 6)
    for _ in range(6):
        page.get("undo").click()
    check("all of it is undone", page.holds("document.getElementById('key-camera-roll').value === '0 deg'") and page.settles())


def check_plan(page):
    page.run("document.getElementById('plan-part').open = true")
    eye = page.run("return document.getElementById('key-camera-position').value")
    page.run("const p = document.getElementById('preset'); p.value = 'fog'; p.dispatchEvent(new Event('change'))")
    page.get("add-cloud").click()
    check("a cloud is on the plan", page.holds("document.getElementById('plan-text').textContent.startsWith('fog')"))
    page.get("add-cloud").click()
    check("an added cloud is chosen", page.holds("document.getElementById('cloud').value === '1'"))
    page.get("remove-cloud").click()
    check("its place is the cloud's before it", page.holds("document.getElementById('cloud').value === '0'"))
    press(page, "plan", [(6, 0)] * 3)
    check("a drag moves it", page.holds("nephos.edits.at(-1).keys.includes('clouds[0].bake.center')"), page.run("return nephos.edits.at(-1)"))
    outline = "document.getElementById('plan').getContext('2d').getImageData(11, 128, 2, 1).data.some(x => x)"
    check("the plan shows more than the cloud", not page.run("return " + outline))
    page.get("plan-paint").click()
    check("the plan is the cloud's while it is painted", page.holds(outline))
    press(page, "plan", [(3, 3)] * 3)
    check("a stroke paints its coverage", page.holds("(document.getElementById('key-clouds-0-bake-map-image')?.value ?? '').includes('.png')"))
    page.get("toggle-cloud").click()
    check("a cloud is switched off", page.holds("document.getElementById('cloud').selectedOptions[0].text.endsWith('(off)')"))
    page.get("remove-cloud").click()
    check("and removed", page.holds("document.getElementById('cloud').disabled"))
    check("the camera stayed", page.run("return document.getElementById('key-camera-position').value") == eye)


def check_region(page):
    page.run("document.querySelector('#pins canvas').click()") # its line lies over the middle
    page.get("choose-region").click()
    page.drag([(20, 10)] * 3)
    check("a region is chosen by a drag", page.holds("!document.getElementById('region').hidden"))
    check("and rendered", page.settles())
    page.get("choose-region").click()
    check("and left", page.holds("document.getElementById('region').hidden") and page.settles())


# WCAG 2: 4.5 for text.
CONTRAST = """
const light = c => { const [r, g, b] = c.match(/[\\d.]+/g).map(x => x / 255).map(x => x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
const ground = e => { for (; e; e = e.parentElement) { const c = getComputedStyle(e).backgroundColor; if (!/, 0\\)$/.test(c)) return c; } return 'rgb(255,255,255)'; };
return [...document.querySelectorAll('#panel *, #bar *, #hint')].filter(e => e.offsetParent && !e.disabled && [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim()))
  .map(e => { const [a, b] = [light(getComputedStyle(e).color), light(ground(e))].sort((x, y) => y - x); return [(a + 0.05) / (b + 0.05), e.id || e.textContent]; })
  .filter(([ratio]) => ratio < 4.5)
"""


def check_file(page, path):
    """An editor writes the scene's file under the page."""
    field = lambda key: f"document.getElementById('key-{key.replace('.', '-')}').value"

    def write(text):
        with open(path + ".new", "w") as out:
            out.write(text)
        os.replace(path + ".new", path)

    page.get("save").click()
    check("the page saves", page.holds("!document.title.startsWith('•') && document.getElementById('note').textContent.startsWith('saved')"))
    saved = open(path).read()
    write(saved + "place: {latitude: 12 deg, longitude: 34 deg}\n")
    check("a file saved by an editor is read", page.holds(field("place.latitude") + " === '12 deg'"))
    check("no question is asked where nothing is edited", page.run("return document.getElementById('news').hidden"))
    check("and the picture is complete anew", page.settles())
    write("camera: {")
    check("a fault of the file is reported", page.holds("document.getElementById('message').textContent.includes('scene.yaml')"))
    check("the last good scene stays", page.run("return " + field("place.latitude")) == "12 deg" and page.pixels())
    page.write("key-terrain-albedo", "0.33")
    albedo = "[0.33, 0.33, 0.33]"
    check("the page has an edit", page.holds("document.title.startsWith('•')") and page.settles())
    check("its field has the scene's words", page.holds(f"{field('terrain.albedo')} === {albedo!r}"))
    write(saved + "place: {latitude: 13 deg, longitude: 34 deg}\n")
    page.run("const p = document.getElementById('panel'); p.scrollTop = p.scrollHeight")
    check("the page asks which wins", page.holds("!document.getElementById('news').hidden"))
    check("where it is seen", page.holds("(b => b.top >= 0 && b.bottom <= innerHeight)(document.getElementById('news').getBoundingClientRect())"))
    check("its own scene stays until then", page.run("return " + field("place.latitude")) == "12 deg")
    page.get("news-merge").click()
    check("the file is read, the edit on top", page.holds(field("place.latitude") + " === '13 deg'")
          and page.holds(f"{field('terrain.albedo')} === {albedo!r}", 5) and page.holds("document.getElementById('news').hidden"),
          (albedo, page.run("return [" + field("terrain.albedo") + ", " + field("place.latitude") + ", document.getElementById('news').hidden]")))
    write(saved + "place: {latitude: 14 deg, longitude: 34 deg}\n")
    check("the page asks again", page.holds("!document.getElementById('news').hidden"))
    page.get("news-drop").click()
    check("the edit is dropped", page.holds(field("place.latitude") + " === '14 deg'") and page.holds(f"{field('terrain.albedo')} !== {albedo!r}"))
    check("and the page is as the file", page.holds("!document.title.startsWith('•')") and page.settles())


def check_frames(program, page, folder):
    """The time line of an animation plays and scrubs."""
    path = os.path.join(folder, "frames.yaml")
    open(path, "w").write(PAGE_SCENE + "animate: {camera.position: {keys: [[1, [0, -6 km, 2500 m]], [9, [0, -6 km, 3300 m]]]}}\n")
    view = View(program, path, "--frames", "1-9")
    page.driver.get(view.url)
    check("the page of frames starts", page.holds("window.nephos && nephos.ready && nephos.state?.stage === 'done'"))
    first = page.digest()
    page.get("play").click()
    check("it plays", page.holds("nephos.frames > 12"))
    page.get("play").click()
    page.run("const f = document.getElementById('frame-slider'); f.value = 8; f.dispatchEvent(new Event('input'))")
    check("it scrubs to a frame", page.holds("nephos.state.frame === 9") and page.settles() and page.digest() != first)
    check("which is named", page.get("frame-number").text == "9")
    view.end()


def check_rest(view, page):
    faint = page.run(CONTRAST)
    check("text has the contrast of level AA", not faint, faint[:5])
    severe = [m["message"] for m in page.driver.get_log("browser") if m["level"] == "SEVERE" and " 422 " not in m["message"]]
    check("the console is clean", not severe, severe[:3])
    page.run("sessionStorage.clear()")
    page.driver.get(view.base + "/")
    check("without a token the page says so", page.holds("document.getElementById('refusal').textContent.includes('token')"))


def run(program):
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "scene.yaml")
        open(path, "w").write(PAGE_SCENE)
        view, page = View(program, path), Page()
        try:
            page.driver.get(view.url)
            check_start(view, page)
            check_fields(page)
            check_hand(page)
            check_aim(page)
            check_panel(page)
            check_sky(page)
            check_plan(page)
            check_region(page)
            check_file(page, path)
            check_rest(view, page)
            check_frames(program, page, folder)
        finally:
            page.driver.quit()
            code, seconds = view.end()
        check("the program ends within a second", code == 0 and seconds < 1.0, (code, seconds))


def main():
    if not webdriver or not shutil.which("chromium") or not shutil.which("chromedriver"):
        if os.environ.get("NEPHOS_REQUIRE_TOOLS"):
            print("python3-selenium, chromium and chromium-driver are required here")
            return 1
        print("skipped: Selenium, Chromium or its driver is missing")
        return 77
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    for number in range(1, count + 1):
        before = check.failures
        run(os.path.abspath(sys.argv[1]))
        if count > 1:
            print(f"run {number} of {count}: {check.failures - before} failures", flush=True)
    return check.failures > 0


if __name__ == "__main__":
    sys.exit(main())
