/** How releases stand at gateways, in words for people. */

import type { GatewayReleaseShape, ReleaseList, RolloutShape } from "../../generated/api.js";
import type { StatusKind } from "../../elements/feedback/status.js";

const STAGES: Readonly<Record<string, readonly [StatusKind, string]>> = {
  queued: ["unknown", "has its turn later"],
  offered: ["busy", "offered"],
  begun: ["busy", "installed there"],
  done: ["ok", "runs it"],
  failed: ["bad", "left it"],
};

/** @param stopped nobody is offered it any more */
export function stageStatus(stage: string, stopped = false): readonly [StatusKind, string] {
  if (stage === "queued" && stopped) return ["unknown", "was not offered it"];
  return STAGES[stage] ?? ["unknown", stage];
}

/** @param total bytes of the release that is fetched; 0 where that is not known */
export function phaseWords(gateway: GatewayReleaseShape, total = 0): string {
  const { candidate, waits } = gateway;
  switch (gateway.phase) {
    case "fetching":
      return total > 0 ? `fetches ${candidate}: ${String(Math.floor((100 * gateway.fetched) / total))} %` : `fetches ${candidate}`;
    case "installing":
      return `installs ${candidate} beside it`;
    case "waiting":
      return waits === "" ? `${candidate} is installed; it changes when nothing has moved for a while` : `${candidate} is installed and waits: ${waits}`;
    case "allowed":
      return `ends in favour of ${candidate}`;
    case "trying":
      return `tries ${candidate}`;
    default:
      return "";
  }
}

export function rolloutWords(rollout: RolloutShape): string {
  const all = rollout.sites.length;
  const done = rollout.sites.filter(({ stage }) => stage === "done").length;
  const have = all === 1 ? (done === 1 ? "the gateway runs it" : "one gateway, which does not run it yet") : `${String(done)} of ${String(all)} gateways run it`;
  if (rollout.stopped !== "") return `Stopped: ${rollout.stopped}. ${capitalise(have)}.`;
  return rollout.runs ? `On its way: ${have}.` : `Done: ${have}.`;
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
