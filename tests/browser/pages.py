"""Pages open in a browser, and what they can be asked."""

import json

OWN = ("file:", "data:", "about:", "chrome:", "chrome-untrusted:")
"""Addresses of the page itself, of data in it, and of the browser's own empty page."""
READY = "const done = arguments[0]; desimReplay.ready.then(done, (error) => done(String(error.stack)))"


class Opened:
    """A page of ours that is open."""

    wishes = ()
    """Media features of its reader."""

    def __init__(self, browser, place):
        """`place`: a file, or an address."""
        self.browser = browser
        browser.get_log("browser")
        browser.get_log("performance")
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": list(self.wishes)})
        browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        browser.get(place if isinstance(place, str) else place.as_uri())

    def press(self, *keys):
        from selenium.webdriver.common.action_chains import ActionChains

        ActionChains(self.browser).send_keys(*keys).perform()

    def tap(self, x, y):
        """Click on the floor at a point (CSS pixels)."""
        box = self.browser.find_element("id", "floor").rect
        point = {"x": box["x"] + x, "y": box["y"] + y, "button": "left", "clickCount": 1}
        for kind in ("mousePressed", "mouseReleased"):
            self.browser.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": kind, **point})
        self.frame()

    def click(self, name):
        self.browser.find_element("id", name).click()

    def text(self, name):
        return str(self.browser.find_element("id", name).text)

    def attribute(self, name, attribute):
        return self.browser.find_element("id", name).get_attribute(attribute)

    def pause(self, seconds):
        script = "const done = arguments[1]; setTimeout(done, arguments[0] * 1000)"
        self.browser.execute_async_script(script, seconds)

    def frame(self):
        """Wait until what was asked for has been drawn."""
        script = "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        self.browser.execute_async_script(script)

    def enlarge(self, width, height, **more):
        """See the page on a screen of another size."""
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False, **more}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.pause(0.2)

    def complaints(self):
        return [entry["message"] for entry in self.browser.get_log("browser")]

    def requests(self):
        """The addresses asked for, but for the page itself and data in it."""
        events = [json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance")]
        asked = [item["params"]["request"]["url"] for item in events if item["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if not url.startswith(OWN)]


class Page(Opened):
    """A replay page that has loaded."""

    def __init__(self, browser, run, folder, **options):
        self.run = run
        path = folder / "replay.html"
        run.replay(path, **options)
        super().__init__(browser, path)
        self.loaded = browser.execute_async_script(READY)
        assert isinstance(self.loaded, int | float), self.loaded

    def ask(self, expression, *values):
        """The value of an expression of the page's hook, `desimReplay`."""
        return self.browser.execute_script(f"const page = window.desimReplay; return {expression}", *values)

    def seek(self, time):
        self.ask("page.seek(arguments[0])", time)

    def indicator(self, key):
        return str(self.browser.find_element("css selector", f"[data-key={key}]").text)

    def until(self, condition):
        """Let the page go on until a condition on `page`, its hook, holds (or ten seconds have gone)."""
        script = (
            "const done = arguments[0], page = window.desimReplay, since = performance.now();"
            f"const look = () => ({condition}) || performance.now() - since > 1e4 ? done() : setTimeout(look, 10);"
            "look()"
        )
        self.browser.execute_async_script(script)

    def pixel(self, x, y):
        """Red, green and blue of the floor at a point (CSS pixels)."""
        [colour] = self.pixels([(x, y)])
        return colour

    def pixels(self, points):
        script = (
            "const floor = document.getElementById('floor'), ratio = floor.width / floor.clientWidth;"
            "const seen = (at) => floor.getContext('2d').getImageData(...at.map((v) => Math.round(v * ratio)), 1, 1);"
            "return arguments[0].map((at) => Array.from(seen(at).data.slice(0, 3)))"
        )
        return list(self.browser.execute_script(script, points))
