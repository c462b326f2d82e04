/** How releases stand at gateways, in words for people. */

import { msg, str } from "@lit/localize";
import { plural } from "../../words/plural.js";
import type { GatewayReleaseShape, ReleaseList, RolloutShape } from "../../generated/api.js";
import type { StatusKind } from "../../elements/feedback/status.js";

const STAGES: Readonly<Record<string, readonly [StatusKind, string]>> = {
  queued: ["unknown", msg("has its turn later")],
  offered: ["busy", msg("offered")],
  begun: ["busy", msg("installed there")],
  done: ["ok", msg("runs it")],
  failed: ["bad", msg("left it")],
};

/** @param stopped nobody is offered it any more */
export function stageStatus(stage: string, stopped = false): readonly [StatusKind, string] {
  if (stage === "queued" && stopped) return ["unknown", msg("was not offered it")];
  return STAGES[stage] ?? ["unknown", stage];
}

/** @param total bytes of the release that is fetched; 0 where that is not known */
export function phaseWords(gateway: GatewayReleaseShape, total = 0): string {
  const { candidate, waits } = gateway;
  switch (gateway.phase) {
    case "fetching":
      return total > 0 ? msg(str`fetches ${candidate}: ${String(Math.floor((100 * gateway.fetched) / total))} %`) : msg(str`fetches ${candidate}`);
    case "installing":
      return msg(str`installs ${candidate} beside it`);
    case "waiting":
      return waits === "" ? msg(str`${candidate} is installed; it changes when nothing has moved for a while`) : msg(str`${candidate} is installed and waits: ${waits}`);
    case "allowed":
      return msg(str`ends in favour of ${candidate}`);
    case "trying":
      return msg(str`tries ${candidate}`);
    default:
      return "";
  }
}

export function rolloutWords(rollout: RolloutShape): string {
  const all = rollout.sites.length;
  const done = rollout.sites.filter(({ stage }) => stage === "done").length;
  const have = all === 1 ? (plural(done, msg("the gateway runs it"), msg("one gateway, which does not run it yet"))) : msg(str`${String(done)} of ${String(all)} gateways run it`);
  if (rollout.stopped !== "") return msg(str`Stopped: ${rollout.stopped}. ${capitalise(have)}.`);
  return rollout.runs ? msg(str`On its way: ${have}.`) : msg(str`Done: ${have}.`);
}

/** Versions that can be handed out, newest file first, and for which of the gateways each is. */
export function offeredVersions(list: ReleaseList): ReadonlyMap<string, readonly string[]> {
  const found = new Map<string, Set<string>>();
  for (const release of list.releases) {
    if (release.problem !== "") continue;
    const sites = list.gateways
      .filter((gateway) => (release.site === "" || release.site === gateway.site) && gateway.current !== release.version)
      .map(({ site }) => site);
    const known = found.get(release.version) ?? new Set<string>();
    for (const site of sites) known.add(site);
    found.set(release.version, known);
  }
  return new Map([...found].map(([version, sites]) => [version, [...sites]]));
}

function capitalise(text: string): string {
  return text.slice(0, 1).toUpperCase() + text.slice(1);
}
