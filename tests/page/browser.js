// A browser that reaches one service and nothing else, and says at once what is wrong.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { chromium } from "playwright-core";

const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

// WebGL without a graphics card, which then draws nothing but WebGL.
const ARGUMENTS = [
  "--no-sandbox",
  "--use-gl=angle",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-gpu-rasterization",
  "--disable-background-networking",
];

export const faults = [];
export const fault = (words) => {
  faults.push(words);
  console.error(`FAULT ${words}`);
};

export async function launch(executablePath) {
  return chromium.launch({ executablePath, headless: true, args: ARGUMENTS });
}

/** A tab at a view of the service: its size, its language and its colours are chosen. */
export async function open(browser, url, view, { theme = "light", language = "en", width = 1280, height = 900 } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, acceptDownloads: true, bypassCSP: false });
  // Everything that is not this service is unreachable, and asking for it is a fault.
  await context.route("**/*", (route) => {
    const asked = route.request().url();
    if (asked.startsWith(`${url}/`) || /^(data|blob):/.test(asked)) return route.continue();
    fault(`the page asks for ${asked}`);
    return route.abort();
  });
  await context.addInitScript(
    ([wantedTheme, wantedLanguage]) => {
      localStorage.setItem("trunnion-theme", wantedTheme);
      localStorage.setItem("trunnion-language", wantedLanguage);
    },
    [theme, language],
  );
  const page = await context.newPage();
  page.on("pageerror", (error) => fault(`${view}: ${error}`));
  page.on("console", (message) => {
    const text = message.text();
    // A refusal is shown by the page; the browser writes it down as well.
    if (message.type() === "error" && !/Failed to load resource/.test(text)) fault(`${view}: ${text}`);
  });
  await page.goto(`${url}/#${view}`);
  await page.waitForLoadState("networkidle");
  return { page, close: () => context.close() };
}

/** No rule of WCAG 2.1 A and AA is broken, and nothing is wider than the window. */
export async function check(page, name) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() =>
    window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"] }),
  );
  for (const { id, help, nodes } of violations)
    fault(`${name}: ${id}: ${help}: ${nodes.slice(0, 3).map(({ target, any }) => `${target} ${any[0]?.message ?? ""}`).join(" | ")}`);
  const over = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
  if (over > 0) fault(`${name}: ${over} px wider than the window`);
}
