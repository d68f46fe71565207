"""report.html in a real browser: report_test.py PENUMBRA

Makes a small run with the program, opens its report from disk and uses it as a reader would.
"""

import csv
import io
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from browser import Browser, skip_without_chromium

PENUMBRA = sys.argv[1]
SIZE = 96
HOSTILE_SCENE = '"><img src=x onerror=window.hacked=1>, \u00fc \u2028 \'$(touch x)\''
HOSTILE_TEXT = "</script><script>window.hacked=1</script><!-- <b>bold</b> \U0001F600 a,b"


def penumbra(*words):
    return subprocess.run([PENUMBRA, *map(str, words)], capture_output=True, text=True, check=False)


def setUpModule():
    global scratch, run, measured, hostile, browser
    scratch = pathlib.Path(tempfile.mkdtemp(prefix="penumbra-report-"))
    run = scratch / "run"
    made = penumbra("compare", "--scene", "fence", "--scene", "half_plane", "--method", "hard", "--method",
                    "pcf", "--method", "separation", "--ladder", "--size", f"{SIZE}x{SIZE}", "--repeats", 1,
                    "--reference-se", 0.01, "--cache", scratch / "cache", "--out", run)
    assert made.returncode == 0, made.stderr
    measured = scratch / "measured"
    made = penumbra("compare", "--scene", "half_plane", "--scene", "two_layers", "--method", "hard", "--method", "pcf",
                    "--effects-table", "--size", "48x48", "--repeats", 1, "--reference-se", 0.05, "--cache",
                    scratch / "cache", "--out", measured)
    assert made.returncode == 0, made.stderr
    make_claims(measured)
    hostile = scratch / "hostile <b>&'\" run"
    make_hostile(hostile)
    browser = Browser()


def tearDownModule():
    browser.close()
    shutil.rmtree(scratch)


def make_claims(folder):
    """claims.csv with the columns of `reproduce`, and the page made anew."""
    header = ("paper,id,claim,place,metric,a_setting,a_scene,a_frame,a_light_scale,a_subdivisions,b_setting,b_scene,"
              "b_frame,b_light_scale,b_subdivisions,paper_ratio,relation,a,b,ratio,ratio_low,ratio_high,verdict,message")
    same = "fig. 1,rmse,pcf,half_plane,0,1,0,hard,half_plane,0,1,0,2,2 (within 1.15×),0.2,0.1,2,1.9,2.1"
    (folder / "claims.csv").write_text(f"""{header}
a-2000,sharper,"filtering is softer, always",{same},holds,
a-2000,faster,filtering is free,{same},does not hold,
a-2000,never,nobody can,{same},could not run,out of memory
""")
    made = penumbra("report", folder)
    assert made.returncode == 0, made.stderr


def make_hostile(folder):
    """The run with names, texts and tables that no program of ours would have written."""
    shutil.copytree(run, folder)
    (folder / "images" / "fence").rename(folder / "images" / HOSTILE_SCENE)
    record = json.loads((folder / "run.json").read_text())
    record["command"] = HOSTILE_TEXT
    record["provenance"]["renderer"] = HOSTILE_TEXT
    record["skipped_scenes"] = {HOSTILE_TEXT: HOSTILE_TEXT}
    for scene in record["scenes"]:
        if scene["id"] == "fence":
            scene.update(id=HOSTILE_SCENE, shows=HOSTILE_TEXT, figure=HOSTILE_TEXT, source=HOSTILE_TEXT)
    for found in record["analysis"]:
        found["scene"] = HOSTILE_SCENE
        found["effects"]["penumbra"]["evidence"] = HOSTILE_TEXT
    for reference in record["references"]:
        if reference["scene"] == "fence":
            reference["scene"] = HOSTILE_SCENE
    (folder / "run.json").write_text(json.dumps(record))
    with open(folder / "results.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        if row["scene"] == "fence":
            row["scene"] = HOSTILE_SCENE
        row["message"] = HOSTILE_TEXT
        row["effects_missing"] = HOSTILE_TEXT
    rows[0]["status"] = HOSTILE_TEXT
    with open(folder / "results.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    with open(folder / "stress.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "method", "setting", "invariant", "status", "deviation", "bound", "note"])
        writer.writerow(["mirror", "hard", "hard", HOSTILE_TEXT, "fail", 0.5, 0.1, HOSTILE_TEXT])
    with open(folder / "claims.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([["paper", HOSTILE_TEXT, "verdict"], [HOSTILE_TEXT] * 3])
    with open(folder / "effects.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow("scene,frame,method,setting,plan,status,frame_ms,frame_ms_low,frame_ms_high,rmse_to_auto,"
                        "max_to_auto,rmse".split(","))
        for plan in ["auto", HOSTILE_TEXT]:
            writer.writerow([HOSTILE_SCENE, 0, "hard", HOSTILE_TEXT, plan, "ok", 1, 1, 1, 0, 0, 0])
    made = penumbra("report", folder)
    assert made.returncode == 0, made.stderr


def is_blank(selector):
    """Whether a canvas shows only one colour."""
    return browser.js("""
        const canvas = document.querySelector(arguments[0]);
        const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const pixels = new Uint32Array(data.buffer);
        return pixels.every((pixel) => pixel === pixels[0]);""", selector)


class ReportTest(unittest.TestCase):
    def setUp(self):
        browser.resize(1280, 900)
        browser.complaints()

    def tearDown(self):
        self.assertEqual(browser.complaints(), [])

    def open(self, view=""):
        browser.open(run / "report.html", view)

    def test_overview_draws_chart_ranking_and_thumbnails(self):
        self.open()
        self.assertFalse(is_blank(".chart canvas"))
        self.assertEqual(len(browser.all("#ranking tbody tr")), len(self.settings()))
        self.assertEqual(len(browser.all(".scene-card")), 2)
        browser.find(".scene-card canvas").location_once_scrolled_into_view
        browser.wait("return document.querySelector('.scene-card canvas').classList.contains('drawn')")
        self.assertFalse(is_blank(".scene-card canvas"))

    def settings(self):
        with open(run / "results.csv", newline="") as file:
            return {row["setting"] for row in csv.DictReader(file)} - {"separation"}

    def test_front_is_that_of_the_program(self):
        """Every scene and the suite: points and front against pareto.csv."""
        with open(run / "pareto.csv", newline="") as file:
            expected = list(csv.DictReader(file))
        for scenes in ["fence", "half_plane", ""]:
            self.open(f"scenes={scenes}")
            points = browser.js("""
                return Chart.getChart(document.querySelector(".chart canvas")).data.datasets
                  .filter((set) => set.intervals).flatMap((set) => set.data.map(({point}) =>
                    [point.setting, point.error, point.ms, point.onFront]))""")
            own = [row for row in expected if row["scene"] == (scenes or "suite")]
            self.assertEqual(len(points), len(own))
            for row in own:
                error, ms, front = next(p[1:] for p in points if p[0] == row["setting"])
                # Sums of the same doubles in another order.
                self.assertAlmostEqual(error, float(row["error"]), delta=1e-12)
                self.assertAlmostEqual(ms, float(row["frame_ms"]), delta=1e-9)
                self.assertEqual(front, row["on_front"] == "1", row["setting"])

    def test_controls_of_the_chart_change_it_and_the_hash(self):
        self.open()
        chart = "Chart.getChart(document.querySelector('.chart canvas'))"
        self.assertEqual(browser.js(f"return {chart}.options.scales.x.type"), "logarithmic")
        browser.find("[aria-label='x axis'] [data-value=linear]").click()
        self.assertEqual(browser.js(f"return {chart}.options.scales.x.type"), "linear")
        browser.js("""const select = document.querySelector('.chart-tools select');
                      select.value = 'p99'; select.dispatchEvent(new Event('change'));""")
        self.assertEqual(browser.js(f"return {chart}.options.scales.y.title.text"), "p99")
        browser.find(".chip[data-scene=half_plane]").click()
        view = browser.js("return location.hash.slice(1)")
        before = browser.texts("#ranking tbody tr")
        self.open(view)
        self.assertEqual(browser.js(f"return {chart}.options.scales.x.type"), "linear")
        self.assertEqual(browser.texts("#ranking tbody tr"), before)
        self.assertEqual(browser.texts(".chip[aria-pressed=true]"), ["half_plane"])

    def test_click_on_a_point_opens_its_setting(self):
        self.open()
        x, y = browser.js("""
            const chart = Chart.getChart(document.querySelector('.chart canvas'));
            const set = chart.data.datasets.findIndex((s) => s.label === 'hard' && s.intervals);
            const {x, y} = chart.getDatasetMeta(set).data[0];
            const box = chart.canvas.getBoundingClientRect();
            return [box.left + x, box.top + y]""")
        for kind in ["mousePressed", "mouseReleased"]:
            browser.emulate("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)
        browser.wait("return document.querySelector('#page').dataset.page === 'compare'")
        browser.drawn()
        self.assertTrue(browser.js("return new URLSearchParams(location.hash.slice(1)).get('b')").startswith("hard"))

    def test_tables_sort_filter_and_export(self):
        self.open("page=rows")
        browser.find("th button[data-column=rmse]").click()
        column = browser.js("return [...document.querySelectorAll('thead th')].findIndex("
                            "(th) => th.ariaSort === 'ascending')") + 1
        shown = [float(t) for t in browser.texts(f"tbody td:nth-child({column})") if t]
        self.assertEqual(shown, sorted(shown))
        browser.find("th button[data-column=rmse]").click()
        shown = [float(t) for t in browser.texts(f"tbody td:nth-child({column})") if t]
        self.assertEqual(shown, sorted(shown, reverse=True))
        browser.find("input[type=search]").send_keys("pcf fence")
        rows = browser.texts("tbody tr")
        self.assertTrue(rows and all("pcf" in row and "fence" in row for row in rows))
        text = browser.js("""
            const done = new Promise((resolve) => {
              const real = URL.createObjectURL;
              URL.createObjectURL = (blob) => { resolve(blob.text()); return real.call(URL, blob); };
            });
            document.querySelector("button.csv").click();
            return done""")
        exported = list(csv.DictReader(text.splitlines()))
        self.assertEqual(len(exported), len(rows))
        self.assertTrue(all(row["method"] == "pcf" for row in exported))

    def test_scene_page_has_methods_by_frames(self):
        self.open("page=scene&scene=fence&all=1")
        rows = browser.texts(".grid tbody th")
        self.assertEqual(rows[0], "reference")
        self.assertEqual(len(rows), 1 + len(self.settings()) + 1)  # and the separation
        self.assertEqual(browser.texts(".grid thead th"), ["frame 0", "frame 1", "frame 2"])
        browser.wait("return document.querySelectorAll('.grid canvas.drawn').length > 3")
        self.assertFalse(is_blank(".grid canvas.drawn"))

    def test_command_reproduces_its_row(self):
        self.open("page=scene&scene=fence&filter=pcf")
        command = next(c for c in browser.texts("td pre") if "--set pcf." in c)
        words = command.split()
        self.assertEqual(words[:2], ["./run", "compare"])
        again = scratch / "again"
        made = penumbra(*words[1:], "--cache", scratch / "cache", "--out", again)
        self.assertEqual(made.returncode, 0, made.stderr)
        with open(again / "results.csv", newline="") as file:
            own = next(csv.DictReader(file))
        with open(run / "results.csv", newline="") as file:
            first = next(r for r in csv.DictReader(file)
                         if (r["scene"], r["frame"], r["setting"]) == ("fence", "0", own["setting"]))
        self.assertEqual((own["rmse"], own["params"]), (first["rmse"], first["params"]))

    def test_slider_divides_the_images(self):
        self.open("page=compare&scene=half_plane&b=hard&look=visibility")
        self.assertFalse(is_blank("canvas.view"))
        picture = "return document.querySelector('canvas.view').toDataURL()"
        before = browser.js(picture)
        browser.js("""const slider = document.querySelector('#slider');
                      slider.value = '0'; slider.dispatchEvent(new Event('input'));""")
        self.assertNotEqual(browser.js(picture), before)
        self.assertIn("at=0.000", browser.js("return location.hash"))

    def test_layouts(self):
        self.open("page=compare&scene=half_plane&b=hard")
        picture = "return document.querySelector('canvas.view').toDataURL()"
        browser.find("[aria-label=Layout] [data-value=flip]").click()
        before = browser.js(picture)
        browser.find("#flip").click()
        self.assertNotEqual(browser.js(picture), before)
        browser.find("[aria-label=Layout] [data-value=side]").click()
        self.assertTrue(browser.find("canvas.view[data-side='1']").is_displayed())
        browser.find("[aria-label=Layout] [data-value=error]").click()
        self.assertFalse(browser.find("canvas.view[data-side='1']").is_displayed())
        self.assertFalse(is_blank("canvas.view"))

    def test_zoom_is_locked_and_linked(self):
        self.open("page=compare&scene=half_plane&b=hard&layout=side&look=visibility")
        both = "return [...document.querySelectorAll('canvas.view')].map((c) => c.toDataURL())"
        before = browser.js(both)
        browser.find("[aria-label='Zoom in']").click()
        after = browser.js(both)
        self.assertTrue(all(a != b for a, b in zip(before, after)))
        browser.wait("return location.hash.includes('zoom=1.50')")
        self.open(browser.js("return location.hash.slice(1)"))
        self.assertEqual(browser.js(both), after)

    def test_inspector_agrees_with_the_images(self):
        """V and error at a pixel to the three digits that are shown."""
        exr = run / "images" / "fence" / "0001"
        self.open("page=compare&scene=fence&frame=1&b=hard")
        for x, y in [(40, 70), (0, SIZE - 1), (70, 50), (30, 80)]:
            browser.go(f"page=compare&scene=fence&frame=1&b=hard&pixel={x},{y}")
            text = " ".join(browser.texts(".inspector"))
            self.assertIn(f"pixel{x}, {y}", text)
            truth, own = self.pixel(exr / "reference.exr", x, y), self.pixel(exr / "hard.exr", x, y)
            if self.pixel(exr / "gbuffer.exr", x, y)["mask"] in (0, 3):
                continue
            for shown, value in re.findall(r"(reference V|V |error [+\u2212])(\d\.\d+)", text):
                expected = {"r": truth["visibility"], "V": own["visibility"],
                            "e": abs(own["visibility"] - truth["visibility"])}[shown[0]]
                # V is stored in steps of 0.001; an error is the difference of two such.
                self.assertAlmostEqual(float(value), expected, delta=0.00101, msg=text)

    def pixel(self, path, x, y):
        from OpenImageIO import ImageBuf
        image = ImageBuf(str(path))
        return dict(zip(image.spec().channelnames, image.getpixel(x, y)))

    def test_mask_dims_other_classes(self):
        self.open("page=compare&scene=half_plane&b=hard&layout=side")
        picture = "return document.querySelector('canvas.view').toDataURL()"
        before = browser.js(picture)
        browser.go("page=compare&scene=half_plane&b=hard&layout=side&mask=penumbra")
        self.assertNotEqual(browser.js(picture), before)

    def test_back_returns_to_the_view_as_it_was_left(self):
        self.open("page=scene&scene=fence")
        browser.find("#page [data-value=error]").click()
        browser.go("page=truth")
        browser.driver.back()
        browser.wait("return document.querySelector('#page').dataset.page === 'scene'")
        self.assertEqual(browser.texts("#page [aria-label=Show] [aria-pressed=true]"), ["Error"])

    def test_keyboard_picks_pixels(self):
        self.open("page=compare&scene=half_plane&b=hard&pixel=10,10")
        browser.js("document.querySelector('canvas.view').focus()")
        browser.press("ArrowRight", shift=True)
        browser.wait("return location.hash.includes('pixel=11%2C10')")

    def test_every_page_draws_on_a_phone_without_overflow(self):
        browser.resize(360, 740)
        for view in ["", "page=scene&scene=fence", "page=compare&scene=fence&b=hard", "page=rows", "page=effects",
                     "page=truth", "page=provenance"]:
            browser.go(view) if view else self.open()
            self.assertLessEqual(browser.js("return document.documentElement.scrollWidth"), 360, view)

    def test_theme_changes_the_colours(self):
        self.open()
        paper = "return getComputedStyle(document.body).backgroundColor"
        before = browser.js(paper)
        browser.find("#theme").click()
        self.assertNotEqual(browser.js(paper), before)
        self.assertFalse(is_blank(".chart canvas"))
        browser.find("#theme").click()

    def test_warnings_are_on_every_page(self):
        for view in ["", "page=truth", "page=compare"]:
            self.open(view)
            self.assertTrue(browser.find("#alerts .alert").is_displayed())

    def test_links_to_nowhere_show_something(self):
        self.open("page=compare&scene=nowhere&frame=77&a=no&b=%3Cb%3E&zoom=-1&pixel=9999,1&at=x")
        self.assertFalse(is_blank("canvas.view"))


class MeasuredRunTest(unittest.TestCase):
    """The sections that a run has only if it was asked for them."""

    def setUp(self):
        browser.resize(1280, 900)
        browser.complaints()

    def tearDown(self):
        self.assertEqual(browser.complaints(), [])

    def test_effects_page_says_what_each_scene_calls_for_and_why(self):
        browser.open(measured / "report.html", "page=effects")
        record = json.loads((measured / "run.json").read_text())
        text = browser.js("return document.querySelector('#page').textContent")
        for found in record["analysis"]:
            for effect in found["effects"].values():
                self.assertIn(effect["evidence"], text)
        summaries = browser.texts(".evidence summary")
        self.assertTrue(all("penumbra" in summary for summary in summaries), summaries)
        self.assertTrue(any(summary.startswith("two_layers, frame") for summary in summaries), summaries)
        self.assertIn(f"for {len(record['analysis'])} frames", text)

    def test_effects_page_has_what_each_plan_costs(self):
        with open(measured / "effects.csv", newline="") as file:
            cells = list(csv.DictReader(file))
        for view, count in [("page=effects", len({(c["scene"], c["setting"], c["plan"]) for c in cells if c["plan"] != "auto"})),
                            ("page=effects&by=suite", len({(c["setting"], c["plan"]) for c in cells if c["plan"] != "auto"}))]:
            browser.open(measured / "report.html", view)
            self.assertEqual(len(browser.all("#effects-cost tbody tr")), count, view)
        own = [c for c in cells if (c["setting"], c["plan"]) == ("pcf", "-penumbra")]
        timed = [c for c in cells if (c["setting"], c["plan"]) == ("pcf", "auto")]
        self.assertEqual(len(own), len(timed))
        ratio = sum(float(c["frame_ms"]) for c in own) / sum(float(c["frame_ms"]) for c in timed)
        error = (sum(float(c["rmse_to_auto"]) ** 2 for c in own) / len(own)) ** 0.5
        row = next(r for r in browser.js("""
            return [...document.querySelectorAll("#effects-cost tbody tr")].map((row) => [...row.cells].map((c) => c.textContent))""")
            if r[:2] == ["pcf", "without penumbra"])
        # Three digits are shown.
        self.assertAlmostEqual(float(row[5]) / ratio, 1, delta=0.006)
        self.assertAlmostEqual(float(row[6]), error, delta=0.006 * error + 1e-12)

    def test_rows_of_the_costs_are_chosen_and_linked(self):
        browser.open(measured / "report.html", "page=effects")
        browser.find("[aria-label=Rows] [data-value=suite]").click()
        self.assertIn("by=suite", browser.js("return location.hash"))
        self.assertNotIn("half_plane", browser.js("return document.querySelector('#effects-cost').textContent"))

    def test_claims_that_fail_stand_out(self):
        browser.open(measured / "report.html", "page=claims")
        self.assertEqual(len(browser.all("tbody tr")), 3)
        self.assertEqual([title.rstrip() for title in browser.texts("thead th")[:3]], ["paper", "claim", "verdict"])
        wrong = browser.texts("tr.wrong")
        self.assertEqual(len(wrong), 2)
        self.assertTrue("does not hold" in wrong[0] + wrong[1] and "could not run" in wrong[0] + wrong[1], wrong)
        self.assertIn("holds: 1 · does not hold: 1 · could not run: 1", browser.js("return document.querySelector('#page').textContent"))

    def test_truth_holds_the_reference_against_exact_visibility(self):
        browser.open(measured / "report.html", "page=truth")
        record = json.loads((measured / "run.json").read_text())
        self.assertEqual(len(browser.all("tbody tr")), len(record["references"]))
        self.assertTrue(all(reference["checked"]["pixels"] > 0 for reference in record["references"]))
        self.assertIn("%", browser.texts("tbody tr")[0])


class HostileRunTest(unittest.TestCase):
    """Nothing that a run folder holds is executed or becomes markup."""

    def test_pages_show_the_texts_and_run_nothing(self):
        browser.resize(1280, 900)
        browser.complaints()
        scene = browser.js("return encodeURIComponent(arguments[0])", HOSTILE_SCENE)
        for view in ["", f"page=scene&scene={scene}&all=1", f"page=compare&scene={scene}&b=pcf", "page=rows",
                     "page=effects", "page=truth", "page=stability", "page=claims", "page=provenance"]:
            browser.go(view) if view else browser.open(hostile / "report.html")
            browser.js("document.querySelectorAll('details.alert').forEach((box) => { box.open = true; })")
            self.assertIsNone(browser.js("return window.hacked ?? null"), view)
            self.assertEqual(browser.js("return document.querySelectorAll('img, b').length"), 0, view)
            self.assertIn(HOSTILE_TEXT, browser.js("return document.body.textContent"), view)
            self.assertEqual(browser.complaints(), [], view)

    def test_policy_forbids_what_got_into_the_markup(self):
        browser.open(hostile / "report.html")
        browser.js("""const script = document.createElement("script");
                      script.textContent = "window.injected = 1";
                      document.body.append(script);
                      document.body.insertAdjacentHTML("beforeend", "<p onclick='window.injected=1' id='p'>p</p>");
                      document.querySelector("#p").click();""")
        self.assertIsNone(browser.js("return window.injected ?? null"))
        browser.complaints()  # of the policy


class BadInputTest(unittest.TestCase):
    """What was cut or edited by hand is refused in one line that names it."""

    def refused(self, name, change):
        folder = scratch / "bad"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(run, folder)
        before = (folder / "report.html").read_bytes()
        path = folder / name
        path.write_text(change(path.read_text()))
        made = penumbra("report", folder)
        self.assertEqual(made.returncode, 2, made.stderr)
        self.assertEqual(made.stderr.strip().count("\n"), 0, made.stderr)
        self.assertEqual((folder / "report.html").read_bytes(), before)
        return made.stderr

    def test_a_number_that_is_none(self):
        def change(text):
            lines = text.split("\n")
            lines[3] = lines[3].replace(",96,96,", ",96,wide,")
            return "\n".join(lines)
        self.assertIn("results.csv:4: column height: 'wide' is not a number", self.refused("results.csv", change))

    def edited(self, column, value):
        """results.csv with `value` in the second row."""
        def change(text):
            rows = list(csv.reader(text.splitlines()))
            rows[2][rows[0].index(column)] = value
            out = io.StringIO()
            csv.writer(out, lineterminator="\n").writerows(rows)
            return out.getvalue()
        return change

    def test_numbers_that_no_run_writes(self):
        for column, value, why in [("rmse", "nan", "is not finite"), ("rmse", "-0.5", "is below 0"),
                                   ("frame_ms", "inf", "is not finite"), ("frame_ms", "-3", "is below 0"),
                                   ("frame", "99999999999", "is not a number"), ("width", "-96", "is below 0"),
                                   ("frame_ms", "1e999", "is not a number")]:
            self.assertIn(f"results.csv:3: column {column}: '", error := self.refused("results.csv", self.edited(column, value)))
            self.assertIn(why, error)

    def test_names_that_lead_elsewhere(self):
        for column in ["scene", "setting"]:
            for name in ["../../../escaped", "..", ""]:
                self.assertIn(f"results.csv:3: column {column}: '{name}' is no name",
                              self.refused("results.csv", self.edited(column, name)))
        self.assertEqual(list(scratch.rglob("escaped*")), [])

    def test_a_record_of_another_version(self):
        def change(text):
            record = json.loads(text)
            del record["analysis"]
            return json.dumps(record)
        error = self.refused("run.json", change)
        self.assertIn("run.json: of another version of Penumbra", error)
        self.assertIn("'analysis'", error)

    def test_effects_that_are_none(self):
        (run / "effects.csv").write_text("")
        try:
            self.assertIn("effects.csv:1: expected the columns", self.refused("effects.csv", lambda text: "scene,frame\n"))
        finally:
            (run / "effects.csv").unlink()

    def changed(self, change):
        """The report of the run after `change(folder)`."""
        folder = scratch / "changed"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(run, folder)
        change(folder)
        return folder, penumbra("report", folder)

    def test_a_run_without_images_has_its_numbers(self):
        def change(folder):
            shutil.rmtree(folder / "images" / "half_plane")
            (folder / "images" / "fence" / "0001" / "hard.exr").unlink()
        folder, made = self.changed(change)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertFalse((folder / "grid" / "half_plane.png").exists(), "a grid of images that are gone")
        self.assertTrue((folder / "grid" / "fence.png").exists())
        browser.complaints()
        for view in ["", "page=scene&scene=half_plane&all=1", "page=scene&scene=fence&all=1", "page=compare&scene=half_plane",
                     "page=compare&scene=fence&frame=1&b=hard"]:
            browser.open(folder / "report.html", view)
            self.assertEqual(browser.complaints(), [], view)
        browser.open(folder / "report.html", "page=scene&scene=half_plane")
        self.assertIn("no image", browser.js("return document.querySelector('#page').textContent"))

    def test_images_that_do_not_fit(self):
        def change(folder):
            shutil.copy(measured / "images" / "half_plane" / "0000" / "hard.exr", folder / "images" / "half_plane" / "0000")
        _, made = self.changed(change)
        self.assertEqual(made.returncode, 2)
        self.assertIn("half_plane/0000/hard.exr: 2304 pixels, the frame's gbuffer.exr has 9216", made.stderr)
        _, made = self.changed(lambda folder: (folder / "images" / "half_plane" / "0000" / "hard.exr").write_text("none"))
        self.assertEqual(made.returncode, 2)
        self.assertIn("hard.exr: ", made.stderr)
        self.assertEqual(made.stderr.strip().count("\n"), 0, made.stderr)

    def test_a_last_line_cut_short_is_left_out(self):
        """As a kill leaves it: --resume makes that row again."""
        def change(folder):
            text = (folder / "results.csv").read_text()
            (folder / "results.csv").write_text(text[:-20])
        folder, made = self.changed(change)
        self.assertEqual(made.returncode, 0, made.stderr)
        browser.open(folder / "report.html", "page=rows")
        with open(run / "results.csv", newline="") as file:
            self.assertEqual(len(browser.all("tbody tr")), sum(1 for _ in csv.reader(file)) - 2)

    def test_a_line_that_lacks_fields(self):
        self.assertIn("results.csv:3: 5 fields, expected", self.refused(
            "results.csv", lambda text: "\n".join(text.split("\n")[:2] + ["fence,0,hard,hard,"] + text.split("\n")[3:])))

    def test_a_record_cut_short(self):
        self.assertIn("run.json", self.refused("run.json", lambda text: text[:len(text) // 2]))

    def test_a_table_whose_lines_differ(self):
        (run / "claims.csv").write_text("paper,id\na,b\n")
        try:
            self.assertIn("claims.csv:2: 1 fields, expected 2", self.refused("claims.csv", lambda text: "paper,id\na\n"))
        finally:
            (run / "claims.csv").unlink()


if __name__ == "__main__":
    skip_without_chromium()
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
