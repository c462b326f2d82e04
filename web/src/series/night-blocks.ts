/** The blocks of a night's line: what was taken, by the archive; what is observed; what is planned. Pure. */

import { msg, str } from "@lit/localize";
import { plural } from "../words/plural.js";
import type { FrameShape, NightStateShape, PlanShape } from "../generated/api.js";
import type { NightBlock } from "./plan-layout.js";

/** Frames of one target that lie further apart belong to two visits (ms). */
const PAUSE_MS = 900_000;
const HIDDEN = msg("another's request");
/** What the night calls the pictures that it takes for itself: they belong to the block around them. */
const FOR_ITSELF = msg("focus or centring");

interface KnownRequest {
  readonly id: string;
  readonly target: string;
  readonly proposal: string;
}

/** What was taken in a night; the proposal is that of the request of its target, where only one has it. */
export function takenBlocks(frames: readonly FrameShape[], requests: readonly KnownRequest[]): readonly NightBlock[] {
  const lights = [...frames].filter(({ target }) => target !== "" && target !== FOR_ITSELF).sort((a, b) => a.time_us - b.time_us);
  const visits: { target: string; frames: FrameShape[]; endMs: number }[] = [];
  for (const frame of lights) {
    const startMs = frame.time_us / 1000;
    const last = visits.at(-1);
    const endMs = startMs + (frame.exposure_s ?? 0) * 1000;
    if (last?.target === frame.target && startMs - last.endMs < PAUSE_MS) {
      last.frames.push(frame);
      last.endMs = endMs;
    } else visits.push({ target: frame.target, frames: [frame], endMs });
  }
  return visits.map(({ target, frames: taken, endMs }) => {
    const startMs = (taken[0]?.time_us ?? 0) / 1000;
    const known = requests.filter((request) => request.target === target);
    const filters = [...new Set(taken.map(({ filter }) => filter).filter(Boolean))].join(", ");
    const many = plural(taken.length, msg("1 frame"), msg(str`${String(taken.length)} frames`));
    return {
      id: `taken-${String(Math.round(startMs))}`,
      request: known.length === 1 ? (known[0]?.id ?? "") : "",
      name: target,
      proposal: new Set(known.map(({ proposal }) => proposal)).size === 1 ? (known[0]?.proposal ?? "") : "",
      startMs,
      endMs: Math.max(endMs, startMs + 1000),
      state: "done",
      reason: `${many}${filters === "" ? "" : ` (${filters})`}.`,
    };
  });
}

/** What a plan has; the block of the request that is observed now is the current one. */
export function plannedBlocks(plan: PlanShape | null, state: NightStateShape | null, nowMs: number): readonly NightBlock[] {
  const observed = state?.phase === "observing" ? state.request : "";
  let current = false;
  return (plan?.blocks ?? []).flatMap((block, i): NightBlock[] => {
    const [startMs, endMs] = [block.start_us / 1000, block.end_us / 1000];
    const isCurrent = !current && observed !== "" && block.request === observed;
    current ||= isCurrent;
    // A plan of before: what of it is over is known by what was taken.
    if (endMs <= nowMs && !isCurrent) return [];
    return [
      {
        id: `planned-${String(i)}-${block.request}`,
        request: block.request,
        name: block.target === "" ? HIDDEN : block.target,
        proposal: block.proposal,
        startMs,
        endMs,
        state: isCurrent ? "current" : "planned",
        reason: block.reason,
        pauses: block.pauses.map(({ kind, start_us: from, end_us: to, reason }) => ({
          kind: kind === "flip" ? "flip" : "focus", startMs: from / 1000, endMs: to / 1000, reason,
        })),
      },
    ];
  });
}

/** What was taken, without what belongs to the block that is observed now, and what is planned. */
export function nightBlocks(taken: readonly NightBlock[], planned: readonly NightBlock[]): readonly NightBlock[] {
  const current = planned.find(({ state }) => state === "current");
  return [...taken.filter(({ name, endMs }) => current === undefined || name !== current.name || endMs < current.startMs), ...planned];
}

/** A proposal's share of the time: what it is due, and what it got. */
export interface ShareRow {
  readonly id: string;
  readonly title: string;
  /** 0 to 1. */
  readonly due: number;
  /** 0 to 1; NaN while nobody got any. */
  readonly got: number;
  readonly usedS: number;
  readonly hours: number;
}

interface SharedProposal {
  readonly id: string;
  readonly title: string;
  readonly share: number;
  readonly used_s: number;
  readonly hours_allocated: number;
  readonly active: boolean;
}

/** Shares among those that are given; shares due are of their sum where that is more than 1. */
export function shareRows(proposals: readonly SharedProposal[]): readonly ShareRow[] {
  const active = proposals.filter(({ active: on, used_s }) => on || used_s > 0);
  const used = active.reduce((sum, { used_s }) => sum + used_s, 0);
  const due = Math.max(1, active.reduce((sum, { share }) => sum + share, 0));
  return active.map(({ id, title, share, used_s, hours_allocated }) => ({
    id, title, due: share / due, got: used === 0 ? Number.NaN : used_s / used, usedS: used_s, hours: hours_allocated,
  }));
}
