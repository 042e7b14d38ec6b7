// A program of a million blocks, opened as a job: the time until its path is drawn, and the memory of the browser.

import { strict as assert } from "node:assert";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fault, launch, open } from "./browser.js";

const BLOCKS = 1_000_000;
const ROWS = 1000;
/** Resident memory of the tab, after the text is there. More than half of it is the browser's own program. */
const MOST_MB = 200;
/** Memory that belongs to the tab alone, at its largest. */
const MOST_PRIVATE_MB = 140;
/** Without a graphics card 2.3 s and more. A test that fails because another program runs beside would be of no use. */
const MOST_S = 8;

/** Rows over a dome; the cutter tilts and turns. Every hundredth block is long, so that its deviation counts. */
function program() {
  const lines = ["%", "(A MILLION BLOCKS)", "G21 G90 G17 G54", "T1 M6", "S12000 M3", "G0 X-40. Y-40. Z50. A-12.7137 C-19.0930", "G94 G1 F1200."];
  const each = BLOCKS / ROWS;
  for (let row = 0; row < ROWS; row += 1) {
    const y = -40 + (80 * row) / ROWS;
    for (let step = 0; step < each; step += 1) {
      const share = (step + (step % 100 === 99 ? 0 : 0.1 * (step % 10))) / each;
      const x = -40 + 80 * (row % 2 ? 1 - share : share);
      const z = -(x * x + y * y) / 200 + 0.3 * Math.sin(x / 3) * Math.cos(y / 4);
      const a = -20 - 5 * Math.sin(x / 15) - y / 8;
      const c = 10 * Math.sin(y / 20) + x / 4;
      lines.push(`X${x.toFixed(4)} Y${y.toFixed(4)} Z${z.toFixed(4)} A${a.toFixed(4)} C${c.toFixed(4)}`);
    }
  }
  return [...lines, "G0 Z50.", "M30", "%", ""].join("\n");
}

async function posted(url, machine_id, text) {
  const form = new FormData();
  const parameters = { tool_radius_mm: 5, work_offset_mm: [12, -7, 35], contact: "feed-plane", tolerance_um: 10 };
  form.append("job", JSON.stringify({ machine_id, operation: "cc-compensation", parameters }));
  form.append("program", new Blob([text]), "million.nc");
  const answer = await fetch(`${url}/v1/jobs`, { method: "POST", body: form });
  assert.ok(answer.ok, await answer.clone().text());
  const { id } = await answer.json();
  for (;;) {
    const job = await (await fetch(`${url}/v1/jobs/${id}`)).json();
    if (job.state === "succeeded") return id;
    assert.ok(job.state === "queued" || job.state === "running", JSON.stringify(job.problem));
    await new Promise((resolve) => setTimeout(resolve, 200));
  }
}

/** What Linux says about a process, in MB. */
const memoryOf = (process) => {
  const text = readFileSync(`/proc/${process}/status`, "utf8");
  const of = (name) => Number(new RegExp(`${name}:\\s+(\\d+)`).exec(text)?.[1]) / 1000;
  return { resident: of("VmRSS"), private: of("RssAnon") };
};

export async function million(executable, url, machine, picture) {
  const text = program();
  const id = await posted(url, machine, text);
  const folder = mkdtempSync(join(tmpdir(), "million-"));
  const file = join(folder, "million.nc");
  writeFileSync(file, text);
  // A browser of its own, whose only tab is this one.
  const browser = await launch(executable);
  const { page } = await open(browser, url, "/jobs");
  const asked = await browser.newBrowserCDPSession();
  const { processInfo } = await asked.send("SystemInfo.getProcessInfo");
  const tabs = processInfo.filter(({ type }) => type === "renderer").map((one) => one.id);
  const tab = tabs.toSorted((a, b) => memoryOf(b).private - memoryOf(a).private);
  // A person looks at the list first. Meanwhile the page makes its renderer.
  await page.waitForTimeout(3000);
  const peak = { resident: 0, private: 0 };
  const look = () => {
    for (const one of tab) {
      try {
        const now = memoryOf(one);
        peak.resident = Math.max(peak.resident, now.resident);
        peak.private = Math.max(peak.private, now.private);
      } catch {
        // A spare process of the browser that ended.
      }
    }
  };
  const looking = setInterval(look, 20);
  const began = Date.now();
  await page.click(`[data-job="${id}"] a`);
  await page.waitForSelector(".readout", { timeout: 60_000 });
  const took_s = (Date.now() - began) / 1000;
  await page.waitForSelector(".codeline", { timeout: 60_000 });
  // The end of the text is a part as any other.
  await page.locator(".program").last().evaluate((element) => element.scrollTo(0, element.scrollHeight));
  await page.waitForFunction(() => /M30/.test([...document.querySelectorAll(".program")].at(-1).innerText));
  // The program that was uploaded is chosen, read beside the result, and in step with it.
  await page.setInputFiles(".programs input[type=file]", file);
  await page.waitForFunction(() => document.querySelectorAll(".program").length === 2, null, { timeout: 60_000 });
  const before = page.locator(".program").first();
  await before.evaluate((element) => element.scrollTo(0, element.scrollHeight / 2));
  await page.waitForTimeout(500);
  await before.locator(".codeline").nth(20).click();
  await page.waitForFunction(() => document.querySelectorAll(".codeline.focus").length >= 2, null, { timeout: 60_000 });
  const [left, right] = await page.locator(".codeline.focus .text").allInnerTexts();
  assert.equal(right, left, "the programs are not in step");
  rmSync(folder, { recursive: true });
  assert.ok((await page.locator(".codeline").count()) < 200, "the whole program is in the document");
  clearInterval(looking);
  look();
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  // The browser gives memory back a little later.
  await page.waitForTimeout(2000);
  await session.send("Performance.enable");
  const { metrics } = await session.send("Performance.getMetrics");
  const heap = metrics.find(({ name }) => name === "JSHeapUsedSize").value / 1e6;
  const resident = Math.max(...tab.map((one) => { try { return memoryOf(one).resident; } catch { return 0; } }));
  console.log(
    `  a million blocks: picture after ${took_s.toFixed(1)} s, JavaScript ${heap.toFixed(0)} MB, ` +
      `tab ${resident.toFixed(0)} MB resident (at most ${peak.resident.toFixed(0)}), ${peak.private.toFixed(0)} MB of its own at most`,
  );
  if (took_s > MOST_S) fault(`a million blocks: the path is drawn after ${took_s} s, the bound is ${MOST_S} s`);
  if (resident > MOST_MB) fault(`a million blocks: the tab has ${resident} MB, the bound is ${MOST_MB} MB`);
  if (peak.private > MOST_PRIVATE_MB) fault(`a million blocks: the tab has ${peak.private} MB of its own, the bound is ${MOST_PRIVATE_MB} MB`);
  await picture(page, "million");
  await browser.close();
}
