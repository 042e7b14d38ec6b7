// Numbers and times as they are shown. The whole value is kept beside, for those who need every digit.

import { language } from "../texts";

const locale = () => (language.value === "zh" ? "zh-CN" : "en-GB");

export function fixed(value: number, digits: number): string {
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? (0).toFixed(digits) : text).replace("-", "−");
}

/** Three significant digits, and no more decimals than a micrometre needs. */
export function short(value: number): string {
  const size = Math.abs(value);
  if (size === 0) return "0";
  return fixed(value, size >= 100 ? 1 : size >= 0.1 ? 2 : 3);
}

/** With a capital and a full stop: texts of the service are often without. */
export const sentence = (text: string) => `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;

export const whole = (value: number) => value.toLocaleString("en").replaceAll(",", "\u202f");

export function day(time: string): string {
  return new Date(time).toLocaleDateString(locale(), { year: "numeric", month: "short", day: "numeric" });
}

export function moment(time: string): string {
  return new Date(time).toLocaleString(locale(), {
    year: "numeric",
    month: "short",
    day: "numeric",
    hour: "2-digit",
    minute: "2-digit",
  });
}

/** The time at this place, as a field for times has it. */
export const hereAndNow = () => new Date(Date.now() - new Date().getTimezoneOffset() * 60_000).toISOString().slice(0, 16);

export const daysSince = (time: string, now = Date.now()) => Math.floor((now - Date.parse(time)) / 86_400_000);

export function seconds(from: string, until: string): string {
  const ms = Date.parse(until) - Date.parse(from);
  return ms < 1000 ? `${ms} ms` : `${(ms / 1000).toFixed(1)} s`;
}
