/** What is said of a topic in a list: who may see it, how often it comes. Pure. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../../format/number.js";
import type { SiteShape, TopicShape } from "../../generated/api.js";

/** Who may follow a topic, in words. */
export function whoMaySee({ described, right, device }: TopicShape, detail: SiteShape | undefined): string {
  const name = device === "" ? "" : (detail?.devices.find(({ id }) => id === device)?.name ?? device);
  const where = name === "" ? msg("the site") : name;
  switch (right) {
    case "view":
      return msg(str`who may view ${where}`);
    case "use":
      return msg(str`who may use ${where}`);
    case "admin":
      return msg("admins");
    case "tap":
      return described && name !== "" ? msg(str`who may tap ${name}`) : msg("admins, and who may tap");
  }
}

/** How often a topic comes; empty while nobody knows. */
export function rateText(hertz: number | null): string {
  if (hertz === null || hertz <= 0) return "";
  if (hertz < 0.1) return msg(str`every ${String(Math.round(1 / hertz))} s`);
  return `${hertz < 10 ? fixedText(hertz, 1) : String(Math.round(hertz))} Hz`;
}

/** Those whose name or type holds all of the words. */
export function filterTopics(topics: readonly TopicShape[], words: string): readonly TopicShape[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean);
  return topics.filter(({ topic, type }) => wanted.every((word) => `${topic} ${type}`.toLowerCase().includes(word)));
}
