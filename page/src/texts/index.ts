// The language of the page. A text that a language lacks is an error of the compiler.

import { computed, effect, signal } from "@preact/signals";
import { en } from "./en";
import { zh } from "./zh";

export type Texts = typeof en;
export type Language = "en" | "zh";

const DICTIONARIES: Record<Language, Texts> = { en, zh };
const NAME = "trunnion-language";

const kept = localStorage.getItem(NAME);
const preferred: Language = navigator.language.toLowerCase().startsWith("zh") ? "zh" : "en";
export const language = signal<Language>(kept === "en" || kept === "zh" ? kept : preferred);
export const texts = computed(() => DICTIONARIES[language.value]);

effect(() => {
  document.documentElement.lang = language.value === "zh" ? "zh-Hans" : "en";
  localStorage.setItem(NAME, language.value);
});
