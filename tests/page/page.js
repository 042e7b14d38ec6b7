// Every view of the page, used as a person uses it. What it shows is compared with what the interface answers.
// Arguments: the browser, the folder of example programs, and a folder for pictures, if they are wanted.

import { strict as assert } from "node:assert";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { check, fault, faults, launch, open } from "./browser.js";
import { million } from "./million.js";

const [executable, examples, pictures] = process.argv.slice(2);
const { DEMO, NEW, EMPTY, CLOSED, TRUNNION_KEY: key } = process.env;
const MACHINE = "demo-ac-table";
const blade = join(examples, "blade.nc");

const get = async (url, path, headers = {}) => {
  const response = await fetch(url + path, { headers: { Accept: "application/json", ...headers } });
  assert.ok(response.ok, `${path}: ${response.status}`);
  return response.json();
};
/** The limit of an error, in the profile of the machine. */
const limit = async (url, name, value) => {
  const { machine_id: _id, revision: _revision, created_at: _at, ...profile } = await get(url, `/v1/machines/${MACHINE}`);
  const response = await fetch(`${url}/v1/machines/${MACHINE}`, {
    method: "PUT",
    headers: { "Content-Type": "application/json", "If-Match": "*" },
    body: JSON.stringify({ ...profile, calibration_limits: { [name]: value } }),
  });
  assert.ok(response.ok, await response.text());
};
const close = (a, b) => Math.abs(a - b) <= 1e-9 * Math.max(1, Math.abs(b));
/** The number that is shown at a place, with every digit, is that of the answer. */
const same = async (page, place, value) => {
  const shown = await page.locator(`${place} .num[data-value], ${place}.num[data-value]`).first().getAttribute("data-value");
  if (!close(Number(shown), value)) fault(`${place}: the page shows ${shown}, the interface answers ${value}`);
  const text = await page.locator(`${place} .num[data-value], ${place}.num[data-value]`).first().innerText();
  const read = Number(text.replace(/[^\d.−-]/g, "").replace("−", "-"));
  if (Math.abs(read - value) > 0.051 * Math.max(1, Math.abs(value) / 100)) fault(`${place}: the text is ${text}, the value ${value}`);
};
/** The pictures of `docs/page.md`: what is in the window, with this part in its middle. */
const gallery = async (page, name, part) => {
  if (!process.env.GALLERY) return;
  if (part) await page.locator(part).first().evaluate((element) => element.scrollIntoView({ block: "center", behavior: "instant" }));
  else await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(process.env.GALLERY, `${name}.png`) });
};
const picture = async (page, name) => {
  if (!pictures) return;
  await page.evaluate(() => window.scrollTo(0, 0));
  await page.waitForTimeout(400);
  await page.screenshot({ path: join(pictures, `${name}.png`), fullPage: true });
};
/** How many colours a picture has: one would be an empty stage. */
const colours = (page, place) =>
  page.locator(place).first().evaluate((canvas) => {
    const copy = document.createElement("canvas");
    copy.width = 64;
    copy.height = 48;
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0, 64, 48);
    const { data } = context.getImageData(0, 0, 64, 48);
    const found = new Set();
    for (let at = 0; at < data.length; at += 4) found.add(`${data[at]} ${data[at + 1]} ${data[at + 2]}`);
    return found.size;
  });

/** Waits until a picture has more than so many colours: a scene is drawn some time after its place is there. */
const drawn = async (page, place, least, fault) => {
  let found = 0;
  for (let look = 0; look < 120 && found <= least; look += 1) {
    if (look > 0) await page.waitForTimeout(250);
    found = await colours(page, place);
  }
  assert.ok(found > least, `${fault}: ${found} colours`);
};

const browser = await launch(executable);

/** Fills in the form for the blade and starts; the result is in sight. */
const compensate = async (page, { offset = ["12", "-7", "35"] } = {}) => {
  await page.setInputFiles("#program", blade);
  const machines = page.locator(".fields select").first();
  if (await machines.locator(`option[value="${MACHINE}"]`).count()) await machines.selectOption(MACHINE);
  const fields = page.locator(".triple input");
  for (const [index, value] of offset.entries()) await fields.nth(index).fill(value);
  await page.click("button.primary.large");
};

const flows = {
  async "a program is compensated, and every number is that of the report"() {
    const { page, close: end } = await open(browser, DEMO, "/compensate");
    await picture(page, "compensate-form");
    // Without the work offset the service asks for it, at its field.
    await compensate(page, { offset: ["", "", ""] });
    await page.waitForSelector(".notice.bad");
    assert.match(await page.locator(".notice.bad").innerText(), /work offset|work_offset/i);
    assert.ok(await page.locator(".field.wrong .fault").count(), "the missing work offset is not marked at its field");
    await check(page, "compensate, refused");
    await picture(page, "compensate-refused");
    await compensate(page);
    await page.waitForSelector(".readout", { timeout: 30_000 });
    const id = decodeURIComponent((await page.locator(".resulthead a").getAttribute("href")).split("/").pop());
    const report = await get(DEMO, `/v1/jobs/${id}/report`);
    await same(page, '[data-name="before-max"]', report.before.max_um);
    await same(page, '[data-name="after-max"]', report.after.max_um);
    for (const name of ["max_um", "rms_um", "max_excess_um", "max_gouge_um"]) {
      await same(page, `[data-row="${name}"] td:nth-of-type(1)`, report.before[name]);
      await same(page, `[data-row="${name}"] td:nth-of-type(2)`, report.after[name]);
    }
    for (const name of ["blocks_in", "blocks_out", "blocks_inserted", "motions_checked", "cc_path_length_mm"])
      await same(page, `[data-row="${name}"]`, report[name]);
    assert.equal(Number(await page.locator('[data-row="worst_line"] button').first().innerText()), report.before.worst_line);
    // The worst line is in sight, and it is that line of the program.
    const line = readFileSync(blade, "utf8").split(/\r?\n/)[report.before.worst_line - 1];
    assert.equal(await page.locator(".codeline.worst .text").first().innerText(), line);
    // The line is marked in both programs, when both were read.
    await page.waitForFunction(() => document.querySelectorAll(".codeline.focus").length >= 3);
    await drawn(page, ".canvas canvas", 40, "the tool path is not drawn");
    await drawn(page, ".chart canvas", 5, "the chart is not drawn");
    // The slider moves the machine, and the program follows.
    const before = await page.locator(".readout").innerText();
    await page.locator(".scrub input").focus();
    for (let press = 0; press < 30; press += 1) await page.keyboard.press("ArrowLeft");
    assert.notEqual(await page.locator(".readout").innerText(), before);
    await page.locator(".divider").focus();
    await page.keyboard.press("ArrowLeft");
    assert.equal(await page.locator(".divider").getAttribute("aria-valuenow"), "45");
    const [saved] = await Promise.all([page.waitForEvent("download"), page.click(".files .primary")]);
    const program = await (await fetch(`${DEMO}/v1/jobs/${id}/program`)).text();
    assert.equal(readFileSync(await saved.path(), "utf8"), program);
    await check(page, "compensate");
    await picture(page, "compensate");
    await page.locator(".divider").press("ArrowRight");
    await page.locator(".divider").blur();
    await gallery(page, "compensate", ".card.path");
    await page.emulateMedia({ media: "print" });
    await picture(page, "compensate-print");
    if (pictures) await page.pdf({ path: join(pictures, "compensate.pdf"), format: "A4" });
    await end();
  },

  async "all corrections in one pass"() {
    const { page, close: end } = await open(browser, DEMO, "/compensate");
    await page.locator(".check input").nth(1).check();
    await compensate(page);
    await page.waitForSelector(".readout", { timeout: 30_000 });
    const id = (await page.locator(".resulthead a").getAttribute("href")).split("/").pop();
    const report = await get(DEMO, `/v1/jobs/${id}/report`);
    await same(page, '[data-name="before-max"]', report.error_budget.sum.before_um);
    await same(page, '[data-row="location_errors"] td:nth-of-type(1)', report.error_budget.location_errors.before_um);
    await check(page, "one pass");
    await end();
  },

  async "machines, their lights, their axes and their revisions"() {
    const { page, close: end } = await open(browser, DEMO, "/");
    await page.waitForSelector(".machine .light");
    assert.equal(await page.locator(".machine").count(), 2);
    await check(page, "overview");
    await gallery(page, "overview");
    await picture(page, "overview");
    await page.goto(`${DEMO}/#/machines`);
    await page.waitForSelector(".machine .light");
    await check(page, "machines");
    await page.goto(`${DEMO}/#/machines/${MACHINE}`);
    await page.waitForSelector(".stage canvas");
    await page.waitForTimeout(500);
    await drawn(page, ".stage canvas", 20, "the machine is not drawn");
    const machine = await get(DEMO, `/v1/machines/${MACHINE}`);
    for (const axis of machine.kinematics.rotary_axes)
      await same(page, `[data-axis="${axis.name}"] td:nth-of-type(6)`, axis.location_error.e_y_um);
    // The tool is parallel to C at A 0, and sixty degrees from it at A -60.
    await page.locator(".sliders input").first().fill("0");
    await page.waitForSelector('[data-name="pole"] .warn');
    await page.locator(".sliders input").first().fill("-60");
    await page.waitForFunction(() => /60\.0°/.test(document.querySelector('[data-name="pole"]')?.innerText ?? ""));
    await page.locator(".sliders input").last().fill("1000");
    await page.waitForTimeout(300);
    await check(page, "machine");
    await picture(page, "machine");
    await gallery(page, "machine");
    // A change makes a revision.
    await page.locator(".profileform .withunit input").nth(1).fill("730");
    await page.click('.profileform button[type="submit"]');
    await page.waitForFunction((wanted) => document.querySelector(".lead")?.textContent.includes(wanted), `revision ${machine.revision + 1}`);
    assert.equal((await get(DEMO, `/v1/machines/${MACHINE}`)).calibration_due_days, 730);
    // The lines of the axes are changed as a form, and shown as they are typed.
    await page.getByText("Change the lines of the axes").click();
    await page.getByLabel("A Limits −").fill("-110");
    await page.waitForTimeout(500);
    await check(page, "lines of the axes");
    await page.click('.axesform button[type="submit"]');
    await page.waitForFunction((wanted) => document.querySelector(".lead")?.textContent.includes(wanted), `revision ${machine.revision + 2}`);
    const [axis] = (await get(DEMO, `/v1/machines/${MACHINE}`)).kinematics.rotary_axes;
    assert.deepEqual(axis, { ...machine.kinematics.rotary_axes[0], limits_deg: [-110, 120] });
    await page.goto(`${DEMO}/#/machines/+`);
    await page.waitForSelector(".stage canvas");
    await page.locator("main select").selectOption("nutating-b-head-c-table");
    await page.fill('main input[pattern]', "from-preset");
    await page.waitForTimeout(500);
    await check(page, "new machine");
    await picture(page, "machine-new");
    await page.click('main button[type="submit"]');
    await page.waitForSelector("[data-axis]");
    assert.equal((await get(DEMO, "/v1/machines/from-preset")).kinematics.rotary_axes[0].side, "head");
    await end();
  },

  async "jobs are listed, filtered and opened; a refusal says its reason"() {
    const { page, close: end } = await open(browser, DEMO, "/jobs");
    const all = (await get(DEMO, "/v1/jobs?limit=50")).items;
    await page.waitForSelector("[data-job]");
    assert.equal(await page.locator("[data-job]").count(), all.length);
    await check(page, "jobs");
    await picture(page, "jobs");
    await page.locator(".filters select").nth(0).selectOption("failed");
    const failed = all.filter(({ state }) => state === "failed");
    await page.waitForFunction((count) => document.querySelectorAll("[data-job]").length === count, failed.length);
    const one = failed.at(-1);
    await page.goto(`${DEMO}/#/jobs/${one.id}`);
    await page.waitForSelector(".notice.bad");
    const words = await page.locator(".notice.bad").innerText();
    assert.ok(words.includes(one.problem.title) && words.includes(one.problem.detail), words);
    await check(page, "failed job");
    await picture(page, "job-failed");
    for (const operation of ["compensation", "verification", "servo-simulation", "posting", "wear-compensation"]) {
      const { id } = all.find((job) => job.operation === operation && job.state === "succeeded");
      await page.goto(`${DEMO}/#/jobs/${id}`);
      await page.waitForSelector(".provenance");
      await page.waitForLoadState("networkidle");
      // The path comes from the service, whoever posted the job; the residuals are on the part.
      if (operation.endsWith("compensation")) {
        await page.waitForSelector(".readout", { timeout: 30_000 });
        await drawn(page, ".canvas canvas", 40, "the tool path is not drawn");
      }
      if (operation === "verification") {
        await page.waitForSelector(".stage canvas");
        await page.waitForTimeout(500);
        await drawn(page, ".stage canvas", 40, "the residuals are not drawn");
      }
      await check(page, operation);
      await picture(page, `job-${operation}`);
    }
    await end();
  },

  async "calibration runs are shown, applied and gone back to"() {
    const { page, close: end } = await open(browser, DEMO, `/calibrate/${MACHINE}`);
    const runs = (await get(DEMO, `/v1/machines/${MACHINE}/calibrations`)).items;
    await page.waitForSelector("[data-run]");
    assert.equal(await page.locator("[data-run]").count(), runs.length);
    for (const run of runs) await same(page, `[data-run="${run.id}"] td:last-child`, run.residual_rms_um);
    await check(page, "calibrations");
    await picture(page, "calibrate");
    await limit(DEMO, "E_Y0C_um", 12.5);
    await page.goto(`${DEMO}/#/calibrate/${MACHINE}/${runs[0].id}`);
    await page.waitForSelector("img.figure");
    for (const [name, { value, standard_uncertainty: u }] of Object.entries(runs[0].iso_230)) {
      const row = `[data-error="${name.replace(/_u(m|rad)$/, "")}"]`;
      await same(page, `${row} td:nth-of-type(1)`, value);
      await same(page, `${row} td:nth-of-type(2)`, 2 * u);
    }
    await same(page, '[data-error="E_Y0C"] td:nth-of-type(3)', 12.5);
    assert.equal(await page.locator('[data-error="E_Y0C"] line.limit').count(), 2);
    for (const [axis, errors] of Object.entries(runs[0].errors))
      for (const [name, { value, standard_uncertainty: u }] of Object.entries(errors)) {
        const row = `[data-error="${axis}.${name.replace(/_u(m|rad)$/, "")}"]`;
        await same(page, `${row} td:nth-of-type(1)`, value);
        await same(page, `${row} td:nth-of-type(2)`, 2 * u);
      }
    await check(page, "calibration run");
    await gallery(page, "calibration");
    await picture(page, "calibration-run");
    await page.locator(".pair .card button, .grid .card button").first().click();
    await check(page, "apply");
    await page.click("dialog[open] .primary");
    await page.waitForSelector(".badge.ok");
    const now = await get(DEMO, `/v1/machines/${MACHINE}`);
    assert.ok(close(now.kinematics.rotary_axes[0].location_error.e_y_um, runs[0].errors.A.e_y_um.value));
    // A run is uploaded; one that is no run is refused with its reason.
    await page.goto(`${DEMO}/#/calibrate/${MACHINE}`);
    await page.setInputFiles('.upload input[type="file"]', { name: "run.json", mimeType: "application/json", buffer: Buffer.from("{}") });
    await page.waitForSelector(".preview");
    await page.click(".preview .primary");
    await page.waitForSelector(".notice.bad");
    await page.locator(".preview .row.end button").first().click();
    await page.setInputFiles('.upload input[type="file"]', { name: "run.json", mimeType: "application/json", buffer: Buffer.from("[1") });
    await page.waitForSelector(".upload .fault");
    await page.setInputFiles('.upload input[type="file"]', join(examples, "ballbar.json"));
    const told = JSON.parse(readFileSync(join(examples, "ballbar.json"), "utf8"));
    await page.waitForFunction((count) => document.querySelectorAll("[data-test]").length === count, told.tests.length);
    await check(page, "run before it is stored");
    await picture(page, "calibrate-preview");
    await page.click(".preview .primary");
    await page.waitForSelector("[data-error]");
    const [saved] = await Promise.all([page.waitForEvent("download"), page.getByText("ISO 230 (TOML)").click()]);
    assert.match(readFileSync(await saved.path(), "utf8"), /E_Y0A/);
    await end();
  },

  async "a run is entered by hand, with a table pasted from a spreadsheet"() {
    const { page, close: end } = await open(browser, DEMO, `/calibrate/${MACHINE}`);
    const before = (await get(DEMO, `/v1/machines/${MACHINE}/calibrations`)).items.length;
    const run = JSON.parse(readFileSync(join(examples, "ballbar.json"), "utf8"));
    await page.click(".byhand");
    await page.locator(".enterrun button[type=submit]").click();
    await page.waitForSelector(".faults li");
    // A name has its unit behind it.
    const field = (words) => page.locator(".enterrun").getByLabel(new RegExp(`^${words}`)).first();
    await field("Measured").fill("2025-03-14T09:26");
    await field("Instrument").fill(run.instrument);
    await field("Temperature").fill("20,1");
    await field("Bar length").fill("100");
    for (const [index, test] of run.tests.entries()) {
      await page.getByText("Add a test").click();
      const part = page.locator(".part").nth(index);
      await part.locator("select").nth(0).selectOption(test.rotary_axis);
      await part.locator("select").nth(1).selectOption(test.bar_direction);
      for (const [axis, value] of test.ball_mm.entries()) await part.locator(".triple input").nth(axis).fill(String(value));
      // A comma for the point, a heading, and a row without values: as a spreadsheet gives them.
      const rows = test.readings.map((one) => `${one.angle_deg}\t${String(one.length_change_um).replace(".", ",")}`);
      await part.locator('[data-cell="0 0"]').evaluate((cell, text) => {
        const clipboardData = new DataTransfer();
        clipboardData.setData("text", text);
        cell.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
      }, ["angle\tlength change", ...rows, "\t", ""].join("\r\n"));
      await page.waitForFunction(
        ([at, count]) => document.querySelectorAll(".part")[at].querySelectorAll("tbody tr").length === count + 1,
        [index, test.readings.length],
      );
    }
    const cell = page.locator('.part:first-of-type [data-cell="1 1"]').first();
    const kept = await cell.inputValue();
    await cell.fill("1.2.3");
    await page.locator(".enterrun button[type=submit]").click();
    await page.waitForSelector(".faults li");
    assert.match(await page.locator(".enterrun .faults").innerText(), /Test 1, row 2.*1\.2\.3/);
    await check(page, "run by hand");
    await gallery(page, "calibrate-by-hand", ".part");
    await picture(page, "calibrate-by-hand");
    await cell.fill(kept);
    await cell.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.dataset.cell), "2 1");
    await page.locator(".enterrun button[type=submit]").click();
    await page.waitForSelector(".preview");
    await page.click(".preview .primary");
    await page.waitForSelector("[data-error]");
    const all = (await get(DEMO, `/v1/machines/${MACHINE}/calibrations`)).items;
    assert.equal(all.length, before + 1);
    const stored = await get(DEMO, `/v1/machines/${MACHINE}/calibrations/${all[0].id}/run`);
    for (const [index, test] of run.tests.entries()) assert.deepEqual(stored.tests[index].readings, test.readings);
    await end();
  },

  async "the circle follows the hand"() {
    const { page, close: end } = await open(browser, DEMO, `/servo/${MACHINE}`);
    await page.waitForSelector(".polar .error");
    const drawn = () => page.locator(".polar .error").getAttribute("d");
    const first = await drawn();
    const slider = page.locator(".slider input").nth(1);
    const answered = page.waitForResponse((response) => response.url().endsWith("/v1/servo-simulations"));
    await slider.fill("1.2");
    const answer = await (await answered).json();
    await page.waitForFunction((old) => document.querySelector(".polar .error")?.getAttribute("d") !== old, first);
    await same(page, '[data-row="max_abs_um"]', answer.contour_error.max_abs_um);
    await page.locator(".match button").click();
    await page.waitForSelector(".match .facts");
    await check(page, "servo");
    await gallery(page, "servo");
    await picture(page, "servo");
    await page.locator(".column .card button").last().click();
    await page.waitForSelector("img.figure", { timeout: 20_000 });
    await end();
  },

  async "wear has its history, its outlook and its entries"() {
    const { page, close: end } = await open(browser, DEMO, `/wear/${MACHINE}/T12`);
    const trend = await get(DEMO, `/v1/machines/${MACHINE}/tools/T12/wear-trend?cutter_id=2&limit_um=60`);
    await page.waitForSelector('[data-name="parts-left"]');
    await same(page, '[data-name="parts-left"]', trend.outlook.parts_left.estimate);
    await same(page, '[data-row="wear_um"]', trend.edges[0].fit.wear_um);
    const scallop = await (
      await fetch(`${DEMO}/v1/scallop-height`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ stepover_mm: 0.4, tool_radius_mm: 5, surface: "flat", allowed_scallop_um: 5 }),
      })
    ).json();
    await same(page, '[data-row="scallop_height_um"]', scallop.scallop_height_um);
    const advice = await (
      await fetch(`${DEMO}/v1/wear-advice`, {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({
          nominal_tool: { radius_mm: 5 },
          actual_tool: { radius_mm: 5 - trend.edges[0].fit.wear_um / 1000 },
          stepover_mm: 0.4,
          surface: "flat",
          allowed_scallop_um: 5,
        }),
      })
    ).json();
    await page.waitForSelector('[data-name="advice"]');
    assert.equal(await page.locator('[data-name="advice"]').getAttribute("data-value"), advice.advice);
    assert.ok((await page.locator(".advice").innerText()).includes(advice.min_tool_radius_mm.toFixed(3)));
    await page.waitForSelector(".stage canvas");
    await page.waitForTimeout(500);
    await drawn(page, ".stage canvas", 40, "the residuals are not drawn");
    await check(page, "wear");
    await gallery(page, "wear");
    await picture(page, "wear");
    await end();
  },

  async "the tour leads a new service from a program to its proof"() {
    const { page, close: end } = await open(browser, NEW, "/");
    const began = Date.now();
    await page.click(".tourcard button");
    await page.waitForSelector(".machineview");
    await check(page, "tour, machine");
    await picture(page, "tour");
    await page.click(".guide .primary");
    await page.waitForSelector(".drop.full");
    assert.ok(await page.locator(".guide .primary").isDisabled(), "the tour goes on before the program is compensated");
    await page.click("button.primary.large");
    await page.waitForSelector(".readout", { timeout: 30_000 });
    for (let step = 3; step <= 5; step += 1) await page.click(".guide .primary");
    await check(page, "tour, result");
    await page.click(".guide .primary");
    assert.equal(await page.locator(".guide").count(), 0);
    assert.ok(Date.now() - began < 60_000, "the tour takes more than a minute");
    assert.equal((await get(NEW, "/v1/jobs")).items.length, 1);
    await end();
  },

  async "a new service loads data to look at"() {
    const { page, close: end } = await open(browser, EMPTY, "/");
    await check(page, "new service");
    await picture(page, "overview-new");
    await page.click(".democard button");
    await page.waitForSelector("[data-job]", { timeout: 60_000 });
    // It is what `trunnion demo` loads.
    const of = async (url) => {
      const base = `/v1/machines/${MACHINE}`;
      const { created_at: _at, ...machine } = await get(url, `${base}/revisions/1`);
      const { items: runs } = await get(url, `${base}/calibrations?limit=200`);
      const own = runs.filter(({ note }) => /grow from run to run/.test(note ?? ""));
      const readings = await Promise.all(own.map(({ id }) => get(url, `${base}/calibrations/${id}/run`)));
      const jobs = (await get(url, `/v1/jobs?limit=200&machine_id=${MACHINE}`)).items.filter((job) => /^demo: /.test(job.external_id ?? ""));
      const { items: wear } = await get(url, `${base}/tools/T12/wear-entries?limit=200`);
      return {
        machine, readings,
        jobs: jobs.map(({ external_id, state, input_sha256, parameters }) => ({ external_id, state, input_sha256, parameters })),
        wear: wear.filter(({ note }) => note === "tool setter").map(({ cutter_id, parts_cut, radius_wear_um, measured_at }) => [cutter_id, parts_cut, radius_wear_um, measured_at]),
      };
    };
    // Compared as text: a zero may have a sign.
    const told = async (url) => JSON.parse(JSON.stringify(await of(url)));
    assert.deepEqual(await told(EMPTY), await told(DEMO));
    assert.ok((await fetch(`${EMPTY}/v1/machines/${MACHINE}`)).headers.get("trunnion-calibration"), "no run is applied");
    await page.goto(`${EMPTY}/#/wear/${MACHINE}/T12`);
    await page.waitForSelector('[data-row="wear_um"]');
    await end();
  },

  async "a service with keys asks for one, and the tab forgets it"() {
    const { page, close: end } = await open(browser, CLOSED, "/machines");
    await page.waitForSelector("dialog[open]");
    await check(page, "key");
    await picture(page, "key");
    await page.fill("dialog input", "trunnion_wrong");
    await page.click("dialog .primary");
    await page.waitForSelector("dialog[open] .notice");
    await page.fill("dialog input", key);
    await page.click("dialog .primary");
    await page.waitForSelector(".machine");
    const kept = await page.evaluate(() => [JSON.stringify(localStorage), JSON.stringify(sessionStorage), document.cookie]);
    assert.ok(!kept[0].includes(key) && kept[1].includes(key) && kept[2] === "", "the key is kept beyond the session");
    await page.goto(`${CLOSED}/#/compensate`);
    await page.locator("select").nth(3).selectOption("radius");
    await page.locator(".fields .withunit input").nth(4).fill("5");
    await compensate(page);
    await page.waitForSelector(".readout", { timeout: 30_000 });
    await end();
  },

  async "with a key the report of a run is opened in the page"() {
    const runs = `/v1/machines/example-ac-table/calibrations`;
    const made = await fetch(`${CLOSED}${runs}`, {
      method: "POST",
      headers: { "Content-Type": "application/json", Authorization: `Bearer ${key}` },
      body: readFileSync(join(examples, "ballbar.json")),
    });
    const { id } = await made.json();
    const { page, close: end } = await open(browser, CLOSED, `/calibrate/example-ac-table/${id}`);
    await page.fill("dialog input", key);
    await page.click("dialog .primary");
    await page.click(".report");
    await page.waitForFunction(() => /Calibration report/.test(document.querySelector(".sheet")?.shadowRoot?.textContent ?? ""));
    const ruled = await page.evaluate(() => getComputedStyle(document.querySelector(".sheet").shadowRoot.querySelector("table")).borderCollapse);
    assert.equal(ruled, "collapse", "the report has lost its styles");
    await check(page, "report");
    await picture(page, "report");
    await end();
  },

  async "jobs and runs print on one or two sheets of A4"() {
    const { items } = await get(DEMO, `/v1/jobs?limit=200&state=succeeded`);
    const run = (await get(DEMO, `/v1/machines/${MACHINE}/calibrations`)).items[0].id;
    const views = [`/calibrate/${MACHINE}/${run}`];
    for (const operation of new Set(items.map((job) => job.operation))) views.push(`/jobs/${items.find((job) => job.operation === operation).id}`);
    for (const [index, view] of views.entries()) {
      const { page, close: end } = await open(browser, DEMO, view);
      await page.waitForTimeout(800);
      const sheets = await page.pdf({ ...(pictures ? { path: join(pictures, `print-${index}.pdf`) } : {}), preferCSSPageSize: true });
      const count = sheets.toString("latin1").match(/\/Type\s*\/Page\b(?!s)/g).length;
      if (count > 2) fault(`${view}: ${count} sheets`);
      await end();
    }
  },

  async "what is wrong is said, and nothing of it is run"() {
    const name = '<img src=x onerror="document.title=1">.nc';
    {
      const { page, close: end } = await open(browser, DEMO, "/compensate");
      await page.setInputFiles("#program", { name, mimeType: "text/plain", buffer: Buffer.from("<script>alert(1)</script>\n\u0000\ufffd(a)\n") });
      assert.match(await page.locator(".drop").innerText(), /<img src=x/);
      assert.equal(await page.locator(".drop img").count(), 0);
      await page.click("button.primary.large");
      await page.waitForSelector(".notice.bad");
      await check(page, "no program");
      await end();
    }
    const answers = {
      "a fault of the service": { status: 500, contentType: "application/problem+json", body: JSON.stringify({ type: "/problems/internal", title: "Internal fault", status: 500, detail: "<b>it</b> failed" }) },
      "a proxy between": { status: 502, contentType: "text/html", body: "<html><script>document.title=1</script>Bad Gateway</html>" },
      "a quota": { status: 429, contentType: "application/problem+json", headers: { "Retry-After": "30" }, body: JSON.stringify({ type: "/problems/too-many-requests", title: "Too many requests", status: 429, detail: "the key has no more requests in this minute" }) },
      "no service": null,
    };
    for (const [what, answer] of Object.entries(answers))
      for (const view of what === "a quota" || what === "a proxy between" ? ["/", "/wear"] : ["/", "/compensate", "/machines", `/machines/${MACHINE}`, "/jobs", "/jobs/01a00000-0000-7000-8000-000000000000", "/calibrate", "/servo", "/wear"]) {
        const { page, close: end } = await open(browser, DEMO, view);
        await page.route("**/v1/**", (route) => (answer ? route.fulfill(answer) : route.abort()));
        await page.reload();
        await page.waitForSelector(".notice.bad", { timeout: 10_000 });
        assert.equal(await page.locator(".notice.bad script, .notice.bad b").count(), 0);
        assert.notEqual(await page.title(), "1");
        if (view === "/") await check(page, what);
        await end();
      }
    // Answers of something else, and an address that is no text.
    for (const view of ["/", "/jobs", `/machines/${MACHINE}`, "/calibrate", "/wear"]) {
      const { page, close: end } = await open(browser, DEMO, view);
      await page.route("**/v1/**", (route) => route.fulfill({ json: { items: 5 } }));
      await page.reload();
      await page.waitForSelector(".notice.bad");
      await page.goto(`${DEMO}/#/nowhere`);
      await page.waitForSelector(".empty");
      await end();
    }
    {
      const { page, close: end } = await open(browser, DEMO, "/jobs/%");
      await page.waitForSelector(".notice.bad");
      await end();
    }
    // No machine at all.
    for (const view of ["/", "/compensate", "/machines", "/calibrate", "/servo", "/wear"]) {
      const { page, close: end } = await open(browser, DEMO, view);
      await page.route("**/v1/machines?**", (route) => route.fulfill({ json: { items: [] } }));
      await page.reload();
      await page.waitForSelector(".empty");
      await check(page, `no machine, ${view}`);
      await end();
    }
  },

  async "every view in dark, in Chinese and on a tablet"() {
    const run = (await get(DEMO, `/v1/machines/${MACHINE}/calibrations`)).items[0].id;
    const views = { overview: "/", compensate: "/compensate", machine: `/machines/${MACHINE}`, jobs: "/jobs",
      calibrate: `/calibrate/${MACHINE}`, run: `/calibrate/${MACHINE}/${run}`, servo: `/servo/${MACHINE}`, wear: `/wear/${MACHINE}/T12` };
    const looks = { dark: { theme: "dark" }, zh: { language: "zh" }, tablet: { width: 820, height: 1180 }, narrow: { width: 600, height: 960 } };
    for (const [look, options] of Object.entries(looks))
      for (const [name, view] of Object.entries(views)) {
        const { page, close: end } = await open(browser, DEMO, view, options);
        if (name === "compensate") {
          await compensate(page);
          await page.waitForSelector(".readout", { timeout: 30_000 });
        }
        await page.waitForTimeout(400);
        await check(page, `${name}, ${look}`);
        await picture(page, `${name}-${look}`);
        if (name === "compensate" && (look === "dark" || look === "zh")) await gallery(page, `compensate-${look}`, ".card.path");
        await end();
      }
  },

  async "a program of a million blocks is drawn in seconds, in little memory"() {
    await million(executable, DEMO, MACHINE, picture);
  },
};

for (const [name, flow] of Object.entries(flows)) {
  // ONLY=words is a shorter look.
  if (process.env.ONLY && !name.includes(process.env.ONLY)) continue;
  const began = Date.now();
  try {
    await flow();
  } catch (error) {
    fault(`${name}: ${error.stack}`);
  }
  console.log(`${name}: ${((Date.now() - began) / 1000).toFixed(1)} s`);
}
await browser.close();
assert.equal(faults.length, 0, `${faults.length} faults`);
