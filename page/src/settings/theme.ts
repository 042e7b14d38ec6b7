// Light or dark: what the system says, or what the person chose.

import { computed, effect, signal } from "@preact/signals";

export type Choice = "system" | "light" | "dark";
const NAME = "trunnion-theme";
const system = matchMedia("(prefers-color-scheme: dark)");
const systemIsDark = signal(system.matches);
system.addEventListener("change", (event) => (systemIsDark.value = event.matches));

const kept = localStorage.getItem(NAME);
export const choice = signal<Choice>(kept === "light" || kept === "dark" ? kept : "system");
export const isDark = computed(() => (choice.value === "system" ? systemIsDark.value : choice.value === "dark"));

effect(() => {
  document.documentElement.dataset["theme"] = isDark.value ? "dark" : "light";
  localStorage.setItem(NAME, choice.value);
});

/** A colour of the style sheet, as it is now. */
export function colour(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
