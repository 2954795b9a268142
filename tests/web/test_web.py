"""The page of web/ in a headless Chromium, driven as a person would, and its numbers against the native programs.

test_web.py ROOT BUILD PAGE CLASS      PAGE: index.html, as web/build.py has made it
"""
import base64
import csv
import ctypes
import io
import json
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import types
import unittest
import urllib.parse
import xml.etree.ElementTree

from browser import Browser, skip_without_tools

ROOT, BUILD, PAGE = (pathlib.Path(sys.argv.pop(1)).resolve() for _ in range(3))
sys.path.insert(0, str(ROOT / "examples/common"))
STUDIES = BUILD / "examples"
N_PROPS, N_STATE = 18, 9
TABLE_1 = {"tau": 0.5, "gamma": 2, "G_max": 1.1, "lambda_crit": 1.01}


class Page(unittest.TestCase):
    """One browser for the tests of a class. No test may leave an error on the console or ask for anything."""

    @classmethod
    def setUpClass(cls):
        cls.browser = Browser(PAGE)
        cls.addClassCleanup(cls.browser.close)

    def setUp(self):
        for file in self.browser.downloads.iterdir():
            file.unlink()
        self.browser.open()

    def tearDown(self):
        self.assertEqual(self.browser.console(), [])
        asked = [url for url in self.browser.requests() if not re.match(r"(file|data|blob|about):", url)]
        self.assertEqual(asked, [])

    def tab(self, name):
        self.browser.find(f"#tab_{name}").click()

    def close_to(self, a, b, tolerance, message=""):
        self.assertLessEqual(abs(a - b), tolerance * max(abs(b), 1e-300), f"{message}: {a} and {b}")


def native(program, *arguments):
    """The report.json of a study's program."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([STUDIES / program, *map(str, arguments), "--out", folder], check=True, capture_output=True)
        return json.loads((pathlib.Path(folder) / "report.json").read_text())


def refusal(program, *arguments):
    """What a study's program says of a bad file."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([STUDIES / program, *map(str, arguments), "--out", folder], capture_output=True, text=True)
    return run.returncode, run.stderr


# ---- Numbers: the law in the page is the native library

IN_PAGE = """
const [kind, points] = arguments, law = window.myogrowth.law, wasm = law.wasm;
const size = 8 * 200, at = {};
for (const name of ["props", "F", "state", "stress", "tangent", "energy", "lateral", "modulus"]) at[name] = wasm.malloc(size);
const put = (address, values) => new Float64Array(wasm.memory.buffer).set(values, address / 8);
const get = (address, n) => [...new Float64Array(wasm.memory.buffer).slice(address / 8, address / 8 + n)];
const done = points.map((p) => {
  put(at.props, p.props);
  put(at.state, p.state);
  let status, result;
  if (kind === "update") {
    put(at.F, p.F);
    const n = [6, 9, 6][p.measure];
    status = wasm.myogrowth_update(at.props, 18, at.F, at.state, at.state, 9, p.dt, p.measure, at.stress, at.tangent,
      at.energy, law.at.message, 400);
    result = {stress: get(at.stress, n), tangent: get(at.tangent, n * n), energy: get(at.energy, 1)};
  } else {
    put(at.lateral, [0]);
    status = wasm.myogrowth_uniaxial(at.props, 18, p.stretch, at.state, at.state, 9, p.dt, at.lateral, at.stress,
      at.modulus, at.energy, law.at.message, 400);
    result = {stress: get(at.stress, 1), lateral: get(at.lateral, 1), modulus: get(at.modulus, 1), energy: get(at.energy, 1)};
  }
  return Object.assign(result, {status, message: law.text(law.at.message), state: get(at.state, 9)});
});
for (const name of Object.keys(at)) wasm.free(at[name]);
return done;
"""


class Numbers(Page):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.library = ctypes.CDLL(BUILD / "abi/libmyogrowth.so")
        cls.browser.open()

    def native_update(self, kind, p):
        doubles = lambda values: (ctypes.c_double * len(values))(*values)  # noqa: E731
        props, state, message = doubles(p["props"]), doubles(p["state"]), ctypes.create_string_buffer(400)
        stress, tangent, energy = doubles([0] * 9), doubles([0] * 81), ctypes.c_double()
        lateral, modulus = ctypes.c_double(0), ctypes.c_double()
        dt = ctypes.c_double(p["dt"])
        if kind == "update":
            n = [6, 9, 6][p["measure"]]
            status = self.library.myogrowth_update(props, N_PROPS, doubles(p["F"]), state, state, N_STATE, dt, p["measure"],
                                                   stress, tangent, ctypes.byref(energy), message, 400)
            result = {"stress": stress[:n], "tangent": tangent[:n * n], "energy": [energy.value]}
        else:
            status = self.library.myogrowth_uniaxial(props, N_PROPS, ctypes.c_double(p["stretch"]), state, state, N_STATE, dt,
                                                     ctypes.byref(lateral), stress, ctypes.byref(modulus),
                                                     ctypes.byref(energy), message, 400)
            result = {"stress": stress[:1], "lateral": [lateral.value], "modulus": [modulus.value], "energy": [energy.value]}
        return {**result, "status": status, "message": message.value.decode(), "state": state[:]}

    def random_point(self, r):
        removal = r.random() < 0.3
        crit = r.uniform(0.95, 1.1)
        props = [r.uniform(1, 100), r.uniform(1, 50), 10**r.uniform(-2, 2), r.uniform(0, 8), 1 + 10**r.uniform(-2, 1), crit,
                 r.gauss(0, 1), r.gauss(0, 1), r.gauss(0, 1), 0, r.randint(0, 1), r.randint(0, 1), 0,
                 *([10**r.uniform(-1, 1), r.uniform(0, 4), r.uniform(0.1, 0.9), r.uniform(0.8, crit)] if removal else [0] * 4),
                 0]
        if r.random() < 0.05:
            props[r.randrange(6)] = -1
        G = r.uniform(0.95, min(props[4], 2) if props[4] > 1 else 1.5)
        F = [(1 if i in (0, 4, 8) else 0) + r.uniform(-0.25, 0.25) for i in range(9)]
        return {"props": props, "F": F, "state": [G, 1, r.uniform(0.8, 1.3), 1, 1, 0, 0, 0, 0], "dt": 10**r.uniform(-3, 3),
                "measure": r.randrange(3), "stretch": r.uniform(0.7, 1.6)}

    def compare(self, kind, points):
        worst, statuses, n = {}, set(), 0
        for p, page in zip(points, self.browser.js(IN_PAGE, kind, points)):
            here = self.native_update(kind, p)
            self.assertEqual((page["status"], page["message"]), (here["status"], here["message"]), p)
            statuses.add(page["status"])
            if page["status"] != 0:
                continue
            n += 1
            elastic = p["props"][0] + p["props"][1]  # stress and energy may cancel: against the moduli
            for name in page.keys() - {"status", "message"}:
                scale = max(map(abs, here[name]))
                if name in ("stress", "energy"):
                    scale = max(scale, 0.01 * elastic)
                error = max(abs(a - b) for a, b in zip(page[name], here[name])) / scale
                worst[name] = max(worst.get(name, 0), error)
                self.assertLessEqual(error, 1e-12, (name, p))
        print(f"{len(points)} points, {kind}, {n} with a result: " + ", ".join(f"{k} {v:.1e}" for k, v in sorted(worst.items())))
        return statuses

    def test_a_thousand_random_points(self):
        r = random.Random(20)
        points = [self.random_point(r) for _ in range(1000)]
        self.assertLessEqual({0, 5}, self.compare("update", points))
        self.assertLessEqual({0, 5}, self.compare("uniaxial", points))

    def test_whole_histories(self):
        """Strips through five protocols and three presets: all that the page computes with, step after step."""
        worst, r = 0, random.Random(1)
        for case in range(40):
            muscle = {"c1": r.uniform(5, 50), "c2": r.uniform(2, 20), "tau": 10**r.uniform(-1, 1), "gamma": r.uniform(0, 6),
                      "G_max": 1 + 10**r.uniform(-1.5, 0.3), "lambda_crit": r.uniform(1, 1.05)}
            time_, stretch, t = [0.0], [1.0], 0.0
            for _ in range(150):
                t += 10**r.uniform(-3, 0)
                time_.append(t)
                stretch.append(min(max(stretch[-1] + r.uniform(-0.02, 0.03), 0.9), 1.8))
            page = self.browser.js("""
                const [muscle, time, stretch] = arguments, law = window.myogrowth.law;
                const points = {time: Float64Array.from(time), stretch: Float64Array.from(stretch)};
                const run = law.pull(muscle, points);
                return {G: [...run.G], lambda_e: [...run.lambda_e], force: [...run.force], grown: [...law.grow(muscle, points)]};
                """, muscle, time_, stretch)
            props = [*muscle.values(), 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0]
            state, lateral, message = [1.0, 1, 1, 0, 0, 0, 0, 0, 0], ctypes.c_double(1), None
            double = ctypes.c_double
            c_state, c_props, stress = (double * 9)(*state), (double * N_PROPS)(*props), double()
            for i, (t, x) in enumerate(zip(time_, stretch)):
                dt = t - time_[i - 1] if i else 0
                status = self.library.myogrowth_uniaxial(c_props, N_PROPS, double(x), c_state, c_state, N_STATE, double(dt),
                                                         ctypes.byref(lateral), ctypes.byref(stress), None, None, message, 0)
                self.assertEqual(status, 0)
                for a, b, scale in ((page["G"][i], c_state[0], 1), (page["lambda_e"][i], c_state[1], 1),
                                    (page["force"][i], stress.value * c_state[3] / x, muscle["c1"])):
                    worst = max(worst, abs(a - b) / scale)
            # Growth alone: backward Euler in whole and half steps, extrapolated.
            c_props[11] = 0
            whole = half = 1.0
            for i in range(1, len(time_)):
                def grown(G, x, dt):
                    s, F, P = (double * 9)(G, 1, x), (double * 9)(x, 0, 0, 0, 1, 0, 0, 0, 1), (double * 9)()
                    self.assertEqual(self.library.myogrowth_update(c_props, N_PROPS, F, s, s, N_STATE, double(dt), 1, P, None,
                                                                   None, None, 0), 0)
                    return s[0]
                dt = time_[i] - time_[i - 1]
                whole = grown(whole, stretch[i], dt)
                half = grown(grown(half, (stretch[i] + stretch[i - 1]) / 2, dt / 2), stretch[i], dt / 2)
                worst = max(worst, abs(page["grown"][i] - (2 * half - whole)))
        print(f"40 histories of 150 steps: {worst:.1e}")
        self.assertLessEqual(worst, 1e-12)

    def test_the_tables_are_the_librarys(self):
        table = self.browser.js("return window.myogrowth.law.table.map(e => [e.symbol, e.unit, e.meaning, e.allowed])")
        for i, row in enumerate(table):
            for name, text in zip(("symbol", "unit", "meaning", "allowed"), row):
                function = getattr(self.library, f"myogrowth_prop_{name}")
                function.restype = ctypes.c_char_p
                self.assertEqual(text, function(i).decode())
        self.assertEqual(len(table), self.library.myogrowth_n_props())


# ---- Play

class Play(Page):
    def numbers(self):
        return {key: float(self.browser.text(f"#n_{key}")) for key in ("peak", "returned5", "returned3", "returned2", "finalG")}

    def test_exact_numbers(self):
        """Against examples/common/eq4.py, which solves eq. 4 to nine digits without the library's code."""
        import eq4
        for values in ({"stretch": 1.1, "ramp": 1, "days": 42}, {"stretch": 1.09, "ramp": 0.1, "days": 200, "gamma": 1,
                       "tau": 2}, {"stretch": 1.15, "ramp": 1, "days": 80, "G_max": 1.3, "lambda_crit": 1.0, "gamma": 3}):
            self.browser.open(urllib.parse.urlencode({**values, "hold": 3650}))
            page = self.numbers()
            a = types.SimpleNamespace(**{**TABLE_1, **values})
            times = [a.ramp, *(page[f"returned{percent}"] for percent in (5, 3, 2)), a.days]
            peak, *returned, last = a.stretch / eq4.exact(a, times)
            self.assertAlmostEqual(page["peak"], peak, delta=6e-6)  # five decimals are shown
            self.assertAlmostEqual(page["finalG"], a.stretch / last, delta=6e-6)
            for x, level in zip(returned, (1.05, 1.03, 1.02)):
                self.assertAlmostEqual(x, level, delta=5e-5, msg=values)  # the day has three decimals

    def test_a_slider_moves_the_curves(self):
        from selenium.webdriver.common.keys import Keys

        before = self.numbers()
        slider = self.browser.find("[name=stretch_slider]")
        for _ in range(3):
            slider.send_keys(Keys.ARROW_LEFT)
        self.assertLess(float(self.browser.js("return arguments[0].value", self.browser.find("[name=stretch]"))), 1.1)
        self.assertLess(self.numbers()["peak"], before["peak"])
        self.assertIn("1.0", slider.get_attribute("aria-valuetext"))
        took = self.browser.js("""
            const times = [], slider = document.querySelector("[name=stretch_slider]");
            for (let i = 0; i < 30; ++i) {
              slider.value = 1 + 0.005 * i;
              slider.dispatchEvent(new Event("input"));
              times.push(window.myogrowth.milliseconds);
            }
            return times.sort((a, b) => a - b)[15];""")
        print(f"six weeks are drawn again in {took:.0f} ms")
        self.assertLess(took, 50)

    def test_bad_numbers_are_named_where_they_stand(self):
        for name, text, words in (("stretch", "1,1", "Stretch: expected a number from 0.5 to 3, found '1,1': decimal comma? write "
                                   "1.1."), ("ramp", "-1", "Ramp: expected a number from 0 to 3650, found '-1'."),
                                  ("G_max", "0.9", "G_max = 0.9: must be finite and > 1."), ("tau", "", "found ''")):
            field = self.browser.find(f"[name={name}]")
            value = self.browser.js("return arguments[0].value", field)
            if text:
                self.browser.type(field, text)
            else:
                self.browser.js("arguments[0].value = ''; arguments[0].dispatchEvent(new Event('input'))", field)
            self.assertEqual(field.get_attribute("aria-invalid"), "true")
            self.assertIn(words, self.browser.text(f"#{field.get_attribute('aria-describedby')}"))
            self.browser.type(field, value)
            self.assertEqual(field.get_attribute("aria-invalid"), "false")

    def test_what_has_no_result_is_said(self):
        """No curve of earlier inputs stays beside inputs that have none, and no error on the console."""
        self.browser.type("[name=c1]", "1e308")
        self.assertIn("There is no result for these inputs: ", self.browser.text("#no_result"))
        self.assertFalse(self.browser.find("#numbers").is_displayed())
        self.browser.type("[name=c1]", "16")
        self.assertEqual(self.browser.text("#no_result"), "")
        self.assertTrue(self.browser.find("#numbers").is_displayed())
        self.browser.open("tab=design&target=9.9&design_limit=1.02&G_max=1e6&gamma=0&tau=30")
        self.assertIn("time steps", self.browser.wait("return document.getElementById('no_result').textContent"))

    def test_ranges_that_the_muscle_makes_wrong_are_said(self):
        self.browser.open("range_lambda_crit=0.9:0.95&tau_rev=1&lambda_crit_rev=0.9")
        self.browser.js("document.querySelectorAll('details').forEach(d => { d.open = true; })")
        self.browser.type("[name=lambda_crit_rev]", "0.97")
        self.assertIn("No band, because of a range", self.browser.wait("return document.getElementById('band_fault').textContent"))
        self.tab("uncertainty")
        self.assertIn("λ_crit, from: lambda_crit_rev = 0.97", self.browser.text("#range_fault"))
        self.assertFalse(self.browser.find("#percentiles").is_displayed())

    def test_more_sarcomeres_than_can_be_drawn(self):
        self.browser.open("lambda_crit=0.01&G_max=1e9&tau=1e-9&gamma=0")
        self.assertIn("Of 1320 sarcomeres, 12 at the beginning, 200 are drawn.", self.browser.text("#panel_play .picture"))

    def test_presets_are_those_of_fit(self):
        self.browser.js("""const s = document.querySelector("[name=preset]"); s.value = "boakes_2007";
                           s.dispatchEvent(new Event("change"));""")
        self.assertEqual(self.browser.js("return window.myogrowth.model.muscle.G_max"), 2.6256)
        self.assertIn("Boakes", self.browser.text(".muscle .note"))
        if (STUDIES / "study_fit").is_file():
            subprocess.run([sys.executable, ROOT / "web/presets.py", STUDIES / "study_fit", "--check"], check=True)

    def test_hover_shows_values_and_a_day_can_be_read_by_keyboard(self):
        from selenium.webdriver import ActionChains
        from selenium.webdriver.common.keys import Keys

        plot = self.browser.find("#panel_play .chart .u-over")
        self.browser.js("arguments[0].scrollIntoView({block: 'center'})", plot)
        ActionChains(self.browser.driver).move_to_element(plot).perform()
        self.browser.wait("return /day\\D*2\\d\\.\\d\\d/.test(document.querySelector('#panel_play .u-legend').innerText)")
        self.assertRegex(self.browser.text("#panel_play .u-legend"), r"1\.0\d\d\d")
        self.browser.find("[name=day]").send_keys(Keys.HOME)
        self.assertIn("Day 0.00: λ 1.0000, λe 1.0000, G 1.0000, force 0.000 kPa", self.browser.text("#readout"))
        self.assertIn("12.0 sarcomeres", self.browser.text("#panel_play .note"))

    def test_release(self):
        self.browser.open("stretch=1.1&ramp=1&hold=10&days=42")
        self.assertAlmostEqual(float(self.browser.text("#n_finalLambda")), 1 / float(self.browser.text("#n_finalG")), delta=2e-5)

    def test_the_band_holds_the_curve_for_every_preset(self):
        for preset in self.browser.js("return [...document.querySelector('[name=preset]').options].map(o => o.value)")[1:]:
            self.browser.js("""const s = document.querySelector("[name=preset]"); s.value = arguments[0];
                               s.dispatchEvent(new Event("change"));""", preset)
            self.browser.wait("return window.myogrowth.model && document.querySelector('#panel_play canvas') && "
                              "/95 %.*between [0-9.]+/.test(document.querySelector('#panel_play canvas').ariaLabel)")


# ---- Links and files

class Compare(Page):
    def setUp(self):
        super().setUp()
        self.tab("compare")

    def open_files(self, *names):
        inputs = self.browser.find("input[type=file]")
        inputs.send_keys("\n".join(str(ROOT / "examples/protocols" / name) for name in names))

    def test_the_files_of_run_protocol_and_its_numbers(self):
        while self.browser.driver.find_elements("css selector", ".programme"):
            self.browser.button("Remove programme").click()
        names = ["step1.csv", "step2.csv", "step4.csv", "continuous.csv"]
        self.open_files(*names, "muscle.csv")
        rows = self.browser.wait("const n = document.querySelectorAll('#comparison tbody tr'); return n.length === 4 && "
                                 "[...n].map(r => [...r.children].map(c => c.textContent))")
        self.browser.type("[name=limit]", "1.07")
        rows = {row[0]: row for row in self.browser.table("#comparison")}
        report = native("study_protocol", *(ROOT / "examples/protocols" / n for n in names), "--injury", 1.07)
        for p in report["protocols"]:
            row = rows[p["title"]]
            for cell, key in zip(row[1:6] + row[7:], ("end_of_lengthening", "peak_lambda_e", "peak_day", "days_above_injury",
                                                      "dose_above_injury", "peak_force", "final_G")):
                self.assertAlmostEqual(float(cell), p[key], delta=0.5001 * 10**-len(cell.split(".")[1]), msg=(p["title"], key))
            self.assertEqual(row[6], "always" if p["returned"] == 0 else f"{p['returned']:.2f}")
        # The curves that it saves are those of the program.
        self.browser.button("Save curves as CSV").click()
        curves = list(csv.DictReader(io.StringIO(self.browser.downloaded("curves.csv").read_text())))
        for p in report["protocols"]:
            mine = [row for row in curves if row["programme"] == p["title"]]
            self.assertEqual(len(mine), len(p["run"]["time"]))
            for name, key in (("day", "time"), ("G", "G"), ("lambda_e", "lambda_e"), ("force_per_reference_area", "force")):
                for row, x in zip(mine, p["run"][key]):
                    self.assertAlmostEqual(float(row[name]), x, delta=2e-9 * max(1, abs(x)))

    def test_drop(self):
        text = (ROOT / "examples/protocols/step8.csv").read_text().replace("include, muscle.csv", "set, G_max, 1.3")
        self.browser.js("""
            const data = new DataTransfer();
            data.items.add(new File([arguments[0]], "step8.csv"));
            window.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));""", text)
        self.browser.wait("return document.querySelectorAll('#comparison tbody tr').length === 3")
        self.assertEqual(self.browser.table("#comparison")[2][0], "8 steps in 14 days")
        self.assertIn("G_max = 1.3", self.browser.text(".p2"))

    def test_cycles(self):
        """Eight hours a day: the page's row `cycle` and its programme, saved, against ./run protocol."""
        self.browser.js("""
            const data = new DataTransfer();
            data.items.add(new File(["title, eight hours a day\\nramp, 1.02, 2\\ncycle, 1.08, 8, 1, 5\\n"], "cycle.csv"));
            window.dispatchEvent(new DragEvent("drop", {dataTransfer: data, bubbles: true, cancelable: true}));""")
        row = self.browser.wait("const r = document.querySelectorAll('#comparison tbody tr'); "
                                "return r.length === 3 && [...r[2].children].map(c => c.textContent)")
        self.browser.button("Save programmes as CSV").click()
        saved = self.browser.downloaded("programme3.csv")
        self.assertIn("cycle, 1.08, 8, 1, 5", saved.read_text())
        protocol, = native("study_protocol", saved, "--set", "G_max=1.1")["protocols"]
        self.assertAlmostEqual(float(row[2]), protocol["peak_lambda_e"], delta=6e-5)
        self.assertAlmostEqual(float(row[8]), protocol["final_G"], delta=2e-3)  # the page's lasts longer: all end together

    def test_edit_by_keyboard(self):
        from selenium.webdriver.common.keys import Keys

        n = len(self.browser.table("#comparison"))
        self.browser.button("Add a programme").send_keys(Keys.ENTER)
        self.assertEqual(len(self.browser.table("#comparison")), n + 1)
        row = "[aria-label='Row 1: to stretch']"
        field = self.browser.driver.find_elements("css selector", f".p2 {row}")[0]
        self.browser.type(field, "1.07")
        self.browser.type(self.browser.find(".p2 [aria-label='Row 1: within days']"), "14")
        self.assertEqual(self.browser.table("#comparison")[2][1], "14.00")
        # A row of repeats: 3 times 2 rows.
        kind = self.browser.find(".p2 [aria-label='Row 2: What to do']")
        kind.send_keys("rep")
        self.browser.wait("return document.querySelector(\".p2 [aria-label='Row 2: last rows']\")")
        self.browser.type(self.browser.find(".p2 [aria-label='Row 2: last rows']"), "1")
        self.assertEqual(self.browser.text(".p2 .fault"), "")
        self.browser.button("Save programmes as CSV").click()
        saved = self.browser.downloaded("programme3.csv")
        self.assertEqual(saved.read_text().count("ramp, 1.07, 14"), 3)
        native("study_protocol", saved)  # reads it

    def test_faults_stand_at_their_rows(self):
        field = self.browser.find(".p0 [aria-label='Row 1: days']")
        self.browser.type(field, "x")
        fault = self.browser.find(f"#{field.get_attribute('aria-describedby')}")
        self.assertEqual(fault.text, "expected a time in days, a number > 0, found 'x'")
        self.assertEqual(len(self.browser.table("#comparison")), 1)
        self.browser.type(field, "8")
        self.assertEqual(fault.text, "")

    def test_fields_stay_fields(self):
        """A comma or # in a field is named, and neither it nor a missing title moves what is typed to another field."""
        self.browser.open("tab=compare&programme=" + urllib.parse.quote("title, A\nramp, 1.1, 7\nhold, 5"))
        stretch, days = (self.browser.find(f".p0 [aria-label='Row {r}: {w}']") for r, w in ((1, "to stretch"), (2, "days")))
        title, rest = self.browser.driver.find_elements("css selector", ".p0 .field input")
        said = lambda field: self.browser.text(f"#{field.get_attribute('aria-describedby')}")  # noqa: E731
        for field, text, words in ((stretch, "1,2", "Row 1: to stretch: expected a number, found '1,2': decimal comma? write 1.2."),
                                   (stretch, "1#2", "found '1#2'"), (title, "Plan #2", "expected a text without #"),
                                   (rest, "100,5", "decimal comma? write 100.5")):
            self.browser.type(field, text)
            self.assertIn(words, said(field))
            self.assertEqual(field.get_attribute("aria-invalid"), "true")
            self.assertEqual(self.browser.table("#comparison"), [])
            self.browser.type(field, {stretch: "1.2", title: "A, b", rest: "100.5"}[field])
            self.assertEqual((said(field), field.get_attribute("aria-invalid")), ("", "false"))
        from selenium.webdriver.common.keys import Keys
        for field in (title, rest):  # without its line, all rows are elsewhere in the text
            self.browser.type(field, Keys.BACKSPACE)
        self.browser.type(days, "9")
        self.assertEqual(self.browser.js("return window.myogrowth.model.programmes"), ["ramp, 1.2, 7\nhold, 9\n"])

    def drop(self, *files):
        """Files of (name, bytes); returns what the page says and the titles that it shows."""
        self.browser.driver.execute_async_script("""
            const done = arguments[1];
            window.myogrowth.panels.compare.open(arguments[0].map(([name, bytes]) => new File([Uint8Array.from(bytes)], name)))
              .then(done, done);""", [[name, list(data)] for name, data in files])
        return self.browser.text("#compare_message"), [row[0] for row in self.browser.table("#comparison")][2:]

    def test_files_of_all_forms(self):
        bom = b"\xef\xbb\xbf"
        self.assertEqual(self.drop(("a.csv", bom + "include, Größe.csv\r\nstep, 1.1\r\nhold, 5,,,\r\n".encode()),
                                   ("Größe.csv", bom + "title, Größe\r\n".encode())), ("", ["Größe"]))
        self.browser.open("tab=compare")
        self.assertEqual(self.drop(("Übung #1.csv", b"step, 1.1\rhold, 5\r"), ("b.csv", b"title, Same\nhold, 1\n")),
                         ("", ["Übung _1", "Same"]))
        self.browser.open("tab=compare")
        self.assertIn("a circle", self.drop(("a.csv", b"include, b.csv\nhold, 1"), ("b.csv", b"include, a.csv\nhold, 1"))[0])
        self.assertEqual(self.drop(("b.csv", b"title, Same\nhold, 1\n"), ("c.csv", b"title, Same\nhold, 2\n")),
                         ("", ["Same", "Same, c"]))
        self.assertIn("There are four programmes already", self.drop(("d.csv", b"hold, 3\n"))[0])
        for data, words in (("title, x\nhold, 1".encode("utf-16"), "UTF-16"), ("title, Größe\nhold, 1".encode("latin-1"), "UTF-8"),
                            (b"include, bad.csv\nhold, 1", "a circle")):
            self.assertIn(words, self.drop(("bad.csv", data))[0])
        said = self.browser.driver.execute_async_script("""
            const folder = new File([], "folder"), large = new File([new Uint8Array(10000001)], "large"), done = arguments[0];
            folder.arrayBuffer = () => Promise.reject(new DOMException("", "NotFoundError")); // as Chromium's of a folder
            window.myogrowth.panels.compare.open([folder, large]).then(() => done(document.getElementById("compare_message").textContent));
            """)
        self.assertEqual(said, "folder: cannot be read: expected files, not folders large: more than 10 MB: expected a programme as CSV")

    def test_saved_programmes_have_the_muscle_of_the_page(self):
        """./run protocol gives the page's numbers, also with a preset and with removal."""
        self.browser.open("tab=compare&tau=2&G_max=1.4&tau_rev=3&c1=20")
        rows = self.browser.table("#comparison")
        self.browser.button("Save programmes as CSV").click()
        report = native("study_protocol", *(self.browser.downloaded(f"programme{i}.csv") for i in (1, 2)), "--injury", 1.05)
        for row, p in zip(rows, report["protocols"], strict=True):
            for cell, key in zip(row[2:6] + row[7:], ("peak_lambda_e", "peak_day", "days_above_injury", "dose_above_injury",
                                                      "peak_force", "final_G")):
                self.assertAlmostEqual(float(cell), p[key], delta=0.5001 * 10**-len(cell.split(".")[1]), msg=key)

    def test_files_are_refused_in_the_words_of_run_protocol(self):
        bad = ["", "hold, 1,5\n", "ramp, 1.1\n", "step, 1.1, 2\n", "distract, 1, 3\n", "step; 1.1\n", "ramp, 1.1, 0\n",
               "set, G_max, 0.9\nhold, 1\n", "set, tau_rev, 1\nhold, 1\n", "step, 200\n", "hold, 1\nhold, 1e6\n", "title\n",
               "title, a\ntitle, b\n", "set, taus, 1\n", "hold, nan\n", "hold, 0x10\n", "hold, 1e999\n", "step, 1.1\n\0",
               "walk, 3\n", "ramp, 1, 1, 5\n", "hold, 3 4\n", 'hold, "3"\n', "title, \x01\n", "# only a comment\n",
               "rest_length, 100\ndistract, -1, 200\n", "\u00e4, 1\n", "measure, 1, lambda_e, 1\n", "fit, c1, 1, 2\n",
               "cycle, 1.1, 25, 1, 7\n", "cycle, 1.1, 8, 2, 7\n", "cycle, 1.1, 8\n", "measure, 1, x, 1, 1\n"]
        for text in bad:
            self.browser.js("""
                const data = new DataTransfer();
                data.items.add(new File([arguments[0]], "bad.csv"));
                document.getElementById("compare_message").textContent = "";
                window.dispatchEvent(new DragEvent("drop", {dataTransfer: data, cancelable: true}));""", text)
            said = self.browser.wait("return document.getElementById('compare_message').textContent")
            with tempfile.TemporaryDirectory() as folder:
                file = pathlib.Path(folder) / "bad.csv"
                file.write_bytes(text.encode())
                status, words = refusal("study_protocol", file)
            self.assertEqual(status, 2, text)
            words = words.strip().replace("error: ", "").replace(f"{folder}/", "")
            if "G_max = 0.9" in words:  # the program adds the parameter's meaning
                self.assertEqual(said, "bad.csv:1:13: G_max = 0.9: must be finite and > 1.")
            elif "keyword" in words or "expected title" in words:  # the page has one keyword more
                self.assertEqual(said.replace("tendon, repeat or", "tendon or"), words)
            else:
                self.assertEqual(said, words, repr(text))

    def test_pictures(self):
        self.browser.open("tab=compare&tau=2&programme=" + urllib.parse.quote(f"title, {'long ' * 40}\uffff\nset, gamma, 1\nhold, 5")
                          + "&programme=" + urllib.parse.quote(f"title, {'x' * 200}\nstep, 1.1\nhold, 9"))
        self.assertIn("– – – xxx", self.browser.text("#panel_compare .u-legend"))  # not by colour alone
        self.browser.button("Save SVG").click()
        svg = self.browser.downloaded("programmes.svg").read_text()
        xml.etree.ElementTree.fromstring(svg)
        for words in ("τ = 2 days", "its own parameters: γ = 1."):
            self.assertIn(words, svg)
        self.assertEqual(self.browser.js("""
            document.body.insertAdjacentHTML("beforeend", arguments[0]);
            const box = (e) => e.getBBox(), inside = (b) => b.x >= 0 && b.x + b.width <= 800;
            return [...document.body.lastElementChild.querySelectorAll("text")].filter(e => !inside(box(e))).map(e => e.textContent);
            """, svg), [])
        self.assertEqual(svg.count("<polyline"), 8)
        self.assertIn("no medical advice", svg)
        self.browser.button("Save PNG").click()
        png = self.browser.downloaded("programmes.png").read_bytes()
        self.assertEqual(png[:8], b"\x89PNG\r\n\x1a\n")
        self.assertGreater(len(png), 20000)

    def test_link(self):
        self.browser.type(self.browser.find(".p0 [aria-label='Row 1: days']"), "6")
        self.browser.type("[name=tau]", "0.8")
        rows = self.browser.table("#comparison")
        self.browser.button("Copy link").click()
        link = self.browser.driver.current_url
        self.browser.driver.get("about:blank")
        self.browser.driver.get(link)
        self.browser.wait("return Boolean(window.myogrowth)")
        self.assertEqual(self.browser.table("#comparison"), rows)
        self.assertEqual(self.browser.find("[name=tau]").get_attribute("value"), "0.8")

    def test_bad_links_are_named(self):
        self.browser.open("tab=dance&G_max=0.5&stretch=9&walk=1&range_tau=3:1&range_gamma=-1:2&ramp=2")
        said = self.browser.text("#link_faults")
        for words in ("tab = dance: expected play,", "G_max = 0.5: must be finite and > 1.", "stretch = 9: expected a number from",
                      "walk = 1: expected one of the page's names", "range_tau = 3:1", "range_gamma = -1:2: gamma = -1"):
            self.assertIn(words, said)
        self.assertEqual(self.browser.find("[name=ramp]").get_attribute("value"), "2")

    def test_hostile_links_are_refused_with_a_message(self):
        """Names of JavaScript's own, entries twice, bounds that no fit can have: said, and the page works."""
        for entry, words in (("__proto__=1", "__proto__ = 1"), ("toString=1", "toString = 1"),
                             ("range_constructor=1:2", "range_constructor = 1:2"), ("tau=1&tau=2", "tau = 2: expected only once"),
                             ("fit_tau=-1:2", "fit_tau = -1:2: tau = -1: must be finite and > 0"),
                             ("fit_lambda_crit=1:1", "fit_lambda_crit = 1:1: expected LOW < HIGH"),
                             ("tau_rev=1&range_lambda_crit=0.5:0.9", "lambda_crit_rev = 1: must be finite and > 0 and <= lambda_crit"),
                             ("&".join(f"programme=hold,{i}" for i in range(1, 7)), "programme = hold,5: expected at most four")):
            self.browser.open(entry)
            self.assertIn(words, self.browser.text("#link_faults"), entry)
            self.assertEqual(self.browser.text("#n_peak")[:2], "1.")

    def test_hostile_rows_end_soon(self):
        """Rows that multiply without end are refused; many short steps are drawn within seconds."""
        for rows, words in (("step, 1.1\n" + "repeat, 1, 1000\nrepeat, 1000, 100\n" * 20, "more than 100000 rows"),
                            ("cycle, 1.1, 8, 1, 20000\n" * 40, "more than 200000 time steps"), ("ramp, 100, 1e-6", ""),
                            ("cycle, 1.1, 1e-5, 1e-6, 0.02", "")):
            started = time.monotonic()
            self.browser.open("tab=compare&programme=" + urllib.parse.quote(rows))
            self.assertLess(time.monotonic() - started, 15, rows[:40])  # once 50
            said = self.browser.js("return [...document.querySelectorAll('.programme .fault')].map(e => e.textContent).join('')")
            self.assertIn(words, said)
            self.assertEqual(bool(said), bool(words), said)

    def test_a_link_keeps_every_digit(self):
        self.browser.type("[name=tau]", "0.1234567890123")
        self.browser.button("Copy link").click()
        self.assertIn("tau=0.1234567890123&", self.browser.driver.current_url)

    def test_what_is_too_long_for_a_link_is_said(self):
        self.browser.js("window.myogrowth.model.fit.data = '#'.repeat(700000)")
        before = self.browser.driver.current_url
        self.browser.button("Copy link").click()
        self.assertIn("too long for a link", self.browser.text("[role=status]"))
        self.assertEqual(self.browser.driver.current_url, before)


# ---- Design, uncertainty, fit

class Design(Page):
    def plan(self, **values):
        self.browser.open(urllib.parse.urlencode({"tab": "design", **values}))
        return self.browser.wait("const rows = document.querySelectorAll('#plan tbody tr'); return rows.length > 0 && "
                                 "[...rows].map(r => [...r.children].map(c => c.textContent))")

    def test_the_plan_of_run_protocol(self):
        for target, limit, muscle in ((1.1, 1.05, {}), (1.14, 1.05, {"G_max": 1.3}), (1.3, 1.06, {"G_max": 1.6, "gamma": 1}),
                                      (1.04, 1.05, {})):
            plan = self.plan(target=target, design_limit=limit, **muscle)
            options = [f"--set={k}={v}".split("=", 1) for k, v in muscle.items()]
            report = native("study_protocol", "--design", target, "--limit", limit, *(x for o in options for x in o))
            for row, days in zip(plan, (report["days"], report["step_days"], report["ramp_days"])):
                self.assertAlmostEqual(float(row[1]), days, delta=6e-5 + 2e-4 * days * (row is plan[2]))
            self.assertAlmostEqual(float(plan[1][2]), report["step_peak"], delta=6e-5)
            self.browser.button("Save schedule as CSV").click()
            saved = self.browser.downloaded("schedule.csv")
            mine = list(csv.reader(saved.read_text().splitlines()))
            saved.unlink()
            with tempfile.TemporaryDirectory() as folder:
                subprocess.run([STUDIES / "study_protocol", "--design", str(target), "--limit", str(limit),
                                *(x for o in options for x in o), "--out", folder], check=True, capture_output=True)
                theirs = list(csv.reader((pathlib.Path(folder) / "schedule.csv").read_text().splitlines()))
            self.assertEqual(mine[0], theirs[0])
            self.assertEqual(len(mine), len(theirs))
            for a, b in zip(mine[1:], theirs[1:]):
                for x, y in zip(a, b):
                    self.assertAlmostEqual(float(x), float(y), delta=1.1e-4)

    def test_what_cannot_be_reached_is_said(self):
        for values, words in (({"target": 1.3}, "No programme reaches stretch 1.3"), ({"design_limit": 1.005}, "nothing grows"),
                              ({"target": 1.1549999999, "tau": 2000}, "more than the 36500")):
            self.browser.open(urllib.parse.urlencode({"tab": "design", **values}))
            self.assertIn(words, self.browser.wait("return document.getElementById('design_message').textContent"))

    def test_it_prints(self):
        self.plan(target=1.14, design_limit=1.05, G_max=1.3)
        self.browser.cdp("Emulation.setEmulatedMedia", media="print")
        shown = self.browser.js("return ['aside', '.bar', '#schedule', '.standing', '.printed'].map(s => "
                                "getComputedStyle(document.querySelector(s)).display !== 'none')")
        self.browser.cdp("Emulation.setEmulatedMedia", media="")
        self.assertEqual(shown, [False, False, True, True, True])
        self.assertIn("G_max = 1.3", self.browser.js("return document.querySelector('.printed').textContent"))
        pdf = base64.b64decode(self.browser.cdp("Page.printToPDF", printBackground=False)["data"])
        self.assertEqual(pdf[:5], b"%PDF-")


class Uncertainty(Page):
    def test_bands(self):
        self.tab("uncertainty")
        said = self.browser.wait("const s = document.getElementById('speed').textContent; return s.includes('a second') && s")
        print(said)
        self.assertGreater(int(re.search(r": (\d+) a second", said).group(1)), 200)  # thousands on a machine that is not busy
        rows = self.browser.table("#percentiles")
        low, middle, high = map(float, rows[0][1:])
        # Half of the ranges' peaks lie on either side of the middle's, 1.063; no percentile is outside of what ends give.
        self.assertTrue(1.03 < low < middle < high < 1.1, rows)
        self.assertAlmostEqual(middle, 1.063, delta=0.005)
        self.browser.type("[name=range_tau_0]", "9")
        self.assertIn("τ: expected from ≤ to, found 9 and 0.75", self.browser.text("#range_fault"))
        self.browser.type("[name=range_tau_0]", "0")
        self.assertIn("must be finite and > 0", self.browser.text("#range_fault"))

    def test_percentiles_of_a_narrow_range_are_the_curve(self):
        ranges = {f"range_{k}": f"{v}:{v}" for k, v in {**TABLE_1, "c1": 16, "c2": 4}.items()}
        self.browser.open(urllib.parse.urlencode({"tab": "uncertainty", **ranges}))
        self.browser.wait("return document.getElementById('speed').textContent.includes('a second')")
        for row in self.browser.table("#percentiles"):
            self.assertEqual(len(set(row[1:])), 1)
        # Long steps: what they cost is said in docs/web.md.
        self.tab("play")
        self.assertAlmostEqual(float(self.browser.table("#percentiles")[0][1]), float(self.browser.text("#n_peak")), delta=1.5e-4)


class Fit(Page):
    def setUp(self):
        super().setUp()
        self.tab("fit")

    def put(self, text):
        self.browser.js("const d = document.querySelector('[name=fit_data]'); d.value = arguments[0]; "
                        "d.dispatchEvent(new Event('input'))", text)
        self.browser.find("#fit_run").click()

    def test_the_example_as_run_fit(self):
        self.browser.button("Put in the example").click()
        found = self.browser.js("return window.myogrowth.fitted")
        report = native("study_fit", ROOT / "examples/identification/example.csv")
        self.close_to(found["chi2"], report["chi2"], 1e-9, "chi2")
        for mine, theirs in zip(found["parameters"], report["parameters"]):
            self.assertEqual(mine["name"], theirs["name"])
            for a, b in (("estimate", "estimate"), ("sd", "sd"), ("lower", "lower"), ("upper", "upper")):
                print(f"{mine['name']} {a}: {mine[a]:.10g} and {theirs[b]:.10g}")
                self.close_to(mine[a], theirs[b], 1e-6, mine["name"] + a)
        self.assertEqual(found["agreeing"], found["starts"])
        self.assertIn("0.44773", str(self.browser.table("#fit_result")))

    def test_plain_rows_and_lengths(self):
        """Day, value, sd with the history of Play, in µm: the same fit."""
        rows = re.findall(r"measure, (\S+), lambda_e, (\S+), (\S+)", (ROOT / "examples/identification/example.csv").read_text())
        self.browser.type("[name=fit_rest]", "2.5")
        for comma, blank in ((",", ""), (" \t", " ")):
            self.browser.js("window.myogrowth.fitted = null")
            self.put("# day value sd\n" + "\n".join(f"{blank}{d}{comma}{2.5 * float(v)!r}{comma}{2.5 * float(s)!r}" for d, v, s in rows))
            found = self.browser.js("return window.myogrowth.fitted")
            self.close_to(found["x"][0], 0.4477267439, 1e-6)
            self.close_to(found["x"][1], 1.014923799, 1e-6)

    def test_bad_rows_are_named(self):
        for text, words in (("1, x, 0.003", "the rows:1:4: expected a value"), ("", "has no rows"), ("1, 1.02", "a standard deviation"),
                            ("\n\n 1 1.02 abc", "the rows:3:9: expected a standard deviation"),
                            ("hold, 3", "expected rows of day, value, standard deviation"), ("1, 1.02, 0.003, 4", "end of the row"),
                            ("fit, gamma, 0, 3\nmeasure, 1, G, 1, 0.1", "this page fits tau and lambda_crit"),
                            ("1;1,02;0,003", "semicolons do not separate"), ("1 1,02 0,003", "decimal comma? write 1.02"),
                            ("1, 1.02, -1", "a standard deviation"), ("1, nan, 1", "a value"), ("1, 1, 0.1\n1, 1, 0.1", "already given"),
                            ("fit, tau, -1, 5\nmeasure, 1, G, 1, 0.1", "the rows:1:1: tau = -1"),
                            ("set, tau, 9\nfit, tau, 1, 5\nmeasure, 1, G, 1, 0.1", "expected a start within the bounds"),
                            ("cycle, 1.1, 8, 1, 365\nmeasure, 1, G, 1, 0.1", "./run fit takes more"),
                            ("\n".join(f"{i}, 1, 0.1" for i in range(501)), "at most 500"), ("tendon, 1, 1, 1", "without a tendon")):
            self.put(text)
            self.assertIn(words, self.browser.text("#panel_fit .fault"), text)
        box = self.browser.find("[name=fit_tau_0]")
        for text, words in (("0,1", "decimal comma? write 0.1"), ("-1", "tau = -1"), ("5", "expected from < to")):
            self.browser.type(box, text)
            self.assertIn(words, self.browser.text("#panel_fit .fault"))
            self.assertEqual(box.get_attribute("aria-invalid"), "true")

    def test_results_of_other_inputs_are_not_shown(self):
        rows = "1, 1.0654, 0.003\n2, 1.0424, 0.003\n50, 1.02, 0.003"
        self.put(rows)
        self.assertIn("ends on day 42, before the last measurement, on day 50", self.browser.text("#fit_result"))
        self.browser.button("Use these values as the muscle's").click()
        self.assertEqual(len(self.browser.table("#fit_result")), 2)
        self.browser.type("[name=gamma]", "1")
        self.assertEqual(self.browser.table("#fit_result"), [])

    def test_what_the_data_leave_open(self):
        self.put("1, 1.0654, 0.003\n2, 1.0424, 0.003")
        self.assertIn("can hardly decide", self.browser.text("#fit_result"))


# ---- For all

CONTRAST = """
const parse = (c) => c.match(/[0-9.]+/g).map(Number), lum = ([r, g, b]) => {
  const f = (v) => (v /= 255) <= 0.03928 ? v / 12.92 : Math.pow((v + 0.055) / 1.055, 2.4);
  return 0.2126 * f(r) + 0.7152 * f(g) + 0.0722 * f(b); };
const back = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor);
  if (c.length < 4 || c[3] > 0) return c; } return [255, 255, 255]; };
const found = [];
for (const e of document.querySelectorAll("body *")) {
  const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()), s = getComputedStyle(e);
  if (!own || e.closest("script, style, noscript") || e.getClientRects().length === 0) continue;
  if (parseFloat(s.fontSize) < 14) found.push(["small", e.tagName, s.fontSize, e.textContent.slice(0, 30)]);
  const a = lum(parse(s.color)), b = lum(back(e)), ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
  if (ratio < 4.5) found.push(["contrast", e.tagName, ratio.toFixed(2), e.textContent.slice(0, 30)]);
}
for (const e of document.querySelectorAll("input, select, textarea, button, canvas, svg")) {
  if (e.getClientRects().length === 0) continue;
  const name = e.getAttribute("aria-label") || (e.labels && e.labels.length > 0 && e.labels[0].textContent) ||
    (e.tagName === "BUTTON" && e.textContent);
  if (!name) found.push(["no name", e.tagName, e.name || "", e.outerHTML.slice(0, 80)]);
}
if (document.documentElement.scrollWidth > innerWidth) found.push(["wide", document.documentElement.scrollWidth, innerWidth]);
return found;
"""


class Everybody(Page):
    def test_every_view_is_readable(self):
        """Contrast, text of 14 px, names for screen readers, no scrolling sideways: wide, at 360 px, dark, zoomed."""
        from selenium.webdriver.common.keys import Keys

        for width, scale, dark in ((1280, 1, False), (640, 2, True), (360, 1, True)):  # 640 at 2: 1280 at 200 % zoom
            self.browser.look_like(width, 1000, dark, scale)
            self.browser.open()
            self.browser.js("document.querySelectorAll('details').forEach(d => { d.open = true; })")
            for name in ("play", "compare", "design", "uncertainty", "fit"):
                self.assertEqual(self.browser.js("return document.querySelector('[role=tab][aria-selected=true]').id"), f"tab_{name}")
                if name == "fit":
                    self.browser.button("Put in the example").click()
                self.browser.wait("return ![...document.querySelectorAll('.plot')].some(p => p.clientWidth && !p.firstChild)")
                self.assertEqual(self.browser.js(CONTRAST), [], (width, dark, name))
                self.assertIn("no medical advice", self.browser.text(".standing"))
                shot = pathlib.Path(BUILD / f"tests/web/{name}_{width}{'_dark' if dark else ''}.png")
                shot.parent.mkdir(parents=True, exist_ok=True)
                shot.write_bytes(base64.b64decode(self.browser.cdp("Page.captureScreenshot", captureBeyondViewport=True)["data"]))
                self.browser.find(f"#tab_{name}").send_keys(Keys.ARROW_RIGHT)
        self.browser.look_like(1280)

    def test_the_whole_page_by_keyboard(self):
        """Every control that is shown is reached by Tab, once round, and shows that it has the focus."""
        from selenium.webdriver.common.keys import Keys

        wanted = self.browser.js("return [...document.querySelectorAll('button, input, select, textarea, summary')].filter(e => "
                                 "e.checkVisibility({contentVisibilityAuto: true}) && e.tabIndex >= 0).map((e, i) => e.dataset.n = String(i))")
        wanted = set(wanted)
        seen, body = set(), self.browser.find("body")
        body.send_keys(Keys.TAB)
        for _ in range(3 * len(wanted)):
            active = self.browser.driver.switch_to.active_element
            if active.tag_name in ("button", "input", "select", "textarea", "summary"):
                seen.add(active.get_attribute("data-n"))
                self.assertEqual(self.browser.js("return getComputedStyle(arguments[0]).outlineStyle", active), "solid")
            if seen == wanted:
                break
            active.send_keys(Keys.TAB)
        self.assertEqual(seen, wanted)


class Build(unittest.TestCase):
    def test_size_and_licences(self):
        files = list(PAGE.parent.iterdir())
        self.assertEqual(sorted(f.name for f in files), ["LICENSE", "LICENSE.uPlot", "index.html"])
        self.assertLessEqual(sum(f.stat().st_size for f in files), 1_000_000)
        self.assertIn("Leon Sorokin", (PAGE.parent / "LICENSE.uPlot").read_text())

    def test_lint(self):
        if not shutil.which("eslint"):
            self.skipTest("no eslint")
        run = subprocess.run(["eslint", "-f", "unix", "--ignore-pattern", "presets.js", "src"], cwd=ROOT / "web", text=True,
                             capture_output=True, env={"NODE_PATH": "/usr/share/nodejs", "PATH": "/usr/bin:/bin"})
        self.assertEqual((run.returncode, run.stdout), (0, ""), run.stderr)

    def test_every_module_is_a_page_and_every_text_is_in_one_file(self):
        for module in (ROOT / "web/src").rglob("*.js"):
            lines = module.read_text().splitlines()
            self.assertTrue(lines[0].startswith("// "), module)
            self.assertLessEqual(len(lines), 160 if module.name != "strings.js" else 200, module)
            if module.name in ("strings.js", "presets.js", "fit_example.js", "dom.js"):
                continue
            for number, line in enumerate(lines, 1):
                for text in re.findall(r'h\("(?:p|h\d|label|summary|legend|button)", \{[^}]*\}, "([^"]+)"', line):
                    self.assertLessEqual(len(text), 1, f"{module}:{number}: '{text}' belongs into strings.js")


if __name__ == "__main__":
    skip_without_tools(PAGE)
    start = time.monotonic()
    program = unittest.main(exit=False)
    print(f"{time.monotonic() - start:.0f} s")
    sys.exit(not program.result.wasSuccessful())
