/** Who of a group would do a command, and why others would not. Pure. */

import { msg, str } from "@lit/localize";
import type { SharedCommandShape, SiteSummary } from "../../generated/api.js";

/** One site of the group: why it is not asked; empty where it is. */
export interface GroupMember {
  readonly site: string;
  readonly name: string;
  readonly why: string;
  /** It is asked, and this is worth knowing before. */
  readonly note: string;
}

/** What is known of each site now. */
export interface GroupFacts {
  /** Why an interlock refuses it; empty where none does. */
  lockText(site: string, device: string, command: string): string;
  /** Why its gateway does not reach the device; empty where it does. */
  unreachableText(site: string, device: string): string;
  /** Who acts on the device now, in words; empty for nobody. */
  holderText(site: string, device: string): string;
}

/** @param all - every command of the fleet: others of the same name take other arguments */
export function previewGroup(
  chosen: readonly SiteSummary[],
  command: SharedCommandShape,
  all: readonly SharedCommandShape[],
  facts: GroupFacts,
): readonly GroupMember[] {
  const { device } = command;
  const id = command.command.id;
  const alike = all.filter((other) => other !== command && other.device === device && other.command.id === id);
  return chosen.map(({ site, name, online }) => {
    const why = ((): string => {
      if (command.barred.includes(site)) return msg("You may look at it, but not use it.");
      if (!command.sites.includes(site)) {
        const other = alike.some(({ sites, barred }) => sites.includes(site) || barred.includes(site));
        return other ? msg("Its command of this name takes other arguments.") : msg("It has no such command.");
      }
      if (!online) return msg("It is offline: nothing is sent, and nothing is kept for later.");
      return facts.unreachableText(site, device) || facts.lockText(site, device, id);
    })();
    const holder = why === "" ? facts.holderText(site, device) : "";
    const note = holder === "" ? "" : msg(str`${holder}: it will refuse. Interrupt on the device's own page.`);
    return { site, name: name === "" ? site : name, why, note };
  });
}

/** Commands that some of the chosen sites share, those of the most sites first. */
export function commandsOf(chosen: readonly SiteSummary[], all: readonly SharedCommandShape[]): readonly SharedCommandShape[] {
  const sites = new Set(chosen.map(({ site }) => site));
  const count = ({ sites: have }: SharedCommandShape): number => have.filter((site) => sites.has(site)).length;
  return all.filter((command) => count(command) > 0).sort((a, b) => count(b) - count(a));
}

/** A key by which a command of the list is chosen: two of the same name may take other arguments. */
export function commandKey({ device, command }: SharedCommandShape): string {
  return [device, command.id, ...command.arguments.map(({ id, type, unit }) => `${id}:${type}:${unit}`)].join("\n");
}

/** `A, B and 3 more`. */
export function nameList(names: readonly string[], most = 6): string {
  if (names.length <= most) return names.join(", ");
  return msg(str`${names.slice(0, most).join(", ")} and ${String(names.length - most)} more`);
}
